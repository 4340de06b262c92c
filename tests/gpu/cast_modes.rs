//! DVR, iso-surface and MIP of one volume against the reference.

use super::reference::{Dense, Difference, difference, picture};
use crate::common::gpu::gpu;
use crate::common::volumes::*;
use burin::gpu::{Caster, FieldPools, Fields, Frame, Gpu, Image};
use burin::math::{Camera, DAffine3, DMat3, DQuat, DVec3, Projection};
use burin::volume::*;

/// Everything of one volume.
pub struct Stage {
    pub gpu: Gpu,
    pub grid: Grid,
    pub fields: [Field; 4],
    pub pools: FieldPools,
    pub caster: Caster,
}

impl Stage {
    pub fn new(gpu: Gpu, grid: Grid, density: Field) -> Self {
        let pools = FieldPools::new(&gpu, &grid, &density, 256 << 20).unwrap();
        let blank = |kind| Field::blank(kind, &grid);
        let fields = [density, blank(FieldKind::Colour), blank(FieldKind::Selection), blank(FieldKind::Labels)];
        let caster = Caster::new(&gpu).unwrap();
        Self { gpu, grid, fields, pools, caster }
    }

    pub fn fields(&self) -> Fields<'_> {
        let [density, colour, selection, labels] = &self.fields;
        one_volume(&self.grid, density, colour, selection, labels)
    }

    pub fn image(&mut self, frame: &Frame) -> Image {
        let [density, colour, selection, labels] = &self.fields;
        let fields = one_volume(&self.grid, density, colour, selection, labels);
        self.caster.image(&self.gpu, &mut self.pools, &fields, frame).unwrap()
    }

    /// The picture with every brick of density in a slot of its own.
    pub fn image_apart(&mut self, frame: &Frame) -> Image {
        let [density, colour, selection, labels] = &self.fields;
        let fields = one_volume(&self.grid, density, colour, selection, labels);
        let mut pools = FieldPools::apart(&self.gpu, &self.grid, density, 256 << 20).unwrap();
        self.caster.image(&self.gpu, &mut pools, &fields, frame).unwrap()
    }

    pub fn compare(&mut self, frame: &Frame) -> Difference {
        let image = self.image(frame);
        let apart = self.image_apart(frame);
        // The same numbers at other places of the texture: sampler weights differ in their last bit, and a hit at the edge of a
        // step moves with them.
        let far = |(a, b): (&[f32; 4], &[f32; 4])| (0..4).any(|i| (a[i] - b[i]).abs() > 0.2 / 255.0);
        let moved = image.colour.iter().zip(&apart.colour).filter(|&pair| far(pair)).count();
        assert!(moved * 500 <= image.colour.len(), "in place {moved} of {} pixels are others", image.colour.len());
        let reference = picture(&Dense::of(&self.fields(), &self.grid), frame);
        let d = difference(&image, &reference, frame.step_mm);
        println!("{:?} lit {} {:?}: {d:?}", frame.mode, frame.lighting.is_some(), frame.camera.projection);
        d
    }
}

/// Anisotropic, oblique, several bricks.
pub fn oblique_grid(dims: [u32; 3]) -> Grid {
    let turn = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(0.3, -0.5, 0.8)));
    Grid {
        dims,
        world_from_index: DAffine3 {
            matrix3: turn * DMat3::from_diagonal(DVec3::new(0.8, 1.0, 1.5)),
            translation: DVec3::new(-17.0, 30.0, 5.0),
        },
    }
}

/// Smooth lumps that fade at the volume's faces, 0..60,000.
pub fn lumps(grid: Grid) -> Field {
    let n = grid.dims.map(f64::from);
    density_u16(grid, move |v| {
        let u: [f64; 3] = std::array::from_fn(|a| (f64::from(v[a]) + 0.5) / n[a]);
        let rim: f64 = u.iter().map(|x| (12.0 * x * (1.0 - x)).min(1.0)).product();
        let wave = (9.0 * u[0] + 2.0 * u[2]).sin() * (7.0 * u[1]).cos() + (11.0 * u[2] - 3.0 * u[0]).sin();
        (60_000.0 * (0.5 + 0.25 * wave).clamp(0.0, 1.0) * rim) as u16
    })
}

pub fn tissue() -> TransferFunction {
    TransferFunction {
        colour: vec![(0.0, [0.0; 3]), (15_000.0, [0.5, 0.2, 0.1]), (30_000.0, [0.9, 0.7, 0.5]), (60_000.0, [1.0; 3])],
        opacity: vec![(12_000.0, 0.0), (40_000.0, 0.25), (60_000.0, 0.4)],
        unit_mm: 1.0,
    }
}

pub fn projections(frame: &Frame) -> [Frame; 2] {
    let near = frame.camera.zoomed(0.75);
    let height_mm = 0.4 * (frame.camera.eye - frame.camera.target).length();
    let flat = Camera { projection: Projection::Orthographic { height_mm }, ..frame.camera };
    [Frame { camera: near, ..frame.clone() }, Frame { camera: flat, ..frame.clone() }]
}

fn stage() -> Option<Stage> {
    let gpu = gpu()?;
    let grid = oblique_grid([70, 44, 36]);
    Some(Stage::new(gpu, grid, lumps(grid)))
}

#[test]
fn dvr_is_the_references() {
    let Some(mut stage) = stage() else { return };
    let view = frame(&stage.grid, tissue(), DVec3::new(1.0, -2.0, 0.7), [72, 60]);
    for frame in projections(&view) {
        for step_mm in [0.8, 1.7] {
            let d = stage.compare(&Frame { step_mm, ..frame.clone() });
            assert!(d.covered > 0.15 && d.largest <= 1.0 && d.misplaced < 0.002, "{d:?}");
        }
        let d = stage.compare(&Frame { lighting: Some(Lighting::default()), ..frame.clone() });
        assert!(d.largest <= 3.0 && d.mean <= 0.2 && d.misplaced < 0.002, "{d:?}");
    }
}

#[test]
fn an_iso_surface_is_the_references() {
    let Some(mut stage) = stage() else { return };
    let view = frame(&stage.grid, tissue(), DVec3::new(-1.0, -1.0, 1.2), [72, 60]);
    for frame in projections(&view) {
        for lighting in [None, Some(Lighting::default())] {
            let d = stage.compare(&Frame { mode: Mode::Iso(26_000.0), lighting, ..frame.clone() });
            assert!(d.covered > 0.15 && d.beyond_one < 0.01 && d.misplaced < 0.01, "{d:?}");
        }
    }
}

#[test]
fn mip_is_the_references() {
    let Some(mut stage) = stage() else { return };
    let view = frame(&stage.grid, tissue(), DVec3::new(0.2, 2.0, 0.7), [72, 60]);
    for frame in projections(&view) {
        let d = stage.compare(&Frame { mode: Mode::Mip, ..frame.clone() });
        assert!(d.covered > 0.15 && d.largest <= 1.0, "{d:?}");
    }
}
