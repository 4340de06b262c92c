//! Random walks over volumes with boxes in them: made, moved, nested, painted in and across, baked, removed, in groups and alone. Whatever is
//! refused has changed nothing; all is undone and done again to the byte, and comes back from projects and after crashes.
//!
//! `BURIN_WALKS` sets how many there are of each kind of numbers, the first of them by the same seeds (1).

use super::boxes::{add, copy_folder, does, every_texel, everything, opened, same};
use super::maker::{run, write_nrrd};
use super::maker_gpu::made;
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::*;
use rand::{Rng, SeedableRng, rngs::StdRng};
use serde_json::{Value, json};

const DIMS: [u32; 3] = [28, 22, 18];

/// A ball in noise of these numbers, and beside it floats on another grid.
fn document(kind: usize, folder: &std::path::Path) -> Option<Document> {
    let values = (0..DIMS.iter().product::<u32>()).map(|i| {
        let [x, y, z] = [i % DIMS[0], i / DIMS[0] % DIMS[1], i / (DIMS[0] * DIMS[1])].map(f64::from);
        let depth = 8.0 - DVec3::new(x - 13.0, y - 10.0, z - 9.0).length();
        (60.0 * depth).clamp(-60.0, 100.0) + 80.0 + f64::from(i.wrapping_mul(2_654_435_761) >> 28)
    });
    let voxels = match kind {
        0 => Voxels::U8(values.map(|v| v as u8).collect()),
        1 => Voxels::I16(values.map(|v| (v * 10.0) as i16 - 500).collect()),
        2 => Voxels::U16(values.map(|v| (v * 200.0) as u16).collect()),
        _ => {
            Voxels::F32(values.enumerate().map(|(i, v)| if i % 97 == 0 { f32::NAN } else { v as f32 * 0.37 }).collect())
        }
    };
    let mut document = made(voxels, DIMS, DVec3::new(1.0, 1.2, 0.9))?;
    let file = folder.join("beside.nrrd");
    let grid = Grid::aligned([20, 20, 20], DVec3::splat(1.3), DVec3::new(4.0, 2.0, -3.0));
    write_nrrd(&file, &grid, |[x, y, z]| (x * 3 + y * 5 + z * 7) as f32);
    for line in [
        json!({"volume": {"add": {"path": file}}}),
        json!({"view": {"size": {"view": "3d", "size": [48, 48]}}}),
        json!({"view": {"frame": {"from": [0.4, 1, 0.5]}}}),
        json!({"segment": {"set": {"id": 1, "name": "one"}}}),
        json!({"segment": {"set": {"id": 2, "name": "held", "locked": true}}}),
    ] {
        does(&mut document, line);
    }
    Some(document)
}

fn one_of<T: Clone>(rng: &mut StdRng, of: &[T]) -> T {
    of[rng.random_range(0..of.len())].clone()
}

/// A volume that is there, and whether it is a box.
fn volume(rng: &mut StdRng, document: &Document, boxes: bool) -> Option<(u32, [u32; 3])> {
    let state = document.state().unwrap();
    let all = state.scene.volumes.all.iter().filter(|(_, v)| !boxes || v.sub_volume.is_some());
    let all: Vec<(u32, [u32; 3])> = all.map(|(id, _)| (id.0, state.volumes[id].grid().dims)).collect();
    (!all.is_empty()).then(|| one_of(rng, &all))
}

fn brush(rng: &mut StdRng) -> Value {
    let target = match rng.random_range(0..5) {
        0 => json!({"selection": rng.random_range(0.0..1.0)}),
        1 => json!({"label": rng.random_range(1..4)}),
        2 => json!({"colour": [1, 0.5, 0, rng.random_range(0.0..1.0)]}),
        _ => json!({"density": rng.random_range(-20.0..300.0)}),
    };
    let plain = ["replace", "add", "subtract", "blend", "restore"];
    let around = ["smooth", "median", "sharpen", "raise", "lower", "push", "pull", "fill"];
    let looks = target.get("density").is_some() && rng.random_bool(0.3);
    json!({
        "target": target,
        "operation": if looks { one_of(rng, &around) } else { one_of(rng, &plain) },
        "radius_mm": one_of(rng, &[0.4, 2.5, 4.0]),
        "falloff": one_of(rng, &["hard", "smooth", "gaussian"]),
        "strength": one_of(rng, &[1.0, 0.6, 0.1]),
        "tip": one_of(rng, &["wash", "build_up"]),
        "height_mm": rng.random_range(0.0..2.0),
        "reach_mm": rng.random_range(0.5..1.5),
        "erase": rng.random_bool(0.08),
        "connected": rng.random_bool(0.05),
    })
}

