//! Sub-volumes as commands: made, refused, undone, changed, removed, saved, found again after a crash.

use super::boxes::copy_folder;
use super::maker::{labelled, run};
use burin::document::Document;
use burin::volume::{DensityMap, FieldKind, VolumeId, Voxels};
use serde_json::{Value, json};

fn does(document: &mut Document, command: Value) -> Value {
    run(document, &command.to_string()).unwrap_or_else(|error| panic!("{command}: {error}"))
}

fn refusal(document: &mut Document, command: Value) -> String {
    run(document, &command.to_string()).unwrap_err().to_string()
}

fn add(lo: [u32; 3], hi: [u32; 3], scale: impl Into<Value>) -> Value {
    json!({"sub_volume": {"add": {"lo": lo, "hi": hi, "scale": scale.into()}}})
}

/// All texels of every volume.
fn texels(document: &Document) -> Vec<(VolumeId, FieldKind, Vec<u8>)> {
    let state = document.state().unwrap();
    let ids: Vec<VolumeId> = state.scene.volumes.all.keys().copied().collect();
    let field = |id: VolumeId, kind| {
        let field = state.volumes[&id].field(kind);
        (id, kind, field.read(0, [0; 3], field.dims(0)).unwrap())
    };
    ids.into_iter().flat_map(|id| FieldKind::ALL.map(|kind| field(id, kind))).collect()
}

#[test]
fn a_box_gets_its_own_samples_and_says_what_it_may_take() {
    let mut document = labelled();
    let fit =
        does(&mut document, json!({"ask": {"sub_volume_fit": {"lo": [2, 3, 4], "hi": [12, 13, 14], "scale": 4}}}));
    let made = does(&mut document, add([2, 3, 4], [12, 13, 14], 4));
    assert_eq!((&made["volume"], &made["parent"]), (&json!(1), &json!(0)));
    assert_eq!((&made["dims"], &fit["dims"]), (&json!([41, 41, 41]), &json!([41, 41, 41])));
    // Density of 2 bytes, colour of 4, selection of 1, labels of 2.
    assert_eq!((&made["most_bytes"], &fit["most_bytes"]), (&json!(41_u64.pow(3) * 9), &made["most_bytes"]));
    assert_eq!(made["held_bytes"], json!(0), "nothing is stored before it is edited");
    assert_eq!(made["step"], json!("Add sub-volume"));
    // The parent's value = 3x + 5y + 7z comes back anywhere between voxels.
    let voxel = does(&mut document, json!({"ask": {"voxel": {"at": {"index": [16.0, 8.0, 12.0]}, "volume": 1}}}));
    let expected = 3.0 * (2.0 + 16.0 / 4.0) + 5.0 * (3.0 + 8.0 / 4.0) + 7.0 * (4.0 + 12.0 / 4.0);
    assert!((voxel["density"].as_f64().unwrap() - expected).abs() < 1e-4, "{voxel}");
    let listed = does(&mut document, json!({"ask": {"sub_volumes": {}}}));
    assert_eq!(listed["sub_volumes"].as_array().unwrap().len(), 1);
}

#[test]
fn boxes_that_cannot_be_are_refused_with_the_field_that_is_wrong() {
    let mut document = labelled();
    for (command, words) in [
        (add([2, 3, 4], [70, 13, 14], 4), ["hi", "at most 69 along i"]),
        (add([2, 3, 4], [12, 3, 14], 4), ["lo", "below hi"]),
        (add([2, 3, 4], [12, 13, 14], 9), ["scale", "1 to 8"]),
        (add([2, 3, 4], [12, 13, 14], json!([2, 0, 2])), ["scale", "1 to 8"]),
    ] {
        let said = refusal(&mut document, command.clone());
        assert!(words.iter().all(|word| said.contains(word)), "{command}: {said}");
    }
    does(&mut document, add([10, 10, 10], [20, 20, 20], 2));
    let said = refusal(&mut document, add([15, 15, 15], [25, 25, 25], 2));
    assert!(said.contains("apart from sub-volume 1"), "{said}");
    does(&mut document, add([20, 10, 10], [30, 20, 20], 3));
    // One inside another is cut out of that, as finely as was asked.
    let inner = does(&mut document, add([12, 12, 12], [16, 15, 14], 8));
    assert_eq!((&inner["parent"], &inner["scale"], &inner["lo"]), (&json!(1), &json!([4, 4, 4]), &json!([4, 4, 4])));
    let said = refusal(&mut document, json!({"sub_volume": {"remove": {"volume": 0}}}));
    assert!(said.contains("one of the sub-volumes: 1"), "{said}");
}

