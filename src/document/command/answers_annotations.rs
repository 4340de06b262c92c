//! What commands on annotations, labels and cutaways and questions for them say.

#![allow(missing_docs)] // fields: what they are called is what they say

use crate::document::scene::annotations::{Annotation, AnnotationId};
use crate::document::scene::cutaways::{Cutaway, CutawayId};
use crate::document::scene::labels::{Label, LabelId, LabelStyle};
use serde::Serialize;

/// `annotation.add`, `annotation.set`, one of `ask.annotations`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AnnotationSaid {
    pub id: AnnotationId,
    #[serde(flatten)]
    pub annotation: Annotation,
    /// How its grid lies; left out where it was not asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<GridSaid>,
    /// Why no picture shows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_shown: Option<String>,
}

/// How a grid lies on its surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct GridSaid {
    pub columns: usize,
    pub rows: usize,
    /// Distance of its vertices on the surface that is wanted.
    pub step_mm: f64,
    /// Along its first axis and across.
    pub size_mm: [f64; 2],
    /// Of the centre, pointing to lower values.
    pub normal: [f64; 3],
    /// Vertices that the surface has no room for.
    pub trimmed: usize,
    /// E/4 − 1 of the symmetric Dirichlet energy E, area-weighted: 0 where nothing is distorted.
    pub excess: f64,
    /// Of its triangles the largest area over the wanted one and the least.
    pub area: [f64; 2],
    /// Triangles turned over.
    pub turned_over: usize,
    /// Whether it is relaxed.
    pub relaxed: bool,
    /// Of a ruler.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_mm: Option<f64>,
    /// Characters that no font has.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub missing: String,
    /// Of one that is stretched much: the size at which it would not be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fitting_mm: Option<f64>,
    /// What is to be told of it, in sentences.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<String>,
    /// Row by row, world mm at rest; `null` where it is trimmed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vertices: Option<Vec<Option<[f64; 3]>>>,
}

/// `ask.annotations`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AnnotationsSaid {
    pub annotations: Vec<AnnotationSaid>,
}

/// `annotation.remove`, `label.remove`, `cutaway.remove`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RemovedSaid {
    pub removed: u32,
}

/// `label.add`, `label.set`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LabelSaid {
    pub id: LabelId,
    #[serde(flatten)]
    pub label: Label,
}

/// `label.from_segments`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LabelledSaid {
    /// The new ones.
    pub labels: Vec<LabelSaid>,
}

/// `label.style`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LabelStyleSaid {
    pub style: LabelStyle,
}

/// Where a picture has a label.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlacedSaid {
    pub id: LabelId,
    pub text: String,
    /// What it names, pixels; `null` where that is outside of the picture or gone.
    pub anchor: Option<[f64; 2]>,
    /// Whether what it names can be seen.
    pub seen: bool,
    /// Left, top, width, height, pixels; `null` where it is not shown.
    pub rect: Option<[f64; 4]>,
    /// From what it names to the text, pixels.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub leader: Vec<[f64; 2]>,
    /// Its number in the key, where pictures show numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub number: Option<usize>,
}

/// `ask.labels`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlacedLabelsSaid {
    pub style: LabelStyle,
    pub labels: Vec<PlacedSaid>,
    /// Labels for which the picture has no room.
    pub left_out: Vec<LabelId>,
}

/// `cutaway.add`, `cutaway.set`, one of `ask.cutaways`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CutawaySaid {
    pub id: CutawayId,
    #[serde(flatten)]
    pub cutaway: Cutaway,
    /// Its mesh; left out where it was not asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<CutawayMeshSaid>,
    /// Why no picture shows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_shown: Option<String>,
}

/// The closed mesh of a cutaway.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CutawayMeshSaid {
    /// Of how many corners and triangles.
    pub counts: [usize; 2],
    pub volume_mm3: f64,
    /// What is to be told of it, in sentences.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<String>,
    /// World mm at rest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corners: Option<Vec<[f64; 3]>>,
    /// Three corners each, counter-clockwise seen from outside.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub triangles: Option<Vec<[u32; 3]>>,
}

/// `ask.cutaways`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CutawaysSaid {
    pub cutaways: Vec<CutawaySaid>,
}
