//! What is known of a brick while it is painted, before its texels are the field's: by the cell.

use crate::volume::brick::{BRICK, Brick, BrickIndex, BrickKey, CELL, CELLS_PER_BRICK};
use crate::volume::cells::Cells;
use crate::volume::field::{Field, FieldKind};
use crate::volume::source::SourceError;

/// The selection's codes over a cell's own voxels, those in the volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SelectedCell {
    /// Least code; 255 without voxels.
    pub min: u8,
    /// Greatest code; 0 without voxels.
    pub max: u8,
    /// Sum of codes.
    pub sum: u16,
}

impl SelectedCell {
    /// A cell without voxels.
    pub const NOTHING: Self = Self { min: u8::MAX, max: 0, sum: 0 };
}

/// A brick's 8³ cells of 4³ voxels, x fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct LiveCells {
    /// As [`Cells`] has them.
    pub ranges: Vec<[f32; 2]>,
    /// Of a selection; else empty.
    pub selected: Vec<SelectedCell>,
}

impl LiveCells {
    /// A brick as its field has it.
    ///
    /// # Errors
    /// If the source fails.
    pub fn of(field: &Field, index: BrickIndex) -> Result<Self, SourceError> {
        let key = BrickKey { level: 0, index };
        let ranges = match field.cells(key) {
            Cells::Uniform(range) => vec![range; CELLS_PER_BRICK],
            Cells::Dense(cells) => cells.to_vec(),
        };
        let selected = match field.kind() {
            FieldKind::Selection => selected_cells(&field.brick(key)?, field.valid(0, index)),
            _ => Vec::new(),
        };
        Ok(Self { ranges, selected })
    }
}

/// The cells of a brick of a selection of which `valid` voxels along each axis lie in the volume.
pub fn selected_cells(brick: &Brick, valid: [u32; 3]) -> Vec<SelectedCell> {
    let texels = match brick {
        Brick::Uniform(value) if valid == [BRICK; 3] => {
            let cell = SelectedCell { min: value[0], max: value[0], sum: u16::from(value[0]) * CELL.pow(3) as u16 };
            return vec![cell; CELLS_PER_BRICK];
        }
        brick => brick.texels(1),
    };
    let mut cells = Vec::with_capacity(CELLS_PER_BRICK);
    let (edge, valid) = (CELL as usize, valid.map(|v| v as usize));
    for cell_z in 0..BRICK as usize / edge {
        for cell_y in 0..BRICK as usize / edge {
            // All rows of the cells against each other first, many codes at once.
            let mut least = [u8::MAX; BRICK as usize];
            let mut greatest = [0_u8; BRICK as usize];
            let mut sums = [0_u16; BRICK as usize];
            for z in cell_z * edge..((cell_z + 1) * edge).min(valid[2]) {
                for y in cell_y * edge..((cell_y + 1) * edge).min(valid[1]) {
                    let row = &texels[BRICK as usize * (y + BRICK as usize * z)..][..valid[0]];
                    least.iter_mut().zip(row).for_each(|(least, &code)| *least = code.min(*least));
                    greatest.iter_mut().zip(row).for_each(|(greatest, &code)| *greatest = code.max(*greatest));
                    sums.iter_mut().zip(row).for_each(|(sum, &code)| *sum += u16::from(code));
                }
            }
            let rows = least.chunks_exact(edge).zip(greatest.chunks_exact(edge)).zip(sums.chunks_exact(edge));
            cells.extend(rows.map(|((least, greatest), sums)| SelectedCell {
                min: least.iter().copied().min().unwrap_or(u8::MAX),
                max: greatest.iter().copied().max().unwrap_or(0),
                sum: sums.iter().sum(),
            }));
        }
    }
    cells
}
