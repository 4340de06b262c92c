//! Fields as NIfTI: the header's numbers read byte by byte as nifti1.h and nifti2.h have them.

use super::export::{density, paint};
use super::files::*;
use super::places::{axis_orders, oblique};
use burin::io;
use burin::io::{Compression, Exported};
use burin::math::{DAffine3, DMat3, DQuat, DVec3};
use burin::volume::*;

const DIMS: [u32; 3] = [7, 5, 9];

fn write(
    folder: &tempfile::TempDir,
    name: &str,
    field: &Field,
    grid: &Grid,
    segments: &Segments,
) -> (Exported, Vec<u8>) {
    let path = folder.path().join(name);
    let exported = io::export(&path, field, grid, segments, Compression::Gzip, &|_| true).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    assert_eq!(exported.bytes, bytes.len() as u64);
    if name.ends_with(".gz") {
        let mut inflated = Vec::new();
        std::io::Read::read_to_end(&mut flate2::read::GzDecoder::new(&bytes[..]), &mut inflated).unwrap();
        bytes = inflated;
    }
    (exported, bytes)
}

fn i16_at(bytes: &[u8], at: usize) -> i16 {
    i16::from_le_bytes(bytes[at..at + 2].try_into().unwrap())
}

fn f32_at(bytes: &[u8], at: usize) -> f32 {
    f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

/// The sform, in the file's unit.
fn sform(bytes: &[u8]) -> [[f32; 4]; 3] {
    std::array::from_fn(|r| std::array::from_fn(|c| f32_at(bytes, 280 + 16 * r + 4 * c)))
}

/// Method 2 of nifti1.h.
fn qform(bytes: &[u8]) -> DAffine3 {
    let f = |at| f64::from(f32_at(bytes, at));
    let (x, y, z) = (f(256), f(260), f(264));
    // Close to a half turn the real part is 0: 32-bit numbers leave nothing of it.
    let w2 = 1.0 - x * x - y * y - z * z;
    let q = DQuat::from_xyzw(x, y, z, if w2 < 1e-7 { 0.0 } else { w2.sqrt() }).normalize();
    let scale = DVec3::new(f(80), f(84), f(88) * f(76));
    DAffine3 {
        matrix3: DMat3::from_quat(q) * DMat3::from_diagonal(scale),
        translation: DVec3::new(f(268), f(272), f(276)),
    }
}

fn rows(a: &DAffine3) -> [[f32; 4]; 3] {
    let m = a.matrix3;
    std::array::from_fn(|r| [m.x_axis[r], m.y_axis[r], m.z_axis[r], a.translation[r]].map(|v| v as f32))
}

/// What any program finds in the header.
fn check_header(bytes: &[u8], dims: [u32; 3], datatype: i16, bits: i16) {
    assert_eq!(i32::from_le_bytes(bytes[..4].try_into().unwrap()), 348);
    let found: Vec<i16> = (0..8).map(|a| i16_at(bytes, 40 + 2 * a)).collect();
    assert_eq!(found, [3, dims[0] as i16, dims[1] as i16, dims[2] as i16, 1, 1, 1, 1]);
    assert_eq!((i16_at(bytes, 70), i16_at(bytes, 72)), (datatype, bits));
    assert_eq!((f32_at(bytes, 108), &bytes[344..352]), (352.0, &b"n+1\0\0\0\0\0"[..]));
    assert!(i16_at(bytes, 254) > 0);
}

#[test]
fn density_that_nobody_edited_leaves_bit_for_bit_in_every_type() {
    let folder = tempfile::tempdir().unwrap();
    for ty in ALL_TYPES {
        for name in ["out.nii", "out.nii.gz", "OUT.NII"] {
            let grid = Grid { dims: DIMS, world_from_index: axis_orders()[17] };
            let voxels = noise(ty, grid.voxel_count() as usize, 11);
            let field = density(voxels.clone(), grid, (1.0, 0.0), DensityMap::codes(0.0, 3.0, Some(1.0)));
            let (exported, bytes) = write(&folder, name, &field, &grid, &Segments::default());
            assert_eq!((exported.voxel_type, exported.voxels_changed, exported.warnings.len()), (ty, 0, 0));
            let (code, bits) = nifti_code(ty);
            check_header(&bytes, DIMS, code, bits);
            assert_eq!((f32_at(&bytes, 112), f32_at(&bytes, 116)), (1.0, 0.0));
            assert_eq!(bytes[352..], bytes_of(&voxels, false));
            // As it came in, as this program reads it.
            let opened = io::open(folder.path().join(name)).unwrap();
            assert_eq!((opened.grid, opened.warnings.len()), (grid, 0));
            let read = opened.source(0, 0, &|_| true).unwrap().read([0; 3], DIMS).unwrap();
            assert_eq!(read.as_bytes(), voxels.as_bytes());
        }
    }
}

#[test]
fn both_forms_say_the_same_place() {
    let folder = tempfile::tempdir().unwrap();
    for place in axis_orders().into_iter().chain((0..40).map(oblique)) {
        let grid = Grid { dims: [3, 4, 5], world_from_index: place };
        let field = density(noise(VoxelType::U8, 60, 1), grid, (1.0, 0.0), DensityMap::codes(0.0, 255.0, Some(1.0)));
        let (_, bytes) = write(&folder, "out.nii", &field, &grid, &Segments::default());
        assert_eq!(sform(&bytes), rows(&place));
        assert_eq!(bytes[123], 2);
        assert!(i16_at(&bytes, 252) > 0);
        let q = qform(&bytes);
        let near =
            q.to_cols_array().iter().zip(place.to_cols_array()).all(|(a, b)| (a - b).abs() < 1e-5 * b.abs().max(4.0));
        assert!(near, "{q:?} {place:?}");
        // Either alone is read as that.
        let mut alone = bytes.clone();
        alone[254] = 0;
        let read = io::open(keep(&folder, "q.nii", &alone)).unwrap().grid.world_from_index;
        assert!(read.to_cols_array().iter().zip(place.to_cols_array()).all(|(a, b)| (a - b).abs() < 1e-4));
    }
    // Axes askew have no quaternion.
    let mut askew = oblique(3);
    askew.matrix3.y_axis += askew.matrix3.x_axis * 0.3;
    let grid = Grid { dims: [3, 4, 5], world_from_index: askew };
    let field = density(noise(VoxelType::U8, 60, 1), grid, (1.0, 0.0), DensityMap::codes(0.0, 255.0, Some(1.0)));
    let (_, bytes) = write(&folder, "out.nii", &field, &grid, &Segments::default());
    assert_eq!((sform(&bytes), i16_at(&bytes, 252)), (rows(&askew), 0));
}

#[test]
fn a_place_in_micrometres_or_metres_comes_back_in_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    for unit in [1, 2, 3] {
        for seed in 0..10 {
            let place = oblique(seed);
            let mut header = Nifti::new(VoxelType::I16, &[3, 4, 5], false);
            for (r, row) in rows(&place).iter().enumerate() {
                header.f32s(280 + 16 * r, row);
            }
            header.i16(254, 1).bytes[123] = unit;
            let voxels = noise(VoxelType::I16, 60, 2);
            let source =
                io::open(keep(&folder, "in.nii", &header.with(&voxels))).unwrap().source(0, 0, &|_| true).unwrap();
            let grid = *source.grid();
            let field = Field::from_source(source, DensityMap::FLOAT, &|_| true).unwrap().unwrap();
            let (_, bytes) = write(&folder, "out.nii", &field, &grid, &Segments::default());
            assert_eq!((bytes[123], sform(&bytes)), (unit, rows(&place)), "{unit} {seed}");
            // The other form says the same in the same unit, and alone is read as that.
            let q = qform(&bytes);
            let near = q
                .to_cols_array()
                .into_iter()
                .zip(place.to_cols_array())
                .all(|(a, b)| (a - b).abs() < 1e-5 * b.abs().max(4.0));
            assert!(near, "{unit} {seed}: {q:?} {place:?}");
            let mut alone = bytes.clone();
            alone[254] = 0;
            let read = io::open(keep(&folder, "q.nii", &alone)).unwrap().grid;
            for (a, b) in read.spacing().to_array().into_iter().zip(grid.spacing().to_array()) {
                assert!((a / b - 1.0).abs() < 1e-5, "{unit} {seed}: {a} mm, {b} expected");
            }
            assert_eq!(io::open(folder.path().join("out.nii")).unwrap().grid, grid);
        }
    }
}

