//! A stroke while it runs, as the host knows it: by which brush and way it paints each of its volumes, and the room that density has.
//!
//! Every volume gets the same dabs in mm at the same distance from each other; where they lie in it, what values, segments and locks say
//! there, and how its density is held, is each volume's own. Owns [`Running`]. The GPU holds texels and dabs.

use crate::document::apply::stroke_nothing::why_nothing;
use crate::document::apply::trail::Trail;
use crate::document::command::answers::{PaintedOnSaid, PaintedSaid};
use crate::document::command::brush::{Lasso, StrokeCommand, StrokePoint};
use crate::document::command::{Command, Place};
use crate::document::error::DocumentError;
use crate::document::history::edit::Edit;
use crate::document::place::normal_of;
use crate::document::scene::ViewName;
use crate::document::state::State;
use crate::document::subject::Subject;
use crate::gpu::PaintedBricks;
use crate::math::Camera;
use crate::paint::{
    Brush, BuildUpBound, Confines, Contour, Dab, IndexBox, Mirror, PaintError, Reach, Sample, StrokePath, VoxelSet,
    with_images,
};
use crate::volume::{DensityMap, FieldKind, Grid, SourceError, Volume, VolumeId};
use std::collections::BTreeSet;

/// A stroke that has begun.
#[derive(Debug)]
pub(crate) struct Running {
    pub(super) brush: Brush,
    /// The same as it was said: a contour is covered by a brush of its own.
    pub(super) painted: Brush,
    /// The contour that it fills, if it does.
    pub(super) contour: Option<Contour>,
    /// Where what is visible was seen from, if it keeps to that.
    pub(super) camera: Option<Camera>,
    /// What came before the first dab: a segment that was missing, a map that was too narrow.
    pub(super) edit: Edit,
    /// Where it has got to in the 3D view.
    pub(super) trail: Option<Trail>,
    pub(super) samples: Vec<Sample>,
    pub(super) missed: u64,
    /// What it paints, in the order in which it was named.
    pub(super) on: Vec<OnVolume>,
}

/// A stroke on one of its volumes.
#[derive(Debug)]
pub(super) struct OnVolume {
    pub(super) id: VolumeId,
    pub(super) path: StrokePath,
    /// Of a brush that adds up on density: what may have, and for how much of it the map has room.
    build_up: Option<(BuildUpBound, f64)>,
    /// That of density before the stroke, and with all that the brush makes.
    pub(super) reach: [Reach; 2],
    /// The map that density needs before the first dab that reaches it, if it is another than it has: to paint anew costs the whole
    /// volume.
    pub(super) needs: Option<DensityMap>,
    /// Boxes in which finer volumes are painted in its place: from a voxel on and before another.
    pub(super) boxes: Vec<[[u32; 3]; 2]>,
    /// What of the visible surface it has come to, if it keeps to that.
    pub(super) seen: VoxelSet,
    /// Sets of voxels that it keeps within, once they were found.
    pub(super) confines: Confines,
    /// Whether it is painted because what it is cut out of is.
    pub(super) goes_along: bool,
    dabs: u64,
    /// Voxels and bricks that hold another value than before, once the stroke has ended.
    changed: (u64, usize),
}

/// Dabs for each volume of a stroke.
pub(super) type Laid = Vec<(VolumeId, Vec<Dab>)>;

impl Running {
    /// Whether explosion points follow what it paints.
    pub(super) fn is_followed(&self) -> bool {
        matches!(self.brush.target.field(), FieldKind::Density | FieldKind::Selection)
    }

    /// Its volumes in the order in which they were named.
    pub(crate) fn volumes(&self) -> Vec<VolumeId> {
        self.on.iter().map(|on| on.id).collect()
    }

    /// What each way is after further samples, and the dabs that they give; after its end, if it `ends`. The stroke stays as it is.
    pub(super) fn lay(&self, samples: &[Sample], ends: bool) -> Result<(Vec<StrokePath>, Laid), PaintError> {
        let mut paths = Vec::new();
        let mut laid = Laid::new();
        for on in &self.on {
            let mut path = on.path.clone();
            let mut dabs = path.extend(samples)?;
            if ends {
                dabs.extend(path.end());
            }
            if let Mirror::Plane(plane) = &self.brush.mirror {
                dabs = with_images(plane, &dabs);
            }
            paths.push(path);
            laid.push((on.id, dabs));
        }
        Ok((paths, laid))
    }

    /// Takes in what was painted.
    pub(super) fn went(&mut self, paths: Vec<StrokePath>, laid: &Laid, samples: &[Sample]) {
        for ((on, path), (_, dabs)) in self.on.iter_mut().zip(paths).zip(laid) {
            on.path = path;
            on.dabs += dabs.len() as u64;
        }
        self.samples.extend_from_slice(samples);
    }