#[test]
fn what_a_box_may_take_is_told_and_refused_where_it_does_not_fit() {
    use super::boxes::{bytes_of, noisy};
    for (numbers, texel) in
        [(bytes_of as fn(Vec<f64>) -> Voxels, 9), (|n| Voxels::F64(n.iter().map(|v| v / 3.0).collect()), 11)]
    {
        let mut document = noisy(numbers);
        if texel == 11 {
            // Doubles whose steps codes would lose.
            let mut state = document.state().unwrap().clone();
            let volume = state.volumes.get_mut(&VolumeId(0)).unwrap();
            volume.density = volume.density.unedited(DensityMap::FLOAT, &|_| true).unwrap().unwrap();
            document.adopt(state);
        }
        let fit = |document: &mut Document, volume: u32, hi: [u32; 3], scale: Value| {
            does(
                document,
                json!({"ask": {"sub_volume_fit": {"volume": volume, "lo": [0, 0, 0], "hi": hi, "scale": scale}}}),
            )
        };
        let said = fit(&mut document, 0, [10, 9, 8], json!([8, 1, 3]));
        assert_eq!(said["most_bytes"], json!(81 * 10 * 25 * texel), "{said}");
        let said = fit(&mut document, 0, [39, 35, 33], json!(8));
        assert_eq!(said["most_bytes"], json!(313_u64 * 281 * 265 * texel), "{said}");
        assert!(said["available_bytes"].is_null() || said["available_bytes"].as_u64().unwrap() > 1 << 20);
        does(&mut document, json!({"sub_volume": {"add": {"lo": [0, 0, 0], "hi": [39, 35, 33], "scale": 8}}}));
        let before = texels_of_first(&document);
        // Eight times as fine again: a hundred gigabytes.
        let inner = json!({"volume": 1, "lo": [0, 0, 0], "hi": [311, 280, 264], "scale": 8});
        for command in [json!({"sub_volume": {"add": inner}}), json!({"ask": {"sub_volume_fit": inner}})] {
            let said = refusal(&mut document, command.clone());
            let words = ["lo, hi, scale", "samples, up to", "MB of memory that are free", "a smaller box or scale"];
            assert!(words.iter().all(|word| said.contains(word)), "{command}: {said}");
        }
        does(
            &mut document,
            json!({"sub_volume": {"add": {"volume": 1, "lo": [0, 0, 0], "hi": [2, 3, 4], "scale": 8}}}),
        );
        let said = refusal(&mut document, json!({"sub_volume": {"set": {"volume": 2, "hi": [311, 280, 264]}}}));
        assert!(said.contains("a smaller box or scale"), "{said}");
        assert!(texels_of_first(&document) == before);
    }
}

fn texels_of_first(document: &Document) -> Vec<u8> {
    let density = &document.state().unwrap().volumes[&VolumeId(0)].density;
    density.read(0, [0; 3], density.dims(0)).unwrap()
}

