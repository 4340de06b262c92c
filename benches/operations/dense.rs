//! A plain ray caster over one dense texture of the whole head: what bricks, bodies and painted fields are measured against.
//!
//! The same lattice, table, light and distances to occupied cells as the program's caster, nothing else; the pictures must agree.

use super::head::{Failure, Volume, transfer};
use burin::gpu::{Frame, Gpu};
use burin::math::{DVec2, DVec3};
use wgpu::util::DeviceExt;

/// Voxels along an edge of a cell.
const CELL: usize = 4;
/// Greatest distance kept, in cells.
const FARTHEST: u8 = 15;

pub struct Dense {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipelines: [wgpu::RenderPipeline; 2],
    group: wgpu::BindGroup,
    view: wgpu::Buffer,
    target: wgpu::Texture,
    dims: [u32; 3],
    /// Value of texel 1.
    hi: f64,
}

impl Dense {
    /// Uploads a volume whose values begin at 0.
    pub fn new(gpu: &Gpu, volume: &Volume, size: [u32; 2]) -> Result<Self, Failure> {
        let (device, queue) = gpu.raw();
        let dims = volume.grid.dims;
        let codes = volume.density.read(0, [0; 3], dims)?;
        let cells = dims.map(|n| n.div_ceil(CELL as u32));
        let map = *volume.density.map();
        let visible = (transfer().opacity.iter().filter(|p| p.1 == 0.0).map(|p| p.0).fold(0.0, f64::max) - map.lo)
            * map.codes_per_unit;
        let distances = distances(bytemuck::cast_slice(&codes), dims.map(|n| n as usize), visible);
        let texture = |label, [width, height, depth_or_array_layers]: [u32; 3], dimension, format, bytes: &[u8]| {
            let usage = wgpu::TextureUsages::TEXTURE_BINDING;
            let size = wgpu::Extent3d { width, height, depth_or_array_layers };
            device.create_texture_with_data(
                queue,
                &wgpu::TextureDescriptor {
                    label: Some(label),
                    size,
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension,
                    format,
                    usage,
                    view_formats: &[],
                },
                wgpu::util::TextureDataOrder::LayerMajor,
                bytes,
            )
        };
        let (d2, d3) = (wgpu::TextureDimension::D2, wgpu::TextureDimension::D3);
        let table = transfer().table(1.0);
        let textures = [
            texture("dense density", dims, d3, wgpu::TextureFormat::R16Unorm, &codes),
            texture("dense skip", cells, d3, wgpu::TextureFormat::R8Uint, &distances),
            texture(
                "dense table",
                [table.len() as u32, 1, 1],
                d2,
                wgpu::TextureFormat::Rgba32Float,
                bytemuck::cast_slice(&table),
            ),
        ];
        let target = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("dense picture"),
            size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: d2,
            format: wgpu::TextureFormat::Rgba32Float,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let module = device.create_shader_module(wgpu::include_wgsl!("dense.wgsl"));
        let seen = |sample_type, view_dimension| wgpu::BindingType::Texture {
            sample_type,
            view_dimension,
            multisampled: false,
        };
        let kinds = [
            wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Uniform,
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            seen(wgpu::TextureSampleType::Float { filterable: true }, wgpu::TextureViewDimension::D3),
            seen(wgpu::TextureSampleType::Uint, wgpu::TextureViewDimension::D3),
            seen(wgpu::TextureSampleType::Float { filterable: false }, wgpu::TextureViewDimension::D2),
            wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        ];
        let visibility = wgpu::ShaderStages::FRAGMENT;
        let entries: Vec<_> = (0..)
            .zip(kinds)
            .map(|(binding, ty)| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None })
            .collect();
        let layout = device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("dense"), entries: &entries });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("dense"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipelines = [0.0, 1.0].map(|lit| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("dense"),
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("cover"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("march"),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: &[("LIT", lit)],
                        ..Default::default()
                    },
                    targets: &[Some(target.format().into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let view = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("dense view"),
            contents: &[0; 80],
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        });
        let views = textures.map(|t| t.create_view(&Default::default()));
        let mut entries = vec![wgpu::BindGroupEntry { binding: 0, resource: view.as_entire_binding() }];
        entries.extend(
            views
                .iter()
                .zip(1..)
                .map(|(v, binding)| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(v) }),
        );
        entries.push(wgpu::BindGroupEntry { binding: 4, resource: wgpu::BindingResource::Sampler(&sampler) });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("dense"),
            layout: &layout,
            entries: &entries,
        });
        Ok(Self { device: device.clone(), queue: queue.clone(), pipelines, group, view, target, dims, hi: map.hi() })
    }

    /// Draws a frame's camera with or without light and reads the picture back.
    pub fn image(&self, gpu: &Gpu, frame: &Frame) -> Result<Vec<[f32; 4]>, Failure> {
        let [width, height] = frame.size;
        let mut words = [[0.0_f32; 4]; 5];
        let mut set = |row: usize, v: DVec3, w: f64| words[row] = [v.x as f32, v.y as f32, v.z as f32, w as f32];
        // A ray before it is given length 1 is linear in the pixel; a unit ray over its forward part is that.
        let forward = frame.camera.forward();
        let through = |x: f64, y: f64| {
            let ray = frame.camera.ray(DVec2::new(x, y), frame.size).dir;
            ray / ray.dot(forward)
        };
        let corner = through(0.0, 0.0);
        let (_, hi) = frame.transfer.domain();
        set(0, frame.camera.eye, self.hi / hi * (frame.transfer.table(1.0).len() - 1) as f64);
        set(1, corner, 0.0);
        set(2, through(1.0, 0.0) - corner, 0.0);
        set(3, through(0.0, 1.0) - corner, 0.0);
        set(4, DVec3::from_array(self.dims.map(f64::from)), 0.0);
        self.queue.write_buffer(&self.view, 0, bytemuck::cast_slice(&words));
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("dense readback"),
            size: u64::from(width * height) * 16,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        {
            let view = self.target.create_view(&Default::default());
            let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store };
            let attachment =
                wgpu::RenderPassColorAttachment { view: &view, depth_slice: None, resolve_target: None, ops };
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(attachment)],
                ..Default::default()
            });
            pass.set_pipeline(&self.pipelines[usize::from(frame.lighting.is_some())]);
            pass.set_bind_group(0, &self.group, &[]);
            pass.draw(0..3, 0..1);
        }
        encoder.copy_texture_to_buffer(
            self.target.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(width * 16),
                    rows_per_image: None,
                },
            },
            self.target.size(),
        );
        self.queue.submit([encoder.finish()]);
        Ok(bytemuck::cast_slice(&gpu.read_buffer(&buffer, "the dense picture")?).to_vec())
    }
}

