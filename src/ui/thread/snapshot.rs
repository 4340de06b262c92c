//! What the window is told of the open document, and pictures that are tried before they are written.
//!
//! Reads the document as anybody could; keeps nothing.

use crate::document::{Command, Document, LabelAnchor, Named, RenderCommand};
use crate::interact::Written;
use crate::io::in_words;
use crate::math::DVec3;
use crate::ui::thread::session::OpenDocument;
use crate::volume::Histogram;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The open document as the window shows it, by its active volume; `None` without one. A histogram that is known is not copied again.
pub(super) fn open_document(
    document: &Document,
    known: Option<&Arc<Histogram>>,
    labels: Arc<Vec<LabelAnchor>>,
) -> Option<OpenDocument> {
    let written = written_places(document, &labels);
    let state = document.state()?;
    let subject = state.at(None).ok()?;
    // Of a sub-volume its own, once that is known.
    let own = subject.volume.density.known_measures();
    let (now, statistics) =
        own.map_or((&subject.histogram, subject.statistics), |own| (&own.histogram, own.statistics));
    let histogram = match known {
        Some(known) if **known == *now => known.clone(),
        _ => Arc::new(now.clone()),
    };
    Some(OpenDocument {
        opening: document.opening(),
        scene: Arc::new(subject.scene.clone()),
        poses: Arc::new(document.poses().clone()),
        grid: *subject.grid(),
        centres: state.subjects().map(|s| (s.id, s.volume.grid().world_bounds().centre())).collect(),
        boxes: Arc::new(state.box_corners()),
        written,
        labels,
        sample_bytes: state.subjects().map(|s| (s.id, s.volume.sample_bytes())).collect(),
        voxel_type: subject.source.voxel_type(),
        statistics,
        histogram,
    })
}

/// What the labels that are shown name. While a stroke runs as it was before: where a segment is deepest is sought in all of it.
pub(super) fn label_anchors(document: &mut Document, before: &Arc<Vec<LabelAnchor>>) -> Arc<Vec<LabelAnchor>> {
    if document.is_painting() {
        return before.clone();
    }
    // Without a document, or where labels cannot be read, there is nothing to show.
    let found = document.label_anchors().unwrap_or_default();
    if found == **before { before.clone() } else { Arc::new(found) }
}

fn written_places(document: &Document, labels: &[LabelAnchor]) -> BTreeMap<Written, DVec3> {
    let annotations = document.annotation_places().into_iter().map(|(id, place)| (Written::Annotation(id), place));
    let cutaways = document.cutaway_places().into_iter().map(|(id, place)| (Written::Cutaway(id), place));
    let labels = labels.iter().filter(|label| matches!(label.named, Named::Point { .. }));
    annotations.chain(cutaways).chain(labels.map(|label| (Written::Label(label.id), label.place))).collect()
}

/// Does the command that writes a picture, to a place of its own: size and eight-bit colours of what was written, or why not.
pub(super) fn sketch(document: &mut Document, asked: &RenderCommand) -> Result<([u32; 2], Vec<u8>), String> {
    let place = tempfile::tempdir().map_err(|error| in_words(&error))?;
    let file = place.path().join("sketch.png");
    let RenderCommand::Image { view, size, camera, transparent, background, supersample, .. } = asked.clone();
    let path = file.clone();
    let command = RenderCommand::Image { path, view, size, camera, transparent, background, supersample };
    document.apply(Command::Render(command)).map_err(|error| error.to_string())?;
    let image = image::open(&file).map_err(|error| error.to_string())?.into_rgba8();
    Ok((image.dimensions().into(), image.into_raw()))
}
