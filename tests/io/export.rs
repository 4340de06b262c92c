//! What leaves is what came: unedited voxels bit for bit, edits in the source's type, the original grid, and the old file
//! until the new one is whole.

use super::files::*;
use super::places::{axis_orders, oblique};
use crate::common::volumes::Watched;
use burin::io;
use burin::io::{Compression, Exported, IoError};
use burin::math::{DAffine3, DVec3};
use burin::volume::*;
use std::sync::Arc;

const DIMS: [u32; 3] = [45, 34, 70];

fn proceed() -> impl Fn(f32) -> bool + Sync {
    |_| true
}

fn write(
    folder: &tempfile::TempDir,
    field: &Field,
    grid: &Grid,
    compression: Compression,
) -> (Exported, std::path::PathBuf) {
    let path = folder.path().join("out.nrrd");
    (io::export(&path, field, grid, &Segments::default(), compression, &proceed()).unwrap(), path)
}

fn read(path: &std::path::Path, component: u32) -> (Grid, Voxels) {
    let opened = io::open(path).unwrap();
    assert!(opened.warnings.is_empty(), "{:?}", opened.warnings);
    let source = opened.source(component, 0, &proceed()).unwrap();
    (opened.grid, source.read([0; 3], opened.grid.dims).unwrap())
}

pub fn density(voxels: Voxels, grid: Grid, scaling: (f64, f64), map: DensityMap) -> Field {
    let source = Arc::new(MemorySource::new("made", grid, voxels, scaling).unwrap());
    Field::from_source(source, map, &|_| true).unwrap().unwrap()
}

/// Sets voxels of a field through their bricks.
pub fn paint(field: &mut Field, edits: &[([u32; 3], [u8; 4])]) {
    let bytes = field.format().bytes();
    for &(voxel, texel) in edits {
        let index = BrickIndex::of_voxel(voxel);
        let mut texels = field.brick(BrickKey { level: 0, index }).unwrap().to_texels(bytes);
        let [x, y, z] = voxel.map(|v| v % BRICK);
        let at = (x + BRICK * (y + BRICK * z)) as usize * bytes;
        texels[at..at + bytes].copy_from_slice(&texel[..bytes]);
        field.swap(vec![(index, Some(Brick::from_texels(texels, bytes)))]).unwrap();
    }
}

fn at(v: [u32; 3]) -> usize {
    (v[0] + DIMS[0] * (v[1] + DIMS[1] * v[2])) as usize
}

#[test]
fn density_that_nobody_edited_leaves_bit_for_bit_in_every_type() {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid { dims: DIMS, world_from_index: oblique(2) };
    for ty in ALL_TYPES {
        let voxels = noise(ty, grid.voxel_count() as usize, 11);
        // A map that keeps almost nothing of the numbers: texels must not matter.
        let mut field = density(voxels.clone(), grid, (1.0, 0.0), DensityMap::codes(0.0, 3.0, Some(1.0)));
        // A brick that was touched, and whose texels are the source's own.
        let index = BrickIndex([1, 0, 1]);
        field.swap(vec![(index, Some(field.base_brick(index).unwrap()))]).unwrap();
        for compression in [Compression::Raw, Compression::Gzip] {
            let (exported, path) = write(&folder, &field, &grid, compression);
            assert_eq!((exported.voxel_type, exported.voxels_changed), (ty, 0));
            assert_eq!(exported.bytes, std::fs::metadata(&path).unwrap().len());
            let (back, read) = read(&path, 0);
            assert_eq!((back, read.voxel_type()), (grid, ty));
            assert_eq!(read.as_bytes(), voxels.as_bytes());
        }
    }
}

#[test]
fn the_original_grid_comes_back_in_every_axis_order() {
    let folder = tempfile::tempdir().unwrap();
    let dims = [3, 4, 5];
    for world_from_index in axis_orders().into_iter().chain((0..20).map(oblique)) {
        let grid = Grid { dims, world_from_index };
        let voxels = noise(VoxelType::U16, 60, 1);
        let field = density(voxels.clone(), grid, (1.0, 0.0), DensityMap::codes(0.0, 65_535.0, Some(1.0)));
        // Numbers are written so that they read back exactly: no tolerance.
        assert_eq!(read(&write(&folder, &field, &grid, Compression::Raw).1, 0), (grid, voxels));
    }
}

