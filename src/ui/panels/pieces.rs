//! What the tool that isolates does without a click: all pieces below a size go at once.

use crate::document::{Command, ComponentCommand, Isolation, PieceSize};
use crate::interact::readout;
use crate::ui::style::theme::{GAP, ROW};
use crate::ui::style::widgets::{button, number, row};
use crate::ui::window::app::App;
use egui::{DragValue, Ui, vec2};

impl App {
    /// The size, and the button that removes what is smaller.
    pub(super) fn pieces_row(&mut self, ui: &mut Ui) {
        row(ui, "Pieces under", |ui| {
            let width = (ui.available_width() - GAP) * 0.5;
            let field = DragValue::new(&mut self.least_piece).range(2..=u64::MAX).suffix(" voxels");
            let about = ("Size of small pieces", "Pieces of what is visible with fewer voxels are small");
            number(ui, width, about, "voxels", field, |x, chars| readout::fixed(x, 0, chars));
            let tip = "Removes all pieces of what is visible that have fewer voxels: within the selection if there is one, else anywhere";
            if button(ui, vec2(width, ROW), "Remove", tip) {
                let small = Isolation::smaller_than(PieceSize::Voxels(self.least_piece));
                self.send(Command::Component(ComponentCommand::Remove(small)));
            }
        });
    }
}
