use super::*;
use burin::volume::{BrickSource, DensityMap, Field, MemorySource, Statistics, TexelFormat, Value, Voxels};
use std::sync::Arc;

/// Density of these voxels in 16-bit codes over a range, and what is true of its source.
fn codes(voxels: Voxels, scaling: (f64, f64), range: [f64; 2], unit: Option<f64>) -> (Field, Statistics) {
    let grid = Grid::aligned([voxels.len() as u32, 1, 1], DVec3::ONE, DVec3::ZERO);
    let source = Arc::new(MemorySource::new("v", grid, voxels, scaling).unwrap());
    assert_eq!(source.scaling(), scaling);
    let statistics = burin::io::statistics(source.as_ref(), &|_| true).unwrap();
    let map = DensityMap::codes(range[0], range[1], unit);
    (Field::from_source(source, map, &|_| true).unwrap().unwrap(), statistics)
}

fn brush(value: f64, operation: Operation) -> Brush {
    Brush { target: Target::Density(value), operation, ..Brush::default() }
}

#[test]
fn codes_are_kept_for_as_long_as_they_hold_what_is_painted() {
    let (field, source) = codes(Voxels::U8(vec![0, 7, 255]), (1.0, 0.0), [0.0, 255.0], Some(1.0));
    let asked = |b: Brush| b.map_for(&field, &source, 1.0);
    for (value, operation) in [(0.0, Operation::Replace), (17.0, Operation::Blend), (255.0, Operation::Replace)] {
        assert_eq!(asked(brush(value, operation)), None, "{value}");
    }
    // A number beyond the range gets wider codes, each integer still a whole number of them.
    for (value, operation, hi) in [(300.0, Operation::Replace, 300.0), (10.0, Operation::Add, 265.0)] {
        let map = asked(brush(value, operation)).unwrap();
        assert_eq!((map.format, map.lo, map.codes_per_unit.fract()), (TexelFormat::R16Unorm, 0.0, 0.0));
        assert!(map.hi() >= hi && map.half_step() < 0.01);
        assert!((0..=hi as u32).all(|v| map.decode(map.encode(f64::from(v))) == f64::from(v)));
    }
    assert!(asked(brush(3.0, Operation::Subtract)).unwrap().lo <= -3.0);
    // A number that is no code, or codes that are too coarse: floats.
    for (value, operation) in [
        (0.1, Operation::Add),
        (2.3, Operation::Subtract),
        (254.3, Operation::Replace),
        (1e9, Operation::Replace),
        (-1e-3, Operation::Blend),
        (9000.0, Operation::Replace),
    ] {
        assert_eq!(asked(brush(value, operation)), Some(DensityMap::FLOAT), "{value}");
    }
    // The same numbers where they are codes.
    let hard = |b: Brush| Brush { falloff: Falloff::Hard, ..b };
    assert_eq!(asked(hard(brush(9000.0, Operation::Replace))).unwrap().format, TexelFormat::R16Unorm);
    let half = Brush { strength: 0.5, ..brush(1.0, Operation::Add) };
    assert_eq!(asked(half), Some(DensityMap::FLOAT));
    for nothing in [
        Brush { erase: true, ..brush(0.1, Operation::Add) },
        brush(1e9, Operation::Restore),
        Brush { target: Target::Selection(1.0), ..Brush::default() },
    ] {
        assert_eq!(asked(nothing), None);
    }
}

#[test]
fn data_that_fill_16_bits_keep_their_codes_for_whole_numbers_only() {
    let (field, source) = codes(Voxels::U16(vec![0, 65_535]), (1.0, 0.0), [0.0, 65_535.0], Some(1.0));
    let hard = Brush { falloff: Falloff::Hard, ..brush(12.0, Operation::Replace) };
    assert_eq!(hard.map_for(&field, &source, 1.0), None);
    for soft in [
        brush(12.0, Operation::Replace),
        Brush { strength: 0.5, ..hard },
        Brush { target: Target::Density(12.5), ..hard },
    ] {
        assert_eq!(soft.map_for(&field, &source, 1.0), Some(DensityMap::FLOAT));
    }
}

#[test]
fn values_that_codes_cut_off_move_to_a_map_that_holds_them() {
    // A range narrower than the data.
    let (field, source) = codes(Voxels::I16(vec![-1000, 40, 3000]), (1.0, 0.0), [0.0, 100.0], Some(1.0));
    let map = brush(1.0, Operation::Add).map_for(&field, &source, 1.0).unwrap();
    assert!(map.lo <= -1000.0 && map.hi() >= 3001.0 && map.codes_per_unit.fract() == 0.0, "{map:?}");
    // An infinity among them, and numbers with a fraction.
    for voxels in [vec![0.0, 1.0, f32::INFINITY], vec![0.0, 1.0, f32::NEG_INFINITY], vec![0.0, 0.5, 1.0]] {
        let (field, source) = codes(Voxels::F32(voxels.clone()), (1.0, 0.0), [0.0, 1.0], None);
        let map = brush(0.3, Operation::Replace).map_for(&field, &source, 1.0);
        assert_eq!(map, Some(DensityMap::FLOAT), "{voxels:?}");
        // An end of the range is a code.
        let cleared = brush(0.0, Operation::Replace).map_for(&field, &source, 1.0);
        assert_eq!(cleared.is_none(), voxels[2] == 1.0, "{voxels:?}");
    }
    // Scaled integers: codes on their own steps.
    let (field, source) = codes(i16::wrap(vec![-5, 0, 9]), (0.25, 10.0), [8.75, 12.25], Some(0.25));
    let map = brush(20.0, Operation::Replace).map_for(&field, &source, 1.0).unwrap();
    assert!([8.75, 9.0, 12.25, 20.0].iter().all(|&v| (map.decode(map.encode(v)) - v).abs() < 1e-9), "{map:?}");
}

#[test]
fn what_adds_up_has_room_to_the_types_end_and_for_one_application_beyond() {
    let (field, source) =
        codes(Voxels::I16((0..64).map(|i| i * 10 - 100).collect()), (1.0, 0.0), [-100.0, 530.0], Some(1.0));
    let hard = |value| Brush { falloff: Falloff::Hard, tip: Tip::BuildUp, ..brush(value, Operation::Add) };
    let ends = |value, coverage| {
        let map = hard(value).map_for(&field, &source, coverage).unwrap();
        [map.lo, map.hi()]
    };
    assert!(ends(1000.0, 3.0)[1] >= 3530.0);
    assert!(ends(1000.0, 50.0)[1] >= 32_767.0);
    assert!(ends(-1000.0, 50.0)[0] <= -32_768.0);
    assert!(ends(40_000.0, 50.0)[1] >= 40_530.0);
    assert_eq!(hard(1000.0).bounds(&field), [-32_768.0, 32_767.0]);
    assert_eq!(hard(40_000.0).bounds(&field), [-32_768.0, 40_530.0]);
    assert_eq!(hard(-40_000.0).bounds(&field), [-40_100.0, 32_767.0]);
}
