//! Painting: from the points of a command to a step of history.
//!
//! While a stroke runs, questions, moves of the view and steps of the simulation leave it running; every other command ends it
//! first, as `stroke.end` would. The GPU holds its texels until [`Document::finish_stroke`], which is the one place that waits for them.
//! While a stroke runs, a command that is not one of its own may end it first, as `stroke.end` would; which do, their effects say.
//! The GPU holds its texels until [`Document::finish_stroke`], which is the one place that waits for them.

use crate::document::Document;
use crate::document::apply::stroke_nothing::why_nothing;
use crate::document::apply::trail::{Resolved, Trail};
use crate::document::command::answers::{Answer, CancelledSaid, ExtendedSaid, PaintedSaid, Said};
use crate::document::command::brush::{StrokeCommand, StrokePoint};
use crate::document::command::resolved::ResolvedCommand;
use crate::document::command::{Command, Place};
use crate::document::error::DocumentError;
use crate::document::history::edit::Edit;
use crate::document::place::normal_of;
use crate::document::scene::ViewName;
use crate::gpu::GpuError;
use crate::math::Camera;
use crate::paint::{Brush, BuildUpBound, Dab, Reach, Sample, StrokePath, Target, VoxelSet};
use crate::volume::{DensityMap, FieldKey, FieldKind, Volume, VolumeId};

/// A stroke that has begun.
#[derive(Debug)]
pub(crate) struct Running {
    /// What it paints on.
    volume: VolumeId,
    brush: Brush,
    /// Where what is visible was seen from, if it keeps to that.
    camera: Option<Camera>,
    path: StrokePath,
    /// Of a brush that adds up on density: what may have, and for how much of it the map has room.
    build_up: Option<(BuildUpBound, f64)>,
    /// That of density before the stroke, and with all that the brush makes.
    reach: [Reach; 2],
    /// What came before the first dab: a segment that was missing, a map that was too narrow.
    edit: Edit,
    /// Where it has got to in the 3D view.
    trail: Option<Trail>,
    /// What of the visible surface it has come to, if it keeps to that.
    seen: VoxelSet,
    samples: Vec<Sample>,
    dabs: u64,
    missed: u64,
}

impl Running {
    /// The field that it paints.
    pub(crate) fn field(&self) -> FieldKey {
        FieldKey::new(self.volume, self.brush.target.field())
    }
}

impl Document {
    pub(crate) fn stroke(&mut self, command: &StrokeCommand) -> Result<Answer, DocumentError> {
        let volume = self.open()?.at(command.volume())?.id;
        let running = self.running.is_some();
        match command {
            StrokeCommand::Begin { .. } | StrokeCommand::Paint { .. } if running => {
                Err(DocumentError::NotNow("a stroke is running; end it (stroke.end) or cancel it first".into()))
            }
            StrokeCommand::Begin { points, .. } => self.begin_with(volume, points),
            StrokeCommand::Paint { points, .. } => {
                self.begin_with(volume, points)?;
                self.finish_stroke()
            }
            StrokeCommand::Extend { .. } | StrokeCommand::End {} | StrokeCommand::Cancel {} if !running => {
                Err(DocumentError::NotNow("no stroke is running; stroke.begin starts one".into()))
            }
            StrokeCommand::Extend { points } => {
                let volume = self.running.as_ref().map_or(volume, |r| r.volume);
                let trail = self.running.as_ref().and_then(|r| r.trail.clone());
                let resolved = self.follow(volume, points, trail)?;
                self.extend_stroke(resolved)
            }
            StrokeCommand::End {} => self.finish_stroke(),
            StrokeCommand::Cancel {} => {
                self.drop_stroke();
                Ok(Said::from(CancelledSaid { cancelled: true, step: None }).into())
            }
        }
    }

    /// Begins a stroke on a volume with these points.
    fn begin_with(&mut self, volume: VolumeId, points: &[StrokePoint]) -> Result<Answer, DocumentError> {
        let resolved = self.follow(volume, points, None)?;
        self.begin_stroke(volume, resolved)
    }

    /// Whether a stroke runs.
    pub fn is_painting(&self) -> bool {
        self.running.is_some()
    }

