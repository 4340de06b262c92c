//! The borders that are dragged: between panels and views, between views, over lists.
//!
//! Panels say while a frame is made where their borders lie; they are asked for the pointer after everything else, so that they
//! lie on top. What a border changes is the [`Layout`] and nothing else.

use crate::ui::style::theme;
use crate::ui::window::app::App;
use crate::ui::window::layout::{BORDER, Layout};
use egui::{CursorIcon, Id, Rect, Role, Sense, Ui, WidgetInfo};
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
    const fn name(self) -> &'static str {
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

    const fn cursor(self) -> CursorIcon {
        match self {
            Self::Left | Self::Right | Self::Upright => CursorIcon::ResizeHorizontal,
            Self::Segments | Self::Lists | Self::Steps | Self::Level => CursorIcon::ResizeVertical,
            Self::Crossing => CursorIcon::Move,
        }
    }

    /// As it was before anybody dragged it.
    fn reset(self, layout: &mut Layout) {
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
    fn drag(self, layout: &mut Layout, start: [f32; 2], moved: egui::Vec2, extent: [f32; 2]) {
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
    edges: Vec<Edge>,
    held: Option<(Border, [f32; 2])>,
    /// Where the layout is kept.
    kept_in: Option<PathBuf>,
}

impl Borders {
    /// Those whose layout is kept in a file.
    pub(crate) fn kept_in(path: PathBuf) -> Self {
        Self { kept_in: Some(path), ..Self::default() }
    }
}

impl App {
    /// A border lies here; drawn now, asked for the pointer later.
    pub(crate) fn border(&mut self, edge: Edge) {
        self.grounds.fill(edge.place, theme::DEEP);
        self.borders.edges.push(edge);
    }

    /// Lets all borders of the frame be dragged.
    pub(crate) fn drag_borders(&mut self, ui: &mut Ui) {
        let mut done = false;
        for Edge { border, place, now, extent } in std::mem::take(&mut self.borders.edges) {
            let response = ui.interact(place, Id::unique(("border", border)), Sense::click_and_drag());
            response.widget_info(|| WidgetInfo::labeled(Role::Splitter, true, border.name()));
            let response = response.on_hover_and_drag_cursor(border.cursor());
            if response.hovered() || response.dragged() {
                let thin = (BORDER - 2.0) * 0.5;
                let line = if place.height() > place.width() * 2.0 {
                    place.shrink2(egui::vec2(thin, 0.0))
                } else if place.width() > place.height() * 2.0 {
                    place.shrink2(egui::vec2(0.0, thin))
                } else {
                    place
                };
                ui.painter().rect_filled(line, 0.0, theme::ACCENT);
            }
            if response.drag_started() {
                self.borders.held = Some((border, now));
            }
            if let (Some((held, start)), Some(moved)) = (self.borders.held, response.total_drag_delta())
                && held == border
            {
                border.drag(&mut self.layout, start, moved, extent);
                self.layout = std::mem::take(&mut self.layout).checked();
            }
            if response.double_clicked() {
                border.reset(&mut self.layout);
            }
            done |= response.double_clicked() || response.drag_stopped();
            if !response.dragged() {
                response.on_hover_text("Drag to move this border; double-click: as it was at first");
            }
        }
        if done {
            self.borders.held = None;
            ui.ctx().request_repaint();
            self.keep_layout();
        }
    }

    /// Writes the layout where it is kept, if it is.
    pub(crate) fn keep_layout(&self) {
        if let Some(path) = &self.borders.kept_in
            && let Err(error) = self.layout.write(path)
        {
            tracing::warn!("{}: the window's layout was not kept: {error}", path.display());
        }
    }
}
