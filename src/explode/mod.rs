//! Exploded views: parts, splitters, forces and the rigid bodies that they move.
//!
//! Exploded Views for Volume Data (2006), with the forms of its forces that keep finite everywhere. Pure: owns the physics
//! engine's types and lets none of them out; knows nothing of the GPU. What hides what is told to it by a callback.

mod state;

pub use state::{Axis, Explosion, Face, Forces, Part, PartId};