/// A command on what is there.
fn command(rng: &mut StdRng, document: &Document) -> Value {
    let place = |rng: &mut StdRng| json!({"mm": [rng.random_range(-1.0..29.0), rng.random_range(-1.0..27.0), rng.random_range(-2.0..17.0)]});
    let scale =
        |rng: &mut StdRng| one_of(rng, &[json!(1), json!(2), json!(2), json!(3), json!(4), json!([2, 1, 3]), json!(8)]);
    let (id, dims) = volume(rng, document, false).unwrap();
    let boxed = volume(rng, document, true);
    match rng.random_range(0..100) {
        0..18 => {
            let lo: [u32; 3] = dims.map(|d| rng.random_range(0..d - 1));
            let hi: [u32; 3] = std::array::from_fn(|a| lo[a] + rng.random_range(1..8));
            let mut command = add(lo, hi, scale(rng));
            command["sub_volume"]["add"]["volume"] = json!(id);
            command
        }
        18..30 if boxed.is_some() => {
            let (id, _) = boxed.unwrap();
            let of = document.state().unwrap().scene.volumes.all[&VolumeId(id)].sub_volume.unwrap().of;
            let moved = |rng: &mut StdRng, v: u32| (i64::from(v) + rng.random_range(-3..4)).max(0);
            let mut set = json!({"volume": id, "discard": rng.random_bool(0.5)});
            if rng.random_bool(0.8) {
                set["lo"] = json!(of.lo.map(|v| moved(rng, v)));
                set["hi"] = json!(of.hi.map(|v| moved(rng, v)));
            }
            if rng.random_bool(0.4) {
                set["scale"] = scale(rng);
            }
            json!({"sub_volume": {"set": set}})
        }
        30..36 if boxed.is_some() => {
            json!({"sub_volume": {"remove": {"volume": boxed.unwrap().0, "inner": rng.random_bool(0.3)}}})
        }
        36..44 if boxed.is_some() => {
            json!({"sub_volume": {"bake": {"volume": boxed.unwrap().0, "remove": rng.random_bool(0.3)}}})
        }
        44..48 => {
            let verb = one_of(rng, &["keep", "remove"]);
            json!({"component": {verb: {"at": place(rng), "volume": id, "matter": "everything"}}})
        }
        48..51 => json!({"component": {"remove": {"at": place(rng), "volume": id, "matter": {"range": [90, 400]}}}}),
        51..55 => json!({"selection": {"from_label": {"label": 1, "volume": id}}}),
        55..57 => json!({"selection": {"clear": {"volume": id}}}),
        57..60 => json!({"volume": {"set": {"volume": id, "visible": rng.random_bool(0.6)}}}),
        60..62 => {
            json!({"volume": {"set": {"volume": rng.random_range(0..2), "pose": {"rotation": [0, 0, 0, 1], "translation": [rng.random_range(-2.0..2.0), 0, 1]}}}})
        }
        62..64 => json!({"volume": {"set": {"volume": id, "active": true}}}),
        64..66 => {
            json!({"volume": {"set": {"volume": id, "opacity": rng.random_range(0.2..1.0), "look": {"mode": "mip"}}}})
        }
        66..68 => json!({"segment": {"remove": {"id": 1, "volume": id}}}),
        68..70 => json!({"segment": {"set": {"id": 1, "name": "one", "volume": id}}}),
        70..72 => json!({"history": {"begin": {}}}),
        72..76 => json!({"history": {"end": {}}}),
        _ => {
            let mut paint = json!({"points": [{"at": place(rng)}, {"at": place(rng)}]});
            if rng.random_bool(0.4) {
                paint["volume"] = json!(id);
            }
            json!({"stroke": {"paint": paint}})
        }
    }
}

