//! Where forces take the parts, and where these stand: at once for a script, step by step for the window.
//!
//! Owns all that the simulation finds: octrees, explosion points, gains, speeds, poses and what they were found for. Nothing of it
//! was decided by anybody, so nothing of it is in the scene or in history. Rest poses are always searched from rest at the present
//! camera, so they depend on nothing that came before; the window leads its bodies towards what was found last while it searches on.

use crate::document::error::DocumentError;
use crate::document::family::{Family, Member};
use crate::document::history::step::Refreshed;
use crate::document::live::graphics::Graphics;
use crate::document::live::stood::{Found, Points, Standing, Stood};
use crate::document::scene::cause::{Cause, has_same_bodies, mark_of_parts, mark_of_scene};
use crate::document::scene::kept_poses::SavedPoses;
use crate::document::state::State;
use crate::document::subject::Subject;
use crate::document::watch::Watch;
use crate::explode::{
    Explosion, Measured, Octrees, Poses, Search, SearchStep, Settled, Simulation, points_of, settle_with_gain,
};
use crate::math::Pose;
use crate::volume::{BrickIndex, FieldKey, FieldKind, LiveCells, TransferFunction, VolumeId};
use std::sync::Arc;

/// Longest edge of the picture that visibility is measured in.
const MEASURED_PX: f64 = 256.0;
/// Steps of the search for each step of the window's animation, at most.
const SEARCH_STEPS: usize = 100;
/// The same for many parts, whose steps cost the square of their number: these times the square of the number, some 80 ms.
const SEARCH_PAIRS: usize = 100_000;

/// A search that runs.
struct Sought {
    cause: Cause,
    points: Points,
    search: Search,
}

/// The simulation of the parts, the poses that it found, and what they were found for.
#[derive(Default)]
pub(crate) struct Motion {
    /// Of a volume and of each sub-volume of it.
    octrees: Option<Vec<Octrees>>,
    /// Whose they are.
    family: Option<Family>,
    points: Option<(Vec<TransferFunction>, u64, Points)>,
    /// How often voxels changed that explosion points stand on.
    voxels: u64,
    poses: Poses,
    bodies: Option<Bodies>,
    sought: Option<Sought>,
    found: Option<Arc<Found>>,
    /// For what they were given up: they could not be moved, or came no nearer.
    given_up: Option<Cause>,
    stood: Stood,
}

/// The window's simulation, and what it was made of.
struct Bodies {
    simulation: Simulation,
    made_of: Explosion,
    poses: Vec<Pose>,
}

/// What some steps of the window's animation did.
pub(crate) struct Moved {
    /// Whether anything still moves or is searched for.
    pub moving: bool,
    /// By the last search that ended.
    pub visible: Option<f64>,
}

