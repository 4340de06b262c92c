//! The measured gain: what is visible, from where, in how many rounds, and independent of what came before.

use super::picture::{directions, measure};
use super::{cube, octants, unit};
use burin::explode::*;
use burin::math::{Camera, DQuat, DVec3, Plane, Pose};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

const RADIUS: f64 = 18.0;
const PX: u32 = 64;

/// A ball in a cube of 60 mm, off the middle, in eight octants; everything else is dense.
fn setup() -> (Explosion, Vec<ExplosionPoint>) {
    let mut explosion = octants(&cube(60));
    explosion.degree = 1.0;
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let points = (0..24).map(|_| ExplosionPoint {
        position: centre() + unit(&mut rng) * RADIUS * rng.random::<f64>().cbrt(),
        weight: 1.0,
    });
    (explosion, points.collect())
}

fn centre() -> DVec3 {
    DVec3::new(2.0, -3.0, 1.0)
}

fn matter(p: DVec3) -> (f64, f64) {
    let inside = p.distance(centre()) < RADIUS;
    // Corners of the cube are air, as about a head.
    let head = p.length() < 40.0;
    if inside { (0.5, 0.0) } else { (0.0, if head { 0.5 } else { 0.0 }) }
}

fn camera(direction: DVec3) -> Camera {
    let up = if direction.x == 0.0 && direction.y == 0.0 { DVec3::Y } else { DVec3::Z };
    Camera::framing(&cube(60).world_bounds(), direction, up).zoomed(0.7)
}

fn settle(explosion: &Explosion, points: &[ExplosionPoint], camera: &Camera) -> Settled {
    settle_with_gain::<ExplodeError>(
        explosion,
        points,
        camera,
        &mut |poses| Ok(measure(explosion, poses, camera, PX, 2.5, &matter)),
        &mut |_| Ok(()),
    )
    .unwrap()
}

#[test]
fn the_picture_of_these_tests_sees_what_it_should() {
    let (explosion, _) = setup();
    let rest = vec![Pose::IDENTITY; 8];
    let view = camera(DVec3::NEG_Y);
    let at_rest = measure(&explosion, &rest, &view, PX, 2.5, &matter);
    assert_eq!(at_rest.visible, 0.0, "the ball is inside");
    assert!(at_rest.hidden.iter().sum::<f64>() >= 1.0);
    let mut away = rest.clone();
    for (pose, part) in away.iter_mut().zip(&explosion.parts).filter(|(_, p)| p.centre().y < 0.0) {
        pose.translation = part.centre() * DVec3::new(9.0, 0.0, 9.0);
    }
    let open = measure(&explosion, &away, &view, PX, 2.5, &matter);
    assert_eq!((open.visible, open.hidden.iter().sum::<f64>()), (1.0, 0.0));
    // One quadrant of the front closed again hides the share of the ball that is seen there.
    let (front, _) = explosion.parts.iter().enumerate().find(|(_, p)| p.centre().cmplt(DVec3::ZERO).all()).unwrap();
    away[front] = Pose::IDENTITY;
    let quarter = measure(&explosion, &away, &view, PX, 2.5, &matter);
    assert!((0.1..0.4).contains(&quarter.hidden[front]), "{quarter:?}");
    assert!((quarter.visible + quarter.hidden[front] - 1.0).abs() < 1e-12);
}

#[test]
fn ninety_nine_percent_are_visible_from_26_directions_and_less_is_moved_than_plainly() {
    let (explosion, points) = setup();
    let unit_mm = explosion.diagonal_mm() * 0.5;
    let shift = |poses: &[Pose]| {
        let moved = poses.iter().zip(&explosion.parts).map(|(q, p)| q.apply(p.centre()).distance(p.centre()));
        moved.sum::<f64>() / 8.0 / unit_mm
    };
    let mut plain = explosion.clone();
    plain.forces.measured_gain = false;
    let (mut with_gain, mut without) = (0.0, 0.0);
    for direction in directions() {
        let view = camera(direction);
        let settled = settle(&explosion, &points, &view);
        assert!(settled.at_rest && settled.rounds <= MAX_ROUNDS && settled.steps <= MAX_STEPS, "{settled:?}");
        // Looked at more closely than it was measured.
        let seen = measure(&explosion, &settled.poses, &view, 2 * PX - 3, 2.5, &matter);
        assert!(seen.visible >= 0.99, "{direction}: {} {settled:?}", seen.visible);
        with_gain += shift(&settled.poses) / 26.0;
        let all = settle(&plain, &points, &view);
        assert_eq!((all.rounds, all.visible, all.gains), (0, None, vec![1.0; 8]));
        without += shift(&all.poses) / 26.0;
    }
    assert!(with_gain < 0.6 * without, "{with_gain} {without}");
}

