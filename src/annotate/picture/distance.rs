//! Signed distances to an outline on a grid of texels.
//!
//! A texel holds the distance of its centre to the nearest point of the outline's boundary, in texels, positive inside: the edge is 0, a
//! halo
//! is the same field at −width. Exact up to the spread, the sign everywhere (non-zero winding). Row 0 is the upper one. Knows no colour
//! and no coarser level.

use crate::annotate::picture::boundary::{boundary, sides_of};
use crate::annotate::picture::error::AnnotateError;
use crate::annotate::picture::outline::Outline;
use glam::DVec2;
use rayon::prelude::*;

/// The most texels on a side: what every GPU that Burin runs on has.
pub const MAX_SIDE: usize = 8192;

/// The most texels of a field.
pub const MAX_TEXELS: usize = 1 << 22;

/// Rows that are made at once, a multiple of BLOCK.
const BAND: usize = 16;

/// Texels on a side of the blocks that share a list of edges.
const BLOCK: usize = 4;

/// From a block's middle to the centre of its furthest texel.
const BLOCK_RADIUS: f64 = 0.5 * (BLOCK - 1) as f64 * std::f64::consts::SQRT_2;

/// Distances over a rectangle of square texels.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceField {
    /// Texels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// A texel's side, mm.
    pub texel_mm: f64,
    /// Distances are clamped to ± so many texels.
    pub spread: f64,
    /// Row by row from above, in texels, positive inside, the edge is 0.
    pub texels: Vec<f32>,
}

impl DistanceField {
    /// Of an outline in mm, y up; `corner` is the left upper corner of the first texel.
    ///
    /// # Errors
    /// If there would be no texel, more than [`MAX_SIDE`] on a side or [`MAX_TEXELS`] in all, or a length is not above 0.
    pub fn of(
        outline: &Outline,
        corner: DVec2,
        texel_mm: f64,
        [width, height]: [usize; 2],
        spread: f64,
    ) -> Result<Self, AnnotateError> {
        if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) || width * height > MAX_TEXELS {
            let expected = format!("1 to {MAX_SIDE} a side and at most {MAX_TEXELS} in all");
            return Err(AnnotateError::out("texels", format!("{width} × {height}"), expected));
        }
        if !(texel_mm > 0.0 && texel_mm.is_finite() && corner.is_finite()) {
            return Err(AnnotateError::out("texel_mm", texel_mm, "a length above 0"));
        }
        if !(1.0..=1024.0).contains(&spread) {
            return Err(AnnotateError::out("spread", spread, "1 to 1024 texels"));
        }
        // In texels from the corner, y down: a texel's centre is its number and a half.
        let to_texel = |p: DVec2| DVec2::new(p.x - corner.x, corner.y - p.y) / texel_mm;
        let edges: Vec<[DVec2; 2]> = boundary(outline).into_iter().map(|s| s.map(to_texel)).collect();
        let sides: Vec<[DVec2; 2]> = sides_of(outline).map(|s| s.map(to_texel)).collect();
        let mut texels = vec![0.0f32; width * height];
        texels.par_chunks_mut(width * BAND).enumerate().for_each(|(band, out)| {
            let rows = [band * BAND, band * BAND + out.len() / width];
            let square = nearest(&edges, rows, width, spread);
            let inside = insides(&sides, rows, width);
            for ((texel, square), inside) in out.iter_mut().zip(square).zip(inside) {
                let d = square.sqrt();
                *texel = if inside { d } else { -d } as f32;
            }
        });
        Ok(Self { width, height, texel_mm, spread, texels })
    }
}

/// Squared distances of texels to the nearest edge, at most the spread's.
///
/// An edge can be nearest to a texel of a block only if it is at most two of the block's radii further from its middle than the nearest one
/// is.
fn nearest(edges: &[[DVec2; 2]], rows: [usize; 2], width: usize, spread: f64) -> Vec<f64> {
    let (across, down) = (width.div_ceil(BLOCK), (rows[1] - rows[0]).div_ceil(BLOCK));
    let middle = |x: usize, y: usize| DVec2::new((x * BLOCK) as f64, (rows[0] + y * BLOCK) as f64) + 0.5 * BLOCK as f64;
    let reach = spread + BLOCK_RADIUS;
    let mut near: Vec<Vec<(f64, u32)>> = vec![Vec::new(); across * down];
    for (n, edge) in edges.iter().enumerate() {
        let to_block = |p: DVec2| (p - DVec2::new(0.0, rows[0] as f64)) / BLOCK as f64 - 0.5;
        let low = to_block(edge[0].min(edge[1]) - reach).ceil().max(DVec2::ZERO);
        let high = to_block(edge[0].max(edge[1]) + reach).floor().min(DVec2::new(across as f64, down as f64) - 1.0);
        if low.x > high.x || low.y > high.y {
            continue;
        }
        for y in low.y as usize..=high.y as usize {
            for x in low.x as usize..=high.x as usize {
                let d = square_to(edge, middle(x, y));
                if d <= reach * reach {
                    near[y * across + x].push((d, n as u32));
                }
            }
        }
    }
    let mut square = vec![spread * spread; (rows[1] - rows[0]) * width];
    for (block, near) in near.iter().enumerate() {
        let Some(least) = near.iter().map(|n| n.0).min_by(f64::total_cmp) else { continue };
        let most = (least.sqrt() + 2.0 * BLOCK_RADIUS + 1e-6).powi(2);
        let (left, top) = (block % across * BLOCK, block / across * BLOCK);
        for &(_, n) in near.iter().filter(|n| n.0 <= most) {
            for y in top..(top + BLOCK).min(rows[1] - rows[0]) {
                for x in left..(left + BLOCK).min(width) {
                    let p = DVec2::new(x as f64 + 0.5, (rows[0] + y) as f64 + 0.5);
                    let best = &mut square[y * width + x];
                    *best = best.min(square_to(&edges[n as usize], p));
                }
            }
        }
    }
    square
}

/// Squared distance of a point to a side.
fn square_to([a, b]: &[DVec2; 2], p: DVec2) -> f64 {
    let (along, to) = (b - a, p - a);
    let t = (to.dot(along) / along.length_squared()).clamp(0.0, 1.0);
    (to - t * along).length_squared()
}

/// Whether texels' centres have a winding number other than 0.
fn insides(sides: &[[DVec2; 2]], rows: [usize; 2], width: usize) -> Vec<bool> {
    let mut crossings: Vec<Vec<(f64, i32)>> = vec![Vec::new(); rows[1] - rows[0]];
    for [a, b] in sides {
        let (first, last) = ((a.y.min(b.y) - 0.5).ceil(), (a.y.max(b.y) - 0.5).ceil() - 1.0);
        let (first, last) = (first.max(rows[0] as f64), last.min(rows[1] as f64 - 1.0));
        if first > last {
            continue;
        }
        let way = if a.y < b.y { 1 } else { -1 };
        for y in first as usize..=last as usize {
            let t = (y as f64 + 0.5 - a.y) / (b.y - a.y);
            crossings[y - rows[0]].push((a.x + t * (b.x - a.x), way));
        }
    }
    let mut inside = Vec::with_capacity(width * crossings.len());
    for row in &mut crossings {
        row.sort_by(|p, q| p.0.total_cmp(&q.0));
        let (mut next, mut winding) = (0, 0);
        for x in 0..width {
            while next < row.len() && row[next].0 <= x as f64 + 0.5 {
                winding += row[next].1;
                next += 1;
            }
            inside.push(winding != 0);
        }
    }
    inside
}
