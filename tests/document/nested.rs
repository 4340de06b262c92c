//! Boxes in boxes: made from the inside out or the other way, let out when an outer one goes, moved about each other; in one step or in
//! groups of steps, saved, and lost and found.

use super::boxes::*;
use crate::common::volumes::each;
use burin::document::Document;
use burin::volume::{FieldKind, VolumeId};
use serde_json::{Value, json};

const INNER: ([u32; 3], [u32; 3]) = ([10, 9, 8], [16, 14, 13]);
const OUTER: ([u32; 3], [u32; 3]) = ([6, 5, 4], [22, 20, 18]);

fn inner(scale: u32) -> Value {
    add(INNER.0, INNER.1, scale)
}

fn outer(scale: u32) -> Value {
    add(OUTER.0, OUTER.1, scale)
}

fn begin() -> Value {
    json!({"history": {"begin": {}}})
}

fn end() -> Value {
    json!({"history": {"end": {}}})
}

fn remove(volume: u32, inner: bool) -> Value {
    json!({"sub_volume": {"remove": {"volume": volume, "inner": inner}}})
}

fn set(volume: u32, lo: [u32; 3], hi: [u32; 3]) -> Value {
    json!({"sub_volume": {"set": {"volume": volume, "lo": lo, "hi": hi}}})
}

fn select(label: u16, volume: u32) -> Value {
    json!({"selection": {"from_label": {"label": label, "volume": volume}}})
}

/// Its last step taken back and done again.
fn undone_and_done_again(document: &mut Document, before: &[(String, Vec<u8>)]) {
    let after = everything(document);
    undo(document, 1);
    same(&everything(document), before, "undone");
    redo(document, 1);
    same(&everything(document), &after, "done again");
}

/// Noise with things painted on it, also where boxes come to lie.
fn painted() -> Document {
    let mut document = noisy(bytes_of);
    // Not where texels are painted in boxes: those that equal what was there are no edits.
    paint_all(&mut document, 0, [18.0, 15.0, 14.0], 4.0);
    for id in [1, 2] {
        does(&mut document, json!({"segment": {"set": {"id": id, "name": format!("of {id}")}}}));
    }
    document
}

/// The samples of a volume that are edited, by kind: where, and their texels.
fn edited(document: &Document, volume: u32) -> Vec<Vec<(usize, Vec<u8>)>> {
    let volume = &document.state().unwrap().volumes[&VolumeId(volume)];
    let of_kind = |kind| {
        let field = volume.field(kind);
        let (dims, bytes) = (field.dims(0), field.format().bytes());
        let mut all = Vec::new();
        for (index, brick) in field.edits() {
            let (base, origin) = (field.base_brick(index).unwrap(), index.origin());
            for at in each(field.valid(0, index), |at| at) {
                let (now, was) = (brick.texel(at, bytes), base.texel(at, bytes));
                let [x, y, z] = std::array::from_fn(|a| origin[a] + at[a]);
                if now != was {
                    all.push(((x + dims[0] * (y + dims[1] * z)) as usize, now[..bytes].to_vec()));
                }
            }
        }
        all
    };
    FieldKind::ALL.map(of_kind).into()
}

/// Fails where a sample of these is another one now.
fn kept(document: &Document, volume: u32, before: &[Vec<(usize, Vec<u8>)>], when: &str) {
    let volume = &document.state().unwrap().volumes[&VolumeId(volume)];
    for (kind, before) in FieldKind::ALL.into_iter().zip(before) {
        let field = volume.field(kind);
        let bytes = field.format().bytes();
        let now = field.read(0, [0; 3], field.dims(0)).unwrap();
        assert!(before.len() > 500, "{kind:?}: {}", before.len());
        for (i, texel) in before {
            assert_eq!(&now[i * bytes..(i + 1) * bytes], texel, "{when}: {kind:?} at {i}");
        }
    }
}

#[test]
fn a_box_around_another_leaves_what_is_edited_there_and_all_is_as_if_it_had_been_first() {
    let mut document = painted();
    does(&mut document, inner(4));
    paint_all(&mut document, 1, [13.0, 11.0, 9.0], 7.0);
    let (before, own) = (everything(&document), edited(&document, 1));
    let said = does(&mut document, outer(2));
    assert_eq!((&said["volume"], &said["parent"], &said["around"]), (&json!(2), &json!(0), &json!([1])), "{said}");
    let listed = does(&mut document, json!({"ask": {"sub_volumes": {}}}));
    let of = &listed["sub_volumes"][0];
    assert_eq!((&of["parent"], &of["lo"], &of["hi"]), (&json!(2), &json!([8, 8, 8]), &json!([20, 18, 18])), "{of}");
    assert_eq!((&of["scale"], &of["dims"]), (&json!([2, 2, 2]), &json!([25, 21, 21])), "the same samples");
    kept(&document, 1, &own, "around it");
    undone_and_done_again(&mut document, &before);

    // Made first.
    let mut other = painted();
    does(&mut other, outer(2));
    does(&mut other, inner(4));
    paint_all(&mut other, 2, [13.0, 11.0, 9.0], 7.0);
    for kind in FieldKind::ALL {
        assert!(texels(&document, 1, kind) == texels(&other, 2, kind), "{kind:?} of the inner one");
        assert!(texels(&document, 2, kind) == texels(&other, 1, kind), "{kind:?} of the outer one");
    }
}

