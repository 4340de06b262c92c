//! What is connected over the faces of sub-volumes: kept, removed, selected, labelled and painted as one, against a flood over cells.

use super::connected::{over, place, say, shows};
use super::maker_gpu::made;
use crate::common::raster::{Nest, Node, Raster};
use crate::common::volumes::each;
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::collections::BTreeSet;

const DIMS: [u32; 3] = [9, 8, 8];

/// Everything that undo answers for, of all volumes.
fn all_bytes(document: &Document) -> (Vec<Vec<u8>>, String) {
    let state = document.state().unwrap();
    let mut all = Vec::new();
    for volume in state.volumes.values() {
        for kind in FieldKind::ALL {
            let field = volume.field(kind);
            for level in 0..field.level_count() {
                all.push(field.read(level, [0; 3], field.dims(level)).unwrap());
            }
            let mut edits: Vec<_> = field.edits().into_keys().collect();
            edits.sort();
            all.push(format!("{:?} {edits:?}", field.map()).into_bytes());
        }
    }
    (all, serde_json::to_string(&(&state.scene.volumes, &state.scene.explosion)).unwrap())
}

fn number(document: &Document, (volume, voxel): Node) -> f64 {
    document.state().unwrap().volumes[&VolumeId(volume as u32)].density.number(voxel).unwrap().to_f64()
}

fn texel(document: &Document, kind: FieldKind, (volume, voxel): Node) -> u16 {
    let [a, b, ..] = document.state().unwrap().volumes[&VolumeId(volume as u32)].field(kind).texel(voxel).unwrap();
    u16::from_le_bytes([a, b])
}

/// Puts a texel of `f` at every voxel of a volume's field.
pub(super) fn fill(document: &mut Document, volume: usize, kind: FieldKind, mut f: impl FnMut([u32; 3]) -> f64) {
    let mut state = document.state().unwrap().clone();
    let field = state.volume_mut(VolumeId(volume as u32)).unwrap().field_mut(kind);
    let (bytes, map, dims) = (field.format().bytes(), *field.map(), field.dims(0));
    let values = each(dims, |v| v);
    let values: std::collections::HashMap<[u32; 3], f64> = values.into_iter().map(|v| (v, f(v))).collect();
    let changes = field.brick_indices(0).into_iter().map(|index| {
        let mut texels = vec![0; BRICK_VOXELS * bytes];
        let (origin, valid) = (index.origin(), field.valid(0, index));
        for v in each(valid, |v| v) {
            let value = values[&std::array::from_fn::<u32, 3, _>(|a| origin[a] + v[a])];
            let texel = match kind {
                FieldKind::Density => map.encode(value),
                FieldKind::Labels => {
                    let [a, b] = (value as u16).to_le_bytes();
                    [a, b, 0, 0]
                }
                _ => [value as u8, 0, 0, 0],
            };
            let at = (v[0] + BRICK * (v[1] + BRICK * v[2])) as usize * bytes;
            texels[at..at + bytes].copy_from_slice(&texel[..bytes]);
        }
        (index, Some(Brick::from_texels(texels, bytes)))
    });
    let changes = changes.collect();
    field.swap(changes).unwrap();
    document.adopt(state);
}

fn add(document: &mut Document, nest: &Nest) {
    let (outer, SubBox { lo, hi, scale }) = nest.within.unwrap();
    say(document, json!({"sub_volume": {"add": {"volume": outer, "lo": lo, "hi": hi, "scale": scale}}}));
}

fn nests() -> Vec<(u32, Vec<Nest>)> {
    let whole = || Nest::whole(DIMS);
    vec![
        (2, vec![whole(), Nest::of(0, [2, 1, 2], [6, 6, 5], [2; 3])]),
        (3, vec![whole(), Nest::of(0, [0, 1, 2], [4, 6, 7], [3, 1, 3])]),
        (2, vec![whole(), Nest::of(0, [1, 1, 2], [4, 6, 5], [2; 3]), Nest::of(0, [4, 2, 1], [8, 5, 6], [1, 2, 2])]),
        (4, vec![whole(), Nest::of(0, [2, 1, 2], [6, 6, 5], [2; 3]), Nest::of(1, [0, 3, 1], [5, 8, 5], [2; 3])]),
    ]
}

