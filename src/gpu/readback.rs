//! Pictures from the GPU to the host.

use super::pass::{FAR, Targets};
use super::{Gpu, GpuError, Image};

/// Waits for the targets and takes them over; objects are still the shaders' codes.
pub(super) fn image(gpu: &Gpu, targets: &Targets) -> Result<Image, GpuError> {
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
    let words = |part: usize, size: u32| -> Vec<u32> {
        let mut words = Vec::with_capacity((width * height * size / 4) as usize);
        for row in bytes[offsets[part]..].chunks_exact(pitch(size) as usize).take(height as usize) {
            let row = row[..(width * size) as usize].chunks_exact(4);
            words.extend(row.map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]])));
        }
        words
    };
    let colour = words(0, 16).chunks_exact(4).map(|c| std::array::from_fn(|i| f32::from_bits(c[i]))).collect();
    let depth = |bits: u32| Some(f32::from_bits(bits)).filter(|d| *d < FAR).unwrap_or(f32::INFINITY);
    Ok(Image {
        size: targets.size,
        colour,
        depth_mm: words(1, 4).into_iter().map(depth).collect(),
        object: words(2, 4),
    })
}
