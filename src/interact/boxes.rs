//! Sub-volumes over the pictures, as plain data: their edges, and the handles that move their faces.
//!
//! Works from the corners of boxes where they lie, in the order of [`Aabb::corners`](crate::math::Aabb::corners); knows no voxels.

use crate::document::{Scene, SubVolume};
use crate::math::{DVec2, DVec3};
use crate::volume::VolumeId;
use std::collections::BTreeMap;

/// Corners of the sub-volumes that are shown, world mm.
pub type BoxCorners = BTreeMap<VolumeId, [DVec3; 8]>;

/// How near the hand must come to a handle, pixels.
const NEAR_PX: f64 = 9.0;

/// A face of a box that can be taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Handle {
    /// The sub-volume.
    pub volume: VolumeId,
    /// The axis that the face lies across.
    pub axis: usize,
    /// Whether it is the face at the box's last corner.
    pub last: bool,
    /// Its middle in the picture.
    pub at: DVec2,
    /// A voxel of the parent along the axis, in the picture.
    pub voxel_px: DVec2,
}

/// Where a picture shows places of the world; nothing behind the eye.
pub type Shows<'a> = &'a dyn Fn(DVec3) -> Option<DVec2>;

/// The handles of all boxes in a picture. Faces that are seen edge on along the sight cannot be moved there and have none.
pub fn handles(scene: &Scene, boxes: &BoxCorners, shows: Shows<'_>) -> Vec<Handle> {
    let mut all = Vec::new();
    for (&volume, corners) in boxes {
        let Some(SubVolume { of, .. }) = scene.volumes.all.get(&volume).and_then(|v| v.sub_volume) else { continue };
        let centre = corners.iter().sum::<DVec3>() / 8.0;
        for axis in 0..3 {
            let edge = corners[1 << axis] - corners[0];
            let voxel = edge / f64::from(of.hi[axis] - of.lo[axis]);
            for last in [false, true] {
                let middle = centre + edge * if last { 0.5 } else { -0.5 };
                let (Some(at), Some(next)) = (shows(middle), shows(middle + voxel)) else { continue };
                if (next - at).length() > 0.3 {
                    all.push(Handle { volume, axis, last, at, voxel_px: next - at });
                }
            }
        }
    }
    all
}

/// The handle under the hand.
pub fn taken(handles: &[Handle], px: DVec2) -> Option<Handle> {
    let near = handles.iter().filter(|h| h.at.distance(px) <= NEAR_PX);
    near.min_by(|a, b| a.at.distance(px).total_cmp(&b.at.distance(px))).copied()
}

/// The edges of a box in a picture.
pub fn edges(corners: &[DVec3; 8], shows: Shows<'_>) -> Vec<[DVec2; 2]> {
    let ends = (0..8_usize).flat_map(|i| (0..3).map(move |a| (i, i | 1 << a))).filter(|(a, b)| a != b);
    ends.filter_map(|(a, b)| Some([shows(corners[a])?, shows(corners[b])?])).collect()
}

/// Whether a slice goes through a box: a plane by a point and its normal.
pub fn crosses(corners: &[DVec3; 8], point: DVec3, normal: DVec3) -> bool {
    let sides = corners.map(|c| (c - point).dot(normal));
    let (least, most) =
        (sides.iter().copied().fold(f64::INFINITY, f64::min), sides.iter().copied().fold(f64::MIN, f64::max));
    least <= 1e-6 && most >= -1e-6
}
