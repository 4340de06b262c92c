//! Rigid bodies under the forces: sums, equilibria, determinism, hands.

use super::{cube, oblique, octants, unit};
use burin::explode::*;
use burin::math::{Camera, DQuat, DVec3, Plane, Pose};
use burin::volume::Grid;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn front(grid: &Grid) -> Camera {
    Camera::framing(&grid.world_bounds(), DVec3::new(0.3, -1.0, 0.2), DVec3::Z)
}

fn ball(count: usize, radius_mm: f64, seed: u64) -> Vec<ExplosionPoint> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..count)
        .map(|_| ExplosionPoint {
            position: unit(&mut rng) * radius_mm * rng.random_range(0.0..1.0_f64).cbrt(),
            weight: rng.random_range(0.5..2.0),
        })
        .collect()
}

fn plain(mut explosion: Explosion, degree: f64, viewing: bool) -> Explosion {
    explosion.degree = degree;
    explosion.forces.viewing = viewing;
    explosion.forces.measured_gain = false;
    explosion
}

/// The sum of the forces on a posed octant of a cube about the origin, from the equations; boxes have their nearest point by
/// clamping.
fn expected(explosion: &Explosion, poses: &[Pose], points: &[ExplosionPoint], camera: &Camera, i: usize) -> Wrench {
    let l = explosion.diagonal_mm() * 0.5;
    let (part, f, d) = (&explosion.parts[i], &explosion.forces, explosion.degree);
    let now = |v: DVec3| poses[i].apply(v) / l;
    let centre = now(part.centre());
    let mut sum = Wrench::default();
    let mut add = |force: DVec3, at: DVec3| {
        sum.force += force;
        sum.torque += (at - centre).cross(force);
    };
    for &v in &part.vertices {
        let r = v / l - now(v);
        if r.length() > 0.0 {
            let c = part.importance * f.return_constant;
            add(r.normalize() * c * (1.0 + r.length() / f.return_length).ln() / part.vertices.len() as f64, now(v));
        }
    }
    let total: f64 = points.iter().map(|p| p.weight).sum();
    let lo = part.vertices.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let hi = part.vertices.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    for p in points {
        let w = p.weight / total;
        let local = poses[i].unapply(p.position);
        let near = local.clamp(lo, hi);
        if near == local {
            let mut way = DVec3::ZERO;
            for face in part.faces.iter().filter(|f| f.cut) {
                way -= face.plane.normal * (face.plane.distance(local) / l / 0.05).exp();
            }
            add(poses[i].rotation * way.normalize() * (d * f.delta_explosion * w), p.position / l);
        } else {
            let r = (poses[i].apply(near) - p.position) / l;
            let strength = d * f.delta_explosion * w * (-r.length() / f.explosion_length).exp();
            add(r.normalize() * strength, now(near));
        }
        if f.viewing {
            let ray = (p.position - camera.eye).normalize();
            let foot = camera.eye + ray * ray.dot(centre * l - camera.eye).max(0.0);
            let r = centre - foot / l;
            add(r.normalize() * (d * f.delta_viewing * w / (r.length() + f.softening)), centre);
        }
    }
    for (j, other) in explosion.parts.iter().enumerate().filter(|(j, _)| *j != i) {
        let r = centre - poses[j].apply(other.centre()) / l;
        let strength = d * f.delta_spacing / (r.length_squared() + f.softening * f.softening);
        add(r.normalize() * strength / explosion.parts.len() as f64, centre);
    }
    sum
}

#[test]
fn what_acts_on_a_part_is_the_sum_of_the_four_forces() {
    let grid = cube(40);
    let camera = front(&grid);
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut explosion = plain(octants(&grid), 0.8, true);
    let mut given = Vec::new();
    for part in &mut explosion.parts {
        let turn = DQuat::from_axis_angle(unit(&mut rng), 0.4);
        given.push(Pose::about(part.centre(), turn, part.centre() * 0.3 + unit(&mut rng) * 3.0));
        part.importance = rng.random_range(0.5..3.0);
    }
    let points = ball(60, 14.0, 1);
    let simulation = Simulation::new(&explosion, &Poses::found(&explosion.parts, &given), &points).unwrap();
    // The bodies' own poses, so that their rounding to 32 bits is no difference.
    let poses = simulation.poses();
    for (i, found) in simulation.wrenches(&camera).into_iter().enumerate() {
        assert!(poses[i].translation.distance(given[i].translation) < 1e-4);
        let expected = expected(&explosion, &poses, &points, &camera, i);
        assert!(found.force.distance(expected.force) < 1e-7, "{i}: {found:?} {expected:?}");
        assert!(found.torque.distance(expected.torque) < 1e-7, "{i}: {found:?} {expected:?}");
        assert!(found.force.length() > 0.05 && found.torque.length() > 0.001);
    }
}

