//! Commands on segments, as far as they change labels: bringing them in from a file, and taking one out.

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
        let subject = state.at(command.volume())?;
        let labels = FieldKey::new(subject.id, FieldKind::Labels);
        match command {
            SegmentCommand::Set { .. } | SegmentCommand::ShowOnly { .. } => Ok(said),
            SegmentCommand::Remove { id, .. } => {
                let changes = without_label(&subject, *id)?;
                edit.swap(state, labels, changes)?;
                Ok(said)
            }
            SegmentCommand::Import { path, component, frame, .. } => {
                let opened = io::open(path)?;
                let other = opened.source(*component, *frame, &|x| watch.proceed(x * 0.3))?;
                edit.reads(&opened.files, &|| watch.proceed(0.3))?;
                let named = opened.labels_of(*component);
                let imported = import(&subject, other.as_ref(), &named, &|x| watch.proceed(0.3 + x * 0.7))?;
                if let Some(segments) = state.scene.segments_mut(labels.volume) {
                    *segments = imported.segments;
                }
                edit.swap(state, labels, imported.changes)?;
                let left_out = opened.left_out(*component).into_iter().collect();
                let warnings = [opened.warnings, left_out, imported.warnings].concat();
                Ok(ImportedSegmentsSaid { labels: imported.said, warnings }.into())
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
