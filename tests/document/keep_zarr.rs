//! Another Zarr reader reads a project's arrays: zarr-python 3, skipped where Python lacks it.

use super::keep_support::*;
use crate::common::one::One;
use burin::document::Autosave;
use burin::volume::*;
use std::process::Command as Process;

const SCRIPT: &str = r#"
import sys, json, hashlib, zarr
group = zarr.open_group(sys.argv[1], mode="r")["volumes/0"]
out = {}
for name in ["density/0", "density_edits/0", "density_edits/edited", "colour/0", "selection/0", "labels/0"]:
    array = group[name]
    out[name] = {"shape": list(array.shape), "dtype": str(array.dtype), "sha256": hashlib.sha256(array[:].tobytes()).hexdigest(),
        "chunks": list(array.chunks), "shards": list(array.shards) if array.shards else None}
for name in ["density", "density_edits", "colour", "selection", "labels"]:
    out[name] = dict(group[name].attrs)
print(json.dumps(out))
"#;

/// The interpreter, or why there is none.
fn python() -> Result<String, String> {
    let python = std::env::var("BURIN_PYTHON").unwrap_or_else(|_| "python3".into());
    let check = "import zarr; assert int(zarr.__version__.split('.')[0]) >= 3, zarr.__version__";
    match Process::new(&python).args(["-c", check]).output() {
        Ok(out) if out.status.success() => Ok(python),
        Ok(_) => Err(format!("{python} has no zarr 3")),
        Err(error) => Err(format!("{python}: {error}")),
    }
}

fn sha256_of(python: &str, bytes: &[u8]) -> String {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("bytes");
    std::fs::write(&path, bytes).unwrap();
    let hash = "import sys, hashlib; print(hashlib.sha256(open(sys.argv[1], 'rb').read()).hexdigest())";
    let out = Process::new(python).args(["-c", hash]).arg(&path).output().unwrap();
    String::from_utf8(out.stdout).unwrap().trim().to_owned()
}

#[test]
fn zarr_python_reads_every_array() {
    let python = match python() {
        Ok(python) => python,
        Err(why) => return println!("skipped: {why}; set BURIN_PYTHON to an interpreter that has it"),
    };
    let dir = tempfile::tempdir().unwrap();
    let mut state = state(DIMS, dir.path());
    paint_all(&mut state);
    let project = dir.path().join("project");
    let mut autosave = Autosave::unsaved(dir.path(), &state).unwrap();
    autosave.save(Some(&project), &state, None, &|_| true).unwrap();
    let out = Process::new(&python).args(["-c", SCRIPT]).arg(project.join("generation-000001")).output().unwrap();
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let said: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();

    let [x, y, z] = DIMS;
    let check = |name: &str, dtype: &str, shape: &[u32], bytes: &[u8]| {
        assert_eq!(said[name]["shape"], serde_json::json!(shape), "{name}");
        assert_eq!(said[name]["dtype"], dtype, "{name}");
        assert_eq!(said[name]["sha256"], sha256_of(&python, bytes), "{name}");
    };
    check("density/0", "uint16", &[z, y, x], state.one().source.read([0; 3], DIMS).unwrap().as_bytes());
    check("selection/0", "uint8", &[z, y, x], &state.one().selection.read(0, [0; 3], DIMS).unwrap());
    check("labels/0", "uint16", &[z, y, x], &state.one().labels.read(0, [0; 3], DIMS).unwrap());
    let colour = state.one().colour.read(0, [0; 3], DIMS).unwrap();
    let planes: Vec<u8> = (0..4).flat_map(|c| colour.iter().skip(c).step_by(4).copied()).collect();
    check("colour/0", "uint8", &[4, z, y, x], &planes);
    // Edited density: texels where a brick is edited, 0 elsewhere; and the map of these bricks.
    let edits = state.one().density.edits();
    let bricks = state.one().density.brick_dims(0);
    let mut texels = Vec::new();
    for k in 0..z {
        for j in 0..y {
            for i in 0..x {
                let at = [i, j, k];
                let texel = edits.get(&BrickIndex::of_voxel(at)).map_or([0; 4], |b| b.texel(at.map(|v| v % BRICK), 2));
                texels.extend(&texel[..2]);
            }
        }
    }
    check("density_edits/0", "uint16", &[z, y, x], &texels);
    let flags: Vec<u8> = state.one().density.brick_indices(0).iter().map(|i| u8::from(edits.contains_key(i))).collect();
    check("density_edits/edited", "uint8", &[bricks[2], bricks[1], bricks[0]], &flags);
    assert_eq!(said["labels/0"]["chunks"], serde_json::json!([32, 32, 32]));
    assert_eq!(said["labels/0"]["shards"], serde_json::json!([128, 128, 128]));

    // OME-Zarr 0.5: axes in order, scale and translation of them; and the grid's full place beside it.
    let image = &said["colour"]["ome"]["multiscales"][0];
    assert_eq!(said["colour"]["ome"]["version"], "0.5");
    let types: Vec<_> =
        image["axes"].as_array().unwrap().iter().map(|a| (a["name"].clone(), a["type"].clone())).collect();
    let expected = [("c", "channel"), ("z", "space"), ("y", "space"), ("x", "space")];
    assert_eq!(types, expected.map(|(n, t)| (n.into(), t.into())));
    let transforms = &image["datasets"][0]["coordinateTransformations"];
    let numbers = |v: &serde_json::Value| v.as_array().unwrap().iter().map(|n| n.as_f64().unwrap()).collect::<Vec<_>>();
    let scale = numbers(&transforms[0]["scale"]);
    for (found, expected) in scale.iter().zip([1.0, 2.5, 1.1, 0.7]) {
        assert!((found - expected).abs() < 1e-12, "{scale:?}");
    }
    assert_eq!(numbers(&transforms[1]["translation"]), [0.0, 1e-3, 17.5, -31.25]);
    let m = state.one().grid().world_from_index;
    for (r, row) in said["density"]["burin"]["world_from_index"].as_array().unwrap().iter().enumerate() {
        assert_eq!(numbers(row), [m.matrix3.x_axis[r], m.matrix3.y_axis[r], m.matrix3.z_axis[r], m.translation[r]]);
    }
}
