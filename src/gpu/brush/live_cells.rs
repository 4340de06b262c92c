//! Cells of painted slots while a stroke runs: asked for once a frame, taken when they have come, never waited for.
//!
//! Owns shaders/brush/live_cells.wgsl's pipelines and what is on its way. From its dabs until the answer to a question put after
//! them a block of cells may show anything.

use crate::gpu::brush::kernel::Variant;
use crate::gpu::device::constants::{BLOCK_CELLS, CELL};
use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::kernel::{Binding, Compute, Kernel};
use crate::gpu::device::shader::shader;
use crate::gpu::fields::pools::FieldPools;
use crate::paint::IndexBox;
use crate::shared_struct;
use crate::volume::{
    BrickIndex, CELLS_PER_BRICK, Cells, Field, FieldKey, FieldKind, LiveCells, SelectedCell, SourceError,
};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Voxels along an edge of a block.
const BLOCK: u32 = BLOCK_CELLS * CELL;
/// Cells in a block.
const CELLS: usize = BLOCK_CELLS.pow(3) as usize;
/// Blocks of a submission, so that it does not hold the queue for long.
const MOST_BLOCKS: usize = 512;
/// Buffers for answers that are kept.
const MOST_IDLE: usize = 4;
/// Words of a block's answer.
const WORDS: usize = CELLS * 3;

shared_struct! {
    /// One block's work.
    pub(crate) struct CellsJob {
        /// The block's first texel in the pool, one before its first own voxel.
        pub at: [u32; 3],
        /// Own voxels in the volume along x, y, z, five bits each.
        pub own: u32,
    }
}

/// The kernel and buffers that outlive strokes.
#[derive(Debug)]
pub(crate) struct CellReader {
    kernel: Kernel<Compute>,
    jobs: wgpu::Buffer,
    answers: wgpu::Buffer,
    idle: Vec<wgpu::Buffer>,
}

/// A block of a brick, one of eight.
type Block = (BrickIndex, u8);

/// An answer on its way.
#[derive(Debug)]
struct Flight {
    blocks: Vec<Block>,
    buffer: wgpu::Buffer,
    come: Arc<AtomicBool>,
}

/// A touched brick.
#[derive(Debug)]
struct Live {
    cells: LiveCells,
    /// First texel of its slot in the pool.
    slot: [u32; 3],
    /// By block: whether it was painted since it was asked for.
    painted: [bool; 8],
    /// By block: how many answers are on their way.
    due: [u32; 8],
}

/// What is known of a running stroke's bricks.
#[derive(Debug, Default)]
pub(crate) struct LiveBricks {
    bricks: BTreeMap<BrickIndex, Live>,
    flights: VecDeque<Flight>,
    /// Bricks that were painted since they were asked for.
    painted: BTreeSet<BrickIndex>,
    /// Bricks of which something came since they were last asked for.
    news: BTreeSet<BrickIndex>,
}

impl CellReader {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        use wgpu::BufferUsages as Use;
        let bindings = [
            Binding::Texture(wgpu::TextureViewDimension::D3, wgpu::TextureSampleType::Float { filterable: false }),
            Binding::Elements { bytes: size_of::<CellsJob>(), written: false },
            Binding::Elements { bytes: 4, written: true },
        ];
        Self {
            kernel: Kernel::new(gpu, shader!("brush/live_cells.wgsl"), Compute("cells_of_block"), &bindings),
            jobs: buffer(gpu, 1 << 12, Use::STORAGE | Use::COPY_DST),
            answers: buffer(gpu, 1 << 16, Use::STORAGE | Use::COPY_SRC),
            idle: Vec::new(),
        }
    }

    /// The pipeline for a selection or for density, compiled when first needed.
    pub(crate) fn prepare(&mut self, gpu: &Gpu, variant: Variant) -> Result<wgpu::ComputePipeline, GpuError> {
        let conditions: &[_] = if variant == Variant::Selection { &["SELECTION"] } else { &[] };
        self.kernel.pipeline(gpu, conditions, &[], &[])
    }

    /// Submits the question for blocks of slots.
    fn ask(
        &mut self,
        gpu: &Gpu,
        pool: &wgpu::Texture,
        variant: Variant,
        asked: &[(CellsJob, Block)],
    ) -> Result<Flight, GpuError> {
        use wgpu::BufferUsages as Use;
        let pipeline = self.prepare(gpu, variant)?;
        let (jobs, blocks): (Vec<_>, Vec<_>) = asked.iter().copied().unzip();
        let bytes = (blocks.len() * WORDS * 4) as u64;
        if self.jobs.size() < size_of_val(&jobs[..]) as u64 {
            self.jobs = buffer(gpu, size_of_val(&jobs[..]) as u64, Use::STORAGE | Use::COPY_DST);
        }
        if self.answers.size() < bytes {
            self.answers = buffer(gpu, bytes, Use::STORAGE | Use::COPY_SRC);
        }
        gpu.queue.write_buffer(&self.jobs, 0, bytemuck::cast_slice(&jobs));
        let answer = match self.idle.iter().position(|b| b.size() >= bytes) {
            Some(i) => self.idle.swap_remove(i),
            None => buffer(gpu, bytes, Use::COPY_DST | Use::MAP_READ),
        };
        let view = pool.create_view(&wgpu::TextureViewDescriptor::default());
        let texture = wgpu::BindingResource::TextureView(&view);
        let resources = [texture, self.jobs.as_entire_binding(), self.answers.as_entire_binding()];
        let group = self.kernel.group(gpu, resources);
        let mut encoder =
            gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("brush cells") });
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("brush cells"),
                timestamp_writes: None,
            });
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, group.as_ref(), &[]);
            pass.dispatch_workgroups(blocks.len() as u32, 1, 1);
        }
        encoder.copy_buffer_to_buffer(&self.answers, 0, &answer, 0, bytes);
        gpu.queue.submit([encoder.finish()]);
        let come: Arc<AtomicBool> = Arc::default();
        let flag = come.clone();
        // A failure leaves it on its way; the stroke's end does without.
        answer.map_async(wgpu::MapMode::Read, .., move |result| flag.store(result.is_ok(), Ordering::Release));
        Ok(Flight { blocks, buffer: answer, come })
    }
}