/// Noise of three values in every lattice, of which the present look shows one.
fn noisy(nests: &[Nest], seed: u64) -> Document {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut value = move || [10_u8, 100, 100, 250, 10][rng.random_range(0..5)];
    let mut document = over(Voxels::U8(each(DIMS, |_| value())), DIMS);
    for (l, nest) in nests.iter().enumerate().skip(1) {
        add(&mut document, nest);
        fill(&mut document, l, FieldKind::Density, |_| f64::from(value()));
    }
    document
}

/// The voxels of all lattices, whoever tells their places.
fn voxels(nests: &[Nest]) -> Vec<Node> {
    nests.iter().enumerate().flat_map(|(l, nest)| each(nest.dims, |v| (l, v))).collect()
}

/// A place in the world of a voxel.
fn mm(document: &Document, (volume, voxel): Node) -> Value {
    let subject = document.state().unwrap().at(Some(VolumeId(volume as u32))).unwrap();
    let at = subject.grid().world_from_index.transform_point3(DVec3::from_array(voxel.map(f64::from)));
    json!({"mm": at.to_array()})
}

/// A large component, and a voxel of it that is told by no face of a box.
fn picked(nests: &[Nest], components: &[BTreeSet<Node>]) -> (BTreeSet<Node>, Node) {
    let component = components.iter().max_by_key(|c| c.len()).unwrap().clone();
    let lattices: BTreeSet<usize> = component.iter().map(|node| node.0).collect();
    assert!(lattices.len() == nests.len(), "it crosses every face: {lattices:?}");
    let inner = |(l, v): &&Node| {
        let apart = |other: &Nest| {
            let Some((outer, SubBox { lo, hi, .. })) = other.within else { return true };
            outer != *l || (0..3).any(|a| v[a] < lo[a] || v[a] > hi[a])
        };
        nests.iter().all(apart) && (0..3).all(|a| *l == 0 || (v[a] > 0 && v[a] + 1 < nests[*l].dims[a]))
    };
    let at = *component.iter().find(inner).unwrap();
    (component, at)
}

#[test]
fn a_component_that_runs_through_boxes_is_one_and_what_is_not_meant_keeps_every_bit() {
    for (n, (fine, nests)) in nests().into_iter().enumerate() {
        let mut document = noisy(&nests, n as u64 + 1);
        let raster = Raster::new(&nests, fine);
        let shown = |document: &Document, node: Node| shows(number(document, node));
        let components = raster.components(1, |node| shown(&document, node));
        let told: BTreeSet<Node> = components.iter().flatten().copied().collect();
        let (component, at) = picked(&nests, &components);
        let at = mm(&document, at);
        let before = all_bytes(&document);
        let densities: Vec<f64> = voxels(&nests).into_iter().map(|node| number(&document, node)).collect();
        for keeps in [true, false] {
            let verb = if keeps { "keep" } else { "remove" };
            let said = say(&mut document, json!({"component": {verb: {"at": at}}}));
            assert_eq!(said["voxels"], json!(component.len()), "{n}: {said}");
            assert_eq!(said["components"], json!(components.len()), "{n}");
            assert_eq!(said["volume"], json!(0));
            let value = said["value"].as_f64().unwrap();
            assert!(!shows(value));
            for (l, _) in nests.iter().enumerate() {
                let own = component.iter().filter(|node| node.0 == l).count();
                assert_eq!(said["volumes"][l], json!({"volume": l, "voxels": own}));
            }
            let mut changed = 0;
            for (node, was) in voxels(&nests).into_iter().zip(&densities) {
                let goes = told.contains(&node) && component.contains(&node) != keeps;
                changed += u64::from(goes);
                assert_eq!(number(&document, node), if goes { value } else { *was }, "{n} {verb}: {node:?}");
            }
            assert_eq!(said["voxels_changed"], json!(changed), "{n}");
            say(&mut document, json!({"history": {"undo": {}}}));
            assert!(all_bytes(&document) == before, "{n}: undone in one step");
        }
        for how in ["replace", "add", "subtract"] {
            for l in 0..nests.len() {
                fill(&mut document, l, FieldKind::Selection, |[x, ..]| if x % 2 == 0 { 200.0 } else { 0.0 });
            }
            say(&mut document, json!({"component": {"select": {"at": at, "how": how}}}));
            for node in voxels(&nests) {
                let was = if node.1[0] % 2 == 0 { 200 } else { 0 };
                let expected = match (how, component.contains(&node)) {
                    ("subtract", true) | ("replace", false) => 0,
                    (_, true) => 255,
                    _ => was,
                };
                assert_eq!(texel(&document, FieldKind::Selection, node), expected, "{n} {how}: {node:?}");
            }
        }
        say(&mut document, json!({"selection": {"clear": {}}}));
        say(&mut document, json!({"component": {"label": {"at": at, "label": 7}}}));
        for node in voxels(&nests) {
            assert_eq!(texel(&document, FieldKind::Labels, node), if component.contains(&node) { 7 } else { 0 });
        }
    }
}

