//! How much of the selection is seen, and which bodies hide the rest.
//!
//! Feeds the viewing force's gain (ERRATA, Exploded Views). Counts pixels; the smaller the frame, the cheaper.

use crate::gpu::cast::caster::Caster;
use crate::gpu::cast::counting::Counter;
use crate::gpu::cast::looks::Looks;
use crate::gpu::cast::merging::{MergedBody, Uniting, unite};
use crate::gpu::cast::tiles::Window;
use crate::gpu::device::constants::TILE;
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::volumes::Fields;
use crate::gpu::layers::DrawnLayers;
use crate::gpu::picture::frame::{Frame, Mask};
use crate::volume::Mode;

/// Samples along a ray are held below this by a longer step.
const MOST_SAMPLES: f64 = 6000.0;

/// Numbers of pixels.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Visibility {
    /// Where the selected matter alone reaches opacity ½.
    pub selected: u64,
    /// Those of them with less than 5 % opacity before that sample.
    pub visible: u64,
    /// By id of all bodies but the selection, each once: those that bodies of this id alone hide by at least 5 %.
    pub hidden_by: Vec<(u32, u64)>,
}

impl Visibility {
    /// Visible share of the selected pixels, 1 if there are none.
    pub fn share(&self) -> f64 {
        if self.selected == 0 { 1.0 } else { self.visible as f64 / self.selected as f64 }
    }
}

impl Caster {
    /// Counts the selection's pixels in a frame, as if drawn by DVR; its bodies masked by [`Mask::Selection`] are the
    /// selection, all others may hide it.
    ///
    /// # Errors
    /// As [`Caster::image`].
    pub fn visibility(
        &mut self,
        gpu: &Gpu,
        pools: &mut FieldPools,
        fields: &Fields<'_>,
        frame: &Frame,
    ) -> Result<Visibility, GpuError> {
        let mut answer = Visibility::default();
        // A part is a body of every volume that it is cut out of.
        for body in frame.bodies.iter().filter(|b| b.mask != Mask::Selection) {
            if answer.hidden_by.iter().all(|(id, _)| *id != body.id) {
                answer.hidden_by.push((body.id, 0));
            }
        }
        let list = unite(frame, fields, pools, Uniting::No)?;
        if frame.size.contains(&0) || !list.iter().any(|d| d.mask == Mask::Selection) {
            return Ok(answer);
        }
        let ways = frame
            .volumes()
            .into_iter()
            .filter_map(|id| Some(2.0 * fields.get(id)?.grid.world_bounds().half_diagonal() * frame.steps_of(id)));
        let length = ways.sum::<f64>();
        let step_mm = frame.step_mm.max(length / MOST_SAMPLES);
        // By plain samples, as scripts of before.
        let mut frame = Frame { step_mm, refine: false, ..frame.clone() };
        // What is drawn on matter hides nothing that the matter does not.
        frame.layers.decals.clear();
        frame.mode = Mode::Dvr;
        frame.looks.iter_mut().for_each(|look| look.mode = Mode::Dvr);
        pools.make_resident(gpu, fields, &frame)?;
        let counts = gpu.scoped("visibility", || {
            let mut scene = self.scene(gpu, pools, fields, &frame, &list, &Window::whole(frame.size))?;
            // Here those are kin that are selected in one family, or of one part.
            let kin = |d: &MergedBody, e: &MergedBody| match (d.mask, e.mask) {
                (Mask::Selection, Mask::Selection) => frame.root_of(d.volume) == frame.root_of(e.volume),
                (Mask::Selection, _) | (_, Mask::Selection) => false,
                _ => d.members[0].0 == e.members[0].0,
            };
            for (i, matter) in scene.matters.iter_mut().enumerate() {
                matter.kin = list[..i].iter().position(|e| kin(&list[i], e)).unwrap_or(i) as u32;
            }
            self.set_looks(gpu, pools, &frame, &scene);
            let lists = self.upload(gpu, &scene);
            let layers = self.draw_layers(gpu, &frame, &list, &mut scene, &lists, frame.size)?;
            gpu.queue.write_buffer(&self.view, 0, bytemuck::bytes_of(&scene.view));
            let group = self.group(gpu, &lists, scene.looks.own, &self.nothing);
            self.count(gpu, pools, &group, (layers.as_ref(), &scene.looks, !frame.boxes.is_empty()), frame.size)
        })?;
        answer.selected = u64::from(counts[0]);
        answer.visible = u64::from(counts[1]);
        for (d, &count) in list.iter().zip(&counts[2..]) {
            if let Some(hidden) = answer.hidden_by.iter_mut().find(|(id, _)| *id == d.members[0].0)
                && d.mask != Mask::Selection
            {
                hidden.1 += u64::from(count);
            }
        }
        Ok(answer)
    }

    fn count(
        &mut self,
        gpu: &Gpu,
        pools: &FieldPools,
        group: &wgpu::BindGroup,
        (layers, looks, boxed): (Option<&DrawnLayers>, &Looks, bool),
        size: [u32; 2],
    ) -> Result<Vec<u32>, GpuError> {
        let counter = self.visibility.get_or_insert_with(|| Counter::new(gpu));
        let mut names: Vec<&'static str> = pools.defs(gpu).into_iter().map(|d| d.0).collect();
        names.extend(["SELECTION", "COUNTS"]);
        if boxed {
            names.extend(["HOLES", "FOUND_AT"]);
        }
        names.extend(looks.conditions(pools.has_labels_in_place()));
        names.extend(layers.into_iter().flat_map(DrawnLayers::conditions));
        let after = self.layers.as_ref().filter(|_| layers.is_some()).map(|l| &l.layout);
        let before = [Some(&self.layout), Some(pools.layout())];
        let pipeline = counter.kernel.pipeline(gpu, &names, &before, after.as_slice())?;
        let counts = counter.kernel.group(gpu, [counter.counts.as_entire_binding()]);
        let mut encoder =
            gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("visibility") });
        encoder.clear_buffer(&counter.counts, 0, None);
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, group, &[]);
            pass.set_bind_group(1, pools.group(), &[]);
            pass.set_bind_group(2, counts.as_ref(), &[]);
            pass.set_bind_group(3, layers.map(|l| &l.group), &[]);
            pass.dispatch_workgroups(size[0].div_ceil(TILE), size[1].div_ceil(TILE), 1);
        }
        encoder.copy_buffer_to_buffer(&counter.counts, 0, &counter.answer, 0, counter.counts.size());
        gpu.queue.submit([encoder.finish()]);
        let bytes = gpu.read_buffer(&counter.answer, "visibility")?;
        Ok(bytes.chunks_exact(4).map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]])).collect())
    }
}