    /// The maps that density needs where the first dabs come to it, or dabs add up beyond the one that it has.
    pub(super) fn wider(&mut self, state: &State, dabs: &Laid) -> Vec<(VolumeId, DensityMap)> {
        let Self { brush, on, .. } = self;
        let volumes = on.iter_mut().zip(dabs).filter_map(|(on, (id, dabs))| Some((on, state.subject(*id)?, dabs)));
        let wider = |(on, subject, dabs): (&mut OnVolume, Subject<'_>, &Vec<Dab>)| {
            if on.needs.is_none() && on.build_up.is_none() {
                return None;
            }
            let dabs: Vec<Dab> = dabs.iter().filter(|dab| on.is_reached(dab, brush, subject.grid())).copied().collect();
            if dabs.is_empty() {
                return None;
            }
            let first = on.needs.take();
            Some((on.id, on.room_for(brush, subject.volume, &dabs).or(first)?))
        };
        volumes.filter_map(wider).collect()
    }
}

impl Running {
    /// Takes the bricks that it painted into the fields. A volume that it left as it was keeps no segment and no wider map of it.
    ///
    /// # Errors
    /// If a source fails; what was taken in by then is in the edit.
    pub(super) fn take_in(&mut self, state: &mut State, mut painted: PaintedBricks) -> Result<(), SourceError> {
        // Sub-volumes first: then their bands follow what was painted on what they are cut out of.
        painted.sort_by_key(|(key, _)| std::cmp::Reverse((state.scene.depth_of(key.volume), key.volume)));
        for (key, bricks) in painted {
            let before = self.edit.counts();
            self.edit.swap(state, key, bricks.into_iter().map(|(index, brick)| (index, Some(brick))).collect())?;
            let after = self.edit.counts();
            let counts = (after.0 - before.0, after.1 - before.1);
            let Some(on) = self.on.iter_mut().find(|on| on.id == key.volume) else { continue };
            on.changed = counts;
        }
        if self.edit.counts().0 == 0 {
            return Ok(());
        }
        for on in &self.on {
            if on.changed.0 == 0 {
                self.edit.spare(state, on.id)?;
            } else if let (FieldKind::Density, Some(volume)) =
                (self.brush.target.field(), state.volumes.get_mut(&on.id))
            {
                let [before, after] = on.reach;
                volume.painted = Some(after.within(before, &volume.density).0);
            }
        }
        Ok(())
    }

    /// The volumes that it left as they were.
    pub(super) fn unchanged(&self) -> BTreeSet<VolumeId> {
        self.on.iter().filter(|on| on.changed.0 == 0).map(|on| on.id).collect()
    }

    /// What is said of it at its end: of all volumes together, and of each where they are several.
    pub(super) fn said(&self, state: &State, bricks_touched: Option<usize>) -> PaintedSaid {
        let told = self.on.iter().filter(|on| !on.goes_along || on.changed.0 > 0);
        let told: Vec<_> = told.map(|on| self.said_of(on, state)).collect();
        let nothing = bricks_touched.is_none().then(|| said_together(state, &told));
        PaintedSaid {
            step: None,
            dabs: self.on.iter().map(|on| on.dabs).sum(),
            missed: self.missed,
            voxels_changed: self.on.iter().map(|on| on.changed.0).sum(),
            bricks_touched,
            nothing,
            volumes: if told.len() > 1 { told } else { Vec::new() },
        }
    }

    fn said_of(&self, on: &OnVolume, state: &State) -> PaintedOnSaid {
        let (voxels_changed, bricks_touched) = on.changed;
        let why = || {
            let subject = state.subject(on.id)?;
            let on = (&on.seen, &on.confines, on.path.step_mm());
            let why = why_nothing(&subject, &self.brush, (&self.samples, self.missed), on);
            Some(why.unwrap_or_else(|error| error.to_string()))
        };
        let nothing = if voxels_changed == 0 { why() } else { None };
        PaintedOnSaid { volume: on.id, dabs: on.dabs, voxels_changed, bricks_touched, nothing }
    }

