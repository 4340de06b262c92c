//! The file browser in the window: rows, places, keys and small questions lead where they say.

use super::driver::{SMALL, Window};
use burin::document::{Command, ProjectCommand};
use burin::ui::{Recent, Report};
use egui::accesskit::Toggled;
use egui::{Key, Modifiers, PointerButton};
use egui_kittest::kittest::{NodeT, Queryable};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A home folder with a little in it: `scans` with two files, a file of another kind, a hidden one.
fn home() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir(dir.path().join("scans")).unwrap();
    for name in ["scans/a.nii", "scans/b.nii", "scans/notes.txt", "scans/.hid.nii"] {
        std::fs::write(dir.path().join(name), "x").unwrap();
    }
    dir
}

/// A window over it that shows the folder `scans` for a project's or a volume's path, with a document or without.
fn browsing(home: &Path, open: bool) -> Window {
    let state = home.join("state");
    let mut window = Window::with_files(SMALL, Recent::kept_in(state), Some(home.into()));
    window.harness.run_steps(3);
    if open {
        window.snapshot(|_| {});
        window.key(Modifiers::COMMAND | Modifiers::SHIFT, Key::S);
    } else {
        window.key(Modifiers::COMMAND, Key::O);
    }
    go(&mut window, home);
    row(&mut window, "Folder scans");
    window
}

fn go(window: &mut Window, folder: &Path) {
    window.click(&format!("Go to {}", folder.display()));
}

/// Waits for a row of the list, which is read beside.
fn row(window: &mut Window, name: &str) -> egui::Rect {
    let begun = Instant::now();
    loop {
        if let Some(node) = window.harness.query_by_label(name) {
            return node.rect();
        }
        assert!(begun.elapsed() < Duration::from_secs(20), "there is never a row {name}");
        std::thread::sleep(Duration::from_millis(2));
        window.harness.run_steps(1);
    }
}

fn chosen(window: &Window, name: &str) -> bool {
    window.harness.get_by_label(name).accesskit_node().toggled() == Some(Toggled::True)
}

fn double_click(window: &mut Window, name: &str) {
    let pos = row(window, name).center();
    window.harness.hover_at(pos);
    window.harness.run_steps(1);
    for pressed in [true, false, true, false] {
        let event =
            egui::Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE };
        window.harness.input_mut().events.push(event);
    }
    window.harness.run_steps(3);
}

fn path(window: &Window) -> String {
    window.harness.get_by_label("Path").value().unwrap_or_default()
}

#[test]
fn the_row_under_the_pointer_is_the_one_that_is_taken() {
    let home = home();
    let mut window = browsing(home.path(), false);
    double_click(&mut window, "Folder scans");
    row(&mut window, "File a.nii");
    for name in ["File a.nii", "File b.nii"] {
        assert_eq!(window.click(name), []);
        for other in ["File a.nii", "File b.nii"] {
            assert_eq!(chosen(&window, other), other == name, "{other} after a click on {name}");
        }
    }
    double_click(&mut window, "File a.nii");
    let begun = Instant::now();
    let sent = loop {
        let sent = window.sent();
        if !sent.is_empty() {
            break serde_json::to_value(&sent).unwrap();
        }
        assert!(begun.elapsed() < Duration::from_secs(20), "nothing is opened");
        window.harness.run_steps(1);
        std::thread::sleep(Duration::from_millis(2));
    };
    let file = home.path().join("scans/a.nii");
    assert_eq!(sent[0]["volume"]["open"]["path"].as_str().map(PathBuf::from), Some(file));
}

#[test]
fn kinds_of_files_are_asked_for_only_where_files_are_shown() {
    let home = home();
    let mut window = browsing(home.path(), false);
    double_click(&mut window, "Folder scans");
    row(&mut window, "File a.nii");
    for (name, shown) in [("File notes.txt", "All files"), ("File .hid.nii", "Hidden")] {
        assert!(window.harness.query_by_label(name).is_none(), "{name}");
        window.click(shown);
        assert!(window.harness.query_by_label(name).is_some(), "{name} with {shown}");
        window.click(shown);
        assert!(window.harness.query_by_label(name).is_none(), "{name} without {shown}");
    }
    let window = browsing(home.path(), true);
    assert!(window.harness.query_by_label("All files").is_none(), "a project is a folder");
    assert!(window.harness.query_by_label("Hidden").is_some());
}

