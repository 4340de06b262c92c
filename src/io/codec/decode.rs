//! What is in a file of voxels: gzip, bzip2, hex and text as streams of bytes.
//!
//! Text gives each number as the bytes of its type, little-endian, so that all encodings look alike behind this door. Knows no
//! header; says how much a file can hold at the most, so that nobody believes one that asks for more.

use crate::io::codec::inflate::{GZIP_MAGIC, Inflate, most_inflated, open_file};
use crate::io::error::IoError;
use crate::io::error::shown;
use crate::volume::VoxelType;
use bzip2::bufread::MultiBzDecoder;
use flate2::bufread::GzDecoder;
use std::fs::File;
use std::io::{BufRead, BufReader, Error, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

/// How voxels are kept in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// As they are.
    Raw,
    /// In a gzip stream.
    Gzip,
    /// In a bzip2 stream.
    Bzip2,
    /// Two hexadecimal digits a byte, white space anywhere.
    Hex,
    /// Numbers with white space or commas between them.
    Text,
}

/// The most that a block of bzip2 can hold: 900,000 bytes of which five stand for up to 259; and the fewest bytes of one.
const BZIP2_BLOCK: (u64, u64) = (900_000 / 5 * 259, 24);

/// The longest word that may be a number: the largest double has 309 digits where it is written out, the smallest 1,074 behind the
/// point.
const LONGEST_WORD: usize = 1100;

impl Encoding {
    /// Its name in messages.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::Gzip => "gzip",
            Self::Bzip2 => "bzip2",
            Self::Hex => "hex",
            Self::Text => "text",
        }
    }

    /// The most bytes of voxels that `bytes` of a file can hold.
    pub(crate) fn most(self, bytes: u64, voxel_type: VoxelType) -> u64 {
        match self {
            Self::Raw => bytes,
            Self::Gzip => most_inflated(bytes),
            Self::Bzip2 => (bytes / BZIP2_BLOCK.1 + 1).saturating_mul(BZIP2_BLOCK.0),
            Self::Hex => bytes / 2,
            // A digit and what parts it from the next.
            Self::Text => bytes.div_ceil(2).saturating_mul(voxel_type.bytes() as u64),
        }
    }

    /// The stream that starts at byte `start` of a file; not for raw data, which are read in place.
    pub(crate) fn open(self, path: &Path, start: u64, voxel_type: VoxelType) -> Result<Box<dyn Read + Send>, IoError> {
        let file = || -> Result<BufReader<File>, IoError> {
            let mut file = open_file(path)?;
            file.seek(SeekFrom::Start(start)).map_err(IoError::system(path, "read the file"))?;
            Ok(BufReader::with_capacity(1 << 16, file))
        };
        Ok(match self {
            Self::Raw => Box::new(file()?),
            Self::Gzip => Box::new(Inflate::open(path, start)?),
            Self::Bzip2 => Box::new(MultiBzDecoder::new(file()?)),
            Self::Hex => Box::new(Hex { from: file()?, digits: 0 }),
            Self::Text => Box::new(Text { from: file()?, voxel_type, numbers: 0, left: ([0; 8], 0) }),
        })
    }
}

/// Whether inflated data are gzip themselves: a file that was compressed twice. A magic number alone may be voxels; a stream
/// that can be inflated is none.
pub(crate) fn is_gzip_again(inflated: impl BufRead) -> bool {
    let mut inflated = inflated;
    let starts = inflated.fill_buf().is_ok_and(|b| b.starts_with(&GZIP_MAGIC));
    starts && GzDecoder::new(inflated).read(&mut [0; 64]).is_ok()
}

fn damage(what: String) -> Error {
    Error::new(ErrorKind::InvalidData, what)
}

struct Hex<R> {
    from: R,
    digits: u64,
}

