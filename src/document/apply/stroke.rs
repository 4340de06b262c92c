//! Painting: from the points of a command to a step of history, on one volume or several at once.
//!
//! While a stroke runs, a command that is not one of its own may end it first, as `stroke.end` would; which do, their effects say.
//! The GPU holds its texels until [`Document::finish_stroke`], which is the one place that waits for them.

use crate::document::Document;
use crate::document::apply::painting::{OnVolume, Running};
use crate::document::apply::trail::{Resolved, Trail};
use crate::document::command::answers::{Answer, CancelledSaid, ExtendedSaid, Said};
use crate::document::command::brush::{StrokeCommand, StrokePoint};
use crate::document::command::resolved::ResolvedCommand;
use crate::document::error::DocumentError;
use crate::document::history::edit::Edit;
use crate::document::state::State;
use crate::gpu::GpuError;
use crate::paint::{Brush, Contour, Limit, Mirror, Operation, Target, VoxelSet, step_mm};
use crate::volume::{Grid, Segment, VolumeId};
use std::sync::Arc;

impl Document {
    pub(crate) fn stroke(&mut self, command: &StrokeCommand) -> Result<Answer, DocumentError> {
        self.open()?.at(None)?;
        let running = self.running.is_some();
        match command {
            StrokeCommand::Begin { .. } | StrokeCommand::Paint { .. } | StrokeCommand::Lasso(_) if running => {
                Err(DocumentError::NotNow("a stroke is running; end it (stroke.end) or cancel it first".into()))
            }
            StrokeCommand::Begin { points, volume, volumes } => self.begin_with(*volume, volumes.as_deref(), points),
            StrokeCommand::Paint { points, volume, volumes } => {
                self.begin_with(*volume, volumes.as_deref(), points)?;
                self.finish_stroke()
            }
            StrokeCommand::Lasso(lasso) => self.lasso(lasso),
            StrokeCommand::Extend { points } => {
                let Some(running) = &self.running else { return Err(none_runs()) };
                let (volumes, trail) = (running.volumes(), running.trail.clone());
                let resolved = self.follow(&volumes, points, trail)?;
                self.extend_stroke(resolved)
            }
            StrokeCommand::End {} | StrokeCommand::Cancel {} if !running => Err(none_runs()),
            StrokeCommand::End {} => self.finish_stroke(),
            StrokeCommand::Cancel {} => {
                self.drop_stroke();
                Ok(Said::from(CancelledSaid { cancelled: true, step: None }).into())
            }
        }
    }

    /// Begins a stroke with these points, on the volume or the volumes that are named.
    fn begin_with(
        &mut self,
        volume: Option<VolumeId>,
        volumes: Option<&[VolumeId]>,
        points: &[StrokePoint],
    ) -> Result<Answer, DocumentError> {
        let state = self.open()?;
        let volumes = state.with_sub_volumes(state.scene.painted_by(volume, volumes)?);
        let resolved = self.follow(&volumes, points, None)?;
        self.begin_stroke(&volumes, resolved)
    }

    /// Whether a stroke runs.
    pub fn is_painting(&self) -> bool {
        self.running.is_some()
    }

    /// Ends the running stroke: waits for the GPU, takes its bricks into the fields and makes one step of them. The answer is that
    /// of `stroke.end`. Without a stroke it does nothing.
    ///
    /// # Errors
    /// If the device fails or the source does; the stroke then still runs.
    pub fn finish_stroke(&mut self) -> Result<Answer, DocumentError> {
        let cut_short = self.end_path()?;
        let painted = self.finish_on_device()?;
        let (Some(state), Some(mut running)) = (&mut self.state, self.running.take()) else {
            return Ok(Answer::default());
        };
        let taken = running.take_in(state, painted);
        let (voxels, bricks) = running.edit.counts();
        if taken.is_err() || voxels == 0 {
            // Nothing painted: the segment or the wider map that was made for it goes too.
            let refreshed = std::mem::replace(&mut running.edit, Edit::new(None)).roll_back(state)?;
            self.mirror(&refreshed);
            self.no_stroke();
            taken?;
            return Ok(Said::from(running.said(self.open()?, None)).into());
        }
        let done = running.as_command(state)?;
        running.edit.made_by(ResolvedCommand {
            brush: Some(running.painted),
            camera: running.camera,
            ..ResolvedCommand::plain(done.clone())
        });
        let mut said = running.said(state, Some(bricks));
        let unchanged = running.unchanged();
        let (step, mut refreshed) = running.edit.finish(state);
        // The GPU took wider maps over at the stroke's beginning, but for those that were put back.
        refreshed.painted = true;
        refreshed.remapped.retain(|id| unchanged.contains(id));
        said.step = step.as_ref().map(|s| s.name.clone());
        self.mirror(&refreshed);
        let mut trouble: Vec<String> = cut_short.into_iter().collect();
        if let Some(step) = step {
            self.unsaved = true;
            trouble.extend(self.history.push(step)?);
        }
        trouble.extend(self.note(&done, &refreshed, true));
        self.revision += 1;
        Ok(Answer { trouble, ..Answer::from(Said::from(said)) })
    }

