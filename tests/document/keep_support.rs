//! Small documents for the tests of keeping, and the comparison of all that is kept.

use crate::common::one::One;
use burin::document::{LoadedDensity, Origin, RestoredDocument, State};
use burin::math::{DAffine3, DMat3, DVec3};
use burin::volume::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::Path;
use std::sync::Arc;

/// Not a multiple of bricks, more than one shard along x, oblique and anisotropic.
pub const DIMS: [u32; 3] = [150, 40, 70];

pub fn grid(dims: [u32; 3]) -> Grid {
    let turn = DMat3::from_rotation_z(0.3) * DMat3::from_rotation_x(-0.2);
    let matrix3 = turn * DMat3::from_diagonal(DVec3::new(0.7, 1.1, -2.5));
    Grid { dims, world_from_index: DAffine3 { matrix3, translation: DVec3::new(-31.25, 17.5, 1e-3) } }
}

pub fn source(dims: [u32; 3], voxels: Voxels, scaling: (f64, f64)) -> Arc<MemorySource> {
    Arc::new(MemorySource::new("test volume", grid(dims), voxels, scaling).unwrap())
}

pub fn random_voxels(ty: VoxelType, dims: [u32; 3], seed: u64) -> Voxels {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let count = dims.iter().map(|&d| d as usize).product();
    let mut voxels = Voxels::try_zeroed(ty, count).unwrap();
    rng.fill(voxels.as_bytes_mut());
    voxels
}

/// A document over a source; its origin is a file in `dir`.
pub fn state_over(source: Arc<dyn BrickSource>, range: [f64; 2], nan_count: u64, dir: &Path) -> State {
    let path = dir.join("origin.bin");
    std::fs::write(&path, b"the file that was opened").unwrap();
    let statistics = Statistics { min: range[0], max: range[1], sum: 1.5, nan_count, ..Statistics::default() };
    let histogram = Histogram { min: range[0], max: range[1], bins: vec![3, 0, 9, 1], ..Histogram::default() };
    let origin = Origin { path, component: 0, frame: 0 };
    State::new(source, origin, statistics, histogram, None, &|_| true).unwrap()
}

/// A document of u16 with a random volume.
pub fn state(dims: [u32; 3], dir: &Path) -> State {
    let voxels = random_voxels(VoxelType::U16, dims, 7);
    state_over(source(dims, voxels, (1.0, 0.0)), [0.0, 65_535.0], 0, dir)
}

/// A brick of random texels, or of one value for some seeds.
pub fn random_brick(kind: FieldKind, format: TexelFormat, seed: u64) -> Brick {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut texels = vec![0_u8; BRICK_VOXELS * format.bytes()];
    match (seed % 5, kind) {
        (0, _) => texels.chunks_exact_mut(format.bytes()).for_each(|t| t[0] = 9),
        (_, FieldKind::Labels) => texels.chunks_exact_mut(2).for_each(|t| t[0] = rng.random_range(0..4)),
        // NaN would make texels that differ from themselves in no bit but compare unequal as numbers; bytes are compared here.
        _ => rng.fill(&mut texels[..]),
    }
    Brick::from_texels(texels, format.bytes())
}

/// Paints a brick of a field.
pub fn paint(state: &mut State, kind: FieldKind, index: [u32; 3], seed: u64) -> (FieldKey, BrickIndex, Option<Brick>) {
    let brick = random_brick(kind, state.one().field(kind).format(), seed);
    let index = BrickIndex(index);
    state.one_mut().field_mut(kind).swap(vec![(index, Some(brick))]).unwrap();
    (key(kind), index, state.one().field(kind).edit(index).cloned())
}

/// Every kind of field painted, at the volume's corners and in between.
pub fn paint_all(state: &mut State) {
    let last = state.one().density.brick_dims(0).map(|d| d - 1);
    for (i, kind) in FieldKind::ALL.into_iter().enumerate() {
        for (j, index) in [[0; 3], last, [last[0], 0, 0], [last[0] / 2, 0, last[2]]].into_iter().enumerate() {
            paint(state, kind, index, (10 * i + j) as u64);
        }
    }
    // An edit to 0 is an edit of density, and none of what was never painted.
    let zero = || vec![(BrickIndex([1, 0, 0]), Some(Brick::Uniform([0; 4])))];
    for kind in FieldKind::ALL {
        state.one_mut().field_mut(kind).swap(zero()).unwrap();
    }
}

/// What differs between two documents: scene, grid, map and edits of every field.
pub fn difference(a: &State, b: &State) -> Option<String> {
    if a.scene != b.scene {
        return Some(format!("scene: {:?}\n{:?}", a.scene, b.scene));
    }
    if a.one().grid() != b.one().grid() || a.one().density.map() != b.one().density.map() {
        return Some("grid or density map".into());
    }
    let differs = |kind: &FieldKind| painted(a, *kind) != painted(b, *kind);
    FieldKind::ALL.into_iter().find(differs).map(|kind| format!("edits of {}", kind.name()))
}

/// The edits that count: an empty brick of a field without a source is none.
fn painted(state: &State, kind: FieldKind) -> Vec<(BrickIndex, Brick)> {
    let edits = state.one().field(kind).edits().into_iter().map(|(i, b)| (i, b.clone()));
    edits.filter(|(_, b)| kind == FieldKind::Density || *b != Brick::Uniform([0; 4])).collect()
}

/// Fails if anything differs, level-0 texels included.
pub fn assert_same(a: &State, b: &State, what: &str) {
    if let Some(difference) = difference(a, b) {
        panic!("{what}: {difference}");
    }
    for kind in FieldKind::ALL {
        let dims = a.one().field(kind).dims(0);
        let (x, y) =
            (a.one().field(kind).read(0, [0; 3], dims).unwrap(), b.one().field(kind).read(0, [0; 3], dims).unwrap());
        assert!(x == y, "{what}: texels of {}", kind.name());
    }
}

/// Fails if a document came back other than it was: scene, grid, map, edits. Its source is not read.
pub fn assert_kept(state: &State, kept: &RestoredDocument, what: &str) {
    assert!(matches!(kept.one().density, LoadedDensity::Whole(_)), "{what}");
    assert_eq!(state.scene, kept.scene, "{what}");
    assert_eq!((*state.one().grid(), *state.one().density.map()), (kept.one().grid, kept.one().map), "{what}");
    for kind in FieldKind::ALL {
        let edits = kept.one().edits.get(&kind).into_iter().flatten().map(|(i, b)| (*i, b.clone()));
        let found: Vec<_> = edits.filter(|(_, b)| kind == FieldKind::Density || *b != Brick::Uniform([0; 4])).collect();
        assert!(painted(state, kind) == found, "{what}: edits of {}", kind.name());
    }
}

/// Writes a description of a generation that was changed, with the hash that it then has: that of its bytes with zeros in the
/// hash's place.
pub fn write_sealed(path: &Path, description: &serde_json::Value) {
    let mut description = description.clone();
    description["blake3"] = "0".repeat(64).into();
    let text = serde_json::to_string_pretty(&description).unwrap();
    let hash = blake3::hash(text.as_bytes()).to_hex();
    std::fs::write(path, text.replacen(&"0".repeat(64), &hash, 1)).unwrap();
}

/// A field of the volume that a document of one has.
pub fn key(kind: FieldKind) -> FieldKey {
    FieldKey::new(VolumeId::FIRST, kind)
}
