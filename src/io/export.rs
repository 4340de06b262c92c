//! Fields to NRRD on the original grid, voxels in the original order, `space: left-posterior-superior`.
//!
//! Density leaves in its source's own type: a voxel whose texel is still the source's own is the source's number bit for bit;
//! an edited one is its value taken back through slope and intercept, rounded and saturated. NRRD has no slope: where the
//! source has one, values leave as `double` (stored · slope + intercept, the sum every other program would make of it), and
//! the keys `burin_stored_type`, `burin_slope`, `burin_intercept` tell how to have the stored numbers back. Selection leaves
//! as the bytes it is kept in (255 is wholly selected: nothing is lost, and a threshold in another program is a number a
//! person can guess); labels as `unsigned short` with the segments' names in 3D Slicer's keys; colour as RGBA.

use super::deflate::Gzip;
use super::layout::to_native;
use super::replace::replace;
use super::{IoError, Progress};
use crate::math::{DAffine3, DMat3, DVec3};
use crate::volume::{BRICK, Field, FieldKind, Grid, Segments, Value, Values, VoxelType, Voxels, is_plain};
use crate::with_voxels;
use std::fmt::Write as _;
use std::io::Write;
use std::path::Path;

/// How voxels are put into the file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// As they are.
    Raw,
    /// One gzip member.
    #[default]
    Gzip,
}

/// What an export wrote.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Exported {
    /// Type of the voxels in the file.
    pub voxel_type: VoxelType,
    /// Length of the file.
    pub bytes: u64,
    /// Voxels that are not the source's own (density), or not 0 (selection, colour, labels).
    pub voxels_changed: u64,
}

/// Voxels handled at once.
const SLAB_VOXELS: u64 = 1 << 21;

/// Writes a field; `grid` is its volume's. The old file of that name stays until the new one is whole and on disk.
///
/// # Errors
/// If `path` does not end in `.nrrd`, the source or the disk fails, or `progress` said no.
pub fn export(
    path: impl AsRef<Path>,
    field: &Field,
    grid: &Grid,
    segments: &Segments,
    compression: Compression,
    progress: Progress<'_>,
) -> Result<Exported, IoError> {
    let path = path.as_ref();
    if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("nrrd")) {
        return Err(IoError::field(&path.display().to_string(), "extension", found_extension(path), "nrrd"));
    }
    let source = field.source().map(|s| &**s);
    let (voxel_type, width) = match (field.kind(), source) {
        (FieldKind::Density, Some(source)) if is_plain(source) => (source.voxel_type(), 1),
        (FieldKind::Density, Some(_)) => (VoxelType::F64, 1),
        (FieldKind::Density, None) => (VoxelType::F32, 1),
        (FieldKind::Colour, _) => (VoxelType::U8, 4),
        (FieldKind::Selection, _) => (VoxelType::U8, 1),
        (FieldKind::Labels, _) => (VoxelType::U16, 1),
    };
    let header = header(field, grid, segments, voxel_type, width, compression);
    let [nx, ny, nz] = grid.dims;
    let thick = (SLAB_VOXELS / (u64::from(nx) * u64::from(ny))).clamp(1, u64::from(BRICK)) as u32;
    let mut voxels_changed = 0;
    let write = |out: &mut dyn Write| {
        for z in (0..nz).step_by(thick as usize) {
            if !progress(z as f32 / nz as f32) {
                return Err(IoError::Cancelled { file: path.display().to_string() });
            }
            let (mut bytes, changed) = slab(field, z, [nx, ny, thick.min(nz - z)])?;
            voxels_changed += changed;
            // Texels are little-endian everywhere, a source's voxels are this machine's.
            if field.kind() == FieldKind::Density && source.is_some() {
                to_native(&mut bytes, voxel_type.bytes(), false);
            }
            out.write_all(&bytes).map_err(IoError::system(path, "write the file"))?;
        }
        Ok(())
    };
    let bytes = replace(path, |out| {
        out.write_all(header.as_bytes()).map_err(IoError::system(path, "write the file"))?;
        let mut write = write;
        match compression {
            Compression::Raw => write(out),
            Compression::Gzip => {
                let mut gzip = Gzip::new(out).map_err(IoError::system(path, "write the file"))?;
                write(&mut gzip)?;
                gzip.finish().map_err(IoError::system(path, "write the file"))
            }
        }
    })?;
    Ok(Exported { voxel_type, bytes, voxels_changed })
}

fn found_extension(path: &Path) -> std::borrow::Cow<'_, str> {
    path.extension().unwrap_or_default().to_string_lossy()
}

