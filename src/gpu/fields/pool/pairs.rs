//! Density that lies in place once more, a voxel and the next one along z in a texel: what software Vulkan reads faster.
//!
//! Its gathering of eight voxels is most of a picture; four pairs are as many voxels for less than half of the instructions. Owns
//! their texture and which boxes of it are to be made anew: from density's texels on the device, whoever wrote them, so that what
//! was painted shows in the next picture. Knows no volume, no brush and no camera.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::kernel::{Binding, Compute, Kernel};
use crate::gpu::device::shader::shader;
use crate::gpu::fields::pool::{Pool, extent, slots};
use crate::shared_struct;
use crate::volume::{Region, TexelFormat};

/// Texels of a workgroup along x, y and z.
const GROUP: [u32; 3] = [8, 8, 4];
/// Bytes of a pair.
const BYTES: u64 = 4;
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg16Unorm;
/// Pairs that are made at once.
const MOST_WORDS: u64 = 4 << 20;
/// So many boxes are kept apart; more become one.
const MOST_BOXES: usize = 64;
/// Bytes between boxes in the buffer that the kernel reads.
const STRIDE: u32 = 256;

shared_struct! {
    /// A box of texels that are made.
    pub(crate) struct PairsBox {
        /// First texel.
        pub lo: [u32; 3],
        /// Words between rows of what is made.
        pub pitch: u32,
        /// One past the last.
        pub end: [u32; 3],
        /// Place of density's last texel along z.
        pub last: u32,
    }
}

/// The kernel that makes them.
#[derive(Debug)]
pub(crate) struct PairsKernel(Kernel<Compute>);

impl PairsKernel {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let unfiltered = wgpu::TextureSampleType::Float { filterable: false };
        let density = Binding::Texture(wgpu::TextureViewDimension::D3, unfiltered);
        let bindings = [Binding::UniformAt(size_of::<PairsBox>()), density, Binding::Storage];
        Self(Kernel::new(gpu, shader!("fields/pairs.wgsl"), Compute("pair"), &bindings))
    }
}

/// Whether pictures on a device are faster by them.
fn serve(gpu: &Gpu) -> bool {
    gpu.is_software() && gpu.has_unorm16()
}

/// See the file's head.
#[derive(Debug)]
pub(crate) struct Pairs {
    pub(crate) texture: wgpu::Texture,
    /// Texels of density that are newer.
    stale: Vec<Region>,
}

impl Pairs {
    /// Those of a texture of density of this size, all still to be made.
    fn new(gpu: &Gpu, size: [u32; 3]) -> Result<Self, GpuError> {
        let texture = gpu.scoped("pairs of voxels", || {
            Ok(gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("pairs of voxels"),
                size: extent(size),
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: FORMAT,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            }))
        })?;
        Ok(Self { texture, stale: vec![Region { lo: [0; 3], end: size }] })
    }

    /// Texels of density in a box are others.
    fn wrote(&mut self, texels: Region) {
        let join = |a: &Region, b: &Region| Region {
            lo: std::array::from_fn(|i| a.lo[i].min(b.lo[i])),
            end: std::array::from_fn(|i| a.end[i].max(b.end[i])),
        };
        let mut texels = texels;
        // One box around two of them where that costs little, and always where there are too many.
        while let Some(i) = self.stale.iter().position(|other| {
            let all = join(other, &texels);
            self.stale.len() >= MOST_BOXES || 4 * count(&all) <= 5 * (count(other) + count(&texels))
        }) {
            texels = join(&self.stale.swap_remove(i), &texels);
        }
        self.stale.push(texels);
    }

    /// Makes what is stale.
    fn renew(&mut self, gpu: &Gpu, kernel: &mut PairsKernel, density: &wgpu::Texture) -> Result<(), GpuError> {
        if self.stale.is_empty() {
            return Ok(());
        }
        let pipeline = kernel.0.pipeline(gpu, &[], &[], &[])?;
        let size = [density.width(), density.height(), density.depth_or_array_layers()];
        let parts: Vec<Region> = self.stale.iter().flat_map(|texels| parts(texels, size)).collect();
        let mut jobs = vec![0; parts.len() * STRIDE as usize];
        for (job, part) in jobs.chunks_exact_mut(STRIDE as usize).zip(&parts) {
            let one = PairsBox { lo: part.lo, pitch: pitch(part), end: part.end, last: size[2] - 1 };
            job[..size_of::<PairsBox>()].copy_from_slice(bytemuck::bytes_of(&one));
        }
        let words = parts.iter().map(words).max().unwrap_or_default();
        gpu.scoped("pairs of voxels", || {
            let buffer = |label, size, usage| {
                let mapped_at_creation = false;
                gpu.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size,
                    usage,
                    mapped_at_creation,
                })
            };
            use wgpu::BufferUsages as Use;
            let places = buffer("boxes of pairs", jobs.len() as u64, Use::UNIFORM | Use::COPY_DST);
            let made = buffer("pairs on their way", words * BYTES, Use::STORAGE | Use::COPY_SRC);
            gpu.queue.write_buffer(&places, 0, &jobs);
            let view = density.create_view(&wgpu::TextureViewDescriptor::default());
            let size = std::num::NonZero::new(size_of::<PairsBox>() as u64);
            let resources = [
                wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer: &places, offset: 0, size }),
                wgpu::BindingResource::TextureView(&view),
                made.as_entire_binding(),
            ];
            let group = kernel.0.group(gpu, resources);
            let descriptor = wgpu::CommandEncoderDescriptor { label: Some("pairs of voxels") };
            let mut encoder = gpu.device.create_command_encoder(&descriptor);
            for (i, part) in (0..).zip(&parts) {
                {
                    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                        label: Some("pairs of voxels"),
                        timestamp_writes: gpu.compute_times("pairs"),
                    });
                    let size = part.size();
                    let [x, y, z] = std::array::from_fn(|a| size[a].div_ceil(GROUP[a]));
                    pass.set_pipeline(&pipeline);
                    pass.set_bind_group(0, group.as_ref(), &[i * STRIDE]);
                    pass.dispatch_workgroups(x, y, z);
                }
                let [x, y, z] = part.lo;
                encoder.copy_buffer_to_texture(
                    wgpu::TexelCopyBufferInfo {
                        buffer: &made,
                        layout: wgpu::TexelCopyBufferLayout {
                            offset: 0,
                            bytes_per_row: Some(pitch(part) * BYTES as u32),
                            rows_per_image: Some(part.size()[1]),
                        },
                    },
                    wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x, y, z }, ..self.texture.as_image_copy() },
                    extent(part.size()),
                );
            }
            gpu.queue.submit([encoder.finish()]);
            Ok(())
        })?;
        self.stale.clear();
        Ok(())
    }
}

