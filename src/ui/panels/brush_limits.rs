//! The menu of where a brush may paint, beside what is seldom said of it: how deep, what is connected, which side of selection or segment,
//! and the plane that strokes are mirrored across.
//!
//! Each row changes the brush; the button is lit while one of them holds, so that nobody wonders why a stroke leaves something alone.

use crate::document::Scene;
use crate::interact::readout;
use crate::interact::readout::LengthUnit;
use crate::math::DVec3;
use crate::paint::{Brush, Mirror, MirrorAxis, OfSegment, Shape, Side};
use crate::ui::style::icons::Icon;
use crate::ui::style::theme;
use crate::ui::style::theme::{GAP, LABEL};
use crate::ui::style::widgets::{
    Face, Scale, button, choice, controls_under, icon_button, line, row, slider, tick, tipped,
};
use egui::{ComboBox, Ui, vec2};

const CONTROLS: f32 = 240.0;

#[derive(Clone, Copy, PartialEq)]
enum Across {
    Off,
    X,
    Y,
    Z,
    Other,
}

/// The button and its menu; `voxel` is the smallest spacing, mm.
pub(super) fn limits_menu(ui: &mut Ui, scene: &Scene, points: &mut Vec<DVec3>, voxel: f64, new: &mut Brush) {
    let lit = new.within_mm.is_some() || new.connected || !new.only.is_anything() || !new.mirror.is_off();
    let tint = if lit { theme::ACCENT } else { theme::TEXT_WEAK };
    let tip = "Where else the brush may paint, and across what it is mirrored";
    let response = icon_button(ui, Face::small(Icon::Down, "More limits of the brush", tip).tint(tint));
    controls_under(&response, |ui| {
        ui.set_width(LABEL + GAP + CONTROLS);
        depth_rows(ui, voxel, new);
        let tip = "Only what hangs together with the place where the stroke begins, through all that shows";
        tick(ui, &mut new.connected, "Only what is connected to where it begins", tip);
        row(ui, "Selection", |ui| side(ui, "Selection", &mut new.only.selection));
        segment_rows(ui, scene, new);
        mirror_rows(ui, scene, points, new);
        row(ui, "Pen", |ui| {
            let tip = "A lighter touch of the pen paints more weakly, where the system tells how hard it is pressed";
            tick(ui, &mut new.pressure.strength, "Strength", tip);
            let tip = "A lighter touch of the pen paints with a smaller brush, down to a quarter of the radius";
            tick(ui, &mut new.pressure.radius, "Radius", tip);
        });
        row(ui, "Lasso", |ui| {
            let LengthUnit { name: unit, per_mm: factor, .. } = LengthUnit::of(voxel);
            let decimals = readout::decimals(voxel * factor * 20.0);
            let scale = Scale { logarithmic: false, decimals, unit, factor };
            let about =
                ("Depth of the lasso", "How deep a contour fills to either side of its slice; 0: the slice alone");
            let most = (voxel * 100.0).max(new.depth_mm);
            slider(ui, about, &mut new.depth_mm, 0.0..=most, scale);
        });
        if new.shape == Shape::Ellipsoid {
            row(ui, "Flatness", |ui| {
                let about =
                    ("Flatness of the ball", "How far the flat ball reaches into the depth, as a share of its radius");
                let most = new.ratio.max(1.0);
                slider(ui, about, &mut new.ratio, 0.05..=most, Scale::PERCENT);
            });
        }
    });
}

fn depth_rows(ui: &mut Ui, voxel: f64, new: &mut Brush) {
    let mut on = new.within_mm.is_some();
    let tip = "Strokes in the 3D view change what lies this near to the surface that is seen, and nothing deeper";
    if tick(ui, &mut on, "Only down to a depth", tip) {
        new.within_mm = on.then_some(voxel * 2.0);
    }
    if let Some(depth) = &mut new.within_mm {
        row(ui, "Depth", |ui| {
            let LengthUnit { name: unit, per_mm: factor, .. } = LengthUnit::of(voxel);
            let decimals = readout::decimals(voxel * factor * 20.0);
            let scale = Scale { logarithmic: false, decimals, unit, factor };
            let tip = "How far from the surface that is seen";
            slider(ui, ("Depth under the surface", tip), depth, 0.0..=(voxel * 40.0).max(*depth), scale);
        });
    }
}

