//! How a volume is shown when it is first seen: from where, in which colours, in which greys.
//!
//! Pictures of one or a few layers, and thin slabs, are looked at from their face, and pictures are drawn as such: opaque, in the
//! slices' greys, unlit. `transfer.reset` comes back here.

use crate::document::scene::{ViewLook, Window};
use crate::math::{Camera, DVec3};
use crate::volume::{Grid, Histogram, TransferFunction};

/// Layers of voxels that are still a picture.
const LAYERS: u32 = 4;
/// Times that a picture is wider than it is thick.
const FLAT: u32 = 8;
/// A slab is thinner than this share of its lesser side.
const THIN: f64 = 0.2;
/// Voxels that a volume is thick at least, or each of them shows more.
const THICK: f64 = 16.0;

/// A world axis, from which side views of slices across it look along it, and what is up in them.
const SIDES: [(DVec3, DVec3); 3] = [(DVec3::NEG_X, DVec3::Z), (DVec3::Y, DVec3::Z), (DVec3::NEG_Z, DVec3::Y)];

/// The colours and opacities that a volume begins with.
pub(crate) fn transfer(grid: &Grid, histogram: &Histogram) -> TransferFunction {
    let voxel = grid.voxel_mm();
    if is_picture(grid) {
        let mut transfer = TransferFunction::from_histogram(histogram, voxel);
        if histogram.ids.is_empty() {
            let Window { level, width } = Window::from_histogram(histogram);
            let half = 0.5 * width;
            transfer.colour = vec![(level - half, [0.0; 3]), (level + half, [1.0; 3])];
            transfer.opacity = vec![(level, 1.0)];
        } else {
            transfer.opacity.iter_mut().for_each(|p| p.1 = if p.1 > 0.0 { 1.0 } else { 0.0 });
        }
        return transfer;
    }
    let thickness = (grid.dims_f64() * grid.spacing()).min_element();
    // Matter of one value is seen by how much of it there is.
    let unit_mm = if histogram.constant().is_some() { thickness * 0.5 } else { voxel.min(thickness / THICK) };
    TransferFunction::from_histogram(histogram, unit_mm)
}

/// Strength of labels per voxel: what lies at their border, where the nearest voxel has no label yet, hides no colour.
const LABELS: f32 = 0.5;
/// Under the colours of segments.
const PALE: [f32; 3] = [0.95; 3];

/// The opacities that the labels of a map begin with, whose segments have the colours: every id is as opaque as every other one, since
/// values between two of them mean nothing.
pub(crate) fn of_labels(grid: &Grid, histogram: &Histogram) -> TransferFunction {
    let first = histogram.ids.iter().copied().find(|id| *id > 0.0).unwrap_or(1.0);
    TransferFunction {
        colour: vec![(first, PALE)],
        opacity: vec![(0.0, 0.0), (first, LABELS)],
        unit_mm: grid.voxel_mm(),
    }
}

/// How the 3D view begins: a slab of few layers has its gradients along its face, and light would come from aside.
pub(crate) fn look(grid: &Grid) -> ViewLook {
    let look = ViewLook::default();
    let thin = slab(grid).is_some_and(|axis| f64::from(grid.dims[axis]) < THICK);
    if is_picture(grid) || thin { ViewLook { lighting: None, ..look } } else { look }
}

/// The first view of a volume: from the front, a slab from its face, as the slices show it.
pub(crate) fn camera(grid: &Grid) -> Camera {
    let (side, up) = match (slab(grid), rod(grid)) {
        (Some(axis), _) => {
            let other = |n: usize| grid.world_from_index.matrix3.col((axis + n) % 3).normalize_or_zero();
            let normal = other(1).cross(other(2)).normalize_or(DVec3::Y);
            let (side, up) = SIDES[nearest(normal)];
            (if normal.dot(side) < 0.0 { -normal } else { normal }, up)
        }
        // What lies along the line of sight would be seen from its end.
        (None, Some(axis)) if nearest(grid.world_from_index.matrix3.col(axis)) == 1 => SIDES[0],
        _ => SIDES[1],
    };
    Camera::framing(&grid.world_bounds(), side, up)
}