/// Words between the rows of a part: whole 256 bytes, as copies want them.
fn pitch(part: &Region) -> u32 {
    part.size()[0].next_multiple_of(64)
}

fn words(part: &Region) -> u64 {
    let [_, height, depth] = part.size().map(u64::from);
    u64::from(pitch(part)) * height * depth
}

/// The pairs that hold a box of texels, in parts that are made at once.
fn parts(texels: &Region, size: [u32; 3]) -> Vec<Region> {
    let end: [u32; 3] = std::array::from_fn(|a| texels.end[a].min(size[a]));
    // A voxel is in the pair before it too.
    let lo = [texels.lo[0], texels.lo[1], texels.lo[2].saturating_sub(1)];
    let layer = words(&Region { lo, end: [end[0], end[1], lo[2] + 1] });
    let layers = (MOST_WORDS / layer.max(1)).max(1) as usize;
    let part = |z: u32| Region { lo: [lo[0], lo[1], z], end: [end[0], end[1], end[2].min(z + layers as u32)] };
    (lo[2]..end[2]).step_by(layers).map(part).collect()
}

fn count(texels: &Region) -> u64 {
    texels.size().map(u64::from).iter().product()
}

impl Pool {
    /// Texels of the texture were written.
    pub(crate) fn wrote(&mut self, texels: Region) {
        if let Some(pairs) = &mut self.pairs {
            pairs.wrote(texels);
        }
    }

    /// Has pairs of what lies in place, as it is now; none where a device is no faster by them, or where they do not fit into the
    /// budget, or into memory, besides what they are made of.
    pub(crate) fn pair(&mut self, gpu: &Gpu, kernel: &mut PairsKernel, budget_bytes: u64) -> Result<(), GpuError> {
        if !self.is_in_place() || self.held_count() == 0 || self.unpaired {
            return Ok(());
        }
        if self.pairs.is_none() {
            let size = slots::texels(self.grid, true);
            let bytes = size.map(u64::from).iter().product::<u64>() * BYTES;
            let layers = gpu.device.limits().max_texture_array_layers;
            let fits = bytes <= slots::MOST_BYTES && self.bytes() + bytes <= budget_bytes && size[2] <= layers;
            let wanted = serve(gpu) && self.format == TexelFormat::R16Unorm && fits;
            match wanted.then(|| Pairs::new(gpu, size)).transpose() {
                Ok(Some(made)) => (self.pairs, self.replaced) = (Some(made), true),
                Ok(None) | Err(GpuError::OutOfMemory { .. }) => self.unpaired = true,
                Err(error) => return Err(error),
            }
        }
        let Self { pairs: Some(pairs), texture, .. } = self else { return Ok(()) };
        pairs.renew(gpu, kernel, texture)
    }
}
