//! What every format gives: a trait for its reader, and what an opened file offers.

use crate::io::error::IoError;
use crate::io::progress::Progress;
use crate::io::regular::FileMark;
use crate::volume::{BrickSource, Grid, Statistics, VoxelType};
use std::path::Path;
use std::sync::Arc;

/// Segments that are named in a message.
const MOST_NAMES: usize = 10;

/// A format.
pub trait Reader: Sync {
    /// The format's name and its usual extensions, for messages.
    fn name(&self) -> &'static str;
    /// What people know it by, with its usual extensions, for lists of what can be opened.
    fn title(&self) -> &'static str;
    /// How the names of its files end that a person opens, lower case with the dot.
    fn endings(&self) -> &'static [&'static str];
    /// Whether the first bytes (inflated if the file is gzip) are this format's.
    fn recognises(&self, head: &[u8]) -> bool;
    /// Whether a file of this name would be of this format; asked when no reader recognises the bytes, so that the error
    /// comes from the reader that the user meant.
    fn claims(&self, file_name: &str) -> bool;
    /// Reads the header; voxels are read by [`Opened::source`].
    ///
    /// # Errors
    /// Of every kind but `NoSuch` and `Cancelled`; they name the field.
    fn open(&self, path: &Path) -> Result<Opened, IoError>;
}

/// The voxels of an opened file.
pub trait Contents: Send + Sync + std::fmt::Debug {
    /// One component of one frame, both inside their counts.
    ///
    /// # Errors
    /// If the voxels cannot be read, or `progress` said no.
    fn source(&self, component: u32, frame: u32, progress: Progress<'_>) -> Result<Arc<dyn BrickSource>, IoError>;
    /// Over all components of all frames, without holding them in memory.
    ///
    /// # Errors
    /// As `source`.
    fn statistics(&self, progress: Progress<'_>) -> Result<Statistics, IoError>;
}

/// A segment as a header names it.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct NamedLabel {
    /// Its voxels have this value.
    pub value: i128,
    /// Name, if there is one.
    pub name: Option<String>,
    /// Display-referred red, green, blue, 0..1, if they are said.
    pub colour: Option<[f32; 3]>,
    /// In which of the file's components its voxels are.
    pub component: u32,
}

/// A file whose header was read and believed.
#[derive(Debug)]
pub struct Opened {
    /// The format's name, with its version or encoding.
    pub format: String,
    /// Dimensions and place, RAS+ mm.
    pub grid: Grid,
    /// Type of the voxels as stored.
    pub voxel_type: VoxelType,
    /// `value = slope · stored + intercept`.
    pub scaling: (f64, f64),
    /// Numbers per voxel, at least 1.
    pub components: u32,
    /// Volumes in the file (time points), at least 1.
    pub frames: u32,
    /// Whether the components are red, green and blue, and perhaps alpha, of eight bits each.
    pub colour: bool,
    /// What was odd about the file and how it was taken.
    pub warnings: Vec<String>,
    /// Every file that its header or its voxels are in, as it was when it was opened; the one that was named comes first.
    pub files: Vec<FileMark>,
    /// Segments that the header names, of all components.
    pub labels: Vec<NamedLabel>,
    pub(super) file: String,
    pub(super) contents: Box<dyn Contents>,
}

impl Opened {
    /// The component that shows the file as it is meant: the first, or of colours their brightness.
    pub fn usual_component(&self) -> u32 {
        if self.colour { self.components } else { 0 }
    }

    /// Red, green and blue of a frame, and alpha where it says anything; `None` if the voxels are no colours.
    ///
    /// # Errors
    /// As [`source`](Self::source).
    pub fn colours(&self, frame: u32, progress: Progress<'_>) -> Result<Option<Vec<Arc<dyn BrickSource>>>, IoError> {
        if !self.colour {
            return Ok(None);
        }
        let sources = (0..self.components).map(|c| self.source(c, frame, progress)).collect::<Result<_, _>>()?;
        crate::io::colour::parts(sources, progress).map(Some)
    }

    /// One component of one frame, both counted from 0. Of colours there is one more, their brightness. Uncompressed voxels stay in the file and are read box by box;
    /// compressed ones are inflated into memory.
    ///
    /// # Errors
    /// `NoSuch`, or what the file's voxels give rise to.
    pub fn source(&self, component: u32, frame: u32, progress: Progress<'_>) -> Result<Arc<dyn BrickSource>, IoError> {
        if self.colour && component == self.components && frame < self.frames {
            let parts = self.colours(frame, progress)?.unwrap_or_default();
            return Ok(Arc::new(crate::io::colour::Luminance { parts }));
        }
        for (what, count, asked) in [("components", self.components, component), ("frames", self.frames, frame)] {
            if asked >= count {
                return Err(IoError::NoSuch { file: self.file.clone(), what, count, asked });
            }
        }
        self.contents.source(component, frame, progress)
    }

    /// The segments that the header names for one component.
    pub fn labels_of(&self, component: u32) -> Vec<NamedLabel> {
        self.labels.iter().filter(|l| l.component == component).cloned().collect()
    }

    /// What is left out where one component is taken for labels, in words; `None` if nothing is.
    pub fn left_out(&self, component: u32) -> Option<String> {
        if self.components < 2 {
            return None;
        }
        let others: Vec<String> = self
            .labels
            .iter()
            .filter(|l| l.component != component)
            .map(|l| l.name.clone().unwrap_or_else(|| format!("Segment {}", l.value)))
            .collect();
        let named = match &others[..] {
            [] => String::new(),
            few if few.len() <= MOST_NAMES => format!(": {} left out", few.join(", ")),
            many => format!(": {} and {} more left out", many[..MOST_NAMES].join(", "), many.len() - MOST_NAMES),
        };
        let taken = if component == 0 { "the first".into() } else { format!("number {component}, counted from 0,") };
        Some(format!("labels lie in {} layers, which may overlap; {taken} is taken{named}", self.components))
    }

    /// Over all components of all frames.
    ///
    /// # Errors
    /// What the file's voxels give rise to.
    pub fn statistics(&self, progress: Progress<'_>) -> Result<Statistics, IoError> {
        self.contents.statistics(progress)
    }
}
