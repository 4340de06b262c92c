//! The last picture of each view: its texture, and for the 3D view what lies at each pixel.

use super::session::Picture;
use crate::document::{Scene, ViewName};
use crate::explode::{Part, PartId};
use crate::interact::Hit;
use crate::math::{Camera, DVec2, DVec3, Pose};
use egui::{Color32, ColorImage, TextureHandle, TextureOptions};
use std::collections::BTreeMap;

/// See the module's head.
#[derive(Default)]
pub(super) struct Pictures {
    textures: BTreeMap<ViewName, TextureHandle>,
    depth: Option<Depth>,
}

struct Depth {
    size: [u32; 2],
    depth_mm: Vec<f32>,
    object: Vec<u32>,
    camera: Camera,
}

impl Pictures {
    /// Forgets all, for another volume.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Takes in a picture; one whose numbers do not fit its size is dropped.
    pub(super) fn take(&mut self, ctx: &egui::Context, picture: Picture) {
        let size = picture.size.map(|s| s as usize);
        let pixels = size[0] * size[1];
        if pixels == 0 || picture.rgba.len() != pixels * 4 {
            return;
        }
        let opaque = picture.rgba.chunks_exact(4).map(|p| Color32::from_rgb(p[0], p[1], p[2])).collect();
        let image = ColorImage::new(size, opaque);
        // Slices show voxels as they are when they are larger than a pixel; the caster's half resolution is smoothed.
        let options = TextureOptions::LINEAR;
        match self.textures.get_mut(&picture.view) {
            Some(texture) => texture.set(image, options),
            None => {
                let texture = ctx.load_texture(picture.view.name(), image, options);
                self.textures.insert(picture.view, texture);
            }
        }
        if picture.view == ViewName::ThreeD && picture.depth_mm.len() == pixels && picture.object.len() == pixels {
            let Picture { size, depth_mm, object, camera, .. } = picture;
            self.depth = Some(Depth { size, depth_mm, object, camera });
        }
    }

    /// The texture of a view, if it was drawn.
    pub(super) fn texture(&self, view: ViewName) -> Option<&TextureHandle> {
        self.textures.get(&view)
    }

    /// The camera that the 3D view was drawn by.
    pub(super) fn camera(&self) -> Option<Camera> {
        self.depth.as_ref().map(|d| d.camera)
    }

    /// What lies under a pixel of the 3D view of the given size.
    pub(super) fn hit(&self, px: DVec2, size: [u32; 2], scene: &Scene) -> Option<Hit> {
        let depth = self.depth.as_ref()?;
        let of = |a: usize| {
            let at = px[a] * f64::from(depth.size[a]) / f64::from(size[a].max(1));
            (at >= 0.0 && at < f64::from(depth.size[a])).then_some(at as usize)
        };
        let i = of(0)? + of(1)? * depth.size[0] as usize;
        let along = f64::from(*depth.depth_mm.get(i)?);
        if !along.is_finite() {
            return None;
        }
        let world = depth.camera.ray(px, size).at(along);
        let part = part_of(scene, depth.object[i].checked_sub(1)?, world);
        let depth_mm = (world - depth.camera.eye).dot(depth.camera.forward());
        Some(Hit { world, part, depth_mm })
    }
}

/// The part that a body is. While all parts are at rest they are drawn as one body, which is in no part's name: the part is then
/// the one that holds the point.
fn part_of(scene: &Scene, body: u32, world: DVec3) -> Option<PartId> {
    let parts = &scene.explosion.parts;
    if let Some(part) = parts.iter().find(|p| p.id.0 == body) {
        return Some(part.id);
    }
    if parts.iter().any(|p| p.pose != Pose::IDENTITY) {
        return None;
    }
    let outside = |p: &Part| p.faces.iter().map(|f| f.plane.distance(world)).fold(f64::NEG_INFINITY, f64::max);
    parts.iter().min_by(|a, b| outside(a).total_cmp(&outside(b))).map(|p| p.id)
}
