//! The tools, a file each: what a tool says of itself and what its button does. A new tool is its file and its line here; bar,
//! keys, the page of keys, hints, outlines and the machine read the list.
//!
//! Knows no window: an icon is strokes, an outline is marks, both plain data.

use crate::document::{Scene, ViewName};
use crate::explode::{Axis, Cut, Poses};
use crate::interact::aim::{Aim, Aimed};
use crate::interact::context::Context;
use crate::interact::event::PointerEvent;
use crate::interact::gesture::Gesture;
use crate::interact::mark::{Mark, Pen};
use crate::interact::writing::Written;
use crate::interact::written::HeldThing;
use crate::math::DVec2;

/// What a tool says of itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct About {
    /// On its button.
    name: &'static str,
    /// Heading of its lines on the page of keys.
    group: &'static str,
    /// These lines: keys as printed and what they do. The first is the key that takes the tool, one letter.
    keys: &'static [(&'static str, &'static str)],
    /// One line for the status bar: what the buttons do now.
    hint: &'static str,
    /// Strokes on a grid of 16 by 16.
    icon: &'static [Pen],
    /// Whether it works on parts: their borders are then drawn.
    of_parts: bool,
    /// Whether Shift is the tool's own; with others it places the crosshair.
    has_shift: bool,
}

/// What a press of the primary button begins.
pub(super) enum Press {
    /// This.
    Begins(Box<dyn Gesture>),
    /// What it does with no tool: the 3D view turns, on slices the crosshair follows.
    Looks,
    /// Nothing.
    Nothing,
}

impl Press {
    fn begins(gesture: impl Gesture + 'static) -> Self {
        Self::Begins(Box::new(gesture))
    }

    /// What it begins for tools that write in the 3D view, if something of theirs is under the hand, or it is in another view.
    fn on_written(e: &PointerEvent, context: &Context<'_>, is_of_tool: fn(Written) -> bool) -> Option<Self> {
        if e.view != ViewName::ThreeD {
            return Some(Self::Looks);
        }
        let under = context.writing.under(e, &context.scene.views.camera, is_of_tool)?;
        Some(Self::begins(HeldThing::new(e, under)))
    }
}

/// What a tool does; only the press must be said.
pub(super) trait Does: Sync {
    /// The primary button goes down, without keys that move the view.
    fn press(&self, e: &PointerEvent, context: &Context<'_>) -> Press;

    /// Which of the things that are written it works on, if on any.
    fn picks(&self) -> Option<fn(Written) -> bool> {
        None
    }

    /// What is said if it is used in a view where it does nothing.
    fn refusal(&self, _view: ViewName) -> Option<&'static str> {
        None
    }

    /// What it would cut if the button went up now, `line` being under the hand.
    fn cuts(&self, _line: Option<[DVec2; 2]>, _placed: (&Scene, &Poses), _aim: Aim, _axis: Axis) -> Vec<Cut> {
        Vec::new()
    }

    /// Whether what lies before its cut comes off, and is tinted.
    fn peels(&self) -> bool {
        false
    }

    /// What is drawn about the pointer, which is over a view.
    fn marks(&self, _scene: &Scene, _at: &Aimed) -> Vec<Mark> {
        Vec::new()
    }
}

/// Makes the tools of their files: each has `ABOUT` and a `Does` of its line's name.
macro_rules! tools {
    ($($(#[$doc:meta])* $name:ident in $file:ident,)*) => {
        $(mod $file;)*

        /// What the primary button does in a view.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
        pub enum Tool {
            $($(#[$doc])* $name,)*
        }

        impl Tool {
            /// In the order of the tool bar.
            pub const ALL: [Self; [$(Self::$name,)*].len()] = [$(Self::$name,)*];

            const fn about(self) -> &'static About {
                match self {
                    $(Self::$name => &$file::ABOUT,)*
                }
            }

            /// What it does.
            pub(super) fn does(self) -> &'static dyn Does {
                match self {
                    $(Self::$name => &$file::$name,)*
                }
            }
        }
    };
}

tools! {
    /// Turns the 3D view; moves the crosshair on slices.
    #[default]
    Navigate in navigate,
    /// Paints.
    Brush in brush,
    /// Fills what is drawn around.
    Lasso in lasso,
    /// Makes boxes of finer voxels and moves their faces.
    SubVolume in sub_volume,
    /// Keeps alone what is connected to a place, or removes it.
    Isolate in isolate,
    /// Cuts the part that is hit along the sight and a screen axis.
    AxisSplit in axis_split,
    /// Cuts the part that is hit parallel to the picture.
    DepthSplit in depth_split,
    /// Cuts all parts that a line crosses.
    LineSplit in line_split,
    /// Moves and turns a part by hand.
    MovePart in move_part,
    /// Lays texts, arrows, rulers, patterns and images on surfaces.
    Annotate in annotate,
    /// Names places.
    Label in label,
    /// Opens windows into what lies behind a surface.
    Cutaway in cutaway,
}

impl Tool {
    /// The name on its button.
    pub const fn name(self) -> &'static str {
        self.about().name
    }

    /// Its key, a capital letter.
    pub const fn key(self) -> char {
        self.about().keys[0].0.as_bytes()[0] as char
    }

    /// One line for the status bar: what the buttons do now.
    pub const fn hint(self) -> &'static str {
        self.about().hint
    }

    /// Its button's strokes, on a grid of 16 by 16.
    pub const fn icon(self) -> &'static [Pen] {
        self.about().icon
    }

    /// Heading and lines of the page of keys: keys as printed, and what they do.
    pub(super) const fn keys(self) -> (&'static str, &'static [(&'static str, &'static str)]) {
        (self.about().group, self.about().keys)
    }

    /// Whether it works on parts.
    pub const fn is_of_parts(self) -> bool {
        self.about().of_parts
    }

    /// Whether Shift is its own; with others it places the crosshair.
    pub(super) const fn has_shift(self) -> bool {
        self.about().has_shift
    }

    /// Whether what lies before its cut comes off.
    pub fn peels(self) -> bool {
        self.does().peels()
    }

    /// Which of the things that are written on surfaces it works on; `None` if it writes nothing.
    pub fn picks(self) -> Option<fn(Written) -> bool> {
        self.does().picks()
    }

    /// What is said if it is used where it does nothing; `None` if it does something there.
    pub fn refusal(self, view: ViewName) -> Option<&'static str> {
        self.does().refusal(view)
    }

    /// What is drawn about the pointer, over the view's picture.
    pub fn marks(self, scene: &Scene, at: &Aimed) -> Vec<Mark> {
        self.does().marks(scene, at)
    }
}
