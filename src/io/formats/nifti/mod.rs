//! NIfTI-1 and -2: `.nii`, `.nii.gz`, and `.hdr` with `.img` (either gzipped), in both byte orders.
//!
//! Reads what the header says of type, scaling, frames (`dim[4]`) and components (`dim[5]` and on, and the parts of RGB, RGBA and
//! complex voxels); the place in the world is `place`'s.

mod header;
mod place;
mod write;

use crate::io::codec::decode::Encoding;
use crate::io::codec::inflate::{GZIP_MAGIC, open_file};
use crate::io::error::IoError;
use crate::io::formats::FileFormat;
use crate::io::formats::nifti::header::Header;
use crate::io::head::head;
use crate::io::layout::{Axis, DataFile, Layout, Role, Skip};
use crate::io::place::{dimension, grid};
use crate::io::reader::{Opened, Reader};
use crate::io::regular::FileMark;
use crate::volume::VoxelType;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Where voxels of a single file begin at the earliest: after the header and the extension flag.
const SINGLE_OFFSETS: [u64; 2] = [352, 544];

/// The format.
pub(super) static FORMAT: FileFormat = FileFormat { reader: &Nifti, writers: &write::FORMATS, rank: 1 };

/// The reader.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nifti;

impl Reader for Nifti {
    fn name(&self) -> &'static str {
        "NIfTI-1 and -2 (.nii, .nii.gz, .hdr with .img)"
    }

    fn title(&self) -> &'static str {
        "NIfTI (.nii, .nii.gz)"
    }

    fn endings(&self) -> &'static [&'static str] {
        &[".nii", ".nii.gz", ".hdr"]
    }

    fn recognises(&self, head: &[u8]) -> bool {
        let magic = head.get(344..348).is_some_and(|m| m == b"n+1\0" || m == b"ni1\0");
        magic || head.get(4..7).is_some_and(|m| m == b"n+2" || m == b"ni2")
    }

    fn claims(&self, file_name: &str) -> bool {
        let name = file_name.strip_suffix(".gz").unwrap_or(file_name);
        [".nii", ".hdr", ".img"].iter().any(|e| name.ends_with(e))
    }

    fn open(&self, path: &Path) -> Result<Opened, IoError> {
        let header_path = partner(path, ".img", ".hdr").unwrap_or_else(|| path.to_path_buf());
        let file = header_path.display().to_string();
        let header = Header::new(&file, &head(&header_path)?)?;
        let mark = FileMark::of(&header_path).map_err(IoError::system(&header_path, "open the file"))?;
        let mut warnings = Vec::new();
        let earliest = if header.single { SINGLE_OFFSETS[usize::from(header.version - 1)] } else { 0 };
        let path = if header.single { header_path } else { image(&header_path, header.version)? };
        let (dims, frames, parts) = header.dims(&mut warnings)?;
        let (voxel_type, inner) = header.voxel_type(&mut warnings)?;
        let scaling = if inner.is_some_and(|i| i.colour) { (1.0, 0.0) } else { header.scaling(&mut warnings) };
        let grid = grid(&file, "sform", dims, place::world_from_index(&header, &mut warnings))?;
        let offset = header.offset(earliest, &mut warnings)?;
        let mut axes: Vec<Axis> = inner.iter().map(|i| Axis { len: i.parts, role: Role::Component }).collect();
        axes.extend((0..3).map(|a| Axis { len: u64::from(dims[a]), role: Role::Space(a) }));
        axes.push(Axis { len: frames, role: Role::Frame });
        axes.extend(parts.map(|len| Axis { len, role: Role::Component }));
        let encoding = if is_gzip(&path)? { Encoding::Gzip } else { Encoding::Raw };
        let (data, skip) = (vec![DataFile { path, start: 0 }], Skip::Bytes(offset));
        let (big_endian, version) = (header.big_endian, header.version);
        let mut opened =
            Layout { data, file, grid, voxel_type, big_endian, scaling, axes, encoding, skip }.opened(warnings)?;
        opened.colour = inner.is_some_and(|i| i.colour && u64::from(opened.components) == i.parts);
        opened.files.push(mark);
        opened.format = format!("NIfTI-{version}{}", if encoding == Encoding::Gzip { ", gzip" } else { "" });
        Ok(opened)
    }
}

/// Parts of a voxel that come one after another.
#[derive(Clone, Copy)]
struct Parts {
    parts: u64,
    colour: bool,
}

