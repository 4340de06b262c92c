//! What a stroke keeps on the GPU for every slot it touches: texels at its start and coverage so far.
//!
//! Owns [`StrokeBuffers`], which serve a number of slots; a stroke takes further ones as it grows. Knows no dabs.

use crate::gpu::brush::kernel::{QUADS, SLOT_PITCH_BYTES, Variant};
use crate::gpu::device::constants::{MOST_ITEMS, ROW_PITCH_BYTES};
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::volume::{BrickIndex, Region, SLOT};

/// Slots of the smallest and of the largest buffers; the latter is what one dispatch can take.
const CAPACITY: [u32; 2] = [16, MOST_ITEMS];
const COVERAGE_BYTES: u64 = (SLOT * SLOT * QUADS) as u64 * 16;
const GATE_BYTES: u64 = crate::paint::GATE_WORDS as u64 * 4;

/// What a stroke needs beyond start and coverage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extras {
    /// Bytes that a slot takes of unedited density, if the stroke restores it, or of goals.
    pub(crate) base: Option<u64>,
    /// Whether the stroke respects a range of values.
    pub(crate) gate: bool,
}

/// The slot of a touched brick, and where what is kept of it is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StrokeSlot {
    /// Number of its buffers among the stroke's.
    pub(crate) buffers: usize,
    /// Within those.
    pub(crate) place: u32,
    /// Its first texel in the pool, which keeps it for as long as it is pinned.
    pub(crate) texel: [u32; 3],
    /// What of it is kept, in its own texels from the apron on: the stroke changes nothing else.
    pub(crate) kept: Region,
}

/// All of a slot.
pub(crate) const WHOLE_SLOT: Region = Region { lo: [0; 3], end: [SLOT; 3] };

/// See the file's head.
#[derive(Debug)]
pub(crate) struct StrokeBuffers {
    variant: Variant,
    extras: Extras,
    capacity: u32,
    /// By place.
    pub(crate) bricks: Vec<BrickIndex>,
    pub(crate) start: wgpu::Buffer,
    pub(crate) coverage: wgpu::Buffer,
    pub(crate) changed: wgpu::Buffer,
    pub(crate) base: Option<wgpu::Buffer>,
    /// A bit for every texel that the range lets through.
    pub(crate) gate: Option<wgpu::Buffer>,
    /// Where what was painted waits while slots show the start. Made when first needed.
    aside: Option<wgpu::Buffer>,
}

/// Bytes that a slot takes, more or less: of slots that share rows each is counted for its part.
pub(crate) fn slot_bytes(variant: Variant, extras: Extras) -> u64 {
    let gate = if extras.gate { GATE_BYTES } else { 0 };
    SLOT_PITCH_BYTES / u64::from(variant.slots_per_row()) + COVERAGE_BYTES + 4 + extras.base.unwrap_or(0) + gate
}

/// How many slots the next buffers hold when `needed` have no place and `touched` have one.
pub(crate) fn next_capacity(needed: usize, touched: usize) -> u32 {
    (needed.max(touched / 2) as u32).next_power_of_two().clamp(CAPACITY[0], CAPACITY[1])
}

