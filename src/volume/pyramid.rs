//! Arithmetic over the texels of one brick or slot: minima and maxima by the cell, and the next coarser level.

use crate::volume::blocks::{Region, fill_box};
use crate::volume::brick::shared_texel;
use crate::volume::brick::{BRICK, BRICK_VOXELS, Brick, CELL, CELLS_PER_BRICK};
use crate::volume::cells::{BrickSummary, Cells};
use crate::volume::texel::{DensityMap, TexelFormat};
use std::borrow::Cow;

/// What is known of a slot.
pub(super) type About = (BrickSummary, Cells);

/// Reads a texel as the number that minima, maxima and occupancy speak of: density in the volume's unit, selection 0..1,
/// the label's id, a colour's alpha.
pub(super) fn texel_value(format: TexelFormat, map: &DensityMap, texel: [u8; 4]) -> f32 {
    match format {
        TexelFormat::R16Unorm | TexelFormat::R32Float => map.decode(texel) as f32,
        TexelFormat::R8Unorm => f32::from(texel[0]) / 255.0,
        TexelFormat::R16Uint => f32::from(u16::from_le_bytes([texel[0], texel[1]])),
        TexelFormat::Rgba8Unorm => f32::from(texel[3]) / 255.0,
    }
}

/// Minima and maxima of a slot: of the whole, and of every cell over all taps that a sample inside it can meet (6³ texels).
/// NaN counts for nothing; an interval with min > max holds no number.
pub(super) fn summarise(format: TexelFormat, map: &DensityMap, slot: &[u8]) -> About {
    if let Some(first) = shared_texel(slot, format.bytes()) {
        let value = texel_value(format, map, first);
        let (min, max) = if value.is_nan() { (f32::INFINITY, f32::NEG_INFINITY) } else { (value, value) };
        return (BrickSummary { uniform: Some(first), min, max }, Cells::Uniform([min, max]));
    }
    let cells = ranges(format, map, slot, [(BRICK / CELL) as usize; 3]);
    debug_assert_eq!(cells.len(), CELLS_PER_BRICK);
    (whole(&cells), Cells::Dense(cells.into()))
}

/// What is known of a brick with cells `old` once the cells `met` have new texels: theirs, with a voxel of their neighbours
/// around. `None` if the minima and maxima alone do not tell that the brick has more than one value.
pub(super) fn renew(
    format: TexelFormat,
    map: &DensityMap,
    old: &[[f32; 2]],
    met: &Region,
    texels: &[u8],
) -> Option<About> {
    let mut cells = old.to_vec();
    let n = (BRICK / CELL) as usize;
    let size = met.size().map(|s| s as usize);
    let new = ranges(format, map, texels, size);
    for (i, row) in new.chunks_exact(size[0]).enumerate() {
        let [x, y, z] = met.lo.map(|v| v as usize);
        let at = x + n * (y + i % size[1] + n * (z + i / size[1]));
        cells[at..at + size[0]].copy_from_slice(row);
    }
    let about = whole(&cells);
    (about.min < about.max).then(|| (about, Cells::Dense(cells.into())))
}

/// The least and the greatest value of all cells.
fn whole(cells: &[[f32; 2]]) -> BrickSummary {
    let [min, max] = cells.iter().fold(NONE, fold);
    BrickSummary { uniform: None, min, max }
}

const NONE: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

fn fold(acc: [f32; 2], [lo, hi]: &[f32; 2]) -> [f32; 2] {
    [acc[0].min(*lo), acc[1].max(*hi)]
}

