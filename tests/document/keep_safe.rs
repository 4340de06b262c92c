//! Nothing in a project leads out of it, what waits for good is refused, and a folder that lost its first file is still a project.

use super::keep_support::*;
use burin::document::{Autosave, Command, KeepError, State, StrokeCommand, Wanted};
use burin::volume::FieldKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

const SMALL: [u32; 3] = [40, 33, 34];

fn saved(dir: &Path, state: &State, name: &str) -> (PathBuf, Autosave) {
    let project = dir.join(name);
    let mut autosave = Autosave::unsaved(dir, state).unwrap();
    autosave.save(Some(&project), state, None, &|_| true).unwrap();
    (project, autosave)
}

fn step(autosave: &mut Autosave, state: &mut State, seed: u64) {
    let (kind, index, _) = paint(state, FieldKind::Labels, [0; 3], seed);
    autosave.record(&Command::Stroke(StrokeCommand::End {}), state, &[(kind, index)], true).unwrap();
}

fn save(autosave: &mut Autosave, state: &State) -> u64 {
    autosave.save(None, state, None, &|_| true).unwrap().generation
}

fn names(dir: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        std::fs::read_dir(dir).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Every file below a folder with its bytes.
fn all(dir: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for name in names(dir) {
        let path = dir.join(name);
        if path.is_dir() { found.extend(all(&path)) } else { found.push((path.clone(), std::fs::read(&path).unwrap())) }
    }
    found
}

#[test]
#[cfg(unix)]
fn nothing_in_a_project_is_followed_out_of_it() {
    use std::os::unix::fs::symlink;
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    paint_all(&mut state);
    let (project, mut autosave) = saved(dir.path(), &state, "project");
    step(&mut autosave, &mut state, 5);
    drop(autosave);
    let outside = dir.path().join("outside");
    for name in [
        "lock",
        "project.json",
        "journal-000001",
        "generation-000001",
        "generation-000001/generation.json",
        "generation-000001/volumes/0/density",
        "generation-000001/volumes/0/density/0/c/0/0/0",
        "generation-000001/volumes/0/labels/0/c/0/0/0",
        "generation-000001/volumes/0/colour/0/c/0",
        "generation-000001/volumes/0/density_edits/edited/c/0/0/0",
    ] {
        let path = project.join(name);
        std::fs::rename(&path, &outside).unwrap();
        symlink(&outside, &path).unwrap();
        let before =
            if outside.is_dir() { all(&outside) } else { vec![(outside.clone(), std::fs::read(&outside).unwrap())] };
        let message = Autosave::open(&project).unwrap_err().to_string();
        assert!(message.contains(name.split('/').next_back().unwrap()), "{name}: {message}");
        assert!(message.contains("a symbolic link found"), "{name}: {message}");
        if name != "lock" {
            let looked = Autosave::look(&project).unwrap_err().to_string();
            assert!(looked.contains("a symbolic link found"), "{name}: {looked}");
        }
        let after =
            if outside.is_dir() { all(&outside) } else { vec![(outside.clone(), std::fs::read(&outside).unwrap())] };
        assert!(before == after, "{name}");
        std::fs::remove_file(&path).unwrap();
        std::fs::rename(&outside, &path).unwrap();
    }
    // A link to nothing makes nothing.
    for name in ["lock", "journal-000001"] {
        let path = project.join(name);
        std::fs::rename(&path, dir.path().join("aside")).unwrap();
        symlink(&outside, &path).unwrap();
        Autosave::open(&project).unwrap_err();
        assert!(!outside.exists(), "{name}");
        std::fs::remove_file(&path).unwrap();
        std::fs::rename(dir.path().join("aside"), &path).unwrap();
    }
    // The way to the project may be one.
    symlink(&project, dir.path().join("way")).unwrap();
    assert_kept(&state, &Autosave::open(&dir.path().join("way")).unwrap().1, "by a link");
    // What a save puts there takes a link's place and leaves alone what it leads to.
    std::fs::write(&outside, b"precious").unwrap();
    let (mut autosave, _) = Autosave::open(&project).unwrap();
    for name in ["project.new", "journal-000002", "generation-000002"] {
        symlink(&outside, project.join(name)).unwrap();
    }
    assert_eq!(save(&mut autosave, &state), 2);
    drop(autosave);
    assert_eq!(std::fs::read(&outside).unwrap(), b"precious");
    assert_kept(&state, &Autosave::open(&project).unwrap().1, "saved over links");
    assert!(std::fs::symlink_metadata(project.join("generation-000002")).unwrap().is_dir());
    // Neither is a damaged journal put aside through one.
    let journal = project.join("journal-000002");
    std::fs::write(&journal, b"no journal").unwrap();
    symlink(&outside, project.join("journal-000002.damaged")).unwrap();
    let (_keeper, kept) = Autosave::open(&project).unwrap();
    assert_eq!(std::fs::read(&outside).unwrap(), b"precious");
    assert_eq!(std::fs::read(&kept.recovered.set_aside.unwrap().0).unwrap(), b"no journal");
}

#[test]
#[cfg(unix)]
fn a_pipe_in_a_project_is_refused_at_once() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    paint_all(&mut state);
    let (project, autosave) = saved(dir.path(), &state, "project");
    drop(autosave);
    for name in [
        "lock",
        "project.json",
        "journal-000001",
        "generation-000001/generation.json",
        "generation-000001/volumes/0/density/0/c/0/0/0",
        "generation-000001/volumes/0/labels/0/c/0/0/0",
    ] {
        let path = project.join(name);
        std::fs::rename(&path, dir.path().join("aside")).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        let start = Instant::now();
        let message = Autosave::open(&project).unwrap_err().to_string();
        assert!(message.contains("a pipe found") && message.contains(&*path.to_string_lossy()), "{message}");
        assert!(start.elapsed() < Duration::from_secs(5), "{name}");
        std::fs::remove_file(&path).unwrap();
        std::fs::rename(dir.path().join("aside"), &path).unwrap();
    }
    Autosave::open(&project).unwrap();
}

