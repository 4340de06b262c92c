//! The brush's falloff drawn by hand: strength from the middle of the brush, on the left, to its rim.
//!
//! Owns nothing: the points are the brush's. What a hand may do to them is `paint`'s rule.

use crate::paint::FalloffCurve;
use crate::ui::style::theme;
use crate::ui::style::theme::ROW;
use egui::{Pos2, Rect, Role, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};

const HANDLE: f32 = 9.0;

/// The curve after what the hand did to it in this frame.
pub(crate) fn falloff_curve(ui: &mut Ui, curve: FalloffCurve) -> FalloffCurve {
    let (outer, ground) = ui.allocate_exact_size(vec2(ui.available_width(), ROW * 2.0), Sense::click());
    ground.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, "Strength from the middle of the brush to its rim"));
    let rect = outer.shrink(HANDLE * 0.5 + 1.0);
    let place = |[x, f]: [f32; 2]| pos2(rect.left() + x * rect.width(), rect.bottom() - f * rect.height());
    let point = |at: Pos2| [(at.x - rect.left()) / rect.width(), (rect.bottom() - at.y) / rect.height()];
    let painter = ui.painter_at(outer);
    painter.rect_filled(outer, 2.0, theme::DEEP);
    let line: Vec<Pos2> = curve.points().iter().map(|p| place(*p)).collect();
    painter.line(line.clone(), Stroke::new(1.5, theme::ACCENT));
    let mut new = curve;
    for (i, &at) in line.iter().enumerate() {
        let area = Rect::from_center_size(at, vec2(HANDLE, HANDLE) * 1.5);
        let handle = ui.interact(area, ui.scope_id().with(("falloff point", i)), Sense::click_and_drag());
        let name = format!("Falloff point {}", i + 1);
        handle.widget_info(|| WidgetInfo::labeled(Role::Slider, true, &name));
        painter.circle_filled(at, HANDLE * 0.4, if handle.hovered() { theme::ACCENT } else { theme::TEXT });
        if handle.secondary_clicked() {
            new = new.without(i);
        } else if let (true, Some(to)) = (handle.dragged(), handle.interact_pointer_pos()) {
            new = new.moved(i, point(to));
        }
        handle.on_hover_text("Strength at this distance: drag it; right-click removes it");
    }
    if let (true, Some(at)) = (ground.double_clicked(), ground.interact_pointer_pos()) {
        new = new.with(point(at));
    }
    ground.on_hover_text("The middle of the brush is on the left, its rim on the right. Double-click adds a point");
    new
}
