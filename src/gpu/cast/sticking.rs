//! Which bodies of a picture hold which decals.
//!
//! A decal lies on the matter of its volume: on every body that is cut out of it, wherever that stands, so that a text across a cut is cut
//! with it. What lies on selected matter goes with the selection. Bodies that no piece of a decal can be on hold none.

use crate::gpu::cast::merging::MergedBody;
use crate::gpu::layers::decals::Stuck;
use crate::gpu::picture::decal::{Decal, DecalMesh};
use crate::gpu::picture::frame::{Frame, Mask};
use crate::math::DVec3;

/// The decals of a frame, each on every body that may hold a piece of it.
pub(crate) fn stuck_on<'a>(frame: &'a Frame, drawn: &[MergedBody]) -> Vec<Stuck<'a>> {
    let mut all = Vec::new();
    for decal in frame.layers.decals.iter().filter(|decal| decal.opacity > 0.0) {
        let Some((centre, radius)) = ball_about(&decal.mesh) else { continue };
        for (i, body) in drawn.iter().enumerate() {
            let reaches = body.planes.iter().all(|plane| plane.distance(centre) <= radius);
            // What has looks of its own by label is one piece of matter with what has none.
            let again = drawn[..i].iter().any(|b| holds(decal, b) && b.pose == body.pose && b.planes == body.planes);
            if holds(decal, body) && reaches && !again {
                all.push(Stuck { decal, body: i as u32, pose: body.pose });
            }
        }
    }
    all
}

fn holds(decal: &Decal, body: &MergedBody) -> bool {
    let mask = match body.mask {
        Mask::None => true,
        Mask::Selection => decal.selected,
        Mask::Background => !decal.selected,
    };
    mask && body.volume == decal.volume
}

/// A ball about all corners, world mm at rest.
fn ball_about(mesh: &DecalMesh) -> Option<(DVec3, f64)> {
    let place = |i: usize| mesh.origin + DVec3::from_array(mesh.corners[i].place.map(f64::from));
    let count = mesh.corners.len();
    let centre = (0..count).map(place).sum::<DVec3>() / count as f64;
    let radius = (0..count).map(|i| place(i).distance(centre)).reduce(f64::max)?;
    Some((centre, radius))
}