#[test]
fn a_slope_that_fits_is_kept_with_the_stored_numbers_and_another_leaves_as_values() {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid::aligned(DIMS, DVec3::ONE, DVec3::ZERO);
    let f = |x: f32| f64::from(x);
    for (ty, scaling) in [
        (VoxelType::I16, (f(0.1), -1024.0)),
        (VoxelType::U8, (1.0, f(-1024.5))),
        (VoxelType::F32, (f(-2.5), f(1e-3))),
        (VoxelType::U64, (2.0, 0.0)),
    ] {
        let voxels = noise(ty, grid.voxel_count() as usize, 4);
        let map = DensityMap::codes(-2000.0, 2000.0, None);
        let mut field = density(voxels.clone(), grid, scaling, map);
        paint(&mut field, &[([6, 4, 8], map.encode(-1000.0))]);
        let (exported, bytes) = write(&folder, "out.nii", &field, &grid, &Segments::default());
        assert_eq!((exported.voxel_type, exported.voxels_changed), (ty, 1));
        assert_eq!((f(f32_at(&bytes, 112)), f(f32_at(&bytes, 116))), scaling);
        let last = bytes.len() - ty.bytes();
        assert_eq!(bytes[352..last], bytes_of(&voxels, false)[..last - 352]);
        // The painted value, taken back through slope and intercept into the type.
        let opened = io::open(folder.path().join("out.nii")).unwrap();
        assert_eq!(opened.scaling, scaling);
        let stored = opened.source(0, 0, &|_| true).unwrap().read([6, 4, 8], [1; 3]).unwrap().get(0);
        let wanted = (-1000.0 - scaling.1) / scaling.0;
        let expected = match ty {
            VoxelType::F32 => wanted,
            VoxelType::U8 | VoxelType::U64 => wanted.clamp(0.0, 255.0),
            _ => wanted.round(),
        };
        assert!((stored - expected).abs() <= map.half_step() / scaling.0.abs() + 0.51, "{stored} {expected}");
    }
    // Slopes that 32-bit numbers do not hold.
    for scaling in [(0.1, 0.0), (1.0, 1e-9 + 1.0), (1e300, 0.0)] {
        let voxels = noise(VoxelType::I16, grid.voxel_count() as usize, 4);
        let field = density(voxels.clone(), grid, scaling, DensityMap::codes(-2000.0, 2000.0, None));
        let (exported, bytes) = write(&folder, "out.nii", &field, &grid, &Segments::default());
        assert_eq!(exported.voxel_type, VoxelType::F64);
        assert_eq!((i16_at(&bytes, 70), f32_at(&bytes, 112), f32_at(&bytes, 116)), (64, 1.0, 0.0));
        for (i, value) in bytes[352..].chunks_exact(8).enumerate() {
            assert_eq!(f64::from_le_bytes(value.try_into().unwrap()), voxels.get(i) * scaling.0 + scaling.1);
        }
    }
}

