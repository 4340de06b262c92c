//! What the window is told of the open document, and pictures that are tried before they are written.
//!
//! Reads the document as anybody could; keeps nothing.

use crate::document::{Command, Document, RenderCommand};
use crate::io::in_words;
use crate::ui::thread::session::OpenDocument;
use crate::volume::Histogram;
use std::sync::Arc;

/// The open document as the window shows it, by its active volume; `None` without one. A histogram that is known is not copied again.
pub(super) fn open_document(document: &Document, known: Option<&Arc<Histogram>>) -> Option<OpenDocument> {
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
        sample_bytes: state.subjects().map(|s| (s.id, s.volume.sample_bytes())).collect(),
        voxel_type: subject.source.voxel_type(),
        statistics,
        histogram,
    })
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
