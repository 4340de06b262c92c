//! The document's GPU: asked for when first needed, made again after a loss, always from the host's fields.
//!
//! Owns device, pools, casters and painter. What is here can be thrown away at any time but a running stroke's dabs, which the
//! painter keeps and paints again.

use crate::document::error::DocumentError;
use crate::document::history::step::Refreshed;
use crate::document::live::area::Area;
use crate::document::state::State;
use crate::gpu::cast::tiles::Window;
use crate::gpu::{
    Caster, FieldPools, Fields, Frame, Gpu, GpuError, GridRequest, Hit, Image, PaintedBricks, Painter, SliceCaster,
    SliceFrame, TracedGrid, Tracer, Visibility, VolumeFields,
};
use crate::math::DVec2;
use crate::paint::{Brush, Confines, Dab, Reach, VoxelSet};
use crate::volume::{BrickIndex, FieldKey, LiveCells, VolumeId};
use std::collections::BTreeSet;

/// Memory for pools of bricks on the GPU, all fields together.
const BUDGET_BYTES: u64 = 512 << 20;
/// Bricks of a field that a picture in motion may wait for: some 5 MB of density.
const MOVING_UPLOADS: usize = 64;

/// What works on one device.
#[derive(Debug)]
struct Tools {
    gpu: Gpu,
    pools: FieldPools,
    caster: Caster,
    slices: SliceCaster,
    /// Made when an annotation is first laid.
    tracer: Option<Tracer>,
}

/// The device and what works on it; `Default` has none yet.
#[derive(Debug, Default)]
pub(crate) struct Graphics {
    gpu: Option<Gpu>,
    tools: Option<Tools>,
    painter: Option<Painter>,
    /// The volumes that a stroke runs on: they stay on the device, seen or not.
    painted: BTreeSet<VolumeId>,
    moving: bool,
}

/// The fields of what pictures show and of what is painted. What is in neither the device may forget.
fn fields<'a>(state: &'a State, painted: &BTreeSet<VolumeId>) -> Fields<'a> {
    let mut fields = Fields::default();
    let painted = painted.iter().filter_map(|id| state.subject(*id));
    for subject in state.visible().chain(painted) {
        let volume = subject.volume;
        fields.put(
            subject.id,
            VolumeFields {
                grid: *subject.grid(),
                density: &volume.density,
                colour: &volume.colour,
                selection: &volume.selection,
                labels: &volume.labels,
            },
        );
    }
    fields
}

impl Graphics {
    /// Works on this device instead of one of its own.
    pub(crate) fn use_gpu(&mut self, gpu: Gpu) {
        *self = Self { gpu: Some(gpu), ..Self::default() };
    }

    /// Whether pictures are in motion: they then wait for a bounded number of bricks, and coarser ones stand in.
    pub(crate) fn set_motion(&mut self, moving: bool) {
        self.moving = moving;
    }

    /// Whether coarser bricks stand in.
    pub(crate) fn is_pending(&self) -> bool {
        self.tools.as_ref().is_some_and(|t| t.pools.is_pending())
    }

    /// The device's name, or why there is none.
    pub(crate) fn describe(&mut self) -> Result<String, GpuError> {
        Ok(self.gpu()?.describe())
    }

    /// Another volume is open.
    pub(crate) fn forget(&mut self) {
        self.tools = None;
        self.painter = None;
        self.painted.clear();
    }

    /// Hands changed voxels on. What fails here is made again when it is next needed.
    pub(crate) fn mirror(&mut self, state: &State, refreshed: &Refreshed) {
        let Some(tools) = &mut self.tools else { return };
        for id in &refreshed.exchanged {
            tools.pools.leave(*id);
        }
        for id in &refreshed.remapped {
            self.remap(state, *id);
        }
        let Some(Tools { gpu, pools, .. }) = &mut self.tools else { return };
        let refreshed = refreshed.slots.iter().try_for_each(|(key, slots)| match state.field(*key) {
            Some(field) if refreshed.painted => pools.refresh_painted(gpu, *key, field, slots),
            Some(field) => pools.refresh(gpu, *key, field, slots),
            None => Ok(()),
        });
        if let Err(error) = refreshed {
            tracing::warn!("{error}");
            self.tools = None;
        }
    }

