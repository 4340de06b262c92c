//! Where parts stand, beside the journal, for whoever finds the document after a crash.
//!
//! A cache: what is missing or damaged is found again. So it is written by one rename and never synced, and only where parts come to
//! rest: a moving explosion writes nothing. Owns the file; knows nothing of what moved the parts.

use crate::document::disk::inside;
use crate::document::scene::kept_poses::SavedPoses;
use std::io::Write;
use std::path::{Path, PathBuf};

/// No list of poses is longer.
const MOST_BYTES: u64 = 64 << 20;

/// The file beside a journal, as it is on disk.
#[derive(Debug)]
pub(crate) struct PosesFile {
    path: PathBuf,
    /// What it held when the document was opened.
    found: Option<Vec<u8>>,
}

impl PosesFile {
    /// The file beside a journal, and the poses in it if they can be read.
    pub(crate) fn beside(journal: &Path) -> (Self, Option<SavedPoses>) {
        let path = journal.with_extension("poses");
        let (dir, name) = (path.parent().unwrap_or(Path::new("")), path.file_name().unwrap_or_default());
        let found = inside::read(dir, &name.to_string_lossy(), MOST_BYTES).ok();
        let kept = found.as_deref().and_then(unsealed);
        (Self { path, found }, kept)
    }

    /// Writes poses in the place of what is there.
    pub(crate) fn write(&self, kept: &SavedPoses) -> std::io::Result<()> {
        self.put(&sealed(kept)?)
    }

    fn put(&self, bytes: &[u8]) -> std::io::Result<()> {
        let beside = self.path.with_extension("poses-new");
        let written = inside::create_anew(&beside).and_then(|mut file| file.write_all(bytes));
        let put = written.and_then(|()| std::fs::rename(&beside, &self.path));
        if put.is_err() {
            let _ = std::fs::remove_file(&beside);
        }
        put
    }

    /// Puts back what was there when the document was opened.
    pub(crate) fn leave_as_found(&self) -> std::io::Result<()> {
        match &self.found {
            Some(bytes) => self.put(bytes),
            None => self.remove(),
        }
    }

    /// Removes it, if it is there.
    pub(crate) fn remove(&self) -> std::io::Result<()> {
        match std::fs::remove_file(&self.path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }
}

/// JSON behind a line with its hash.
fn sealed(kept: &SavedPoses) -> std::io::Result<Vec<u8>> {
    let json = serde_json::to_vec(kept)?;
    let mut bytes = format!("{}\n", blake3::hash(&json).to_hex()).into_bytes();
    bytes.extend(json);
    Ok(bytes)
}

fn unsealed(bytes: &[u8]) -> Option<SavedPoses> {
    let end = bytes.iter().position(|&b| b == b'\n')?;
    let (hash, json) = (&bytes[..end], &bytes[end + 1..]);
    if hash != blake3::hash(json).to_hex().as_bytes() {
        return None;
    }
    serde_json::from_slice(json).ok()
}