impl<R: BufRead> Hex<R> {
    /// The next digit's value; `None` at the end.
    fn digit(&mut self) -> std::io::Result<Option<u8>> {
        loop {
            let buffer = self.from.fill_buf()?;
            let Some(&byte) = buffer.first() else { return Ok(None) };
            self.from.consume(1);
            match (byte as char).to_digit(16) {
                Some(value) => {
                    self.digits += 1;
                    return Ok(Some(value as u8));
                }
                None if byte.is_ascii_whitespace() => {}
                None => {
                    let found = shown(&byte.escape_ascii().to_string());
                    return Err(damage(format!("\"{found}\" after {} digits", self.digits)));
                }
            }
        }
    }
}

impl<R: BufRead> Read for Hex<R> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        for (n, byte) in out.iter_mut().enumerate() {
            let Some(high) = self.digit()? else { return Ok(n) };
            let Some(low) = self.digit()? else { return Err(ErrorKind::UnexpectedEof.into()) };
            *byte = high << 4 | low;
        }
        Ok(out.len())
    }
}

struct Text<R> {
    from: R,
    voxel_type: VoxelType,
    numbers: u64,
    /// Bytes of a number that found no room, the last ones; and how many.
    left: ([u8; 8], usize),
}

impl<R: BufRead> Text<R> {
    /// The next word; empty at the end.
    fn word(&mut self, word: &mut Vec<u8>) -> std::io::Result<()> {
        word.clear();
        loop {
            let buffer = self.from.fill_buf()?;
            if buffer.is_empty() {
                return Ok(());
            }
            let separates = |b: &u8| b.is_ascii_whitespace() || *b == b',';
            let skip = if word.is_empty() { buffer.iter().take_while(|b| separates(b)).count() } else { 0 };
            let take = buffer[skip..].iter().take_while(|b| !separates(b)).count();
            word.extend_from_slice(&buffer[skip..skip + take.min(LONGEST_WORD + 1)]);
            let ends = skip + take < buffer.len();
            self.from.consume(skip + take);
            if word.len() > LONGEST_WORD {
                let found = shown(&String::from_utf8_lossy(word));
                return Err(damage(format!("\"{found}\" as number {} is none", self.numbers + 1)));
            }
            if ends && !word.is_empty() {
                return Ok(());
            }
        }
    }

    fn stored(&self, word: &[u8]) -> std::io::Result<[u8; 8]> {
        let text = std::str::from_utf8(word).unwrap_or("");
        let wrong = || {
            let found = shown(&String::from_utf8_lossy(word));
            damage(format!("\"{found}\" as number {} is no {}", self.numbers + 1, self.voxel_type.name()))
        };
        let mut out = [0; 8];
        match self.voxel_type {
            VoxelType::F32 => out[..4].copy_from_slice(&text.parse::<f32>().map_err(|_| wrong())?.to_le_bytes()),
            VoxelType::F64 => out = text.parse::<f64>().map_err(|_| wrong())?.to_le_bytes(),
            integer => {
                // Some writers put 3.0 or 1e3 for whole numbers.
                let whole = |x: f64| (x.fract() == 0.0 && x.abs() < 2.0_f64.powi(64)).then_some(x as i128);
                let value: Option<i128> = text.parse().ok().or_else(|| text.parse().ok().and_then(whole));
                let bits = integer.bytes() as u32 * 8;
                let signed = matches!(integer, VoxelType::I8 | VoxelType::I16 | VoxelType::I32 | VoxelType::I64);
                let range = if signed { -(1_i128 << (bits - 1))..1_i128 << (bits - 1) } else { 0..1_i128 << bits };
                let value = value.filter(|v| range.contains(v)).ok_or_else(wrong)?;
                out.copy_from_slice(&value.to_le_bytes()[..8]);
            }
        }
        Ok(out)
    }
}

impl<R: BufRead> Read for Text<R> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let width = self.voxel_type.bytes();
        let mut word = Vec::new();
        let mut done = 0;
        while done < out.len() {
            if self.left.1 == 0 {
                self.word(&mut word)?;
                if word.is_empty() {
                    break;
                }
                self.left = (self.stored(&word)?, width);
                self.numbers += 1;
            }
            let (bytes, left) = self.left;
            let run = left.min(out.len() - done);
            out[done..done + run].copy_from_slice(&bytes[width - left..width - left + run]);
            self.left.1 -= run;
            done += run;
        }
        Ok(done)
    }
}
