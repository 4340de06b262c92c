//! Annotations and cutaways in pictures and answers: what is told of how they lie, and what a frame shows of them.

use crate::document::Document;
use crate::document::command::answers::{
    AnnotationSaid, AnnotationsSaid, CutawayMeshSaid, CutawaySaid, CutawaysSaid, GridSaid, Said,
};
use crate::document::error::DocumentError;
use crate::document::live::spots::why;
use crate::document::scene::annotations::AnnotationId;
use crate::document::scene::cutaways::CutawayId;
use crate::gpu::Layers;

impl Document {
    /// What `annotation.add` and `annotation.set` answer: also how the grid lies. An annotation that cannot be drawn is refused.
    pub(crate) fn annotated(&mut self, said: Said) -> Result<Said, DocumentError> {
        match said {
            Said::Annotation(said) => {
                let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
                let lay = self.laid.get(state, &mut self.graphics, said.id, true)?;
                Ok(AnnotationSaid { grid: Some(lay.said.clone()), ..*said }.into())
            }
            other => Ok(other),
        }
    }

    /// What `cutaway.add` and `cutaway.set` answer: also how its mesh is. One that cannot be cut is refused.
    pub(crate) fn opened(&mut self, said: Said) -> Result<Said, DocumentError> {
        match said {
            Said::Cutaway(said) => {
                let mesh = Some(self.cutaway_mesh(said.id, false)?);
                Ok(CutawaySaid { mesh, ..*said }.into())
            }
            other => Ok(other),
        }
    }

    pub(crate) fn ask_annotations(
        &mut self,
        id: Option<AnnotationId>,
        vertices: bool,
    ) -> Result<AnnotationsSaid, DocumentError> {
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        let all = &state.scene.annotations;
        let ids: Vec<AnnotationId> = match id {
            Some(id) => all.get(id).map(|_| vec![id])?,
            None => all.all.keys().copied().collect(),
        };
        let mut annotations = Vec::new();
        for id in ids {
            let annotation = all.get(id)?.clone();
            let (grid, not_shown) = match self.laid.get(state, &mut self.graphics, id, true) {
                Ok(lay) => {
                    let points = || lay.grid.points.iter().map(|p| p.map(|p| p.to_array())).collect();
                    (Some(GridSaid { vertices: vertices.then(points), ..lay.said.clone() }), None)
                }
                // Those that can be told of are told of.
                Err(error) => (None, Some(why(error)?)),
            };
            annotations.push(AnnotationSaid { id, annotation, grid, not_shown });
        }
        Ok(AnnotationsSaid { annotations })
    }

    pub(crate) fn ask_cutaways(&mut self, id: Option<CutawayId>, mesh: bool) -> Result<CutawaysSaid, DocumentError> {
        let all = self.open()?.scene.cutaways.clone();
        let ids: Vec<CutawayId> = match id {
            Some(id) => all.get(id).map(|_| vec![id])?,
            None => all.all.keys().copied().collect(),
        };
        let mut cutaways = Vec::new();
        for id in ids {
            let cutaway = all.get(id)?.clone();
            let (mesh, not_shown) = match self.cutaway_mesh(id, mesh) {
                Ok(mesh) => (Some(mesh), None),
                Err(error) => (None, Some(why(error)?)),
            };
            cutaways.push(CutawaySaid { id, cutaway, mesh, not_shown });
        }
        Ok(CutawaysSaid { cutaways })
    }

    fn cutaway_mesh(&mut self, id: CutawayId, whole: bool) -> Result<CutawayMeshSaid, DocumentError> {
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        let opened = self.windows.get(state, &mut self.graphics, id, true)?;
        let (corners, triangles) = (opened.window.corners(), opened.window.triangles());
        let at = |i: u32| corners[i as usize] - opened.origin;
        let volume = triangles.iter().map(|[a, b, c]| at(*a).dot(at(*b).cross(at(*c)))).sum::<f64>() / 6.0;
        Ok(CutawayMeshSaid {
            counts: [corners.len(), triangles.len()],
            volume_mm3: volume,
            remarks: opened.remarks.clone(),
            corners: whole.then(|| corners.iter().map(|c| c.to_array()).collect()),
            triangles: whole.then(|| triangles.to_vec()),
        })
    }

    /// What a picture shows besides bodies: windows, and if it is `dressed` what lies on surfaces. `at_last`: as it is wanted, whatever
    /// that costs.
    pub(crate) fn lay_out(&mut self, layers: &mut Layers, dressed: bool, at_last: bool) {
        let Some(state) = &self.state else { return };
        if state.scene.annotations.all.is_empty() && state.scene.cutaways.all.is_empty() {
            return;
        }
        if dressed {
            layers.decals = self.laid.decals(state, &mut self.graphics, at_last);
        }
        let poses = self.motion.poses();
        self.windows.cut(state, &mut self.graphics, poses, layers, (dressed, at_last));
    }

    /// Finds what pictures of a moment ago showed as it was quickly found; for a moment in which there is nothing else to do. Answers
    /// whether a picture would now be another one.
    pub fn settle_layers(&mut self) -> bool {
        let Some(state) = &self.state else { return false };
        if self.running.is_some() || !(self.laid.is_behind(state) || self.windows.is_behind(state)) {
            return false;
        }
        self.lay_out(&mut Layers::default(), true, true);
        self.revision += 1;
        true
    }
}
