//! The journal: what was done since the last save comes back, whole steps only, once.

use super::keep_support::*;
use crate::common::one::{One, segments};
use burin::document::{Autosave, BrushCommand, Command, KeepError, RestoredDocument, State, StrokeCommand, recovery};
use burin::io::{Told, Witness};
use burin::math::DVec3;
use burin::paint::Sample;
use burin::volume::*;
use std::path::{Path, PathBuf};

const SMALL: [u32; 3] = [70, 33, 34];

fn command() -> Command {
    Command::Stroke(StrokeCommand::End {})
}

fn other_command() -> Command {
    serde_json::from_value::<BrushCommand>(serde_json::json!({ "set": { "radius_mm": 2.0 } }))
        .map(Command::Brush)
        .unwrap()
}

fn reopened(project: &Path) -> (RestoredDocument, burin::document::Recovered) {
    let (_keeper, kept) = Autosave::open(project).unwrap();
    let recovered = kept.recovered.clone();
    (kept, recovered)
}

fn project(dir: &Path, state: &State) -> (Autosave, PathBuf) {
    let project = dir.join("project");
    let mut autosave = Autosave::unsaved(dir, state).unwrap();
    autosave.save(Some(&project), state, None, &|_| true).unwrap();
    (autosave, project)
}

/// One step of each sort of change, deterministic; the same number gives the same step.
fn step(state: &mut State, n: u64) -> Vec<(FieldKey, BrickIndex)> {
    let dims = state.one().density.brick_dims(0);
    let kind = FieldKind::ALL[(n % 4) as usize];
    let index =
        [(n % u64::from(dims[0])) as u32, (n / 3 % u64::from(dims[1])) as u32, (n / 5 % u64::from(dims[2])) as u32];
    state.scene.views.crosshair = DVec3::new(n as f64, 0.5, -0.25);
    if n.is_multiple_of(3) {
        segments(&mut state.scene).ensure(n as u16);
    }
    if n % 7 == 6 {
        // As an undo does: the edit is gone.
        let index = BrickIndex(index);
        state.one_mut().field_mut(kind).swap(vec![(index, None)]).unwrap();
        return vec![(key(kind), index)];
    }
    let (kind, index, _) = paint(state, kind, index, 1000 + n);
    vec![(kind, index)]
}

fn sample(x: f64) -> Sample {
    Sample { position: DVec3::new(x, 1.0 / 3.0, -2.0), normal: DVec3::Z, pressure: 0.5, breaks: false }
}

#[test]
fn steps_after_the_last_save_come_back() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    paint_all(&mut state);
    let (mut autosave, project) = project(dir.path(), &state);
    for n in 1..=20 {
        let touched = step(&mut state, n);
        autosave.record(&command(), &state, &touched, n % 2 == 0).unwrap();
    }
    drop(autosave);
    let (again, recovered) = reopened(&project);
    assert_kept(&state, &again, "recovered");
    assert_eq!((recovered.steps, recovered.torn_bytes, recovered.set_aside), (20, 0, None));
    assert_eq!(recovered.last, serde_json::to_value(command()).unwrap());
    // Opening is no step, and what came back is journaled still.
    assert_kept(&state, &reopened(&project).0, "recovered again");
}

#[test]
fn a_journal_goes_on_after_a_recovery_and_ends_with_a_save() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (mut autosave, project) = project(dir.path(), &state);
    let touched = step(&mut state, 1);
    autosave.record(&command(), &state, &touched, true).unwrap();
    drop(autosave);
    let (mut autosave, _) = Autosave::open(&project).unwrap();
    let touched = step(&mut state, 2);
    autosave.record(&command(), &state, &touched, true).unwrap();
    drop(autosave);
    let (again, recovered) = reopened(&project);
    assert_kept(&state, &again, "two sittings");
    assert_eq!(recovered.steps, 2);
    let (mut autosave, _) = Autosave::open(&project).unwrap();
    autosave.save(None, &state, None, &|_| true).unwrap();
    let touched = step(&mut state, 3);
    autosave.record(&command(), &state, &touched, true).unwrap();
    drop(autosave);
    let (again, recovered) = reopened(&project);
    assert_kept(&state, &again, "after a save");
    assert_eq!(recovered.steps, 1);
}

