//! The command line: damage and recovery are told by every door; names of any bytes work or are refused in plain words, and
//! nothing that is printed is an order to a terminal.

use super::maker::write_nrrd;
use burin::math::DVec3;
use burin::volume::Grid;
use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What it said on stdout and stderr, and its exit code.
fn burin(folder: &Path, arguments: &[&dyn AsRef<OsStr>], script: &str) -> (String, String, Option<i32>) {
    let mut command = Command::new(crate::common::program());
    command.current_dir(folder).env("HOME", folder).args(arguments.iter().map(|a| a.as_ref()));
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let _ = child.stdin.take().unwrap().write_all(script.as_bytes());
    let output = child.wait_with_output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr), output.status.code())
}

fn volume(path: &Path) {
    let grid = Grid::aligned([12, 10, 8], DVec3::ONE, DVec3::ZERO);
    write_nrrd(path, &grid, |v| v[0] as f32);
}

/// A project with two steps in its journal, as a crash leaves it.
fn crashed(folder: &Path) -> PathBuf {
    use super::maker::run;
    volume(&folder.join("v.nrrd"));
    let mut document = burin::document::Document::new();
    let json = |value: serde_json::Value| value.to_string();
    run(&mut document, &json(serde_json::json!({"volume":{"open":{"path":folder.join("v.nrrd")}}}))).unwrap();
    run(&mut document, &json(serde_json::json!({"project":{"save":{"path":folder.join("p")}}}))).unwrap();
    run(&mut document, r#"{"segment":{"set":{"id":7,"name":"jaw"}}}"#).unwrap();
    run(&mut document, r#"{"segment":{"set":{"id":8,"name":"tooth"}}}"#).unwrap();
    drop(document);
    folder.join("p")
}

#[test]
fn recovery_and_damage_are_told_by_every_door() {
    let folder = tempfile::tempdir().unwrap();
    let project = crashed(folder.path());
    let journal = project.join("journal-000001");
    let whole = std::fs::read(&journal).unwrap();
    let doors = |words: &[&str]| {
        let render: [&dyn AsRef<OsStr>; 8] = [&"render", &"p", &"-o", &"x.png", &"--view", &"axial", &"--size", &"8x8"];
        let run: [&dyn AsRef<OsStr>; 4] = [&"run", &"-", &"--project", &"p"];
        for arguments in [&render[..], &run[..]] {
            let (_, stderr, _) = burin(folder.path(), arguments, "");
            for word in words {
                assert!(stderr.contains(word), "{word:?} not in {stderr:?}");
            }
        }
    };
    doors(&["p: What was not saved when the program ended was brought back"]);
    // The second step was being written.
    std::fs::write(&journal, &whole[..whole.len() - 3]).unwrap();
    let (_, stderr, _) = burin(folder.path(), &[&"render", &"p", &"-o", &"x.png", &"--view", &"axial"], "");
    assert!(
        stderr.contains("brought back") && stderr.contains("being noted when the program ended is lost"),
        "{stderr}"
    );
    // The first is damaged.
    let mut damaged = whole.clone();
    damaged[60] ^= 1;
    std::fs::write(&journal, &damaged).unwrap();
    doors(&["checksum does not match", "with the steps in them, are lost"]);
    // It is told once by whoever puts it aside.
    std::fs::write(&journal, b"no journal at all, but long enough").unwrap();
    doors(&["journal-000001: header"]);
    std::fs::remove_file(project.join("project.json")).unwrap();
    doors(&["project.json is missing; generation 1, the newest that is whole, was opened"]);
    // What a script says is on stdout, a line a command, and nothing else.
    let (stdout, _, code) = burin(folder.path(), &[&"run", &"-", &"--project", &"p"], "{\"ask\":{\"history\":{}}}\n");
    assert_eq!((stdout.lines().count(), code), (1, Some(0)), "{stdout}");
}

#[test]
fn a_new_project_is_made_where_there_is_none() {
    let folder = tempfile::tempdir().unwrap();
    volume(&folder.path().join("v.nrrd"));
    let script = "{\"volume\":{\"open\":{\"path\":\"v.nrrd\"}}}\n{\"project\":{\"save\":{}}}\n";
    let (stdout, stderr, code) = burin(folder.path(), &[&"run", &"-", &"--project", &"new"], script);
    assert_eq!((stdout.lines().count(), stderr.as_str(), code), (2, "", Some(0)), "{stdout}");
    assert!(folder.path().join("new/project.json").exists());
}

#[test]
fn a_file_is_no_place_for_a_project_and_that_is_said_at_once() {
    let folder = tempfile::tempdir().unwrap();
    volume(&folder.path().join("v.nrrd"));
    let before = std::fs::read(folder.path().join("v.nrrd")).unwrap();
    let script = "{\"ask\":{\"volume\":{}}}\n";
    let (stdout, stderr, code) = burin(folder.path(), &[&"run", &"-", &"--project", &"v.nrrd"], script);
    assert_eq!((stdout.as_str(), code), ("", Some(2)));
    assert!(stderr.contains("v.nrrd: a file found"), "{stderr}");
    assert_eq!(std::fs::read(folder.path().join("v.nrrd")).unwrap(), before);
}

#[test]
#[cfg(unix)]
fn names_of_any_bytes_work_or_are_refused_in_plain_words() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    for name in
        [&b"sp ace.nrrd"[..], b"new\nline.nrrd", b"\x1b[31mred.nrrd", b"not \xff utf8.nrrd", "größe.nrrd".as_bytes()]
    {
        let name = OsStr::from_bytes(name);
        volume(&folder.path().join(name));
        let (stdout, stderr, code) = burin(folder.path(), &[&"info", &name], "");
        assert_eq!((code, stderr.as_str()), (Some(0), ""), "{name:?}");
        assert!(stdout.contains("dims: [12,10,8]"), "{stdout}");
        let (_, stderr, code) = burin(folder.path(), &[&"render", &name, &"-o", &"x.png", &"--view", &"axial"], "");
        let no_gpu = stderr.contains("needs a GPU");
        assert!(code == Some(0) || no_gpu, "{name:?}: {stderr}");
        // The project is in a folder of that name.
        let project = Path::new(name).with_extension("burin");
        let script = "{\"volume\":{\"open\":{\"path\":\"~/plain.nrrd\"}}}\n{\"project\":{\"save\":{}}}\n";
        volume(&folder.path().join("plain.nrrd"));
        let (stdout, stderr, code) = burin(folder.path(), &[&"run", &"-", &"--project", &project], script);
        assert_eq!((code, stderr.as_str()), (Some(0), ""), "{name:?}: {stdout}");
        assert!(folder.path().join(&project).join("project.json").exists());
    }
    let name = OsStr::from_bytes(b"not \xff utf8");
    let (_, stderr, code) = burin(folder.path(), &[&"render", &"plain.nrrd", &"-o", &name], "");
    assert_eq!(code, Some(2));
    assert!(stderr.contains("--output: a name that is not UTF-8 found"), "{stderr}");
    let (stdout, ..) = burin(folder.path(), &[&"run", &"-"], "{\"volume\":{\"open\":{\"path\":\"\"}}}\n");
    assert!(stdout.contains("path: nothing found"), "{stdout}");
}

#[test]
fn a_volume_whose_name_is_not_utf_8_is_saved_whole_and_never_linked() {
    #[cfg(unix)]
    {
        use burin::document::{Command, DensityKeeping, Document, OpenAs, ProjectCommand, VolumeCommand};
        use std::os::unix::ffi::OsStrExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(OsStr::from_bytes(b"v\xff.nrrd"));
        volume(&path);
        let mut document = Document::new();
        document.keep_unsaved_in(folder.path().join("states"));
        let open = VolumeCommand::Open { path, component: 0, frame: 0, range: None, open_as: OpenAs::Image };
        let answer = document.apply(Command::Volume(open)).unwrap().to_json().unwrap();
        assert!(answer["warnings"][0].as_str().unwrap().contains("not UTF-8"), "{answer}");
        let save = |density| {
            Command::Project(ProjectCommand::Save { path: Some(folder.path().join("p")), density: Some(density) })
        };
        let refused = document.apply(save(DensityKeeping::Linked)).unwrap_err().to_string();
        assert!(
            refused.contains("a name that is not UTF-8 found") && refused.contains("density \"whole\""),
            "{refused}"
        );
        document.apply(save(DensityKeeping::Whole)).unwrap();
        document.apply(Command::Ask(burin::document::Question::Scene {})).unwrap();
        drop(document);
        let open = ProjectCommand::Open { path: folder.path().join("p"), source: None, generation: None };
        Document::new().apply(Command::Project(open)).unwrap();
    }
}

#[test]
fn what_is_printed_is_no_order_to_a_terminal_and_of_bounded_length() {
    let folder = tempfile::tempdir().unwrap();
    let nasty = "\u{1b}]0;title\u{7}\u{9b}31m\u{7f}\u{202e}";
    let is_order = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
    // A header that is none, a name that is not there, a segment's name, an unknown field.
    let long = "x".repeat(3000);
    std::fs::write(folder.path().join("bad.nrrd"), format!("NRRD0004\n{nasty}{long}\n\n")).unwrap();
    let header = format!("NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 1\n{nasty}: {long}\nencoding: raw\n\nx");
    std::fs::write(folder.path().join("odd.nrrd"), header).unwrap();
    volume(&folder.path().join("v.nrrd"));
    let missing = format!("{nasty}missing.nrrd");
    let script = format!(
        "{{\"volume\":{{\"open\":{{\"path\":\"v.nrrd\"}}}}}}\n{}\n",
        serde_json::json!({"segment":{"set":{"id":1,"name":nasty}}})
    );
    let cases: [(&[&dyn AsRef<OsStr>], &str); 6] = [
        (&[&"info", &"bad.nrrd"], ""),
        (&[&"info", &"odd.nrrd"], ""),
        (&[&"info", &"odd.nrrd", &"--json"], ""),
        (&[&"info", &missing], ""),
        (&[&"run", &missing], ""),
        (&[&"run", &"-"], &script),
    ];
    for (i, (arguments, script)) in cases.into_iter().enumerate() {
        let (stdout, stderr, _) = burin(folder.path(), arguments, script);
        let said = stdout.clone() + &stderr;
        assert!(!said.chars().any(is_order), "case {i}: {said:?}");
        assert!(said.lines().all(|line| line.chars().count() < 4200), "case {i}: {said:?}");
        // What JSON says is still what it was.
        if i == 5 {
            let last: serde_json::Value = serde_json::from_str(stdout.lines().last().unwrap()).unwrap();
            assert_eq!(last["ok"]["segment"]["name"], nasty);
        }
    }
    assert_eq!(burin::script::plain("a\tb\u{1b}"), "a\\tb\\u{1b}");
    assert_eq!(burin::script::plain(&long).chars().count(), 200 + 60 + "…(2740 more)…".chars().count());
}

#[test]
#[cfg(unix)]
fn a_script_that_has_no_end_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (_, stderr, code) = burin(folder.path(), &[&"run", &"/dev/zero"], "");
    assert!(stderr.contains("/dev/zero: cannot open the script: a device found"), "{stderr}");
    assert_eq!(code, Some(2));
}