impl LiveBricks {
    /// What is known of bricks before the first dab on them.
    pub(crate) fn begin(
        &mut self,
        field: &Field,
        bricks: impl IntoIterator<Item = (BrickIndex, [u32; 3])>,
    ) -> Result<(), SourceError> {
        for (brick, slot) in bricks {
            let cells = LiveCells::of(field, brick)?;
            self.bricks.insert(brick, Live { cells, slot, painted: [false; 8], due: [0; 8] });
        }
        Ok(())
    }

    /// Forgets bricks again.
    pub(crate) fn forget(&mut self, bricks: &[BrickIndex]) {
        for brick in bricks {
            self.bricks.remove(brick);
            self.painted.remove(brick);
        }
    }

    /// Dabs were submitted that change these boxes of voxels, each within a brick's slot.
    pub(crate) fn paint(
        &mut self,
        met: &BTreeMap<BrickIndex, IndexBox>,
        dims: [u32; 3],
        key: FieldKey,
        pools: &mut FieldPools,
    ) {
        for (brick, bounds) in met {
            if let Some(live) = self.bricks.get_mut(brick) {
                blocks_of(*brick, bounds, dims).for_each(|block| live.painted[usize::from(block)] = true);
                self.painted.insert(*brick);
            }
        }
        self.show(met.keys(), key, pools);
    }

    /// Puts the question for all that was painted since the last one.
    pub(crate) fn ask(
        &mut self,
        gpu: &Gpu,
        variant: Variant,
        reader: &mut CellReader,
        pool: &wgpu::Texture,
        dims: [u32; 3],
    ) -> Result<(), GpuError> {
        let mut asked = Vec::new();
        for brick in std::mem::take(&mut self.painted) {
            let Some(live) = self.bricks.get_mut(&brick) else { continue };
            for block in (0..8_u8).filter(|b| std::mem::take(&mut live.painted[usize::from(*b)])) {
                let first = corner(block);
                let own = |a: usize| dims[a].saturating_sub(brick.origin()[a] + first[a]).min(BLOCK);
                let at = std::array::from_fn(|a| live.slot[a] + first[a]);
                asked.push((CellsJob { at, own: own(0) | own(1) << 5 | own(2) << 10 }, (brick, block)));
                live.due[usize::from(block)] += 1;
            }
        }
        for part in asked.chunks(MOST_BLOCKS) {
            self.flights.push_back(gpu.scoped("painted cells", || reader.ask(gpu, pool, variant, part))?);
        }
        Ok(())
    }

