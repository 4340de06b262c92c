//! What of a volume can be connected under the present looks: of segments, parts and the selection, of whatever volume, where it lies.

use super::connected::{DIMS, flood, lumps, over, refused, say, shows, some};
use super::maker::{bytes, write_nrrd};
use crate::common::one::One;
use crate::common::volumes::each;
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

#[test]
fn floats_show_by_their_texels_and_nan_shows_nowhere() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let values = [39.9, 40.0, 40.1, 199.9, 200.0, f32::NAN, 100.0];
    // The last bricks have one value beside NaN.
    let voxels: Vec<f32> = each(DIMS, |v| values[rng.random_range(if v[2] >= 30 { 5..7 } else { 0..7 })]);
    let mut document = over(Voxels::F32(voxels.clone()), DIMS);
    let set: Vec<bool> = voxels.iter().map(|v| shows(f64::from(*v))).collect();
    let at = some(&set, 2);
    let said = say(&mut document, json!({"component":{"select":{"at":{"index":at}}}}));
    assert_eq!(said["voxels"], flood(&set, DIMS, at, 1).iter().filter(|c| **c).count());
}

#[test]
fn hidden_segments_and_segments_with_looks_of_their_own_count_as_they_show() {
    let voxels = vec![100_u8; DIMS.iter().product::<u32>() as usize];
    let mut document = over(Voxels::U8(voxels), DIMS);
    let mut state = document.state().unwrap().clone();
    let grid = *state.one().grid();
    // Three slabs: 1, none, 2.
    let label = |v: [u32; 3]| [1, 0, 0, 2][(v[0] / 20).min(3) as usize];
    state.one_mut().labels = crate::common::volumes::painted(FieldKind::Labels, &grid, |v| [label(v), 0, 0, 0]);
    document.adopt(state);
    for id in [1, 2] {
        say(&mut document, json!({"segment":{"set":{"id":id}}}));
    }
    let [a, b] = [20, 40].map(|n: u64| n * u64::from(DIMS[1] * DIMS[2]));
    let ask = |document: &mut Document, x: u32, within: Value| {
        let mut what = json!({"at":{"index":[x, 3, 3]}});
        if !within.is_null() {
            what["within"] = within;
        }
        let said = say(document, json!({"component":{"select": what}}))["voxels"].as_u64();
        say(document, json!({"selection":{"clear":{}}}));
        said
    };
    assert_eq!(ask(&mut document, 30, Value::Null), Some(u64::from(DIMS.iter().product::<u32>())));
    assert_eq!(ask(&mut document, 30, json!({"segment":0})), Some(b));
    assert_eq!(ask(&mut document, 10, json!({"segment":1})), Some(a));
    // Of a segment that does not show, nothing is met, and what lies beyond it is apart.
    say(&mut document, json!({"segment":{"set":{"id":2,"look":{"opacity":0}}}}));
    assert_eq!(ask(&mut document, 30, Value::Null), Some(a + b));
    say(&mut document, json!({"segment":{"show_only":{"ids":[1]}}}));
    assert_eq!(ask(&mut document, 10, Value::Null), Some(a));
    let hidden = refused(&mut document, json!({"component":{"keep":{"at":{"index":[30,3,3]}}}}));
    assert!(hidden.contains("a place at matter that the 3D view shows"), "{hidden}");
    // A surface shows what lies above it.
    say(&mut document, json!({"segment":{"show_only":{}}}));
    say(&mut document, json!({"segment":{"set":{"id":1,"look":{"mode":{"iso":101}}}}}));
    assert_eq!(ask(&mut document, 30, Value::Null), Some(b));
}