/// Boxes of one volume are apart, lie in it, and their samples are where they are said to be.
fn check(document: &Document, when: &str) {
    let state = document.state().unwrap();
    let boxes = || state.scene.volumes.all.iter().filter_map(|(id, v)| Some((*id, v.sub_volume?)));
    for (id, sub) in boxes() {
        assert_eq!(state.volumes[&id].sub_box(), Some(sub.of), "{when}: {id}");
        let dims = state.volumes[&sub.parent].grid().dims;
        assert!((0..3).all(|a| sub.of.lo[a] < sub.of.hi[a] && sub.of.hi[a] < dims[a]), "{when}: {id}");
        let beside = boxes().filter(|(other, its)| *other != id && its.parent == sub.parent);
        for (other, its) in beside {
            assert!(its.of.is_apart(&sub.of), "{when}: {id} and {other}");
        }
    }
    let befores = state.volumes.keys().filter(|id| id.is_of_before()).count();
    assert_eq!(befores, boxes().count(), "{when}");
}

fn walk(kind: usize, seed: u64, steps: usize) -> bool {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut document) = document(kind, folder.path()) else { return false };
    let path = folder.path().join("walk.burin");
    does(&mut document, json!({"project": {"save": {"path": path}}}));
    let mut rng = StdRng::seed_from_u64(seed);
    let begun = document.history().undo_names().len();
    let start = everything(&document);
    let mut now = start.clone();
    let mut trace: Vec<String> = Vec::new();
    for at in 0..steps {
        let set = brush(&mut rng);
        does(&mut document, json!({"brush": {"set": set}}));
        let line = command(&mut rng, &document);
        let done = run(&mut document, &line.to_string());
        let what = if line.get("stroke").is_some() { format!("{line} with {set}") } else { line.to_string() };
        trace.push(format!("{what}: {}", done.as_ref().map_or_else(ToString::to_string, |_| "done".into())));
        let when = format!("kind {kind}, seed {seed}: {}", trace.join("\n"));
        let after = everything(&document);
        if done.is_err() {
            same(&after, &now, &format!("refused: {when}"));
        }
        check(&document, &when);
        let in_group = document.history().in_group();
        if !in_group && rng.random_bool(0.2) {
            let steps = rng.random_range(1..4).min(document.history().undo_names().len() - begun);
            does(&mut document, json!({"history": {"undo": {"steps": steps}}}));
            check(&document, &when);
            if rng.random_bool(0.5) {
                lost(&document, &path, folder.path(), &format!("undone by {steps}: {when}"));
            }
            does(&mut document, json!({"history": {"redo": {"steps": steps}}}));
            same(&everything(&document), &after, &format!("undone by {steps} and done again: {when}"));
        }
        if at % 9 == 4 {
            lost(&document, &path, folder.path(), &when);
        }
        if !in_group && rng.random_bool(0.06) {
            does(&mut document, json!({"project": {"save": {}}}));
            trace.push("saved".into());
            lost(&document, &path, folder.path(), &format!("saved: {when}"));
        }
        now = after;
    }
    let when = format!("kind {kind}, seed {seed}: {}", trace.join("\n"));
    if document.history().in_group() {
        does(&mut document, json!({"history": {"end": {}}}));
    }
    let steps = document.history().undo_names().len() - begun;
    does(&mut document, json!({"history": {"undo": {"steps": steps}}}));
    same(&everything(&document), &start, &format!("all undone: {when}"));
    does(&mut document, json!({"history": {"redo": {"steps": 1000}}}));
    same(&everything(&document), &now, &format!("all done again: {when}"));
    let copy = folder.path().join("last.burin");
    copy_folder(&path, &copy);
    same(&every_texel(&opened(&copy)), &every_texel(&document), &format!("all texels, lost and found: {when}"));
    true
}

/// Fails where what a crash would leave is not what is there.
fn lost(document: &Document, path: &std::path::Path, folder: &std::path::Path, when: &str) {
    let copy = folder.join("found.burin");
    std::fs::remove_dir_all(&copy).ok();
    copy_folder(path, &copy);
    same(&everything(&opened(&copy)), &everything(document), &format!("lost and found: {when}"));
}

#[test]
fn walks_over_boxes_come_back_by_undo_redo_crashes_and_saves() {
    let walks: u64 = std::env::var("BURIN_WALKS").map_or(1, |n| n.parse().unwrap());
    let first: u64 = std::env::var("BURIN_FIRST_WALK").map_or(0, |n| n.parse().unwrap());
    for seed in first..first + walks {
        for kind in 0..4 {
            if !walk(kind, seed * 4 + kind as u64, 24) {
                return;
            }
        }
    }
}
