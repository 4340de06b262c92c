//! A surface that is felt gives no energy back that was not put in: a simulated device at 1,000 steps a second.

use super::contact::{ISO, MIDDLE, RADIUS, ball, direction, head};
use burin::document::{ContactField, ContactForce, Document};
use burin::interact::devices::{Feel, Stylus};
use burin::math::DVec3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

const DT: f64 = 0.001;

/// A field about a place that is renewed where the device goes.
struct Near<'a> {
    document: &'a Document,
    field: ContactField,
}

impl<'a> Near<'a> {
    fn new(document: &'a Document, at: DVec3) -> Self {
        Self { document, field: document.contact_field(at, None).unwrap() }
    }

    fn at(&mut self, at: DVec3) -> &ContactField {
        if at.distance(self.field.centre()) > 0.5 * self.field.reach_mm() {
            self.field = self.document.contact_field(at, None).unwrap();
        }
        &self.field
    }
}

/// A mass of 45 g that falls toward the middle's side of a ball and is held off by what it feels: mm, mm/s, N. Answers the energy at
/// every step, mJ, without what stands in the force, and whether it flies free.
fn bounced(
    document: &Document,
    mut force: impl FnMut(&ContactField, DVec3) -> DVec3,
    from: DVec3,
    speed: DVec3,
) -> Vec<(f64, bool)> {
    let mass = 0.045;
    // A hand that lets its arm hang: 3 m/s² downward, against x.
    let pull = DVec3::X * -3_000.0;
    let (mut at, mut v) = (from, speed);
    let mut near = Near::new(document, at);
    let mut energy = Vec::new();
    for _ in 0..10_000 {
        let held = force(near.at(at), at);
        let free = held == DVec3::ZERO && near.at(at).contact(at, ISO, &laws()[0]).depth_mm.is_some_and(|d| d < 0.0);
        // g·mm²/s² are nJ; N·mm are mJ.
        energy.push((0.5 * mass * v.length_squared() * 1e-3 - mass * 1e-3 * pull.dot(at - from), free));
        let acceleration = held / mass * 1_000.0 + pull;
        at += v * DT + 0.5 * acceleration * DT * DT;
        v += acceleration * DT;
    }
    energy
}

/// By how much energy ever was above what it had been at any time before, mJ, between contacts.
fn greatest_gain(energy: &[(f64, bool)]) -> f64 {
    let (mut least, mut most) = (energy[0].0, 0.0_f64);
    for &(now, free) in energy {
        most = most.max(now - least);
        // What one contact took, the next does not give.
        least = if free { least.min(now) } else { least };
    }
    most
}

fn laws() -> [ContactForce; 3] {
    [(0.5, 3.0), (2.0, 5.0), (8.0, 20.0)].map(|(stiffness_n_per_mm, most_n)| ContactForce {
        stiffness_n_per_mm,
        most_n,
        tolerance_mm: 0.2,
    })
}

#[test]
fn a_mass_on_a_surface_never_has_more_energy_than_it_came_with() {
    let mut naive: f64 = 0.0;
    for (name, document) in [("ball", ball()), ("head", head())] {
        for law in laws() {
            let mut rng = ChaCha8Rng::seed_from_u64(9);
            let mut worst = f64::NEG_INFINITY;
            let mut last = 0.0;
            for _ in 0..6 {
                let from = MIDDLE + DVec3::X * (RADIUS + rng.random_range(1.0..5.0));
                let speed = direction(&mut rng) * rng.random_range(5.0..150.0);
                let mut feel = Feel::new(law);
                let energy = bounced(&document, |field, at| feel.step(field, at, ISO, DT).force_n, from, speed);
                worst = worst.max(greatest_gain(&energy));
                last += energy[energy.len() - 1].0 / 6.0;
                let energy = bounced(&document, |field, at| field.contact(at, ISO, &law).force_n, from, speed);
                naive = naive.max(greatest_gain(&energy));
            }
            let k = law.stiffness_n_per_mm;
            println!("{name}, {k} N/mm: {worst:.2e} mJ above the beginning at most, {last:.3} mJ in the end");
            assert!(worst <= 1e-9, "{name} {k}: {worst}");
        }
    }
    println!("a spring that is only sampled: {naive:.3} mJ more");
    assert!(naive > 0.01, "the spring alone gives energy: {naive}");
}