#[test]
fn a_volume_that_was_moved_is_met_where_it_lies() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("b.nrrd");
    let grid = Grid::aligned([20, 18, 16], DVec3::new(1.0, 1.5, 2.0), DVec3::new(3.0, -4.0, 7.0));
    // Two lumps in one row.
    let lump = |v: [u32; 3]| (2..7).contains(&v[0]) || (11..17).contains(&v[0]);
    write_nrrd(&path, &grid, |v| if lump(v) && v[1] > 2 { 100.0 } else { 10.0 });
    let mut document = over(Voxels::U8(lumps(6)), DIMS);
    say(&mut document, json!({"volume":{"add":{"path":path}}}));
    let pose = json!({"rotation":[0.0,0.0,-0.28,0.96],"translation":[4.0,13.0,2.0]});
    let function = json!({"colour":[[0,[1,1,1]]],"opacity":[[40,0],[60,0.5],[150,0.5],[200,0]],"unit_mm":1});
    say(&mut document, json!({"volume":{"set":{"volume":1,"pose":pose,"look":{"transfer":function}}}}));
    let first = bytes(&document);
    let subject = document.state().unwrap().at(Some(VolumeId(1))).unwrap();
    let world = subject.grid().world_from_index.transform_point3(DVec3::new(13.2, 8.4, 7.3));
    let said = say(&mut document, json!({"component":{"keep":{"at":{"mm":world.to_array()},"volume":1}}}));
    assert_eq!((said["volume"].as_u64(), said["voxels"].as_u64()), (Some(1), Some(6 * 15 * 16)));
    let density = |document: &Document, v: [u32; 3]| {
        document.state().unwrap().volumes[&VolumeId(1)].density.number(v).unwrap().to_f64().round()
    };
    assert_eq!([4, 13].map(|x| density(&document, [x, 8, 7])), [10.0, 100.0]);
    assert!(bytes(&document).0 == first.0, "the other volume is as it was");
    // The step can be done again elsewhere: its place is in mm, its volume named.
    let history = say(&mut document, json!({"ask":{"history":{"commands":true}}}));
    let commands = history["undo_commands"].as_array().unwrap();
    let last = commands.iter().flat_map(|c| c.as_array().unwrap()).find(|c| c["command"]["component"].is_object());
    let keep = &last.unwrap()["command"]["component"]["keep"];
    assert_eq!(keep["volume"], 1);
    assert!(keep["at"]["mm"].is_array(), "{keep}");
}

#[test]
fn a_pixel_of_the_3d_view_means_what_it_shows_of_whatever_volume() {
    let dims = [64, 48, 40];
    let block =
        |v: [u32; 3], x: std::ops::Range<u32>| x.contains(&v[0]) && (8..40).contains(&v[1]) && (8..32).contains(&v[2]);
    let voxels = each(dims, |v| if block(v, 6..26) || block(v, 38..58) { 200_u8 } else { 0 });
    let Some(mut document) = super::maker_gpu::made(Voxels::U8(voxels), dims, DVec3::ONE) else { return };
    let function = json!({"colour":[[0,[1,0.8,0.6]]],"opacity":[[90,0],[110,0.9]],"unit_mm":1});
    say(&mut document, json!({"transfer":{"set":{"function":function}}}));
    // Another block above both, in a volume of its own.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("above.nrrd");
    let grid = Grid::aligned([30, 20, 20], DVec3::ONE, DVec3::new(17.0, 10.0, 45.0));
    write_nrrd(&path, &grid, |v| if v.iter().all(|x| (3..17).contains(x)) { 200.0 } else { 0.0 });
    say(&mut document, json!({"volume":{"add":{"path":path}}}));
    say(&mut document, json!({"volume":{"set":{"volume":1,"look":{"transfer":function}}}}));
    say(&mut document, json!({"view":{"size":{"view":"3d","size":[96,96]}}}));
    say(&mut document, json!({"view":{"frame":{"from":[0,-1,0]}}}));
    let shown = |document: &mut Document, rest: [f64; 3]| {
        // The pixel that shows the place, found by looking at all.
        let mut best = (f64::INFINITY, [0.0; 2]);
        for i in 0..24 * 24 {
            let px = [f64::from(i % 24) * 4.0 + 2.0, f64::from(i / 24) * 4.0 + 2.0];
            let hit = say(document, json!({"ask":{"pick":{"px":px}}}))["hit"].take();
            let Some(mm) = hit["rest_mm"].as_array() else { continue };
            let far: f64 = mm.iter().zip(rest).map(|(a, b)| (a.as_f64().unwrap() - b).powi(2)).sum();
            if far < best.0 {
                best = (far, px);
            }
        }
        assert!(best.0 < 16.0, "nothing shows near {rest:?}");
        best.1
    };
    let (left, right, above) = (
        shown(&mut document, [16.0, 8.0, 20.0]),
        shown(&mut document, [48.0, 8.0, 20.0]),
        shown(&mut document, [27.0, 13.0, 55.0]),
    );
    let pick = |document: &mut Document, px: [f64; 2]| say(document, json!({"ask":{"pick":{"px":px}}}))["hit"].take();
    let at = |px: [f64; 2]| json!({"pixel":{"view":"3d","px":px}});
    let said = say(&mut document, json!({"component":{"keep":{"at":at(left)}}}));
    assert_eq!((&said["volume"], &said["voxels"], &said["components"]), (&json!(0), &json!(20 * 32 * 24), &json!(2)));
    assert!(pick(&mut document, left).is_object() && pick(&mut document, above).is_object());
    assert!(pick(&mut document, right).is_null(), "the picture follows");
    say(&mut document, json!({"history":{"undo":{}}}));
    assert!(pick(&mut document, right).is_object());
    let said = say(&mut document, json!({"component":{"remove":{"at":at(above)}}}));
    assert_eq!((&said["volume"], &said["voxels"]), (&json!(1), &json!(14 * 14 * 14)));
    assert!(pick(&mut document, above).is_null());
    let said = refused(&mut document, json!({"component":{"keep":{"at":at(above)}}}));
    assert!(said.contains("where nothing is visible"), "{said}");
    // A volume that is named is meant, whatever hides it.
    let said = refused(&mut document, json!({"component":{"keep":{"at":at(left),"volume":1}}}));
    assert!(said.contains("at: "), "{said}");
}

