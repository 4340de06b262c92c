//! NRRD: attached and detached headers, encodings raw and gzip, every number type and space.

use super::inflate::open_file;
use super::layout::{Encoding, Layout, Role};
use super::nrrd_header::{Header, ONE_DATA_FILE};
use super::{IoError, Opened, Reader, nrrd_place};
use std::io::{BufRead, BufReader, Seek, SeekFrom};
use std::path::{Component, Path, PathBuf};

/// The reader.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nrrd;

impl Reader for Nrrd {
    fn name(&self) -> &'static str {
        "NRRD (.nrrd, .nhdr)"
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
        let (grid, axes) = nrrd_place::place(&header, &mut warnings)?;
        let big_endian = match header.get("endian").map(str::to_ascii_lowercase).as_deref() {
            Some("big") => true,
            Some("little") => false,
            None if voxel_type.bytes() == 1 => false,
            found => return Err(header.wrong("endian", found.unwrap_or_default(), "little or big")),
        };
        let (path, start) = data_file(path, &header)?;
        let file = header.file.clone();
        let encoding = Encoding::Raw { start };
        let mut layout = Layout { path, file, grid, voxel_type, big_endian, scaling: (1.0, 0.0), axes, encoding };
        layout.encoding = encoding_of(&header, &layout, start)?;
        if layout.axes.iter().filter(|a| a.role == Role::Component).count() > 1 {
            warnings.push("several axes are neither space nor time: they count together as components".into());
        }
        layout.opened(warnings)
    }
}

/// The file of the voxels and where in it they may begin.
fn data_file(path: &Path, header: &Header) -> Result<(PathBuf, u64), IoError> {
    let Some(name) = header.get("data file") else { return Ok((path.into(), header.end)) };
    if name.contains('%') {
        return Err(header.wrong("data file", name, ONE_DATA_FILE));
    }
    let name = Path::new(name);
    // A header must not make anyone read what lies elsewhere.
    let inside = name.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
    if !inside || name.file_name().is_none() {
        return Err(header.wrong("data file", name.display(), "a file in the header's own folder or below"));
    }
    let data = path.parent().unwrap_or(Path::new("")).join(name);
    if data.is_file() {
        Ok((data, 0))
    } else {
        Err(header.wrong("data file", name.display(), format!("a file; there is none at {}", data.display())))
    }
}

/// Where the voxels begin, after `line skip` and `byte skip`.
fn encoding_of(header: &Header, layout: &Layout, start: u64) -> Result<Encoding, IoError> {
    let line_skip = header.number("line skip")?.unwrap_or(0);
    let byte_skip = header.number("byte skip")?.unwrap_or(0);
    if line_skip < 0 {
        return Err(header.wrong("line skip", line_skip, "0 or more lines"));
    }
    let start = if line_skip > 0 { after_lines(layout, start, line_skip as u64)? } else { start };
    let skip = u64::try_from(byte_skip);
    match header.get("encoding").map(str::to_ascii_lowercase).as_deref() {
        Some("raw") => match skip {
            Ok(skip) => Ok(Encoding::Raw { start: start.saturating_add(skip) }),
            // Counted from the end: −1 says that the voxels are the file's last bytes, −1−n that n bytes follow them.
            Err(_) => {
                let len =
                    std::fs::metadata(&layout.path).map_err(IoError::system(&layout.path, "open the file"))?.len();
                let behind = (byte_skip + 1).unsigned_abs();
                let from = layout.bytes().and_then(|b| b.checked_add(behind)).and_then(|b| len.checked_sub(b));
                match from.filter(|&from| from >= start) {
                    Some(start) => Ok(Encoding::Raw { start }),
                    None => Err(IoError::Truncated {
                        file: header.file.clone(),
                        found: format!("{} bytes after the header", len.saturating_sub(start)),
                        expected: format!("{:?} bytes and {behind} behind them", layout.bytes()),
                    }),
                }
            }
        },
        Some("gzip" | "gz") => match skip {
            Ok(skip) => Ok(Encoding::Gzip { start, skip }),
            Err(_) => Err(header.wrong("byte skip", byte_skip, "0 or more for gzip; negative only for raw")),
        },
        found => {
            let expected = "raw or gzip: others are not supported yet; save the file anew with one of these";
            Err(header.wrong("encoding", found.unwrap_or_default(), expected))
        }
    }
}

fn after_lines(layout: &Layout, start: u64, lines: u64) -> Result<u64, IoError> {
    let failed = |e| IoError::system(&layout.path, "read the file")(e);
    let mut file = open_file(&layout.path)?;
    file.seek(SeekFrom::Start(start)).map_err(failed)?;
    let mut reader = BufReader::new(file);
    let mut at = start;
    for line in 0..lines {
        // In pieces: a line may be as long as the file.
        loop {
            let piece = reader.fill_buf().map_err(|e| IoError::system(&layout.path, "read the file")(e))?;
            if piece.is_empty() {
                return Err(IoError::Truncated {
                    file: layout.file.clone(),
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
