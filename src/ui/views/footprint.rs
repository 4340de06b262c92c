//! The brush's footprint in every view before the click: where the dab under the pointer meets each slice, and its silhouette in 3D.

use crate::document::{Aim, SlicePlane, ViewName};
use crate::interact::{Form, Tool};
use crate::math::{DVec2, DVec3};
use crate::ui::style::theme;
use crate::ui::thread::session::Request;
use crate::ui::views::overlay::paint_colour;
use crate::ui::window::app::App;
use egui::{Color32, Painter, Pos2, Stroke};

/// Neighbouring pixels of the 3D view by which the surface's normal is told.
const BESIDE_PX: f64 = 3.0;

impl App {
    /// Draws it over a view; `plane` is the view's slice, if it is one.
    pub(crate) fn draw_footprint(
        &self,
        painter: &Painter,
        view: ViewName,
        plane: Option<&SlicePlane>,
        size: [u32; 2],
        to_screen: &dyn Fn(DVec2) -> Pos2,
    ) {
        let Some(scene) = self.scene.as_ref().filter(|_| self.interaction.tool() == Tool::Brush) else { return };
        let (Some(form), Some(open)) = (self.aimed_form(), self.opened()) else { return };
        let here = self.viewports.hovered.is_some_and(|(v, _)| v == view);
        let image = scene.brush.mirror.plane(&open.grid).map(|plane| form.image(&plane));
        let erase = scene.brush.erase || painter.ctx().input(|i| i.key_down(egui::Key::E));
        let colour = if erase { theme::ERROR } else { paint_colour(scene.brush.target, scene) };
        // About the pointer a ring says it already, unless the form is flat.
        let forms = std::iter::once(form).filter(|form| !here || plane.is_none() && form.ratio != 1.0).chain(image);
        for form in forms {
            let points: Vec<Pos2> = self.outline(&form, plane, size).into_iter().map(to_screen).collect();
            if !points.is_empty() {
                let dark = Stroke::new(2.6, Color32::from_black_alpha(110));
                painter.add(egui::Shape::closed_line(points.clone(), dark));
                painter.add(egui::Shape::closed_line(points, Stroke::new(1.1, colour.gamma_multiply(0.85))));
            }
        }
    }

    /// A form in pixels of a view.
    fn outline(&self, form: &Form, plane: Option<&SlicePlane>, size: [u32; 2]) -> Vec<DVec2> {
        let Some(scene) = &self.scene else { return Vec::new() };
        match plane {
            Some(plane) => {
                let corners = form.meets(plane.centre, plane.right, plane.up);
                corners.iter().map(|c| plane.pixel(plane.centre + plane.right * c.x + plane.up * c.y)).collect()
            }
            None => {
                let camera = &scene.views.camera;
                let Some((middle, depth)) = camera.project(form.centre, size) else { return Vec::new() };
                let (right, up) = camera.right_up();
                let per_px = camera.mm_per_pixel(depth, size[1]);
                let corners = form.silhouette(camera.forward(), right, up);
                corners.iter().map(|c| middle + DVec2::new(c.x, -c.y) / per_px).collect()
            }
        }
    }

    /// Tells where the brush is, if pictures follow it. A hand that holds something else moves no brush, and a stroke says itself where
    /// it is.
    pub(crate) fn tell_aim(&mut self) {
        let follows = self.scene.as_ref().is_some_and(|s| s.focus.on && s.focus.at.is_none());
        if !follows || self.interaction.tool() != Tool::Brush || self.viewports.captured.is_some() {
            return;
        }
        let Some(aim) = self.aimed() else { return };
        if self.viewports.aimed.replace(aim) != Some(aim) {
            self.request(Request::Aim(Some(aim)));
        }
    }

    /// Where a click would paint now.
    fn aimed(&self) -> Option<Aim> {
        let rest = self.aimed_form()?.centre;
        let (view, px) = self.viewports.hovered?;
        let part = match view {
            ViewName::ThreeD => self.hit(px, *self.viewports.sizes.get(&view)?)?.part,
            _ => self.scene.as_ref()?.explosion.of_body(0, rest),
        };
        Some(Aim { rest, part })
    }

    /// The form of the dab that a click would paint now.
    fn aimed_form(&self) -> Option<Form> {
        let (scene, open) = (self.scene.as_ref()?, self.opened()?);
        let (view, px) = self.viewports.hovered?;
        let mut views = scene.views.clone();
        let size = *self.viewports.sizes.get(&view)?;
        if let Some(i) = view.slice() {
            views.slices[i].size = size;
        }
        let slice = SlicePlane::new(&open.grid, &views, if view == ViewName::ThreeD { ViewName::Axial } else { view })?;
        let half = open.grid.spacing()[slice.axis] * 0.5;
        let (centre, normal) = match view {
            ViewName::ThreeD => {
                let hit = self.hit(px, size)?;
                // At rest a part's matter lies elsewhere: slices show it there.
                let part = scene.explosion.parts.iter().find(|p| Some(p.id) == hit.part);
                let pose = part.map(|part| open.poses.of(part));
                let beside = |step: DVec2| self.hit(px + step, size).filter(|h| h.part == hit.part).map(|h| h.world);
                let normal = beside(DVec2::X * BESIDE_PX).zip(beside(DVec2::Y * BESIDE_PX)).and_then(|(x, y)| {
                    let turned: DVec3 = (x - hit.world).cross(y - hit.world);
                    turned.try_normalize()
                });
                let at_rest = |at: DVec3| pose.map_or(at, |pose| pose.unapply(at));
                let normal = normal.map(|n| (at_rest(hit.world + n) - at_rest(hit.world)).normalize_or(n));
                (at_rest(hit.world), normal)
            }
            _ => (slice.world(px), None),
        };
        Some(Form::of(&scene.brush, centre, normal, (slice.towards_viewer, half)))
    }
}