#[test]
fn boxes_in_one_that_goes_keep_what_is_edited_in_them_and_lie_in_what_it_lay_in() {
    let mut document = painted();
    does(&mut document, outer(2));
    does(&mut document, inner(4));
    does(&mut document, add([11, 10, 9], [14, 13, 12], 8));
    assert_eq!(document.state().unwrap().scene.volumes.all[&VolumeId(3)].sub_volume.unwrap().parent, VolumeId(2));
    paint_all(&mut document, 1, [29.0, 26.0, 24.0], 6.0);
    paint_all(&mut document, 2, [13.0, 11.0, 9.0], 7.0);
    paint_all(&mut document, 3, [13.0, 11.0, 9.0], 8.0);
    let (before, own) = (everything(&document), [edited(&document, 2), edited(&document, 3)]);
    does(&mut document, remove(1, false));
    let listed = does(&mut document, json!({"ask": {"sub_volumes": {}}}));
    let [middle, least] = [0, 1].map(|i| &listed["sub_volumes"][i]);
    assert_eq!((&middle["parent"], &middle["lo"], &middle["scale"]), (&json!(0), &json!(INNER.0), &json!([4, 4, 4])));
    assert_eq!((&least["parent"], &least["scale"]), (&json!(2), &json!([2, 2, 2])));
    kept(&document, 2, &own[0], "let out");
    kept(&document, 3, &own[1], "with it");
    undone_and_done_again(&mut document, &before);
    // As if the outer one had never been.
    let mut other = painted();
    does(&mut other, inner(4));
    paint_all(&mut other, 1, [13.0, 11.0, 9.0], 7.0);
    for kind in FieldKind::ALL {
        assert!(texels(&document, 2, kind) == texels(&other, 1, kind), "{kind:?} of the middle one");
    }
    undo(&mut document, 1);
    does(&mut document, remove(1, true));
    assert_eq!(document.state().unwrap().volumes.len(), 1, "all of them");
    undo(&mut document, 1);
    same(&everything(&document), &before, "all of them undone");
}

#[test]
fn what_has_changed_around_a_box_since_it_was_made_does_not_change_it_later() {
    let mut document = painted();
    does(&mut document, inner(4));
    let own = texels(&document, 1, FieldKind::Selection);
    let labels = texels(&document, 1, FieldKind::Labels);
    assert!(own.iter().any(|s| *s > 0));
    paint(&mut document, 0, FieldKind::Selection, |_| Some(0.0));
    // Half a voxel from the faces on.
    let deep = |all: &[u8], bytes: usize| -> Vec<u8> {
        let place = |i: usize| [i % 25, i / 25 % 21, i / 525];
        let is_deep = |i: usize| place(i).into_iter().zip([25, 21, 21]).all(|(v, n)| v >= 2 && v + 2 < n);
        all.chunks_exact(bytes).enumerate().filter(|(i, _)| is_deep(*i)).flat_map(|(_, t)| t.to_vec()).collect()
    };
    let expected = deep(&own, 1);
    assert!(expected.iter().any(|s| *s > 0) && deep(&texels(&document, 1, FieldKind::Selection), 1) == expected);
    does(&mut document, outer(2));
    assert!(deep(&texels(&document, 1, FieldKind::Selection), 1) == expected, "nor does a box around it");
    assert!(texels(&document, 2, FieldKind::Selection).iter().all(|s| *s == 0), "which is as its parent is now");
    does(&mut document, remove(2, false));
    assert!(deep(&texels(&document, 1, FieldKind::Selection), 1) == expected, "nor that this one goes");
    does(&mut document, set(1, [9, 8, 7], [18, 15, 14]));
    let grown = &document.state().unwrap().volumes[&VolumeId(1)];
    let now = grown.selection.read(0, [4, 4, 4], [25, 21, 21]).unwrap();
    assert!(deep(&now, 1) == expected, "nor that it grows");
    assert!(grown.labels.read(0, [4, 4, 4], [25, 21, 21]).unwrap() == labels);
}

