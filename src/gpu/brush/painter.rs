//! Painting on the GPU: the life of a stroke, from its first dab to the bricks it changed, on one volume or several at once.
//!
//! Owns what a stroke gathers on each volume (coverage, texels at its start) and its dabs, so that it can be taken back, or painted
//! again after a loss of the device. The pools' slots show it in the same frame; the host's fields stay as they are until
//! [`Painter::finish`]. Sees to it that the volumes of a stroke get its dabs together or not at all. Knows no history.

use crate::gpu::brush::stroke::Stroke;
use crate::gpu::brush::tools::{Tools, of};
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::volumes::Fields;
use crate::paint::{Brush, Confines, Dab, Reach, VoxelSet, margin};
use crate::volume::{Brick, BrickIndex, BrickKey, FieldKey, FieldKind, LiveCells, Refresh, Segments, VolumeId};
use std::collections::BTreeMap;

/// Paints strokes, one at a time. Long-lived: it keeps pipelines and some buffers.
#[derive(Debug)]
pub struct Painter {
    tools: Tools,
    /// The running stroke on each volume that it paints.
    strokes: BTreeMap<VolumeId, Stroke>,
}

/// Bricks of each field that a stroke painted.
pub type PaintedBricks = Vec<(FieldKey, Vec<(BrickIndex, Brick)>)>;

