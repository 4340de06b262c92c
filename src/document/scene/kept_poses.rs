//! Poses as they are kept beside a scene: a cache, so that what was saved is shown at once.
//!
//! What is missing is found again. Owns what is known of poses that were written when they were still kept in the scene itself.

use crate::document::scene::Scene;
use crate::document::scene::cause::mark_of_scene;
use crate::explode::{PartPose, PartRecord, Poses};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Where parts stand.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SavedPoses {
    /// Names the scene whose forces they are at rest under; `None` if they were on their way.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest_of: Option<String>,
    /// Of the parts that forces moved.
    pub parts: Poses,
}

impl SavedPoses {
    /// Poses that a scene's parts rest in.
    pub(crate) fn at_rest(scene: &Scene, parts: Poses) -> Self {
        Self { rest_of: Some(mark_of_scene(scene)), parts }
    }
}

/// Where forces had taken the parts of an explosion that was written when poses were kept in the scene itself.
pub(crate) fn poses_of_before(explosion: &Value) -> Poses {
    let parts: Vec<PartRecord> = serde_json::from_value(explosion["parts"].clone()).unwrap_or_default();
    let free = parts.into_iter().filter(|part| !part.pinned);
    free.map(|PartRecord { id, pose, .. }| PartPose { id, pose }).collect::<Vec<_>>().into()
}
