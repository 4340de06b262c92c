//! The file browser without its window: folders, typed paths, what is asked before something is written over.

use burin::interact::readout::bytes;
use burin::ui::browse::{Asks, Browser, By, Kind, Order, Purpose, Reading, date, places, resolve, shown};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant, UNIX_EPOCH};

const OPEN: Purpose = Purpose { asks: Asks::Open, endings: &[".nii", ".nii.gz", ".nrrd"] };
const PICTURE: Purpose = Purpose { asks: Asks::SaveFile, endings: &[".png", ".exr"] };
const PROJECT: Purpose = Purpose { asks: Asks::SaveFolder, endings: &[] };

/// A folder with a little of everything.
fn tree() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    for folder in ["scans", "scans/deep", "Old", "head.burin", "lost.burin", ".cache"] {
        std::fs::create_dir(at(folder)).unwrap();
    }
    std::fs::write(at("head.burin/project.json"), "{}").unwrap();
    std::fs::write(at("lost.burin/journal-1"), "x").unwrap();
    for (name, bytes) in
        [("scan10.nii", 10), ("scan9.nii.gz", 2000), ("Skull.NRRD", 300), ("notes.txt", 5), (".hid.nii", 1)]
    {
        std::fs::write(at(name), vec![0; bytes]).unwrap();
    }
    dir
}

fn browser(purpose: Purpose, folder: &Path, name: &str) -> Browser {
    let mut browser = Browser::new(purpose, folder, name, Some(folder.join("scans")), Arc::new(|| {}));
    wait(&mut browser);
    browser
}

