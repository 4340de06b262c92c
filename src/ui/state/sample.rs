//! The sample: a head and its brain, which come with the program and are laid into a folder of its own when they are asked for.
//!
//! They lie there as files like any other, so that a project may link them and scripts may open them. `assets/NOTICE.md`, which
//! says whose they are, lies beside them.

use crate::io::{in_words, replace_file};
use crate::ui::state::recent::private_folder;
use std::path::{Path, PathBuf};

const HEAD: &[u8] = include_bytes!("../../../assets/ch2.nii.gz");
const BRAIN: &[u8] = include_bytes!("../../../assets/ch2bet.nii.gz");
const NOTICE: &[u8] = include_bytes!("../../../assets/NOTICE.md");
/// The head's name; a document of this name in the sample's folder is the sample.
const HEAD_NAME: &str = "ch2.nii.gz";
const BRAIN_NAME: &str = "ch2bet.nii.gz";

/// Where the sample lies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sample {
    /// A whole head, MRI.
    pub head: PathBuf,
    /// Its brain alone.
    pub brain: PathBuf,
}

impl Sample {
    /// The sample as it lies below a folder of the program's own, whether it is there yet or not.
    pub fn below(folder: &Path) -> Self {
        let folder = folder.join("sample");
        Self { head: folder.join(HEAD_NAME), brain: folder.join(BRAIN_NAME) }
    }

    /// Lays it there, if it is not there whole.
    ///
    /// # Errors
    /// A sentence, if the disk refuses.
    pub fn lay(&self) -> Result<(), String> {
        let folder = self.head.parent().unwrap_or(Path::new("."));
        private_folder(folder)
            .map_err(|error| format!("The sample needs the folder {}: {}.", folder.display(), in_words(&error)))?;
        let files = [(&self.head, HEAD), (&self.brain, BRAIN), (&folder.join("NOTICE.md"), NOTICE)];
        for (path, bytes) in files {
            if std::fs::read(path).is_ok_and(|there| there == bytes) {
                continue;
            }
            replace_file(path, bytes).map_err(|error| format!("The sample could not be unpacked: {error}."))?;
        }
        Ok(())
    }
}
