//! What a hand feels of a surface: depth, normal and force from the voxels on the host, and how quickly they are told.

use super::maker::run;
use super::maker_gpu::block;
use burin::document::{Command, ContactField, ContactForce, Document, Origin, Place, Question, State};
use burin::math::DVec3;
use burin::volume::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::sync::Arc;
use std::time::Instant;

pub const MIDDLE: DVec3 = DVec3::new(40.3, 39.6, 40.1);
pub const RADIUS: f64 = 30.0;
/// Per mm of depth.
const SLOPE: f64 = 10.0;
pub const ISO: f64 = 100.0;

/// A document over voxels; asks for no device.
pub fn over(dims: [u32; 3], spacing: DVec3, value: impl Fn(DVec3) -> f64) -> Document {
    let grid = Grid::aligned(dims, spacing, DVec3::ZERO);
    let at = |[x, y, z]: [u32; 3]| DVec3::new(f64::from(x), f64::from(y), f64::from(z)) * spacing;
    let voxels = Voxels::F32(crate::common::volumes::each(dims, |v| value(at(v)) as f32));
    let source = Arc::new(MemorySource::new("made", grid, voxels, (1.0, 0.0)).unwrap());
    let statistics = burin::io::statistics(source.as_ref(), &|_| true).unwrap();
    let histogram = Histogram { min: statistics.min, max: statistics.max, bins: vec![1; 4], ..Histogram::default() };
    let origin = Origin { path: "made.nrrd".into(), component: 0, frame: 0 };
    let mut document = Document::new();
    document.adopt(State::new(source, origin, statistics, histogram, None, &|_| true).unwrap());
    document
}

/// A ball whose values fall outward by 10 a mm, 100 on its surface.
pub fn ball() -> Document {
    over([81; 3], DVec3::ONE, |p| ISO + SLOPE * (RADIUS - p.distance(MIDDLE)))
}

/// A ball with bumps of many sizes, as a head has them, on voxels that are no cubes.
pub fn head() -> Document {
    over([81, 70, 60], DVec3::new(1.0, 1.2, 1.4), |p| {
        let d = p - MIDDLE;
        let bumps: f64 = [(0.21, 2.5), (0.47, 1.2), (0.9, 0.5)]
            .iter()
            .map(|(f, a)| a * ((d.x * f).sin() * (d.y * f * 1.1 + 1.0).cos() + (d.z * f * 0.9 + 2.0).sin()))
            .sum();
        ISO + 40.0 * ((RADIUS - 4.0 - d.length() + bumps) * SLOPE / 40.0).tanh()
    })
}

pub fn direction(rng: &mut ChaCha8Rng) -> DVec3 {
    loop {
        let d = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        if (0.1..1.0).contains(&d.length()) {
            return d.normalize();
        }
    }
}

fn law(most_n: f64) -> ContactForce {
    ContactForce { stiffness_n_per_mm: 0.5, most_n, tolerance_mm: 0.25 }
}

#[test]
fn a_ball_pushes_outward_by_stiffness_times_depth() {
    let document = ball();
    let mut rng = ChaCha8Rng::seed_from_u64(31);
    let (mut askew, mut off): (f64, f64) = (0.0, 0.0);
    for _ in 0..300 {
        let (outward, depth) = (direction(&mut rng), rng.random_range(0.5..3.0));
        let at = MIDDLE + outward * (RADIUS - depth);
        let field = document.contact_field(at, None).unwrap();
        let contact = field.contact(at, ISO, &law(10.0));
        assert!(contact.known && contact.inside && contact.touching);
        askew = askew.max(contact.force_n.angle_between(outward).to_degrees());
        off = off.max((contact.force_n.length() / (0.5 * depth) - 1.0).abs());
        let capped = field.contact(at, ISO, &law(0.2));
        assert!((capped.force_n.length() - 0.2).abs() < 1e-12, "{capped:?}");
    }
    println!("a ball's force: {askew:.2} degrees askew, {:.2} % off", off * 100.0);
    assert!(askew < 3.0 && off < 0.02, "{askew} {off}");
}

