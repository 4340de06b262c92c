//! The formats of volume files, a folder each: a new one is a folder, and its lines here.

pub(crate) mod nifti;
pub(crate) mod nrrd;

use crate::io::formats::nifti::Nifti;
use crate::io::formats::nrrd::Nrrd;
use crate::io::leaving::Format;
use crate::io::reader::Reader;

/// All readers, in the order in which they are asked.
pub fn readers() -> &'static [&'static dyn Reader] {
    &[&Nifti, &Nrrd]
}

/// All that fields can leave in, in the order in which names are compared.
pub(crate) fn writers() -> impl Iterator<Item = &'static Format> {
    [&nrrd::write::FORMATS[..], &nifti::write::FORMATS[..]].into_iter().flatten()
}
