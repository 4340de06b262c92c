//! Parts as rigid bodies under the four forces, step by step to rest.
//!
//! Exploded Views (2006), 3.2; forces in `forces`. Lengths in half-diagonals, one factor on all forces, mass 1: these set the
//! speed and not the poses. Importance multiplies the return force. Sums run in the order of parts and points, so the same
//! input gives the same poses to the bit. Knows the camera, not the picture: gains are given to it.

use crate::explode::bodies::{Bodies, STEP_S, State};
use crate::explode::error::ExplodeError;
use crate::explode::forces::{explosion_force, from_ray, return_force, spacing_force, viewing_force, viewing_ray};
use crate::explode::octree::ExplosionPoint;
use crate::explode::poses::Poses;
use crate::explode::solid::PartShape;
use crate::explode::state::{Explosion, Forces};
use crate::math::{Camera, DQuat, DVec3, Pose, Ray};
use rayon::prelude::*;

/// One factor on all forces, 1/s².
const FACTOR: f64 = 200.0;
/// Inertia that a part of mass 1 has at least, for every half-diagonal to its furthest corner. A push of ½ that jumps from one
/// corner to the next as the part turns by a degree or two must not spin it within a step: ½·200·(1/60)²/0.03 is 0.9 for the
/// stiffest; a tenth stills splinters and leaves parts of common size alone, for inertia changes no rest pose.
const LEAST_INERTIA: f64 = 0.1;
/// Half-diagonals a second of a part's fastest corner under which it counts as slow. Not of its turn: splinters turn about
/// themselves for long, pushed at one corner, and nothing is seen of it.
const SLOW: f64 = 1e-3;
/// Slow steps in a row after which all are at rest: more than a turning point lasts.
const PATIENCE: u32 = 3;
/// Half-diagonals that a part's corners may tremble about their places, and for how many steps until that is rest: where an
/// explosion point sits on an edge, the force on it turns from step to step.
const TREMBLE: f64 = 1e-3;
const TREMBLING: u32 = 30;
/// Half-diagonals, and quaternion distance, within which a slow part snaps to where nothing keeps it from.
const NEAR: f64 = 1e-3;
/// Part–point pairs from which threads pay.
const MANY: usize = 1024;

struct Member {
    solid: PartShape,
    /// The centre at rest, world, half-diagonals.
    centre: DVec3,
    importance: f64,
    /// The hand's pose of a pinned part, returned as it is.
    pinned: Option<Pose>,
    gain: f64,
    /// Where the part goes, and the state that means.
    home: (Pose, State),
    snapped: bool,
}

/// Rigid bodies, one a part, and the forces on them; a step is 1/60 s of simulated time.
pub struct Simulation {
    bodies: Bodies,
    members: Vec<Member>,
    points: Vec<ExplosionPoint>,
    unit_mm: f64,
    forces: Forces,
    degree: f64,
    /// Whether only the return force acts, towards poses given from outside.
    led: bool,
    slow_steps: u32,
    /// Where the parts were when one last left the neighbourhood of where it was, and how many steps ago.
    anchor: (Vec<State>, u32),
}

/// Force and torque about a part's centre, in units of the forces' constants and half-diagonals, world axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    /// Force.
    pub force: DVec3,
    /// Torque.
    pub torque: DVec3,
}

impl Simulation {
    /// Parts in these poses, without speed; every gain 1, or 0 if gains are to be measured.
    ///
    /// # Errors
    /// If the explosion is not sound (see [`Explosion::check`]).
    pub fn new(explosion: &Explosion, poses: &Poses, points: &[ExplosionPoint]) -> Result<Self, ExplodeError> {
        explosion.check()?;
        let unit_mm = explosion.diagonal_mm() * 0.5;
        let forces = explosion.forces;
        let mut bodies = Bodies::new();
        let mut members = Vec::with_capacity(explosion.parts.len());
        for part in &explosion.parts {
            let solid = PartShape::of(part, unit_mm)?;
            let centre = solid.centre_mm() / unit_mm;
            // The stiffest spring must not turn within few steps; mass changes no rest pose.
            let stiffness = FACTOR * part.importance * forces.return_constant / forces.return_length;
            let mass = (stiffness * STEP_S * STEP_S * 4.0).max(1.0);
            // Two thirds of the corners' mean square: a ball's, since a sliver's own would spin about its long axis.
            let corners = solid.corners();
            let spread = corners.iter().map(|c| c.length_squared()).sum::<f64>() / corners.len() as f64;
            let reach = corners.iter().map(|c| c.length()).fold(1e-4, f64::max);
            let inertia = (spread * 2.0 / 3.0).max(reach * LEAST_INERTIA);
            let pose = poses.of(part);
            bodies.add(mass, mass * inertia, part.held.is_some(), state_of(&pose, solid.centre_mm(), unit_mm));
            members.push(Member {
                solid,
                centre,
                importance: part.importance,
                pinned: part.held,
                gain: if forces.measured_gain { 0.0 } else { 1.0 },
                home: (Pose::IDENTITY, State::REST),
                snapped: pose == Pose::IDENTITY,
            });
        }
        let mut simulation = Self {
            bodies,
            members,
            points: Vec::new(),
            unit_mm,
            forces,
            degree: explosion.degree,
            led: false,
            slow_steps: 0,
            anchor: (Vec::new(), 0),
        };
        simulation.set_points(points);
        Ok(simulation)
    }

