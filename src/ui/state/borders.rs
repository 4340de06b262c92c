//! The borders that are dragged between panels and views: where they lie in this frame, and which is held.
//!
//! Drawn and dragged in `window::borders`; knows no document.

use crate::ui::state::layout::Layout;
use egui::CursorIcon;
use egui::Rect;
use std::path::PathBuf;

/// What lies on its two sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Border {
    /// Panel on the left, views.
    Left,
    /// Views, panel on the right.
    Right,
    /// Sections of the left panel, segments.
    Segments,
    /// Sections of the right panel, parts and steps.
    Lists,
    /// Parts, steps.
    Steps,
    /// Views side by side.
    Upright,
    /// Views over each other.
    Level,
    /// All four views.
    Crossing,
}

impl Border {
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Left => "Border of the left panel",
            Self::Right => "Border of the right panel",
            Self::Segments => "Border over the segments",
            Self::Lists => "Border over the parts",
            Self::Steps => "Border over the history",
            Self::Upright => "Border between left and right views",
            Self::Level => "Border between upper and lower views",
            Self::Crossing => "Corner of all four views",
        }
    }

    pub(crate) const fn cursor(self) -> CursorIcon {
        match self {
            Self::Left | Self::Right | Self::Upright => CursorIcon::ResizeHorizontal,
            Self::Segments | Self::Lists | Self::Steps | Self::Level => CursorIcon::ResizeVertical,
            Self::Crossing => CursorIcon::Move,
        }
    }

    /// As it was before anybody dragged it.
    pub(crate) fn reset(self, layout: &mut Layout) {
        let usual = Layout::default();
        match self {
            Self::Left => layout.left = usual.left,
            Self::Right => layout.right = usual.right,
            Self::Segments => layout.segments = None,
            Self::Lists => layout.lists = None,
            Self::Steps => layout.steps = usual.steps,
            Self::Upright => layout.views[0] = 0.5,
            Self::Level => layout.views[1] = 0.5,
            Self::Crossing => layout.views = [0.5; 2],
        }
    }

    /// Where a drag by `moved` points leads from `start`; shares are of `extent` points.
    pub(crate) fn drag(self, layout: &mut Layout, start: [f32; 2], moved: egui::Vec2, extent: [f32; 2]) {
        let share = |i: usize, by: f32| start[i] + by / extent[i].max(1.0);
        match self {
            Self::Left => layout.left = start[0] + moved.x,
            Self::Right => layout.right = start[0] - moved.x,
            Self::Segments => layout.segments = Some(start[1] - moved.y),
            Self::Lists => layout.lists = Some(start[1] - moved.y),
            Self::Steps => layout.steps = share(1, -moved.y),
            Self::Upright => layout.views[0] = share(0, moved.x),
            Self::Level => layout.views[1] = share(1, moved.y),
            Self::Crossing => layout.views = [share(0, moved.x), share(1, moved.y)],
        }
    }
}

/// A border of this frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    pub(crate) border: Border,
    pub(crate) place: Rect,
    /// What it stands at across and down, in the layout's own measure, as far as the window lets it.
    pub(crate) now: [f32; 2],
    /// Points that a share of 1 is of.
    pub(crate) extent: [f32; 2],
}

/// The borders of a frame, and the one that is held.
#[derive(Debug, Default)]
pub(crate) struct Borders {
    pub(crate) edges: Vec<Edge>,
    pub(crate) held: Option<(Border, [f32; 2])>,
    /// Where the layout is kept.
    pub(crate) kept_in: Option<PathBuf>,
}

impl Borders {
    /// Those whose layout is kept in a file.
    pub(crate) fn kept_in(path: PathBuf) -> Self {
        Self { kept_in: Some(path), ..Self::default() }
    }
}
