//! Closed meshes of windowed cutaways ("Direct Volume Editing", 2008, section 5.2).

pub mod cutaway;
pub mod lasso;
pub(crate) mod lasso_line;
pub mod patch;
