//! What is written on and about volumes, against formulas, plain minimisers and brute force.

mod cutaway;
mod distance;
mod geodesic;
mod label_parts;
mod label_scene;
mod labels;
mod lasso;
mod relaxed;
mod relaxed_oracle;
mod text;
mod traced_grid;
mod trilinear;
mod voxels;