#[test]
#[cfg(unix)]
fn what_has_another_name_elsewhere_is_not_written_into() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (project, mut autosave) = saved(dir.path(), &state, "project");
    step(&mut autosave, &mut state, 1);
    drop(autosave);
    let (precious, other) = (dir.path().join("precious"), dir.path().join("journal of a copy"));
    std::fs::write(&precious, b"process of making steel").unwrap();
    std::fs::remove_file(project.join("lock")).unwrap();
    std::fs::hard_link(&precious, project.join("lock")).unwrap();
    std::fs::hard_link(project.join("journal-000001"), &other).unwrap();
    let before = std::fs::read(&other).unwrap();
    let (mut autosave, _) = Autosave::open(&project).unwrap();
    step(&mut autosave, &mut state, 2);
    drop(autosave);
    assert_eq!(std::fs::read(&precious).unwrap(), b"process of making steel");
    assert!(std::fs::read(&other).unwrap() == before);
    assert_kept(&state, &Autosave::open(&project).unwrap().1, "noted in a journal of its own");
    // Nor is another file that is named as the lock is.
    std::fs::remove_file(project.join("lock")).unwrap();
    std::fs::write(project.join("lock"), b"a key").unwrap();
    drop(Autosave::open(&project).unwrap());
    assert_eq!(std::fs::read(project.join("lock")).unwrap(), b"a key");
}

#[test]
fn a_folder_that_lost_its_first_file_is_a_project_and_no_leftover() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (project, mut autosave) = saved(dir.path(), &state, "project");
    let first = state.clone();
    paint_all(&mut state);
    assert_eq!(save(&mut autosave, &state), 2);
    step(&mut autosave, &mut state, 3);
    drop(autosave);
    std::fs::remove_file(project.join("project.json")).unwrap();
    let before = all(&project);
    // Somebody else's save is refused and harms nothing.
    let mut other = Autosave::unsaved(dir.path(), &first).unwrap();
    let refused = other.save(Some(&project), &first, None, &|_| true).unwrap_err();
    assert!(matches!(&refused, KeepError::LostProject { generation: Some(2), .. }), "{refused}");
    assert!(all(&project) == before);
    other.discard().unwrap();
    // The newest generation opens, with the steps in its journal.
    let seen = Autosave::look(&project).unwrap();
    assert_kept(&state, &seen, "looked at");
    let (mut autosave, kept) = Autosave::open(&project).unwrap();
    assert_eq!(kept.recovered.steps, 1);
    assert!(kept.recovered.told[0].contains("project.json is missing; generation 2"), "{:?}", kept.recovered.told);
    assert_kept(&state, &kept, "opened");
    assert_eq!(save(&mut autosave, &state), 3);
    drop(autosave);
    let again = Autosave::open(&project).unwrap().1;
    assert_eq!(again.recovered.told, [""; 0]);
    assert_kept(&state, &again, "a project again");
}