#[test]
fn a_brushed_region_in_boxes_bounds_what_is_connected_and_what_a_box_stands_for_is_no_region() {
    for (n, (fine, nests)) in nests().into_iter().enumerate() {
        let mut document = noisy(&nests, n as u64 + 1);
        let raster = Raster::new(&nests, fine);
        let region = |(l, [x, y, z]): Node| (x + 2 * y + z + l as u32) % 7 > 1;
        for l in 0..nests.len() {
            fill(&mut document, l, FieldKind::Selection, |v| if region((l, v)) { 128.0 } else { 127.0 });
        }
        let components = raster.components(1, |node| region(node) && shows(number(&document, node)));
        let largest = components.iter().map(BTreeSet::len).max().unwrap();
        let component = components.iter().find(|c| c.len() == largest).unwrap();
        let at = mm(&document, *component.iter().next_back().unwrap());
        let told: BTreeSet<Node> = components.iter().flatten().copied().collect();
        let densities: Vec<f64> = voxels(&nests).into_iter().map(|node| number(&document, node)).collect();
        let said = say(&mut document, json!({"component": {"keep": {"at": at}}}));
        assert_eq!(said["voxels"], json!(largest), "{n}");
        for (node, was) in voxels(&nests).into_iter().zip(densities) {
            let goes = told.contains(&node) && !component.contains(&node);
            assert_eq!(
                number(&document, node),
                if goes { said["value"].as_f64().unwrap() } else { was },
                "{n}: {node:?}"
            );
        }
    }
    // Selected where a box stands for it alone: nothing is.
    let (_, nests) = nests().remove(0);
    let mut document = noisy(&nests, 1);
    let hidden = |v: [u32; 3]| (3..6).contains(&v[0]) && (2..6).contains(&v[1]) && (3..5).contains(&v[2]);
    fill(&mut document, 0, FieldKind::Selection, |v| if hidden(v) { 255.0 } else { 0.0 });
    let bounded = say(&mut document, json!({"component": {"keep": {}}}));
    say(&mut document, json!({"history": {"undo": {}}}));
    let free = say(&mut document, json!({"component": {"keep": {"within": "volume"}}}));
    assert_eq!(bounded["voxels"], free["voxels"]);
}

