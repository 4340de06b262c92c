//! What a splitter is about to cut and where parts end, so that the hand does not work blind: at rest parts make a picture
//! without seams, and a cut shows nothing before it is made.
//!
//! Planes, not lines: whoever draws knows which surface is seen, and shows them there. Knows no pixels of pictures.

use crate::document::{Scene, SlicePlane};
use crate::explode::{Axis, Part, Poses, axis_plane, depth_plane, line_plane};
use crate::interact::event::Hit;
use crate::interact::gesture::Gesture;
use crate::interact::slices::{Cut, CutSlice, cuts_on};
use crate::interact::tool::Tool;
use crate::math::{DVec2, DVec3, Plane, Ray};

/// What a tool points at.
#[derive(Clone, Copy, Debug)]
pub enum Aim {
    /// A pixel of the 3D view of `size` pixels, and what is seen there.
    Solid {
        /// Pixel.
        px: DVec2,
        /// The view's size.
        size: [u32; 2],
        /// What lies there.
        hit: Option<Hit>,
    },
    /// A pixel of a slice.
    Slice {
        /// Pixel.
        px: DVec2,
        /// The slice.
        slice: CutSlice,
    },
}

/// What a tool would cut if the button went up now; what it would only graze is left out.
pub fn cuts(
    (tool, gesture): (Tool, Option<&Gesture>),
    (scene, poses): (&Scene, &Poses),
    aim: Aim,
    axis: Axis,
) -> Vec<Cut> {
    let cuts = match aim {
        Aim::Solid { px, size, hit } => solid_cuts((tool, gesture), (scene, poses), (px, size), hit, axis),
        Aim::Slice { px, slice } => match (tool, gesture) {
            (Tool::LineSplit, Some(Gesture::Line { from, to, .. })) => cuts_on(&slice, scene, tool, (*from, *to), axis),
            (Tool::AxisSplit | Tool::DepthSplit, _) => cuts_on(&slice, scene, tool, (px, px), axis),
            _ => Vec::new(),
        },
    };
    let divides = |cut: &Cut| {
        let mut copy = (*scene.explosion).clone();
        copy.split_at_rest(cut.part, &cut.plane).is_ok_and(|halves| halves.is_some())
    };
    cuts.into_iter().filter(divides).collect()
}

fn solid_cuts(
    (tool, gesture): (Tool, Option<&Gesture>),
    (scene, poses): (&Scene, &Poses),
    (px, size): (DVec2, [u32; 2]),
    hit: Option<Hit>,
    axis: Axis,
) -> Vec<Cut> {
    let (camera, explosion) = (&scene.views.camera, &scene.explosion);
    let (ids, plane) = match (tool, gesture, hit) {
        (Tool::LineSplit, Some(Gesture::Line { from, to, .. }), _) => {
            let ids = explosion.meeting(poses, camera, *from, *to, size).unwrap_or_default();
            (ids, line_plane(camera, *from, *to, size))
        }
        (Tool::AxisSplit, _, Some(hit)) => {
            (hit.part.into_iter().collect(), axis_plane(camera, px, size, axis, hit.world))
        }
        (Tool::DepthSplit, _, Some(hit)) => (hit.part.into_iter().collect(), depth_plane(camera, hit.world)),
        _ => return Vec::new(),
    };
    let Ok(plane) = plane else { return Vec::new() };
    let parts = ids.into_iter().filter_map(|id| explosion.part(id).ok());
    parts.map(|p| Cut { part: p.id, plane: poses.of(p).unapply_plane(&plane) }).collect()
}

/// The planes at rest, with their part inside, that splitters made of it.
pub fn seams(part: &Part) -> impl Iterator<Item = Plane> {
    part.faces.iter().filter(|f| f.cut).map(|f| f.plane)
}

/// Where a plane at rest crosses a part on a slice, which shows the volume at rest: both ends in world mm. The plane may be a face
/// of the part. `None` if it does not, or lies in the slice.
pub fn crossing(part: &Part, plane: &Plane, slice: &SlicePlane) -> Option<[DVec3; 2]> {
    let seen = slice.right.cross(slice.up).try_normalize()?;
    let dir = seen.cross(plane.normal).try_normalize()?;
    // From the slice's middle within the slice to the plane.
    let towards = plane.normal - seen * seen.dot(plane.normal);
    let origin = slice.centre - towards * (plane.distance(slice.centre) / towards.length_squared());
    let others: Vec<Plane> = part.faces.iter().map(|f| f.plane).filter(|face| face != plane).collect();
    let line = Ray { origin, dir };
    let (t0, t1) = line.clip(&others, f64::NEG_INFINITY, f64::INFINITY)?;
    (t0.is_finite() && t1.is_finite()).then(|| [line.at(t0), line.at(t1)])
}
