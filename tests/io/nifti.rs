//! Fields of NIfTI-1 headers: what is taken, what is refused, and in which words.

use super::files::*;
use burin::io;
use burin::volume::{VoxelType, Voxels};

fn voxels() -> Voxels {
    noise(VoxelType::I16, 60, 1)
}

fn header() -> Nifti {
    let mut header = Nifti::new(VoxelType::I16, &[3, 4, 5], false);
    header.i16(252, 1);
    header
}

/// The error's text, which must name the file and the field, what was found and what was expected.
fn refused(folder: &tempfile::TempDir, bytes: &[u8], field: &str, found: &str) -> String {
    let text = io::open(keep(folder, "bad.nii", bytes)).unwrap_err().to_string();
    for part in ["bad.nii", field, &format!("found {found}"), "expected"] {
        assert!(text.contains(part), "no {part} in: {text}");
    }
    text
}

#[test]
fn headers_that_cannot_be_are_refused_by_field() {
    let folder = tempfile::tempdir().unwrap();
    let bad = |at: usize, x: i16, field: &str, found: &str| {
        let mut h = header();
        h.i16(at, x);
        refused(&folder, &h.with(&voxels()), field, found);
    };
    bad(40, 0, "dim[0]", "0");
    bad(40, 8, "dim[0]", "8");
    bad(40, -3, "dim[0]", "-3");
    bad(42, 0, "dim[1]", "0");
    bad(44, -4, "dim[2]", "-4");
    bad(46, i16::MIN, "dim[3]", "-32768");
    bad(70, 0, "datatype", "0");
    bad(70, 1, "datatype", "1 (binary)");
    bad(70, 1536, "datatype", "1536 (128-bit float)");
    bad(70, 2048, "datatype", "2048 (256-bit complex)");
    bad(70, -7, "datatype", "-7");
    let mut h = header();
    h.i16(40, 4).i16(48, -1);
    refused(&folder, &h.with(&voxels()), "dim[4]", "-1");
    for (offset, found) in [(-1.0, "-1"), (352.5, "352.5"), (f32::NAN, "NaN"), (f32::INFINITY, "inf")] {
        let mut h = header();
        h.f32(108, offset);
        refused(&folder, &h.with(&voxels()), "vox_offset", found);
    }
    let mut h = header();
    h.i32(0, 347);
    refused(&folder, &h.with(&voxels()), "sizeof_hdr", "347");
    h.i32(0, 540);
    refused(&folder, &[&h.with(&voxels())[..], &[0; 200]].concat(), "magic", "");
    assert!(refused(&folder, &h.with(&voxels())[..400], "a NIfTI header", "400 bytes").contains("540 bytes"));
    let second = Nifti::second(VoxelType::I16, &[3, 4, 5], false);
    let mut sent_as_text = second.clone();
    sent_as_text.bytes[8] = b'\n';
    assert!(refused(&folder, &sent_as_text.with(&voxels()), "magic", "\"n+2").contains("as text"));
    for (at, x, field, found) in [
        (16, 9_i64, "dim[0]", "9"),
        (24, 0, "dim[1]", "0"),
        (32, -1, "dim[2]", "-1"),
        (40, 1 << 40, "dim[3]", "1099511627776"),
        (168, -3, "vox_offset", "-3"),
        (168, i64::MAX, "vox_offset", "9223372036854775807"),
    ] {
        let mut h = second.clone();
        h.put(at, x.to_le_bytes());
        refused(&folder, &h.with(&voxels()), field, &found[..found.len().min(10)]);
    }
    let mut h = header();
    h.bytes[344..348].copy_from_slice(b"\0\0\0\0");
    assert!(refused(&folder, &h.with(&voxels()), "magic", "\"\\0\\0\\0\\0\"").contains("Analyze"));
    h.bytes[344..348].copy_from_slice(b"ni1\0");
    refused(&folder, &h.with(&voxels()), "magic", "\"ni1\"");
}

#[test]
fn oddities_that_do_no_harm_are_taken_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let open = |h: &Nifti| {
        let opened = io::open(keep(&folder, "odd.nii", &h.with(&voxels()))).unwrap();
        assert_eq!(opened.source(0, 0, &|_| true).unwrap().read([0; 3], [3, 4, 5]).unwrap(), voxels());
        (opened.warnings, opened.scaling)
    };
    assert_eq!(open(&header()), (vec![], (1.0, 0.0)));
    let mut h = header();
    h.i16(40, 5);
    h.i16(48, 0).i16(50, 0);
    assert_eq!(open(&h).0.len(), 2);
    let mut h = header();
    h.i16(72, 8);
    assert!(open(&h).0[0].starts_with("bitpix"));
    // Inside the header the voxels cannot be; 0 is what many writers leave there.
    let mut h = header();
    h.f32(108, 0.0);
    assert!(open(&h).0.is_empty());
    h.f32(108, 348.0);
    assert!(open(&h).0[0].starts_with("vox_offset"));
    // Extensions between header and voxels are passed over.
    let mut h = header();
    h.f32(108, 368.0);
    h.bytes.extend_from_slice(&[9; 16]);
    assert!(open(&h).0.is_empty());
    for (slope, inter, expected, warnings) in [
        (0.0, 5.0, (1.0, 0.0), 0),
        (f32::NAN, 5.0, (1.0, 0.0), 0),
        (f32::INFINITY, 5.0, (1.0, 0.0), 0),
        (2.0, f32::NAN, (2.0, 0.0), 1),
        (-0.5, 7.0, (-0.5, 7.0), 0),
        (1.0, -1024.0, (1.0, -1024.0), 0),
    ] {
        let mut h = header();
        h.f32s(112, &[slope, inter]);
        let (found, scaling) = open(&h);
        assert_eq!((found.len(), scaling), (warnings, expected), "{slope} {inter}");
    }
}

