use super::*;
use burin::volume::{BRICK, BRICK_VOXELS, BrickIndex};
use rand::{Rng, SeedableRng, rngs::StdRng};
use std::collections::{BTreeSet, VecDeque};
use std::convert::Infallible;

/// A plain flood fill through faces.
fn flood(dims: [u32; 3], open: &[bool], starts: &[[u32; 3]]) -> BTreeSet<[u32; 3]> {
    let at = |v: [u32; 3]| (v[0] + dims[0] * (v[1] + dims[1] * v[2])) as usize;
    let mut found = BTreeSet::new();
    let mut next: VecDeque<_> = starts.iter().copied().filter(|v| open[at(*v)]).collect();
    while let Some(v) = next.pop_front() {
        if !found.insert(v) {
            continue;
        }
        for axis in 0..3 {
            for step in [-1_i64, 1] {
                let to = i64::from(v[axis]) + step;
                if to < 0 || to >= i64::from(dims[axis]) {
                    continue;
                }
                let mut beside = v;
                beside[axis] = to as u32;
                if open[at(beside)] && !found.contains(&beside) {
                    next.push_back(beside);
                }
            }
        }
    }
    found
}

#[test]
fn what_is_connected_is_what_a_plain_flood_fill_finds() {
    let mut rng = StdRng::seed_from_u64(3);
    // Near the threshold at which what is open hangs together, so that ways wind through many bricks.
    for (dims, share) in [
        ([70, 40, 37], 0.34),
        ([70, 40, 37], 0.31),
        ([33, 64, 65], 0.5),
        ([1, 90, 3], 0.9),
        ([64, 32, 96], 0.33),
        ([40, 40, 40], 1.0),
    ] {
        let all: Vec<_> = voxels(dims).collect();
        let open: Vec<bool> = all.iter().map(|_| rng.random_bool(share)).collect();
        let bits = |brick: BrickIndex| {
            let mut bits = Box::new([0_u32; BRICK_VOXELS / 32]);
            for (v, _) in all.iter().zip(&open).filter(|(v, open)| **open && BrickIndex::of_voxel(**v) == brick) {
                let [x, y, z] = v.map(|v| v % BRICK);
                bits[(y + BRICK * z) as usize] |= 1 << x;
            }
            Ok::<_, Infallible>(bits)
        };
        let mut starts = vec![all[rng.random_range(0..all.len())], all[all.len() / 2]];
        starts.extend(all.iter().zip(&open).find(|(_, open)| **open).map(|(v, _)| *v));
        for starts in [&starts[..], &starts[2..], &starts[..1]] {
            let Ok(found) = connected(dims, starts, bits);
            let expected = flood(dims, &open, starts);
            let wrong = all.iter().filter(|v| found.contains(**v) != expected.contains(*v)).count();
            assert_eq!(wrong, 0, "{dims:?} {share} {starts:?}: of {}", expected.len());
        }
    }
}
