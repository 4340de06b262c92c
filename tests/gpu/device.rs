//! The device's failures are answers.

use crate::common::gpu::{gpu, sample};
use crate::common::volumes::*;
use burin::gpu::{FieldPools, Gpu, GpuError, SliceCut};
use burin::math::DVec3;
use burin::volume::*;

#[test]
fn a_lost_device_is_an_answer_and_everything_can_be_made_again() {
    if gpu().is_none() {
        return;
    }
    let gpu = Gpu::headless().unwrap();
    let grid = unit_grid([40, 40, 40]);
    let density = density_u16(grid, |v| (v[0] * 100 + v[1]) as u16);
    let blank = [FieldKind::Colour, FieldKind::Selection, FieldKind::Labels].map(|kind| Field::blank(kind, &grid));
    let fields = one_volume(&grid, &density, &blank[0], &blank[1], &blank[2]);
    let frame = frame(&grid, ramp(-1.0, 4000.0), DVec3::NEG_Y, [32, 32]);
    let mut pools = FieldPools::new(&gpu, &grid, &density, 16 << 20).unwrap();
    pools.make_resident(&gpu, &fields, &frame).unwrap();
    let before = sample(&gpu, &pools, &[[20.0, 7.0, 3.0]]);
    assert!(!gpu.lost());
    gpu.raw().0.destroy();
    let _ = gpu.raw().0.poll(wgpu::PollType::Poll);
    assert!(gpu.lost());
    let error =
        pools.make_slice_resident(&gpu, &fields, VolumeId::FIRST, SliceCut::Row { axis: 0, index: 3 }).unwrap_err();
    assert!(matches!(error, GpuError::Lost { .. }), "{error}");
    assert!(matches!(FieldPools::new(&gpu, &grid, &density, 16 << 20), Err(GpuError::Lost { .. })));
    let gpu = Gpu::headless().unwrap();
    let mut pools = FieldPools::new(&gpu, &grid, &density, 16 << 20).unwrap();
    pools.make_resident(&gpu, &fields, &frame).unwrap();
    assert_eq!(sample(&gpu, &pools, &[[20.0, 7.0, 3.0]]), before);
}

#[test]
fn no_memory_and_bad_calls_are_answers_and_the_device_goes_on() {
    let Some(gpu) = gpu() else { return };
    let side = gpu.raw().0.limits().max_texture_dimension_3d.min(2048);
    let texture = |width: u32, what: &str| {
        gpu.scoped(what, || {
            Ok(gpu.raw().0.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width, height: side, depth_or_array_layers: side },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D3,
                format: wgpu::TextureFormat::R32Float,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            }))
        })
    };
    let error = texture(0, "a texture of nothing").unwrap_err();
    assert!(matches!(&error, GpuError::Refused { what, .. } if what == "a texture of nothing"), "{error}");
    // 32 GiB: beyond the machines that run this; where it does fit there is nothing to see.
    if let Err(error) = texture(side, "a texture of everything") {
        assert!(matches!(&error, GpuError::OutOfMemory { .. } | GpuError::Refused { .. }), "{error}");
        assert!(error.to_string().contains("a texture of everything"), "{error}");
    }
    let small = gpu.scoped("a buffer", || {
        Ok(gpu.raw().0.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: 16,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        }))
    });
    assert_eq!(gpu.read_buffer(&small.unwrap(), "a buffer").unwrap(), [0; 16]);
    let words = gpu.describe();
    let density = if gpu.has_unorm16() { ", 16-bit density" } else { "no 16-bit density" };
    assert!(words.contains("Vulkan") || words.contains("Metal") || words.contains("Dx12"), "{words}");
    assert!(words.contains(density), "{words}");
}

#[test]
fn no_adapter_says_what_to_install() {
    let text = GpuError::NoAdapter { reason: "none".into() }.to_string();
    assert!(text.contains("mesa-vulkan-drivers") && text.contains("none"), "{text}");
}

#[test]
fn an_adapter_is_chosen_by_what_it_is_or_by_part_of_its_name() {
    use burin::gpu::AdapterChoice;
    let info = |name: &str, device_type| wgpu::AdapterInfo {
        name: name.into(),
        ..wgpu::AdapterInfo::new(device_type, wgpu::Backend::Vulkan)
    };
    let software = info("llvmpipe (LLVM 15.0.6, 256 bits)", wgpu::DeviceType::Cpu);
    let small = info("Intel(R) UHD Graphics", wgpu::DeviceType::IntegratedGpu);
    let large = info("NVIDIA H100", wgpu::DeviceType::DiscreteGpu);
    let all = [software.clone(), small, large];
    let choice = AdapterChoice::from_words;
    assert_eq!(choice("hardware").among(&all), Ok(1));
    assert_eq!((choice("h100").among(&all), choice(" NVIDIA ").among(&all)), (Ok(2), Ok(2)));
    assert_eq!((choice("llvm").among(&all), choice("").among(&all)), (Ok(0), Ok(0)));
    let error = choice("hardware").among(&[software]).unwrap_err();
    assert!(error.contains("a graphics card expected") && error.contains("llvmpipe"), "{error}");
    assert!(choice("radeon").among(&all).unwrap_err().contains("NVIDIA H100"));
    assert!(choice("").among(&[]).unwrap_err().contains("found none"));
    for words in ["", "hardware", "H100"] {
        assert_eq!(choice(words).words(), words);
    }
}

#[test]
fn a_device_of_a_name_that_none_has_says_what_there_is() {
    let Some(gpu) = gpu() else { return };
    let named = |name: &str| Gpu::headless_of(&burin::gpu::AdapterChoice::from_words(name));
    assert_eq!(named(gpu.name()).unwrap().name(), gpu.name());
    let error = named("no such adapter").unwrap_err();
    assert!(matches!(&error, GpuError::NoAdapter { reason } if reason.contains(gpu.name())), "{error}");
}

#[test]
fn a_device_that_is_asked_for_times_tells_those_of_every_pass_once() {
    let Some(plain) = gpu() else { return };
    assert_eq!(plain.pass_times().unwrap(), None);
    let gpu = Gpu::headless_timed().unwrap();
    // Where the adapter has no times there is nothing to tell.
    let Some(none) = gpu.pass_times().unwrap() else { return };
    assert_eq!(none, []);
    let grid = unit_grid([40, 40, 40]);
    let density = density_u16(grid, |v| (v[0] * 100 + v[1]) as u16);
    let blank = [FieldKind::Colour, FieldKind::Selection, FieldKind::Labels].map(|kind| Field::blank(kind, &grid));
    let fields = one_volume(&grid, &density, &blank[0], &blank[1], &blank[2]);
    let mut pools = FieldPools::new(&gpu, &grid, &density, 16 << 20).unwrap();
    let mut caster = burin::gpu::Caster::new(&gpu).unwrap();
    for size in [[32, 32], [256, 256]] {
        let frame = frame(&grid, ramp(-1.0, 4000.0), DVec3::NEG_Y, size);
        let start = std::time::Instant::now();
        caster.image(&gpu, &mut pools, &fields, &frame).unwrap();
        let wall = start.elapsed().as_secs_f64() * 1e3;
        let times = gpu.pass_times().unwrap().unwrap();
        let cast: f64 = times.iter().filter(|(pass, _)| *pass == "cast").map(|(_, ms)| ms).sum();
        assert!(cast > 0.0 && cast <= wall, "{cast} of {wall} ms: {times:?}");
    }
    assert_eq!(gpu.pass_times().unwrap().unwrap(), [], "told once");
}
