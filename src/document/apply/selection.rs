//! Commands on the selection as a whole.

use crate::document::Document;
use crate::document::apply::selection_import::import;
use crate::document::command::SelectionCommand;
use crate::document::command::answers::{Said, SelectedSaid};
use crate::document::error::DocumentError;
use crate::document::history::edit::Edit;
use crate::document::scene::check::finite;
use crate::document::state::State;
use crate::document::subject::Subject;
use crate::io;
use crate::volume::{Brick, BrickIndex, BrickKey, Changes, FieldKey, FieldKind, VolumeId};
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
        let subject = state.at(command.volume())?;
        let id = subject.id;
        let (mut covered, mut warnings) = (None, None);
        let changes = match command {
            SelectionCommand::FromLabel { label, .. } => from_label(&subject, *label)?,
            SelectionCommand::Clear { .. } => Changes::new(),
            SelectionCommand::Set { .. } => return Ok(said),
            SelectionCommand::Import { path, threshold, soften_mm, .. } => {
                let (threshold, soften_mm) = (finite("threshold", *threshold)?, *soften_mm);
                let most = (subject.grid().spacing() * MAX_SOFTEN_VOXELS).min_element();
                if !(0.0..=most).contains(&soften_mm) {
                    return Err(DocumentError::invalid("soften_mm", soften_mm, format!("0 to {most} mm")));
                }
                let opened = io::open(path)?;
                let other = opened.source(0, 0, &|x| watch.proceed(x * 0.3))?;
                edit.reads(&opened.files, &|| watch.proceed(0.3))?;
                let imported =
                    import(&subject, other.as_ref(), threshold, soften_mm, &|x| watch.proceed(0.3 + x * 0.7))?;
                covered = Some(imported.covered);
                warnings = Some([opened.warnings, imported.warnings].concat());
                imported.changes
            }
        };
        replace(state, id, edit, changes)?;
        Ok(SelectedSaid { selected_bricks: state.at(Some(id))?.selection.edits().len(), covered, warnings }.into())
    }
}

/// Makes `changes` all that is selected.
fn replace(state: &mut State, id: VolumeId, edit: &mut Edit, mut changes: Changes) -> Result<(), DocumentError> {
    let given: std::collections::BTreeSet<BrickIndex> = changes.iter().map(|(index, _)| *index).collect();
    let selected = &state.at(Some(id))?.volume.selection;
    let gone = selected.present().into_iter().filter(|index| !given.contains(index));
    changes.extend(gone.map(|index| (index, selected.nothing())));
    Ok(edit.swap(state, FieldKey::new(id, FieldKind::Selection), changes)?)
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
