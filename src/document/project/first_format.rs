//! What projects and journals of format 1 say, in the words of format 2.
//!
//! Format 1 had one volume: its file, its window and its segments were parts of the scene, its arrays lay beside the JSON. Works on
//! JSON alone, so that nothing else needs to know that there was another format.

use serde_json::{Map, Value, json};

/// A generation's description.
pub(crate) fn generation(value: &mut Value) {
    let Some(all) = value.as_object_mut() else { return };
    if let Some(mut volume) = all.remove("volume") {
        let shards = all.remove("shards").unwrap_or(json!({}));
        if let Some(volume) = volume.as_object_mut() {
            volume.insert("shards".into(), shards);
        }
        all.insert("volumes".into(), json!({ "0": volume }));
    }
    if let Some(past) = all.get_mut("past") {
        looks(past);
    }
    if let Some(scene) = all.get_mut("scene").and_then(Value::as_object_mut) {
        parts(scene, &Map::new());
    }
}

/// Parts of a scene by name; `known` is the scene that they change.
pub(crate) fn parts(parts: &mut Map<String, Value>, known: &Map<String, Value>) {
    let said = |parts: &Map<String, Value>, name: &str, fresh: Value| {
        parts.get(name).or_else(|| known.get(name)).cloned().unwrap_or(fresh)
    };
    for name in ["origin", "segments"] {
        if let Some(part) = parts.remove(name) {
            let mut volumes = said(parts, "volumes", json!({ "active": 0, "next": 1, "all": {} }));
            volumes["all"]["0"][name] = part;
            parts.insert("volumes".into(), volumes);
        }
    }
    if let Some(window) = parts.remove("window") {
        let mut shown = said(parts, "shown", json!({}));
        shown["0"]["window"] = window;
        parts.insert("shown".into(), shown);
    }
}

/// Looks wherever they are: of the past of looks, or what is new of it.
pub(crate) fn looks(value: &mut Value) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(looks),
        Value::Object(fields) => {
            if ["transfer", "look", "layers"].iter().all(|name| fields.contains_key(*name))
                && let Some(window) = fields.remove("window")
            {
                fields.insert("shown".into(), json!({ "0": { "window": window } }));
            }
            fields.values_mut().for_each(looks);
        }
        _ => {}
    }
}
