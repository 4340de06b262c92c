//! The maps of empty space against brute force.

use crate::common::gpu::{gpu, sample, sample_maps};
use crate::common::volumes::*;
use burin::gpu::{FieldPools, Mask, VisibleValues, distances};
use burin::math::DVec3;
use burin::volume::*;
use rand::{Rng, SeedableRng};

fn brute(occupied: &[u8], cells: [u32; 3], at: [u32; 3]) -> u8 {
    let all = each(cells, |c| c);
    all.iter()
        .zip(occupied)
        .filter(|(_, o)| **o != 0)
        .map(|(c, _)| (0..3).map(|a| c[a].abs_diff(at[a])).max().unwrap())
        .min()
        .unwrap_or(15)
        .min(15) as u8
}

#[test]
fn distances_are_those_of_brute_force() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
    for (cells, share) in
        [([20, 9, 13], 0.002), ([5, 40, 3], 0.02), ([1, 1, 7], 0.3), ([18, 18, 18], 0.0), ([6, 6, 6], 1.0)]
    {
        let occupied: Vec<u8> = each(cells, |_| u8::from(rng_bool(&mut rng, share)));
        let all = distances(&occupied, cells, [0; 3], cells);
        for (i, at) in each(cells, |c| c).into_iter().enumerate() {
            assert_eq!(all[i], brute(&occupied, cells, at), "{cells:?} {at:?}");
        }
        // A box within is the same.
        let lo = cells.map(|n| n / 3);
        let size: [u32; 3] = std::array::from_fn(|a| (cells[a] - lo[a]).div_ceil(2));
        let part = distances(&occupied, cells, lo, size);
        for (i, d) in each(size, |c| c).into_iter().enumerate() {
            let at: [u32; 3] = std::array::from_fn(|a| lo[a] + d[a]);
            assert_eq!(part[i], brute(&occupied, cells, at), "box of {cells:?} {at:?}");
        }
    }
}

fn rng_bool(rng: &mut impl Rng, share: f64) -> bool {
    rng.random_range(0.0..1.0) < share
}

#[test]
fn what_shows_is_never_called_clear() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
    for _ in 0..200 {
        let tf = random_transfer(&mut rng);
        let shows = VisibleValues::of(&tf, Mode::Dvr);
        for _ in 0..50 {
            let a = rng.random_range(-50.0_f32..1100.0);
            let b = a + rng.random_range(0.0_f32..200.0);
            let opaque = (0..=400).any(|i| tf.opacity_at(f64::from(a) + f64::from(b - a) * f64::from(i) / 400.0) > 0.0);
            assert!(!opaque || shows.any(a, b), "{tf:?} [{a}, {b}]");
        }
        // Tight: well inside a clear stretch nothing shows.
        for pair in tf.opacity.windows(2).filter(|p| p[0].1 == 0.0 && p[1].1 == 0.0 && p[1].0 - p[0].0 > 4.0) {
            assert!(!shows.any(pair[0].0 as f32 + 1.0, pair[1].0 as f32 - 1.0), "{tf:?}");
        }
    }
    let tf = ramp(100.0, 200.0);
    assert!(!VisibleValues::of(&tf, Mode::Dvr).any(f32::INFINITY, f32::NEG_INFINITY), "nothing but NaN");
    let iso = VisibleValues::of(&tf, Mode::Iso(150.0));
    assert!(iso.any(140.0, 150.0) && iso.any(150.0, 300.0) && iso.any(200.0, 300.0) && !iso.any(0.0, 149.9));
    // A high stretch without opacity still hides a lower maximum.
    let gap = TransferFunction { opacity: vec![(0.0, 0.0), (10.0, 0.0), (20.0, 1.0), (30.0, 0.0)], ..tf };
    assert!(VisibleValues::of(&gap, Mode::Mip).any(40.0, 50.0) && !VisibleValues::of(&gap, Mode::Dvr).any(40.0, 50.0));
    assert!(!VisibleValues::of(&gap, Mode::Mip).any(2.0, 9.0));
}

/// A picture looks colours up in a table: a value takes the entry next to it.
#[test]
fn what_shows_by_the_table_s_rounding_is_never_called_clear() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(8);
    let (mut rounded, mut clear) = (0, 0);
    for _ in 0..300 {
        let tf = random_transfer(&mut rng);
        let shows = VisibleValues::of(&tf, Mode::Dvr);
        let (lo, hi) = tf.domain();
        let entry = (hi - lo) / (TABLE_ENTRIES - 1) as f64;
        let opacity = |v: f64| tf.opacity_at(lo + entry * ((v - lo) / entry).round().clamp(0.0, 4095.0));
        for &(value, _) in &tf.opacity {
            for i in -60..=60 {
                let v = (value + entry * 0.05 * f64::from(i)) as f32;
                let about = [-1.2, -0.6, 0.0, 0.6, 1.2].map(|e| f64::from(v) + e * entry);
                if opacity(f64::from(v)) > 0.0 {
                    rounded += u32::from(tf.opacity_at(f64::from(v)) == 0.0);
                    assert!(shows.any(v, v), "{tf:?} {v}");
                } else if about.iter().all(|&v| tf.opacity_at(v) == 0.0) {
                    clear += 1;
                    assert!(!shows.any(v, v), "{tf:?} {v}: more than an entry from what shows");
                }
            }
        }
    }
    assert!(rounded > 100 && clear > 1000, "{rounded} {clear}");
}