    /// Takes the answers that have come, in the order of the questions. Does not wait.
    pub(crate) fn follow(
        &mut self,
        gpu: &Gpu,
        (key, field): (FieldKey, &Field),
        variant: Variant,
        reader: &mut CellReader,
        pools: &mut FieldPools,
    ) -> Result<(), GpuError> {
        if self.flights.is_empty() {
            return Ok(());
        }
        gpu.check()?;
        // A failed poll is a lost device, which the next call tells.
        let _ = gpu.device.poll(wgpu::PollType::Poll);
        let mut told = BTreeSet::new();
        while let Some(flight) = self.flights.pop_front_if(|f| f.come.load(Ordering::Acquire)) {
            {
                let view = flight
                    .buffer
                    .get_mapped_range(..(flight.blocks.len() * WORDS * 4) as u64)
                    .map_err(|e| GpuError::Refused { what: "painted cells".into(), reason: e.to_string() })?;
                let words = view.chunks_exact(4).map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]]));
                let words: Vec<u32> = words.collect();
                for ((brick, block), words) in flight.blocks.iter().zip(words.chunks_exact(WORDS)) {
                    if let Some(live) = self.bricks.get_mut(brick) {
                        live.due[usize::from(*block)] -= 1;
                        live.take(*block, words, field, variant);
                        told.insert(*brick);
                    }
                }
            }
            flight.buffer.unmap();
            if reader.idle.len() < MOST_IDLE {
                reader.idle.push(flight.buffer);
            }
        }
        self.news.extend(&told);
        self.show(told.iter(), key, pools);
        Ok(())
    }

    /// Bricks of which something came since this was last asked.
    pub(crate) fn take_news(&mut self) -> Vec<(BrickIndex, LiveCells)> {
        let news = std::mem::take(&mut self.news);
        news.into_iter().filter_map(|b| Some((b, self.bricks.get(&b)?.cells.clone()))).collect()
    }

    /// Whether answers are on their way.
    pub(crate) fn are_due(&self) -> bool {
        !(self.flights.is_empty() && self.news.is_empty() && self.painted.is_empty())
    }

    fn show<'a>(&self, bricks: impl Iterator<Item = &'a BrickIndex>, key: FieldKey, pools: &mut FieldPools) {
        for brick in bricks {
            let Some(live) = self.bricks.get(brick) else { continue };
            let mut ranges = live.cells.ranges.clone();
            for block in (0..8_u8).filter(|b| live.painted[usize::from(*b)] || live.due[usize::from(*b)] > 0) {
                cells_in(block).for_each(|cell| ranges[cell] = [f32::NEG_INFINITY, f32::INFINITY]);
            }
            pools.set_live(key, *brick, Cells::Dense(ranges.into()));
        }
    }
}

impl Live {
    /// A block's answer.
    fn take(&mut self, block: u8, words: &[u32], field: &Field, variant: Variant) {
        for (cell, words) in cells_in(block).zip(words.chunks_exact(3)) {
            let [least, greatest, codes] = [words[0], words[1], words[2]];
            self.cells.ranges[cell] = if least > greatest {
                [f32::INFINITY, f32::NEG_INFINITY]
            } else {
                [least, greatest].map(|key| value(key, field, variant))
            };
            if let Some(selected) = self.cells.selected.get_mut(cell) {
                *selected = SelectedCell {
                    min: (codes >> 16 & 255) as u8,
                    max: (codes >> 24) as u8,
                    sum: (codes & 0xffff) as u16,
                };
            }
        }
    }
}

/// The value that a texel's key stands for.
fn value(key: u32, field: &Field, variant: Variant) -> f32 {
    let texel = f32::from_bits(if key >> 31 == 1 { key & 0x7fff_ffff } else { !key });
    match variant {
        Variant::Selection => (texel * 255.0).round() / 255.0,
        Variant::Codes | Variant::CodesInFloats => {
            let [a, b] = ((texel * 65_535.0).round() as u16).to_le_bytes();
            field.map().decode([a, b, 0, 0]) as f32
        }
        Variant::Floats => field.map().decode(texel.to_le_bytes()) as f32,
        Variant::Labels | Variant::Colour => texel,
    }
}

/// First voxel of a block within its brick.
fn corner(block: u8) -> [u32; 3] {
    std::array::from_fn(|a| u32::from(block >> a & 1) * BLOCK)
}

/// The cells of a block within its brick, x fastest.
fn cells_in(block: u8) -> impl Iterator<Item = usize> {
    let [x, y, z] = corner(block).map(|v| (v / 4) as usize);
    debug_assert_eq!(CELLS_PER_BRICK, 8 * CELLS);
    (0..CELLS).map(move |i| x + i % 4 + 8 * (y + i / 4 % 4 + 8 * (z + i / 16)))
}

/// The blocks of a brick whose texels, those around included, show any of a box of voxels.
fn blocks_of(brick: BrickIndex, bounds: &IndexBox, dims: [u32; 3]) -> impl Iterator<Item = u8> + use<> {
    let (origin, bounds) = (brick.origin(), *bounds);
    (0..8).filter(move |&block| {
        let first = corner(block);
        (0..3).all(|a| {
            let (lo, end) = (origin[a] + first[a], origin[a] + first[a] + BLOCK);
            // Beyond the volume texels repeat its border.
            let beyond = bounds.end[a] == dims[a] && lo >= dims[a];
            bounds.lo[a] <= end && bounds.end[a] + 1 > lo || beyond
        })
    })
}

fn buffer(gpu: &Gpu, bytes: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("brush cells"),
        size: bytes.next_power_of_two(),
        usage,
        mapped_at_creation: false,
    })
}

/// Whether minima and maxima of a field's cells matter to anything.
pub(crate) fn matters(kind: FieldKind) -> bool {
    matches!(kind, FieldKind::Density | FieldKind::Selection)
}