    /// Ends the running stroke: waits for the GPU, takes its bricks into the field and makes a step of them. The answer is that
    /// of `stroke.end`. Without a stroke it does nothing.
    ///
    /// # Errors
    /// If the device fails or the source does; the stroke then still runs.
    pub fn finish_stroke(&mut self) -> Result<Answer, DocumentError> {
        let cut_short = self.end_path()?;
        let (Some(running), Some(state)) = (&mut self.running, &mut self.state) else { return Ok(Answer::default()) };
        let key = running.field();
        let changes: Vec<_> =
            self.graphics.finish(state)?.into_iter().map(|(index, brick)| (index, Some(brick))).collect();
        let Some(mut running) = self.running.take() else { return Ok(Answer::default()) };
        let swapped = running.edit.swap(state, key, changes);
        let (voxels, bricks) = running.edit.counts();
        if swapped.is_err() || voxels == 0 {
            // Nothing painted: the segment or the wider map that was made for it goes too.
            let refreshed = running.edit.roll_back(state)?;
            self.mirror(&refreshed);
            self.no_stroke();
            swapped?;
            let why = why_nothing(
                &self.open()?.at(Some(key.volume))?,
                &running.brush,
                &running.samples,
                running.missed,
                &running.seen,
            )?;
            let said = PaintedSaid {
                step: None,
                dabs: running.dabs,
                missed: running.missed,
                voxels_changed: 0,
                bricks_touched: None,
                nothing: Some(why),
            };
            return Ok(Said::from(said).into());
        }
        if let (FieldKind::Density, Some(volume)) = (key.kind, state.volumes.get_mut(&key.volume)) {
            let [before, after] = running.reach;
            volume.painted = Some(after.within(before, &volume.density).0);
        }
        let axial = normal_of(&state.at(Some(key.volume))?, ViewName::Axial);
        let at = |s: &Sample| {
            let Sample { position, normal, pressure, breaks } = *s;
            let normal = (normal != axial).then(|| normal.to_array());
            StrokePoint { at: Place::Mm(position.to_array()), pressure, breaks, normal }
        };
        let done = Command::Stroke(StrokeCommand::Paint {
            points: running.samples.iter().map(at).collect(),
            volume: (key.volume != state.scene.volumes.active).then_some(key.volume),
        });
        running.edit.made_by(ResolvedCommand {
            brush: Some(running.brush),
            camera: running.camera,
            ..ResolvedCommand::plain(done.clone())
        });
        let (step, mut refreshed) = running.edit.finish(state);
        // The GPU took a wider map over at the stroke's beginning.
        refreshed.painted = true;
        refreshed.remapped.clear();
        let said = PaintedSaid {
            step: step.as_ref().map(|s| s.name.clone()),
            dabs: running.dabs,
            missed: running.missed,
            voxels_changed: voxels,
            bricks_touched: Some(bricks),
            nothing: None,
        };
        self.mirror(&refreshed);
        let mut trouble: Vec<String> = cut_short.into_iter().collect();
        if let Some(step) = step {
            self.unsaved = true;
            trouble.extend(self.history.push(step)?);
        }
        trouble.extend(self.note(&done, &refreshed.bricks, true));
        self.revision += 1;
        Ok(Answer { trouble, ..Answer::from(Said::from(said)) })
    }

    /// Paints what is left of the running stroke: what the pointer passed since its last whole pixel, and the dab at its last sample.
    /// Where there is no room for it the stroke ends without, and the answer says so.
    fn end_path(&mut self) -> Result<Option<String>, DocumentError> {
        let Some(running) = &self.running else { return Ok(None) };
        let mut path = running.path.clone();
        let samples = running.trail.as_ref().map_or_else(Vec::new, Trail::end);
        let mut dabs = path.extend(&samples)?;
        dabs.extend(path.end());
        if dabs.is_empty() {
            return Ok(None);
        }
        self.make_room(&dabs)?;
        self.keep_to_surface(&dabs)?;
        let (Some(running), Some(state)) = (&mut self.running, &self.state) else { return Ok(None) };
        match self.graphics.extend(state, &dabs) {
            Ok(_) => running.dabs += dabs.len() as u64,
            Err(DocumentError::Gpu(error @ (GpuError::StrokeTooLarge { .. } | GpuError::PoolFull { .. }))) => {
                return Ok(Some(format!("the stroke ends before its last point: {error}")));
            }
            Err(error) => return Err(error),
        }
        running.path = path;
        running.samples.extend(samples);
        running.trail = None;
        Ok(None)
    }