impl Painter {
    /// A painter on this device.
    ///
    /// # Errors
    /// If the device refuses its small buffers.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self { tools: Tools::new(gpu)?, strokes: BTreeMap::new() })
    }

    /// Sets the memory that one stroke may take on the GPU, in bytes (some 350 kB a touched brick; slots of the pools come on
    /// top).
    pub fn set_budget(&mut self, bytes: u64) {
        self.tools.budget_bytes = bytes;
    }

    /// How often dabs were submitted so far.
    pub fn submits(&self) -> u64 {
        self.tools.dispatcher.submits
    }

    /// Whether a stroke is running.
    pub fn is_painting(&self) -> bool {
        !self.strokes.is_empty()
    }

    /// The running stroke's dabs so far on a volume, in order.
    pub fn dabs(&self, volume: VolumeId) -> &[Dab] {
        self.strokes.get(&volume).map_or(&[], |s| &s.dabs)
    }

    /// The bricks that the running stroke shows in, itself or through an apron, in order.
    pub fn touched(&self) -> Vec<(FieldKey, BrickIndex)> {
        self.strokes.values().flat_map(|s| s.touched().into_iter().map(|brick| (s.key(), brick))).collect()
    }

    /// Looks at the fields as they were at the running stroke's start, in those of the touched bricks that `under` names: what a
    /// stroke paints must not change where it goes on. Without a stroke it only looks.
    ///
    /// # Errors
    /// Those of the look; as [`finish`](Self::finish).
    pub fn at_start<T>(
        &mut self,
        pools: &mut FieldPools,
        under: impl Fn(VolumeId, BrickIndex) -> bool,
        look: impl FnOnce(&mut FieldPools) -> Result<T, GpuError>,
    ) -> Result<T, GpuError> {
        let gpu = &self.tools.gpu;
        let mut aside = Vec::new();
        let mut begun = Ok(());
        // Where a picture shows something does not hang on colour; on labels it does where looks go by them.
        for stroke in self.strokes.values_mut().filter(|s| s.kind() != FieldKind::Colour) {
            let bricks: Vec<_> = stroke.touched().into_iter().filter(|&brick| under(stroke.volume, brick)).collect();
            if begun.is_ok() && !bricks.is_empty() {
                begun = stroke.show_start(gpu, pools, &bricks);
                aside.extend(begun.is_ok().then_some((stroke.volume, bricks)));
            }
        }
        let seen = begun.and_then(|()| look(pools));
        for (volume, bricks) in aside {
            if let Some(stroke) = self.strokes.get(&volume) {
                stroke.show_painted(gpu, pools, &bricks)?;
            }
        }
        seen
    }

    /// Starts a stroke on a volume's fields as they are now, or lets the one that has begun paint this volume too; they must stay so
    /// until it ends. Labels of locked segments are kept. `reach` is that of density with what the brush makes.
    ///
    /// # Errors
    /// [`GpuError::Stroke`] if one runs on the volume, or has dabs on another already; [`GpuError::Paint`] if the brush is not valid;
    /// [`GpuError::BeyondRange`] if density cannot yet hold what the brush makes: widen its
    /// [`DensityMap`](crate::volume::DensityMap) and begin again.
    pub fn begin(
        &mut self,
        volume: VolumeId,
        fields: &Fields<'_>,
        brush: &Brush,
        segments: &Segments,
        reach: Reach,
    ) -> Result<(), GpuError> {
        if self.strokes.contains_key(&volume) || self.strokes.values().any(|s| !s.dabs.is_empty()) {
            return Err(GpuError::Stroke("one is running; end or cancel it first"));
        }
        brush.check()?;
        let fields = of(fields, volume)?;
        brush.check_on(fields.density)?;
        if let Some(needed) = brush.range_needed(fields.density) {
            let map = fields.density.map();
            return Err(GpuError::BeyondRange { needed, held: [map.lo, map.hi()] });
        }
        self.strokes.insert(volume, Stroke::new(volume, &fields, brush, segments, reach));
        Ok(())
    }

    /// Lets the running stroke paint these voxels of a volume besides those that it may already, if it keeps to the visible
    /// surface: other voxels it leaves alone. To be called before the dabs on them.
    pub fn open(&mut self, volume: VolumeId, voxels: &VoxelSet) {
        if let Some(stroke) = self.strokes.get_mut(&volume).filter(|s| s.brush.keeps_to_surface()) {
            let new = stroke.seen.extend(voxels);
            let reach = margin(stroke.brush.within_mm.unwrap_or(0.0), &stroke.grid);
            stroke.stale.extend(new.slots(stroke.grid.dims, reach));
        }
    }

    /// Lets the running stroke paint no voxels of a volume but those in all of these sets. To be called before its first dab there.
    pub fn confine(&mut self, volume: VolumeId, confines: &Confines) {
        if let Some(stroke) = self.strokes.get_mut(&volume).filter(|s| s.slots.is_empty()) {
            stroke.confines.clone_from(confines);
        }
    }

    /// Paints further dabs, for each volume its own: after it the pools' slots show them, without waiting for the GPU. Answers the
    /// bricks that the dabs show in, in order. `fields` are those of [`begin`](Self::begin).
    ///
    /// # Errors
    /// [`GpuError::StrokeTooLarge`] and [`GpuError::PoolFull`] if there is no room for more bricks; [`GpuError::Lost`];
    /// [`GpuError::Source`]; [`GpuError::Stroke`] if none runs on such a volume. The stroke is then as it was on all volumes and
    /// can be ended, cancelled or replayed.
    pub fn extend(
        &mut self,
        pools: &mut FieldPools,
        fields: &Fields<'_>,
        dabs: &[(VolumeId, &[Dab])],
    ) -> Result<Vec<(FieldKey, BrickIndex)>, GpuError> {
        self.tools.gpu.check()?;
        if self.strokes.is_empty() || dabs.iter().any(|(volume, _)| !self.strokes.contains_key(volume)) {
            return Err(NOT_RUNNING);
        }
        self.mend(pools, fields)?;
        // Slots that lie in place move when another volume comes, so all come before the first is held.
        for volume in self.strokes.keys() {
            pools.have(&self.tools.gpu, fields, *volume)?;
        }
        let before: BTreeMap<_, _> = self.strokes.iter().map(|(volume, s)| (*volume, s.dabs.len())).collect();
        let mut bricks = Vec::new();
        for (volume, dabs) in dabs {
            let elsewhere = self.strokes.values().filter(|s| s.volume != *volume).map(Stroke::bytes).sum();
            let Some(stroke) = self.strokes.get_mut(volume) else { continue };
            let painted = of(fields, *volume).and_then(|f| self.tools.extend(stroke, pools, &f, dabs, elsewhere));
            match painted {
                Ok(met) => bricks.extend(met.into_iter().map(|brick| (stroke.key(), brick))),
                Err(error) => {
                    self.fall_back(&before);
                    self.mend(pools, fields)?;
                    return Err(error);
                }
            }
        }
        bricks.sort_unstable();
        Ok(bricks)
    }

    /// Volumes that got dabs which others could not take have no more than these.
    fn fall_back(&mut self, before: &BTreeMap<VolumeId, usize>) {
        for (volume, stroke) in &mut self.strokes {
            let count = before.get(volume).copied().unwrap_or_default();
            if stroke.dabs.len() > count {
                stroke.dabs.truncate(count);
                stroke.torn = true;
            }
        }
    }

    /// Lays strokes anew whose slots show more than their dabs.
    fn mend(&mut self, pools: &mut FieldPools, fields: &Fields<'_>) -> Result<(), GpuError> {
        for stroke in self.strokes.values_mut().filter(|s| s.torn) {
            self.tools.rewind(stroke, pools, &of(fields, stroke.volume)?)?;
        }
        Ok(())
    }

    /// Takes what has come of the minima and maxima of the running stroke's cells, and asks for those of what was painted since:
    /// `pools` skip by them. To be called once a frame. Never waits.
    ///
    /// # Errors
    /// [`GpuError::Lost`] and others of the device.
    pub fn follow(&mut self, pools: &mut FieldPools, fields: &Fields<'_>) -> Result<(), GpuError> {
        for stroke in self.strokes.values_mut() {
            self.tools.follow(stroke, pools, &of(fields, stroke.volume)?)?;
        }
        Ok(())
    }

    /// The cells of the running stroke's bricks, of those of which something came since this was last asked. Only strokes on
    /// density and the selection have any.
    pub fn take_live(&mut self) -> Vec<(FieldKey, BrickIndex, LiveCells)> {
        let news = |s: &mut Stroke| {
            let key = s.key();
            s.live.take_news().into_iter().map(move |(brick, cells)| (key, brick, cells))
        };
        self.strokes.values_mut().flat_map(news).collect()
    }

    /// Whether something of the running stroke's cells is still to come, or to be taken.
    pub fn is_due(&self) -> bool {
        self.strokes.values().any(|s| s.live.are_due())
    }

    /// Ends the stroke: waits for the GPU and answers, for each volume, the bricks whose own texels differ from those at its start, in
    /// order, with zeros beyond the volume. None: the stroke changed nothing there. The slots show the stroke already; give the bricks
    /// to [`Field::swap`](crate::volume::Field::swap) and the answer to [`FieldPools::refresh_painted`] before anything else is
    /// drawn.
    ///
    /// # Errors
    /// [`GpuError::Lost`] and others of the device. The stroke then goes on and can be replayed or cancelled.
    pub fn finish(&mut self, pools: &mut FieldPools, fields: &Fields<'_>) -> Result<PaintedBricks, GpuError> {
        if self.strokes.is_empty() {
            return Err(NOT_RUNNING);
        }
        self.mend(pools, fields)?;
        for (volume, stroke) in &mut self.strokes {
            self.tools.settle(stroke, pools, &of(fields, *volume)?)?;
        }
        let mut bricks = Vec::new();
        for (volume, stroke) in &self.strokes {
            bricks.push((stroke.key(), self.tools.changed(stroke, pools, &of(fields, *volume)?)?));
        }
        for (_, stroke) in std::mem::take(&mut self.strokes) {
            pools.hand_over(stroke.key());
            self.tools.keep(stroke);
        }
        Ok(bricks)
    }

    /// Takes the stroke back: the slots are as they were. Answers what the pools showed of it, for
    /// [`FieldPools::refresh_painted`] with the unchanged fields.
    ///
    /// # Errors
    /// [`GpuError::Lost`]: then there is nothing left to take back, and the stroke is gone too.
    pub fn cancel(&mut self, pools: &mut FieldPools) -> Result<Vec<(FieldKey, Refresh)>, GpuError> {
        if self.strokes.is_empty() {
            return Err(NOT_RUNNING);
        }
        let mut showed = Vec::new();
        let mut done = Ok(());
        for (_, stroke) in std::mem::take(&mut self.strokes) {
            let restored = stroke.restore(&self.tools.gpu, pools);
            if restored.is_ok() {
                pools.hand_over(stroke.key());
            } else {
                pools.unpin(stroke.key());
            }
            let slots = stroke.touched().into_iter().map(|index| BrickKey { level: 0, index });
            showed.push((stroke.key(), Refresh::whole(slots)));
            self.tools.keep(stroke);
            done = done.and(restored);
        }
        done.map(|()| showed)
    }

    /// A brick of a volume as the running stroke shows it. Waits for the GPU.
    ///
    /// # Errors
    /// As [`finish`](Self::finish).
    pub fn live(
        &self,
        pools: &FieldPools,
        fields: &Fields<'_>,
        volume: VolumeId,
        brick: BrickIndex,
    ) -> Result<Option<Brick>, GpuError> {
        let Some(stroke) = self.strokes.get(&volume) else { return Ok(None) };
        self.tools.live(stroke, pools, &of(fields, volume)?, brick)
    }

    /// After a loss of the device: paints the running stroke again on a new one, from the host's bricks. Without a running
    /// stroke it only changes over.
    ///
    /// # Errors
    /// As [`extend`](Self::extend); the dabs are kept, so that it can be tried again.
    pub fn replay(&mut self, gpu: &Gpu, pools: &mut FieldPools, fields: &Fields<'_>) -> Result<(), GpuError> {
        let mut tools = Tools::new(gpu)?;
        tools.budget_bytes = self.tools.budget_bytes;
        let strokes = std::mem::take(&mut self.strokes);
        let mut dabs: Vec<(VolumeId, Vec<Dab>)> = Vec::new();
        self.tools = tools;
        for (volume, stroke) in strokes {
            let (stroke, laid) = stroke.anew();
            self.strokes.insert(volume, stroke);
            dabs.push((volume, laid));
        }
        if dabs.is_empty() {
            return Ok(());
        }
        let again: Vec<_> = dabs.iter().map(|(volume, dabs)| (*volume, dabs.as_slice())).collect();
        let painted = self.extend(pools, fields, &again).map(drop);
        if painted.is_err() {
            for (volume, dabs) in dabs {
                if let Some(stroke) = self.strokes.get_mut(&volume) {
                    stroke.dabs = dabs;
                }
            }
        }
        painted
    }
}

const NOT_RUNNING: GpuError = GpuError::Stroke("none is running; begin one first");
