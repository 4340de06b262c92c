//! A file that is either the old one or the whole new one: written beside it, synced, then renamed over it. What is write-protected
//! stays, and rights are kept.

use crate::io::disk;
use crate::io::error::IoError;
use crate::io::regular::{must_be_regular, without_waiting};
use std::fs::{File, Metadata, OpenOptions};
use std::io::{BufWriter, Error, ErrorKind, Write};
use std::path::Path;

/// Writes a file anew: whoever looks, and whatever fails, finds the old file or the whole new one.
///
/// # Errors
/// If the system refuses.
pub fn replace_file(path: &Path, bytes: &[u8]) -> Result<(), IoError> {
    replace(path, |out| out.write_all(bytes).map_err(IoError::system(path, "write the file"))).map(|_| ())
}

/// Writes `path` anew by what `write` puts out. If anything fails (a full disk, a source, a cancel) the old file is as it was
/// and nothing is left beside it. Answers the new file's bytes.
pub(super) fn replace(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> Result<(), IoError>,
) -> Result<u64, IoError> {
    let failed = |e| IoError::system(path, "write the file")(e);
    // A link stays a link: what it points to is written.
    let target = if path.is_symlink() { std::fs::canonicalize(path).map_err(failed)? } else { path.to_path_buf() };
    if target.is_dir() {
        return Err(failed(Error::new(ErrorKind::IsADirectory, "there is a folder of that name")));
    }
    let old = match std::fs::metadata(&target) {
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        old => Some(old.map_err(failed)?),
    };
    if let Some(old) = &old {
        must_be_regular(old).map_err(failed)?;
        may_be_written(old, "file").map_err(failed)?;
        // Whoever may not write into it may not replace it either, though the folder would let them.
        without_waiting(OpenOptions::new().write(true)).open(&target).map_err(failed)?;
    }
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    may_be_written(&std::fs::metadata(folder).map_err(failed)?, "folder").map_err(failed)?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".burin-").suffix(".part");
    // As any new file would have it, not private as temporary files are.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let part = builder.tempfile_in(folder).map_err(failed)?;
    let mut out = BufWriter::with_capacity(1 << 18, part.as_file());
    write(&mut out)?;
    out.flush().map_err(failed)?;
    drop(out);
    if let Some(old) = old {
        keep_rights(part.as_file(), &old).map_err(failed)?;
    }
    disk::sync(part.as_file(), part.path()).map_err(failed)?;
    let bytes = part.as_file().metadata().map_err(failed)?.len();
    part.persist(&target).map_err(|e| failed(e.error))?;
    disk::renamed(&target);
    // The rename itself lasts only once the folder is on disk.
    disk::sync_dir(folder).map_err(failed)?;
    Ok(bytes)
}

/// Fails if nobody may write there, whoever asks: a superuser would be let.
fn may_be_written(about: &Metadata, what: &str) -> std::io::Result<()> {
    match about.permissions().readonly() {
        true => Err(Error::new(ErrorKind::PermissionDenied, format!("the {what} is write-protected"))),
        false => Ok(()),
    }
}

/// Gives a new file the rights, and if it can be the owner, of the one that it replaces.
fn keep_rights(file: &File, old: &Metadata) -> std::io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        // Only a superuser can give files away; the rights come after, since that takes some of them.
        let _ = std::os::unix::fs::fchown(file, Some(old.uid()), Some(old.gid()));
    }
    file.set_permissions(old.permissions())
}
