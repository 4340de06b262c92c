//! Labels: texts in the picture's plane, each joined by a leader to what it names, as a person decided them.
//!
//! Where in a picture they are put is `annotate::labels`' to find, anew for every camera. Owns texts, what they name and how all of them look.

use crate::document::error::DocumentError;
use crate::document::scene::annotations::AnnotationId;
use crate::document::scene::check::{checked_colour, finite};
use crate::explode::PartId;
use crate::volume::VolumeId;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

const MOST_EVER: u32 = 1 << 24;
const MOST_CHARACTERS: usize = 500;

/// Name of a label within its document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
pub struct LabelId(pub u32);

/// What a label's leader ends at.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Named {
    /// A place of a volume, that goes with the part that holds it.
    Point {
        /// Whose place.
        volume: VolumeId,
        /// Continuous index of the volume.
        index: [f64; 3],
        /// Whether it is selected matter's, and stays with the selection.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        selected: bool,
    },
    /// A segment, at the voxel that is deepest inside it.
    Segment {
        /// Of which volume.
        volume: VolumeId,
        /// Its number.
        segment: u16,
    },
    /// A part, at its middle.
    Part(PartId),
    /// The centre of an annotation.
    Annotation(AnnotationId),
}

/// A text in the picture's plane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Label {
    /// What it says.
    pub text: String,
    /// What it names.
    pub at: Named,
    /// Whether pictures show it.
    pub visible: bool,
}

/// How all labels look.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct LabelStyle {
    /// Whether pictures show any.
    pub visible: bool,
    /// Whether pictures show numbers, whose texts are a key beside.
    pub numbers: bool,
    /// Height of letters, pixels of a picture 800 high; in other pictures of the window as many as they are, of renders in proportion.
    pub size_px: f32,
    /// Of texts and leaders, display-referred; `None`: what stands out from the background.
    #[serde(default)]
    pub colour: Option<[f32; 3]>,
}

impl Default for LabelStyle {
    fn default() -> Self {
        Self { visible: true, numbers: false, size_px: 13.0, colour: None }
    }
}

/// The labels of a document.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Labels {
    /// The number that the next one gets.
    pub next: u32,
    /// By number.
    pub all: BTreeMap<LabelId, Label>,
    /// How they look.
    #[serde(default)]
    pub style: LabelStyle,
}

impl Label {
    /// # Errors
    /// The first field that is wrong.
    pub(crate) fn check(&self) -> Result<(), DocumentError> {
        let count = self.text.chars().count();
        if count > MOST_CHARACTERS || self.text.trim().is_empty() {
            let expected = format!("a text of 1 to {MOST_CHARACTERS} characters");
            return Err(DocumentError::invalid("text", format!("{count} characters"), expected));
        }
        match &self.at {
            Named::Point { index, .. } => index.iter().try_for_each(|v| finite("at.index", *v).map(drop)),
            Named::Segment { segment: 0, .. } => {
                Err(DocumentError::invalid("at.segment", 0, "1 to 65535; label 0 is unlabelled matter"))
            }
            _ => Ok(()),
        }
    }
}

/// What stands out from a colour.
fn ink_on(colour: [f32; 3]) -> [f32; 3] {
    let light = 0.3 * colour[0] + 0.59 * colour[1] + 0.11 * colour[2];
    if light > 0.5 { [0.05, 0.06, 0.08] } else { [0.94, 0.95, 0.96] }
}

impl LabelStyle {
    /// Colours of texts and leaders on a background, and of the shade about them; display-referred.
    pub fn inks(&self, background: [f32; 3]) -> [[f32; 3]; 2] {
        let ink = self.colour.unwrap_or_else(|| ink_on(background));
        [ink, ink_on(ink)]
    }

    /// # Errors
    /// The first field that is wrong.
    pub(crate) fn check(&self) -> Result<(), DocumentError> {
        if !(6.0..=96.0).contains(&self.size_px) {
            return Err(DocumentError::invalid("size_px", self.size_px, "6 to 96 pixels"));
        }
        self.colour.map_or(Ok(()), |colour| checked_colour("colour", colour).map(drop))
    }
}

impl Labels {
    /// # Errors
    /// The first field that is wrong.
    pub(crate) fn check(&self) -> Result<(), DocumentError> {
        if self.next > MOST_EVER || self.all.keys().any(|id| id.0 >= self.next) {
            let expected = format!("a number above those of all labels, at most {MOST_EVER}");
            return Err(DocumentError::invalid("next", self.next, expected));
        }
        self.style.check().map_err(|e| e.within("style"))?;
        self.all.iter().try_for_each(|(id, one)| one.check().map_err(|e| e.within(&format!("all.{}", id.0))))
    }

    /// # Errors
    /// If there is none of the name.
    pub(crate) fn get(&self, id: LabelId) -> Result<&Label, DocumentError> {
        self.all.get(&id).ok_or_else(|| {
            let expected = match self.all.is_empty() {
                true => "a label, of which there is none; label.add makes one".to_owned(),
                false => format!("the number of one of the {} labels; ask.labels tells them", self.all.len()),
            };
            DocumentError::invalid("id", id.0, expected)
        })
    }

    /// A new one.
    pub(crate) fn put(&mut self, one: Label) -> LabelId {
        let id = LabelId(self.next);
        self.next += 1;
        self.all.insert(id, one);
        id
    }
}