#[test]
fn a_journal_cut_anywhere_gives_the_steps_before_the_cut() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (mut autosave, project) = project(dir.path(), &state);
    let journal = project.join("journal-000001");
    let length = || std::fs::metadata(&journal).unwrap().len();
    let mut after = vec![(length(), state.clone())];
    for n in 1..=6 {
        let touched = step(&mut state, n);
        autosave.record(&command(), &state, &touched, false).unwrap();
        after.push((length(), state.clone()));
    }
    drop(autosave);
    let whole = std::fs::read(&journal).unwrap();
    assert_eq!(whole.len() as u64, after[6].0);
    // On both sides of every border between steps, within the 12 bytes of a record's head, and in between.
    let mut cuts: Vec<u64> =
        after.iter().flat_map(|(end, _)| [end.saturating_sub(1), *end, end + 1, end + 11, end + 13]).collect();
    cuts.extend((0..12).map(|i| after[0].0 + i * whole.len() as u64 / 12));
    for cut in cuts.into_iter().filter(|&c| c >= after[0].0 && c <= whole.len() as u64) {
        std::fs::write(&journal, &whole[..cut as usize]).unwrap();
        let (end, expected) = after.iter().rev().find(|(end, _)| *end <= cut).unwrap();
        let (again, recovered) = reopened(&project);
        assert_kept(expected, &again, &format!("cut at {cut}"));
        assert_eq!((recovered.torn_bytes, recovered.set_aside), (cut - end, None), "cut at {cut}");
    }
}

#[test]
fn a_damaged_record_ends_the_journal_and_a_copy_is_set_aside() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (mut autosave, project) = project(dir.path(), &state);
    let journal = project.join("journal-000001");
    let mut expected = state.clone();
    let mut border = 0;
    for n in 1..=4 {
        if n == 3 {
            (expected, border) = (state.clone(), std::fs::metadata(&journal).unwrap().len());
        }
        let touched = step(&mut state, n);
        autosave.record(&command(), &state, &touched, false).unwrap();
    }
    drop(autosave);
    let mut bytes = std::fs::read(&journal).unwrap();
    bytes[border as usize + 40] ^= 1;
    std::fs::write(&journal, &bytes).unwrap();
    let (again, recovered) = reopened(&project);
    assert_kept(&expected, &again, "before the damage");
    let (aside, what) = recovered.set_aside.unwrap();
    assert_eq!(std::fs::read(&aside).unwrap(), bytes);
    assert!(what.contains(&format!("record at byte {border}: its checksum does not match")), "{what}");
}

#[test]
fn a_record_whose_length_is_damaged_is_no_end_that_was_being_written() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (mut autosave, project) = project(dir.path(), &state);
    let journal = project.join("journal-000001");
    let mut borders = Vec::new();
    for n in 1..=4 {
        borders.push((std::fs::metadata(&journal).unwrap().len() as usize, state.clone()));
        let touched = step(&mut state, n);
        autosave.record(&command(), &state, &touched, false).unwrap();
    }
    drop(autosave);
    let whole = std::fs::read(&journal).unwrap();
    for (n, (border, expected)) in borders.iter().enumerate() {
        let mut bytes = whole.clone();
        bytes[border + 3] ^= 0x40;
        std::fs::write(&journal, &bytes).unwrap();
        let (again, recovered) = reopened(&project);
        assert_kept(expected, &again, &format!("before step {n}"));
        // Of the last record nobody can tell it from one that was being written.
        let Some((aside, what)) = recovered.set_aside else {
            assert_eq!(n, 3, "the steps after {n} are lost without a copy");
            continue;
        };
        assert_eq!(std::fs::read(&aside).unwrap(), bytes);
        assert!(what.contains(&format!("record at byte {border}: it is longer than the file")), "{what}");
    }
}

#[test]
fn a_record_that_is_there_twice_is_taken_once() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (mut autosave, project) = project(dir.path(), &state);
    let journal = project.join("journal-000001");
    let mut start = 0;
    for n in 1..=2 {
        start = std::fs::metadata(&journal).unwrap().len() as usize;
        let touched = step(&mut state, n);
        autosave.record(&command(), &state, &touched, false).unwrap();
    }
    drop(autosave);
    let mut bytes = std::fs::read(&journal).unwrap();
    let end = bytes.len();
    bytes.extend_from_within(start..);
    std::fs::write(&journal, &bytes).unwrap();
    let (again, recovered) = reopened(&project);
    assert_kept(&state, &again, "doubled");
    assert_eq!(recovered.steps, 2);
    assert!(recovered.set_aside.unwrap().1.contains(&format!("record at byte {end}: it is not the one after 2")));
}

