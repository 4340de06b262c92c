//! The keyboard: one table that the window obeys and the page of keys shows.

use crate::document::PastOf;
use crate::interact::event::{Key, Modifiers};
use crate::interact::tools::Tool;

/// What a key asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Chooses a tool.
    Choose(Tool),
    /// Brush radius times this.
    BrushSize(f64),
    /// Paints this label from now on.
    Label(u16),
    /// Removes what is picked of what is written.
    Remove,
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

/// What the keyboard and the pointer can do with any tool: heading, keys, what they do.
const GENERAL: &[(&str, &str, &str)] = &[
    ("Look", "Wheel on a slice", "Next or previous slice"),
    ("Look", "Up, Down", "Next or previous slice"),
    ("Look", "Ctrl + wheel", "Zoom"),
    ("Look", "Wheel in 3D", "Zoom"),
    ("Look", "Right drag on a slice", "Grey window: across for width, up for level"),
    ("Look", "Right drag in 3D", "Zoom"),
    ("Look", "Space + drag, middle drag", "Pan"),
    ("Look", "Alt + drag in 3D", "Turn, with any tool"),
    ("Look", "Shift + click", "Crosshair here, with any tool"),
    ("Look", "Double-click the view's title", "One view or all four"),
    ("Look", "F", "One view or all four"),
    ("Look", "Home", "Fit the view; in 3D the direction stays"),
    ("Look", "Shift + Home", "3D view from the front"),
    ("Look", "Alt + Left, Alt + Right", "View or look before, and after"),
    ("Look", "Alt + Shift + Left, Right", "Look alone before, and after"),
    ("Panels", "Drag a border", "More room; double-click: as at first"),
    ("Panels", "Double-click the curve", "A new point of opacity or colour"),
    ("Panels", "Right-click a point", "Remove it"),
    ("Panels", "Shift + drag a point", "Opacity and its colour together"),
    ("Panels", "Half-shaded ball in a row", "Its own look in 3D"),
    ("Document", "Ctrl + Z", "Undo"),
    ("Document", "Ctrl + Y, Ctrl + Shift + Z", "Redo"),
    ("Document", "Ctrl + S", "Save"),
    ("Document", "Ctrl + Shift + S", "Save as"),
    ("Document", "Ctrl + O", "Open"),
    ("Document", "Esc", "Take back what is running"),
    ("Document", "F1, ?", "This page"),
];

/// How many lines the page has.
const LINES: usize = {
    let (mut lines, mut at) = (GENERAL.len(), 0);
    while at < Tool::ALL.len() {
        lines += Tool::ALL[at].keys().1.len();
        at += 1;
    }
    lines
};

/// Everything that the keyboard and the pointer can do: what tools say of themselves, then what goes with any tool.
pub const SHORTCUTS: [Shortcut; LINES] = {
    let mut all = [Shortcut { group: "", keys: "", what: "" }; LINES];
    let (mut next, mut at) = (0, 0);
    while at < Tool::ALL.len() {
        let (group, lines) = Tool::ALL[at].keys();
        let mut line = 0;
        while line < lines.len() {
            let (keys, what) = lines[line];
            all[next] = Shortcut { group, keys, what };
            (next, line) = (next + 1, line + 1);
        }
        at += 1;
    }
    let mut line = 0;
    while line < GENERAL.len() {
        let (group, keys, what) = GENERAL[line];
        all[next] = Shortcut { group, keys, what };
        (next, line) = (next + 1, line + 1);
    }
    all
};

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
        Key::Delete => Some(Action::Remove),
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
