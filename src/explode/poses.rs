//! Where the parts stand: what the simulation found, apart from what a person decided ([`Explosion`]).
//!
//! Found again whenever it is wanted, so it is in no history and is saved as a cache only. A part that a hand holds stands where
//! the hand has it, whatever is noted here. Owns how parts that come, go or are let go of stand; knows no forces.

use crate::explode::error::ExplodeError;
use crate::explode::state::{Explosion, Part, PartId};
use crate::math::Pose;
use crate::math::convex::diameter;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Where forces took each part; what is not noted is at rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Vec<PartPose>", into = "Vec<PartPose>")]
pub struct Poses(BTreeMap<PartId, Pose>);

/// Where one part stands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartPose {
    /// The part.
    pub id: PartId,
    /// `world_from_rest`, millimetres.
    pub pose: Pose,
}

impl From<Vec<PartPose>> for Poses {
    fn from(list: Vec<PartPose>) -> Self {
        Self(list.into_iter().filter(|p| p.pose != Pose::IDENTITY).map(|p| (p.id, p.pose)).collect())
    }
}

impl From<Poses> for Vec<PartPose> {
    fn from(poses: Poses) -> Self {
        poses.0.into_iter().map(|(id, pose)| PartPose { id, pose }).collect()
    }
}

impl Poses {
    /// What a simulation of these parts found, in order of parts.
    pub fn found(parts: &[Part], poses: &[Pose]) -> Self {
        let free = parts.iter().zip(poses).filter(|(part, _)| part.held.is_none());
        free.map(|(part, &pose)| PartPose { id: part.id, pose }).collect::<Vec<_>>().into()
    }

    /// Where a part stands.
    pub fn of(&self, part: &Part) -> Pose {
        part.held.or_else(|| self.0.get(&part.id).copied()).unwrap_or_default()
    }

    /// The same of all parts, in their order.
    pub fn in_order(&self, parts: &[Part]) -> Vec<Pose> {
        parts.iter().map(|part| self.of(part)).collect()
    }

    /// The same with their names, as answers tell it.
    pub fn told(&self, parts: &[Part]) -> Vec<PartPose> {
        parts.iter().map(|part| PartPose { id: part.id, pose: self.of(part) }).collect()
    }

    /// Whether every part stands where it does in the unexploded volume.
    pub fn at_rest(&self, parts: &[Part]) -> bool {
        parts.iter().all(|part| self.of(part) == Pose::IDENTITY)
    }

    /// Whether no force has taken any part anywhere; hands may hold some.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Where the parts of `after` stand, if those of `before` stand as noted here and nothing has moved since: halves where the whole
    /// stood, and what a hand let go of where the hand had it.
    #[must_use]
    pub fn carried(&self, before: &Explosion, after: &Explosion) -> Self {
        let of = |id: PartId| before.parts.iter().find(|p| p.id == id);
        let pose = |part: &Part| {
            let before = of(part.id).or_else(|| before.parts.iter().find(|whole| part.is_half_of(whole)))?;
            Some(PartPose { id: part.id, pose: self.of(before) })
        };
        let free = after.parts.iter().filter(|part| part.held.is_none());
        free.filter_map(pose).collect::<Vec<_>>().into()
    }

    /// Checks that parts can stand there, for instance of a project that was written by hand.
    ///
    /// # Errors
    /// The first pose that no part can have.
    pub fn check(&self, explosion: &Explosion) -> Result<(), ExplodeError> {
        for (i, part) in explosion.parts.iter().enumerate() {
            explosion.check_pose(part, &self.of(part)).map_err(|e| e.within(&format!("parts[{i}].")))?;
        }
        Ok(())
    }
}

/// Share of a part's extent by which the corners of its half may lie outside.
const OUTSIDE: f64 = 1e-6;

impl Part {
    /// Whether this is another part's matter, and not all of it.
    fn is_half_of(&self, whole: &Self) -> bool {
        let slack = OUTSIDE * diameter(&whole.vertices);
        let inside = whole.faces.iter().all(|face| self.vertices.iter().all(|&v| face.plane.distance(v) <= slack));
        inside && self.volume_mm3() < whole.volume_mm3() * (1.0 - OUTSIDE)
    }
}
