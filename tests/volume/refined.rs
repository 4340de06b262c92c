//! Boxes of a volume at a finer resolution: samples by the equations of "Direct Volume Editing" (2008), 4.1, one at a time.

use crate::common::volumes::{each, unit_grid};
use burin::volume::*;
use std::sync::Arc;

/// A volume of floats.
fn volume(dims: [u32; 3], f: impl Fn([f64; 3]) -> f64) -> Arc<Volume> {
    let grid = unit_grid(dims);
    let values = each(dims, |v| f(v.map(f64::from)) as f32);
    let source = Arc::new(MemorySource::new("made", grid, Voxels::F32(values), (1.0, 0.0)).unwrap());
    let (statistics, histogram) = (Statistics { min: 0.0, max: 1.0, ..Statistics::default() }, Histogram::default());
    Arc::new(Volume::new(source, DensityMap::FLOAT, statistics, histogram, &|_| true).unwrap().unwrap())
}

fn all(volume: &Volume) -> Vec<f64> {
    let mut out = Vec::new();
    volume.density.values([0; 3], volume.grid().dims).unwrap().each(|_, number| out.push(number.to_f64()));
    out
}

/// The share of the spline: 0 on a face of the box, 1 from half a voxel inside on.
fn inside(of: &SubBox, x: [f64; 3]) -> f64 {
    let off = |a: usize| (x[a] - f64::from(of.lo[a])).min(f64::from(of.hi[a]) - x[a]);
    (2.0 * off(0).min(off(1)).min(off(2))).clamp(0.0, 1.0)
}

/// De Casteljau on ½(v₋ + v), v, ½(v + v₊) along one axis after another, and linear interpolation, blended.
fn by_the_book(of: &SubBox, v: &dyn Fn([i64; 3]) -> f64, x: [f64; 3]) -> f64 {
    fn spline(f: &dyn Fn(i64) -> f64, x: f64, finer: bool) -> f64 {
        if !finer {
            return f(x.round() as i64);
        }
        let i = (x + 0.5).floor();
        let p = 0.5 + x - i;
        let mid = f(i as i64);
        let (a, b) = (0.5 * (f(i as i64 - 1) + mid), 0.5 * (mid + f(i as i64 + 1)));
        let (l, r) = (a + p * (mid - a), mid + p * (b - mid));
        l + p * (r - l)
    }
    fn line(f: &dyn Fn(i64) -> f64, x: f64) -> f64 {
        let i = x.floor();
        let (a, t) = (f(i as i64), x - i);
        if t == 0.0 { a } else { a + t * (f(i as i64 + 1) - a) }
    }
    let finer = of.scale.map(|s| s > 1);
    let smooth = spline(&|k| spline(&|j| spline(&|i| v([i, j, k]), x[0], finer[0]), x[1], finer[1]), x[2], finer[2]);
    let straight = line(&|k| line(&|j| line(&|i| v([i, j, k]), x[0]), x[1]), x[2]);
    straight + inside(of, x) * (smooth - straight)
}

fn place(of: &SubBox, sample: [u32; 3]) -> [f64; 3] {
    std::array::from_fn(|a| f64::from(of.lo[a]) + f64::from(sample[a]) / f64::from(of.scale[a]))
}

#[test]
fn samples_are_the_quadratic_quasi_interpolant_and_linear_at_the_faces() {
    let dims = [9, 8, 7];
    let rough = |v: [f64; 3]| ((v[0] * 12.9898 + v[1] * 78.233 + v[2] * 37.719).sin() * 43_758.545).fract();
    let parent = volume(dims, rough);
    let clamped = |v: [i64; 3]| {
        let c: [f64; 3] = std::array::from_fn(|a| v[a].clamp(0, i64::from(dims[a]) - 1) as f64);
        f64::from(rough(c) as f32)
    };
    for scale in [[1, 1, 1], [2, 2, 2], [3, 1, 8], [8, 5, 4]] {
        for (lo, hi) in [([2, 1, 2], [6, 5, 5]), ([0, 0, 0], [8, 7, 6])] {
            let of = SubBox { lo, hi, scale };
            let found = all(&Volume::refined(&parent, of));
            let expected = each(of.dims(), |s| by_the_book(&of, &clamped, place(&of, s)));
            for ((found, expected), at) in found.iter().zip(&expected).zip(each(of.dims(), |s| s)) {
                assert!((found - expected).abs() < 1e-6, "{of:?} at {at:?}: {found}, {expected} expected");
            }
        }
    }
}

