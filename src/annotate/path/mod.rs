//! Lines on surfaces: shortest ways, their ticks and bands along them.

pub(crate) mod cell_route;
pub mod geodesic;
pub mod strip;
pub mod surface_path;
