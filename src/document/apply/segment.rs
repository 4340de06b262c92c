//! Commands on segments, as far as they change labels: bringing them in from a file, and taking one out, in a volume and in all sub-volumes
//! of it.

use crate::document::Document;
use crate::document::apply::labels::import;
use crate::document::command::SegmentCommand;
use crate::document::command::answers::{ImportedSegmentsSaid, Said};
use crate::document::error::DocumentError;
use crate::document::history::edit::Edit;
use crate::document::subject::Subject;
use crate::io;
use crate::volume::{Brick, BrickKey, Changes, FieldKey, FieldKind, SourceError};
use rayon::prelude::*;

impl Document {
    pub(crate) fn segment(
        &mut self,
        command: &SegmentCommand,
        said: Said,
        edit: &mut Edit,
    ) -> Result<Said, DocumentError> {
        let watch = self.watch.clone();
        let state = self.open_mut()?;
        state.at(command.volume())?;
        match command {
            SegmentCommand::Set { .. } | SegmentCommand::ShowOnly { .. } => Ok(said),
            SegmentCommand::Remove { id, volume } => {
                // Sub-volumes have the segments of what they are cut out of.
                let root = state.scene.root_of(state.at(*volume)?.id);
                let volumes = state.with_all_inside(Some(root))?;
                for &volume in &volumes {
                    let changes = without_label(&state.at(Some(volume))?, *id)?;
                    edit.swap_among(state, FieldKey::new(volume, FieldKind::Labels), changes, &volumes)?;
                }
                Ok(said)
            }
            SegmentCommand::Import { path, component, frame, volume } => {
                let opened = io::open(path)?;
                let other = opened.source(*component, *frame, &|x| watch.proceed(x * 0.3))?;
                edit.reads(&opened.files, &|| watch.proceed(0.3))?;
                let named = opened.labels_of(*component);
                let volumes = state.with_all_inside(*volume)?;
                let (mut labels, mut warnings) = (None, Vec::new());
                for (n, id) in volumes.iter().enumerate() {
                    let proceed = |x: f32| watch.proceed(0.3 + 0.7 * (n as f32 + x) / volumes.len() as f32);
                    let imported = match import(&state.at(Some(*id))?, other.as_ref(), &named, &proceed) {
                        Ok(imported) => imported,
                        // A sub-volume beside what the file holds has nothing of it.
                        Err(DocumentError::Elsewhere { .. }) if n > 0 => continue,
                        Err(error) => return Err(error),
                    };
                    if let Some(segments) = state.scene.segments_mut(*id) {
                        *segments = imported.segments;
                    }
                    edit.swap_among(state, FieldKey::new(*id, FieldKind::Labels), imported.changes, &volumes)?;
                    if n == 0 {
                        (labels, warnings) = (Some(imported.said), imported.warnings);
                    }
                }
                let left_out = opened.left_out(*component).into_iter().collect();
                let warnings = [opened.warnings, left_out, warnings].concat();
                let labels = labels.ok_or(DocumentError::NoVolume)?;
                Ok(ImportedSegmentsSaid { labels, warnings }.into())
            }
        }
    }
}

/// The bricks that hold a label, with 0 in its place.
fn without_label(subject: &Subject<'_>, id: u16) -> Result<Changes, SourceError> {
    let bytes = subject.labels.format().bytes();
    let gone = id.to_le_bytes();
    let changed = subject.labels.present().into_par_iter().map(|index| {
        let mut texels = subject.labels.brick(BrickKey { level: 0, index })?.to_texels(bytes);
        let mut found = false;
        for texel in texels.chunks_exact_mut(bytes).filter(|t| **t == gone) {
            texel.fill(0);
            found = true;
        }
        Ok(found.then(|| (index, Some(Brick::from_texels(texels, bytes)))))
    });
    Ok(changed.collect::<Result<Vec<_>, SourceError>>()?.into_iter().flatten().collect())
}
