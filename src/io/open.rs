//! Opening a volume file of whatever format.

use crate::io::error::IoError;
use crate::io::foreign;
use crate::io::formats::readers;
use crate::io::head::head;
use crate::io::reader::Opened;
use crate::io::regular::FileMark;
use std::path::Path;

/// Opens a volume file of any known format.
///
/// # Errors
/// If no reader knows the file, or its reader's.
pub fn open(path: impl AsRef<Path>) -> Result<Opened, IoError> {
    let path = path.as_ref();
    if path.is_dir() {
        return Err(foreign::folder(path));
    }
    let head = head(path)?;
    // Before anything is believed: whoever compares later knows the file that was read.
    let named = FileMark::of(path).map_err(IoError::system(path, "open the file"))?;
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let reader = match readers().iter().find(|r| r.recognises(&head)) {
        Some(reader) => Some(reader),
        // A file that is known for something else is that, whatever it is called.
        None => match foreign::file(path, &head, named.bytes) {
            Some(foreign) => return Err(foreign),
            None => readers().iter().find(|r| r.claims(&name)),
        },
    };
    match reader {
        Some(reader) => {
            let mut opened = reader.open(path)?;
            opened.files.retain(|file| !file.is_same_file(&named));
            opened.files.insert(0, named);
            Ok(opened)
        }
        None => Err(IoError::Unknown {
            file: path.display().to_string(),
            found: format!("first bytes \"{}\"", head[..head.len().min(16)].escape_ascii()),
            expected: readers().iter().map(|r| r.name()).collect::<Vec<_>>().join(", "),
        }),
    }
}
