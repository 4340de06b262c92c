//! Label maps: as a new document, and brought into the open one.

use super::maker::{bytes, labelled, run};
use crate::common::one::One;
use burin::document::{Document, recovery};
use burin::math::{DAffine3, DMat3, DVec3};
use burin::volume::*;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Writes voxels to an attached, raw NRRD.
fn write(folder: &Path, grid: &Grid, voxels: &Voxels) -> PathBuf {
    let m = grid.world_from_index;
    let row = |v: DVec3| format!("({:?},{:?},{:?})", v.x, v.y, v.z);
    let [nx, ny, nz] = grid.dims;
    let type_ = match voxels.voxel_type() {
        VoxelType::F32 => "float",
        VoxelType::F64 => "double",
        VoxelType::U8 => "uint8",
        VoxelType::I16 => "int16",
        VoxelType::U16 => "uint16",
        VoxelType::I32 => "int32",
        VoxelType::U32 => "uint32",
        VoxelType::I64 => "int64",
        VoxelType::U64 => "uint64",
        VoxelType::I8 => "int8",
    };
    let mut bytes = format!(
        "NRRD0004\ntype: {type_}\ndimension: 3\nspace: RAS\nsizes: {nx} {ny} {nz}\nspace directions: {} {} {}\n\
         space origin: {}\nendian: little\nencoding: raw\n\n",
        row(m.matrix3.x_axis),
        row(m.matrix3.y_axis),
        row(m.matrix3.z_axis),
        row(m.translation)
    )
    .into_bytes();
    bytes.extend_from_slice(voxels.as_bytes());
    let path = folder.join("labels.nrrd");
    std::fs::write(&path, bytes).unwrap();
    path
}

fn each<T>(grid: &Grid, f: impl Fn([u32; 3]) -> T) -> Vec<T> {
    voxels(grid).map(f).collect()
}

