//! Coarser levels, sources that fail, and what is visible between two values.

use super::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Paints a whole field by texels.
fn painted(kind: FieldKind, dims: [u32; 3], texel: impl Fn([u32; 3]) -> [u8; 4]) -> Field {
    crate::common::volumes::painted(kind, &Grid::aligned(dims, DVec3::ONE, DVec3::ZERO), texel)
}

/// The voxels of level 0 that a voxel of level 1 covers.
fn covered(at: [u32; 3], dims: [u32; 3]) -> Vec<[u32; 3]> {
    let mut all = Vec::new();
    for i in 0..8 {
        let voxel: [u32; 3] = std::array::from_fn(|a| 2 * at[a] + (i >> a & 1));
        if (0..3).all(|a| voxel[a] < dims[a]) {
            all.push(voxel);
        }
    }
    all
}

fn scramble(v: [u32; 3]) -> u32 {
    v[0].wrapping_mul(2_654_435_761)
        ^ v[1].wrapping_mul(40_503).rotate_left(7)
        ^ v[2].wrapping_mul(97_531).rotate_left(13)
}

#[test]
fn a_coarser_selection_is_the_mean_to_the_nearest_step() {
    let dims = [37, 34, 33];
    let value = |v: [u32; 3]| (scramble(v) >> 9) as u8;
    let field = painted(FieldKind::Selection, dims, |v| [value(v), 0, 0, 0]);
    let [nx, ny, nz] = field.dims(1);
    let texels = field.read(1, [0; 3], [nx, ny, nz]).unwrap();
    let mut halves = 0;
    for (i, &found) in texels.iter().enumerate() {
        let i = i as u32;
        let taps = covered([i % nx, i / nx % ny, i / (nx * ny)], dims);
        let mean = taps.iter().map(|&v| f64::from(value(v))).sum::<f64>() / taps.len() as f64;
        assert!((f64::from(found) - mean).abs() <= 0.5, "{found} for {mean}");
        // Halves go up, so that what is half selected does not fade from afar.
        if mean.fract() == 0.5 {
            assert_eq!(f64::from(found), mean + 0.5);
            halves += 1;
        }
    }
    assert!(halves > 100);
}

#[test]
fn a_coarser_density_in_codes_is_the_mean_to_the_nearest_step_after_edits_too() {
    let dims = [37, 70, 33];
    let value = |v: [u32; 3]| (scramble(v) >> 7) as u16;
    let mut field = crate::common::volumes::density_u16(Grid::aligned(dims, DVec3::ONE, DVec3::ZERO), value);
    // An edit in the middle of a brick, at odd voxels, and one up to the volume's border.
    let edited = |v: [u32; 3]| (0..3).all(|a| (5..12).contains(&v[a])) || v[1] > 66 && v[0] > 30;
    let now = |v: [u32; 3]| if edited(v) { !value(v) } else { value(v) };
    let brick = |index: BrickIndex| {
        let (origin, valid) = (index.origin(), field.valid(0, index));
        let mut texels = vec![0; BRICK_VOXELS * 2];
        for i in 0..BRICK_VOXELS as u32 {
            let at = [i % BRICK, i / BRICK % BRICK, i / (BRICK * BRICK)];
            if (0..3).all(|a| at[a] < valid[a]) {
                let code = now(std::array::from_fn(|a| origin[a] + at[a]));
                texels[i as usize * 2..][..2].copy_from_slice(&code.to_le_bytes());
            }
        }
        (index, Some(Brick::from_texels(texels, 2)))
    };
    let changes = field.brick_indices(0).into_iter().map(brick).collect();
    field.swap(changes).unwrap();
    let [nx, ny, nz] = field.dims(1);
    let texels = field.read(1, [0; 3], [nx, ny, nz]).unwrap();
    for (i, found) in texels.chunks_exact(2).enumerate() {
        let i = i as u32;
        let taps = covered([i % nx, i / nx % ny, i / (nx * ny)], dims);
        let mean = taps.iter().map(|&v| f64::from(now(v))).sum::<f64>() / taps.len() as f64;
        let found = f64::from(u16::from_le_bytes([found[0], found[1]]));
        assert!((found - mean).abs() <= 0.5 && (mean.fract() != 0.5 || found > mean), "{found} for {mean}");
    }
}

