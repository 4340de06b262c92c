//! Sub-volumes over the pictures: where their boxes are, and with the tool for them the handles of their faces.

use crate::document::SlicePlane;
use crate::interact::Tool;
use crate::interact::boxes::{BoxCorners, Shows, crosses, edges, handles};
use crate::math::{DVec2, DVec3};
use crate::ui::style::theme;
use crate::ui::window::app::App;
use egui::{Color32, Painter, Pos2, Rect, Stroke, vec2};

impl App {
    /// Over a slice, or over the 3D view's picture of `size` pixels.
    pub(crate) fn boxes(
        &self,
        painter: &Painter,
        slice: Option<&SlicePlane>,
        size: [u32; 2],
        to_screen: &dyn Fn(DVec2) -> Pos2,
    ) {
        let (Some(scene), Some(open)) = (&self.scene, self.opened()) else { return };
        let camera = scene.views.camera;
        let in_3d = |world: DVec3| camera.project(world, size).map(|(px, _)| px);
        let on_slice = |world: DVec3| slice.map(|slice| slice.pixel(world));
        let shows: Shows<'_> = if slice.is_some() { &on_slice } else { &in_3d };
        let met: BoxCorners = match slice {
            Some(slice) => {
                let normal = slice.right.cross(slice.up);
                let met = open.boxes.iter().filter(|(_, corners)| crosses(corners, slice.centre, normal));
                met.map(|(id, corners)| (*id, *corners)).collect()
            }
            None => (*open.boxes).clone(),
        };
        let held = self.interaction.tool() == Tool::SubVolume;
        for (id, corners) in &met {
            let meant = held || *id == scene.volumes.active;
            let colour = if meant { theme::ACCENT } else { Color32::from_white_alpha(110) };
            for ends in edges(corners, shows) {
                let ends = ends.map(to_screen);
                painter.line_segment(ends, Stroke::new(2.4, Color32::from_black_alpha(if meant { 110 } else { 60 })));
                painter.line_segment(ends, Stroke::new(1.0, colour));
            }
        }
        if held {
            for handle in handles(scene, &met, shows) {
                let square = Rect::from_center_size(to_screen(handle.at), vec2(7.0, 7.0));
                painter.rect_filled(square.expand(1.0), 1.0, Color32::from_black_alpha(170));
                painter.rect_filled(square, 1.0, theme::ACCENT);
            }
        }
    }
}
