//! Connected components against a plain flood fill, voxel by voxel.

use crate::common::volumes::each;
use burin::segment::{BrickMask, Components, Connectivity};
use burin::volume::{BRICK, BrickIndex};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::HashMap;

type Failed = std::convert::Infallible;

fn place(v: [u32; 3], dims: [u32; 3]) -> usize {
    v[0] as usize + dims[0] as usize * (v[1] as usize + dims[1] as usize * v[2] as usize)
}

/// From a voxel to its neighbours, by what they share: offsets of which so many at most differ.
fn offsets(connectivity: Connectivity) -> Vec<[i64; 3]> {
    let most = match connectivity {
        Connectivity::Six => 1,
        Connectivity::Eighteen => 2,
        Connectivity::TwentySix => 3,
    };
    let all = (0..27_i64).map(|n| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1]);
    all.filter(|by| (1..=most).contains(&by.iter().filter(|d| **d != 0).count())).collect()
}

/// The number of each voxel's component, 0 for none, and how many voxels each has.
fn flood(set: &[bool], dims: [u32; 3], connectivity: Connectivity) -> (Vec<u32>, Vec<u64>) {
    let mut number = vec![0; set.len()];
    let mut sizes = Vec::new();
    let offsets = offsets(connectivity);
    for start in each(dims, |v| v) {
        if !set[place(start, dims)] || number[place(start, dims)] != 0 {
            continue;
        }
        sizes.push(0);
        let own = sizes.len() as u32;
        number[place(start, dims)] = own;
        let mut open = vec![start];
        while let Some(v) = open.pop() {
            sizes[own as usize - 1] += 1;
            for by in &offsets {
                let next: [i64; 3] = std::array::from_fn(|a| i64::from(v[a]) + by[a]);
                if !(0..3).all(|a| (0..i64::from(dims[a])).contains(&next[a])) {
                    continue;
                }
                let next = next.map(|x| x as u32);
                let at = place(next, dims);
                if set[at] && number[at] == 0 {
                    number[at] = own;
                    open.push(next);
                }
            }
        }
    }
    (number, sizes)
}

fn brick(set: &[bool], dims: [u32; 3], index: BrickIndex) -> BrickMask {
    let origin = index.origin();
    let valid: [u32; 3] = std::array::from_fn(|a| BRICK.min(dims[a] - origin[a]));
    BrickMask::new(valid, |v| set[place(std::array::from_fn(|a| origin[a] + v[a]), dims)])
}

fn components(set: &[bool], dims: [u32; 3], connectivity: Connectivity) -> Components {
    Components::new(dims, connectivity, |index| Ok::<_, Failed>(brick(set, dims, index))).unwrap()
}

/// Holds components to the flood: the same voxels together, the same sizes, the same masks.
fn hold(set: &[bool], dims: [u32; 3], connectivity: Connectivity, what: &str) {
    let found = components(set, dims, connectivity);
    let (number, sizes) = flood(set, dims, connectivity);
    assert_eq!(found.len(), sizes.len(), "{what}");
    let mut partner = HashMap::new();
    for v in each(dims, |v| v) {
        let (own, expected) = (found.at(v), number[place(v, dims)]);
        assert_eq!(own.is_some(), expected != 0, "{what} {v:?}");
        let Some(own) = own else { continue };
        assert_eq!(*partner.entry(own).or_insert(expected), expected, "{what} {v:?}");
    }
    assert_eq!(partner.len(), sizes.len(), "{what}: as many as the flood has");
    for (&id, &expected) in &partner {
        assert_eq!(found.size(id), sizes[expected as usize - 1], "{what} {id:?}");
    }
    assert_eq!(found.sizes().iter().sum::<u64>(), set.iter().filter(|s| **s).count() as u64, "{what}");
    assert_eq!(found.largest().map(|id| found.size(id)), sizes.iter().max().copied(), "{what}");
    // The voxels of some, and of all others, as masks.
    for &id in partner.keys().take(1) {
        for wanted in [true, false] {
            let bricks: HashMap<_, _> = found.voxels(|other| (other == id) == wanted).into_iter().collect();
            for v in each(dims, |v| v) {
                let expected = found.at(v).is_some_and(|other| (other == id) == wanted);
                let mask = bricks.get(&BrickIndex::of_voxel(v));
                let held = mask.is_some_and(|mask| mask.contains(v.map(|x| x % BRICK)));
                assert_eq!(held, expected, "{what} {id:?} {v:?}");
            }
        }
    }
    assert_eq!(found.at(dims), None, "outside");
}

const ALL: [Connectivity; 3] = [Connectivity::Six, Connectivity::Eighteen, Connectivity::TwentySix];

#[test]
fn components_of_noise_of_any_density_are_those_of_a_flood() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for dims in [[36, 34, 33], [65, 33, 5], [1, 70, 34], [34, 1, 66], [67, 34, 1], [1, 1, 97], [33, 1, 1], [3, 2, 4]] {
        for share in [0.03, 0.3, 0.6, 0.96] {
            let set = each(dims, |_| rng.random_range(0.0..1.0) < share);
            for connectivity in ALL {
                hold(&set, dims, connectivity, &format!("{dims:?} {share} {connectivity:?}"));
            }
        }
    }
}

