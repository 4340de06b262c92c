//! The few controls that panels are made of. Each has an accessible name and a tooltip, and none grows with what it shows; none
//! knows the document.

use crate::interact::readout;
use crate::ui::style::icons;
use crate::ui::style::icons::Icon;
use crate::ui::style::theme;
use crate::ui::style::theme::{GAP, LABEL, ROW};
use egui::{
    Align, Align2, Color32, CornerRadius, DragValue, Layout, Popup, PopupCloseBehavior, Response, RichText, Role,
};
use egui::{ScrollArea, Sense, Slider, SliderClamping, Stroke, TextStyle, Ui, WidgetInfo, vec2};
use std::ops::RangeInclusive;

/// A tooltip that stays while the control cannot be used.
pub(crate) fn tipped(response: Response, tip: &str) -> Response {
    response.on_hover_text(tip).on_disabled_hover_text(tip)
}

/// Width that a list leaves to its scroll bar.
const LIST_BAR: f32 = 9.0;

/// The rows of a list in sight, scrolled within `height` whatever their number: what comes to it moves nothing else.
pub(crate) fn list(
    ui: &mut Ui,
    name: &str,
    height: f32,
    row: f32,
    rows: usize,
    to_end: bool,
    mut show: impl FnMut(&mut Ui, std::ops::Range<usize>),
) {
    ui.scope(|ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        let area = ScrollArea::vertical().id_salt(name).max_height(height).min_scrolled_height(height);
        area.auto_shrink([false, false]).stick_to_bottom(to_end).show_rows(ui, row, rows, |ui, range| {
            // The bar lies over nothing that is clicked.
            ui.set_max_width(ui.available_width() - LIST_BAR);
            show(ui, range);
        });
    });
}

/// A label and what it names on one line.
pub(crate) fn row<R>(ui: &mut Ui, label: &str, body: impl FnOnce(&mut Ui) -> R) -> R {
    ui.horizontal(|ui| {
        ui.set_min_height(ROW);
        let (rect, _) = ui.allocate_exact_size(vec2(LABEL, ROW), Sense::hover());
        let font = TextStyle::Body.resolve(ui.style());
        ui.painter().text(rect.left_center(), Align2::LEFT_CENTER, label, font, theme::TEXT_WEAK);
        body(ui)
    })
    .inner
}

/// How a slider counts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    pub(crate) logarithmic: bool,
    pub(crate) decimals: usize,
    pub(crate) unit: &'static str,
    /// Units in 1 of the value.
    pub(crate) factor: f64,
}

impl Scale {
    /// The value as it is.
    pub(crate) const PLAIN: Self = Self { logarithmic: false, decimals: 0, unit: "", factor: 1.0 };
    /// 0..1 as percent.
    pub(crate) const PERCENT: Self = Self { unit: " %", factor: 100.0, ..Self::PLAIN };
}

/// Width of a number beside its slider: no value of any unit makes it wider.
const NUMBER: f32 = 72.0;

/// A slider with its number; changed if either was. A value beyond its ends stays until a hand moves it.
pub(crate) fn slider(
    ui: &mut Ui,
    (name, tip): (&str, &str),
    value: &mut f64,
    range: RangeInclusive<f64>,
    scale: Scale,
) -> Response {
    ui.spacing_mut().slider_width = (ui.available_width() - NUMBER - GAP).max(24.0);
    let (lo, hi) = (*range.start(), *range.end());
    // Halves, where the distance is beyond all numbers.
    let unit = if (hi - lo).is_finite() { 1.0 } else { 0.5 };
    let mut at = *value * unit;
    let rail = ui
        .add(
            Slider::new(&mut at, lo * unit..=hi * unit)
                .show_value(false)
                .logarithmic(scale.logarithmic)
                .smart_aim(false)
                .clamping(SliderClamping::Edits),
        )
        .accessible_name(name);
    let rail = tipped(rail, tip);
    if rail.changed() {
        *value = at / unit;
    }
    let factor = scale.factor;
    let mut shown = *value * factor;
    let speed = if scale.logarithmic { shown.abs().max(0.01) * 0.01 } else { (hi / 400.0 - lo / 400.0) * factor };
    let field = DragValue::new(&mut shown).range(lo * factor..=hi * factor).clamp_existing_to_range(false);
    let field = field.speed(speed).suffix(scale.unit);
    let about = (&*format!("{name}, value"), &*format!("{tip}. Drag, or click to type"));
    let text = number(ui, NUMBER, about, scale.unit, field, |x, chars| readout::fixed(x, scale.decimals, chars));
    if text.changed() {
        *value = shown / factor;
    }
    rail | text
}

