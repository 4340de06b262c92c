//! Projects on disk: what is saved comes back, and a save writes what changed.

use super::keep_support::*;
use crate::common::one::{One, segments};
use burin::document::{
    Autosave, DensityKeeping, KeepError, LoadedDensity, Origin, RestoredDocument, SavedPoses, State,
};
use burin::math::DVec3;
use burin::volume::*;
use std::collections::BTreeMap;
use std::path::Path;

fn reopened(dir: &Path) -> (Autosave, State) {
    let (autosave, kept) = Autosave::open(dir).unwrap();
    (autosave, state_of(kept))
}

fn state_of(kept: RestoredDocument) -> State {
    kept.into_state(|_| panic!("the density is in the project"), &|_| true).unwrap()
}

fn save(autosave: &mut Autosave, path: Option<&Path>, state: &State) -> burin::document::Saved {
    autosave.save(path, state, None, &|_| true).unwrap()
}

/// A saved project in `dir/project`, with a private recovery folder.
fn saved(dir: &Path, state: &State) -> Autosave {
    let mut autosave = Autosave::unsaved(dir, state).unwrap();
    save(&mut autosave, Some(&dir.join("project")), state);
    autosave
}

fn files(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    fn walk(root: &Path, dir: &Path, into: &mut BTreeMap<String, Vec<u8>>) {
        for entry in std::fs::read_dir(dir).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(root, &path, into);
            } else {
                let name = path.strip_prefix(root).unwrap().to_str().unwrap().to_owned();
                into.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    let mut all = BTreeMap::new();
    walk(dir, dir, &mut all);
    all
}

#[test]
fn a_saved_document_opens_as_it_was() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(DIMS, dir.path());
    paint_all(&mut state);
    state.scene.views.crosshair = DVec3::new(0.1, -1.0 / 3.0, 1e-300);
    segments(&mut state.scene).ensure(3);
    drop(saved(dir.path(), &state));
    let (_keeper, again) = reopened(&dir.path().join("project"));
    assert_same(&state, &again, "reopened");
    // Nothing of the original is needed any more.
    assert_eq!(again.one().source.name(), "test volume");
    assert_eq!(again.one().statistics, state.one().statistics);
    assert_eq!(again.one().histogram, state.one().histogram);
    let dims = state.one().grid().dims;
    assert_eq!(again.one().source.read([0; 3], dims).unwrap(), state.one().source.read([0; 3], dims).unwrap());
}

#[test]
fn every_voxel_type_comes_back_bit_for_bit() {
    let dims = [37, 33, 35];
    for ty in [
        VoxelType::U8,
        VoxelType::I8,
        VoxelType::U16,
        VoxelType::I16,
        VoxelType::U32,
        VoxelType::I32,
        VoxelType::U64,
        VoxelType::I64,
        VoxelType::F32,
        VoxelType::F64,
    ] {
        let dir = tempfile::tempdir().unwrap();
        // Random bits: NaN with payloads, infinities and −0 among the floats.
        let voxels = random_voxels(ty, dims, 3);
        let state = state_over(source(dims, voxels, (0.5, -3.0)), [-10.0, 10.0], 1, dir.path());
        drop(saved(dir.path(), &state));
        let (_keeper, again) = reopened(&dir.path().join("project"));
        let (a, b) = (state.one().source.read([0; 3], dims).unwrap(), again.one().source.read([0; 3], dims).unwrap());
        assert_eq!((a.voxel_type(), a.as_bytes() == b.as_bytes()), (b.voxel_type(), true), "{ty:?}");
        assert_eq!(again.one().source.scaling(), (0.5, -3.0));
    }
}

#[test]
fn a_box_read_from_a_project_is_the_box_of_its_source() {
    let dir = tempfile::tempdir().unwrap();
    let state = state(DIMS, dir.path());
    drop(saved(dir.path(), &state));
    let (_keeper, again) = reopened(&dir.path().join("project"));
    for (lo, size) in
        [([0; 3], [1; 3]), ([31, 31, 31], [2, 2, 2]), ([127, 0, 60], [23, 40, 10]), ([149, 39, 69], [1; 3])]
    {
        assert_eq!(
            again.one().source.read(lo, size).unwrap(),
            state.one().source.read(lo, size).unwrap(),
            "{lo:?} {size:?}"
        );
    }
    let beyond = again.one().source.read([149, 39, 69], [2, 1, 1]).unwrap_err();
    assert!(matches!(beyond, SourceError::OutOfBounds { .. }));
}

