//! Headings that fold what is under them, and which of them a person has folded.
//!
//! The toolkit knows how they stand in this run; [`Layout`](crate::ui::state::layout::Layout) keeps it over runs, by title. Which sections there are is the panels'.

use crate::ui::style::icons;
use crate::ui::style::icons::Icon;
use crate::ui::style::theme;
use crate::ui::style::widgets::line;
use crate::ui::window::app::App;
use egui::collapsing_header::CollapsingState;
use egui::{Align2, Color32, Id, Role, Sense, Stroke, Ui, UiBuilder, WidgetInfo, vec2};

/// Headings that were clicked in this frame, and whether they are open now.
#[derive(Clone, Default)]
struct Toggled(Vec<(String, bool)>);

impl App {
    /// Folds and unfolds as it was left in the run before.
    pub(crate) fn fold_as_kept(&self, ctx: &egui::Context) {
        for (title, &open) in &self.layout.folds {
            let mut state = fold_state(ctx, title, open);
            state.set_open(open);
            state.store(ctx);
        }
    }

    /// Keeps what was folded or unfolded in this frame.
    pub(crate) fn keep_folds(&mut self, ctx: &egui::Context) {
        let Toggled(toggled) = ctx.data_mut(|d| d.remove_temp(Id::NULL)).unwrap_or_default();
        if !toggled.is_empty() {
            self.layout.folds.extend(toggled);
            self.keep_layout();
        }
    }
}

/// A heading that folds what is under it. `of`: whose that is, where it is a question.
pub(crate) fn section(ui: &mut Ui, (title, of): (&str, Option<&str>), body: impl FnOnce(&mut Ui)) {
    heading(ui, (title, of), true, BOLD).show_body_unindented(ui, body);
    let at = ui.cursor().min;
    ui.painter().hline(at.x..=at.x + ui.available_width(), at.y, Stroke::new(1.0, theme::LINE));
    ui.add_space(2.0);
}

/// The same within a section, folded at first.
pub(crate) fn subsection(ui: &mut Ui, title: &str, body: impl FnOnce(&mut Ui)) {
    heading(ui, (title, None), false, &[0.0]).show_body_unindented(ui, body);
}

/// Twice, half a pixel apart: the one weight of the font serves as bold.
const BOLD: &[f32] = &[0.0, 0.45];

fn fold_state(ctx: &egui::Context, title: &str, open: bool) -> CollapsingState {
    CollapsingState::load_with_default_open(ctx, egui::Id::unique(("section", title)), open)
}

/// Whether the list under this heading is unfolded.
pub(crate) fn is_unfolded(ctx: &egui::Context, title: &str) -> bool {
    fold_state(ctx, title, true).is_open()
}

/// A heading over a list that has a place of its own; says whether the list is unfolded.
pub(crate) fn list_heading(ui: &mut Ui, heads: (&str, Option<&str>)) -> bool {
    heading(ui, heads, true, BOLD).is_open()
}

fn heading(ui: &mut Ui, (title, of): (&str, Option<&str>), open: bool, weight: &[f32]) -> CollapsingState {
    let mut state = fold_state(ui.ctx(), title, open);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), 24.0), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, state.is_open(), title));
    let response = response.accessible_name(format!("Section {title}")).on_hover_text("Click to fold or unfold");
    if response.clicked() {
        state.toggle(ui);
        state.store(ui.ctx());
        let open = state.is_open();
        ui.data_mut(|d| d.get_temp_mut_or_default::<Toggled>(Id::NULL).0.push((title.to_owned(), open)));
    }
    let colour = if response.hovered() || response.has_focus() { Color32::WHITE } else { theme::TEXT };
    let chevron = egui::Rect::from_center_size(rect.left_center() + vec2(6.0, 0.0), vec2(12.0, 12.0));
    icons::paint(ui.painter(), chevron, if state.is_open() { Icon::Down } else { Icon::Right }, theme::TEXT_WEAK);
    let font = egui::FontId::new(13.5, egui::FontFamily::Proportional);
    let at = rect.left_center() + vec2(18.0, 0.0);
    let mut end = at.x;
    for shift in weight {
        end = ui.painter().text(at + vec2(*shift, 0.0), Align2::LEFT_CENTER, title, font.clone(), colour).right();
    }
    if let Some(of) = of {
        let place = rect.with_min_x((end + 2.0 * theme::GAP).min(rect.right()));
        line(&mut ui.new_child(UiBuilder::new().max_rect(place)), of, place.width(), theme::TEXT_WEAK);
    }
    state
}