#[test]
fn a_box_alone_is_meant_where_it_is_named_and_one_that_is_hidden_stands_for_nothing() {
    let (fine, nests) = nests().remove(0);
    let mut document = noisy(&nests, 1);
    let own = Raster::new(&[Nest::whole(nests[1].dims)], fine).components(1, |(_, v)| shows(number(&document, (1, v))));
    let largest = own.iter().map(BTreeSet::len).max().unwrap();
    let said = say(&mut document, json!({"component": {"keep": {"volume": 1}}}));
    assert_eq!((&said["voxels"], &said["volume"]), (&json!(largest), &json!(1)));
    say(&mut document, json!({"history": {"undo": {}}}));
    // Where the box is at hand and none is named, what is connected goes on outside of it.
    let whole = say(&mut document, json!({"component": {"keep": {}}}));
    say(&mut document, json!({"history": {"undo": {}}}));
    say(&mut document, json!({"volume": {"set": {"volume": 1, "active": true}}}));
    assert_eq!(document.state().unwrap().scene.volumes.active, VolumeId(1));
    let said = say(&mut document, json!({"component": {"keep": {}}}));
    assert_eq!((&said["voxels"], &said["volume"]), (&whole["voxels"], &json!(0)));
    say(&mut document, json!({"history": {"undo": {}}}));
    say(&mut document, json!({"volume": {"set": {"volume": 1, "visible": false}}}));
    let inside = |document: &Document| {
        let density = &document.state().unwrap().volumes[&VolumeId(1)].density;
        density.read(0, [1; 3], density.dims(0).map(|d| d - 2)).unwrap()
    };
    let before = inside(&document);
    let plain = Raster::new(&nests[..1], 1).components(1, |node| shows(number(&document, node)));
    let largest = plain.iter().map(BTreeSet::len).max().unwrap();
    let said = say(&mut document, json!({"component": {"keep": {"volume": 0}}}));
    assert_eq!(said["voxels"], json!(largest));
    assert!(inside(&document) == before, "half a voxel from its faces on what is hidden stays as it is");
}

#[test]
fn a_gap_of_one_fine_sample_parts_what_the_voxels_under_it_hold_together() {
    // Also where the box ends at the volume's border and where two boxes meet.
    for boxes in [vec![([0; 3], [8, 7, 7])], vec![([0, 0, 0], [4, 7, 7]), ([4, 0, 0], [8, 7, 7])]] {
        let mut voxels = vec![100; 9 * 8 * 8];
        voxels[0] = 10;
        let mut document = over(Voxels::U8(voxels), DIMS);
        for (n, (lo, hi)) in boxes.iter().enumerate() {
            add(&mut document, &Nest::of(0, *lo, *hi, [4; 3]));
            fill(&mut document, n + 1, FieldKind::Density, |[_, _, z]| if z == 14 { 10.0 } else { 100.0 });
        }
        let said = say(&mut document, json!({"component": {"keep": {"at": {"index": [1, 1, 1]}}}}));
        assert_eq!(said["components"], json!(2), "{boxes:?}");
        let samples: u64 = boxes.iter().map(|(lo, hi)| u64::from((hi[0] - lo[0]) * 4 + 1) * 29 * 14).sum();
        assert_eq!(said["voxels"], json!(samples), "{boxes:?}");
        // 14 layers of a quarter of a voxel, of which the first reaches to the border, on the whole cross-section.
        let expected = 0.7 * 1.5 * samples as f64 / 64.0;
        assert!((said["mm3"].as_f64().unwrap() / expected - 1.0).abs() < 1e-9, "{said}");
    }
}

