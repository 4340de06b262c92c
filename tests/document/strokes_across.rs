//! Strokes that paint several volumes at once: a volume and a finer, mirrored, moved one inside it.
//!
//! What every voxel must hold is written from the brush's documentation: dabs at fixed arc length of the path, G = strength · F(d / radius)
//! with d in world mm from the voxel's centre, P′ = P + G·((C op P) − P).

use super::maker::run;
use burin::document::Document;
use burin::math::{DAffine3, DMat3, DVec3, Pose};
use burin::volume::{FieldKind, Grid, VolumeId};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command as Process, Stdio};

/// Oblique, of thick slices, about the origin.
fn outer() -> Grid {
    let matrix3 = DMat3::from_rotation_z(0.2) * DMat3::from_diagonal(DVec3::new(1.5, 1.2, 2.0));
    centred([24, 20, 16], matrix3)
}

/// Fine, turned and mirrored.
fn inner() -> Grid {
    let turned = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    centred([26, 22, 20], turned * DMat3::from_diagonal(DVec3::new(-0.6, 0.6, 0.6)))
}

fn centred(dims: [u32; 3], matrix3: DMat3) -> Grid {
    let middle = DVec3::from_array(dims.map(|n| f64::from(n - 1) / 2.0));
    Grid { dims, world_from_index: DAffine3 { matrix3, translation: -(matrix3 * middle) } }
}

/// Where the inner volume is moved to by hand.
fn pose() -> Value {
    json!({"rotation": [0.0, 0.0, 0.6, 0.8], "translation": [2.0, -1.0, 1.5]})
}

fn value([x, y, z]: [u32; 3]) -> i16 {
    ((x * 7 + y * 5 + z * 3) % 90) as i16 - 20
}

/// 16-bit integers in an NRRD.
fn file(dir: &Path, name: &str, grid: &Grid) -> PathBuf {
    let m = grid.world_from_index;
    let row = |v: DVec3| format!("({:?},{:?},{:?})", v.x, v.y, v.z);
    let [nx, ny, nz] = grid.dims;
    let [a, b, c] = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis].map(row);
    let mut bytes = format!(
        "NRRD0004\ntype: short\ndimension: 3\nspace: right-anterior-superior\nsizes: {nx} {ny} {nz}\n\
         space directions: {a} {b} {c}\nspace origin: {}\nendian: little\nencoding: raw\n\n",
        row(m.translation)
    )
    .into_bytes();
    for v in voxels(grid.dims) {
        bytes.extend(value(v).to_le_bytes());
    }
    let path = dir.join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

