//! Exploded views: parts, splitters, forces and the rigid bodies that they move.
//!
//! Exploded Views for Volume Data (2006), with the forms of its forces that keep finite everywhere. Pure: owns the physics
//! engine's types and lets none of them out; knows nothing of the GPU. What hides what is told to it by a callback.

mod bodies;
mod convex;
mod error;
pub mod forces;
mod gain;
mod octree;
mod parts;
mod poses;
mod simulation;
mod solid;
mod splitters;
mod state;

pub use error::ExplodeError;
pub use gain::{MAX_ROUNDS, MAX_STEPS, Measured, Search, SearchStep, Settled, settle_with_gain};
pub use octree::{ExplosionPoint, LEAF, MAX_POINTS, Octrees, explosion_points, points_of};
pub use poses::{PartPose, Poses};
pub use simulation::{Simulation, Wrench};
pub use solid::{Nearest, PartShape};
pub use splitters::{axis_plane, depth_plane, line_plane};
pub use state::{Axis, Cut, Explosion, Face, Forces, Part, PartId, PartRecord};