#[test]
fn a_brush_that_keeps_to_what_is_connected_goes_through_faces() {
    let value = |v: [u32; 3]| if (3..6).contains(&v[1]) && (3..6).contains(&v[2]) { 200_u8 } else { 0 };
    let dims = [24, 9, 9];
    let Some(mut document) = made(Voxels::U8(each(dims, value)), dims, DVec3::ONE) else { return };
    let function = json!({"colour": [[0, [1, 1, 1]]], "opacity": [[90, 0], [110, 0.9]], "unit_mm": 1});
    say(&mut document, json!({"transfer": {"set": {"function": function}}}));
    add(&mut document, &Nest::of(0, [8, 2, 2], [16, 6, 6], [2; 3]));
    let set = json!({"target": {"selection": 1}, "falloff": "hard", "radius_mm": 60, "connected": true});
    say(&mut document, json!({"brush": {"set": set}}));
    let stroke = json!({"stroke": {"paint": {"points": [{"at": {"mm": [2, 4, 4]}}], "volume": 0}}});
    let selected = |document: &Document, node| texel(document, FieldKind::Selection, node);
    say(&mut document, stroke.clone());
    assert_eq!([4, 20].map(|x| selected(&document, (0, [x, 4, 4]))), [255; 2], "before the box and behind it");
    assert_eq!(selected(&document, (1, [8, 4, 4])), 255);
    assert_eq!(selected(&document, (1, [8, 0, 0])), 0);
    say(&mut document, json!({"history": {"undo": {}}}));
    // A gap in the box alone parts what lies behind it; the voxels that it stands for say nothing.
    fill(&mut document, 1, FieldKind::Density, |[x, y, z]| {
        let bar = (2..8).contains(&y) && (2..8).contains(&z);
        if bar && x != 9 { 200.0 } else { 0.0 }
    });
    say(&mut document, stroke);
    assert_eq!([4, 20].map(|x| selected(&document, (0, [x, 4, 4]))), [255, 0]);
    assert_eq!([8, 10].map(|x| selected(&document, (1, [x, 4, 4]))), [255, 0]);
}

#[test]
fn places_are_of_whoever_tells_them() {
    let (_, nests) = nests().remove(0);
    let mut document = over(Voxels::U8(vec![10; place([0, 0, 1], DIMS) * 8]), DIMS);
    add(&mut document, &nests[1]);
    fill(&mut document, 1, FieldKind::Density, |v| if v == [3, 4, 2] { 100.0 } else { 10.0 });
    let at = mm(&document, (1, [3, 4, 2]));
    let said = say(&mut document, json!({"component": {"keep": {"at": at}}}));
    assert_eq!(said["voxels"], json!(1));
    assert!((said["mm3"].as_f64().unwrap() - 0.7 * 1.5 / 8.0).abs() < 1e-12, "{said}");
}

#[test]
fn what_is_done_to_a_selection_or_a_segment_as_a_whole_is_done_in_every_box_of_it() {
    let (_, nests) = nests().remove(3);
    let mut document = noisy(&nests, 1);
    let label = |(l, [x, y, z]): Node| (x + y * 2 + z * 3 + l as u32) % 4;
    say(&mut document, json!({"segment": {"set": {"id": 1}}}));
    say(&mut document, json!({"segment": {"set": {"id": 2}}}));
    for l in 0..nests.len() {
        fill(&mut document, l, FieldKind::Labels, |v| f64::from(label((l, v))));
        fill(&mut document, l, FieldKind::Selection, |v| f64::from(v[0] * 20));
    }
    // One that is not seen has it too.
    say(&mut document, json!({"volume": {"set": {"volume": 2, "visible": false}}}));
    let before = all_bytes(&document);
    let all = voxels(&nests);
    let said = say(&mut document, json!({"selection": {"from_label": {"label": 2}}}));
    assert_eq!(said["step"], json!("Select label 2"));
    for node in &all {
        let expected = if label(*node) == 2 { 255 } else { 0 };
        assert_eq!(texel(&document, FieldKind::Selection, *node), expected, "{node:?}");
    }
    say(&mut document, json!({"selection": {"clear": {}}}));
    assert!(all.iter().all(|node| texel(&document, FieldKind::Selection, *node) == 0));
    say(&mut document, json!({"history": {"undo": {}}}));
    say(&mut document, json!({"selection": {"clear": {"volume": 1}}}));
    for node in &all {
        let expected = if label(*node) == 2 && node.0 == 0 { 255 } else { 0 };
        assert_eq!(texel(&document, FieldKind::Selection, *node), expected, "a box alone: {node:?}");
    }
    for named in [json!(0), json!(1), Value::Null] {
        say(&mut document, json!({"segment": {"remove": {"id": 2, "volume": named}}}));
        for node in &all {
            let expected = if label(*node) == 2 { 0 } else { label(*node) };
            assert_eq!(u32::from(texel(&document, FieldKind::Labels, *node)), expected, "{node:?}");
        }
        assert!(document.state().unwrap().scene.segments().get(2).is_none());
        say(&mut document, json!({"history": {"undo": {}}}));
    }
    say(&mut document, json!({"history": {"undo": {}}}));
    say(&mut document, json!({"history": {"undo": {}}}));
    assert!(all_bytes(&document) == before);
}

