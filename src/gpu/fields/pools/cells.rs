//! The fields' cell minima and maxima as maps of empty space, at the level that each brick is drawn from.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::matter::{Matter, Showing};
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::slot_key::brick_of;
use crate::gpu::fields::volumes::Fields;
use crate::gpu::picture::frame::Mask;
use crate::volume::{BRICK, BrickIndex, BrickKey, CELL, Cells, Field, FieldKey, FieldKind, VolumeId};
use std::collections::HashSet;

impl FieldPools {
    /// Makes and renews the maps of empty space of what bodies show, where bricks changed or are drawn from another level.
    /// Answers each one's first cell in the texture of all maps. To be called after the bricks were made resident.
    ///
    /// # Errors
    /// Out of memory, a lost device, or a volume that `fields` has not.
    pub fn skip_maps(&mut self, gpu: &Gpu, fields: &Fields<'_>, wanted: &[Matter]) -> Result<Vec<[u32; 3]>, GpuError> {
        let volumes = &self.volumes;
        let shape =
            |id: VolumeId| volumes.get(&id).map_or(([1; 3], [1; 3]), |v| (v.demand.grid().dims, v.demand.bricks()));
        let numbers = self.skips.have(gpu, wanted, &shape)?;
        for (matter, &number) in wanted.iter().zip(&numbers) {
            let id = matter.volume;
            let (Some(volume), Some(fields)) = (self.volumes.get(&id), fields.get(id)) else {
                return Err(GpuError::NoVolume { id: id.0 });
            };
            let [density, selection] = [FieldKind::Density, FieldKind::Selection].map(|kind| FieldKey::new(id, kind));
            let labels_key = FieldKey::new(id, FieldKind::Labels);
            // What labels a running stroke has made there is known by the device alone.
            let painted: HashSet<BrickIndex> = self.pinned(labels_key).into_iter().collect();
            let (pages, demand) = (&self.pages, &volume.demand);
            let of = |i: usize| {
                let at = brick_of(demand.bricks(), i).0;
                let [live, live_selection] = demand.live(i);
                let values = CellsOf::new(fields.density, live, pages.level_of(density, i), at);
                let masked = matter.mask != Mask::None && pages.has(selection);
                let level = pages.level_of(selection, i);
                let chosen = masked.then(|| CellsOf::new(fields.selection, live_selection, level, at));
                let by_label = matches!(matter.values, Showing::ByLabel(_));
                let index = BrickIndex(at);
                let level = pages.level_of(labels_key, i);
                let labels = (by_label && !painted.contains(&index))
                    .then(|| LabelCells::new(fields.labels, level, index, pages.has(labels_key)))
                    .flatten();
                std::array::from_fn(|cell| {
                    let range = values.range(cell);
                    let shows = match (&matter.values, &labels) {
                        (Showing::One(values), _) => values.any(range[0], range[1]),
                        (Showing::ByLabel(by), Some(labels)) => labels.any(cell, |label| by.shows(label, range)),
                        (Showing::ByLabel(by), None) => by.any(range),
                    };
                    if !shows {
                        return false;
                    }
                    let [least, most] = chosen.as_ref().map_or([0.0, 0.0], |c| c.range(cell));
                    match matter.mask {
                        Mask::None => true,
                        Mask::Selection => most > 0.0,
                        Mask::Background => least < 1.0,
                    }
                })
            };
            self.skips.renew(gpu, number, &of)?;
        }
        self.rebind(gpu)?;
        Ok(numbers.into_iter().map(|number| self.skips.place(number)).collect())
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

/// Labels of a brick of level 0, as the level that it is drawn from has them: a sample has its voxel's own.
enum LabelCells {
    One(u16),
    /// Of every voxel of level 0, x fastest.
    Each(Vec<u16>),
}

impl LabelCells {
    /// `None` where they cannot be told. `held`: whether anything of the field is on the device.
    fn new(labels: &Field, level: u8, index: BrickIndex, held: bool) -> Option<Self> {
        if !held {
            return Some(Self::One(0));
        }
        let coarse = BrickKey { level, index: BrickIndex(index.0.map(|b| b >> level)) };
        if let Some(texel) = labels.summary(coarse).uniform {
            return Some(Self::One(u16::from_le_bytes([texel[0], texel[1]])));
        }
        let lo = index.origin().map(|v| i64::from(v >> level));
        let edge = (BRICK >> level).max(1);
        let texels = labels.read(level, lo, [edge; 3]).ok()?;
        let at = |v: u32| (v >> level).min(edge - 1);
        let label = |i: usize| u16::from_le_bytes([texels[2 * i], texels[2 * i + 1]]);
        let voxel = |i: u32| [i % BRICK, i / BRICK % BRICK, i / (BRICK * BRICK)].map(at);
        let each = (0..BRICK * BRICK * BRICK).map(voxel).map(|[x, y, z]| label((x + edge * (y + edge * z)) as usize));
        Some(Self::Each(each.collect()))
    }

    /// Whether it is so of any label in a cell.
    fn any(&self, cell: usize, mut of: impl FnMut(u16) -> bool) -> bool {
        let each = match self {
            Self::One(label) => return of(*label),
            Self::Each(each) => each,
        };
        let (edge, n) = (CELL as usize, BRICK as usize);
        let first = [cell % 8, cell / 8 % 8, cell / 64].map(|c| c * edge);
        let mut last = None;
        (0..edge * edge).any(|row| {
            let at = first[0] + n * (first[1] + row % edge + n * (first[2] + row / edge));
            each[at..at + edge].iter().any(|&label| last.replace(label) != Some(label) && of(label))
        })
    }
}