#[test]
fn contact_is_a_distance_within_the_tolerance_and_nothing_pulls() {
    let document = ball();
    let field = document.contact_field(MIDDLE + DVec3::X * RADIUS, None).unwrap();
    let at = |depth: f64| field.contact(MIDDLE + DVec3::X * (RADIUS - depth), ISO, &law(10.0));
    for depth in [-2.0, -0.3] {
        let contact = at(depth);
        assert!(contact.known && !contact.inside && !contact.touching, "{depth}: {contact:?}");
    }
    for depth in [-0.2, -0.05] {
        let contact = at(depth);
        assert!(!contact.inside && contact.touching, "{depth}: {contact:?}");
        assert_eq!(contact.force_n, DVec3::ZERO, "a surface does not pull");
        assert!((contact.depth_mm.unwrap() - depth).abs() < 0.02, "{depth}: {contact:?}");
    }
    // Far from where the field was taken, and outside of the volume, nothing is known.
    assert!(!field.contact(MIDDLE - DVec3::X * RADIUS, ISO, &law(10.0)).known);
    let corner = document.contact_field(DVec3::ZERO, None).unwrap();
    assert!(!corner.contact(DVec3::splat(-3.0), ISO, &law(10.0)).known);
    assert!(!field.contact(DVec3::NAN, ISO, &law(10.0)).known);
}

#[test]
fn where_the_field_is_even_there_is_no_depth() {
    let document = over([40; 3], DVec3::ONE, |p| if p.distance(DVec3::splat(20.0)) < 12.0 { 200.0 } else { 0.0 });
    let field = document.contact_field(DVec3::splat(20.0), None).unwrap();
    let contact = field.contact(DVec3::splat(20.0), ISO, &law(1.0));
    assert!(contact.known && contact.inside && contact.touching, "{contact:?}");
    assert_eq!((contact.depth_mm, contact.normal, contact.force_n), (None, None, DVec3::ZERO));
}

/// Walks about the surface at 1,000 steps a second as a hand does, and tells how long answers took, microseconds, in order.
fn walked(document: &Document, steps: usize) -> (usize, usize, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let feed = document.touch();
    let (mut field, mut at, mut speed) = (None::<ContactField>, MIDDLE + DVec3::Y * RADIUS, DVec3::ZERO);
    let (mut known, mut touched, mut took, mut renewed) = (0, 0, Vec::new(), Vec::new());
    for step in 0..steps {
        // A frame of 60 a second.
        if step % 16 == 0 {
            feed.want(at, None);
            let begun = Instant::now();
            if document.renew_touch().unwrap() {
                renewed.push(begun.elapsed().as_secs_f64() * 1e3);
            }
        }
        let begun = Instant::now();
        field = feed.latest(field.take());
        let contact = field.as_ref().unwrap().contact(at, ISO, &law(2.0));
        took.push(begun.elapsed().as_secs_f64() * 1e6);
        known += usize::from(contact.known);
        touched += usize::from(contact.touching);
        // Up to 200 mm/s along the surface.
        speed = (speed + direction(&mut rng) * 0.02).clamp_length_max(0.2);
        at += speed;
        at = MIDDLE + (at - MIDDLE).normalize() * rng.random_range(RADIUS - 6.0..RADIUS + 2.0);
    }
    println!("{} fields, each in {:.1} ms", renewed.len(), renewed.iter().sum::<f64>() / renewed.len() as f64);
    took.sort_by(f64::total_cmp);
    (known, touched, took)
}

#[test]
fn a_device_is_answered_a_thousand_times_a_second() {
    for (name, document) in [("ball", ball()), ("head", head())] {
        let (known, touched, took) = walked(&document, 5_000);
        let (median, worst) = (took[took.len() / 2], took[took.len() - 1]);
        let under = took.iter().filter(|t| **t < 1_000.0).count();
        println!(
            "{name}: {known} of 5000 known, {touched} touch; {median:.2} µs in the middle, {worst:.0} µs at worst, {under} under 1 ms"
        );
        assert_eq!(known, 5_000, "{name}");
        assert!(touched > 500, "{name}: {touched}");
        // The thread may lose the processor now and then; an answer alone takes a hundredth of what it may.
        assert!(median < 100.0, "{name}: {median}");
    }
}

