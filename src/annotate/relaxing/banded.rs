//! Symmetric positive definite banded matrices.
//!
//! The Hessian of an energy on a lattice couples neighbours only: numbered along the lattice it is a band. Owns such a matrix and its
//! Cholesky factor, in tiles of four by four so that a processor's registers are used, and in 32 bits: a Newton step on a factor that
//! is a little off is still one downhill. It knows nothing of the energy.

/// Rows and columns of a tile.
const TILE: usize = 4;

/// Numbers that a processor multiplies at once, on the least that one may be; they divide a tile.
const LANES: usize = 4;

/// A symmetric matrix of which the diagonal and `band` diagonals below it are kept; after [`factorise`](Self::factorise) its
/// Cholesky factor, in place.
#[derive(Clone, Debug, Default)]
pub(crate) struct Banded {
    size: usize,
    /// Entries of a row: a whole number of tiles, of which the last is on the diagonal.
    width: usize,
    /// Row by row; the rows of a tile begin at the same column.
    rows: Vec<f32>,
}

impl Banded {
    /// Makes this a matrix of zeros, `size` rows with `band` entries left of the diagonal, in the room that it has.
    pub(crate) fn clear(&mut self, size: usize, band: usize) {
        self.size = size;
        self.width = (band.div_ceil(TILE) + 1) * TILE;
        self.rows.clear();
        self.rows.resize(size.div_ceil(TILE) * TILE * self.width, 0.0);
    }

    /// Adds to the entry (`row`, `column`), `column` ≤ `row` ≤ `column` + band.
    pub(crate) fn add(&mut self, row: usize, column: usize, value: f32) {
        let tile = row / TILE;
        self.rows[row * self.width + self.width + column - (tile + 1) * TILE] += value;
    }

    /// Adds `value` to the diagonal.
    pub(crate) fn shift(&mut self, value: f32) {
        for row in 0..self.size {
            self.add(row, row, value);
        }
    }

    /// Replaces the matrix by its Cholesky factor. False if it is not positive definite.
    pub(crate) fn factorise(&mut self) -> bool {
        let width = self.width;
        for row in self.size..self.size.div_ceil(TILE) * TILE {
            self.rows[row * width + width - TILE + row % TILE] = 1.0;
        }
        let reach = width / TILE - 1;
        for i in 0..self.size.div_ceil(TILE) {
            let (above, rest) = self.rows.split_at_mut(i * TILE * width);
            let mine = &mut rest[..TILE * width];
            for j in i.saturating_sub(reach)..i {
                let theirs = &above[j * TILE * width..(j + 1) * TILE * width];
                // Tile j of these rows; the common columns are those before it, from the first of these rows on.
                let at = (j + reach - i) * TILE;
                let tile = subtracted(mine, theirs, width, at, width - TILE);
                // Times the inverse of the transposed diagonal tile.
                for (r, mut line) in tile.into_iter().enumerate() {
                    for c in 0..TILE {
                        for k in 0..c {
                            line[c] -= line[k] * theirs[c * width + width - TILE + k];
                        }
                        line[c] /= theirs[c * width + width - TILE + c];
                    }
                    mine[r * width + at..r * width + at + TILE].copy_from_slice(&line);
                }
            }
            let mut tile = subtracted(mine, mine, width, width - TILE, width - TILE);
            for r in 0..TILE {
                for c in 0..=r {
                    for k in 0..c {
                        tile[r][c] -= tile[r][k] * tile[c][k];
                    }
                    if r > c {
                        tile[r][c] /= tile[c][c];
                    } else if tile[r][r] > 0.0 && tile[r][r].is_finite() {
                        tile[r][r] = tile[r][r].sqrt();
                    } else {
                        return false;
                    }
                }
                mine[r * width + width - TILE..(r + 1) * width].copy_from_slice(&tile[r]);
            }
        }
        true
    }

    /// Solves for the right-hand side in `x`, in place, with the factor.
    pub(crate) fn solve(&self, x: &mut [f32]) {
        for i in 0..self.size {
            let (row, first) = self.left_of_diagonal(i);
            let sum = dot(row, &x[first..i]);
            x[i] = (x[i] - sum) / self.diagonal(i);
        }
        for i in (0..self.size).rev() {
            let (row, first) = self.left_of_diagonal(i);
            x[i] /= self.diagonal(i);
            let value = x[i];
            for (entry, factor) in x[first..i].iter_mut().zip(row) {
                *entry -= value * factor;
            }
        }
    }

    /// The entries of a row left of its diagonal, and the column of the first of them.
    fn left_of_diagonal(&self, row: usize) -> (&[f32], usize) {
        let end = (row / TILE + 1) * TILE;
        let first = end.saturating_sub(self.width);
        let begin = row * self.width + self.width - end;
        (&self.rows[begin + first..begin + row], first)
    }

    fn diagonal(&self, row: usize) -> f32 {
        self.rows[row * self.width + self.width - TILE + row % TILE]
    }
}

/// The tile of `mine` at column `at`, less the products of the `at` entries before it with as many of `theirs` before `end`.
fn subtracted(mine: &[f32], theirs: &[f32], width: usize, at: usize, end: usize) -> [[f32; TILE]; TILE] {
    let mut tile = [[0.0; TILE]; TILE];
    for half in [0, 2] {
        let a: [&[[f32; LANES]]; 2] = [0, 1].map(|r| mine[(half + r) * width..(half + r) * width + at].as_chunks().0);
        let b: [&[[f32; LANES]]; TILE] =
            [0, 1, 2, 3].map(|c| theirs[c * width + end - at..c * width + end].as_chunks().0);
        let length = a.iter().chain(&b).map(|row| row.len()).min().unwrap_or(0);
        let a = a.map(|row| &row[..length]);
        let b = b.map(|row| &row[..length]);
        let mut sums = [[[0.0; LANES]; TILE]; 2];
        for k in 0..length {
            for r in 0..2 {
                for c in 0..TILE {
                    for lane in 0..LANES {
                        sums[r][c][lane] += a[r][k][lane] * b[c][k][lane];
                    }
                }
            }
        }
        for r in 0..2 {
            for c in 0..TILE {
                tile[half + r][c] = mine[(half + r) * width + at + c] - sums[r][c].iter().sum::<f32>();
            }
        }
    }
    tile
}

/// Eight partial sums, so that the compiler can use its widest registers.
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0; 8];
    let (left, right) = (a.chunks_exact(8), b.chunks_exact(8));
    let tail: f32 = left.remainder().iter().zip(right.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in left.zip(right) {
        for lane in 0..8 {
            sums[lane] += x[lane] * y[lane];
        }
    }
    sums.iter().sum::<f32>() + tail
}
