//! Which bricks of level 0 are needed, how urgently, and what page each gets.

use super::FieldPools;
use crate::gpu::pool::{self, Page, Pool};
use crate::gpu::sight;
use crate::volume::{BrickIndex, BrickKey, Field, FieldKind};
use std::collections::HashSet;

impl FieldPools {
    /// Whether the look shows any of a brick of level 0.
    pub(super) fn shows(&self, density: &Field, index: BrickIndex) -> bool {
        let about = density.summary(BrickKey { level: 0, index });
        self.look.as_ref().is_some_and(|l| l.shows.any(about.min, about.max))
    }

    /// What the look shows, what slices run through, and what is being painted.
    pub(super) fn needed(&self) -> Vec<bool> {
        let mut needed = self.visible.clone();
        let [nx, ny, _] = self.bricks.map(|n| n as usize);
        for (i, needed) in needed.iter_mut().enumerate() {
            let at = [i % nx, i / nx % ny, i / (nx * ny)];
            *needed |= (0..3).any(|a| self.slices[a].is_some_and(|row| row as usize == at[a]));
            *needed |= self.forced[0].contains(&i);
        }
        needed
    }

    pub(super) fn urgency(&self, density: &Field) -> Vec<f32> {
        let [nx, ny, _] = self.bricks.map(|n| n as usize);
        let mut urgency = match (&self.sight, &self.look) {
            (Some(sight), Some(look)) => {
                let known = || sight::extinctions(density, &self.grid, &look.transfer);
                sight::urgency(sight, &self.grid, self.bricks, self.extinction.get_or_init(known))
            }
            _ => vec![0.0; self.bricks.iter().map(|&b| b as usize).product()],
        };
        for (i, urgency) in urgency.iter_mut().enumerate() {
            let at = [i % nx, i / nx % ny, i / (nx * ny)];
            // A slice shows its voxels at about a pixel each.
            if (0..3).any(|a| self.slices[a].is_some_and(|row| row as usize == at[a])) {
                *urgency = urgency.max(1.0);
            }
        }
        urgency
    }
}

/// Where a brick of level 0 is drawn from.
pub(super) fn page(
    pool: &Pool,
    field: &Field,
    held: &HashSet<BrickKey>,
    uniform: &HashSet<BrickKey>,
    index: BrickIndex,
    needed: bool,
) -> Page {
    let mut key = BrickKey { level: 0, index };
    if let Some(page) = pool.pinned_page(key) {
        return page;
    }
    let about = field.summary(key);
    if let Some(texel) = about.uniform {
        return pool::uniform_page(0, pool.bits(texel));
    }
    if !needed {
        // Nothing of it shows under the look, its least value neither.
        let texel = if field.kind() == FieldKind::Density { field.map().encode(f64::from(about.min)) } else { [0; 4] };
        return pool::uniform_page(0, pool.bits(texel));
    }
    while key.level < field.level_count() {
        if held.contains(&key)
            && let Some(page) = pool.page(key)
        {
            return page;
        }
        if uniform.contains(&key)
            && let Some(texel) = field.summary(key).uniform
        {
            return pool::uniform_page(key.level, pool.bits(texel));
        }
        key = BrickKey { level: key.level + 1, index: key.index.parent() };
    }
    // The cut covers every needed brick, so this is not reached.
    pool::uniform_page(0, 0)
}