    /// The whole stroke as a command that can be done again elsewhere: its points in mm, its volumes by name where it is not plain
    /// which they are.
    ///
    /// # Errors
    /// If a volume of it is gone.
    pub(super) fn as_command(&self, state: &State) -> Result<Command, DocumentError> {
        let volumes = self.volumes();
        let first = state.at(volumes.first().copied())?;
        let axial = normal_of(&first, ViewName::Axial);
        let at = |s: &Sample| {
            let Sample { position, normal, pressure, breaks } = *s;
            let normal = (normal != axial).then(|| normal.to_array());
            StrokePoint { at: Place::Mm(position.to_array()), pressure, breaks, normal }
        };
        let plain = first.id == state.scene.volumes.active && state.scene.also.is_empty();
        let several = volumes.len() > 1;
        let (volume, volumes) = ((!plain && !several).then_some(first.id), several.then_some(volumes));
        if let Some(Contour { points, normal, depth_mm }) = &self.contour {
            return Ok(Command::Stroke(StrokeCommand::Lasso(Lasso {
                depth_mm: Some(*depth_mm),
                normal: Some(normal.to_array()),
                pressure: self.samples.first().map_or(1.0, |s| s.pressure),
                volume,
                volumes,
                ..Lasso::of(points.iter().map(|p| Place::Mm(p.to_array())).collect())
            })));
        }
        Ok(Command::Stroke(StrokeCommand::Paint { points: self.samples.iter().map(at).collect(), volume, volumes }))
    }
}

/// Why nothing changed anywhere: one sentence where it is the same for all volumes, else one for each.
fn said_together(state: &State, told: &[PaintedOnSaid]) -> String {
    let sentences: Vec<_> = told.iter().filter_map(|told| Some((told.volume, told.nothing.clone()?))).collect();
    match sentences.split_first() {
        Some(((_, one), others)) if others.iter().all(|(_, other)| other == one) => one.clone(),
        _ => {
            let named = |(id, why): &(VolumeId, String)| {
                let name = state.scene.volumes.all.get(id).map_or("", |settings| settings.name.as_str());
                format!("{name} ({id}): {why}")
            };
            sentences.iter().map(named).collect::<Vec<_>>().join(" ")
        }
    }
}

impl OnVolume {
    /// Before the first dab; those of the stroke lie `step_mm` apart.
    ///
    /// # Errors
    /// If the brush is not one for the volume, or its source fails.
    pub(super) fn new(subject: &Subject<'_>, brush: &Brush, step_mm: f64) -> Result<Self, DocumentError> {
        brush.check_around(subject.grid())?;
        let path = StrokePath::apart_by(step_mm, brush, subject.grid())?;
        // What a straight stroke piles up, since a wider map costs the whole volume; one application without building up.
        let build_up = brush.piles_up().then(|| BuildUpBound::new(brush, subject.grid()));
        let room = build_up.as_ref().map_or(1.0, |build_up| build_up.of_a_line(step_mm).max(1.0));
        let build_up = build_up.map(|build_up| (build_up, room));
        let volume = subject.volume;
        let before = match (volume.painted, brush.target.field()) {
            (Some(reach), _) => Reach(reach),
            (None, FieldKind::Density) => Reach::new([volume.histogram.min, volume.histogram.max], &volume.density)?,
            _ => Reach([0.0; 2]),
        };
        let reach = [before, before.after(brush, &volume.density, room)];
        let needs = map_for(brush, volume, room, reach[1]);
        Ok(Self {
            id: subject.id,
            path,
            build_up,
            reach,
            needs,
            boxes: Vec::new(),
            seen: VoxelSet::default(),
            confines: Confines::new(),
            goes_along: false,
            dabs: 0,
            changed: (0, 0),
        })
    }

    /// Whether a dab may paint voxels of its own.
    fn is_reached(&self, dab: &Dab, brush: &Brush, grid: &Grid) -> bool {
        dab.footprint(brush, grid).is_some_and(|footprint| {
            let IndexBox { lo, end } = footprint.bounds;
            let is_within = |[from, to]: &[[u32; 3]; 2]| (0..3).all(|a| from[a] <= lo[a] && end[a] <= to[a]);
            !self.boxes.iter().any(is_within)
        })
    }

    /// The map that density needs once these dabs add up too, if it is another than it has.
    fn room_for(&mut self, brush: &Brush, volume: &Volume, dabs: &[Dab]) -> Option<DensityMap> {
        let (build_up, room) = self.build_up.as_mut()?;
        let most = build_up.add(dabs);
        if most <= *room {
            return None;
        }
        // Twice as much as before at least: to paint anew costs the whole volume.
        *room = most.max(*room * 2.0);
        let [before, reach] = &mut self.reach;
        *reach = before.after(brush, &volume.density, *room);
        map_for(brush, volume, *room, *reach)
    }
}

/// The map that density needs for a brush, if it is another than it has.
fn map_for(brush: &Brush, volume: &Volume, coverage: f64, reach: Reach) -> Option<DensityMap> {
    let wider = brush.map_for(&volume.density, &volume.statistics, coverage);
    brush.floats_for(wider.as_ref().unwrap_or(volume.density.map()), &volume.density, reach).or(wider)
}