/// A number that is dragged, or typed and entered, in a place that is never wider: `show` writes it in so many characters, which `beside` stands
/// before or behind.
pub(crate) fn number<'a>(
    ui: &mut Ui,
    width: f32,
    (name, tip): (&str, &str),
    beside: &str,
    field: DragValue<'a>,
    show: impl Fn(f64, usize) -> String + 'a,
) -> Response {
    let (place, _) = ui.allocate_exact_size(vec2(width, ROW), Sense::hover());
    let layout = Layout::centered_and_justified(egui::Direction::LeftToRight);
    let mut inner = ui.new_child(egui::UiBuilder::new().max_rect(place).layout(layout));
    inner.shrink_clip_rect(place);
    inner.spacing_mut().button_padding.x = 2.0;
    let font = TextStyle::Monospace.resolve(ui.style());
    let digit = ui.ctx().fonts_mut(|f| f.glyph_width(&font, '0')).max(1.0);
    // What stands beside it is written as text is.
    let text = TextStyle::Body.resolve(ui.style());
    let beside = match beside.trim() {
        "" => 0.0,
        beside => ui.painter().layout_no_wrap(beside.to_owned(), text, theme::TEXT).size().x + GAP,
    };
    let chars = ((width - 4.0 - beside) / digit).floor().max(4.0) as usize;
    // What is typed counts when it is entered: its first digits are another number.
    let field = field.update_while_editing(false);
    let field = if escaped(ui) { field.custom_parser(|_| None) } else { field };
    let field = field.clip_text(true).custom_formatter(move |x, _| show(x, chars));
    tipped(inner.add(field).accessible_name(name), tip)
}

/// Whether Escape was hit in this frame or the one before: the toolkit would enter a frame later what it left.
fn escaped(ui: &Ui) -> bool {
    let (id, now) = (egui::Id::unique("escape in a number"), ui.ctx().cumulative_pass_nr());
    if ui.input(|i| i.key_pressed(egui::Key::Escape)) {
        ui.data_mut(|d| d.insert_temp(id, now));
    }
    ui.data(|d| d.get_temp::<u64>(id)).is_some_and(|at| now <= at + 1)
}

/// A button of this size with its tooltip.
pub(crate) fn button(ui: &mut Ui, size: egui::Vec2, text: &str, tip: &str) -> bool {
    tipped(ui.add_sized(size, egui::Button::new(text).truncate()), tip).clicked()
}

/// A button that opens a menu; without a text it is as wide as its sign.
pub(crate) fn menu(ui: &mut Ui, size: egui::Vec2, (name, text, tip): (&str, &str, &str), body: impl FnOnce(&mut Ui)) {
    let padding = ui.spacing().button_padding.x;
    // Room at the end for the sign that says menu.
    let label = if text.is_empty() { String::new() } else { format!("{text}     ") };
    let button = egui::Button::new(label).min_size(size);
    let (response, _) = egui::containers::menu::MenuButton::from_button(button).ui(ui, body);
    let sign = match text.is_empty() {
        true => response.rect.center(),
        false => response.rect.right_center() - vec2(padding + 4.0, 0.0),
    };
    let place = egui::Rect::from_center_size(sign, vec2(12.0, 12.0));
    icons::paint(ui.painter(), place, Icon::Down, theme::TEXT_WEAK);
    tipped(response.accessible_name(name), tip);
}

/// A box that is ticked; answers whether it was changed.
pub(crate) fn tick(ui: &mut Ui, on: &mut bool, text: &str, tip: &str) -> bool {
    tipped(ui.checkbox(on, text), tip).changed()
}

/// One of a few: all are seen, one is lit. Answers another one that was clicked.
pub(crate) fn choice<T: PartialEq + Copy>(
    ui: &mut Ui,
    name: &str,
    now: Option<T>,
    options: &[(T, &str, &str)],
) -> Option<T> {
    pick(ui, name, now, options).filter(|picked| now != Some(*picked))
}

