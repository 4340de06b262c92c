//! Commands on parts and forces.

use super::maker::{labelled, run};
use crate::common::one::One;
use serde_json::json;

#[test]
fn a_plane_cuts_every_part_and_undo_joins_them_again() {
    let mut document = labelled();
    let plane = |n: [f64; 3]| json!({"part":{"split":{"by":{"plane":{"point":[0,0,0],"normal":n}}}}}).to_string();
    let centre = document.state().unwrap().one().grid().world_bounds().centre();
    let at = |n: [f64; 3]| plane(n).replace("[0,0,0]", &json!(centre.to_array()).to_string());
    for (n, parts) in [([1.0, 0.0, 0.0], 2), ([0.0, 1.0, 0.0], 4), ([0.0, 0.0, 1.0], 8)] {
        let answer = run(&mut document, &at(n)).unwrap();
        assert_eq!(answer["parts"], parts);
        assert_eq!(answer["halves"].as_array().unwrap().len(), parts / 2);
    }
    // The same plane again cuts nothing and is no step.
    assert_eq!(run(&mut document, &at([0.0, 0.0, 1.0])).unwrap()["step"], serde_json::Value::Null);
    assert_eq!(document.history().undo_names().len(), 3);
    run(&mut document, r#"{"history":{"undo":{"steps":3}}}"#).unwrap();
    assert_eq!(document.state().unwrap().scene.explosion.parts.len(), 1);
}

#[test]
fn a_part_is_named_coloured_hidden_and_moved_each_in_one_step() {
    let mut document = labelled();
    for (line, step) in [
        (r#"{"part":{"set":{"id":1,"name":"jaw"}}}"#, "Rename Part 1"),
        (r#"{"part":{"set":{"id":1,"colour":[1,0,0]}}}"#, "Colour jaw"),
        (r#"{"part":{"set":{"id":1,"visible":false}}}"#, "Hide jaw"),
        (r#"{"part":{"move":{"id":1,"pose":{"rotation":[0,0,0,1],"translation":[5,0,0]}}}}"#, "Move jaw"),
        (r#"{"part":{"set":{"id":1,"pinned":false}}}"#, "Unpin jaw"),
        (r#"{"part":{"set":{"id":1,"own_colour":true}}}"#, "Colour jaw"),
    ] {
        assert_eq!(run(&mut document, line).unwrap()["step"], step);
    }
    let part = document.state().unwrap().scene.explosion.parts[0].clone();
    assert_eq!((part.name.as_str(), part.colour, part.visible, part.held), ("jaw", None, false, None));
    assert_eq!(document.poses().of(&part).translation.x, 5.0);
    run(&mut document, r#"{"history":{"undo":{"steps":6}}}"#).unwrap();
    assert_eq!(document.state().unwrap().scene.explosion.parts[0].name, "Part 1");
}

#[test]
fn a_part_that_is_not_there_is_named_beside_those_that_are() {
    let mut document = labelled();
    let error = run(&mut document, r#"{"part":{"set":{"id":7,"visible":false}}}"#).unwrap_err().to_string();
    assert!(error.contains('7') && error.contains('1'), "{error}");
    let error = run(&mut document, r#"{"explosion":{"degree":{"value":-1}}}"#).unwrap_err().to_string();
    assert_eq!(error, "degree: -1 found, a number from 0 to 10 expected");
    assert_eq!(document.state().unwrap().scene.explosion.degree, 0.0);
}

#[test]
fn ids_of_parts_are_never_used_twice() {
    let mut document = labelled();
    let centre = document.state().unwrap().one().grid().world_bounds().centre();
    let split = json!({"part":{"split":{"by":{"plane":{"point":centre.to_array(),"normal":[1,0,0]}}}}}).to_string();
    let mut seen = std::collections::BTreeSet::from([1]);
    for _ in 0..3 {
        run(&mut document, &split).unwrap();
        let now: Vec<u32> = document.state().unwrap().scene.explosion.parts.iter().map(|p| p.id.0).collect();
        assert!(now.iter().all(|id| seen.insert(*id)), "{now:?} {seen:?}");
        run(&mut document, r#"{"part":{"reset":{}}}"#).unwrap();
        assert!(seen.insert(document.state().unwrap().scene.explosion.parts[0].id.0));
    }
}
