//! The views' own past, apart from undo, so that undo never moves the camera.

use super::Views;
use std::collections::VecDeque;

/// More are not kept: nobody walks back that far.
const KEPT: usize = 256;

/// See the module's head.
#[derive(Debug, Default)]
pub(super) struct ViewHistory {
    back: VecDeque<Views>,
    forward: Vec<Views>,
    /// A drag is one change of view, however many commands it has.
    in_group: bool,
}

impl ViewHistory {
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Notes a change of view; those of one group are one change.
    pub(super) fn moved(&mut self, before: Views, now: &Views, in_group: bool) {
        if before == *now || (in_group && self.in_group) {
            return;
        }
        self.in_group = in_group;
        self.forward.clear();
        self.back.push_back(before);
        if self.back.len() > KEPT {
            self.back.pop_front();
        }
    }

    /// A group has ended.
    pub(super) fn group_closed(&mut self) {
        self.in_group = false;
    }

    /// Exchanges the views with the ones before (or after a `back`); sizes in pixels stay. `false` if there are none.
    pub(super) fn travel(&mut self, views: &mut Views, back: bool) -> bool {
        let Some(mut other) = (if back { self.back.pop_back() } else { self.forward.pop() }) else { return false };
        other.size = views.size;
        for (slice, now) in other.slices.iter_mut().zip(&views.slices) {
            slice.size = now.size;
        }
        std::mem::swap(views, &mut other);
        if back {
            self.forward.push(other)
        } else {
            self.back.push_back(other)
        }
        true
    }

    /// Numbers of views behind and ahead.
    pub(super) fn counts(&self) -> (usize, usize) {
        (self.back.len(), self.forward.len())
    }
}
