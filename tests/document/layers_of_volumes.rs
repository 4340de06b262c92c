//! How fields are shown, of one volume or of all: commands, pictures, the past of looks, what is saved.

use super::maker::{run, write_nrrd};
use burin::document::{Document, Layer, ViewName};
use burin::math::DVec3;
use burin::volume::{FieldKind, Grid, VolumeId};
use serde_json::{Value, json};
use std::path::Path;

fn say(document: &mut Document, line: Value) -> Value {
    run(document, &line.to_string()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

/// Two volumes of matter beside each other.
fn two(dir: &Path) -> Document {
    let file = |name: &str, at: f64| {
        let path = dir.join(name);
        let grid = Grid::aligned([20, 16, 12], DVec3::ONE, DVec3::new(at, 0.0, 0.0));
        write_nrrd(&path, &grid, |[x, y, z]| {
            let inside = (3..17).contains(&x) && (3..13).contains(&y) && (2..10).contains(&z);
            if inside { 80.0 + (x % 5) as f32 } else { 0.0 }
        });
        path
    };
    let mut document = Document::new();
    document.keep_unsaved_in(dir.join("unsaved"));
    say(&mut document, json!({"volume": {"open": {"path": file("a.nrrd", 0.0)}}}));
    say(&mut document, json!({"volume": {"add": {"path": file("b.nrrd", 21.0)}}}));
    document
}

/// Visible and opacity of a field of both volumes.
fn shown(document: &Document, field: FieldKind) -> [(bool, f32); 2] {
    let scene = &document.state().unwrap().scene;
    [0, 1].map(|id| scene.layer_of(VolumeId(id), field)).map(|layer| (layer.visible, layer.opacity))
}

fn layer(document: &mut Document, change: Value) -> Value {
    say(document, json!({"view": {"layer": change}}))
}

#[test]
fn a_volume_that_shows_a_field_in_its_own_way_leaves_the_others_and_can_show_it_as_they_do_again() {
    let dir = tempfile::tempdir().unwrap();
    let mut document = two(dir.path());
    let labels = FieldKind::Labels;
    assert_eq!(shown(&document, labels), [(true, 0.5); 2]);
    // Of all volumes, as ever.
    layer(&mut document, json!({"field": "labels", "visible": false, "opacity": 0.25}));
    assert_eq!(shown(&document, labels), [(false, 0.25); 2]);
    // Of one; what is left out stays.
    let answer = layer(&mut document, json!({"field": "labels", "visible": true, "volume": 1}));
    assert_eq!(shown(&document, labels), [(false, 0.25), (true, 0.25)]);
    assert_eq!(answer["layers"][3], json!({"field": "labels", "visible": true, "opacity": 0.25}));
    assert_eq!(answer["step"], Value::Null);
    layer(&mut document, json!({"field": "labels", "opacity": 0.75}));
    assert_eq!(shown(&document, labels), [(false, 0.75), (true, 0.25)], "the active one has no way of its own");
    assert_eq!(shown(&document, FieldKind::Colour), [(true, 1.0); 2]);
    // One field beside another.
    layer(&mut document, json!({"field": "colour", "opacity": 0.75, "volume": 1}));
    assert_eq!(shown(&document, labels), [(false, 0.75), (true, 0.25)]);
    layer(&mut document, json!({"field": "labels", "opacity": 0.25, "volume": 1}));
    assert_eq!(shown(&document, FieldKind::Colour), [(true, 1.0), (true, 0.75)]);
    layer(&mut document, json!({"field": "colour", "shared": true, "volume": 1}));
    // The active one's own way is meant where it has one.
    say(&mut document, json!({"volume": {"set": {"volume": 1, "active": true}}}));
    layer(&mut document, json!({"field": "labels", "opacity": 0.5}));
    assert_eq!(shown(&document, labels), [(false, 0.75), (true, 0.5)]);
    // The past of looks, saved, opened.
    say(&mut document, json!({"view": {"back": {"of": "looks"}}}));
    assert_eq!(shown(&document, labels), [(false, 0.75), (true, 0.25)]);
    say(&mut document, json!({"view": {"forward": {"of": "looks"}}}));
    let path = dir.path().join("p.burin");
    say(&mut document, json!({"project": {"save": {"path": path}}}));
    layer(&mut document, json!({"field": "colour", "opacity": 0.5, "volume": 0}));
    drop(document);
    let mut document = Document::new();
    say(&mut document, json!({"project": {"open": {"path": path}}}));
    assert_eq!(shown(&document, labels), [(false, 0.75), (true, 0.5)]);
    assert_eq!(shown(&document, FieldKind::Colour), [(true, 0.5), (true, 1.0)], "what came after the save too");
    layer(&mut document, json!({"field": "labels", "shared": true, "volume": 1}));
    assert_eq!(shown(&document, labels), [(false, 0.75); 2]);
    layer(&mut document, json!({"field": "labels", "visible": true}));
    assert_eq!(shown(&document, labels), [(true, 0.75); 2], "it follows again");
    for (wrong, needle) in [
        (json!({"field": "labels", "visible": true, "volume": 7}), "1 (b.nrrd)"),
        (json!({"field": "labels", "visible": true, "shared": true}), "shared"),
        (json!({"field": "labels", "opacity": 2, "volume": 1}), "opacity"),
        (json!({"field": "density", "opacity": 0.5, "volume": 1}), "opacity"),
    ] {
        let said = run(&mut document, &json!({"view": {"layer": wrong}}).to_string()).unwrap_err().to_string();
        assert!(said.contains(needle), "{wrong}: {said}");
    }
    assert_eq!(shown(&document, labels), [(true, 0.75); 2]);
}

fn pictures(document: &mut Document) -> Vec<Vec<[f32; 4]>> {
    [ViewName::ThreeD, ViewName::Axial]
        .map(|view| document.picture(view, [60, 40], None).unwrap().colour.clone())
        .to_vec()
}

/// Whether pictures are the same but for rounding.
fn same(a: &[Vec<[f32; 4]>], b: &[Vec<[f32; 4]>]) -> bool {
    let close = |(p, q): (&[f32; 4], &[f32; 4])| p.iter().zip(q).all(|(p, q)| (p - q).abs() < 1.0 / 255.0);
    a.iter().zip(b).all(|(a, b)| a.iter().zip(b).all(close))
}

#[test]
fn a_field_that_one_volume_hides_is_seen_on_the_other_alone() {
    if crate::common::gpu::gpu().is_none() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let mut document = two(dir.path());
    let function = json!({"colour": [[0, [1, 1, 1]]], "opacity": [[20, 0], [60, 0.9]], "unit_mm": 1});
    say(&mut document, json!({"transfer": {"set": {"function": function}}}));
    say(&mut document, json!({"view": {"look": {"shaded": false}}}));
    say(&mut document, json!({"view": {"frame": {"from": [0, -1, 0.3]}}}));
    say(&mut document, json!({"view": {"crosshair": {"at": {"mm": [20, 8, 6]}}}}));
    say(&mut document, json!({"view": {"fit": {"view": "axial"}}}));
    say(&mut document, json!({"view": {"zoom": {"view": "axial", "factor": 2.5}}}));
    for target in [json!({"label": 2}), json!({"colour": [1, 0, 0, 1]}), json!({"selection": 1})] {
        let field =
            if target.get("label").is_some() { "labels" } else { target.as_object().unwrap().keys().next().unwrap() };
        say(&mut document, json!({"brush": {"set": {"target": target, "radius_mm": 6}}}));
        let paint = |x: f64, id: u32| {
            let at = json!({"mm": [x, 4, 6]});
            json!({"stroke": {"paint": {"points": [{"at": at}], "volume": id}}})
        };
        let bare = pictures(&mut document);
        say(&mut document, paint(8.0, 0));
        let first = pictures(&mut document);
        say(&mut document, paint(31.0, 1));
        let both = pictures(&mut document);
        assert!(!same(&bare, &first) && !same(&first, &both), "{field}");
        layer(&mut document, json!({"field": field, "visible": false, "volume": 1}));
        assert!(same(&pictures(&mut document), &first), "{field} of the second is hidden");
        layer(&mut document, json!({"field": field, "visible": false, "volume": 0}));
        assert!(same(&pictures(&mut document), &bare), "{field} of both is hidden");
        layer(&mut document, json!({"field": field, "shared": true, "volume": 0}));
        layer(&mut document, json!({"field": field, "shared": true, "volume": 1}));
        assert!(same(&pictures(&mut document), &both), "{field} is shown again");
        say(&mut document, json!({"history": {"undo": {"steps": 2}}}));
    }
    // Density in slices.
    let shown = pictures(&mut document);
    layer(&mut document, json!({"field": "density", "visible": false, "volume": 1}));
    let hidden = pictures(&mut document);
    assert!(same(&shown[..1], &hidden[..1]), "in 3D the transfer function says it");
    assert!(shown[1] != hidden[1]);
}

#[test]
fn segments_have_a_strength_of_their_own_in_3d_which_walks_with_the_past_of_looks_and_is_saved() {
    let dir = tempfile::tempdir().unwrap();
    let mut document = two(dir.path());
    let shown = |document: &Document, id: u32| {
        let layer = document.state().unwrap().scene.layer_of(VolumeId(id), FieldKind::Labels);
        [layer.in_slices(), layer.in_3d()]
    };
    let both = |document: &Document| [shown(document, 0), shown(document, 1)];
    assert_eq!(both(&document), [[0.5; 2]; 2]);
    layer(&mut document, json!({"field": "labels", "visible": false}));
    assert_eq!(both(&document), [[0.0; 2]; 2]);
    layer(&mut document, json!({"field": "labels", "visible": true}));
    assert_eq!(both(&document), [[0.5; 2]; 2]);
    // Who names one strength means it everywhere, as it always was.
    let answer = layer(&mut document, json!({"field": "labels", "opacity": 0.25}));
    assert_eq!(answer["layers"][3], json!({"field": "labels", "visible": true, "opacity": 0.25}));
    assert_eq!(both(&document), [[0.25; 2]; 2]);
    let answer = layer(&mut document, json!({"field": "labels", "opacity_3d": 0.75, "volume": 1}));
    assert_eq!(answer["layers"][3], json!({"field": "labels", "visible": true, "opacity": 0.25, "opacity_3d": 0.75}));
    assert_eq!(both(&document), [[0.25; 2], [0.25, 0.75]]);
    layer(&mut document, json!({"field": "labels", "opacity": 0.5, "opacity_3d": 0.0, "volume": 1}));
    assert_eq!(both(&document), [[0.25; 2], [0.5, 0.0]]);
    say(&mut document, json!({"view": {"back": {"of": "looks"}}}));
    assert_eq!(both(&document), [[0.25; 2], [0.25, 0.75]]);
    let path = dir.path().join("p.burin");
    say(&mut document, json!({"project": {"save": {"path": path}}}));
    layer(&mut document, json!({"field": "selection", "opacity_3d": 1}));
    drop(document);
    let mut document = Document::new();
    say(&mut document, json!({"project": {"open": {"path": path}}}));
    assert_eq!(both(&document), [[0.25; 2], [0.25, 0.75]]);
    let selection = document.state().unwrap().scene.layer_of(VolumeId(0), FieldKind::Selection);
    assert_eq!((selection.in_slices(), selection.in_3d()), (0.5, 1.0), "what came after the save too");
    layer(&mut document, json!({"field": "labels", "shared": true, "volume": 1}));
    assert_eq!(both(&document), [[0.25; 2]; 2]);
    for (wrong, needle) in [
        (json!({"field": "labels", "opacity_3d": 1.5}), "opacity_3d: 1.5 found, 0 to 1 expected"),
        (json!({"field": "density", "opacity_3d": 0.5}), "opacity_3d: 0.5 found, 1"),
        (json!({"field": "labels", "opacity_3d": 0.5, "shared": true}), "shared"),
    ] {
        let said = run(&mut document, &json!({"view": {"layer": wrong}}).to_string()).unwrap_err().to_string();
        assert!(said.contains(needle), "{wrong}: {said}");
    }
    // Projects of before say it once: their pictures stay those that were seen.
    let before: Layer = serde_json::from_value(json!({"field": "labels", "visible": true, "opacity": 0.3})).unwrap();
    assert_eq!((before.in_slices(), before.in_3d()), (0.3, 0.3));
}

#[test]
fn what_is_labelled_has_its_segments_colour_in_3d_or_the_colours_of_its_look_and_lets_slices_through() {
    if crate::common::gpu::gpu().is_none() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let mut document = two(dir.path());
    let function = json!({"colour": [[0, [1, 1, 1]]], "opacity": [[20, 0], [60, 1]], "unit_mm": 0.1});
    for volume in [0, 1] {
        say(
            &mut document,
            json!({"volume": {"set": {"volume": volume, "look": {"transfer": function, "shaded": false}, "opacity": 1}}}),
        );
    }
    say(&mut document, json!({"view": {"window": {"level": 40, "width": 80}}}));
    say(&mut document, json!({"view": {"frame": {"from": [0, -1, 0]}}}));
    say(&mut document, json!({"brush": {"set": {"target": {"label": 2}, "radius_mm": 30}}}));
    for volume in [0, 1] {
        let points = json!([{"at": {"index": [10, 8, 6]}}]);
        say(&mut document, json!({"stroke": {"paint": {"points": points, "volume": volume}}}));
        say(&mut document, json!({"segment": {"set": {"id": 2, "colour": [0.2, 0.4, 0.8], "volume": volume}}}));
    }
    say(&mut document, json!({"view": {"crosshair": {"at": {"mm": [10, 8, 6]}}}}));
    say(&mut document, json!({"view": {"fit": {"view": "axial"}}}));
    // The colours of the middles of both volumes in 3D, and of the first in its slice.
    let colours = |document: &mut Document| {
        let size = [96, 64];
        let camera = document.state().unwrap().scene.views.camera;
        let solid = document.picture(ViewName::ThreeD, size, None).unwrap();
        let at = |x: f64| {
            let (px, _) = camera.project(DVec3::new(x, 3.0, 6.0), size).unwrap();
            let [r, g, b, a] = solid.colour[solid.index(px).unwrap()];
            assert!(a > 0.99, "opaque: {a} at {px}");
            [r, g, b]
        };
        let slice = document.picture(ViewName::Axial, size, None).unwrap();
        let middle = slice.colour[32 * 96 + 48];
        [at(10.0), at(31.0), [middle[0], middle[1], middle[2]]]
    };
    let near = |found: [[f32; 3]; 3], wanted: [[f32; 3]; 3], what: &str| {
        let pairs = found.iter().flatten().zip(wanted.iter().flatten());
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 0.011), "{what}: {found:?}, {wanted:?} wanted");
    };
    let own = [0.2, 0.4, 0.8];
    let mixed = |strength: f32, under: f32| own.map(|c| under + (c - under) * strength);
    // 80 to 84 are white in slices.
    near(colours(&mut document), [mixed(0.5, 1.0); 3], "as it begins");
    layer(&mut document, json!({"field": "labels", "opacity_3d": 0.25}));
    near(colours(&mut document), [mixed(0.25, 1.0), mixed(0.25, 1.0), mixed(0.5, 1.0)], "in 3D alone");
    layer(&mut document, json!({"field": "labels", "opacity": 0.75}));
    near(colours(&mut document), [mixed(0.75, 1.0); 3], "everywhere");
    layer(&mut document, json!({"field": "labels", "opacity": 0.75, "opacity_3d": 1}));
    let red = json!({"colour": [[0, [0.9, 0.1, 0.1]]], "opacity": [[20, 0], [60, 1]], "unit_mm": 0.1});
    say(&mut document, json!({"segment": {"set": {"id": 2, "look": {"transfer": red}, "volume": 1}}}));
    near(colours(&mut document), [own, [0.9, 0.1, 0.1], mixed(0.75, 1.0)], "the colours of its look are its own");
    say(&mut document, json!({"segment": {"set": {"id": 2, "look": {"opacity": 1, "shaded": false}, "volume": 0}}}));
    near(colours(&mut document), [own, [0.9, 0.1, 0.1], mixed(0.75, 1.0)], "a look without colours has its segment's");
    // What parts and selections have for themselves shows too, before any segment's colour and the selection's, but for colours that
    // a segment has for itself.
    let one = |colour: [f32; 3]| json!({"colour": [[0, colour]], "opacity": [[20, 0], [60, 1]], "unit_mm": 0.1});
    let (green, blue) = ([0.1, 0.8, 0.3], [0.2, 0.3, 1.0]);
    say(&mut document, json!({"part": {"set": {"id": 1, "look": {"transfer": one(green)}}}}));
    near(colours(&mut document), [green, [0.9, 0.1, 0.1], mixed(0.75, 1.0)], "the colours of a part's look");
    say(&mut document, json!({"segment": {"set": {"id": 2, "look": "inherit", "volume": 1}}}));
    near(colours(&mut document), [green, green, mixed(0.75, 1.0)], "of all its matter");
    say(&mut document, json!({"view": {"layer": {"field": "selection", "opacity": 0.5}}}));
    say(&mut document, json!({"selection": {"from_label": {"label": 2, "volume": 0}}}));
    let tinted: [f32; 3] = std::array::from_fn(|i| own[i] * 0.5 + burin::document::SELECTION_COLOUR[i] * 0.5);
    let found = colours(&mut document);
    assert!(found[1].iter().zip(green).all(|(a, b)| (a - b).abs() < 0.011), "a part: {found:?}");
    assert!(
        found[0].iter().zip(tinted).all(|(a, b)| (a - b).abs() < 0.011),
        "the selection, without a look: {found:?}"
    );
    say(&mut document, json!({"selection": {"set": {"volume": 0, "look": {"transfer": one(blue)}}}}));
    let found = colours(&mut document);
    assert!(found[0].iter().zip(blue).all(|(a, b)| (a - b).abs() < 0.011), "the colours of its look: {found:?}");
}
