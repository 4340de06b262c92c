//! Annotations: pictures that lie on an iso-surface of a volume, as a person decided them ("Direct Volume Editing", 2008, section 5).
//!
//! Owns what they show, where they are centred and how their grids are made; the grids themselves are found from the voxels and belong to
//! `document::live`. Places are continuous indices of the volume, so that an annotation goes with its volume wherever that is put.

use crate::document::error::DocumentError;
use crate::document::scene::check::{checked_colour, finite, positive};
use crate::volume::VolumeId;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Vertices of a grid along an edge at most.
pub(crate) const MOST_VERTICES: u32 = 257;
/// Annotations of a document at most: numbers that are named by hand.
const MOST_EVER: u32 = 1 << 24;
/// Characters of a text.
const MOST_CHARACTERS: usize = 2_000;
/// Bytes of an image's file.
pub(crate) const MOST_IMAGE_BYTES: usize = 16 << 20;

/// Name of an annotation within its document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
pub struct AnnotationId(pub u32);

/// The annotations of a document.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Annotations {
    /// The number that the next one gets.
    pub next: u32,
    /// By number.
    pub all: BTreeMap<AnnotationId, Annotation>,
}

/// A place on a surface of a volume and a direction there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Anchor {
    /// Whose surface it is on; of a sub-volume the one that it is cut out of.
    pub volume: VolumeId,
    /// The centre, continuous index of the volume.
    pub centre: [f64; 3],
    /// A second place, in whose direction from the centre the grid's first axis goes, continuous index of the volume.
    pub toward: [f64; 3],
    /// The value of the surface.
    pub value: f64,
    /// Whether it is on selected matter, and stays with the selection when parts move.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub selected: bool,
}

/// Where the lines of a grid go (section 5, "vector lookup").
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Directions {
    /// On from where the centre's direction goes (equation 5).
    #[default]
    Picked,
    /// Along a vector field: the volumes of its x, y and z in the world.
    Field([VolumeId; 3]),
    /// Where the surface bends most.
    MostCurved,
    /// Where it bends least.
    LeastCurved,
}

/// How a grid is made.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Tracing {
    /// Distance of neighbouring vertices, mm; left out: a voxel, or what [`MOST_VERTICES`] allow.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_mm: Option<f64>,
    /// How near a vertex comes to the surface, in voxels.
    pub tolerance: f64,
    /// Where its lines go.
    #[serde(default)]
    pub directions: Directions,
    /// Whether it is relaxed on the surface to be as little distorted as that allows.
    pub relaxed: bool,
}

impl Default for Tracing {
    fn default() -> Self {
        Self { step_mm: None, tolerance: 0.01, directions: Directions::Picked, relaxed: true }
    }
}

/// Where the lines of a text begin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Align {
    /// At the side where reading begins.
    Start,
    /// In the middle.
    #[default]
    Centre,
    /// At the other side.
    End,
}

/// What fills a rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PatternKind {
    /// Parallel lines.
    Lines,
    /// Two sets of them.
    Cross,
    /// Dots.
    Dots,
    /// Squares by turns.
    Checker,
    /// A line along the border alone.
    Frame,
}

/// What an annotation shows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Content {
    /// A text in any script.
    Text {
        /// Lines end with a line feed.
        text: String,
        /// How far the middle of the baseline lies above its ends, mm: an arch; below 0 a bowl.
        #[serde(default)]
        bend_mm: f64,
        /// Where shorter lines begin.
        #[serde(default)]
        align: Align,
    },
    /// A picture with alpha from a PNG file.
    Image {
        /// What it was read from.
        path: String,
        /// The file's bytes in base 64; read when the annotation is made.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(with = "Option<String>")]
        png: Option<Arc<str>>,
    },
    /// Hatching.
    Pattern {
        /// Of what.
        kind: PatternKind,
        /// Height over width of the rectangle.
        aspect: f64,
        /// Distance of its lines or dots, mm.
        spacing_mm: f64,
        /// Width of its lines, diameter of its dots, mm.
        line_mm: f64,
        /// Turn of its lines, degrees.
        #[serde(default)]
        angle_deg: f64,
    },
    /// An arrow along the first axis.
    Arrow {
        /// Width of the shaft over its length.
        thickness: f64,
    },
    /// The shortest way on the surface from the centre to a place, with its length.
    Ruler {
        /// Continuous index of the volume; of a command `to` beside the content says it.
        #[serde(default)]
        to: [f64; 3],
        /// Distance of its ticks, mm; left out: a round one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        tick_mm: Option<f64>,
    },
}

impl Content {
    /// What it is called where it has no name.
    pub(crate) fn called(&self) -> String {
        match self {
            Self::Text { text, .. } => text.lines().next().unwrap_or_default().chars().take(40).collect(),
            Self::Image { path, .. } => path.rsplit(['/', '\\']).next().unwrap_or("Image").to_owned(),
            Self::Pattern { .. } => "Pattern".into(),
            Self::Arrow { .. } => "Arrow".into(),
            Self::Ruler { .. } => "Ruler".into(),
        }
    }
}