fn wait(browser: &mut Browser) {
    let begun = Instant::now();
    loop {
        browser.poll();
        if *browser.reading() != Reading::On {
            return;
        }
        assert!(begun.elapsed() < Duration::from_secs(20), "the folder is never read");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn names(browser: &Browser) -> Vec<String> {
    (0..browser.len()).map(|row| browser.entry(row).unwrap().name.to_string_lossy().into_owned()).collect()
}

#[test]
fn folders_come_first_and_numbers_count_by_their_value() {
    let dir = tree();
    let mut b = browser(OPEN, dir.path(), "");
    assert_eq!(names(&b), ["Old", "scans", "head.burin", "lost.burin", "scan9.nii.gz", "scan10.nii", "Skull.NRRD"]);
    let kinds: Vec<Kind> = (0..4).map(|row| b.entry(row).unwrap().kind).collect();
    assert_eq!(kinds, [Kind::Folder, Kind::Folder, Kind::Project, Kind::Project]);
    b.sort(Order::by(By::Size));
    assert_eq!(names(&b)[2..5], ["scan9.nii.gz", "Skull.NRRD", "scan10.nii"], "the largest first");
    b.sort(Order::by(By::Size));
    assert_eq!(names(&b).last().unwrap(), "scan9.nii.gz", "the same column once more turns it round");
}

#[test]
fn what_cannot_be_opened_and_what_is_hidden_is_shown_when_asked_for() {
    let dir = tree();
    let mut b = browser(OPEN, dir.path(), "");
    b.show(true, false);
    assert!(names(&b).contains(&"notes.txt".into()) && !names(&b).contains(&".hid.nii".into()));
    b.show(false, true);
    assert!(!names(&b).contains(&"notes.txt".into()));
    assert!(names(&b).contains(&".hid.nii".into()) && names(&b).contains(&".cache".into()));
    assert!(names(&browser(PROJECT, dir.path(), "x")).iter().all(|n| !n.contains("scan9")), "files are no projects");
}

#[test]
fn typing_jumps_and_enter_takes_what_was_jumped_to() {
    let dir = tree();
    let mut b = browser(OPEN, dir.path(), "");
    b.type_text("sk".into());
    assert_eq!(b.entry(b.row().unwrap()).unwrap().name, "Skull.NRRD");
    assert_eq!(b.enter(), Some(dir.path().join("Skull.NRRD")));
    b.type_text("head".into());
    assert_eq!(b.enter(), Some(dir.path().join("head.burin")), "a project is opened and not gone into");
    b.type_text("lost.burin".into());
    assert_eq!(b.enter(), Some(dir.path().join("lost.burin")), "one without its manifest is for the document to judge");
    b.type_text("sca".into());
    assert_eq!(b.enter(), None);
    assert_eq!(b.folder(), dir.path().join("scans"), "a folder is gone into");
    assert_eq!(b.text(), "");
}

#[test]
fn a_path_that_leads_nowhere_is_said_and_stays() {
    let dir = tree();
    let mut b = browser(OPEN, dir.path(), "");
    for (typed, said) in [
        ("nothing.nii", "There is no “nothing.nii” in this folder."),
        ("~nobody/x.nii", "“~nobody/x.nii” is not known here"),
        ("file://elsewhere/x.nii", "another machine"),
    ] {
        b.type_text(typed.into());
        assert_eq!(b.enter(), None);
        assert!(b.error().unwrap().contains(said), "{:?}", b.error());
        assert_eq!(b.text(), typed);
        assert_eq!(b.folder(), dir.path());
    }
    b.type_text("n".into());
    assert_eq!(b.error(), None, "the sentence goes with its cause");
    b.type_text("/elsewhere/none.nii".into());
    assert_eq!(b.enter(), Some("/elsewhere/none.nii".into()), "a whole path is for the document to judge");
}

#[test]
fn typed_paths_mean_what_they_say() {
    let dir = tree();
    let here = dir.path();
    let home = Path::new("/home/someone");
    let to = |text: &str| resolve(text, here, Some(home)).unwrap();
    assert_eq!(to("~"), home);
    assert_eq!(to("~/a b/c.nii"), home.join("a b/c.nii"));
    assert_eq!(to("  /data/x.nii \n"), Path::new("/data/x.nii"));
    assert_eq!(to("scans/./x.nii"), here.join("scans/x.nii"));
    assert_eq!(to("\"/data/two words.nii\""), Path::new("/data/two words.nii"));
    assert_eq!(to("file:///data/two%20words%C3%A4.nii"), Path::new("/data/two wordsä.nii"));
    assert_eq!(to("file:///data/50%.nii"), Path::new("/data/50%.nii"));
    assert_eq!(to("file://localhost/data/x.nii"), Path::new("/data/x.nii"), "this machine by its name");
    assert_eq!(to("~//c.nii"), home.join("c.nii"), "a stroke too many does not leave home");
    assert_eq!(to("scans/../scan10.nii"), here.canonicalize().unwrap().join("scan10.nii"));
    assert!(resolve("~/x", here, None).is_err());
    assert!(resolve("   ", here, None).is_err());
    // A name may end in a blank, or begin with the sign of home.
    for odd in [" blank.nii ", "~odd.nii", "'quoted'"] {
        std::fs::write(here.join(odd), "").unwrap();
        assert_eq!(to(odd), here.join(odd));
    }
}

#[test]
fn arrows_move_through_the_list_and_the_way_up_remembers() {
    let dir = tree();
    let mut b = browser(OPEN, dir.path(), "");
    b.step(1);
    assert_eq!(b.row(), Some(0));
    b.step(1);
    b.step(-5);
    b.step(1);
    assert_eq!(b.row(), Some(1));
    assert_eq!(b.enter(), None);
    wait(&mut b);
    assert_eq!(b.folder(), dir.path().join("scans"));
    assert_eq!(names(&b), ["deep"]);
    b.up();
    wait(&mut b);
    assert_eq!(b.row(), Some(1), "where one came from is chosen");
    b.step(100);
    assert_eq!(b.row(), Some(b.len() - 1));
    let mut fresh = browser(OPEN, dir.path(), "");
    fresh.step(3);
    assert_eq!(fresh.row(), Some(2), "three presses in one frame are three");
    assert_eq!(b.enter(), Some(dir.path().join("Skull.NRRD")));
    // What was typed last counts.
    b.type_text("scan10.nii".into());
    b.step(-100);
    assert_eq!(b.enter(), None);
    assert_eq!(b.folder(), dir.path().join("Old"));
}

#[test]
fn writing_over_a_file_is_asked_and_an_ending_is_given() {
    let dir = tree();
    std::fs::write(dir.path().join("view.png"), "mine").unwrap();
    let mut b = browser(PICTURE, dir.path(), "view.png");
    assert_eq!(b.enter(), None);
    assert_eq!(b.replaces(), Some(dir.path().join("view.png").as_path()));
    assert!(b.back_out(), "Escape leaves the question first");
    assert_eq!((b.replaces(), b.text()), (None, "view.png"));
    assert!(!b.back_out());
    b.type_text("view".into());
    assert_eq!(b.enter(), None, "the ending makes it the file that is there");
    assert_eq!(b.replace(), Some(dir.path().join("view.png")));
    b.type_text("other".into());
    assert_eq!(b.enter(), Some(dir.path().join("other.png")));
    b.type_text("other.EXR".into());
    assert_eq!(b.enter(), Some(dir.path().join("other.EXR")));
    b.type_text("none/other.png".into());
    assert_eq!(b.enter(), None);
    assert!(b.error().unwrap().contains("There is no folder"), "{:?}", b.error());
    // With its ending the name is that of a folder, over which nothing can be written.
    std::fs::create_dir(dir.path().join("taken.png")).unwrap();
    b.type_text("taken".into());
    assert_eq!((b.enter(), b.replaces()), (None, None));
    assert!(b.error().unwrap().contains("“taken.png” is no file"), "{:?}", b.error());
    b.type_text("scans".into());
    assert_eq!(b.enter(), None);
    assert_eq!((b.folder(), b.text()), (dir.path().join("scans").as_path(), "view.png"), "a folder is gone into");
}

#[test]
fn an_ending_that_is_typed_before_the_offered_one_counts_once() {
    const VOLUME: Purpose = Purpose { asks: Asks::SaveFile, endings: &[".nii.gz", ".nii"] };
    let dir = tree();
    for (purpose, offered, typed, taken) in [
        (PICTURE, "view.png", "head.png.png", "head.png"),
        (PICTURE, "view.png", "head.exr.png", "head.exr"),
        (PICTURE, "view.png", "head.v2.png", "head.v2.png"),
        (PICTURE, "view.png", ".png.png", ".png.png"),
        (VOLUME, "ct-labels.nii.gz", "mine.nii.gz.nii.gz", "mine.nii.gz"),
        (VOLUME, "ct-labels.nii.gz", "mine.nii.nii.gz", "mine.nii"),
        (VOLUME, "ct-labels.nii.gz", "mine.nii.gz", "mine.nii.gz"),
        (PROJECT, "ct.burin", "mine.burin.burin", "mine.burin"),
        (PROJECT, "ct.burin", "mine.burin", "mine.burin"),
        (PROJECT, "ct.burin", "mine.nii.burin", "mine.nii.burin"),
    ] {
        let mut b = browser(purpose, dir.path(), offered);
        b.type_text(typed.into());
        assert_eq!(b.enter(), Some(dir.path().join(taken)), "{typed} for {offered}");
    }
}

#[test]
fn a_project_gets_a_folder_of_its_own() {
    let dir = tree();
    let mut b = browser(PROJECT, dir.path(), "new.burin");
    assert_eq!(b.enter(), Some(dir.path().join("new.burin")));
    b.type_text("notes.txt".into());
    assert_eq!(b.enter(), None);
    assert!(b.error().unwrap().contains("is a file"), "{:?}", b.error());
    b.type_text("scans".into());
    assert_eq!(b.enter(), None);
    assert_eq!(b.folder(), dir.path().join("scans"), "a folder with something in it is gone into");
    b.type_text("deep".into());
    assert_eq!(b.enter(), Some(dir.path().join("scans/deep")), "an empty one serves");
}

#[test]
fn a_new_folder_is_made_and_gone_into() {
    let dir = tree();
    let mut b = browser(PICTURE, dir.path(), "view.png");
    b.name_folder("a/b".into());
    b.make_folder();
    assert!(b.error().unwrap().contains("without “/”"));
    b.name_folder("scans".into());
    b.make_folder();
    assert!(b.error().unwrap().contains("something of that name is there already"), "{:?}", b.error());
    assert_eq!(b.new_folder(), Some("scans"), "what was typed stays");
    b.name_folder("pictures".into());
    b.make_folder();
    assert_eq!(b.folder(), dir.path().join("pictures"));
    assert_eq!((b.error(), b.new_folder(), b.text()), (None, None, "view.png"));
}

#[test]
fn ten_thousand_files_hold_nobody() {
    let dir = tempfile::tempdir().unwrap();
    for i in 0..10_000 {
        std::fs::File::create(dir.path().join(format!("slice{i}.nii"))).unwrap();
    }
    let begun = Instant::now();
    let mut b = Browser::new(OPEN, dir.path(), "", None, Arc::new(|| {}));
    b.poll();
    assert!(begun.elapsed() < Duration::from_millis(100), "it is read beside: {:?}", begun.elapsed());
    wait(&mut b);
    assert_eq!(b.len(), 10_000);
    assert_eq!(names(&b)[9_999], "slice9999.nii");
    b.type_text("slice1234.".into());
    assert_eq!(b.row(), Some(1234));
}

#[test]
fn a_folder_that_is_gone_is_shown_as_the_next_one_above() {
    let dir = tree();
    let b = browser(OPEN, &dir.path().join("scans/gone/too"), "");
    assert_eq!(b.folder(), dir.path().join("scans"));
    let mut b = browser(OPEN, &dir.path().join("scans/deep"), "");
    std::fs::remove_dir(dir.path().join("scans/deep")).unwrap();
    b.refresh();
    wait(&mut b);
    let Reading::Failed(why) = b.reading() else { panic!("{:?}", b.reading()) };
    assert_eq!(why, "This folder cannot be shown: it is not there.");
}

#[cfg(unix)]
#[test]
fn names_that_are_no_text_are_shown_and_opened() {
    use std::os::unix::ffi::OsStrExt;
    let dir = tempfile::tempdir().unwrap();
    let name = OsStr::from_bytes(b"h\xffad\n.nii");
    std::fs::write(dir.path().join(name), "x").unwrap();
    rustix_fifo(&dir.path().join("pipe.nii"));
    std::os::unix::fs::symlink(dir.path().join("nowhere"), dir.path().join("link.nii")).unwrap();
    let mut b = browser(OPEN, dir.path(), "");
    assert_eq!(b.len(), 1, "neither a pipe nor a link to nothing can be opened");
    assert_eq!(shown(&b.entry(0).unwrap().name), "h\u{fffd}ad\\n.nii");
    b.step(1);
    assert_eq!(b.enter(), Some(dir.path().join(name)));
}

#[cfg(unix)]
fn rustix_fifo(path: &Path) {
    let made = std::process::Command::new("mkfifo").arg(path).status().unwrap();
    assert!(made.success());
}

#[test]
fn places_are_each_named_once() {
    let home = tempfile::tempdir().unwrap();
    std::fs::create_dir(home.path().join("Documents")).unwrap();
    let recent = [PathBuf::from("/data/a"), home.path().join("Documents")];
    let found = places(Some(home.path()), &recent);
    let count = |path: &Path| found.iter().filter(|p| p.path == path).count();
    assert_eq!((count(home.path()), count(&recent[0]), count(&recent[1])), (1, 1, 1));
    assert!(found.iter().any(|p| p.recent && p.name == "a"));
    assert!(!found.iter().any(|p| p.name == "Desktop"), "only what is there");
}

#[test]
fn sizes_and_dates_are_read_in_passing() {
    let said: Vec<String> = [0, 999, 1000, 9_949, 9_951, 999_499, 999_500, 7_109_137, u64::MAX].map(bytes).into();
    assert_eq!(said, ["0 B", "999 B", "1.0 kB", "9.9 kB", "10 kB", "999 kB", "1.0 MB", "7.1 MB", "18446744 TB"]);
    let at = |days: u64| UNIX_EPOCH + Duration::from_secs(days * 86_400);
    // Days since 1970 of known dates, leap days among them.
    for (days, said) in [
        (0, "1970-01-01"),
        (11_016, "2000-02-29"),
        (19_782, "2024-02-29"),
        (19_783, "2024-03-01"),
        (20_783, "2026-11-26"),
        (47_540, "2100-02-28"),
        (47_541, "2100-03-01"),
    ] {
        assert_eq!(date(at(days), at(60_000)), said);
    }
    assert_eq!(date(at(10), at(10) + Duration::from_secs(7300)), "2 hours ago");
    assert_eq!(date(UNIX_EPOCH - Duration::from_secs(1), at(1)), "1969-12-31");
    assert_eq!(date(at(20_783), at(3)), "2026-11-26", "a clock that runs ahead");
}

#[test]
fn a_name_from_the_systems_dialog_that_becomes_another_files_by_its_ending_is_asked_about() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    std::fs::write(at("view.png"), "not to be lost").unwrap();
    std::fs::create_dir(at("folder.png")).unwrap();
    let given = |name: &str| Browser::given(PICTURE, &at(name), None, Arc::new(|| {}));
    // The system has asked about a name that was whole.
    for (name, path) in [("view.png", "view.png"), ("new.EXR", "new.EXR"), ("new", "new.png"), ("a.b", "a.b.png")] {
        assert_eq!(given(name).map_err(|_| ()), Ok(at(path)), "{name}");
    }
    let Err(mut b) = given("view") else { panic!("written over without a word") };
    assert_eq!((b.replaces(), b.folder()), (Some(&*at("view.png")), dir.path()));
    assert!(b.back_out());
    assert_eq!((b.text(), b.replaces()), ("view.png", None), "another name can be typed");
    let Err(b) = given("folder") else { panic!("a folder is no file") };
    assert!(b.error().is_some_and(|e| e.contains("folder.png")), "{:?}", b.error());
}
