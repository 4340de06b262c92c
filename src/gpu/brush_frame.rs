//! Which slots the dabs of one frame meet, and the box of work in each.
//!
//! Pure arithmetic: from footprints to [`Work`]. Its cost follows the dabs and the slots they meet, not the volume.

use super::brush_kernel::{BrushItem, MOST_DABS};
use crate::paint::{Footprint, IndexBox};
use crate::volume::{BrickIndex, SLOT};
use std::collections::BTreeMap;

/// A slot's share of up to [`MOST_DABS`] dabs that follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Work {
    /// Voxels that change at most.
    bounds: IndexBox,
    /// Numbers of the first and the last dab that meet the slot.
    dabs: [u32; 2],
}

/// Dabs in groups of what a dispatch can take, each with the slots it meets.
pub(super) fn groups(footprints: &[Footprint], dims: [u32; 3]) -> Vec<(&[Footprint], BTreeMap<BrickIndex, Work>)> {
    footprints
        .chunks(MOST_DABS)
        .map(|group| {
            let mut work: BTreeMap<BrickIndex, Work> = BTreeMap::new();
            for (n, footprint) in (0_u32..).zip(group) {
                for brick in footprint.bounds.slots(dims) {
                    let new = Work { bounds: footprint.bounds, dabs: [n, n] };
                    work.entry(brick)
                        .and_modify(|w| *w = Work { bounds: w.bounds.union(&new.bounds), dabs: [w.dabs[0], n] })
                        .or_insert(new);
                }
            }
            (group, work)
        })
        .collect()
}

impl Work {
    /// The same in the slot's own texels and words. `next` is the first word of the box among the new words.
    pub(super) fn item(&self, brick: BrickIndex, dims: [u32; 3], place: u32, per_word: u32, next: u32) -> BrushItem {
        let origin = brick.origin().map(|o| o as i32 - 1);
        let mut lo: [u32; 3] = std::array::from_fn(|a| (self.bounds.lo[a] as i32 - origin[a]).max(0) as u32);
        let mut end: [u32; 3] =
            std::array::from_fn(|a| (self.bounds.end[a] as i32 - origin[a]).clamp(0, SLOT as i32) as u32);
        for a in 0..3 {
            // Texels beyond the volume repeat its border.
            if self.bounds.lo[a] == 0 {
                lo[a] = 0;
            }
            if self.bounds.end[a] == dims[a] {
                end[a] = SLOT;
            }
        }
        (lo[0], end[0]) = (lo[0] / per_word, end[0].div_ceil(per_word));
        BrushItem {
            origin,
            place,
            lo,
            next,
            size: std::array::from_fn(|a| end[a] - lo[a]),
            first_dab: self.dabs[0],
            dab_count: self.dabs[1] - self.dabs[0] + 1,
            unused_a: 0,
            unused_b: 0,
            unused_c: 0,
        }
    }
}