fn voxels([nx, ny, nz]: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

fn say(document: &mut Document, line: Value) -> Value {
    run(document, &line.to_string()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

fn refused(document: &mut Document, line: Value) -> String {
    run(document, &line.to_string()).expect_err(&line.to_string()).to_string()
}

/// The outer volume 0, which is active, and the inner volume 1; nothing where there is no GPU and that is known.
fn nested(dir: &Path) -> Option<Document> {
    crate::common::gpu::gpu()?;
    let mut document = Document::new();
    document.keep_unsaved_in(dir.join("unsaved"));
    let (a, b) = (file(dir, "outer.nrrd", &outer()), file(dir, "inner.nrrd", &inner()));
    say(&mut document, json!({"volume": {"open": {"path": a}}}));
    say(&mut document, json!({"volume": {"add": {"path": b}}}));
    say(&mut document, json!({"volume": {"set": {"volume": 1, "pose": pose()}}}));
    Some(document)
}

/// Where a voxel of a volume lies in the world, by its file and the pose that it was given.
fn world(document: &Document, id: u32, v: [u32; 3]) -> DVec3 {
    let grid = if id == 0 { outer() } else { inner() };
    let at = grid.world_from_index.transform_point3(DVec3::from_array(v.map(f64::from)));
    let given = document.state().unwrap().scene.volumes.all[&VolumeId(id)].pose;
    if given == Pose::IDENTITY { at } else { given.apply(at) }
}

/// Every byte of one volume's fields, its map of density and its segments.
fn of(document: &Document, id: u32) -> (Vec<Vec<u8>>, String) {
    let state = document.state().unwrap();
    let volume = &state.volumes[&VolumeId(id)];
    let bytes = FieldKind::ALL.map(|kind| {
        let field = volume.field(kind);
        field.read(0, [0; 3], field.dims(0)).unwrap()
    });
    let segments = &state.scene.volumes.all[&VolumeId(id)].segments;
    (bytes.to_vec(), format!("{:?} {}", volume.density.map(), serde_json::to_string(segments).unwrap()))
}

/// Every volume that there is.
fn all(document: &Document) -> Vec<(Vec<Vec<u8>>, String)> {
    document.state().unwrap().volumes.keys().map(|id| of(document, id.0)).collect()
}

fn both(document: &Document) -> [(Vec<Vec<u8>>, String); 2] {
    [of(document, 0), of(document, 1)]
}

/// The way that most strokes here take: through both volumes, bent, leaving the inner one.
const WAY: [[f64; 3]; 4] = [[-9.0, -2.0, 1.0], [1.0, 0.5, 2.0], [4.0, -3.0, 0.0], [11.0, 6.0, -3.5]];

fn points() -> Value {
    Value::Array(WAY.map(|mm| json!({"at": {"mm": mm}})).to_vec())
}

struct Laid {
    at: DVec3,
    /// The share by which it counts where dabs add up.
    share: f64,
}

/// Dabs `step` apart along the polyline, the first at its first point, and one at its last.
fn dabs(way: &[[f64; 3]], step: f64) -> Vec<Laid> {
    let way: Vec<_> = way.iter().map(|p| DVec3::from_array(*p)).collect();
    let lengths: Vec<f64> = way.windows(2).map(|w| w[0].distance(w[1])).collect();
    let total: f64 = lengths.iter().sum();
    let at = |mut arc: f64| {
        for (i, length) in lengths.iter().enumerate() {
            if arc <= *length || i + 1 == lengths.len() {
                return way[i].lerp(way[i + 1], (arc / length).min(1.0));
            }
            arc -= length;
        }
        way[0]
    };
    let count = (total / step).floor() as u32;
    let mut dabs: Vec<_> = (0..=count).map(|n| Laid { at: at(f64::from(n) * step), share: 1.0 }).collect();
    dabs.push(Laid { at: *way.last().unwrap(), share: total / step - f64::from(count) });
    dabs
}

/// F of the falloff's name at d / radius.
fn falloff(name: &str, x: f64) -> f64 {
    match name {
        _ if x > 1.0 => 0.0,
        "hard" => 1.0,
        "linear" => 1.0 - x,
        _ => (1.0 - x * x).powi(2),
    }
}

const RADIUS: f64 = 3.2;
const SPACING: f64 = 0.25;

/// Whether rounding of single-precision distances may decide about a hard rim.
fn at_rim(dabs: &[Laid], p: DVec3, radius: f64) -> bool {
    dabs.iter().any(|dab| (dab.at.distance(p) / radius - 1.0).abs() < 2e-6)
}

fn set_brush(document: &mut Document, target: Value, more: Value) {
    let mut set = json!({"target": target, "radius_mm": RADIUS, "spacing": SPACING, "shape": "sphere", "strength": 0.75,
        "falloff": "smooth", "tip": "wash", "operation": "replace", "erase": false});
    set["any_value"] = json!(more.get("range").is_none());
    set.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    say(document, json!({"brush": {"set": set}}));
}

#[test]
fn every_voxel_of_both_volumes_has_what_one_path_in_mm_gives_it() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = nested(dir.path()) else { return };
    let dabs = dabs(&WAY, SPACING * RADIUS);
    let paint = json!({"stroke": {"paint": {"points": points(), "volumes": [0, 1]}}});
    for (target, name, tip, operation) in [
        (json!({"density": 40.0}), "smooth", "build_up", "add"),
        (json!({"density": 600.0}), "linear", "wash", "replace"),
        (json!({"colour": [1.0, 0.5, 0.0, 0.8]}), "smooth", "wash", "replace"),
        (json!({"selection": 1.0}), "linear", "build_up", "replace"),
        (json!({"label": 3}), "hard", "wash", "replace"),
    ] {
        set_brush(&mut document, target.clone(), json!({"falloff": name, "tip": tip, "operation": operation}));
        let answer = say(&mut document, paint.clone());
        let state = document.state().unwrap();
        let mut changed = [0_u64; 2];
        for id in [0_u32, 1] {
            let volume = &state.volumes[&VolumeId(id)];
            for v in voxels(volume.grid().dims) {
                let p = world(&document, id, v);
                let g = |dab: &Laid| 0.75 * falloff(name, dab.at.distance(p) / RADIUS);
                let wash = dabs.iter().map(g).fold(0.0, f64::max);
                let sum: f64 = dabs.iter().map(|d| g(d) * d.share).sum();
                let rest: f64 = dabs.iter().map(|d| 1.0 - g(d) * d.share).product();
                let start = f64::from(value(v));
                let told = format!("{target} {v:?} of {id}");
                match name {
                    _ if target.get("density").is_some() => {
                        let expected =
                            if operation == "add" { start + sum * 40.0 } else { start + wash * (600.0 - start) };
                        let found = f64::from(volume.density.value(v).unwrap());
                        assert!((found - expected).abs() < 0.02, "{told}: {found} for {expected}");
                        changed[id as usize] += u64::from(found != start);
                    }
                    _ if target.get("colour").is_some() => {
                        let found = volume.colour.texel(v).unwrap();
                        let alpha = (wash * 0.8 * 255.0 - f64::from(found[3])).abs();
                        assert!(alpha <= 0.51, "{told}: {found:?} for {wash}");
                        assert!(found[3] == 0 || found[..3] == [255, 128, 0], "{told}: {found:?}");
                        changed[id as usize] += u64::from(found != [0; 4]);
                    }
                    _ if target.get("selection").is_some() => {
                        let found = volume.selection.texel(v).unwrap()[0];
                        assert!(((1.0 - rest) * 255.0 - f64::from(found)).abs() <= 0.51, "{told}: {found} for {rest}");
                        changed[id as usize] += u64::from(found != 0);
                    }
                    _ => {
                        let found = volume.labels.texel(v).unwrap()[0];
                        let expected = if wash > 0.0 { 3 } else { 0 };
                        assert!(found == expected || at_rim(&dabs, p, RADIUS), "{told}: {found}");
                        changed[id as usize] += u64::from(found != 0);
                    }
                }
            }
        }
        assert!(changed.iter().all(|n| *n > 200), "{target}: {changed:?}");
        for (id, of) in answer["volumes"].as_array().unwrap().iter().enumerate() {
            assert_eq!((&of["volume"], &of["voxels_changed"]), (&json!(id), &json!(changed[id])), "{target}");
        }
        assert_eq!(answer["voxels_changed"], json!(changed[0] + changed[1]));
        say(&mut document, json!({"history": {"undo": {}}}));
    }
}

#[test]
fn a_thin_brush_leaves_no_gap_in_the_coarse_volume_and_paints_the_fine_one_by_distance() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = nested(dir.path()) else { return };
    // Under half of a voxel's diagonal in the one (1.38 mm), over it in the other (0.52 mm).
    set_brush(&mut document, json!({"label": 2}), json!({"radius_mm": 0.6, "falloff": "hard"}));
    say(&mut document, json!({"stroke": {"paint": {"points": points(), "volumes": [1, 0]}}}));
    let dabs = dabs(&WAY, SPACING * 0.6);
    let index_from_world = outer().world_from_index.inverse();
    // The part of a piece of the way that lies in a voxel, by where it meets the voxel's walls.
    let within = |v: [u32; 3], ends: &[[f64; 3]]| {
        let [a, b] = [ends[0], ends[1]].map(|p| index_from_world.transform_point3(DVec3::from_array(p)));
        let (centre, step) = (DVec3::from_array(v.map(f64::from)), b - a);
        let [s, t] = [-0.5, 0.5].map(|half| (centre + half - a) / step);
        s.max(t).min_element().min(1.0) - s.min(t).max_element().max(0.0)
    };
    let state = document.state().unwrap();
    let mut painted = [0, 0];
    for id in [0_u32, 1] {
        let volume = &state.volumes[&VolumeId(id)];
        for v in voxels(volume.grid().dims) {
            let p = world(&document, id, v);
            let near = dabs.iter().any(|dab| dab.at.distance(p) <= 0.6);
            let most = WAY.windows(2).map(|ends| within(v, ends)).fold(f64::NEG_INFINITY, f64::max);
            let found = volume.labels.texel(v).unwrap()[0] == 2;
            let touched = id == 0 && most.abs() < 1e-9;
            let expected = near || (id == 0 && most > 0.0);
            assert!(found == expected || touched || at_rim(&dabs, p, 0.6), "{v:?} of {id}: {found}");
            painted[id as usize] += u32::from(found);
        }
    }
    assert!(painted[0] > 20 && painted[1] > 20, "{painted:?}");
}

#[test]
fn single_voxels_add_up_by_one_spacing_of_dabs_whichever_volume_they_are_of() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = nested(dir.path()) else { return };
    // Through the centres of a row of the outer volume's voxels: none is passed without a dab.
    let row = |x: f64| outer().world_from_index.transform_point3(DVec3::new(x, 9.0, 8.0));
    let ends = [row(6.0), row(17.0)].map(|p| p.to_array());
    let more = json!({"radius_mm": 0.0, "tip": "build_up", "operation": "add", "strength": 0.5, "falloff": "hard"});
    set_brush(&mut document, json!({"density": 8.0}), more);
    let points = ends.map(|mm| json!({"at": {"mm": mm}}));
    say(&mut document, json!({"stroke": {"paint": {"points": points, "volumes": [0, 1]}}}));
    // A quarter of the thinnest layer of voxels: the inner volume's.
    let dabs = dabs(&ends, 0.6 / 4.0);
    let state = document.state().unwrap();
    for x in 7..17 {
        let holds = |dab: &&Laid| (dab.at.distance(row(f64::from(x)))) <= 0.75;
        let sum: f64 = dabs.iter().filter(holds).map(|dab| dab.share).sum();
        let v = [x, 9, 8];
        let expected = f64::from(value(v)) + 8.0 * 0.5 * sum;
        let found = f64::from(state.volumes[&VolumeId(0)].density.value(v).unwrap());
        // A dab on the border of two voxels may be either's.
        assert!(
            (found - expected).abs() <= 4.01 && found - f64::from(value(v)) > 30.0,
            "{v:?}: {found} for {expected}"
        );
    }
}

