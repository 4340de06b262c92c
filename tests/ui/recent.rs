//! What was open lately, and the sample: files below a folder that the test names, never the user's own.

use burin::document::OpenAs;
use burin::ui::{Recent, Sample};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

fn paths(recent: &Recent) -> Vec<PathBuf> {
    recent.entries().iter().map(|seen| seen.path.clone()).collect()
}

#[test]
fn the_last_one_comes_first_and_each_once() {
    let dir = tempfile::tempdir().unwrap();
    let state = dir.path().join("a/b");
    let mut recent = Recent::kept_in(state.clone());
    for (path, project) in
        [("/data/one.nii", false), ("/data/two.burin", true), ("/other/one.nii", false), ("/data/one.nii", false)]
    {
        match project {
            true => recent.note_project(Path::new(path)),
            false => recent.note_volume(Path::new(path), OpenAs::Image),
        }
    }
    let known = ["/data/one.nii", "/other/one.nii", "/data/two.burin"].map(PathBuf::from);
    assert_eq!(paths(&recent), known);
    assert_eq!(recent.folders(), ["/data", "/other"].map(PathBuf::from));
    let again = Recent::kept_in(state.clone());
    assert_eq!(paths(&again), known, "it is kept");
    assert!(again.entries()[2].project && !again.entries()[0].project);
    for i in 0..40 {
        recent.note_volume(Path::new(&format!("/many/{i}.nii")), OpenAs::Image);
    }
    assert_eq!(recent.entries().len(), 24);
    recent.forget(Path::new("/many/39.nii"));
    assert_eq!(Recent::kept_in(state.clone()).entries()[0].path, Path::new("/many/38.nii"));
    recent.forget_all();
    assert!(Recent::kept_in(state).entries().is_empty());
}

#[test]
fn two_windows_keep_each_others_files() {
    let dir = tempfile::tempdir().unwrap();
    let (mut a, mut b) = (Recent::kept_in(dir.path().into()), Recent::kept_in(dir.path().into()));
    a.note_volume(Path::new("/data/a.nii"), OpenAs::Image);
    b.note_volume(Path::new("/data/b.nii"), OpenAs::Image);
    assert_eq!(paths(&Recent::kept_in(dir.path().into())), ["/data/b.nii", "/data/a.nii"].map(PathBuf::from));
}

#[test]
fn a_damaged_list_costs_what_is_damaged() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("recent.json");
    for damage in [
        "",
        "{",
        "[1, 2]",
        "{\"entries\": 3}",
        "\u{0}\u{0}",
        "{\"entries\": [{\"path\": \"relative.nii\"}, {\"path\": [300]}]}",
    ] {
        std::fs::write(&file, damage).unwrap();
        assert!(Recent::kept_in(dir.path().into()).entries().is_empty(), "{damage}");
    }
    let list = r#"{"version": 7, "entries": [1, {"path": "/data/a.nii", "when": -3, "more": []},
        {"when": 5}, {"path": "/data/b.burin", "project": true, "when": 18446744073709551615}]}"#;
    std::fs::write(&file, list).unwrap();
    let mut recent = Recent::kept_in(dir.path().into());
    assert_eq!(paths(&recent), ["/data/a.nii", "/data/b.burin"].map(PathBuf::from));
    recent.note_volume(Path::new("/data/c.nii"), OpenAs::Image);
    assert_eq!(Recent::kept_in(dir.path().into()).entries().len(), 3);
    std::fs::write(&file, vec![b' '; 2 << 20]).unwrap();
    assert!(Recent::kept_in(dir.path().into()).entries().is_empty(), "an endless list is none");
}

#[test]
fn a_folder_that_cannot_be_written_costs_nothing_else() {
    let dir = tempfile::tempdir().unwrap();
    let taken = dir.path().join("file");
    std::fs::write(&taken, "x").unwrap();
    let mut recent = Recent::kept_in(taken.join("below"));
    recent.note_volume(Path::new("/data/a.nii"), OpenAs::Image);
    assert_eq!(recent.entries().len(), 1, "for this window it is known");
    let mut nowhere = Recent::default();
    nowhere.note_volume(Path::new("/data/a.nii"), OpenAs::Image);
    assert_eq!(nowhere.entries().len(), 1);
}

