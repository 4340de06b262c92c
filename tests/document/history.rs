//! Undo and redo: every byte back, within a budget, in groups.

use super::maker::{labelled, run, undone};
use burin::document::{Document, remove_dead_history};
use rand::{Rng, SeedableRng, seq::IndexedRandom};

/// A command that changes something undoable, a look or a view, at random.
fn random_line(rng: &mut impl Rng) -> String {
    let id = rng.random_range(1..5);
    let n = rng.random_range(0..100);
    match rng.random_range(0..12) {
        0 => format!(r#"{{"segment":{{"set":{{"id":{id},"name":"bone {n}"}}}}}}"#),
        1 => format!(r#"{{"segment":{{"set":{{"id":{id},"colour":[0.{n},0.5,1]}}}}}}"#),
        2 => format!(r#"{{"segment":{{"remove":{{"id":{id}}}}}}}"#),
        3 => format!(r#"{{"selection":{{"from_label":{{"label":{id}}}}}}}"#),
        4 => r#"{"selection":{"clear":{}}}"#.into(),
        5 => format!(r#"{{"view":{{"window":{{"level":{n},"width":{}}}}}}}"#, n + 1),
        6 => format!(r#"{{"view":{{"layer":{{"field":"labels","visible":true,"opacity":0.{n}}}}}}}"#),
        7 => format!(r#"{{"view":{{"look":{{"mode":{{"iso":{n}}}}}}}}}"#),
        8 => format!(r#"{{"view":{{"orbit":{{"azimuth_deg":{n},"elevation_deg":1}}}}}}"#),
        9 => r#"{"transfer":{"reset":{}}}"#.into(),
        10 => format!(
            r#"{{"transfer":{{"set":{{"function":{{"colour":[[0,[0,0,0]],[{},[1,1,1]]],"opacity":[[0,0.{n}]],"unit_mm":1}}}}}}}}"#,
            n + 1
        ),
        _ => [r#"{"history":{"begin":{}}}"#, r#"{"history":{"end":{}}}"#].choose(rng).unwrap().to_string(),
    }
}

fn walk(seed: u64, budget: u64) {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut document = labelled();
    run(&mut document, &format!(r#"{{"history":{{"budget":{{"bytes":{budget}}}}}}}"#)).unwrap();
    let start = undone(&document);
    for _ in 0..60 {
        let steps = document.history().undo_names().len();
        let before = undone(&document);
        let line = random_line(&mut rng);
        // What is refused (an unknown segment, an end without begin) must change nothing.
        if run(&mut document, &line).is_err() {
            assert_eq!(undone(&document), before, "{line}");
            assert_eq!(document.history().undo_names().len(), steps, "{line}");
        }
        if rng.random_range(0..6) == 0 {
            let line = if rng.random() { r#"{"history":{"undo":{}}}"# } else { r#"{"history":{"redo":{}}}"# };
            run(&mut document, line).unwrap();
        }
    }
    let end = undone(&document);
    let all = |d: &mut Document, way: &str| {
        run(d, &format!(r#"{{"history":{{"{way}":{{"steps":1000}}}}}}"#)).unwrap();
    };
    all(&mut document, "redo");
    let newest = undone(&document);
    for _ in 0..2 {
        all(&mut document, "undo");
        assert_eq!(undone(&document), start, "seed {seed}");
        all(&mut document, "redo");
        assert_eq!(undone(&document), newest, "seed {seed}");
    }
    assert_ne!(end, start, "seed {seed}: a walk that changed nothing tests nothing");
    assert!(document.history().bytes().0 <= budget);
}

#[test]
fn a_random_walk_comes_back_byte_for_byte_both_ways() {
    (0..8).for_each(|seed| walk(seed, 1 << 30));
}

#[test]
fn steps_beyond_the_budget_come_back_from_disk() {
    (100..104).for_each(|seed| walk(seed, 0));
    (104..106).for_each(|seed| walk(seed, 3000));
}

#[test]
fn a_command_that_changes_nothing_is_no_step() {
    let mut document = labelled();
    for line in [
        r#"{"selection":{"clear":{}}}"#,
        r#"{"segment":{"set":{"id":1,"visible":true}}}"#,
        r#"{"transfer":{"reset":{}}}"#,
        r#"{"view":{"look":{"shaded":true}}}"#,
    ] {
        assert_eq!(run(&mut document, line).unwrap()["step"], serde_json::Value::Null, "{line}");
    }
    assert_eq!(document.history().undo_names().len(), 0);
}

#[test]
fn a_group_is_one_step_and_one_that_returns_is_none() {
    let mut document = labelled();
    let seed = |d: &mut Document, n: u32| {
        run(d, &format!(r#"{{"explosion":{{"seed":{{"value":{n}}}}}}}"#)).unwrap();
    };
    let now = |d: &Document| d.state().unwrap().scene.explosion.seed;
    seed(&mut document, 5);
    run(&mut document, r#"{"history":{"begin":{}}}"#).unwrap();
    (6..20).for_each(|n| seed(&mut document, n));
    assert_eq!(run(&mut document, r#"{"history":{"end":{}}}"#).unwrap()["step"], "Seed of explosion points");
    assert_eq!(document.history().undo_names().len(), 2);
    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    assert_eq!(now(&document), 5);
    run(&mut document, r#"{"history":{"begin":{}}}"#).unwrap();
    seed(&mut document, 9);
    seed(&mut document, 5);
    assert_eq!(run(&mut document, r#"{"history":{"end":{}}}"#).unwrap()["step"], serde_json::Value::Null);
    // Redo is still there: the group did nothing.
    assert_eq!(document.history().redo_names().len(), 1);
    run(&mut document, r#"{"history":{"begin":{}}}"#).unwrap();
    seed(&mut document, 9);
    run(&mut document, r#"{"history":{"cancel":{}}}"#).unwrap();
    assert_eq!(now(&document), 5);
}

#[test]
fn steps_on_disk_go_with_their_process_however_it_ended() {
    let parent = tempfile::tempdir().unwrap();
    let folders = || std::fs::read_dir(parent.path()).unwrap().count();
    let mut document = labelled();
    document.keep_history_in(parent.path().to_owned());
    run(&mut document, r#"{"history":{"budget":{"bytes":0}}}"#).unwrap();
    let start = undone(&document);
    run(&mut document, r#"{"selection":{"from_label":{"label":1}}}"#).unwrap();
    assert_eq!(folders(), 1);
    // What a crash leaves is the same without the process that held its lock.
    let dead = parent.path().join("burin-history-dead");
    std::fs::create_dir(&dead).unwrap();
    #[cfg(unix)]
    std::fs::set_permissions(&dead, std::os::unix::fs::PermissionsExt::from_mode(0o700)).unwrap();
    for name in ["lock", "step-1"] {
        std::fs::write(dead.join(name), b"left").unwrap();
    }
    // Of somebody else, or of something else: not ours to remove.
    std::fs::create_dir_all(parent.path().join("burin-history-none/step-1")).unwrap();
    std::fs::write(parent.path().join("burin-history-file"), b"").unwrap();
    #[cfg(unix)]
    {
        let open = parent.path().join("burin-history-open");
        std::fs::create_dir(&open).unwrap();
        std::fs::write(open.join("lock"), b"").unwrap();
        std::fs::set_permissions(&open, std::os::unix::fs::PermissionsExt::from_mode(0o777)).unwrap();
        std::os::unix::fs::symlink(&open, parent.path().join("burin-history-link")).unwrap();
    }
    let before = folders();
    assert_eq!(remove_dead_history(parent.path()), 1);
    assert_eq!(folders(), before - 1);
    assert!(!dead.exists());
    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    assert_eq!(undone(&document), start);
    drop(document);
    assert_eq!(folders(), before - 2);
}

#[test]
fn a_full_disk_is_an_answer_and_loses_no_step() {
    let mut document = labelled();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("not a folder");
    std::fs::write(&file, b"").unwrap();
    document.keep_history_in(file);
    run(&mut document, r#"{"history":{"budget":{"bytes":0}}}"#).unwrap();
    let start = undone(&document);
    let answer = run(&mut document, r#"{"selection":{"from_label":{"label":1}}}"#).unwrap();
    assert!(answer["warning"].as_str().unwrap().contains("older steps of history cannot go to"), "{answer}");
    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    assert_eq!(undone(&document), start);
}

#[test]
fn what_was_taken_back_is_gone_once_something_else_is_done() {
    let mut document = labelled();
    for name in ["a", "b", "c"] {
        run(&mut document, &format!(r#"{{"segment":{{"set":{{"id":1,"name":"{name}"}}}}}}"#)).unwrap();
    }
    run(&mut document, r#"{"history":{"undo":{"steps":2}}}"#).unwrap();
    assert_eq!(document.history().redo_names().len(), 2);
    run(&mut document, r#"{"segment":{"set":{"id":2,"name":"d"}}}"#).unwrap();
    assert_eq!((document.history().undo_names().len(), document.history().redo_names().len()), (2, 0));
    let here = undone(&document);
    assert_eq!(run(&mut document, r#"{"history":{"redo":{}}}"#).unwrap()["redone"], serde_json::json!([]));
    assert_eq!(undone(&document), here);
}

/// The folders of history in a folder.
#[cfg(unix)]
fn spilled(folder: &std::path::Path) -> Vec<std::path::PathBuf> {
    let named = |e: &std::fs::DirEntry| e.file_name().to_string_lossy().starts_with("burin-history-");
    std::fs::read_dir(folder).unwrap().map(Result::unwrap).filter(named).map(|e| e.path()).collect()
}

#[test]
#[cfg(unix)]
fn history_on_disk_is_private_and_goes_when_its_process_was_killed() {
    use std::io::{BufRead, BufReader, Write};
    use std::os::unix::fs::PermissionsExt;
    use std::process::{Command, Stdio};
    let folder = tempfile::tempdir().unwrap();
    let grid = burin::volume::Grid::aligned([8; 3], burin::math::DVec3::ONE, burin::math::DVec3::ZERO);
    super::maker::write_nrrd(&folder.path().join("v.nrrd"), &grid, |v| v[0] as f32);
    let temporary = folder.path().join("tmp");
    std::fs::create_dir(&temporary).unwrap();
    let burin = || {
        let mut command = Command::new(crate::common::program());
        command.args(["run", "-"]).current_dir(folder.path()).env("TMPDIR", &temporary);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        command
    };
    let mut child = burin().spawn().unwrap();
    let lines = [
        r#"{"volume":{"open":{"path":"v.nrrd"}}}"#,
        r#"{"history":{"budget":{"bytes":0}}}"#,
        r#"{"segment":{"set":{"id":1,"name":"jaw"}}}"#,
        r#"{"ask":{"history":{}}}"#,
    ];
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all((lines.join("\n") + "\n").as_bytes()).unwrap();
    let answers = BufReader::new(child.stdout.take().unwrap()).lines().map_while(Result::ok).take(lines.len());
    assert_eq!(answers.count(), lines.len());
    let [left] = &spilled(&temporary)[..] else { panic!("one folder expected: {:?}", spilled(&temporary)) };
    assert_eq!(left.metadata().unwrap().permissions().mode() & 0o777, 0o700);
    assert!(left.join("step-1").exists());
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(spilled(&temporary).len(), 1);
    // One of an older version, that others could look into.
    let older = temporary.join("burin-history-older");
    std::fs::create_dir(&older).unwrap();
    std::fs::write(older.join("lock"), b"").unwrap();
    std::fs::set_permissions(&older, PermissionsExt::from_mode(0o755)).unwrap();
    let mut next = burin().spawn().unwrap();
    drop(next.stdin.take());
    next.wait().unwrap();
    assert!(spilled(&temporary).is_empty());
}