#[test]
fn a_save_writes_the_shards_that_changed_and_links_the_others() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(DIMS, dir.path());
    paint_all(&mut state);
    let mut autosave = saved(dir.path(), &state);
    let project = dir.path().join("project");
    let first = files(&project.join("generation-000001"));
    paint(&mut state, FieldKind::Selection, [0, 0, 1], 99);
    let second = save(&mut autosave, None, &state);
    assert_eq!(second.generation, 2);
    let all = files(&project.join("generation-000002"));
    assert_eq!(first.keys().collect::<Vec<_>>(), all.keys().collect::<Vec<_>>());
    let changed: Vec<_> =
        all.iter().filter(|(name, bytes)| first[*name] != **bytes).map(|(name, _)| &name[..]).collect();
    assert_eq!(changed, ["generation.json", "volumes/0/selection/0/c/0/0/0"]);
    // Only these two were written, every other file is the same file.
    let written: usize = changed.iter().map(|name| all[*name].len()).sum();
    assert_eq!(second.bytes_written, written as u64);
    assert_eq!(second.files_linked as usize, all.len() - 2);
    #[cfg(unix)]
    for name in all.keys().filter(|n| !changed.contains(&&n[..])) {
        use std::os::unix::fs::MetadataExt;
        let inode = |g: &str| std::fs::metadata(project.join(g).join(name)).unwrap().ino();
        assert_eq!(inode("generation-000001"), inode("generation-000002"), "{name}");
    }
    // A save after an undo back to what was saved writes no shard at all.
    let before = state.one().selection.edits().len();
    let third = save(&mut autosave, None, &state);
    assert_eq!(
        (third.bytes_written as usize, before),
        (files(&project.join("generation-000003"))["generation.json"].len(), 4 + 2)
    );
    // The generation before the current one is kept, older ones go.
    assert!(!project.join("generation-000001").exists() && project.join("generation-000002").exists());
    assert_same(
        &state,
        &{
            drop(autosave);
            reopened(&project)
        }
        .1,
        "third",
    );
}

#[test]
fn a_brick_that_is_empty_again_takes_its_shard_away() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(DIMS, dir.path());
    paint(&mut state, FieldKind::Labels, [4, 0, 0], 1);
    let mut autosave = saved(dir.path(), &state);
    let project = dir.path().join("project");
    assert!(project.join("generation-000001/volumes/0/labels/0/c/0/0/1").exists());
    state.one_mut().labels.swap(vec![(BrickIndex([4, 0, 0]), None)]).unwrap();
    save(&mut autosave, None, &state);
    assert!(!project.join("generation-000002/volumes/0/labels/0/c/0/0/1").exists());
    drop(autosave);
    assert_same(&state, &reopened(&project).1, "emptied");
}

#[test]
fn a_source_goes_on_reading_after_its_generation_is_gone() {
    let dir = tempfile::tempdir().unwrap();
    let state = state(DIMS, dir.path());
    drop(saved(dir.path(), &state));
    let (mut autosave, kept) = Autosave::open(&dir.path().join("project")).unwrap();
    let LoadedDensity::Whole(source) = &kept.one().density else { panic!("whole") };
    for _ in 0..3 {
        save(&mut autosave, None, &state);
    }
    assert!(!dir.path().join("project/generation-000001").exists());
    // Nothing was read before, so nothing is remembered.
    assert_eq!(source.read([0; 3], DIMS).unwrap(), state.one().source.read([0; 3], DIMS).unwrap());
}

#[test]
fn density_may_stay_in_its_file_as_long_as_that_is_the_same() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(DIMS, dir.path());
    paint_all(&mut state);
    let project = dir.path().join("project");
    let mut autosave = Autosave::unsaved(dir.path(), &state).unwrap();
    autosave.save(Some(&project), &state, Some(DensityKeeping::Linked), &|_| true).unwrap();
    assert!(!project.join("generation-000001/volumes/0/density").exists());
    drop(autosave);
    let (mut autosave, kept) = Autosave::open(&project).unwrap();
    let LoadedDensity::Linked(path) = &kept.one().density else { panic!("linked") };
    assert_eq!(*path, std::fs::canonicalize(&state.scene.origin().unwrap().path).unwrap());
    let source = state.one().source.clone();
    let again = kept.into_state(|_| Ok(source.clone()), &|_| true).unwrap();
    assert_same(&state, &again, "linked");
    // It stays so until told otherwise, and may become whole.
    save(&mut autosave, None, &again);
    assert!(!project.join("generation-000002/volumes/0/density").exists());
    autosave.save(None, &again, Some(DensityKeeping::Whole), &|_| true).unwrap();
    drop(autosave);
    assert_same(&state, &reopened(&project).1, "whole");

    let other = dir.path().join("other");
    let mut autosave = Autosave::unsaved(dir.path(), &state).unwrap();
    autosave.save(Some(&other), &state, Some(DensityKeeping::Linked), &|_| true).unwrap();
    drop(autosave);
    std::fs::write(&state.scene.origin().unwrap().path, b"the file that was opeNed").unwrap();
    // It opens at once; what is wrong is known when the hash is, and saving waits for that.
    let (mut autosave, kept) = Autosave::open(&other).unwrap();
    let seen = kept.into_state(|_| Ok(state.one().source.clone()), &|_| true).unwrap();
    let message = autosave.save(None, &seen, None, &|_| true).unwrap_err().to_string();
    assert!(message.contains("origin.bin: blake3: ") && message.contains(" found, "), "{message}");
    assert_eq!(seen.files[&VolumeId::FIRST].trouble(), Some(message));
    drop(autosave);
    std::fs::write(&state.scene.origin().unwrap().path, b"longer than the file that was opened").unwrap();
    let message = Autosave::open(&other).unwrap_err().to_string();
    assert!(message.contains("origin.bin: bytes: 36 found, 24 expected"), "{message}");
}

