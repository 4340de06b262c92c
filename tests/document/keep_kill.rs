//! A process that dies at any moment of painting and saving loses at most the step in progress.
//!
//! The child is this test binary again, running `paints_and_saves_until_it_is_killed`; it says each step's number on stdout
//! when the keeper says that it is kept. The parent kills it at seeded moments, opens what it finds, and compares every byte
//! with the same steps done in memory. `BURIN_KILLS` sets how often (20, of which a quarter here: `keep_program` kills the
//! program itself, this test reaches what that cannot, journals that are gathered among it).

use super::keep_support::*;
use crate::common::one::{One, segments};
use burin::document::{Autosave, Command, State, StrokeCommand};
use burin::math::DVec3;
use burin::paint::Sample;
use burin::volume::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command as Process, Stdio};
use std::time::{Duration, Instant};

const SMALL: [u32; 3] = [40, 33, 34];
const CHILD: &str = "BURIN_TEST_KILL_PROJECT";

/// Step `n`, the same whenever it is done. Sets the crosshair's x to `n`, so that a document says how far it is.
fn step(state: &mut State, n: u64, large: bool) -> Vec<(FieldKey, BrickIndex)> {
    let mut rng = ChaCha8Rng::seed_from_u64(n);
    let dims = state.one().density.brick_dims(0);
    state.scene.views.crosshair = DVec3::new(n as f64, 0.0, 0.0);
    segments(&mut state.scene).ensure(rng.random_range(1..200));
    let mut touched = Vec::new();
    for _ in 0..if large { 5 } else { 1 + n % 3 } {
        let kind = if large { FieldKind::Colour } else { FieldKind::ALL[rng.random_range(0..4)] };
        // Few bricks, so that most of a long journal is superseded.
        let index = if large { [rng.random_range(0..2), 0, 0] } else { dims.map(|d| rng.random_range(0..d)) };
        if rng.random_range(0..8) == 0 {
            state.one_mut().field_mut(kind).swap(vec![(BrickIndex(index), None)]).unwrap();
        } else {
            paint(state, kind, index, rng.random());
        }
        touched.push((key(kind), BrickIndex(index)));
    }
    touched
}

fn opened(project: &Path) -> (Autosave, State) {
    let (autosave, kept) = Autosave::open(project).unwrap();
    assert_eq!(kept.recovered.set_aside, None);
    (autosave, kept.into_state(|_| panic!("the density is in the project"), &|_| true).unwrap())
}

fn steps_in(state: &State) -> u64 {
    state.scene.views.crosshair.x as u64
}

/// Whether a round paints many bricks and never saves, so that its journal is gathered; the others save every few steps.
fn is_large(round: u64) -> bool {
    round % 2 == 1
}

#[test]
#[ignore = "a child process of a_killed_process_loses_at_most_the_step_in_progress"]
fn paints_and_saves_until_it_is_killed() {
    let Ok(project) = std::env::var(CHILD) else { return };
    let round: u64 = std::env::var("BURIN_TEST_KILL_ROUND").unwrap().parse().unwrap();
    let (mut autosave, mut state) = opened(Path::new(&project));
    let say = |text: String| {
        let mut out = std::io::stdout().lock();
        writeln!(out, "{text}").and_then(|()| out.flush()).unwrap();
    };
    say("ready".into());
    let mut rng = ChaCha8Rng::seed_from_u64(round);
    loop {
        let n = steps_in(&state) + 1;
        for i in 0..rng.random_range(0..3) {
            let position = DVec3::new(f64::from(i), n as f64, 0.0);
            autosave
                .samples(
                    &[burin::volume::VolumeId::FIRST],
                    &[Sample { position, normal: DVec3::Z, pressure: 1.0, breaks: false }],
                )
                .unwrap();
        }
        let touched = step(&mut state, n, is_large(round));
        autosave.record(&Command::Stroke(StrokeCommand::End {}), &state, &touched, true).unwrap();
        say(format!("done {n}"));
        if !is_large(round) && rng.random_range(0..3) == 0 {
            say("saving".into());
            autosave.save(None, &state, None, &|_| true).unwrap();
            say("saved".into());
        }
    }
}

/// How often to kill.
pub fn kills() -> u64 {
    std::env::var("BURIN_KILLS").ok().and_then(|k| k.parse().ok()).unwrap_or(20)
}

#[test]
fn a_killed_process_loses_at_most_the_step_in_progress() {
    let kills = kills().div_ceil(4);
    let dir = tempfile::tempdir().unwrap();
    let project = dir.path().join("project");
    let mut state = state(SMALL, dir.path());
    let mut autosave = Autosave::unsaved(dir.path(), &state).unwrap();
    autosave.save(Some(&project), &state, None, &|_| true).unwrap();
    drop(autosave);
    let mut rng = ChaCha8Rng::seed_from_u64(2026);
    let (mut in_a_save, mut in_a_step, mut steps) = (0, 0, 0);
    for round in 0..kills {
        let mut child = Process::new(std::env::current_exe().unwrap())
            .args(["--exact", "document::keep_kill::paints_and_saves_until_it_is_killed", "--ignored", "--nocapture"])
            .env(CHILD, &project)
            .env("BURIN_TEST_KILL_ROUND", round.to_string())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map_while(Result::ok);
        assert!(lines.any(|line| line == "ready"), "round {round}: the child did not open the project");
        // A moment within what follows some line, whatever the machine's speed: the mean time of a line is measured first.
        let wait_for = if is_large(round) { rng.random_range(4..14) } else { rng.random_range(1..9) };
        let start = Instant::now();
        let mut said: Vec<String> = lines.by_ref().take(wait_for).collect();
        if is_large(round) || round % 4 == 2 {
            std::thread::sleep((start.elapsed() / wait_for as u32).mul_f64(rng.random_range(0.0..2.0)));
        } else {
            // Until a save begins, and a little into it.
            while said.last().is_none_or(|line| line != "saving") {
                said.extend(lines.by_ref().take(1));
            }
            std::thread::sleep(Duration::from_micros(rng.random_range(0..3000)));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        said.extend(lines);
        let before = steps_in(&state);
        let acknowledged =
            said.iter().rev().find_map(|l| l.strip_prefix("done ")).map_or(before, |n| n.parse().unwrap());
        let (_keeper, found) = Autosave::open(&project).unwrap();
        assert_eq!(found.recovered.set_aside, None);
        let reached = found.scene.views.crosshair.x as u64;
        assert!(
            reached == acknowledged || reached == acknowledged + 1,
            "round {round}: {reached} steps found, {acknowledged} acknowledged"
        );
        for n in before + 1..=reached {
            step(&mut state, n, is_large(round));
        }
        assert_kept(&state, &found, &format!("round {round}, {reached} steps"));
        in_a_save += u64::from(said.last().is_some_and(|l| l == "saving"));
        in_a_step += reached - acknowledged;
        steps += reached - before;
    }
    assert!(in_a_save > 0, "no kill fell into a save");
    println!("{kills} kills over {steps} steps: {in_a_save} in a save, {in_a_step} between a step and its answer");
}
