//! Which views were drawn, and for the 3D view what lies at each pixel.

use crate::document::{LabelAnchor, ViewName};
use crate::explode::{Explosion, PartId, Poses};
use crate::gpu::ObjectId;
use crate::interact::Hit;
use crate::interact::surface::Surface;
use crate::math::{Camera, DVec2, DVec3};
use crate::ui::thread::session::Picture;
use std::cell::OnceCell;
use std::collections::BTreeSet;

/// The views' last pictures, as far as the pointer asks them: depth in mm and body of each pixel of the 3D view.
#[derive(Default)]
pub(crate) struct Pictures {
    drawn: BTreeSet<ViewName>,
    depth: Option<Depth>,
}

struct Depth {
    size: [u32; 2],
    depth_mm: Vec<f32>,
    object: Vec<ObjectId>,
    camera: Camera,
    /// Made when somebody asks.
    surface: OnceCell<Surface>,
}

impl Pictures {
    /// Forgets all, for another volume.
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Notes a picture that is shown from now on.
    pub(crate) fn take(&mut self, picture: Picture) {
        self.drawn.insert(picture.view);
        let pixels = picture.size[0] as usize * picture.size[1] as usize;
        if picture.view == ViewName::ThreeD && picture.depth_mm.len() == pixels && picture.object.len() == pixels {
            let Picture { size, depth_mm, object, camera, .. } = picture;
            self.depth = Some(Depth { size, depth_mm, object, camera, surface: OnceCell::new() });
        }
    }

    /// Notes that a view shows no picture any more.
    pub(crate) fn lose(&mut self, view: ViewName) {
        self.drawn.remove(&view);
    }

    /// Whether a view was drawn.
    pub(crate) fn has(&self, view: ViewName) -> bool {
        self.drawn.contains(&view)
    }

    /// The surface that the 3D view shows.
    pub(crate) fn surface(&self) -> Option<&Surface> {
        let depth = self.depth.as_ref()?;
        let Depth { size, depth_mm, object, camera, surface } = depth;
        Some(surface.get_or_init(|| Surface::new(camera, *size, depth_mm, object)))
    }

    /// The camera of the 3D view's picture.
    pub(crate) fn camera(&self) -> Option<Camera> {
        self.depth.as_ref().map(|depth| depth.camera)
    }

    /// Where the 3D view's picture has a place, as shares of its width and height.
    pub(crate) fn share(&self, world: DVec3) -> Option<DVec2> {
        let depth = self.depth.as_ref()?;
        let (px, _) = depth.camera.project(world, depth.size)?;
        Some(px / DVec2::from_array(depth.size.map(f64::from)))
    }

    /// The same of what a label names, and whether it is seen there; `None` outside of the picture.
    pub(crate) fn seen(&self, anchor: &LabelAnchor) -> Option<(DVec2, bool)> {
        let depth = self.depth.as_ref()?;
        let (px, _) = depth.camera.project(anchor.place, depth.size)?;
        let i = depth.pixel(px, depth.size)?;
        let at_mm = depth.camera.ray(px, depth.size).origin.distance(anchor.place);
        let object = depth.object[i];
        let segment = object.volume().zip(object.segment());
        let seen = anchor.is_seen(f64::from(*depth.depth_mm.get(i)?), at_mm, segment, object.body());
        Some((px / DVec2::from_array(depth.size.map(f64::from)), seen))
    }

    /// What a pixel of the 3D view of the given size shows; `None` for nothing.
    pub(crate) fn object(&self, px: DVec2, size: [u32; 2]) -> Option<ObjectId> {
        let depth = self.depth.as_ref()?;
        depth.object.get(depth.pixel(px, size)?).copied().filter(|object| *object != ObjectId::NOTHING)
    }

    /// What lies under a pixel of the 3D view of the given size.
    pub(crate) fn hit(&self, px: DVec2, size: [u32; 2], (explosion, poses): (&Explosion, &Poses)) -> Option<Hit> {
        let depth = self.depth.as_ref()?;
        let i = depth.pixel(px, size)?;
        let along = f64::from(*depth.depth_mm.get(i)?);
        if !along.is_finite() {
            return None;
        }
        let world = depth.camera.ray(px, size).at(along);
        let part = part_of(explosion, poses, depth.object[i].body()?, world);
        let depth_mm = (world - depth.camera.eye).dot(depth.camera.forward());
        Some(Hit { world, part, depth_mm })
    }
}

impl Depth {
    /// Where a pixel of a view of the given size lies in what was drawn.
    fn pixel(&self, px: DVec2, size: [u32; 2]) -> Option<usize> {
        let of = |a: usize| {
            let at = px[a] * f64::from(self.size[a]) / f64::from(size[a].max(1));
            (at >= 0.0 && at < f64::from(self.size[a])).then_some(at as usize)
        };
        Some(of(0)? + of(1)? * self.size[0] as usize)
    }
}

/// The part that a body is. While all parts are at rest they are drawn as one body, which is in no part's name: the part is then
/// the one that holds the point.
fn part_of(explosion: &Explosion, poses: &Poses, body: u32, world: DVec3) -> Option<PartId> {
    let known = body == 0 && poses.at_rest(&explosion.parts) || explosion.parts.iter().any(|p| p.id.0 == body);
    explosion.of_body(body, world).filter(|_| known)
}
