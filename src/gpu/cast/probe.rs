//! What lies under points of the picture: one, or many along a line.
//!
//! Rays along a line of the picture are one row of pixels of a picture that is turned and scaled so that the line runs along it,
//! and cost what so many pixels cost.

use crate::gpu::cast::caster::Caster;
use crate::gpu::cast::tiles::Window;
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::volumes::Fields;
use crate::gpu::picture::frame::Frame;
use crate::gpu::picture::image::Image;
use crate::gpu::picture::object_id::ObjectId;
use crate::math::{Camera, DVec2, DVec3, Projection};

/// Rays of one row.
const ROW: u32 = 4096;
/// Width and height of the turned picture, pixels: its pixel is half of that of the plane at distance 1.
const TURNED: [u32; 2] = [2; 2];

/// A point under a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// World mm.
    pub world: DVec3,
    /// World mm with the body at rest; of a mesh, in its own space.
    pub rest: DVec3,
    /// Id of the body or opaque mesh.
    pub body: u32,
    /// All that is known of it.
    pub object: ObjectId,
    /// Millimetres along the ray.
    pub depth_mm: f64,
}

impl Caster {
    /// The first visible surface on the ray through a point of the picture, in pixels: where opacity reaches ½, the iso-surface,
    /// or the maximum.
    ///
    /// # Errors
    /// As [`image`](Self::image).
    pub fn pick(
        &mut self,
        gpu: &Gpu,
        pools: &mut FieldPools,
        fields: &Fields<'_>,
        frame: &Frame,
        px: DVec2,
    ) -> Result<Option<Hit>, GpuError> {
        let window = Window { picture: frame.size, origin: px - 0.5, size: [1; 2], only: None };
        let image = self.part(gpu, pools, fields, frame, &window)?;
        Ok(hit(frame, &image, 0, px, frame.size))
    }

    /// The same under `count` points from one place of the picture to another, evenly apart: the last at `to`, the first a step
    /// after `from`.
    ///
    /// # Errors
    /// As [`image`](Self::image).
    pub fn pick_along(
        &mut self,
        gpu: &Gpu,
        pools: &mut FieldPools,
        fields: &Fields<'_>,
        frame: &Frame,
        [from, to]: [DVec2; 2],
        count: u32,
    ) -> Result<Vec<Option<Hit>>, GpuError> {
        let step = (to - from) / f64::from(count.max(1));
        let Some((camera, first)) = turned(&frame.camera, frame.size, from, step) else {
            let hit = self.pick(gpu, pools, fields, frame, to)?;
            return Ok(vec![hit; count as usize]);
        };
        // By the picture that is seen: what is needed does not change with every line.
        pools.make_resident(gpu, fields, frame)?;
        let frame = Frame { camera, size: TURNED, ..frame.clone() };
        let mut hits = Vec::with_capacity(count as usize);
        for begin in (0..count).step_by(ROW as usize) {
            let size = [ROW.min(count - begin), 1];
            let origin = first + DVec2::new(f64::from(begin) + 1.0, 0.0) - 0.5;
            let window = Window { picture: TURNED, origin, size, only: None };
            let image = self.part_as_held(gpu, pools, fields, &frame, &window)?;
            hits.extend((0..size[0]).map(|i| {
                let px = origin + DVec2::new(f64::from(i) + 0.5, 0.5);
                hit(&frame, &image, i as usize, px, TURNED)
            }));
        }
        Ok(hits)
    }
}

fn hit(frame: &Frame, image: &Image, i: usize, px: DVec2, size: [u32; 2]) -> Option<Hit> {
    let depth_mm = f64::from(image.depth_mm[i]);
    let object = image.object[i];
    let id = object.body().filter(|_| depth_mm.is_finite())?;
    let world = frame.camera.ray(px, size).at(depth_mm);
    let body = frame.bodies.iter().find(|b| b.id == id).map(|b| &b.pose);
    let mesh = || frame.layers.opaque.iter().find(|m| m.id == id).map(|m| &m.pose);
    let rest = body.or_else(mesh).map_or(world, |pose| pose.unapply(world));
    Some(Hit { world, rest, body: id, object, depth_mm })
}

/// The same camera turned about its direction of sight and narrowed, so that a step in a picture of `size` is a pixel to the right
/// in one of [`TURNED`]; and where the place `from` lies in that. `None` if the step is none.
fn turned(camera: &Camera, size: [u32; 2], from: DVec2, step: DVec2) -> Option<(Camera, DVec2)> {
    let [w, h] = size.map(f64::from);
    let half = camera.half_height();
    // In the plane at distance 1, or in mm in orthographic projection; y up.
    let along = DVec2::new(step.x, -step.y) * (2.0 * half / h);
    let at = DVec2::new(2.0 * from.x - w, h - 2.0 * from.y) * (half / h);
    let pixel = along.length();
    let x = along.try_normalize()?;
    let (right, up) = camera.right_up();
    let projection = match camera.projection {
        Projection::Perspective { .. } => Projection::Perspective { fov_y_deg: 2.0 * pixel.atan().to_degrees() },
        Projection::Orthographic { .. } => Projection::Orthographic { height_mm: 2.0 * pixel },
    };
    let camera = Camera { up: up * x.x - right * x.y, projection, ..*camera };
    Some((camera, DVec2::new(1.0 + at.dot(x) / pixel, 1.0 - x.perp_dot(at) / pixel)))
}
