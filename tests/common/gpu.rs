//! A device for tests, and a kernel that samples fields at given points through `burin::field`.

use burin::gpu::device::shader;
use burin::gpu::{FieldPools, Gpu};
use std::sync::OnceLock;

/// Says that a test cannot run for want of something, and what to `install`. That fails, unless `BURIN_WITHOUT_GPU=1` says that it
/// is known: a suite that passes because nothing ran tells nobody anything.
///
/// # Panics
/// Where the variable does not say so.
pub fn missing(reason: impl std::fmt::Display, install: &str) {
    let known = std::env::var("BURIN_WITHOUT_GPU").is_ok_and(|v| v == "1");
    assert!(known, "{reason}. Install {install}; or set BURIN_WITHOUT_GPU=1, which leaves out the tests that need it");
    println!("skipped: {reason}");
}

/// The device, or `None` where there is none and that is known: such tests end early. No test asks in another way.
///
/// # Panics
/// Where there is none and `BURIN_WITHOUT_GPU=1` does not say so.
pub fn gpu() -> Option<Gpu> {
    static GPU: OnceLock<Result<Gpu, String>> = OnceLock::new();
    let gpu = GPU.get_or_init(|| Gpu::headless().map_err(|e| e.to_string()));
    let install = "a Vulkan loader and a driver, of the graphics card or Mesa's software one (Debian: libvulkan1, mesa-vulkan-drivers)";
    gpu.as_ref().map_err(|reason| missing(reason, install)).ok().cloned()
}

/// What a field's texel is at a place, as the shader sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Sampled {
    pub density: f32,
    pub selection: f32,
    pub label: u32,
    pub level: u32,
    pub colour: [f32; 4],
    pub skip: [u32; 4],
}

const SAMPLER: &str = "
#import burin::field::{brick_of, density_page, density_at, selection_page, selection_at, colour_page, colour_at, label_at,
    cell_of, skip_at}
struct Sampled { density: f32, selection: f32, label: u32, level: u32, colour: vec4<f32>, skip: vec4<u32> }
@group(0) @binding(0) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> out: array<Sampled>;
@group(0) @binding(2) var<storage, read> maps: array<vec4<u32>, 3>;
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= arrayLength(&points)) { return; }
    let p = points[id.x].xyz;
    let brick = brick_of(p);
    let page = density_page(brick);
    let cell = cell_of(p);
    out[id.x].density = density_at(page, p);
    out[id.x].level = page.level;
    out[id.x].selection = selection_at(selection_page(brick), p);
    out[id.x].colour = colour_at(colour_page(brick), p);
    out[id.x].label = label_at(p);
    out[id.x].skip = vec4<u32>(skip_at(maps[0].xyz, cell), skip_at(maps[1].xyz, cell), skip_at(maps[2].xyz, cell), 0u);
}";

/// Samples all fields at places in voxels.
pub fn sample(gpu: &Gpu, pools: &FieldPools, points: &[[f32; 3]]) -> Vec<Sampled> {
    sample_maps(gpu, pools, &[], points)
}

/// The same with up to three maps of empty space that begin at these cells.
pub fn sample_maps(gpu: &Gpu, pools: &FieldPools, maps: &[[u32; 3]], points: &[[f32; 3]]) -> Vec<Sampled> {
    use wgpu::util::DeviceExt;
    let (device, queue) = gpu.raw();
    let module = shader::compile_source(gpu, "sampler.wgsl", SAMPLER, &pools.defs(gpu)).unwrap();
    let padded: Vec<[f32; 4]> = points.iter().map(|p| [p[0], p[1], p[2], 0.0]).collect();
    let input = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::cast_slice(&padded),
        usage: wgpu::BufferUsages::STORAGE,
    });
    let mut firsts = [[0_u32; 4]; 3];
    firsts.iter_mut().zip(maps).for_each(|(first, map)| first[..3].copy_from_slice(map));
    let firsts = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::cast_slice(&firsts),
        usage: wgpu::BufferUsages::STORAGE,
    });
    // A sentinel that no field holds.
    let sentinel = vec![0xcd_u8; points.len() * size_of::<Sampled>()];
    let output = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: &sentinel,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
    });
    let read = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: sentinel.len() as u64,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let entry = |binding, read_only| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let own = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[entry(0, true), entry(1, false), entry(2, true)],
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(&own), Some(pools.layout())],
        immediate_size: 0,
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: Some(&layout),
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &own,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: input.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: output.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 2, resource: firsts.as_entire_binding() },
        ],
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.set_bind_group(1, pools.group(), &[]);
        pass.dispatch_workgroups(points.len().div_ceil(64) as u32, 1, 1);
    }
    encoder.copy_buffer_to_buffer(&output, 0, &read, 0, sentinel.len() as u64);
    queue.submit([encoder.finish()]);
    bytemuck::cast_slice(&gpu.read_buffer(&read, "samples").unwrap()).to_vec()
}