    /// Replaces the explosion points, world mm.
    pub fn set_points(&mut self, points: &[ExplosionPoint]) {
        let scaled = |p: &ExplosionPoint| ExplosionPoint { position: p.position / self.unit_mm, weight: p.weight };
        let usable = |p: &&ExplosionPoint| p.position.is_finite() && p.weight.is_finite() && p.weight > 0.0;
        self.points = points.iter().filter(usable).map(scaled).collect();
        self.disturb();
    }

    /// Changes the degree of explosion.
    pub fn set_degree(&mut self, degree: f64) {
        self.degree = degree;
        self.disturb();
    }

    /// Changes the viewing force's gains, in order of parts.
    pub fn set_gains(&mut self, gains: &[f64]) {
        for (member, gain) in self.members.iter_mut().zip(gains) {
            member.gain = *gain;
        }
        self.disturb();
    }

    /// Holds a part at a hand's pose (`Some`), or lets go of it (`None`). `index` is the order of parts.
    pub fn hold(&mut self, index: usize, pose: Option<Pose>) {
        let Some(member) = self.members.get_mut(index) else { return };
        member.pinned = pose;
        member.snapped = false;
        self.bodies.fix(index, pose.is_some());
        if let Some(pose) = pose {
            self.bodies.put(index, state_of(&pose, member.solid.centre_mm(), self.unit_mm));
        }
        self.disturb();
    }

    /// From now on parts only return, and to these poses, which they reach exactly: an animation to what was settled.
    /// `None`: all forces again.
    pub fn lead(&mut self, targets: Option<&[Pose]>) {
        self.led = targets.is_some();
        for (i, member) in self.members.iter_mut().enumerate() {
            let pose = targets.and_then(|t| t.get(i)).copied().unwrap_or(Pose::IDENTITY);
            if member.home.0 != pose {
                member.home = (pose, state_of(&pose, member.solid.centre_mm(), self.unit_mm));
                member.snapped = false;
            }
        }
        self.disturb();
    }

    /// One step of 1/60 s; answers whether anything still moves.
    pub fn step(&mut self, camera: &Camera) -> bool {
        let wrenches: Vec<(DVec3, DVec3)> =
            self.wrenches(camera).into_iter().map(|w| (w.force * FACTOR, w.torque * FACTOR)).collect();
        self.bodies.step(&wrenches);
        let slow = (0..self.members.len()).all(|i| self.members[i].pinned.is_some() || self.speed(i) < SLOW);
        self.slow_steps = if slow { self.slow_steps + 1 } else { 0 };
        self.follow_anchor();
        let (homing, still) = (self.led || !self.pushes(), self.still());
        for (i, member) in self.members.iter_mut().enumerate() {
            member.snapped = homing && member.pinned.is_none() && {
                let (at, home) = (self.bodies.state(i), member.home.1);
                let near = at.shift.distance(home.shift) < NEAR && turned(at.rotation, home.rotation) < NEAR;
                (near && fastest(&self.bodies, i, &member.solid) < SLOW) || still
            };
            if member.snapped {
                self.bodies.put(i, member.home.1);
            }
        }
        self.moving()
    }

    fn speed(&self, i: usize) -> f64 {
        fastest(&self.bodies, i, &self.members[i].solid)
    }

    fn disturb(&mut self) {
        self.slow_steps = 0;
        self.anchor.1 = 0;
    }

    fn still(&self) -> bool {
        self.slow_steps >= PATIENCE || self.anchor.1 >= TREMBLING
    }

    fn follow_anchor(&mut self) {
        let states: Vec<State> = (0..self.members.len()).map(|i| self.bodies.state(i)).collect();
        let (anchor, age) = &mut self.anchor;
        let near = |((a, b), member): ((&State, &State), &Member)| {
            member.solid.corners().iter().all(|&c| a.place(c).distance(b.place(c)) < TREMBLE)
        };
        if anchor.len() == states.len() && states.iter().zip(anchor.iter()).zip(&self.members).all(near) {
            *age += 1;
        } else {
            self.anchor = (states, 0);
        }
    }

    /// Steps until nothing moves or `max_steps` are done; answers how many.
    pub fn settle(&mut self, camera: &Camera, max_steps: u32) -> u32 {
        let mut steps = 0;
        while steps < max_steps && (steps == 0 || self.moving()) {
            self.step(camera);
            steps += 1;
        }
        steps
    }

