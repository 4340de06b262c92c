//! The segments that a NRRD header names in 3D Slicer's keys (`.seg.nrrd`): `SegmentN_Name`, `_Color`, `_LabelValue`, `_Layer`.
//!
//! A layer is one of the numbers of a voxel: segments of several layers may overlap. Older files have no values and layers:
//! each segment is 1 in a layer of its own.

use crate::io::reader::NamedLabel;
use std::collections::{BTreeMap, BTreeSet};

/// What voxels of any type can hold.
const WHOLE: std::ops::Range<i128> = i64::MIN as i128..1 << 64;

/// Warnings that one header may give rise to.
const MOST_WARNINGS: usize = 5;

/// The segments in the order of their numbers; `keys` are the header's free ones.
pub(crate) fn segments(keys: &[(String, String)], components: u32, warnings: &mut Vec<String>) -> Vec<NamedLabel> {
    let mut found: BTreeMap<u32, BTreeMap<&str, &str>> = BTreeMap::new();
    for (key, value) in keys {
        let Some((number, field)) = key.strip_prefix("Segment").and_then(|k| k.split_once('_')) else { continue };
        if let Ok(number) = number.parse() {
            found.entry(number).or_default().insert(field, value.trim());
        }
    }
    let mut odd = Vec::new();
    let mut taken = BTreeSet::new();
    let mut labels = Vec::new();
    for (number, fields) in &found {
        let get = |field: &str| fields.get(field).copied();
        let old = get("LabelValue").is_none() && get("Layer").is_none();
        let value = get("LabelValue").unwrap_or("1");
        let layer = get("Layer").map_or_else(|| if old { number.to_string() } else { "0".into() }, str::to_owned);
        // Older files of one segment are its voxels alone.
        let layer = if old && components == 1 && found.len() == 1 { "0".into() } else { layer };
        let (Ok(value), Ok(component)) = (value.parse::<i128>(), layer.parse::<u32>()) else {
            odd.push(format!("Segment{number} has label value {value} in layer {layer}, which are no numbers"));
            continue;
        };
        if component >= components || value == 0 || !WHOLE.contains(&value) || !taken.insert((component, value)) {
            odd.push(format!("Segment{number} has label value {value} in layer {layer}, which is no place of its own"));
            continue;
        }
        let name = get("Name").filter(|n| !n.is_empty()).or_else(|| get("ID")).filter(|n| !n.is_empty());
        let colour = get("Color").and_then(colour);
        if colour.is_none() && get("Color").is_some() {
            odd.push(format!("Segment{number}_Color is no red, green and blue of 0 to 1"));
        }
        labels.push(NamedLabel { value, name: name.map(str::to_owned), colour, component });
    }
    let more = odd.len().saturating_sub(MOST_WARNINGS);
    warnings.extend(odd.into_iter().take(MOST_WARNINGS).map(|w| format!("{}; not used", crate::io::error::shown(&w))));
    if more > 0 {
        warnings.push(format!("{more} more segments of the header are odd"));
    }
    labels
}

fn colour(text: &str) -> Option<[f32; 3]> {
    let numbers: Option<Vec<f32>> = text.split_whitespace().map(|w| w.parse().ok()).collect();
    let colour: [f32; 3] = numbers?.try_into().ok()?;
    colour.iter().all(|c| (0.0..=1.0).contains(c)).then_some(colour)
}
