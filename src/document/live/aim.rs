//! Where the brush is: under the hand, or where a stroke laid its last dab. Pictures with a focus follow it.
//!
//! Nobody decided it, so it is in no scene, no history and no project.

use crate::document::state::State;
use crate::explode::{PartId, Poses};
use crate::math::DVec3;

/// A place of matter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// World mm, at rest.
    pub rest: DVec3,
    /// The part that it goes with; `None`: of what stays where it is.
    pub part: Option<PartId>,
}

impl Aim {
    /// A place of the world at rest, with the part that holds it.
    pub(crate) fn at(state: &State, rest: DVec3) -> Self {
        Self { rest, part: state.scene.explosion.of_body(0, rest) }
    }

    /// Where it stands now.
    pub(crate) fn world(&self, state: &State, poses: &Poses) -> DVec3 {
        let part = state.scene.explosion.parts.iter().find(|p| Some(p.id) == self.part);
        part.map_or(self.rest, |part| poses.of(part).apply(self.rest))
    }
}
