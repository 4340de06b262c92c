//! Nothing is written over a file that the document reads, into a project's own folder, or over what is protected.

use super::maker::{run, write_nrrd};
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::Grid;
use serde_json::{Value, json};
use std::path::Path;

fn opened(dir: &Path) -> Document {
    let grid = Grid::aligned([12, 10, 8], DVec3::ONE, DVec3::ZERO);
    write_nrrd(&dir.join("whole.nrrd"), &grid, |v| v[0] as f32);
    let whole = std::fs::read(dir.join("whole.nrrd")).unwrap();
    let end = whole.windows(2).position(|w| w == b"\n\n").unwrap() + 1;
    let header = [&whole[..end], b"data file: v.nrrd.raw.nrrd\n\n"].concat();
    std::fs::write(dir.join("v.nhdr"), header).unwrap();
    std::fs::write(dir.join("v.nrrd.raw.nrrd"), &whole[end + 1..]).unwrap();
    let mut document = Document::new();
    run(&mut document, &json!({"volume":{"open":{"path":dir.join("v.nhdr")}}}).to_string()).unwrap();
    document
}

fn export(document: &mut Document, path: &Path) -> Result<Value, String> {
    let line = json!({"volume":{"export":{"field":"density","path":path}}}).to_string();
    run(document, &line).map_err(|e| e.to_string())
}

fn picture(document: &mut Document, path: &Path) -> String {
    let line = json!({"render":{"image":{"path":path,"view":"axial"}}}).to_string();
    run(document, &line).unwrap_err().to_string()
}

#[test]
fn a_file_that_the_volume_is_read_from_is_not_written_over() {
    let dir = tempfile::tempdir().unwrap();
    let mut document = opened(dir.path());
    let data = dir.path().join("v.nrrd.raw.nrrd");
    let before = std::fs::read(&data).unwrap();
    let mut names = vec![data.clone(), dir.path().join("./v.nrrd.raw.nrrd")];
    #[cfg(unix)]
    {
        std::fs::hard_link(&data, dir.path().join("hard.nrrd")).unwrap();
        std::os::unix::fs::symlink(&data, dir.path().join("soft.nrrd")).unwrap();
        std::os::unix::fs::symlink(dir.path(), dir.path().join("way")).unwrap();
        names.extend(["hard.nrrd", "soft.nrrd", "way/v.nrrd.raw.nrrd"].map(|name| dir.path().join(name)));
    }
    for path in &names {
        let refused = export(&mut document, path).unwrap_err();
        assert!(refused.contains("which the volume is read from"), "{}: {refused}", path.display());
        let refused = picture(&mut document, path);
        assert!(refused.contains("which the volume is read from"), "{}: {refused}", path.display());
    }
    let refused = picture(&mut document, &dir.path().join("v.nhdr"));
    assert!(refused.contains("v.nhdr, which the volume is read from"), "{refused}");
    assert!(std::fs::read(&data).unwrap() == before);
    export(&mut document, &dir.path().join("other.nrrd")).unwrap();
    assert!(std::fs::read(&data).unwrap() == before);
}