#[test]
fn every_door_finds_a_source_below_the_home_folder() {
    use super::maker::run;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.nrrd");
    volume(&path);
    let mut document = burin::document::Document::new();
    for line in [
        serde_json::json!({"volume":{"open":{"path":path}}}),
        serde_json::json!({"project":{"save":{"path":folder.path().join("p"),"density":"linked"}}}),
    ] {
        run(&mut document, &line.to_string()).unwrap();
    }
    drop(document);
    std::fs::create_dir(folder.path().join("attic")).unwrap();
    std::fs::rename(&path, folder.path().join("attic/v.nrrd")).unwrap();
    // No shell takes the tilde for the home folder there.
    let source = "--source=~/attic/v.nrrd";
    let render: [&dyn AsRef<OsStr>; 9] =
        [&"render", &"p", &source, &"-o", &"x.png", &"--view", &"axial", &"--size", &"8x8"];
    let run: [&dyn AsRef<OsStr>; 5] = [&"run", &"-", &"--project", &"p", &source];
    for arguments in [&run[..], &render[..]] {
        let (_, stderr, code) = burin(folder.path(), arguments, "");
        assert!(code == Some(0) || stderr.contains("needs a GPU"), "{stderr}");
    }
}

#[test]
fn a_source_that_is_another_is_told_by_every_door() {
    use super::maker::run;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("v.nrrd");
    volume(&path);
    let mut document = burin::document::Document::new();
    for line in [
        serde_json::json!({"volume":{"open":{"path":path}}}),
        serde_json::json!({"segment":{"set":{"id":7,"name":"jaw"}}}),
        serde_json::json!({"project":{"save":{"path":folder.path().join("p"),"density":"linked"}}}),
    ] {
        run(&mut document, &line.to_string()).unwrap();
    }
    drop(document);
    let render: [&dyn AsRef<OsStr>; 8] = [&"render", &"p", &"-o", &"x.png", &"--view", &"axial", &"--size", &"8x8"];
    let run: [&dyn AsRef<OsStr>; 4] = [&"run", &"-", &"--project", &"p"];
    let script = "{\"ask\":{\"volume\":{}}}\n";
    for arguments in [&run[..], &render[..]] {
        let (_, stderr, _) = burin(folder.path(), arguments, script);
        assert!(!stderr.contains("blake3"), "it is the same: {stderr}");
    }
    // Another voxel, the same length and time: only the hash tells.
    let modified = std::fs::metadata(&path).unwrap().modified().unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(&path, bytes).unwrap();
    std::fs::OpenOptions::new().write(true).open(&path).unwrap().set_modified(modified).unwrap();
    for arguments in [&run[..], &render[..]] {
        let (_, stderr, _) = burin(folder.path(), arguments, script);
        if stderr.contains("needs a GPU") {
            continue;
        }
        assert!(stderr.contains("v.nrrd: blake3: "), "{stderr}");
    }
}

