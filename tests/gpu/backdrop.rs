//! What lies under a window's controls, pixel by pixel.

use crate::common::gpu::gpu;
use burin::gpu::{Backdrop, BackdropDraw, BackdropPicture, Fill, Gpu};

const SIZE: [u32; 2] = [64, 16];
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// What the target is before; no colour of a test.
const BEFORE: [u8; 4] = [10, 200, 30, 255];

fn drawn(gpu: &Gpu, backdrop: &BackdropDraw) -> impl Fn(u32, u32) -> [u8; 4] + use<> {
    let (device, queue) = gpu.raw();
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let view = target.create_view(&Default::default());
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(SIZE[0] * SIZE[1] * 4),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let [r, g, b, a] = BEFORE.map(|x| f64::from(x) / 255.0);
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a }), store: wgpu::StoreOp::Store };
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let attachment = wgpu::RenderPassColorAttachment { view: &view, depth_slice: None, resolve_target: None, ops };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(attachment)],
            ..Default::default()
        });
        backdrop.draw(&mut pass);
    }
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(SIZE[0] * 4), rows_per_image: None };
    let into = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(target.as_image_copy(), into, target.size());
    queue.submit([encoder.finish()]);
    let bytes = gpu.read_buffer(&buffer, "the window").unwrap();
    move |x, y| {
        let at = ((y * SIZE[0] + x) * 4) as usize;
        bytes[at..at + 4].try_into().unwrap()
    }
}

/// Every pixel of a picture is another colour.
fn picture([width, height]: [u32; 2]) -> Vec<u8> {
    (0..height).flat_map(|y| (0..width).flat_map(move |x| [x as u8 * 9, y as u8 * 30, 77, 13])).collect()
}

#[test]
fn a_picture_of_its_places_size_is_shown_as_it_is_and_fills_lie_under_and_over_it() {
    let Some(gpu) = gpu() else { return };
    let mut backdrop = Backdrop::new(gpu.clone(), FORMAT).unwrap();
    backdrop.take(2, [20, 6], &picture([20, 6])).unwrap();
    let red = [1.0, 0.0, 0.0, 1.0];
    let under = [Fill { place: [3.0, 2.0, 40.0, 12.0], colour: red }];
    // Half of white over it: multiplied by alpha, as egui's colours are.
    let over = [Fill { place: [12.0, 5.0, 13.0, 6.0], colour: [0.5; 4] }];
    let shown = [
        BackdropPicture { place: [10.0, 4.0, 30.0, 10.0], picture: 2 },
        BackdropPicture { place: [50.0, 0.0, 64.0, 16.0], picture: 3 },
    ];
    let at = drawn(&gpu, &backdrop.prepare(SIZE, &under, &shown, &over).unwrap());
    for (x, y) in [(0, 0), (2, 2), (3, 1), (40, 5), (5, 12), (55, 8)] {
        assert_eq!(at(x, y), BEFORE, "nothing lies at {x} {y}, and picture 3 never came");
    }
    for (x, y) in [(3, 2), (39, 11), (9, 4), (30, 9), (10, 3), (29, 10)] {
        assert_eq!(at(x, y), [255, 0, 0, 255], "the fill at {x} {y}");
    }
    for (x, y) in [(10, 4), (29, 4), (10, 9), (29, 9), (17, 7)] {
        let (u, v) = (x - 10, y - 4);
        assert_eq!(at(x, y), [u as u8 * 9, v as u8 * 30, 77, 255], "the picture at {x} {y}, opaque");
    }
    let mixed = at(12, 5);
    for (found, below) in mixed.iter().zip([18, 30, 77, 255]) {
        let expected = (127.5 + 0.5 * f64::from(below)) as i32;
        assert!((i32::from(*found) - expected).abs() <= 1, "{mixed:?}");
    }
}

#[test]
fn a_coarse_picture_is_enlarged_without_steps_and_a_new_one_replaces_it() {
    let Some(gpu) = gpu() else { return };
    let mut backdrop = Backdrop::new(gpu.clone(), FORMAT).unwrap();
    let whole = [BackdropPicture { place: [0.0, 0.0, 64.0, 16.0], picture: 0 }];
    let grey = |values: &[u8]| values.iter().flat_map(|&v| [v, v, v, 255]).collect::<Vec<u8>>();
    backdrop.take(0, [2, 1], &grey(&[0, 200])).unwrap();
    let at = drawn(&gpu, &backdrop.prepare(SIZE, &[], &whole, &[]).unwrap());
    // Texel centres lie at a quarter and three quarters; between them it is linear.
    for x in [0, 8, 15, 20, 31, 40, 47, 48, 60, 63] {
        let share = ((f64::from(x) + 0.5) / 64.0 * 2.0 - 0.5).clamp(0.0, 1.0);
        let found = i32::from(at(x, 7)[0]);
        assert!((found - (share * 200.0).round() as i32).abs() <= 2, "{found} at {x}, {share} of the way");
    }
    backdrop.take(0, [1, 1], &grey(&[90])).unwrap();
    let at = drawn(&gpu, &backdrop.prepare(SIZE, &[], &whole, &[]).unwrap());
    assert_eq!((at(0, 0), at(63, 15)), ([90, 90, 90, 255], [90, 90, 90, 255]));
    backdrop.forget();
    let at = drawn(&gpu, &backdrop.prepare(SIZE, &[], &whole, &[]).unwrap());
    assert_eq!(at(32, 8), BEFORE);
}

#[test]
fn a_picture_that_does_not_fit_its_numbers_or_the_device_is_refused_in_words() {
    let Some(gpu) = gpu() else { return };
    let mut backdrop = Backdrop::new(gpu.clone(), FORMAT).unwrap();
    let short = backdrop.take(0, [2, 2], &[0; 15]).unwrap_err().to_string();
    assert!(short.contains("15 bytes found") && short.contains("2 × 2"), "{short}");
    assert!(backdrop.take(0, [0, 2], &[]).is_err());
    let most = gpu.raw().0.limits().max_texture_dimension_2d;
    let wide = backdrop.take(0, [most + 1, 1], &vec![0; (most as usize + 1) * 4]).unwrap_err().to_string();
    assert!(wide.contains("a window's picture"), "{wide}");
    gpu.check().unwrap();
}