#[test]
fn boxes_that_are_no_boxes_are_refused_by_what_is_wrong_with_them() {
    let mut document = labelled();
    let whole =
        |lo: Value, hi: Value, scale: Value| json!({"sub_volume": {"add": {"lo": lo, "hi": hi, "scale": scale}}});
    // Of no extent, turned about, outside, not whole, not of this world.
    for (lo, hi, scale, words) in [
        (json!([2, 3, 4]), json!([2, 3, 4]), json!(2), "below hi"),
        (json!([2, 3, 4]), json!([12, 3, 14]), json!(2), "below hi"),
        (json!([12, 13, 14]), json!([2, 3, 4]), json!(2), "below hi"),
        (json!([69, 39, 32]), json!([70, 40, 33]), json!(2), "at most 69 along i"),
        (json!([0, 0, 0]), json!([69, 40, 32]), json!(2), "at most 39 along j"),
        (json!([0, 0, 0]), json!([u32::MAX, 4, 4]), json!(2), "at most 69 along i"),
        (json!([2, 3, 4]), json!([12, 13, 14]), json!(0), "1 to 8 samples"),
        (json!([2, 3, 4]), json!([12, 13, 14]), json!(9), "1 to 8 samples"),
        (json!([2, 3, 4]), json!([12, 13, 14]), json!([1, 8, u32::MAX]), "1 to 8 samples"),
    ] {
        let command = whole(lo, hi, scale);
        let said = refusal(&mut document, command.clone());
        assert!(said.contains(words), "{command}: {said}");
    }
    for (lo, hi, scale, words) in [
        (json!([-1, 3, 4]), json!([12, 13, 14]), json!(2), "u32"),
        (json!([1.5, 3, 4]), json!([12, 13, 14]), json!(2), "u32"),
        (json!([null, 3, 4]), json!([12, 13, 14]), json!(2), "u32"),
        (json!([3, 4]), json!([12, 13, 14]), json!(2), "array of length 3"),
        (json!([2, 3, 4]), json!([12, 13, 14]), json!(2.5), "a whole number from 1 to 8"),
        (json!([2, 3, 4]), json!([12, 13, 14]), json!([2, 2]), "a whole number from 1 to 8"),
        (json!([2, 3, 4]), json!([12, 13, 14]), json!(-2), "a whole number from 1 to 8"),
    ] {
        let command = whole(lo, hi, scale).to_string();
        let said = serde_json::from_str::<burin::document::Command>(&command).unwrap_err().to_string();
        assert!(said.contains(words), "{command}: {said}");
    }
    assert_eq!(document.state().unwrap().volumes.len(), 1);
    // Faces, edges and corners may touch; one voxel is enough, and so is all of a volume.
    for (lo, hi) in [
        ([10, 10, 10], [11, 11, 11]),
        ([11, 10, 10], [12, 11, 11]),
        ([11, 11, 10], [12, 12, 11]),
        ([9, 9, 9], [10, 10, 10]),
    ] {
        does(&mut document, add(lo, hi, 8));
    }
    does(&mut document, add([0, 0, 0], [69, 39, 32], 1));
    let listed = does(&mut document, json!({"ask": {"sub_volumes": {"volume": 5}}}));
    assert_eq!(listed["sub_volumes"].as_array().unwrap().len(), 4, "all of them in the last one");
}

#[test]
fn undo_takes_a_box_with_its_content_and_redo_brings_both() {
    let mut document = labelled();
    let before = texels(&document);
    does(&mut document, add([0, 0, 0], [40, 20, 12], 2));
    does(&mut document, json!({"selection": {"from_label": {"label": 1, "volume": 1}}}));
    let selected = texels(&document);
    assert!(
        selected
            .iter()
            .any(|(id, kind, texels)| { id.0 == 1 && *kind == FieldKind::Selection && texels.iter().any(|t| *t != 0) })
    );
    does(&mut document, json!({"sub_volume": {"remove": {"volume": 1}}}));
    assert!(texels(&document) == before);
    does(&mut document, json!({"history": {"undo": {}}}));
    assert!(texels(&document) == selected);
    does(&mut document, json!({"history": {"undo": {"steps": 2}}}));
    assert!(texels(&document) == before);
    assert_eq!(document.state().unwrap().volumes.len(), 1, "nor is anything left of what it was computed from");
    does(&mut document, json!({"history": {"redo": {"steps": 2}}}));
    assert!(texels(&document) == selected);
}

