//! Fields to files on the original grid, voxels in the original order.
//!
//! Density leaves in its source's own type: a voxel that nobody edited is the source's number bit for bit; an edited one is its
//! value taken back through slope and intercept, rounded and saturated. A format that has no slope gets the values as `double`
//! (stored · slope + intercept, the sum every other program would make of it). Selection leaves as the bytes it is kept in (255 is
//! wholly selected: nothing is lost, and a threshold in another program is a number a person can guess); colour as RGBA; labels as
//! the ids that the file they came from has, in the least type that holds them, at least `unsigned short`.
//!
//! Owns what is written; how a format says it is its own (`formats`).

use crate::io::codec::deflate::Gzip;
use crate::io::error::IoError;
use crate::io::formats::writers;
use crate::io::leaving::Compression;
use crate::io::leaving::{Format, Leaving};
use crate::io::progress::Progress;
use crate::io::replace::replace;
use crate::volume::{BRICK, Field, FieldKind, Grid, Segments, VoxelType, is_plain};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

/// What an export wrote.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Exported {
    /// Type of the voxels in the file.
    pub voxel_type: VoxelType,
    /// Length of the file.
    pub bytes: u64,
    /// Voxels that are not the source's own (density), or not 0 (selection, colour, labels).
    pub voxels_changed: u64,
    /// What could not be written as it is.
    pub warnings: Vec<String>,
}

/// How the names of files end that a field can leave in, format by format; the one that keeps most of the field first, and of each
/// format the usual ending.
pub fn export_endings(kind: FieldKind) -> Vec<&'static [&'static str]> {
    writers().filter(|f| !f.labels_only || kind == FieldKind::Labels).map(|f| f.endings).collect()
}

/// What people know the format of these endings by, what is to be said about it, and whether it is for labels only.
pub(crate) fn about_format(endings: &[&str]) -> Option<(&'static str, &'static str, bool)> {
    writers().find(|f| f.endings == endings).map(|f| (f.name, f.about, f.labels_only))
}

/// Voxels handled at once.
const SLAB_VOXELS: u64 = 1 << 21;

/// Writes a field; `grid` is its volume's. The old file of that name stays until the new one is whole and on disk.
///
/// # Errors
/// If `path` ends in none of [`export_endings`], if the format has no room for the field, the source or the disk fails, or `progress`
/// said no.
pub fn export(
    path: impl AsRef<Path>,
    field: &Field,
    grid: &Grid,
    segments: &Segments,
    compression: Compression,
    progress: Progress<'_>,
) -> Result<Exported, IoError> {
    let path = path.as_ref();
    let file = path.display().to_string();
    let (format, by_name) = format(path, &file, field.kind())?;
    let compression = by_name.unwrap_or(compression);
    let mut leaving = Leaving {
        field,
        grid,
        segments,
        voxel_type: VoxelType::U8,
        width: 1,
        scaling: (1.0, 0.0),
        values: BTreeMap::new(),
    };
    let mut warnings = Vec::new();
    match (field.kind(), field.source().map(|s| &**s)) {
        (FieldKind::Density, Some(source)) => {
            let kept = is_plain(source) || (format.keeps)(source.scaling());
            leaving.voxel_type = if kept { source.voxel_type() } else { VoxelType::F64 };
            leaving.scaling = if kept { source.scaling() } else { (1.0, 0.0) };
        }
        (FieldKind::Density, None) => leaving.voxel_type = VoxelType::F32,
        (FieldKind::Colour, _) => leaving.width = 4,
        (FieldKind::Selection, _) => {}
        (FieldKind::Labels, _) => {
            leaving.values = segments.file_values();
            leaving.voxel_type = holding(&file, &leaving.values)?;
            let other = segments.0.iter().filter(|s| leaving.values.get(&s.id) != Some(&s.file_value()));
            warnings.extend(other.map(|s| {
                let value = leaving.values.get(&s.id).copied().unwrap_or_default();
                format!("{} is {value} in the file: {} is another segment's", s.name, s.file_value())
            }));
        }
    }
    let header = (format.header)(&leaving, compression);
    let [nx, ny, nz] = grid.dims;
    let thick = (SLAB_VOXELS / (u64::from(nx) * u64::from(ny))).clamp(1, u64::from(BRICK)) as u32;
    let mut voxels_changed = 0;
    let write = |out: &mut dyn Write| {
        for z in (0..nz).step_by(thick as usize) {
            if !progress(z as f32 / nz as f32) {
                return Err(IoError::Cancelled { file: file.clone() });
            }
            let (bytes, changed) = leaving.slab(z, [nx, ny, thick.min(nz - z)])?;
            voxels_changed += changed;
            out.write_all(&bytes).map_err(IoError::system(path, "write the file"))?;
        }
        Ok(())
    };
    let bytes = replace(path, |out| {
        let mut write = write;
        match compression {
            // A NIfTI is compressed as a whole, a NRRD behind its header.
            Compression::Gzip if by_name.is_some() => {
                let mut gzip = Gzip::new(out).map_err(IoError::system(path, "write the file"))?;
                gzip.write_all(&header).map_err(IoError::system(path, "write the file"))?;
                write(&mut gzip)?;
                gzip.finish().map_err(IoError::system(path, "write the file"))
            }
            Compression::Gzip => {
                out.write_all(&header).map_err(IoError::system(path, "write the file"))?;
                let mut gzip = Gzip::new(out).map_err(IoError::system(path, "write the file"))?;
                write(&mut gzip)?;
                gzip.finish().map_err(IoError::system(path, "write the file"))
            }
            Compression::Raw => {
                out.write_all(&header).map_err(IoError::system(path, "write the file"))?;
                write(out)
            }
        }
    })?;
    Ok(Exported { voxel_type: leaving.voxel_type, bytes, voxels_changed, warnings })
}

