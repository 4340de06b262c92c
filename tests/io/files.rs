//! Files made byte by byte from the formats' definitions (nifti1.h; teem's NRRD format page), for every test of readers.

use burin::volume::{VoxelType, Voxels};
use burin::with_voxels;
use flate2::{Compression, write::GzEncoder};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::io::Write;

pub const ALL_TYPES: [VoxelType; 10] = [
    VoxelType::U8,
    VoxelType::I8,
    VoxelType::U16,
    VoxelType::I16,
    VoxelType::U32,
    VoxelType::I32,
    VoxelType::U64,
    VoxelType::I64,
    VoxelType::F32,
    VoxelType::F64,
];

pub fn random(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// Random bits: every value of integers, and NaN, infinities and subnormals of floats.
pub fn noise(ty: VoxelType, count: usize, seed: u64) -> Voxels {
    let mut voxels = Voxels::try_zeroed(ty, count).unwrap();
    random(seed).fill(voxels.as_bytes_mut());
    voxels
}

/// The voxels' bytes in a byte order.
pub fn bytes_of(voxels: &Voxels, big: bool) -> Vec<u8> {
    let mut bytes = voxels.as_bytes().to_vec();
    if big != cfg!(target_endian = "big") {
        bytes.chunks_exact_mut(voxels.voxel_type().bytes()).for_each(<[u8]>::reverse);
    }
    bytes
}

pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

pub fn bzip2(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// Datatype code and bits, nifti1.h.
pub fn nifti_code(ty: VoxelType) -> (i16, i16) {
    match ty {
        VoxelType::U8 => (2, 8),
        VoxelType::I16 => (4, 16),
        VoxelType::I32 => (8, 32),
        VoxelType::F32 => (16, 32),
        VoxelType::F64 => (64, 64),
        VoxelType::I8 => (256, 8),
        VoxelType::U16 => (512, 16),
        VoxelType::U32 => (768, 32),
        VoxelType::I64 => (1024, 64),
        VoxelType::U64 => (1280, 64),
    }
}

/// A NIfTI-1 header under construction; field offsets as in nifti1.h.
#[derive(Clone)]
pub struct Nifti {
    pub bytes: Vec<u8>,
    pub big: bool,
}

impl Nifti {
    /// 1 mm voxels, no form, voxels right behind the header.
    pub fn new(ty: VoxelType, dims: &[i16], big: bool) -> Self {
        let mut header = Self { bytes: vec![0; 352], big };
        header.i32(0, 348);
        header.i16(40, dims.len() as i16);
        for a in 0..7 {
            header.i16(42 + 2 * a, dims.get(a).copied().unwrap_or(1));
        }
        let (code, bits) = nifti_code(ty);
        header.i16(70, code).i16(72, bits).f32s(76, &[1.0; 8]).f32(108, 352.0);
        header.bytes[344..348].copy_from_slice(b"n+1\0");
        header
    }

    /// The same as NIfTI-2; field offsets as in nifti2.h.
    pub fn second(ty: VoxelType, dims: &[i64], big: bool) -> Self {
        let mut header = Self { bytes: vec![0; 544], big };
        header.bytes[4..12].copy_from_slice(b"n+2\0\r\n\x1a\n");
        let (code, bits) = nifti_code(ty);
        header.i32(0, 540).i16(12, code).i16(14, bits).put(16, (dims.len() as i64).to_le_bytes());
        for a in 0..7 {
            header.put(24 + 8 * a, dims.get(a).copied().unwrap_or(1).to_le_bytes());
        }
        header.f64s(104, &[1.0; 8]).put(168, 544_i64.to_le_bytes()).clone()
    }

    pub fn f64s(&mut self, at: usize, xs: &[f64]) -> &mut Self {
        for (i, &x) in xs.iter().enumerate() {
            self.put(at + 8 * i, x.to_le_bytes());
        }
        self
    }

    pub fn put<const N: usize>(&mut self, at: usize, mut bytes: [u8; N]) -> &mut Self {
        if self.big {
            bytes.reverse();
        }
        self.bytes[at..at + N].copy_from_slice(&bytes);
        self
    }

    pub fn i16(&mut self, at: usize, x: i16) -> &mut Self {
        self.put(at, x.to_le_bytes())
    }

    pub fn i32(&mut self, at: usize, x: i32) -> &mut Self {
        self.put(at, x.to_le_bytes())
    }

    pub fn f32(&mut self, at: usize, x: f32) -> &mut Self {
        self.put(at, x.to_le_bytes())
    }

    pub fn f32s(&mut self, at: usize, xs: &[f32]) -> &mut Self {
        for (i, &x) in xs.iter().enumerate() {
            self.f32(at + 4 * i, x);
        }
        self
    }

    /// The whole file.
    pub fn with(&self, voxels: &Voxels) -> Vec<u8> {
        [self.bytes.clone(), bytes_of(voxels, self.big)].concat()
    }
}

/// A NRRD file with an attached header of these lines.
pub fn nrrd(lines: &[&str], data: &[u8]) -> Vec<u8> {
    let mut file = format!("NRRD0004\n{}\n\n", lines.join("\n")).into_bytes();
    file.extend_from_slice(data);
    file
}

/// The voxel at an index of all voxels, by the definition of "x fastest".
pub fn reference_box(all: &Voxels, dims: [u32; 3], lo: [u32; 3], size: [u32; 3]) -> Voxels {
    fn gather<T: burin::volume::Value>(v: &[T], dims: [u32; 3], lo: [u32; 3], size: [u32; 3]) -> Voxels {
        let mut out = Vec::new();
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let index = (lo[0] + x) as usize
                        + dims[0] as usize * ((lo[1] + y) as usize + dims[1] as usize * (lo[2] + z) as usize);
                    out.push(v[index]);
                }
            }
        }
        T::wrap(out)
    }
    with_voxels!(all, v => gather(v, dims, lo, size))
}

/// Writes bytes as a file of a folder.
pub fn keep(folder: &tempfile::TempDir, name: &str, bytes: &[u8]) -> std::path::PathBuf {
    let path = folder.path().join(name);
    // Some file systems wait for the disk when a file is cut and written anew, but not when it is new.
    let _ = std::fs::remove_file(&path);
    std::fs::write(&path, bytes).unwrap();
    path
}
