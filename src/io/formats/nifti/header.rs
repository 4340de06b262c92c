//! The fields of a NIfTI header, of version 1 (348 bytes; nifti1.h, 2005) or 2 (540 bytes; nifti2.h, 2011): the same fields at other
//! places, wider.

use crate::io::error::IoError;

/// Size of the headers, and what their first field says.
const SIZES: [usize; 2] = [348, 540];

/// The fields that say what voxels are, where they are in the file and in the world.
#[derive(Clone, Debug)]
pub(crate) struct Header {
    pub(crate) file: String,
    /// 1 or 2.
    pub(crate) version: u8,
    pub(crate) big_endian: bool,
    /// Whether the voxels follow in the same file.
    pub(crate) single: bool,
    /// `dim[0]` is how many of the others count.
    pub(crate) dim: [i64; 8],
    pub(crate) datatype: i16,
    pub(crate) bitpix: i16,
    /// `pixdim[0]` is the sign of k in the qform.
    pub(crate) pixdim: [f64; 8],
    pub(crate) vox_offset: f64,
    pub(crate) slope: f64,
    pub(crate) intercept: f64,
    pub(crate) xyzt_units: i32,
    pub(crate) qform_code: i32,
    pub(crate) sform_code: i32,
    /// `quatern_b`, `_c`, `_d`.
    pub(crate) quaternion: [f64; 3],
    /// `qoffset_x`, `_y`, `_z`.
    pub(crate) offset: [f64; 3],
    /// `srow_x`, `_y`, `_z`.
    pub(crate) rows: [[f64; 4]; 3],
}

impl Header {
    /// Reads a header from a file's first bytes.
    pub(crate) fn new(file: &str, head: &[u8]) -> Result<Self, IoError> {
        let wrong = |field: &str, found: String, expected: &str| Err(IoError::field(file, field, found, expected));
        let size = |big_endian| Bytes { bytes: head, big_endian }.i32(0);
        let short = || IoError::Truncated {
            file: file.into(),
            found: format!("{} bytes", head.len()),
            expected: "a NIfTI header of 348 or 540 bytes before the voxels".into(),
        };
        if head.len() < SIZES[0] {
            return Err(short());
        }
        let found = [false, true].into_iter().find_map(|big_endian| {
            let version = SIZES.iter().position(|&s| i32::try_from(s) == Ok(size(big_endian)))?;
            Some((version, big_endian))
        });
        let Some((version, big_endian)) = found else {
            return wrong("sizeof_hdr", size(false).to_string(), "348 (NIfTI-1) or 540 (NIfTI-2) in either byte order");
        };
        if head.len() < SIZES[version] {
            return Err(short());
        }
        let bytes = Bytes { bytes: head, big_endian };
        let magic = if version == 0 { &head[344..348] } else { &head[4..12] };
        let single = match magic {
            b"n+1\0" | b"n+2\0\r\n\x1a\n" => true,
            b"ni1\0" | b"ni2\0\r\n\x1a\n" => false,
            found => {
                let expected = match version {
                    0 => "\"n+1\" or \"ni1\"; if it is Analyze 7.5, convert it to NIfTI-1",
                    _ => "\"n+2\" or \"ni2\" with \"\\r\\n\\x1a\\n\" behind it; if it was sent as text, get it again",
                };
                return wrong("magic", format!("\"{}\"", String::from_utf8_lossy(found)), expected);
            }
        };
        Ok(if version == 0 { bytes.first(file, single) } else { bytes.second(file, single) })
    }

    pub(crate) fn wrong(&self, field: &str, found: impl std::fmt::Display, expected: &str) -> IoError {
        IoError::field(&self.file, field, found, expected)
    }
}

/// A header's bytes, by offset.
#[derive(Clone, Copy)]
struct Bytes<'a> {
    bytes: &'a [u8],
    big_endian: bool,
}

impl Bytes<'_> {
    fn at<const N: usize>(self, at: usize) -> [u8; N] {
        let mut out = [0; N];
        out.copy_from_slice(&self.bytes[at..at + N]);
        if self.big_endian != cfg!(target_endian = "big") {
            out.reverse();
        }
        out
    }

    fn i16(self, at: usize) -> i16 {
        i16::from_ne_bytes(self.at(at))
    }

    fn i32(self, at: usize) -> i32 {
        i32::from_ne_bytes(self.at(at))
    }

    fn i64(self, at: usize) -> i64 {
        i64::from_ne_bytes(self.at(at))
    }

    fn f32(self, at: usize) -> f64 {
        f64::from(f32::from_ne_bytes(self.at(at)))
    }

    fn f64(self, at: usize) -> f64 {
        f64::from_ne_bytes(self.at(at))
    }

    fn first(self, file: &str, single: bool) -> Header {
        let row = |at: usize| std::array::from_fn(|c| self.f32(at + 4 * c));
        Header {
            file: file.into(),
            version: 1,
            big_endian: self.big_endian,
            single,
            dim: std::array::from_fn(|a| self.i16(40 + 2 * a).into()),
            datatype: self.i16(70),
            bitpix: self.i16(72),
            pixdim: std::array::from_fn(|a| self.f32(76 + 4 * a)),
            vox_offset: self.f32(108),
            slope: self.f32(112),
            intercept: self.f32(116),
            xyzt_units: self.bytes[123].into(),
            qform_code: self.i16(252).into(),
            sform_code: self.i16(254).into(),
            quaternion: std::array::from_fn(|a| self.f32(256 + 4 * a)),
            offset: std::array::from_fn(|a| self.f32(268 + 4 * a)),
            rows: [row(280), row(296), row(312)],
        }
    }

    fn second(self, file: &str, single: bool) -> Header {
        let row = |at: usize| std::array::from_fn(|c| self.f64(at + 8 * c));
        Header {
            file: file.into(),
            version: 2,
            big_endian: self.big_endian,
            single,
            dim: std::array::from_fn(|a| self.i64(16 + 8 * a)),
            datatype: self.i16(12),
            bitpix: self.i16(14),
            pixdim: std::array::from_fn(|a| self.f64(104 + 8 * a)),
            vox_offset: self.i64(168) as f64,
            slope: self.f64(176),
            intercept: self.f64(184),
            xyzt_units: self.i32(500),
            qform_code: self.i32(344),
            sform_code: self.i32(348),
            quaternion: std::array::from_fn(|a| self.f64(352 + 8 * a)),
            offset: std::array::from_fn(|a| self.f64(376 + 8 * a)),
            rows: [row(400), row(432), row(464)],
        }
    }
}