    /// Density has another map.
    pub(crate) fn remap(&mut self, state: &State, volume: VolumeId) {
        if let (Some(tools), Some(subject)) = (&mut self.tools, state.subject(volume)) {
            tools.pools.remap(volume, &subject.volume.density);
        }
    }

    pub(crate) fn image(&mut self, state: &State, frame: &Frame) -> Result<Image, DocumentError> {
        let bound = self.bound();
        self.with(state, "a picture", |t, painter, fields| {
            painter.follow(&mut t.pools, fields)?;
            t.pools.bound_uploads(bound);
            t.caster.image(&t.gpu, &mut t.pools, fields, frame)
        })
    }

    pub(crate) fn rows(
        &mut self,
        state: &State,
        frame: &Frame,
        rows: std::ops::Range<u32>,
    ) -> Result<Image, DocumentError> {
        let bound = self.bound();
        self.with(state, "a picture", |t, painter, fields| {
            painter.follow(&mut t.pools, fields)?;
            t.pools.bound_uploads(bound);
            t.caster.rows(&t.gpu, &mut t.pools, fields, frame, rows.clone())
        })
    }

    /// A rectangle of a picture at rest, its top-left corner at `corner`: whatever moves, no brick stands in for a finer one.
    pub(crate) fn part(
        &mut self,
        state: &State,
        frame: &Frame,
        corner: [u32; 2],
        size: [u32; 2],
    ) -> Result<Image, DocumentError> {
        let origin = DVec2::new(f64::from(corner[0]), f64::from(corner[1]));
        self.with(state, "a picture", |t, painter, fields| {
            painter.follow(&mut t.pools, fields)?;
            t.pools.bound_uploads(None);
            t.caster.part(
                &t.gpu,
                &mut t.pools,
                fields,
                frame,
                &Window { picture: frame.size, origin, size, only: None },
            )
        })
    }

    /// The same with the voxels that the running stroke had met at its start.
    pub(crate) fn part_at_start(
        &mut self,
        state: &State,
        frame: &Frame,
        corner: [u32; 2],
        size: [u32; 2],
    ) -> Result<Image, DocumentError> {
        let [origin, extent] = [corner, size].map(|[x, y]| DVec2::new(f64::from(x), f64::from(y)));
        let area = Area { lo: origin, hi: origin + extent };
        let window = Window { picture: frame.size, origin, size, only: None };
        self.with(state, "a picture", |t, painter, fields| {
            let Tools { gpu, pools, caster, .. } = t;
            pools.bound_uploads(None);
            painter.at_start(
                pools,
                |volume, brick| shows(state, frame, &area, volume, brick),
                |pools| caster.part(gpu, pools, fields, frame, &window),
            )
        })
    }

    pub(crate) fn slice(&mut self, state: &State, frame: &SliceFrame) -> Result<Image, DocumentError> {
        let colour = self.with(state, "a slice", |t, _, fields| {
            t.pools.bound_uploads(None);
            t.slices.pixels(&t.gpu, &mut t.pools, fields, frame)
        })?;
        Ok(Image { colour, ..Image::empty(frame.size) })
    }

    pub(crate) fn pick(&mut self, state: &State, frame: &Frame, px: DVec2) -> Result<Option<Hit>, DocumentError> {
        let bound = self.bound();
        self.with(state, "a pixel of the 3D view", |t, _, fields| {
            t.pools.bound_uploads(bound);
            t.caster.pick(&t.gpu, &mut t.pools, fields, frame, px)
        })
    }

