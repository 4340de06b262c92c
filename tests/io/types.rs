//! Every number type in both byte orders, plain and compressed, in both formats.

use super::files::*;
use burin::io;
use burin::volume::{VoxelType, Voxels};
use rand::Rng;

const DIMS: [u32; 3] = [37, 5, 41];

/// Names of a type as teem's table has them; every one must be read.
fn spellings(ty: VoxelType) -> &'static [&'static str] {
    match ty {
        VoxelType::I8 => &["signed char", "int8", "int8_t"],
        VoxelType::U8 => &["uchar", "unsigned char", "uint8", "uint8_t", "UChar"],
        VoxelType::I16 => &["short", "short int", "signed short", "signed short int", "int16", "int16_t"],
        VoxelType::U16 => &["ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"],
        VoxelType::I32 => &["int", "signed int", "int32", "int32_t"],
        VoxelType::U32 => &["uint", "unsigned int", "uint32", "uint32_t"],
        VoxelType::I64 => {
            &["longlong", "long long", "long long int", "signed long long", "signed long long int", "int64", "int64_t"]
        }
        VoxelType::U64 => {
            &["ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t", "unsigned  long long"]
        }
        VoxelType::F32 => &["float"],
        VoxelType::F64 => &["double"],
    }
}

fn check(path: &std::path::Path, voxels: &Voxels) {
    let opened = io::open(path).unwrap();
    assert_eq!((opened.grid.dims, opened.voxel_type), (DIMS, voxels.voxel_type()), "{path:?}");
    assert_eq!((opened.components, opened.frames), (1, 1));
    let source = opened.source(0, 0, &|_| true).unwrap();
    let mut random = random(7);
    let mut boxes = vec![([0; 3], DIMS), ([36, 4, 40], [1; 3]), ([0, 0, 40], [37, 5, 1]), ([0, 1, 3], [37, 2, 30])];
    for _ in 0..20 {
        let lo: [u32; 3] = std::array::from_fn(|a| random.random_range(0..DIMS[a]));
        boxes.push((lo, std::array::from_fn(|a| random.random_range(1..=DIMS[a] - lo[a]))));
    }
    for (lo, size) in boxes {
        let read = source.read(lo, size).unwrap();
        assert_eq!(read.voxel_type(), voxels.voxel_type());
        // As bytes, since NaN differs from itself.
        assert_eq!(read.as_bytes(), reference_box(voxels, DIMS, lo, size).as_bytes(), "{path:?} {lo:?} {size:?}");
    }
    assert!(source.read([0, 0, 1], DIMS).is_err());
    assert!(source.read([u32::MAX, 0, 0], [1; 3]).is_err());
}

#[test]
fn nifti_voxels_are_the_files_in_every_type_and_byte_order() {
    let folder = tempfile::tempdir().unwrap();
    for ty in ALL_TYPES {
        let voxels = noise(ty, DIMS.iter().product::<u32>() as usize, 1);
        for big in [false, true] {
            let file = Nifti::new(ty, &DIMS.map(|d| d as i16), big).with(&voxels);
            check(&keep(&folder, "a.nii", &file), &voxels);
            check(&keep(&folder, "a.nii.gz", &gzip(&file)), &voxels);
        }
    }
}

#[test]
fn nrrd_voxels_are_the_files_in_every_type_spelling_and_byte_order() {
    let folder = tempfile::tempdir().unwrap();
    for ty in ALL_TYPES {
        let voxels = noise(ty, DIMS.iter().product::<u32>() as usize, 2);
        for big in [false, true] {
            for (i, spelling) in spellings(ty).iter().enumerate() {
                let raw = bytes_of(&voxels, big);
                let (encoding, data) = match i % 4 {
                    0 => ("raw", raw),
                    1 => ("gzip", gzip(&raw)),
                    2 => ("gz", gzip(&raw)),
                    _ => ("RAW", raw),
                };
                let lines = [
                    &format!("type: {spelling}"),
                    "dimension: 3",
                    "sizes: 37 5 41",
                    &format!("encoding: {encoding}"),
                    &format!("endian: {}", if big { "big" } else { "little" }),
                ];
                check(&keep(&folder, "a.nrrd", &nrrd(&lines, &data)), &voxels);
            }
        }
    }
    // Types with one spelling have not met gzip above.
    for ty in [VoxelType::F32, VoxelType::F64] {
        let voxels = noise(ty, DIMS.iter().product::<u32>() as usize, 3);
        let ty = format!("type: {}", spellings(ty)[0]);
        let lines = [&ty, "dimension: 3", "sizes: 37 5 41", "encoding: gzip", "endian: big"];
        check(&keep(&folder, "a.nrrd", &nrrd(&lines, &gzip(&bytes_of(&voxels, true)))), &voxels);
    }
}

#[test]
fn a_byte_order_is_what_it_says() {
    let folder = tempfile::tempdir().unwrap();
    let mut header = Nifti::new(VoxelType::U16, &[1, 1, 1], true);
    header.bytes.extend_from_slice(&[1, 2]);
    let source = io::open(keep(&folder, "a.nii", &header.bytes)).unwrap().source(0, 0, &|_| true).unwrap();
    assert_eq!(source.read([0; 3], [1; 3]).unwrap(), Voxels::U16(vec![258]));
}
