//! What is written on surfaces, as the tools for it have it in hand: what a new thing will be, which one is picked, where all of them are.
//!
//! Owns what panels say of things that are not there yet. Knows no voxels: places come from the document.

use crate::document::{
    Align, Annotation, AnnotationChange, AnnotationCommand, AnnotationId, Command, Content, CutawayChange,
    CutawayCommand, CutawayId, LabelChange, LabelCommand, LabelId, PatternKind, ViewName,
};
use crate::interact::event::PointerEvent;
use crate::interact::readout::round_length;
use crate::math::{Camera, DVec2, DVec3};
use std::collections::BTreeMap;

/// How near the hand must come to a middle, pixels.
const NEAR_PX: f64 = 10.0;
/// What lies behind what is seen by more than this share of its distance is hidden.
const BEHIND: f64 = 0.02;

/// One of the things that are written on surfaces or beside the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Written {
    /// An annotation.
    Annotation(AnnotationId),
    /// A label.
    Label(LabelId),
    /// A cutaway.
    Cutaway(CutawayId),
}

impl Written {
    /// What takes it away.
    pub fn remove(self) -> Command {
        match self {
            Self::Annotation(id) => Command::Annotation(AnnotationCommand::Remove { id }),
            Self::Label(id) => Command::Label(LabelCommand::Remove { id }),
            Self::Cutaway(id) => Command::Cutaway(CutawayCommand::Remove { id }),
        }
    }
}

/// What a new annotation shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum WritingKind {
    /// A text.
    #[default]
    Text,
    /// An arrow.
    Arrow,
    /// The shortest way to another place, with its length.
    Ruler,
    /// Hatching.
    Pattern,
    /// A picture from a file.
    Image,
}

impl WritingKind {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Text, Self::Arrow, Self::Ruler, Self::Pattern, Self::Image];

    /// Whether its size is that of letters.
    pub fn has_letters(self) -> bool {
        matches!(self, Self::Text | Self::Ruler)
    }
}

/// What new things will be, what is picked, and where all are.
#[derive(Clone, Debug, PartialEq)]
pub struct Writing {
    /// Where middles are and leaders end, world mm as posed.
    pub places: BTreeMap<Written, DVec3>,
    /// What the panel shows and keys act on.
    pub picked: Option<Written>,
    /// Length of the box of what is open from corner to corner, mm.
    pub extent_mm: f64,
    /// Of a new annotation.
    pub kind: WritingKind,
    /// Of a new text.
    pub text: String,
    /// Of a new pattern.
    pub pattern: PatternKind,
    /// File of a new image.
    pub image: Option<String>,
    /// Sizes that a person chose; of the others what is usual.
    pub sizes_mm: BTreeMap<WritingKind, f64>,
    /// Of a new annotation, display-referred.
    pub colour: [f32; 3],
    /// Of a new annotation, display-referred.
    pub halo: Option<[f32; 3]>,
    /// Text of a new label.
    pub label: String,
    /// Depth of a new cutaway, if a person chose it.
    pub depth_mm: Option<f64>,
    /// Width of a new cutaway's rim, if a person chose it.
    pub rim_mm: Option<f64>,
    /// Whether a new cutaway leaves selected matter standing.
    pub spare_selection: bool,
}

impl Default for Writing {
    fn default() -> Self {
        Self {
            places: BTreeMap::new(),
            picked: None,
            extent_mm: 100.0,
            kind: WritingKind::Text,
            text: "Text".into(),
            pattern: PatternKind::Lines,
            image: None,
            sizes_mm: BTreeMap::new(),
            colour: Annotation::INK,
            halo: Some(Annotation::PAPER),
            label: "Label".into(),
            depth_mm: None,
            rim_mm: None,
            spare_selection: true,
        }
    }
}

impl Writing {
    /// Size of a new annotation, mm: of letters their height, of all others their width.
    pub fn size_mm(&self) -> f64 {
        let usual = || round_length(self.extent_mm * if self.kind.has_letters() { 0.03 } else { 0.15 });
        self.sizes_mm.get(&self.kind).copied().unwrap_or_else(usual)
    }

    /// Depth of a new cutaway, mm.
    pub fn depth_mm(&self) -> f64 {
        self.depth_mm.unwrap_or_else(|| round_length(self.extent_mm * 0.15))
    }

    /// Width of a new cutaway's rim, mm.
    pub fn rim_mm(&self) -> f64 {
        self.rim_mm.unwrap_or_else(|| round_length(self.extent_mm * 0.006))
    }

    /// A new annotation, but for its place.
    pub fn annotation(&self) -> AnnotationChange {
        let size = self.size_mm();
        let content = match self.kind {
            WritingKind::Text => Content::Text { text: self.text.clone(), bend_mm: 0.0, align: Align::Centre },
            WritingKind::Arrow => Content::Arrow { thickness: 0.08 },
            WritingKind::Ruler => Content::Ruler { to: [0.0; 3], tick_mm: None },
            WritingKind::Pattern => Content::Pattern {
                kind: self.pattern,
                aspect: 1.0,
                spacing_mm: size / 10.0,
                line_mm: size / 30.0,
                angle_deg: 0.0,
            },
            WritingKind::Image => Content::Image { path: self.image.clone().unwrap_or_default(), png: None },
        };
        AnnotationChange {
            content: Some(content),
            size_mm: Some(size),
            colour: Some(self.colour),
            halo: self.halo,
            no_halo: self.halo.is_none(),
            ..AnnotationChange::default()
        }
    }

    /// A new cutaway, but for its place and its size.
    pub fn cutaway(&self) -> CutawayChange {
        CutawayChange {
            depth_mm: Some(self.depth_mm()),
            rim_mm: Some(self.rim_mm()),
            spare_selection: Some(self.spare_selection),
            ..CutawayChange::default()
        }
    }

    /// A new label, but for its place.
    pub fn label(&self) -> LabelChange {
        LabelChange { text: Some(self.label.clone()), ..LabelChange::default() }
    }

    /// What has its middle under the hand, of those that a tool works on, and where that is in the picture. What is hidden has not.
    pub fn under(&self, e: &PointerEvent, camera: &Camera, is_meant: fn(Written) -> bool) -> Option<(Written, DVec2)> {
        if e.view != ViewName::ThreeD {
            return None;
        }
        let shown = self.places.iter().filter(|(one, _)| is_meant(**one)).filter_map(|(one, place)| {
            let (px, depth) = camera.project(*place, e.size)?;
            let hidden = e.hit.is_some_and(|hit| depth > hit.depth_mm + BEHIND * hit.depth_mm.abs());
            (px.distance(e.px) <= NEAR_PX && !hidden).then_some((*one, px))
        });
        shown.min_by(|a, b| a.1.distance(e.px).total_cmp(&b.1.distance(e.px)))
    }
}