#[test]
fn a_stroke_on_two_volumes_is_one_step_that_comes_back_byte_for_byte() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = nested(dir.path()) else { return };
    for (target, more) in [
        (json!({"density": 77.25}), json!({})),
        (json!({"density": 30.0}), json!({"tip": "build_up", "operation": "add"})),
        (json!({"colour": [0.2, 0.4, 1.0, 1.0]}), json!({"operation": "blend"})),
        (json!({"selection": 1.0}), json!({"shape": "disc"})),
        (json!({"label": 9}), json!({"range": [0, 40]})),
    ] {
        set_brush(&mut document, target.clone(), more);
        let before = both(&document);
        let steps = document.history().undo_names().count();
        let answer = say(&mut document, json!({"stroke": {"paint": {"points": points(), "volumes": [1, 0]}}}));
        let after = both(&document);
        assert!(before[0] != after[0] && before[1] != after[1], "{target}: {answer}");
        assert!(answer["step"].as_str().unwrap().ends_with("in 2 volumes"), "{answer}");
        assert_eq!(document.history().undo_names().count(), steps + 1);
        for _ in 0..2 {
            say(&mut document, json!({"history": {"undo": {}}}));
            assert!(both(&document) == before, "{target} taken back");
            say(&mut document, json!({"history": {"redo": {}}}));
            assert!(both(&document) == after, "{target} done again");
        }
        // What the step keeps does the same elsewhere.
        let kept = say(&mut document, json!({"ask": {"history": {"commands": true}}}))["undo_commands"][0][0].clone();
        assert_eq!(kept["command"]["stroke"]["paint"]["volumes"], json!([1, 0]));
        say(&mut document, json!({"history": {"undo": {}}}));
        say(&mut document, kept["command"].clone());
        assert!(both(&document) == after, "{target} by its command");
    }
}

#[test]
fn a_stroke_in_frames_is_the_stroke_at_once_and_a_cancelled_one_none() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = nested(dir.path()) else { return };
    set_brush(&mut document, json!({"density": 25.0}), json!({"tip": "build_up", "operation": "add"}));
    let before = both(&document);
    say(&mut document, json!({"stroke": {"paint": {"points": points(), "volumes": [0, 1]}}}));
    let at_once = both(&document);
    say(&mut document, json!({"history": {"undo": {}}}));
    for ends in ["end", "cancel"] {
        for (i, mm) in WAY.iter().enumerate() {
            let points = json!([{"at": {"mm": mm}}]);
            match i {
                0 => say(&mut document, json!({"stroke": {"begin": {"points": points, "volumes": [0, 1]}}})),
                _ => say(&mut document, json!({"stroke": {"extend": {"points": points}}})),
            };
        }
        let answer = say(&mut document, json!({"stroke": {ends: {}}}));
        if ends == "end" {
            assert!(both(&document) == at_once);
            assert_eq!(answer["volumes"].as_array().unwrap().len(), 2, "{answer}");
            say(&mut document, json!({"history": {"undo": {}}}));
        }
        assert!(both(&document) == before, "{ends}");
    }
    assert_eq!(document.history().undo_names().count(), 2, "the volume that was added and its pose");
}