#[test]
fn an_edit_leaves_rounded_and_saturated_to_the_sources_type_and_nothing_beside_it_changes() {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid::aligned(DIMS, DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO);
    let places = [[0, 0, 0], [31, 31, 31], [32, 32, 32], [44, 33, 69], [7, 33, 64]];
    // 8-bit data in a map of 1/16 steps over −16…496, so that edits can be fractions and lie beyond the type.
    let map = DensityMap { format: TexelFormat::R16Unorm, lo: -16.0, codes_per_unit: 16.0 };
    let values = [100.4, 100.5, 300.0, -9.0, 254.75];
    let expected = [100_u8, 101, 255, 0, 255];
    // The source is 7 where edited, so that each edit is one.
    let mut voxels = noise(VoxelType::U8, grid.voxel_count() as usize, 12);
    let Voxels::U8(numbers) = &mut voxels else { panic!() };
    places.iter().for_each(|&p| numbers[at(p)] = 7);
    let mut after = numbers.clone();
    places.iter().zip(expected).for_each(|(&p, e)| after[at(p)] = e);
    let mut field = density(voxels, grid, (1.0, 0.0), map);
    let edits: Vec<_> = places.iter().zip(values).map(|(&p, v)| (p, map.encode(v))).collect();
    paint(&mut field, &edits);
    let (exported, path) = write(&folder, &field, &grid, Compression::Gzip);
    assert_eq!(exported.voxels_changed, 5);
    assert_eq!(read(&path, 0).1, Voxels::U8(after));

    // Floats keep the edit as it is, and NaN beside it.
    let mut voxels = noise(VoxelType::F32, grid.voxel_count() as usize, 13);
    voxels.as_bytes_mut()[..4].copy_from_slice(&0x7fc1_2345_u32.to_ne_bytes());
    let mut field = density(voxels.clone(), grid, (1.0, 0.0), DensityMap::FLOAT);
    paint(&mut field, &[([1, 0, 0], DensityMap::FLOAT.encode(0.1))]);
    voxels.as_bytes_mut()[4..8].copy_from_slice(&0.1_f32.to_ne_bytes());
    assert_eq!(read(&write(&folder, &field, &grid, Compression::Raw).1, 0).1.as_bytes(), voxels.as_bytes());
}

#[test]
fn scaled_density_leaves_as_the_values_it_stands_for_and_can_be_taken_back() {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid::aligned(DIMS, DVec3::ONE, DVec3::ZERO);
    let voxels = noise(VoxelType::I16, grid.voxel_count() as usize, 14);
    for (slope, intercept) in [(0.3_f32.into(), -1024.0), (-2.5, 7.0), (1.0, -1024.0)] {
        let map = DensityMap::codes(-90_000.0, 90_000.0, None);
        let mut field = density(voxels.clone(), grid, (slope, intercept), map);
        let code = map.encode(1234.0);
        paint(&mut field, &[([40, 3, 2], code)]);
        let (exported, path) = write(&folder, &field, &grid, Compression::Gzip);
        assert_eq!((exported.voxel_type, exported.voxels_changed), (VoxelType::F64, 1));
        let Voxels::F64(read) = read(&path, 0).1 else { panic!() };
        for (i, &value) in read.iter().enumerate() {
            if i == at([40, 3, 2]) {
                // Half a step of the type and half of the codes.
                let tolerance = slope.abs() / 2.0 + map.half_step();
                assert!((value - 1234.0).abs() <= tolerance, "{value}");
                let stored = (value - intercept) / slope;
                assert!((stored - stored.round()).abs() < 1e-9, "a number that the source's type has: {stored}");
            } else {
                assert_eq!(value, voxels.get(i) * slope + intercept);
                assert_eq!(((value - intercept) / slope).round(), voxels.get(i));
            }
        }
        let text = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).into_owned();
        assert!(text.contains(&format!("burin_slope:={slope:?}\nburin_intercept:={intercept:?}\n")));
        assert!(text.contains("burin_stored_type:=short\n"));
    }
}

