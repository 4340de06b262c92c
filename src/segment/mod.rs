//! Which voxels belong together, as arithmetic: sets of voxels by the brick, and their connected components.
//!
//! Owns [`Components`], the one place where connectedness is decided, whoever asks (isolating, brushes that keep to what is connected,
//! islands of segments), and [`Joined`], which carries it over the faces of boxes of finer voxels. A set is a mask for every brick of
//! 32³; bricks that are all in or all out cost no loop over voxels. Knows grids of bricks and boxes of them, neither what made a voxel one
//! of the set nor documents or the GPU.

mod components;
mod joined;
mod mask;
mod runs;

pub use components::{ComponentId, Components};
pub use joined::{Joined, Lattice};
pub use mask::{BrickMask, ROWS, RowBits};
pub use runs::Connectivity;
