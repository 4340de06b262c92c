//! Fields of a volume to files: voxels on their grid, or the closed surface of what is selected or labelled; the name's ending says which.

use crate::document::command::answers::{ExportedMeshSaid, ExportedSaid, Said};
use crate::document::error::DocumentError;
use crate::document::frame::SELECTION_COLOUR;
use crate::document::state::State;
use crate::document::subject::Subject;
use crate::document::watch::Watch;
use crate::io::{self, Compression};
use crate::mesh::{label_surface, selection_surface};
use crate::volume::{FieldKind, VolumeId};
use std::path::Path;

/// What is said of a field of a volume where some of what is seen in its place is edited in sub-volumes, which have files of their own.
///
/// # Errors
/// If there is no such volume.
pub(super) fn beside_the_file(
    state: &State,
    volume: VolumeId,
    field: FieldKind,
) -> Result<Option<String>, DocumentError> {
    let family = state.family(volume)?;
    let edited = family.subjects(state).skip(1).filter(|(_, subject)| !subject.field(field).edits().is_empty());
    let names: Vec<String> = edited.map(|(_, subject)| subject.settings.name.clone()).collect();
    let said = || {
        format!(
            "what is edited in {} is finer than this file and in it only as far as it was baked: sub_volume.bake puts it into the \
             volume, sub_volume.export writes it as fine as it is",
            names.join(", ")
        )
    };
    Ok((!names.is_empty()).then(said))
}

/// Writes a field. `label` is the segment whose surface is meant; `beside` is said with what is written.
///
/// # Errors
/// If the name's ending has no room for the field, if there is nothing to write or nothing to read, or `watch` said no.
pub(super) fn export(
    subject: &Subject<'_>,
    field: FieldKind,
    label: Option<u16>,
    path: &Path,
    watch: &Watch,
    beside: Option<String>,
) -> Result<Said, DocumentError> {
    if io::is_mesh(path) {
        return export_surface(subject, (field, label), path, watch, beside);
    }
    if let Some(label) = label {
        let expected =
            "nothing where voxels are written, which hold all labels; .stl, .ply, .obj or .glb for the surface of one";
        return Err(DocumentError::invalid("label", label, expected));
    }
    let (compression, proceed) = (Compression::default(), |x| watch.proceed(x));
    let exported =
        io::export(path, subject.field(field), subject.volume.grid(), subject.segments(), compression, &proceed)?;
    let warnings = exported.warnings.iter().cloned().chain(beside).collect();
    Ok(ExportedSaid { exported, warnings }.into())
}

fn export_surface(
    subject: &Subject<'_>,
    (field, label): (FieldKind, Option<u16>),
    path: &Path,
    watch: &Watch,
    beside: Option<String>,
) -> Result<Said, DocumentError> {
    let (segments, world_from_index) = (subject.segments(), &subject.grid().world_from_index);
    let proceed = |x: f32| watch.proceed(x * 0.9);
    let (mesh, name, colour) = match (field, label) {
        (FieldKind::Selection, None) => (
            selection_surface(&subject.selection, world_from_index, &proceed)?,
            "Selection".to_owned(),
            SELECTION_COLOUR,
        ),
        (FieldKind::Labels, label) => {
            // The only one is meant where none is named.
            let only = segments.0.first().filter(|_| segments.0.len() == 1).map(|segment| segment.id);
            let segment = label.or(only).and_then(|id| segments.get(id));
            let segment = segment.ok_or_else(|| match label {
                Some(label) => DocumentError::no_segment("label", label, segments),
                None => DocumentError::no_segment("label", "none", segments),
            })?;
            let mesh = label_surface(&subject.labels, segment.id, world_from_index, &proceed)?;
            (mesh, segment.name.clone(), segment.colour)
        }
        (FieldKind::Selection, Some(label)) => {
            return Err(DocumentError::invalid("label", label, "nothing: the selection has no labels"));
        }
        (FieldKind::Density | FieldKind::Colour, _) => {
            let expected = "selection or labels: a mesh is the surface of what is selected or of a segment";
            return Err(DocumentError::invalid("field", field.name(), expected));
        }
    };
    let mesh = mesh.ok_or(DocumentError::Stopped)?;
    if mesh.triangles().is_empty() {
        let nothing = match field {
            FieldKind::Selection => "a selection that is a half nowhere".to_owned(),
            _ => format!("{name}, which has no voxel"),
        };
        let found = beside.into_iter().fold(nothing, |found, beside| format!("{found} ({beside})"));
        return Err(DocumentError::invalid("field", found, "something that has a surface"));
    }
    let exported = io::export_mesh(path, &mesh, &name, colour)?;
    Ok(ExportedMeshSaid { exported, warnings: beside.into_iter().collect() }.into())
}
