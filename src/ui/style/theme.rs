//! One look for the whole window: neutral greys, one accent, a 4 px grid, 13.5 px text.
//!
//! Owns every colour and length that panels share. Text keeps a contrast of at least 4.5 to 1 against what it stands on.

use crate::document::ViewName;
use egui::{Color32, CornerRadius, FontFamily, FontId, Margin, Stroke, TextStyle, Vec2, Visuals};

/// Behind panels.
pub const PANEL: Color32 = Color32::from_rgb(0x25, 0x26, 0x29);
/// Behind the bars at the top and the bottom.
pub const BAR: Color32 = Color32::from_rgb(0x1d, 0x1e, 0x20);
/// Between views, and behind fields that take text.
pub const DEEP: Color32 = Color32::from_rgb(0x16, 0x17, 0x18);
/// Over the window, under a question.
pub const SHADE: Color32 = Color32::from_black_alpha(140);
/// Lines between areas.
pub const LINE: Color32 = Color32::from_rgb(0x38, 0x3a, 0x3e);
/// Buttons at rest.
pub const CONTROL: Color32 = Color32::from_rgb(0x36, 0x38, 0x3d);
/// Buttons under the pointer.
pub const CONTROL_HOVER: Color32 = Color32::from_rgb(0x44, 0x47, 0x4d);
/// What is read.
pub const TEXT: Color32 = Color32::from_rgb(0xdd, 0xde, 0xe1);
/// What stands beside it.
pub const TEXT_WEAK: Color32 = Color32::from_rgb(0xa9, 0xac, 0xb2);
/// What is chosen.
pub const ACCENT: Color32 = Color32::from_rgb(0x5a, 0xa2, 0xe8);
/// Behind what is chosen.
pub const ACCENT_FILL: Color32 = Color32::from_rgb(0x2c, 0x56, 0x82);
/// Errors.
pub const ERROR: Color32 = Color32::from_rgb(0xf0, 0x7a, 0x72);
/// Warnings.
pub const WARNING: Color32 = Color32::from_rgb(0xe3, 0xb3, 0x5a);

/// Height of rows and of what is clicked in them.
pub const ROW: f32 = 22.0;
/// Width of the labels in front of controls.
pub const LABEL: f32 = 86.0;
/// Radius of corners.
pub const ROUND: u8 = 3;
/// One step of the grid.
pub const GAP: f32 = 4.0;

/// The colour of a view's name, its lines in the other views, and its frame.
pub const fn view_colour(view: ViewName) -> Color32 {
    match view {
        ViewName::ThreeD => Color32::from_rgb(0x7d, 0xa7, 0xe0),
        ViewName::Axial => Color32::from_rgb(0xe0, 0x6c, 0x62),
        ViewName::Coronal => Color32::from_rgb(0x6f, 0xba, 0x78),
        ViewName::Sagittal => Color32::from_rgb(0xdc, 0xb8, 0x52),
    }
}

/// The title that people read.
pub const fn view_title(view: ViewName) -> &'static str {
    match view {
        ViewName::ThreeD => "3D",
        ViewName::Axial => "Axial",
        ViewName::Coronal => "Coronal",
        ViewName::Sagittal => "Sagittal",
    }
}

/// Display-referred colour, 0..1.
pub(crate) fn rgb(c: [f32; 3]) -> Color32 {
    let byte = |x: f32| (x.clamp(0.0, 1.0) * 255.0).round() as u8;
    Color32::from_rgb(byte(c[0]), byte(c[1]), byte(c[2]))
}

/// Puts it on.
pub fn apply(ctx: &egui::Context) {
    ctx.set_theme(egui::Theme::Dark);
    ctx.all_styles_mut(|style| {
        style.text_styles = [
            (TextStyle::Small, FontId::new(12.0, FontFamily::Proportional)),
            (TextStyle::Body, FontId::new(13.5, FontFamily::Proportional)),
            (TextStyle::Button, FontId::new(13.5, FontFamily::Proportional)),
            (TextStyle::Heading, FontId::new(15.0, FontFamily::Proportional)),
            (TextStyle::Monospace, FontId::new(12.5, FontFamily::Monospace)),
        ]
        .into();
        // Digits of one width: numbers do not dance while they change.
        style.drag_value_text_style = TextStyle::Monospace;
        style.animation_time = 0.08;
        style.interaction.tooltip_delay = 0.4;
        style.spacing.item_spacing = Vec2::new(GAP, GAP);
        style.spacing.button_padding = Vec2::new(8.0, 3.0);
        style.spacing.interact_size = Vec2::new(24.0, ROW);
        style.spacing.slider_rail_height = 4.0;
        style.spacing.window_margin = Margin::same(16);
        style.spacing.menu_margin = Margin::same(6);
        style.spacing.combo_width = 60.0;
        style.visuals = visuals();
    });
}

fn visuals() -> Visuals {
    let mut v = Visuals::dark();
    v.panel_fill = PANEL;
    v.window_fill = Color32::from_rgb(0x2a, 0x2b, 0x2f);
    v.window_stroke = Stroke::new(1.0, Color32::from_rgb(0x4a, 0x4d, 0x53));
    v.window_corner_radius = CornerRadius::same(6);
    v.menu_corner_radius = CornerRadius::same(4);
    v.extreme_bg_color = DEEP;
    v.text_edit_bg_color = Some(DEEP);
    v.faint_bg_color = Color32::from_rgb(0x2a, 0x2b, 0x2f);
    v.override_text_color = None;
    v.weak_text_color = Some(TEXT_WEAK);
    v.hyperlink_color = ACCENT;
    v.error_fg_color = ERROR;
    v.warn_fg_color = WARNING;
    v.selection.bg_fill = ACCENT_FILL;
    v.selection.stroke = Stroke::new(1.0, Color32::WHITE);
    v.slider_trailing_fill = true;
    v.disabled_alpha = 0.45;
    let radius = CornerRadius::same(ROUND);
    let w = &mut v.widgets;
    for state in [&mut w.noninteractive, &mut w.inactive, &mut w.hovered, &mut w.active, &mut w.open] {
        state.corner_radius = radius;
        state.expansion = 0.0;
        state.fg_stroke = Stroke::new(1.0, TEXT);
        state.bg_stroke = Stroke::NONE;
    }
    w.noninteractive.bg_fill = PANEL;
    w.noninteractive.bg_stroke = Stroke::new(1.0, LINE);
    w.inactive.bg_fill = CONTROL;
    w.inactive.weak_bg_fill = CONTROL;
    w.hovered.bg_fill = CONTROL_HOVER;
    w.hovered.weak_bg_fill = CONTROL_HOVER;
    w.hovered.fg_stroke = Stroke::new(1.0, Color32::WHITE);
    w.active.bg_fill = ACCENT_FILL;
    w.active.weak_bg_fill = ACCENT_FILL;
    w.active.bg_stroke = Stroke::new(1.0, ACCENT);
    w.active.fg_stroke = Stroke::new(1.0, Color32::WHITE);
    w.open.bg_fill = CONTROL_HOVER;
    w.open.weak_bg_fill = CONTROL_HOVER;
    v
}

/// What scales the whole window: large screens without a scale of their own get larger text.
pub(crate) fn zoom_for(height_px: f32, native_scale: f32) -> f32 {
    if native_scale <= 1.01 && height_px >= 1200.0 { 1.25 } else { 1.0 }
}
