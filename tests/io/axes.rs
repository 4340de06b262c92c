//! Components and frames: wherever their axes lie in the file, a component of a frame is the same volume.

use super::files::*;
use burin::io;
use burin::io::IoError;
use burin::volume::{Value, VoxelType, Voxels};
use burin::with_voxels;

/// The voxels for which `at` (all file axes, fastest first) has `fixed[a]` where that is given.
fn reference(all: &Voxels, sizes: &[usize], fixed: &[Option<usize>]) -> Voxels {
    fn pick<T: Value>(v: &[T], sizes: &[usize], fixed: &[Option<usize>]) -> Voxels {
        let mut out = Vec::new();
        for (n, &x) in v.iter().enumerate() {
            let mut rest = n;
            let kept = sizes.iter().zip(fixed).all(|(&len, fix)| {
                let at = rest % len;
                rest /= len;
                fix.is_none_or(|f| f == at)
            });
            if kept {
                out.push(x);
            }
        }
        T::wrap(out)
    }
    with_voxels!(all, v => pick(v, sizes, fixed))
}

fn check(path: &std::path::Path, dims: [u32; 3], component: u32, frame: u32, expected: &Voxels) {
    let opened = io::open(path).unwrap();
    assert_eq!(opened.grid.dims, dims, "{path:?}");
    let source = opened.source(component, frame, &|_| true).unwrap();
    assert_eq!(source.read([0; 3], dims).unwrap().as_bytes(), expected.as_bytes(), "{path:?} {component} {frame}");
    let (lo, size) = ([1, 0, 1], [dims[0] - 1, dims[1], dims[2] - 1]);
    let part = reference_box(expected, dims, lo, size);
    assert_eq!(source.read(lo, size).unwrap().as_bytes(), part.as_bytes(), "{path:?} {component} {frame}");
}

#[test]
fn components_of_nrrd_lie_on_any_axis() {
    let folder = tempfile::tempdir().unwrap();
    for place in 0..4 {
        // 70 and 300 make the whole larger than what is picked from one piece in memory, and each piece smaller.
        let mut sizes = vec![70, 6, 300];
        sizes.insert(place, 3);
        let voxels = noise(VoxelType::I32, sizes.iter().product(), 4);
        let mut directions = vec!["(1,0,0)", "(0,1,0)", "(0,0,1)"];
        directions.insert(place, "none");
        let mut kinds = vec!["domain"; 3];
        kinds.insert(place, "list");
        let text = |v: &[usize]| v.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
        for (encoding, big) in [("raw", true), ("raw", false), ("gzip", true), ("gzip", false)] {
            let lines = [
                "type: int32",
                "dimension: 4",
                "space: RAS",
                &format!("sizes: {}", text(&sizes)),
                &format!("space directions: {}", directions.join(" ")),
                &format!("kinds: {}", kinds.join(" ")),
                &format!("encoding: {encoding}"),
                &format!("endian: {}", if big { "big" } else { "little" }),
            ];
            let raw = bytes_of(&voxels, big);
            let data = if encoding == "raw" { raw } else { gzip(&raw) };
            let path = keep(&folder, "a.nrrd", &nrrd(&lines, &data));
            let opened = io::open(&path).unwrap();
            assert_eq!((opened.components, opened.frames), (3, 1));
            for c in [0, 2] {
                let mut fixed = vec![None; 4];
                fixed[place] = Some(c);
                check(&path, [70, 6, 300], c as u32, 0, &reference(&voxels, &sizes, &fixed));
            }
        }
    }
}

#[test]
fn a_voxel_of_many_components_is_read_by_component() {
    let folder = tempfile::tempdir().unwrap();
    let sizes = [4000, 4, 3, 2];
    let voxels = noise(VoxelType::U16, sizes.iter().product(), 5);
    let lines =
        ["type: uint16", "dimension: 4", "sizes: 4000 4 3 2", "kinds: list domain domain domain", "endian: big"];
    for (encoding, data) in
        [("encoding: raw", bytes_of(&voxels, true)), ("encoding: gz", gzip(&bytes_of(&voxels, true)))]
    {
        let path = keep(&folder, "a.nrrd", &nrrd(&[&lines[..], &[encoding]].concat(), &data));
        check(&path, [4, 3, 2], 3998, 0, &reference(&voxels, &sizes, &[Some(3998), None, None, None]));
    }
}

#[test]
fn two_axes_beside_space_are_components_and_frames() {
    let folder = tempfile::tempdir().unwrap();
    let sizes = [2, 5, 4, 3, 6];
    let voxels = noise(VoxelType::U16, sizes.iter().product(), 5);
    let lines = [
        "type: ushort",
        "dimension: 5",
        "space: LPS",
        "sizes: 2 5 4 3 6",
        "kinds: complex domain domain domain time",
        "space directions: none (1,0,0) (0,1,0) (0,0,1) none",
        "encoding: raw",
        "endian: little",
    ];
    let path = keep(&folder, "a.nrrd", &nrrd(&lines, &bytes_of(&voxels, false)));
    let opened = io::open(&path).unwrap();
    assert_eq!((opened.components, opened.frames), (2, 6));
    for (c, f) in [(0, 0), (1, 0), (0, 5), (1, 3)] {
        let fixed = [Some(c), None, None, None, Some(f)];
        check(&path, [5, 4, 3], c as u32, f as u32, &reference(&voxels, &sizes, &fixed));
    }
    let opened = io::open(&path).unwrap();
    let asked = |c, f| opened.source(c, f, &|_| true).unwrap_err();
    assert!(matches!(asked(2, 0), IoError::NoSuch { what: "components", count: 2, asked: 2, .. }));
    assert!(matches!(asked(0, 6), IoError::NoSuch { what: "frames", count: 6, asked: 6, .. }));
}