fn voxels(grid: &Grid) -> impl Iterator<Item = [u32; 3]> + use<> {
    let [nx, ny, nz] = grid.dims;
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

fn import(document: &mut Document, path: &Path) -> Result<Value, String> {
    run(document, &json!({"segment":{"import":{"path":path}}}).to_string()).map_err(|e| e.to_string())
}

fn label(document: &Document, v: [u32; 3]) -> u16 {
    let texel = document.state().unwrap().one().labels.texel(v).unwrap();
    u16::from_le_bytes([texel[0], texel[1]])
}

fn grid_of(document: &Document) -> Grid {
    *document.state().unwrap().one().grid()
}

/// A document without labels.
fn plain() -> Document {
    let mut document = Document::new();
    document.adopt(super::maker::state());
    document
}

#[test]
fn labels_lie_over_those_that_are_there_and_undo_takes_table_and_voxels_back() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = labelled();
    let grid = grid_of(&document);
    // Segment 2 is the user's own: the file's 2 is something else, and its 1 is the one that is there.
    run(&mut document, r#"{"segment":{"set":{"id":2,"name":"Mine"}}}"#).unwrap();
    let before = bytes(&document);
    let old: Vec<u16> = each(&grid, |v| label(&document, v));
    let map = |v: [u32; 3]| match v {
        [x, _, 12] => (x % 3) as u8 * 2,
        [x, _, 13] if x >= 40 => 1,
        _ => 0,
    };
    let path = write(folder.path(), &grid, &Voxels::U8(each(&grid, map)));
    let answer = import(&mut document, &path).unwrap();
    for (n, v) in voxels(&grid).enumerate() {
        let expected = match map(v) {
            0 => old[n],
            1 => 1,
            2 => 3,
            _ => 4,
        };
        assert_eq!(label(&document, v), expected, "{v:?}");
    }
    let count = |id| voxels(&grid).filter(|v| map(*v) == id).count();
    assert_eq!(
        answer["segments"],
        json!([
            { "id": 1, "value": 1, "name": "Segment 1", "voxels": count(1) },
            { "id": 3, "value": 2, "name": "Segment 2", "voxels": count(2) },
            { "id": 4, "value": 4, "name": "Segment 4", "voxels": count(4) },
        ])
    );
    assert_eq!((&answer["covered"], &answer["resampled"]), (&json!(1.0), &json!(false)));
    assert_eq!(answer["labelled_voxels"], count(1) + count(2) + count(4));
    let segments = &document.state().unwrap().scene.segments();
    assert_eq!(segments.get(3).unwrap().source_value, Some(2));
    assert_eq!(segments.get(4).unwrap().source_value, None);
    assert_eq!(segments.get(2).unwrap().name, "Mine");
    let after = bytes(&document);
    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    assert!(bytes(&document) == before);
    run(&mut document, r#"{"history":{"redo":{}}}"#).unwrap();
    assert!(bytes(&document) == after);
    // The same again changes nothing.
    assert_eq!(import(&mut document, &path).unwrap()["step"], Value::Null);
}

#[test]
fn ids_of_any_size_become_ids_that_the_label_field_holds() {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid::aligned([40, 6, 5], DVec3::ONE, DVec3::ZERO);
    let base = folder.path().join("base.nrrd");
    std::fs::rename(write(folder.path(), &grid, &Voxels::U8(vec![0; 1200])), &base).unwrap();
    let open = json!({"volume":{"open":{"path":base}}}).to_string();
    let pick = |v: [u32; 3]| ((v[0] + v[1]) % 4) as usize;
    fn made<T: burin::volume::Value>(grid: &Grid, ids: [T; 3], pick: impl Fn([u32; 3]) -> usize) -> Voxels {
        T::wrap(each(grid, |v| if pick(v) == 0 { T::from_f64(0.0) } else { ids[pick(v) - 1] }))
    }
    let wide = 1_u64 << 53;
    for (numbers, values, ids) in [
        (made(&grid, [7_u8, 1, 255], pick), [7, 1, 255], [7, 1, 255]),
        (made(&grid, [-3_i8, 1, 127], pick), [-3, 1, 127], [2, 1, 127]),
        (made(&grid, [-32_768_i16, -1, 5], pick), [-32_768, -1, 5], [1, 2, 5]),
        (made(&grid, [65_535_u16, 9, 1], pick), [65_535, 9, 1], [65_535, 9, 1]),
        (made(&grid, [65_536_u32, u32::MAX, 1], pick), [65_536, u32::MAX.into(), 1], [2, 3, 1]),
        (made(&grid, [i32::MIN, 2, 3], pick), [i32::MIN.into(), 2, 3], [1, 2, 3]),
        // Neighbours that a 64-bit float cannot tell apart.
        (
            made(&grid, [wide + 1, wide, u64::MAX], pick),
            [i128::from(wide) + 1, wide.into(), u64::MAX.into()],
            [2, 1, 3],
        ),
        (
            made(&grid, [i64::MIN, i64::MAX, i64::MAX - 1], pick),
            [i64::MIN.into(), i64::MAX.into(), i128::from(i64::MAX) - 1],
            [1, 3, 2],
        ),
        (made(&grid, [7.0_f32, 3.0, 16_777_216.0], pick), [7, 3, 16_777_216], [7, 3, 1]),
        (made(&grid, [7.0_f64, -0.0, -4.0], pick), [7, 0, -4], [7, 0, 1]),
    ] {
        let mut document = Document::new();
        run(&mut document, &open).unwrap();
        let path = write(folder.path(), &grid, &numbers);
        let answer = import(&mut document, &path).unwrap();
        for v in voxels(&grid) {
            assert_eq!(label(&document, v), [0, ids[0], ids[1], ids[2]][pick(v)], "{:?} {v:?}", numbers.voxel_type());
        }
        let segments = &document.state().unwrap().scene.segments();
        for (value, id) in values.into_iter().zip(ids).filter(|(_, id)| *id != 0) {
            let segment = segments.get(id).unwrap();
            assert_eq!((segment.file_value(), &segment.name), (value, &format!("Segment {value}")));
        }
        let said: Vec<i128> =
            answer["segments"].as_array().unwrap().iter().map(|s| s["value"].to_string().parse().unwrap()).collect();
        let mut sorted: Vec<i128> = values.into_iter().filter(|v| *v != 0).collect();
        sorted.sort_unstable();
        assert_eq!(said, sorted);
        // What a project and the journal keep.
        let scene = serde_json::to_string(&document.state().unwrap().scene).unwrap();
        let back: burin::document::Scene = serde_json::from_str(&scene).unwrap();
        assert_eq!(*back.segments(), **segments);
    }
}

#[test]
fn what_is_no_label_map_is_refused_with_what_was_found() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = labelled();
    let grid = grid_of(&document);
    let before = bytes(&document);
    for odd in [0.5, f32::NAN, f32::INFINITY, 1e30, -2.25] {
        let value = |v: [u32; 3]| if v == [5, 6, 7] { odd } else { 3.0 };
        let path = write(folder.path(), &grid, &Voxels::F32(each(&grid, value)));
        let text = import(&mut document, &path).unwrap_err();
        let found = format!("label ids: found {} at voxel [5, 6, 7]; expected whole numbers", f64::from(odd));
        assert!(text.contains("labels.nrrd") && text.contains(&found), "{text}");
    }
    let number = |v: [u32; 3]| (v[0] + 70 * (v[1] + 40 * v[2])) % 65_537;
    let path = write(folder.path(), &grid, &Voxels::U32(each(&grid, number)));
    let text = import(&mut document, &path).unwrap_err();
    assert!(text.contains("found more than 65535 different ids; expected at most 65535"), "{text}");
    // As many as there is room for, and two that are there already with the same name.
    let number = |v: [u32; 3]| (v[0] + 70 * (v[1] + 40 * v[2])) % 65_536;
    let path = write(folder.path(), &grid, &Voxels::U32(each(&grid, number)));
    let answer = import(&mut document, &path).unwrap();
    assert_eq!(answer["segments"].as_array().unwrap().len(), 65_535);
    assert_eq!(label(&document, [1, 0, 0]), 1);
    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    run(&mut document, r#"{"segment":{"set":{"id":2,"name":"Mine"}}}"#).unwrap();
    let text = import(&mut document, &path).unwrap_err();
    assert!(text.contains("found 1 ids where 0 are free") && text.contains("65535 segments in all"), "{text}");
    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    assert!(bytes(&document) == before);
}

#[test]
fn scaled_integers_are_labels_as_far_as_they_come_to_whole_numbers() {
    use crate::io::files::Nifti;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("labels.nii");
    // A tenth is none of a 32-bit float's numbers: what it makes of 30 is 3 all the same. A half of an odd number is no whole.
    for (slope, stored, wanted) in [(0.1, 30, Some(3)), (0.5, 14, Some(7)), (0.5, 15, None), (0.5, 1_200_001, None)] {
        let mut header = Nifti::new(VoxelType::I32, &[3, 4, 5], false);
        header.f32(112, slope).i16(254, 1);
        header.f32s(280, &[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        std::fs::write(&path, header.with(&Voxels::I32(vec![stored; 60]))).unwrap();
        let mut document = Document::new();
        let open = json!({"volume":{"open":{"path":path,"as":"labels"}}}).to_string();
        let opened = run(&mut document, &open);
        assert_eq!(opened.is_ok(), wanted.is_some(), "{slope} of {stored}: {opened:?}");
        if let Some(wanted) = wanted {
            assert_eq!(label(&document, [1, 2, 3]), wanted);
        }
    }
}

#[test]
fn another_grid_gives_the_nearest_voxels_labels() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = plain();
    let ours = grid_of(&document);
    let label_at = |v: [u32; 3]| (v[0] * 7 + v[1] * 3 + v[2] * 11) % 5;
    let point = |v: [u32; 3]| DVec3::new(v[0] as f64, v[1] as f64, v[2] as f64);
    for (dims, spacing, turn) in [
        ([60, 40, 50], DVec3::new(1.3, 2.1, 1.7), -0.3),
        // Finer by far, so that a brick of ours is too many voxels at once.
        ([160, 160, 110], DVec3::new(0.2, 0.2, 0.1), 0.2),
    ] {
        let matrix3 = DMat3::from_rotation_z(turn) * DMat3::from_diagonal(spacing);
        let theirs =
            Grid { dims, world_from_index: DAffine3 { matrix3, translation: DVec3::new(-20.0, -15.0, -30.0) } };
        let path = write(folder.path(), &theirs, &Voxels::U32(each(&theirs, label_at)));
        let answer = import(&mut document, &path).unwrap();
        let (mut covered, mut total) = (0_u32, 0_u32);
        for v in voxels(&ours) {
            let world = ours.world_from_index.transform_point3(point(v));
            let p = theirs.index_from_world().transform_point3(world);
            let near = p.round();
            let inside = near.cmpge(DVec3::ZERO).all() && near.cmplt(theirs.dims_f64()).all();
            total += 1;
            covered += u32::from(inside);
            // Midway either neighbour is right.
            if inside && ((p - near).abs() - 0.5).abs().min_element() > 1e-4 {
                let expected = label_at([near.x as u32, near.y as u32, near.z as u32]);
                assert_eq!(u32::from(label(&document, v)), expected, "{v:?}");
            } else if !inside && ((p - near).abs() - 0.5).abs().min_element() > 1e-4 {
                assert_eq!(label(&document, v), 0, "{v:?}");
            }
        }
        let share = f64::from(covered) / f64::from(total);
        assert!(share > 0.01 && share < 1.0, "{share}");
        assert!((answer["covered"].as_f64().unwrap() - share).abs() < 1e-3, "{answer}");
        assert_eq!(answer["resampled"], true);
        let warnings = answer["warnings"].to_string();
        assert!(warnings.contains("of the volume: it lies at x "), "{warnings}");
        run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    }
}

#[test]
fn a_file_from_another_space_is_refused_with_both_places() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = labelled();
    let ours = grid_of(&document);
    let before = bytes(&document);
    let mut away = ours;
    away.world_from_index.translation.x += 500.0;
    let path = write(folder.path(), &away, &Voxels::U8(each(&away, |v| u8::from(v[0] < 2))));
    for verb in [json!({"segment":{"import":{"path":path}}}), json!({"selection":{"import":{"path":path}}})] {
        let text = run(&mut document, &verb.to_string()).unwrap_err().to_string();
        let bounds = ours.world_bounds();
        let ours_said = format!("x {:.1} to {:.1}", bounds.min.x, bounds.max.x);
        assert!(text.contains("labels.nrrd: place: found 2640 voxels of"), "{text}");
        assert!(text.contains(&ours_said) && text.contains(" mm; expected them in the volume, at x "), "{text}");
        let first = Grid { dims: [2, 40, 33], ..away }.world_bounds();
        assert!(text.contains(&format!("x {:.1} to {:.1}", first.min.x, first.max.x)), "{text}");
    }
    // The boxes meet, but no label lies in ours.
    let mut beside = ours;
    beside.world_from_index.translation += ours.world_from_index.matrix3.x_axis * 40.0;
    let path = write(folder.path(), &beside, &Voxels::U8(each(&beside, |v| u8::from(v[0] >= 35))));
    for verb in [json!({"segment":{"import":{"path":path}}}), json!({"selection":{"import":{"path":path}}})] {
        let text = run(&mut document, &verb.to_string()).unwrap_err().to_string();
        assert!(text.contains("place: found"), "{text}");
    }
    assert!(bytes(&document) == before);
    // Half of them do.
    let path = write(folder.path(), &beside, &Voxels::U8(each(&beside, |v| u8::from(v[0] < 60))));
    for verb in [json!({"segment":{"import":{"path":path}}}), json!({"selection":{"import":{"path":path}}})] {
        let answer = run(&mut document, &verb.to_string()).unwrap();
        let warnings = answer["warnings"].to_string();
        assert!(warnings.contains("50.0 % of the file's voxels of"), "{warnings}");
        assert!(warnings.contains("the file covers 42.9 % of the volume"), "{warnings}");
        assert!((answer["covered"].as_f64().unwrap() - 30.0 / 70.0).abs() < 1e-12);
    }
    // A file with nothing in it brings nothing, and says so.
    let path = write(folder.path(), &ours, &Voxels::U8(each(&ours, |_| 0)));
    let answer = import(&mut document, &path).unwrap();
    assert_eq!((&answer["step"], &answer["labelled_voxels"]), (&Value::Null, &json!(0)));
    assert!(answer["warnings"].to_string().contains("holds no labels"), "{answer}");
}

#[test]
fn voxels_of_locked_segments_keep_their_label() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = labelled();
    let grid = grid_of(&document);
    run(&mut document, r#"{"segment":{"set":{"id":1,"locked":true}}}"#).unwrap();
    let old: Vec<u16> = each(&grid, |v| label(&document, v));
    let path = write(folder.path(), &grid, &Voxels::U8(each(&grid, |_| 9)));
    let answer = import(&mut document, &path).unwrap();
    let kept = old.iter().filter(|&&l| l == 1).count();
    assert!(kept > 0);
    assert_eq!((&answer["kept_locked"], &answer["labelled_voxels"]), (&json!(kept), &json!(old.len() - kept)));
    for (v, old) in voxels(&grid).zip(old) {
        assert_eq!(label(&document, v), if old == 1 { 1 } else { 9 });
    }
    assert!(answer["warnings"].to_string().contains("locked"));
}

#[test]
fn a_label_map_opens_as_labels_as_selection_or_as_the_image_that_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid::aligned([40, 33, 5], DVec3::new(1.0, 2.0, 3.0), DVec3::splat(4.0));
    let map = |v: [u32; 3]| [0, 70_000, -5, 3][((v[0] / 4 + v[1]) % 4) as usize];
    let path = write(folder.path(), &grid, &Voxels::I32(each(&grid, map)));
    let open = |extra: Value| {
        let mut command = json!({ "path": path });
        command.as_object_mut().unwrap().extend(extra.as_object().unwrap().clone());
        let mut document = Document::new();
        let answer = run(&mut document, &json!({"volume":{"open":command}}).to_string()).unwrap();
        (document, answer)
    };
    for (extra, what) in [
        (json!({}), "image"),
        (json!({"as":"image"}), "image"),
        (json!({"as":"labels"}), "labels"),
        (json!({"as":"selection"}), "selection"),
    ] {
        let (mut document, answer) = open(extra);
        assert_eq!(answer["dims"], json!([40, 33, 5]));
        assert_eq!((answer["min"].as_f64(), answer["max"].as_f64()), (Some(-5.0), Some(70_000.0)));
        for v in voxels(&grid) {
            let expected = match map(v) {
                70_000 => 2,
                -5 => 1,
                other => other as u16,
            };
            assert_eq!(label(&document, v), if what == "labels" { expected } else { 0 }, "{what} {v:?}");
            let selected = document.state().unwrap().one().selection.texel(v).unwrap()[0];
            assert_eq!(selected, if what == "selection" && map(v) > 0 { 255 } else { 0 }, "{what} {v:?}");
        }
        assert!(document.history().undo_names().len() == 0 && !document.is_unsaved());
        let values: Vec<i128> = document.state().unwrap().scene.segments().0.iter().map(Segment::file_value).collect();
        assert_eq!(values, if what == "labels" { vec![-5, 70_000, 3] } else { vec![] });
        if what != "labels" {
            assert_eq!(answer.get("segments"), None);
        }
        if what == "selection" {
            assert_eq!(answer["selected_voxels"], voxels(&grid).filter(|v| map(*v) > 0).count());
        }
        // A project keeps it.
        let project = folder.path().join(what);
        let _ = std::fs::remove_dir_all(&project);
        run(&mut document, &json!({"project":{"save":{"path":project}}}).to_string()).unwrap();
        let saved = bytes(&document);
        let mut again = Document::new();
        drop(document);
        run(&mut again, &json!({"project":{"open":{"path":project}}}).to_string()).unwrap();
        assert!(bytes(&again) == saved, "{what}");
    }
    let mut document = Document::new();
    let refused = json!({"volume":{"open":{"path":path,"as":"meshes"}}}).to_string();
    assert!(serde_json::from_str::<burin::document::Command>(&refused).is_err());
    let path = write(folder.path(), &grid, &Voxels::F32(each(&grid, |_| 0.25)));
    let open = json!({"volume":{"open":{"path":path,"as":"labels"}}});
    assert!(run(&mut document, &open.to_string()).unwrap_err().to_string().contains("found 0.25"));
    assert!(document.state().is_none());
}

#[test]
fn labels_and_selection_of_an_opened_file_come_back_after_a_crash() {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid::aligned([40, 33, 5], DVec3::ONE, DVec3::ZERO);
    let path = write(folder.path(), &grid, &Voxels::U32(each(&grid, |v| v[0] * 40_000)));
    for what in ["labels", "selection"] {
        let state_dir = folder.path().join(what);
        let mut document = Document::new();
        document.keep_unsaved_in(state_dir.clone());
        run(&mut document, &json!({"volume":{"open":{"path":path,"as":what}}}).to_string()).unwrap();
        run(&mut document, r#"{"view":{"window":{"level":1,"width":2}}}"#).unwrap();
        let before = bytes(&document);
        drop(document);
        let lost = recovery::list(&state_dir).unwrap();
        assert_eq!(lost.len(), 1, "{what}");
        let mut again = Document::new();
        again.keep_unsaved_in(state_dir);
        run(&mut again, &json!({"project":{"recover":{"id":lost[0].id}}}).to_string()).unwrap();
        assert!(bytes(&again) == before, "{what}");
    }
}

#[test]
fn what_was_only_opened_and_looked_at_is_no_unsaved_work() {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid::aligned([40, 33, 5], DVec3::ONE, DVec3::ZERO);
    let path = write(folder.path(), &grid, &Voxels::U32(each(&grid, |v| v[0] * 40_000)));
    for what in ["image", "labels", "selection"] {
        let state_dir = folder.path().join(what);
        let mut document = Document::new();
        document.keep_unsaved_in(state_dir.clone());
        run(&mut document, &json!({"volume":{"open":{"path":path,"as":what}}}).to_string()).unwrap();
        run(&mut document, r#"{"view":{"orbit":{"azimuth_deg":5,"elevation_deg":0}}}"#).unwrap();
        drop(document);
        assert_eq!(recovery::list(&state_dir).unwrap(), [], "{what}");
        assert_eq!(std::fs::read_dir(state_dir.join("recovery")).unwrap().count(), 0, "{what}: nothing is left behind");
    }
    // One voxel of work after the looking about, and all of it is offered: the file's labels, the work and the view.
    let state_dir = folder.path().join("worked");
    let mut document = Document::new();
    document.keep_unsaved_in(state_dir.clone());
    run(&mut document, &json!({"volume":{"open":{"path":path,"as":"labels"}}}).to_string()).unwrap();
    run(&mut document, r#"{"view":{"orbit":{"azimuth_deg":5,"elevation_deg":0}}}"#).unwrap();
    run(&mut document, r#"{"segment":{"set":{"id":2,"name":"bone"}}}"#).unwrap();
    let (before, views) = (bytes(&document), document.state().unwrap().scene.views.clone());
    drop(document);
    let lost = recovery::list(&state_dir).unwrap();
    assert_eq!(lost.len(), 1);
    let mut again = Document::new();
    again.keep_unsaved_in(state_dir);
    let answer = run(&mut again, &json!({"project":{"recover":{"id":lost[0].id}}}).to_string()).unwrap();
    assert_eq!(answer["recovered"]["steps"], 1, "the opening is none of them");
    assert!(bytes(&again) == before);
    assert_eq!(again.state().unwrap().scene.views, views);
}

#[test]
fn a_seg_nrrd_brings_names_and_colours_and_of_its_layers_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let header = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 2 40 6 5\nkinds: list domain domain domain\nencoding: raw\n\
                  Segment0_Name:=Liver\nSegment0_Color:=1 0.5 0\nSegment0_LabelValue:=1\nSegment0_Layer:=0\n\
                  Segment1_Name:=Tumour\nSegment1_Color:=0 0 1\nSegment1_LabelValue:=1\nSegment1_Layer:=1\n\n";
    // The liver everywhere; the tumour in it where x is 3.
    let voxels = (0..1200).flat_map(|n| [1, u8::from(n % 40 == 3)]);
    let path = folder.path().join("two.seg.nrrd");
    std::fs::write(&path, header.bytes().chain(voxels).collect::<Vec<u8>>()).unwrap();
    let mut document = Document::new();
    let answer = run(&mut document, &json!({"volume":{"open":{"path":path,"as":"labels"}}}).to_string()).unwrap();
    assert!(
        answer["warnings"].to_string().contains("in 2 layers, which may overlap; the first is taken: Tumour left out")
    );
    let second = json!({"segment":{"import":{"path":path,"component":1}}}).to_string();
    assert_eq!(run(&mut document, &second).unwrap()["labelled_voxels"], 30);
    let table = &document.state().unwrap().scene.segments();
    let told: Vec<_> = table.0.iter().map(|s| (s.id, s.name.as_str(), s.colour, s.file_value())).collect();
    assert_eq!(told, [(1, "Liver", [1.0, 0.5, 0.0], 1), (2, "Tumour", [0.0, 0.0, 1.0], 1)]);
    for v in voxels_of_x(&[2, 3, 4]) {
        assert_eq!(label(&document, v), if v[0] == 3 { 2 } else { 1 });
    }
}

fn voxels_of_x(xs: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    xs.iter().flat_map(|&x| (0..30).map(move |n| [x, n % 6, n / 6]))
}