#[test]
fn selection_labels_and_colour_leave_as_they_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid { dims: DIMS, world_from_index: oblique(5) };
    let mut segments = Segments::default();
    segments.ensure(3);
    let segment = segments.get_mut(3).unwrap();
    (segment.name, segment.colour) = ("a\nb\\c".into(), [1.0, 0.5, 0.0]);
    for kind in [FieldKind::Selection, FieldKind::Labels, FieldKind::Colour] {
        let mut field = Field::blank(kind, &grid);
        let texels = [([0, 0, 0], [255, 2, 9, 7]), ([44, 33, 69], [127, 255, 3, 4]), ([32, 31, 5], [1, 0, 0, 255])];
        paint(&mut field, &texels);
        let path = folder.path().join("out.nrrd");
        let exported = io::export(&path, &field, &grid, &segments, Compression::Gzip, &proceed()).unwrap();
        assert_eq!(exported.voxels_changed, 3);
        let bytes = field.format().bytes();
        let parts = if kind == FieldKind::Colour { 4 } else { 1 };
        for c in 0..parts {
            let (back, read) = read(&path, c);
            assert_eq!(back, grid);
            let width = bytes / parts as usize;
            assert_eq!(read.voxel_type(), if width == 2 { VoxelType::U16 } else { VoxelType::U8 });
            let nonzero = (0..read.len()).filter(|&i| read.get(i) != 0.0).count();
            let mut expected = 0;
            for (voxel, texel) in texels {
                let from = c as usize * width;
                let number: u32 = (0..width).map(|b| u32::from(texel[from + b]) << (8 * b)).sum();
                assert_eq!(read.get(at(voxel)), f64::from(number), "{kind:?} {voxel:?} {c}");
                expected += usize::from(number != 0);
            }
            assert_eq!(nonzero, expected);
        }
        let text = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).into_owned();
        let named = text.contains("Segment0_Name:=a\\nb\\\\c\nSegment0_Color:=1 0.5 0\nSegment0_LabelValue:=3\n");
        assert_eq!(named, kind == FieldKind::Labels);
    }
}

#[test]
fn what_fails_midway_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = keep(&folder, "out.nrrd", b"the old one");
    let grid = Grid::aligned(DIMS, DVec3::ONE, DVec3::ZERO);
    let voxels = noise(VoxelType::U8, grid.voxel_count() as usize, 1);
    // Only whole planes fail, which is how the export reads; the field itself reads bricks.
    let fails = |lo: [u32; 3], size: [u32; 3]| match size[..2] == DIMS[..2] && lo[2] + size[2] > 40 {
        true => Err(SourceError::Unreadable { name: "failing".into(), reason: "gone".into() }),
        false => Ok(()),
    };
    let source = Watched(MemorySource::new("failing", grid, voxels, (1.0, 0.0)).unwrap(), fails);
    let field =
        Field::from_source(Arc::new(source), DensityMap::codes(0.0, 255.0, Some(1.0)), &|_| true).unwrap().unwrap();
    let segments = Segments::default();
    let error = io::export(&path, &field, &grid, &segments, Compression::Raw, &proceed()).unwrap_err();
    assert!(matches!(error, IoError::Source(_)), "{error}");
    let selection = Field::blank(FieldKind::Selection, &grid);
    let error = io::export(&path, &selection, &grid, &segments, Compression::Gzip, &|done| done < 0.4).unwrap_err();
    assert!(matches!(error, IoError::Cancelled { .. }), "{error}");
    assert_eq!(std::fs::read(&path).unwrap(), b"the old one");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    let a_folder = folder.path().join("folder.nrrd");
    std::fs::create_dir(&a_folder).unwrap();
    for nowhere in ["missing/out.nrrd", "folder.nrrd"] {
        let error = io::export(folder.path().join(nowhere), &selection, &grid, &segments, Compression::Raw, &proceed());
        assert!(matches!(error, Err(IoError::System { .. })));
    }
    std::fs::remove_dir(&a_folder).unwrap();
    // Another program would take the name's word for the format.
    for other in ["out.nhdr", "out.nrrd.gz", "out.seg.nrrd", "out.nii.bz2", "nii", "out", "."] {
        let error = io::export(folder.path().join(other), &selection, &grid, &segments, Compression::Raw, &proceed());
        let text = error.unwrap_err().to_string();
        assert!(text.contains("extension: found") && text.contains("expected one of nrrd, nii.gz, nii"), "{text}");
    }
    io::export(&path, &selection, &grid, &segments, Compression::Raw, &proceed()).unwrap();
    assert_eq!(read(&path, 0).1, Voxels::U8(vec![0; grid.voxel_count() as usize]));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_file_can_be_written_over_the_one_its_voxels_are_read_from() {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid { dims: DIMS, world_from_index: DAffine3::IDENTITY };
    let voxels = noise(VoxelType::U16, grid.voxel_count() as usize, 3);
    let first = density(voxels.clone(), grid, (1.0, 0.0), DensityMap::codes(0.0, 65_535.0, Some(1.0)));
    let (_, path) = write(&folder, &first, &grid, Compression::Raw);
    let source = io::open(&path).unwrap().source(0, 0, &proceed()).unwrap();
    let again = Field::from_source(source, DensityMap::codes(0.0, 65_535.0, Some(1.0)), &|_| true).unwrap().unwrap();
    for compression in [Compression::Raw, Compression::Gzip] {
        write(&folder, &again, &grid, compression);
        assert_eq!(read(&path, 0), (grid, voxels.clone()));
    }
}

