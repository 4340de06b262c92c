//! What of a volume can show in a picture: which values of it, of which share, and by which labels.
//!
//! Pure. A map of empty space is made for each that is asked for.

use crate::gpu::fields::visible_values::VisibleValues;
use crate::gpu::picture::frame::{LabelLooks, Mask};
use crate::volume::{FieldKey, FieldKind, VolumeId};
use std::collections::BTreeMap;

/// What of a volume bodies show: a cell that has none of it is empty to them.
#[derive(Clone, Debug, PartialEq)]
pub struct Matter {
    /// The volume.
    pub volume: VolumeId,
    /// Its values that show.
    pub values: Showing,
    /// The share of them.
    pub mask: Mask,
}

impl Matter {
    pub(super) fn hangs_on(&self, key: FieldKey) -> bool {
        self.volume == key.volume
            && match key.kind {
                FieldKind::Density => true,
                FieldKind::Colour => false,
                FieldKind::Selection => self.mask != Mask::None,
                FieldKind::Labels => matches!(self.values, Showing::ByLabel(_)),
            }
    }
}

/// The values that show of any matter, or by its label.
#[derive(Clone, Debug, PartialEq)]
pub enum Showing {
    /// Of all matter.
    One(VisibleValues),
    /// By label.
    ByLabel(LabelValues),
}

/// The values that show of each label's matter.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelValues {
    /// Those that differ.
    values: Vec<VisibleValues>,
    /// Of labels that are not named; `None`: nothing of them shows.
    default: Option<usize>,
    by_label: BTreeMap<u16, Option<usize>>,
}

impl LabelValues {
    /// Of looks by label; `of` answers the values that a row shows.
    pub fn new(labels: &LabelLooks, of: impl Fn(usize) -> VisibleValues) -> Self {
        let mut values: Vec<VisibleValues> = Vec::new();
        let mut places = BTreeMap::new();
        for row in labels.rows() {
            let shown = of(row);
            let at = values.iter().position(|v| *v == shown).unwrap_or_else(|| {
                values.push(shown);
                values.len() - 1
            });
            places.insert(row, at);
        }
        let place = |row: Option<usize>| row.and_then(|row| places.get(&row).copied());
        let by_label = labels.by_label.iter().map(|(&label, &row)| (label, place(row))).collect();
        Self { values, default: place(labels.default), by_label }
    }

    /// Whether anything in `[lo, hi]` of a label's matter shows.
    pub fn shows(&self, label: u16, [lo, hi]: [f32; 2]) -> bool {
        let at = self.by_label.get(&label).copied().unwrap_or(self.default);
        at.is_some_and(|at| self.values[at].any(lo, hi))
    }

    /// The same of any label's.
    pub fn any(&self, [lo, hi]: [f32; 2]) -> bool {
        self.values.iter().any(|values| values.any(lo, hi))
    }
}
