//! Damaged projects and refusing disks: an error that says what and where, and nothing lost.

use super::keep_support::*;
use crate::common::one::One;
use burin::document::{Autosave, Command, KeepError, RestoredDocument, State, StrokeCommand};
use burin::volume::*;
use std::path::{Path, PathBuf};

const SMALL: [u32; 3] = [70, 33, 40];

fn saved(dir: &Path, state: &State) -> PathBuf {
    let project = dir.join("project");
    let mut autosave = Autosave::unsaved(dir, state).unwrap();
    autosave.save(Some(&project), state, None, &|_| true).unwrap();
    project
}

fn opened(project: &Path) -> RestoredDocument {
    Autosave::open(project).unwrap().1
}

/// The whole message of an opening that fails, at once or when voxels are read.
fn refusal(project: &Path) -> String {
    match Autosave::open(project) {
        Err(error) => error.to_string(),
        Ok((_keeper, kept)) => kept.into_state(|_| panic!("whole"), &|_| true).expect_err("it opened").to_string(),
    }
}

#[test]
fn what_is_damaged_is_named_with_what_was_found_and_expected() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    paint_all(&mut state);
    let project = saved(dir.path(), &state);
    let cut = |bytes: &[u8]| bytes[..bytes.len() / 2].to_vec();
    let flip = |bytes: &[u8]| {
        let mut bytes = bytes.to_vec();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 0x10;
        bytes
    };
    let replace = |from: &'static str, to: &'static str| {
        move |bytes: &[u8]| {
            let text = String::from_utf8(bytes.to_vec()).unwrap();
            assert!(text.contains(from), "{from}");
            text.replacen(from, to, 1).into_bytes()
        }
    };
    type Damage<'a> = Box<dyn Fn(&[u8]) -> Vec<u8> + 'a>;
    let cases: Vec<(&str, Damage<'_>, &[&str])> = vec![
        (
            "project.json",
            Box::new(cut),
            &["project.json: JSON: ", "found, JSON with format, version and generation expected"],
        ),
        ("project.json", Box::new(|_| Vec::new()), &["project.json: JSON: EOF"]),
        (
            "project.json",
            Box::new(replace("burin project", "other")),
            &["format: \"other\" found, \"burin project\" expected"],
        ),
        ("project.json", Box::new(replace("\"version\": 2", "\"version\": 9")), &["version: 9 found, 2 expected"]),
        ("project.json", Box::new(replace("\"generation\": 1", "\"generation\": 7")), &["project.json: blake3: "]),
        ("generation-000001/generation.json", Box::new(cut), &["generation.json: JSON: "]),
        (
            "generation-000001/generation.json",
            Box::new(replace("\"version\": 2", "\"version\": 3")),
            &["generation.json: version: 3 found, 2"],
        ),
        (
            "generation-000001/generation.json",
            Box::new(replace("        70,", "        4000000000,")),
            &["volumes.0.dims: [4000000000, 33, 40] found"],
        ),
        (
            "generation-000001/generation.json",
            Box::new(replace("        70,", "        270,")),
            &["generation.json: blake3: "],
        ),
        (
            "generation-000001/generation.json",
            Box::new(replace("\"0/0/0\"", "\"9/0/0\"")),
            &["generation.json: blake3: "],
        ),
        ("generation-000001/volumes/0/selection/0/c/0/0/0", Box::new(cut), &["selection/0/c/0/0/0: blake3: "]),
        ("generation-000001/volumes/0/labels/0/c/0/0/0", Box::new(flip), &["labels/0/c/0/0/0: blake3: "]),
        ("generation-000001/volumes/0/colour/0/c/0/0/0/0", Box::new(|_| Vec::new()), &["colour/0/c/0/0/0/0: blake3: "]),
        (
            "generation-000001/volumes/0/density_edits/edited/c/0/0/0",
            Box::new(cut),
            &["density_edits/edited/c/0/0/0: blake3: "],
        ),
        ("generation-000001/volumes/0/density/0/c/0/0/0", Box::new(cut), &["density/0/c/0/0/0: blake3: "]),
        ("generation-000001/volumes/0/density/0/c/0/0/0", Box::new(flip), &["density/0/c/0/0/0: blake3: "]),
    ];
    for (name, damage, expected) in cases {
        let path = project.join(name);
        let good = std::fs::read(&path).unwrap();
        // The file may be a link that another generation shares; damage must not.
        std::fs::write(&path, damage(&good)).unwrap();
        let message = refusal(&project);
        for part in expected {
            assert!(message.contains(part), "{name}: {part:?} not in {message:?}");
        }
        std::fs::write(&path, good).unwrap();
    }
    for name in [
        "generation-000001/volumes/0/density/0/c/0/0/0",
        "generation-000001/volumes/0/labels/0/c/0/0/0",
        "generation-000001/generation.json",
    ] {
        let (path, aside) = (project.join(name), dir.path().join("aside"));
        std::fs::rename(&path, &aside).unwrap();
        let message = refusal(&project);
        assert!(message.contains("cannot read") && message.contains(name), "{message}");
        std::fs::rename(&aside, &path).unwrap();
    }
    assert_kept(&state, &opened(&project), "put right again");
    assert!(matches!(Autosave::open(dir.path()), Err(KeepError::NotAProject { .. })));
}

