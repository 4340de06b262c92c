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
    let mut cells = vec![SelectedCell::NOTHING; CELLS_PER_BRICK];
    let n = BRICK / CELL;
    for z in 0..valid[2] {
        for y in 0..valid[1] {
            for x in 0..valid[0] {
                let code = match brick {
                    Brick::Uniform(value) => value[0],
                    Brick::Dense(texels) => texels[(x + BRICK * (y + BRICK * z)) as usize],
                };
                let cell = &mut cells[(x / CELL + n * (y / CELL + n * (z / CELL))) as usize];
                *cell =
                    SelectedCell { min: cell.min.min(code), max: cell.max.max(code), sum: cell.sum + u16::from(code) };
            }
        }
    }
    cells
}