    /// Whether the parts had not come to rest at the last step.
    pub fn moving(&self) -> bool {
        let homing = self.led || !self.pushes();
        !self.still() && self.members.iter().any(|m| m.pinned.is_none() && !(homing && m.snapped))
    }

    /// Poses in order of parts; the identity exactly where a part rests, a hand's pose exactly where it is pinned.
    pub fn poses(&self) -> Vec<Pose> {
        let pose = |(i, member): (usize, &Member)| {
            if let Some(pose) = member.pinned {
                return pose;
            }
            let State { shift, rotation } = self.bodies.state(i);
            match member.snapped {
                true => member.home.0,
                false => Pose::about(member.solid.centre_mm(), rotation.normalize(), shift * self.unit_mm),
            }
        };
        self.members.iter().enumerate().map(pose).collect()
    }

    /// What acts on each part now, in order of parts.
    pub fn wrenches(&self, camera: &Camera) -> Vec<Wrench> {
        let scaled = Camera { eye: camera.eye / self.unit_mm, target: camera.target / self.unit_mm, ..*camera };
        let states: Vec<State> = (0..self.members.len()).map(|i| self.bodies.state(i)).collect();
        let rays: Vec<Ray> = self.points.iter().map(|p| viewing_ray(&scaled, p.position)).collect();
        let sideways = scaled.right_up().0;
        let wrench = |i: usize| self.wrench(i, &states, &rays, sideways);
        let parts = 0..self.members.len();
        // Each part's sum is one thread's, in order; threads only share out the parts.
        if self.members.len() * self.points.len() >= MANY {
            parts.into_par_iter().map(wrench).collect()
        } else {
            parts.map(wrench).collect()
        }
    }

    /// Whether anything but the return force acts.
    fn pushes(&self) -> bool {
        let f = &self.forces;
        let viewing = if f.viewing { f.delta_viewing } else { 0.0 };
        self.degree * f.delta_explosion.max(viewing).max(f.delta_spacing) > 0.0
    }

    fn wrench(&self, i: usize, states: &[State], rays: &[Ray], sideways: DVec3) -> Wrench {
        let (member, state, f) = (&self.members[i], states[i], &self.forces);
        if member.pinned.is_some() || member.snapped && (self.led || !self.pushes()) {
            return Wrench::default();
        }
        let mut sum = Wrench::default();
        let mut add = |force: DVec3, arm: DVec3| {
            sum.force += force;
            sum.torque += arm.cross(force);
        };

        let importance = if self.led { 1.0 } else { member.importance };
        let home = member.home.1;
        let corners = member.solid.corners();
        for &corner in corners {
            let arm = state.rotation * corner;
            let to_home = home.shift + home.rotation * corner - state.shift - arm;
            let force = return_force(to_home, importance * f.return_constant, f.return_length);
            add(force / corners.len() as f64, arm);
        }
        if self.led || self.degree <= 0.0 {
            return sum;
        }

        let total: f64 = self.points.iter().map(|p| p.weight).sum();
        let centre = member.centre + state.shift;
        let (c_e, c_s) = (self.degree * f.delta_explosion, self.degree * f.delta_spacing);
        let c_v = if f.viewing { self.degree * f.delta_viewing * member.gain } else { 0.0 };
        let inverse = state.rotation.inverse();
        for (point, ray) in self.points.iter().zip(rays) {
            let share = point.weight / total;
            let local = inverse * (point.position - centre);
            if c_e > 0.0
                && let Some(push) = explosion_force(&member.solid, local, c_e * share, f.explosion_length)
            {
                add(state.rotation * push.force, state.rotation * push.at);
            }
            if c_v > 0.0 {
                let away = from_ray(ray, centre);
                add(viewing_force(away, c_v * share, f.softening, sideways), DVec3::ZERO);
            }
        }

        let count = self.members.len() as f64;
        for (j, other) in self.members.iter().enumerate().filter(|(j, _)| *j != i) {
            let away = centre - (other.centre + states[j].shift);
            let fallback = if i < j { DVec3::NEG_X } else { DVec3::X };
            add(spacing_force(away, c_s / count, f.softening, fallback), DVec3::ZERO);
        }
        sum
    }
}

fn state_of(pose: &Pose, centre_mm: DVec3, unit_mm: f64) -> State {
    State { shift: (pose.apply(centre_mm) - centre_mm) / unit_mm, rotation: pose.rotation }
}

/// Speed of a part's fastest corner, half-diagonals a second.
fn fastest(bodies: &Bodies, i: usize, solid: &PartShape) -> f64 {
    let (linear, angular) = bodies.velocity(i);
    let rotation = bodies.state(i).rotation;
    solid.corners().iter().map(|&c| (linear + angular.cross(rotation * c)).length()).fold(0.0, f64::max)
}

/// How far two turns are apart: sine of half the angle, both signs of a quaternion being one turn.
fn turned(a: DQuat, b: DQuat) -> f64 {
    let relative = a * b.inverse();
    relative.xyz().length()
}