fn side(ui: &mut Ui, name: &str, side: &mut Option<Side>) {
    let options = [
        (None, "Anywhere", "It does not matter"),
        (Some(Side::Inside), "Inside", "Only inside is painted"),
        (Some(Side::Outside), "Outside", "Only outside is painted"),
    ];
    *side = choice(ui, name, Some(*side), &options).unwrap_or(*side);
}

fn segment_rows(ui: &mut Ui, scene: &Scene, new: &mut Brush) {
    let mut which = new.only.segment.map(|of| of.side);
    row(ui, "Segment", |ui| side(ui, "Segment", &mut which));
    let first = scene.segments().0.first().map_or(1, |s| s.id);
    let id = new.only.segment.map_or(first, |of| of.id);
    new.only.segment = which.map(|side| OfSegment { id, side });
    if let Some(of) = &mut new.only.segment {
        row(ui, "of", |ui| {
            let named = |id: u16| scene.segments().get(id).map_or_else(|| id.to_string(), |s| s.name.clone());
            let width = ui.available_width();
            let shown = ComboBox::from_id_salt("only segment")
                .width(width)
                .truncate()
                .selected_text(named(of.id))
                .show_ui(ui, |ui| {
                    for option in scene.segments().0.iter().map(|s| s.id) {
                        ui.selectable_value(&mut of.id, option, named(option)).on_hover_text("This segment");
                    }
                });
            tipped(shown.response.accessible_name("Segment to keep to"), "Which segment is meant");
        });
    }
}

fn mirror_rows(ui: &mut Ui, scene: &Scene, points: &mut Vec<DVec3>, new: &mut Brush) {
    let now = match new.mirror {
        Mirror::Off => Across::Off,
        Mirror::Axis(MirrorAxis::X) => Across::X,
        Mirror::Axis(MirrorAxis::Y) => Across::Y,
        Mirror::Axis(MirrorAxis::Z) => Across::Z,
        _ => Across::Other,
    };
    row(ui, "Mirror", |ui| {
        let options = [
            (Across::Off, "Off", "Strokes are painted once"),
            (Across::X, "x", "Also on the other side of the volume's middle along its first axis"),
            (Across::Y, "y", "Also on the other side of the volume's middle along its second axis"),
            (Across::Z, "z", "Also on the other side of the volume's middle along its third axis"),
        ];
        match choice(ui, "Mirror", Some(now), &options) {
            Some(Across::Off) => new.mirror = Mirror::Off,
            Some(Across::X) => new.mirror = Mirror::Axis(MirrorAxis::X),
            Some(Across::Y) => new.mirror = Mirror::Axis(MirrorAxis::Y),
            Some(Across::Z) => new.mirror = Mirror::Axis(MirrorAxis::Z),
            Some(Across::Other) | None => {}
        }
    });
    row(ui, "", |ui| {
        let cuts: Vec<_> =
            scene.explosion.parts.iter().flat_map(|p| p.faces.iter().filter(|f| f.cut).map(move |f| (p, f))).collect();
        ui.add_enabled_ui(!cuts.is_empty(), |ui| {
            let width = ui.available_width();
            let shown = ComboBox::from_id_salt("mirror face").width(width).truncate().selected_text("A part's face…");
            let shown = shown.show_ui(ui, |ui| {
                for (part, face) in cuts {
                    let [x, y, z] = face.plane.normal.to_array();
                    let text = format!("{}: facing {x:.2}, {y:.2}, {z:.2}", part.name);
                    let chosen = new.mirror == Mirror::Plane(face.plane);
                    if ui.selectable_label(chosen, text).on_hover_text("Mirror across this face").clicked() {
                        new.mirror = Mirror::Plane(face.plane);
                    }
                }
            });
            tipped(
                shown.response.accessible_name("Face to mirror across"),
                "Mirror across a face where a part was cut",
            );
        });
    });
    row(ui, "", |ui| {
        let count = points.len();
        let text = format!("Take the crosshair as point {} of 3", count + 1);
        let tip = "Mirror across the plane through three places: put the crosshair at each and press this";
        if button(ui, vec2(ui.available_width(), theme::ROW), &text, tip) {
            points.push(scene.views.crosshair);
        }
    });
    if let [a, b, c] = points[..] {
        points.clear();
        let mirror = Mirror::Points([a, b, c]);
        let candidate = Brush { mirror, ..*new };
        if candidate.check().is_ok() {
            new.mirror = mirror;
        }
    }
    if now == Across::Other {
        line(ui, "Mirrored across a plane of your own", LABEL + GAP + CONTROLS, theme::TEXT_WEAK);
    }
}
