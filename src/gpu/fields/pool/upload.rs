//! Texels of bricks on their way into slots.
//!
//! Owns the two ways: slot by slot, and all of a new texture at once, since a device clears a texture before its first
//! partial write. Staging memory is bounded in both.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::pool::slots::texels;
use crate::gpu::fields::pool::{FieldOf, Pool, extent};
use crate::gpu::fields::slot_key::SlotKey;
use crate::volume::{BrickKey, Field, Region, SLOT, SLOT_VOXELS, TexelFormat, VolumeId};
use rayon::prelude::*;

/// Bytes handed to the queue before it is told to start.
const BATCH_BYTES: usize = 32 << 20;
/// A new texture up to this size is written at once; a larger one would need as much memory again for its staging.
const WHOLE_BYTES: u64 = 128 << 20;

/// Texels of a brick and the slot they go to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Upload {
    pub(super) key: SlotKey,
    pub(super) slot: [u32; 3],
    /// Those of the slot, counted from the apron on.
    pub(super) part: Region,
}

impl Upload {
    /// All of a slot.
    pub(super) fn whole(key: SlotKey, slot: [u32; 3]) -> Self {
        Self { key, slot, part: Region { lo: [0; 3], end: [SLOT; 3] } }
    }
}

impl Pool {
    /// New texels for those of a volume's `slots` that are held.
    pub(crate) fn renew(
        &mut self,
        gpu: &Gpu,
        (volume, field): (VolumeId, &Field),
        slots: &[(BrickKey, Region)],
    ) -> Result<(), GpuError> {
        let held = |(brick, region): &(BrickKey, Region)| {
            let part = region.in_slot(brick.index, field.dims(brick.level));
            let key = SlotKey::new(volume, *brick);
            self.held.get(&key).map(|h| Upload { key, slot: h.slot, part })
        };
        let uploads: Vec<_> = slots.iter().filter_map(held).collect();
        self.upload(gpu, &|of| (of == volume).then_some(field), &uploads)
    }

    pub(super) fn upload(&mut self, gpu: &Gpu, field_of: FieldOf<'_, '_>, uploads: &[Upload]) -> Result<(), GpuError> {
        if uploads.is_empty() {
            return Ok(());
        }
        let [width, height, depth] = texels(self.grid, self.is_in_place());
        let pitch = (width * self.format.bytes() as u32).next_multiple_of(256);
        let whole = u64::from(pitch) * u64::from(height) * u64::from(depth);
        let at_once = !self.written && whole <= WHOLE_BYTES.min(gpu.device.limits().max_buffer_size);
        if at_once {
            self.upload_whole(gpu, field_of, uploads, (pitch, whole))?;
        } else {
            self.upload_slots(gpu, field_of, uploads)?;
        }
        self.written = true;
        self.uploaded += uploads.len() as u64;
        for Upload { slot, part, .. } in uploads {
            let origin = self.origin(*slot);
            let at = |v: [u32; 3]| std::array::from_fn(|a| origin[a] + v[a]);
            self.wrote(Region { lo: at(part.lo), end: at(part.end) });
        }
        Ok(())
    }

    fn texels(&self, field_of: FieldOf<'_, '_>, uploads: &[Upload]) -> Result<Vec<Vec<u8>>, GpuError> {
        uploads
            .par_iter()
            .map(|Upload { key: SlotKey { volume, brick }, part, .. }| {
                let field = field_of(*volume).ok_or(GpuError::NoVolume { id: volume.0 })?;
                let widen = field.format() == TexelFormat::R16Unorm && self.format == TexelFormat::R32Float;
                let origin = brick.index.origin();
                let lo = std::array::from_fn(|a| i64::from(origin[a]) + i64::from(part.lo[a]) - 1);
                let texels = field.read(brick.level, lo, part.size())?;
                Ok(if widen { widened(&texels) } else { texels })
            })
            .collect()
    }

    fn upload_slots(&self, gpu: &Gpu, field_of: FieldOf<'_, '_>, uploads: &[Upload]) -> Result<(), GpuError> {
        let bytes = self.format.bytes();
        let batch = (BATCH_BYTES / (SLOT_VOXELS * bytes)).max(1);
        for (i, part) in uploads.chunks(batch).enumerate() {
            let texels = self.texels(field_of, part)?;
            if i > 0 {
                // The batch before is in place and its staging free again.
                gpu.wait()?;
            }
            gpu.scoped(&format!("bricks of {}", self.name), || {
                for (Upload { slot, part, .. }, texels) in part.iter().zip(&texels) {
                    let origin = self.origin(*slot);
                    let [x, y, z] = std::array::from_fn(|a| origin[a] + part.lo[a]);
                    let size = part.size();
                    gpu.queue.write_texture(
                        wgpu::TexelCopyTextureInfo {
                            origin: wgpu::Origin3d { x, y, z },
                            ..self.texture.as_image_copy()
                        },
                        texels,
                        wgpu::TexelCopyBufferLayout {
                            offset: 0,
                            bytes_per_row: Some(size[0] * bytes as u32),
                            rows_per_image: Some(size[1]),
                        },
                        extent(size),
                    );
                }
                gpu.queue.submit([]);
                Ok(())
            })?;
        }
        Ok(())
    }

    fn upload_whole(
        &self,
        gpu: &Gpu,
        field_of: FieldOf<'_, '_>,
        uploads: &[Upload],
        (pitch, whole): (u32, u64),
    ) -> Result<(), GpuError> {
        let bytes = self.format.bytes();
        let what = format!("bricks of {}", self.name);
        let buffer = gpu.scoped(&what, || {
            Ok(gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("pool staging"),
                size: whole,
                usage: wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: true,
            }))
        })?;
        {
            let mut view = buffer
                .get_mapped_range_mut(..)
                .map_err(|e| GpuError::Refused { what: what.clone(), reason: e.to_string() })?;
            let [_, height, _] = texels(self.grid, self.is_in_place());
            let row_bytes = SLOT as usize * bytes;
            for part in uploads.chunks((BATCH_BYTES / (SLOT_VOXELS * bytes)).max(1)) {
                for (Upload { slot, .. }, texels) in part.iter().zip(self.texels(field_of, part)?) {
                    let [x, y, z] = self.origin(*slot).map(|t| t as usize);
                    let rows = height as usize;
                    for (i, row) in texels.chunks_exact(row_bytes).enumerate() {
                        let (dy, dz) = (i % SLOT as usize, i / SLOT as usize);
                        let at = (y + dy + rows * (z + dz)) * pitch as usize + x * bytes;
                        view.slice(at..at + row_bytes).copy_from_slice(row);
                    }
                }
            }
        }
        gpu.scoped(&what, || {
            buffer.unmap();
            let mut encoder =
                gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("fill pool") });
            encoder.copy_buffer_to_texture(
                wgpu::TexelCopyBufferInfo {
                    buffer: &buffer,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(pitch),
                        rows_per_image: Some(self.texture.height()),
                    },
                },
                self.texture.as_image_copy(),
                self.texture.size(),
            );
            gpu.queue.submit([encoder.finish()]);
            Ok(())
        })
    }
}

/// 16-bit codes as the floats that a `r16unorm` texture would read.
fn widened(codes: &[u8]) -> Vec<u8> {
    codes.chunks_exact(2).flat_map(|t| (f32::from(u16::from_le_bytes([t[0], t[1]])) / 65_535.0).to_le_bytes()).collect()
}