    /// What lies under points of the 3D view, evenly apart from one place to another, from the finest voxels; of those that the
    /// running stroke had met from what they were at its start.
    pub(crate) fn pick_along(
        &mut self,
        state: &State,
        frame: &Frame,
        ends: [DVec2; 2],
        count: u32,
    ) -> Result<Vec<Option<Hit>>, DocumentError> {
        let area = Area { lo: ends[0].min(ends[1]) - 1.0, hi: ends[0].max(ends[1]) + 1.0 };
        self.with(state, "pixels of the 3D view", |t, painter, fields| {
            let Tools { gpu, pools, caster, .. } = t;
            pools.bound_uploads(None);
            painter.at_start(
                pools,
                |volume, brick| shows(state, frame, &area, volume, brick),
                |pools| caster.pick_along(gpu, pools, fields, frame, ends, count),
            )
        })
    }

    /// A grid over an iso-surface as it is now, a running stroke included.
    pub(crate) fn trace(&mut self, state: &State, request: &GridRequest) -> Result<TracedGrid, DocumentError> {
        self.with(state, "an annotation", |t, _, fields| {
            let Tools { gpu, pools, tracer, .. } = t;
            pools.bound_uploads(None);
            let tracer = match tracer {
                Some(tracer) => tracer,
                None => tracer.insert(Tracer::new(gpu)?),
            };
            tracer.grid(gpu, pools, fields, request)
        })
    }

    pub(crate) fn visibility(&mut self, state: &State, frame: &Frame) -> Result<Visibility, DocumentError> {
        self.with(state, "visibility", |t, _, fields| {
            // Poses depend on it, and must not on what was held before.
            t.pools.bound_uploads(None);
            t.caster.visibility(&t.gpu, &mut t.pools, fields, frame)
        })
    }

    /// Begins a stroke on a volume, or lets the one that has begun paint it too; it stays on the device until the stroke ends.
    pub(crate) fn begin(
        &mut self,
        state: &State,
        volume: VolumeId,
        brush: &Brush,
        reach: Reach,
    ) -> Result<(), DocumentError> {
        let subject = state.at(Some(volume))?;
        self.painted.insert(volume);
        self.with(state, "painting", |_, painter, fields| {
            painter.begin(volume, fields, brush, subject.segments(), reach)
        })
    }

    /// Lets the running stroke, which keeps to the visible surface, paint these voxels of a volume.
    pub(crate) fn open(&mut self, volume: VolumeId, voxels: &VoxelSet) {
        if let Some(painter) = &mut self.painter {
            painter.open(volume, voxels);
        }
    }

    /// Lets the running stroke paint nothing of a volume but what is in all of these sets.
    pub(crate) fn confine(&mut self, volume: VolumeId, confines: &Confines) {
        if let Some(painter) = &mut self.painter {
            painter.confine(volume, confines);
        }
    }

    /// Paints further dabs, on each volume its own; answers the bricks that they show in.
    pub(crate) fn extend(
        &mut self,
        state: &State,
        dabs: &[(VolumeId, &[Dab])],
    ) -> Result<Vec<(FieldKey, BrickIndex)>, DocumentError> {
        self.with(state, "painting", |t, painter, fields| painter.extend(&mut t.pools, fields, dabs))
    }

    pub(crate) fn finish(&mut self, state: &State) -> Result<PaintedBricks, DocumentError> {
        let finished = self.with(state, "painting", |t, painter, fields| painter.finish(&mut t.pools, fields))?;
        self.painted.clear();
        Ok(finished)
    }

    /// The running stroke's dabs so far on a volume.
    pub(crate) fn dabs(&self, volume: VolumeId) -> Vec<Dab> {
        self.painter.as_ref().map_or_else(Vec::new, |painter| painter.dabs(volume).to_vec())
    }