/// CRC-32C of RFC 3720, bit by bit: what ends a shard's index.
fn crc32c(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| if sum & 1 == 1 { sum >> 1 ^ 0x82f6_3b78 } else { sum >> 1 })
    })
}

#[test]
fn an_index_that_asks_for_more_than_the_shard_holds_is_damage_and_costs_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    paint_all(&mut state);
    let project = saved(dir.path(), &state);
    let path = project.join("generation-000001/volumes/0/density/0/c/0/0/0");
    let good = std::fs::read(&path).unwrap();
    // Where each of 4³ bricks begins and how long it is, 64 bits each, and the sum of that.
    let at = good.len() - 4 * 4 * 4 * 16 - 4;
    let sum = |bytes: &[u8]| crc32c(&bytes[at..bytes.len() - 4]).to_le_bytes();
    assert_eq!(good[good.len() - 4..], sum(&good));
    let length = good.len() as u64;
    for (offset, bytes) in
        [(0, length + 1), (0, 1 << 40), (0, 1 << 62), (length, 1), (1 << 62, 8), (u64::MAX - 7, 16), (8, u64::MAX - 1)]
    {
        let mut bad = good.clone();
        bad[at..at + 8].copy_from_slice(&u64::to_le_bytes(offset));
        bad[at + 8..at + 16].copy_from_slice(&u64::to_le_bytes(bytes));
        let sum = sum(&bad);
        let end = bad.len() - 4;
        bad[end..].copy_from_slice(&sum);
        std::fs::write(&path, bad).unwrap();
        let message = refusal(&project);
        assert!(message.contains("density/0/c/0/0/0: blake3: "), "{offset} {bytes}: {message}");
    }
    std::fs::write(&path, good).unwrap();
    assert_kept(&state, &opened(&project), "put right again");
}

#[test]
fn a_place_that_cannot_be_written_is_refused_and_the_document_goes_on() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    paint_all(&mut state);
    let mut autosave = Autosave::unsaved(dir.path(), &state).unwrap();
    let below_a_file = state.scene.origin().unwrap().path.join("project");
    let refused = autosave.save(Some(&below_a_file), &state, None, &|_| true).unwrap_err();
    assert!(matches!(&refused, KeepError::Io { path, .. } if *path == below_a_file), "{refused}");
    autosave.save(Some(&dir.path().join("project")), &state, None, &|_| true).unwrap();
    drop(autosave);
    assert_kept(&state, &opened(&dir.path().join("project")), "saved elsewhere");
}

#[test]
fn a_save_that_is_stopped_leaves_the_project_as_it_was() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let project = saved(dir.path(), &state);
    let before = state.clone();
    let (mut autosave, _) = Autosave::open(&project).unwrap();
    paint_all(&mut state);
    let stopped = autosave.save(None, &state, None, &|share| share < 0.2);
    assert!(matches!(stopped, Err(KeepError::Stopped)));
    assert!(!project.join("generation-000002").exists());
    drop(autosave);
    assert_kept(&before, &opened(&project), "stopped");
}

/// A child with a limit on the size of files, which a full disk resembles: writes fail in the middle.
#[cfg(unix)]
mod full_disk {
    use super::*;
    use std::process::Command as Process;

    const CHILD: &str = "BURIN_TEST_FULL_PROJECT";

    fn noise(state: &mut State, seed: u64) -> Vec<(FieldKey, BrickIndex)> {
        let indices = state.one().colour.brick_indices(0);
        indices
            .iter()
            .map(|i| paint(state, FieldKind::Colour, i.0, seed * 5 + 1 + u64::from(i.0[0])).1)
            .map(|i| (key(FieldKind::Colour), i))
            .collect()
    }

    fn end() -> Command {
        Command::Stroke(StrokeCommand::End {})
    }

