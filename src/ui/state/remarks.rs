//! What was said of how annotations and cutaways lie on their surfaces, until they are other ones.

use crate::document::answers::{AnnotationSaid, CutawaySaid};
use crate::document::{Annotation, AnnotationId, Cutaway, CutawayId, Scene};
use crate::interact::Written;
use std::collections::BTreeMap;

/// What is to be told of one.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Remark {
    /// In sentences.
    pub(crate) said: Vec<String>,
    /// A size at which an annotation would be stretched little, mm.
    pub(crate) fitting_mm: Option<f64>,
}

/// All of them, with what they were said of.
#[derive(Clone, Debug, Default)]
pub(crate) struct Remarks {
    annotations: BTreeMap<AnnotationId, (Annotation, Remark)>,
    cutaways: BTreeMap<CutawayId, (Cutaway, Remark)>,
}

impl Remarks {
    /// Another document is open.
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }

    pub(crate) fn of_annotation(&mut self, said: &AnnotationSaid) {
        let Some(grid) = &said.grid else { return };
        let remark = Remark { said: grid.remarks.clone(), fitting_mm: grid.fitting_mm };
        self.annotations.insert(said.id, (said.annotation.clone(), remark));
    }

    pub(crate) fn of_cutaway(&mut self, said: &CutawaySaid) {
        let Some(mesh) = &said.mesh else { return };
        let remark = Remark { said: mesh.remarks.clone(), fitting_mm: None };
        self.cutaways.insert(said.id, (said.cutaway.clone(), remark));
    }

    /// What holds of one as it is now.
    pub(crate) fn of(&self, one: Written, scene: &Scene) -> Option<&Remark> {
        let remark = match one {
            Written::Annotation(id) => {
                let (of, remark) = self.annotations.get(&id)?;
                // Another name or colour is no other place.
                let now = scene.annotations.all.get(&id)?;
                let same = now.anchor == of.anchor && now.content == of.content && now.size_mm == of.size_mm;
                same.then_some(remark)
            }
            Written::Cutaway(id) => {
                let (of, remark) = self.cutaways.get(&id)?;
                let now = scene.cutaways.all.get(&id)?;
                let same = now.anchor == of.anchor && now.outline == of.outline && now.depth_mm == of.depth_mm;
                same.then_some(remark)
            }
            Written::Label(_) => None,
        };
        remark.filter(|remark| !remark.said.is_empty())
    }
}
