//! The caster's kernel in its two forms: a fragment for every pixel of rectangles, or a workgroup for every tile of a list.
//!
//! Both march by the same shader, `shaders/cast/picture.wgsl`, and give the same bits. Owns the pipelines and what each form needs
//! to know where bodies show. Knows no body.

use crate::gpu::cast::tiles::Tiles;
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::kernel::{Binding, Compute, Draw, Kernel};
use crate::gpu::device::shader::shader;
use crate::gpu::device::textures::{COLOUR, DEPTH, OBJECT, Targets};
use wgpu::util::DeviceExt;

/// How a picture's pixels are marched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// By fragments of a triangle over rectangles of the picture.
    Fragments,
    /// By workgroups, one a tile.
    Workgroups,
}

/// Tiles that one pipeline serves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Share {
    /// All in which bodies show.
    All,
    /// Those whose bodies follow one another.
    Ordered,
    /// Those whose bodies are merged.
    Merged,
}

impl Share {
    fn holds(self, merges: bool) -> bool {
        match self {
            Self::All => true,
            Self::Ordered => !merges,
            Self::Merged => merges,
        }
    }
}

/// A pipeline's work in a pass.
pub(crate) struct Work {
    pub share: Share,
    pub conditions: Vec<&'static str>,
}

/// The groups that both forms bind: layouts and groups of the caster, the fields, and layers if there are any.
#[derive(Clone, Copy)]
pub(crate) struct Groups<'a> {
    pub caster: (&'a wgpu::BindGroupLayout, &'a wgpu::BindGroup),
    pub fields: (&'a wgpu::BindGroupLayout, &'a wgpu::BindGroup),
    pub layers: Option<(&'a wgpu::BindGroupLayout, &'a wgpu::BindGroup)>,
}

/// How a pass's targets begin.
#[derive(Clone, Copy)]
pub(crate) enum Begins<'a> {
    /// With opaque meshes, or nothing.
    With(Option<&'a Targets>),
    /// As an earlier pass left them.
    AsItIs,
}

/// The caster's kernel, ready to march in either form; pipelines are made when a picture first needs them.
#[derive(Debug)]
pub(crate) struct Forms {
    pub form: Form,
    fragments: Kernel<Draw>,
    workgroups: Kernel<Compute>,
}

const FILE: &str = shader!("cast/picture.wgsl");
/// Workgroups along x; more go on in y.
const ROW: u32 = 1 << 15;

impl Forms {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let flat = |format| Binding::Written(wgpu::TextureViewDimension::D2, format);
        let places = Binding::Elements { bytes: 4, written: false };
        let out = [places, flat(COLOUR), flat(DEPTH), flat(OBJECT)];
        Self {
            form: if gpu.is_software() { Form::Fragments } else { Form::Workgroups },
            fragments: Kernel::new(gpu, FILE, Draw::cover("march_pixel", &[COLOUR, DEPTH, OBJECT]), &[]),
            workgroups: Kernel::new(gpu, FILE, Compute("march_tile"), &out),
        }
    }

    /// Submits a pass of a picture.
    pub(crate) fn submit(
        &mut self,
        gpu: &Gpu,
        tiles: &Tiles,
        work: &[Work],
        groups: Groups<'_>,
        targets: &Targets,
        begins: Begins<'_>,
    ) -> Result<(), GpuError> {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("cast") });
        if let Begins::With(Some(opaque)) = begins {
            targets.take_over(&mut encoder, opaque);
        }
        let clear = matches!(begins, Begins::With(None));
        match self.form {
            Form::Fragments => self.draw(gpu, &mut encoder, tiles, work, groups, targets, clear)?,
            Form::Workgroups => self.dispatch(gpu, &mut encoder, tiles, work, groups, targets, clear)?,
        }
        gpu.queue.submit([encoder.finish()]);
        Ok(())
    }

    fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        tiles: &Tiles,
        work: &[Work],
        groups: Groups<'_>,
        targets: &Targets,
        clear: bool,
    ) -> Result<(), GpuError> {
        let pipelines = pipelines(&mut self.fragments, gpu, work, groups, |w| w.conditions.clone())?;
        let views = targets.views();
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("cast"),
            color_attachments: &Targets::attachments(&views, clear),
            timestamp_writes: gpu.render_times("cast"),
            ..Default::default()
        });
        pass.set_bind_group(0, groups.caster.1, &[]);
        pass.set_bind_group(1, groups.fields.1, &[]);
        pass.set_bind_group(3, groups.layers.map(|l| l.1), &[]);
        for (pipeline, w) in pipelines.iter().zip(work) {
            pass.set_pipeline(pipeline);
            let mut areas = tiles.areas(targets.size, |merges| w.share.holds(merges));
            if w.share == Share::All {
                // A box around what it draws costs one pipeline less than many small ones.
                let around =
                    |a: [u32; 4], b: [u32; 4]| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])];
                areas = areas.into_iter().reduce(around).into_iter().collect();
            }
            for [left, top, right, bottom] in areas {
                pass.set_scissor_rect(left, top, right - left, bottom - top);
                pass.draw(0..3, 0..1);
            }
        }
        Ok(())
    }

    fn dispatch(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        tiles: &Tiles,
        work: &[Work],
        groups: Groups<'_>,
        targets: &Targets,
        clear: bool,
    ) -> Result<(), GpuError> {
        let conditions = |w: &Work| [&w.conditions[..], &["TILED"]].concat();
        let pipelines = pipelines(&mut self.workgroups, gpu, work, groups, conditions)?;
        let views = targets.views();
        if clear {
            encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("cast: nothing"),
                color_attachments: &Targets::attachments(&views, true),
                ..Default::default()
            });
        }
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("cast"),
            timestamp_writes: gpu.compute_times("cast"),
        });
        pass.set_bind_group(0, groups.caster.1, &[]);
        pass.set_bind_group(1, groups.fields.1, &[]);
        pass.set_bind_group(3, groups.layers.map(|l| l.1), &[]);
        for (pipeline, w) in pipelines.iter().zip(work) {
            let list = tiles.places(|merges| w.share.holds(merges));
            if list.is_empty() {
                continue;
            }
            let places = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("tiles to draw"),
                contents: bytemuck::cast_slice(&list),
                usage: wgpu::BufferUsages::STORAGE,
            });
            let out = views.iter().map(wgpu::BindingResource::TextureView);
            let own = self.workgroups.group(gpu, [places.as_entire_binding()].into_iter().chain(out));
            pass.set_pipeline(pipeline);
            pass.set_bind_group(2, own.as_ref(), &[]);
            let count = list.len() as u32;
            pass.dispatch_workgroups(count.min(ROW), count.div_ceil(ROW), 1);
        }
        Ok(())
    }
}

fn pipelines<E: crate::gpu::device::kernel::Entry>(
    kernel: &mut Kernel<E>,
    gpu: &Gpu,
    work: &[Work],
    groups: Groups<'_>,
    conditions: impl Fn(&Work) -> Vec<&'static str>,
) -> Result<Vec<E::Pipeline>, GpuError> {
    let before = [Some(groups.caster.0), Some(groups.fields.0)];
    let layers = groups.layers.map(|l| l.0);
    work.iter().map(|w| kernel.pipeline(gpu, &conditions(w), &before, layers.as_slice())).collect()
}
