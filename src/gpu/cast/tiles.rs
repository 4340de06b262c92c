//! Which bodies show in which tile of the picture, in order of sight.
//!
//! Owns the lists of 8×8-pixel tiles: silhouettes of convex solids laid over the tiles, conservatively, so that a ray finds
//! the few bodies it can meet without asking all of them. Tiles that hold a pair without an order are marked.

use crate::gpu::cast::order::Order;
use crate::gpu::cast::solid::Polyhedron;
use crate::gpu::device::constants::{MERGE_MARK, TILE};
use crate::math::{Camera, DVec2};

/// Pixels by which silhouettes are widened, for the GPU's narrower numbers.
const MARGIN: f64 = 0.02;

/// A rectangle of a picture that is drawn: all of it, or less. Pixel (0, 0) of the rectangle lies at `origin`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Size of the whole picture in pixels.
    pub picture: [u32; 2],
    /// Top-left corner in pixels of the picture, not necessarily whole.
    pub origin: DVec2,
    /// Size of the rectangle in pixels.
    pub size: [u32; 2],
    /// Nothing is drawn but tiles that hold pixels of the rectangle from the first of these on and before the second.
    pub only: Option<[[u32; 2]; 2]>,
}

impl Window {
    /// Whether a tile is drawn, by its number in rows of so many.
    fn draws(&self, tile: u32, across: u32) -> bool {
        let first = [tile % across, tile / across].map(|t| t * TILE);
        self.only.is_none_or(|[lo, hi]| (0..2).all(|a| first[a] + TILE > lo[a] && first[a] < hi[a]))
    }

    /// The whole picture.
    pub fn whole(picture: [u32; 2]) -> Self {
        Self { picture, origin: DVec2::ZERO, size: picture, only: None }
    }
}

/// The lists.
#[derive(Debug, PartialEq)]
pub struct Tiles {
    /// Tiles along x and y.
    pub dims: [u32; 2],
    /// Per tile, x fastest: first entry in `lists`, and count with [`MERGE_MARK`] where intervals must be merged.
    pub heads: Vec<[u32; 2]>,
    /// Indices of solids, nearest first.
    pub lists: Vec<u32>,
    /// The longest list of a tile whose bodies follow one another.
    pub longest_ordered: usize,
    /// The longest list of a tile whose bodies must be merged.
    pub longest_merged: usize,
}

impl Tiles {
    /// Lists for solids in world mm.
    pub fn of(solids: &[Polyhedron], order: &Order, camera: &Camera, window: &Window) -> Self {
        let dims = window.size.map(|s| s.div_ceil(TILE));
        let mut per_tile: Vec<Vec<u32>> = vec![Vec::new(); (dims[0] * dims[1]) as usize];
        for &solid in &order.sequence {
            for (y, span) in spans(&solids[solid], camera, window, dims).into_iter().enumerate() {
                let Some((first, last)) = span else { continue };
                let row = y * dims[0] as usize;
                for list in &mut per_tile[row + first as usize..=row + last as usize] {
                    list.push(solid as u32);
                }
            }
        }
        let mut tiles = Self { dims, heads: Vec::new(), lists: Vec::new(), longest_ordered: 0, longest_merged: 0 };
        for list in per_tile {
            let clash = (1..list.len()).any(|i| list[..i].iter().any(|&a| order.clash(a as usize, list[i] as usize)));
            let longest = if clash { &mut tiles.longest_merged } else { &mut tiles.longest_ordered };
            *longest = (*longest).max(list.len());
            let mark = if clash { MERGE_MARK } else { 0 };
            // How long lists are says what pictures are compiled for: that is asked of all tiles, drawn or not.
            let drawn = window.draws(tiles.heads.len() as u32, dims[0]);
            let count = if drawn { list.len() as u32 | mark } else { 0 };
            tiles.heads.push([tiles.lists.len() as u32, count]);
            tiles.lists.extend(list);
        }
        tiles
    }

    /// Columns, and rows in the upper 16 bits, of the tiles that hold bodies and whose mark `wanted` asks for.
    pub fn places(&self, wanted: impl Fn(bool) -> bool) -> Vec<u32> {
        let heads = (0_u32..).zip(&self.heads);
        let held = heads.filter(|(_, [_, count])| count & !MERGE_MARK > 0 && wanted(count & MERGE_MARK != 0));
        held.map(|(i, _)| (i % self.dims[0]) | ((i / self.dims[0]) << 16)).collect()
    }