#[test]
fn degree_one_and_mixed_terms_come_back_and_squares_a_quarter_higher() {
    let dims = [12; 3];
    let of = SubBox { lo: [2; 3], hi: [9; 3], scale: [4; 3] };
    let compare = |f: &dyn Fn([f64; 3]) -> f64, above: f64, what: &str| {
        let found = all(&Volume::refined(&volume(dims, f), of));
        for (found, at) in found.iter().zip(each(of.dims(), |s| place(&of, s))) {
            if inside(&of, at) == 1.0 {
                assert!((found - f(at) - above).abs() < 1e-4, "{what} at {at:?}: {found}");
            }
        }
    };
    compare(&|[x, y, z]| 3.0 * x - 2.0 * y + 0.5 * z + 1.0, 0.0, "degree 1");
    compare(&|[x, y, _]| x * y, 0.0, "xy");
    compare(&|[x, ..]| x * x, 0.25, "x²");
    compare(&|[x, y, z]| x * x + y * y + z * z, 0.75, "x² + y² + z²");
}

#[test]
fn a_box_that_divides_nothing_is_a_copy_of_all_fields_and_others_are_interpolated() {
    let dims = [40, 12, 10];
    let mut parent = (*volume(dims, |[x, y, z]| x * 3.0 + y * y - z)).clone();
    let texel = |kind: FieldKind, [x, y, z]: [u32; 3]| -> Vec<u8> {
        match kind {
            FieldKind::Labels => ((x / 3 + y + z) as u16 % 5).to_le_bytes().to_vec(),
            FieldKind::Selection => vec![(x * 6 + y) as u8],
            _ => vec![(x * 5) as u8, (y * 20) as u8, (z * 9) as u8, 255 - (x * 4) as u8],
        }
    };
    for kind in [FieldKind::Colour, FieldKind::Selection, FieldKind::Labels] {
        let field = parent.field_mut(kind);
        let changes = field.brick_indices(0).into_iter().map(|index| {
            let o = index.origin();
            let texels = each([BRICK; 3], |v| texel(kind, std::array::from_fn(|a| o[a] + v[a])));
            (index, Some(Brick::from_texels(texels.concat(), field.format().bytes())))
        });
        let changes = changes.collect();
        field.swap(changes).unwrap();
    }
    let parent = Arc::new(parent);
    let (lo, hi) = ([3, 1, 2], [38, 9, 8]);
    let copy = Volume::refined(&parent, SubBox { lo, hi, scale: [1; 3] });
    for kind in FieldKind::ALL {
        let of_parent = parent.field(kind).read(0, lo.map(i64::from), copy.grid().dims).unwrap();
        let of_copy = copy.field(kind).read(0, [0; 3], copy.grid().dims).unwrap();
        assert!(of_copy == of_parent, "{}", kind.name());
        assert!(copy.field(kind).edits().is_empty() && !copy.field(kind).is_blank());
    }
    let of = SubBox { lo, hi, scale: [2, 4, 1] };
    let fine = Volume::refined(&parent, of);
    for at in each(of.dims(), |s| s).into_iter().step_by(7) {
        let x = place(&of, at);
        let near = std::array::from_fn(|a| (x[a] + 0.5).floor() as u32);
        assert_eq!(fine.labels.texel(at).unwrap()[..2], texel(FieldKind::Labels, near)[..], "label at {x:?}");
        let colour = fine.colour.texel(at).unwrap();
        for (channel, &found) in colour.iter().enumerate() {
            let linear = (0..8).map(|corner| {
                let mut weight = 1.0;
                let tap = std::array::from_fn(|a| {
                    let (below, t) = (x[a].floor(), x[a].fract());
                    let up = corner >> a & 1 == 1;
                    weight *= if up { t } else { 1.0 - t };
                    (below as u32 + u32::from(up)).min(dims[a] - 1)
                });
                weight * f64::from(texel(FieldKind::Colour, tap)[channel])
            });
            let expected: f64 = linear.sum();
            assert!((f64::from(found) - expected).abs() <= 0.501, "colour {channel} at {x:?}");
        }
    }
}