#[test]
fn a_hand_that_carves_two_volumes_in_the_3d_view_goes_where_a_script_goes() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = nested(dir.path()) else { return };
    let function = json!({"colour": [[0, [1, 1, 1]]], "opacity": [[20, 0], [40, 0.9]], "unit_mm": 1});
    say(&mut document, json!({"transfer": {"set": {"function": function}}}));
    say(&mut document, json!({"view": {"size": {"view": "3d", "size": [96, 96]}}}));
    set_brush(&mut document, json!({"density": -20.0}), json!({"radius_mm": 2.5, "falloff": "hard", "strength": 1.0}));
    let way = [[30.0, 50.0], [44.0, 46.0], [52.0, 52.0], [66.0, 40.0]];
    let point = |px: [f64; 2]| json!({"at": {"pixel": {"view": "3d", "px": px}}});
    for visible_only in [false, true] {
        say(&mut document, json!({"brush": {"set": {"visible_only": visible_only}}}));
        let before = both(&document);
        say(&mut document, json!({"stroke": {"paint": {"points": way.map(point), "volumes": [0, 1]}}}));
        let at_once = both(&document);
        assert!(at_once[0] != before[0] && at_once[1] != before[1], "{visible_only}");
        say(&mut document, json!({"history": {"undo": {}}}));
        say(&mut document, json!({"stroke": {"begin": {"points": [point(way[0])], "volumes": [0, 1]}}}));
        for ends in way.windows(2) {
            for share in [0.3, 0.6, 1.0] {
                let px = [0, 1].map(|i| ends[0][i] + (ends[1][i] - ends[0][i]) * share);
                say(&mut document, json!({"stroke": {"extend": {"points": [point(px)]}}}));
                document.picture(burin::document::ViewName::ThreeD, [32, 32], None).unwrap();
            }
        }
        say(&mut document, json!({"stroke": {"end": {}}}));
        assert!(both(&document) == at_once, "{visible_only}");
        say(&mut document, json!({"history": {"undo": {}}}));
        assert!(both(&document) == before);
    }
}

#[test]
fn what_is_named_wrongly_is_said_and_changes_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = nested(dir.path()) else { return };
    set_brush(&mut document, json!({"selection": 1.0}), json!({}));
    let before = (both(&document), document.history().undo_names().count());
    let begin = |more: Value| {
        let mut begin = json!({"points": points()});
        begin.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        json!({"stroke": {"paint": begin}})
    };
    for (more, needle) in [
        (json!({"volumes": []}), "at least one"),
        (json!({"volumes": [1, 1]}), "1 twice"),
        (json!({"volumes": [0, 7]}), "1 (inner.nrrd)"),
        (json!({"volumes": [0, 1], "volume": 0}), "either `volume` or `volumes`"),
    ] {
        let said = refused(&mut document, begin(more.clone()));
        assert!(said.contains("volumes") && said.contains(needle), "{more}: {said}");
    }
    // One of the two cannot be painted so: a radius of 200 km is more than 65,536 of its voxels.
    let tiny = centred([4, 4, 4], DMat3::from_diagonal(DVec3::splat(0.0001)));
    say(&mut document, json!({"volume": {"add": {"path": file(dir.path(), "tiny.nrrd", &tiny)}}}));
    set_brush(&mut document, json!({"label": 4}), json!({"radius_mm": 20.0}));
    let said = refused(&mut document, begin(json!({"volumes": [0, 2]})));
    assert!(said.contains("radius_mm"), "{said}");
    assert!(refused(&mut document, json!({"brush": {"also": {"volumes": [5]}}})).contains("volumes"));
    assert!(!document.is_painting());
    assert!((both(&document), document.history().undo_names().count() - 1) == before);
}

#[test]
fn a_stroke_that_misses_one_of_its_volumes_leaves_no_segment_and_no_wider_map_there() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = nested(dir.path()) else { return };
    say(&mut document, json!({"segment": {"set": {"id": 6, "name": "Lesion", "colour": [0.1, 0.9, 0.3]}}}));
    let before = both(&document);
    // At the outer volume's border, far from the inner one.
    let beside = json!([{"at": {"mm": [-14.0, -4.0, 0.0]}}, {"at": {"mm": [-13.0, 2.0, 1.0]}}]);
    for target in [json!({"label": 6}), json!({"density": 0.125}), json!({"density": 90_000.0})] {
        set_brush(&mut document, target.clone(), json!({"radius_mm": 2.0, "falloff": "hard"}));
        let answer = say(&mut document, json!({"stroke": {"paint": {"points": beside, "volumes": [1, 0]}}}));
        assert!(of(&document, 0) != before[0], "{target}: {answer}");
        assert!(of(&document, 1) == before[1], "{target}: {answer}");
        let told = &answer["volumes"][0];
        assert_eq!(
            (&told["voxels_changed"], told["nothing"].as_str().unwrap()),
            (&json!(0), "The stroke lay outside the volume.")
        );
        // The pictures of what was put back are right too: what is painted there next has its own values.
        say(&mut document, json!({"history": {"undo": {}}}));
        assert!(both(&document) == before);
    }
    // Where both are met, the segment is called and coloured as where it was known.
    set_brush(&mut document, json!({"label": 6}), json!({}));
    say(&mut document, json!({"stroke": {"paint": {"points": points(), "volumes": [1, 0]}}}));
    let segments = &document.state().unwrap().scene.volumes.all[&VolumeId(1)].segments;
    assert_eq!((segments.get(6).unwrap().name.as_str(), segments.get(6).unwrap().colour), ("Lesion", [0.1, 0.9, 0.3]));
    // Beside both it is no step.
    let all = both(&document);
    let far = json!([{"at": {"mm": [900.0, 0.0, 0.0]}}]);
    let answer = say(&mut document, json!({"stroke": {"paint": {"points": far, "volumes": [1, 0]}}}));
    assert_eq!((&answer["step"], &answer["nothing"]), (&Value::Null, &json!("The stroke lay outside the volume.")));
    assert!(both(&document) == all);
}

