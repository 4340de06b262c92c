//! Gzip on all cores: pieces are deflated side by side, each ending on a byte, and follow one another as one member, since
//! many readers of NRRD stop after the first.

use flate2::{Compress, CompressError, Compression, Crc, FlushCompress};
use rayon::prelude::*;
use std::io::Write;

/// Bytes deflated at once. What came before a piece is not known to it, which costs well under a hundredth.
const PIECE: usize = 1 << 20;

/// Noise of scanners gains nothing from more.
const LEVEL: u32 = 2;

/// A gzip member under construction.
#[derive(Debug)]
pub(crate) struct Gzip<W> {
    out: W,
    sum: Crc,
}

impl<W: Write> Gzip<W> {
    /// Writes the member's head: deflate, no name, no time, unknown system.
    pub(crate) fn new(mut out: W) -> std::io::Result<Self> {
        out.write_all(&[0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 255])?;
        Ok(Self { out, sum: Crc::new() })
    }

    /// Writes the end of the deflate stream (an empty last block), the checksum and the length.
    pub(crate) fn finish(mut self) -> std::io::Result<()> {
        self.out.write_all(&[3, 0])?;
        self.out.write_all(&self.sum.sum().to_le_bytes())?;
        self.out.write_all(&self.sum.amount().to_le_bytes())
    }
}

impl<W: Write> Write for Gzip<W> {
    /// Takes all of it.
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let pieces = bytes.par_chunks(PIECE).map(piece).collect::<Result<Vec<_>, _>>()?;
        for (deflated, sum) in pieces {
            self.out.write_all(&deflated)?;
            self.sum.combine(&sum);
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}

/// Deflate blocks that end on a byte and are not the stream's last, and the piece's checksum.
fn piece(bytes: &[u8]) -> Result<(Vec<u8>, Crc), CompressError> {
    let mut sum = Crc::new();
    sum.update(bytes);
    let mut deflate = Compress::new(Compression::new(LEVEL), false);
    let mut out = Vec::with_capacity(bytes.len() / 2 + 1024);
    loop {
        deflate.compress_vec(&bytes[deflate.total_in() as usize..], &mut out, FlushCompress::Sync)?;
        // Room that is left over says that nothing waits for more.
        if deflate.total_in() == bytes.len() as u64 && out.len() < out.capacity() {
            return Ok((out, sum));
        }
        out.reserve(out.capacity());
    }
}
