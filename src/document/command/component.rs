//! The commands on what is connected: what of the matter that shows hangs together with a place stays, goes, is selected or labelled.

#![allow(missing_docs)] // fields: the command's own text says what they are

use crate::document::command::Place;
use crate::volume::{Number, VolumeId};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which voxels can be connected at all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Matter {
    /// Those that the 3D view shows: of an opacity above 0 under the present look, hidden segments left out.
    #[default]
    Visible,
    /// Those whose value is in this closed range, told in the source's own numbers.
    Range([Number; 2]),
    /// All.
    Everything,
}

/// Where voxels may be connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Within {
    /// Anywhere in the volume.
    Volume,
    /// Where the selection is a half at least.
    Selection,
    /// In a segment; 0: where there is no label.
    Segment(u16),
}

/// Which voxels are neighbours: 6 (they share a face), 18 (or an edge), 26 (or a corner).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "u8", into = "u8")]
#[schemars(with = "u8")]
pub struct Neighbours(u8);

impl Default for Neighbours {
    fn default() -> Self {
        Self(6)
    }
}

impl TryFrom<u8> for Neighbours {
    type Error = String;

    fn try_from(count: u8) -> Result<Self, String> {
        match count {
            6 | 18 | 26 => Ok(Self(count)),
            _ => Err(format!("neighbours: {count} found, 6, 18 or 26 expected")),
        }
    }
}

impl From<Neighbours> for u8 {
    fn from(neighbours: Neighbours) -> Self {
        neighbours.0
    }
}

/// A size that pieces are told by.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PieceSize {
    /// Of all its voxels together.
    Mm3(f64),
    /// Voxels, of whatever size.
    Voxels(u64),
}

/// Which component is meant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Connected {
    pub at: Option<Place>,
    pub volume: Option<VolumeId>,
    pub matter: Matter,
    pub within: Option<Within>,
    pub neighbours: Neighbours,
    pub smaller_than: Option<PieceSize>,
}

/// What a verb has for itself, beside what says which component is meant.
macro_rules! of_a_component {
    ($($(#[$doc:meta])* $name:ident { $($(#[$field:meta])* $extra:ident: $type:ty,)* })*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
            #[serde(deny_unknown_fields)]
            pub struct $name {
                /// A place in it: in mm, in index, or a pixel of a view. The largest component if left out.
                #[serde(default, skip_serializing_if = "Option::is_none")]
                pub at: Option<Place>,
                /// If left out the volume that a pixel of the 3D view shows, else the active one.
                #[serde(default, skip_serializing_if = "Option::is_none")]
                pub volume: Option<VolumeId>,
                /// Which voxels can be connected: `"visible"` if left out, `{"range":[lo,hi]}`, `"everything"`.
                #[serde(default)]
                pub matter: Matter,
                /// Where: `"volume"`, `"selection"`, `{"segment":id}`.
                #[serde(default, skip_serializing_if = "Option::is_none")]
                pub within: Option<Within>,
                /// 6 if left out; 18 or 26: voxels that share an edge, or a corner, are neighbours too.
                #[serde(default)]
                pub neighbours: Neighbours,
                /// In place of one component all that are smaller: `{"mm3":2.5}`, `{"voxels":20}`. Without `at`.
                #[serde(default, skip_serializing_if = "Option::is_none")]
                pub smaller_than: Option<PieceSize>,
                $($(#[$field])* pub $extra: $type,)*
            }

            impl $name {
                fn connected(&self) -> Connected {
                    let Self { at, volume, matter, within, neighbours, smaller_than, .. } = *self;
                    Connected { at, volume, matter, within, neighbours, smaller_than }
                }

                fn put(&mut self, at: Option<Place>, volume: Option<VolumeId>) {
                    (self.at, self.volume) = (at, volume);
                }
            }
        )*
    };
}

of_a_component! {
    /// Of `component.keep` and `component.remove`. Where nothing is said of `within`: in what is selected if anything is, else anywhere.
    Isolation {
        /// What removed voxels become. If left out the value that the brush's erasing sets, or another that does not show.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        value: Option<f64>,
    }
    /// Of `component.select`. Where nothing is said of `within`: anywhere.
    Selecting {
        /// Whether it becomes all that is selected, is added or taken away.
        #[serde(default)]
        how: Joining,
    }
    /// Of `component.label`. Where nothing is said of `within`: in what is selected if anything is, else anywhere.
    Labelling {
        /// The segment, which is made if there is none; 0 takes labels away. Voxels of locked segments stay as they are.
        label: u16,
    }
}

impl Isolation {
    /// Of what is connected to a place under the present look.
    pub fn at(at: Place) -> Self {
        Self { at: Some(at), ..Self::default() }
    }

    /// Of all that are smaller under the present look.
    pub fn smaller_than(size: PieceSize) -> Self {
        Self { smaller_than: Some(size), ..Self::default() }
    }
}

/// What becomes of what was selected before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Joining {
    /// Nothing of it stays.
    #[default]
    Replace,
    /// It stays.
    Add,
    /// It stays but for the component.
    Subtract,
}

/// See [`Command::Component`](crate::document::Command::Component).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ComponentCommand {
    /// Removes from density all matter but the component. Answers `volume`, `voxels` of the component, `components`, and `value`.
    Keep(Isolation),
    /// Removes the component from density. Answers as `keep`.
    Remove(Isolation),
    /// Selects the component. Answers `volume`, `voxels`, `components`.
    Select(Selecting),
    /// Labels the component. Answers `volume`, `voxels`, `components`, and `kept_locked`: voxels left alone.
    Label(Labelling),
}

impl ComponentCommand {
    /// Which component is meant.
    pub(crate) fn connected(&self) -> Connected {
        match self {
            Self::Keep(removal) | Self::Remove(removal) => removal.connected(),
            Self::Select(selecting) => selecting.connected(),
            Self::Label(labelling) => labelling.connected(),
        }
    }

    /// The same of another place and volume.
    #[must_use]
    pub(crate) fn put(mut self, at: Option<Place>, volume: Option<VolumeId>) -> Self {
        match &mut self {
            Self::Keep(removal) | Self::Remove(removal) => removal.put(at, volume),
            Self::Select(selecting) => selecting.put(at, volume),
            Self::Label(labelling) => labelling.put(at, volume),
        }
        self
    }

    /// What the step is called.
    pub(crate) fn step_name(&self) -> String {
        let of = |small: Option<PieceSize>| if small.is_some() { "small pieces" } else { "what is connected" };
        match self {
            Self::Keep(said) => format!("Keep {}", of(said.smaller_than)),
            Self::Remove(said) => format!("Remove {}", of(said.smaller_than)),
            Self::Select(said) => format!("Select {}", of(said.smaller_than)),
            Self::Label(said) => format!("Label {} on {}", said.label, of(said.smaller_than)),
        }
    }
}
