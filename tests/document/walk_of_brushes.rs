//! Random brushes with every operation, shape, falloff and limit: each stroke is undone and done again to the byte, and what its step says
//! of it does the same elsewhere.

use super::maker::{bytes, run};
use super::maker_gpu::made;
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::Voxels;
use rand::{Rng, SeedableRng, rngs::StdRng};
use serde_json::{Value, json};

const DIMS: [u32; 3] = [36, 20, 18];

fn say(document: &mut Document, line: &Value) -> Value {
    run(document, &line.to_string()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

/// Balls of matter in noise; floats have what is not a number.
fn document(kind: u32) -> Option<Document> {
    let values = (0..DIMS.iter().product::<u32>()).map(|i| {
        let [x, y, z] = [i % DIMS[0], i / DIMS[0] % DIMS[1], i / (DIMS[0] * DIMS[1])].map(f64::from);
        let inside = |c: [f64; 3], r: f64| r - DVec3::new(x - c[0], y - c[1], z - c[2]).length();
        let depth = inside([12.0, 9.0, 9.0], 8.0).max(inside([29.0, 12.0, 10.0], 6.0));
        (60.0 * depth).clamp(-60.0, 100.0) + 80.0 + f64::from(i.wrapping_mul(2_654_435_761) >> 28)
    });
    let voxels = match kind {
        0 => Voxels::U8(values.map(|v| v as u8).collect()),
        1 => Voxels::I16(values.map(|v| (v * 10.0) as i16 - 500).collect()),
        _ => {
            Voxels::F32(values.enumerate().map(|(i, v)| if i % 97 == 0 { f32::NAN } else { v as f32 * 0.37 }).collect())
        }
    };
    let mut document = made(voxels, DIMS, DVec3::new(1.0, 1.2, 0.9))?;
    let middle = [120.0, 700.0, 44.0][kind as usize];
    let function = json!({"colour":[[0,[1,1,1]]],"opacity":[[middle - 1.0, 0],[middle, 0.9]],"unit_mm":1});
    for line in [
        json!({"transfer":{"set":{"function":function}}}),
        json!({"view":{"size":{"view":"3d","size":[64,64]}}}),
        json!({"view":{"frame":{"from":[0.4,1,0.5]}}}),
        json!({"segment":{"set":{"id":2,"name":"held","locked":true}}}),
    ] {
        say(&mut document, &line);
    }
    Some(document)
}

fn one_of<T: Clone>(rng: &mut StdRng, of: &[T]) -> T {
    of[rng.random_range(0..of.len())].clone()
}

fn settings(rng: &mut StdRng) -> Value {
    let target = match rng.random_range(0..6) {
        0 => json!({"selection":rng.random_range(0.0..1.0)}),
        1 => json!({"label":rng.random_range(1..4)}),
        2 => json!({"colour":[1, 0.5, 0, rng.random_range(0.0..1.0)]}),
        _ => json!({"density":rng.random_range(-20.0..300.0)}),
    };
    let plain = ["replace", "add", "subtract", "blend", "restore"];
    let around = ["smooth", "median", "sharpen", "raise", "lower", "push", "pull", "fill"];
    let looks = (target.get("density").is_some() || target.get("selection").is_some()) && rng.random_bool(0.6);
    let side = one_of(rng, &["inside", "outside"]);
    let falloffs = [json!("hard"), json!("smooth"), json!("gaussian"), json!({"curve":[[0,0.3],[0.4,1],[1,0.1]]})];
    let mirrors = [
        json!("off"),
        json!("off"),
        json!({"axis":"y"}),
        json!({"points":[[18,3,0],[18,20,1],[21,9,15]]}),
        json!({"face":{"part":1,"face":1}}),
    ];
    let onlys = [
        json!({}),
        json!({}),
        json!({}),
        json!({}),
        json!({"selection":side}),
        json!({"segment":{"id":1,"side":side}}),
        json!({"selection":"outside","segment":{"id":0,"side":"inside"}}),
    ];
    let mut set = json!({
        "target": target,
        "operation": if looks { one_of(rng, &around) } else { one_of(rng, &plain) },
        "shape": one_of(rng, &["sphere", "sphere", "disc", "ellipsoid"]),
        "radius_mm": one_of(rng, &[0.4, 3.0, 5.0]),
        "falloff": one_of(rng, &falloffs),
        "strength": one_of(rng, &[1.0, 0.6, 0.05]),
        "tip": one_of(rng, &["wash", "build_up"]),
        "ratio": rng.random_range(0.2..2.0),
        "height_mm": rng.random_range(0.0..3.0),
        "reach_mm": rng.random_range(0.5..2.0),
        "mirror": one_of(rng, &mirrors),
        "only": one_of(rng, &onlys),
        "connected": rng.random_bool(0.12),
        "visible_only": rng.random_bool(0.1),
        "erase": rng.random_bool(0.08),
        "pressure": {"strength": rng.random_bool(0.7), "radius": rng.random_bool(0.3)},
    });
    if rng.random_bool(0.25) {
        set["range"] = json!([rng.random_range(-50.0..60.0), rng.random_range(60.0..900.0)]);
    } else {
        set["any_value"] = json!(true);
    }
    if rng.random_bool(0.15) {
        set["within_mm"] = json!(rng.random_range(0.0..4.0));
    } else {
        set["any_depth"] = json!(true);
    }
    set
}

fn stroke(rng: &mut StdRng) -> Value {
    let mut place = || json!({"index": DIMS.map(|d| rng.random_range(-2.0..f64::from(d) + 2.0))});
    let [a, b, c] = [place(), place(), place()];
    match rng.random_range(0..4) {
        0 => {
            json!({"stroke":{"lasso":{"points":[a, b, c],"normal":[0.2,0.3,1],"depth_mm":rng.random_range(0.0..3.0)}}})
        }
        1 => {
            let px = |rng: &mut StdRng| json!({"at":{"pixel":{"view":"3d","px":[rng.random_range(16.0..48.0), rng.random_range(16.0..48.0)]}}});
            json!({"stroke":{"paint":{"points":[px(rng), px(rng)]}}})
        }
        _ => json!({"stroke":{"paint":{"points":[{"at":a},{"at":b,"pressure":rng.random_range(0.0..1.0)}]}}}),
    }
}

#[test]
fn every_stroke_is_undone_done_again_and_told_to_the_byte() {
    let mut rng = StdRng::seed_from_u64(20);
    for kind in 0..3 {
        let (Some(mut document), Some(mut other)) = (document(kind), document(kind)) else { return };
        let (mut steps, mut nothing) = (0, 0);
        while steps < 6 && nothing < 40 {
            let set = settings(&mut rng);
            say(&mut document, &json!({"brush":{"set":set}}));
            let line = stroke(&mut rng);
            let before = bytes(&document);
            let answer = say(&mut document, &line);
            if answer["step"].is_null() {
                nothing += 1;
                assert!(answer["nothing"].is_string(), "{set} {line}: {answer}");
                assert!(bytes(&document) == before, "{set} {line}");
                continue;
            }
            steps += 1;
            let after = bytes(&document);
            say(&mut document, &json!({"history":{"undo":{}}}));
            assert!(bytes(&document) == before, "undo of {set} {line}");
            say(&mut document, &json!({"history":{"redo":{}}}));
            assert!(bytes(&document) == after, "redo of {set} {line}");
            let told = say(&mut document, &json!({"ask":{"history":{"commands":true}}}));
            let step = told["undo_commands"][0][0].clone();
            let mut brush = step["brush"].clone();
            let fields = brush.as_object_mut().unwrap();
            fields.remove("falloff_before_labels");
            for (field, none) in [("range", "any_value"), ("within_mm", "any_depth")] {
                if fields.get(field).is_none_or(Value::is_null) {
                    fields.insert(none.into(), json!(true));
                }
            }
            for (field, default) in [
                ("only", json!({})),
                ("connected", json!(false)),
                ("mirror", json!("off")),
                ("pressure", json!({"strength":true,"radius":false})),
                ("ratio", json!(0.5)),
                ("depth_mm", json!(0.0)),
            ] {
                fields.entry(field).or_insert(default);
            }
            say(&mut other, &json!({"brush":{"set":brush}}));
            say(&mut other, &step["command"]);
            assert!(bytes(&other) == after, "what the step says of {set} {line}: {step}");
        }
        assert!(steps == 6, "{kind}: {steps}, and {nothing} that changed nothing");
    }
}