    /// Paints what is left of the running stroke: what the pointer passed since its last whole pixel, and the dab at its last sample.
    /// Where there is no room for it the stroke ends without, and the answer says so.
    fn end_path(&mut self) -> Result<Option<String>, DocumentError> {
        let Some(running) = &self.running else { return Ok(None) };
        let samples = running.trail.as_ref().map_or_else(Vec::new, Trail::end);
        let (paths, mut dabs) = running.lay(&samples, true)?;
        if dabs.iter().all(|(_, dabs)| dabs.is_empty()) {
            return Ok(None);
        }
        self.lay_along(&mut dabs)?;
        self.make_room(&dabs)?;
        self.keep_to_limits(&dabs)?;
        match self.extend_on_device(&dabs) {
            Ok(_) => {}
            Err(DocumentError::Gpu(error @ (GpuError::StrokeTooLarge { .. } | GpuError::PoolFull { .. }))) => {
                return Ok(Some(format!("the stroke ends before its last point: {error}")));
            }
            Err(error) => return Err(error),
        }
        if let Some(running) = &mut self.running {
            running.went(paths, &dabs, &samples);
            running.trail = None;
        }
        Ok(None)
    }

    /// Takes the running stroke back.
    pub(crate) fn drop_stroke(&mut self) {
        let (Some(running), Some(state)) = (self.running.take(), &mut self.state) else { return };
        self.graphics.cancel(state);
        // Of a stroke there are at most segments and maps to take back; a source that fails leaves the wider map.
        match running.edit.roll_back(state) {
            Ok(refreshed) => self.mirror(&refreshed),
            Err(error) => tracing::warn!("{error}"),
        }
        self.motion.forget_points();
        self.no_stroke();
        self.revision += 1;
    }

    /// Starts a stroke on these volumes with resolved samples.
    pub(crate) fn begin_stroke(&mut self, volumes: &[VolumeId], resolved: Resolved) -> Result<Answer, DocumentError> {
        self.begin_within(volumes, resolved, None)
    }

    /// The same, kept within a contour if there is one, which its one dab covers.
    pub(super) fn begin_within(
        &mut self,
        volumes: &[VolumeId],
        resolved: Resolved,
        contour: Option<Contour>,
    ) -> Result<Answer, DocumentError> {
        let state = self.state.as_mut().ok_or(DocumentError::NothingOpen)?;
        let mut brush = *state.scene.brush;
        if resolved.on_slice {
            brush = brush.off_surface();
        }
        let first = state.at(volumes.first().copied())?;
        brush.mirror = brush.mirror.plane(first.grid()).map_or(Mirror::Off, Mirror::Plane);
        if brush.effective().looks_around() {
            brush = brush.with_lengths(first.grid());
        }
        let painted = brush;
        if let Some(contour) = &contour {
            let grids: Vec<_> = volumes.iter().filter_map(|id| Some(*state.subject(*id)?.grid())).collect();
            brush = contour.brush(&brush, &grids);
        }
        let on = {
            let subjects = volumes.iter().map(|id| state.at(Some(*id))).collect::<Result<Vec<_>, _>>()?;
            let step_mm = step_mm(&brush, subjects.iter().map(|subject| subject.grid()));
            let mut on = subjects.iter().map(|s| OnVolume::new(s, &brush, step_mm)).collect::<Result<Vec<_>, _>>()?;
            for (on, subject) in on.iter_mut().zip(&subjects) {
                on.goes_along = subject.settings.sub_volume.is_some_and(|sub| volumes.contains(&sub.parent));
                on.boxes = state.finer_boxes(subject.id, volumes);
                if !on.boxes.is_empty() {
                    on.confines.push((Limit::SubVolumes, Arc::new(VoxelSet::all_but(on.boxes.clone()))));
                }
                on.confines
                    .extend(contour.as_ref().map(|c| (Limit::Contour, Arc::new(within(c, &brush, subject.grid())))));
            }
            on
        };
        let mut edit = Edit::new(Some(state));
        let named = on.iter().filter(|on| !on.goes_along).count();
        edit.name(match (verb(&brush), brush.target.field().name(), named) {
            (what, field, 1) => format!("{what} {field}"),
            (what, field, count) => format!("{what} {field} in {count} volumes"),
        });
        if let (Target::Label(label), false) = (brush.target, brush.erase) {
            ensure_segments(state, volumes, label);
        }
        self.running = Some(Running {
            brush,
            painted,
            contour,
            camera: brush.keeps_to_surface().then_some(state.scene.views.camera),
            edit,
            trail: None,
            samples: Vec::new(),
            missed: 0,
            on,
        });
        let first = self.begin_on_device().and_then(|()| self.extend_stroke(resolved));
        if first.is_err() {
            self.drop_stroke();
        }
        first
    }