#[test]
fn a_step_larger_than_a_record_is_there_whole_or_not_at_all() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state([160, 64, 160], dir.path());
    let (mut autosave, project) = project(dir.path(), &state);
    let journal = project.join("journal-000001");
    let before = state.clone();
    // 6 MiB that do not compress.
    let touched: Vec<_> = state
        .one()
        .colour
        .brick_indices(0)
        .into_iter()
        .enumerate()
        .map(|(i, index)| paint(&mut state, FieldKind::Colour, index.0, 5 * i as u64 + 1))
        .map(|(kind, index, _)| (kind, index))
        .collect();
    autosave.record(&command(), &state, &touched, false).unwrap();
    drop(autosave);
    let whole = std::fs::read(&journal).unwrap();
    assert_kept(&state, &reopened(&project).0, "whole");
    // The first record ends where its length says; what is left of the step is not done.
    let length = u32::from_le_bytes(std::array::from_fn(|i| whole[28 + i])) as usize;
    let first_end = 28 + 12 + length;
    assert!(first_end < whole.len() - (1 << 20), "{first_end} of {}", whole.len());
    std::fs::write(&journal, &whole[..first_end]).unwrap();
    let (again, recovered) = reopened(&project);
    assert_kept(&before, &again, "its first part");
    assert_eq!((recovered.steps, recovered.torn_bytes as usize), (0, first_end - 28));
    // And what is noted afterwards follows what was whole.
    let (mut autosave, _) = Autosave::open(&project).unwrap();
    let mut state = before;
    let touched = step(&mut state, 1);
    autosave.record(&command(), &state, &touched, false).unwrap();
    drop(autosave);
    assert_kept(&state, &reopened(&project).0, "the step after");
}

#[test]
fn a_journal_of_another_generation_is_never_replayed() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (mut autosave, project) = project(dir.path(), &state);
    let touched = step(&mut state, 1);
    autosave.record(&command(), &state, &touched, true).unwrap();
    let old = std::fs::read(project.join("journal-000001")).unwrap();
    // The user takes the step back by hand and saves: replaying the old journal would bring it back.
    state.one_mut().field_mut(touched[0].0.kind).swap(vec![(touched[0].1, None)]).unwrap();
    autosave.save(None, &state, None, &|_| true).unwrap();
    drop(autosave);
    assert!(!project.join("journal-000001").exists());
    std::fs::write(project.join("journal-000001"), &old).unwrap();
    assert_kept(&state, &reopened(&project).0, "stray journal");
    std::fs::write(project.join("journal-000002"), &old).unwrap();
    let (again, recovered) = reopened(&project);
    assert_kept(&state, &again, "journal under a wrong name");
    let (_, what) = recovered.set_aside.unwrap();
    assert!(what.contains("journal-000002: generation: 1 found, 2 expected"), "{what}");
}

#[test]
fn a_journal_grows_with_the_bricks_touched_and_not_with_history() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (mut autosave, project) = project(dir.path(), &state);
    let mut written = 0;
    let mut last = 0;
    for n in 0..80 {
        // 128 KiB that do not compress, on one of two bricks.
        let (kind, index, _) = paint(&mut state, FieldKind::Colour, [n % 2, 0, 0], u64::from(5 * n + 1));
        autosave.record(&command(), &state, &[(kind, index)], false).unwrap();
        let now = std::fs::metadata(project.join("journal-000001")).unwrap().len();
        written += now.saturating_sub(last);
        last = now;
    }
    assert!(written > 8 << 20, "{written}");
    assert!(last < 6 << 20, "{last}");
    drop(autosave);
    let (again, recovered) = reopened(&project);
    assert_kept(&state, &again, "gathered");
    assert_eq!(recovered.steps, 80);
}

