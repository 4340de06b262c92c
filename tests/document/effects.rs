//! What a command means for everything around it: said once, and so that the rest of the program holds it.

use super::maker::{labelled, run};
use burin::document::Command;
use burin::document::effects::{Lasts, Noted, Redraws, Remembered};
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// One command of every noun and verb.
pub fn one_of_each() -> Vec<Value> {
    let camera = json!({"eye":[0,-200,0],"target":[0,0,0],"up":[0,0,1],"projection":{"perspective":{"fov_y_deg":30}}});
    let pose = json!({"rotation":[0,0,0,1],"translation":[1,0,0]});
    let forces = json!({"delta_explosion":0.5,"delta_viewing":0.3,"delta_spacing":0.2,"return_constant":0.25,
        "return_length":0.1,"explosion_length":0.2,"softening":0.05,"viewing":true,"measured_gain":true});
    let function = json!({"colour":[[0,[1,1,1]]],"opacity":[[0,0.5]],"unit_mm":1});
    let at = json!({"index":[3,3,3]});
    vec![
        json!({"project":{"open":{"path":"p"}}}),
        json!({"project":{"save":{}}}),
        json!({"project":{"lost":{}}}),
        json!({"project":{"recover":{"id":"1"}}}),
        json!({"project":{"forget":{"id":"1"}}}),
        json!({"volume":{"open":{"path":"v.nrrd"}}}),
        json!({"volume":{"export":{"field":"density","path":"v.nrrd"}}}),
        json!({"volume":{"add":{"path":"v.nrrd"}}}),
        json!({"volume":{"set":{"volume":0,"opacity":0.5}}}),
        json!({"volume":{"remove":{"volume":0}}}),
        json!({"transfer":{"set":{"function":function}}}),
        json!({"transfer":{"reset":{}}}),
        json!({"view":{"camera":{"camera":camera}}}),
        json!({"view":{"frame":{"from":[0,-1,0]}}}),
        json!({"view":{"fit":{"view":"axial"}}}),
        json!({"view":{"orbit":{"azimuth_deg":1,"elevation_deg":1}}}),
        json!({"view":{"pan":{"view":"3d","px":[1,1]}}}),
        json!({"view":{"zoom":{"view":"3d","factor":0.9}}}),
        json!({"view":{"size":{"view":"3d","size":[64,64]}}}),
        json!({"view":{"crosshair":{"at":at}}}),
        json!({"view":{"scroll":{"view":"axial","voxels":1}}}),
        json!({"view":{"look":{"shaded":false}}}),
        json!({"view":{"focus":{"distance_mm":9,"opacity":0.25,"as":"contour"}}}),
        json!({"view":{"window":{"level":10,"width":5}}}),
        json!({"view":{"layer":{"field":"labels","visible":false,"opacity":0.5}}}),
        json!({"view":{"back":{}}}),
        json!({"view":{"forward":{}}}),
        json!({"brush":{"set":{"radius_mm":3}}}),
        json!({"brush":{"also":{"volumes":[0]}}}),
        json!({"stroke":{"paint":{"points":[{"at":at}]}}}),
        json!({"stroke":{"lasso":{"points":[at, at, at]}}}),
        json!({"stroke":{"begin":{"points":[{"at":at}]}}}),
        json!({"stroke":{"extend":{"points":[{"at":at}]}}}),
        json!({"stroke":{"end":{}}}),
        json!({"stroke":{"cancel":{}}}),
        json!({"component":{"keep":{"at":at}}}),
        json!({"component":{"remove":{"at":at}}}),
        json!({"component":{"select":{"at":at}}}),
        json!({"component":{"label":{"at":at,"label":1}}}),
        json!({"selection":{"import":{"path":"s.nrrd"}}}),
        json!({"selection":{"set":{"look":{"opacity":0.5}}}}),
        json!({"segment":{"show_only":{"ids":[0,1]}}}),
        json!({"selection":{"from_label":{"label":1}}}),
        json!({"selection":{"clear":{}}}),
        json!({"sub_volume":{"add":{"lo":[1,1,1],"hi":[4,4,4],"scale":2}}}),
        json!({"sub_volume":{"set":{"volume":1,"scale":[1,2,3]}}}),
        json!({"sub_volume":{"remove":{"volume":1}}}),
        json!({"sub_volume":{"bake":{"volume":1}}}),
        json!({"sub_volume":{"export":{"volume":1,"field":"density","path":"x.nrrd"}}}),
        json!({"segment":{"set":{"id":1,"name":"jaw"}}}),
        json!({"segment":{"remove":{"id":1}}}),
        json!({"segment":{"import":{"path":"l.nrrd"}}}),
        json!({"part":{"split":{"by":{"depth":{"px":[3,3]}}}}}),
        json!({"part":{"set":{"id":1,"visible":false}}}),
        json!({"part":{"move":{"id":1,"pose":pose}}}),
        json!({"part":{"reset":{}}}),
        json!({"explosion":{"degree":{"value":0.5}}}),
        json!({"explosion":{"forces":{"forces":forces}}}),
        json!({"explosion":{"seed":{"value":3}}}),
        json!({"explosion":{"settle":{}}}),
        json!({"explosion":{"step":{"steps":1}}}),
        json!({"annotation":{"add":{"text":"x","at":at,"toward":{"index":[4,3,3]},"value":20}}}),
        json!({"annotation":{"set":{"id":0,"size_mm":2}}}),
        json!({"annotation":{"remove":{"id":0}}}),
        json!({"label":{"add":{"text":"x","at":at}}}),
        json!({"label":{"set":{"id":0,"text":"y"}}}),
        json!({"label":{"remove":{"id":0}}}),
        json!({"label":{"from_segments":{"segments":[1]}}}),
        json!({"label":{"style":{"numbers":true}}}),
        json!({"cutaway":{"add":{"at":at,"toward":{"index":[4,3,3]},"value":20}}}),
        json!({"cutaway":{"set":{"id":0,"depth_mm":2}}}),
        json!({"cutaway":{"remove":{"id":0}}}),
        json!({"history":{"undo":{}}}),
        json!({"history":{"redo":{}}}),
        json!({"history":{"budget":{"bytes":1000}}}),
        json!({"history":{"begin":{}}}),
        json!({"history":{"end":{}}}),
        json!({"history":{"cancel":{}}}),
        json!({"ask":{"volume":{}}}),
        json!({"ask":{"sub_volumes":{}}}),
        json!({"ask":{"sub_volume_fit":{"lo":[1,1,1],"hi":[4,4,4],"scale":2}}}),
        json!({"ask":{"scene":{}}}),
        json!({"ask":{"parts":{}}}),
        json!({"ask":{"voxel":{"at":at}}}),
        json!({"ask":{"pick":{"px":[3,3]}}}),
        json!({"ask":{"field":{"field":"labels"}}}),
        json!({"ask":{"contact":{"at":at,"value":20}}}),
        json!({"ask":{"visibility":{}}}),
        json!({"ask":{"history":{}}}),
        json!({"ask":{"annotations":{}}}),
        json!({"ask":{"labels":{}}}),
        json!({"ask":{"cutaways":{}}}),
        json!({"render":{"image":{"path":"x.png"}}}),
    ]
}

