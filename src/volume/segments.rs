//! The table of segments: what the label field's numbers mean.

use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// A labelled object. Its voxels are those whose label is `id`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Segment {
    /// Label value, at least 1.
    pub id: u16,
    /// Name, as the user gave it.
    pub name: String,
    /// Display-referred red, green, blue, 0..1.
    pub colour: [f32; 3],
    /// Whether it is drawn.
    pub visible: bool,
    /// Whether brushes leave its voxels alone.
    pub locked: bool,
    /// The label that the file it came from has for it, where that is another number than `id` (any 64-bit integer): exports write
    /// it again.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source_value: Option<i128>,
}

impl Segment {
    /// A segment as it is until somebody says otherwise.
    pub fn new(id: u16) -> Self {
        // Hues a golden ratio apart never come close to those just before.
        let hue = (f32::from(id) * 0.618_034).fract() * 6.0;
        let ramp = |shift: f32| (((hue + shift) % 6.0 - 3.0).abs() - 1.0).clamp(0.0, 1.0) * 0.65 + 0.3;
        let colour = [ramp(0.0), ramp(4.0), ramp(2.0)];
        Self { id, name: format!("Segment {id}"), colour, visible: true, locked: false, source_value: None }
    }

    /// The label that files have for it.
    pub fn file_value(&self) -> i128 {
        self.source_value.unwrap_or(i128::from(self.id))
    }
}

/// All segments, by rising id.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Segments(pub Vec<Segment>);

impl Segments {
    /// The segment of a label.
    pub fn get(&self, id: u16) -> Option<&Segment> {
        self.0.binary_search_by_key(&id, |s| s.id).ok().map(|i| &self.0[i])
    }

    /// What files have for the id of each segment: the number that it came with, else its id. Where two would have the same, the
    /// one with a number of its own has it, then the lower id; another gets the lowest number that is free.
    pub fn file_values(&self) -> BTreeMap<u16, i128> {
        let mut values = BTreeMap::new();
        let mut taken = BTreeSet::new();
        let own_first = |own: bool| self.0.iter().filter(move |s| s.source_value.is_some() == own);
        let wishes = own_first(true).chain(own_first(false));
        let mut late: Vec<&Segment> = wishes
            .filter(|s| {
                let free = s.file_value() != 0 && taken.insert(s.file_value());
                if free {
                    values.insert(s.id, s.file_value());
                }
                !free
            })
            .collect();
        late.sort_by_key(|s| s.id);
        let mut next = (1..).filter(|n| !taken.contains(n));
        for segment in late {
            values.extend(next.next().map(|value| (segment.id, value)));
        }
        values
    }

    /// The same, to change it.
    pub fn get_mut(&mut self, id: u16) -> Option<&mut Segment> {
        self.0.binary_search_by_key(&id, |s| s.id).ok().map(|i| &mut self.0[i])
    }

    /// Adds a segment, or replaces the one of that id.
    pub fn put(&mut self, segment: Segment) {
        match self.0.binary_search_by_key(&segment.id, |s| s.id) {
            Ok(i) => self.0[i] = segment,
            Err(i) => self.0.insert(i, segment),
        }
    }

    /// A segment of that id if there is none, with a colour that differs from its neighbours'.
    pub fn ensure(&mut self, id: u16) {
        if id != 0 && self.get(id).is_none() {
            self.put(Segment::new(id));
        }
    }

    /// An id for another segment: the one after the last, or where that is the greatest there is the lowest that is free. `None`
    /// if all are taken.
    pub fn free(&self) -> Option<u16> {
        let after = self.0.last().map_or(Some(1), |last| last.id.checked_add(1));
        after.or_else(|| (1..=u16::MAX).zip(&self.0).find(|(id, segment)| *id != segment.id).map(|(id, _)| id))
    }

    /// The colour of a label: its segment's, or the one that [`ensure`](Self::ensure) would give it.
    pub fn colour_of(&self, id: u16) -> [f32; 3] {
        self.get(id).map_or_else(|| Segment::new(id).colour, |segment| segment.colour)
    }
}