#[test]
fn ranges_locks_and_restoring_go_by_each_volume_itself() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = nested(dir.path()) else { return };
    let paint = json!({"stroke": {"paint": {"points": points(), "volumes": [0, 1]}}});
    // By its own values.
    set_brush(&mut document, json!({"label": 1}), json!({"range": [10, 30]}));
    say(&mut document, paint.clone());
    let mut free = 0;
    for id in [0_u32, 1] {
        let volume = &document.state().unwrap().volumes[&VolumeId(id)];
        for v in voxels(volume.grid().dims) {
            let labelled = volume.labels.texel(v).unwrap()[0] == 1;
            assert!(!labelled || (10..=30).contains(&value(v)), "{v:?} of {id}");
            free += u32::from(labelled);
        }
    }
    assert!(free > 500);
    // By its own locks: the same number is locked in one and not in the other.
    say(&mut document, json!({"segment": {"set": {"id": 1, "locked": true, "volume": 1}}}));
    let before = both(&document);
    set_brush(&mut document, json!({"label": 2}), json!({}));
    say(&mut document, paint.clone());
    let count = |document: &Document, id: u32, label: u8| {
        let labels = &document.state().unwrap().volumes[&VolumeId(id)].labels;
        voxels(labels.dims(0)).filter(|v| labels.texel(*v).unwrap()[0] == label).count()
    };
    assert_eq!(count(&document, 0, 1), 0, "painted over");
    assert!(count(&document, 1, 1) > 0 && count(&document, 1, 2) > 0, "kept");
    say(&mut document, json!({"history": {"undo": {}}}));
    assert!(both(&document) == before);
    // Back to each volume's own source.
    say(&mut document, json!({"segment": {"set": {"id": 1, "locked": false, "volume": 1}}}));
    let before = both(&document);
    set_brush(&mut document, json!({"density": 300.0}), json!({"falloff": "hard", "strength": 1.0}));
    say(&mut document, paint.clone());
    set_brush(
        &mut document,
        json!({"density": 300.0}),
        json!({"falloff": "hard", "strength": 1.0, "operation": "restore"}),
    );
    say(&mut document, paint);
    for (now, then) in both(&document).iter().zip(&before) {
        let kind = FieldKind::ALL.iter().position(|kind| *kind == FieldKind::Density).unwrap();
        assert!(now.0.iter().zip(&then.0).enumerate().all(|(i, (a, b))| i == kind || a == b));
    }
    for id in [0_u32, 1] {
        let volume = &document.state().unwrap().volumes[&VolumeId(id)];
        assert!(voxels(volume.grid().dims).all(|v| volume.density.value(v).unwrap() == f32::from(value(v))));
    }
}

#[test]
fn pictures_of_the_same_frame_show_a_running_stroke_in_all_its_volumes() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = nested(dir.path()) else { return };
    set_brush(&mut document, json!({"density": 400.0}), json!({"falloff": "hard", "strength": 1.0}));
    say(&mut document, json!({"view": {"crosshair": {"at": {"mm": [1.0, 0.5, 2.0]}}}}));
    let pictures = |document: &mut Document| {
        use burin::document::ViewName::{Axial, ThreeD};
        [ThreeD, Axial].map(|view| document.picture(view, [48, 48], None).unwrap().colour)
    };
    for volumes in [json!([0, 1]), json!([1]), json!([0])] {
        let before = pictures(&mut document);
        let begin = json!({"points": points(), "volumes": volumes});
        say(&mut document, json!({"stroke": {"begin": begin}}));
        let running = pictures(&mut document);
        assert!(running[0] != before[0] && running[1] != before[1], "{volumes}");
        say(&mut document, json!({"stroke": {"end": {}}}));
        let ended = pictures(&mut document);
        assert!(running == ended, "{volumes}");
        say(&mut document, json!({"history": {"undo": {}}}));
        assert!(pictures(&mut document) == before, "{volumes} taken back");
    }
}

#[test]
fn volumes_out_of_sight_are_painted_where_they_are_named() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = nested(dir.path()) else { return };
    set_brush(&mut document, json!({"density": 400.0}), json!({}));
    say(&mut document, json!({"stroke": {"paint": {"points": points(), "volumes": [0, 1]}}}));
    let seen = both(&document);
    say(&mut document, json!({"history": {"undo": {}}}));
    for id in [0, 1] {
        say(&mut document, json!({"volume": {"set": {"volume": id, "visible": false}}}));
    }
    let part = |i: usize| json!([points()[i]]);
    say(&mut document, json!({"stroke": {"begin": {"points": part(0), "volumes": [0, 1]}}}));
    for i in 1..WAY.len() {
        document.picture(burin::document::ViewName::ThreeD, [16, 16], None).unwrap();
        say(&mut document, json!({"stroke": {"extend": {"points": part(i)}}}));
    }
    say(&mut document, json!({"stroke": {"end": {}}}));
    assert!(both(&document) == seen);
}

#[test]
fn the_brush_paints_what_was_chosen_besides_the_active_volume_while_it_is_seen() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = nested(dir.path()) else { return };
    set_brush(&mut document, json!({"selection": 1.0}), json!({}));
    let plain = json!({"stroke": {"paint": {"points": points()}}});
    let changes = |document: &mut Document, line: &Value| {
        let before = both(document);
        say(document, line.clone());
        let after = both(document);
        say(document, json!({"history": {"undo": {}}}));
        assert!(both(document) == before);
        [0, 1].map(|i| before[i] != after[i])
    };
    assert_eq!(changes(&mut document, &plain), [true, false]);
    assert_eq!(say(&mut document, json!({"ask": {"scene": {}}}))["scene"].get("also"), None);
    let answer = say(&mut document, json!({"brush": {"also": {"volumes": [1]}}}));
    assert_eq!((&answer["also"], &answer["step"]), (&json!([1]), &Value::Null), "a brush's setting is no step");
    assert_eq!(changes(&mut document, &plain), [true, true]);
    assert_eq!(say(&mut document, json!({"ask": {"scene": {}}}))["scene"]["also"], json!([1]));
    // Whoever names what is painted means that.
    let one = json!({"stroke": {"paint": {"points": points(), "volume": 0}}});
    assert_eq!(changes(&mut document, &one), [true, false]);
    say(&mut document, one);
    let kept = say(&mut document, json!({"ask": {"history": {"commands": true}}}))["undo_commands"][0][0].clone();
    say(&mut document, json!({"history": {"undo": {}}}));
    assert_eq!(changes(&mut document, &kept["command"]), [true, false], "{kept}");
    // The other way round, and out of sight.
    say(&mut document, json!({"volume": {"set": {"volume": 1, "active": true}}}));
    assert_eq!(changes(&mut document, &plain), [false, true]);
    say(&mut document, json!({"brush": {"also": {"volumes": [0, 1]}}}));
    assert_eq!(changes(&mut document, &plain), [true, true]);
    say(&mut document, json!({"volume": {"set": {"volume": 0, "visible": false}}}));
    assert_eq!(changes(&mut document, &plain), [false, true]);
    say(&mut document, json!({"volume": {"set": {"volume": 0, "visible": true}}}));
    // Saved with the scene; one that is removed is not painted, and again once it is back.
    let path = dir.path().join("kept.burin");
    say(&mut document, json!({"project": {"save": {"path": path}}}));
    drop(document);
    let mut document = Document::new();
    say(&mut document, json!({"project": {"open": {"path": path}}}));
    assert_eq!(changes(&mut document, &plain), [true, true]);
    say(&mut document, json!({"volume": {"remove": {"volume": 0}}}));
    assert_ne!(say(&mut document, plain.clone())["step"], Value::Null);
    say(&mut document, json!({"history": {"undo": {"steps": 2}}}));
    assert_eq!(changes(&mut document, &plain), [true, true]);
}

