//! Strokes on the GPU against equations 1 and 2 over dense arrays, in the form P′ = P + G·((C op P) − P).

mod clicks;
mod live;
mod pictures;
mod reference;
mod several;
mod slots;
mod strokes;

use crate::common::falloffs::*;
use crate::common::gpu::gpu;
use crate::common::one::of_one;
use crate::common::volumes::*;
use burin::gpu::{FieldPools, Gpu, Painter};
use burin::math::{DAffine3, DMat3, DVec3};
use burin::paint::*;
use burin::volume::*;
use rand::{Rng, SeedableRng, rngs::StdRng};

const DIMS: [u32; 3] = [40, 36, 34];

/// Slabs, turned and sheared.
fn grids() -> [Grid; 3] {
    [0, 1, 2].map(|kind| grid_of(DIMS, kind))
}

/// Each slim enough for an oracle of many brushes, across one border of bricks; the last across all three.
fn oracle_grids() -> [Grid; 4] {
    [grid_of([40, 12, 9], 0), grid_of([11, 36, 10], 1), grid_of([12, 9, 34], 2), grid_of(DIMS, 2)]
}

fn grid_of(dims: [u32; 3], kind: usize) -> Grid {
    let turned = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    let sheared = DMat3::from_cols(DVec3::X * 0.9, DVec3::new(0.3, 0.9, 0.0), DVec3::new(-0.4, 0.5, 1.6));
    let slabs = DMat3::from_diagonal(DVec3::new(0.7, 0.9, 2.5));
    let matrix3 = [slabs, turned, sheared][kind];
    Grid { dims, world_from_index: DAffine3 { matrix3, translation: DVec3::new(-31.5, 12.25, 100.0) } }
}

/// The bricks that the only volume's stroke shows in.
fn touched(painter: &Painter) -> Vec<BrickIndex> {
    painter.touched().into_iter().map(|(_, brick)| brick).collect()
}

/// Four fields with something in every voxel, on the GPU.
struct Canvas {
    grid: Grid,
    density: Field,
    /// Density without edits.
    base: Vec<u8>,
    colour: Field,
    selection: Field,
    labels: Field,
    pools: FieldPools,
    painter: Painter,
    segments: Segments,
    reach: Reach,
}

fn noise(v: [u32; 3], salt: u32) -> u32 {
    let h = v[0].wrapping_mul(0x9e37_79b1) ^ v[1].wrapping_mul(0x85eb_ca6b) ^ v[2].wrapping_mul(0xc2b2_ae35) ^ salt;
    let h = (h ^ h >> 15).wrapping_mul(0x2c1b_3c6d);
    h ^ h >> 13
}

impl Canvas {
    fn new(gpu: &Gpu, grid: Grid, density: Field) -> Self {
        let colour = painted(FieldKind::Colour, &grid, |v| {
            let n = noise(v, 1);
            if n.is_multiple_of(3) { [0; 4] } else { (n | 1 << 24).to_le_bytes() }
        });
        let selection = painted(FieldKind::Selection, &grid, |v| [noise(v, 2) as u8, 0, 0, 0]);
        let labels = painted(FieldKind::Labels, &grid, |v| [[0, 5, 2, 255][noise(v, 3) as usize % 4], 0, 0, 0]);
        let pools = FieldPools::new(gpu, &grid, &density, 64 << 20).unwrap();
        let mut segments = Segments::default();
        for id in [2, 5, 255] {
            segments.ensure(id);
        }
        segments.get_mut(2).unwrap().locked = true;
        let painter = Painter::new(gpu).unwrap();
        let base = density.read(0, [0; 3], grid.dims).unwrap();
        Self { grid, base, density, colour, selection, labels, pools, painter, segments, reach: Reach([0.0; 2]) }
    }

    /// Nothing painted, density 0.
    fn blank(gpu: &Gpu, grid: Grid) -> Self {
        let density = density_u16(grid, |_| 0);
        let pools = FieldPools::new(gpu, &grid, &density, 64 << 20).unwrap();
        Self {
            grid,
            base: density.read(0, [0; 3], grid.dims).unwrap(),
            density,
            colour: Field::blank(FieldKind::Colour, &grid),
            selection: Field::blank(FieldKind::Selection, &grid),
            labels: Field::blank(FieldKind::Labels, &grid),
            pools,
            painter: Painter::new(gpu).unwrap(),
            segments: Segments::default(),
            reach: Reach([0.0; 2]),
        }
    }

