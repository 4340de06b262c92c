//! Which slots the dabs of one frame meet, the box of work in each, and the dispatches that do it.
//!
//! Pure arithmetic: from footprints to a [`Plan`]. Its cost follows the dabs and the slots they meet, not the volume.

use crate::gpu::brush::kernel::{BrushDab, BrushItem, DABS_BYTES, ITEMS_BYTES, choices};
use crate::gpu::brush::stroke::Stroke;
use crate::gpu::device::constants::{MOST_DABS, ROW_PITCH_BYTES, ROWS_AT_ONCE};
use crate::paint::{Footprint, IndexBox};
use crate::volume::{BrickIndex, Region, SLOT, SLOT_VOXELS};
use std::collections::BTreeMap;

/// Uniform offsets are multiples of this on every adapter.
const ALIGNED: usize = 256;

/// What one submission may cost, in texels times dabs, so that the queue is never held for long: some 25 ms on two cores without
/// a graphics card.
pub(crate) const MOST_COST: u64 = 4 << 20;
/// Dabs of a dispatch, so that a whole slot under all of them costs no more than that.
pub(crate) const GROUP_DABS: usize = 96;
/// A texel's reading and writing costs as much as so many dabs.
const TEXEL_DABS: u32 = 4;

const _: () = assert!(GROUP_DABS <= MOST_DABS as usize);
const _: () = assert!(SLOT_VOXELS as u64 * (GROUP_DABS as u64 + TEXEL_DABS as u64) <= MOST_COST);

/// By brick whose slot shows any of the dabs: a box of voxels around what they change in it.
pub(crate) fn met(footprints: &[Footprint], dims: [u32; 3]) -> BTreeMap<BrickIndex, IndexBox> {
    let mut met: BTreeMap<BrickIndex, IndexBox> = BTreeMap::new();
    for footprint in footprints {
        for brick in footprint.bounds.slots(dims) {
            met.entry(brick).and_modify(|b| *b = b.union(&footprint.bounds)).or_insert(footprint.bounds);
        }
    }
    met
}

/// A slot's share of up to [`GROUP_DABS`] dabs that follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Work {
    /// Voxels that change at most.
    pub(crate) bounds: IndexBox,
    /// Numbers of the first and the last dab that meet the slot.
    dabs: [u32; 2],
}

/// Dabs that follow each other, and the slots they meet.
pub(crate) type Group<'a> = (&'a [Footprint], BTreeMap<BrickIndex, Work>);

/// Dabs in groups of what a dispatch can take, each with the slots it meets.
pub(crate) fn groups(footprints: &[Footprint], dims: [u32; 3]) -> Vec<Group<'_>> {
    footprints
        .chunks(GROUP_DABS)
        .map(|group| {
            let mut work: BTreeMap<BrickIndex, Work> = BTreeMap::new();
            for (n, footprint) in (0_u32..).zip(group) {
                for brick in footprint.bounds.slots(dims) {
                    let new = Work { bounds: footprint.bounds, dabs: [n, n] };
                    work.entry(brick)
                        .and_modify(|w| *w = Work { bounds: w.bounds.union(&new.bounds), dabs: [w.dabs[0], n] })
                        .or_insert(new);
                }
            }
            (group, work)
        })
        .collect()
}

impl Work {
    /// The same in the slot's own texels; where its new texels go and what is done is left open.
    pub(crate) fn item(&self, brick: BrickIndex, dims: [u32; 3], place: u32) -> BrushItem {
        let Region { mut lo, mut end } = texels(&self.bounds, brick, dims);
        (lo[0], end[0]) = (lo[0] / 4, end[0].div_ceil(4));
        BrushItem {
            origin: brick.origin().map(|o| o as i32 - 1),
            place,
            lo,
            next: 0,
            size: std::array::from_fn(|a| end[a] - lo[a]),
            first_dab: self.dabs[0],
            dab_count: self.dabs[1] - self.dabs[0] + 1,
            first_job: 0,
            choices: 0,
            unused: 0,
        }
    }
}

/// The texels of a brick's slot that dabs within `bounds` may change, in whole fours along x as the kernel takes them.
pub(crate) fn texels(bounds: &IndexBox, brick: BrickIndex, dims: [u32; 3]) -> Region {
    let Region { mut lo, mut end } = Region { lo: bounds.lo, end: bounds.end }.in_slot(brick, dims);
    (lo[0], end[0]) = (lo[0] / 4 * 4, end[0].next_multiple_of(4).min(SLOT));
    Region { lo, end }
}

/// A frame's dispatches and the bytes that they read.
pub(crate) struct Plan {
    /// The stroke's constants, then dabs and items at their offsets.
    pub(crate) uniforms: Vec<u8>,
    pub(crate) dispatches: Vec<Dispatch>,
    /// Per workgroup of all dispatches: item and workgroup within it.
    pub(crate) jobs: Vec<u32>,
    /// Bytes of new texels of the largest dispatch.
    pub(crate) next_bytes: u64,
}