impl std::fmt::Debug for Motion {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Motion").field("poses", &self.poses).finish_non_exhaustive()
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
        self.new_voxels();
    }

    fn new_voxels(&mut self) {
        self.points = None;
        self.voxels += 1;
    }

    /// Follows changed voxels.
    pub(crate) fn mirror(&mut self, state: &State, refreshed: &Refreshed) {
        let Some(family) = state.exploded() else { return self.forget_points() };
        let is_other = self.family.as_ref().is_some_and(|before| *before != family);
        if is_other || family.0.iter().any(|member| refreshed.exchanged.contains(&member.id)) {
            return self.forget_points();
        }
        let remapped = family.0.iter().any(|member| refreshed.remapped.contains(&member.id));
        let matters = |key: &FieldKey| matches!(key.kind, FieldKind::Density | FieldKind::Selection);
        let bricks_of = |id: VolumeId| -> Vec<BrickIndex> {
            let slots = refreshed.slots.iter().filter(|(key, _)| key.volume == id && matters(key));
            slots.flat_map(|(_, r)| r.finest()).collect()
        };
        let bricks: Vec<Vec<BrickIndex>> = family.0.iter().map(|member| bricks_of(member.id)).collect();
        if bricks.iter().all(Vec::is_empty) && !remapped {
            return;
        }
        self.new_voxels();
        let each = self.octrees.iter_mut().flatten().zip(family.subjects(state)).zip(bricks);
        let updated = each.into_iter().try_for_each(|((octrees, (_, subject)), bricks)| {
            octrees.update(&subject.volume.density, &subject.volume.selection, bricks)
        });
        if let Err(error) = updated {
            tracing::warn!("{error}");
            self.octrees = None;
        }
    }

    /// Follows a stroke on density or the selection that is still running.
    pub(crate) fn follow(
        &mut self,
        state: &State,
        live: &[(FieldKey, BrickIndex, LiveCells)],
    ) -> Result<(), DocumentError> {
        let place_in = |family: &Family, key: &FieldKey| family.0.iter().position(|member| member.id == key.volume);
        let of_it = |family: &Family| live.iter().any(|(key, ..)| place_in(family, key).is_some());
        let Some(family) = state.exploded().filter(of_it) else {
            return Ok(());
        };
        let all = self.octrees(state, &family)?;
        for (key, index, cells) in live {
            let (Some(at), Some(volume)) = (place_in(&family, key), state.volumes.get(&key.volume)) else { continue };
            match key.kind {
                FieldKind::Selection => all[at].paint(&volume.density, *index, &cells.selected),
                _ => all[at].paint_density(&volume.density, *index, &cells.ranges),
            }
        }
        self.new_voxels();
        Ok(())
    }

    fn octrees(&mut self, state: &State, family: &Family) -> Result<&mut Vec<Octrees>, DocumentError> {
        // Whoever reads the first volume ahead has learned nothing that parts would have to follow.
        if self.family.replace(family.clone()).is_some_and(|before| before != *family) {
            self.forget_points();
        }
        Ok(match self.octrees.take() {
            Some(octrees) => self.octrees.insert(octrees),
            None => {
                let of = |(member, subject): (&Member, Subject<'_>)| {
                    let (volume, standing) = (subject.volume, member.standing.clone());
                    Octrees::within(subject.grid(), standing, &volume.density, &volume.selection)
                };
                self.octrees.insert(family.subjects(state).map(of).collect::<Result<_, _>>()?)
            }
        })
    }

    fn points(&mut self, state: &State) -> Result<Points, DocumentError> {
        let Some(family) = state.exploded() else { return Ok(Points::from(Vec::new())) };
        let transfers: Vec<TransferFunction> =
            family.subjects(state).map(|(_, subject)| subject.transfer().clone()).collect();
        let seed = state.scene.explosion.seed;
        if self.family.as_ref().is_some_and(|before| *before != family) {
            self.forget_points();
        }
        if let Some((t, s, points)) = &self.points
            && *t == transfers
            && *s == seed
        {
            return Ok(points.clone());
        }
        let shown: Vec<_> = self.octrees(state, &family)?.iter().zip(&transfers).collect();
        let points: Points = points_of(&shown, seed).into();
        self.points = Some((transfers, seed, points.clone()));
        Ok(points)
    }

    /// Where the parts stand.
    pub(crate) fn poses(&self) -> &Poses {
        &self.poses
    }

    /// Somebody decided something about the parts: what stood under the scene of `before` stands as it did, halves where the whole
    /// stood. With `remember` undo can bring back how it is now. Answers whether that says something new of where parts stand.
    pub(crate) fn decided(&mut self, before: &Explosion, now: &Explosion, remember: bool) -> bool {
        if before == now {
            return false;
        }
        if remember {
            self.remember(before);
        }
        let carried = self.poses.carried(before, now);
        carried != std::mem::replace(&mut self.poses, carried.clone())
    }

    /// History brought other parts or another degree: they stand where they stood when that was left, or, if nobody remembers, in
    /// the unexploded volume at rest and in any other where they are.
    pub(crate) fn travelled(&mut self, before: &Explosion, now: &Explosion) {
        if before == now {
            return;
        }
        self.remember(before);
        match self.stood.under(&mark_of_parts(now)) {
            Some(Standing { poses, found }) => {
                self.poses = poses.clone();
                self.found = found.clone().or_else(|| self.found.take());
            }
            None if now.degree == 0.0 => self.poses = Poses::default(),
            None => self.poses = self.poses.carried(before, now),
        }
        self.sought = None;
    }

    fn remember(&mut self, left: &Explosion) {
        let of = |found: &&Arc<Found>| has_same_bodies(found.cause.explosion(), left);
        let standing = Standing { poses: self.poses.clone(), found: self.found.as_ref().filter(of).cloned() };
        self.stood.note(mark_of_parts(left), standing);
    }

    /// What is kept beside the scene.
    pub(crate) fn kept(&self, state: &State) -> SavedPoses {
        let rest_of = (!self.must_move(state)).then(|| mark_of_scene(&state.scene));
        SavedPoses { rest_of, parts: self.poses.clone() }
    }

    /// Parts stand where they were kept.
    pub(crate) fn stand(&mut self, state: &State, kept: SavedPoses) {
        let rests = kept.rest_of.is_some_and(|mark| mark == mark_of_scene(&state.scene));
        self.poses = kept.parts;
        self.found = rests.then(|| {
            let (cause, parts) = (Cause::of(&state.scene, self.voxels), &state.scene.explosion.parts);
            Arc::new(Found { cause, points: None, poses: self.poses.in_order(parts), visible: None })
        });
    }

    /// Whether parts do not stand where forces would have them now, as far as that is known and can be changed.
    pub(crate) fn must_move(&self, state: &State) -> bool {
        self.is_away(state) && !self.given_up.as_ref().is_some_and(|cause| cause.holds(&state.scene, self.voxels))
    }

    fn is_away(&self, state: &State) -> bool {
        let explosion = &*state.scene.explosion;
        let rests = |found: &Arc<Found>| {
            found.cause.holds(&state.scene, self.voxels) && found.poses == self.poses.in_order(&explosion.parts)
        };
        match explosion.degree == 0.0 {
            true => !self.poses.is_empty(),
            false => !self.found.as_ref().is_some_and(rests),
        }
    }

    /// Rest poses, at once.
    pub(crate) fn settle(
        &mut self,
        state: &State,
        graphics: &mut Graphics,
        watch: &Watch,
    ) -> Result<Settled, DocumentError> {
        let points = self.points(state)?;
        let (explosion, camera) = (&*state.scene.explosion, state.scene.views.camera);
        let mut look = |poses: &[Pose]| measure(state, graphics, poses);
        let mut proceed = |share| if watch.proceed(share) { Ok(()) } else { Err(DocumentError::Stopped) };
        let settled = settle_with_gain(explosion, &points, &camera, &mut look, &mut proceed)?;
        let (cause, poses) = (Cause::of(&state.scene, self.voxels), settled.poses.clone());
        self.poses = Poses::found(&explosion.parts, &poses);
        self.found = Some(Arc::new(Found { cause, points: Some(points), poses, visible: settled.visible }));
        (self.sought, self.bodies, self.given_up) = (None, None, None);
        Ok(settled)
    }

    /// Reads what explosion points are found in, so that the first move of the slider need not wait for it.
    pub(crate) fn prepare(&mut self, state: &State) -> Result<(), DocumentError> {
        if let (true, Some(family)) = (state.scene.explosion.parts.len() > 1, state.exploded()) {
            self.octrees(state, &family)?;
        }
        Ok(())
    }

    /// Where the window's bodies are led: to what was found, and until something is found for the present degree to what was found
    /// for another one, or to where the search has come, as far as that degree says.
    fn target(&self, explosion: &Explosion) -> Vec<Pose> {
        let of = |cause: &Cause| has_same_bodies(cause.explosion(), explosion);
        let found = self.found.as_ref().filter(|found| of(&found.cause));
        let found = found.map(|found| (found.cause.explosion().degree, found.poses.clone()));
        let sought = self.sought.as_ref().filter(|sought| of(&sought.cause));
        let sought = || sought.map(|Sought { search, .. }| (search.degree_now(), search.settled().poses));
        match found.filter(|(degree, _)| *degree > 0.0 || explosion.degree == 0.0).or_else(sought) {
            Some((degree, poses)) if degree == explosion.degree => poses,
            Some((degree, poses)) if degree > 0.0 => {
                let share = explosion.degree / degree;
                let shared = |(part, pose): (&crate::explode::Part, &Pose)| match part.held {
                    Some(held) => held,
                    None => pose.share(share, part.centre()),
                };
                explosion.parts.iter().zip(&poses).map(shared).collect()
            }
            _ => self.poses.in_order(&explosion.parts),
        }
    }

    /// Steps of 1/60 s of the window's animation.
    pub(crate) fn step(&mut self, state: &State, graphics: &mut Graphics, steps: u32) -> Result<Moved, DocumentError> {
        let moved = self.search_on(state, graphics, steps).and_then(|()| self.lead_on(state, steps));
        // What fails is not tried again before something is another way.
        let over = moved.as_ref().map_or(true, |moved| steps > 0 && !moved.moving && self.is_away(state));
        self.given_up = over.then(|| Cause::of(&state.scene, self.voxels));
        moved
    }

    fn search_on(&mut self, state: &State, graphics: &mut Graphics, steps: u32) -> Result<(), DocumentError> {
        let points = self.points(state)?;
        let (explosion, camera) = (&*state.scene.explosion, state.scene.views.camera);
        if self.found.as_ref().is_some_and(|found| found.cause.holds(&state.scene, self.voxels)) {
            self.sought = None;
            return Ok(());
        }
        // A search that runs is ended before the next begins: while someone paints or turns, causes change every frame.
        if self.sought.is_none() {
            let cause = Cause::of(&state.scene, self.voxels);
            let known = |found: &&Found| found.cause.is_like(&cause) && found.points.as_ref() == Some(&points);
            match self.found.as_deref().filter(known) {
                // The same points, so the same poses.
                Some(found) => {
                    let (poses, visible) = (found.poses.clone(), found.visible);
                    self.found = Some(Arc::new(Found { cause, points: Some(points), poses, visible }));
                }
                None => {
                    let search = Search::new(explosion, &points, &camera)?;
                    self.sought = Some(Sought { cause, points, search });
                }
            }
        }
        // Counted, not timed: the same script gives the same poses.
        let slice = (SEARCH_PAIRS / explosion.parts.len().pow(2).max(1)).clamp(2, SEARCH_STEPS) as u32;
        for _ in 0..steps.max(1) {
            let Some(Sought { search, .. }) = &mut self.sought else { break };
            match search.advance(slice) {
                SearchStep::Moving => {}
                SearchStep::Measure(poses) => {
                    // A change of parts since the search began makes its measurement meaningless, not wrong.
                    let measured = if poses.len() == explosion.parts.len() {
                        measure(state, graphics, &poses)?
                    } else {
                        Measured { visible: 1.0, hidden: vec![0.0; poses.len()] }
                    };
                    search.measured(&measured);
                }
                SearchStep::Done => {
                    let Settled { poses, visible, .. } = search.settled();
                    let done = self.sought.take().map(|Sought { cause, points, .. }| (cause, Some(points)));
                    self.found = done.map(|(cause, points)| Arc::new(Found { cause, points, poses, visible }));
                }
            }
        }
        Ok(())
    }

    fn lead_on(&mut self, state: &State, steps: u32) -> Result<Moved, DocumentError> {
        let (explosion, camera) = (&*state.scene.explosion, state.scene.views.camera);
        let poses = self.poses.in_order(&explosion.parts);
        let mut bodies = match self.bodies.take() {
            Some(b) if has_same_bodies(&b.made_of, explosion) && b.poses == poses => b,
            _ => {
                Bodies { simulation: Simulation::new(explosion, &self.poses, &[])?, made_of: explosion.clone(), poses }
            }
        };
        bodies.simulation.lead(Some(&self.target(explosion)));
        let mut moving = false;
        for _ in 0..steps {
            moving = bodies.simulation.step(&camera);
        }
        bodies.poses = bodies.simulation.poses();
        self.poses = Poses::found(&explosion.parts, &bodies.poses);
        self.bodies = Some(bodies);
        let visible = self.found.as_ref().and_then(|found| found.visible);
        Ok(Moved { moving: moving || self.sought.is_some(), visible })
    }
}

/// What the picture shows of the selection with the parts at these poses.
fn measure(state: &State, graphics: &mut Graphics, poses: &[Pose]) -> Result<Measured, DocumentError> {
    let (parts, views) = (&state.scene.explosion.parts, &state.scene.views);
    let longest = f64::from(views.size[0].max(views.size[1]));
    let size = views.size.map(|s| (f64::from(s) * MEASURED_PX / longest).round().max(1.0) as u32);
    let frame = state.parted_frame(&Poses::found(parts, poses), &views.camera, size);
    let seen = graphics.visibility(state, &frame)?;
    let share = |pixels: u64| pixels as f64 / seen.selected.max(1) as f64;
    let hidden = parts
        .iter()
        .map(|part| seen.hidden_by.iter().find(|(id, _)| *id == part.id.0).map_or(0.0, |(_, pixels)| share(*pixels)));
    Ok(Measured { visible: seen.share(), hidden: hidden.collect() })
}