#[test]
fn dimensions_that_a_file_leaves_at_0_are_1_and_those_beyond_time_are_components() {
    let folder = tempfile::tempdir().unwrap();
    // As FSL, SPM and others leave pictures: counted as three dimensions, the third 0.
    for (rank, dims) in
        [(3, [12, 5, 0]), (2, [12, 5, 0]), (2, [12, 5, 9]), (3, [60, 0, 0]), (1, [60, 0, 0]), (3, [12, 5, 1])]
    {
        let mut h = header();
        h.i16(40, rank).i16(42, dims[0]).i16(44, dims[1]).i16(46, dims[2]);
        let opened = io::open(keep(&folder, "flat.nii", &h.with(&voxels()))).unwrap();
        let expected = if dims[0] == 60 { [60, 1, 1] } else { [12, 5, 1] };
        assert_eq!((opened.grid.dims, opened.components, opened.frames), (expected, 1, 1));
        assert_eq!(opened.source(0, 0, &|_| true).unwrap().read([0; 3], expected).unwrap(), voxels());
    }
    // x y z t and three more, in both versions.
    let sizes = [2, 3, 2, 2, 2, 3, 2];
    let all = noise(VoxelType::U16, sizes.iter().product(), 8);
    for second in [false, true] {
        let file = if second {
            Nifti::second(VoxelType::U16, &sizes.map(|s| s as i64), true).with(&all)
        } else {
            Nifti::new(VoxelType::U16, &sizes.map(|s| s as i16), true).with(&all)
        };
        let opened = io::open(keep(&folder, "seven.nii", &file)).unwrap();
        assert_eq!((opened.grid.dims, opened.components, opened.frames), ([2, 3, 2], 12, 2));
        assert!(opened.warnings.iter().any(|w| w.starts_with("dim[6] is 3")), "{:?}", opened.warnings);
        for frame in 0..2 {
            for component in 0..12 {
                // The first of the further dimensions runs fastest.
                let from = (frame + 2 * component) * 12;
                let Voxels::U16(numbers) = &all else { panic!() };
                let expected = Voxels::U16(numbers[from..from + 12].to_vec());
                let source = opened.source(component as u32, frame as u32, &|_| true).unwrap();
                assert_eq!(source.read([0; 3], [2, 3, 2]).unwrap(), expected, "{frame} {component}");
            }
        }
    }
}

#[test]
fn a_second_nifti_is_read_as_the_first_is() {
    let folder = tempfile::tempdir().unwrap();
    for (round, ty) in ALL_TYPES.into_iter().enumerate() {
        let big = round % 2 == 0;
        let numbers = noise(ty, 60, 3);
        let mut h = Nifti::second(ty, &[3, 4, 5], big);
        h.f64s(176, &[0.1, -7.0]);
        let file = h.with(&numbers);
        let mut pair = h.clone();
        pair.bytes[4..7].copy_from_slice(b"ni2");
        pair.bytes.truncate(540);
        pair.put(168, 0_i64.to_le_bytes());
        keep(&folder, "pair.img", &bytes_of(&numbers, big));
        for path in [
            keep(&folder, "a.nii", &file),
            keep(&folder, "a.nii.gz", &gzip(&file)),
            keep(&folder, "pair.hdr", &pair.bytes),
            folder.path().join("pair.img"),
        ] {
            let opened = io::open(path).unwrap();
            assert_eq!((opened.voxel_type, opened.scaling), (ty, (0.1, -7.0)));
            let read = opened.source(0, 0, &|_| true).unwrap().read([0; 3], [3, 4, 5]).unwrap();
            assert_eq!(read.as_bytes(), numbers.as_bytes());
        }
    }
}

