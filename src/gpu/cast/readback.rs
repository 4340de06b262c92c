//! Pictures from the GPU to the host.

use crate::gpu::device::constants::FAR;
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::textures::Targets;
use crate::gpu::picture::image::Image;
use crate::gpu::picture::object_id::ObjectId;

/// Waits for the targets and takes them over; beside the picture, what the shaders say of each pixel's object.
pub(crate) fn image(gpu: &Gpu, targets: &Targets) -> Result<(Image, Vec<u32>), GpuError> {
    let [width, height] = targets.size;
    // Rows of copies are padded to 256 bytes.
    let pitch = |bytes: u32| (width * bytes).next_multiple_of(256);
    let parts = [(&targets.colour, 16), (&targets.depth, 4), (&targets.object, 4)];
    let total: u64 = parts.iter().map(|(_, bytes)| u64::from(pitch(*bytes)) * u64::from(height)).sum();
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("picture readback"),
        size: total,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder =
        gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("picture readback") });
    let mut offsets = Vec::new();
    let mut offset = 0;
    for (texture, bytes) in parts {
        offsets.push(offset as usize);
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout { offset, bytes_per_row: Some(pitch(bytes)), rows_per_image: None },
            },
            texture.size(),
        );
        offset += u64::from(pitch(bytes)) * u64::from(height);
    }
    gpu.queue.submit([encoder.finish()]);
    let bytes = gpu.read_buffer(&buffer, "a picture")?;
    let rows = |part: usize, size: u32| {
        let rows = bytes[offsets[part]..].chunks_exact(pitch(size) as usize).take(height as usize);
        rows.map(move |row| &row[..(width * size) as usize])
    };
    let count = (width * height) as usize;
    let mut image = Image {
        size: targets.size,
        colour: Vec::with_capacity(count),
        depth_mm: Vec::with_capacity(count),
        object: vec![ObjectId::NOTHING; count],
    };
    let mut codes = Vec::with_capacity(count);
    for row in rows(0, 16) {
        image.colour.extend(row.chunks_exact(16).map(bytemuck::pod_read_unaligned::<[f32; 4]>));
    }
    for row in rows(1, 4) {
        let depth = row.chunks_exact(4).map(bytemuck::pod_read_unaligned::<f32>);
        image.depth_mm.extend(depth.map(|d| if d < FAR { d } else { f32::INFINITY }));
    }
    for row in rows(2, 4) {
        codes.extend(row.chunks_exact(4).map(bytemuck::pod_read_unaligned::<u32>));
    }
    Ok((image, codes))
}