#[test]
fn faces_move_about_inner_boxes_and_over_others() {
    let mut document = painted();
    does(&mut document, outer(2));
    does(&mut document, inner(4));
    does(&mut document, add([24, 5, 5], [28, 9, 9], 4));
    paint_all(&mut document, 2, [13.0, 11.0, 9.0], 7.0);
    let (before, own) = (everything(&document), edited(&document, 2));
    let parent =
        |document: &Document, id: u32| document.state().unwrap().scene.volumes.all[&VolumeId(id)].sub_volume.unwrap();
    // Larger: the inner one has the same samples at other numbers; the one beside it comes to lie in it.
    let said = does(&mut document, set(1, [2, 3, 4], [30, 20, 18]));
    assert_eq!(said["around"], json!([3]), "{said}");
    kept(&document, 2, &own, "in a larger one");
    assert_eq!((parent(&document, 2).of.lo, parent(&document, 3).parent), ([16, 12, 8], VolumeId(1)));
    // Apart from both: they lie in the volume again.
    does(&mut document, set(1, [2, 21, 4], [30, 30, 18]));
    kept(&document, 2, &own, "beside it");
    for id in [2, 3] {
        assert_eq!(parent(&document, id).parent, VolumeId(0));
    }
    let after = everything(&document);
    undo(&mut document, 2);
    same(&everything(&document), &before, "undone");
    redo(&mut document, 2);
    same(&everything(&document), &after, "done again");
    undo(&mut document, 2);
    // Divided otherwise.
    does(&mut document, json!({"sub_volume": {"set": {"volume": 1, "scale": 4}}}));
    assert_eq!((parent(&document, 2).of.lo, parent(&document, 2).of.scale), ([16, 16, 16], [1; 3]));
    kept(&document, 2, &own, "in a finer one");
    undo(&mut document, 1);
    same(&everything(&document), &before, "undone");
}

#[test]
fn boxes_that_cannot_be_nested_are_refused_and_nothing_changes() {
    let mut document = painted();
    does(&mut document, inner(4));
    let before = everything(&document);
    for (command, words) in [
        (outer(3), ["scale", "divides [4, 4, 4]"]),
        (outer(8), ["scale", "divides [4, 4, 4]"]),
        (inner(4), ["lo, hi", "sub_volume.set divides more finely"]),
        (inner(8), ["lo, hi", "sub_volume.set divides more finely"]),
        (add([11, 10, 9], [13, 12, 11], 6), ["scale", "multiple of [4, 4, 4]"]),
        (add([12, 9, 8], [20, 14, 13], 2), ["lo, hi", "inside it or around it"]),
    ] {
        let said = refusal(&mut document, command.clone());
        assert!(words.iter().all(|word| said.contains(word)), "{command}: {said}");
    }
    same(&everything(&document), &before, "refused");
    // Two at once, one of which does not fit.
    does(&mut document, add([18, 9, 8], [21, 14, 13], 3));
    let before = everything(&document);
    assert!(refusal(&mut document, outer(2)).contains("divides [3, 3, 3]"));
    does(&mut document, outer(1));
    undo(&mut document, 1);
    same(&everything(&document), &before, "undone");
    does(&mut document, remove(2, false));
    does(&mut document, outer(2));
    let before = everything(&document);
    for (command, words) in [
        (set(3, [6, 5, 4], [14, 20, 18]), ["lo, hi", "holds all of sub-volume 1"]),
        (json!({"sub_volume": {"set": {"volume": 3, "scale": 3}}}), ["scale", "1 to 8 times as fine"]),
        (json!({"sub_volume": {"set": {"volume": 3, "scale": 8}}}), ["scale", "1 to 8 times as fine"]),
    ] {
        let said = refusal(&mut document, command.clone());
        assert!(words.iter().all(|word| said.contains(word)), "{command}: {said}");
    }
    same(&everything(&document), &before, "refused");
    // Faces between the outer one's parent's voxels: it cannot be let out.
    does(&mut document, json!({"sub_volume": {"add": {"volume": 3, "lo": [25, 3, 3], "hi": [29, 7, 7], "scale": 2}}}));
    let before = everything(&document);
    let said = refusal(&mut document, remove(3, false));
    assert!(said.contains("sub-volume 4") && said.contains("\"inner\": true"), "{said}");
    same(&everything(&document), &before, "refused");
    does(&mut document, remove(3, true));
    assert_eq!(document.state().unwrap().volumes.len(), 1);
}