/// The bytes of planes `z` and on, and how many of their voxels count as changed.
fn slab(field: &Field, z: u32, size: [u32; 3]) -> Result<(Vec<u8>, u64), IoError> {
    let lo = [0, 0, z];
    let texel_bytes = field.format().bytes();
    let texels = || field.read(0, lo.map(i64::from), size);
    let (FieldKind::Density, Some(source)) = (field.kind(), field.source()) else {
        let texels = texels()?;
        let changed = texels.chunks_exact(texel_bytes).filter(|t| t.iter().any(|&b| b != 0)).count();
        return Ok((texels, changed as u64));
    };
    let (slope, intercept) = source.scaling();
    let Values { own: mut voxels, painted, .. } = field.values(lo, size)?;
    with_voxels!(&mut voxels, v => take_edits(v, &painted, source.scaling()));
    let changed = painted.len() as u64;
    if is_plain(&**source) {
        return Ok((voxels.as_bytes().to_vec(), changed));
    }
    let values: Vec<f64> = with_voxels!(&voxels, v => v.iter().map(|x| x.to_f64() * slope + intercept).collect());
    Ok((Voxels::F64(values).as_bytes().to_vec(), changed))
}

/// Puts painted values in place of the source's numbers.
fn take_edits<T: Value>(voxels: &mut [T], painted: &[(usize, f64)], (slope, intercept): (f64, f64)) {
    for &(place, value) in painted {
        voxels[place] = T::from_f64((value - intercept) / slope);
    }
}

fn header(
    field: &Field,
    grid: &Grid,
    segments: &Segments,
    voxel_type: VoxelType,
    width: u32,
    compression: Compression,
) -> String {
    let lps = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0))) * grid.world_from_index;
    let vector = |v: DVec3| format!("({:?},{:?},{:?})", v.x + 0.0, v.y + 0.0, v.z + 0.0);
    let m = lps.matrix3;
    let [nx, ny, nz] = grid.dims;
    let directions = format!("{} {} {}", vector(m.x_axis), vector(m.y_axis), vector(m.z_axis));
    let (dimension, inner, none, kind) =
        if width == 1 { (3, String::new(), "", "") } else { (4, format!("{width} "), "none ", "RGBA-color ") };
    let encoding = match compression {
        Compression::Raw => "raw",
        Compression::Gzip => "gzip",
    };
    let mut text = format!(
        "NRRD0004\n\
         # Complete NRRD file format specification at: http://teem.sourceforge.net/nrrd/format.html\n\
         type: {}\ndimension: {dimension}\nspace: left-posterior-superior\nsizes: {inner}{nx} {ny} {nz}\n\
         space directions: {none}{directions}\nkinds: {kind}domain domain domain\nendian: little\n\
         encoding: {encoding}\nspace origin: {}\nspace units: \"mm\" \"mm\" \"mm\"\n",
        teem_name(voxel_type),
        vector(lps.translation),
    );
    text.push_str(&key("burin_field", field.kind().name()));
    match field.kind() {
        FieldKind::Density => {
            if let Some(source) = field.source().filter(|s| !is_plain(&***s)) {
                let (slope, intercept) = source.scaling();
                text.push_str(&key("burin_stored_type", teem_name(source.voxel_type())));
                text.push_str(&key("burin_slope", &format!("{slope:?}")));
                text.push_str(&key("burin_intercept", &format!("{intercept:?}")));
            }
        }
        FieldKind::Selection => text.push_str(&key("burin_one", "255")),
        FieldKind::Labels => segment_keys(&mut text, grid, segments),
        FieldKind::Colour => {}
    }
    text.push('\n');
    text
}

/// Names and colours as 3D Slicer's `.seg.nrrd` has them.
fn segment_keys(text: &mut String, grid: &Grid, segments: &Segments) {
    let [nx, ny, nz] = grid.dims.map(|d| d - 1);
    for (i, segment) in segments.0.iter().enumerate() {
        let [r, g, b] = segment.colour;
        for (name, value) in [
            ("ID", format!("Segment_{}", segment.id)),
            ("Name", segment.name.clone()),
            ("Color", format!("{r} {g} {b}")),
            ("LabelValue", segment.id.to_string()),
            ("Layer", "0".into()),
            ("Extent", format!("0 {nx} 0 {ny} 0 {nz}")),
        ] {
            let _ = write!(text, "{}", key(&format!("Segment{i}_{name}"), &value));
        }
    }
    if !segments.0.is_empty() {
        text.push_str(&key("Segmentation_ContainedRepresentationNames", "Binary labelmap|"));
        text.push_str(&key("Segmentation_MasterRepresentation", "Binary labelmap"));
    }
}

/// A key with its value, line ends and backslashes escaped as the format asks.
fn key(name: &str, value: &str) -> String {
    format!("{name}:={}\n", value.replace('\\', "\\\\").replace('\r', "").replace('\n', "\\n"))
}

/// As teem writes it.
fn teem_name(voxel_type: VoxelType) -> &'static str {
    match voxel_type {
        VoxelType::U8 => "unsigned char",
        VoxelType::I8 => "signed char",
        VoxelType::U16 => "unsigned short",
        VoxelType::I16 => "short",
        VoxelType::U32 => "unsigned int",
        VoxelType::I32 => "int",
        VoxelType::U64 => "unsigned long long int",
        VoxelType::I64 => "long long int",
        VoxelType::F32 => "float",
        VoxelType::F64 => "double",
    }
}