#[test]
fn what_is_brought_in_from_a_file_comes_to_boxes_at_their_resolution() {
    let (_, nests) = nests().remove(0);
    let mut document = noisy(&nests, 1);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fine.nrrd");
    // Three file voxels for each of the volume's; the box's samples lie nearest to some of their own.
    let own = *document.state().unwrap().at(None).unwrap().grid();
    let grid = Grid {
        dims: DIMS.map(|d| 3 * d),
        world_from_index: own.world_from_index
            * burin::math::DAffine3 {
                matrix3: burin::math::DMat3::from_diagonal(DVec3::splat(1.0 / 3.0)),
                translation: DVec3::splat(-1.0 / 3.0),
            },
    };
    let value = |v: [u32; 3]| if (v[0] * 5 + v[1] * 3 + v[2]) % 11 < 4 { 1.0 } else { 0.0 };
    super::maker::write_nrrd(&path, &grid, value);
    say(&mut document, json!({"selection": {"import": {"path": path, "threshold": 0.5}}}));
    say(&mut document, json!({"segment": {"import": {"path": path}}}));
    let state = document.state().unwrap().clone();
    let mut both = [0; 2];
    for node in voxels(&nests) {
        let subject = state.at(Some(VolumeId(node.0 as u32))).unwrap();
        let place = subject.grid().world_from_index.transform_point3(DVec3::from_array(node.1.map(f64::from)));
        let at = grid.index_from_world().transform_point3(place);
        // Halfway between two of the file's is either's.
        if (at - at.floor() - 0.5).abs().min_element() < 1e-6 {
            continue;
        }
        let expected = value((at + 0.5).floor().to_array().map(|v| v as u32));
        both[node.0] += 1;
        assert_eq!(texel(&document, FieldKind::Labels, node), expected as u16, "{node:?}");
        assert_eq!(texel(&document, FieldKind::Selection, node) >= 128, expected == 1.0, "{node:?}");
    }
    assert!(both[0] > 500 && both[1] > 50, "{both:?}");
}

/// Cuts a volume of `dims` voxels into 8 and lets no view move the parts.
fn cut_in_eight(document: &mut Document, dims: [u32; 3]) {
    let grid = *document.state().unwrap().at(None).unwrap().grid();
    let middle = grid.world_from_index.transform_point3(DVec3::from_array(dims.map(|d| f64::from(d - 1) * 0.5)));
    for axis in 0..3 {
        let mut normal = [0.0; 3];
        normal[axis] = 1.0;
        let plane = json!({"point": middle.to_array(), "normal": normal});
        say(document, json!({"part": {"split": {"by": {"plane": plane}}}}));
    }
    let mut forces = json!(document.state().unwrap().scene.explosion.forces);
    (forces["viewing"], forces["measured_gain"]) = (json!(false), json!(false));
    say(document, json!({"explosion": {"forces": {"forces": forces}}}));
}

/// Where forces take the parts.
fn displaced(document: &mut Document) -> Vec<DVec3> {
    say(document, json!({"explosion": {"degree": {"value": 1.0}}}));
    let said = say(document, json!({"explosion": {"settle": {}}}));
    let parts = document.state().unwrap().scene.explosion.parts.clone();
    let moved = parts.iter().zip(said["poses"].as_array().unwrap()).map(|(part, pose)| {
        let pose: burin::math::Pose = serde_json::from_value(pose["pose"].clone()).unwrap();
        pose.apply(part.centre()) - part.centre()
    });
    moved.collect()
}