#[test]
fn bricks_that_are_all_in_or_all_out_join_like_any_other() {
    let dims = [64, 33, 34];
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for round in 0..4 {
        // Bricks of one value beside bricks of noise, so that every kind of border is met.
        let kinds: Vec<u32> = (0..8).map(|_| rng.random_range(0..4)).collect();
        let set = each(dims, |v| {
            let [x, y, z] = v.map(|v| v / BRICK);
            match kinds[(x + 2 * (y + 2 * z)) as usize] {
                0 => true,
                1 => false,
                _ => rng.random_range(0.0..1.0) < 0.3,
            }
        });
        for connectivity in ALL {
            hold(&set, dims, connectivity, &format!("round {round} {connectivity:?}"));
        }
    }
}

#[test]
fn what_meets_at_an_edge_or_a_corner_of_bricks_is_one_only_where_that_counts() {
    let dims = [64, 64, 64];
    // Two bricks and two single voxels, diagonal to each other, everywhere that bricks meet.
    for (a, b, joined) in [
        ([31, 40, 40], [32, 40, 40], [true, true, true]),
        ([31, 31, 40], [32, 32, 40], [false, true, true]),
        ([32, 31, 40], [31, 32, 40], [false, true, true]),
        ([40, 32, 31], [40, 31, 32], [false, true, true]),
        ([31, 31, 31], [32, 32, 32], [false, false, true]),
        ([32, 31, 31], [31, 32, 32], [false, false, true]),
        ([31, 32, 31], [32, 31, 32], [false, false, true]),
        ([32, 32, 31], [31, 31, 32], [false, false, true]),
        ([31, 20, 20], [32, 21, 21], [false, false, true]),
        ([20, 31, 31], [21, 32, 32], [false, false, true]),
    ] {
        for whole in [false, true] {
            let holds = |v: [u32; 3], w: [u32; 3]| if whole { v.map(|x| x / 32) == w.map(|x| x / 32) } else { v == w };
            let set = each(dims, |v| holds(v, a) || holds(v, b));
            for (connectivity, joined) in ALL.into_iter().zip(joined) {
                let found = components(&set, dims, connectivity);
                // Whole bricks meet by whatever their places have in common.
                let differing = (0..3).filter(|&i| a[i] / 32 != b[i] / 32).count();
                let joined = if whole { differing <= [1, 2, 3][connectivity as usize] } else { joined };
                assert_eq!(found.at(a) == found.at(b), joined, "{a:?} {b:?} {connectivity:?} {whole}");
            }
        }
    }
}

#[test]
fn a_snake_through_all_bricks_is_one() {
    // The longest way: what union-find must not be slow or wrong on.
    let dims = [70, 41, 37];
    let set = each(dims, |[x, y, z]| match (y % 2, z % 2) {
        (0, 0) => true,
        (1, 0) => x == if y / 2 % 2 == 0 { dims[0] - 1 } else { 0 },
        (0, 1) => x == 0 && y == if z / 2 % 2 == 0 { dims[1] - 1 } else { 0 },
        _ => false,
    });
    hold(&set, dims, Connectivity::Six, "snake");
    assert_eq!(components(&set, dims, Connectivity::Six).len(), 1);
    assert!(components(&vec![false; set.len()], dims, Connectivity::Six).is_empty());
}

#[test]
fn a_mask_that_fails_is_what_is_said() {
    let failed =
        Components::new(
            [40; 3],
            Connectivity::Six,
            |index| {
                if index.0 == [1, 0, 1] { Err("no") } else { Ok(BrickMask::All) }
            },
        );
    assert_eq!(failed.map(|c| c.len()), Err("no"));
}

#[test]
fn masks_are_cut_and_joined_voxel_by_voxel() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let valid = [32, 7, 19];
    let kinds = |rng: &mut ChaCha8Rng| {
        let share = [0.0, 0.4, 1.0][rng.random_range(0..3)];
        let voxels = each(valid, |_| rng.random_range(0.0..1.0) < share);
        let mask = BrickMask::new(valid, |v| voxels[place(v, valid)]);
        (voxels, mask)
    };
    for _ in 0..40 {
        let ((a, a_mask), (b, b_mask)) = (kinds(&mut rng), kinds(&mut rng));
        let expected = |f: fn(bool, bool) -> bool| BrickMask::new(valid, |v| f(a[place(v, valid)], b[place(v, valid)]));
        assert_eq!(a_mask.clone().and(b_mask.clone(), valid), expected(|a, b| a && b));
        assert_eq!(a_mask.clone().or(b_mask.clone(), valid), expected(|a, b| a || b));
        assert_eq!(a_mask.clone().without(&b_mask, valid), expected(|a, b| a && !b));
        assert_eq!(a_mask.count(valid), a.iter().filter(|v| **v).count() as u64);
    }
}