#[test]
fn hidden_parts_and_matter_that_its_part_or_the_selection_hides_are_not_met() {
    let voxels = vec![100_u8; DIMS.iter().product::<u32>() as usize];
    let mut document = over(Voxels::U8(voxels), DIMS);
    let grid = *document.state().unwrap().at(None).unwrap().grid();
    let world = |v: [u32; 3]| grid.world_from_index.transform_point3(DVec3::from_array(v.map(f64::from)));
    // Oblique, through bricks.
    let (normal, offset) = (DVec3::new(0.8, 0.6, 0.0), 26.3);
    let cut = json!({"plane":{"normal":normal.to_array(),"point":(normal * offset).to_array()}});
    say(&mut document, json!({"part":{"split":{"by":cut}}}));
    let parts = document.state().unwrap().scene.explosion.parts.clone();
    assert_eq!(parts.len(), 2);
    let beyond = |v: [u32; 3]| world(v).dot(normal) > offset;
    let hidden = parts.iter().find(|part| part.centre().dot(normal) > offset).unwrap().id.0;
    let ask = |document: &mut Document, within: &str| {
        let said = say(document, json!({"component":{"label":{"label":9,"at":{"index":[0,0,0]},"within":within}}}));
        let found = document.state().unwrap().one().labels.clone();
        say(document, json!({"history":{"undo":{}}}));
        (said["voxels"].as_u64().unwrap(), each(DIMS, |v| found.value(v).unwrap() == 9.0))
    };
    let all = u64::from(DIMS.iter().product::<u32>());
    assert_eq!(ask(&mut document, "volume").0, all, "cut, and all of it shown");
    let near: Vec<bool> = each(DIMS, |v| !beyond(v));
    for change in [json!({"visible":false}), json!({"visible":true,"look":{"opacity":0}})] {
        let mut set = change.clone();
        set["id"] = json!(hidden);
        say(&mut document, json!({"part":{"set":set}}));
        assert!(ask(&mut document, "volume").1 == near, "{change}");
    }
    say(&mut document, json!({"part":{"set":{"id":hidden,"look":"inherit"}}}));
    assert_eq!(ask(&mut document, "volume").0, all);
    // What is selected is no part's, and has its own look.
    let region = |v: [u32; 3]| v[2] > 20 && v[0] < 50;
    let mut state = document.state().unwrap().clone();
    let own = *state.one().grid();
    state.one_mut().selection =
        crate::common::volumes::painted(FieldKind::Selection, &own, |v| [if region(v) { 200 } else { 0 }, 0, 0, 0]);
    document.adopt(state);
    say(&mut document, json!({"selection":{"set":{"look":{"opacity":0}}}}));
    assert!(ask(&mut document, "volume").1 == each(DIMS, |v| !region(v)));
    say(&mut document, json!({"selection":{"set":{"look":"inherit"}}}));
    say(&mut document, json!({"part":{"set":{"id":hidden,"visible":false}}}));
    assert!(
        ask(&mut document, "volume").1 == each(DIMS, |v| region(v) || !beyond(v)),
        "selected matter shows though its part is hidden"
    );
}