#[test]
fn parts_make_way_for_what_is_selected_and_dense_in_a_box_and_not_for_what_it_stands_for() {
    let dims = [32, 30, 28];
    let fixture = |hi: [u32; 3], scale: [u32; 3]| {
        let mut voxels = vec![100; 32 * 30 * 28];
        voxels[0] = 0;
        let mut document = over(Voxels::U8(voxels), dims);
        add(&mut document, &Nest::of(0, [6, 8, 5], hi, scale));
        cut_in_eight(&mut document, dims);
        document
    };
    let (lo, hi) = (DVec3::new(6.0, 8.0, 5.0), [22, 24, 20]);
    let ball = |p: DVec3| if p.distance(DVec3::new(13.0, 15.0, 12.0)) < 5.0 { 255.0 } else { 0.0 };
    let at = |v: [u32; 3]| DVec3::from_array(v.map(f64::from));
    // On the volume alone, no box seen.
    let mut plain = fixture(hi, [2; 3]);
    say(&mut plain, json!({"sub_volume": {"remove": {"volume": 1}}}));
    fill(&mut plain, 0, FieldKind::Selection, |v| ball(at(v)));
    let expected = displaced(&mut plain);
    let largest = expected.iter().map(|d| d.length()).fold(0.0, f64::max);
    assert!(largest > 2.0, "{expected:?}");
    // The same in a box alone.
    let mut boxed = fixture(hi, [2; 3]);
    fill(&mut boxed, 1, FieldKind::Selection, |v| ball(lo + at(v) / 2.0));
    let found = displaced(&mut boxed);
    // Points lie elsewhere in leaves of eight voxels than in leaves of eight samples.
    for (found, expected) in found.iter().zip(&expected) {
        let (along, longer) = (found.normalize().dot(expected.normalize()), found.length() / expected.length());
        assert!(along > 0.8 && (0.7..1.4).contains(&longer), "{found}, {expected} expected");
    }
    // Nothing at all: parts keep from each other alone.
    let none = displaced(&mut fixture(hi, [2; 3]));
    assert!(none.iter().zip(&found).all(|(none, found)| none.distance(*found) > 0.2 * largest));
    let like_none = |document: &mut Document| {
        displaced(document).iter().zip(&none).all(|(found, none)| found.distance(*none) < 1e-6)
    };
    fill(&mut boxed, 1, FieldKind::Selection, |_| 0.0);
    assert!(like_none(&mut boxed), "nothing is selected any more");
    // Selected on the volume where the box stands for it alone.
    fill(&mut boxed, 0, FieldKind::Selection, |v| ball(at(v)));
    assert!(like_none(&mut boxed), "what the box stands for");
    // Selected and clear: matter that was removed in the box alone.
    let mut clear = fixture(hi, [2; 3]);
    fill(&mut clear, 1, FieldKind::Selection, |v| ball(lo + at(v) / 2.0));
    fill(&mut clear, 1, FieldKind::Density, |_| 0.0);
    assert!(like_none(&mut clear), "nothing of it shows");
}