#[test]
fn the_newest_whole_generation_is_taken_and_a_damaged_one_left() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (project, mut autosave) = saved(dir.path(), &state, "project");
    let first = state.clone();
    paint_all(&mut state);
    save(&mut autosave, &state);
    step(&mut autosave, &mut state, 3);
    drop(autosave);
    let broken = project.join("generation-000002/volumes/0/labels/0/c/0/0/0");
    std::fs::write(&broken, b"no shard").unwrap();
    // The project says which it is, and what could be opened instead.
    let error = Autosave::open(&project).unwrap_err();
    assert!(matches!(&error, KeepError::Damaged { whole: 1, .. }), "{error}");
    let message = error.to_string();
    assert!(message.contains("labels/0/c/0/0/0") && message.contains("project.open generation 1"), "{message}");
    let (autosave, kept) = Autosave::open_wanted(&project, Wanted { generation: Some(1), source: None }).unwrap();
    assert_kept(&first, &kept, "asked for");
    drop(autosave);
    // The same by a command, as the message says it.
    let open = |more: serde_json::Value| {
        let mut open = serde_json::json!({ "path": project });
        open.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        let mut document = burin::document::Document::new();
        let done = document.apply(serde_json::from_value(serde_json::json!({ "project": { "open": open } })).unwrap());
        done.map(|_| difference(&first, document.state().unwrap()))
    };
    assert!(open(serde_json::json!({})).is_err());
    assert_eq!(open(serde_json::json!({ "generation": 1 })).unwrap(), None);
    let journal = std::fs::read(project.join("journal-000002")).unwrap();
    std::fs::remove_file(project.join("project.json")).unwrap();
    let (mut autosave, kept) = Autosave::open(&project).unwrap();
    let told = &kept.recovered.told[0];
    assert!(told.contains("generation 1, the newest that is whole") && told.contains("labels/0/c/0/0/0"), "{told}");
    assert_kept(&first, &kept, "whole");
    assert_eq!(save(&mut autosave, &first), 3);
    assert_eq!(std::fs::read(&broken).unwrap(), b"no shard");
    drop(autosave);
    // Steps that nobody has read are put aside, or left.
    let kept_journal = all(&project).into_iter().any(|(_, bytes)| bytes == journal);
    assert!(kept_journal, "{:?}", names(&project));
    assert_kept(&first, &Autosave::open(&project).unwrap().1, "again");
}

#[test]
fn a_folder_with_a_number_that_no_save_gave_is_no_generation() {
    let dir = tempfile::tempdir().unwrap();
    let state = state(SMALL, dir.path());
    let (project, mut autosave) = saved(dir.path(), &state, "project");
    let odd = project.join(format!("generation-{}", u64::MAX));
    std::fs::create_dir(&odd).unwrap();
    std::fs::write(odd.join("generation.json"), b"{}").unwrap();
    assert_eq!(save(&mut autosave, &state), 2);
    drop(autosave);
    assert_kept(&state, &Autosave::open(&project).unwrap().1, "beside it");
}

#[test]
fn a_save_whose_journal_cannot_be_made_leaves_the_current_generation() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (project, mut autosave) = saved(dir.path(), &state, "project");
    let before = state.clone();
    paint_all(&mut state);
    std::fs::create_dir_all(project.join("journal-000002/full")).unwrap();
    let refused = autosave.save(None, &state, None, &|_| true).unwrap_err().to_string();
    assert!(refused.contains("journal-000002"), "{refused}");
    assert_eq!(names(&project), ["generation-000001", "journal-000001", "journal-000002", "lock", "project.json"]);
    drop(autosave);
    assert_kept(&before, &Autosave::open(&project).unwrap().1, "as it was");
}

#[test]
fn damaged_journals_that_were_put_aside_stay() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (project, mut autosave) = saved(dir.path(), &state, "project");
    let mut aside: Vec<(PathBuf, Vec<u8>)> = Vec::new();
    for round in 0..3 {
        for seed in 0..3 {
            step(&mut autosave, &mut state, round * 10 + seed);
        }
        drop(autosave);
        let path =
            project.join(names(&project).into_iter().find(|n| n.starts_with("journal-") && !n.contains('.')).unwrap());
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[60] ^= 1;
        std::fs::write(&path, &bytes).unwrap();
        // Not saved between the first and the second: both journals have the same name.
        let (again, kept) = Autosave::open(&project).unwrap();
        let (place, reason) = kept.recovered.set_aside.clone().unwrap();
        assert!(reason.contains("are lost") && reason.contains(" bytes from there on"), "{reason}");
        aside.push((place, bytes));
        state = kept.into_state(|_| panic!("whole"), &|_| true).unwrap();
        autosave = again;
        if round > 0 {
            save(&mut autosave, &state);
        }
        for (place, bytes) in &aside {
            assert!(std::fs::read(place).is_ok_and(|found| found == *bytes), "{}", place.display());
        }
    }
    assert_eq!(aside.iter().map(|(place, _)| place).collect::<std::collections::BTreeSet<_>>().len(), 3);
}