#[test]
fn two_halves_and_one_point_rest_where_bisection_says() {
    let grid = cube(20);
    let mut explosion = plain(Explosion::whole(&grid), 1.0, false);
    explosion.split_at_rest(PartId(1), &Plane { normal: DVec3::X, offset: 0.0 }).unwrap();
    let unit_mm = explosion.diagonal_mm() * 0.5;
    let f = explosion.forces;
    let points = [ExplosionPoint { position: DVec3::ZERO, weight: 3.0 }];
    let mut simulation = Simulation::new(&explosion, &Poses::default(), &points).unwrap();
    let steps = simulation.settle(&front(&grid), 1000);
    assert!(!simulation.moving() && steps < 300, "{steps}");
    // Shifted by d each: all corners return alike, the point pushes the face's middle, the centres are 2(h + d) apart.
    let h = 5.0 / unit_mm;
    let balance = |d: f64| {
        f.return_constant * (1.0 + d / f.return_length).ln()
            - f.delta_explosion * (-d / f.explosion_length).exp()
            - f.delta_spacing / ((2.0 * (h + d)).powi(2) + f.softening.powi(2)) / 2.0
    };
    let (mut lo, mut hi) = (0.0, 2.0);
    for _ in 0..60 {
        let mid = (lo + hi) * 0.5;
        if balance(mid) < 0.0 { lo = mid } else { hi = mid }
    }
    for (pose, sign) in simulation.poses().into_iter().zip([-1.0, 1.0]) {
        // At 0.001 half-diagonals a second under damping 12/s, about 0.0001 is left to go.
        assert!((pose.translation.x * sign / unit_mm - lo).abs() < 2e-4, "{pose:?} {lo}");
        assert!(pose.translation.y.abs() < 1e-3 && pose.rotation.xyz().length() < 1e-4);
    }
    assert!(lo > 0.1);
}

#[test]
fn at_rest_the_forces_balance() {
    let grid = oblique();
    let centre = Explosion::whole(&grid).parts[0].centre();
    let explosion = plain(octants(&grid), 1.0, false);
    let mut points = ball(100, 20.0, 3);
    points.iter_mut().for_each(|p| p.position += centre);
    let mut simulation = Simulation::new(&explosion, &Poses::default(), &points).unwrap();
    let steps = simulation.settle(&front(&grid), 600);
    assert!(!simulation.moving(), "{steps}");
    assert!((40..250).contains(&steps), "{steps} steps: about 110 are usual");
    for wrench in simulation.wrenches(&front(&grid)) {
        assert!(wrench.force.length() < 1e-3 && wrench.torque.length() < 1e-3, "{wrench:?}");
    }
    let mean: f64 = simulation
        .poses()
        .iter()
        .zip(&explosion.parts)
        .map(|(q, p)| q.apply(p.centre()).distance(p.centre()))
        .sum::<f64>()
        / 8.0;
    assert!(mean / (explosion.diagonal_mm() * 0.5) > 0.05);
}

#[test]
fn the_same_input_gives_the_same_poses_to_the_bit() {
    let grid = cube(64);
    let mut explosion = plain(octants(&grid), 1.0, true);
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    while explosion.parts.len() < 16 {
        let part = &explosion.parts[rng.random_range(0..explosion.parts.len())];
        let (id, plane) = (part.id, Plane::through(part.centre(), unit(&mut rng)).unwrap());
        explosion.split_at_rest(id, &plane).unwrap();
    }
    // Enough pairs for threads to share the parts.
    let points = ball(80, 20.0, 2);
    let run = || {
        let mut simulation = Simulation::new(&explosion, &Poses::default(), &points).unwrap();
        simulation.settle(&front(&grid), 40);
        simulation.poses()
    };
    let bits = |poses: Vec<Pose>| -> Vec<u64> {
        poses
            .iter()
            .flat_map(|p| p.rotation.to_array().into_iter().chain(p.translation.to_array()))
            .map(f64::to_bits)
            .collect()
    };
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let first = bits(run());
    assert_eq!(first, bits(run()));
    assert_eq!(first, bits(one_thread.install(run)));
}

