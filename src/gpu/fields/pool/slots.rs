//! How slots lie in a pool's texture: a grid of them apart, or in place, each where its brick is in the volume.
//!
//! Owns the sizes of grids and textures. Knows no bricks.

use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::pool::extent;
use crate::volume::{BRICK, SLOT, SLOT_VOXELS, TexelFormat};

/// Slots along an axis: a slot's place is a byte of a page, and textures end at 2048 texels on many adapters.
const MOST_ALONG: u32 = 60;
/// Larger textures fail on common drivers.
pub(super) const MOST_BYTES: u64 = (2 << 30) - 1;

fn wgpu_format(format: TexelFormat) -> wgpu::TextureFormat {
    match format {
        TexelFormat::R16Unorm => wgpu::TextureFormat::R16Unorm,
        TexelFormat::R32Float => wgpu::TextureFormat::R32Float,
        TexelFormat::Rgba8Unorm => wgpu::TextureFormat::Rgba8Unorm,
        TexelFormat::R8Unorm => wgpu::TextureFormat::R8Unorm,
        TexelFormat::R16Uint => wgpu::TextureFormat::R16Uint,
    }
}

pub(super) fn places([nx, ny, nz]: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

/// The grid of the most slots that are at most `slots`, of those the nearest to a cube.
fn largest_grid(slots: u64, along: u32) -> [u32; 3] {
    let mut best = (0, 0, [1; 3]);
    for a in 1..=along {
        for b in a..=along {
            let c = (slots / (u64::from(a) * u64::from(b))).min(u64::from(along)) as u32;
            if c >= b {
                best = best.max((a * b * c, u32::MAX - (c - a), [a, b, c]));
            }
        }
    }
    // Fewer slots than any such box: a row.
    if best.0 == 0 { [1, 1, slots.clamp(1, u64::from(along)) as u32] } else { best.2 }
}

/// A grid of at least `slots` places, if `limit` has as many, that contains `old`; the shortest axis grows first.
pub(super) fn grow_grid(old: [u32; 3], slots: usize, limit: [u32; 3]) -> [u32; 3] {
    let mut grid = old;
    while grid.iter().map(|&n| n as usize).product::<usize>() < slots {
        let Some(axis) = (0..3).filter(|&a| grid[a] < limit[a]).min_by_key(|&a| grid[a]) else { break };
        grid[axis] += 1;
    }
    grid
}

/// Bytes of a slot.
pub(super) fn bytes(format: TexelFormat) -> u64 {
    (SLOT_VOXELS * format.bytes()) as u64
}

/// The grid of slots that lie apart within a budget.
pub(super) fn limit(gpu: &Gpu, format: TexelFormat, budget_bytes: u64) -> [u32; 3] {
    let along = (gpu.device.limits().max_texture_dimension_3d / SLOT).min(MOST_ALONG);
    largest_grid((budget_bytes.min(MOST_BYTES) / bytes(format)).max(1), along)
}

/// Texels along each axis of a grid of slots.
pub(super) fn texels(grid: [u32; 3], in_place: bool) -> [u32; 3] {
    grid.map(|n| if in_place { n * BRICK + SLOT - BRICK } else { n * SLOT })
}

pub(super) fn slots_texture(gpu: &Gpu, name: &str, format: TexelFormat, size: [u32; 3]) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(&format!("{name} pool")),
        size: extent(size),
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D3,
        format: wgpu_format(format),
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}