/// The same; answers the one that was clicked, also if it is lit already.
pub(crate) fn pick<T: PartialEq + Copy>(
    ui: &mut Ui,
    name: &str,
    now: Option<T>,
    options: &[(T, &str, &str)],
) -> Option<T> {
    let mut clicked = None;
    ui.spacing_mut().item_spacing.x = 1.0;
    let mut font = TextStyle::Button.resolve(ui.style());
    let room = ui.available_width() - (options.len() as f32 - 1.0);
    // Each gets its text and an equal share of what is left, so that no text meets its neighbour; in a narrow panel the text is
    // smaller.
    let (widths, spare) = loop {
        let text = |label: &str| ui.painter().layout_no_wrap(label.to_owned(), font.clone(), Color32::WHITE).size().x;
        let widths: Vec<f32> = options.iter().map(|o| text(o.1)).collect();
        let spare = (room - widths.iter().sum::<f32>()) / options.len() as f32;
        if spare >= 6.0 || font.size <= 10.5 {
            break (widths, spare.max(2.0));
        }
        font.size -= 0.5;
    };
    for (i, (value, label, tip)) in options.iter().enumerate() {
        let (rect, response) = ui.allocate_exact_size(vec2(widths[i] + spare, ROW), Sense::click());
        let on = now == Some(*value);
        let enabled = ui.is_enabled();
        response.widget_info(|| WidgetInfo::selected(Role::RadioButton, enabled, on, format!("{name}: {label}")));
        let round = |first: bool, last: bool| CornerRadius {
            nw: if first { theme::ROUND } else { 0 },
            sw: if first { theme::ROUND } else { 0 },
            ne: if last { theme::ROUND } else { 0 },
            se: if last { theme::ROUND } else { 0 },
        };
        paint_face(ui, rect, &response, on, round(i == 0, i + 1 == options.len()));
        let colour = face_colour(ui, &response, on);
        ui.painter().text(rect.center(), Align2::CENTER_CENTER, label, font.clone(), colour);
        if tipped(response, tip).clicked() {
            clicked = Some(*value);
        }
    }
    clicked
}

fn face_colour(ui: &Ui, response: &Response, on: bool) -> Color32 {
    let colour = if on || response.hovered() { Color32::WHITE } else { theme::TEXT };
    if ui.is_enabled() { colour } else { ui.visuals().disable(colour) }
}

fn paint_face(ui: &Ui, rect: egui::Rect, response: &Response, on: bool, radius: CornerRadius) {
    let fill = match (on, response.hovered()) {
        (true, _) => theme::ACCENT_FILL,
        (false, true) => theme::CONTROL_HOVER,
        (false, false) => theme::CONTROL,
    };
    let fill = if ui.is_enabled() { fill } else { ui.visuals().disable(fill) };
    ui.painter().rect_filled(rect, radius, fill);
    if response.has_focus() {
        ui.painter().rect_stroke(rect, radius, Stroke::new(1.5, theme::ACCENT), egui::StrokeKind::Inside);
    }
}

/// What an icon button is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face<'a> {
    pub(crate) icon: Icon,
    /// Accessible name; also the text beside the icon if `with_text`.
    pub(crate) name: &'a str,
    pub(crate) tip: &'a str,
    pub(crate) on: bool,
    pub(crate) with_text: bool,
    /// Without a ground of its own until the pointer comes.
    pub(crate) flat: bool,
    pub(crate) size: f32,
    pub(crate) tint: Option<Color32>,
}

impl<'a> Face<'a> {
    /// A small one for the end of a row.
    pub(crate) fn small(icon: Icon, name: &'a str, tip: &'a str) -> Self {
        Self { icon, name, tip, on: false, with_text: false, flat: true, size: ROW, tint: None }
    }

    /// One for the tool bar.
    pub(crate) fn tool(icon: Icon, name: &'a str, tip: &'a str, with_text: bool) -> Self {
        Self { icon, name, tip, on: false, with_text, flat: true, size: 32.0, tint: None }
    }

    pub(crate) fn on(self, on: bool) -> Self {
        Self { on, ..self }
    }

    pub(crate) fn tint(self, tint: Color32) -> Self {
        Self { tint: Some(tint), ..self }
    }
}

