//! Which bricks of level 0 of a volume are needed, and how urgently.
//!
//! Pure: knows no device and no slots. Needed is what looks show of the matter that bodies draw, what slices run through, what a
//! surface is traced through, and what is being painted. Judged brick by brick where something changed that this depends on.

use crate::gpu::fields::dirty_bricks::DirtyBricks;
use crate::gpu::fields::importance::{self, Viewing};
use crate::gpu::fields::slot_key::{brick_of, count_of, number_of};
use crate::gpu::fields::visible_values::VisibleValues;
use crate::gpu::fields::volumes::VolumeFields;
use crate::gpu::picture::frame::{Body, Mask};
use crate::math::DVec3;
use crate::volume::{BRICK, BrickIndex, BrickKey, Cells, Field, FieldKind, Grid, TransferFunction};
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};
use std::sync::OnceLock;

/// What a frame asks of a volume.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Asked {
    pub(crate) viewing: Viewing,
    /// Of all looks that its bodies have.
    pub(crate) values: Vec<VisibleValues>,
    /// Of its first body: what hides what is told by it.
    pub(crate) transfer: Option<TransferFunction>,
}

/// What a slice runs through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SliceCut {
    /// The voxels at an index of a voxel axis.
    Row {
        /// 0 i, 1 j, 2 k.
        axis: usize,
        /// Along it.
        index: u32,
    },
    /// A rectangle anywhere in index space.
    Plane {
        /// The view that it is of, 0 to 2: each has one cut through a volume.
        view: usize,
        /// A corner.
        corner: DVec3,
        /// To the next corner.
        across: DVec3,
        /// To the other one.
        down: DVec3,
    },
}

impl SliceCut {
    fn view(self) -> usize {
        match self {
            Self::Row { axis, .. } => axis,
            Self::Plane { view, .. } => view.min(2),
        }
    }

    /// Whether it runs through a brick of level 0, for a plane with a voxel around it.
    fn meets(self, brick: BrickIndex) -> bool {
        match self {
            Self::Row { axis, index } => brick.0[axis] == index / BRICK,
            Self::Plane { corner, across, down, .. } => {
                let half = DVec3::splat(0.5 * f64::from(BRICK) + 1.0);
                let middle = DVec3::from_array(brick.origin().map(f64::from)) + 0.5 * (f64::from(BRICK) - 1.0);
                let ends = [corner, corner + across, corner + down, corner + across + down];
                let (lo, hi) = ends.iter().fold((ends[0], ends[0]), |(lo, hi), &p| (lo.min(p), hi.max(p)));
                let normal = across.cross(down);
                let apart = (middle - corner).dot(normal).abs() > normal.abs().dot(half);
                !apart && (middle + half).cmpge(lo).all() && (middle - half).cmple(hi).all()
            }
        }
    }
}

/// Which bricks of one volume are needed for what was last asked of it, kept up to date brick by brick.
#[derive(Debug)]
pub(crate) struct Demand {
    grid: Grid,
    bricks: [u32; 3],
    asked: Option<Asked>,
    /// What slices run through, by view.
    slices: [Option<SliceCut>; 3],
    /// Bricks that are asked for themselves, whatever pictures show.
    reached: HashSet<usize>,
    /// By brick of level 0: whether a look shows any of it. Empty: not known.
    visible: Vec<bool>,
    /// By brick of level 0: whether anything draws it.
    needed: Vec<bool>,
    /// Bricks of which that is to be judged anew.
    unsure: DirtyBricks,
    /// By brick of level 0: how much it hides. Known once it was needed.
    extinction: OnceLock<Vec<f32>>,
    /// What cells of a running stroke's bricks hold, of density and of the selection.
    live: [HashMap<usize, Cells>; 2],
    judged: u64,
}

/// Whether two lists of bodies draw the same matter, wherever it is moved to.
fn same_matter(a: &[Body], b: &[Body]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.mask == b.mask && a.region == b.region && a.labels == b.labels)
}

fn any(cells: &Cells, of: impl Fn([f32; 2]) -> bool) -> bool {
    match cells {
        Cells::Uniform(range) => of(*range),
        Cells::Dense(cells) => cells.iter().any(|&range| of(range)),
    }
}

/// The number of a field that cells and needs depend on.
pub(crate) fn live_place(kind: FieldKind) -> Option<usize> {
    match kind {
        FieldKind::Density => Some(0),
        FieldKind::Selection => Some(1),
        FieldKind::Colour | FieldKind::Labels => None,
    }
}

