//! What a stroke left in the pools' slots, back on the host.
//!
//! Owns [`Answers`], the buffer on the way. Reads no more of a slot than the stroke may have changed; the rest of a brick is the
//! field's. Knows no dabs.

use crate::gpu::brush::buffers::{StrokeBuffers, StrokeSlot, at, rows};
use crate::gpu::brush::kernel::Variant;
use crate::gpu::device::constants::ROW_PITCH_BYTES;
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::pools::FieldPools;
use crate::volume::{BRICK, Brick, BrickIndex, BrickKey, Field, FieldKey, Region};
use std::collections::HashSet;

/// Bricks of one copy, so that the buffer between stays small.
const BATCH: usize = 128;

/// A slot of a brick of the stroke.
pub(crate) type Touched<'a> = (BrickIndex, &'a StrokeSlot);

/// A buffer that is kept: a new one would be cleared first, which costs as much as what is copied into it.
#[derive(Debug, Default)]
pub(crate) struct Answers(Option<wgpu::Buffer>);

impl Answers {
    /// The bricks of which a voxel of their own differs from the stroke's start, in order. Waits for the GPU.
    pub(crate) fn changed(
        &mut self,
        gpu: &Gpu,
        pools: &FieldPools,
        (key, field): (FieldKey, &Field),
        buffers: &[StrokeBuffers],
        mut touched: Vec<Touched<'_>>,
    ) -> Result<Vec<(BrickIndex, Brick)>, GpuError> {
        touched.sort_unstable_by_key(|(brick, _)| *brick);
        if touched.len() > BATCH {
            // Of many perhaps few changed.
            let flags = Flags(buffers);
            let changed = self.read(gpu, flags.bytes(), |e, to| flags.copy(e, to), |bytes| flags.changed(bytes))?;
            touched.retain(|(brick, _)| changed.contains(brick));
            return self.bricks(gpu, pools, (key, field), &touched, &Flags(&[]));
        }
        self.bricks(gpu, pools, (key, field), &touched, &Flags(buffers))
    }

    /// Bricks as these slots show them, zero beyond the volume; of those that `flags` speak of only the changed ones. Waits for the
    /// GPU.
    pub(crate) fn bricks(
        &mut self,
        gpu: &Gpu,
        pools: &FieldPools,
        (key, field): (FieldKey, &Field),
        wanted: &[Touched<'_>],
        flags: &Flags<'_>,
    ) -> Result<Vec<(BrickIndex, Brick)>, GpuError> {
        let mut out = Vec::with_capacity(wanted.len());
        for batch in wanted.chunks(BATCH) {
            let (Some(texture), Some(format)) = (pools.texture(key), pools.format(key)) else {
                return Err(GpuError::Stroke("the pools hold no slots of the field"));
            };
            let variant = Variant::of(field.format(), format);
            let mut columns = Columns::new(variant, flags.bytes());
            let boxes: Vec<_> = batch
                .iter()
                .filter_map(|(brick, slot)| Some((*brick, slot, own(slot)?)))
                .map(|(brick, slot, own)| (brick, slot, own, columns.place(&own)))
                .collect();
            let copy = |encoder: &mut wgpu::CommandEncoder, to: &wgpu::Buffer| {
                flags.copy(encoder, to);
                for (_, slot, own, offset) in &boxes {
                    let first = std::array::from_fn(|a| slot.texel[a] + 1 + own.lo[a]);
                    let [width, height, depth_or_array_layers] = own.size();
                    let extent = wgpu::Extent3d { width, height, depth_or_array_layers };
                    encoder.copy_texture_to_buffer(at(texture, first), rows(to, *offset, height), extent);
                }
            };
            let look = |bytes: &[u8]| {
                let changed = flags.changed(bytes);
                let wanted = boxes.iter().filter(|(brick, ..)| flags.0.is_empty() || changed.contains(brick));
                wanted
                    .map(|(brick, _, own, offset)| {
                        Ok((*brick, unpack(&bytes[*offset as usize..], field, *brick, own, variant)?))
                    })
                    .collect::<Result<Vec<_>, GpuError>>()
            };
            out.extend(self.read(gpu, columns.bytes(), copy, look)??);
        }
        Ok(out)
    }

    fn read<T>(
        &mut self,
        gpu: &Gpu,
        bytes: u64,
        copy: impl FnOnce(&mut wgpu::CommandEncoder, &wgpu::Buffer),
        look: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, GpuError> {
        let what = "painted bricks";
        let held = self.0.take().filter(|held| held.size() >= bytes);
        let buffer = gpu.scoped(what, || {
            let buffer = held.unwrap_or_else(|| {
                gpu.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(what),
                    size: bytes.next_power_of_two(),
                    usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                    mapped_at_creation: false,
                })
            });
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(what) });
            copy(&mut encoder, &buffer);
            gpu.queue.submit([encoder.finish()]);
            Ok(buffer)
        })?;
        let seen = gpu.look_into(&buffer, bytes, what, look)?;
        self.0 = Some(buffer);
        Ok(seen)
    }
}