#[test]
fn a_coarser_colour_is_the_mean_by_alpha() {
    let dims = [37, 34, 33];
    // Eight alike in every second place along x.
    let place = |v: [u32; 3]| if (v[0] / 2).is_multiple_of(2) { v.map(|i| i / 2) } else { v };
    let value = |v: [u32; 3]| {
        let [r, g, b, a] = (scramble(place(v)) | 1 << 30).to_le_bytes();
        if a % 3 == 0 { [0; 4] } else { [r, g, b, a] }
    };
    let field = painted(FieldKind::Colour, dims, value);
    let [nx, ny, nz] = field.dims(1);
    let texels = field.read(1, [0; 3], [nx, ny, nz]).unwrap();
    for (i, found) in texels.chunks_exact(4).enumerate() {
        let i = i as u32;
        let taps: Vec<_> = covered([i % nx, i / nx % ny, i / (nx * ny)], dims).into_iter().map(value).collect();
        let alpha: f64 = taps.iter().map(|t| f64::from(t[3])).sum();
        let mean = |channel: usize| match channel {
            3 => alpha / taps.len() as f64,
            _ => taps.iter().map(|t| f64::from(t[channel]) * f64::from(t[3])).sum::<f64>() / alpha.max(1.0),
        };
        for (channel, &found) in found.iter().enumerate() {
            assert!((f64::from(found) - mean(channel)).abs() <= 0.5, "{taps:?}: {found} for {}", mean(channel));
        }
    }
}

#[test]
fn voxels_become_the_codes_of_their_values() {
    let maps = [
        DensityMap::codes(0.0, 255.0, Some(1.0)),
        DensityMap::codes(-128.0, 127.0, Some(1.0)),
        DensityMap::codes(-32_768.0, 32_767.0, Some(1.0)),
        DensityMap::codes(-1000.0, 3000.0, Some(1.0)),
        DensityMap::codes(0.0, 2.0, Some(1.0)),
        DensityMap::codes(0.25, 3.75, None),
        DensityMap::codes(-7.5, 1000.0, Some(0.5)),
        DensityMap { lo: -1e12, ..DensityMap::codes(0.0, 1.0, Some(1.0)) },
        DensityMap::FLOAT,
    ];
    let bytes: Vec<u8> = (0..=255).collect();
    let halves: Vec<u16> = (0..=65_535).collect();
    let signed = |v: &[u16]| v.iter().map(|&v| v as i16).collect::<Vec<_>>();
    let all = [
        Voxels::U8(bytes.clone()),
        Voxels::I8(bytes.iter().map(|&v| v as i8).collect()),
        Voxels::U16(halves.clone()),
        Voxels::I16(signed(&halves)),
    ];
    for map in maps {
        for voxels in &all {
            for (slope, intercept) in [(1.0, 0.0), (2.0, -1024.0), (0.5, 0.25), (-1.0, 255.0), (1e9, 0.0)] {
                let mut texels = vec![7];
                map.encode_voxels(voxels, (slope, intercept), &mut texels);
                let size = map.format.bytes();
                assert_eq!((texels[0], texels.len()), (7, 1 + voxels.len() * size));
                for (i, texel) in texels[1..].chunks_exact(size).enumerate() {
                    let stored = match voxels {
                        Voxels::U8(v) => f64::from(v[i]),
                        Voxels::I8(v) => f64::from(v[i]),
                        Voxels::U16(v) => f64::from(v[i]),
                        Voxels::I16(v) => f64::from(v[i]),
                        _ => unreachable!(),
                    };
                    let code = (slope * stored + intercept - map.lo) * map.codes_per_unit;
                    if map.format == TexelFormat::R32Float {
                        assert_eq!(texel, (code as f32).to_le_bytes());
                        continue;
                    }
                    let found = f64::from(u16::from_le_bytes([texel[0], texel[1]]));
                    let off = (found - code.clamp(0.0, 65_535.0)).abs();
                    assert!(off <= 0.5 + 1e-9, "{map:?} {slope} {intercept}: {stored} became {found}, not {code}");
                }
            }
        }
    }
}

