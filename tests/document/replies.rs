//! What commands and questions answer with is what is there: places, frames, counts, warnings.

use super::maker::{bytes, labelled, run, write_nrrd};
use super::maker_gpu::{block, cut, select};
use crate::common::one::{One, segments};
use burin::document::{Document, DocumentError};
use burin::math::{DAffine3, DMat3, DVec3};
use burin::volume::{Grid, Segment};
use serde_json::{Value, json};

fn say(document: &mut Document, line: Value) -> Value {
    run(document, &line.to_string()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn a_volume_answers_with_the_rows_of_its_frame() {
    let mut document = labelled();
    let answer = say(&mut document, json!({"ask":{"volume":{}}}));
    // The frame of the maker's volume: turned by 0.2 about z, voxels of 1 × 1.5 × 2 mm.
    let (sin, cos) = 0.2_f64.sin_cos();
    let rows = [[cos, -1.5 * sin, 0.0, -30.0], [sin, 1.5 * cos, 0.0, -20.0], [0.0, 0.0, 2.0, -35.0]];
    for (r, row) in rows.iter().enumerate() {
        for (c, expected) in row.iter().enumerate() {
            let found = number(&answer["world_from_index"][r][c]);
            assert!((found - expected).abs() < 1e-12, "row {r}, column {c}: {found}, {expected} expected");
        }
    }
    for (a, expected) in [1.0, 1.5, 2.0].into_iter().enumerate() {
        assert!((number(&answer["spacing_mm"][a]) - expected).abs() < 1e-12);
    }
}

#[test]
fn a_crosshair_answers_in_millimetres_and_in_voxels() {
    let mut document = labelled();
    let answer = say(&mut document, json!({"view":{"crosshair":{"at":{"index":[3,4,5]}}}}));
    let (sin, cos) = 0.2_f64.sin_cos();
    let mm = [-30.0 + 3.0 * cos - 6.0 * sin, -20.0 + 3.0 * sin + 6.0 * cos, -25.0];
    for a in 0..3 {
        assert!((number(&answer["index"][a]) - [3.0, 4.0, 5.0][a]).abs() < 1e-9, "{answer}");
        assert!((number(&answer["crosshair_mm"][a]) - mm[a]).abs() < 1e-9, "{answer}");
    }
    let scrolled = say(&mut document, json!({"view":{"scroll":{"view":"axial","voxels":2}}}));
    assert!((number(&scrolled["index"][2]) - 7.0).abs() < 1e-9, "{scrolled}");
}

#[test]
fn light_that_is_given_takes_the_place_of_the_light_that_was() {
    let mut document = labelled();
    for (ambient, power) in [(0.1, 8.0), (0.4, 20.0)] {
        let light = json!({"ambient":ambient,"diffuse":0.5,"specular":0.25,"power":power});
        let answer = say(&mut document, json!({"view":{"look":{"lighting":light}}}));
        let kept = document.state().unwrap().scene.look.lighting.unwrap();
        assert_eq!((f64::from(kept.ambient), f64::from(kept.power)), (f64::from(ambient as f32), power));
        assert_eq!(number(&answer["look"]["lighting"]["power"]), power);
    }
    // Light alone needs no more than to be asked for, and goes.
    say(&mut document, json!({"view":{"look":{"shaded":true}}}));
    assert_eq!(document.state().unwrap().scene.look.lighting.unwrap().power, 20.0, "what was chosen stays");
    say(&mut document, json!({"view":{"look":{"shaded":false}}}));
    assert_eq!(document.state().unwrap().scene.look.lighting, None);
}

#[test]
fn a_group_within_a_group_is_refused_and_the_first_goes_on() {
    let mut document = labelled();
    let before = bytes(&document);
    say(&mut document, json!({"history":{"begin":{}}}));
    say(&mut document, json!({"segment":{"set":{"id":1,"name":"jaw"}}}));
    let refused = run(&mut document, r#"{"history":{"begin":{}}}"#).unwrap_err();
    assert!(matches!(refused, DocumentError::NotNow(_)), "{refused}");
    assert!(refused.to_string().contains("history.end"), "{refused}");
    say(&mut document, json!({"segment":{"set":{"id":2,"name":"ear"}}}));
    say(&mut document, json!({"history":{"end":{}}}));
    assert_eq!(document.history().undo_names().len(), 1, "both are one step");
    say(&mut document, json!({"history":{"undo":{}}}));
    assert!(bytes(&document) == before);
}

#[test]
fn one_part_again_keeps_how_far_parts_go() {
    let mut document = labelled();
    let centre = document.state().unwrap().one().grid().world_bounds().centre().to_array();
    say(&mut document, json!({"part":{"split":{"by":{"plane":{"point":centre,"normal":[1,0,0]}}}}}));
    say(&mut document, json!({"explosion":{"degree":{"value":0.75}}}));
    say(&mut document, json!({"part":{"reset":{}}}));
    let explosion = &document.state().unwrap().scene.explosion;
    assert_eq!((explosion.parts.len(), explosion.degree), (1, 0.75));
}

#[test]
fn an_export_says_which_segment_leaves_by_another_number() {
    let folder = tempfile::tempdir().unwrap();
    // Both would be 2 in a file: one by its own number, the other by the one that it came with.
    let mut state = super::maker::state();
    segments(&mut state.scene).ensure(2);
    segments(&mut state.scene).ensure(3);
    let twin = Segment { source_value: Some(2), name: "Twin".into(), ..state.scene.segments().0[1].clone() };
    segments(&mut state.scene).0[1] = twin;
    let mut document = Document::new();
    document.adopt(state);
    let path = folder.path().join("labels.nrrd");
    let answer = say(&mut document, json!({"volume":{"export":{"field":"labels","path":path}}}));
    let told: Vec<&str> = answer["warnings"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert!(matches!(told[..], [one] if one.contains("2 is another segment's")), "{answer}");
    // Nothing is told where every segment has a number of its own.
    let mut plain = labelled();
    let answer = say(&mut plain, json!({"volume":{"export":{"field":"labels","path":path}}}));
    assert_eq!(answer["warnings"], json!([]));
}

#[test]
fn a_label_that_got_no_voxel_is_counted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fine.nrrd");
    let mut document = labelled();
    let ours = *document.state().unwrap().one().grid();
    // Four times as fine along x, the first voxel on ours: one label in three of them, one in a voxel between two of ours.
    let fine = Grid {
        dims: [80, 4, 4],
        world_from_index: DAffine3 {
            matrix3: ours.world_from_index.matrix3 * DMat3::from_diagonal(DVec3::new(0.25, 1.0, 1.0)),
            translation: ours.world_from_index.translation,
        },
    };
    for (lost, told) in [(&[][..], None), (&[18][..], Some("1 of 2 labels got no voxel")), (&[18, 22], Some("2 of 3"))]
    {
        write_nrrd(&path, &fine, |v| match v {
            [x, 1, 1] if (39..=41).contains(&x) => 5.0,
            [x, 1, 1] if lost.contains(&x) => x as f32,
            _ => 0.0,
        });
        let answer = say(&mut document, json!({"segment":{"import":{"path":path}}}));
        let found: Vec<&str> = answer["warnings"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
        let lost: Vec<_> = found.iter().filter(|w| w.contains("got no voxel")).collect();
        assert_eq!(lost.len(), usize::from(told.is_some()), "{found:?}");
        assert!(told.is_none_or(|told| lost[0].contains(told)), "{found:?}");
        assert_eq!(answer["labelled_voxels"], 1);
    }
}

#[test]
fn a_selected_voxel_beside_the_volume_selects_what_it_reaches_into() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("beside.nrrd");
    let mut document = labelled();
    let ours = *document.state().unwrap().one().grid();
    // Voxels four of ours long; one is selected, its centre 1.5 voxels before our first. The value falls off to 0 at 2.5.
    let grid = Grid {
        dims: [6, 3, 3],
        world_from_index: ours.world_from_index
            * DAffine3::from_scale_rotation_translation(
                DVec3::new(4.0, 1.0, 1.0),
                burin::math::DQuat::IDENTITY,
                DVec3::new(-1.5, 9.0, 9.0),
            ),
    };
    write_nrrd(&path, &grid, |v| if v == [0, 1, 1] { 100.0 } else { 0.0 });
    let answer = say(&mut document, json!({"selection":{"import":{"path":path,"threshold":0,"soften_mm":0}}}));
    let selection = &document.state().unwrap().one().selection;
    // 0, 1 and 2 lie before 2.5.
    let row: Vec<u8> = (0..6).map(|x| selection.texel([x, 10, 10]).unwrap()[0]).collect();
    assert_eq!(row, [255, 255, 255, 0, 0, 0], "{answer}");
    // Farther away it reaches nothing, and that is an error.
    let far = Grid {
        world_from_index: grid.world_from_index * DAffine3::from_translation(DVec3::new(-2.0, 0.0, 0.0)),
        ..grid
    };
    write_nrrd(&path, &far, |v| if v == [0, 1, 1] { 100.0 } else { 0.0 });
    let line = json!({"selection":{"import":{"path":path,"threshold":0,"soften_mm":0}}});
    run(&mut document, &line.to_string()).unwrap_err();
}

#[test]
fn visibility_answers_what_there_is_and_what_of_it_is_seen() {
    let Some(mut document) = block() else { return };
    cut(&mut document);
    select(&mut document);
    let answer = say(&mut document, json!({"ask":{"visibility":{}}}));
    let [selected, visible, share] = ["selected", "visible", "share"].map(|name| number(&answer[name]));
    // A ball of 7 mm in the middle of an opaque block: nothing of it is seen, and whoever hides it is named.
    assert!(selected > 50.0 && visible < 0.02 * selected, "{answer}");
    assert!((share - visible / selected).abs() < 1e-6, "{answer}");
    let hidden: f64 = answer["hidden_by"].as_array().unwrap().iter().map(|p| number(&p["pixels"])).sum();
    assert!(hidden >= selected - visible, "{answer}");
    // With nothing before it there is as much, and all is seen.
    for part in document.state().unwrap().scene.explosion.parts.clone() {
        say(&mut document, json!({"part":{"set":{"id":part.id,"visible":false}}}));
    }
    let alone = say(&mut document, json!({"ask":{"visibility":{}}}));
    assert_eq!(alone["selected"], answer["selected"]);
    assert_eq!((&alone["visible"], number(&alone["share"])), (&alone["selected"], 1.0));
    assert_eq!(alone["hidden_by"].as_array().map_or(0, Vec::len), 0, "{alone}");
}

#[test]
fn labels_are_summed_as_numbers_too() {
    let mut document = labelled();
    let answer = say(&mut document, json!({"ask":{"field":{"field":"labels"}}}));
    let [one, two] = ["1", "2"].map(|id| number(&answer["voxels_by_label"][id]));
    assert!(one > 100.0 && two > 100.0, "{answer}");
    assert_eq!(
        ["nonzero", "sum", "max", "min"].map(|name| number(&answer[name])),
        [one + two, one + 2.0 * two, 2.0, 0.0]
    );
}

#[test]
fn a_selection_from_elsewhere_says_where_what_it_has_lies() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("far.nrrd");
    let mut document = labelled();
    let far = Grid::aligned([7, 5, 4], DVec3::new(1.0, 2.0, 3.0), DVec3::new(1000.0, 2000.0, 3000.0));
    write_nrrd(&path, &far, |v| f32::from([1, 2, 3] == v || [4, 3, 1] == v));
    let line = json!({"selection":{"import":{"path":path,"threshold":0}}}).to_string();
    let said = run(&mut document, &line).unwrap_err().to_string();
    // From the outer faces of [1, 2, 1] to those of [4, 3, 3].
    let place = "2 voxels of values above 0 at x 1000.5 to 1004.5, y 2003.0 to 2007.0, z 3001.5 to 3010.5 mm";
    assert!(said.contains(place), "{said}");
    // With nothing above it, there is nothing to place: the file is placed.
    write_nrrd(&path, &far, |_| 0.0);
    let said = run(&mut document, &line).unwrap_err().to_string();
    assert!(said.contains("x 999.5 to 1006.5, y 1999.0 to 2009.0, z 2998.5 to 3010.5 mm"), "{said}");
    // In its place it may be empty.
    let grid = *document.state().unwrap().one().grid();
    write_nrrd(&path, &grid, |_| 0.0);
    assert_eq!(say(&mut document, serde_json::from_str(&line).unwrap())["step"], Value::Null);
}