    /// Paints what fits, then what does not.
    #[test]
    #[ignore = "a child process of a_full_disk_is_told_and_loses_nothing"]
    fn saves_and_records_on_a_full_disk() {
        let Ok(project) = std::env::var(CHILD) else { return };
        let (mut autosave, kept) = Autosave::open(Path::new(&project)).unwrap();
        let mut state = kept.into_state(|_| panic!("whole"), &|_| true).unwrap();
        let (kind, index, _) = paint(&mut state, FieldKind::Labels, [0; 3], 1);
        autosave.record(&end(), &state, &[(kind, index)], true).unwrap();
        let touched = noise(&mut state, 3);
        let told = autosave.record(&end(), &state, &touched, true).unwrap_err();
        println!("record: {told}");
        let told = autosave.save(None, &state, None, &|_| true).unwrap_err();
        println!("save: {told}");
        assert!(!Path::new(&project).join("generation-000002").exists());
        assert!(!Path::new(&project).join("journal-000002").exists());
        // What is refused stays refused until there is room, and does no harm.
        assert!(autosave.record(&end(), &state, &[], true).is_err());
    }

    #[test]
    fn a_full_disk_is_told_and_loses_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let mut state = state(SMALL, dir.path());
        let project = saved(dir.path(), &state);
        // Blocks of 512 bytes in sh: 128 KiB a file; SIGXFSZ ignored, so that write answers with an error.
        let out = Process::new("sh")
            .args(["-c", "trap '' XFSZ; ulimit -f 256; exec \"$0\" \"$@\""])
            .arg(std::env::current_exe().unwrap())
            .args([
                "--exact",
                "document::keep_faults::full_disk::saves_and_records_on_a_full_disk",
                "--ignored",
                "--nocapture",
            ])
            .env(CHILD, &project)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&out.stdout).into_owned();
        assert!(out.status.success(), "{said}{}", String::from_utf8_lossy(&out.stderr));
        let line = |start: &str| said.lines().find(|l| l.starts_with(start)).unwrap_or_default().to_owned();
        let advice = "free some space or save elsewhere; what was saved before is intact";
        assert!(line("record: ").contains("journal-000001") && line("record: ").contains(advice), "{said}");
        assert!(line("save: ").contains("colour/0/c/0/0/0/0") && line("save: ").contains(advice), "{said}");
        paint(&mut state, FieldKind::Labels, [0; 3], 1);
        assert_kept(&state, &opened(&project), "the step before the disk was full");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_step_that_the_disk_refused_is_written_with_the_next_one() {
        let dir = tempfile::tempdir().unwrap();
        let mut state = state(SMALL, dir.path());
        let project = saved(dir.path(), &state);
        let status = Process::new("sh")
            .args(["-c", "trap '' XFSZ; ulimit -S -f 256; exec \"$0\" \"$@\""])
            .arg(std::env::current_exe().unwrap())
            .args([
                "--exact",
                "document::keep_faults::full_disk::records_when_there_is_room_again",
                "--ignored",
                "--nocapture",
            ])
            .env(CHILD, &project)
            .status()
            .unwrap();
        assert!(status.success());
        noise(&mut state, 3);
        paint(&mut state, FieldKind::Labels, [0; 3], 1);
        assert_kept(&state, &opened(&project), "both steps");
    }

    #[test]
    #[ignore = "a child process of a_step_that_the_disk_refused_is_written_with_the_next_one"]
    fn records_when_there_is_room_again() {
        let Ok(project) = std::env::var(CHILD) else { return };
        let (mut autosave, kept) = Autosave::open(Path::new(&project)).unwrap();
        let mut state = kept.into_state(|_| panic!("whole"), &|_| true).unwrap();
        let touched = noise(&mut state, 3);
        assert!(autosave.record(&end(), &state, &touched, true).is_err());
        let lifted =
            Process::new("prlimit").args(["--fsize=unlimited", "--pid", &std::process::id().to_string()]).status();
        assert!(lifted.is_ok_and(|s| s.success()), "prlimit of util-linux lifts the limit");
        let (kind, index, _) = paint(&mut state, FieldKind::Labels, [0; 3], 1);
        autosave.record(&end(), &state, &[(kind, index)], true).unwrap();
    }
}

#[test]
fn a_save_that_fails_at_its_last_step_leaves_nothing_of_itself() {
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(SMALL, dir.path());
    let project = saved(dir.path(), &state);
    let (mut autosave, _) = Autosave::open(&project).unwrap();
    paint_all(&mut state);
    let named = std::fs::read(project.join("project.json")).unwrap();
    // A folder of that name is what no rename replaces.
    std::fs::remove_file(project.join("project.json")).unwrap();
    std::fs::create_dir(project.join("project.json")).unwrap();
    autosave.save(None, &state, None, &|_| true).unwrap_err();
    let mut names: Vec<String> =
        std::fs::read_dir(&project).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, ["generation-000001", "journal-000001", "lock", "project.json"]);
    // And the next one succeeds.
    std::fs::remove_dir(project.join("project.json")).unwrap();
    std::fs::write(project.join("project.json"), named).unwrap();
    assert_eq!(autosave.save(None, &state, None, &|_| true).unwrap().generation, 2);
    drop(autosave);
    assert_kept(&state, &opened(&project), "after a save that failed");
}
