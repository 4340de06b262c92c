//! The list of readers: a new format is one line here.

use crate::io::nifti::Nifti;
use crate::io::nrrd::Nrrd;
use crate::io::reader::Reader;

/// All readers, in the order in which they are asked.
pub fn readers() -> &'static [&'static dyn Reader] {
    &[&Nifti, &Nrrd]
}