/// Which of the slots of these buffers changed, one word a slot, at an answer's beginning.
pub(crate) struct Flags<'a>(pub(crate) &'a [StrokeBuffers]);

impl Flags<'_> {
    fn bytes(&self) -> u64 {
        self.0.iter().map(|b| b.bricks.len() as u64 * 4).sum()
    }

    fn copy(&self, encoder: &mut wgpu::CommandEncoder, to: &wgpu::Buffer) {
        let mut offset = 0;
        for buffers in self.0.iter().filter(|b| !b.bricks.is_empty()) {
            let bytes = buffers.bricks.len() as u64 * 4;
            encoder.copy_buffer_to_buffer(&buffers.changed, 0, to, offset, bytes);
            offset += bytes;
        }
    }

    fn changed(&self, bytes: &[u8]) -> HashSet<BrickIndex> {
        let bricks = self.0.iter().flat_map(|b| &b.bricks).zip(bytes.chunks_exact(4));
        bricks.filter(|(_, flag)| flag.iter().any(|&b| b != 0)).map(|(brick, _)| *brick).collect()
    }
}

/// What of a slot's kept texels is its brick's own, counted from the brick's first voxel.
fn own(slot: &StrokeSlot) -> Option<Region> {
    let Region { lo, end } = slot.kept;
    let own = Region { lo: lo.map(|v| v.saturating_sub(1)), end: end.map(|v| v.saturating_sub(1).min(BRICK)) };
    (0..3).all(|a| own.lo[a] < own.end[a]).then_some(own)
}

/// Boxes of texels side by side in rows at the copies' pitch, each in a column as wide as a brick.
struct Columns {
    variant: Variant,
    /// Rows that each has.
    rows: Vec<u64>,
    first: u64,
}

impl Columns {
    /// None yet, from so many bytes on.
    fn new(variant: Variant, bytes: u64) -> Self {
        let count = ROW_PITCH_BYTES / (BRICK * variant.bytes());
        Self { variant, rows: vec![0; count as usize], first: bytes.next_multiple_of(u64::from(ROW_PITCH_BYTES)) }
    }

    /// Where a box goes: the least filled column.
    fn place(&mut self, own: &Region) -> u64 {
        let [_, height, depth] = own.size();
        let (column, rows) =
            (0_u64..).zip(&mut self.rows).min_by_key(|(_, rows)| **rows).unwrap_or((0, &mut self.first));
        let offset = *rows * u64::from(ROW_PITCH_BYTES) + column * u64::from(BRICK * self.variant.bytes());
        *rows += u64::from(height * depth);
        self.first + offset
    }

    /// Bytes of all.
    fn bytes(&self) -> u64 {
        self.first + self.rows.iter().max().copied().unwrap_or(0) * u64::from(ROW_PITCH_BYTES)
    }
}

/// A brick in the host's format: a box of rows at the copies' pitch, and around it what the field has.
fn unpack(texels: &[u8], field: &Field, brick: BrickIndex, own: &Region, variant: Variant) -> Result<Brick, GpuError> {
    let bytes = field.format().bytes();
    let (valid, size) = (field.valid(0, brick), own.size());
    let whole = own.lo == [0; 3] && (0..3).all(|a| own.end[a] >= valid[a]);
    let key = BrickKey { level: 0, index: brick };
    let before = if whole { Brick::Uniform([0; 4]) } else { field.brick(key)? };
    let width = own.end[0].min(valid[0]).saturating_sub(own.lo[0]) as usize;
    Ok(before.edited(bytes, |out| {
        for z in own.lo[2]..own.end[2].min(valid[2]) {
            for y in own.lo[1]..own.end[1].min(valid[1]) {
                let row = (z - own.lo[2]) * size[1] + y - own.lo[1];
                let row = &texels[(row * ROW_PITCH_BYTES) as usize..][..width * variant.bytes() as usize];
                let to = &mut out[(own.lo[0] + BRICK * (y + BRICK * z)) as usize * bytes..][..width * bytes];
                if variant == Variant::CodesInFloats {
                    for (to, from) in to.chunks_exact_mut(2).zip(row.chunks_exact(4)) {
                        let value = f32::from_le_bytes([from[0], from[1], from[2], from[3]]);
                        to.copy_from_slice(&((value * 65_535.0).round() as u16).to_le_bytes());
                    }
                } else {
                    to.copy_from_slice(row);
                }
            }
        }
    }))
}
