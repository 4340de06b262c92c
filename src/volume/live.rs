//! What is known of a brick while it is painted, before its texels are the field's: by the cell.

use super::field::{Cells, Field, FieldKind};
use super::{BRICK, Brick, BrickIndex, BrickKey, CELL, CELLS_PER_BRICK, SourceError};

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
    let mut cells = vec![SelectedCell::NOTHING; CELLS_PER_BRICK];
    for z in 0..valid[2] {
        for y in 0..valid[1] {
            let row = &texels[(BRICK * (y + BRICK * z)) as usize..][..valid[0] as usize];
            let first = (BRICK / CELL * (y / CELL + BRICK / CELL * (z / CELL))) as usize;
            for (cell, codes) in cells[first..].iter_mut().zip(row.chunks(CELL as usize)) {
                *cell = codes.iter().fold(*cell, |cell, &code| SelectedCell {
                    min: cell.min.min(code),
                    max: cell.max.max(code),
                    sum: cell.sum + u16::from(code),
                });
            }
        }
    }
    cells
}
