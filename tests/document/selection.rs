//! Selections from other volumes.

use super::maker::{labelled, run, write_nrrd};
use crate::common::one::One;
use burin::document::Document;
use burin::math::{DAffine3, DMat3, DVec3};
use burin::volume::Grid;
use serde_json::json;

fn import(document: &mut Document, grid: &Grid, threshold: f64, soften_mm: f64, value: impl Fn([u32; 3]) -> f32) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("other.nrrd");
    write_nrrd(&path, grid, value);
    let line = json!({"selection":{"import":{"path":path,"threshold":threshold,"soften_mm":soften_mm}}});
    run(document, &line.to_string()).unwrap();
}

fn selected(document: &Document, v: [u32; 3]) -> u8 {
    document.state().unwrap().one().selection.texel(v).unwrap()[0]
}

fn voxels(grid: &Grid) -> impl Iterator<Item = [u32; 3]> + use<> {
    let [nx, ny, nz] = grid.dims;
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

#[test]
fn on_the_same_grid_exactly_the_voxels_above_the_threshold_are_selected() {
    let mut document = labelled();
    let grid = *document.state().unwrap().one().grid();
    let value = |v: [u32; 3]| if v == [5, 5, 5] { f32::NAN } else { (v[0] * 7 + v[1] * 13 + v[2] * 29) as f32 % 101.0 };
    import(&mut document, &grid, 50.0, 0.0, value);
    for v in voxels(&grid) {
        assert_eq!(selected(&document, v), if value(v) > 50.0 { 255 } else { 0 }, "{v:?}");
    }
    assert_eq!(document.history().undo_names().len(), 1);
}

#[test]
fn another_grid_is_resampled_by_world_position() {
    let mut document = labelled();
    let ours = *document.state().unwrap().one().grid();
    // Coarser, shifted, turned otherwise; covers all of ours but for the last corner of x.
    let turn = DMat3::from_rotation_z(-0.3) * DMat3::from_diagonal(DVec3::new(2.0, 3.0, 1.25));
    let theirs = Grid {
        dims: [80, 60, 90],
        world_from_index: DAffine3 { matrix3: turn, translation: DVec3::new(-90.0, -70.0, -50.0) },
    };
    // Linear in the world, so that trilinear interpolation is exact.
    let plane = |p: DVec3| p.x * 0.7 - p.y * 0.2 + p.z * 0.4;
    let value = |v: [u32; 3]| {
        plane(theirs.world_from_index.transform_point3(DVec3::new(v[0] as f64, v[1] as f64, v[2] as f64))) as f32
    };
    import(&mut document, &theirs, 3.0, 0.0, value);
    let mut counted = [0, 0];
    for v in voxels(&ours) {
        let world = ours.world_from_index.transform_point3(DVec3::new(v[0] as f64, v[1] as f64, v[2] as f64));
        let at = theirs.index_from_world().transform_point3(world);
        let inside = at.cmpge(DVec3::ZERO).all() && at.cmple(theirs.dims_f64() - 1.0).all();
        // f32 values of some tens are good to 1e-5; nearer to the threshold either answer is right.
        if inside && (plane(world) - 3.0).abs() > 1e-4 {
            let expected = plane(world) > 3.0;
            assert_eq!(selected(&document, v), if expected { 255 } else { 0 }, "{v:?}");
            counted[usize::from(expected)] += 1;
        }
    }
    assert!(counted.iter().all(|&n| n > 1000), "{counted:?}");
}

#[test]
fn a_soft_border_is_the_distance_to_the_other_side() {
    let mut document = labelled();
    let grid = *document.state().unwrap().one().grid();
    let s = grid.spacing();
    let soften = 5.0;
    // A ball across the border of bricks and blocks, and one voxel alone in a corner of the volume.
    let inside = |v: [u32; 3]| {
        let d = (DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2])) - DVec3::new(63.0, 31.5, 20.0)) * s;
        d.length() < 6.5 || v == [0, 0, 0]
    };
    import(&mut document, &grid, 0.5, soften, |v| if inside(v) { 1.0 } else { 0.0 });
    let apart = |a: [u32; 3], b: [u32; 3]| {
        let d: [f64; 3] = std::array::from_fn(|i| (f64::from(a[i]) - f64::from(b[i])) * s[i]);
        (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()
    };
    let (ins, outs): (Vec<_>, Vec<_>) = voxels(&grid).partition(|&v| inside(v));
    let half = s.min_element() / 2.0;
    let expected = |d: f64| ((0.5 + d / soften).clamp(0.0, 1.0) * 255.0).round();
    for &v in &ins {
        let near = outs.iter().map(|&o| apart(v, o)).fold(f64::INFINITY, f64::min);
        assert_eq!(f64::from(selected(&document, v)), expected(near - half), "{v:?}");
    }
    for &v in &outs {
        let near = ins.iter().map(|&o| apart(v, o)).fold(f64::INFINITY, f64::min);
        assert_eq!(f64::from(selected(&document, v)), expected(half - near), "{v:?}");
    }
}

#[test]
fn the_ramp_of_a_flat_border_is_its_closed_form() {
    let mut document = labelled();
    let grid = *document.state().unwrap().one().grid();
    import(&mut document, &grid, 0.5, 4.0, |v| if v[0] < 40 { 1.0 } else { 0.0 });
    // Spacing 1 along x: voxel 39 lies ½ mm inside, voxel 40 ½ mm outside, and so on; ±2 mm end the ramp.
    for (x, share) in [(37, 1.0), (38, 0.875), (39, 0.625), (40, 0.375), (41, 0.125), (42, 0.0), (20, 1.0)] {
        assert_eq!(f64::from(selected(&document, [x, 20, 10])), (share * 255.0_f64).round(), "{x}");
    }
}

#[test]
fn a_file_that_is_not_there_changes_nothing() {
    let mut document = labelled();
    let error = run(&mut document, r#"{"selection":{"import":{"path":"/nowhere/mask.nrrd"}}}"#).unwrap_err();
    assert!(error.to_string().starts_with("/nowhere/mask.nrrd"), "{error}");
    let error = run(&mut document, r#"{"selection":{"import":{"path":"x.nrrd","soften_mm":-1}}}"#).unwrap_err();
    assert_eq!(error.to_string(), "soften_mm: -1 found, 0 to 128 mm expected");
    assert_eq!(document.history().undo_names().len(), 0);
}
