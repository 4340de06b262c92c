//! A journal that grows long is gathered anew, again and again, and nothing of what it holds is lost by it.

use super::keep_support::*;
use burin::document::{Command, Keeper, State, StrokeCommand};
use burin::volume::{FieldKey, FieldKind};
use std::path::{Path, PathBuf};

const SMALL: [u32; 3] = [70, 33, 34];

fn project(dir: &Path, state: &State) -> (Keeper, PathBuf) {
    let project = dir.join("project");
    let mut keeper = Keeper::unsaved(dir, state).unwrap();
    keeper.save(Some(&project), state, None, &|_| true).unwrap();
    (keeper, project)
}

/// Paints 128 KiB that do not compress on one of two bricks of colour, and notes it.
fn paint_colour(keeper: &mut Keeper, state: &mut State, n: u64) {
    let (kind, index, _) = paint(state, FieldKind::Colour, [(n % 2) as u32, 0, 0], 5 * n + 1);
    note(keeper, state, (kind, index));
}

fn note(keeper: &mut Keeper, state: &State, touched: (FieldKey, burin::volume::BrickIndex)) {
    keeper.record(&Command::Stroke(StrokeCommand::End {}), state, &[touched], false).unwrap();
}

fn length(project: &Path) -> u64 {
    std::fs::metadata(project.join("journal-000001")).unwrap().len()
}

/// Paints until the journal has been gathered so many times.
fn gather(keeper: &mut Keeper, state: &mut State, project: &Path, times: usize) {
    let (mut gathered, mut last) = (0, length(project));
    for n in 0..200 {
        paint_colour(keeper, state, n);
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
    let (mut keeper, project) = project(dir.path(), &state);
    // Each lies at another place in each file, and is read from where the last gathering put it.
    for (i, kind) in [FieldKind::Labels, FieldKind::Density, FieldKind::Selection].into_iter().enumerate() {
        let (kind, index, _) = paint(&mut state, kind, [1, 0, 1], 91 + 5 * i as u64);
        note(&mut keeper, &state, (kind, index));
    }
    gather(&mut keeper, &mut state, &project, 3);
    drop(keeper);
    let (_keeper, kept) = Keeper::open(&project).unwrap();
    assert_eq!(kept.recovered.set_aside, None);
    assert_kept(&state, &kept, "gathered three times");
}

#[test]
fn what_a_crash_left_is_not_cut_off_by_whoever_leaves_it_as_it_was_found() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let (mut keeper, project) = project(dir.path(), &state);
    let (kind, index, _) = paint(&mut state, FieldKind::Labels, [1, 0, 1], 91);
    note(&mut keeper, &state, (kind, index));
    drop(keeper);
    let found = state.clone();
    // Nothing gathered: what came later goes, what was found stays.
    let (mut keeper, _) = Keeper::open(&project).unwrap();
    paint_colour(&mut keeper, &mut state, 3);
    keeper.leave_as_found().unwrap();
    let (mut keeper, kept) = Keeper::open(&project).unwrap();
    assert_kept(&found, &kept, "as it was found");
    // Gathered: the two cannot be told apart any more, and all stays.
    let mut state = found;
    gather(&mut keeper, &mut state, &project, 1);
    paint_colour(&mut keeper, &mut state, 501);
    keeper.leave_as_found().unwrap();
    let (_keeper, kept) = Keeper::open(&project).unwrap();
    assert_eq!((kept.recovered.set_aside.clone(), kept.recovered.torn_bytes), (None, 0));
    assert_kept(&state, &kept, "gathered with what came later");
}
