//! Cutaways: windows into what lies behind a surface, as a person decided them ("Direct Volume Editing", 2008, section 5.2).
//!
//! Owns where they are, how deep and what they spare; the closed meshes that cut are found from the voxels and belong to
//! `document::live`.

use crate::document::error::DocumentError;
use crate::document::scene::annotations::Anchor;
use crate::document::scene::check::{checked_colour, finite, positive};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

const MOST_EVER: u32 = 1 << 24;
/// Places of a lasso.
const MOST_PLACES: usize = 4096;

/// Name of a cutaway within its document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
pub struct CutawayId(pub u32);

/// The outline of a window.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Outline {
    /// A grid about a place, as an annotation's.
    Grid {
        /// Along the direction, mm on the surface.
        width_mm: f64,
        /// Across, mm on the surface.
        height_mm: f64,
    },
    /// A closed line on the surface.
    Lasso {
        /// Continuous indices of the volume, in order.
        points: Vec<[f64; 3]>,
    },
}

/// The visible edge of a window.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Rim {
    /// Mm on the surface; 0: none.
    pub width_mm: f64,
    /// Display-referred.
    pub colour: [f32; 3],
}

/// What stands in a window as it was.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spared {
    /// Selected matter.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub selection: bool,
    /// Matter of these segments.
    #[serde(default, skip_serializing_if = "BTreeSet::is_empty")]
    pub segments: BTreeSet<u16>,
}

impl Spared {
    /// Nothing is.
    pub(crate) fn is_nothing(&self) -> bool {
        !self.selection && self.segments.is_empty()
    }
}

/// A window into what lies behind a surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Cutaway {
    /// What it is called.
    pub name: String,
    /// Its middle and direction; of a lasso the middle and the direction of the floor.
    pub anchor: Anchor,
    /// Its outline.
    pub outline: Outline,
    /// How far the floor lies behind the surface, against the normal in its middle, mm.
    pub depth_mm: f64,
    /// Its edge.
    pub rim: Rim,
    /// Whether its walls grow darker with their depth.
    pub shaded: bool,
    /// What stands in it.
    #[serde(default, skip_serializing_if = "Spared::is_nothing")]
    pub spares: Spared,
    /// Whether it is open.
    pub open: bool,
}

/// The cutaways of a document.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Cutaways {
    /// The number that the next one gets.
    pub next: u32,
    /// By number.
    pub all: BTreeMap<CutawayId, Cutaway>,
}

impl Cutaway {
    /// # Errors
    /// The first field that is wrong.
    pub(crate) fn check(&self) -> Result<(), DocumentError> {
        positive("depth_mm", self.depth_mm)?;
        self.anchor.check()?;
        match &self.outline {
            Outline::Grid { width_mm, height_mm } => {
                positive("width_mm", *width_mm)?;
                positive("height_mm", *height_mm)?;
            }
            Outline::Lasso { points } => {
                if !(3..=MOST_PLACES).contains(&points.len()) {
                    let expected = format!("3 to {MOST_PLACES} places on the surface");
                    return Err(DocumentError::invalid("lasso", format!("{} places", points.len()), expected));
                }
                points.iter().flatten().try_for_each(|v| finite("lasso", *v).map(drop))?;
            }
        }
        if !(self.rim.width_mm.is_finite() && self.rim.width_mm >= 0.0) {
            return Err(DocumentError::invalid("rim.width_mm", self.rim.width_mm, "a length in mm, 0 or more"));
        }
        checked_colour("rim.colour", self.rim.colour).map(drop)
    }
}

impl Cutaways {
    /// # Errors
    /// The first field that is wrong.
    pub(crate) fn check(&self) -> Result<(), DocumentError> {
        if self.next > MOST_EVER || self.all.keys().any(|id| id.0 >= self.next) {
            let expected = format!("a number above those of all cutaways, at most {MOST_EVER}");
            return Err(DocumentError::invalid("next", self.next, expected));
        }
        self.all.iter().try_for_each(|(id, one)| one.check().map_err(|e| e.within(&format!("all.{}", id.0))))
    }

    /// # Errors
    /// If there is none of the name.
    pub(crate) fn get(&self, id: CutawayId) -> Result<&Cutaway, DocumentError> {
        self.all.get(&id).ok_or_else(|| {
            let known: Vec<_> = self.all.iter().map(|(id, one)| format!("{} ({})", id.0, one.name)).collect();
            let expected = match known.is_empty() {
                true => "a cutaway, of which there is none; cutaway.add makes one".to_owned(),
                false => format!("one of the cutaways: {}", known.join(", ")),
            };
            DocumentError::invalid("id", id.0, expected)
        })
    }

    /// A new one.
    pub(crate) fn put(&mut self, one: Cutaway) -> CutawayId {
        let id = CutawayId(self.next);
        self.next += 1;
        self.all.insert(id, one);
        id
    }
}