#[test]
fn a_box_grows_without_loss_and_shrinks_only_when_told_to() {
    let mut document = labelled();
    does(&mut document, add([4, 4, 0], [40, 20, 12], 2));
    does(&mut document, json!({"selection": {"from_label": {"label": 1, "volume": 1}}}));
    let before = texels(&document);
    let count = |document: &mut Document| {
        does(document, json!({"ask": {"field": {"field": "selection", "volume": 1}}}))["nonzero"].as_u64().unwrap()
    };
    let selected = count(&mut document);
    does(&mut document, json!({"sub_volume": {"set": {"volume": 1, "lo": [2, 0, 0], "hi": [50, 30, 16]}}}));
    assert_eq!(count(&mut document), selected);
    does(&mut document, json!({"history": {"undo": {}}}));
    assert!(texels(&document) == before);
    does(&mut document, json!({"history": {"redo": {}}}));
    assert_eq!(count(&mut document), selected);
    let smaller = |discard: bool| json!({"sub_volume": {"set": {"volume": 1, "lo": [4, 4, 0], "hi": [12, 12, 8], "discard": discard}}});
    let said = refusal(&mut document, smaller(false));
    assert!(said.contains("edited samples outside") && said.contains("discard"), "{said}");
    does(&mut document, smaller(true));
    assert!(count(&mut document) < selected);
}

#[test]
fn what_was_painted_on_the_parent_later_changes_of_a_box_its_faces_alone() {
    let mut document = labelled();
    does(&mut document, add([0, 0, 0], [40, 20, 12], 2));
    // What is not seen is not painted with what it is cut out of.
    does(&mut document, json!({"volume": {"set": {"volume": 1, "visible": false}}}));
    let (all, before) = (texels(&document), inside(&document));
    does(&mut document, json!({"component": {"select": {"volume": 0, "matter": {"range": [0, 250]}, "how": "add"}}}));
    assert!(inside(&document) == before, "half a voxel from the faces on it is as it was");
    // On a face a sample at a voxel's centre is that voxel.
    let state = document.state().unwrap();
    let (parent, fine) = (&state.volumes[&VolumeId(0)].selection, &state.volumes[&VolumeId(1)].selection);
    for (x, y) in [(0, 0), (3, 0), (13, 5), (38, 19), (8, 2)] {
        assert_eq!(fine.texel([2 * x, 2 * y, 0]).unwrap(), parent.texel([x, y, 0]).unwrap(), "{x} {y}");
    }
    assert!((0..40).any(|x| fine.texel([2 * x, 0, 0]).unwrap()[0] == 255));
    does(&mut document, json!({"history": {"undo": {}}}));
    assert!(texels(&document) == all);
}

/// The samples of the first box that are no nearer to its faces than half a voxel.
fn inside(document: &Document) -> Vec<Vec<u8>> {
    let volume = &document.state().unwrap().volumes[&VolumeId(1)];
    FieldKind::ALL.map(|kind| volume.field(kind).read(0, [1; 3], volume.grid().dims.map(|d| d - 2)).unwrap()).into()
}

