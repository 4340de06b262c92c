//! Pictures and slices of several volumes with looks of their own, as a document draws them, against frames that are written down here and
//! marched by the reference.

use super::maker::{run, write_nrrd};
use crate::common::gpu::gpu;
use crate::gpu::reference::{Dense, difference, picture};
use burin::document::{Document, SELECTION_COLOUR, State, ViewName};
use burin::explode::PartId;
use burin::gpu::{Body, Fields, Frame, LabelLooks, Look, Mask, Overlay, VolumeFields};
use burin::math::{DAffine3, DMat3, DVec2, DVec3, Plane};
use burin::volume::*;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

pub(super) const SIZE: [u32; 2] = [60, 48];

pub(super) fn say(document: &mut Document, line: Value) -> Value {
    run(document, &line.to_string()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

fn transfer(colour: [f32; 3], lo: f64) -> TransferFunction {
    TransferFunction {
        colour: vec![(0.0, colour), (900.0, [1.0 - colour[0], 0.7, colour[2]])],
        opacity: vec![(lo, 0.0), (700.0, 0.25), (900.0, 0.4)],
        unit_mm: 1.0,
    }
}

/// A scan, an oblique one of another spacing that was moved by hand, and a map of labels on a grid of its own.
pub(super) fn three(dir: &Path) -> Document {
    let lumps = |[x, y, z]: [u32; 3]| {
        let wave = (x as f32 * 0.31).sin() + (y as f32 * 0.23).cos() + (z as f32 * 0.41).sin();
        (450.0 + 150.0 * wave).round()
    };
    let at = |name: &str| dir.join(name);
    write_nrrd(&at("a.nrrd"), &Grid::aligned([44, 30, 26], DVec3::ONE, DVec3::ZERO), lumps);
    let turned = DMat3::from_rotation_z(0.4) * DMat3::from_diagonal(DVec3::new(1.6, 1.3, 1.9));
    let oblique = DAffine3 { matrix3: turned, translation: DVec3::new(10.0, -4.0, -6.0) };
    write_nrrd(&at("b.nrrd"), &Grid { dims: [20, 18, 16], world_from_index: oblique }, |[x, y, z]| {
        (lumps([z * 2, x, y]) * 0.9 + 20.0).round()
    });
    let map = Grid::aligned([18, 16, 12], DVec3::splat(2.3), DVec3::new(-2.0, 1.0, 0.5));
    write_nrrd(&at("c.nrrd"), &map, |[x, y, z]| ((x / 4 + y / 5 + z / 5) % 5) as f32);
    let mut document = Document::new();
    document.keep_unsaved_in(dir.join("unsaved"));
    say(&mut document, json!({"volume":{"open":{"path":at("a.nrrd")}}}));
    say(&mut document, json!({"volume":{"add":{"path":at("b.nrrd")}}}));
    say(&mut document, json!({"volume":{"add":{"path":at("c.nrrd"),"as":"labels"}}}));
    let function = |colour, lo| json!(transfer(colour, lo));
    say(&mut document, json!({"transfer":{"set":{"function":function([0.9, 0.2, 0.1], 450.0)}}}));
    let look = json!({"transfer":function([0.1, 0.8, 0.3], 520.0),"lighting":null});
    let pose = json!({"rotation":[0.0,0.0,0.0,1.0],"translation":[4.0,3.0,2.0]});
    say(&mut document, json!({"volume":{"set":{"volume":1,"opacity":0.7,"look":look,"pose":pose}}}));
    let flat = json!({"colour":[[0,[0.5,0.5,0.5]]],"opacity":[[0.2,0.0],[0.8,0.3]],"unit_mm":1.0});
    say(&mut document, json!({"volume":{"set":{"volume":2,"look":{"transfer":flat,"shaded":false}}}}));
    say(&mut document, json!({"view":{"look":{"shaded":false,"refine":false,"step_voxels":0.5}}}));
    say(&mut document, json!({"view":{"frame":{"from":[0.6,-1.0,0.5],"zoom":1.2}}}));
    document
}

fn fields(state: &State) -> Fields<'_> {
    let mut fields = Fields::default();
    for (id, volume) in &state.volumes {
        let [density, colour, selection, labels] = FieldKind::ALL.map(|kind| volume.field(kind));
        let grid = *state.subject(*id).unwrap().grid();
        fields.put(*id, VolumeFields { grid, density, colour, selection, labels });
    }
    fields
}

/// What a picture of these bodies is to be, everything else as `three` says it.
fn wanted(state: &State, bodies: Vec<Body>, looks: Vec<Look>) -> Frame {
    let overlay = |id: u32| Overlay {
        colour: 1.0,
        labels: if state.scene.layer(FieldKind::Labels).visible { 0.5 } else { 0.0 },
        selection: 0.5,
        selection_colour: SELECTION_COLOUR,
        segments: state.scene.volumes.all[&VolumeId(id)].segments.clone(),
    };
    Frame {
        camera: state.scene.views.camera,
        size: SIZE,
        // The smallest voxels are those of the first volume, 1 mm.
        step_mm: 0.5,
        refine: false,
        mode: Mode::Dvr,
        lighting: None,
        transfer: transfer([0.9, 0.2, 0.1], 450.0),
        looks,
        bodies,
        overlay: overlay(0),
        layers: Default::default(),
        overlays: (0..3).map(|id| (VolumeId(id), overlay(id))).collect(),
        boxes: Vec::new(),
        focus: None,
    }
}

/// The looks of the three volumes, and that of segments.
pub(super) fn looks() -> Vec<Look> {
    let flat = TransferFunction { colour: vec![(0.0, [0.5; 3])], opacity: vec![(0.2, 0.0), (0.8, 0.3)], unit_mm: 1.0 };
    let look = |transfer, opacity| Look { transfer, mode: Mode::Dvr, lighting: None, opacity };
    let (scan, other) = (transfer([0.9, 0.2, 0.1], 450.0), transfer([0.1, 0.8, 0.3], 520.0));
    vec![look(scan, 1.0), look(other, 0.7), look(flat, 1.0)]
}

pub(super) fn compare(document: &mut Document, bodies: Vec<Body>, looks: Vec<Look>, what: &str) {
    let image = document.picture(ViewName::ThreeD, SIZE, None).unwrap();
    let state = document.state().unwrap();
    let frame = wanted(state, bodies, looks);
    let d = difference(&image, &picture(&Dense::many(&fields(state)), &frame), frame.step_mm);
    println!("{what}: {d:?}");
    assert!(d.covered > 0.1 && d.mean <= 0.2 && d.beyond_one < 0.02 && d.misplaced < 0.02, "{what}: {d:?}");
}

pub(super) fn body(id: u32, volume: u32) -> Body {
    Body { volume: VolumeId(volume), look: Some(volume as usize), ..Body::whole(id) }
}

#[test]
fn visible_volumes_are_drawn_together_each_where_it_lies_with_its_look_and_opacity() {
    if gpu().is_none() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let mut document = three(dir.path());
    compare(&mut document, (0..3).map(|v| body(0, v)).collect(), looks(), "all three");
    say(&mut document, json!({"volume":{"set":{"volume":2,"visible":false}}}));
    compare(&mut document, vec![body(0, 0), body(0, 1)], looks(), "two of them");
    say(&mut document, json!({"volume":{"set":{"volume":0,"visible":false}}}));
    say(&mut document, json!({"view":{"look":{"step_voxels":0.5 / 1.3}}}));
    compare(&mut document, vec![body(0, 1)], looks(), "one that is half transparent");
    say(&mut document, json!({"volume":{"set":{"volume":1,"opacity":0.0}}}));
    let image = document.picture(ViewName::ThreeD, SIZE, None).unwrap();
    assert!(image.colour.iter().all(|c| c[3] == 0.0), "nothing is left");
    let said = say(&mut document, json!({"ask":{"pick":{"px":[30, 24],"size":SIZE}}}));
    assert_eq!(said["hit"], Value::Null);
}

#[test]
fn parts_selections_and_segments_of_every_volume_have_their_looks_when_moved_apart() {
    if gpu().is_none() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let mut document = three(dir.path());
    // Where the selection ends, labels do too: which of two colours is there rounding decides.
    say(&mut document, json!({"view":{"layer":{"field":"labels","visible":false,"opacity":0.5}}}));
    say(&mut document, json!({"selection":{"from_label":{"label":2,"volume":2}}}));
    say(&mut document, json!({"part":{"split":{"by":{"plane":{"point":[20,12,12],"normal":[1,0.2,0]}}}}}));
    let pose = json!({"rotation":[0.0,0.0,0.0,1.0],"translation":[14.0,2.0,0.0]});
    let ids: Vec<u32> = document.state().unwrap().scene.explosion.parts.iter().map(|p| p.id.0).collect();
    say(&mut document, json!({"part":{"move":{"id":ids[0],"pose":pose}}}));
    say(&mut document, json!({"part":{"set":{"id":ids[1],"look":{"opacity":0.5}}}}));
    say(&mut document, json!({"selection":{"set":{"volume":2,"look":{"opacity":0.8,"mode":{"iso":1.5}}}}}));
    say(&mut document, json!({"segment":{"set":{"id":1,"volume":2,"look":{"opacity":0.0}}}}));
    say(&mut document, json!({"segment":{"set":{"id":3,"volume":2,"look":{"mode":{"iso":2.5}}}}}));
    let scene = &document.state().unwrap().scene;
    let faces = |id: u32| -> Vec<Plane> {
        let part = scene.explosion.part(PartId(id)).unwrap();
        part.faces.iter().filter(|face| face.cut).map(|face| face.plane).collect()
    };
    let [scan, other, flat] = <[Look; 3]>::try_from(looks()).unwrap();
    let half = |look: &Look| Look { opacity: look.opacity * 0.5, ..look.clone() };
    let iso = |value: f64, opacity: f32| Look { mode: Mode::Iso(value), opacity, ..flat.clone() };
    let rows = vec![
        scan.clone(),
        other.clone(),
        flat.clone(),
        half(&scan),
        half(&other),
        half(&flat),
        iso(1.5, 0.8),
        iso(0.5, 1.0),
        iso(0.5, 0.5),
        iso(0.5, 0.8),
    ];
    let mut bodies = Vec::new();
    for (n, id) in ids.iter().enumerate() {
        let pose = document.poses().of(scene.explosion.part(PartId(*id)).unwrap());
        for volume in 0..3 {
            let whole = Body { region: faces(*id), pose, ..body(*id, volume) };
            if volume < 2 {
                bodies.push(Body { look: Some(volume as usize + 3 * n), ..whole });
                continue;
            }
            // What is not selected of the map: segment 1 is hidden, segment 3 a surface.
            let [plain, surface] = [[2, 7], [5, 8]][n];
            let table =
                |default, own| Some(Arc::new(LabelLooks { default, by_label: BTreeMap::from([(1, None), (3, own)]) }));
            for labels in [table(Some(plain), None), table(None, Some(surface))] {
                bodies.push(Body { labels, look: None, mask: Mask::Background, ..whole.clone() });
            }
        }
    }
    // Selected matter of the map is one thing that stays where it is.
    let by_label = BTreeMap::from([(1, None), (3, Some(9))]);
    let labels = Some(Arc::new(LabelLooks { default: Some(6), by_label }));
    bodies.push(Body { labels, look: None, mask: Mask::Selection, ..body(0, 2) });
    compare(&mut document, bodies, rows, "moved apart");
}

/// Density between voxels, in f64; `None` outside.
pub(super) fn value(state: &State, id: u32, world: DVec3) -> Option<f64> {
    let subject = state.subject(VolumeId(id)).unwrap();
    let p = subject.grid().index_from_world().transform_point3(world);
    let last = subject.grid().dims_f64() - 1.0;
    if p.cmplt(DVec3::splat(-0.5)).any() || p.cmpge(last + 0.5).any() {
        return None;
    }
    let (lo, mut sum) = (p.floor(), 0.0);
    for corner in 0..8_u32 {
        let step = DVec3::new(f64::from(corner & 1), f64::from(corner >> 1 & 1), f64::from(corner >> 2));
        let share: f64 = (0..3).map(|a| if step[a] > 0.0 { p[a] - lo[a] } else { 1.0 - p[a] + lo[a] }).product();
        let voxel = (lo + step).clamp(DVec3::ZERO, last).to_array().map(|v| v as u32);
        sum += share * f64::from(subject.density.value(voxel).unwrap());
    }
    Some(sum)
}

#[test]
fn slices_lay_volumes_over_each_other_in_their_order_whichever_is_active() {
    if gpu().is_none() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let mut document = three(dir.path());
    say(&mut document, json!({"volume":{"set":{"volume":2,"visible":false}}}));
    say(&mut document, json!({"view":{"window":{"volume":0,"level":450,"width":500}}}));
    say(&mut document, json!({"view":{"window":{"volume":1,"level":400,"width":700}}}));
    say(&mut document, json!({"view":{"size":{"view":"axial","size":SIZE}}}));
    for (active, hidden) in [(0, None), (1, None), (1, Some(1)), (0, Some(1)), (1, Some(0))] {
        for id in [0, 1] {
            let line = json!({"volume":{"set":{"volume":id,"visible":hidden != Some(id),"active":id == active}}});
            say(&mut document, line);
        }
        let picture = document.picture(ViewName::Axial, SIZE, None).unwrap();
        let state = document.state().unwrap();
        let grid = *state.at(None).unwrap().grid();
        let plane = burin::document::SlicePlane::new(&grid, &state.scene.views, ViewName::Axial).unwrap();
        let (mut both, mut largest) = (0, 0.0_f64);
        for (i, got) in picture.colour.iter().enumerate() {
            let px = DVec2::new((i as u32 % SIZE[0]) as f64 + 0.5, (i as u32 / SIZE[0]) as f64 + 0.5);
            let world = plane.world(px);
            let mut expected = [0.0; 4];
            let mut met = 0;
            for (id, level, width, opacity) in [(0, 450.0, 500.0, 1.0), (1, 400.0, 700.0, f64::from(0.7_f32))] {
                if hidden == Some(id) {
                    continue;
                }
                let Some(value) = value(state, id, world) else { continue };
                met += 1;
                let grey = ((value - (level - 0.5 * width)) / width).clamp(0.0, 1.0);
                let over = [grey, grey, grey, 1.0].map(|c| c * opacity);
                expected = std::array::from_fn(|c| over[c] + expected[c] * (1.0 - opacity));
            }
            both += usize::from(met == 2);
            // Where a volume ends rounding decides.
            let near = |id: u32| {
                let subject = state.subject(VolumeId(id)).unwrap();
                let p = subject.grid().index_from_world().transform_point3(world) + 0.5;
                (0..3).any(|a| p[a].abs() < 1e-3 || (p[a] - subject.grid().dims_f64()[a]).abs() < 1e-3)
            };
            if !near(0) && !near(1) {
                let off = (0..4).map(|c| (f64::from(got[c]) - expected[c]).abs()).fold(0.0, f64::max);
                largest = largest.max(off * 255.0);
            }
        }
        assert!(hidden.is_some() || both > 300, "{both} pixels show both");
        assert!(largest <= 1.5, "active {active}, hidden {hidden:?}: off by {largest}");
    }
}

#[test]
fn a_pick_tells_volume_and_segment_and_whether_something_is_selected() {
    if gpu().is_none() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let mut document = three(dir.path());
    for id in [0, 1] {
        say(&mut document, json!({"volume":{"set":{"volume":id,"visible":false}}}));
    }
    // A surface: nothing of a voxel is seen through another.
    say(&mut document, json!({"volume":{"set":{"volume":2,"look":{"mode":{"iso":2.5}}}}}));
    let mut told = std::collections::BTreeSet::new();
    for (x, y) in (18..42).step_by(3).flat_map(|x| (14..34).step_by(4).map(move |y| (x, y))) {
        let pick =
            |document: &mut Document| say(document, json!({"ask":{"pick":{"px":[x, y],"size":SIZE}}}))["hit"].clone();
        let hit = pick(&mut document);
        let Some(index) = hit["index"].as_array() else { continue };
        let index: Vec<f64> = index.iter().map(|v| v.as_f64().unwrap()).collect();
        let fraction = index.iter().map(|v| ((v + 0.5).fract() - 0.5).abs()).fold(0.0, f64::max);
        if fraction > 0.49 {
            continue;
        }
        let voxel: Vec<u32> = index.iter().map(|v| (v + 0.5).floor() as u32).collect();
        let state = document.state().unwrap();
        let label = state.volumes[&VolumeId(2)].labels.value([voxel[0], voxel[1], voxel[2]]).unwrap() as u16;
        let segment = (label > 0).then_some(label);
        assert_eq!((&hit["volume"], hit.get("segment")), (&json!(2), segment.map(|s| json!(s)).as_ref()), "{hit}");
        assert_eq!(hit["selection"], json!(false));
        if let Some(label) = segment {
            told.insert(label);
            say(&mut document, json!({"selection":{"from_label":{"label":label,"volume":2}}}));
            assert_eq!(pick(&mut document)["selection"], json!(true));
            say(&mut document, json!({"selection":{"clear":{"volume":2}}}));
        }
    }
    assert!(!told.is_empty());
}
