//! Commands on the selection as a whole: of a volume and of all sub-volumes in it, each at its own resolution.

use crate::document::Document;
use crate::document::apply::selection_import::import;
use crate::document::command::SelectionCommand;
use crate::document::command::answers::{Said, SelectedSaid};
use crate::document::error::DocumentError;
use crate::document::history::edit::Edit;
use crate::document::scene::check::finite;
use crate::document::subject::Subject;
use crate::io;
use crate::volume::{Brick, BrickKey, Changes, FieldKey, FieldKind};
use rayon::prelude::*;

/// The widest soft border, in voxels: blocks and what is around them have to fit into memory.
const MAX_SOFTEN_VOXELS: f64 = 128.0;

impl Document {
    pub(crate) fn selection(
        &mut self,
        command: &SelectionCommand,
        said: Said,
        edit: &mut Edit,
    ) -> Result<Said, DocumentError> {
        let watch = self.watch.clone();
        let state = self.open_mut()?;
        if matches!(command, SelectionCommand::Set { .. }) {
            state.at(command.volume())?;
            return Ok(said);
        }
        let volumes = state.with_all_inside(command.volume())?;
        let (mut covered, mut warnings) = (None, None);
        let mut changes = Vec::new();
        match command {
            SelectionCommand::FromLabel { label, .. } => {
                for &id in &volumes {
                    changes.push((id, from_label(&state.at(Some(id))?, *label)?));
                }
            }
            SelectionCommand::Clear { .. } => changes.extend(volumes.iter().map(|id| (*id, Changes::new()))),
            SelectionCommand::Set { .. } => {}
            SelectionCommand::Import { path, threshold, soften_mm, .. } => {
                let (threshold, soften_mm) = (finite("threshold", *threshold)?, *soften_mm);
                let subject = state.at(volumes.first().copied())?;
                let most = (subject.grid().spacing() * MAX_SOFTEN_VOXELS).min_element();
                if !(0.0..=most).contains(&soften_mm) {
                    return Err(DocumentError::invalid("soften_mm", soften_mm, format!("0 to {most} mm")));
                }
                let opened = io::open(path)?;
                let other = opened.source(0, 0, &|x| watch.proceed(x * 0.3))?;
                edit.reads(&opened.files, &|| watch.proceed(0.3))?;
                for (n, id) in volumes.iter().enumerate() {
                    let subject = state.at(Some(*id))?;
                    let proceed = |x: f32| watch.proceed(0.3 + 0.7 * (n as f32 + x) / volumes.len() as f32);
                    // Softer than its samples allow it need not be, which are finer.
                    let most = (subject.grid().spacing() * MAX_SOFTEN_VOXELS).min_element();
                    match import(&subject, other.as_ref(), threshold, soften_mm.min(most), &proceed) {
                        Ok(imported) => {
                            if n == 0 {
                                covered = Some(imported.covered);
                                warnings = Some([opened.warnings.clone(), imported.warnings].concat());
                            }
                            changes.push((*id, imported.changes));
                        }
                        // A sub-volume beside what the file holds has nothing of it.
                        Err(DocumentError::Elsewhere { .. }) if n > 0 => changes.push((*id, Changes::new())),
                        Err(error) => return Err(error),
                    }
                }
            }
        }
        let mut selected_bricks = 0;
        for (id, changes) in changes {
            let changes = state.at(Some(id))?.volume.selection.replaced_by(changes);
            edit.swap_among(state, FieldKey::new(id, FieldKind::Selection), changes, &volumes)?;
            selected_bricks += state.at(Some(id))?.volume.selection.edits().len();
        }
        Ok(SelectedSaid { selected_bricks, covered, warnings }.into())
    }
}

fn from_label(subject: &Subject<'_>, label: u16) -> Result<Changes, DocumentError> {
    if label == 0 || subject.segments().get(label).is_none() {
        return Err(DocumentError::no_segment("label", label, subject.segments()));
    }
    let wanted = label.to_le_bytes();
    let bytes = subject.labels.format().bytes();
    let selected = subject.labels.present().into_par_iter().map(|index| {
        let brick = subject.labels.brick(BrickKey { level: 0, index })?;
        let texels = brick.to_texels(bytes).chunks_exact(bytes).map(|t| if t == wanted { 255 } else { 0 }).collect();
        Ok((index, Some(Brick::from_texels(texels, 1))))
    });
    selected.collect()
}