impl Demand {
    /// Nothing is asked for yet.
    pub(crate) fn new(grid: &Grid, bricks: [u32; 3]) -> Self {
        Self {
            grid: *grid,
            bricks,
            asked: None,
            slices: [None; 3],
            reached: HashSet::new(),
            visible: Vec::new(),
            needed: vec![false; count_of(bricks)],
            unsure: DirtyBricks::all(),
            extinction: OnceLock::new(),
            live: Default::default(),
            judged: 0,
        }
    }

    pub(crate) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Bricks of level 0 along each axis.
    pub(crate) fn bricks(&self) -> [u32; 3] {
        self.bricks
    }

    /// Whether anything draws a brick of level 0, as it was last judged.
    pub(crate) fn needs(&self, brick: usize) -> bool {
        self.needed[brick]
    }

    /// Bricks looked at so far.
    pub(crate) fn judged(&self) -> u64 {
        self.judged
    }

    /// What the cells of a running stroke's brick hold, of density and of the selection.
    pub(crate) fn live(&self, brick: usize) -> [Option<&Cells>; 2] {
        [0, 1].map(|map| self.live[map].get(&brick))
    }

    /// The volume lies elsewhere. Answers whether it does.
    pub(crate) fn place(&mut self, grid: &Grid) -> bool {
        let moved = self.grid != *grid;
        if moved {
            self.grid = *grid;
            self.unsure = DirtyBricks::all();
            self.extinction.take();
        }
        moved
    }

    /// Takes what a frame asks. Answers whether other bricks may be the right ones.
    pub(crate) fn ask(&mut self, asked: Asked) -> bool {
        let old = self.asked.as_ref();
        let values = old.is_none_or(|old| old.values != asked.values);
        let transfer = old.is_none_or(|old| old.transfer != asked.transfer);
        let view = !old.is_some_and(|old| old.viewing.sees_like(&asked.viewing));
        if values {
            self.visible.clear();
        }
        if values || transfer {
            self.extinction.take();
        }
        if view && old.is_none_or(|old| !same_matter(&old.viewing.bodies, &asked.viewing.bodies)) {
            self.unsure = DirtyBricks::all();
        }
        if values || transfer || view {
            self.asked = Some(asked);
        }
        values || transfer || view
    }

    /// A slice is drawn. Answers whether it asks for other bricks than the last one of its view.
    pub(crate) fn slice(&mut self, cut: SliceCut) -> bool {
        let cut = match cut {
            // The first voxel of the last row of bricks stands for all of them.
            SliceCut::Row { axis, index } => {
                let index = index.min(self.grid.dims[axis].saturating_sub(1)) / BRICK * BRICK;
                SliceCut::Row { axis, index }
            }
            plane => plane,
        };
        let old = self.slices[cut.view()];
        if old == Some(cut) {
            return false;
        }
        self.slices[cut.view()] = Some(cut);
        let met = |i: &usize| {
            let brick = brick_of(self.bricks, *i);
            cut.meets(brick) || old.is_some_and(|old| old.meets(brick))
        };
        let met: Vec<usize> = (0..count_of(self.bricks)).filter(met).collect();
        self.unsure.extend(met);
        true
    }

    /// These bricks of level 0 are needed more than any others, and no longer those that were named before. Answers whether they are
    /// others.
    pub(crate) fn reach(&mut self, bricks: HashSet<usize>) -> bool {
        let others = self.reached != bricks;
        if others {
            self.unsure.extend(self.reached.symmetric_difference(&bricks).copied());
            self.reached = bricks;
        }
        others
    }

    /// All values are others.
    pub(crate) fn remap(&mut self) {
        self.visible.clear();
        self.extinction.take();
    }

    /// A brick of level 0 of a field is new: what was said of its live cells is over.
    pub(crate) fn renew(&mut self, field: &Field, index: BrickIndex) {
        let Some(map) = live_place(field.kind()) else { return };
        let i = number_of(self.bricks, index);
        if field.kind() == FieldKind::Density {
            if !self.visible.is_empty() {
                self.visible[i] = self.shows(field, index);
            }
            let transfer = self.asked.as_ref().and_then(|a| a.transfer.as_ref());
            if let (Some(extinction), Some(transfer)) = (self.extinction.get_mut(), transfer) {
                extinction[i] = importance::extinction(field, &self.grid, transfer, index);
            }
        }
        self.live[map].remove(&i);
        self.unsure.insert(i);
    }

