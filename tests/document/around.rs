//! Neighbourhood operators of the brush against plain loops from their equations, on anisotropic grids across borders of bricks.

use super::maker::run;
use super::maker_gpu::made;
use crate::common::one::One;
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::{FieldKind, Voxels};
use serde_json::{Value, json};

const DIMS: [u32; 3] = [42, 37, 35];
const SPACING: DVec3 = DVec3::new(1.0, 0.8, 1.7);

fn say(document: &mut Document, line: Value) -> Value {
    run(document, &line.to_string()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

fn all() -> impl Iterator<Item = [i64; 3]> {
    let [x, y, z] = DIMS.map(i64::from);
    (0..z).flat_map(move |k| (0..y).flat_map(move |j| (0..x).map(move |i| [i, j, k])))
}

/// Repeated beyond the border.
fn at(values: &[f64], v: [i64; 3]) -> f64 {
    let [x, y, z]: [usize; 3] = std::array::from_fn(|a| v[a].clamp(0, i64::from(DIMS[a]) - 1) as usize);
    values[x + DIMS[0] as usize * (y + DIMS[1] as usize * z)]
}

fn noise(v: [i64; 3]) -> u32 {
    let h = (v[0] as u32).wrapping_mul(0x9e37_79b1) ^ (v[1] as u32).wrapping_mul(0x85eb_ca6b);
    let h = (h ^ (v[2] as u32).wrapping_mul(0xc2b2_ae35) ^ 77).wrapping_mul(0x2c1b_3c6d);
    h ^ h >> 13
}

fn density(document: &Document) -> Vec<f64> {
    let field = &document.state().unwrap().one().density;
    all().map(|v| f64::from(field.value(v.map(|v| v as u32)).unwrap())).collect()
}

fn selection(document: &Document) -> Vec<f64> {
    let texels = document.state().unwrap().one().field(FieldKind::Selection).read(0, [0; 3], DIMS).unwrap();
    texels.into_iter().map(f64::from).collect()
}

/// Mean of the box of 3 σ, weighted by e^(−d²/2σ²), of what is a number.
fn gaussian(values: &[f64], v: [i64; 3], sigma: f64) -> f64 {
    let reach = SPACING.to_array().map(|h| (3.0 * sigma / h + 1e-9).floor() as i64);
    let (mut sum, mut weight) = (0.0, 0.0);
    for z in -reach[2]..=reach[2] {
        for y in -reach[1]..=reach[1] {
            for x in -reach[0]..=reach[0] {
                let value = at(values, [v[0] + x, v[1] + y, v[2] + z]);
                let d = (DVec3::new(x as f64, y as f64, z as f64) * SPACING).length();
                if value.is_finite() {
                    let w = (-d * d / (2.0 * sigma * sigma)).exp();
                    sum += w * value;
                    weight += w;
                }
            }
        }
    }
    sum / weight
}

fn median(values: &[f64], v: [i64; 3], radius: f64) -> f64 {
    let mut near = Vec::new();
    for z in -5..=5_i64 {
        for y in -5..=5_i64 {
            for x in -5..=5_i64 {
                let value = at(values, [v[0] + x, v[1] + y, v[2] + z]);
                let d = (DVec3::new(x as f64, y as f64, z as f64) * SPACING).length();
                if d <= radius + 1e-9 && value.is_finite() {
                    near.push(value);
                }
            }
        }
    }
    near.sort_by(f64::total_cmp);
    let n = near.len();
    if n % 2 == 1 { near[n / 2] } else { (near[n / 2 - 1] + near[n / 2]) / 2.0 }
}

/// G of a wash of smooth dabs at these places.
fn coverage(v: [i64; 3], centres: &[DVec3], radius: f64, strength: f64) -> f64 {
    let place = DVec3::new(v[0] as f64, v[1] as f64, v[2] as f64) * SPACING;
    let g = |c: &DVec3| {
        let x = place.distance(*c) / radius;
        if x < 1.0 { strength * (1.0 - x * x).powi(2) } else { 0.0 }
    };
    centres.iter().map(g).fold(0.0, f64::max)
}

/// Two clicks' worth of a stroke: the places break, so that there is a dab at each and none between.
const PLACES: [[f64; 3]; 2] = [[31.2, 25.1, 54.0], [8.0, 5.1, 12.4]];

fn stroke(document: &mut Document, settings: Value) {
    say(document, json!({"brush":{"set":settings}}));
    let points = PLACES.map(|p| json!({"at":{"mm":p},"breaks":true}));
    say(document, json!({"stroke":{"paint":{"points":points}}}));
}

#[test]
fn values_go_toward_the_mean_or_median_about_them_or_away_from_it() {
    let bytes: Vec<f64> = all().map(|v| f64::from(noise(v) % 256)).collect();
    let floats: Vec<f64> = all()
        .map(|v| match noise(v) % 40 {
            0 => f64::NAN,
            n => f64::from((n as f32) * 3.7 - 60.0),
        })
        .collect();
    let centres = PLACES.map(DVec3::from_array);
    let ends = |values: &[f64]| {
        let finite = || values.iter().copied().filter(|v| v.is_finite());
        [finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max)]
    };
    for (values, is_float) in [(&bytes, false), (&floats, true)] {
        for (operation, length) in [("smooth", 1.1), ("median", 1.75), ("sharpen", 0.9)] {
            let voxels = match is_float {
                true => Voxels::F32(values.iter().map(|v| *v as f32).collect()),
                false => Voxels::U8(values.iter().map(|v| *v as u8).collect()),
            };
            let Some(mut document) = made(voxels, DIMS, SPACING) else { return };
            let settings = json!({"radius_mm":7.5,"strength":0.8,"falloff":"smooth","target":{"density":0},
                "operation":operation,"reach_mm":length});
            stroke(&mut document, settings);
            let (found, [least, most]) = (density(&document), ends(values));
            let mut changed = 0;
            for (i, v) in all().enumerate() {
                let (p, g) = (values[i], coverage(v, &centres, 7.5, 0.8));
                if g == 0.0 || !p.is_finite() {
                    assert!(found[i] == p || !p.is_finite() && !found[i].is_finite(), "{operation} {v:?}");
                    continue;
                }
                let c = match operation {
                    "smooth" => gaussian(values, v, length),
                    "median" => median(values, v, length),
                    _ => (2.0 * p - gaussian(values, v, length)).clamp(least, most),
                };
                let expected = p + g * (c - p);
                changed += usize::from((expected - p).abs() > 0.5);
                // Codes are 1/257 of a step of 8 bits, and f32 rounds by a millionth of some hundred.
                assert!((found[i] - expected).abs() < 0.004, "{operation} {v:?}: {} for {expected} from {p}", found[i]);
            }
            assert!(changed > 500, "{operation}: {changed}");
            say(&mut document, json!({"history":{"undo":{}}}));
            let back = density(&document);
            assert!(back.iter().zip(values).all(|(a, b)| a == b || a.is_nan() && b.is_nan()));
        }
    }
}

#[test]
fn the_selection_is_smoothed_too() {
    let Some(mut document) = made(Voxels::U8(vec![9; 42 * 37 * 35]), DIMS, SPACING) else { return };
    say(&mut document, json!({"brush":{"set":{"radius_mm":5,"falloff":"hard","target":{"selection":1}}}}));
    say(&mut document, json!({"stroke":{"paint":{"points":[{"at":{"mm":[29,25,52]}}]}}}));
    let before = selection(&document);
    stroke(&mut document, json!({"radius_mm":7.5,"falloff":"smooth","operation":"smooth","reach_mm":1.2}));
    let (found, centres) = (selection(&document), PLACES.map(DVec3::from_array));
    let mut between = 0;
    for (i, v) in all().enumerate() {
        let g = coverage(v, &centres, 7.5, 1.0);
        let expected = before[i] + g * (if g > 0.0 { gaussian(&before, v, 1.2) } else { 0.0 } - before[i]);
        assert!((found[i] - expected).abs() < 0.51, "{v:?}: {} for {expected}", found[i]);
        between += usize::from(found[i] > 0.0 && found[i] < 255.0);
    }
    assert!(between > 300, "{between}");
}

#[test]
fn what_a_brush_cannot_do_is_refused_by_name() {
    let Some(mut document) = made(Voxels::U8(vec![9; 42 * 37 * 35]), DIMS, SPACING) else { return };
    for (set, said) in [
        (json!({"operation":"smooth","target":{"colour":[1,0,0,1]}}), "operation"),
        (json!({"operation":"raise","target":{"label":1}}), "operation"),
        (json!({"reach_mm":0}), "reach_mm"),
        (json!({"height_mm":-1}), "height_mm"),
        (json!({"ratio":0}), "ratio"),
    ] {
        let error = run(&mut document, &json!({"brush":{"set":set}}).to_string()).unwrap_err().to_string();
        assert!(error.contains(said), "{set}: {error}");
    }
    for (set, said) in [
        (json!({"operation":"smooth","target":{"density":0},"reach_mm":7}), "reach_mm"),
        (json!({"operation":"median","reach_mm":4.1}), "reach_mm"),
        (json!({"operation":"pull","height_mm":10}), "height_mm"),
    ] {
        say(&mut document, json!({"brush":{"set":set}}));
        let stroke = json!({"stroke":{"paint":{"points":[{"at":{"mm":[20,20,20]}}]}}});
        let error = run(&mut document, &stroke.to_string()).unwrap_err().to_string();
        assert!(error.contains(said), "{set}: {error}");
    }
    // Whoever goes on to colours paints plainly.
    let answer = say(&mut document, json!({"brush":{"set":{"target":{"colour":[1,0,0,1]}}}}));
    assert_eq!(answer["brush"]["operation"], "replace");
}
