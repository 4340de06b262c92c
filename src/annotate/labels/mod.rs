//! Labels in screen space.
//!
//! Labels stand in two columns beside the object, joined to their points by leaders that never cross. [`place_still`] places them
//! for one picture; [`place`] follows a moving scene and remembers where they were. Owns the memory of places only; knows neither
//! camera nor fonts: points come projected, texts as their sizes.

mod board;
mod change;
mod column;
mod follow;
mod key;
mod leader;
mod memory;
mod pole;
mod still;
mod types;

pub use column::{Stand, Wish, approach, spread};
pub use follow::place;
pub use key::{KeyLine, key_lines};
pub use leader::{Ends, burden, length, route, route_both};
pub use memory::Memory;
pub use pole::pole;
pub use still::place_still;
pub use types::{Frame, Label, Placed, Reason, Rect, Side, Style, Viewport};
