//! The first bytes of a file: what readers know their format by.

use crate::io::codec::inflate;
use crate::io::error::IoError;
use std::io::Read;
use std::path::Path;

/// Bytes of a file's beginning, inflated if it is gzip, that readers may look at.
pub(crate) const HEAD_BYTES: u64 = 544;

/// The first bytes of a file, inflated if it is gzip; fewer if the file is shorter or damaged.
pub(crate) fn head(path: &Path) -> Result<Vec<u8>, IoError> {
    let file = inflate::open_file(path)?;
    let mut start = Vec::new();
    (&file).take(2).read_to_end(&mut start).map_err(IoError::system(path, "read the file"))?;
    let mut head = Vec::new();
    if start == inflate::GZIP_MAGIC {
        // A damaged stream gives what comes before the damage; the reader that is chosen says what is wrong.
        let _ = inflate::Inflate::open(path, 0)?.take(HEAD_BYTES).read_to_end(&mut head);
    } else {
        head = start;
        (&file).take(HEAD_BYTES - 2).read_to_end(&mut head).map_err(IoError::system(path, "read the file"))?;
    }
    Ok(head)
}