/// The ball's cube cut by random planes near its middle: needles and splinters beside large parts.
fn shattered(seed: u64) -> Explosion {
    let mut explosion = Explosion::whole(&cube(60));
    explosion.degree = 1.0;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for _ in 0..4 {
        let plane = Plane::through(unit(&mut rng) * 6.0, unit(&mut rng)).unwrap();
        for id in explosion.parts.iter().map(|p| p.id).collect::<Vec<_>>() {
            explosion.split_at_rest(id, &plane).unwrap();
        }
    }
    explosion
}

#[test]
fn needles_and_splinters_come_to_rest_and_leave_rounds_to_large_parts() {
    let (_, points) = setup();
    let cases = [(10, DVec3::NEG_Y), (15, DVec3::Y), (16, DVec3::new(1.0, 1.0, 0.0))];
    for (seed, direction) in cases {
        let (explosion, view) = (shattered(seed), camera(direction));
        let settled = settle(&explosion, &points, &view);
        assert!(settled.at_rest && settled.rounds <= MAX_ROUNDS && settled.steps <= MAX_STEPS, "{seed}: {settled:?}");
        let seen = measure(&explosion, &settled.poses, &view, 2 * PX - 3, 2.5, &matter);
        assert!(seen.visible >= 0.99, "{seed}: {} {settled:?}", seen.visible);
    }
}

/// Springs so soft that parts are under way for hundreds of steps.
fn sluggish() -> (Explosion, Vec<ExplosionPoint>) {
    let (mut explosion, points) = setup();
    explosion.forces = Forces { return_constant: 0.05, return_length: 1.0, ..explosion.forces };
    (explosion, points)
}

#[test]
fn what_was_measured_last_is_where_the_parts_rest() {
    let (explosion, points) = sluggish();
    let mut seen = Vec::new();
    let mut look = |poses: &[Pose]| {
        seen = poses.to_vec();
        Ok(Measured { visible: 1.0, hidden: vec![0.0; 8] })
    };
    let view = camera(DVec3::NEG_Y);
    let settled = settle_with_gain::<ExplodeError>(&explosion, &points, &view, &mut look, &mut |_| Ok(())).unwrap();
    assert!(settled.at_rest && settled.rounds > 1, "{settled:?}");
    for ((pose, seen), part) in settled.poses.iter().zip(&seen).zip(&explosion.parts) {
        let apart = pose.apply(part.centre()).distance(seen.apply(part.centre()));
        assert!(apart < 0.1, "{apart} mm");
    }
}

#[test]
fn parts_that_are_long_under_way_leave_steps_for_all_rounds() {
    let (mut explosion, points) = sluggish();
    explosion.forces.return_constant = 0.01;
    let mut look = |_: &[Pose]| Ok(Measured { visible: 0.3, hidden: vec![0.1; 8] });
    let view = camera(DVec3::NEG_Y);
    let settled = settle_with_gain::<ExplodeError>(&explosion, &points, &view, &mut look, &mut |_| Ok(())).unwrap();
    assert!(settled.rounds >= MAX_ROUNDS - 2, "{settled:?}");
    assert!(settled.steps <= MAX_STEPS && settled.steps > MAX_STEPS / 2, "{settled:?}");
}