/// Labels 1 to 4 along x.
fn labels(grid: &Grid) -> Field {
    let mut field = Field::blank(FieldKind::Labels, grid);
    let [nx, ny, nz] = grid.dims;
    let all = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
    let texels: Vec<_> = all.map(|v| (v, [(v[0] % 5) as u8, 0, 0, 0])).collect();
    paint(&mut field, &texels);
    field
}

fn segments(values: &[(u16, Option<i128>)]) -> Segments {
    Segments(values.iter().map(|&(id, source_value)| Segment { source_value, ..Segment::new(id) }).collect())
}

#[test]
fn labels_leave_with_the_ids_that_they_came_with_in_a_type_that_holds_them() {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid { dims: DIMS, world_from_index: oblique(5) };
    let field = labels(&grid);
    let big = i128::from(u64::MAX);
    for (values, expected, ty) in [
        ([None, None, None, None], [1, 2, 3, 4], VoxelType::U16),
        ([Some(65_535), None, None, None], [65_535, 2, 3, 4], VoxelType::U16),
        ([Some(-7), None, None, None], [-7, 2, 3, 4], VoxelType::I16),
        ([Some(-7), Some(40_000), None, None], [-7, 40_000, 3, 4], VoxelType::I32),
        ([Some(70_000), None, None, None], [70_000, 2, 3, 4], VoxelType::U32),
        ([Some(1 << 40), None, Some(-1), None], [1 << 40, 2, -1, 4], VoxelType::I64),
        ([Some(big), None, None, Some((1 << 53) + 1)], [big, 2, 3, (1 << 53) + 1], VoxelType::U64),
        // Ids that are another segment's give way: the one that brought its number keeps it.
        ([None, Some(1), Some(1), None], [2, 1, 3, 4], VoxelType::U16),
        ([Some(2), None, None, Some(3)], [2, 1, 4, 3], VoxelType::U16),
    ] {
        let table = segments(&[(1, values[0]), (2, values[1]), (3, values[2]), (4, values[3])]);
        for name in ["l.nii", "l.nii.gz", "l.nrrd", "l.seg.nrrd"] {
            let path = folder.path().join(name);
            let exported = io::export(&path, &field, &grid, &table, Compression::Gzip, &|_| true).unwrap();
            assert_eq!((exported.voxel_type, exported.voxels_changed), (ty, 7 * 5 * 9 - 2 * 45));
            let moved = (0..4).filter(|&i| expected[i] != values[i].unwrap_or(i as i128 + 1)).count();
            assert_eq!(exported.warnings.len(), moved, "{:?}", exported.warnings);
            let opened = io::open(&path).unwrap();
            let voxels = opened.source(0, 0, &|_| true).unwrap().read([0; 3], DIMS).unwrap();
            assert_eq!(voxels.voxel_type(), ty);
            let raw = bytes_of(&voxels, false);
            for (i, stored) in raw.chunks_exact(ty.bytes()).enumerate() {
                let sign =
                    if matches!(ty, VoxelType::I16 | VoxelType::I32 | VoxelType::I64) && stored[ty.bytes() - 1] > 127 {
                        0xff
                    } else {
                        0
                    };
                let mut wide = [sign; 16];
                wide[..ty.bytes()].copy_from_slice(stored);
                let label = i % 7 % 5;
                let wanted = if label == 0 { 0 } else { expected[label - 1] };
                assert_eq!(i128::from_le_bytes(wide), wanted, "{name} {i}");
            }
            if name.ends_with("nrrd") {
                let values: Vec<i128> = opened.labels.iter().map(|l| l.value).collect();
                assert_eq!(values, expected);
            } else {
                let bytes = if name == "l.nii" { std::fs::read(&path).unwrap() } else { continue };
                // NIFTI_INTENT_LABEL.
                assert_eq!(i16_at(&bytes, 68), 1002);
            }
        }
    }
    let both = segments(&[(1, Some(big)), (2, Some(-1)), (3, None), (4, None)]);
    let error =
        io::export(folder.path().join("l.nii"), &field, &grid, &both, Compression::Gzip, &|_| true).unwrap_err();
    assert!(error.to_string().contains("label ids: found -1 and 18446744073709551615; expected"), "{error}");
}

