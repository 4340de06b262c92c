//! Painting, as arithmetic: brushes, strokes, dabs, and what a dab does to a texel.
//!
//! Pure: knows fields and geometry, neither the GPU nor documents. Direct Volume Editing (2008) section 3, equations 1 and 2
//! in the form P′ = P + G·((C op P) − P), G = strength·F(d), F = 0 beyond the support.

mod brush;

pub use brush::{Brush, Falloff, Operation, Sample, Shape, Target, Tip};