impl Header {
    /// Voxels, frames, and what `dim[5]` to `dim[7]` count.
    fn dims(&self, warnings: &mut Vec<String>) -> Result<([u32; 3], u64, [u64; 3]), IoError> {
        let rank = self.dim[0];
        if !(1..=7).contains(&rank) {
            return Err(self.wrong("dim[0]", rank, "1 to 7 dimensions"));
        }
        let mut dims = [1_u64; 8];
        for (a, dim) in dims.iter_mut().enumerate().take(rank as usize + 1).skip(1) {
            let field = format!("dim[{a}]");
            *dim = match self.dim[a] {
                n @ 1.. => n as u64,
                // Writers leave unused dimensions at 0 and count them all the same.
                0 if a > 1 => {
                    warnings.push(format!("{field} is 0; taken as 1"));
                    1
                }
                n => return Err(self.wrong(&field, n, if self.version == 1 { "1 to 32767" } else { "1 or more" })),
            };
            if a > 5 && *dim > 1 {
                warnings.push(format!("{field} is {dim}, neither space nor time: counted as components"));
            }
        }
        let mut out = [0; 3];
        for a in 0..3 {
            out[a] = dimension(&self.file, &format!("dim[{}]", a + 1), dims[a + 1])?;
        }
        Ok((out, dims[4], [dims[5], dims[6], dims[7]]))
    }

    fn voxel_type(&self, warnings: &mut Vec<String>) -> Result<(VoxelType, Option<Parts>), IoError> {
        let code = self.datatype;
        let colour = |parts| Some(Parts { parts, colour: true });
        let complex = Some(Parts { parts: 2, colour: false });
        let (voxel_type, parts) = match code {
            2 => (VoxelType::U8, None),
            4 => (VoxelType::I16, None),
            8 => (VoxelType::I32, None),
            16 => (VoxelType::F32, None),
            32 => (VoxelType::F32, complex),
            64 => (VoxelType::F64, None),
            128 => (VoxelType::U8, colour(3)),
            256 => (VoxelType::I8, None),
            512 => (VoxelType::U16, None),
            768 => (VoxelType::U32, None),
            1024 => (VoxelType::I64, None),
            1280 => (VoxelType::U64, None),
            1792 => (VoxelType::F64, complex),
            2304 => (VoxelType::U8, colour(4)),
            _ => {
                let name = match code {
                    1 => " (binary)",
                    1536 => " (128-bit float)",
                    2048 => " (256-bit complex)",
                    _ => "",
                };
                let expected = "2, 4, 8, 16, 32, 64, 128, 256, 512, 768, 1024, 1280, 1792 or 2304";
                return Err(self.wrong("datatype", format!("{code}{name}"), expected));
            }
        };
        let bits = voxel_type.bytes() * 8 * parts.map_or(1, |p| p.parts as usize);
        let found = self.bitpix;
        if i32::from(found) != bits as i32 {
            warnings.push(format!("bitpix is {found}, datatype {code} has {bits}; datatype is believed"));
        }
        Ok((voxel_type, parts))
    }

    /// `scl_slope`, `scl_inter`: none if the slope is 0 or not a number.
    fn scaling(&self, warnings: &mut Vec<String>) -> (f64, f64) {
        let (slope, intercept) = (self.slope, self.intercept);
        if slope == 0.0 || !slope.is_finite() {
            return (1.0, 0.0);
        }
        if !intercept.is_finite() {
            warnings.push(format!("scl_inter is {intercept}; taken as 0"));
            return (slope, 0.0);
        }
        (slope, intercept)
    }

    fn offset(&self, earliest: u64, warnings: &mut Vec<String>) -> Result<u64, IoError> {
        let found = self.vox_offset;
        if !(found >= 0.0 && found.fract() == 0.0 && found < 9e15) {
            return Err(self.wrong("vox_offset", found, "a whole number of bytes, at least 0"));
        }
        let offset = found as u64;
        if offset >= earliest {
            return Ok(offset);
        }
        if offset != 0 {
            warnings.push(format!("vox_offset is {offset}, inside the header; taken as {earliest}"));
        }
        Ok(earliest)
    }
}

/// The path with one ending in place of another, a further `.gz` on either side put up with; `None` if `path` does not end
/// so, or there is no such file.
fn partner(path: &Path, from: &str, to: &str) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let plain = if name.to_lowercase().ends_with(".gz") { &name[..name.len() - 3] } else { name };
    let stem_len = plain.len().checked_sub(from.len())?;
    let (stem, ending) = (plain.get(..stem_len)?, plain.get(stem_len..)?);
    if !ending.eq_ignore_ascii_case(from) {
        return None;
    }
    let upper = to.to_uppercase();
    let candidates = [format!("{stem}{to}"), format!("{stem}{to}.gz"), format!("{stem}{upper}")];
    candidates.into_iter().map(|name| path.with_file_name(name)).find(|p| p.is_file())
}

/// The file of voxels that belongs to a header.
fn image(header: &Path, version: u8) -> Result<PathBuf, IoError> {
    partner(header, ".hdr", ".img").ok_or_else(|| {
        let expected = "a file of the same name ending in .img or .img.gz beside a header ending in .hdr";
        let found = format!("\"ni{version}\" (voxels in another file)");
        IoError::field(&header.display().to_string(), "magic", found, expected)
    })
}

fn is_gzip(path: &Path) -> Result<bool, IoError> {
    let mut magic = Vec::new();
    open_file(path)?.take(2).read_to_end(&mut magic).map_err(IoError::system(path, "read the file"))?;
    Ok(magic == GZIP_MAGIC)
}