#[test]
fn a_seg_nrrd_has_the_fields_that_3d_slicer_reads() {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid { dims: [40, 5, 9], world_from_index: oblique(5) };
    let mut field = Field::blank(FieldKind::Labels, &grid);
    paint(&mut field, &[([3, 1, 2], [2, 0, 0, 0]), ([38, 4, 8], [2, 0, 0, 0]), ([5, 0, 0], [1, 1, 0, 0])]);
    let mut table = segments(&[(2, Some(900)), (257, None), (300, None)]);
    (table.0[0].name, table.0[0].colour) = ("Left kidney\nµ\\".into(), [1.0, 0.5, 0.25]);
    let path = folder.path().join("a.seg.nrrd");
    io::export(&path, &field, &grid, &table, Compression::Gzip, &|_| true).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let text = String::from_utf8_lossy(&bytes).into_owned();
    for line in [
        "type: unsigned short",
        "space: left-posterior-superior",
        "Segment0_ID:=Segment_2",
        "Segment0_Name:=Left kidney\\nµ\\\\",
        "Segment0_Color:=1 0.5 0.25",
        "Segment0_LabelValue:=900",
        "Segment0_Layer:=0",
        "Segment0_Extent:=3 38 1 4 2 8",
        "Segment1_LabelValue:=257",
        "Segment1_Extent:=5 5 0 0 0 0",
        "Segment2_Extent:=0 -1 0 -1 0 -1",
        "Segmentation_ContainedRepresentationNames:=Binary labelmap|",
        "Segmentation_MasterRepresentation:=Binary labelmap",
    ] {
        assert!(text.contains(&format!("\n{line}\n")), "{line} in {text}");
    }
    let opened = io::open(&path).unwrap();
    assert!(opened.warnings.is_empty(), "{:?}", opened.warnings);
    let first = &opened.labels[0];
    assert_eq!(
        (first.value, first.name.as_deref(), first.colour),
        (900, Some("Left kidney\nµ\\"), Some([1.0, 0.5, 0.25]))
    );
    assert_eq!(opened.labels.len(), 3);
}