/// Minima and maxima of `n` cells along each axis, from their texels with one more on every side.
fn ranges(format: TexelFormat, map: &DensityMap, texels: &[u8], n: [usize; 3]) -> Vec<[f32; 2]> {
    // Codes rise with values, so integer formats are compared as they are and decoded once a cell.
    let density = |raw: f64| (map.lo + raw / map.codes_per_unit) as f32;
    let float = |t: &[u8]| f32::from_le_bytes([t[0], t[1], t[2], t[3]]);
    match format {
        TexelFormat::R16Unorm => extremes(&halves(texels), n, |raw| density(f64::from(raw))),
        TexelFormat::R16Uint => extremes(&halves(texels), n, f32::from),
        TexelFormat::R32Float => extremes(&each_texel::<4, _>(texels, float), n, |raw| density(f64::from(raw))),
        TexelFormat::R8Unorm => extremes(texels, n, |raw| f32::from(raw) / 255.0),
        TexelFormat::Rgba8Unorm => extremes(&each_texel::<4, _>(texels, |t| t[3]), n, |raw| f32::from(raw) / 255.0),
    }
}

fn each_texel<const N: usize, T>(texels: &[u8], read: impl Fn(&[u8]) -> T) -> Vec<T> {
    texels.chunks_exact(N).map(read).collect()
}

/// Texels of 16 bits, where they lie if they lie so that they can be read there.
fn halves(texels: &[u8]) -> Cow<'_, [u16]> {
    match bytemuck::try_cast_slice(texels) {
        Ok(halves) if cfg!(target_endian = "little") => Cow::Borrowed(halves),
        _ => Cow::Owned(each_texel::<2, _>(texels, |t| u16::from_le_bytes([t[0], t[1]]))),
    }
}

/// Numbers of which the least and the greatest are sought; NaN counts for nothing.
trait Ordered: Copy + PartialOrd {
    const LEAST: Self;
    const GREATEST: Self;
}

macro_rules! ordered {
    ($($number:ty: $least:expr, $greatest:expr;)*) => {
        $(impl Ordered for $number {
            const LEAST: Self = $least;
            const GREATEST: Self = $greatest;
        })*
    };
}
ordered! {
    u8: u8::MIN, u8::MAX;
    u16: u16::MIN, u16::MAX;
    f32: f32::NEG_INFINITY, f32::INFINITY;
}

/// Of a value that is not a number, what was there stays: comparing with it says no.
fn lower<T: Ordered>(least: &mut T, value: T) {
    *least = if value < *least { value } else { *least };
}

fn raise<T: Ordered>(greatest: &mut T, value: T) {
    *greatest = if value > *greatest { value } else { *greatest };
}

/// Least and greatest of each of `n` cells over 6 values along each axis at a stride of 4, decoded; [`NONE`] without a number.
fn extremes<T: Ordered>(values: &[T], n: [usize; 3], decode: impl Fn(T) -> f32) -> Vec<[f32; 2]> {
    // Separable. Whole planes against each other first and values within a row last: the first passes see the most values and
    // compare neighbours alike, many in one instruction.
    let [nx, ny, nz] = n;
    let [sx, sy, _] = n.map(|n| n * CELL as usize + 2);
    let reach = CELL as usize + 2;
    let mut cells = Vec::with_capacity(nx * ny * nz);
    let (mut plane_least, mut plane_greatest) = (vec![T::GREATEST; sx * sy], vec![T::LEAST; sx * sy]);
    let (mut row_least, mut row_greatest) = (vec![T::GREATEST; sx], vec![T::LEAST; sx]);
    for z in (0..nz).map(|cell| cell * CELL as usize) {
        plane_least.fill(T::GREATEST);
        plane_greatest.fill(T::LEAST);
        for plane in values[z * sx * sy..(z + reach) * sx * sy].chunks_exact(sx * sy) {
            plane_least.iter_mut().zip(plane).for_each(|(least, &v)| lower(least, v));
            plane_greatest.iter_mut().zip(plane).for_each(|(greatest, &v)| raise(greatest, v));
        }
        for y in (0..ny).map(|cell| cell * CELL as usize) {
            row_least.fill(T::GREATEST);
            row_greatest.fill(T::LEAST);
            let rows = y * sx..(y + reach) * sx;
            for row in plane_least[rows.clone()].chunks_exact(sx) {
                row_least.iter_mut().zip(row).for_each(|(least, &v)| lower(least, v));
            }
            for row in plane_greatest[rows].chunks_exact(sx) {
                row_greatest.iter_mut().zip(row).for_each(|(greatest, &v)| raise(greatest, v));
            }
            cells.extend((0..nx).map(|cell| {
                let taps = cell * CELL as usize..cell * CELL as usize + reach;
                let (mut least, mut greatest) = (T::GREATEST, T::LEAST);
                row_least[taps.clone()].iter().for_each(|&v| lower(&mut least, v));
                row_greatest[taps].iter().for_each(|&v| raise(&mut greatest, v));
                if least <= greatest { [decode(least), decode(greatest)] } else { NONE }
            }));
        }
    }
    cells
}

