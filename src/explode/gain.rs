//! The viewing force's gain, measured: only parts that hide the selection are pushed aside, and no further than it takes.
//!
//! Plain equation 3 of Exploded Views (2006) pushes parts that hide nothing and has several equilibria. Here every part starts
//! with gain 0; one that hides more than 0.1 % of the selection's pixels gets 0.25, then ×1.5 each round, until 99.5 % is
//! visible. Measured at degree 1 from the rest pose whatever came before, then scaled with the degree. Knows no picture: what
//! is hidden is told by a callback, or by the caller between two steps ([`Search`]).

use crate::explode::error::ExplodeError;
use crate::explode::octree::ExplosionPoint;
use crate::explode::poses::Poses;
use crate::explode::simulation::Simulation;
use crate::explode::state::Explosion;
use crate::math::{Camera, Pose};

/// Measurements at most.
pub const MAX_ROUNDS: u32 = 12;
/// Steps at most, all rounds and the last approach together.
pub const MAX_STEPS: u32 = 1500;
/// Share of the selection's pixels that is enough.
const ENOUGH: f64 = 0.995;
/// Share of the selection's pixels that a part may hide.
const TOLERATED: f64 = 0.001;
/// A part's first gain, and the factor of the following.
const FIRST_GAIN: f64 = 0.25;
const RAISE: f64 = 1.5;
/// Fair shares of the steps left that a round may take: parts that are long in finding rest must leave steps to later rounds.
const SHARES: u32 = 2;
/// Steps between two looks at whether to go on.
const SLICE: u32 = 4;
/// Steps kept for the way from degree 1 to the degree asked for.
const LAST_APPROACH: u32 = 200;

/// What a picture from the camera shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// Share of the selection's pixels that is visible, 1 if it has none.
    pub visible: f64,
    /// Share of the selection's pixels that each part hides, in order of parts.
    pub hidden: Vec<f64>,
}

/// Where the parts came to rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Settled {
    /// In order of parts.
    pub poses: Vec<Pose>,
    /// In order of parts; 1 without measuring.
    pub gains: Vec<f64>,
    /// Measurements made.
    pub rounds: u32,
    /// Steps made.
    pub steps: u32,
    /// Whether the parts came to rest within the steps allowed.
    pub at_rest: bool,
    /// Visible share at degree 1 by the last measurement, if there was one.
    pub visible: Option<f64>,
}

/// What [`Search::advance`] ended with.
#[derive(Clone, Debug, PartialEq)]
pub enum SearchStep {
    /// Call again.
    Moving,
    /// Measure the picture with the parts at these poses, and tell [`Search::measured`].
    Measure(Vec<Pose>),
    /// [`Search::settled`] has the answer.
    Done,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Stage {
    Gains,
    Asking,
    Approach,
    Done,
}

/// The search for rest poses in slices, for a window that must not wait.
pub struct Search {
    simulation: Simulation,
    camera: Camera,
    degree: f64,
    gains: Vec<f64>,
    stage: Stage,
    rounds: u32,
    steps: u32,
    /// Steps that this round must not pass.
    limit: u32,
    visible: Option<f64>,
}

impl Search {
    /// Begins at rest; pinned parts are where the hand put them.
    ///
    /// # Errors
    /// If the explosion is not sound.
    pub fn new(explosion: &Explosion, points: &[ExplosionPoint], camera: &Camera) -> Result<Self, ExplodeError> {
        let mut simulation = Simulation::new(explosion, &Poses::default(), points)?;
        let measuring = explosion.forces.measured_gain && explosion.forces.viewing && explosion.degree > 0.0;
        let measuring = measuring && explosion.forces.delta_viewing > 0.0 && !points.is_empty();
        let gains = vec![if measuring { 0.0 } else { 1.0 }; explosion.parts.len()];
        simulation.set_gains(&gains);
        if measuring {
            simulation.set_degree(1.0);
        }
        let stage = if measuring { Stage::Gains } else { Stage::Approach };
        Ok(Self {
            simulation,
            camera: *camera,
            degree: explosion.degree,
            gains,
            stage,
            rounds: 0,
            steps: 0,
            limit: MAX_STEPS * SHARES / MAX_ROUNDS,
            visible: None,
        })
    }

