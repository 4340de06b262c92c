//! What shaders read through `burin::field` against the host's fields.

use crate::common::gpu::{gpu, sample};
use crate::common::volumes::*;
use burin::gpu::{FieldPools, Fields};
use burin::math::DVec3;
use burin::volume::*;
use rand::{Rng, SeedableRng};

/// Linear interpolation of a level's texels at a place in level-0 voxels, taps clamped to the volume.
fn trilinear(field: &Field, level: u8, p: [f32; 3], value: impl Fn([u8; 4]) -> f64) -> f64 {
    let bytes = field.format().bytes();
    let f = f64::from(1_u32 << level);
    let q: [f64; 3] = std::array::from_fn(|a| (f64::from(p[a]) + 0.5) / f - 0.5);
    let lo = q.map(|x| x.floor() as i64);
    let taps = field.read(level, lo, [2; 3]).unwrap();
    (0..8)
        .map(|i| {
            let mut texel = [0; 4];
            texel[..bytes].copy_from_slice(&taps[i * bytes..(i + 1) * bytes]);
            let weight: f64 = (0..3)
                .map(|a| {
                    let t = q[a] - lo[a] as f64;
                    if i >> a & 1 == 1 { t } else { 1.0 - t }
                })
                .product();
            if weight == 0.0 { 0.0 } else { weight * value(texel) }
        })
        .sum()
}

/// Seeded places: anywhere in the box, and on brick borders, volume faces and corners.
fn places(dims: [u32; 3], count: usize) -> Vec<[f32; 3]> {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
    let mut out: Vec<[f32; 3]> = (0..count)
        .map(|i| {
            std::array::from_fn(|a| {
                let n = dims[a] as f32;
                match (i + a) % 3 {
                    0 => ((rng.random_range(0..=dims[a] / 32) * 32) as f32 - 0.5).min(n - 0.5),
                    _ => rng.random_range(-0.5..n - 0.5),
                }
            })
        })
        .collect();
    for i in 0..8 {
        out.push(std::array::from_fn(|a| if i >> a & 1 == 1 { dims[a] as f32 - 0.501 } else { -0.5 }));
    }
    out
}

#[test]
fn samples_through_pages_equal_the_dense_field() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([70, 66, 40]);
    let density = density_u16(grid, |v| ((v[0] * 631 + v[1] * 409 + v[2] * 211 + v[0] * v[1] * 7) % 60_000) as u16);
    let selection = painted(FieldKind::Selection, &grid, |v| {
        [if v[0] > 40 { ((v[1] * 5 + v[2] * 3) % 256) as u8 } else { 255 }, 0, 0, 0]
    });
    let colour =
        painted(FieldKind::Colour, &grid, |v| [(v[0] * 3) as u8, (v[1] * 2) as u8, v[2] as u8, (v[0] + v[1]) as u8]);
    let labels = painted(FieldKind::Labels, &grid, |v| {
        let [a, b] = ((v[0] / 3 + 7 * (v[1] / 5) + 300 * (v[2] / 11)) as u16).to_le_bytes();
        [a, b, 0, 0]
    });
    let fields = Fields { density: &density, colour: &colour, selection: &selection, labels: &labels };
    let mut pools = FieldPools::new(&gpu, &grid, &density, 256 << 20).unwrap();
    let frame = frame(&grid, ramp(-1.0, 60_000.0), DVec3::new(1.0, -2.0, 0.5), [64, 64]);
    assert!(pools.make_resident(&gpu, &fields, &frame).unwrap());
    let points = places(grid.dims, 4000);
    let unorm = |t: u8| f64::from(t) / 255.0;
    for (p, s) in points.iter().zip(sample(&gpu, &pools, &points)) {
        assert_eq!(s.level, 0);
        // Samplers weigh with 8 bits: a 256th of the largest step between neighbours.
        let expected = trilinear(&density, 0, *p, |t| density.map().decode(t));
        assert!((f64::from(s.density) - expected).abs() <= 60_000.0 / 200.0, "{p:?}: {} for {expected}", s.density);
        let expected = trilinear(&selection, 0, *p, |t| unorm(t[0]));
        assert!((f64::from(s.selection) - expected).abs() <= 1.0 / 200.0, "{p:?}: {} for {expected}", s.selection);
        for c in 0..4 {
            let expected = trilinear(&colour, 0, *p, |t| unorm(t[c]));
            assert!((f64::from(s.colour[c]) - expected).abs() <= 1.0 / 200.0, "{p:?} channel {c}");
        }
        let voxel = std::array::from_fn(|a| ((p[a] + 0.5).floor() as u32).min(grid.dims[a] - 1));
        assert_eq!(s.label, labels.value(voxel).unwrap() as u32, "{p:?}");
    }
    assert!(!pools.make_resident(&gpu, &fields, &frame).unwrap(), "the same frame again changes nothing");
}
