//! One frame of the window: the pass over its controls, and what the graphics device draws of it, beside one layer of paint by the
//! toolkit's own shader.

use super::cube::document;
use super::head::Failure;
use super::measure::{Report, measure};
use burin::document::{Command, Document, ViewCommand};
use burin::ui::{App, Canvas, OpenDocument, Picture, Report as Told, Request, Session, Snapshot, WorkerEnd};
use eframe::egui_wgpu::{RenderState, RendererOptions, ScreenDescriptor, WgpuConfiguration};
use egui::epaint::{ClippedPrimitive, Mesh, Primitive};
use egui::{Color32, Context, Event, Pos2, RawInput, Rect, ViewportId, pos2, vec2};
use std::sync::Arc;

/// A window without a screen.
struct Stage {
    state: RenderState,
    ctx: Context,
    app: App,
    size: [u32; 2],
    target: wgpu::Texture,
    seconds: f64,
}

impl Stage {
    fn new(session: Session, size: [u32; 2]) -> Result<Self, Failure> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let options = RendererOptions { dithering: false, ..RendererOptions::default() };
        let state = pollster::block_on(RenderState::create(&WgpuConfiguration::default(), &instance, None, options))?;
        let target = state.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("window"),
            size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: state.target_format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        let app = App::new(session).with_canvas(Canvas::new(&state)?);
        Ok(Self { state, ctx: Context::default(), app, size, target, seconds: 0.0 })
    }

    /// A frame with the pointer at a place, in points.
    fn frame(&mut self, pointer: Pos2) -> Result<(), Failure> {
        self.seconds += 0.1;
        let [width, height] = self.size.map(|s| s as f32);
        let mut raw = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, vec2(width, height) / self.ctx.zoom_factor())),
            time: Some(self.seconds),
            events: vec![Event::PointerMoved(pointer)],
            ..RawInput::default()
        };
        raw.viewports.entry(ViewportId::ROOT).or_default().native_pixels_per_point = Some(1.0);
        let ctx = self.ctx.clone();
        let mut full = ctx.run_ui(raw, |ui| self.app.show(ui));
        let mut renderer = self.state.renderer.write();
        for (id, deltas) in full.textures_delta.set.drain() {
            for delta in deltas {
                renderer.update_texture(&self.state.device, &self.state.queue, id, &delta);
            }
        }
        drop(renderer);
        self.draw(&ctx.tessellate(full.shapes, full.pixels_per_point), full.pixels_per_point)
    }

    fn draw(&self, paint: &[ClippedPrimitive], pixels_per_point: f32) -> Result<(), Failure> {
        let RenderState { device, queue, renderer, .. } = &self.state;
        let screen = ScreenDescriptor { size_in_pixels: self.size, pixels_per_point };
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut renderer = renderer.write();
        renderer.update_buffers(device, queue, &mut encoder, paint, &screen);
        let view = self.target.create_view(&wgpu::TextureViewDescriptor::default());
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store };
        let attachment = wgpu::RenderPassColorAttachment { view: &view, depth_slice: None, resolve_target: None, ops };
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(attachment)],
            ..wgpu::RenderPassDescriptor::default()
        });
        renderer.render(&mut pass.forget_lifetime(), paint, &screen);
        queue.submit([encoder.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(())
    }
}

/// What the document tells first.
fn snapshot(document: &Document) -> Result<Snapshot, Failure> {
    let volume = document.state().ok_or("nothing is open")?.at(None)?;
    let open = OpenDocument {
        opening: 1,
        scene: Arc::new(volume.scene.clone()),
        poses: Arc::new(document.poses().clone()),
        grid: *volume.grid(),
        centres: [(volume.id, volume.volume.grid().world_bounds().centre())].into(),
        boxes: Default::default(),
        sample_bytes: Default::default(),
        labels: Default::default(),
        written: Default::default(),
        voxel_type: volume.source.voxel_type(),
        statistics: volume.statistics,
        histogram: Arc::new(volume.histogram.clone()),
    };
    Ok(Snapshot { serial: u64::MAX, open: Some(open), ..Snapshot::default() })
}

/// Gives each view whose size the window has told a picture of that size; answers how many.
fn pictures(far: &WorkerEnd, snapshot: &Snapshot) -> Result<usize, Failure> {
    let camera = snapshot.open.as_ref().ok_or("nothing is open")?.scene.views.camera;
    let mut sent = 0;
    for (_, request) in far.requests.try_iter() {
        let Request::Apply(Command::View(ViewCommand::Size { view, size })) = request else { continue };
        let rgba = (0..size[0] * size[1]).flat_map(|i| [i as u8, (i >> 8) as u8, 40, 255]).collect();
        let picture = Picture { view, size, rgba, depth_mm: Vec::new(), object: Vec::new(), camera, serial: 0 };
        far.reports.send(Told::Picture(Box::new(picture)))?;
        sent += 1;
    }
    Ok(sent)
}

pub fn frame(report: &mut Report) -> Result<(), Failure> {
    let folder = tempfile::tempdir()?;
    let document = document(128, folder.path())?;
    for size in [[1280, 800], [2560, 1440]] {
        let (session, far) = Session::pair();
        let mut stage = Stage::new(session, size)?;
        let told = snapshot(&document)?;
        far.reports.send(Told::Snapshot(Arc::new(told.clone())))?;
        let mut shown = 0;
        for _ in 0..8 {
            stage.frame(pos2(500.0, 300.0))?;
            shown += pictures(&far, &told)?;
        }
        if shown < 4 {
            return Err(format!("{shown} views have a picture, 4 were to have one").into());
        }
        let [width, height] = size;
        let time = measure(3, 15, |i| stage.frame(pos2(500.0 + i as f32, 300.0)))?;
        report.row(&format!("frame of the window, {width}×{height}"), time, "");
        let whole = Rect::from_min_size(Pos2::ZERO, vec2(width as f32, height as f32));
        let mut mesh = Mesh::default();
        mesh.add_colored_rect(whole, Color32::DARK_GRAY);
        let layer = [ClippedPrimitive { clip_rect: whole, primitive: Primitive::Mesh(mesh) }];
        let time = measure(3, 15, |_| stage.draw(&layer, 1.0))?;
        report.row(&format!("one layer of the toolkit's paint, {width}×{height}"), time, "");
    }
    Ok(())
}