#[test]
fn degree_zero_is_the_identity_exactly_from_wherever() {
    let grid = cube(40);
    let camera = front(&grid);
    let mut explosion = plain(octants(&grid), 1.0, true);
    let points = ball(60, 14.0, 1);
    let mut simulation = Simulation::new(&explosion, &Poses::default(), &points).unwrap();
    simulation.settle(&camera, 400);
    assert!(simulation.poses().iter().all(|p| *p != Pose::IDENTITY));
    simulation.set_degree(0.0);
    let steps = simulation.settle(&camera, 1000);
    assert!(!simulation.moving() && steps < 300, "{steps}");
    assert!(simulation.poses().iter().all(|p| *p == Pose::IDENTITY), "{:?}", simulation.poses());
    assert!(simulation.wrenches(&camera).iter().all(|w| *w == Wrench::default()));
    // Also from poses of another session, and where it begins.
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    explosion.degree = 0.0;
    let mut thrown =
        |part: &Part| Pose::about(part.centre(), DQuat::from_axis_angle(unit(&mut rng), 2.5), unit(&mut rng) * 90.0);
    let thrown: Vec<Pose> = explosion.parts.iter().map(&mut thrown).collect();
    let poses = Poses::found(&explosion.parts, &thrown);
    let mut simulation = Simulation::new(&explosion, &poses, &points).unwrap();
    assert!(simulation.poses().iter().all(|p| *p != Pose::IDENTITY));
    simulation.settle(&camera, 1000);
    assert!(simulation.poses().iter().all(|p| *p == Pose::IDENTITY));
    let rest = Simulation::new(&plain(octants(&grid), 0.0, true), &Poses::default(), &points).unwrap();
    assert!(!rest.moving() && rest.poses().iter().all(|p| *p == Pose::IDENTITY));
}

#[test]
fn a_pinned_part_stays_in_the_hand_and_others_still_keep_clear_of_it() {
    let grid = cube(40);
    let camera = front(&grid);
    let points = ball(60, 14.0, 1);
    let mut explosion = plain(octants(&grid), 1.0, false);
    let free = {
        let mut simulation = Simulation::new(&explosion, &Poses::default(), &points).unwrap();
        simulation.settle(&camera, 600);
        simulation.poses()
    };
    let hand = Pose { rotation: DQuat::from_rotation_y(0.123), translation: DVec3::new(1.1, 2.2, -3.3) };
    let id = explosion.parts[0].id;
    explosion.place(id, hand).unwrap();
    let hand = explosion.parts[0].held.unwrap();
    let mut simulation = Simulation::new(&explosion, &Poses::default(), &points).unwrap();
    simulation.settle(&camera, 600);
    let held = simulation.poses();
    assert_eq!(held[0], hand, "to the bit");
    // Its neighbours feel it elsewhere than where it would have gone.
    assert!(held[1].translation.distance(free[1].translation) > 0.05);
    // Dragged while everything runs, and let go.
    let further = Pose { translation: DVec3::new(40.0, 0.0, 0.0), ..hand };
    simulation.hold(0, Some(further));
    simulation.step(&camera);
    assert_eq!(simulation.poses()[0], further);
    simulation.set_degree(0.0);
    simulation.settle(&camera, 1000);
    assert_eq!(simulation.poses()[0], further, "pinned: degree 0 does not take it out of the hand");
    assert_eq!(simulation.poses()[1], Pose::IDENTITY);
    simulation.hold(0, None);
    simulation.settle(&camera, 1000);
    assert_eq!(simulation.poses()[0], Pose::IDENTITY);
    // Taken from its rest and let go it returns as it went: seen on the way, in no leap.
    simulation.hold(0, Some(further));
    simulation.hold(0, None);
    let way = |simulation: &Simulation| simulation.poses()[0].translation.distance(further.translation);
    assert!(way(&simulation) < 1e-3, "still where it was let go");
    simulation.step(&camera);
    assert!((0.05..2.0).contains(&way(&simulation)), "{} mm", way(&simulation));
    assert!(explosion.place(id, Pose { translation: DVec3::NAN, ..hand }).is_err());
    assert!(explosion.place(PartId(99), hand).is_err());
}

