//! Where parts stood under the scenes that were left, so that undo and redo show them at once.
//!
//! A memory beside history and not in it: it is bounded, goes with the program, and whatever it lacks is found again. Knows what a
//! scene says of its parts by a mark only.

use crate::document::scene::cause::Cause;
use crate::explode::{ExplosionPoint, Poses};
use crate::math::Pose;
use std::collections::VecDeque;
use std::sync::Arc;

/// Scenes that are remembered.
const KEPT: usize = 256;

/// Explosion points that are shared.
pub(crate) type Points = Arc<[ExplosionPoint]>;

/// Rest poses that were found.
#[derive(Debug)]
pub(crate) struct Found {
    /// For what.
    pub cause: Cause,
    /// For which explosion points; `None` of poses that were kept: for those that there were.
    pub points: Option<Points>,
    /// In order of parts.
    pub poses: Vec<Pose>,
    /// Share of the selection that is visible, if it was measured.
    pub visible: Option<f64>,
}

/// Where parts stand, and what is known of where they rest.
#[derive(Clone, Debug, Default)]
pub(crate) struct Standing {
    pub poses: Poses,
    pub found: Option<Arc<Found>>,
}

/// Where the parts stood under the last scenes that were left, by the scene's mark.
#[derive(Debug, Default)]
pub(crate) struct Stood(VecDeque<(String, Standing)>);

impl Stood {
    /// Notes where parts stand as a scene is left; what was noted of the same one goes.
    pub(crate) fn note(&mut self, mark: String, standing: Standing) {
        self.0.retain(|(known, _)| *known != mark);
        self.0.push_back((mark, standing));
        if self.0.len() > KEPT {
            self.0.pop_front();
        }
    }

    /// Where they stood when it was last left.
    pub(crate) fn under(&self, mark: &str) -> Option<&Standing> {
        self.0.iter().find(|(known, _)| known == mark).map(|(_, standing)| standing)
    }
}
