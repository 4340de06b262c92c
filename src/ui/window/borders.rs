//! The borders that are dragged: between panels and views, between views, over lists.
//!
//! Panels say while a frame is made where their borders lie; they are asked for the pointer after everything else, so that they
//! lie on top. What a border changes is the [`Layout`] and nothing else.

use crate::ui::state::borders::Edge;
use crate::ui::state::layout::BORDER;
use crate::ui::style::theme;
use crate::ui::window::app::App;
use egui::{Id, Role, Sense, Ui, WidgetInfo};

impl App {
    /// A border lies here; drawn now, asked for the pointer later.
    pub(crate) fn border(&mut self, edge: Edge) {
        self.backdrop.fill(edge.place, theme::DEEP);
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