#[test]
fn nothing_is_written_into_what_a_project_keeps() {
    let dir = tempfile::tempdir().unwrap();
    let mut document = opened(dir.path());
    let project = dir.path().join("p");
    run(&mut document, &json!({"project":{"save":{"path":project}}}).to_string()).unwrap();
    let kept = |document: &mut Document| run(document, r#"{"project":{"save":{}}}"#).unwrap();
    for name in
        ["generation-000001/x.nrrd", "generation-000001/volumes/0/density/0/c/0/0/x.nrrd", "journal-000009.nrrd"]
    {
        let refused = export(&mut document, &project.join(name)).unwrap_err();
        assert!(refused.contains("a place that the project") && refused.contains(name), "{refused}");
    }
    for name in ["project.json", "lock", "journal-000001", "generation-000001/generation.json"] {
        let refused = picture(&mut document, &project.join(name));
        assert!(refused.contains("a place that the project"), "{refused}");
    }
    // The second by a way that nothing is there to resolve yet.
    for name in ["generation-000001/copy", "generation-000001/new/../copy"] {
        let inside = json!({"project":{"save":{"path":project.join(name)}}}).to_string();
        let refused = run(&mut document, &inside).unwrap_err().to_string();
        assert!(refused.contains("a place that the project"), "{refused}");
    }
    kept(&mut document);
    // Of another project neither.
    let mut other = opened(dir.path());
    let refused = export(&mut other, &project.join("generation-000001/x.nrrd")).unwrap_err();
    assert!(refused.contains("a place that the project"), "{refused}");
    drop(document);
    run(&mut Document::new(), &json!({"project":{"open":{"path":project}}}).to_string()).unwrap();
}

#[test]
#[cfg(unix)]
fn what_is_write_protected_stays_and_rights_are_kept() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempfile::tempdir().unwrap();
    let mut document = opened(dir.path());
    let mode = |path: &Path| path.metadata().unwrap().permissions().mode() & 0o7777;
    let set = |path: &Path, mode: u32| std::fs::set_permissions(path, PermissionsExt::from_mode(mode)).unwrap();
    let target = dir.path().join("out.nrrd");
    std::fs::write(&target, b"old").unwrap();
    for protected in [0o444, 0o400, 0o555] {
        set(&target, protected);
        let refused = export(&mut document, &target).unwrap_err();
        assert!(refused.contains("out.nrrd") && refused.contains("the file is write-protected"), "{refused}");
        assert_eq!((std::fs::read(&target).unwrap(), mode(&target)), (b"old".to_vec(), protected));
    }
    for kept in [0o600, 0o664, 0o755] {
        set(&target, kept);
        export(&mut document, &target).unwrap();
        assert_eq!(mode(&target), kept);
    }
    let folder = dir.path().join("folder");
    std::fs::create_dir(&folder).unwrap();
    set(&folder, 0o555);
    let refused = export(&mut document, &folder.join("out.nrrd")).unwrap_err();
    assert!(refused.contains("the folder is write-protected"), "{refused}");
    let refused = run(&mut document, &json!({"project":{"save":{"path":folder}}}).to_string()).unwrap_err().to_string();
    assert!(refused.contains("write-protected") && std::fs::read_dir(&folder).unwrap().count() == 0, "{refused}");
    set(&folder, 0o755);
    // A pipe or a device is no file to put another in the place of.
    for path in [dir.path().join("pipe.nrrd"), dir.path().join("null.nrrd")] {
        if path.ends_with("pipe.nrrd") {
            assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        } else {
            std::os::unix::fs::symlink("/dev/null", &path).unwrap();
        }
        let refused = export(&mut document, &path).unwrap_err();
        assert!(refused.contains("found, a regular file expected"), "{refused}");
    }
    // A project whose first file is protected is not saved over, and one that is saved keeps its rights.
    let project = dir.path().join("p");
    run(&mut document, &json!({"project":{"save":{"path":project}}}).to_string()).unwrap();
    let first = project.join("project.json");
    set(&first, 0o444);
    let refused = run(&mut document, r#"{"project":{"save":{}}}"#).unwrap_err().to_string();
    assert!(refused.contains("project.json") && refused.contains("write-protected"), "{refused}");
    assert!(!project.join("generation-000002").exists());
    set(&first, 0o640);
    run(&mut document, r#"{"project":{"save":{}}}"#).unwrap();
    assert_eq!(mode(&first), 0o640);
}

#[test]
#[cfg(unix)]
fn a_project_on_a_full_disk_opens_to_look_and_stays_as_it_is() {
    let dir = tempfile::tempdir().unwrap();
    let mut document = opened(dir.path());
    run(&mut document, &json!({"project":{"save":{"path":dir.path().join("p")}}}).to_string()).unwrap();
    document.leave_as_found().unwrap();
    assert!(!dir.path().join("p/journal-000001").exists());
    // No file may have a byte: a full disk; SIGXFSZ ignored, so that write answers with an error.
    let run = || {
        std::process::Command::new("sh")
            .args(["-c", "trap '' XFSZ; ulimit -f 0; exec \"$0\" run - --project p"])
            .arg(crate::common::program())
            .current_dir(dir.path())
            .stdin(std::process::Stdio::null())
            .output()
            .unwrap()
    };
    for _ in 0..2 {
        let output = run();
        let told = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success() && told.contains("open to look at: cannot write p/journal-000001"), "{told}");
        assert!(!told.contains("lost"), "{told}");
        assert!(!dir.path().join("p/journal-000001").exists());
    }
    // An older version left an empty one.
    std::fs::write(dir.path().join("p/journal-000001"), b"").unwrap();
    let mut again = Document::new();
    let path = dir.path().join("p");
    let answer = super::maker::run(&mut again, &json!({"project":{"open":{"path":path}}}).to_string()).unwrap();
    assert_eq!(answer["warnings"], json!([]));
}

#[test]
#[cfg(unix)]
fn a_project_where_nothing_can_be_written_opens_to_look_and_saves_elsewhere() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempfile::tempdir().unwrap();
    let mut document = opened(dir.path());
    let project = dir.path().join("p");
    run(&mut document, &json!({"project":{"save":{"path":project}}}).to_string()).unwrap();
    run(&mut document, r#"{"segment":{"set":{"id":7,"name":"jaw"}}}"#).unwrap();
    drop(document);
    std::fs::remove_file(project.join("lock")).unwrap();
    std::fs::set_permissions(&project, PermissionsExt::from_mode(0o555)).unwrap();
    let mut document = Document::new();
    let answer = run(&mut document, &json!({"project":{"open":{"path":project}}}).to_string()).unwrap();
    let told = answer["warnings"].to_string();
    assert!(told.contains("open to look at") && told.contains("write-protected"), "{told}");
    // What a crash left is there, and nothing was made.
    assert_eq!(answer["recovered"]["steps"], 1);
    assert!(!project.join("lock").exists());
    run(&mut document, r#"{"segment":{"set":{"id":8,"name":"tooth"}}}"#).unwrap();
    run(&mut document, r#"{"project":{"save":{}}}"#).unwrap_err();
    run(&mut document, &json!({"project":{"save":{"path":dir.path().join("q")}}}).to_string()).unwrap();
    drop(document);
    std::fs::set_permissions(&project, PermissionsExt::from_mode(0o755)).unwrap();
    let mut again = Document::new();
    run(&mut again, &json!({"project":{"open":{"path":dir.path().join("q")}}}).to_string()).unwrap();
    assert_eq!(again.state().unwrap().scene.segments().get(8).unwrap().name, "tooth");
}