#[test]
fn as_many_segments_as_there_can_be_leave_and_come_back_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid::aligned([1, 1, 1], DVec3::ONE, DVec3::ZERO);
    let all: Vec<_> = (1..=u16::MAX).map(|id| (id, Some(i128::from(id) + 1_000_000_000_000))).collect();
    let path = folder.path().join("all.seg.nrrd");
    let field = Field::blank(FieldKind::Labels, &grid);
    io::export(&path, &field, &grid, &segments(&all), Compression::Gzip, &|_| true).unwrap();
    let opened = io::open(&path).unwrap();
    assert_eq!((opened.labels.len(), opened.warnings.len()), (65_535, 0));
    assert_eq!(opened.labels[65_534].value, 1_000_000_065_535);
}

#[test]
fn selection_and_colour_leave_as_they_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid { dims: DIMS, world_from_index: oblique(2) };
    for (kind, datatype, bits) in [(FieldKind::Selection, 2, 8), (FieldKind::Colour, 2304, 32)] {
        let mut field = Field::blank(kind, &grid);
        paint(&mut field, &[([0; 3], [255, 2, 9, 7]), ([6, 4, 8], [127, 255, 3, 4])]);
        for name in ["out.nii", "out.nii.gz"] {
            let (exported, bytes) = write(&folder, name, &field, &grid, &Segments::default());
            assert_eq!(exported.voxels_changed, 2);
            check_header(&bytes, DIMS, datatype, bits);
            let width = bits as usize / 8;
            assert_eq!(bytes.len(), 352 + 7 * 5 * 9 * width);
            assert_eq!(bytes[352..352 + width], [255, 2, 9, 7][..width]);
            assert_eq!(bytes[bytes.len() - width..], [127, 255, 3, 4][..width]);
            assert!(bytes[352 + width..bytes.len() - width].iter().all(|&b| b == 0));
        }
    }
}

