//! The tables of looks on the GPU: of a picture's one look, of the rows of many, of labels' looks and of segment colours.
//!
//! Owns their textures, and makes anew only what changed. What is in a row is `looks`'; knows no bodies.

use crate::gpu::cast::looks::{Looks, ROW, Row, entries, integrals, rows};
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::textures::{COLOUR, data, write};
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::picture::frame::{Frame, Look};
use crate::volume::TABLE_ENTRIES;
use rayon::prelude::*;

/// Tables of looks that are kept.
const TABLES: usize = 2;

/// What a row of the table holds.
#[derive(Clone, Debug)]
enum Written {
    /// Nothing was written yet.
    No,
    Nothing,
    Look(Box<Look>),
}

/// Rows of looks on the GPU.
#[derive(Debug)]
struct LookTable {
    step_mm: f64,
    /// Rows of a look.
    each: usize,
    rows: Vec<Written>,
    texture: wgpu::Texture,
}

/// The textures that a picture's looks are read from.
pub(crate) struct LookTextures<'a> {
    pub(crate) table: &'a wgpu::Texture,
    pub(crate) label_looks: &'a wgpu::Texture,
    pub(crate) segments: &'a wgpu::Texture,
}

/// Tables with what they hold.
#[derive(Debug)]
pub(crate) struct LookTables {
    /// Of a look that serves all of a picture.
    one: (Vec<[f32; 4]>, wgpu::Texture),
    /// Rows of looks, by the step that they were made for; pictures and picks take turns.
    rows: Vec<LookTable>,
    label_looks: (Vec<[f32; 4]>, wgpu::Texture),
    segments: (Vec<[u8; 4]>, wgpu::Texture),
}

impl LookTables {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        Self {
            one: (Vec::new(), data(gpu, "transfer table", [TABLE_ENTRIES as u32, 2], COLOUR)),
            rows: Vec::new(),
            label_looks: (Vec::new(), data(gpu, "labels' looks", [256, 1], COLOUR)),
            segments: (Vec::new(), data(gpu, "segment colours", [256, 1], wgpu::TextureFormat::Rgba8Unorm)),
        }
    }

    /// What was set last. `own`: bodies have looks of their own.
    pub(crate) fn textures(&self, own: bool) -> LookTextures<'_> {
        let table = self.rows.first().filter(|_| own).map_or(&self.one.1, |rows| &rows.texture);
        LookTextures { table, label_looks: &self.label_looks.1, segments: &self.segments.1 }
    }

    /// Has the tables of a frame's looks, labels and segment colours.
    pub(crate) fn set(&mut self, gpu: &Gpu, pools: &FieldPools, frame: &Frame, looks: &Looks) {
        if looks.own {
            self.set_rows(gpu, frame, looks);
        } else {
            let look = match looks.rows.first() {
                Some(&Row::Look(row)) => frame.look(row),
                _ => frame.look(None),
            };
            let mut entries = entries(look, frame.step_mm);
            if looks.refines {
                entries.extend(integrals(look, frame.step_mm));
            }
            entries.resize(2 * TABLE_ENTRIES, [0.0; 4]);
            if self.one.0 != entries {
                write(gpu, &self.one.1, bytemuck::cast_slice(&entries), 16);
                self.one.0 = entries;
            }
        }
        if looks.by_label && !looks.row_a_label {
            let texels = looks.label_texels(frame, &|id| pools.value_of_texel(id));
            if self.label_looks.0 != texels {
                let size = [256, texels.len() as u32 / 256];
                self.label_looks.1 = data(gpu, "labels' looks", size, COLOUR);
                write(gpu, &self.label_looks.1, bytemuck::cast_slice(&texels), 16);
                self.label_looks.0 = texels;
            }
        }
        let colours = looks.segment_colours(frame);
        if self.segments.0 != colours {
            let size = [256, colours.len() as u32 / 256];
            self.segments.1 = data(gpu, "segment colours", size, wgpu::TextureFormat::Rgba8Unorm);
            write(gpu, &self.segments.1, bytemuck::cast_slice(&colours), 4);
            self.segments.0 = colours;
        }
    }

    /// The table of looks, of which only rows that changed are made anew.
    fn set_rows(&mut self, gpu: &Gpu, frame: &Frame, looks: &Looks) {
        let each = looks.rows_each();
        let serves = |t: &LookTable| (t.step_mm, t.each) == (frame.step_mm, each) && t.rows.len() >= looks.rows.len();
        let at = self.rows.iter().position(serves);
        let mut table = match at {
            Some(at) => self.rows.remove(at),
            None => {
                self.rows.truncate(TABLES - 1);
                let rows = looks.rows.len().next_power_of_two();
                LookTable {
                    step_mm: frame.step_mm,
                    each,
                    rows: vec![Written::No; rows],
                    texture: data(gpu, "looks", [ROW as u32, (rows * each) as u32], COLOUR),
                }
            }
        };
        let stale = |(i, row): (usize, &Row)| match (row, &table.rows[i]) {
            (Row::Look(row), Written::Look(old)) => !frame.look(*row).is(old),
            (Row::Nothing, Written::Nothing) => false,
            _ => true,
        };
        let stale: Vec<usize> = looks.rows.iter().enumerate().filter(|at| stale(*at)).map(|(i, _)| i).collect();
        let make = |&i: &usize| match looks.rows[i] {
            Row::Look(row) => (i, rows(frame.look(row), frame.step_mm, looks.refines)),
            Row::Nothing => (i, vec![[0.0; 4]; each * ROW]),
        };
        let made: Vec<_> = stale.par_iter().map(make).collect();
        for (i, texels) in made {
            gpu.queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    origin: wgpu::Origin3d { x: 0, y: (i * each) as u32, z: 0 },
                    ..table.texture.as_image_copy()
                },
                bytemuck::cast_slice(&texels),
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(16 * ROW as u32), rows_per_image: None },
                wgpu::Extent3d { width: ROW as u32, height: each as u32, depth_or_array_layers: 1 },
            );
            table.rows[i] = match looks.rows[i] {
                Row::Look(row) => Written::Look(Box::new(frame.look(row).to_look())),
                Row::Nothing => Written::Nothing,
            };
        }
        self.rows.insert(0, table);
    }
}