/// A button with an icon.
pub(crate) fn icon_button(ui: &mut Ui, face: Face<'_>) -> Response {
    let font = TextStyle::Button.resolve(ui.style());
    let text = face.with_text.then(|| ui.painter().layout_no_wrap(face.name.to_owned(), font, Color32::PLACEHOLDER));
    let width = text.as_ref().map_or(face.size, |t| t.size().x + 16.0 + 6.0 + 16.0);
    let (rect, response) = ui.allocate_exact_size(vec2(width, face.size), Sense::click());
    let enabled = ui.is_enabled();
    response.widget_info(|| WidgetInfo::selected(Role::Button, enabled, face.on, face.name));
    if face.on || !face.flat || response.hovered() || response.has_focus() {
        paint_face(ui, rect, &response, face.on, CornerRadius::same(theme::ROUND));
    }
    let colour = match face.tint {
        Some(tint) if enabled && !face.on => tint,
        _ => face_colour(ui, &response, face.on),
    };
    let square = match &text {
        Some(_) => egui::Rect::from_center_size(rect.left_center() + vec2(16.0, 0.0), vec2(16.0, 16.0)),
        None => rect,
    };
    let paint = if face.size < ROW { icons::paint_narrow } else { icons::paint };
    paint(ui.painter(), square, face.icon, colour);
    if let Some(text) = text {
        let at = rect.left_center() + vec2(30.0, -text.size().y * 0.5);
        ui.painter().galley(at, text, colour);
    }
    tipped(response, face.tip)
}

/// What a button opens with controls in it, which look as they do in panels; it stays until something beside it is clicked.
pub(crate) fn controls_under(button: &Response, body: impl FnOnce(&mut Ui)) {
    let popup = Popup::menu(button).close_behavior(PopupCloseBehavior::CloseOnClickOutside);
    popup.style(egui::style::StyleModifier::default()).show(body);
}

/// Says that something runs, a few times a second: on software drivers a frame costs what runs its time.
pub(crate) fn spinner(ui: &mut Ui, size: f32) {
    let (rect, response) = ui.allocate_exact_size(vec2(size, size), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::ProgressIndicator, true, "Running"));
    let turn = (ui.input(|i| i.time) * 8.0).floor() as f32 * std::f32::consts::FRAC_PI_4;
    let at = |i: u8| rect.center() + egui::Vec2::angled(turn + f32::from(i) * 0.35) * (size * 0.5 - 1.5);
    ui.painter().add(egui::Shape::line((0..=12).map(at).collect(), Stroke::new(2.0, theme::ACCENT)));
    ui.ctx().request_repaint_after(std::time::Duration::from_millis(125));
}

/// A line of text that says what is missing.
pub(crate) fn empty(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).color(theme::TEXT_WEAK));
}

/// A line of text of so much width that ends in … where there is no room for all of it, and says all of it to whoever points at it.
pub(crate) fn line(ui: &mut Ui, text: &str, width: f32, colour: Color32) {
    let (rect, response) = ui.allocate_exact_size(vec2(width, ROW), Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, text));
    let shown = cut_text(ui, text, TextStyle::Body.resolve(ui.style()), colour, width);
    ui.painter().galley(rect.left_center() - vec2(0.0, shown.size().y * 0.5), shown, colour);
    response.on_hover_text(text);
}

/// One line of text that ends in … where there is no room for all of it.
pub(crate) fn cut_text(
    ui: &Ui,
    text: &str,
    font: egui::FontId,
    colour: Color32,
    width: f32,
) -> std::sync::Arc<egui::Galley> {
    let mut job = egui::text::LayoutJob::simple_singleline(text.to_owned(), font, colour);
    job.wrap = egui::text::TextWrapping::truncate_at_width(width);
    ui.painter().layout_job(job)
}

/// Contents from the right.
pub(crate) fn from_right<R>(ui: &mut Ui, body: impl FnOnce(&mut Ui) -> R) -> R {
    ui.with_layout(Layout::right_to_left(Align::Center), body).inner
}

/// One line of buttons that ends at the right.
pub(crate) fn from_right_row<R>(ui: &mut Ui, body: impl FnOnce(&mut Ui) -> R) -> R {
    ui.allocate_ui_with_layout(vec2(ui.available_width(), 32.0), Layout::right_to_left(Align::Center), body).inner
}

/// The button that is meant most often.
pub(crate) fn primary(text: &str) -> egui::Button<'_> {
    egui::Button::new(RichText::new(text).color(Color32::WHITE)).fill(theme::ACCENT_FILL).min_size(vec2(110.0, 30.0))
}

/// The button that leaves a question as if it had not been asked.
pub(crate) fn cancel(ui: &mut Ui) -> bool {
    tipped(ui.add(plain("Cancel")), "Back to where it was, nothing done (Esc)").clicked()
}

/// Any other.
pub(crate) fn plain(text: &str) -> egui::Button<'_> {
    egui::Button::new(text).min_size(vec2(90.0, 30.0))
}
