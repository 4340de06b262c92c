//! Finer samples of a block of numbers: per axis which voxels a sample is made of, and the tensor product over all three.
//!
//! The spline is that of "Direct Volume Editing" (2008), 4.1: at x about voxel i = ⌊x + ½⌋, p = x − i + ½, the quadratic Bézier curve
//! of ½(v_{i−1} + v_i), v_i, ½(v_i + v_{i+1}). Near a face of the box it is blended with linear interpolation, whose share goes
//! from 1 on the face to 0 half a voxel away (the least of all axes), so that the samples go on from what lies outside.

/// Numbers of the parent, x fastest.
pub(super) struct Block {
    pub size: [u32; 3],
    pub values: Vec<f64>,
}

/// Half a voxel: the band in which samples go over to what lies outside the box.
const BAND: f64 = 0.5;

/// A sample along one axis: places in the block.
#[derive(Clone, Copy)]
struct Tap {
    /// Of the voxels before, at and after the nearest one.
    spline: [usize; 3],
    weights: [f64; 3],
    linear: [(usize, f64); 2],
    /// How much of the spline there is as far as this axis goes.
    inside: f64,
}

/// The samples along one axis.
pub(super) struct Axis {
    first: u32,
    count: u32,
    taps: Vec<Tap>,
}

impl Axis {
    /// Samples at places in voxels of a parent of `dims` along the axis, in order; the box goes from face to face. `finer`: by splines; else
    /// linear, which copies voxels.
    pub(super) fn new(places: impl Iterator<Item = f64>, faces: [f64; 2], dims: u32, finer: bool) -> Self {
        let places: Vec<f64> = places.collect();
        let most = f64::from(dims - 1);
        let held = |i: f64| i.clamp(0.0, most);
        let (least, last) = (places.first().copied().unwrap_or(0.0), places.last().copied().unwrap_or(0.0));
        let first = held((least + 0.5).floor() - 1.0);
        let end = held((last + 0.5).floor() + 1.0);
        let at = |i: f64| (held(i) - first) as usize;
        let tap = |&x: &f64| {
            let below = x.floor();
            let share = x - below;
            let inside = ((x - faces[0]).min(faces[1] - x) / BAND).clamp(0.0, 1.0);
            let linear = [(at(below), 1.0 - share), (at(below + 1.0), share)];
            if !finer {
                let [a, b] = linear;
                return Tap { spline: [a.0, a.0, b.0], weights: [0.0, a.1, b.1], linear, inside };
            }
            let i = (x + 0.5).floor();
            let p = x - i + 0.5;
            let (before, after) = (0.5 * (1.0 - p) * (1.0 - p), 0.5 * p * p);
            Tap {
                spline: [at(i - 1.0), at(i), at(i + 1.0)],
                weights: [before, 1.0 - before - after, after],
                linear,
                inside,
            }
        };
        Self { first: first as u32, count: (end - first) as u32 + 1, taps: places.iter().map(tap).collect() }
    }

    /// The first voxel that any sample asks for.
    pub(super) fn first(&self) -> u32 {
        self.first
    }

    /// How many.
    pub(super) fn count(&self) -> u32 {
        self.count
    }

    /// The place in the block of the voxel that a sample lies in.
    pub(super) fn nearest(&self, sample: usize) -> usize {
        let [a, b] = self.taps[sample].linear;
        if b.1 >= 0.5 { b.0 } else { a.0 }
    }

    /// Places in the block that samples `from` to `to` are made of.
    pub(super) fn reach(&self, from: u32, to: u32) -> [usize; 2] {
        let taps = &self.taps[from as usize..=to as usize];
        let all = || taps.iter().flat_map(|t| t.spline.into_iter().chain(t.linear.map(|l| l.0)));
        [all().min().unwrap_or(0), all().max().unwrap_or(0)]
    }
}