    fn codes(gpu: &Gpu, grid: Grid) -> Self {
        Self::new(gpu, grid, density_u16(grid, |v| noise(v, 0) as u16))
    }

    fn floats(gpu: &Gpu, grid: Grid) -> Self {
        Self::new(
            gpu,
            grid,
            density_f32(grid, |v| match noise(v, 0) % 50 {
                0 => f32::NAN,
                1 => f32::INFINITY,
                n => n as f32 * 3.7 - 60.0,
            }),
        )
    }

    /// New pools, with every brick of density in a slot of its own or in place.
    fn lay(&mut self, gpu: &Gpu, apart: bool) {
        let make = if apart { FieldPools::apart } else { FieldPools::new };
        self.pools = make(gpu, &self.grid, &self.density, 64 << 20).unwrap();
        assert_eq!(self.in_place(gpu, FieldKind::Density), !apart);
    }

    fn in_place(&self, gpu: &Gpu, kind: FieldKind) -> bool {
        kind == FieldKind::Density && self.pools.defs(gpu).iter().any(|d| d.0 == "IN_PLACE")
    }

    fn field(&self, kind: FieldKind) -> &Field {
        match kind {
            FieldKind::Density => &self.density,
            FieldKind::Colour => &self.colour,
            FieldKind::Selection => &self.selection,
            FieldKind::Labels => &self.labels,
        }
    }

    fn field_mut(&mut self, kind: FieldKind) -> &mut Field {
        match kind {
            FieldKind::Density => &mut self.density,
            FieldKind::Colour => &mut self.colour,
            FieldKind::Selection => &mut self.selection,
            FieldKind::Labels => &mut self.labels,
        }
    }

    fn texels(&self, kind: FieldKind) -> Vec<u8> {
        self.field(kind).read(0, [0; 3], self.grid.dims).unwrap()
    }

    fn begin(&mut self, brush: &Brush) {
        let Self { grid, density, colour, selection, labels, painter, segments, reach, .. } = self;
        let fields = one_volume(grid, density, colour, selection, labels);
        painter.begin(VolumeId::FIRST, &fields, brush, segments, *reach).unwrap();
    }

    fn extend(&mut self, dabs: &[Dab]) -> Vec<BrickIndex> {
        let Self { grid, density, colour, selection, labels, painter, pools, .. } = self;
        let fields = one_volume(grid, density, colour, selection, labels);
        let met = painter.extend(pools, &fields, &[(VolumeId::FIRST, dabs)]).unwrap();
        met.into_iter().map(|(_, brick)| brick).collect()
    }

    fn finish(&mut self) -> Vec<(BrickIndex, Brick)> {
        let Self { grid, density, colour, selection, labels, painter, pools, .. } = self;
        let fields = one_volume(grid, density, colour, selection, labels);
        of_one(painter.finish(pools, &fields).unwrap())
    }

    /// A whole stroke in three frames; answers the texels that the field then has. The field itself stays as it was.
    fn paint(&mut self, brush: &Brush, dabs: &[Dab]) -> Vec<u8> {
        let kind = brush.target.field();
        self.begin(brush);
        for part in dabs.chunks(dabs.len().div_ceil(3).max(1)) {
            self.extend(part);
        }
        let changed = self.finish();
        let mut after = self.field(kind).clone();
        for (index, brick) in &changed {
            assert_ne!(brick, &after.brick(BrickKey { level: 0, index: *index }).unwrap(), "{index:?} did not change");
        }
        let (_, refresh) = after.swap(changed.into_iter().map(|(i, b)| (i, Some(b))).collect()).unwrap();
        // The slots must show the unchanged field again before the next stroke.
        let gpu = gpu().unwrap();
        let Self { grid, density, colour, selection, labels, pools, .. } = self;
        let fields = one_volume(grid, density, colour, selection, labels);
        pools.refresh(&gpu, kind, fields.field(kind.into()).unwrap(), &refresh).unwrap();
        after.read(0, [0; 3], self.grid.dims).unwrap()
    }
}

fn dab_at(grid: &Grid, index: DVec3, radius_mm: f64) -> Dab {
    let m = grid.world_from_index;
    let normal = m.matrix3.x_axis.cross(m.matrix3.y_axis).normalize();
    Dab { centre: m.transform_point3(index), radius_mm, pressure: 1.0, normal }
}
