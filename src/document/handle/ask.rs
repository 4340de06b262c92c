//! Questions; they change nothing.

use super::frame::WHOLE;
use super::place::check_size;
use super::view::checked;
use super::{Document, DocumentError, PastOf, Question, State};
use crate::math::DVec2;
use crate::volume::{BRICK, BrickKey, FieldKind, SourceError};
use rayon::prelude::*;
use serde_json::{Value, json};
use std::collections::BTreeMap;

impl Document {
    pub(in crate::document) fn ask(&mut self, question: Question) -> Result<Value, DocumentError> {
        match question {
            Question::Volume {} => Ok(volume(self.open()?)),
            Question::Scene {} => Ok(json!({ "scene": self.open()?.scene })),
            Question::Parts {} => {
                let explosion = &self.open()?.scene.explosion;
                Ok(json!({ "degree": explosion.degree, "parts": explosion.parts }))
            }
            Question::Voxel { at } => {
                let world = self.resolve(at)?.map(|sample| sample.position);
                world.map_or(Ok(json!({ "inside": false })), |world| voxel(self.open()?, world))
            }
            Question::Field { field } => Ok(sums(self.open()?, field)?),
            Question::History {} => {
                let (memory, disk) = self.history.bytes();
                let past = |of| {
                    let (back, forward) = self.state.as_ref().map_or((0, 0), |s| s.past.counts(Some(of)));
                    json!({ "back": back, "forward": forward })
                };
                Ok(json!({
                    "undo": self.history.undo_names().rev().collect::<Vec<_>>(),
                    "redo": self.history.redo_names().collect::<Vec<_>>(),
                    "memory": memory,
                    "disk": disk,
                    "budget": self.history.budget_bytes(),
                    "views": past(PastOf::Views),
                    "looks": past(PastOf::Looks),
                }))
            }
            Question::Pick { px, size } => {
                let Some(hit) = self.pick(DVec2::from_array(px), size)? else { return Ok(json!({ "hit": null })) };
                let state = self.open()?;
                let index = state.grid().index_from_world().transform_point3(hit.rest);
                Ok(json!({ "hit": {
                    "mm": hit.world.to_array(),
                    "rest_mm": hit.rest.to_array(),
                    "index": index.to_array(),
                    "part": state.part_at(hit.body, hit.rest)?,
                    "selection": hit.body == WHOLE && !state.selection.is_blank(),
                    "depth_mm": hit.depth_mm,
                } }))
            }
            Question::Visibility { camera, size } => {
                let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
                let views = &state.scene.views;
                let camera = checked(camera.unwrap_or(views.camera), &state.grid().world_bounds())?;
                let size = check_size(size.unwrap_or(views.size))?;
                let frame = state.parted_frame(&state.scene.explosion, &camera, size);
                let seen = self.graphics.visibility(state, &frame)?;
                let hidden: Vec<Value> =
                    seen.hidden_by.iter().map(|(id, px)| json!({ "part": id, "pixels": px })).collect();
                Ok(json!({
                    "share": seen.share(),
                    "selected": seen.selected,
                    "visible": seen.visible,
                    "hidden_by": hidden,
                }))
            }
        }
    }
}

pub(in crate::document) fn volume(state: &State) -> Value {
    let grid = state.grid();
    let m = grid.world_from_index;
    let rows: [[f64; 4]; 3] = std::array::from_fn(|r| {
        let row = m.matrix3.row(r);
        [row.x, row.y, row.z, m.translation[r]]
    });
    let s = &state.statistics;
    let map = state.density.map();
    json!({
        "name": state.source.name(),
        "dims": grid.dims,
        "voxel_type": state.source.voxel_type(),
        "world_from_index": rows,
        "spacing_mm": grid.spacing().to_array(),
        "min": s.min, "max": s.max, "sum": s.sum, "nan_count": s.nan_count,
        "texels": state.density.format(),
        "half_step": map.half_step(),
        "levels": state.density.level_count(),
    })
}

fn voxel(state: &State, world: crate::math::DVec3) -> Result<Value, DocumentError> {
    let index = state.grid().index_from_world().transform_point3(world);
    let Some(voxel) = state.grid().voxel_at(index) else {
        return Ok(json!({ "inside": false, "mm": world.to_array(), "index": index.to_array() }));
    };
    let texel = state.colour.texel(voxel)?;
    let label = state.labels.value(voxel)? as u16;
    Ok(json!({
        "inside": true,
        "mm": world.to_array(),
        "index": index.to_array(),
        "voxel": voxel,
        "density": state.density.map().decode(state.density.texel(voxel)?),
        "colour": texel.map(|c| f32::from(c) / 255.0),
        "selection": state.selection.value(voxel)?,
        "label": label,
        "segment": state.scene.segments.get(label).map(|s| s.name.clone()),
    }))
}

#[derive(Default)]
struct Sums {
    sum: f64,
    nonzero: u64,
    max: Option<f64>,
    labels: BTreeMap<u16, u64>,
}

impl Sums {
    fn join(mut self, other: Self) -> Self {
        self.sum += other.sum;
        self.nonzero += other.nonzero;
        self.max = match (self.max, other.max) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        };
        for (label, count) in other.labels {
            *self.labels.entry(label).or_default() += count;
        }
        self
    }
}

/// Sum, count of non-zero and largest value; colour counts by its alpha. Brick by brick in order, so that the answer is the
/// same on every run.
fn sums(state: &State, kind: FieldKind) -> Result<Value, SourceError> {
    let field = state.field(kind);
    let bytes = field.format().bytes();
    let one = |index| -> Result<Sums, SourceError> {
        let mut sums = Sums::default();
        let brick = field.brick(BrickKey { level: 0, index })?;
        let valid = field.valid(0, index);
        let texels = brick.to_texels(bytes);
        for z in 0..valid[2] {
            for y in 0..valid[1] {
                let start = (BRICK * (y + BRICK * z)) as usize * bytes;
                for texel in texels[start..start + valid[0] as usize * bytes].chunks_exact(bytes) {
                    let mut padded = [0; 4];
                    padded[..bytes].copy_from_slice(texel);
                    let value = match kind {
                        FieldKind::Density => field.map().decode(padded),
                        FieldKind::Colour => f64::from(padded[3]) / 255.0,
                        FieldKind::Selection => f64::from(padded[0]) / 255.0,
                        FieldKind::Labels => f64::from(u16::from_le_bytes([padded[0], padded[1]])),
                    };
                    if !value.is_finite() {
                        continue;
                    }
                    sums.sum += value;
                    sums.nonzero += u64::from(value != 0.0);
                    sums.max = Some(sums.max.map_or(value, |m: f64| m.max(value)));
                    if kind == FieldKind::Labels && value != 0.0 {
                        *sums.labels.entry(value as u16).or_default() += 1;
                    }
                }
            }
        }
        Ok(sums)
    };
    let bricks = field.brick_indices(0).into_par_iter().map(one).collect::<Result<Vec<_>, _>>()?;
    let sums = bricks.into_iter().fold(Sums::default(), Sums::join);
    let mut answer = json!({
        "field": kind.name(),
        "sum": sums.sum,
        "nonzero": sums.nonzero,
        "max": sums.max,
        "edited_bricks": field.edits().len(),
    });
    if kind == FieldKind::Labels {
        answer["voxels_by_label"] = json!(sums.labels);
    }
    Ok(answer)
}
