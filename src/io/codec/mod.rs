//! Bytes as files pack them, and back: gzip, zlib, bzip2, hexadecimal and decimal text.
//!
//! Knows neither headers nor voxels' meaning.

pub(crate) mod decode;
pub(crate) mod deflate;
pub(crate) mod inflate;
