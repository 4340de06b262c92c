//! Readers and writers of volumes.
//!
//! Owns the [`Reader`] trait, the formats (`formats`, of meshes `meshes`), `info`, the export, and how a file is replaced. A reader turns a file into a [`Grid`] in
//! RAS+ mm (LPS is turned here and nowhere else) and into `BrickSource`s; voxels keep their file's order, the affine carries
//! the orientation. Files are hostile: what is allocated is bounded by what the file can hold, and an error names the field.
//! Knows no GPU and no document.
//!
//! [`Grid`]: crate::volume::Grid

pub(crate) mod codec;
mod colour;
pub(crate) mod disk;
mod error;
mod export;
mod export_mesh;
mod foreign;
mod formats;
mod head;
mod info;
mod layout;
mod layout_read;
mod leaving;
mod meshes;
mod open;
mod place;
mod progress;
mod raw;
mod reader;
pub(crate) mod regular;
mod replace;
mod statistics;
mod stream;
mod system_fonts;
mod words;

pub use disk::{Told, Witness};
pub use error::IoError;
pub(crate) use export::about_format;
pub use export::{Exported, export, export_endings};
pub(crate) use export_mesh::about_mesh_format;
pub use export_mesh::{ExportedMesh, export_mesh, is_mesh, mesh_endings};
pub use foreign::what_is;
pub use formats::readers;
pub use info::{Info, info};
pub use leaving::Compression;
pub use open::open;
pub use progress::Progress;
pub use reader::{Contents, NamedLabel, Opened, Reader};
pub use regular::{FileMark, open_regular, read_regular};
pub use replace::replace_file;
pub use statistics::statistics;
pub use system_fonts::{SystemFont, font_folders, fonts_for};
pub use words::{in_words, without_numbers};