#[test]
fn axes_without_directions_go_by_kind_and_place() {
    let folder = tempfile::tempdir().unwrap();
    let count = |lines: &[&str]| {
        let all = [&["type: uchar", "encoding: raw"], lines].concat();
        let opened = io::open(keep(&folder, "a.nrrd", &nrrd(&all, &[0; 840]))).unwrap();
        (opened.grid.dims, opened.components, opened.frames)
    };
    let sizes4 = ["dimension: 4", "sizes: 4 5 6 7"];
    assert_eq!(count(&sizes4), ([4, 5, 6], 1, 7));
    assert_eq!(count(&[&sizes4[..], &["kinds: vector domain domain domain"]].concat()), ([5, 6, 7], 4, 1));
    assert_eq!(count(&[&sizes4[..], &["kinds: domain domain domain time"]].concat()), ([4, 5, 6], 1, 7));
    assert_eq!(count(&[&sizes4[..], &["kinds: domain domain domain list"]].concat()), ([4, 5, 6], 7, 1));
    assert_eq!(count(&[&sizes4[..], &["kinds: ??? space RGBA-color space"]].concat()), ([4, 5, 7], 6, 1));
    let none_last = ["space: RAS", "space directions: (1,0,0) (0,1,0) (0,0,1) none"];
    assert_eq!(count(&[&sizes4[..], &none_last].concat()), ([4, 5, 6], 1, 7));
    let none_first = ["space: RAS", "space directions: none (1,0,0) (0,1,0) (0,0,1)"];
    assert_eq!(count(&[&sizes4[..], &none_first].concat()), ([5, 6, 7], 4, 1));
    let time = ["space: RAST", "space directions: (1,0,0,0) (0,1,0,0) (0,0,1,0) (0,0,0,2)"];
    assert_eq!(count(&[&sizes4[..], &time, &["kinds: domain domain domain time"]].concat()), ([4, 5, 6], 1, 7));
    // As ITK writes series and pictures.
    let itk = ["space dimension: 4", "space directions: (1,0,0,0) (0,1,0,0) (0,0,1,0) (0,0,0,2)"];
    assert_eq!(count(&[&sizes4[..], &itk, &["space origin: (1,2,3,4)"]].concat()), ([4, 5, 6], 1, 7));
    let flat = ["space dimension: 2", "space directions: (1,0) (0,2)", "space origin: (1,2)"];
    assert_eq!(count(&[&["dimension: 2", "sizes: 8 9"], &flat[..]].concat()), ([8, 9, 1], 1, 1));
    assert_eq!(count(&["dimension: 2", "sizes: 8 9"]), ([8, 9, 1], 1, 1));
    assert_eq!(count(&["dimension: 1", "sizes: 9", "spacings: 2"]), ([9, 1, 1], 1, 1));
    let flat = ["dimension: 2", "sizes: 8 9", "space: LPS", "space directions: (0,2,0) (0,0,3)"];
    assert_eq!(count(&flat), ([8, 9, 1], 1, 1));
}

#[test]
fn frames_and_components_of_nifti_are_dim_4_and_5() {
    let folder = tempfile::tempdir().unwrap();
    let sizes = [5, 4, 3, 2, 6];
    let voxels = noise(VoxelType::F64, sizes.iter().product(), 6);
    let file = Nifti::new(VoxelType::F64, &[5, 4, 3, 2, 6], true).with(&voxels);
    for path in [keep(&folder, "a.nii", &file), keep(&folder, "a.nii.gz", &gzip(&file))] {
        let opened = io::open(&path).unwrap();
        assert_eq!((opened.components, opened.frames), (6, 2));
        for (f, c) in [(0, 0), (1, 0), (0, 5), (1, 3)] {
            let fixed = [None, None, None, Some(f), Some(c)];
            check(&path, [5, 4, 3], c as u32, f as u32, &reference(&voxels, &sizes, &fixed));
        }
    }
}

#[test]
fn colour_and_complex_voxels_of_nifti_are_components() {
    let folder = tempfile::tempdir().unwrap();
    for (code, parts, ty) in
        [(128, 3, VoxelType::U8), (2304, 4, VoxelType::U8), (32, 2, VoxelType::F32), (1792, 2, VoxelType::F64)]
    {
        let sizes = [parts, 5, 4, 3];
        let voxels = noise(ty, sizes.iter().product(), 6);
        let mut header = Nifti::new(ty, &[5, 4, 3], false);
        header.i16(70, code).i16(72, (parts * ty.bytes() * 8) as i16).f32s(112, &[2.0, 1.0]);
        let path = keep(&folder, "a.nii", &header.with(&voxels));
        let opened = io::open(&path).unwrap();
        assert_eq!((opened.components, opened.voxel_type), (parts as u32, ty));
        // The standard: slope and intercept are not for colours.
        assert_eq!(opened.scaling, if ty == VoxelType::U8 { (1.0, 0.0) } else { (2.0, 1.0) });
        for c in 0..parts {
            check(&path, [5, 4, 3], c as u32, 0, &reference(&voxels, &sizes, &[Some(c), None, None, None]));
        }
    }
}