    /// Makes up to `steps` steps, fewer if a measurement is due or all is done.
    pub fn advance(&mut self, steps: u32) -> SearchStep {
        let limit = match self.stage {
            Stage::Asking => return SearchStep::Measure(self.simulation.poses()),
            Stage::Done => return SearchStep::Done,
            Stage::Gains => self.limit.min(self.measuring_steps()),
            Stage::Approach => MAX_STEPS,
        };
        self.steps += self.simulation.settle(&self.camera, steps.min(limit.saturating_sub(self.steps)));
        if self.simulation.moving() && self.steps < limit {
            return SearchStep::Moving;
        }
        if self.stage == Stage::Gains {
            self.stage = Stage::Asking;
            SearchStep::Measure(self.simulation.poses())
        } else {
            self.stage = Stage::Done;
            SearchStep::Done
        }
    }

    /// Steps that rounds of measuring may use up.
    fn measuring_steps(&self) -> u32 {
        if self.degree == 1.0 { MAX_STEPS } else { MAX_STEPS - LAST_APPROACH }
    }

    /// Takes a measurement that [`SearchStep::Measure`] asked for.
    pub fn measured(&mut self, measured: &Measured) {
        if self.stage != Stage::Asking {
            return;
        }
        self.rounds += 1;
        self.visible = Some(measured.visible);
        let mut raised = false;
        let more = self.rounds < MAX_ROUNDS && self.steps < self.measuring_steps();
        if more && measured.visible < ENOUGH {
            for (gain, hidden) in self.gains.iter_mut().zip(&measured.hidden) {
                if *hidden > TOLERATED {
                    *gain = if *gain == 0.0 { FIRST_GAIN } else { *gain * RAISE };
                    raised = true;
                }
            }
        }
        // Parts that still moved when they were looked at may yet come to lie before the selection.
        if raised || more && self.simulation.moving() {
            self.simulation.set_gains(&self.gains);
            self.limit = self.steps + (self.measuring_steps() - self.steps) * SHARES / (MAX_ROUNDS - self.rounds);
            self.stage = Stage::Gains;
        } else {
            if self.degree != 1.0 {
                self.simulation.set_degree(self.degree);
            }
            self.stage = Stage::Approach;
        }
    }

    /// How much of what it may take was done, 0..1: it often takes less.
    fn share(&self) -> f32 {
        (self.steps as f32 / MAX_STEPS as f32).max(self.rounds as f32 / MAX_ROUNDS as f32).min(1.0)
    }

    /// The degree that the poses of [`settled`](Self::settled) are of: gains are measured at 1.
    pub fn degree_now(&self) -> f64 {
        match self.stage {
            Stage::Gains | Stage::Asking => 1.0,
            Stage::Approach | Stage::Done => self.degree,
        }
    }

    /// The answer so far; final after [`SearchStep::Done`].
    pub fn settled(&self) -> Settled {
        Settled {
            poses: self.simulation.poses(),
            gains: self.gains.clone(),
            rounds: self.rounds,
            steps: self.steps,
            at_rest: !self.simulation.moving(),
            visible: self.visible,
        }
    }
}

/// Runs a [`Search`] to its end. `measure` looks at the picture with the parts at given poses; it is called only where forces
/// ask for a measured gain. `go_on` gets the share done, 0..1, every few steps.
///
/// # Errors
/// If the explosion is not sound, or what `measure` or `go_on` failed with.
pub fn settle_with_gain<E: From<ExplodeError>>(
    explosion: &Explosion,
    points: &[ExplosionPoint],
    camera: &Camera,
    measure: &mut dyn FnMut(&[Pose]) -> Result<Measured, E>,
    proceed: &mut dyn FnMut(f32) -> Result<(), E>,
) -> Result<Settled, E> {
    let mut search = Search::new(explosion, points, camera)?;
    loop {
        proceed(search.share())?;
        match search.advance(SLICE) {
            SearchStep::Moving => {}
            SearchStep::Measure(poses) => search.measured(&measure(&poses)?),
            SearchStep::Done => return Ok(search.settled()),
        }
    }
}
