//! A file that is either the old one or the whole new one: written beside it, synced, then renamed over it.

use super::IoError;
use std::fs::File;
use std::io::{BufWriter, Write};
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
        return Err(failed(std::io::Error::new(std::io::ErrorKind::IsADirectory, "there is a folder of that name")));
    }
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
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
    part.as_file().sync_all().map_err(failed)?;
    let bytes = part.as_file().metadata().map_err(failed)?.len();
    part.persist(&target).map_err(|e| failed(e.error))?;
    // The rename itself lasts only once the folder is on disk.
    #[cfg(unix)]
    File::open(folder).and_then(|f| f.sync_all()).map_err(failed)?;
    Ok(bytes)
}