/// A dispatch that is being filled.
#[derive(Default)]
struct Begun {
    items: Vec<BrushItem>,
    copies: Vec<Copy>,
    jobs: Vec<u32>,
    rows: u32,
    cost: u64,
}

impl Begun {
    fn add(&mut self, item: BrushItem, slot: [u32; 3], cost: u64) {
        self.copies.push(Copy::of(&item, slot));
        let rows = item.size[1] * item.size[2];
        self.rows += rows;
        let number = (self.items.len() as u32) << 16;
        self.jobs.extend((0..rows.div_ceil(ROWS_AT_ONCE)).map(|group| number | group));
        self.items.push(item);
        self.cost += cost;
    }
}

/// Texels times dabs, and what a texel costs without any.
fn cost(item: &BrushItem) -> u64 {
    u64::from(item.size.iter().product::<u32>() * 4) * u64::from(item.dab_count + TEXEL_DABS)
}

/// The work of one group of dabs on slots of the same buffers, of [`MOST_COST`] or one slot's.
pub(crate) struct Dispatch {
    /// Number of those buffers among the stroke's.
    pub(crate) buffers: usize,
    /// Offsets within the uniforms.
    pub(crate) dabs_at: u32,
    pub(crate) items_at: u32,
    pub(crate) workgroups: u32,
    /// See [`MOST_COST`].
    pub(crate) cost: u64,
    pub(crate) copies: Vec<Copy>,
}

/// From a box of new texels into a slot.
pub(crate) struct Copy {
    pub(crate) offset: u64,
    pub(crate) rows: u32,
    pub(crate) to: [u32; 3],
    pub(crate) extent: wgpu::Extent3d,
}

impl Plan {
    pub(crate) fn new(stroke: &Stroke, groups: &[Group<'_>]) -> Self {
        let mut plan = Self { uniforms: Vec::new(), dispatches: Vec::new(), jobs: Vec::new(), next_bytes: 0 };
        plan.append(bytemuck::bytes_of(&stroke.constants), ALIGNED);
        let choices = choices(&stroke.brush, stroke.is_gated());
        for (dabs, work) in groups {
            let dabs: Vec<_> = dabs.iter().map(|dab| BrushDab::new(dab, stroke.brush.radius_mm)).collect();
            let dabs_at = plan.append(bytemuck::cast_slice(&dabs), DABS_BYTES as usize);
            for buffers in 0..stroke.buffers.len() {
                let mut begun = Begun::default();
                for (brick, work) in work {
                    let Some(slot) = stroke.slots.get(brick).filter(|s| s.buffers == buffers) else { continue };
                    let item = work.item(*brick, stroke.grid.dims, slot.place);
                    let cost = cost(&item);
                    if begun.cost > 0 && begun.cost + cost > MOST_COST {
                        plan.dispatch(buffers, dabs_at, std::mem::take(&mut begun));
                    }
                    begun.add(BrushItem { next: begun.rows, choices, ..item }, slot.texel, cost);
                }
                plan.dispatch(buffers, dabs_at, begun);
            }
        }
        plan
    }

    fn dispatch(&mut self, buffers: usize, dabs_at: u32, begun: Begun) {
        if begun.items.is_empty() {
            return;
        }
        let Begun { mut items, copies, jobs, rows, cost } = begun;
        items[0].first_job = self.jobs.len() as u32;
        let items_at = self.append(bytemuck::cast_slice(&items), ITEMS_BYTES as usize);
        self.next_bytes = self.next_bytes.max(u64::from(rows * ROW_PITCH_BYTES));
        let workgroups = jobs.len() as u32;
        self.jobs.extend(jobs);
        self.dispatches.push(Dispatch { buffers, dabs_at, items_at, workgroups, cost, copies });
    }

    /// Adds bytes, padded; answers where.
    fn append(&mut self, bytes: &[u8], pad_to: usize) -> u32 {
        let offset = self.uniforms.len();
        self.uniforms.extend_from_slice(bytes);
        self.uniforms.resize(offset + bytes.len().next_multiple_of(pad_to), 0);
        offset as u32
    }
}

impl Copy {
    /// From the new texels of an item's box into its slot.
    fn of(item: &BrushItem, slot: [u32; 3]) -> Self {
        let x = item.lo[0] * 4;
        let end = ((item.lo[0] + item.size[0]) * 4).min(SLOT);
        Self {
            offset: u64::from(item.next * ROW_PITCH_BYTES),
            rows: item.size[1],
            to: [slot[0] + x, slot[1] + item.lo[1], slot[2] + item.lo[2]],
            extent: wgpu::Extent3d { width: end - x, height: item.size[1], depth_or_array_layers: item.size[2] },
        }
    }
}
