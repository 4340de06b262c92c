//! What is no regular file is refused at once, by name; and every file behind a volume is known.

use burin::io;
use burin::io::FileMark;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The message of a reading that must not wait.
fn refused<T: std::fmt::Debug>(read: impl FnOnce() -> Result<T, io::IoError>) -> String {
    let start = Instant::now();
    let message = read().unwrap_err().to_string();
    assert!(start.elapsed() < Duration::from_secs(2), "{message}");
    message
}

#[cfg(unix)]
fn pipe(path: &Path) -> PathBuf {
    let made = std::process::Command::new("mkfifo").arg(path).status();
    assert!(made.is_ok_and(|s| s.success()), "mkfifo of coreutils makes a pipe");
    path.to_owned()
}

#[test]
#[cfg(unix)]
fn a_pipe_a_device_a_socket_and_a_folder_are_refused_at_once_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let socket = folder.path().join("socket.nrrd");
    let _listening = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    let linked = folder.path().join("linked.nii");
    std::os::unix::fs::symlink("/dev/zero", &linked).unwrap();
    for (path, kind) in [
        (pipe(&folder.path().join("pipe.nii.gz")), "a pipe"),
        (socket, "a socket"),
        (PathBuf::from("/dev/zero"), "a device"),
        (linked, "a device"),
        (folder.path().to_owned(), "a folder"),
    ] {
        for message in [refused(|| io::open(&path)), refused(|| io::info(&path, &|_| true))] {
            assert!(message.contains(&*path.to_string_lossy()) && message.contains(kind), "{message}");
        }
        let error = io::open_regular(&path).unwrap_err().to_string();
        assert_eq!(error, format!("{kind} found, a regular file expected"));
    }
}

#[test]
#[cfg(unix)]
fn a_header_that_names_a_pipe_for_its_voxels_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    pipe(&folder.path().join("v.raw"));
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: v.raw\n\n";
    std::fs::write(folder.path().join("v.nhdr"), header).unwrap();
    let message = refused(|| io::open(folder.path().join("v.nhdr")));
    assert!(message.contains("v.raw"), "{message}");
}

#[test]
fn no_more_of_a_small_file_is_read_than_it_may_have() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("small");
    std::fs::write(&path, [7; 10]).unwrap();
    assert_eq!(io::read_regular(&path, 10).unwrap(), [7; 10]);
    // A file with a hole has any length and takes no room.
    std::fs::File::create(&path).unwrap().set_len(1 << 40).unwrap();
    let message = io::read_regular(&path, 1 << 10).unwrap_err().to_string();
    assert_eq!(message, "over 1024 bytes found, at most 1024 expected");
}

#[test]
fn every_file_of_a_volume_is_known_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: v.raw\n\n";
    let (named, data) = (folder.path().join("v.nhdr"), folder.path().join("v.raw"));
    std::fs::write(&named, header).unwrap();
    std::fs::write(&data, [1; 8]).unwrap();
    let files = io::open(&named).unwrap().files;
    assert_eq!(files, [FileMark::of(&named).unwrap(), FileMark::of(&data).unwrap()]);
    // Same length, same time: what the system notes by itself tells.
    let time = std::fs::metadata(&data).unwrap().modified().unwrap();
    std::thread::sleep(Duration::from_millis(20));
    std::fs::write(&data, [2; 8]).unwrap();
    std::fs::File::options().write(true).open(&data).unwrap().set_modified(time).unwrap();
    let now = FileMark::of(&data).unwrap();
    assert_eq!((now.bytes, now.modified_ns), (8, files[1].modified_ns));
    assert!(now != files[1] || cfg!(not(unix)));
    let attached = folder.path().join("v.nrrd");
    std::fs::write(&attached, [header.replace("data file: v.raw\n", "").as_bytes(), &[1; 8]].concat()).unwrap();
    assert_eq!(io::open(&attached).unwrap().files, [FileMark::of(&attached).unwrap()]);
}