fn command(line: &Value) -> Command {
    serde_json::from_value(line.clone()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

fn name(line: &Value) -> String {
    let (noun, verb) = line.as_object().unwrap().iter().next().unwrap();
    format!("{noun}.{}", verb.as_object().unwrap().keys().next().unwrap())
}

fn noun(line: &Value) -> String {
    line.as_object().unwrap().keys().next().unwrap().clone()
}

/// Every `noun.verb` of the schema.
fn verbs() -> BTreeSet<String> {
    let schema = burin::script::schema();
    let resolved = |value: &Value| match value["$ref"].as_str() {
        Some(path) => schema.pointer(path.trim_start_matches('#')).unwrap().clone(),
        None => value.clone(),
    };
    let mut all = BTreeSet::new();
    for noun in schema["oneOf"].as_array().unwrap() {
        let (name, verbs) = noun["properties"].as_object().unwrap().iter().next().unwrap();
        for verb in resolved(verbs)["oneOf"].as_array().unwrap() {
            all.insert(format!("{name}.{}", verb["properties"].as_object().unwrap().keys().next().unwrap()));
        }
    }
    all
}

#[test]
fn every_verb_of_the_schema_says_what_it_means_under_its_own_name() {
    let told: BTreeSet<String> = one_of_each().iter().map(|line| command(line).effects().name.to_owned()).collect();
    assert_eq!(told, one_of_each().iter().map(name).collect());
    assert_eq!(told, verbs());
}

/// What follows from a command's own text and not from a list: what asks or looks about changes nothing that is kept.
#[test]
fn what_changes_nothing_redraws_nothing_and_is_not_noted() {
    for line in one_of_each() {
        let effects = command(&line).effects();
        let noun = noun(&line);
        if ["ask", "render"].contains(&&*noun) {
            assert_eq!((effects.redraws, effects.journal), (Redraws::NONE, Noted::Never));
        }
        if noun == "ask" {
            assert!(!effects.ends_stroke && effects.lasts == Lasts::AtOnce, "{line}");
        }
        if effects.past == Remembered::View {
            assert!(!effects.ends_stroke && effects.redraws == Redraws::NONE, "{line}: cameras and planes tell it");
        }
        // Whoever opens replaces all there is.
        assert!(!effects.opens || (effects.redraws == Redraws::ALL && effects.is_awaited), "{line}");
        // What takes its time has an answer that somebody waits for.
        assert!(effects.lasts == Lasts::AtOnce || effects.is_awaited, "{line}");
    }
}

/// Steps, and what a step may have changed: a command that makes one is noted.
#[test]
fn whatever_makes_a_step_is_noted() {
    // Files would be made where the tests run.
    let of_files = ["project", "volume", "render"];
    for line in one_of_each().into_iter().filter(|line| !of_files.contains(&&*noun(line))) {
        let mut document = labelled();
        let Ok(answer) = run(&mut document, &line.to_string()) else { continue };
        if document.history().undo_names().len() > 0 {
            let effects = command(&line).effects();
            assert!(matches!(effects.journal, Noted::Step | Noted::Stroke), "{line}: {answer}");
            assert_ne!(effects.redraws, Redraws::NONE, "{line}: {answer}");
        }
    }
}