#[test]
fn groups_of_changes_of_boxes_are_undone_whole_and_a_crash_within_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.burin");
    let mut document = painted();
    does(&mut document, inner(4));
    paint_all(&mut document, 1, [13.0, 11.0, 9.0], 7.0);
    does(&mut document, json!({"project": {"save": {"path": path}}}));
    let before = everything(&document);
    let groups: [Vec<Value>; 7] = [
        // Painted, then resized, then painted.
        vec![select(1, 1), set(1, [9, 8, 7], [18, 15, 14]), select(2, 1), set(1, [8, 8, 7], [18, 15, 14])],
        // Made and resized.
        vec![outer(2), select(1, 2), set(2, [5, 5, 4], [23, 20, 18]), select(2, 2), select(2, 1)],
        // Resized and removed, or made, resized and removed.
        vec![set(1, [9, 8, 7], [18, 15, 14]), select(1, 1), remove(1, false)],
        vec![outer(2), set(2, [5, 5, 4], [23, 20, 18]), select(1, 1), remove(2, false), select(2, 1)],
        vec![outer(2), select(2, 2), set(2, [20, 5, 4], [24, 20, 18]).tap_discard(), remove(2, true)],
        // Baked and removed with what is in it.
        vec![select(1, 1), outer(2), json!({"sub_volume": {"bake": {"volume": 1, "remove": true}}}), remove(2, true)],
        vec![set(1, [9, 8, 7], [18, 15, 14]), set(1, INNER.0, INNER.1), select(1, 1)],
    ];
    for (at, group) in groups.into_iter().enumerate() {
        does(&mut document, begin());
        let last = group.len() - 1;
        for (n, command) in group.into_iter().enumerate() {
            does(&mut document, command.clone());
            if at < 2 || n == last {
                let copy = folder.path().join(format!("found-{at}.burin"));
                std::fs::remove_dir_all(&copy).ok();
                copy_folder(&path, &copy);
                let when = format!("group {at}, lost after {command}");
                same(&everything(&opened(&copy)), &everything(&document), &when);
            }
        }
        does(&mut document, end());
        let after = everything(&document);
        for round in 0..if at < 2 { 2 } else { 1 } {
            undo(&mut document, 1);
            same(&everything(&document), &before, &format!("group {at} undone, {round}"));
            let copy = folder.path().join("undone.burin");
            std::fs::remove_dir_all(&copy).ok();
            copy_folder(&path, &copy);
            same(&everything(&opened(&copy)), &before, &format!("group {at} undone and lost"));
            redo(&mut document, 1);
            same(&everything(&document), &after, &format!("group {at} done again, {round}"));
        }
        let texels = if at < 2 { every_texel(&document) } else { Vec::new() };
        if at < 2 {
            undo(&mut document, 1);
            redo(&mut document, 1);
            same(&every_texel(&document), &texels, &format!("group {at}, all texels"));
        }
        undo(&mut document, 1);
        // A group that is given up.
        does(&mut document, begin());
        does(&mut document, outer(2));
        does(&mut document, set(1, [10, 9, 8], [30, 19, 23]));
        does(&mut document, json!({"history": {"cancel": {}}}));
        same(&everything(&document), &before, "given up");
    }
}

trait Discards {
    fn tap_discard(self) -> Self;
}

impl Discards for Value {
    /// A `sub_volume.set` that may lose edits.
    fn tap_discard(mut self) -> Self {
        self["sub_volume"]["set"]["discard"] = json!(true);
        self
    }
}

#[test]
fn nested_boxes_come_back_from_projects_and_journals() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.burin");
    let mut document = painted();
    does(&mut document, inner(4));
    paint_all(&mut document, 1, [13.0, 11.0, 9.0], 7.0);
    does(&mut document, add([11, 10, 9], [14, 13, 12], 8));
    paint_all(&mut document, 2, [13.0, 11.0, 9.0], 8.0);
    does(&mut document, json!({"project": {"save": {"path": path}}}));
    // Around both, in the journal alone; and around that.
    does(&mut document, outer(2));
    does(&mut document, add([4, 4, 3], [30, 22, 20], 1));
    does(&mut document, select(1, 2));
    let there = every_texel(&document);
    let (found, copy) = killed(document, &path);
    same(&every_texel(&found), &there, "lost");
    drop(found);
    let mut document = opened(&copy);
    same(&every_texel(&document), &there, "lost and left");
    does(&mut document, json!({"project": {"save": {}}}));
    drop(document);
    let mut document = opened(&copy);
    same(&every_texel(&document), &there, "saved");
    does(&mut document, remove(3, false));
    let without = every_texel(&document);
    let (mut found, copy) = killed(document, &copy);
    same(&every_texel(&found), &without, "lost after the outer one went");
    does(&mut found, json!({"project": {"save": {}}}));
    drop(found);
    same(&every_texel(&opened(&copy)), &without, "saved without it");
}