#[test]
fn fields_are_counted_as_boxes_have_them_in_place_of_what_they_stand_for() {
    for (n, (fine, nests)) in nests().into_iter().enumerate() {
        let mut document = noisy(&nests, n as u64 + 1);
        let label = |(l, [x, y, z]): Node| (x + y * 2 + z * 3 + l as u32) % 3;
        let selected = |(l, [x, y, z]): Node| (x * 5 + y * 31 + z * 13 + l as u32 * 3) % 256;
        for l in 0..nests.len() {
            fill(&mut document, l, FieldKind::Labels, |v| f64::from(label((l, v))));
            fill(&mut document, l, FieldKind::Selection, |v| f64::from(selected((l, v))));
        }
        let shares = Raster::new(&nests, fine).shares(&nests);
        let size = |l: usize| {
            let mut size = 0.7 * 1.0 * 1.5;
            let mut nest = &nests[l];
            while let Some((outer, SubBox { scale, .. })) = nest.within {
                size /= scale.iter().map(|s| f64::from(*s)).product::<f64>();
                nest = &nests[outer];
            }
            size
        };
        let of = |wanted: u32| shares.iter().filter(move |(node, _)| label(**node) == wanted);
        let labels = say(&mut document, json!({"ask": {"field": {"field": "labels", "volume": 0}}}));
        for id in 1..3 {
            assert_eq!(labels["voxels_by_label"][id.to_string()], json!(of(id).count()), "{n}");
            let expected: f64 = of(id).map(|((l, _), share)| share * size(*l)).sum();
            let found = labels["mm3_by_label"][id.to_string()].as_f64().unwrap();
            assert!((found / expected - 1.0).abs() < 1e-9, "{n}: {found}, {expected} expected");
        }
        let said = say(&mut document, json!({"ask": {"field": {"field": "selection", "volume": 0}}}));
        let expected: f64 =
            shares.iter().map(|(node, share)| f64::from(selected(*node)) / 255.0 * share * size(node.0)).sum();
        let found = said["selected_mm3"].as_f64().unwrap();
        assert!((found / expected - 1.0).abs() < 1e-9, "{n}: {found}, {expected} expected");
        assert_eq!(said["nonzero"], json!(shares.keys().filter(|node| selected(**node) > 0).count()), "{n}");
        let said = say(&mut document, json!({"ask": {"field": {"field": "density", "volume": 0}}}));
        let expected: f64 = shares.keys().map(|node| number(&document, *node)).sum();
        assert!((said["sum"].as_f64().unwrap() - expected).abs() < 1e-6, "{n}: {said}, {expected} expected");
    }
}

#[test]
fn small_pieces_go_wherever_they_lie_and_larger_ones_stay() {
    let (fine, nests) = nests().remove(0);
    let size = [1.05, 1.05 / 8.0];
    for (what, is_small) in [
        (
            json!({"voxels": 9}),
            Box::new(|piece: &BTreeSet<Node>| piece.len() < 9) as Box<dyn Fn(&BTreeSet<Node>) -> bool>,
        ),
        (
            json!({"mm3": 2.0}),
            Box::new(|piece: &BTreeSet<Node>| piece.iter().map(|node| size[node.0]).sum::<f64>() < 2.0),
        ),
    ] {
        let mut document = noisy(&nests, 1);
        let pieces = Raster::new(&nests, fine).components(1, |node| shows(number(&document, node)));
        let (small, large): (Vec<_>, Vec<_>) = pieces.into_iter().partition(|piece| is_small(piece));
        assert!(small.len() > 20 && !large.is_empty());
        let said = say(&mut document, json!({"component": {"remove": {"smaller_than": what}}}));
        assert_eq!(said["pieces"], json!(small.len()), "{what}");
        assert_eq!(document.history().undo_names().next_back(), Some("Remove small pieces"));
        assert_eq!(said["voxels_changed"], json!(small.iter().map(BTreeSet::len).sum::<usize>()), "{what}");
        assert!(small.iter().flatten().all(|node| !shows(number(&document, *node))), "{what}");
        assert!(large.iter().flatten().all(|node| shows(number(&document, *node))), "{what}");
        let again = say(&mut document, json!({"component": {"remove": {"smaller_than": what}}}));
        assert_eq!((&again["pieces"], &again["nothing"]), (&json!(0), &json!("No piece is smaller than that.")));
        let at = json!({"component": {"remove": {"smaller_than": what, "at": {"index": [1, 1, 1]}}}});
        assert!(super::maker::run(&mut document, &at.to_string()).unwrap_err().to_string().contains("smaller_than"));
    }
}