#[test]
fn a_script_that_saves_nothing_leaves_the_project_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let project = crashed(folder.path());
    let journal = project.join("journal-000001");
    let before = std::fs::read(&journal).unwrap();
    let script = "{\"segment\":{\"set\":{\"id\":9,\"name\":\"tongue\"}}}\n{\"ask\":{\"scene\":{}}}\n";
    for _ in 0..2 {
        let (stdout, stderr, code) = burin(folder.path(), &[&"run", &"-", &"--project", &"p"], script);
        assert_eq!(code, Some(0), "{stderr}");
        assert!(stdout.contains("tongue") && stdout.contains("tooth"), "{stdout}");
        assert!(std::fs::read(&journal).unwrap() == before, "what the script did is still in the journal");
    }
}

#[test]
fn home_is_meant_in_every_path_of_a_script_unless_something_is_named_so() {
    let folder = tempfile::tempdir().unwrap();
    volume(&folder.path().join("v.nrrd"));
    let script = [
        serde_json::json!({"volume":{"open":{"path":"~/v.nrrd"}}}),
        serde_json::json!({"segment":{"import":{"path":"~/v.nrrd"}}}),
        serde_json::json!({"selection":{"import":{"path":"~/v.nrrd","threshold":3}}}),
        serde_json::json!({"volume":{"export":{"field":"labels","path":"~/out.nrrd"}}}),
        serde_json::json!({"project":{"save":{"path":"~/p","density":"linked"}}}),
    ];
    let script = script.map(|line| line.to_string()).join("\n");
    let elsewhere = tempfile::tempdir().unwrap();
    let mut command = Command::new(crate::common::program());
    command.current_dir(elsewhere.path()).env("HOME", folder.path()).args(["run", "-"]);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(script.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    assert!(folder.path().join("out.nrrd").exists() && folder.path().join("p/project.json").exists());
    assert_eq!(std::fs::read_dir(elsewhere.path()).unwrap().count(), 0);
    // The volume that a project is told to read from, too.
    std::fs::create_dir(folder.path().join("moved")).unwrap();
    std::fs::rename(folder.path().join("v.nrrd"), folder.path().join("moved/w.nrrd")).unwrap();
    let open = serde_json::json!({"project":{"open":{"path":"~/p","source":"~/moved/w.nrrd"}}}).to_string();
    let (stdout, stderr, code) = burin(folder.path(), &[&"run", &"-"], &open);
    assert_eq!(code, Some(0), "{stdout} {stderr}");
    // A folder that is named by the sign of home is that folder.
    std::fs::create_dir(folder.path().join("~")).unwrap();
    let grid = Grid::aligned([3, 3, 3], DVec3::ONE, DVec3::ZERO);
    write_nrrd(&folder.path().join("~/own.nrrd"), &grid, |_| 1.0);
    let (stdout, stderr, code) = burin(folder.path(), &[&"info", &"~/own.nrrd"], "");
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stdout.contains("dims: [3,3,3]"), "{stdout}");
}