#[test]
fn samples_of_a_stroke_that_was_running_come_back_until_it_ends() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (mut autosave, project) = project(dir.path(), &state);
    autosave.samples(&[burin::volume::VolumeId::FIRST], &[sample(1.0)]).unwrap();
    autosave.samples(&[burin::volume::VolumeId::FIRST], &[sample(2.0), sample(3.0)]).unwrap();
    // What goes on beside the stroke does not end it.
    autosave.record(&other_command(), &state, &[], false).unwrap();
    drop(autosave);
    let (mut autosave, kept) = Autosave::open(&project).unwrap();
    assert_eq!(kept.recovered.stroke, [sample(1.0), sample(2.0), sample(3.0)]);
    autosave.no_stroke().unwrap();
    drop(autosave);
    assert_eq!(reopened(&project).1.stroke, []);
    let (mut autosave, _) = Autosave::open(&project).unwrap();
    autosave.samples(&[burin::volume::VolumeId::FIRST], &[sample(4.0)]).unwrap();
    let touched = step(&mut state, 1);
    autosave.record(&command(), &state, &touched, true).unwrap();
    drop(autosave);
    assert_eq!(reopened(&project).1.stroke, []);
}

#[test]
fn another_density_map_comes_back_with_all_edits_in_it() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    paint_all(&mut state);
    let (mut autosave, project) = project(dir.path(), &state);
    let (kind, index, _) = paint(&mut state, FieldKind::Density, [1, 1, 0], 5);
    autosave.record(&command(), &state, &[(kind, index)], true).unwrap();
    // Painting beyond the range: floats from here on, and one edit less.
    let mut wide = Field::from_source(state.one().source.clone(), DensityMap::FLOAT, &|_| true).unwrap().unwrap();
    let edits: Vec<_> = state.one().density.edits().into_keys().skip(1).collect();
    let changes = edits.iter().map(|&i| (i, Some(Brick::Uniform(123_456.75_f32.to_le_bytes())))).collect();
    wide.swap(changes).unwrap();
    state.one_mut().density = wide;
    autosave.record(&command(), &state, &[(key(FieldKind::Density), index)], true).unwrap();
    drop(autosave);
    let (again, _) = reopened(&project);
    assert_kept(&state, &again, "widened");
    assert_eq!(again.one().map.format, TexelFormat::R32Float);
    let again = again.into_state(|_| panic!("the density is in the project"), &|_| true).unwrap();
    assert_same(&state, &again, "widened, as a document");
    // And a save over it writes edits of the new map only.
    let (mut autosave, _) = Autosave::open(&project).unwrap();
    autosave.save(None, &again, None, &|_| true).unwrap();
    drop(autosave);
    assert_kept(&state, &reopened(&project).0, "widened and saved");
}

#[test]
fn a_scene_that_json_cannot_say_is_refused_and_nothing_is_lost() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (mut autosave, project) = project(dir.path(), &state);
    let touched = step(&mut state, 1);
    autosave.record(&command(), &state, &touched, true).unwrap();
    let good = state.clone();
    state.scene.shown.get_mut(&VolumeId::FIRST).unwrap().window.level = f64::NAN;
    assert!(matches!(autosave.record(&command(), &state, &[], true), Err(KeepError::Scene { .. })));
    let refused = autosave.save(None, &state, None, &|_| true).unwrap_err();
    assert!(matches!(&refused, KeepError::Scene { .. }), "{refused}");
    drop(autosave);
    assert_kept(&good, &reopened(&project).0, "after a refusal");
}

#[test]
fn an_unsaved_document_is_found_at_the_next_start() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let mut autosave = Autosave::unsaved(dir.path(), &state).unwrap();
    let touched = step(&mut state, 1);
    autosave.record(&command(), &state, &touched, true).unwrap();
    assert_eq!(recovery::list(dir.path()).unwrap(), [], "it is open");
    drop(autosave);
    let lost = recovery::list(dir.path()).unwrap();
    assert_eq!(lost.len(), 1);
    assert_eq!(lost[0].origin, state.scene.origin().unwrap().path);
    let (mut autosave, kept) = Autosave::recover(dir.path(), &lost[0].id).unwrap();
    assert_eq!(kept.recovered.steps, 1);
    let source = state.one().source.clone();
    assert_same(&state, &kept.into_state(|_| Ok(source.clone()), &|_| true).unwrap(), "recovered");
    // Saved, it is lost no more.
    autosave.save(Some(&dir.path().join("project")), &state, None, &|_| true).unwrap();
    assert_eq!(recovery::list(dir.path()).unwrap(), []);
    drop(autosave);
    assert_eq!(recovery::list(dir.path()).unwrap(), []);
    assert_kept(&state, &reopened(&dir.path().join("project")).0, "saved");
}

