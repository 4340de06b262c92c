//! What of the editor of the transfer function outlives a frame: which point is chosen, the histogram's bars, the range that is shown.

use crate::ui::state::look_of::LookOf;
use crate::volume::Histogram;
use egui::Rect;
use egui::pos2;
use std::sync::Arc;

/// A point of the function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Point {
    Opacity(usize),
    Colour(usize),
}

/// What of the editor outlives a frame.
#[derive(Debug, Default)]
pub(crate) struct TransferEditor {
    /// What has the function for itself that is shown instead of the active volume's.
    pub(crate) of: Option<LookOf>,
    pub(crate) selected: Option<Point>,
    /// Heights 0..1 of the histogram, and the histogram they are of.
    pub(crate) bars: Option<(Arc<Histogram>, Vec<f32>)>,
}

/// Values across the plot.
#[derive(Clone, Copy)]
pub(crate) struct Plot {
    pub(crate) rect: Rect,
    pub(crate) lo: f64,
    pub(crate) hi: f64,
}

/// Widths of the plot, either way, beyond which a point is drawn no further off.
pub(crate) const FAR: f64 = 1e4;

impl Plot {
    /// Over a histogram's values; of one value alone with room beside it.
    pub(crate) fn new(rect: Rect, histogram: &Histogram) -> Self {
        let (lo, hi) = (histogram.min, histogram.max);
        let room = (lo.abs() * 1e-6).max(1.0);
        let [lo, hi] = match hi > lo {
            true => [lo, hi],
            false if lo + room > f64::MAX => [lo - room, lo],
            false => [lo, lo + room],
        };
        Self { rect, lo, hi }
    }

    pub(crate) fn x(&self, value: f64) -> f32 {
        // Halves, where the distance is beyond all numbers.
        let unit = if (self.hi - self.lo).is_finite() { 1.0 } else { 0.5 };
        let share = (value * unit - self.lo * unit) / (self.hi * unit - self.lo * unit);
        self.rect.left() + share.clamp(-FAR, FAR) as f32 * self.rect.width()
    }

    pub(crate) fn value(&self, x: f32) -> f64 {
        let share = f64::from((x - self.rect.left()) / self.rect.width());
        self.lo * (1.0 - share) + self.hi * share
    }

    pub(crate) fn y(&self, opacity: f32) -> f32 {
        self.rect.bottom() - opacity.clamp(0.0, 1.0) * self.rect.height()
    }

    pub(crate) fn opacity(&self, y: f32) -> f64 {
        f64::from((self.rect.bottom() - y) / self.rect.height())
    }

    /// Least distance of neighbours: what a hand can still tell apart.
    pub(crate) fn gap(&self) -> f64 {
        self.hi / 2000.0 - self.lo / 2000.0
    }
}

impl TransferEditor {
    /// Shows the function of something, or of the active volume again.
    pub(crate) fn edit(&mut self, of: Option<LookOf>) {
        (self.of, self.selected) = (of, None);
    }

    /// One bar for each column of pixels; neighbours of one height are one.
    pub(crate) fn bars(&mut self, plot: &Plot, histogram: &Arc<Histogram>, scale: f32) -> Vec<Rect> {
        if !self.bars.as_ref().is_some_and(|(h, _)| Arc::ptr_eq(h, histogram)) {
            self.bars = Some((histogram.clone(), heights(&histogram.bins)));
        }
        let Some((_, bars)) = &self.bars else { return Vec::new() };
        let columns = (plot.rect.width() * scale).max(1.0) as usize;
        let mut rects: Vec<Rect> = Vec::new();
        for c in 0..columns {
            // Several bins under one column: the highest is seen.
            let (a, b) = (c * bars.len() / columns, ((c + 1) * bars.len()).div_ceil(columns));
            let height = bars[a.min(bars.len())..b.min(bars.len())].iter().copied().fold(0.0, f32::max);
            let x = plot.rect.left() + c as f32 / scale;
            let top = plot.rect.bottom() - height * plot.rect.height() * 0.94;
            match rects.last_mut().filter(|last| last.top() == top) {
                Some(last) => last.max.x = x + 1.0 / scale,
                None => rects.push(Rect::from_min_max(pos2(x, top), pos2(x + 1.0 / scale, plot.rect.bottom()))),
            }
        }
        rects
    }
}

/// Logarithms of the counts, 0..1: air would hide all tissue otherwise.
pub(crate) fn heights(bins: &[u64]) -> Vec<f32> {
    let top = bins.iter().copied().max().unwrap_or(0).max(1) as f64;
    bins.iter().map(|&n| ((1.0 + n as f64).ln() / (1.0 + top).ln()) as f32).collect()
}