/// A picture on a surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Annotation {
    /// What it is called.
    pub name: String,
    /// What it shows.
    pub content: Content,
    /// Where.
    pub anchor: Anchor,
    /// Of a text and of a ruler the height of its letters, of all others their width; mm.
    pub size_mm: f64,
    /// How its grid is made.
    #[serde(default)]
    pub tracing: Tracing,
    /// Of shapes, display-referred.
    pub colour: [f32; 3],
    /// Display-referred; `None`: shapes have no halo.
    #[serde(default)]
    pub halo: Option<[f32; 3]>,
    /// 0..1.
    pub opacity: f32,
    /// Whether it is lit as the surface is.
    pub lit: bool,
    /// Whether pictures show it.
    pub visible: bool,
}

impl Anchor {
    /// # Errors
    /// The first field that is wrong.
    pub(crate) fn check(&self) -> Result<(), DocumentError> {
        self.centre.iter().try_for_each(|v| finite("centre", *v).map(drop))?;
        self.toward.iter().try_for_each(|v| finite("toward", *v).map(drop))?;
        finite("value", self.value)?;
        if self.centre == self.toward {
            let found = format!("{:?}, which is the centre", self.toward);
            return Err(DocumentError::invalid("toward", found, "another place than the centre"));
        }
        Ok(())
    }
}

impl Tracing {
    fn check(&self) -> Result<(), DocumentError> {
        if let Some(step) = self.step_mm {
            positive("step_mm", step)?;
        }
        if !(1e-4..=0.5).contains(&self.tolerance) {
            return Err(DocumentError::invalid("tolerance", self.tolerance, "0.0001 to 0.5 voxels"));
        }
        Ok(())
    }
}

impl Content {
    fn check(&self) -> Result<(), DocumentError> {
        match self {
            Self::Text { text, bend_mm, .. } => {
                let count = text.chars().count();
                if count > MOST_CHARACTERS || text.trim().is_empty() {
                    let expected = format!("a text of 1 to {MOST_CHARACTERS} characters");
                    return Err(DocumentError::invalid("text", format!("{count} characters"), expected));
                }
                finite("bend_mm", *bend_mm).map(drop)
            }
            Self::Image { path, png } => match png {
                Some(png) if png.len() > MOST_IMAGE_BYTES / 3 * 4 + 4 => {
                    let found = format!("{path}, of {} MB", (png.len() / 4 * 3) >> 20);
                    Err(DocumentError::invalid(
                        "path",
                        found,
                        format!("a file of at most {} MB", MOST_IMAGE_BYTES >> 20),
                    ))
                }
                _ => Ok(()),
            },
            Self::Pattern { aspect, spacing_mm, line_mm, angle_deg, .. } => {
                positive("spacing_mm", *spacing_mm)?;
                positive("line_mm", *line_mm)?;
                finite("angle_deg", *angle_deg)?;
                match (0.01..=100.0).contains(aspect) {
                    true => Ok(()),
                    false => Err(DocumentError::invalid("aspect", aspect, "a height over a width, 0.01 to 100")),
                }
            }
            Self::Arrow { thickness } => match (0.005..=0.5).contains(thickness) {
                true => Ok(()),
                false => Err(DocumentError::invalid("thickness", thickness, "a share of the length, 0.005 to 0.5")),
            },
            Self::Ruler { to, tick_mm } => {
                to.iter().try_for_each(|v| finite("to", *v).map(drop))?;
                tick_mm.map_or(Ok(()), |tick| positive("tick_mm", tick).map(drop))
            }
        }
    }
}

impl Annotation {
    /// Letters of a new one: dark ones with a light halo are read on matter of any colour.
    pub const INK: [f32; 3] = [0.07, 0.08, 0.12];
    /// Their halo.
    pub const PAPER: [f32; 3] = [0.98, 0.98, 0.96];

    /// # Errors
    /// The first field that is wrong.
    pub(crate) fn check(&self) -> Result<(), DocumentError> {
        self.anchor.check()?;
        self.content.check()?;
        self.tracing.check()?;
        positive("size_mm", self.size_mm)?;
        checked_colour("colour", self.colour)?;
        self.halo.map_or(Ok(()), |halo| checked_colour("halo", halo).map(drop))?;
        match (0.0..=1.0).contains(&self.opacity) {
            true => Ok(()),
            false => Err(DocumentError::invalid("opacity", self.opacity, "0 to 1")),
        }
    }
}

impl Annotations {
    /// # Errors
    /// The first field that is wrong.
    pub(crate) fn check(&self) -> Result<(), DocumentError> {
        if self.next > MOST_EVER || self.all.keys().any(|id| id.0 >= self.next) {
            let expected = format!("a number above those of all annotations, at most {MOST_EVER}");
            return Err(DocumentError::invalid("next", self.next, expected));
        }
        self.all.iter().try_for_each(|(id, one)| one.check().map_err(|e| e.within(&format!("all.{}", id.0))))
    }

    /// # Errors
    /// If there is none of the name.
    pub(crate) fn get(&self, id: AnnotationId) -> Result<&Annotation, DocumentError> {
        self.all.get(&id).ok_or_else(|| {
            let known: Vec<_> = self.all.iter().map(|(id, one)| format!("{} ({})", id.0, one.name)).collect();
            let expected = match known.is_empty() {
                true => "an annotation, of which there is none; annotation.add makes one".to_owned(),
                false => format!("one of the annotations: {}", known.join(", ")),
            };
            DocumentError::invalid("id", id.0, expected)
        })
    }

    /// A new one.
    pub(crate) fn put(&mut self, one: Annotation) -> AnnotationId {
        let id = AnnotationId(self.next);
        self.next += 1;
        self.all.insert(id, one);
        id
    }
}
