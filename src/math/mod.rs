//! Geometry shared by every floor: rays, boxes, planes, poses and cameras.
//!
//! World is RAS+ millimetres, right-handed. A transform is named `to_from`. All of it is `f64`; only the GPU floor
//! narrows to `f32`. Knows nothing of voxels, files or the GPU.

mod camera;
pub mod convex;
mod pose;
mod shapes;

pub use camera::{Camera, Projection};
pub use glam::{DAffine3, DMat2, DMat3, DMat4, DQuat, DVec2, DVec3, DVec4};
pub use pose::Pose;
pub use shapes::{Aabb, Plane, Ray, nearest_region, outside_by};
