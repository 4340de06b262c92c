//! A colour that is changed by hand: a square that opens hue, saturation and brightness, with some colours ready.
//!
//! Of our own, since each of its controls has a name, and one of them can be whatever the caller needs there.

use crate::ui::style::theme;
use crate::ui::style::theme::{GAP, LABEL, ROW};
use crate::ui::style::widgets::{Scale, controls_under, row, slider};
use egui::ecolor::{hsv_from_rgb, rgb_from_hsv};
use egui::{Rect, Response, Role, Sense, Stroke, StrokeKind, Ui, WidgetInfo, vec2};

/// The square's size.
const SQUARE: egui::Vec2 = vec2(22.0, 18.0);
/// Well apart from each other, also for most who confuse red and green.
const READY: [(&str, [f32; 3]); 8] = [
    ("red", [0.89, 0.29, 0.25]),
    ("orange", [0.95, 0.61, 0.22]),
    ("yellow", [0.94, 0.87, 0.35]),
    ("green", [0.34, 0.72, 0.40]),
    ("cyan", [0.33, 0.78, 0.83]),
    ("blue", [0.30, 0.50, 0.88]),
    ("magenta", [0.80, 0.44, 0.78]),
    ("white", [0.95, 0.95, 0.95]),
];

/// A square of a display-referred colour, 0..1, that opens the picker; changed if the colour was.
pub(crate) fn colour_button(ui: &mut Ui, name: &str, colour: &mut [f32; 3]) -> Response {
    colour_button_with(ui, name, colour, |_| {})
}

/// The same with something more at the picker's end.
pub(crate) fn colour_button_with(
    ui: &mut Ui,
    name: &str,
    colour: &mut [f32; 3],
    more: impl FnOnce(&mut Ui),
) -> Response {
    let mut response = square(ui, SQUARE, name, *colour).on_hover_text(name);
    let mut changed = false;
    controls_under(&response, |ui| {
        ui.set_width(LABEL + 190.0);
        changed = picker(ui, response.id, colour);
        more(ui);
    });
    if changed {
        response.mark_changed();
    }
    response
}

fn square(ui: &mut Ui, size: egui::Vec2, name: &str, colour: [f32; 3]) -> Response {
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let fill = theme::rgb(colour);
    response.widget_info(|| {
        let mut info = WidgetInfo::labeled(Role::ColorWell, ui.is_enabled(), name);
        info.current_text_value = Some(hex(colour));
        info
    });
    ui.painter().rect_filled(rect, theme::ROUND, fill);
    let edge = if response.hovered() || response.has_focus() { theme::TEXT } else { theme::LINE };
    ui.painter().rect_stroke(rect, 3.0, Stroke::new(1.0, edge), StrokeKind::Inside);
    response
}

/// Colours that are ready on one line of this width, behind one more by its name; the one that was clicked.
pub(crate) fn ready_colours(ui: &mut Ui, width: f32, first: Option<(&str, [f32; 3])>) -> Option<[f32; 3]> {
    let ready = READY.map(|(name, colour)| (format!("Pick {name}"), name, colour));
    let first = first.map(|(name, colour)| (name.to_owned(), name, colour));
    let gap = GAP + 2.0;
    let count = READY.len() + usize::from(first.is_some());
    let each = ((width + gap) / count as f32 - gap).min(28.0).floor();
    ui.spacing_mut().item_spacing.x = gap;
    let mut clicked = |(name, tip, colour): &(String, &str, [f32; 3])| {
        square(ui, vec2(each, ROW), name, *colour).on_hover_text(*tip).clicked()
    };
    first.into_iter().chain(ready).filter(|colour| clicked(colour)).map(|(.., colour)| colour).last()
}

fn picker(ui: &mut Ui, id: egui::Id, colour: &mut [f32; 3]) -> bool {
    let before = *colour;
    let width = ui.available_width();
    *colour = ui.horizontal(|ui| ready_colours(ui, width, None)).inner.unwrap_or(*colour);
    ui.add_space(GAP);
    // Grey has no hue and black no saturation: what was chosen last is kept for the way back.
    let known = ui.data(|d| d.get_temp::<([f32; 3], [f32; 3])>(id)).filter(|(of, _)| of == colour);
    let [mut h, mut s, mut v] = known.map_or_else(
        || {
            let (h, s, v) = hsv_from_rgb(*colour);
            [f64::from(h), f64::from(s), f64::from(v)]
        },
        |(_, hsv)| hsv.map(f64::from),
    );
    let degrees = Scale { decimals: 0, unit: "°", ..Scale::PLAIN };
    let mut turn = h * 360.0;
    let mut moved = row(ui, "Hue", |ui| {
        slider(ui, ("Hue", "Which colour of the rainbow"), &mut turn, 0.0..=360.0, degrees).changed()
    });
    h = turn / 360.0;
    moved |= row(ui, "Saturation", |ui| {
        slider(ui, ("Saturation", "From grey to the pure colour"), &mut s, 0.0..=1.0, Scale::PERCENT).changed()
    });
    moved |= row(ui, "Brightness", |ui| {
        slider(ui, ("Brightness", "From black to bright"), &mut v, 0.0..=1.0, Scale::PERCENT).changed()
    });
    if moved {
        let hsv = [h as f32, s as f32, v as f32];
        *colour = rgb_from_hsv((hsv[0], hsv[1], hsv[2]));
        ui.data_mut(|d| d.insert_temp(id, (*colour, hsv)));
    }
    row(ui, "Hex", |ui| {
        let draft = id.with("hex");
        let now = hex(*colour);
        let mut text = ui.data(|d| d.get_temp::<String>(draft)).unwrap_or_else(|| now.clone());
        let field = egui::TextEdit::singleline(&mut text)
            .id(draft.with("field"))
            .desired_width(80.0)
            .align(egui::Align2::LEFT_CENTER);
        let field = ui.add(field).accessible_name("Colour in hex");
        let field = field.on_hover_text("Red, green and blue as six digits, such as #e34a40");
        // While it is typed the colour follows whatever is a colour.
        if field.changed()
            && let Some(typed) = from_hex(&text)
        {
            *colour = typed;
        }
        ui.data_mut(|d| d.remove::<String>(draft));
        if field.has_focus() {
            ui.data_mut(|d| d.insert_temp(draft, text));
        }
    });
    *colour != before
}

/// A colour as `#rrggbb`.
pub(crate) fn hex(colour: [f32; 3]) -> String {
    let c = theme::rgb(colour);
    format!("#{:02x}{:02x}{:02x}", c.r(), c.g(), c.b())
}

/// The colour that `#rrggbb`, `rrggbb` or `#rgb` names.
fn from_hex(text: &str) -> Option<[f32; 3]> {
    let digits: Option<Vec<u32>> = text.trim().trim_start_matches('#').chars().map(|c| c.to_digit(16)).collect();
    let byte = |high: u32, low: u32| (high * 16 + low) as f32 / 255.0;
    match digits?[..] {
        [r, g, b] => Some([byte(r, r), byte(g, g), byte(b, b)]),
        [r, rr, g, gg, b, bb] => Some([byte(r, rr), byte(g, gg), byte(b, bb)]),
        _ => None,
    }
}

/// Says over a square that its colour is nobody's choice.
pub(crate) fn strike_out(ui: &Ui, square: Rect) {
    let inner = square.shrink(3.0);
    ui.painter().line_segment([inner.left_bottom(), inner.right_top()], Stroke::new(1.5, theme::DEEP));
}
