//! The room for labels beside the object.
//!
//! Labels of a side stand with their near edges on one vertical line, a margin away from the object's outline or, where the picture
//! ends there, as far out as its widest label allows. Sides are computed mirrored, so that labels always lie toward +u: u is x on
//! the right and −x on the left. Owns the two lines and the height; knows neither orders nor time.

use crate::annotate::labels::types::{Label, Reason, Rect, Side, Style, Viewport};
use glam::DVec2;
use std::cmp::Ordering;

/// A point has to lie this far before the labels of its side, px.
const BEFORE: f64 = 4.0;

/// Both columns' room, px.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Board {
    /// Middle of the object, x.
    pub(crate) middle: f64,
    /// Half its width.
    pub(crate) half: f64,
    /// u of the near edges, left and right.
    pub(crate) edge: [f64; 2],
    /// The greatest u that leaves the widest label in the picture.
    pub(crate) most: [f64; 2],
    /// Least y of labels.
    pub(crate) top: f64,
    /// Greatest y of labels.
    pub(crate) bottom: f64,
}

impl Board {
    /// The room beside this outline (or, without one, beside the points that are visible).
    #[must_use]
    pub(crate) fn new(viewport: &Viewport, style: &Style, labels: &[Label]) -> Self {
        let inside = |point: &DVec2| point.is_finite();
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for point in viewport.outline.iter().filter(|point| inside(point)) {
            (low, high) = (low.min(point.x), high.max(point.x));
        }
        if low > high {
            for label in labels.iter().filter(|label| label.visible && inside(&label.anchor)) {
                (low, high) = (low.min(label.anchor.x), high.max(label.anchor.x));
            }
        }
        if low > high {
            (low, high) = (viewport.size.x / 2.0, viewport.size.x / 2.0);
        }
        // What lies out of the picture is no reason to move the middle out too.
        (low, high) = (low.clamp(0.0, viewport.size.x), high.clamp(0.0, viewport.size.x));
        let room = viewport.size.x / 2.0 - style.border - style.margin;
        let widest = labels.iter().map(|label| label.size.x).filter(|width| *width <= room).fold(0.0, f64::max);
        let most = [-(style.border + widest), viewport.size.x - style.border - widest];
        Self {
            middle: f64::midpoint(low, high),
            half: ((high - low) / 2.0).max(1.0),
            edge: [(style.margin - low).min(most[0]), (high + style.margin).min(most[1])],
            most,
            top: style.border,
            bottom: viewport.size.y - style.border,
        }
    }

    /// The side of a column: 0 is left, 1 right.
    #[must_use]
    pub(crate) fn side(column: usize) -> Side {
        if column == 0 { Side::Left } else { Side::Right }
    }

    /// A point mirrored into a column's own x, or back.
    #[must_use]
    pub(crate) fn mirrored(column: usize, point: DVec2) -> DVec2 {
        if column == 0 { DVec2::new(-point.x, point.y) } else { point }
    }

    /// How far past the middle a point lies toward a column, px.
    #[must_use]
    pub(crate) fn toward(&self, column: usize, anchor: DVec2) -> f64 {
        if column == 0 { self.middle - anchor.x } else { anchor.x - self.middle }
    }

    /// Middle of the near edge of a label at this height.
    #[must_use]
    pub(crate) fn port(&self, column: usize, y: f64) -> DVec2 {
        Self::mirrored(column, DVec2::new(self.edge[column], y))
    }

    /// The place of a label of this size whose middle is at this height.
    #[must_use]
    pub(crate) fn rect(&self, column: usize, y: f64, size: DVec2) -> Rect {
        let near = self.port(column, y);
        let left = if column == 0 { near.x - size.x } else { near.x };
        Rect { min: DVec2::new(left, y - size.y / 2.0), max: DVec2::new(left + size.x, y + size.y / 2.0) }
    }

    /// Whether a point lies in the picture and between the columns.
    #[must_use]
    pub(crate) fn reaches(&self, anchor: DVec2, size: DVec2) -> bool {
        anchor.is_finite()
            && (0.0..=size.y).contains(&anchor.y)
            && (0..2).all(|column| Self::mirrored(column, anchor).x <= self.edge[column] - BEFORE)
    }

    /// Whether a text of this size fits beside the object at all.
    #[must_use]
    pub(crate) fn fits(&self, viewport: &Viewport, style: &Style, size: DVec2) -> bool {
        size.is_finite()
            && size.min_element() > 0.0
            && size.x <= viewport.size.x / 2.0 - style.border - style.margin
            && size.y <= self.bottom - self.top
    }
}

/// The order in which labels are left out: by priority, the farther of equal ones first, then the one of the greater id.
pub(crate) fn lowest_first(a: &Label, b: &Label) -> Ordering {
    a.priority.total_cmp(&b.priority).then(b.depth.total_cmp(&a.depth)).then(b.id.cmp(&a.id))
}

/// Indices of the labels that want a place and can have one, highest priority first, and of those that can not, lowest first, with why.
pub(crate) fn sorted_out(
    board: &Board,
    viewport: &Viewport,
    style: &Style,
    labels: &[Label],
) -> (Vec<usize>, Vec<(usize, Reason)>) {
    let mut wanted: Vec<usize> = (0..labels.len()).filter(|&n| labels[n].visible).collect();
    wanted.sort_by(|&a, &b| lowest_first(&labels[b], &labels[a]));
    let tallest = wanted.iter().map(|&n| labels[n].size.y).filter(|y| y.is_finite()).fold(0.0, f64::max);
    // Two columns hold all but what one label's height may leave over in one of them.
    let room = 2.0 * (board.bottom - board.top + style.gap) - (tallest + style.gap);
    let (mut kept, mut left_out, mut used) = (Vec::new(), Vec::new(), 0.0);
    for n in wanted {
        let label = &labels[n];
        if !board.reaches(label.anchor, viewport.size) {
            left_out.push((n, Reason::OutOfReach));
        } else if !board.fits(viewport, style, label.size) || used + label.size.y + style.gap > room {
            left_out.push((n, Reason::NoRoom));
        } else {
            used += label.size.y + style.gap;
            kept.push(n);
        }
    }
    left_out.reverse();
    (kept, left_out)
}