/// Writes the half-size version of `child` into its parent's texels from `octant` on, where it covers `part` of the child.
/// `valid` is how many texels of the child lie in the volume along each axis; `part` is within. Density and selection average, colours average weighted by alpha, labels take the most
/// frequent label that is not 0 (the lowest of equals) so that thin segments stay in sight.
pub(super) fn coarsen(
    format: TexelFormat,
    child: &Brick,
    valid: [u32; 3],
    part: &Region,
    octant: [u32; 3],
    parent: &mut [u8],
) {
    debug_assert_eq!(parent.len(), BRICK_VOXELS * format.bytes());
    let (part, to) = (part.halved(), octant.map(|o| o * (BRICK / 2)));
    match child {
        Brick::Uniform(value) => {
            let at = part.shifted(to);
            fill_box(&mean(format, &[*value])[..format.bytes()], parent, [BRICK; 3], at.lo, at.size());
        }
        Brick::Dense(texels) => match format.bytes() {
            _ if halve(format, texels, valid, &part, to, parent) => {}
            1 => means::<1>(format, texels, valid, &part, to, parent),
            2 => means::<2>(format, texels, valid, &part, to, parent),
            _ => means::<4>(format, texels, valid, &part, to, parent),
        },
    }
}

/// [`coarsen`] of numbers in codes whose voxels all have their eight children, which is nearly all of every edit; answers false, and
/// does nothing, for others.
fn halve(format: TexelFormat, child: &[u8], valid: [u32; 3], part: &Region, to: [u32; 3], parent: &mut [u8]) -> bool {
    if (0..3).any(|a| 2 * part.end[a] > valid[a]) {
        return false;
    }
    match format {
        TexelFormat::R8Unorm => averages(child, part, to, parent, |[code]| u32::from(code), |code| [code as u8]),
        TexelFormat::R16Unorm => {
            let read = |code| u32::from(u16::from_le_bytes(code));
            averages(child, part, to, parent, read, |code| (code as u16).to_le_bytes());
        }
        _ => return false,
    }
    true
}

fn averages<const N: usize>(
    child: &[u8],
    part: &Region,
    to: [u32; 3],
    parent: &mut [u8],
    read: impl Fn([u8; N]) -> u32,
    write: impl Fn(u32) -> [u8; N],
) {
    let row = |texels: [u32; 3]| (texels[0] + BRICK * (texels[1] + BRICK * texels[2])) as usize * N;
    let width = (part.end[0] - part.lo[0]) as usize * N;
    for z in part.lo[2]..part.end[2] {
        for y in part.lo[1]..part.end[1] {
            let beside = [[0, 0], [1, 0], [0, 1], [1, 1]];
            let rows = beside.map(|[dy, dz]| &child[row([2 * part.lo[0], 2 * y + dy, 2 * z + dz])..][..2 * width]);
            let start = row([to[0] + part.lo[0], to[1] + y, to[2] + z]);
            let (out, _) = parent[start..start + width].as_chunks_mut::<N>();
            let [a, b, c, d] = rows.map(|row| row.as_chunks::<N>().0.as_chunks::<2>().0);
            for ((((out, a), b), c), d) in out.iter_mut().zip(a).zip(b).zip(c).zip(d) {
                let pair = |texels: &[[u8; N]; 2]| read(texels[0]) + read(texels[1]);
                *out = write((pair(a) + pair(b) + pair(c) + pair(d) + 4) / 8);
            }
        }
    }
}

