//! From the points of a stroke to its samples: those in mm, in index or on a slice as they are given, those in the 3D view by
//! looking at the surface all along the pointer's way.
//!
//! Owns where in the picture a stroke has got to. What is joined and what breaks is `paint`'s rule.

use super::{Document, DocumentError, Place, State, StrokePoint, ViewName};
use crate::gpu::{Frame, Hit};
use crate::math::{Camera, DVec2, Pose};
use crate::paint::{Sample, Seen, SurfaceRule};

/// Looks lie this share of a voxel apart at most, across the line of sight.
const LOOKS_VOXELS: f64 = 0.25;
/// Samples along a ray that looks lie this share of a voxel apart at most.
const STEP_VOXELS: f64 = 0.125;
/// Most looks from one point to the next, and from one pixel to the next.
const MOST_LOOKS: f64 = 65_536.0;
const MOST_LOOKS_PER_PIXEL: f64 = 4096.0;

/// Where a stroke in the 3D view has got to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trail {
    camera: Camera,
    px: DVec2,
    size: [u32; 2],
    pressure: f32,
    hit: Option<Hit>,
}

/// Points as samples.
#[derive(Debug, Default)]
pub(super) struct Resolved {
    pub(super) samples: Vec<Sample>,
    /// Points of the 3D view where nothing shows.
    pub(super) missed: u64,
    pub(super) trail: Option<Trail>,
    /// Whether the first point is one of a slice.
    pub(super) on_slice: bool,
}

impl State {
    /// What a look into the 3D view is marched by: the picture, with samples dense enough to tell where a surface is.
    pub(super) fn looking(&self, camera: &Camera, size: [u32; 2]) -> Frame {
        let frame = self.frame(camera, size);
        Frame { step_mm: frame.step_mm.min(STEP_VOXELS * self.grid().voxel_mm()), ..frame }
    }
}

impl Document {
    /// Resolves a stroke's points, the first after `trail`.
    ///
    /// # Errors
    /// As [`resolve`](Self::resolve).
    pub(super) fn follow(&mut self, points: &[StrokePoint], trail: Option<Trail>) -> Result<Resolved, DocumentError> {
        let on_slice = |p: &StrokePoint| matches!(p.at, Place::Pixel { view, .. } if view != ViewName::ThreeD);
        let mut resolved = Resolved { trail, on_slice: points.first().is_some_and(on_slice), ..Resolved::default() };
        for point in points {
            match point.at {
                Place::Pixel { view: ViewName::ThreeD, px, size } => {
                    self.follow_pixel(point, DVec2::from_array(px), size, &mut resolved)?;
                }
                at => {
                    let sample = self.resolve(at)?;
                    let StrokePoint { pressure, breaks, .. } = *point;
                    resolved.samples.extend(sample.map(|s| Sample { pressure, breaks, ..s }));
                    resolved.trail = None;
                }
            }
        }
        Ok(resolved)
    }

    fn follow_pixel(
        &mut self,
        point: &StrokePoint,
        px: DVec2,
        size: Option<[u32; 2]>,
        resolved: &mut Resolved,
    ) -> Result<(), DocumentError> {
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        let size = super::place::check_size(size.unwrap_or(state.scene.views.size))?;
        if !px.is_finite() {
            return Err(DocumentError::invalid("px", px, "two finite numbers"));
        }
        let camera = state.scene.views.camera;
        let frame = state.looking(&camera, size);
        let pixel_mm = pixel_mm(&frame, state);
        let rule = SurfaceRule {
            radius_mm: state.scene.brush.radius_mm,
            voxel_mm: state.grid().voxel_mm(),
            pixel_mm,
            normal: super::place::normal_of(state, ViewName::Axial),
        };
        let before = resolved.trail.filter(|_| !point.breaks);
        let from = before.and_then(|trail| trail.seen_by(&camera, size));
        // A first look is one at the point itself.
        let from = from.unwrap_or(px);
        let [looks, per_pixel] = looks_between(pixel_mm, state.grid().voxel_mm(), from.distance(px));
        let hits = self.graphics.pick_along(state, &frame, [from, px], looks)?;
        let last = before.and_then(|trail| trail.hit).map(seen);
        let (first, count) = (before.map_or(point.pressure, |trail| trail.pressure), hits.len() as f32);
        let pressure = |i: usize| first + (point.pressure - first) * ((i + 1) as f32 / count);
        let looks: Vec<_> = hits.iter().enumerate().map(|(i, hit)| (hit.map(seen), pressure(i))).collect();
        // A point that is a path given by mm or index before goes on from there.
        let joins = resolved.trail.is_none() && !point.breaks;
        let mut samples = rule.follow(last, &looks, per_pixel as usize);
        if let (true, Some(sample)) = (joins, samples.first_mut()) {
            sample.breaks = false;
        }
        resolved.samples.extend(samples);
        let hit = hits.last().copied().flatten();
        resolved.missed += u64::from(hit.is_none());
        resolved.trail = Some(Trail { camera, px, size, pressure: point.pressure, hit });
        Ok(())
    }
}

impl Trail {
    /// Where in a picture of this camera the stroke has got to: what was hit last if another camera saw it. `None` if that is
    /// nowhere.
    fn seen_by(&self, camera: &Camera, size: [u32; 2]) -> Option<DVec2> {
        if self.camera == *camera && self.size == size {
            return Some(self.px);
        }
        camera.project(self.hit?.world, size).map(|(px, _)| px)
    }
}

fn seen(hit: Hit) -> Seen {
    Seen { position: hit.rest, part: hit.body }
}

/// Size of a pixel of the picture where what is drawn ends, mm: what is nearer is smaller.
pub(super) fn pixel_mm(frame: &Frame, state: &State) -> f64 {
    let corners = state.grid().world_corners();
    let forward = frame.camera.forward();
    let far = |pose: &Pose| corners.map(|c| (pose.apply(c) - frame.camera.eye).dot(forward));
    let furthest = frame.bodies.iter().flat_map(|b| far(&b.pose)).fold(0.0, f64::max);
    frame.camera.mm_per_pixel(furthest, frame.size[1])
}

/// How many looks a way of so many pixels takes, and how many of them make a pixel. It does not depend on where along the way the
/// pointer was sampled.
fn looks_between(pixel_mm: f64, voxel_mm: f64, pixels: f64) -> [u32; 2] {
    let most = (MOST_LOOKS / pixels.max(1.0)).floor().clamp(1.0, MOST_LOOKS_PER_PIXEL);
    let per_pixel = (pixel_mm / (LOOKS_VOXELS * voxel_mm)).ceil().clamp(1.0, most);
    // A length that is whole but for its rounding takes no look more.
    let looks = (pixels * per_pixel - 1e-6).ceil().clamp(1.0, MOST_LOOKS);
    [looks as u32, per_pixel as u32]
}
