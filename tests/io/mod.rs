//! Readers and writers.

mod axes;
mod export;
mod export_nifti;
pub mod files;
mod foreign;
mod hostile;
mod meshes;
mod nifti;
mod nrrd;
mod nrrd_data;
mod places;
mod regular;
mod segments;
mod statistics;
mod types;
mod words;
