//! The formats of volume files, a file or folder each: a new one is its own and no line elsewhere, since `build.rs` lists what lies
//! here. Each has a `FORMAT`: who reads it, what fields leave in, and what people know it by.
//!
//! `cargo fmt` does not find what is listed like this; `tools/test` gives it the files.

use crate::io::leaving::Format;
use crate::io::reader::Reader;

/// What a format's file must have, as `FORMAT`.
struct FileFormat {
    /// Reads it.
    reader: &'static dyn Reader,
    /// What fields leave in; a name is of the longest ending that it has.
    writers: &'static [Format],
    /// Formats that keep more of a field come first where a person chooses.
    rank: u8,
}

include!(concat!(env!("OUT_DIR"), "/formats.rs"));

/// All readers, in the order in which they are asked.
pub fn readers() -> &'static [&'static dyn Reader] {
    static READERS: [&dyn Reader; FORMATS.len()] = {
        let mut readers = [FORMATS[0].reader; FORMATS.len()];
        let mut at = 1;
        while at < FORMATS.len() {
            readers[at] = FORMATS[at].reader;
            at += 1;
        }
        readers
    };
    &READERS
}

/// All that fields can leave in, what keeps most of them first.
pub(crate) fn writers() -> impl Iterator<Item = &'static Format> {
    let mut formats = FORMATS;
    formats.sort_by_key(|format| format.rank);
    formats.into_iter().flat_map(|format| format.writers)
}