/// Names the file in the environment of the child below.
const CHILD: &str = "BURIN_TEST_EXPORT_TO";

#[test]
#[ignore = "run by the test below with a limit on the size of files"]
fn export_to_a_full_disk() {
    let Some(path) = std::env::var_os(CHILD) else { return };
    let grid = Grid::aligned([100; 3], DVec3::ONE, DVec3::ZERO);
    let field = density(noise(VoxelType::U8, 1_000_000, 2), grid, (1.0, 0.0), DensityMap::codes(0.0, 255.0, Some(1.0)));
    for compression in [Compression::Raw, Compression::Gzip] {
        let error = io::export(&path, &field, &grid, &Segments::default(), compression, &proceed()).unwrap_err();
        println!("{error}");
        assert!(matches!(error, IoError::System { action: "write the file", .. }), "{error}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = keep(&folder, "out.nrrd", b"the old one");
    // Blocks of 512 bytes in sh: 128 KiB a file; with SIGXFSZ ignored a write answers with an error.
    let out = std::process::Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 256; exec \"$0\" \"$@\""])
        .arg(std::env::current_exe().unwrap())
        .args(["--exact", "io::export::export_to_a_full_disk", "--ignored", "--nocapture"])
        .env(CHILD, &path)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&out.stdout).into_owned();
    assert!(out.status.success(), "{said}{}", String::from_utf8_lossy(&out.stderr));
    assert_eq!(said.matches("out.nrrd: cannot write the file: ").count(), 2, "{said}");
    assert_eq!(std::fs::read(&path).unwrap(), b"the old one");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn an_export_is_on_disk_before_it_takes_its_name_and_has_the_rights_of_any_new_file() {
    use burin::io::{Told, Witness};
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid::aligned(DIMS, DVec3::ONE, DVec3::ZERO);
    let selection = Field::blank(FieldKind::Selection, &grid);
    for name in ["out.nrrd", "out.nii.gz"] {
        let path = folder.path().join(name);
        let witness = Witness::new(folder.path());
        io::export(&path, &selection, &grid, &Segments::default(), Compression::Gzip, &proceed()).unwrap();
        let told = witness.told();
        let renamed = told.iter().position(|t| *t == Told::Rename(path.clone())).unwrap_or_else(|| panic!("{told:?}"));
        let content = |t: &Told| matches!(t, Told::Sync(p) if p.parent() == Some(folder.path()));
        assert_eq!(told.iter().position(content).map(|at| at < renamed), Some(true), "{told:?}");
        let names = told.iter().rposition(|t| *t == Told::Sync(folder.path().to_owned()));
        assert_eq!(names.map(|at| at > renamed), Some(true), "{told:?}");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let plain = folder.path().join("plain");
            std::fs::write(&plain, "x").unwrap();
            let mode = |path: &std::path::Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
            assert_eq!(mode(&path), mode(&plain), "{name}");
        }
    }
}

#[test]
fn density_without_a_source_leaves_as_floats() {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid::aligned([5, 4, 3], DVec3::ONE, DVec3::ZERO);
    let field = Field::blank(FieldKind::Density, &grid);
    let path = folder.path().join("out.nrrd");
    let exported = io::export(&path, &field, &grid, &Segments::default(), Compression::Raw, &proceed()).unwrap();
    assert_eq!(exported.voxel_type, VoxelType::F32);
    assert_eq!(read(&path, 0).1, Voxels::F32(vec![0.0; 60]));
}
