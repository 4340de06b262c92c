//! Files that somebody names: only regular ones are opened, without waiting, and what a file was is known afterwards.
//!
//! A pipe or a device may have no end and no beginning: to open or to read it would hold the program for good. Whoever reads a file
//! by a path from outside opens it here. Knows no format.

use std::fs::{File, Metadata, OpenOptions};
use std::io::{Error, ErrorKind, Read, Result};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// Opens a regular file for reading; symbolic links on the way to it are followed.
///
/// # Errors
/// If it is something else, which the message names, or the system refuses.
pub fn open_regular(path: &Path) -> Result<File> {
    // Asked before opening: already to open a device may do something.
    must_be_regular(&std::fs::metadata(path)?)?;
    let file = without_waiting(OpenOptions::new().read(true)).open(path)?;
    must_be_regular(&file.metadata()?)?;
    Ok(file)
}

/// All of a regular file that is meant to be small.
///
/// # Errors
/// As [`open_regular`]; if it has more than `most` bytes.
pub fn read_regular(path: &Path, most: u64) -> Result<Vec<u8>> {
    read_up_to(open_regular(path)?, most)
}

/// All of an open file, but never more than `most` bytes of it.
pub(crate) fn read_up_to(file: File, most: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(Error::new(ErrorKind::FileTooLarge, format!("over {most} bytes found, at most {most} expected")));
    }
    Ok(bytes)
}

/// So that what turns out to be a pipe does not wait for its writer.
pub(crate) fn without_waiting(options: &mut OpenOptions) -> &mut OpenOptions {
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(
        options,
        (rustix::fs::OFlags::NONBLOCK | rustix::fs::OFlags::NOCTTY).bits() as i32,
    );
    options
}

/// Fails with the kind of what is no regular file.
pub(crate) fn must_be_regular(about: &Metadata) -> Result<()> {
    match about.is_file() {
        true => Ok(()),
        false => Err(Error::new(ErrorKind::InvalidInput, format!("{} found, a regular file expected", kind(about)))),
    }
}

/// What something is, in words.
pub(crate) fn kind(about: &Metadata) -> &'static str {
    let kind = about.file_type();
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return "a pipe";
        }
        if kind.is_socket() {
            return "a socket";
        }
    }
    match () {
        () if kind.is_dir() => "a folder",
        () if kind.is_symlink() => "a symbolic link",
        () if kind.is_file() => "a file",
        () => "a device",
    }
}

/// A file as it was at some moment: two marks are equal if nothing that the system keeps of it has changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileMark {
    /// As it was named.
    pub path: PathBuf,
    /// The disk that it is on and its number there; 0 where the system has none.
    pub place: (u64, u64),
    /// Length.
    pub bytes: u64,
    /// When it was last written, nanoseconds since 1970; `None` if the system does not say.
    pub modified_ns: Option<u64>,
    /// When anything of it changed, its name and rights included; nobody can set it.
    pub changed_ns: Option<u64>,
}

impl FileMark {
    /// The regular file that a path leads to, as it is now.
    ///
    /// # Errors
    /// If there is none, or the system refuses.
    pub fn of(path: &Path) -> Result<Self> {
        let about = std::fs::metadata(path)?;
        must_be_regular(&about)?;
        Ok(Self::new(path, &about))
    }

    /// An open file as it is now.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn of_open(path: &Path, file: &File) -> Result<Self> {
        Ok(Self::new(path, &file.metadata()?))
    }

    fn new(path: &Path, about: &Metadata) -> Self {
        let since_1970 = |time: SystemTime| time.duration_since(UNIX_EPOCH).ok().map(|t| t.as_nanos() as u64);
        Self {
            path: path.to_owned(),
            place: place(about),
            bytes: about.len(),
            modified_ns: about.modified().ok().and_then(since_1970),
            changed_ns: changed_ns(about),
        }
    }

    /// Whether this is the file of another name.
    pub fn is_same_file(&self, other: &Self) -> bool {
        if self.place == (0, 0) { self.path == other.path } else { self.place == other.place }
    }
}

#[cfg(unix)]
fn place(about: &Metadata) -> (u64, u64) {
    use std::os::unix::fs::MetadataExt;
    (about.dev(), about.ino())
}

#[cfg(not(unix))]
fn place(_about: &Metadata) -> (u64, u64) {
    (0, 0)
}

#[cfg(unix)]
fn changed_ns(about: &Metadata) -> Option<u64> {
    use std::os::unix::fs::MetadataExt;
    u64::try_from(i128::from(about.ctime()) * 1_000_000_000 + i128::from(about.ctime_nsec())).ok()
}

#[cfg(not(unix))]
fn changed_ns(_about: &Metadata) -> Option<u64> {
    None
}

/// Reads all of `bytes` from byte `at` on, wherever the file stands.
#[cfg(unix)]
pub(crate) fn read_exact_at(file: &File, bytes: &mut [u8], at: u64) -> Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, bytes, at)
}

#[cfg(windows)]
pub(crate) fn read_exact_at(file: &File, mut bytes: &mut [u8], mut at: u64) -> Result<()> {
    while !bytes.is_empty() {
        match std::os::windows::fs::FileExt::seek_read(file, bytes, at) {
            Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
            Ok(n) => {
                bytes = &mut bytes[n..];
                at += n as u64;
            }
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(())
}
