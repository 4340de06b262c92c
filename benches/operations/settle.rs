//! Steps of the simulation alone, all four forces acting, by the number of parts.

use super::head::Failure;
use super::measure::{Report, measure};
use burin::explode::{Explosion, ExplosionPoint, MAX_POINTS, Poses, Simulation};
use burin::math::{Camera, DVec3, Plane};
use burin::volume::Grid;

const STEPS: u32 = 200;

/// A cube of 256 mm cut `cuts` times along each axis, and as many explosion points as there can be on a ball inside.
fn scene(cuts: u32) -> Result<(Explosion, Vec<ExplosionPoint>, Grid), Failure> {
    let grid = Grid::aligned([256; 3], DVec3::ONE, DVec3::ZERO);
    let mut explosion = Explosion::whole(&grid);
    for axis in 0..3 {
        for cut in 1..=cuts {
            let at = DVec3::splat(256.0 * f64::from(cut) / f64::from(cuts + 1));
            let plane = Plane::through(at, DVec3::AXES[axis]).ok_or("no plane")?;
            for id in explosion.parts.iter().map(|p| p.id).collect::<Vec<_>>() {
                explosion.split_at_rest(id, &plane)?;
            }
        }
    }
    explosion.degree = 1.0;
    explosion.forces.measured_gain = false;
    // A spiral from pole to pole, at two thirds of the half edge.
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let point = |i: usize| {
        let z = 1.0 - 2.0 * (i as f64 + 0.5) / MAX_POINTS as f64;
        let (r, turn) = ((1.0 - z * z).sqrt(), golden * i as f64);
        let position = DVec3::splat(127.5) + DVec3::new(r * turn.cos(), r * turn.sin(), z) * 85.0;
        ExplosionPoint { position, weight: 512.0 }
    };
    Ok((explosion, (0..MAX_POINTS).map(point).collect(), grid))
}

pub fn settle(report: &mut Report) -> Result<(), Failure> {
    for cuts in [1, 3] {
        let (explosion, points, grid) = scene(cuts)?;
        let camera = Camera::framing(&grid.world_bounds(), DVec3::new(1.0, 0.7, 0.4), DVec3::Z);
        let mut poses = None;
        let time = measure(1, 5, |_| -> Result<(), Failure> {
            let mut simulation = Simulation::new(&explosion, &Poses::default(), &points)?;
            for _ in 0..STEPS {
                simulation.step(&camera);
            }
            let reached = simulation.poses();
            if poses.get_or_insert_with(|| reached.clone()) != &reached {
                return Err("the same start led to other poses".into());
            }
            Ok(())
        })?;
        let beside = format!(
            "{:.1} steps per ms wall, {:.1} per ms CPU",
            f64::from(STEPS) / time.wall,
            f64::from(STEPS) / time.cpu
        );
        let parts = explosion.parts.len();
        report.row(&format!("{STEPS} steps, {parts} parts, {} points", points.len()), time, &beside);
    }
    Ok(())
}