#[test]
fn without_the_viewing_force_the_ball_stays_hidden() {
    let (mut explosion, points) = setup();
    explosion.forces.viewing = false;
    let view = camera(DVec3::new(1.0, -1.0, 1.0));
    let settled = settle(&explosion, &points, &view);
    assert_eq!(settled.rounds, 0);
    assert!(measure(&explosion, &settled.poses, &view, PX, 2.5, &matter).visible < 0.5);
}

#[test]
fn the_same_camera_gives_the_same_poses_whatever_came_before() {
    let (explosion, points) = setup();
    let view = camera(DVec3::new(1.0, -1.0, 0.0));
    let first = settle(&explosion, &points, &view);
    for direction in [DVec3::Z, DVec3::X] {
        assert_ne!(settle(&explosion, &points, &camera(direction)).poses, first.poses);
    }
    assert_eq!(settle(&explosion, &points, &view), first);
    // In slices, as a window does it.
    let mut search = Search::new(&explosion, &points, &view).unwrap();
    let mut slices = 0;
    let sliced = loop {
        slices += 1;
        match search.advance(7) {
            SearchStep::Moving => {}
            SearchStep::Measure(poses) => search.measured(&measure(&explosion, &poses, &view, PX, 2.5, &matter)),
            SearchStep::Done => break search.settled(),
        }
    };
    assert!(slices > 20);
    assert_eq!(sliced, first);
}

#[test]
fn a_search_may_run_beside_the_window() {
    let (explosion, points) = setup();
    let view = camera(DVec3::NEG_Y);
    let here = settle(&explosion, &points, &view);
    let mut search = Search::new(&explosion, &points, &view).unwrap();
    let there = std::thread::spawn(move || {
        loop {
            match search.advance(100) {
                SearchStep::Moving => {}
                SearchStep::Measure(poses) => search.measured(&measure(&explosion, &poses, &view, PX, 2.5, &matter)),
                SearchStep::Done => return search.settled(),
            }
        }
    });
    assert_eq!(there.join().unwrap(), here);
}

#[test]
fn the_gain_is_measured_at_degree_one_and_then_scaled() {
    let (explosion, points) = setup();
    let view = camera(DVec3::new(1.0, -1.0, 0.0));
    let full = settle(&explosion, &points, &view);
    let distance = |a: &[Pose], b: &[Pose]| {
        let apart = explosion
            .parts
            .iter()
            .zip(a.iter().zip(b))
            .map(|(p, (a, b))| a.apply(p.centre()).distance(b.apply(p.centre())));
        apart.fold(0.0, f64::max)
    };
    let rest = vec![Pose::IDENTITY; 8];
    let mut last = distance(&full.poses, &rest);
    let at = |degree: f64| settle(&Explosion { degree, ..explosion.clone() }, &points, &view);
    let near = at(0.999);
    assert_eq!(near.gains, full.gains);
    for degree in [0.75, 0.5, 0.25, 0.05] {
        let settled = at(degree);
        assert_eq!(settled.gains, full.gains);
        assert!(settled.at_rest && settled.steps <= MAX_STEPS);
        let reach = distance(&settled.poses, &rest);
        assert!(reach < last, "degree {degree}: {reach} after {last}");
        last = reach;
    }
    let zero = at(0.0);
    assert_eq!((zero.poses, zero.rounds), (rest, 0));
    // A small step of the slider is a small step of the parts.
    assert!(distance(&near.poses, &full.poses) < 0.5);
}

#[test]
fn parts_that_hide_nothing_get_no_gain_and_those_in_the_way_no_more_than_needed() {
    let (explosion, points) = setup();
    let settled = settle(&explosion, &points, &camera(DVec3::NEG_Y));
    for (part, gain) in explosion.parts.iter().zip(&settled.gains) {
        if part.centre().y > 0.0 {
            assert_eq!(*gain, 0.0, "behind the ball");
        } else {
            assert!((0.25..3.0).contains(gain));
            // 0.25 times a whole power of 1.5.
            let power = (gain / 0.25).ln() / 1.5_f64.ln();
            assert!((power - power.round()).abs() < 1e-9);
        }
    }
}

