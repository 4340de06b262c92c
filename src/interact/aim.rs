//! Where a tool points, before anything is pressed.

use crate::interact::event::Hit;
use crate::interact::slices::CutSlice;
use crate::math::DVec2;

/// What a tool points at.
#[derive(Clone, Copy, Debug)]
pub enum Aim {
    /// A pixel of the 3D view of `size` pixels, and what is seen there.
    Solid {
        /// Pixel.
        px: DVec2,
        /// The view's size.
        size: [u32; 2],
        /// What lies there.
        hit: Option<Hit>,
    },
    /// A pixel of a slice.
    Slice {
        /// Pixel.
        px: DVec2,
        /// The slice.
        slice: CutSlice,
    },
}

/// The pointer over a view, as far as marks about it need to know.
#[derive(Clone, Copy, Debug)]
pub struct Aimed {
    /// Pixel of the view.
    pub px: DVec2,
    /// Millimetres in a pixel where it points; `None` over nothing in the 3D view.
    pub mm_per_px: Option<f64>,
    /// Whether the key that takes away is held.
    pub erase: bool,
}
