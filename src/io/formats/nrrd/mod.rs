//! NRRD: attached and detached headers, series of data files, every encoding, number type and space.

mod files;
mod header;
mod place;
mod segments;
mod write;

use crate::io::codec::decode::Encoding;
use crate::io::codec::inflate::open_file;
use crate::io::error::IoError;
use crate::io::formats::FileFormat;
use crate::io::formats::nrrd::files::data_files;
use crate::io::formats::nrrd::header::Header;
use crate::io::layout::{Axis, DataFile, Layout, Role, Skip};
use crate::io::reader::{Opened, Reader};
use crate::volume::VoxelType;
use std::io::{BufRead, BufReader, Seek, SeekFrom};
use std::path::Path;

/// The format.
pub(super) static FORMAT: FileFormat = FileFormat { reader: &Nrrd, writers: &write::FORMATS, rank: 0 };

/// The reader.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nrrd;

impl Reader for Nrrd {
    fn name(&self) -> &'static str {
        "NRRD (.nrrd, .nhdr)"
    }

    fn title(&self) -> &'static str {
        "NRRD (.nrrd)"
    }

    fn endings(&self) -> &'static [&'static str] {
        &[".nrrd", ".nhdr"]
    }

    fn recognises(&self, head: &[u8]) -> bool {
        head.starts_with(b"NRRD")
    }

    fn claims(&self, file_name: &str) -> bool {
        file_name.ends_with(".nrrd") || file_name.ends_with(".nhdr")
    }

    fn open(&self, path: &Path) -> Result<Opened, IoError> {
        let mut warnings = Vec::new();
        let header = Header::read(path, &mut warnings)?;
        let voxel_type = header.voxel_type()?;
        let (grid, axes) = place::place(&header, &mut warnings)?;
        let encoding = encoding(&header)?;
        let big_endian = match header.get("endian").map(str::to_ascii_lowercase).as_deref() {
            Some("big") => true,
            Some("little") => false,
            None if voxel_type.bytes() == 1 || encoding == Encoding::Text => false,
            found => return Err(header.wrong("endian", found.unwrap_or_default(), "little or big")),
        };
        // Numbers in text have no order of bytes.
        let big_endian = big_endian && encoding != Encoding::Text;
        let (files, start) = match data_files(path, &header, &header.sizes()?)? {
            Some(files) => (files, 0),
            None => (vec![path.to_path_buf()], header.end),
        };
        let lines = match header.number("line skip")?.unwrap_or(0) {
            lines @ 0.. => lines as u64,
            lines => return Err(header.wrong("line skip", lines, "0 or more lines")),
        };
        let data = files.into_iter().map(|path| {
            let start = if lines > 0 { after_lines(&header.file, &path, start, lines)? } else { start };
            Ok(DataFile { path, start })
        });
        let data = data.collect::<Result<_, IoError>>()?;
        let skip = skip(&header, encoding)?;
        let file = header.file.clone();
        if axes.iter().filter(|a| a.role == Role::Component).count() > 1 {
            warnings.push("several axes are neither space nor time: they count together as components".into());
        }
        let colour = is_colour(&header, &axes, voxel_type)?;
        let layout = Layout { data, file, grid, voxel_type, big_endian, scaling: (1.0, 0.0), axes, encoding, skip };
        let mut opened = layout.opened(warnings)?;
        opened.format = format!("NRRD, {}", encoding.name());
        opened.colour = colour;
        opened.labels = segments::segments(&header.keys, opened.components, &mut opened.warnings);
        Ok(opened)
    }
}

/// Whether components are colours: by their kind, or three or four bytes that lie side by side and whose kind says nothing.
fn is_colour(header: &Header, axes: &[Axis], voxel_type: VoxelType) -> Result<bool, IoError> {
    let mut components = axes.iter().enumerate().filter(|(_, a)| a.role == Role::Component);
    let (Some((at, axis)), None) = (components.next(), components.next()) else { return Ok(false) };
    let kinds = header.words_for("kinds", header.dimension)?;
    let kind = kinds.map_or("???".into(), |kinds| kinds[at].to_ascii_lowercase());
    let silent = voxel_type == VoxelType::U8 && at == 0 && ["???", "none"].contains(&kind.as_str());
    Ok(match axis.len {
        3 => silent || ["rgb-color", "3-color"].contains(&kind.as_str()),
        4 => silent || ["rgba-color", "4-color"].contains(&kind.as_str()),
        _ => false,
    })
}

fn encoding(header: &Header) -> Result<Encoding, IoError> {
    match header.get("encoding").map(str::to_ascii_lowercase).as_deref() {
        Some("raw") => Ok(Encoding::Raw),
        Some("gzip" | "gz") => Ok(Encoding::Gzip),
        Some("bzip2" | "bz2") => Ok(Encoding::Bzip2),
        Some("hex") => Ok(Encoding::Hex),
        Some("ascii" | "text" | "txt") => Ok(Encoding::Text),
        found => Err(header.wrong("encoding", found.unwrap_or_default(), "raw, gzip, bzip2, hex or ascii")),
    }
}

/// `byte skip`: counted in what a compressed file holds. Counted from the end, −1 says that the voxels are the last bytes, −1−n
/// that n bytes follow them.
fn skip(header: &Header, encoding: Encoding) -> Result<Skip, IoError> {
    let skip = header.number("byte skip")?.unwrap_or(0);
    match (u64::try_from(skip), encoding) {
        (Ok(skip), _) => Ok(Skip::Bytes(skip)),
        (Err(_), Encoding::Hex | Encoding::Text) => {
            let expected = format!("0 or more: {} has no length to count back by", encoding.name());
            Err(header.wrong("byte skip", skip, expected))
        }
        (Err(_), _) => Ok(Skip::AllBut((skip + 1).unsigned_abs())),
    }
}

/// The byte behind so many lines of a file.
fn after_lines(header: &str, path: &Path, start: u64, lines: u64) -> Result<u64, IoError> {
    let failed = |e| IoError::system(path, "read the file")(e);
    let mut file = open_file(path)?;
    file.seek(SeekFrom::Start(start)).map_err(failed)?;
    let mut reader = BufReader::new(file);
    let mut at = start;
    for line in 0..lines {
        // In pieces: a line may be as long as the file.
        loop {
            let piece = reader.fill_buf().map_err(failed)?;
            if piece.is_empty() {
                return Err(IoError::Truncated {
                    file: header.into(),
                    found: format!("{line} lines"),
                    expected: format!("{lines} lines to skip"),
                });
            }
            let newline = piece.iter().position(|&b| b == b'\n');
            let used = newline.map_or(piece.len(), |n| n + 1);
            reader.consume(used);
            at += used as u64;
            if newline.is_some() {
                break;
            }
        }
    }
    Ok(at)
}
