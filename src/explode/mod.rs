//! Exploded views: parts, splitters, forces and the rigid bodies that they move.
//!
//! Exploded Views for Volume Data (2006), with the forms of its forces that keep finite everywhere. Pure: owns the physics
//! engine's types and lets none of them out; knows nothing of the GPU. What hides what is told to it by a callback.

mod convex;
mod error;
mod parts;
mod splitters;
mod state;

pub use error::ExplodeError;
pub use splitters::{axis_plane, depth_plane, line_plane};
pub use state::{Axis, Explosion, Face, Forces, Part, PartId};
