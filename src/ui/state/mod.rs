//! What the window holds between two frames, type by type. Plain data, of which panels, views and dialogs are drawn.
//!
//! Stands below the window: knows neither `App` nor who draws it.

pub(crate) mod borders;
pub(crate) mod dialog;
pub(crate) mod hit_buffer;
pub(crate) mod labels_shown;
pub(crate) mod layout;
pub(crate) mod left_out;
pub(crate) mod lesson;
pub(crate) mod look_of;
pub(crate) mod message;
pub(crate) mod note;
pub(crate) mod path_purpose;
pub(crate) mod picture_wish;
pub(crate) mod pixels;
pub(crate) mod recent;
pub(crate) mod remarks;
pub(crate) mod sample;
pub(crate) mod saving;
pub(crate) mod trail;
pub(crate) mod transfer_editor;
pub(crate) mod viewports;
