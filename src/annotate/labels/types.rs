//! What goes into and comes out of the placing of labels.
//!
//! A label is a point in the picture and the size of its text; where it goes is a rectangle and a leader to it. All lengths are in
//! pixels of the picture, x to the right, y downward, origin at the top left corner. Owns plain data; knows no camera and no text.

use glam::DVec2;

/// A point that wants a label, in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Label {
    /// Whose label it is; no two of a frame are the same.
    pub id: u64,
    /// The projected point, px.
    pub anchor: DVec2,
    /// Distance from the viewer in any unit; of two equal priorities the nearer is kept.
    pub depth: f64,
    /// False if the point is hidden: its label fades and takes no room.
    pub visible: bool,
    /// Width and height of its text, px.
    pub size: DVec2,
    /// Labels of low priority are left out first; any finite number.
    pub priority: f64,
}

/// The picture that labels go into.
#[derive(Clone, Debug, PartialEq)]
pub struct Viewport {
    /// Width and height, px.
    pub size: DVec2,
    /// Corners of the object's outline on the screen, px: labels keep out of its box, as far as the
    /// picture has room beside it. None: the points themselves stand for it.
    pub outline: Vec<DVec2>,
}

/// How labels are placed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// From the outline to the labels, px.
    pub margin: f64,
    /// From the picture's edge to the labels, px.
    pub border: f64,
    /// The least gap between two labels of a column, px.
    pub gap: f64,
    /// The gap that labels take where there is room, px.
    pub roomy: f64,
    /// Between a leader and a point that it passes, px.
    pub clearance: f64,
    /// A point has to be this far past the middle, as a share of half the object's width, before its label changes sides.
    pub dead_band: f64,
    /// The most that a label goes in x and in y while the scene moves by one step, px.
    pub stride: DVec2,
    /// The greatest speed of a label on its way, px/s.
    pub speed: f64,
    /// How long a label that changes places takes to fade out, and to fade in, s.
    pub fade_s: f64,
    /// How long a label whose point is hidden takes to fade out, and in when it comes back, s.
    pub hide_s: f64,
    /// How long all labels rest between two rounds of changes, s.
    pub rest_s: f64,
    /// What a right angle in a leader is worth in px of its length.
    pub bend: f64,
    /// Two neighbours change places if that spares this much, px of leader.
    pub worth: f64,
    /// The most changes of one label in a quarter turn; one of them is kept for its change of side.
    pub changes: usize,
    /// A scene that has not moved for so long is no longer turning: labels are placed anew if that helps much, s. Infinite: never.
    pub still_s: f64,
}

impl Style {
    /// The size of letters that the usual lengths are for, px.
    const USUAL_PX: f64 = 13.0;

    /// The usual one for letters of a size, px.
    #[must_use]
    pub fn of_letters(size_px: f64) -> Self {
        let of = Self::default();
        let scale = size_px / Self::USUAL_PX;
        Self {
            margin: of.margin * scale,
            border: of.border * scale,
            gap: of.gap * scale,
            roomy: of.roomy * scale,
            clearance: of.clearance * scale,
            ..of
        }
    }
}

impl Default for Style {
    fn default() -> Self {
        Self {
            margin: 24.0,
            border: 4.0,
            gap: 2.0,
            roomy: 7.0,
            clearance: 3.0,
            dead_band: 0.04,
            stride: DVec2::new(6.0, 7.5),
            speed: 450.0,
            fade_s: 0.08,
            hide_s: 0.2,
            rest_s: 0.25,
            bend: 40.0,
            worth: 25.0,
            changes: 3,
            still_s: 2.5,
        }
    }
}

/// A side of the object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
}

/// A rectangle in the picture, px.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    /// Top left corner.
    pub min: DVec2,
    /// Bottom right corner.
    pub max: DVec2,
}

/// Where one label is.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    /// Whose label it is.
    pub id: u64,
    /// Its text's place, px.
    pub rect: Rect,
    /// The column that it stands in.
    pub side: Side,
    /// From the point to the middle of the rectangle's near edge, px; onward in x.
    pub leader: Vec<DVec2>,
    /// 0 (gone) to 1.
    pub opacity: f64,
    /// False while it fades or changes places.
    pub settled: bool,
}

/// Why a label has no place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// Labels of higher priority fill both columns, or its text is too wide for the picture.
    NoRoom,
    /// Its point is out of the picture, or under a column of labels.
    OutOfReach,
    /// There is room, which is being made as the scene moves.
    Waiting,
}

/// Labels in one frame.
///
/// In every frame, settled or not, no two rectangles overlap, no leader crosses another, and none runs through another's
/// rectangle; all rectangles lie in the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// The labels that have a place, by id.
    pub labels: Vec<Placed>,
    /// The visible ones that have none, lowest priority first, with the reason.
    pub left_out: Vec<(u64, Reason)>,
    /// No label changes places. Labels of points that become hidden or visible may fade, where they stand.
    pub settled: bool,
}