#[test]
fn one_project_is_open_once() {
    let dir = tempfile::tempdir().unwrap();
    let autosave = saved(dir.path(), &state(DIMS, dir.path()));
    let project = dir.path().join("project");
    let message = Autosave::open(&project).unwrap_err().to_string();
    assert!(message.contains(&format!("process {}", std::process::id())), "{message}");
    assert!(message.contains("is open in another window or script"), "{message}");
    drop(autosave);
    Autosave::open(&project).unwrap();
}

#[test]
fn a_project_can_be_looked_at_while_it_is_open() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(DIMS, dir.path());
    let mut autosave = saved(dir.path(), &state);
    let project = dir.path().join("project");
    for n in 0..2 {
        let (kind, index, _) = paint(&mut state, FieldKind::Labels, [n, 0, 0], u64::from(n));
        let command = burin::document::Command::Selection(burin::document::SelectionCommand::Clear { volume: None });
        autosave.record(&command, &state, &[(kind, index)], true).unwrap();
        let before = files(&project);
        let seen = Autosave::look(&project).unwrap();
        assert_eq!(seen.recovered.steps, 1);
        assert_same(&state, &state_of(seen), "seen");
        assert_eq!(files(&project).keys().collect::<Vec<_>>(), before.keys().collect::<Vec<_>>());
        save(&mut autosave, None, &state);
    }
    assert_same(&state, &state_of(Autosave::look(&project).unwrap()), "saved");
}

#[test]
fn a_new_project_takes_no_folder_with_something_in_it() {
    let dir = tempfile::tempdir().unwrap();
    let state = state(DIMS, dir.path());
    let mut autosave = Autosave::unsaved(dir.path(), &state).unwrap();
    let refused = autosave.save(Some(dir.path()), &state, None, &|_| true).unwrap_err();
    assert!(matches!(&refused, KeepError::NotEmpty { found, .. } if found == "origin.bin"), "{refused}");
    assert!(matches!(autosave.save(None, &state, None, &|_| true), Err(KeepError::NoPath)));
    // What a failed first save made is gone again.
    let elsewhere = dir.path().join("elsewhere");
    let stopped = autosave.save(Some(&elsewhere), &state, None, &|_| false).unwrap_err();
    assert!(matches!(stopped, KeepError::Stopped) && !elsewhere.exists());
    autosave.discard().unwrap();
}

#[test]
fn a_range_narrower_than_a_step_of_the_data_and_steps_near_nothing_have_codes_that_are_kept() {
    let dir = tempfile::tempdir().unwrap();
    let dims = [8, 4, 3];
    let byte = source(dims, random_voxels(VoxelType::U8, dims, 3), (1.0, 0.0));
    let least = source(dims, random_voxels(VoxelType::U8, dims, 4), (1e-310, 0.0));
    for (n, (source, range)) in
        [(&byte, Some([0.0, 0.4])), (&byte, Some([10.2, 10.3])), (&byte, Some([-0.1, 0.1])), (&least, None)]
            .into_iter()
            .enumerate()
    {
        let (slope, _) = source.scaling();
        let statistics = Statistics { min: 0.0, max: 255.0 * slope, sum: 1.0, nan_count: 0, ..Statistics::default() };
        let histogram = Histogram { min: 0.0, max: 255.0 * slope, bins: vec![3, 0, 9, 1], ..Histogram::default() };
        let origin = Origin { path: dir.path().join("byte.nrrd"), component: 0, frame: 0 };
        let state = State::new(source.clone(), origin, statistics, histogram, range, &|_| true).unwrap();
        let map = *state.one().density.map();
        assert!(map.codes_per_unit.is_finite() && map.hi() > map.lo, "{range:?}: {map:?}");
        for end in range.into_iter().flatten() {
            assert!((map.decode(map.encode(end)) - end).abs() <= map.half_step() * 1.001, "{range:?}: {map:?}");
        }
        // A number that JSON has no word for would keep all of it from being saved.
        let project = dir.path().join(format!("p{n}"));
        Autosave::create(&project, &state, &SavedPoses::default(), None, &|_| true).unwrap();
        assert_eq!(Autosave::open(&project).unwrap().1.one().map, map);
    }
}