/// Kills the program once it has answered so many lines of a script.
fn killed_after(project: &Path, script: &[Value]) {
    let mut child = Process::new(crate::common::program())
        .args(["run", "-", "--project"])
        .arg(project)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let mut answers = BufReader::new(child.stdout.take().unwrap()).lines().map_while(Result::ok);
    for line in script {
        writeln!(stdin, "{line}").unwrap();
        stdin.flush().unwrap();
        let answer = answers.next().expect("an answer");
        assert!(!answer.contains("\"error\""), "{line}: {answer}");
    }
    // Standard input stays open till now: a script that ends is not killed.
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn a_stroke_on_two_volumes_that_a_kill_cut_off_is_painted_on_both_as_far_as_it_had_come() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = nested(dir.path()) else { return };
    let project = dir.path().join("p.burin");
    let part = |range: std::ops::Range<usize>| Value::Array(points().as_array().unwrap()[range].to_vec());
    set_brush(&mut document, json!({"density": 60.0}), json!({"tip": "build_up", "operation": "add"}));
    say(&mut document, json!({"project": {"save": {"path": project}}}));
    let before = both(&document);
    // What is to be found: the same stroke at once, as far as its last sample.
    say(&mut document, json!({"stroke": {"paint": {"points": part(0..3), "volumes": [1, 0]}}}));
    let expected = both(&document);
    assert!(expected[0] != before[0] && expected[1] != before[1]);
    say(&mut document, json!({"history": {"undo": {}}}));
    say(&mut document, json!({"project": {"save": {}}}));
    drop(document);
    killed_after(
        &project,
        &[
            json!({"stroke": {"begin": {"points": part(0..1), "volumes": [1, 0]}}}),
            json!({"stroke": {"extend": {"points": part(1..2)}}}),
            json!({"stroke": {"extend": {"points": part(2..3)}}}),
        ],
    );
    let mut document = Document::new();
    let answer = say(&mut document, json!({"project": {"open": {"path": project}}}));
    assert_eq!(answer["recovered"]["stroke"], json!("painted"), "{answer}");
    assert!(both(&document) == expected);
    say(&mut document, json!({"history": {"undo": {}}}));
    assert!(both(&document) == before, "taken back");
    say(&mut document, json!({"history": {"redo": {}}}));
    // The step that came of it is in the journal itself.
    drop(document);
    let mut document = Document::new();
    let answer = say(&mut document, json!({"project": {"open": {"path": project}}}));
    assert_eq!(answer["recovered"]["stroke"], json!("none"), "{answer}");
    assert!(both(&document) == expected);
}

/// One command of a walk over strokes on one volume or both.
fn any_command(rng: &mut ChaCha8Rng) -> Value {
    let target = match rng.random_range(0..4) {
        0 => json!({"selection": 1.0}),
        1 => json!({"label": rng.random_range(1..5)}),
        2 => json!({"colour": [0.5, 0.25, 1.0, rng.random_range(0..5) as f64 / 4.0]}),
        _ => json!({"density": rng.random_range(-400..40_000) as f64 / 8.0}),
    };
    let name = |rng: &mut ChaCha8Rng, names: &[&str]| json!(names[rng.random_range(0..names.len())]);
    let spot = |rng: &mut ChaCha8Rng| {
        let mm: [f64; 3] = std::array::from_fn(|_| rng.random_range(-13.0..13.0));
        json!({"at": {"mm": mm}, "pressure": rng.random_range(0.1..1.0)})
    };
    match rng.random_range(0..9) {
        0 => json!({"history": {"undo": {"steps": rng.random_range(1..3)}}}),
        1 => json!({"history": {"redo": {}}}),
        2 => {
            let also = [0, 1][rng.random_range(0..2)];
            json!({"brush": {"also": {"volumes": [also]}}})
        }
        3 | 4 => json!({"brush": {"set": {
            "target": target, "radius_mm": rng.random_range(0.0..4.0), "strength": rng.random_range(0.1..1.0),
            "falloff": name(rng, &["hard", "linear", "smooth"]), "tip": name(rng, &["wash", "build_up"]),
            "operation": name(rng, &["replace", "blend", "add", "subtract", "restore"]),
            "shape": name(rng, &["sphere", "disc"]), "erase": rng.random_bool(0.2),
        }}}),
        5 => json!({"volume": {"set": {"volume": rng.random_range(0..2), "active": true}}}),
        _ => {
            let points: Vec<_> = (0..rng.random_range(1..4)).map(|_| spot(rng)).collect();
            let volumes = [json!([0, 1]), json!([1, 0]), json!([1]), Value::Null][rng.random_range(0..4)].clone();
            let mut stroke = json!({"points": points});
            if !volumes.is_null() {
                stroke["volumes"] = volumes;
            }
            json!({"stroke": {"paint": stroke}})
        }
    }
}

