//! Pictures for a window: half resolution while something moves, refined at rest in bands of rows.
//!
//! Owns the two pictures and how far the refinement has come. A band is as many rows as lately took the queue about 40 ms,
//! and the next is submitted only when the last is done, so that the window stays answerable.

use super::pass::{Targets, draw_over, full_screen};
use super::shader::{self, Def};
use super::tiles::{TILE, Window};
use super::{Caster, FieldPools, Fields, Frame, Gpu, GpuError};
use crate::shared_struct;
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Milliseconds that a band should take.
const BAND_MS: f64 = 40.0;

shared_struct! {
    /// See shaders/screen.wgsl.
    pub struct Show {
        /// Display-referred.
        pub background: [f32; 3],
        /// Refined rows.
        pub rows_done: f32,
        /// Pixels of the full picture.
        pub size: [f32; 2],
        /// Pixels of the preview.
        pub preview_size: [f32; 2],
    }
}

/// A band on its way: its rows, and the microseconds it took once it is done.
#[derive(Debug)]
struct Band {
    rows: u32,
    micros: Arc<AtomicU64>,
}

/// See the module's head.
#[derive(Debug, Default)]
pub(super) struct Screen {
    /// The frame shown, and the caller's number for the voxels' content.
    of: Option<(Frame, u64)>,
    preview: Option<Targets>,
    full: Option<Targets>,
    preview_done: bool,
    rows_done: u32,
    band_rows: u32,
    band: Option<Band>,
    show: Option<wgpu::Buffer>,
    blits: HashMap<wgpu::TextureFormat, (wgpu::BindGroupLayout, wgpu::RenderPipeline)>,
}

/// How a window's picture is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Something moves: half resolution will do.
    pub moving: bool,
    /// Changes whenever voxels did, also within a running stroke.
    pub content: u64,
    /// Display-referred.
    pub background: [f32; 3],
}

