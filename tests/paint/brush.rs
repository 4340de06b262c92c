use super::*;
use burin::volume::{DensityMap, Field, MemorySource, Number, Voxels};
use std::sync::Arc;

#[test]
fn a_wrong_setting_is_named_with_what_was_found() {
    let good = Brush::default();
    good.check().unwrap();
    let bad = [
        ("radius_mm", Brush { radius_mm: -1.0, ..good }),
        ("radius_mm", Brush { radius_mm: f64::NAN, ..good }),
        ("radius_mm", Brush { radius_mm: f64::INFINITY, ..good }),
        ("strength", Brush { strength: 1.01, ..good }),
        ("strength", Brush { strength: f32::NAN, ..good }),
        ("spacing", Brush { spacing: 0.0, ..good }),
        ("spacing", Brush { spacing: 0.3, ..good }),
        ("target.density", Brush { target: Target::Density(f64::NAN), ..good }),
        ("target.colour", Brush { target: Target::Colour([0.0, 0.0, 2.0, 1.0]), ..good }),
        ("target.selection", Brush { target: Target::Selection(-0.5), ..good }),
        ("erase_density.to", Brush { erase_density: EraseDensity::To(f64::INFINITY), ..good }),
        ("range", Brush { range: Some([3.0, 2.0].map(Number::Real)), ..good }),
        ("range", Brush { range: Some([f64::NAN, 2.0].map(Number::Real)), ..good }),
    ];
    for (field, brush) in bad {
        let text = brush.check().unwrap_err().to_string();
        assert!(text.starts_with(&format!("brush.{field} is ")) && text.contains("expected"), "{text}");
    }
    let huge = Brush { radius_mm: 1e7, ..good };
    assert!(StrokePath::new(&huge, &Grid::aligned([8; 3], DVec3::ONE, DVec3::ZERO)).is_err());
}

#[test]
fn values_beyond_the_codes_are_named_before_the_stroke() {
    let grid = Grid::aligned([4, 4, 4], DVec3::ONE, DVec3::ZERO);
    let source =
        MemorySource::new("v", grid, Voxels::I16((0..64).map(|i| i * 10 - 100).collect()), (1.0, 0.0)).unwrap();
    let map = DensityMap::codes(-100.0, 530.0, Some(1.0));
    let field = Field::from_source(Arc::new(source), map, &|_| true).unwrap().unwrap();
    let brush = |value, operation| Brush { target: Target::Density(value), operation, ..Brush::default() };
    assert_eq!(brush(530.0, Operation::Replace).range_needed(&field), None);
    assert_eq!(brush(-100.0, Operation::Blend).range_needed(&field), None);
    let [lo, hi] = brush(2000.0, Operation::Replace).range_needed(&field).unwrap();
    assert_eq!((lo, hi), (-100.0, 2000.0));
    let [lo, _] = brush(50.0, Operation::Subtract).range_needed(&field).unwrap();
    assert_eq!(lo, -150.0);
    // Half strength makes half the offset in a wash.
    let weak = Brush { strength: 0.5, ..brush(1000.0, Operation::Add) };
    assert_eq!(weak.range_needed(&field).unwrap()[1], 1030.0);
    assert_eq!(brush(1e9, Operation::Restore).range_needed(&field), None);
    assert_eq!(Brush { erase: true, ..brush(1e9, Operation::Add) }.range_needed(&field), None);
    assert_eq!(Brush { target: Target::Selection(1.0), ..Brush::default() }.range_needed(&field), None);
}
