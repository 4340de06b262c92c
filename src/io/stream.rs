//! The block of a [`Layout`] from its first byte on, decoded, whatever it is encoded in and however many files it lies in.

use crate::io::codec::decode::Encoding;
use crate::io::codec::inflate::open_file;
use crate::io::error::IoError;
use crate::io::layout::{CHUNK, Layout, Skip, to_native};
use crate::volume::Value;
use std::fs::File;
use std::io::{Error, ErrorKind, Read, Seek, SeekFrom, copy, sink};

enum Input {
    Raw(File),
    Decoded(Box<dyn Read + Send>),
}

/// A reader of decoded bytes, over as many files as the block has.
pub(super) struct Stream<'a> {
    layout: &'a Layout,
    /// The file that is being read, and how much of its share is left.
    file: usize,
    left: u64,
    from: Input,
    passed: u64,
}

impl<'a> Stream<'a> {
    pub(super) fn new(layout: &'a Layout) -> Result<Self, IoError> {
        let mut stream = Self { layout, file: 0, left: 0, from: Input::Decoded(Box::new(std::io::empty())), passed: 0 };
        stream.open(0)?;
        Ok(stream)
    }

    /// Starts with one of the files.
    fn open(&mut self, file: usize) -> Result<(), IoError> {
        let layout = self.layout;
        let data = &layout.data[file];
        self.file = file;
        self.left = layout.file_bytes().unwrap_or(0);
        if layout.encoding == Encoding::Raw {
            let mut opened = open_file(&data.path)?;
            opened.seek(SeekFrom::Start(data.start)).map_err(IoError::system(&data.path, "read the file"))?;
            self.from = Input::Raw(opened);
            return Ok(());
        }
        let open = || layout.encoding.open(&data.path, data.start, layout.voxel_type);
        let skip = match layout.skip {
            Skip::Bytes(skip) => skip,
            // How much there is before the voxels only the end tells.
            Skip::AllBut(behind) => {
                let all = copy(&mut open()?, &mut sink()).map_err(|e| self.failed(e))?;
                let needed = self.left.saturating_add(behind);
                all.checked_sub(needed).ok_or_else(|| IoError::Truncated {
                    file: layout.file.clone(),
                    found: format!("{all} bytes, decoded"),
                    expected: format!("{} bytes and {behind} behind them", self.left),
                })?
            }
        };
        let mut from = open()?;
        match copy(&mut from.by_ref().take(skip), &mut sink()) {
            Ok(n) if n == skip => {}
            Ok(_) => return Err(self.failed(ErrorKind::UnexpectedEof.into())),
            Err(error) => return Err(self.failed(error)),
        }
        self.from = Input::Decoded(from);
        Ok(())
    }

    /// The file with the next byte.
    fn proceed(&mut self) -> Result<(), IoError> {
        if self.left == 0 {
            self.check_end()?;
            self.open(self.file + 1)?;
        }
        Ok(())
    }

    /// The next voxels.
    pub(super) fn fill<T: Value>(&mut self, out: &mut [T]) -> Result<(), IoError> {
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(out);
        let mut done = 0;
        while done < bytes.len() {
            self.proceed()?;
            let run = (bytes.len() - done).min(usize::try_from(self.left).unwrap_or(usize::MAX));
            self.passed += run as u64;
            let part = &mut bytes[done..done + run];
            let read = match &mut self.from {
                Input::Raw(file) => file.read_exact(part),
                Input::Decoded(from) => from.read_exact(part),
            };
            read.map_err(|e| self.failed(e))?;
            self.left -= run as u64;
            done += run;
        }
        to_native(bytes, size_of::<T>(), self.layout.big_endian);
        Ok(())
    }

    /// Passes over bytes of the block.
    pub(super) fn skip(&mut self, mut bytes: u64) -> Result<(), IoError> {
        while bytes > 0 {
            self.proceed()?;
            let run = bytes.min(self.left);
            self.passed += run;
            let skipped = match &mut self.from {
                Input::Raw(file) => i64::try_from(run)
                    .map_err(|_| ErrorKind::UnexpectedEof.into())
                    .and_then(|n| file.seek_relative(n))
                    .map(|()| run),
                Input::Decoded(from) => copy(&mut from.by_ref().take(run), &mut sink()),
            };
            match skipped {
                Ok(n) if n == run => {}
                Ok(_) => return Err(self.failed(ErrorKind::UnexpectedEof.into())),
                Err(error) => return Err(self.failed(error)),
            }
            self.left -= run;
            bytes -= run;
        }
        Ok(())
    }

    /// Reads on to the end of a compressed stream, if it is near, so that its checksum is looked at.
    pub(super) fn check_end(&mut self) -> Result<(), IoError> {
        match (&mut self.from, self.layout.encoding) {
            (Input::Decoded(from), Encoding::Gzip | Encoding::Bzip2) => {
                let rest = copy(&mut from.by_ref().take(CHUNK as u64), &mut sink());
                rest.map(|_| ()).map_err(|e| self.failed(e))
            }
            _ => Ok(()),
        }
    }

    fn failed(&self, error: Error) -> IoError {
        let layout = self.layout;
        let file = match &layout.data[..] {
            [_] => layout.file.clone(),
            several => format!("{} ({})", layout.file, several[self.file].path.display()),
        };
        match error.kind() {
            ErrorKind::UnexpectedEof => IoError::Truncated {
                file,
                found: format!("an end after less than {} bytes", self.passed),
                expected: format!("{} bytes", layout.bytes().unwrap_or(u64::MAX)),
            },
            ErrorKind::InvalidInput | ErrorKind::InvalidData => {
                IoError::Damaged { file, encoding: layout.encoding.name(), reason: error.to_string() }
            }
            _ => IoError::System { file, action: "read the file", source: error },
        }
    }
}