impl Caster {
    /// Draws a frame over a target of the frame's size and of the given format. A changed frame shows at half resolution at once;
    /// at rest every call refines a band of rows. Answers whether the picture is finished: if not, call again.
    ///
    /// # Errors
    /// As [`Caster::image`].
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        pools: &mut FieldPools,
        fields: &Fields<'_>,
        frame: &Frame,
        wanted: Wanted,
        target: &wgpu::TextureView,
        format: wgpu::TextureFormat,
    ) -> Result<bool, GpuError> {
        if frame.size.contains(&0) {
            return Ok(true);
        }
        let loaded = pools.make_resident(gpu, fields, frame)?;
        gpu.scoped("the window's picture", || {
            let of = (frame.clone(), wanted.content);
            if loaded || self.screen.of.as_ref() != Some(&of) {
                self.screen.of = Some(of);
                self.screen.preview_done = false;
                self.screen.rows_done = 0;
                self.screen.band = None;
            }
            if !self.screen.preview_done && self.screen.rows_done == 0 {
                self.preview(gpu, pools, fields, frame)?;
            } else if !wanted.moving {
                self.refine(gpu, pools, fields, frame)?;
            }
            self.blit(gpu, frame.size, wanted.background, target, format)?;
            Ok(self.screen.rows_done == frame.size[1])
        })
    }

    fn preview(&mut self, gpu: &Gpu, pools: &FieldPools, fields: &Fields<'_>, frame: &Frame) -> Result<(), GpuError> {
        let size = frame.size.map(|s| s.div_ceil(2));
        let drawn = self.drawn(pools, fields, frame);
        let targets = match self.screen.preview.take().filter(|t| t.size == size) {
            Some(targets) => targets,
            None => Targets::new(gpu, size),
        };
        self.render(gpu, pools, frame, &drawn, &Window::whole(size), &targets, 0..size[1])?;
        self.screen.preview = Some(targets);
        self.screen.preview_done = true;
        Ok(())
    }

    fn refine(&mut self, gpu: &Gpu, pools: &FieldPools, fields: &Fields<'_>, frame: &Frame) -> Result<(), GpuError> {
        let height = frame.size[1];
        // A failed poll is a lost device, which the scope around this reports.
        let _ = gpu.device.poll(wgpu::PollType::Poll);
        if let Some(band) = &self.screen.band {
            let micros = band.micros.load(Ordering::Acquire);
            if micros == 0 {
                return Ok(());
            }
            let fitting = f64::from(band.rows) * BAND_MS * 1000.0 / micros as f64;
            // Rows differ; growing at most twofold keeps a band behind an empty one short.
            let fitting = fitting.min(2.0 * f64::from(band.rows)).max(f64::from(TILE));
            self.screen.band_rows = fitting as u32 / TILE * TILE;
            self.screen.rows_done = (self.screen.rows_done + band.rows).min(height);
            self.screen.band = None;
        }
        if self.screen.rows_done == height {
            return Ok(());
        }
        let start = self.screen.rows_done;
        let end = (start + self.screen.band_rows.max(2 * TILE)).min(height);
        let drawn = self.drawn(pools, fields, frame);
        let targets = match self.screen.full.take().filter(|t| t.size == frame.size) {
            Some(targets) => targets,
            None => Targets::new(gpu, frame.size),
        };
        let begun = Instant::now();
        self.render(gpu, pools, frame, &drawn, &Window::whole(frame.size), &targets, start..end)?;
        self.screen.full = Some(targets);
        let micros = Arc::new(AtomicU64::new(0));
        let done = Arc::clone(&micros);
        gpu.queue.on_submitted_work_done(move || {
            done.store((begun.elapsed().as_micros() as u64).max(1), Ordering::Release);
        });
        self.screen.band = Some(Band { rows: end - start, micros });
        Ok(())
    }

    fn blit(
        &mut self,
        gpu: &Gpu,
        size: [u32; 2],
        background: [f32; 3],
        target: &wgpu::TextureView,
        format: wgpu::TextureFormat,
    ) -> Result<(), GpuError> {
        let screen = &mut self.screen;
        let (layout, pipeline) = match screen.blits.entry(format) {
            Entry::Occupied(made) => made.into_mut(),
            Entry::Vacant(place) => place.insert(blit_pipeline(gpu, format)?),
        };
        let show = screen.show.get_or_insert_with(|| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("screen"),
                size: size_of::<Show>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        });
        let Some(preview) = screen.preview.as_ref() else { return Ok(()) };
        let full = screen.full.as_ref().unwrap_or(preview);
        let values = Show {
            background,
            rows_done: screen.rows_done as f32,
            size: size.map(|s| s as f32),
            preview_size: preview.size.map(|s| s as f32),
        };
        gpu.queue.write_buffer(show, 0, bytemuck::bytes_of(&values));
        let views = [&full.colour, &preview.colour].map(|t| t.create_view(&wgpu::TextureViewDescriptor::default()));
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("screen"),
            layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: show.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&views[0]) },
                wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::TextureView(&views[1]) },
            ],
        });
        draw_over(gpu, "screen", target, pipeline, &[&group]);
        Ok(())
    }
}

fn blit_pipeline(
    gpu: &Gpu,
    format: wgpu::TextureFormat,
) -> Result<(wgpu::BindGroupLayout, wgpu::RenderPipeline), GpuError> {
    let texture = |binding| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    };
    let uniform = wgpu::BindGroupLayoutEntry {
        binding: 0,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("screen"),
        entries: &[uniform, texture(1), texture(2)],
    });
    let defs: &[(&str, Def)] = if format.is_srgb() { &[("LINEAR_TARGET", Def::Bool(true))] } else { &[] };
    let module = shader::compile(gpu, "screen.wgsl", defs)?;
    let pipeline = full_screen(gpu, "screen.wgsl", &module, &[&layout], &[format], "blit");
    Ok((layout, pipeline))
}