impl StrokeBuffers {
    pub(crate) fn new(gpu: &Gpu, variant: Variant, extras: Extras, capacity: u32) -> Result<Self, GpuError> {
        use wgpu::BufferUsages as Use;
        let count = u64::from(capacity);
        let make = |label, size, usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: usage | Use::STORAGE | Use::COPY_DST,
                mapped_at_creation: false,
            })
        };
        gpu.scoped("a stroke's buffers", || {
            let pitches = u64::from(capacity.div_ceil(variant.slots_per_row()));
            Ok(Self {
                variant,
                extras,
                capacity,
                bricks: Vec::new(),
                start: make("brush start", pitches * SLOT_PITCH_BYTES, Use::COPY_SRC),
                coverage: make("brush coverage", count * COVERAGE_BYTES, Use::empty()),
                changed: make("brush changed", count * 4, Use::COPY_SRC),
                base: extras.base.map(|bytes| make("brush base", count * bytes, Use::empty())),
                gate: extras.gate.then(|| make("brush gate", count * GATE_BYTES, Use::empty())),
                aside: None,
            })
        })
    }

    /// Whether a stroke of this kind can take it over.
    pub(crate) fn serves(&self, variant: Variant, extras: Extras) -> bool {
        self.variant == variant && self.extras == extras
    }

    pub(crate) fn bytes(&self) -> u64 {
        u64::from(self.capacity) * slot_bytes(self.variant, self.extras)
            + self.aside.as_ref().map_or(0, wgpu::Buffer::size)
    }

    pub(crate) fn room(&self) -> usize {
        self.capacity as usize - self.bricks.len()
    }

    /// Gives a slot of a brick the next place.
    pub(crate) fn place(&mut self, brick: BrickIndex) -> u32 {
        self.bricks.push(brick);
        self.bricks.len() as u32 - 1
    }

    /// Slots at these places differ from their start in nothing.
    pub(crate) fn clear_changed(&self, encoder: &mut wgpu::CommandEncoder, places: std::ops::Range<usize>) {
        if !places.is_empty() {
            encoder.clear_buffer(&self.changed, places.start as u64 * 4, Some(places.len() as u64 * 4));
        }
    }

    /// Slots at these places have gathered nothing.
    pub(crate) fn clear_coverage(&self, encoder: &mut wgpu::CommandEncoder, places: std::ops::Range<usize>) {
        if !places.is_empty() {
            let (first, bytes) = (places.start as u64 * COVERAGE_BYTES, places.len() as u64 * COVERAGE_BYTES);
            encoder.clear_buffer(&self.coverage, first, Some(bytes));
        }
    }

    /// Keeps a slot's texels as they are now as those of the stroke's start.
    pub(crate) fn keep(&self, encoder: &mut wgpu::CommandEncoder, slot: &StrokeSlot, pool: &wgpu::Texture) {
        let (from, extent) = slot.texels(pool);
        encoder.copy_texture_to_buffer(from, self.rows(&self.start, slot), extent);
    }

    /// Puts a slot's texels back as they were at the stroke's start.
    pub(crate) fn restore(&self, encoder: &mut wgpu::CommandEncoder, slot: &StrokeSlot, pool: &wgpu::Texture) {
        let (to, extent) = slot.texels(pool);
        encoder.copy_buffer_to_texture(self.rows(&self.start, slot), to, extent);
    }

    /// Makes room for [`put_aside`](Self::put_aside).
    pub(crate) fn make_aside(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        use wgpu::BufferUsages as Use;
        if self.aside.is_none() {
            let (size, usage) = (self.start.size(), Use::COPY_SRC | Use::COPY_DST);
            self.aside = Some(gpu.scoped("a stroke's buffers", || {
                let label = Some("brush aside");
                let about = wgpu::BufferDescriptor { label, size, usage, mapped_at_creation: false };
                Ok(gpu.device.create_buffer(&about))
            })?);
        }
        Ok(())
    }

    /// Keeps a slot's texels as they are now, until [`put_back`](Self::put_back).
    pub(crate) fn put_aside(&self, encoder: &mut wgpu::CommandEncoder, slot: &StrokeSlot, pool: &wgpu::Texture) {
        if let Some(aside) = &self.aside {
            let (from, extent) = slot.texels(pool);
            encoder.copy_texture_to_buffer(from, self.rows(aside, slot), extent);
        }
    }

    /// Gives a slot back what was put aside.
    pub(crate) fn put_back(&self, encoder: &mut wgpu::CommandEncoder, slot: &StrokeSlot, pool: &wgpu::Texture) {
        if let Some(aside) = &self.aside {
            let (to, extent) = slot.texels(pool);
            encoder.copy_buffer_to_texture(self.rows(aside, slot), to, extent);
        }
    }

    /// Where the part of a slot that is kept lies in a buffer of as many slots.
    fn rows<'a>(&self, buffer: &'a wgpu::Buffer, slot: &StrokeSlot) -> wgpu::TexelCopyBufferInfo<'a> {
        let beside = self.variant.slots_per_row();
        let [x, y, z] = slot.kept.lo;
        let pitch = u64::from(slot.place / beside) * SLOT_PITCH_BYTES + u64::from((z * SLOT + y) * ROW_PITCH_BYTES);
        let offset = pitch + u64::from(slot.place % beside * self.variant.row_bytes() + x * self.variant.bytes());
        rows(buffer, offset, SLOT)
    }
}

impl StrokeSlot {
    /// The part of it that is kept, in the pool.
    fn texels<'a>(&self, pool: &'a wgpu::Texture) -> (wgpu::TexelCopyTextureInfo<'a>, wgpu::Extent3d) {
        let [width, height, depth_or_array_layers] = self.kept.size();
        let first = std::array::from_fn(|a| self.texel[a] + self.kept.lo[a]);
        (at(pool, first), wgpu::Extent3d { width, height, depth_or_array_layers })
    }
}

/// Rows at the copies' pitch.
pub(crate) fn rows(buffer: &wgpu::Buffer, offset: u64, rows_per_image: u32) -> wgpu::TexelCopyBufferInfo<'_> {
    wgpu::TexelCopyBufferInfo {
        buffer,
        layout: wgpu::TexelCopyBufferLayout {
            offset,
            bytes_per_row: Some(ROW_PITCH_BYTES),
            rows_per_image: Some(rows_per_image),
        },
    }
}

/// A box of a texture that starts at a texel.
pub(crate) fn at(texture: &wgpu::Texture, [x, y, z]: [u32; 3]) -> wgpu::TexelCopyTextureInfo<'_> {
    wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x, y, z }, ..texture.as_image_copy() }
}
