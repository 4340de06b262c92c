//! Surfaces that a brush moves along their normals, measured where the values cross the middle.

use super::maker::run;
use super::maker_gpu::made;
use crate::common::one::One;
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::Voxels;
use serde_json::{Value, json};

const RADIUS: f64 = 40.0;
const CENTRE: DVec3 = DVec3::new(45.2, 45.7, 5.1);

fn say(document: &mut Document, line: Value) -> Value {
    run(document, &line.to_string()).unwrap_or_else(|e| panic!("{line}: {e}"))
}

/// The upper half of a ball of 40 voxels' radius; its values fall from 200 to 0 over `soft` voxels.
fn ball(soft: f64, spacing: DVec3) -> Option<Document> {
    let dims: [u32; 3] = (DVec3::new(92.0, 92.0, 54.0) / spacing).to_array().map(|d| d as u32);
    let mut voxels = Vec::new();
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                let at = DVec3::new(f64::from(x), f64::from(y), f64::from(z)) * spacing;
                let depth = (RADIUS - at.distance(CENTRE)) / soft + 0.5;
                voxels.push((200.0 * depth.clamp(0.0, 1.0)).round() as u8);
            }
        }
    }
    made(Voxels::U8(voxels), dims, spacing)
}

/// A direction from the ball's middle: along the swipe, and across it, degrees from the top.
fn toward(along: f64, across: f64) -> DVec3 {
    let (a, b) = (along.to_radians(), across.to_radians());
    DVec3::new(a.sin() * b.cos(), b.sin(), a.cos() * b.cos())
}

/// The radius at which values between voxels cross 100.
fn surface(document: &Document, spacing: DVec3, direction: DVec3) -> f64 {
    let density = &document.state().unwrap().one().density;
    let value = |r: f64| {
        let at = (CENTRE + direction * r) / spacing;
        let (base, part) = (at.floor(), at - at.floor());
        let mut sum = 0.0;
        for corner in 0..8_u32 {
            let step = [corner & 1, corner >> 1 & 1, corner >> 2];
            let voxel = std::array::from_fn(|a| base[a] as u32 + step[a]);
            let share: f64 = (0..3).map(|a| if step[a] == 1 { part[a] } else { 1.0 - part[a] }).product();
            sum += share * f64::from(density.value(voxel).unwrap());
        }
        sum
    };
    let steps = (0..400).map(|i| RADIUS + 6.0 - f64::from(i) * 0.03);
    let mut outer = RADIUS + 6.0;
    for r in steps {
        if value(r) >= 100.0 {
            let (a, b) = (value(r), value(outer));
            return r + (outer - r) * (a - 100.0) / (a - b).max(1e-9);
        }
        outer = r;
    }
    panic!("no surface along {direction}");
}

fn swipe(document: &mut Document, settings: Value) {
    say(document, json!({"brush":{"set":settings}}));
    let points: Vec<_> =
        (-5..=5).map(|i| json!({"at":{"mm":(CENTRE + toward(f64::from(i) * 4.0, 0.0) * RADIUS).to_array()}})).collect();
    say(document, json!({"stroke":{"paint":{"points":points}}}));
}

