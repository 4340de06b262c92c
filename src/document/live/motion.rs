//! Where forces take the parts: at once for a script, step by step for the window.
//!
//! Rest poses are always searched from the rest pose at the present camera, so they depend on nothing that came before; the window
//! leads its bodies towards what was found last while it searches on. Owns octrees, explosion points and the window's bodies.

use crate::document::error::DocumentError;
use crate::document::history::step::Refreshed;
use crate::document::live::graphics::Graphics;
use crate::document::state::State;
use crate::document::watch::Watch;
use crate::explode::{
    Explosion, ExplosionPoint, Measured, Octrees, Progress, Search, Settled, Simulation, settle_with_gain,
};
use crate::math::{Camera, Pose};
use crate::volume::{BrickIndex, FieldKind, LiveCells, TransferFunction};

/// Longest edge of the picture that visibility is measured in.
const MEASURED_PX: f64 = 256.0;
/// Steps of the search for each step of the window's animation, at most.
const SEARCH_STEPS: usize = 100;
/// The same for many parts, whose steps cost the square of their number: these times the square of the number, some 80 ms.
const SEARCH_PAIRS: usize = 100_000;

/// What rest poses depend on.
#[derive(Clone, Debug, PartialEq)]
struct Cause {
    /// Poses of parts that are not pinned are the identity here.
    explosion: Explosion,
    camera: Camera,
    points: Vec<ExplosionPoint>,
}

/// See the module's head.
#[derive(Default)]
pub(crate) struct Motion {
    octrees: Option<Octrees>,
    points: Option<(TransferFunction, u64, Vec<ExplosionPoint>)>,
    bodies: Option<Bodies>,
    search: Option<(Cause, Search)>,
    reached: Option<(Cause, Settled)>,
}

/// The window's simulation, and what it was made of.
struct Bodies {
    simulation: Simulation,
    made_of: Explosion,
    poses: Vec<Pose>,
}

/// What some steps of the window's animation did.
pub(crate) struct Moved {
    pub poses: Vec<Pose>,
    /// Whether anything still moves or is searched for.
    pub moving: bool,
    /// By the last search that ended.
    pub visible: Option<f64>,
}

impl std::fmt::Debug for Motion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Motion").field("points", &self.points.as_ref().map(|p| p.2.len())).finish_non_exhaustive()
    }
}

impl Motion {
    /// Another volume is open.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }

    /// What was painted and taken back again is read anew.
    pub(crate) fn forget_points(&mut self) {
        self.octrees = None;
        self.points = None;
    }

    /// Follows changed voxels.
    pub(crate) fn mirror(&mut self, state: &State, refreshed: &Refreshed) {
        let slots =
            refreshed.slots.iter().filter(|(kind, _)| matches!(kind, FieldKind::Density | FieldKind::Selection));
        let bricks: Vec<BrickIndex> = slots.flat_map(|(_, r)| r.finest()).collect();
        if bricks.is_empty() && !refreshed.remapped {
            return;
        }
        self.points = None;
        let updated = self.octrees.as_mut().map(|o| o.update(&state.density, &state.selection, bricks.iter().copied()));
        if let Some(Err(error)) = updated {
            tracing::warn!("{error}");
            self.octrees = None;
        }
    }

    /// Follows a stroke on density or the selection that is still running.
    pub(crate) fn follow(
        &mut self,
        state: &State,
        kind: FieldKind,
        live: &[(BrickIndex, LiveCells)],
    ) -> Result<(), DocumentError> {
        if live.is_empty() {
            return Ok(());
        }
        let octrees = self.octrees(state)?;
        for (index, cells) in live {
            match kind {
                FieldKind::Selection => octrees.paint(&state.density, *index, &cells.selected),
                _ => octrees.paint_density(&state.density, *index, &cells.ranges),
            }
        }
        self.points = None;
        Ok(())
    }

    fn octrees(&mut self, state: &State) -> Result<&mut Octrees, DocumentError> {
        Ok(match self.octrees.take() {
            Some(octrees) => self.octrees.insert(octrees),
            None => self.octrees.insert(Octrees::new(state.grid(), &state.density, &state.selection)?),
        })
    }

    fn points(&mut self, state: &State) -> Result<&[ExplosionPoint], DocumentError> {
        let (transfer, seed) = (&state.scene.transfer, state.scene.explosion.seed);
        if self.points.as_ref().is_none_or(|(t, s, _)| t != transfer || *s != seed) {
            let found = self.octrees(state)?.points(transfer, seed);
            self.points = Some((transfer.clone(), seed, found));
        }
        Ok(self.points.as_ref().map_or(&[], |(.., points)| points))
    }

    /// Rest poses, at once.
    pub(crate) fn settle(
        &mut self,
        state: &State,
        graphics: &mut Graphics,
        watch: &Watch,
    ) -> Result<Settled, DocumentError> {
        let points = self.points(state)?.to_vec();
        let (explosion, camera) = (&state.scene.explosion, state.scene.views.camera);
        let mut look = |poses: &[Pose]| measure(state, graphics, poses);
        let mut go_on = |share| if watch.go_on(share) { Ok(()) } else { Err(DocumentError::Stopped) };
        let settled = settle_with_gain(explosion, &points, &camera, &mut look, &mut go_on)?;
        self.reached = Some((Cause { explosion: at_rest(explosion), camera, points }, settled.clone()));
        self.search = None;
        self.bodies = None;
        Ok(settled)
    }

