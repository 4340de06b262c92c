//! How much each brick matters to a picture: pixels of its voxels on the screen, less what hides it.
//!
//! Pure: knows no device. An estimate that orders bricks when not all fit; what is drawn does not depend on it otherwise.

use crate::gpu::picture::frame::Body;
use crate::math::{Aabb, Camera, DVec3, Plane, Projection};
use crate::volume::{BRICK, BrickIndex, BrickKey, Cells, Field, Grid, TransferFunction};
use rayon::prelude::*;

/// What remains of a brick's weight where it lies outside the picture: it is next when the camera turns.
const OUTSIDE: f32 = 0.02;
/// What remains where it is wholly hidden: estimates err.
const HIDDEN: f32 = 0.05;

/// Sides of pictures whose ratios differ by no more than this share have the same shape.
const SAME_SHAPE: f64 = 0.02;

/// Camera and picture of a frame, and those of its bodies that are of one volume.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Viewing {
    pub(crate) camera: Camera,
    pub(crate) size: [u32; 2],
    pub(crate) bodies: Vec<Body>,
}

impl Viewing {
    /// Whether bricks matter alike to both: a picture in fewer pixels, but for the rounding of its sides, is the same picture.
    pub(crate) fn sees_like(&self, other: &Self) -> bool {
        let ([w, h], [v, g]) = (self.size.map(f64::from), other.size.map(f64::from));
        self.camera == other.camera && self.bodies == other.bodies && (w * g - v * h).abs() <= SAME_SHAPE * w * g
    }
}

/// Extinction of every brick of level 0 along its edge.
pub(crate) fn extinctions(density: &Field, grid: &Grid, transfer: &TransferFunction) -> Vec<f32> {
    let bricks = density.brick_indices(0);
    bricks.into_par_iter().map(|index| extinction(density, grid, transfer, index)).collect()
}

/// Extinction of a brick of level 0 along its edge, estimated from its cells' middle values.
pub(crate) fn extinction(density: &Field, grid: &Grid, transfer: &TransferFunction, index: BrickIndex) -> f32 {
    let edge = f64::from(BRICK) * grid.voxel_mm() / transfer.unit_mm;
    let tau = |[lo, hi]: [f32; 2]| {
        if lo > hi {
            return 0.0;
        }
        let opacity = transfer.opacity_at(f64::from(lo + hi) * 0.5).min(0.999);
        -f64::from(1.0 - opacity).ln() * edge
    };
    match density.cells(BrickKey { level: 0, index }) {
        Cells::Uniform(range) => tau(range) as f32,
        Cells::Dense(cells) => (cells.iter().map(|&c| tau(c)).sum::<f64>() / cells.len() as f64) as f32,
    }
}

/// For each of some bricks of level 0: pixels along a voxel's edge where a body shows it nearest, weighted by what reaches the
/// eye.
pub(crate) fn urgency(
    viewing: &Viewing,
    grid: &Grid,
    bricks: [u32; 3],
    extinction: &[f32],
    wanted: &[BrickKey],
) -> Vec<f32> {
    let voxel = grid.voxel_mm();
    let index_from_world = grid.index_from_world();
    wanted
        .par_iter()
        .map(|key| {
            let at = key.index.0;
            let corners = corners(grid, key.index);
            let mut best = 0.0_f32;
            for body in &viewing.bodies {
                if outside(&body.region, &corners) {
                    continue;
                }
                let posed = corners.map(|c| body.pose.apply(c));
                let (inside, distance) = seen(&viewing.camera, viewing.size, &posed);
                let distance = distance.max(1e-3 * voxel);
                let pixels = (voxel / viewing.camera.mm_per_pixel(distance, viewing.size[1])) as f32;
                let eye = body.pose.unapply(toward(&viewing.camera, &posed));
                let clear = transmittance(
                    index_from_world.transform_point3(eye),
                    DVec3::new(f64::from(at[0]), f64::from(at[1]), f64::from(at[2])),
                    bricks,
                    extinction,
                );
                let weight = (HIDDEN + (1.0 - HIDDEN) * clear) * if inside { 1.0 } else { OUTSIDE };
                best = best.max(pixels * weight);
            }
            best
        })
        .collect()
}

/// Whether one of a region's planes has all corners beyond it.
pub(crate) fn outside(region: &[Plane], corners: &[DVec3; 8]) -> bool {
    region.iter().any(|plane| corners.iter().all(|&c| plane.distance(c) > 0.0))
}

/// World corners of a brick, a voxel of apron included.
pub(crate) fn corners(grid: &Grid, brick: BrickIndex) -> [DVec3; 8] {
    let lo = DVec3::from_array(brick.origin().map(f64::from)) - 1.0;
    Aabb { min: lo, max: lo + f64::from(BRICK) + 1.0 }.corners().map(|c| grid.world_from_index.transform_point3(c))
}

/// Whether any of a posed brick may be in the picture, and how near it comes along the direction of sight, in mm.
fn seen(camera: &Camera, size: [u32; 2], corners: &[DVec3; 8]) -> (bool, f64) {
    let view = camera.view_from_world();
    let points = corners.map(|c| view.transform_point3(c));
    let nearest = points.iter().map(|p| -p.z).fold(f64::INFINITY, f64::min);
    let perspective = matches!(camera.projection, Projection::Perspective { .. });
    let half_y = camera.half_height();
    let half_x = half_y * f64::from(size[0]) / f64::from(size[1].max(1));
    let limit = |half: f64, z: f64| if perspective { half * -z } else { half };
    // Outside if all corners are beyond one side, or behind the eye.
    let outside = points.iter().all(|p| p.z > 0.0)
        || points.iter().all(|p| p.x > limit(half_x, p.z))
        || points.iter().all(|p| -p.x > limit(half_x, p.z))
        || points.iter().all(|p| p.y > limit(half_y, p.z))
        || points.iter().all(|p| -p.y > limit(half_y, p.z));
    (!outside, nearest)
}

/// A point towards which the brick is seen: the eye, or its place before the brick in orthographic projection.
fn toward(camera: &Camera, corners: &[DVec3; 8]) -> DVec3 {
    match camera.projection {
        Projection::Perspective { .. } => camera.eye,
        Projection::Orthographic { .. } => {
            let centre = (corners[0] + corners[7]) * 0.5;
            centre - camera.forward() * (centre - camera.eye).dot(camera.forward())
        }
    }
}

/// What light of a brick's centre passes the bricks between it and the eye (index space), in steps of half a brick.
fn transmittance(eye: DVec3, brick: DVec3, bricks: [u32; 3], extinction: &[f32]) -> f32 {
    let centre = brick + 0.5;
    let to_eye = (eye + 0.5) / f64::from(BRICK) - centre;
    let steps = (to_eye.length() * 2.0).floor().min(512.0) as u32;
    let step = to_eye.normalize_or_zero() * 0.5;
    let most = DVec3::from_array(bricks.map(f64::from));
    let mut tau = 0.0;
    for k in 1..steps {
        let p = centre + step * f64::from(k);
        if p.cmplt(DVec3::ZERO).any() || p.cmpge(most).any() || tau > 8.0 {
            break;
        }
        if p.floor() == brick {
            continue;
        }
        let i = p.x as usize + bricks[0] as usize * (p.y as usize + bricks[1] as usize * p.z as usize);
        tau += extinction[i] * 0.5;
    }
    (-tau).exp()
}
