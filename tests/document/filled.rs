//! Filling in against a dense solver of Laplace's equation, and what must hold of any such filling.

use super::maker::run;
use super::maker_gpu::made;
use crate::common::one::One;
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::Voxels;
use serde_json::{Value, json};

const DIMS: [u32; 3] = [40, 36, 34];
const SPACING: DVec3 = DVec3::new(1.0, 1.3, 0.7);

fn say(document: &mut Document, line: Value) -> Value {
    run(document, &line.to_string()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

fn all() -> impl Iterator<Item = [u32; 3]> {
    (0..DIMS[2]).flat_map(|z| (0..DIMS[1]).flat_map(move |y| (0..DIMS[0]).map(move |x| [x, y, z])))
}

fn place(v: [u32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from)) * SPACING
}

fn value(document: &Document, v: [u32; 3]) -> f64 {
    f64::from(document.state().unwrap().one().density.value(v).unwrap())
}

fn index(v: [u32; 3]) -> usize {
    (v[0] + DIMS[0] * (v[1] + DIMS[1] * v[2])) as usize
}

/// Σ (u(beside) − u)/h² = 0 for each of these voxels, the others held, by elimination.
fn dense(values: &[f64], domain: &[[u32; 3]]) -> Vec<f64> {
    let n = domain.len();
    let number = |v: [u32; 3]| domain.iter().position(|d| *d == v);
    let mut rows = vec![vec![0.0; n + 1]; n];
    for (i, v) in domain.iter().enumerate() {
        for axis in 0..3 {
            let w = 1.0 / SPACING[axis].powi(2);
            for step in [-1_i64, 1] {
                let to = i64::from(v[axis]) + step;
                if to < 0 || to >= i64::from(DIMS[axis]) {
                    continue;
                }
                let mut beside = *v;
                beside[axis] = to as u32;
                let held = values[index(beside)];
                match number(beside) {
                    Some(j) => rows[i][j] -= w,
                    None if held.is_finite() => rows[i][n] += w * held,
                    None => continue,
                }
                rows[i][i] += w;
            }
        }
    }
    for i in 0..n {
        let (head, tail) = rows.split_at_mut(i + 1);
        let pivot = &head[i];
        for row in tail.iter_mut().filter(|row| row[i] != 0.0) {
            let factor = row[i] / pivot[i];
            row.iter_mut().zip(pivot).skip(i).for_each(|(a, b)| *a -= factor * b);
        }
    }
    let mut u = vec![0.0; n];
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|j| rows[i][j] * u[j]).sum();
        u[i] = (rows[i][n] - known) / rows[i][i];
    }
    u
}

/// A hole of zeros and what is not a number in something that curves, across a border of bricks.
fn holed() -> Vec<f64> {
    let middle = DVec3::new(31.0, 14.0, 7.0);
    all()
        .map(|v| {
            let p = place(v);
            match p.distance(middle) {
                d if d < 1.1 => f64::NAN,
                d if d < 2.6 => 0.0,
                _ => f64::from((80.0 + 1.7 * p.x - 0.8 * p.y + 0.05 * p.x * p.z + 4.0 * (p.y * 0.7).sin()) as f32),
            }
        })
        .collect()
}

/// The points of a stroke of two dabs, and what it covers.
const POINTS: [[f64; 3]; 2] = [[30.2, 13.8, 7.1], [31.6, 14.6, 7.0]];
const RADIUS: f64 = 3.05;

#[test]
fn a_hole_is_filled_in_as_a_dense_solver_does() {
    let values = holed();
    let Some(mut document) = made(Voxels::F32(values.iter().map(|v| *v as f32).collect()), DIMS, SPACING) else {
        return;
    };
    let settings = json!({"radius_mm":RADIUS,"falloff":"hard","target":{"density":0},"operation":"fill"});
    say(&mut document, json!({"brush":{"set":settings}}));
    let points = POINTS.map(|p| json!({"at":{"mm":p},"breaks":true}));
    let domain: Vec<_> =
        all().filter(|v| POINTS.iter().any(|p| place(*v).distance(DVec3::from_array(*p)) <= RADIUS)).collect();
    let expected = dense(&values, &domain);
    for live in [false, true] {
        if live {
            say(&mut document, json!({"stroke":{"begin":{"points":[points[0]]}}}));
            say(&mut document, json!({"stroke":{"extend":{"points":[points[1]]}}}));
            say(&mut document, json!({"stroke":{"end":{}}}));
        } else {
            say(&mut document, json!({"stroke":{"paint":{"points":points}}}));
        }
        for (v, expected) in domain.iter().zip(&expected) {
            let found = value(&document, *v);
            assert!((found - expected).abs() < 1e-3, "{live} {v:?}: {found} for {expected}");
        }
        let changed = all().filter(|v| value(&document, *v).to_bits() != values[index(*v)].to_bits()).count();
        let same = |v: &[u32; 3]| {
            let (a, b) = (value(&document, *v), values[index(*v)]);
            a == b || a.is_nan() && b.is_nan()
        };
        assert!(changed > 50 && all().filter(|v| !domain.contains(v)).all(|v| same(&v)));
        // No value lies beyond those at the rim.
        let rim = domain.iter().flat_map(|v| {
            let v = *v;
            (0..3).flat_map(move |axis| [-1_i64, 1].map(|step| (axis, step))).map(move |(axis, step)| {
                let mut beside = v;
                beside[axis] = (i64::from(v[axis]) + step) as u32;
                beside
            })
        });
        let held: Vec<f64> = rim.filter(|v| !domain.contains(v)).map(|v| values[index(v)]).collect();
        let (least, most) = held.iter().fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
        assert!(domain.iter().all(|v| (least..=most).contains(&value(&document, *v))));
        say(&mut document, json!({"history":{"undo":{}}}));
        assert!(all().all(|v| {
            let (a, b) = (value(&document, v), values[index(v)]);
            a == b || a.is_nan() && b.is_nan()
        }));
    }
}

#[test]
fn what_is_even_is_filled_in_as_it_was_and_a_range_leaves_the_rest() {
    // A bright streak through a ramp; the ramp comes back, whose own voxels a range of values keeps.
    let ramp = |v: [u32; 3]| 20.0 + 2.0 * f64::from(v[0]) + f64::from(v[1]) + f64::from(v[2]);
    let streak = |v: [u32; 3]| v[1].abs_diff(18) <= 1 && v[2].abs_diff(17) <= 1;
    let voxels = all().map(|v| if streak(v) { 255 } else { ramp(v) as u8 }).collect();
    let Some(mut document) = made(Voxels::U8(voxels), DIMS, DVec3::ONE) else { return };
    let settings = json!({"radius_mm":4,"falloff":"hard","target":{"density":0},"operation":"fill","range":[200,255]});
    say(&mut document, json!({"brush":{"set":settings}}));
    say(&mut document, json!({"stroke":{"paint":{"points":[{"at":{"index":[6,18,17]}},{"at":{"index":[33,18,17]}}]}}}));
    for v in all() {
        let found = value(&document, v);
        if streak(v) && (6..=33).contains(&v[0]) && (8..32).contains(&v[0]) {
            assert!((found - ramp(v)).abs() < 1.0, "{v:?}: {found} for {}", ramp(v));
        } else if !streak(v) {
            assert_eq!(found, ramp(v), "{v:?}");
        }
    }
}
