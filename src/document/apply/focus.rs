//! What pictures look at: the focus of the scene about the place where the brush is.

use crate::document::Document;
use crate::document::apply::trail::Trail;
use crate::document::live::aim::Aim;
use crate::gpu::Frame;
use crate::paint::Sample;

impl Document {
    /// Says where the hand is, or takes it away. Answers whether the 3D view is another picture for it.
    pub fn aim(&mut self, aim: Option<Aim>) -> bool {
        let Some(state) = &self.state else { return false };
        let seen = state.scene.focus.on && state.scene.focus.at.is_none();
        std::mem::replace(&mut self.aim, aim) != aim && seen
    }

    /// The same of the last dab of a stroke.
    pub(crate) fn aim_at(&mut self, trail: Option<&Trail>, samples: &[Sample]) {
        let Some(state) = &self.state else { return };
        let at_rest = self.motion.poses().at_rest(&state.scene.explosion.parts);
        let aim = match (trail.and_then(Trail::hit), samples.last()) {
            // What stands apart from its parts is what is selected.
            (Some(hit), _) if hit.body == 0 && !at_rest => Some(Aim { rest: hit.rest, part: None }),
            (Some(hit), _) => Some(Aim { rest: hit.rest, part: state.scene.explosion.of_body(hit.body, hit.rest) }),
            (None, Some(sample)) => Some(Aim::at(state, sample.position)),
            (None, None) => self.aim,
        };
        self.aim = aim;
    }

    /// What the 3D view shows, with its focus.
    pub(crate) fn focused(&self, frame: Frame) -> Frame {
        let Some(state) = self.state.as_ref() else { return frame };
        let focus = &state.scene.focus;
        let aim = focus.at.map_or(self.aim, |at| Some(Aim::at(state, at.into())));
        let about = |aim: Aim| focus.about(aim.world(state, self.motion.poses()), state.scene.brush.radius_mm);
        Frame { focus: aim.and_then(about), ..frame }
    }
}