#[test]
fn random_strokes_on_both_volumes_come_back_by_undo_redo_and_after_a_crash() {
    for seed in 0..3 {
        let dir = tempfile::tempdir().unwrap();
        let Some(mut document) = nested(dir.path()) else { return };
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut steps = 0;
        for _ in 0..30 {
            let line = any_command(&mut rng);
            let before = all(&document);
            let Ok(answer) = run(&mut document, &line.to_string()) else {
                assert!(all(&document) == before, "{line} was refused and changed something");
                continue;
            };
            if answer["step"].is_string() && line.get("stroke").is_some() {
                let after = all(&document);
                say(&mut document, json!({"history": {"undo": {}}}));
                assert!(all(&document) == before, "{seed}: {line} taken back");
                say(&mut document, json!({"history": {"redo": {}}}));
                assert!(all(&document) == after, "{seed}: {line} done again");
                steps += 1;
            }
        }
        assert!(steps > 2, "{seed}: {steps}");
        let last = all(&document);
        // A program that ends without a word.
        drop(document);
        let mut document = Document::new();
        document.keep_unsaved_in(dir.path().join("unsaved"));
        let lost = say(&mut document, json!({"project": {"lost": {}}}))["lost"].clone();
        say(&mut document, json!({"project": {"recover": {"id": lost[0]["id"]}}}));
        assert!(all(&document) == last, "{seed}: recovered");
    }
}

/// Volumes as nobody would wish for them: thin as one voxel, mirrored, sheared, of a hundredth of a millimetre and of forty.
fn odd_grids() -> [Grid; 5] {
    let sheared = DMat3::from_cols(DVec3::X * 0.9, DVec3::new(0.3, -1.1, 0.1), DVec3::new(-0.4, 0.5, 1.6));
    let turned = DMat3::from_axis_angle(DVec3::new(-1.0, 0.4, 2.0).normalize(), 2.1);
    [
        centred([18, 14, 1], turned * DMat3::from_diagonal(DVec3::new(1.0, 1.3, 5.0))),
        centred([12, 35, 9], sheared),
        centred([13, 9, 34], DMat3::from_diagonal(DVec3::new(0.01, -0.01, 0.02))),
        centred([3, 2, 4], turned * 40.0),
        centred([1, 1, 1], DMat3::from_diagonal(DVec3::splat(-3.0))),
    ]
}

/// A brush and a stroke that goes to and fro near one of the volumes.
fn any_stroke(rng: &mut ChaCha8Rng, document: &Document) -> (Value, Value, Vec<u32>) {
    let state = document.state().unwrap();
    let ids: Vec<u32> = state.volumes.keys().map(|id| id.0).collect();
    let near = state.subject(VolumeId(ids[rng.random_range(0..ids.len())])).unwrap();
    let grid = *near.grid();
    let points: Vec<_> = (0..rng.random_range(1..4))
        .map(|_| {
            let at = DVec3::from_array(grid.dims.map(|n| rng.random_range(-1.0..f64::from(n))));
            let mm = grid.world_from_index.transform_point3(at).to_array();
            // Where a disc faces is said: left out it is the axial slice of the first volume.
            let normal = [0.2, -0.3, 0.9];
            let (pressure, breaks) = (rng.random_range(0.2..1.0), rng.random_bool(0.1));
            json!({"at": {"mm": mm}, "pressure": pressure, "breaks": breaks, "normal": normal})
        })
        .collect();
    let target = match rng.random_range(0..4) {
        0 => json!({"selection": 1.0}),
        1 => json!({"label": rng.random_range(1..5)}),
        2 => json!({"colour": [0.5, 0.25, 1.0, rng.random_range(1..5) as f64 / 4.0]}),
        _ => json!({"density": rng.random_range(-400..40_000) as f64 / 8.0}),
    };
    let mut name = |names: &[&str]| json!(names[rng.random_range(0..names.len())]);
    let (falloff, tip) = (name(&["hard", "linear", "smooth"]), name(&["wash", "build_up"]));
    let (shape, operation) = (name(&["sphere", "disc"]), name(&["replace", "blend", "add", "subtract", "restore"]));
    let radius = grid.voxel_mm() * rng.random_range(0.4..5.0);
    let mut brush = json!({"target": target, "radius_mm": radius, "strength": rng.random_range(0.2..1.0), "spacing": 0.25,
        "falloff": falloff, "tip": tip, "operation": operation, "shape": shape, "erase": rng.random_bool(0.2)});
    match rng.random_bool(0.2) {
        true => brush["range"] = json!([0, 30]),
        false => brush["any_value"] = json!(true),
    }
    let mut painted = ids;
    while painted.len() > 1 && rng.random_bool(0.4) {
        painted.remove(rng.random_range(0..painted.len()));
    }
    if rng.random_bool(0.5) {
        painted.reverse();
    }
    (json!({"brush": {"set": brush}}), json!({"points": points}), painted)
}

