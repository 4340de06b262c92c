//! What a splitter is about to cut and where parts end, so that the hand does not work blind: at rest parts make a picture
//! without seams, and a cut shows nothing before it is made.
//!
//! Planes, not lines: whoever draws knows which surface is seen, and shows them there. Knows no pixels of pictures.

use crate::document::{Scene, SlicePlane};
use crate::explode::{Axis, Cut, Part, Poses};
use crate::interact::aim::Aim;
use crate::interact::tools::Tool;
use crate::math::{DVec2, DVec3, Plane, Ray};

/// What a tool would cut if the button went up now, `line` being under the hand; what it would only graze is left out.
pub fn cuts(
    (tool, line): (Tool, Option<[DVec2; 2]>),
    (scene, poses): (&Scene, &Poses),
    aim: Aim,
    axis: Axis,
) -> Vec<Cut> {
    let divides = |cut: &Cut| {
        let mut copy = (*scene.explosion).clone();
        copy.split_at_rest(cut.part, &cut.plane).is_ok_and(|halves| halves.is_some())
    };
    tool.does().cuts(line, (scene, poses), aim, axis).into_iter().filter(divides).collect()
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