/// A row or an element as a weighted sum of three; a lone weight is a copy, so that what has no number elsewhere does no harm.
fn weigh(weights: [f64; 3], from: [&[f64]; 3], out: &mut Vec<f64>) {
    let [w0, w1, w2] = weights;
    match (w0 == 0.0, w2 == 0.0) {
        (true, true) => out.extend_from_slice(from[1]),
        (true, false) if w1 == 0.0 => out.extend_from_slice(from[2]),
        (true, false) => out.extend(from[1].iter().zip(from[2]).map(|(b, c)| w1 * b + w2 * c)),
        (false, true) => out.extend(from[0].iter().zip(from[1]).map(|(a, b)| w0 * a + w1 * b)),
        (false, false) => {
            let rows = from[0].iter().zip(from[1]).zip(from[2]);
            out.extend(rows.map(|((a, b), c)| w0 * a + w1 * b + w2 * c));
        }
    }
}

/// The samples of three axes, x fastest, blended with linear ones near the faces.
pub(super) fn quasi_interpolate(block: &Block, axes: &[Axis; 3]) -> Vec<f64> {
    let mut out = interpolate(block, axes);
    blend_at_faces(block, axes, &mut out);
    out
}

/// The samples of three axes, x fastest.
pub(super) fn interpolate(block: &Block, axes: &[Axis; 3]) -> Vec<f64> {
    let [nx, ny, nz] = block.size.map(|s| s as usize);
    let [sx, sy, sz] = axes.each_ref().map(|a| a.taps.len());
    // Along x first, where there are few rows; what follows goes row by row, many numbers in one instruction.
    let mut along_x = Vec::with_capacity(sx * ny * nz);
    for row in block.values.chunks_exact(nx) {
        for tap in &axes[0].taps {
            let [a, b, c] = tap.spline;
            weigh(tap.weights, [&row[a..=a], &row[b..=b], &row[c..=c]], &mut along_x);
        }
    }
    let mut along_y = Vec::with_capacity(sx * sy * nz);
    for plane in along_x.chunks_exact(sx * ny) {
        for tap in &axes[1].taps {
            weigh(tap.weights, tap.spline.map(|i| &plane[i * sx..(i + 1) * sx]), &mut along_y);
        }
    }
    let mut out = Vec::with_capacity(sx * sy * sz);
    let plane = sx * sy;
    for tap in &axes[2].taps {
        weigh(tap.weights, tap.spline.map(|i| &along_y[i * plane..(i + 1) * plane]), &mut out);
    }
    out
}

/// In the band lets linear interpolation take its share.
fn blend_at_faces(block: &Block, axes: &[Axis; 3], out: &mut [f64]) {
    let [nx, ny] = [block.size[0] as usize, block.size[1] as usize];
    let sx = axes[0].taps.len();
    let linear = |x: &Tap, y: &Tap, z: &Tap| {
        let mut sum = 0.0;
        for (k, wz) in z.linear {
            for (j, wy) in y.linear {
                for (i, wx) in x.linear {
                    let weight = wx * wy * wz;
                    if weight != 0.0 {
                        sum += weight * block.values[i + nx * (j + ny * k)];
                    }
                }
            }
        }
        sum
    };
    let band = |taps: &[Tap]| taps.iter().take_while(|t| t.inside < 1.0).count();
    let before = band(&axes[0].taps);
    let after = axes[0].taps.iter().rev().take_while(|t| t.inside < 1.0).count().min(sx - before);
    let mut rows = out.chunks_exact_mut(sx);
    for z in &axes[2].taps {
        for y in &axes[1].taps {
            let Some(row) = rows.next() else { return };
            let across = y.inside.min(z.inside);
            let mut blend = |at: usize| {
                let x = &axes[0].taps[at];
                let inside = across.min(x.inside);
                if inside < 1.0 {
                    let own = linear(x, y, z);
                    row[at] = if inside == 0.0 { own } else { own + inside * (row[at] - own) };
                }
            };
            if across < 1.0 {
                (0..sx).for_each(blend);
            } else {
                (0..before).for_each(&mut blend);
                (sx - after..sx).for_each(&mut blend);
            }
        }
    }
}