    /// Takes the running stroke back.
    pub(crate) fn drop_stroke(&mut self) {
        let (Some(running), Some(state)) = (self.running.take(), &mut self.state) else { return };
        self.graphics.cancel(state, running.field());
        // Of a stroke there is at most a segment and a map to take back; a source that fails leaves the wider map.
        match running.edit.roll_back(state) {
            Ok(refreshed) => self.mirror(&refreshed),
            Err(error) => tracing::warn!("{error}"),
        }
        self.motion.forget_points();
        self.no_stroke();
        self.revision += 1;
    }

    /// Starts a stroke with resolved samples.
    pub(crate) fn begin_stroke(&mut self, id: VolumeId, resolved: Resolved) -> Result<Answer, DocumentError> {
        let state = self.state.as_mut().ok_or(DocumentError::NothingOpen)?;
        let subject = state.at(Some(id))?;
        let mut brush = *state.scene.brush;
        brush.visible_only &= !resolved.on_slice;
        let path = StrokePath::new(&brush, subject.grid())?;
        // What a straight stroke piles up, since a wider map costs the whole volume; one application without building up.
        let build_up = brush.piles_up().then(|| BuildUpBound::new(&brush, subject.grid()));
        let room = build_up.as_ref().map_or(1.0, |build_up| build_up.of_a_line(path.step_mm()).max(1.0));
        let build_up = build_up.map(|build_up| (build_up, room));
        let volume = subject.volume;
        let before = match (volume.painted, brush.target.field()) {
            (Some(reach), _) => Reach(reach),
            (None, FieldKind::Density) => Reach::new([volume.histogram.min, volume.histogram.max], &volume.density)?,
            _ => Reach([0.0; 2]),
        };
        let reach = [before, before.after(&brush, &volume.density, room)];
        let map = map_for(&brush, volume, room, reach[1]);
        let mut edit = Edit::new(Some(state));
        edit.name(format!("{} {}", if brush.erase { "Erase" } else { "Paint" }, brush.target.field().name()));
        if let (Target::Label(label), false, Some(segments)) = (brush.target, brush.erase, state.scene.segments_mut(id))
        {
            segments.ensure(label);
        }
        let mut begun = Ok(());
        if let Some(map) = map {
            begun = edit.remap(state, id, map).map_err(DocumentError::from);
            self.graphics.remap(state, id);
        }
        let begun = begun.and_then(|()| self.graphics.begin(state, id, &brush, reach[1]));
        self.running = Some(Running {
            volume: id,
            brush,
            camera: brush.visible_only.then_some(state.scene.views.camera),
            path,
            build_up,
            reach,
            edit,
            trail: None,
            seen: VoxelSet::default(),
            samples: Vec::new(),
            dabs: 0,
            missed: 0,
        });
        let first = begun.and_then(|()| self.extend_stroke(resolved));
        if first.is_err() {
            self.drop_stroke();
        }
        first
    }

    /// Widens the density's map before dabs add up beyond it, and paints anew what the stroke had painted.
    ///
    /// # Errors
    /// If the device fails or the source does; the stroke is then taken back.
    fn make_room(&mut self, dabs: &[Dab]) -> Result<(), DocumentError> {
        let (Some(running), Some(state)) = (&mut self.running, &mut self.state) else { return Ok(()) };
        let Some((build_up, room)) = &mut running.build_up else { return Ok(()) };
        let most = build_up.add(dabs);
        if most <= *room {
            return Ok(());
        }
        // Twice as much as before at least: to paint anew costs the whole volume.
        *room = most.max(*room * 2.0);
        let [before, reach] = &mut running.reach;
        let id = running.volume;
        let Some(volume) = state.volumes.get(&id) else { return Ok(()) };
        *reach = before.after(&running.brush, &volume.density, *room);
        let Some(map) = map_for(&running.brush, volume, *room, *reach) else { return Ok(()) };
        let before = self.graphics.dabs();
        self.graphics.cancel(state, FieldKey::new(id, FieldKind::Density));
        let mut widened = running.edit.remap(state, id, map).map_err(DocumentError::from);
        self.graphics.remap(state, id);
        widened = widened.and_then(|()| self.graphics.begin(state, id, &running.brush, running.reach[1]));
        self.graphics.open(&running.seen);
        let painted = widened
            .and_then(|()| if before.is_empty() { Ok(()) } else { self.graphics.extend(state, &before).map(drop) });
        if painted.is_err() {
            self.drop_stroke();
        }
        painted
    }