#[test]
fn an_empty_list_says_why_it_is_empty() {
    let home = home();
    std::fs::create_dir(home.path().join("scans/none")).unwrap();
    std::fs::create_dir(home.path().join("scans/text")).unwrap();
    std::fs::write(home.path().join("scans/text/notes.txt"), "x").unwrap();
    let said = |window: &mut Window, text: &str| {
        let begun = Instant::now();
        while window.harness.query_by_label(text).is_none() {
            assert!(begun.elapsed() < Duration::from_secs(20), "“{text}” is never said");
            window.harness.run_steps(1);
            std::thread::sleep(Duration::from_millis(2));
        }
    };
    let nothing = "Nothing here that can be opened. “All files” shows the rest.";
    let mut window = browsing(home.path(), false);
    double_click(&mut window, "Folder scans");
    double_click(&mut window, "Folder text");
    said(&mut window, nothing);
    window.click("All files");
    row(&mut window, "File notes.txt");
    window.click("Folder above");
    double_click(&mut window, "Folder none");
    said(&mut window, "This folder is empty.");
    window.click("All files");
    said(&mut window, nothing);
    let mut window = browsing(home.path(), true);
    double_click(&mut window, "Folder scans");
    double_click(&mut window, "Folder text");
    said(&mut window, "No folder is in here.");
}

#[test]
fn pages_and_arrows_move_through_the_list_both_ways() {
    let home = home();
    for i in 0..60 {
        std::fs::write(home.path().join(format!("scans/s{i:02}.nii")), "x").unwrap();
    }
    let mut window = browsing(home.path(), false);
    double_click(&mut window, "Folder scans");
    row(&mut window, "File a.nii");
    window.key(Modifiers::NONE, Key::ArrowDown);
    assert!(chosen(&window, "File a.nii"));
    window.key(Modifiers::NONE, Key::ArrowDown);
    assert!(chosen(&window, "File b.nii"));
    window.key(Modifiers::NONE, Key::PageDown);
    assert!(window.harness.query_by_label("File b.nii").is_none_or(|_| !chosen(&window, "File b.nii")));
    window.key(Modifiers::NONE, Key::PageUp);
    assert!(chosen(&window, "File b.nii"), "a page down and up again is where one was");
    window.key(Modifiers::NONE, Key::ArrowUp);
    assert!(chosen(&window, "File a.nii"));
}

#[test]
fn f5_reads_the_folder_anew() {
    let home = home();
    let mut window = browsing(home.path(), false);
    double_click(&mut window, "Folder scans");
    row(&mut window, "File a.nii");
    std::fs::write(home.path().join("scans/new.nii"), "x").unwrap();
    window.harness.run_steps(5);
    assert!(window.harness.query_by_label("File new.nii").is_none());
    window.key(Modifiers::NONE, Key::F5);
    row(&mut window, "File new.nii");
}

#[test]
fn no_folder_is_made_unless_it_is_wanted() {
    let home = home();
    let mut window = browsing(home.path(), true);
    let typed = |window: &mut Window| {
        window.click("New folder");
        window.harness.get_by_label("Name of the new folder").type_text("fresh");
        window.harness.run_steps(2);
    };
    let before = path(&window);
    typed(&mut window);
    assert_eq!(window.click("Make no folder"), []);
    assert!(window.harness.query_by_label("Name of the new folder").is_none(), "the question is gone");
    assert!(!home.path().join("fresh").exists());
    assert_eq!(path(&window), before, "what was typed for the project is not touched");
    typed(&mut window);
    window.key(Modifiers::NONE, Key::Enter);
    assert!(home.path().join("fresh").is_dir(), "Enter makes it");
    std::fs::remove_dir(home.path().join("fresh")).unwrap();
    go(&mut window, home.path());
    typed(&mut window);
    window.click("Make the folder");
    assert!(home.path().join("fresh").is_dir());
    assert!(window.harness.query_by_label("Name of the new folder").is_none());
    // It is gone into: the project comes to lie there.
    let sent = window.click("Save project at this path");
    let [Command::Project(ProjectCommand::Save { path: Some(saved), .. })] = &sent[..] else { panic!("{sent:?}") };
    assert_eq!(saved, &home.path().join("fresh").join(&before));
}

#[test]
fn the_folder_is_read_anew_when_a_path_failed() {
    let home = home();
    let mut window = browsing(home.path(), false);
    double_click(&mut window, "Folder scans");
    row(&mut window, "File a.nii");
    window.harness.get_by_label("Path").type_text("b.nii");
    window.harness.run_steps(2);
    window.harness.key_press_modifiers(Modifiers::NONE, Key::Enter);
    let begun = Instant::now();
    let sent = loop {
        window.harness.run_steps(1);
        let sent = window.sent();
        if !sent.is_empty() {
            break sent;
        }
        assert!(begun.elapsed() < Duration::from_secs(20), "nothing is opened");
        std::thread::sleep(Duration::from_millis(2));
    };
    std::fs::write(home.path().join("scans/better.nii"), "x").unwrap();
    window.report(Report::Refused(Box::new(sent[0].clone()), "b.nii: it is damaged".into()));
    assert_eq!(path(&window), "b.nii", "what was typed is there");
    row(&mut window, "File better.nii");
}