/// Per cell the distance (largest of the axes) to the next cell in which a sample may be above the code `visible`.
fn distances(codes: &[u16], dims: [usize; 3], visible: f64) -> Vec<u8> {
    let cells = dims.map(|n| n.div_ceil(CELL));
    let at = |c: [usize; 3]| c[0] + cells[0] * (c[1] + cells[1] * c[2]);
    let mut distance = vec![FARTHEST; cells.iter().product()];
    for (i, &code) in codes.iter().enumerate() {
        if f64::from(code) > visible {
            let p = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
            // A voxel is a tap of samples up to one voxel away.
            let lo = p.map(|x| x.saturating_sub(1) / CELL);
            let hi: [usize; 3] = std::array::from_fn(|a| ((p[a] + 1) / CELL).min(cells[a] - 1));
            for z in lo[2]..=hi[2] {
                for y in lo[1]..=hi[1] {
                    for x in lo[0]..=hi[0] {
                        distance[at([x, y, z])] = 0;
                    }
                }
            }
        }
    }
    // The largest of three axes separates: one axis after another, forwards and backwards, grows a box by one cell a round.
    for round in 1..FARTHEST {
        let mut grown = distance.clone();
        for axis in 0..3 {
            let before = grown.clone();
            for (i, d) in grown.iter_mut().enumerate() {
                let stride = [1, cells[0], cells[0] * cells[1]][axis];
                let place = i / stride % cells[axis];
                let near = |there: bool, j: usize| there && before[j] < round;
                if *d >= round && (near(place > 0, i.wrapping_sub(stride)) || near(place + 1 < cells[axis], i + stride))
                {
                    // Reached in this round: anything below the next one marks it for the other axes.
                    *d = round - 1;
                }
            }
        }
        for (d, g) in distance.iter_mut().zip(grown) {
            if *d >= round && g < round {
                *d = round;
            }
        }
    }
    distance
}