#[test]
fn what_is_known_of_bricks_without_their_samples_bounds_them_at_every_level() {
    let parent = volume([20, 18, 16], |[x, y, z]| if x > 9.0 { (x * 0.7 + y).sin() * 50.0 + z } else { 7.0 });
    let fine = Volume::refined(&parent, SubBox { lo: [1, 2, 0], hi: [18, 16, 15], scale: [5, 8, 4] });
    let density = &fine.density;
    let mut uniform = 0;
    for level in 0..density.level_count() {
        for index in density.brick_indices(level) {
            let key = BrickKey { level, index };
            let (summary, slot) = (density.summary(key), density.slot(key).unwrap());
            let values: Vec<f32> = slot.chunks_exact(4).map(|t| f32::from_le_bytes([t[0], t[1], t[2], t[3]])).collect();
            assert!(values.iter().all(|v| (summary.min..=summary.max).contains(v)), "{key:?}: {summary:?}");
            if let Some(shared) = summary.uniform {
                uniform += 1;
                assert!(slot.chunks_exact(4).all(|t| t == shared), "{key:?}");
            }
            let Cells::Dense(cells) = density.cells(key) else { continue };
            for (i, cell) in cells.iter().enumerate() {
                let at: [usize; 3] = [i % 8 * 4, i / 8 % 8 * 4, i / 64 * 4];
                for v in each([6; 3], |v| v) {
                    let [x, y, z]: [usize; 3] = std::array::from_fn(|a| at[a] + v[a] as usize);
                    let value = values[x + 34 * (y + 34 * z)];
                    assert!((cell[0]..=cell[1]).contains(&value), "{key:?} cell {i}: {value} not in {cell:?}");
                }
            }
        }
    }
    assert!(uniform > 0, "bricks of one value are known for that");
}

#[test]
fn edits_go_along_where_faces_move_and_samples_are_divided_otherwise() {
    let parent = volume([24; 3], |[x, y, z]| x + 2.0 * y + 3.0 * z);
    let of = SubBox { lo: [6; 3], hi: [16; 3], scale: [4; 3] };
    let mut old = Volume::refined(&parent, of);
    // A ball of 100 more about the middle, and a label there.
    let distance = |at: [u32; 3]| {
        let x = place(&of, at);
        (0..3).map(|a| (x[a] - 11.0).powi(2)).sum::<f64>().sqrt()
    };
    let base = old.density.clone();
    let (mut ball, mut labels) = (Vec::new(), Vec::new());
    for index in base.brick_indices(0) {
        let mut texels = base.base_brick(index).unwrap().to_texels(4);
        let mut label = vec![0_u8; BRICK_VOXELS * 2];
        let valid = base.valid(0, index);
        for at in each([BRICK; 3], |v| v).into_iter().filter(|at| (0..3).all(|a| at[a] < valid[a])) {
            let i = (at[0] + BRICK * (at[1] + BRICK * at[2])) as usize;
            if distance(std::array::from_fn(|a| index.origin()[a] + at[a])) <= 3.0 {
                let value = f32::from_le_bytes(texels[i * 4..i * 4 + 4].try_into().unwrap()) + 100.0;
                texels[i * 4..i * 4 + 4].copy_from_slice(&value.to_le_bytes());
                label[i * 2] = 9;
            }
        }
        ball.push((index, Some(Brick::from_texels(texels, 4))));
        labels.push((index, Some(Brick::from_texels(label, 2))));
    }
    old.density.swap(ball).unwrap();
    old.labels.swap(labels).unwrap();
    let larger = SubBox { lo: [3, 4, 5], hi: [20, 19, 18], scale: [4; 3] };
    let mut grown = Volume::refined(&parent, larger);
    let carry = |from, to| Carry { from, before: &parent, parent: parent.clone(), to };
    assert_eq!(carry(&old, larger).into(&mut grown).unwrap(), 0);
    for at in each(of.dims(), |s| s) {
        let there = std::array::from_fn(|a| at[a] + (of.lo[a] - larger.lo[a]) * 4);
        let (was, is) = (old.density.value(at).unwrap(), grown.density.value(there).unwrap());
        assert!((was - is).abs() < 1e-4, "{at:?}: {was} {is}");
        assert_eq!(old.labels.texel(at).unwrap(), grown.labels.texel(there).unwrap());
    }
    let of_finer = SubBox { scale: [8, 8, 4], ..larger };
    let mut finer = Volume::refined(&parent, of_finer);
    assert_eq!(carry(&old, of_finer).into(&mut finer).unwrap(), 0);
    let at = [8 * 8, 7 * 8, 6 * 4];
    assert!((finer.density.value(at).unwrap() - (6.0 * 11.0 + 100.0)).abs() < 1e-4, "the ball's middle");
    assert_eq!(finer.labels.value(at).unwrap(), 9.0);
    let of_cut = SubBox { hi: [11, 16, 16], ..of };
    let mut cut = Volume::refined(&parent, of_cut);
    assert!(carry(&old, of_cut).into(&mut cut).unwrap() > 100, "half of the ball lies outside");
}