#[test]
fn a_lost_document_whose_file_changed_says_so_and_can_be_discarded() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let mut autosave = Autosave::unsaved(dir.path(), &state).unwrap();
    let touched = step(&mut state, 1);
    autosave.record(&command(), &state, &touched, true).unwrap();
    drop(autosave);
    let lost = recovery::list(dir.path()).unwrap();
    std::fs::write(&state.scene.origin().unwrap().path, b"another file").unwrap();
    let message = Autosave::recover(dir.path(), &lost[0].id).unwrap_err().to_string();
    assert!(message.contains("origin.bin: bytes: 12 found, 24 expected"), "{message}");
    recovery::discard(dir.path(), &lost[0].id).unwrap();
    assert_eq!(recovery::list(dir.path()).unwrap(), []);
    assert!(matches!(recovery::discard(dir.path(), "../project"), Err(KeepError::NothingLost { .. })));
}

#[test]
fn a_document_with_no_step_leaves_nothing_to_recover() {
    let dir = tempfile::tempdir().unwrap();
    drop(Autosave::unsaved(dir.path(), &state(SMALL, dir.path())).unwrap());
    assert_eq!(recovery::list(dir.path()).unwrap(), []);
    assert_eq!(std::fs::read_dir(dir.path().join("recovery")).unwrap().count(), 0);
}

#[test]
fn looking_about_is_nothing_to_recover_until_something_is_done() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let mut autosave = Autosave::unsaved(dir.path(), &state).unwrap();
    state.scene.views.crosshair = DVec3::new(3.0, 2.0, 1.0);
    autosave.record(&other_command(), &state, &[], true).unwrap();
    drop(autosave);
    assert_eq!(recovery::list(dir.path()).unwrap(), []);
    let mut autosave = Autosave::unsaved(dir.path(), &state).unwrap();
    state.scene.views.size = [77, 55];
    autosave.record(&other_command(), &state, &[], true).unwrap();
    segments(&mut state.scene).ensure(9);
    autosave.record(&other_command(), &state, &[], true).unwrap();
    drop(autosave);
    let lost = recovery::list(dir.path()).unwrap();
    let (_keeper, kept) = Autosave::recover(dir.path(), &lost[0].id).unwrap();
    assert_eq!(kept.scene.views.size, [77, 55], "what was looked at comes along");
    assert!(kept.scene.segments().get(9).is_some());
}

#[test]
fn a_stroke_that_ran_or_a_journal_that_is_damaged_may_be_work() {
    let dir = tempfile::tempdir().unwrap();
    let state = state(SMALL, dir.path());
    let begun = |folder: &Path, taken_back: bool| {
        let mut autosave = Autosave::unsaved(folder, &state).unwrap();
        autosave.samples(&[burin::volume::VolumeId::FIRST], &[sample(1.0)]).unwrap();
        if taken_back {
            autosave.no_stroke().unwrap();
        }
    };
    for (taken_back, name) in [(false, "runs"), (true, "taken back")] {
        let folder = dir.path().join(name);
        begun(&folder, taken_back);
        assert_eq!(recovery::list(&folder).unwrap().len(), usize::from(!taken_back), "{name}");
    }
    let folder = dir.path().join("damaged");
    begun(&folder, true);
    let of_document = std::fs::read_dir(folder.join("recovery")).unwrap().next().unwrap().unwrap().path();
    let mut bytes = std::fs::read(of_document.join("journal")).unwrap();
    let whole = bytes.len();
    for (at, what) in [(28, "a length"), (60, "a body")] {
        bytes[at] ^= 0x40;
        std::fs::write(of_document.join("journal"), &bytes).unwrap();
        assert_eq!(recovery::list(&folder).unwrap().len(), 1, "{what}");
        bytes[at] ^= 0x40;
    }
    std::fs::write(of_document.join("journal"), &bytes[..whole - 1]).unwrap();
    assert_eq!(recovery::list(&folder).unwrap().len(), 1, "an end that is missing");
}

#[test]
fn looking_about_in_a_project_comes_back_and_counts_as_no_step() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (mut autosave, place) = project(dir.path(), &state);
    state.scene.views.crosshair = DVec3::new(3.0, 2.0, 1.0);
    autosave.record(&other_command(), &state, &[], true).unwrap();
    drop(autosave);
    let (kept, recovered) = reopened(&place);
    assert_eq!(recovered.steps, 0, "no work was lost");
    assert_kept(&state, &kept, "the views as they were");
    let (mut autosave, _) = Autosave::open(&place).unwrap();
    let touched = step(&mut state, 1);
    autosave.record(&command(), &state, &touched, true).unwrap();
    drop(autosave);
    assert_eq!(reopened(&place).1.steps, 1);
}