#[test]
fn what_cannot_be_uncovered_ends_after_twelve_rounds() {
    let (explosion, points) = setup();
    let view = camera(DVec3::NEG_Y);
    let mut calls = 0;
    let settled = settle_with_gain::<ExplodeError>(
        &explosion,
        &points,
        &view,
        &mut |_| {
            calls += 1;
            Ok(Measured { visible: 0.3, hidden: vec![0.1; 8] })
        },
        &mut |_| Ok(()),
    )
    .unwrap();
    assert!(settled.rounds <= MAX_ROUNDS && settled.steps <= MAX_STEPS && calls == settled.rounds, "{settled:?}");
    assert!(settled.poses.iter().all(|p| p.translation.is_finite()));
    let failed = settle_with_gain(
        &explosion,
        &points,
        &view,
        &mut |_| Err(ExplodeError::NoPlane { splitter: "none", reason: "the picture failed" }),
        &mut |_| Ok(()),
    );
    assert!(failed.is_err());
    // A measurement of fewer parts, or of nothing that is a number, raises no gain and ends like any other.
    for odd in [Measured::default(), Measured { visible: f64::NAN, hidden: vec![f64::NAN; 3] }] {
        let settled =
            settle_with_gain::<ExplodeError>(&explosion, &points, &view, &mut |_| Ok(odd.clone()), &mut |_| Ok(()))
                .unwrap();
        assert!(settled.gains == [0.0; 8] && settled.rounds <= MAX_ROUNDS, "{settled:?}");
        assert!(settled.poses.iter().all(|p| p.translation.is_finite() && *p != Pose::IDENTITY), "{settled:?}");
    }
}

#[test]
fn a_search_tells_how_far_it_is_and_ends_between_steps_when_it_is_told_to() {
    let (explosion, points) = setup();
    let view = camera(DVec3::NEG_Y);
    let mut look = |poses: &[Pose]| Ok::<_, ExplodeError>(measure(&explosion, poses, &view, PX, 2.5, &matter));
    let mut told = Vec::new();
    let mut listen = |share| {
        told.push(share);
        Ok(())
    };
    let settled = settle_with_gain(&explosion, &points, &view, &mut look, &mut listen).unwrap();
    assert!(told.is_sorted() && told[0] == 0.0 && told[told.len() - 1] <= 1.0, "{told:?}");
    assert!(told.len() > settled.rounds as usize * 3, "also between measurements: {} times", told.len());

    // Without looking up it is the same to the bit.
    let mut search = Search::new(&explosion, &points, &view).unwrap();
    let whole = loop {
        match search.advance(MAX_STEPS) {
            SearchStep::Measure(poses) => search.measured(&look(&poses).unwrap()),
            SearchStep::Done => break search.settled(),
            SearchStep::Moving => {}
        }
    };
    assert_eq!((settled.poses, settled.steps, settled.rounds), (whole.poses, whole.steps, whole.rounds));

    let mut looks = 0;
    let mut stop = |share: f32| {
        looks += 1;
        if share > 0.0 { Err(ExplodeError::NoPlane { splitter: "none", reason: "stopped" }) } else { Ok(()) }
    };
    assert!(settle_with_gain(&explosion, &points, &view, &mut look, &mut stop).is_err());
    assert_eq!(looks, 2, "after the first few steps");
}

#[test]
fn pinned_parts_keep_the_hands_pose_while_others_make_way() {
    let (mut explosion, points) = setup();
    let view = camera(DVec3::NEG_Y);
    let hand = Pose { rotation: DQuat::from_rotation_z(0.2), translation: DVec3::new(50.0, -10.0, 3.0) };
    let id = explosion.parts[4].id;
    explosion.place(id, hand).unwrap();
    let settled = settle(&explosion, &points, &view);
    assert_eq!(settled.poses[4], explosion.parts[4].held.unwrap());
    assert!(settled.poses.iter().enumerate().all(|(i, p)| i == 4 || *p != Pose::IDENTITY));
    explosion.degree = 0.0;
    let zero = settle(&explosion, &points, &view);
    assert_eq!(zero.poses[4], explosion.parts[4].held.unwrap());
    assert!(zero.poses.iter().enumerate().all(|(i, p)| i == 4 || *p == Pose::IDENTITY));
}
