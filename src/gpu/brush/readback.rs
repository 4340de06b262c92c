//! What a stroke left in the pools' slots, back on the host.

use crate::gpu::brush::buffers::{StrokeBuffers, at, rows};
use crate::gpu::brush::kernel::Variant;
use crate::gpu::device::constants::ROW_PITCH_BYTES;
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::pools::FieldPools;
use crate::volume::{BRICK, BRICK_VOXELS, Brick, BrickIndex, Field};

/// Bricks of one copy, so that the buffer between stays small.
const BATCH: usize = 128;
/// Bytes of 32³ texels' rows at the copies' pitch.
const BRICK_PITCH_BYTES: u64 = (BRICK * BRICK * ROW_PITCH_BYTES) as u64;
const BRICK_EXTENT: wgpu::Extent3d = wgpu::Extent3d { width: BRICK, height: BRICK, depth_or_array_layers: BRICK };

/// The bricks in which a voxel of their own differs from the stroke's start, in order. Waits for the GPU.
pub(crate) fn changed(gpu: &Gpu, buffers: &[StrokeBuffers]) -> Result<Vec<BrickIndex>, GpuError> {
    let count: usize = buffers.iter().map(|b| b.bricks.len()).sum();
    if count == 0 {
        return Ok(Vec::new());
    }
    let flags = read(gpu, "a stroke's changes", count as u64 * 4, |encoder, buffer| {
        let mut offset = 0;
        for some in buffers.iter().filter(|b| !b.bricks.is_empty()) {
            let bytes = some.bricks.len() as u64 * 4;
            encoder.copy_buffer_to_buffer(&some.changed, 0, buffer, offset, bytes);
            offset += bytes;
        }
    })?;
    let bricks = buffers.iter().flat_map(|b| &b.bricks);
    let mut changed: Vec<_> =
        bricks.zip(flags.chunks_exact(4)).filter(|(_, flag)| flag.iter().any(|&b| b != 0)).map(|(b, _)| *b).collect();
    changed.sort_unstable();
    Ok(changed)
}

/// The texels of bricks in these slots, zero beyond the volume. Waits for the GPU.
pub(crate) fn bricks(
    gpu: &Gpu,
    pools: &FieldPools,
    field: &Field,
    wanted: &[(BrickIndex, [u32; 3])],
) -> Result<Vec<(BrickIndex, Brick)>, GpuError> {
    let mut out = Vec::with_capacity(wanted.len());
    for batch in wanted.chunks(BATCH) {
        let (Some(texture), Some(format)) = (pools.texture(field.kind()), pools.format(field.kind())) else {
            return Err(GpuError::Stroke("the pools hold no slots of the field"));
        };
        let variant = Variant::of(field.format(), format);
        let row = BRICK * variant.bytes();
        let beside = u64::from(ROW_PITCH_BYTES / row);
        let place = |i: usize| (i as u64 / beside) * BRICK_PITCH_BYTES + (i as u64 % beside) * u64::from(row);
        let size = (batch.len() as u64).div_ceil(beside) * BRICK_PITCH_BYTES;
        let texels = read(gpu, "painted bricks", size, |encoder, buffer| {
            for (i, (_, slot)) in batch.iter().enumerate() {
                let interior = slot.map(|s| s + 1);
                encoder.copy_texture_to_buffer(at(texture, interior), rows(buffer, place(i), BRICK), BRICK_EXTENT);
            }
        })?;
        for (i, (brick, _)) in batch.iter().enumerate() {
            out.push((*brick, unpack(&texels[place(i) as usize..], field, *brick, variant)));
        }
    }
    Ok(out)
}

/// Rows at the copies' pitch to a brick in the host's format.
fn unpack(texels: &[u8], field: &Field, brick: BrickIndex, variant: Variant) -> Brick {
    let bytes = field.format().bytes();
    let valid = field.valid(0, brick).map(|v| v as usize);
    let edge = BRICK as usize;
    let mut out = vec![0; BRICK_VOXELS * bytes];
    for z in 0..valid[2] {
        for y in 0..valid[1] {
            let row = &texels[(z * edge + y) * ROW_PITCH_BYTES as usize..][..valid[0] * variant.bytes() as usize];
            let to = &mut out[(z * edge + y) * edge * bytes..][..valid[0] * bytes];
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
    Brick::from_texels(out, bytes)
}

fn read(
    gpu: &Gpu,
    what: &str,
    bytes: u64,
    copy: impl FnOnce(&mut wgpu::CommandEncoder, &wgpu::Buffer),
) -> Result<Vec<u8>, GpuError> {
    let buffer = gpu.scoped(what, || {
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(what),
            size: bytes,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some(what) });
        copy(&mut encoder, &buffer);
        gpu.queue.submit([encoder.finish()]);
        Ok(buffer)
    })?;
    gpu.read_buffer(&buffer, what)
}