    /// Reads what explosion points are found in, so that the first move of the slider need not wait for it.
    pub(crate) fn prepare(&mut self, state: &State) -> Result<(), DocumentError> {
        if self.octrees.is_none() && state.scene.explosion.parts.len() > 1 {
            self.octrees(state)?;
        }
        Ok(())
    }

    /// Where the window's bodies are led: to what was found, and until something is found for the present degree to what was found
    /// for another one, or to where the search has come, as far as that degree says.
    fn target(&self, explosion: &Explosion) -> Vec<Pose> {
        let found = self.reached.as_ref().filter(|(cause, _)| alike(&cause.explosion, explosion));
        let found = found.map(|(cause, settled)| (cause.explosion.degree, settled.poses.clone()));
        let sought = self.search.as_ref().filter(|(cause, _)| alike(&cause.explosion, explosion));
        let sought = || sought.map(|(_, search)| (search.degree_now(), search.settled().poses));
        match found.filter(|(degree, _)| *degree > 0.0 || explosion.degree == 0.0).or_else(sought) {
            Some((degree, poses)) if degree == explosion.degree => poses,
            Some((degree, poses)) if degree > 0.0 => {
                let share = explosion.degree / degree;
                explosion.parts.iter().zip(&poses).map(|(part, pose)| pose.share(share, part.centre())).collect()
            }
            _ => explosion.poses(),
        }
    }

    /// Steps of 1/60 s of the window's animation.
    pub(crate) fn step(&mut self, state: &State, graphics: &mut Graphics, steps: u32) -> Result<Moved, DocumentError> {
        let points = self.points(state)?.to_vec();
        let (explosion, camera) = (&state.scene.explosion, state.scene.views.camera);
        let cause = Cause { explosion: at_rest(explosion), camera, points };
        // A search that runs is ended before the next begins: while someone paints or turns, causes change every frame.
        if self.search.is_none() && self.reached.as_ref().is_none_or(|(reached, _)| *reached != cause) {
            let search = Search::new(explosion, &cause.points, &camera)?;
            self.search = Some((cause, search));
        }
        // Counted, not timed: the same script gives the same poses.
        let slice = (SEARCH_PAIRS / explosion.parts.len().pow(2).max(1)).clamp(2, SEARCH_STEPS) as u32;
        for _ in 0..steps.max(1) {
            let Some((_, search)) = &mut self.search else { break };
            match search.advance(slice) {
                Progress::Moving => {}
                Progress::Measure(poses) => {
                    // A change of parts since the search began makes its measurement meaningless, not wrong.
                    let measured = if poses.len() == explosion.parts.len() {
                        measure(state, graphics, &poses)?
                    } else {
                        Measured { visible: 1.0, hidden: vec![0.0; poses.len()] }
                    };
                    search.measured(&measured);
                }
                Progress::Done => {
                    let settled = search.settled();
                    self.reached = self.search.take().map(|(cause, _)| (cause, settled));
                }
            }
        }
        let poses = explosion.poses();
        let mut bodies = match self.bodies.take() {
            Some(b) if b.made_of == at_rest(explosion) && b.poses == poses => b,
            Some(b) if alike(&b.made_of, explosion) && b.poses == poses => Bodies { made_of: at_rest(explosion), ..b },
            _ => Bodies { simulation: Simulation::new(explosion, &[])?, made_of: at_rest(explosion), poses },
        };
        bodies.simulation.lead(Some(&self.target(explosion)));
        let mut moving = false;
        for _ in 0..steps {
            moving = bodies.simulation.step(&camera);
        }
        bodies.poses = bodies.simulation.poses();
        let moved = Moved {
            poses: bodies.poses.clone(),
            moving: moving || self.search.is_some(),
            visible: self.reached.as_ref().and_then(|(_, settled)| settled.visible),
        };
        self.bodies = Some(bodies);
        Ok(moved)
    }
}

/// The explosion without what a simulation decides.
fn at_rest(explosion: &Explosion) -> Explosion {
    let mut explosion = explosion.clone();
    explosion.parts.iter_mut().filter(|p| !p.pinned).for_each(|p| p.pose = Pose::IDENTITY);
    explosion
}

/// Whether two explosions have the same bodies: forces and degree may differ.
fn alike(a: &Explosion, b: &Explosion) -> bool {
    a.parts.len() == b.parts.len()
        && a.parts.iter().zip(&b.parts).all(|(a, b)| {
            a.id == b.id
                && a.pinned == b.pinned
                && a.importance == b.importance
                && a.faces == b.faces
                && (!a.pinned || a.pose == b.pose)
        })
}

/// What the picture shows of the selection with the parts at these poses.
fn measure(state: &State, graphics: &mut Graphics, poses: &[Pose]) -> Result<Measured, DocumentError> {
    let mut explosion = state.scene.explosion.clone();
    explosion.set_poses(poses);
    let views = &state.scene.views;
    let longest = f64::from(views.size[0].max(views.size[1]));
    let size = views.size.map(|s| (f64::from(s) * MEASURED_PX / longest).round().max(1.0) as u32);
    let seen = graphics.visibility(state, &state.parted_frame(&explosion, &views.camera, size))?;
    let share = |pixels: u64| pixels as f64 / seen.selected.max(1) as f64;
    let hidden = explosion
        .parts
        .iter()
        .map(|part| seen.hidden_by.iter().find(|(id, _)| *id == part.id.0).map_or(0.0, |(_, pixels)| share(*pixels)));
    Ok(Measured { visible: seen.share(), hidden: hidden.collect() })
}