#[test]
fn what_is_told_of_a_box_is_of_its_own_samples_as_they_are_now() {
    use super::boxes::{bytes_of, noisy, paint};
    let mut document = noisy(bytes_of);
    // Half of the box is even.
    paint(&mut document, 0, FieldKind::Density, |[x, ..]| (x < 16).then_some(90.0));
    let look =
        json!({"mode": "dvr", "transfer": {"colour": [[0, [1, 1, 1]]], "opacity": [[0, 0], [1, 1]], "unit_mm": 1}});
    does(&mut document, add([2, 2, 2], [12, 10, 9], 3));
    does(&mut document, json!({"volume": {"set": {"volume": 1, "look": look}}}));
    let told = |document: &mut Document| {
        let said = does(document, json!({"ask": {"volume": {"volume": 1}}}));
        ["min", "max", "sum"].map(|name| said[name].as_f64().unwrap())
    };
    let expected = |document: &Document| {
        let density = &document.state().unwrap().volumes[&VolumeId(1)].density;
        let all: Vec<f64> = crate::common::volumes::each(density.dims(0), |v| density.number(v).unwrap().to_f64());
        let fold = |f: fn(f64, f64) -> f64| all.iter().copied().reduce(f).unwrap();
        [fold(f64::min), fold(f64::max), all.iter().sum()]
    };
    let near = |a: [f64; 3], b: [f64; 3]| (0..3).all(|i| (a[i] - b[i]).abs() <= 1e-9 * b[i].abs());
    assert!(document.state().unwrap().volumes[&VolumeId(1)].density.known_measures().is_none(), "nobody has asked");
    let even = told(&mut document);
    assert_eq!(even[..2], [90.0; 2], "as even as its parent is there, which goes from 0 to 200");
    assert!(near(even, expected(&document)), "{even:?} {:?}", expected(&document));
    // What is edited counts.
    paint(&mut document, 1, FieldKind::Density, |[x, y, z]| (x < 9 && y < 5 && z < 7).then_some(150.0));
    assert!(document.state().unwrap().volumes[&VolumeId(1)].density.known_measures().is_none());
    let edited = told(&mut document);
    assert_eq!(edited[..2], [90.0, 150.0]);
    assert!(near(edited, expected(&document)), "{edited:?} {:?}", expected(&document));
    let reset = |document: &mut Document, volume: u32| {
        let said = does(document, json!({"transfer": {"reset": {"volume": volume}}}));
        [0, 1].map(|i| said["domain"][i].as_f64().unwrap())
    };
    let [lo, hi] = reset(&mut document, 1);
    assert!((89.0..=150.0).contains(&lo) && (140.0..=151.0).contains(&hi), "{lo} to {hi}");
    let [lo, hi] = reset(&mut document, 0);
    assert!(hi > 180.0, "{lo} to {hi}: its parent's own");
}

#[test]
fn projects_and_journals_bring_boxes_back_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.burin");
    let mut document = labelled();
    does(&mut document, json!({"selection": {"from_label": {"label": 2, "volume": 0}}}));
    does(&mut document, add([0, 0, 0], [40, 20, 12], 2));
    // After it was made the parent's selection goes; the box still has it, but for what was taken away there.
    does(&mut document, json!({"selection": {"clear": {"volume": 0}}}));
    does(&mut document, json!({"project": {"save": {"path": path}}}));
    let saved = texels(&document);
    let open = json!({"project": {"open": {"path": path}}});
    drop(document);
    let mut document = Document::new();
    does(&mut document, open.clone());
    assert!(texels(&document) == saved, "saved");
    does(&mut document, json!({"selection": {"clear": {"volume": 1}}}));
    does(&mut document, add([42, 4, 4], [60, 20, 20], 3));
    does(&mut document, json!({"selection": {"from_label": {"label": 1, "volume": 2}}}));
    does(&mut document, json!({"sub_volume": {"set": {"volume": 1, "hi": [41, 22, 14]}}}));
    let changed = texels(&document);
    assert!(changed != saved);
    // As if the program had been killed: nothing is saved, the journal holds the rest.
    std::mem::forget(std::mem::replace(&mut document, Document::new()));
    std::fs::remove_file(path.join("lock")).ok();
    let copy = folder.path().join("copy.burin");
    copy_folder(&path, &copy);
    let mut document = Document::new();
    does(&mut document, json!({"project": {"open": {"path": copy}}}));
    assert!(texels(&document) == changed, "from the journal");
    let bytes = does(&mut document, json!({"project": {"save": {}}}))["saved"]["bytes_written"].as_u64().unwrap();
    // The samples of the first box alone are 83 × 45 × 29 of 2 bytes, and more when it grew.
    assert!(bytes < 2_000_000, "{bytes} bytes: nothing is stored that is not edited");
    drop(document);
    let mut document = Document::new();
    does(&mut document, json!({"project": {"open": {"path": copy}}}));
    assert!(texels(&document) == changed, "saved again");
}