    /// Before dabs are painted by a stroke that keeps to the visible surface: finds what that is under them.
    fn keep_to_surface(&mut self, dabs: &[Dab]) -> Result<(), DocumentError> {
        let Some(running) = self.running.as_mut().filter(|r| r.brush.visible_only && !dabs.is_empty()) else {
            return Ok(());
        };
        let (volume, mut seen) = (running.volume, std::mem::take(&mut running.seen));
        let found = self.see(volume, dabs, &mut seen);
        self.graphics.open(&seen);
        if let Some(running) = &mut self.running {
            running.seen = seen;
        }
        found
    }

    fn extend_stroke(&mut self, resolved: Resolved) -> Result<Answer, DocumentError> {
        let Resolved { samples, missed, trail, .. } = resolved;
        let Some(running) = &self.running else { return Ok(Answer::default()) };
        let mut path = running.path.clone();
        let dabs = path.extend(&samples)?;
        self.make_room(&dabs)?;
        self.keep_to_surface(&dabs)?;
        let (Some(running), Some(state)) = (&mut self.running, &self.state) else { return Ok(Answer::default()) };
        let bricks = if dabs.is_empty() { Vec::new() } else { self.graphics.extend(state, &dabs)? };
        running.path = path;
        running.samples.extend_from_slice(&samples);
        running.trail = trail;
        running.dabs += dabs.len() as u64;
        running.missed += missed;
        let volume = running.volume;
        let length_mm = running.path.length_mm();
        let said = ExtendedSaid { dabs: dabs.len(), missed, bricks_touched: bricks.len(), length_mm };
        let mut answer = Answer::from(Said::from(said));
        let noted = if samples.is_empty() { None } else { self.keeper.as_mut().map(|k| k.samples(volume, &samples)) };
        if let Some(Err(error)) = noted {
            answer.trouble.push(error.to_string());
        }
        self.revision += 1;
        Ok(answer)
    }

    /// Lets explosion points follow a running stroke. Answers whether more of it is to come.
    pub(crate) fn follow_stroke(&mut self) -> Result<bool, DocumentError> {
        let (Some(running), Some(state)) = (&self.running, &self.state) else { return Ok(false) };
        let key = running.field();
        if matches!(key.kind, FieldKind::Density | FieldKind::Selection) {
            let live = self.graphics.live(state)?;
            self.motion.follow(state, key, &live)?;
        }
        Ok(self.graphics.is_due())
    }

    /// Whether a running stroke has cells that explosion points have not followed yet.
    pub(crate) fn has_stroke_to_follow(&self) -> bool {
        let followed = |r: &Running| matches!(r.field().kind, FieldKind::Density | FieldKind::Selection);
        self.running.as_ref().is_some_and(followed) && self.graphics.is_due()
    }

    /// Says that no stroke runs any more.
    pub(crate) fn no_stroke(&mut self) {
        if let Some(Err(error)) = self.keeper.as_mut().map(crate::document::journal::autosave::Keeper::no_stroke) {
            tracing::warn!("{error}");
        }
    }
}

/// The map that density needs for a brush, if it is another than it has.
fn map_for(brush: &Brush, volume: &Volume, coverage: f64, reach: Reach) -> Option<DensityMap> {
    let wider = brush.map_for(&volume.density, &volume.statistics, coverage);
    brush.floats_for(wider.as_ref().unwrap_or(volume.density.map()), &volume.density, reach).or(wider)
}
