//! Lines that say where parts end and where a splitter is about to cut. At rest parts make a picture without seams, and a cut
//! through air shows nothing: without these lines the hand would work blind.
//!
//! Rings of world mm, closed, as the parts stand now. A cut is found by cutting a copy, so that it is the one that a click makes.

use super::{Gesture, Hit, Tool};
use crate::document::Scene;
use crate::explode::{Axis, Explosion, Part, PartId, axis_plane, depth_plane};
use crate::math::{DVec2, DVec3};

/// The faces of a part that splitters made.
pub fn seams(part: &Part) -> Vec<Vec<DVec3>> {
    let rings = part.faces.iter().zip(part.polygons()).filter(|(face, ring)| face.cut && ring.len() > 2);
    rings.map(|(_, ring)| placed(part, &ring)).collect()
}

/// The faces that a tool would make if the button went up now: at a pixel of the 3D view of `size` pixels that shows `hit`.
pub fn cuts(
    (tool, gesture): (Tool, Option<&Gesture>),
    scene: &Scene,
    (px, size): (DVec2, [u32; 2]),
    hit: Option<Hit>,
    axis: Axis,
) -> Vec<Vec<DVec3>> {
    let mut after: Explosion = scene.explosion.clone();
    let camera = &scene.views.camera;
    let halves = match (tool, gesture) {
        (Tool::LineSplit, Some(Gesture::Line { from, to })) if from != to => {
            after.split_by_line(camera, *from, *to, size).unwrap_or_default()
        }
        (Tool::AxisSplit | Tool::DepthSplit, _) => {
            let mut cut = || {
                let hit = hit?;
                let plane = match tool {
                    Tool::AxisSplit => axis_plane(camera, px, size, axis, hit.world),
                    _ => depth_plane(camera, hit.world),
                };
                after.split(hit.part?, &plane.ok()?).ok()?
            };
            cut().into_iter().collect()
        }
        _ => Vec::new(),
    };
    let made = |[half, _]: &[PartId; 2]| {
        let part = after.part(*half).ok()?;
        // A split puts its own face last.
        Some(placed(part, part.polygons().last()?))
    };
    halves.iter().filter_map(made).collect()
}

fn placed(part: &Part, ring: &[DVec3]) -> Vec<DVec3> {
    ring.iter().map(|&corner| part.pose.apply(corner)).collect()
}