fn random_transfer(rng: &mut impl Rng) -> TransferFunction {
    let mut value = rng.random_range(0.0..100.0);
    let mut opacity = Vec::new();
    for _ in 0..rng.random_range(1..8) {
        opacity.push((value, if rng_bool(rng, 0.6) { 0.0 } else { rng.random_range(0.0..1.0) }));
        value += rng.random_range(0.5..200.0);
    }
    TransferFunction { colour: vec![(0.0, [1.0; 3]), (1000.0, [0.5; 3])], opacity, unit_mm: 1.0 }
}

/// Every sample that shows lies in a cell of distance 0, and no nearer cell is occupied than a distance says.
fn check_maps(
    gpu: &burin::gpu::Gpu,
    (pools, maps): (&FieldPools, &[[u32; 3]]),
    dims: [u32; 3],
    shows: impl Fn(f32, f32) -> [bool; 3],
    seed: u64,
) {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let points: Vec<[f32; 3]> =
        (0..6000).map(|_| std::array::from_fn(|a| rng.random_range(-0.5..dims[a] as f32 - 0.5))).collect();
    let mut skipped = 0;
    for (p, s) in points.iter().zip(sample_maps(gpu, pools, maps, &points)) {
        for (map, shown) in shows(s.density, s.selection).into_iter().enumerate() {
            assert!(!shown || s.skip[map] == 0, "map {map} at {p:?}: {s:?}");
            skipped += u32::from(s.skip[map] > 0);
        }
    }
    assert!(skipped > 1000, "something can be skipped: {skipped}");
    let cells = dims.map(|d| d.div_ceil(4));
    let centres: Vec<[f32; 3]> = each(cells, |c| c.map(|v| v as f32 * 4.0 + 0.5));
    let all = sample_maps(gpu, pools, maps, &centres);
    for map in 0..3 {
        let occupied: Vec<u8> = all.iter().map(|s| u8::from(s.skip[map] == 0)).collect();
        assert_eq!(
            all.iter().map(|s| s.skip[map] as u8).collect::<Vec<_>>(),
            distances(&occupied, cells, [0; 3], cells),
            "map {map}"
        );
    }
}

#[test]
fn no_sample_that_shows_is_skipped_also_after_edits_and_at_coarser_levels() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([80, 70, 66]);
    let ball = |v: [u32; 3], c: [f32; 3], r: f32| (0..3).map(|a| (v[a] as f32 - c[a]).powi(2)).sum::<f32>().sqrt() < r;
    let mut density = density_u16(grid, |v| {
        if ball(v, [30.0, 30.0, 30.0], 9.0) { 800 + (v[0] % 7) as u16 } else { (v[0] % 5 + v[1] % 3) as u16 }
    });
    let mut selection =
        painted(FieldKind::Selection, &grid, |v| [if ball(v, [34.0, 30.0, 30.0], 8.0) { 255 } else { 0 }, 0, 0, 0]);
    let (colour, labels) = (Field::blank(FieldKind::Colour, &grid), Field::blank(FieldKind::Labels, &grid));
    let transfer = ramp(100.0, 900.0);
    let frame = frame(&grid, transfer.clone(), DVec3::new(0.3, -1.0, 0.2), [64, 64]);
    let shows = move |density: f32, selection: f32| {
        let any = transfer.opacity_at(f64::from(density)) > 0.0;
        [any, any && selection > 0.0, any && selection < 1.0]
    };
    let all = [Mask::None, Mask::Selection, Mask::Background].map(|mask| matter(&frame, mask));
    // All of it, then a pool of one slot, where everything is drawn from coarser levels.
    for budget in [64 << 20, 32] {
        let mut pools = FieldPools::apart(&gpu, &grid, &density, budget).unwrap();
        let fields = one_volume(&grid, &density, &colour, &selection, &labels);
        pools.make_resident(&gpu, &fields, &frame).unwrap();
        let maps = pools.skip_maps(&gpu, &fields, &all).unwrap();
        check_maps(&gpu, (&pools, &maps), grid.dims, &shows, 11);
        let coarse = sample(&gpu, &pools, &[[30.0; 3]])[0].level;
        assert_eq!(coarse > 0, budget == 32);
        // A bright brick far from the ball, and no selection any more in the first one.
        let change = vec![(BrickIndex([2, 1, 1]), Some(Brick::Uniform([0x20, 3, 0, 0])))];
        let (before, refresh) = density.swap(change).unwrap();
        pools.refresh(&gpu, FieldKind::Density, &density, &refresh).unwrap();
        let (selected, refresh) = selection.swap(vec![(BrickIndex([0, 0, 0]), None)]).unwrap();
        pools.refresh(&gpu, FieldKind::Selection, &selection, &refresh).unwrap();
        let fields = one_volume(&grid, &density, &colour, &selection, &labels);
        pools.make_resident(&gpu, &fields, &frame).unwrap();
        let maps = pools.skip_maps(&gpu, &fields, &all).unwrap();
        assert_eq!(sample_maps(&gpu, &pools, &maps, &[[70.0, 50.0, 50.0]])[0].skip[0], 0);
        check_maps(&gpu, (&pools, &maps), grid.dims, &shows, 12);
        // As at the start, for the next budget.
        density.swap(before).unwrap();
        selection.swap(selected).unwrap();
    }
}