/// [`coarsen`] for texels of `N` bytes, `part` in voxels of the parent's level.
fn means<const N: usize>(
    format: TexelFormat,
    child: &[u8],
    valid: [u32; 3],
    part: &Region,
    to: [u32; 3],
    parent: &mut [u8],
) {
    for z in part.lo[2]..part.end[2] {
        for y in part.lo[1]..part.end[1] {
            for x in part.lo[0]..part.end[0] {
                let mut taps = [[0_u8; 4]; 8];
                let mut n = 0;
                for dz in 0..2.min(valid[2] - 2 * z) {
                    for dy in 0..2.min(valid[1] - 2 * y) {
                        for dx in 0..2.min(valid[0] - 2 * x) {
                            let from = (2 * x + dx + BRICK * (2 * y + dy + BRICK * (2 * z + dz))) as usize * N;
                            taps[n][..N].copy_from_slice(&child[from..from + N]);
                            n += 1;
                        }
                    }
                }
                let at = (to[0] + x + BRICK * (to[1] + y + BRICK * (to[2] + z))) as usize * N;
                parent[at..at + N].copy_from_slice(&mean(format, &taps[..n])[..N]);
            }
        }
    }
}

fn mean(format: TexelFormat, taps: &[[u8; 4]]) -> [u8; 4] {
    let n = taps.len() as u32;
    match format {
        TexelFormat::R8Unorm => {
            let sum: u32 = taps.iter().map(|t| u32::from(t[0])).sum();
            [((sum + n / 2) / n) as u8, 0, 0, 0]
        }
        TexelFormat::R16Unorm => {
            let sum: u32 = taps.iter().map(|t| u32::from(u16::from_le_bytes([t[0], t[1]]))).sum();
            let [a, b] = (((sum + n / 2) / n) as u16).to_le_bytes();
            [a, b, 0, 0]
        }
        TexelFormat::R32Float => {
            let numbers = || taps.iter().map(|&t| f32::from_le_bytes(t)).filter(|v| !v.is_nan());
            // One infinite voxel would be all of a picture from afar.
            let finite = numbers().filter(|v| v.is_finite());
            let (sum, count) = finite.fold((0.0_f64, 0_u32), |(s, c), v| (s + f64::from(v), c + 1));
            let value = if count == 0 { numbers().next().unwrap_or(f32::NAN) } else { (sum / f64::from(count)) as f32 };
            value.to_le_bytes()
        }
        TexelFormat::Rgba8Unorm => {
            let alpha: u32 = taps.iter().map(|t| u32::from(t[3])).sum();
            if alpha == 0 {
                return [0; 4];
            }
            if alike(taps) {
                return taps[0];
            }
            let channel = |i: usize| {
                let sum: u32 = taps.iter().map(|t| u32::from(t[i]) * u32::from(t[3])).sum();
                ((sum + alpha / 2) / alpha) as u8
            };
            [channel(0), channel(1), channel(2), ((alpha + n / 2) / n) as u8]
        }
        TexelFormat::R16Uint => {
            if alike(taps) {
                return taps[0];
            }
            let label = |t: &[u8; 4]| u16::from_le_bytes([t[0], t[1]]);
            let count = |id: u16| taps.iter().filter(|t| label(t) == id).count();
            let best =
                taps.iter().map(label).filter(|&id| id != 0).max_by_key(|&id| (count(id), std::cmp::Reverse(id)));
            let [a, b] = best.unwrap_or(0).to_le_bytes();
            [a, b, 0, 0]
        }
    }
}

fn alike(taps: &[[u8; 4]]) -> bool {
    taps.iter().all(|tap| *tap == taps[0])
}
