//! Minimum, maximum, sum and NaN count, pinned to closed forms.

use super::files::*;
use burin::io;
use burin::io::Info;
use burin::math::DVec3;
use burin::volume::{Grid, MemorySource, Number, VoxelType, Voxels};
use burin::with_voxel_type;

/// What `burin info` tells, its numbers as f64.
struct Told {
    info: Info,
    min: Option<f64>,
    max: Option<f64>,
    sum: f64,
    nan_count: u64,
}

fn info(folder: &tempfile::TempDir, voxels: &Voxels, dims: &[i16], scaling: [f32; 2]) -> Told {
    let mut header = Nifti::new(voxels.voxel_type(), dims, true);
    header.f32s(112, &scaling).i16(252, 1);
    let raw = io::info(keep(folder, "a.nii", &header.with(voxels)), &|_| true).unwrap();
    let packed = io::info(keep(folder, "a.nii.gz", &gzip(&header.with(voxels))), &|_| true).unwrap();
    assert_eq!(raw, Info { format: raw.format.clone(), ..packed });
    let number = |n: Option<Number>| n.map(Number::to_f64);
    let (min, max) = (number(raw.min), number(raw.max));
    let raw = Told { min, max, sum: raw.sum.to_f64(), nan_count: raw.nan_count, info: raw };
    let all: usize = dims.iter().map(|&d| d as usize).product();
    if dims[..3].iter().map(|&d| d as usize).product::<usize>() == all {
        let grid = Grid::aligned([dims[0], dims[1], dims[2]].map(|d| d as u32), DVec3::ONE, DVec3::ZERO);
        let scaling = if scaling[0] == 0.0 { (1.0, 0.0) } else { (scaling[0].into(), scaling[1].into()) };
        let source = MemorySource::new("made", grid, voxels.clone(), scaling).unwrap();
        let s = io::statistics(&source, &|_| true).unwrap();
        assert_eq!((Some(s.min).filter(|m| m.is_finite()), s.nan_count), (raw.min, raw.nan_count));
        assert_eq!(Some(s.max).filter(|m| m.is_finite()), raw.max);
        // Slabs are added in another order.
        assert!(s.sum == raw.sum || (s.sum - raw.sum).abs() <= 1e-12 * raw.sum.abs().max(1.0), "{} {}", s.sum, raw.sum);
    }
    raw
}

#[test]
fn a_ramp_sums_to_half_n_times_n_minus_one() {
    let folder = tempfile::tempdir().unwrap();
    // 100 numbers 0…99 in each of 9000 rows: more than one piece of the file, and every type holds them.
    for ty in ALL_TYPES {
        let ramp: Voxels = with_voxel_type!(ty, T => {
            let row: Vec<T> = (0..100_u8).map(|x| x as T).collect();
            burin::volume::Value::wrap(row.repeat(9000))
        });
        let found = info(&folder, &ramp, &[100, 90, 100], [0.0, 0.0]);
        assert_eq!((found.min, found.max), (Some(0.0), Some(99.0)));
        assert_eq!((found.sum, found.nan_count), (9000.0 * 99.0 * 100.0 / 2.0, 0));
        // −0.5 x + 3: exact in f64.
        let found = info(&folder, &ramp, &[100, 90, 100], [-0.5, 3.0]);
        assert_eq!((found.min, found.max), (Some(3.0 - 49.5), Some(3.0)));
        assert_eq!(found.sum, 9000.0 * (300.0 - 99.0 * 25.0));
        assert_eq!(found.info.voxel_type, ty.name());
    }
}

#[test]
fn statistics_are_of_finite_values_in_all_components_and_frames() {
    let folder = tempfile::tempdir().unwrap();
    let n = f32::NAN;
    let voxels = Voxels::F32(vec![1.0, n, f32::INFINITY, -4.0, 2.5, n, f32::NEG_INFINITY, 8.0]);
    let found = info(&folder, &voxels, &[2, 1, 1, 2, 2], [0.0, 0.0]);
    assert_eq!((found.info.components, found.info.frames), (2, 2));
    assert_eq!((found.min, found.max, found.sum, found.nan_count), (Some(-4.0), Some(8.0), 7.5, 2));
    let found = info(&folder, &Voxels::F64(vec![f64::NAN; 3]), &[3, 1, 1], [0.0, 0.0]);
    assert_eq!((found.min, found.max, found.sum, found.nan_count), (None, None, 0.0, 3));
    let json = serde_json::to_value(&found.info).unwrap();
    assert!(json["min"].is_null() && json["max"].is_null());
    let keys: std::collections::BTreeSet<_> = json.as_object().unwrap().keys().map(String::as_str).collect();
    let expected = [
        "components",
        "dims",
        "format",
        "frames",
        "max",
        "min",
        "nan_count",
        "sum",
        "voxel_type",
        "warnings",
        "world_from_index",
    ];
    assert!(keys.into_iter().eq(expected));
    assert_eq!(json["world_from_index"][2][2], 1.0);
}

#[test]
fn sums_lose_nothing_that_f64_can_hold() {
    let folder = tempfile::tempdir().unwrap();
    let found = info(&folder, &Voxels::F64(vec![1e16, 1.0, -1e16]), &[3, 1, 1], [0.0, 0.0]);
    assert_eq!(found.sum, 1.0);
    // Parts of it are beyond all numbers.
    let ends = [vec![-1e308; 16], vec![1e308; 16], vec![3.0; 4]].concat();
    assert_eq!(info(&folder, &Voxels::F64(ends), &[6, 6, 1], [0.0, 0.0]).sum, 12.0);
    let found = info(&folder, &Voxels::F64(vec![1e308, 1e308, f64::INFINITY]), &[3, 1, 1], [0.0, 0.0]);
    assert_eq!(found.sum, f64::INFINITY);
    let found = info(&folder, &Voxels::I64(vec![i64::MAX, 5, -i64::MAX]), &[3, 1, 1], [0.0, 0.0]);
    assert_eq!(found.sum, 5.0);
    let found = info(&folder, &Voxels::U64(vec![u64::MAX, u64::MAX]), &[2, 1, 1], [0.0, 0.0]);
    assert_eq!((found.sum, found.max), (2.0_f64.powi(65), Some(2.0_f64.powi(64))));
    let found = info(&folder, &Voxels::U32(vec![u32::MAX; 300_000]), &[300, 100, 10], [0.0, 0.0]);
    assert_eq!(found.sum, 300_000.0 * 4_294_967_295.0);
}

#[test]
fn a_reader_that_is_told_to_stop_stops() {
    let folder = tempfile::tempdir().unwrap();
    let file = Nifti::new(VoxelType::U8, &[100, 100, 300], false).with(&noise(VoxelType::U8, 3_000_000, 1));
    for path in [keep(&folder, "a.nii", &file), keep(&folder, "a.nii.gz", &gzip(&file))] {
        let seen = std::sync::Mutex::new(Vec::new());
        let half = |done: f32| {
            seen.lock().unwrap().push(done);
            done < 0.5
        };
        assert!(matches!(io::info(&path, &half), Err(io::IoError::Cancelled { .. })));
        assert!(seen.lock().unwrap().iter().all(|s| (0.0..=1.0).contains(s)));
        let read = io::open(&path).unwrap().source(0, 0, &|_| false);
        assert_eq!(read.is_err(), path.ends_with("a.nii.gz"));
    }
}