#[test]
fn an_axis_too_long_for_the_first_version_leaves_as_the_second() {
    let folder = tempfile::tempdir().unwrap();
    let place = DAffine3 { matrix3: DMat3::from_rotation_z(0.3), translation: DVec3::new(0.1, 0.2, 0.3) };
    for (dims, size) in [([32_767, 1, 2], 348), ([32_768, 1, 2], 540)] {
        let grid = Grid { dims, world_from_index: place };
        let voxels = noise(VoxelType::I16, 2 * dims[0] as usize, 1);
        let field = density(voxels.clone(), grid, (0.5, 3.0), DensityMap::codes(-9.0, 9.0, None));
        let (_, bytes) = write(&folder, "out.nii", &field, &grid, &Segments::default());
        assert_eq!(i32::from_le_bytes(bytes[..4].try_into().unwrap()), size);
        let opened = io::open(folder.path().join("out.nii")).unwrap();
        assert_eq!((opened.grid.dims, opened.scaling, opened.warnings.len()), (dims, (0.5, 3.0), 0));
        assert_eq!(opened.source(0, 0, &|_| true).unwrap().read([0; 3], dims).unwrap(), voxels);
        if size == 540 {
            // nifti2.h: rank and lengths, where voxels begin, the sform's first row.
            let i64_at = |at: usize| i64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
            let f64_at = |at: usize| f64::from_bits(i64_at(at) as u64);
            assert_eq!([i64_at(16), i64_at(24), i64_at(32), i64_at(40), i64_at(168)], [3, 32_768, 1, 2, 544]);
            assert_eq!(&bytes[4..12], b"n+2\0\r\n\x1a\n");
            assert_eq!([f64_at(400), f64_at(408), f64_at(424)], [0.3_f64.cos(), -0.3_f64.sin(), 0.1]);
            // Doubles hold the place as it is; the qform is the same but for rounding.
            assert_eq!(opened.grid, grid);
            let mut alone = bytes.clone();
            alone[348] = 0;
            let read = io::open(keep(&folder, "q.nii", &alone)).unwrap().grid.world_from_index;
            assert!(read.to_cols_array().iter().zip(place.to_cols_array()).all(|(a, b)| (a - b).abs() < 1e-12));
        }
    }
}

#[test]
fn edits_are_there_also_in_slabs_that_begin_inside_a_brick() {
    let folder = tempfile::tempdir().unwrap();
    // Planes of over 65,536 voxels leave in slabs thinner than a brick: the second begins at plane 31, inside the first.
    let dims = [260, 260, 33];
    let grid = Grid::aligned(dims, DVec3::ONE, DVec3::ZERO);
    let voxels = Voxels::U8(vec![9; grid.voxel_count() as usize]);
    // No brick that begins in the slab is edited: one would have all of it looked at.
    let places = [[0, 0, 30], [31, 7, 31], [259, 259, 31]];
    let at = |v: [u32; 3]| (v[0] + dims[0] * (v[1] + dims[1] * v[2])) as usize;
    let map = DensityMap::codes(0.0, 255.0, Some(1.0));
    let mut field = density(voxels, grid, (1.0, 0.0), map);
    paint(&mut field, &places.map(|p| (p, map.encode(200.0))));
    let mut selection = Field::blank(FieldKind::Selection, &grid);
    paint(&mut selection, &places.map(|p| (p, [200, 0, 0, 0])));
    for (field, rest) in [(&field, 9), (&selection, 0)] {
        for name in ["out.nii", "out.nrrd"] {
            let path = folder.path().join(name);
            let exported = io::export(&path, field, &grid, &Segments::default(), Compression::Raw, &|_| true).unwrap();
            assert_eq!(exported.voxels_changed, 3, "{name}");
            let read = io::open(&path).unwrap().source(0, 0, &|_| true).unwrap().read([0; 3], dims).unwrap();
            let Voxels::U8(read) = read else { panic!() };
            let edited: Vec<usize> = (0..read.len()).filter(|&i| read[i] != rest).collect();
            assert_eq!(edited, places.map(at), "{name}");
            assert!(edited.iter().all(|&i| read[i] == 200));
        }
    }
}

#[test]
fn the_second_version_says_its_unit_too() {
    let folder = tempfile::tempdir().unwrap();
    // No float holds 0.3, but 300 micrometres.
    let grid = Grid::aligned([40_000, 1, 1], DVec3::splat(0.3), DVec3::new(0.9, 0.6, 0.3));
    let field = Field::blank(FieldKind::Selection, &grid);
    let (_, bytes) = write(&folder, "out.nii", &field, &grid, &Segments::default());
    assert_eq!(i32::from_le_bytes(bytes[..4].try_into().unwrap()), 540);
    let read = io::open(folder.path().join("out.nii")).unwrap().grid;
    let far = |a: DVec3, b: DVec3| (a - b).abs().max_element();
    assert!(far(read.spacing(), grid.spacing()) < 1e-9, "{read:?}");
    assert!(far(read.world_from_index.translation, grid.world_from_index.translation) < 1e-9, "{read:?}");
}
