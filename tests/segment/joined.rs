//! Components over the faces of boxes of finer voxels, and who tells what is where, against little cubes.

use crate::common::raster::{Nest, Node, Raster};
use crate::common::volumes::each;
use burin::segment::{BrickMask, ComponentId, Connectivity, Joined, Lattice};
use burin::volume::{BRICK, BrickIndex, Standing, SubBox};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::{BTreeMap, BTreeSet};

type Failed = std::convert::Infallible;

fn standing(nests: &[Nest]) -> Vec<Standing> {
    let mut all: Vec<Standing> = Vec::new();
    for (l, nest) in nests.iter().enumerate() {
        let inner =
            nests.iter().filter_map(|nest| nest.within).filter(|(outer, _)| *outer == l).map(|(_, of)| of).collect();
        all.push(match nest.within {
            Some((outer, of)) => all[outer].of_inner(&of, inner),
            None => Standing::of_whole(nest.dims, inner),
        });
    }
    all
}

/// Boxes in a small volume: alone, at its border, side by side, one in another, also with a face in common, a chain of three.
fn nests() -> Vec<(u32, Vec<Nest>)> {
    let whole = || Nest::whole([7, 6, 6]);
    vec![
        (2, vec![whole(), Nest::of(0, [2, 1, 2], [5, 4, 4], [2; 3])]),
        (3, vec![whole(), Nest::of(0, [1, 1, 1], [3, 4, 3], [3, 1, 3])]),
        (1, vec![whole(), Nest::of(0, [2, 1, 2], [5, 4, 4], [1; 3])]),
        (2, vec![whole(), Nest::of(0, [0, 2, 0], [6, 4, 5], [2; 3])]),
        (2, vec![whole(), Nest::of(0, [0; 3], [6, 5, 5], [2, 1, 2])]),
        (
            6,
            vec![
                Nest::whole([5, 4, 4]),
                Nest::of(0, [1, 1, 1], [2, 3, 3], [2; 3]),
                Nest::of(0, [2, 1, 1], [4, 2, 3], [3; 3]),
            ],
        ),
        (4, vec![whole(), Nest::of(0, [1, 1, 1], [4, 4, 4], [2; 3]), Nest::of(1, [2, 2, 2], [4, 4, 5], [2; 3])]),
        // The inner box has a face where the outer one ends.
        (4, vec![whole(), Nest::of(0, [1, 1, 1], [4, 4, 4], [2; 3]), Nest::of(1, [0, 2, 0], [4, 4, 6], [2; 3])]),
        (
            4,
            vec![
                Nest::whole([5, 5, 4]),
                Nest::of(0, [0, 1, 1], [2, 3, 3], [2; 3]),
                Nest::of(0, [2, 0, 1], [4, 3, 2], [1; 3]),
                Nest::of(1, [2, 0, 0], [4, 3, 4], [2; 3]),
            ],
        ),
    ]
}

fn place(v: [u32; 3], dims: [u32; 3]) -> usize {
    v[0] as usize + dims[0] as usize * (v[1] as usize + dims[1] as usize * v[2] as usize)
}

#[test]
fn every_place_is_told_by_one_volume_and_each_voxel_stands_for_what_is_left_of_its_cell() {
    for (n, (fine, nests)) in nests().into_iter().enumerate() {
        let shares = Raster::new(&nests, fine).shares(&nests);
        let mut whole = 0.0;
        for (l, standing) in standing(&nests).iter().enumerate() {
            for voxel in each(nests[l].dims, |v| v) {
                let expected = shares.get(&(l, voxel)).copied().unwrap_or(0.0);
                let found = standing.share(voxel);
                assert!((found - expected).abs() < 1e-9, "{n}: {l} {voxel:?}: {found}, {expected} expected");
                // Of the outermost voxels what lies beyond the centres is nobody's to be asked about.
                assert_eq!(standing.is_asked(voxel), expected > 0.0, "{n}: {l} {voxel:?}");
                assert!(standing.is_odd_in(BrickIndex::of_voxel(voxel)) || found == 1.0, "{n}: {l} {voxel:?}: {found}");
                let mut nest = &nests[l];
                let mut size = 1.0;
                while let Some((outer, SubBox { scale, .. })) = nest.within {
                    size /= scale.iter().map(|s| f64::from(*s)).product::<f64>();
                    nest = &nests[outer];
                }
                whole += found * size;
            }
        }
        let voxels: f64 = nests[0].dims.iter().map(|d| f64::from(*d)).product();
        assert!((whole - voxels).abs() < 1e-6, "{n}: {whole} of {voxels}");
    }
}

fn hold((fine, nests): &(u32, Vec<Nest>), connectivity: Connectivity, seed: u64, share: f64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let sets: Vec<Vec<bool>> =
        nests.iter().map(|nest| each(nest.dims, |_| rng.random_range(0.0..1.0) < share)).collect();
    let standing = standing(nests);
    let lattices: Vec<Lattice<'_>> =
        nests.iter().zip(&standing).map(|(nest, standing)| Lattice { standing, within: nest.within }).collect();
    let found = Joined::new(&lattices, connectivity, |l, index: BrickIndex| {
        let (origin, dims) = (index.origin(), nests[l].dims);
        let valid: [u32; 3] = std::array::from_fn(|a| BRICK.min(dims[a] - origin[a]));
        Ok::<_, Failed>(BrickMask::new(valid, |v| {
            let v = std::array::from_fn(|a| origin[a] + v[a]);
            sets[l][place(v, dims)] && standing[l].is_asked(v)
        }))
    })
    .unwrap();
    let most = match connectivity {
        Connectivity::Six => 1,
        Connectivity::Eighteen => 2,
        Connectivity::TwentySix => 3,
    };
    let expected = Raster::new(nests, *fine).components(most, |(l, v)| sets[l][place(v, nests[l].dims)]);
    let mut by_id: BTreeMap<ComponentId, BTreeSet<Node>> = BTreeMap::new();
    for (l, nest) in nests.iter().enumerate() {
        for v in each(nest.dims, |v| v) {
            if let Some(id) = found.at(l, v) {
                by_id.entry(id).or_default().insert((l, v));
            }
        }
    }
    let what = format!("{nests:?} {connectivity:?} {seed}");
    assert_eq!(found.len(), expected.len(), "{what}");
    for (id, own) in &by_id {
        assert_eq!(found.size(*id), own.len() as u64, "{what}");
    }
    let sorted = |mut all: Vec<BTreeSet<Node>>| {
        all.sort();
        all
    };
    assert!(sorted(by_id.into_values().collect()) == sorted(expected), "{what}");
}

#[test]
fn what_is_connected_over_the_faces_of_boxes_is_what_touches_there() {
    for nests in nests() {
        for (seed, share) in [(1, 0.25), (2, 0.4)] {
            hold(&nests, Connectivity::Six, seed, share);
        }
    }
}

#[test]
fn edges_and_corners_count_over_faces_where_they_count_elsewhere() {
    for nests in nests().into_iter().take(5) {
        for connectivity in [Connectivity::Eighteen, Connectivity::TwentySix] {
            hold(&nests, connectivity, 3, 0.12);
        }
    }
}