#[test]
fn a_coarser_label_is_the_most_frequent_one_and_the_lowest_of_equals() {
    let dims = [37, 34, 33];
    let value = |v: [u32; 3]| [0_u16, 0, 0, 7, 300, 65_535][(scramble(v) >> 11) as usize % 6];
    let field = painted(FieldKind::Labels, dims, |v| {
        let [a, b] = value(v).to_le_bytes();
        [a, b, 0, 0]
    });
    let [nx, ny, nz] = field.dims(1);
    let texels = field.read(1, [0; 3], [nx, ny, nz]).unwrap();
    let mut ties = 0;
    for (i, found) in texels.chunks_exact(2).enumerate() {
        let i = i as u32;
        let taps: Vec<u16> =
            covered([i % nx, i / nx % ny, i / (nx * ny)], dims).into_iter().map(value).filter(|&l| l != 0).collect();
        let count = |id: u16| taps.iter().filter(|&&l| l == id).count();
        let most = [7, 300, 65_535].map(count).into_iter().max().unwrap();
        let right = [7, 300, 65_535].into_iter().find(|&id| count(id) == most).filter(|_| most > 0).unwrap_or(0);
        assert_eq!(u16::from_le_bytes([found[0], found[1]]), right, "{taps:?}");
        ties += usize::from(most > 0 && [7, 300, 65_535].iter().filter(|&&id| count(id) == most).count() > 1);
    }
    assert!(ties > 100);
}

#[test]
fn a_coarser_float_is_the_mean_of_the_numbers_it_covers() {
    let dims = [37, 34, 33];
    let value = |v: [u32; 3]| match scramble(v) >> 12 {
        n if n % 3 == 0 => f32::NAN,
        n if n % 17 == 1 => f32::INFINITY,
        n => (n % 1000) as f32 - 500.0,
    };
    let field = crate::common::volumes::density_f32(Grid::aligned(dims, DVec3::ONE, DVec3::ZERO), value);
    let [nx, ny, nz] = field.dims(1);
    let texels = field.read(1, [0; 3], [nx, ny, nz]).unwrap();
    let mut none = 0;
    for (i, found) in texels.chunks_exact(4).enumerate() {
        let found = f32::from_le_bytes(found.try_into().unwrap());
        let i = i as u32;
        let taps: Vec<f64> =
            covered([i % nx, i / nx % ny, i / (nx * ny)], dims).into_iter().map(|v| f64::from(value(v))).collect();
        let numbers: Vec<f64> = taps.iter().copied().filter(|v| v.is_finite()).collect();
        if numbers.is_empty() {
            assert!(if taps.iter().all(|v| v.is_nan()) { found.is_nan() } else { found == f32::INFINITY });
            none += 1;
        } else {
            let mean = numbers.iter().sum::<f64>() / numbers.len() as f64;
            assert!((f64::from(found) - mean).abs() <= 1e-4, "{found} for {mean}");
        }
    }
    assert!(none > 0);
}

/// Voxels that cannot be read while it fails.
#[derive(Debug)]
struct Failing {
    inner: Arc<MemorySource>,
    fails: AtomicBool,
}

