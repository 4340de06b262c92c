//! The fields' cell minima and maxima as bits for the maps of empty space, at the level that each brick is drawn from.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::pools::marks::Marks;
use crate::gpu::fields::pools::{FieldPools, Fields};
use crate::gpu::fields::skip_maps::Map;
use crate::volume::{BrickIndex, BrickKey, Cells, Field};

impl FieldPools {
    /// Renews the maps of empty space where bricks changed or are drawn from another level.
    pub(super) fn settle_cells(&mut self, gpu: &Gpu, fields: &Fields<'_>) -> Result<bool, GpuError> {
        let (Some(look), [Some(density), _, selection, _]) = (&self.look, &self.pools) else {
            self.stale_cells = Marks::all();
            return Ok(false);
        };
        let bricks = self.stale_cells.take(self.visible.len());
        if bricks.is_empty() {
            return Ok(false);
        }
        let (row, slab) = (self.bricks[0] as usize, (self.bricks[0] * self.bricks[1]) as usize);
        let live = &self.live;
        let of = |b: [u32; 3]| {
            let i = b[0] as usize + row * b[1] as usize + slab * b[2] as usize;
            let matter = CellsOf::new(fields.density, live[0].get(&i), density.level_of(i), b);
            let chosen =
                selection.as_ref().map(|pool| CellsOf::new(fields.selection, live[1].get(&i), pool.level_of(i), b));
            std::array::from_fn(|cell| {
                let [lo, hi] = matter.range(cell);
                if !look.shows.any(lo, hi) {
                    return 0;
                }
                let [least, most] = chosen.as_ref().map_or([0.0, 0.0], |c| c.range(cell));
                let selected = u8::from(most > 0.0) << Map::Selection as u8;
                let left = u8::from(least < 1.0) << Map::Background as u8;
                1 << Map::Matter as u8 | selected | left
            })
        };
        self.skips.update(gpu, &bricks, &of)?;
        Ok(true)
    }
}

/// The cells of 4³ voxels of a brick of level 0, as the level that it is drawn from has them.
struct CellsOf {
    cells: Cells,
    /// A running stroke's, which are of level 0.
    live: Option<Cells>,
    level: u8,
    /// First cell of the brick within the coarse brick, in cells of level 0.
    first: [u32; 3],
}

impl CellsOf {
    fn new(field: &Field, live: Option<&Cells>, level: u8, brick: [u32; 3]) -> Self {
        // Bricks that a stroke paints are drawn from level 0, and looked at as they were at its start too.
        let level = if live.is_some() { 0 } else { level };
        let index = BrickIndex(brick.map(|b| b >> level));
        let first = std::array::from_fn(|a| (brick[a] - (index.0[a] << level)) * 8);
        Self { cells: field.cells(BrickKey { level, index }), live: live.cloned(), level, first }
    }

    fn range(&self, cell: usize) -> [f32; 2] {
        let at = [cell % 8, cell / 8 % 8, cell / 64];
        let [x, y, z] = std::array::from_fn(|a| (self.first[a] as usize + at[a]) >> self.level);
        let [lo, hi] = in_cell(&self.cells, x + 8 * (y + 8 * z));
        match &self.live {
            Some(live) => {
                let [least, most] = in_cell(live, cell);
                [lo.min(least), hi.max(most)]
            }
            None => [lo, hi],
        }
    }
}

fn in_cell(cells: &Cells, cell: usize) -> [f32; 2] {
    match cells {
        Cells::Uniform(range) => *range,
        Cells::Dense(cells) => cells[cell],
    }
}