    /// Takes the running stroke back; nothing of it is left even if the device fails meanwhile.
    pub(crate) fn cancel(&mut self, state: &State) {
        self.painted.clear();
        let (Some(tools), Some(painter)) = (&mut self.tools, &mut self.painter) else {
            // It waits for a device to be painted again on.
            self.painter = None;
            return;
        };
        if !painter.is_painting() {
            return;
        }
        let done = painter.cancel(&mut tools.pools);
        let done = done.map(|slots| Refreshed { slots, painted: true, ..Refreshed::default() });
        match done {
            Ok(refreshed) => self.mirror(state, &refreshed),
            Err(error) => {
                tracing::warn!("{error}");
                self.forget();
            }
        }
    }

    /// Cells of the running stroke's bricks of which something is new, if it has come already.
    pub(crate) fn live(&mut self, state: &State) -> Result<Vec<(FieldKey, BrickIndex, LiveCells)>, DocumentError> {
        self.with(state, "painting", |t, painter, fields| {
            painter.follow(&mut t.pools, fields)?;
            Ok(painter.take_live())
        })
    }

    /// Whether something of them is still to come.
    pub(crate) fn is_due(&self) -> bool {
        self.painter.as_ref().is_some_and(Painter::is_due)
    }

    fn bound(&self) -> Option<usize> {
        self.moving.then_some(MOVING_UPLOADS)
    }

    fn gpu(&mut self) -> Result<&Gpu, GpuError> {
        if self.gpu.as_ref().is_none_or(Gpu::lost) {
            self.gpu = Some(Gpu::headless()?);
        }
        self.gpu.as_ref().ok_or(GpuError::NoAdapter { reason: "none asked for".into() })
    }

    /// Does `work`; if the device is lost on the way, once more on a new one.
    fn with<T>(
        &mut self,
        state: &State,
        what: &'static str,
        mut work: impl FnMut(&mut Tools, &mut Painter, &Fields<'_>) -> Result<T, GpuError>,
    ) -> Result<T, DocumentError> {
        let fields = fields(state, &self.painted);
        let mut again = true;
        loop {
            let done = self.ready(&fields).map_err(|error| match error {
                GpuError::NoAdapter { .. } | GpuError::NoDevice { .. } => {
                    DocumentError::NoGpu { what, reason: error.to_string() }
                }
                other => other.into(),
            })?;
            match work(done.0, done.1, &fields) {
                Err(GpuError::Lost { reason }) if again => {
                    tracing::warn!("the graphics device was lost ({reason}) and is asked for again");
                    again = false;
                    self.tools = None;
                }
                other => return Ok(other?),
            }
        }
    }

    fn ready(&mut self, fields: &Fields<'_>) -> Result<(&mut Tools, &mut Painter), GpuError> {
        let gpu = self.gpu()?.clone();
        if self.tools.as_ref().is_some_and(|t| t.gpu.lost()) {
            self.tools = None;
        }
        if self.tools.is_none() {
            let mut pools = FieldPools::empty(&gpu, BUDGET_BYTES)?;
            match &mut self.painter {
                // A stroke that was running goes on.
                Some(painter) => painter.replay(&gpu, &mut pools, fields)?,
                None => self.painter = Some(Painter::new(&gpu)?),
            }
            let (caster, slices) = (Caster::new(&gpu)?, SliceCaster::new(&gpu)?);
            self.tools = Some(Tools { gpu, pools, caster, slices, tracer: None });
        }
        match (&mut self.tools, &mut self.painter) {
            (Some(tools), Some(painter)) => Ok((tools, painter)),
            _ => Err(GpuError::NoAdapter { reason: "none asked for".into() }),
        }
    }
}

/// Whether a brick of a volume may show in an area of a picture.
fn shows(state: &State, frame: &Frame, area: &Area, volume: VolumeId, brick: BrickIndex) -> bool {
    state.subject(volume).is_some_and(|subject| area.shows_brick(frame, subject.grid(), brick))
}
