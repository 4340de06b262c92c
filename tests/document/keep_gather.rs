//! A journal that grows long is gathered anew, again and again, and nothing of what it holds is lost by it.

use super::keep_support::*;
use burin::document::{Autosave, Command, State, StrokeCommand};
use burin::volume::{FieldKey, FieldKind};
use std::path::{Path, PathBuf};

const SMALL: [u32; 3] = [70, 33, 34];

fn project(dir: &Path, state: &State) -> (Autosave, PathBuf) {
    let project = dir.join("project");
    let mut autosave = Autosave::unsaved(dir, state).unwrap();
    autosave.save(Some(&project), state, None, &|_| true).unwrap();
    (autosave, project)
}

/// Paints 128 KiB that do not compress on one of two bricks of colour, and notes it.
fn paint_colour(autosave: &mut Autosave, state: &mut State, n: u64) {
    let (kind, index, _) = paint(state, FieldKind::Colour, [(n % 2) as u32, 0, 0], 5 * n + 1);
    note(autosave, state, (kind, index));
}

fn note(autosave: &mut Autosave, state: &State, touched: (FieldKey, burin::volume::BrickIndex)) {
    autosave.record(&Command::Stroke(StrokeCommand::End {}), state, &[touched], false).unwrap();
}

fn length(project: &Path) -> u64 {
    std::fs::metadata(project.join("journal-000001")).unwrap().len()
}

/// Paints until the journal has been gathered so many times.
fn gather(autosave: &mut Autosave, state: &mut State, project: &Path, times: usize) {
    let (mut gathered, mut last) = (0, length(project));
    for n in 0..200 {
        paint_colour(autosave, state, n);
        let now = length(project);
        gathered += usize::from(now < last);
        last = now;
        if gathered == times {
            return;
        }
    }
    panic!("gathered {gathered} times only");
}

#[test]
fn what_was_painted_once_outlives_every_gathering() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (mut autosave, project) = project(dir.path(), &state);
    // Each lies at another place in each file, and is read from where the last gathering put it.
    for (i, kind) in [FieldKind::Labels, FieldKind::Density, FieldKind::Selection].into_iter().enumerate() {
        let (kind, index, _) = paint(&mut state, kind, [1, 0, 1], 91 + 5 * i as u64);
        note(&mut autosave, &state, (kind, index));
    }
    gather(&mut autosave, &mut state, &project, 3);
    drop(autosave);
    let (_keeper, kept) = Autosave::open(&project).unwrap();
    assert_eq!(kept.recovered.set_aside, None);
    assert_kept(&state, &kept, "gathered three times");
}

#[test]
fn what_a_crash_left_is_not_cut_off_by_whoever_leaves_it_as_it_was_found() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (mut autosave, project) = project(dir.path(), &state);
    let (kind, index, _) = paint(&mut state, FieldKind::Labels, [1, 0, 1], 91);
    note(&mut autosave, &state, (kind, index));
    drop(autosave);
    let found = state.clone();
    // Nothing gathered: what came later goes, what was found stays.
    let (mut autosave, _) = Autosave::open(&project).unwrap();
    paint_colour(&mut autosave, &mut state, 3);
    autosave.leave_as_found().unwrap();
    let (mut autosave, kept) = Autosave::open(&project).unwrap();
    assert_kept(&found, &kept, "as it was found");
    // Gathered: the two cannot be told apart any more, and all stays.
    let mut state = found;
    gather(&mut autosave, &mut state, &project, 1);
    paint_colour(&mut autosave, &mut state, 501);
    autosave.leave_as_found().unwrap();
    let (_keeper, kept) = Autosave::open(&project).unwrap();
    assert_eq!((kept.recovered.set_aside.clone(), kept.recovered.torn_bytes), (None, 0));
    assert_kept(&state, &kept, "gathered with what came later");
}
