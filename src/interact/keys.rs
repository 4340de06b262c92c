//! The keyboard: one table that the window obeys and the page of keys shows.

use crate::document::PastOf;
use crate::interact::event::{Key, Modifiers};
use crate::interact::tool::Tool;

/// What a key asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Chooses a tool.
    Choose(Tool),
    /// Brush radius times this.
    BrushSize(f64),
    /// Paints this label from now on.
    Label(u16),
    /// Steps the slice under the pointer.
    Slice(i32),
    /// Takes back a step.
    Undo,
    /// Does it again.
    Redo,
    /// Writes the project.
    Save,
    /// Writes the project elsewhere.
    SaveAs,
    /// Opens a file or project.
    Open,
    /// Fits the view under the pointer.
    Fit,
    /// The 3D view from the front, fitted.
    Front,
    /// What was seen before the last change of views and looks, or of one of them.
    Back(Option<PastOf>),
    /// What was seen before `Back`.
    Forward(Option<PastOf>),
    /// The view under the pointer alone, or all four.
    Maximise,
    /// Shows or hides the page of keys.
    Keys,
    /// Takes back what runs.
    Abort,
}

/// A line of the page of keys.
#[derive(Clone, Copy, Debug)]
pub struct Shortcut {
    /// Heading it stands under.
    pub group: &'static str,
    /// Keys, as printed.
    pub keys: &'static str,
    /// What they do.
    pub what: &'static str,
}

const fn line(group: &'static str, keys: &'static str, what: &'static str) -> Shortcut {
    Shortcut { group, keys, what }
}

/// Everything that the keyboard and the pointer can do.
pub const SHORTCUTS: [Shortcut; 40] = [
    line("Paint", "B", "Brush"),
    line("Paint", "[  ]", "Smaller or larger brush"),
    line("Paint", "Shift + wheel", "Smaller or larger brush"),
    line("Paint", "Hold E", "Erase, also from the middle of a stroke on"),
    line("Paint", "1 … 9", "Paint this label"),
    line("Paint", "Esc", "Take the running stroke back"),
    line("Look", "N", "Navigate"),
    line("Look", "Wheel on a slice", "Next or previous slice"),
    line("Look", "Up, Down", "Next or previous slice"),
    line("Look", "Ctrl + wheel", "Zoom"),
    line("Look", "Wheel in 3D", "Zoom"),
    line("Look", "Right drag on a slice", "Grey window: across for width, up for level"),
    line("Look", "Right drag in 3D", "Zoom"),
    line("Look", "Space + drag, middle drag", "Pan"),
    line("Look", "Alt + drag in 3D", "Turn, with any tool"),
    line("Look", "Shift + click", "Crosshair here, with any tool"),
    line("Look", "Double-click the view's title", "One view or all four"),
    line("Look", "F", "One view or all four"),
    line("Look", "Home", "Fit the view; in 3D the direction stays"),
    line("Look", "Shift + Home", "3D view from the front"),
    line("Look", "Alt + Left, Alt + Right", "View or look before, and after"),
    line("Look", "Alt + Shift + Left, Right", "Look alone before, and after"),
    line("Parts", "X", "Axis split (Shift: vertical)"),
    line("Parts", "D", "Depth split"),
    line("Parts", "L", "Line split"),
    line("Parts", "M", "Move part"),
    line("Parts", "Click or line on a slice", "Cut there, with the split tools"),
    line("Parts", "Drag, tool Move part", "Move a part and pin it"),
    line("Parts", "Ctrl + drag, tool Move part", "Turn a part and pin it"),
    line("Panels", "Drag a border", "More room; double-click: as at first"),
    line("Panels", "Double-click the curve", "A new point of opacity or colour"),
    line("Panels", "Right-click a point", "Remove it"),
    line("Panels", "Shift + drag a point", "Opacity and its colour together"),
    line("Document", "Ctrl + Z", "Undo"),
    line("Document", "Ctrl + Y, Ctrl + Shift + Z", "Redo"),
    line("Document", "Ctrl + S", "Save"),
    line("Document", "Ctrl + Shift + S", "Save as"),
    line("Document", "Ctrl + O", "Open"),
    line("Document", "Esc", "Take back what is running"),
    line("Document", "F1, ?", "This page"),
];

/// What a key does, if anything. Held keys (Space, E) are modifiers of the pointer and not asked here.
pub fn action_of(key: Key, modifiers: Modifiers) -> Option<Action> {
    if modifiers.alt {
        let of = modifiers.shift.then_some(PastOf::Looks);
        return match key {
            Key::Left if !modifiers.ctrl => Some(Action::Back(of)),
            Key::Right if !modifiers.ctrl => Some(Action::Forward(of)),
            _ => None,
        };
    }
    if modifiers.ctrl {
        return match (key, modifiers.shift) {
            (Key::Char('Z'), false) => Some(Action::Undo),
            (Key::Char('Y'), false) | (Key::Char('Z'), true) => Some(Action::Redo),
            (Key::Char('S'), false) => Some(Action::Save),
            (Key::Char('S'), true) => Some(Action::SaveAs),
            (Key::Char('O'), false) => Some(Action::Open),
            _ => None,
        };
    }
    match key {
        Key::Escape => Some(Action::Abort),
        Key::Help => Some(Action::Keys),
        Key::Home if modifiers.shift => Some(Action::Front),
        _ if modifiers.shift => None,
        Key::BracketLeft => Some(Action::BrushSize(1.0 / crate::interact::machine::SIZE_STEP)),
        Key::BracketRight => Some(Action::BrushSize(crate::interact::machine::SIZE_STEP)),
        Key::Up => Some(Action::Slice(1)),
        Key::Down => Some(Action::Slice(-1)),
        Key::Home => Some(Action::Fit),
        Key::Left | Key::Right => None,
        Key::Char('F') => Some(Action::Maximise),
        Key::Char(c @ '1'..='9') => Some(Action::Label(c as u16 - '0' as u16)),
        Key::Char(c) => Tool::ALL.into_iter().find(|t| t.key() == c).map(Action::Choose),
    }
}
