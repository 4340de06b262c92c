//! The three first steps on the sample head, each done by one click: select, split, slide.
//!
//! A strip at the foot of the window, there from the sample's opening until it is closed. What its buttons do are commands like
//! any other, to be undone like any other.

use crate::document::{Command, ExplosionCommand, PartCommand, SelectionCommand, Splitter, ViewCommand};
use crate::ui::state::lesson::Lesson;
use crate::ui::state::sample::Sample;
use crate::ui::style::icons::Icon;
use crate::ui::style::theme;
use crate::ui::style::theme::GAP;
use crate::ui::style::widgets::{Face, from_right, icon_button, tipped};
use crate::ui::window::app::App;
use egui::{Button, Color32, Frame, Margin, Panel, RichText, Ui, vec2};
use std::path::Path;

/// Where the sample's brain lies, world mm: three cuts through it make eight parts.
const MIDDLE: [f64; 3] = [0.0, -18.0, 16.0];
/// A soft border about the brain, mm, and what of its values is brain.
const SOFT_MM: f64 = 2.0;
const BRAIN: f64 = 0.5;

const STEPS: [(&str, &str); 3] = [
    ("Select the brain", "Marks what shall stay in sight. By hand: press B and paint, on a slice or in 3D"),
    ("Split the head", "Cuts the rest into eight parts. By hand: press X and click in the 3D view"),
    ("Slide the parts apart", "Moves the parts out of the way. By hand: pull “Degree” under Explosion"),
];

impl App {
    /// The sample is open, or something else.
    pub(crate) fn begin_lesson(&mut self, opened: &Path) {
        let sample = self.recent.folder().map(Sample::below);
        self.lesson = sample.filter(|sample| sample.head == opened).map(|_| Lesson(0));
    }

    pub(crate) fn lesson_strip(&mut self, ui: &mut Ui) {
        let Some(Lesson(next)) = self.lesson.filter(|_| self.opened().is_some()) else { return };
        let frame = Frame::new().inner_margin(Margin::symmetric(10, 5));
        let (mut clicked, mut closed) = (None, false);
        let strip = Panel::bottom("lesson").resizable(false).frame(frame).show(ui, |ui| {
            ui.horizontal(|ui| {
                ui.set_min_height(26.0);
                ui.label(RichText::new("First steps").color(theme::TEXT_WEAK));
                ui.add_space(8.0);
                for (i, (name, tip)) in STEPS.iter().enumerate() {
                    let fill = if i == next { theme::ACCENT_FILL } else { theme::CONTROL };
                    let text = RichText::new(format!("{}  {name}", i + 1)).color(if i == next {
                        Color32::WHITE
                    } else {
                        theme::TEXT
                    });
                    let button = Button::new(text).fill(fill).min_size(vec2(0.0, 26.0));
                    if tipped(ui.add(button).accessible_name(*name), tip).clicked() {
                        clicked = Some(i);
                    }
                    ui.add_space(GAP);
                }
                from_right(ui, |ui| {
                    let face =
                        Face::small(Icon::Close, "Close the first steps", "Close; the start page tells them again");
                    closed = icon_button(ui, face).clicked();
                });
            });
        });
        self.backdrop.fill(strip.response.rect, theme::BAR);
        if let Some(step) = clicked {
            // A step needs those before it: whoever begins with the last one sees what it is for all the same.
            (next.min(step)..=step).for_each(|step| self.do_step(step));
            self.lesson = Some(Lesson(next.max(step + 1)));
        }
        if closed {
            self.lesson = None;
        }
    }

    fn do_step(&mut self, step: usize) {
        match step {
            0 => {
                let Some(sample) = self.recent.folder().map(Sample::below) else { return };
                let import =
                    SelectionCommand::Import { path: sample.brain, threshold: BRAIN, soften_mm: SOFT_MM, volume: None };
                self.send(Command::Selection(import));
            }
            1 => {
                for normal in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
                    let by = Splitter::Plane { point: MIDDLE, normal, part: None };
                    self.send(Command::Part(PartCommand::Split { by, size: None }));
                }
                self.send(Command::View(ViewCommand::Frame { from: [0.75, 1.0, 0.45], up: None, zoom: Some(1.3) }));
            }
            _ => self.send(Command::Explosion(ExplosionCommand::Degree { value: 1.0 })),
        }
    }
}