    /// While a stroke runs: what the cells of a brick hold that it paints.
    pub(crate) fn set_live(&mut self, map: usize, brick: usize, cells: Cells) {
        self.live[map].insert(brick, cells);
        self.unsure.insert(brick);
    }

    /// Ends that for a field. Answers the bricks that it was said of.
    pub(crate) fn end_live(&mut self, map: usize) -> Vec<usize> {
        let bricks: Vec<_> = std::mem::take(&mut self.live[map]).into_keys().collect();
        self.unsure.extend(bricks.iter().copied());
        bricks
    }

    /// Judges the bricks anew of which something changed. Answers those that are judged otherwise, in order.
    pub(crate) fn judge(&mut self, fields: &VolumeFields<'_>) -> Vec<usize> {
        if self.visible.is_empty() {
            let bricks = fields.density.brick_indices(0);
            self.visible = bricks.into_par_iter().map(|b| self.shows(fields.density, b)).collect();
            self.unsure = DirtyBricks::all();
        }
        let dirty = self.unsure.take(self.visible.len());
        self.judged += dirty.len() as u64;
        let judged: Vec<bool> = dirty.par_iter().with_min_len(64).map(|&i| self.is_needed(fields, i)).collect();
        let mut changed = Vec::new();
        for (i, needed) in dirty.into_iter().zip(judged) {
            if self.needed[i] != needed {
                self.needed[i] = needed;
                changed.push(i);
            }
        }
        changed
    }

    fn any_value(&self, [lo, hi]: [f32; 2]) -> bool {
        self.asked.as_ref().is_some_and(|asked| asked.values.iter().any(|values| values.any(lo, hi)))
    }

    /// Whether a look shows any of a brick of level 0.
    fn shows(&self, density: &Field, index: BrickIndex) -> bool {
        let about = density.summary(BrickKey { level: 0, index });
        self.any_value([about.min, about.max])
    }

    fn is_needed(&self, fields: &VolumeFields<'_>, i: usize) -> bool {
        let index = brick_of(self.bricks, i);
        // A stroke's bricks are looked at as they are and as they were at its start.
        let live = || self.live[0].get(&i).is_some_and(|cells| any(cells, |range| self.any_value(range)));
        self.sliced(index)
            || self.reached.contains(&i)
            || (self.visible[i] || live()) && self.is_drawn(fields.selection, i, index)
    }

    /// Whether a body draws any of a brick: hidden parts need nothing.
    fn is_drawn(&self, selection: &Field, i: usize, index: BrickIndex) -> bool {
        let Some(Asked { viewing, .. }) = &self.asked else { return false };
        if viewing.bodies.iter().any(|b| b.mask == Mask::None && b.region.is_empty()) {
            return true;
        }
        let about = selection.summary(BrickKey { level: 0, index });
        let live = self.live[1].get(&i);
        let holds =
            |of: &dyn Fn([f32; 2]) -> bool| of([about.min, about.max]) || live.is_some_and(|cells| any(cells, of));
        let corners = importance::corners(&self.grid, index);
        viewing.bodies.iter().any(|body| {
            let shares = match body.mask {
                Mask::None => true,
                Mask::Selection => holds(&|[_, most]| most > 0.0),
                Mask::Background => holds(&|[least, _]| least < 1.0),
            };
            shares && !importance::outside(&body.region, &corners)
        })
    }

    /// Whether a slice runs through a brick of level 0.
    fn sliced(&self, index: BrickIndex) -> bool {
        self.slices.iter().flatten().any(|cut| cut.meets(index))
    }

    /// How much each of some bricks of level 0 matters to the picture.
    pub(crate) fn urgency(&self, density: &Field, bricks: &[BrickKey]) -> Vec<f32> {
        let mut urgency = match &self.asked {
            Some(Asked { viewing, transfer: Some(transfer), .. }) => {
                let known = || importance::extinctions(density, &self.grid, transfer);
                importance::urgency(viewing, &self.grid, self.bricks, self.extinction.get_or_init(known), bricks)
            }
            _ => vec![0.0; bricks.len()],
        };
        for (urgency, key) in urgency.iter_mut().zip(bricks) {
            // A slice shows its voxels at about a pixel each.
            if self.sliced(key.index) {
                *urgency = urgency.max(1.0);
            }
            if self.reached.contains(&number_of(self.bricks, key.index)) {
                *urgency = f32::MAX;
            }
        }
        urgency
    }
}