/// The format that a name asks for, and the compression that it says: another program would take the name's word for it.
fn format(path: &Path, file: &str, kind: FieldKind) -> Result<(&'static Format, Option<Compression>), IoError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let endings = export_endings(kind).concat().iter().map(|e| &e[1..]).collect::<Vec<_>>().join(", ");
    let all = writers().flat_map(|f| f.endings.iter().map(move |&ending| (f, ending)));
    match all.filter(|(_, ending)| name.ends_with(ending)).max_by_key(|(_, ending)| ending.len()) {
        Some((format, ending)) if format.labels_only && kind != FieldKind::Labels => {
            let expected = format!("one of {endings}: only labels are segments");
            Err(IoError::field(file, "extension", &ending[1..], expected))
        }
        Some((format, ending)) => Ok((format, (format.compression)(ending))),
        None => {
            let found = path.extension().unwrap_or_default().to_string_lossy();
            Err(IoError::field(file, "extension", found, format!("one of {endings}")))
        }
    }
}

/// The least type that holds labels of these values.
fn holding(file: &str, values: &BTreeMap<u16, i128>) -> Result<VoxelType, IoError> {
    let lo = values.values().copied().min().unwrap_or(0).min(0);
    let hi = values.values().copied().max().unwrap_or(0).max(0);
    let types = [
        (VoxelType::U16, 0, u16::MAX.into()),
        (VoxelType::I16, i16::MIN.into(), i16::MAX.into()),
        (VoxelType::U32, 0, u32::MAX.into()),
        (VoxelType::I32, i32::MIN.into(), i32::MAX.into()),
        (VoxelType::I64, i64::MIN.into(), i64::MAX.into()),
        (VoxelType::U64, 0, u64::MAX.into()),
    ];
    let holds = |&&(_, least, most): &&(VoxelType, i128, i128)| least <= lo && hi <= most;
    types.iter().find(holds).map(|t| t.0).ok_or_else(|| {
        let expected = "ids that one type of 64 bits holds; import one of the two label maps alone";
        IoError::field(file, "label ids", format!("{lo} and {hi}"), expected)
    })
}
