//! Grids that lie on a surface as little distorted as it allows, and without folds: the open problem of "Direct Volume Editing".

pub(crate) mod banded;
pub(crate) mod dirichlet;
pub(crate) mod growth;
pub mod relax;
pub(crate) mod sheet;
pub(crate) mod slide;
pub(crate) mod unfold;