#[test]
fn a_thread_of_its_own_is_answered_while_the_document_works() {
    let mut document = ball();
    let feed = document.touch();
    feed.want(MIDDLE + DVec3::X * RADIUS, None);
    assert!(document.renew_touch().unwrap());
    assert!(!document.renew_touch().unwrap(), "nothing is new");
    let thread = std::thread::spawn(move || {
        let (mut field, mut known) = (None, 0);
        for step in 0..2_000_u32 {
            let at = MIDDLE + DVec3::X * (RADIUS - f64::from(step % 100) * 0.01);
            feed.want(at, None);
            field = feed.latest(field);
            known += usize::from(field.as_ref().is_some_and(|f| f.contact(at, ISO, &law(2.0)).known));
            std::thread::yield_now();
        }
        known
    });
    for _ in 0..20 {
        run(&mut document, r#"{"volume":{"set":{"volume":0,"opacity":0.5}}}"#).unwrap();
        document.renew_touch().unwrap();
    }
    assert_eq!(thread.join().unwrap(), 2_000);
}

fn felt(document: &mut Document, mm: DVec3) -> Value {
    let ask = json!({"ask":{"contact":{"at":{"mm":mm.to_array()},"value":100,"stiffness":2,"most":5}}});
    run(document, &ask.to_string()).unwrap()
}

#[test]
fn a_script_is_told_what_a_device_feels() {
    let mut document = ball();
    let outward = DVec3::new(1.0, 2.0, -2.0) / 3.0;
    let said = felt(&mut document, MIDDLE + outward * (RADIUS - 1.5));
    let vector = |name: &str| DVec3::from_array(serde_json::from_value(said[name].clone()).unwrap());
    assert_eq!((&said["touching"], &said["inside"], &said["known"]), (&json!(true), &json!(true), &json!(true)));
    assert!((said["depth_mm"].as_f64().unwrap() - 1.5).abs() < 0.02, "{said}");
    assert!(vector("normal").angle_between(outward) < 0.03 && vector("normal").is_normalized(), "{said}");
    assert!((vector("force_n") - vector("normal") * 3.0).length() < 0.06, "{said}");
    let deep = felt(&mut document, MIDDLE + outward * (RADIUS - 9.0));
    let force = DVec3::from_array(serde_json::from_value(deep["force_n"].clone()).unwrap());
    assert!((force.length() - 5.0).abs() < 1e-9, "{deep}");
    // The surface that is shown is the one that is meant.
    run(&mut document, r#"{"view":{"look":{"mode":{"iso":120}}}}"#).unwrap();
    let at = Place::Mm((MIDDLE + outward * (RADIUS - 1.5)).to_array());
    let shown = run(&mut document, &json!({"ask":{"contact":{"at":at}}}).to_string()).unwrap();
    assert_eq!((&shown["value"], &shown["inside"]), (&json!(120.0), &json!(false)), "{shown}");
}

#[test]
fn what_cannot_be_felt_is_refused_with_what_is_wrong() {
    let mut document = ball();
    let at = json!({"mm":[40, 40, 40]});
    for (question, words) in [
        (json!({"at":at}), ["value", "nothing"]),
        (json!({"at":at,"value":1,"stiffness":0}), ["stiffness", "positive"]),
        (json!({"at":at,"value":1,"most":-1}), ["most", "positive"]),
        (json!({"at":at,"value":1,"tolerance_mm":-0.5}), ["tolerance_mm", "0 or more"]),
        (json!({"at":at,"value":1,"volume":7}), ["volume", "7"]),
    ] {
        let error = run(&mut document, &json!({"ask":{"contact":question}}).to_string()).unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{question}: {error}");
    }
    let nowhere = Question::Contact {
        at: Place::Mm([f64::NAN; 3]),
        volume: None,
        value: Some(1.0),
        stiffness: None,
        most: None,
        tolerance_mm: None,
    };
    assert!(document.apply(Command::Ask(nowhere)).unwrap_err().to_string().contains("mm"));
}

#[test]
fn edits_are_felt_when_they_are_finished_and_no_more_when_they_are_undone() {
    let Some(mut document) = block() else { return };
    let say = |document: &mut Document, line: Value| run(document, &line.to_string()).unwrap();
    let feed = document.touch();
    // Just outside of the block's face x = 8, and then inside of what is painted there.
    let at = DVec3::new(6.0, 24.0, 20.0);
    feed.want(at, None);
    let inside = |document: &Document| {
        document.renew_touch().unwrap();
        feed.latest(None).unwrap().contact(at, 100.0, &law(2.0)).inside
    };
    assert!(!inside(&document));
    say(&mut document, json!({"brush":{"set":{"target":{"density":200},"radius_mm":4,"falloff":"hard"}}}));
    let points = json!([{"at":{"mm":[5, 24, 20]}}, {"at":{"mm":[7, 24, 20]}}]);
    say(&mut document, json!({"stroke":{"begin":{"points":points}}}));
    assert!(!inside(&document), "what was read back last");
    say(&mut document, json!({"stroke":{"end":{}}}));
    assert!(inside(&document));
    assert_eq!(felt(&mut document, at)["inside"], json!(true));
    say(&mut document, json!({"history":{"undo":{}}}));
    assert!(!inside(&document));
}