#[test]
fn a_part_caught_in_flight_stays_where_the_others_see_it() {
    let grid = cube(40);
    let camera = front(&grid);
    let points = ball(60, 14.0, 1);
    let explosion = plain(octants(&grid), 1.0, false);
    let mut simulation = Simulation::new(&explosion, &Poses::default(), &points).unwrap();
    for _ in 0..12 {
        simulation.step(&camera);
    }
    let caught = simulation.poses()[0];
    assert!(caught.translation.length() > 0.5, "it flies: {caught:?}");
    simulation.hold(0, Some(caught));
    simulation.settle(&camera, 2000);
    assert!(!simulation.moving() && simulation.poses()[0] == caught);
    // The others rest where the forces balance with the caught part in the hand, not where its flight would have led it.
    for i in 1..8 {
        let left = expected(&explosion, &simulation.poses(), &points, &camera, i);
        assert!(left.force.length() < 2e-3, "{i}: {left:?}");
    }
}

#[test]
fn importance_holds_a_part_back_and_changes_no_balance() {
    let grid = cube(40);
    let camera = front(&grid);
    let points = ball(60, 14.0, 1);
    let mut last = f64::INFINITY;
    for importance in [0.5, 1.0, 4.0, 100.0, 1e6] {
        let mut explosion = plain(octants(&grid), 1.0, true);
        explosion.parts[2].importance = importance;
        let mut simulation = Simulation::new(&explosion, &Poses::default(), &points).unwrap();
        simulation.settle(&camera, 2000);
        assert!(!simulation.moving(), "{importance}");
        let pose = simulation.poses()[2];
        let centre = explosion.parts[2].centre();
        let moved = pose.apply(centre).distance(centre);
        assert!(moved < last * 0.9, "{importance}: {moved} after {last}");
        last = moved;
        let left = expected(&explosion, &simulation.poses(), &points, &camera, 2);
        // A heavy part creeps: its mass makes the same speed mean more force.
        assert!(left.force.length() < 2e-3 * importance.max(1.0), "{importance}: {left:?}");
    }
    assert!(last < 1e-3, "{last} mm at importance 1,000,000");
}

#[test]
fn led_parts_reach_the_given_poses_exactly() {
    let grid = cube(40);
    let camera = front(&grid);
    let explosion = plain(octants(&grid), 1.0, true);
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    let targets: Vec<Pose> = explosion
        .parts
        .iter()
        .map(|p| Pose::about(p.centre(), DQuat::from_axis_angle(unit(&mut rng), 0.5), unit(&mut rng) * 20.0))
        .collect();
    let mut simulation = Simulation::new(&explosion, &Poses::default(), &ball(10, 5.0, 1)).unwrap();
    simulation.lead(Some(&targets));
    simulation.step(&camera);
    assert!(simulation.poses() != targets);
    simulation.settle(&camera, 1000);
    assert_eq!(simulation.poses(), targets);
    simulation.lead(None);
    simulation.step(&camera);
    assert!(simulation.moving() && simulation.poses() != targets);
}

#[test]
fn nothing_selected_moves_parts_by_spacing_only() {
    let grid = cube(40);
    let mut explosion = plain(octants(&grid), 1.0, true);
    let nan = ExplosionPoint { position: DVec3::NAN, weight: 1.0 };
    let mut simulation = Simulation::new(&explosion, &Poses::default(), &[nan]).unwrap();
    simulation.settle(&front(&grid), 600);
    for (pose, part) in simulation.poses().iter().zip(&explosion.parts) {
        let shift = pose.apply(part.centre()) - part.centre();
        assert!(
            shift.length() > 0.5 && shift.normalize().dot(part.centre().normalize()) > 0.999,
            "along its own diagonal"
        );
    }
    for i in 0..8 {
        let left = expected(&explosion, &simulation.poses(), &[], &front(&grid), i);
        assert!(left.force.length() < 2e-3, "spacing and return balance: {i}: {left:?}");
    }
    explosion.degree = f64::NAN;
    assert!(Simulation::new(&explosion, &Poses::default(), &[]).is_err());
}
