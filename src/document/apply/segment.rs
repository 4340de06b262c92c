//! Commands on the table of segments.

use crate::document::Document;
use crate::document::apply::labels::import;
use crate::document::command::SegmentCommand;
use crate::document::error::DocumentError;
use crate::document::history::edit::Edit;
use crate::document::scene::check::check_segment;
use crate::document::state::State;
use crate::io;
use crate::volume::{Brick, BrickIndex, Changes, FieldKind, Segment, SourceError};
use rayon::prelude::*;
use serde_json::{Value, json};

impl Document {
    pub(crate) fn segment(&mut self, command: SegmentCommand, edit: &mut Edit) -> Result<Value, DocumentError> {
        let watch = self.watch.clone();
        let state = self.open_mut()?;
        match command {
            SegmentCommand::Import { path, component, frame } => {
                edit.name("Import segments");
                let opened = io::open(&path)?;
                let other = opened.source(component, frame, &|x| watch.go_on(x * 0.3))?;
                let named = opened.labels_of(component);
                let imported = import(state, other.as_ref(), &named, &|x| watch.go_on(0.3 + x * 0.7))?;
                state.scene.segments = imported.segments;
                edit.swap(state, FieldKind::Labels, imported.changes)?;
                let mut answer = imported.answer;
                let left_out = opened.left_out(component).into_iter().collect();
                answer["warnings"] = json!([opened.warnings, left_out, imported.warnings].concat());
                Ok(answer)
            }
            SegmentCommand::Set { id, name, colour, visible, locked } => {
                let wanted = Segment::new(id);
                check_segment(&Segment { colour: colour.unwrap_or(wanted.colour), ..wanted })?;
                let known = state.scene.segments.get(id).map(|s| s.name.clone());
                edit.name(match (&known, &name) {
                    (None, _) => format!("Add segment {id}"),
                    (Some(old), Some(new)) if old != new => format!("Rename segment {old}"),
                    (Some(old), _) => format!("Change segment {old}"),
                });
                state.scene.segments.ensure(id);
                let segment = state.scene.segments.get_mut(id).ok_or(DocumentError::NothingOpen)?;
                segment.name = name.unwrap_or_else(|| segment.name.clone());
                segment.colour = colour.unwrap_or(segment.colour);
                segment.visible = visible.unwrap_or(segment.visible);
                segment.locked = locked.unwrap_or(segment.locked);
                Ok(json!({ "segment": segment }))
            }
            SegmentCommand::Remove { id } => {
                let Some(segment) = state.scene.segments.get(id) else {
                    return Err(DocumentError::no_segment("id", id, &state.scene.segments));
                };
                edit.name(format!("Remove segment {}", segment.name));
                state.scene.segments.0.retain(|s| s.id != id);
                let changes = without_label(state, id)?;
                edit.swap(state, FieldKind::Labels, changes)?;
                Ok(json!({ "removed": id }))
            }
        }
    }
}

/// The edited bricks that hold a label, with 0 in its place.
fn without_label(state: &State, id: u16) -> Result<Changes, SourceError> {
    let bytes = state.labels.format().bytes();
    let gone = id.to_le_bytes();
    let edits: Vec<(BrickIndex, &Brick)> = state.labels.edits().into_iter().collect();
    let changed = edits.into_par_iter().filter_map(|(index, brick)| {
        let mut texels = brick.to_texels(bytes);
        let mut found = false;
        for texel in texels.chunks_exact_mut(bytes).filter(|t| **t == gone) {
            texel.fill(0);
            found = true;
        }
        found.then(|| (index, Some(Brick::from_texels(texels, bytes))))
    });
    Ok(changed.collect())
}