    fn extend_stroke(&mut self, resolved: Resolved) -> Result<Answer, DocumentError> {
        let Resolved { samples, missed, trail, .. } = resolved;
        let Some(running) = &self.running else { return Ok(Answer::default()) };
        let (paths, mut dabs) = running.lay(&samples, false)?;
        self.lay_along(&mut dabs)?;
        let count = dabs.iter().map(|(_, dabs)| dabs.len()).sum();
        self.make_room(&dabs)?;
        self.keep_to_limits(&dabs)?;
        let bricks = if count == 0 { Vec::new() } else { self.extend_on_device(&dabs)? };
        let Some(running) = &mut self.running else { return Ok(Answer::default()) };
        running.went(paths, &dabs, &samples);
        running.trail = trail.clone();
        running.missed += missed;
        let volumes = running.volumes();
        let length_mm = running.on.first().map_or(0.0, |on| on.path.length_mm());
        let said = ExtendedSaid { dabs: count, missed, bricks_touched: bricks.len(), length_mm };
        let mut answer = Answer::from(Said::from(said));
        // A contour is noted as a whole, once it is filled.
        let whole = running.contour.is_some();
        let noted = if samples.is_empty() || whole {
            None
        } else {
            self.autosave.as_mut().map(|k| k.samples(&volumes, &samples))
        };
        if let Some(Err(error)) = noted {
            answer.trouble.push(error.to_string());
        }
        self.aim_at(trail.as_ref(), &samples);
        self.revision += 1;
        Ok(answer)
    }

    /// Lets explosion points follow a running stroke. Answers whether more of it is to come.
    pub(crate) fn follow_stroke(&mut self) -> Result<bool, DocumentError> {
        let (Some(running), Some(state)) = (&self.running, &self.state) else { return Ok(false) };
        if running.is_followed() {
            let live = self.graphics.live(state)?;
            self.motion.follow(state, &live)?;
        }
        Ok(self.graphics.is_due())
    }

    /// Whether a running stroke has cells that explosion points have not followed yet.
    pub(crate) fn has_stroke_to_follow(&self) -> bool {
        self.running.as_ref().is_some_and(Running::is_followed) && self.graphics.is_due()
    }

    /// Says that no stroke runs any more.
    pub(crate) fn no_stroke(&mut self) {
        if let Some(Err(error)) = self.autosave.as_mut().map(crate::document::journal::autosave::Autosave::no_stroke) {
            tracing::warn!("{error}");
        }
    }
}

/// The voxels that a contour fills, and its image if the brush is mirrored.
fn within(contour: &Contour, brush: &Brush, grid: &Grid) -> VoxelSet {
    let mut set = contour.voxels(grid);
    if let Mirror::Plane(plane) = &brush.mirror {
        set.extend(&contour.image(plane).voxels(grid));
    }
    set
}

/// What a stroke does, for the name of its step.
fn verb(brush: &Brush) -> &'static str {
    match brush.effective() {
        _ if brush.erase => "Erase",
        Operation::Smooth | Operation::Median => "Smooth",
        Operation::Sharpen => "Sharpen",
        Operation::Raise => "Raise",
        Operation::Lower => "Lower",
        Operation::Push => "Push",
        Operation::Pull => "Pull",
        Operation::Fill => "Fill in",
        Operation::Replace | Operation::Add | Operation::Subtract | Operation::Blend | Operation::Restore => "Paint",
    }
}

fn none_runs() -> DocumentError {
    DocumentError::NotNow("no stroke is running; stroke.begin starts one".into())
}

/// Gives each of the volumes the segment of a label, where it has none: as it is called and coloured in the first of them that has it.
fn ensure_segments(state: &mut State, volumes: &[VolumeId], label: u16) {
    let known = volumes.iter().find_map(|id| state.scene.volumes.all.get(id)?.segments.get(label));
    let known =
        known.map(|segment| Segment { name: segment.name.clone(), colour: segment.colour, ..Segment::new(label) });
    for id in volumes {
        let Some(segments) = state.scene.segments_mut(*id) else { continue };
        match &known {
            Some(segment) if segments.get(label).is_none() => segments.put(segment.clone()),
            _ => segments.ensure(label),
        }
    }
}
