//! Meshes to files, the old file of that name staying until the new one is whole.
//!
//! Owns which format a name asks for, and what is told of what was written; how a format says it is its own (`meshes`).

use crate::io::error::IoError;
use crate::io::meshes::{FORMATS, LeavingMesh, MeshFormat};
use crate::io::replace::replace;
use crate::mesh::TriangleMesh;
use std::path::Path;

/// What the export of a mesh wrote.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct ExportedMesh {
    /// Triangles in the file.
    pub triangles: usize,
    /// Corners that they share.
    pub vertices: usize,
    /// What they enclose.
    pub volume_mm3: f64,
    /// Whether every edge is of two triangles, once each way.
    pub closed: bool,
    /// Length of the file.
    pub bytes: u64,
}

/// How the names of files end that meshes can leave in, format by format, of each the usual one first.
pub fn mesh_endings() -> impl Iterator<Item = &'static [&'static str]> {
    FORMATS.iter().map(|format| format.endings)
}

/// What people know the format of these endings by, and what is to be said about it.
pub(crate) fn about_mesh_format(endings: &[&str]) -> Option<(&'static str, &'static str)> {
    FORMATS.iter().find(|format| format.endings == endings).map(|format| (format.name, format.about))
}

/// Whether a file of that name is one of a mesh.
pub fn is_mesh(path: &Path) -> bool {
    format(path).is_some()
}

fn format(path: &Path) -> Option<&'static MeshFormat> {
    let name = path.file_name()?.to_string_lossy().to_lowercase();
    FORMATS.iter().find(|format| format.endings.iter().any(|ending| name.ends_with(ending)))
}

/// Writes a mesh in world mm; `name` and `colour` (display-referred, 0..1) go along where the format has room for them.
///
/// # Errors
/// If `path` ends in none of [`mesh_endings`], if the format has no room for so many triangles, or the disk fails.
pub fn export_mesh(
    path: impl AsRef<Path>,
    mesh: &TriangleMesh,
    name: &str,
    colour: [f32; 3],
) -> Result<ExportedMesh, IoError> {
    let path = path.as_ref();
    let file = path.display().to_string();
    let format = format(path).ok_or_else(|| {
        let endings: Vec<&str> = FORMATS.iter().flat_map(|f| f.endings).map(|ending| &ending[1..]).collect();
        let found = path.extension().unwrap_or_default().to_string_lossy();
        IoError::field(&file, "extension", found, format!("one of {}", endings.join(", ")))
    })?;
    let (triangles, vertices) = (mesh.triangles().len(), mesh.corners().len());
    let needed = (triangles * 12 + vertices * 24) as u64;
    if needed > format.most_bytes {
        let expected = format!("at most {} bytes of them in {}; write .ply or .stl", format.most_bytes, format.name);
        return Err(IoError::field(&file, "triangles", format!("{triangles}, {needed} bytes"), expected));
    }
    let leaving = LeavingMesh { mesh, name, colour };
    let bytes = replace(path, |out| (format.write)(&leaving, out).map_err(IoError::system(path, "write the file")))?;
    Ok(ExportedMesh { triangles, vertices, volume_mm3: mesh.volume_mm3(), closed: mesh.is_closed(), bytes })
}
