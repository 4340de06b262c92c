//! The rigid bodies, and the engine's exact arithmetic: the only file that knows the physics engine.
//!
//! A body's position is its part's displacement from rest in half-diagonals, so that at rest it is zero exactly. There is no
//! gravity, no collider and no sleep: forces are given anew for every step.

use crate::math::{DQuat, DVec3};
use rapier3d::dynamics::RigidBodyType;
use rapier3d::math::{Pose, Rotation, Vector};
use rapier3d::na::ComplexField;
use rapier3d::prelude::{MassProperties, PhysicsWorld, RigidBody, RigidBodyBuilder, RigidBodyHandle};

/// Where a body is: shift of its centre in half-diagonals, and turn about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct State {
    pub shift: DVec3,
    pub rotation: DQuat,
}

impl State {
    pub(super) const REST: Self = Self { shift: DVec3::ZERO, rotation: DQuat::IDENTITY };

    /// How far a point about the centre at rest is from that centre now.
    pub(super) fn place(&self, point: DVec3) -> DVec3 {
        self.shift + self.rotation * point
    }
}

/// Seconds a step.
pub(super) const STEP_S: f64 = 1.0 / 60.0;
/// Linear and angular damping, 1/s.
const DAMPING: f32 = 12.0;

pub(super) struct Bodies {
    world: PhysicsWorld,
    handles: Vec<RigidBodyHandle>,
}

impl Bodies {
    pub(super) fn new() -> Self {
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::ZERO;
        world.integration_parameters.dt = STEP_S as f32;
        Self { world, handles: Vec::new() }
    }

    /// Adds a body with the same inertia about every axis; a fixed one is never moved by forces.
    pub(super) fn add(&mut self, mass: f64, inertia: f64, fixed: bool, state: State) {
        let builder = if fixed { RigidBodyBuilder::fixed() } else { RigidBodyBuilder::dynamic() };
        let body = builder
            .pose(pose(state))
            .additional_mass_properties(MassProperties::new(Vector::ZERO, mass as f32, Vector::splat(inertia as f32)))
            .linear_damping(DAMPING)
            .angular_damping(DAMPING)
            .can_sleep(false);
        self.handles.push(self.world.insert_body(body));
    }

    pub(super) fn state(&self, i: usize) -> State {
        let Some(body) = self.world.bodies.get(self.handles[i]) else { return State::REST };
        State { shift: body.translation().as_dvec3(), rotation: body.rotation().as_dquat() }
    }

    /// Velocity of the centre in half-diagonals a second, and of the turn in radians a second, world axes.
    pub(super) fn velocity(&self, i: usize) -> (DVec3, DVec3) {
        let velocity = |body: &RigidBody| (body.linvel().as_dvec3(), body.angvel().as_dvec3());
        self.world.bodies.get(self.handles[i]).map_or((DVec3::ZERO, DVec3::ZERO), velocity)
    }

    /// Puts a body somewhere, without speed.
    pub(super) fn put(&mut self, i: usize, state: State) {
        if let Some(body) = self.world.bodies.get_mut(self.handles[i]) {
            body.set_position(pose(state), true);
            body.set_linvel(Vector::ZERO, true);
            body.set_angvel(Vector::ZERO, true);
        }
    }

    /// Whether forces leave a body alone.
    pub(super) fn fix(&mut self, i: usize, fixed: bool) {
        if let Some(body) = self.world.bodies.get_mut(self.handles[i]) {
            body.set_body_type(if fixed { RigidBodyType::Fixed } else { RigidBodyType::Dynamic }, true);
        }
    }

    /// One step with these forces and torques about the centres.
    pub(super) fn step(&mut self, wrenches: &[(DVec3, DVec3)]) {
        for (handle, (force, torque)) in self.handles.iter().zip(wrenches) {
            if let Some(body) = self.world.bodies.get_mut(*handle) {
                // They persist from step to step until reset.
                body.reset_forces(true);
                body.reset_torques(true);
                body.add_force(force.as_vec3(), true);
                body.add_torque(torque.as_vec3(), true);
            }
        }
        self.world.step();
    }
}

fn pose(state: State) -> Pose {
    let q: Rotation = state.rotation.as_quat();
    Pose::from_parts(state.shift.as_vec3(), q)
}

/// The engine's own software exponential: the system's may differ in the last bit from one processor to the next.
pub(super) fn exp(x: f64) -> f64 {
    ComplexField::exp(x)
}

/// The same of ln(1 + x).
pub(super) fn ln_1p(x: f64) -> f64 {
    ComplexField::ln_1p(x)
}