#[cfg(unix)]
#[test]
fn the_list_is_for_its_owner_and_is_no_link() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempfile::tempdir().unwrap();
    let state = dir.path().join("state");
    let mut recent = Recent::kept_in(state.clone());
    recent.note_volume(Path::new("/data/a.nii"), OpenAs::Image);
    let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
    assert_eq!((mode(&state), mode(&state.join("recent.json"))), (0o700, 0o600));
    assert_eq!(std::fs::read_dir(&state).unwrap().count(), 1, "nothing is left beside it");

    let other = dir.path().join("other");
    std::fs::write(&other, std::fs::read(state.join("recent.json")).unwrap()).unwrap();
    std::fs::remove_file(state.join("recent.json")).unwrap();
    std::os::unix::fs::symlink(&other, state.join("recent.json")).unwrap();
    let before = std::fs::read(&other).unwrap();
    let mut linked = Recent::kept_in(state);
    assert!(linked.entries().is_empty());
    linked.note_volume(Path::new("/data/b.nii"), OpenAs::Image);
    assert_eq!(std::fs::read(&other).unwrap(), before, "what the link leads to is not written");
}

#[cfg(unix)]
#[test]
fn a_name_that_is_no_text_is_kept_as_it_is() {
    use std::os::unix::ffi::OsStrExt;
    let dir = tempfile::tempdir().unwrap();
    let path = PathBuf::from(std::ffi::OsStr::from_bytes(b"/data/h\xffad \n.nii"));
    Recent::kept_in(dir.path().into()).note_volume(&path, OpenAs::Image);
    assert_eq!(paths(&Recent::kept_in(dir.path().into())), [path]);
}

#[test]
fn what_is_gone_is_known_after_a_look() {
    let dir = tempfile::tempdir().unwrap();
    let here = dir.path().join("here.nii");
    std::fs::write(&here, "x").unwrap();
    let mut recent = Recent::kept_in(dir.path().join("state"));
    for (path, project) in
        [(here.clone(), false), (dir.path().join("gone.nii"), false), (here.clone().with_extension("burin"), true)]
    {
        match project {
            true => recent.note_project(&path),
            false => recent.note_volume(&path, OpenAs::Image),
        }
    }
    let mut recent = Recent::kept_in(dir.path().join("state"));
    recent.look(Arc::new(|| {}));
    let begun = Instant::now();
    while !(recent.is_gone(&dir.path().join("gone.nii")) && recent.is_gone(&dir.path().join("here.burin"))) {
        recent.poll();
        assert!(begun.elapsed() < Duration::from_secs(20));
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(!recent.is_gone(&here));
}

#[test]
fn the_sample_is_laid_whole_and_opens() {
    let dir = tempfile::tempdir().unwrap();
    let sample = Sample::below(dir.path());
    sample.lay().unwrap();
    let head = burin::io::open(&sample.head).unwrap();
    assert_eq!(head.grid.dims, [181, 217, 181]);
    assert_eq!(burin::io::open(&sample.brain).unwrap().grid.dims, [181, 217, 181]);
    assert!(sample.head.with_file_name("NOTICE.md").exists(), "whose it is lies beside it");
    // What was damaged is laid anew.
    std::fs::write(&sample.head, "x").unwrap();
    sample.lay().unwrap();
    assert!(std::fs::metadata(&sample.head).unwrap().len() > 3_000_000);
    let mut recent = Recent::kept_in(dir.path().into());
    recent.note_volume(&sample.head, OpenAs::Image);
    assert!(recent.entries().is_empty(), "the start page offers it already");
    let taken = dir.path().join("file");
    std::fs::write(&taken, "x").unwrap();
    let error = Sample::below(&taken).lay().unwrap_err();
    assert!(error.contains("The sample needs the folder") && !error.contains("os error"), "{error}");
}

#[test]
fn a_list_that_somebody_else_wrote_is_no_longer_and_names_nothing_twice() {
    let dir = tempfile::tempdir().unwrap();
    let entry = |i: u32| serde_json::json!({ "path": format!("/data/{i}.nii"), "project": false, "when": 1000 - i });
    let entries: Vec<_> = (0..200).flat_map(|i| [entry(i), entry(i)]).collect();
    let list = serde_json::json!({ "version": 1, "entries": entries });
    std::fs::write(dir.path().join("recent.json"), list.to_string()).unwrap();
    let read = paths(&Recent::kept_in(dir.path().into()));
    // As many as one of this program's own has, in their order.
    let own = tempfile::tempdir().unwrap();
    let mut recent = Recent::kept_in(own.path().into());
    (0..200).for_each(|i| recent.note_volume(Path::new(&format!("/data/{i}.nii")), OpenAs::Image));
    let most = recent.entries().len();
    assert!((5..100).contains(&most));
    assert_eq!(read, (0..most).map(|i| PathBuf::from(format!("/data/{i}.nii"))).collect::<Vec<_>>());
}