#[test]
fn a_swipe_raises_the_surface_evenly_by_its_height() {
    for (soft, spacing, radius) in
        [(2.0, DVec3::ONE, 8.0), (0.01, DVec3::ONE, 6.0), (3.0, DVec3::new(1.0, 1.25, 0.8), 8.0)]
    {
        for (operation, way) in [("raise", 2.0), ("lower", -2.0), ("pull", 2.0), ("push", -2.0)] {
            let Some(mut document) = ball(soft, spacing) else { return };
            let settings = json!({"radius_mm":radius,"falloff":"smooth","target":{"density":0},
                "operation":operation,"height_mm":2});
            swipe(&mut document, settings);
            let plain = ball(soft, spacing).unwrap();
            let moved: Vec<f64> = (-36..=36)
                .map(|i| toward(f64::from(i) * 0.5, 0.0))
                .map(|d| surface(&document, spacing, d) - surface(&plain, spacing, d))
                .collect();
            let mean = moved.iter().sum::<f64>() / moved.len() as f64;
            let uneven = (moved.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / moved.len() as f64).sqrt();
            let worst = moved.iter().map(|m| (m - way).abs()).fold(0.0, f64::max);
            println!("{operation} soft {soft}: mean {mean:.3}, worst {worst:.3} off, uneven {uneven:.3}");
            // A step that is one voxel sharp is known no better than to half of one.
            let allowed = if soft < 1.0 { 0.6 } else { 0.25 };
            assert!((mean - way).abs() <= 0.25 && worst <= allowed, "{operation} {soft}: {mean} {worst}");
            assert!(uneven <= 0.25, "{operation} {soft}: {uneven}");
            // Beyond the rim nothing moves.
            let beside = toward(0.0, 20.0);
            assert!((surface(&document, spacing, beside) - surface(&plain, spacing, beside)).abs() < 1e-6);
        }
    }
}

#[test]
fn what_was_pushed_in_is_pulled_out_again() {
    for (soft, there, back) in [(3.0, "push", "pull"), (2.0, "pull", "push")] {
        let Some(mut document) = ball(soft, DVec3::ONE) else { return };
        let plain = ball(soft, DVec3::ONE).unwrap();
        for operation in [there, back] {
            let settings = json!({"radius_mm":9,"falloff":"smooth","target":{"density":0},
                "operation":operation,"height_mm":2});
            swipe(&mut document, settings);
        }
        let mut worst: f64 = 0.0;
        for along in [-12.0, -4.0, 0.0, 7.0, 14.0] {
            for across in [-12.0, -8.0, -4.0, 0.0, 2.0, 6.0, 10.0] {
                let d = toward(along, across);
                worst = worst.max((surface(&document, DVec3::ONE, d) - surface(&plain, DVec3::ONE, d)).abs());
            }
        }
        println!("{there}, then {back}: {worst:.3} voxels off at worst");
        assert!(worst <= 0.05 * 2.0, "{there} {back}: {worst}");
    }
}

/// Root of the mean square of what is left of a surface's way, of a point in it, after a stroke there and one back, in voxels.
fn left_over(
    document: &mut Document,
    plain: &Document,
    spacing: DVec3,
    settings: &Value,
    [there, back]: [&str; 2],
) -> f64 {
    for operation in [there, back] {
        let mut settings = settings.clone();
        settings["operation"] = json!(operation);
        settings["target"] = json!({"density": 0});
        swipe(document, settings);
    }
    let mut squares = Vec::new();
    for along in -3..=3 {
        for across in -4..=4 {
            let d = toward(f64::from(along) * 4.0, f64::from(across) * 2.5);
            squares.push((surface(document, spacing, d) - surface(plain, spacing, d)).powi(2));
        }
    }
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

#[test]
fn a_stroke_there_and_one_back_leave_a_twentieth_of_the_height_at_most() {
    let (pushed, raised) = (["push", "pull"], [["raise", "lower"], ["lower", "raise"]]);
    for (radius, height, pairs) in [(9.0, 2.0, &raised[..]), (9.0, 4.0, &[pushed][..])] {
        for pair in pairs {
            let Some(mut document) = ball(2.5, DVec3::ONE) else { return };
            let plain = ball(2.5, DVec3::ONE).unwrap();
            let settings = json!({"radius_mm":radius,"falloff":"smooth","height_mm":height});
            let left = left_over(&mut document, &plain, DVec3::ONE, &settings, *pair) / height;
            println!("radius {radius}, height {height}: {} then {}: {left:.3} of the height", pair[0], pair[1]);
            assert!(left <= 0.05, "{radius} {height} {pair:?}: {left}");
        }
    }
}
