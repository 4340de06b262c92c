//! What the tests share: data makers and pictures, no formula under test.

pub mod falloffs;
pub mod gpu;
pub mod one;
pub mod oracle;
pub mod raster;
pub mod volumes;

use std::path::{Path, PathBuf};

/// The folder with assets and fixtures: the repository, or what `BURIN_ROOT` says where the tests were carried elsewhere.
pub fn root() -> PathBuf {
    std::env::var_os("BURIN_ROOT").map_or_else(|| env!("CARGO_MANIFEST_DIR").into(), PathBuf::from)
}

/// The program: the one built beside the tests, or what `BURIN_PROGRAM` says.
pub fn program() -> PathBuf {
    std::env::var_os("BURIN_PROGRAM").map_or_else(|| env!("CARGO_BIN_EXE_burin").into(), PathBuf::from)
}

/// All sources below a folder.
pub fn sources(dir: &Path, into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, into);
        } else if path.extension().is_some_and(|e| e == "rs") {
            into.push(path);
        }
    }
}
