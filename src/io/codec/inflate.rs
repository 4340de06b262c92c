//! Gzip as a stream: several members one after another are one, what follows the last is ignored, as gzip does.

use crate::io::error::IoError;
use flate2::bufread::GzDecoder;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// How a gzip file begins.
pub(crate) const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

/// Deflate cannot expand further than this: 258 bytes for two bits, and a little for the stream's frame.
const MAX_EXPANSION: u64 = 1032;

/// The most bytes that a gzip stream of `compressed` bytes can hold.
pub(crate) fn most_inflated(compressed: u64) -> u64 {
    compressed.saturating_mul(MAX_EXPANSION).saturating_add(1024)
}

/// Opens a regular file for reading.
pub(crate) fn open_file(path: &Path) -> Result<File, IoError> {
    let about = std::fs::metadata(path).map_err(IoError::system(path, "open the file"))?;
    if about.is_file() {
        crate::io::regular::open_regular(path).map_err(IoError::system(path, "open the file"))
    } else {
        Err(IoError::Unknown {
            file: path.display().to_string(),
            found: crate::io::regular::kind(&about).into(),
            expected: "a file".into(),
        })
    }
}

/// A gzip file that is read from one byte of its content on.
#[derive(Debug)]
pub(crate) struct Inflate {
    member: Option<GzDecoder<BufReader<File>>>,
}

impl Inflate {
    /// The stream that starts at byte `start` of a file.
    pub(crate) fn open(path: &Path, start: u64) -> Result<Self, IoError> {
        let mut file = open_file(path)?;
        file.seek(SeekFrom::Start(start)).map_err(IoError::system(path, "read the file"))?;
        Ok(Self { member: Some(GzDecoder::new(BufReader::with_capacity(1 << 16, file))) })
    }
}

impl Read for Inflate {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        if out.is_empty() {
            return Ok(0);
        }
        while let Some(member) = &mut self.member {
            let n = member.read(out)?;
            if n > 0 {
                return Ok(n);
            }
            // The member's checksum was right. Another may follow.
            let Some(done) = self.member.take() else { break };
            let mut rest = done.into_inner();
            if rest.fill_buf()?.starts_with(&GZIP_MAGIC) {
                self.member = Some(GzDecoder::new(rest));
            }
        }
        Ok(0)
    }
}