#[test]
fn a_hand_gets_no_more_back_from_a_press_than_it_put_in() {
    for (name, document) in [("ball", ball()), ("head", head())] {
        let mut rng = ChaCha8Rng::seed_from_u64(17);
        let (mut most, mut greatest, mut pressed): (f64, f64, f64) = (f64::NEG_INFINITY, 0.0, 0.0);
        let mut returned: f64 = 0.0;
        for _ in 0..200 {
            let law = laws()[rng.random_range(0..3)];
            let mut stylus = Stylus::new(Feel::new(law));
            let outward = direction(&mut rng);
            let top = MIDDLE + outward * (RADIUS + 3.0);
            let mut near = Near::new(&document, top);
            let (depth, seconds) = (rng.random_range(4.0..9.0), rng.random_range(0.15..0.6));
            let (tremor, hertz) = (rng.random_range(0.0..0.1), rng.random_range(8.0..12.0));
            let aside = outward.any_orthonormal_vector() * rng.random_range(0.0..6.0);
            let (mut given, mut held, mut last) = (0.0, DVec3::ZERO, top);
            let steps = (seconds / DT) as usize;
            for step in 0..=steps {
                let share = step as f64 / steps as f64;
                let turn = std::f64::consts::TAU;
                let down = 0.5 * (1.0 - (turn * share).cos()) * depth + tremor * (turn * hertz * share * seconds).sin();
                let at = top - outward * down + aside * share;
                given += held.dot(at - last);
                returned += held.dot(at - last).max(0.0);
                (last, stylus.pose.translation) = (at, at);
                let touch = stylus.touch(near.at(at), ISO, DT);
                held = touch.force_n;
                greatest = greatest.max(held.length() / law.most_n);
                pressed = pressed.max(held.length());
            }
            assert_eq!(held, DVec3::ZERO, "{name}: it is out again");
            most = most.max(given);
        }
        println!(
            "{name}: of 200 presses the one that gave most gave {most:.2e} mJ, all of them {returned:.1} mJ on their ways out; the greatest force was {pressed:.2} N"
        );
        // It is rounding that lies above.
        assert!(most <= 1e-12, "{name}: {most}");
        assert!(greatest <= 1.0 + 1e-9 && pressed > 3.0 && returned > 10.0, "{name}: {greatest} {pressed}");
    }
}

/// Who presses slowly feels stiffness × depth all the same.
#[test]
fn a_slow_press_feels_the_spring() {
    let document = ball();
    let law = laws()[0];
    let mut feel = Feel::new(law);
    let field = document.contact_field(MIDDLE + DVec3::Z * RADIUS, None).unwrap();
    let mut off: f64 = 0.0;
    for step in 0..4_000 {
        // 1 mm/s inward, from a tenth outside.
        let depth = f64::from(step) * 1e-3 - 0.1;
        let touch = feel.step(&field, MIDDLE + DVec3::Z * (RADIUS - depth), ISO, DT);
        if depth > 0.5 {
            off = off.max((touch.force_n.z / (law.stiffness_n_per_mm * depth) - 1.0).abs());
        }
    }
    println!("a slow press: {:.2} % off", off * 100.0);
    assert!(off < 0.02, "{off}");
}

/// Whoever is inside when it begins is not thrown out.
#[test]
fn what_begins_inside_is_not_kicked() {
    let document = ball();
    let mut feel = Feel::new(laws()[2]);
    let at = MIDDLE + DVec3::Z * (RADIUS - 5.0);
    let field = document.contact_field(at, None).unwrap();
    for _ in 0..100 {
        let touch = feel.step(&field, at, ISO, DT);
        assert_eq!(touch.force_n, DVec3::ZERO);
        assert!(touch.contact.inside);
    }
    assert!(feel.step(&field, at - DVec3::Z * 0.2, ISO, DT).force_n.z > 0.0, "who presses on feels it");
}