    /// Rectangles of pixels, left, top, right and bottom, that together are the tiles that hold bodies and whose mark `wanted`
    /// asks for, within a target's size.
    pub fn areas(&self, [width, height]: [u32; 2], wanted: impl Fn(bool) -> bool) -> Vec<[u32; 4]> {
        let holds = |&[_, count]: &[u32; 2]| count & !MERGE_MARK > 0 && wanted(count & MERGE_MARK != 0);
        let mut areas: Vec<[u32; 4]> = Vec::new();
        // Those that reach down to this row, and may go on.
        let mut above: Vec<usize> = Vec::new();
        for (y, heads) in (0..).zip(self.heads.chunks_exact((self.dims[0] as usize).max(1))) {
            let (top, bottom) = (y * TILE, ((y + 1) * TILE).min(height));
            let mut here = Vec::new();
            let mut x = 0;
            for run in heads.chunk_by(|a, b| holds(a) == holds(b)) {
                let (left, right) = (x * TILE, ((x + run.len() as u32) * TILE).min(width));
                x += run.len() as u32;
                if !holds(&run[0]) {
                    continue;
                }
                let same = |&&i: &&usize| [areas[i][0], areas[i][2]] == [left, right];
                let area = above.iter().find(same).copied().unwrap_or(areas.len());
                match areas.get_mut(area) {
                    Some(area) => area[3] = bottom,
                    None => areas.push([left, top, right, bottom]),
                }
                here.push(area);
            }
            above = here;
        }
        areas
    }
}

/// The tiles that a solid's silhouette meets: per row of tiles the first and the last column.
pub(crate) fn spans(solid: &Polyhedron, camera: &Camera, window: &Window, dims: [u32; 2]) -> Vec<Option<(u32, u32)>> {
    let projected: Option<Vec<DVec2>> =
        solid.corners().iter().map(|&p| camera.project(p, window.picture).map(|(px, _)| px - window.origin)).collect();
    // A corner at or behind the eye: its silhouette has no outline, so it may show anywhere.
    let Some(points) = projected else { return vec![Some((0, dims[0].saturating_sub(1))); dims[1] as usize] };
    let outline = hull(points);
    let tile = f64::from(TILE);
    (0..dims[1])
        .map(|y| {
            let (top, bottom) = (f64::from(y) * tile - MARGIN, f64::from(y + 1) * tile + MARGIN);
            let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
            for (i, &a) in outline.iter().enumerate() {
                let b = outline[(i + 1) % outline.len()];
                let (upper, lower) = if a.y <= b.y { (a, b) } else { (b, a) };
                if lower.y < top || upper.y > bottom {
                    continue;
                }
                let along = |y: f64| {
                    let t = if lower.y > upper.y { (y - upper.y) / (lower.y - upper.y) } else { 0.0 };
                    upper.x + (lower.x - upper.x) * t.clamp(0.0, 1.0)
                };
                let ends = if lower.y > upper.y { [along(top), along(bottom)] } else { [upper.x, lower.x] };
                lo = lo.min(ends[0]).min(ends[1]);
                hi = hi.max(ends[0]).max(ends[1]);
            }
            let first = ((lo - MARGIN) / tile).floor();
            let last = ((hi + MARGIN) / tile).floor();
            let end = f64::from(dims[0]) - 1.0;
            (last >= 0.0 && first <= end).then(|| (first.max(0.0) as u32, last.min(end) as u32))
        })
        .collect()
}

/// Outline of the points' convex hull (Andrew's monotone chain).
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut outline: Vec<DVec2> = Vec::with_capacity(points.len() + 1);
    for pass in 0..2 {
        let start = outline.len();
        for &p in &points {
            while outline.len() >= start + 2 {
                let (a, b) = (outline[outline.len() - 2], outline[outline.len() - 1]);
                if (b - a).perp_dot(p - a) > 0.0 {
                    break;
                }
                outline.pop();
            }
            outline.push(p);
        }
        outline.pop();
        if pass == 0 {
            points.reverse();
        }
    }
    outline
}