#[test]
fn saving_elsewhere_takes_unsaved_steps_along() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (mut autosave, first) = project(dir.path(), &state);
    let saved = state.clone();
    let touched = step(&mut state, 1);
    autosave.record(&command(), &state, &touched, true).unwrap();
    let second = dir.path().join("second");
    autosave.save(Some(&second), &state, None, &|_| true).unwrap();
    assert_eq!(autosave.project_dir(), Some(second.as_path()));
    drop(autosave);
    assert_kept(&saved, &reopened(&first).0, "the first as it was saved");
    assert_kept(&state, &reopened(&second).0, "the second as it is");
}

#[test]
fn a_journal_that_is_long_while_a_stroke_runs_keeps_its_samples() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (mut autosave, project) = project(dir.path(), &state);
    let samples: Vec<Sample> = (0..5).map(|i| sample(f64::from(i))).collect();
    autosave.samples(&[burin::volume::VolumeId::FIRST], &samples).unwrap();
    for n in 0..60 {
        let (kind, index, _) = paint(&mut state, FieldKind::Colour, [n % 2, 0, 0], u64::from(5 * n + 1));
        autosave.record(&other_command(), &state, &[(kind, index)], false).unwrap();
    }
    let length = std::fs::metadata(project.join("journal-000001")).unwrap().len();
    assert!(length > 6 << 20, "{length}: long enough to be gathered, were it not for the stroke");
    drop(autosave);
    let (again, recovered) = reopened(&project);
    assert_kept(&state, &again, "all steps");
    assert_eq!((recovered.stroke, recovered.steps), (samples, 60));
}

/// Where in the notes a file's or folder's sync is.
fn synced(told: &[Told], path: &Path) -> Vec<usize> {
    (0..told.len()).filter(|&i| told[i] == Told::Sync(path.to_owned())).collect()
}

#[test]
fn a_step_is_synced_before_it_is_answered() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (mut autosave, project) = project(dir.path(), &state);
    let witness = Witness::new(&project);
    let journal = project.join("journal-000001");
    for n in 1..4 {
        let touched = step(&mut state, n);
        autosave.record(&command(), &state, &touched, true).unwrap();
        assert_eq!(synced(&witness.told(), &journal).len(), n as usize);
    }
    // Frames of an animation need not be.
    autosave.record(&other_command(), &state, &[], false).unwrap();
    assert_eq!(synced(&witness.told(), &journal).len(), 3);
}

#[test]
fn everything_of_a_save_is_synced_before_the_one_rename_and_that_after_it() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (mut autosave, project) = project(dir.path(), &state);
    paint_all(&mut state);
    let witness = Witness::new(&project);
    autosave.save(None, &state, None, &|_| true).unwrap();
    let told = witness.told();
    let renames: Vec<usize> = (0..told.len()).filter(|&i| matches!(told[i], Told::Rename(_))).collect();
    let [rename] = renames[..] else { panic!("one rename expected: {told:?}") };
    assert_eq!(told[rename], Told::Rename(project.join("project.json")));
    fn below(dir: &Path, found: &mut Vec<PathBuf>) {
        found.push(dir.to_owned());
        for entry in std::fs::read_dir(dir).unwrap().map(Result::unwrap) {
            let path = entry.path();
            if path.is_dir() { below(&path, found) } else { found.push(path) }
        }
    }
    let mut written = vec![project.join("journal-000002"), project.join("project.new"), project.clone()];
    below(&project.join("generation-000002"), &mut written);
    // What is a link was synced when it was written.
    written.retain(|path| !links(path));
    assert!(written.iter().filter(|path| path.is_file()).count() > 5, "{written:?}");
    for path in written {
        assert!(synced(&told, &path).first().is_some_and(|&at| at < rename), "{} in {told:?}", path.display());
    }
    assert!(synced(&told, &project).last().is_some_and(|&at| at > rename), "{told:?}");
}

/// Whether a file is in another generation too.
fn links(path: &Path) -> bool {
    #[cfg(unix)]
    return path.metadata().is_ok_and(|about| about.is_file() && std::os::unix::fs::MetadataExt::nlink(&about) > 1);
    #[cfg(not(unix))]
    return path.is_file() && path.to_string_lossy().contains("density");
}