impl BrickSource for Failing {
    fn grid(&self) -> &Grid {
        self.inner.grid()
    }
    fn voxel_type(&self) -> VoxelType {
        self.inner.voxel_type()
    }
    fn scaling(&self) -> (f64, f64) {
        self.inner.scaling()
    }
    fn name(&self) -> &str {
        "failing"
    }
    fn read(&self, lo: [u32; 3], size: [u32; 3]) -> Result<Voxels, SourceError> {
        // A brick alone is still read: what fails is what lies about it.
        if self.fails.load(Ordering::Relaxed) && size.iter().any(|&s| s > BRICK) {
            return Err(SourceError::Unreadable { name: "failing".into(), reason: "made to fail".into() });
        }
        self.inner.read(lo, size)
    }
}

#[test]
fn a_swap_whose_source_fails_leaves_the_field_as_it_was() {
    let dims = [70, 70, 70];
    let (inner, _) = ramp(dims);
    let source = Arc::new(Failing { inner, fails: AtomicBool::new(false) });
    let map = DensityMap::codes(0.0, 65_535.0, Some(1.0));
    let mut field = Field::from_source(source.clone(), map, &|_| true).unwrap().unwrap();
    let (first, second) = (BrickIndex([0, 0, 0]), BrickIndex([1, 1, 1]));
    field.swap(vec![(first, Some(Brick::Uniform([9, 9, 0, 0])))]).unwrap();
    let levels = |field: &Field| -> Vec<Vec<u8>> {
        (0..field.level_count()).map(|l| field.read(l, [0; 3], field.dims(l)).unwrap()).collect()
    };
    let before = levels(&field);
    source.fails.store(true, Ordering::Relaxed);
    // One brick gets an edit, one loses its own.
    let change = vec![(second, Some(Brick::Uniform([1, 2, 0, 0]))), (first, None)];
    assert!(field.swap(change.clone()).is_err());
    source.fails.store(false, Ordering::Relaxed);
    assert_eq!(field.edits().into_keys().collect::<Vec<_>>(), [first]);
    assert!(levels(&field) == before);
    // And it goes on from there.
    let (old, _) = field.swap(change).unwrap();
    assert_eq!(old, [(second, None), (first, Some(Brick::Uniform([9, 9, 0, 0])))]);
    assert!(levels(&field) != before);
}

#[test]
fn a_peak_between_two_values_counts_as_visible() {
    let peaks = TransferFunction {
        colour: vec![(0.0, [1.0; 3])],
        opacity: vec![(10.0, 0.0), (20.0, 0.75), (30.0, 0.0), (40.0, 0.25), (50.0, 0.0)],
        unit_mm: 1.0,
    };
    for (lo, hi, right) in [
        (10.0, 30.0, 0.75),
        (0.0, 100.0, 0.75),
        (20.0, 20.0, 0.75),
        (30.0, 60.0, 0.25),
        (25.0, 35.0, 0.375),
        (0.0, 10.0, 0.0),
        (30.0, 30.0, 0.0),
        (f64::NEG_INFINITY, f64::INFINITY, 0.75),
        (20.0, 10.0, 0.0),
    ] {
        assert_eq!(peaks.max_opacity_in(lo, hi), right, "{lo}..{hi}");
    }
}

#[test]
fn floats_hold_what_scaled_numbers_stand_for() {
    let grid = Grid::aligned([5, 4, 3], DVec3::ONE, DVec3::ZERO);
    let stored: Vec<i16> = (0..60).map(|i| i * 37 - 900).collect();
    for (slope, intercept) in [(1.0, 0.0), (0.5, -1000.0), (-2.0, 32.25)] {
        let source = MemorySource::new("scaled", grid, Voxels::I16(stored.clone()), (slope, intercept)).unwrap();
        let field = Field::from_source(std::sync::Arc::new(source), DensityMap::FLOAT, &|_| true).unwrap().unwrap();
        for (i, &x) in stored.iter().enumerate() {
            let i = i as u32;
            let found = field.value([i % 5, i / 5 % 4, i / 20]).unwrap();
            // Halves and quarters of small numbers: floats hold them.
            assert_eq!(f64::from(found), f64::from(x) * slope + intercept, "{x} by {slope} and {intercept}");
        }
    }
}