#[test]
fn a_header_and_its_image_may_be_two_files() {
    let folder = tempfile::tempdir().unwrap();
    let mut h = header();
    h.bytes[344..348].copy_from_slice(b"ni1\0");
    h.f32(108, 16.0);
    h.bytes.truncate(348);
    let data = [vec![1; 16], bytes_of(&voxels(), false)].concat();
    let header_path = keep(&folder, "a.hdr", &h.bytes);
    assert!(io::open(&header_path).unwrap_err().to_string().contains(".img"));
    let image_path = keep(&folder, "a.img", &data);
    for path in [&header_path, &image_path] {
        let opened = io::open(path).unwrap();
        // Both are known: neither may be written over, and both are hashed.
        let mut names: Vec<_> = opened.files.iter().map(|f| f.path.file_name().unwrap().to_owned()).collect();
        names.sort();
        assert_eq!(names, ["a.hdr", "a.img"]);
        let source = opened.source(0, 0, &|_| true).unwrap();
        assert_eq!(source.read([0; 3], [3, 4, 5]).unwrap(), voxels());
    }
    std::fs::remove_file(&image_path).unwrap();
    std::fs::remove_file(&header_path).unwrap();
    keep(&folder, "a.img.gz", &gzip(&data));
    let source = io::open(keep(&folder, "a.hdr.gz", &gzip(&h.bytes))).unwrap().source(0, 0, &|_| true).unwrap();
    assert_eq!(source.read([0; 3], [3, 4, 5]).unwrap(), voxels());
}

#[test]
fn a_format_is_known_by_its_bytes_and_not_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    assert!(io::open(keep(&folder, "a.dat", &header().with(&voxels()))).is_ok());
    assert!(io::open(keep(&folder, "b", &gzip(&header().with(&voxels())))).is_ok());
    assert!(io::open(keep(&folder, "c.nrrd", &header().with(&voxels()))).is_ok());
    let error = |name: &str, bytes: &[u8]| io::open(keep(&folder, name, bytes)).unwrap_err().to_string();
    let text = error("d.xyz", b"some text");
    assert!(text.contains("some text") && text.contains("NIfTI-1") && text.contains("NRRD"), "{text}");
    assert!(error("empty.nii", b"").contains("0 bytes"));
    assert!(error("short.nii.gz", &gzip(&[0; 100])).contains("100 bytes"));
    assert!(error("empty.xyz", b"").contains("this is an empty file"));
    assert!(io::open(folder.path()).unwrap_err().to_string().contains("a folder"));
    let missing = io::open(folder.path().join("missing.nii")).unwrap_err().to_string();
    assert!(missing.contains("missing.nii") && missing.contains("open"), "{missing}");
}

#[test]
fn the_head_that_the_demo_shows_is_what_it_is() {
    let path = crate::common::root().join("assets/ch2.nii.gz");
    if !path.exists() {
        eprintln!("skipped: {} is absent", path.display());
        return;
    }
    let info = io::info(&path, &|_| true).unwrap();
    assert_eq!((info.dims, info.voxel_type), ([181, 217, 181], "u8"));
    assert_eq!(info.world_from_index, [[1.0, 0.0, 0.0, -90.0], [0.0, 1.0, 0.0, -125.0], [0.0, 0.0, 1.0, -71.0]]);
    // As nibabel and numpy have them.
    let numbers = [info.min.unwrap(), info.max.unwrap(), info.sum].map(burin::volume::Number::to_f64);
    assert_eq!(numbers, [0.0, 254.0, 317_151_210.0]);
}

#[test]
fn only_the_types_of_colours_are_colours() {
    let folder = tempfile::tempdir().unwrap();
    for (code, bits, ty, parts, colour) in [
        (32, 64, VoxelType::F32, 2, false),
        (1792, 128, VoxelType::F64, 2, false),
        (128, 24, VoxelType::U8, 3, true),
        (2304, 32, VoxelType::U8, 4, true),
        (256, 8, VoxelType::I8, 1, false),
        (2, 8, VoxelType::U8, 1, false),
    ] {
        let mut header = Nifti::new(ty, &[3, 4, 5], false);
        header.i16(70, code).i16(72, bits).i16(252, 1);
        let file = header.with(&noise(ty, 60 * parts as usize, 9));
        let opened = io::open(keep(&folder, "a.nii", &file)).unwrap();
        assert_eq!((opened.voxel_type, opened.components, opened.colour), (ty, parts, colour), "{code}");
        assert_eq!(opened.colours(0, &|_| true).unwrap().is_some(), colour, "{code}");
    }
}

#[test]
fn axes_that_are_not_there_are_as_long_as_those_that_are() {
    let folder = tempfile::tempdir().unwrap();
    for (dims, pixdim, spacing) in [
        (&[60][..], [2.0, 0.0, 0.0], [2.0, 2.0, 2.0]),
        (&[12, 5], [2.0, 3.0, 0.0], [2.0, 3.0, 2.0]),
        (&[12, 5], [4.0, 3.0, 0.0], [4.0, 3.0, 3.0]),
        (&[3, 4, 5], [2.0, 3.0, 4.0], [2.0, 3.0, 4.0]),
    ] {
        let mut header = Nifti::new(VoxelType::I16, dims, false);
        header.f32s(80, &pixdim);
        let opened = io::open(keep(&folder, "a.nii", &header.with(&voxels()))).unwrap();
        assert_eq!(opened.grid.spacing().to_array(), spacing, "{dims:?}");
    }
}
