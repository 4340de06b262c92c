//! How the window is divided: widths of the side panels, where the four views meet, heights of the lists, what is folded.
//!
//! A preference of the person and not of the document: in no project and in no history, kept in a file beside the program's
//! other state and read at its next start. Owns the bounds within which everything can still be used; knows no controls.

use crate::io::replace_file;
use crate::ui::state::recent::private_folder;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::Error;
use std::path::Path;

/// Thickness of what is dragged, points.
pub(crate) const BORDER: f32 = 5.0;
/// Least and largest width of a side panel, points.
const SIDE: [f32; 2] = [256.0, 520.0];
/// Width that the views keep however narrow the window is, points.
const CENTRE: f32 = 380.0;
/// Least share of a view.
const VIEW: f32 = 0.15;
/// Height of a heading over a list, points.
pub(crate) const HEAD: f32 = 30.0;
/// Least height of a list: three rows and a half say that there are more.
pub(crate) const LIST: f32 = 77.0;
/// Sections that are remembered: more than there are.
const MOST_FOLDS: usize = 32;
/// A file longer than this is none of ours.
const MOST_BYTES: u64 = 4096;

/// Sizes as the person chose them; what a window is too small for is taken back only as long as it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Layout {
    /// Width of the panel on the left, points.
    pub left: f32,
    /// Width of the panel on the right, points.
    pub right: f32,
    /// Where the four views meet, as shares of width and height, 0..1.
    pub views: [f32; 2],
    /// Height of the list of segments with its heading, points; `None`: what is left.
    pub segments: Option<f32>,
    /// Height of the lists of parts and steps with their headings, points; `None`: what is left.
    pub lists: Option<f32>,
    /// The steps' share of that, 0..1.
    pub steps: f32,
    /// Sections by title that were folded or unfolded by hand, and whether they are open.
    pub folds: BTreeMap<String, bool>,
}

impl Default for Layout {
    fn default() -> Self {
        Self {
            left: 288.0,
            right: 288.0,
            views: [0.5; 2],
            segments: None,
            lists: None,
            steps: 0.34,
            folds: BTreeMap::new(),
        }
    }
}

impl Layout {
    /// The layout that a file keeps; the usual one where there is none or it cannot be read.
    pub fn read(path: &Path) -> Self {
        let whole = || -> Option<Self> {
            let about = std::fs::metadata(path).ok()?;
            let fits = about.is_file() && about.len() <= MOST_BYTES;
            serde_json::from_str(&fits.then(|| std::fs::read_to_string(path).ok())??).ok()
        };
        whole().unwrap_or_default().checked()
    }

    /// Keeps it in a file, whole or not at all.
    ///
    /// # Errors
    /// What the system refuses.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        if let Some(dir) = path.parent() {
            private_folder(dir)?;
        }
        replace_file(path, serde_json::to_string(self)?.as_bytes()).map_err(Error::other)
    }

    /// The same with every number within bounds; what is no number becomes the usual.
    pub(crate) fn checked(self) -> Self {
        let usual = Self::default();
        let within = |x: f32, [lo, hi]: [f32; 2], else_: f32| if x.is_finite() { x.clamp(lo, hi) } else { else_ };
        let list = |x: Option<f32>| x.filter(|h| h.is_finite()).map(|h| h.clamp(HEAD, 10_000.0));
        Self {
            left: within(self.left, SIDE, usual.left),
            right: within(self.right, SIDE, usual.right),
            views: self.views.map(|v| within(v, [VIEW, 1.0 - VIEW], 0.5)),
            segments: list(self.segments),
            lists: list(self.lists),
            steps: within(self.steps, [0.0, 1.0], usual.steps),
            folds: self.folds.into_iter().take(MOST_FOLDS).collect(),
        }
    }

    /// Widths of the panels on the left and on the right in a window of this width: the views keep theirs, as long as the panels
    /// can be read.
    pub(crate) fn sides(&self, window: f32) -> [f32; 2] {
        let [least, most] = SIDE;
        let room = |other: f32| (window - CENTRE - other).clamp(least, most);
        let left = self.left.min(room(self.right.min(room(least))));
        [left, self.right.min(room(left))]
    }

    /// Height of lists below sections of `natural` height in a column of height `all`: by hand, else what the sections leave,
    /// at least the share `least` of the column. `open` of `heads` lists are unfolded.
    pub(crate) fn list(by_hand: Option<f32>, all: f32, natural: f32, least: f32, [open, heads]: [u8; 2]) -> f32 {
        let folded = f32::from(heads) * HEAD;
        if open == 0 {
            return folded;
        }
        let lowest = (folded + f32::from(open) * LIST).min(all * 0.6);
        let usual = (all - natural - BORDER).max(all * least);
        by_hand.unwrap_or(usual).clamp(lowest, (all * 0.75).max(lowest)).round()
    }
}