#[test]
fn odd_volumes_get_at_once_what_they_get_one_after_another() {
    let (mut strokes, mut several) = (0, 0);
    for seed in 0..2 {
        let dir = tempfile::tempdir().unwrap();
        if crate::common::gpu::gpu().is_none() {
            return;
        }
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut document = Document::new();
        document.keep_unsaved_in(dir.path().join("unsaved"));
        for (i, grid) in odd_grids().iter().enumerate() {
            let verb = if i == 0 { "open" } else { "add" };
            say(&mut document, json!({"volume": {verb: {"path": file(dir.path(), &format!("{i}.nrrd"), grid)}}}));
        }
        for _ in 0..12 {
            if rng.random_bool(0.3) {
                let turn: [f64; 3] = std::array::from_fn(|_| rng.random_range(-3.0..3.0));
                let rotation = burin::math::DQuat::from_scaled_axis(DVec3::from_array(turn)).to_array();
                let translation: [f64; 3] = std::array::from_fn(|_| rng.random_range(-3.0..3.0));
                let pose = json!({"rotation": rotation, "translation": translation});
                say(&mut document, json!({"volume": {"set": {"volume": rng.random_range(0..5), "pose": pose}}}));
            }
            let (brush, points, painted) = any_stroke(&mut rng, &document);
            say(&mut document, brush.clone());
            let before = all(&document);
            let stroke = |key: &str, which: Value| {
                let mut stroke = points.clone();
                stroke[key] = which;
                json!({"stroke": {"paint": stroke}})
            };
            let at_once = run(&mut document, &stroke("volumes", json!(painted)).to_string());
            let told = format!("{seed}: {brush} {points} on {painted:?}");
            let Ok(answer) = at_once else {
                assert!(all(&document) == before, "{told} was refused and changed something");
                continue;
            };
            let after = all(&document);
            strokes += 1;
            if answer["step"].is_string() {
                say(&mut document, json!({"history": {"undo": {}}}));
                assert!(all(&document) == before, "{told} taken back");
                say(&mut document, json!({"history": {"redo": {}}}));
                assert!(all(&document) == after, "{told} done again");
                say(&mut document, json!({"history": {"undo": {}}}));
            }
            // Each by itself; the dabs' distance is the brush's own on all of them.
            let own = 0.25 * brush["brush"]["set"]["radius_mm"].as_f64().unwrap();
            let thinnest = if painted.contains(&3) { 40.0 } else { 3.0 };
            if own < thinnest / 64.0 {
                say(&mut document, stroke("volumes", json!(painted)));
                continue;
            }
            several += u32::from(painted.len() > 1);
            for id in &painted {
                run(&mut document, &stroke("volume", json!(id)).to_string())
                    .unwrap_or_else(|e| panic!("{told} {id}: {e}"));
            }
            for ((now, then), id) in all(&document).iter().zip(&after).zip(0..) {
                assert!(now.0 == then.0, "{told}: volume {id} alone");
            }
            if rng.random_bool(0.3) {
                use burin::document::ViewName::{Axial, Sagittal, ThreeD};
                for view in [ThreeD, Axial, Sagittal] {
                    document.picture(view, [24, 16], None).unwrap();
                }
            }
        }
        let last = all(&document);
        drop(document);
        let mut document = Document::new();
        document.keep_unsaved_in(dir.path().join("unsaved"));
        let lost = say(&mut document, json!({"project": {"lost": {}}}))["lost"].clone();
        say(&mut document, json!({"project": {"recover": {"id": lost[0]["id"]}}}));
        assert!(all(&document) == last, "{seed}: recovered");
    }
    assert!(strokes > 12 && several > 2, "{strokes} strokes, {several} on several volumes and each by itself");
}

#[test]
fn what_looks_around_does_so_in_each_volume_by_its_own_voxels() {
    let dir = tempfile::tempdir().unwrap();
    let Some(mut document) = nested(dir.path()) else { return };
    let at = json!([{"at": {"mm": [0.5, 1.0, -0.5]}}]);
    let corners = json!([{"mm": [-4, -4, 0]}, {"mm": [5, -3, 0]}, {"mm": [1, 6, 0]}]);
    for operation in ["smooth", "median", "sharpen", "fill", "lasso"] {
        let more = json!({"operation": if operation == "lasso" { "add" } else { operation }, "reach_mm": 2.1, "radius_mm": 3.0});
        set_brush(&mut document, json!({"density": 12.5}), more);
        let line = |of: Value| match operation {
            "lasso" => {
                json!({"stroke": {"lasso": {"points": corners, "normal": [0, 0.1, 1], "depth_mm": 1.5, "volumes": of}}})
            }
            _ => json!({"stroke": {"paint": {"points": at, "volumes": of}}}),
        };
        let before = both(&document);
        say(&mut document, line(json!([0, 1])));
        let together = both(&document);
        // Values go evenly through most of both, which filling in leaves as it is.
        let changed = [0, 1].map(|i| together[i] != before[i]);
        assert!(changed == [true; 2] || operation == "fill", "{operation}");
        say(&mut document, json!({"history": {"undo": {}}}));
        assert!(both(&document) == before, "{operation} is one step");
        say(&mut document, line(json!([1])));
        say(&mut document, line(json!([0])));
        assert!(both(&document) == together, "{operation}");
        say(&mut document, json!({"history": {"undo": {"steps": 2}}}));
    }
}

#[test]
fn what_a_kill_cut_off_while_it_moved_the_surface_or_filled_in_is_done_as_far_as_it_had_come() {
    for operation in ["raise", "fill"] {
        let dir = tempfile::tempdir().unwrap();
        let Some(mut document) = nested(dir.path()) else { return };
        let project = dir.path().join("p.burin");
        let part = |range: std::ops::Range<usize>| Value::Array(points().as_array().unwrap()[range].to_vec());
        let more = json!({"operation": operation, "height_mm": 1.5, "radius_mm": 2.5, "mirror": {"axis": "z"}});
        set_brush(&mut document, json!({"density": 0.0}), more);
        let lasso =
            json!({"stroke": {"lasso": {"points": [{"mm": [-4, -4, 0]}, {"mm": [5, -3, 0]}, {"mm": [1, 6, 0]}]}}});
        say(&mut document, json!({"project": {"save": {"path": project}}}));
        say(&mut document, lasso.clone());
        say(&mut document, json!({"stroke": {"paint": {"points": part(0..2), "volumes": [1, 0]}}}));
        let expected = both(&document);
        say(&mut document, json!({"history": {"undo": {"steps": 2}}}));
        say(&mut document, json!({"project": {"save": {}}}));
        drop(document);
        killed_after(
            &project,
            &[
                lasso,
                json!({"stroke": {"begin": {"points": part(0..1), "volumes": [1, 0]}}}),
                json!({"stroke": {"extend": {"points": part(1..2)}}}),
            ],
        );
        let mut document = Document::new();
        let answer = say(&mut document, json!({"project": {"open": {"path": project}}}));
        assert_eq!(answer["recovered"]["stroke"], json!("painted"), "{answer}");
        assert!(both(&document) == expected, "{operation}");
    }
}
