//! Whether what a pixel shows is selected: picks and EXR files against the selection itself, at rest and apart, for every mode.

use super::maker::{run, write_nrrd};
use super::pictures::channel;
use crate::common::gpu::gpu;
use burin::document::{Document, State};
use burin::math::{DAffine3, DMat3, DVec2, DVec3, Pose};
use burin::volume::*;
use rand::{Rng, SeedableRng, rngs::StdRng};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;

const SIZE: [u32; 2] = [48, 36];

fn say(document: &mut Document, line: Value) -> Value {
    run(document, &line.to_string()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

/// Two volumes that overlap, one oblique and moved by hand, with a soft ball and a hard one selected.
fn two(dir: &Path) -> Document {
    let lumps = |[x, y, z]: [u32; 3]| {
        let wave = (x as f32 * 0.31).sin() + (y as f32 * 0.23).cos() + (z as f32 * 0.41).sin();
        (450.0 + 150.0 * wave).round()
    };
    let turned = DMat3::from_rotation_z(0.4) * DMat3::from_diagonal(DVec3::new(1.6, 1.3, 1.9));
    let oblique = DAffine3 { matrix3: turned, translation: DVec3::new(22.0, -4.0, -6.0) };
    let grids =
        [Grid::aligned([44, 30, 26], DVec3::ONE, DVec3::ZERO), Grid { dims: [20, 18, 16], world_from_index: oblique }];
    let mut document = Document::new();
    document.keep_unsaved_in(dir.join("unsaved"));
    for (grid, verb) in grids.iter().zip(["open", "add"]) {
        let path = dir.join(format!("{verb}.nrrd"));
        write_nrrd(&path, grid, lumps);
        say(&mut document, json!({"volume":{verb:{"path":path}}}));
    }
    let pose = json!({"rotation":[0.0,0.0,-0.28,0.96],"translation":[4.0,13.0,2.0]});
    say(&mut document, json!({"volume":{"set":{"volume":1,"pose":pose,"visible":true,"opacity":1}}}));
    let function = json!({"colour":[[0,[0.8,0.5,0.4]]],"opacity":[[420,0],[620,0.6]],"unit_mm":1});
    for volume in [0, 1] {
        say(&mut document, json!({"volume":{"set":{"volume":volume,"look":{"transfer":function}}}}));
    }
    for (volume, falloff, at, radius) in [(0, "smooth", [12.0, 3.0, 13.0], 13), (1, "hard", [9.0, 4.0, 11.0], 9)] {
        let brush = json!({"target":{"selection":1},"radius_mm":radius,"falloff":falloff});
        say(&mut document, json!({"brush":{"set":brush}}));
        say(&mut document, json!({"stroke":{"paint":{"volume":volume,"points":[{"at":{"index":at}}]}}}));
    }
    say(&mut document, json!({"view":{"frame":{"from":[0.3,-1.0,0.5],"zoom":0.8}}}));
    document
}

/// How much a volume is selected at a place of the world at rest: between the eight voxels about it, the border's beyond it.
fn share(state: &State, volume: VolumeId, rest: DVec3) -> f64 {
    let subject = state.subject(volume).unwrap();
    let last = subject.grid().dims_f64() - 1.0;
    let p = subject.grid().index_from_world().transform_point3(rest).clamp(DVec3::ZERO, last);
    let lo = p.floor().min(last - 1.0);
    let f = p - lo;
    let corner = |i: u32| {
        let off = DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
        let weight = (DVec3::ONE - off - f).abs();
        let voxel = (lo + off).to_array().map(|v| v as u32);
        weight.element_product() * f64::from(subject.volume.selection.value(voxel).unwrap())
    };
    (0..8).map(corner).sum()
}

/// Where bodies are: parts by their ids, what is selected and what is in one piece, 0, at rest.
fn poses(document: &mut Document) -> BTreeMap<u32, Pose> {
    let parts = say(document, json!({"ask":{"parts":{}}}))["parts"].take();
    let of =
        |part: &Value| (part["id"].as_u64().unwrap() as u32, serde_json::from_value(part["pose"].clone()).unwrap());
    parts.as_array().unwrap().iter().map(of).chain([(0, Pose::IDENTITY)]).collect()
}

/// Pixels that show what is selected and what is not, beside those that are too near to half to say.
fn check(document: &mut Document, dir: &Path, mask_made: bool, what: &str) {
    let path = dir.join("p.exr");
    say(document, json!({"render":{"image":{"path":path,"size":SIZE}}}));
    let [z, id, volume, selected] = ["Z", "id", "volume", "selected"].map(|name| channel(&path, name));
    let poses = poses(document);
    let mut random = StdRng::seed_from_u64(7);
    let mut told = BTreeMap::<(u32, bool), usize>::new();
    let mut near = 0;
    for i in 0..z.len() {
        if id[i] == 0.0 {
            assert_eq!(selected[i], 0.0, "{what}: nothing is not selected");
            continue;
        }
        let px = DVec2::new((i % 48) as f64 + 0.5, (i / 48) as f64 + 0.5);
        let (body, of) = (id[i] as u32 - 1, volume[i] as u32 - 1);
        if mask_made {
            // Also where the mask makes the surface, which lies at half.
            assert_eq!(selected[i] == 1.0, body == 0, "{what}: surfaces divide at half, {px}");
        }
        let state = document.state().unwrap();
        let world = state.scene.views.camera.ray(px, SIZE).at(f64::from(z[i]));
        let share = share(state, VolumeId(of), poses[&body].unapply(world));
        // A filter's weights have eight bits.
        if (share - 0.5).abs() < 0.03 {
            near += 1;
            continue;
        }
        assert_eq!(selected[i] == 1.0, share > 0.5, "{what}: {share} of volume {of} at {px}, body {body}");
        *told.entry((of, share > 0.5)).or_default() += 1;
        if random.random_bool(0.01) {
            let hit = say(document, json!({"ask":{"pick":{"px":[px.x,px.y],"size":SIZE}}}))["hit"].take();
            assert_eq!((&hit["selected"], &hit["volume"]), (&json!(share > 0.5), &json!(of)), "{what}: {hit}");
        }
    }
    println!("{what}: {told:?}, {near} near to half");
    assert!(told.len() == 4 && told.values().all(|&n| n > 6), "{what}: {told:?}");
}

#[test]
fn a_pixel_is_selected_where_its_volume_is_at_rest_and_apart() {
    if gpu().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut document = two(folder.path());
    let modes = [json!("dvr"), json!({"iso":520}), json!("mip")];
    let check = |document: &mut Document, modes: [&Value; 2], apart: bool, what: &str| {
        for (volume, mode) in modes.into_iter().enumerate() {
            say(document, json!({"volume":{"set":{"volume":volume,"look":{"mode":mode}}}}));
        }
        check(document, folder.path(), apart && modes.iter().all(|m| m.is_object()), &format!("{what}, {modes:?}"));
    };
    let [dvr, iso, mip] = &modes;
    for both in [[dvr, dvr], [iso, iso], [mip, mip]] {
        check(&mut document, both, false, "at rest");
    }
    say(&mut document, json!({"view":{"layer":{"field":"selection","visible":false}}}));
    check(&mut document, [dvr, dvr], false, "with the layer hidden");
    for normal in [[1, 0, 0], [0, 0, 1]] {
        say(&mut document, json!({"part":{"split":{"by":{"plane":{"point":[20,12,12],"normal":normal}}}}}));
    }
    say(&mut document, json!({"part":{"set":{"id":6,"colour":[0.5,0.9,0.6]}}}));
    check(&mut document, [dvr, dvr], false, "with a part of another colour");
    say(&mut document, json!({"explosion":{"degree":{"value":0.8}}}));
    say(&mut document, json!({"explosion":{"settle":{}}}));
    for both in [[dvr, dvr], [iso, iso]] {
        check(&mut document, both, true, "apart");
    }
}