/// The world axis nearest to a direction.
fn nearest(direction: DVec3) -> usize {
    let d = direction.abs();
    if d.y >= d.x && d.y >= d.z { 1 } else { usize::from(d.z > d.x) * 2 }
}

/// Whether a volume is a picture: a few layers of voxels.
fn is_picture(grid: &Grid) -> bool {
    let mut dims = grid.dims;
    dims.sort_unstable();
    dims[0] <= LAYERS && dims[1] >= FLAT * dims[0]
}

/// The axes by their length in mm, the shortest first.
fn by_length(grid: &Grid) -> [(usize, f64); 3] {
    let lengths = grid.dims_f64() * grid.spacing();
    let mut axes = [0, 1, 2].map(|a| (a, lengths[a]));
    axes.sort_by(|a, b| a.1.total_cmp(&b.1));
    axes
}

/// The voxel axis across a picture or a thin slab.
fn slab(grid: &Grid) -> Option<usize> {
    if is_picture(grid) {
        return (0..3).min_by_key(|&a| grid.dims[a]);
    }
    let [(axis, least), (_, middle), _] = by_length(grid);
    (least < THIN * middle).then_some(axis)
}

/// The voxel axis along a rod.
fn rod(grid: &Grid) -> Option<usize> {
    let [_, (_, middle), (axis, most)] = by_length(grid);
    (middle < THIN * most).then_some(axis)
}

impl Window {
    /// From the thousandth of the values to the last hundredths of those that are not background, so that neither air nor a few
    /// bright voxels take greys from the rest. A CT shows its soft tissue, of a label map all ids have a grey, of
    /// one value alone it is the middle grey.
    pub fn from_histogram(histogram: &Histogram) -> Self {
        let bins = histogram.bins.len();
        let value = |at: f64| histogram.value_at(at);
        let kind = (&histogram.ids[..], histogram.constant(), histogram.classes());
        let ends = match kind {
            ([first, .., last], ..) => [*first, *last],
            (_, Some(only), _) => {
                let half = only.abs().clamp(1.0, 1e300);
                [only.clamp(-1e300, 1e300) - half, only.clamp(-1e300, 1e300) + half]
            }
            (_, _, Some(classes)) => {
                let white = value(histogram.share_below(classes.upper..bins, 0.995));
                if histogram.is_hounsfield() {
                    [-160.0, white.clamp(240.0, 440.0)]
                } else {
                    [value(histogram.share_below(0..bins, 0.001)), white]
                }
            }
            _ => [histogram.min, histogram.max],
        };
        let [black, white] = ends.map(|end| if end.is_finite() { end } else { 0.0 });
        let width = (white * 0.5 - black * 0.5) * 2.0;
        let least = histogram.bin_width().max(black.abs() * 1e-6);
        let width = if width.is_finite() { width } else { f64::MAX * 0.5 };
        let width = if width > 0.0 { width.max(least) } else { least.max(1.0) };
        let level = black * 0.5 + white * 0.5;
        // What was measured is as good as its sample: no more digits than tell a hundredth of the window.
        match kind {
            ([], None, Some(_)) => Self { level, width }.rounded(),
            _ => Self { level, width },
        }
    }

    /// The same with no more digits than tell a hundredth of its width; whole numbers keep all of theirs.
    pub fn rounded(self) -> Self {
        Self { level: to_digits(self.level, self.width), width: to_digits(self.width, self.width) }
    }
}

/// A number to the digits that tell a hundredth of `span`.
fn to_digits(number: f64, span: f64) -> f64 {
    let decimals = (2.0 - span.log10().floor()).max(0.0);
    // Doubles end before 330 decimals: spans smaller than that are not rounded.
    if decimals > 300.0 { number } else { format!("{number:.0$}", decimals as usize).parse().unwrap_or(number) }
}
