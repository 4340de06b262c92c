//! Which bricks of level 0 are needed, and how urgently.
//!
//! Needed is what the look shows of the matter that bodies draw, what slices run through, and what is being painted. Judged
//! brick by brick where something changed that this depends on.

use crate::gpu::fields::importance;
use crate::gpu::fields::pools::{FieldPools, Fields};
use crate::gpu::picture::frame::{Body, Mask};
use crate::volume::{BrickIndex, BrickKey, Cells, Field};
use rayon::prelude::*;

/// Whether two lists of bodies draw the same matter, wherever it is moved to.
pub(super) fn same_matter(a: &[Body], b: &[Body]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.mask == b.mask && a.region == b.region)
}

fn any(cells: &Cells, of: impl Fn([f32; 2]) -> bool) -> bool {
    match cells {
        Cells::Uniform(range) => of(*range),
        Cells::Dense(cells) => cells.iter().any(|&range| of(range)),
    }
}

impl FieldPools {
    /// Judges the bricks anew of which something changed; each field's pages follow those that are judged otherwise.
    pub(super) fn judge(&mut self, fields: &Fields<'_>) {
        if self.visible.is_empty() {
            let bricks = fields.density.brick_indices(0);
            self.visible = bricks.into_par_iter().map(|b| self.shows(fields.density, b)).collect();
            self.unsure = crate::gpu::fields::pools::marks::Marks::all();
        }
        let marks = self.unsure.take(self.visible.len());
        self.judged += marks.len() as u64;
        let judged: Vec<bool> = marks.par_iter().with_min_len(64).map(|&i| self.is_needed(fields, i)).collect();
        for (i, needed) in marks.into_iter().zip(judged) {
            if self.needed[i] != needed {
                self.needed[i] = needed;
                self.shown.iter_mut().for_each(|s| s.stale.insert(i));
            }
        }
    }

    /// Whether the look shows any of a brick of level 0.
    pub(super) fn shows(&self, density: &Field, index: BrickIndex) -> bool {
        let about = density.summary(BrickKey { level: 0, index });
        self.look.as_ref().is_some_and(|l| l.shows.any(about.min, about.max))
    }

    fn is_needed(&self, fields: &Fields<'_>, i: usize) -> bool {
        let shows = |cells: &Cells| self.look.as_ref().is_some_and(|l| any(cells, |[lo, hi]| l.shows.any(lo, hi)));
        // A stroke's bricks are looked at as they are and as they were at its start.
        let visible = self.visible[i] || self.live[0].get(&i).is_some_and(shows);
        self.sliced(self.key_at(i).index) || visible && self.is_drawn(fields.selection, i)
    }

    /// Whether a body draws any of a brick: hidden parts need nothing.
    fn is_drawn(&self, selection: &Field, i: usize) -> bool {
        let Some(sight) = &self.sight else { return false };
        if sight.bodies.iter().any(|b| b.mask == Mask::None && b.region.is_empty()) {
            return true;
        }
        let key = self.key_at(i);
        let about = selection.summary(key);
        let live = self.live[1].get(&i);
        let holds =
            |of: &dyn Fn([f32; 2]) -> bool| of([about.min, about.max]) || live.is_some_and(|cells| any(cells, of));
        let corners = importance::corners(&self.grid, key.index);
        sight.bodies.iter().any(|body| {
            let shares = match body.mask {
                Mask::None => true,
                Mask::Selection => holds(&|[_, most]| most > 0.0),
                Mask::Background => holds(&|[least, _]| least < 1.0),
            };
            shares && !importance::outside(&body.region, &corners)
        })
    }

    /// Whether a slice runs through a brick of level 0.
    fn sliced(&self, index: BrickIndex) -> bool {
        (0..3).any(|a| self.slices[a] == Some(index.0[a]))
    }

    /// How much each of some bricks of level 0 matters to the picture.
    pub(super) fn urgency(&self, density: &Field, bricks: &[BrickKey]) -> Vec<f32> {
        let mut urgency = match (&self.sight, &self.look) {
            (Some(sight), Some(look)) => {
                let known = || importance::extinctions(density, &self.grid, &look.transfer);
                importance::urgency(sight, &self.grid, self.bricks, self.extinction.get_or_init(known), bricks)
            }
            _ => vec![0.0; bricks.len()],
        };
        for (urgency, key) in urgency.iter_mut().zip(bricks) {
            // A slice shows its voxels at about a pixel each.
            if self.sliced(key.index) {
                *urgency = urgency.max(1.0);
            }
        }
        urgency
    }
}
