//! Dabs and what follows: the brush alone by the volume's size, and a stamp with the picture after it.

use super::cube::{apply, document, over};
use super::head::{Failure, Volume, frame};
use super::measure::{Report, measure, measure_by_turns};
use burin::gpu::{Body, Caster, FieldPools, Frame, Gpu, Painter};
use burin::math::{Camera, DQuat, DVec3};
use burin::paint::{Brush, Falloff, Reach, Sample, StrokePath, Target};
use burin::volume::{Mode, Segments, TransferFunction, Value, VolumeId};
use serde_json::json;

/// A volume that can be clicked on.
pub struct Easel {
    gpu: Gpu,
    volume: Volume,
    pools: FieldPools,
    painter: Painter,
}

impl Easel {
    /// A cube of 1 in the middle of n³ zeros, as the other programs paint into.
    fn new(n: u32) -> Result<Self, Failure> {
        let mut voxels = vec![0_u8; (n as usize).pow(3)];
        let (from, to) = (n as usize / 4, 3 * n as usize / 4);
        for z in from..to {
            for y in from..to {
                let row = n as usize * (y + n as usize * z);
                voxels[row + from..row + to].fill(1);
            }
        }
        Self::on(Gpu::headless()?, Volume::new([n; 3], u8::wrap(voxels), 2.0)?, 512 << 20)
    }

    /// Any volume on a device, with a budget in bytes.
    pub fn on(gpu: Gpu, volume: Volume, budget: u64) -> Result<Self, Failure> {
        let pools = FieldPools::new(&gpu, &volume.grid, &volume.density, budget)?;
        let painter = Painter::new(&gpu)?;
        Ok(Self { gpu, volume, pools, painter })
    }

    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// One click: a stroke of one dab, kept. Answers how many bricks changed.
    pub fn click(&mut self, brush: &Brush, at: DVec3) -> Result<usize, Failure> {
        let volume = &mut self.volume;
        self.painter.begin(VolumeId::FIRST, &volume.fields(), brush, &Segments::default(), Reach([0.0; 2]))?;
        let mut path = StrokePath::new(brush, &volume.grid)?;
        let dabs = path.extend(&[Sample { position: at, normal: DVec3::Z, pressure: 1.0, breaks: false }])?;
        self.painter.extend(&mut self.pools, &volume.fields(), &[(VolumeId::FIRST, &dabs)])?;
        let painted = self.painter.finish(&mut self.pools, &volume.fields())?;
        let changed: Vec<_> = painted.into_iter().flat_map(|(_, bricks)| bricks).collect();
        let bricks = changed.len();
        let kind = brush.target.field();
        let field = match kind {
            burin::volume::FieldKind::Density => &mut volume.density,
            burin::volume::FieldKind::Colour => &mut volume.colour,
            burin::volume::FieldKind::Selection => &mut volume.selection,
            burin::volume::FieldKind::Labels => &mut volume.labels,
        };
        let (_, refresh) = field.swap(changed.into_iter().map(|(i, b)| (i, Some(b))).collect())?;
        self.pools.refresh_painted(&self.gpu, kind, field, &refresh)?;
        Ok(bricks)
    }
}

/// The other programs' path: a quarter of the brush further every time, inside the volume.
fn path(n: f64, i: usize, diameter: f64) -> DVec3 {
    let margin = diameter / 2.0 + 2.0;
    let t = 0.37 * i as f64;
    let at = |f: f64| (margin + (n - 2.0 * margin) * (0.5 + 0.5 * (t * f).sin())).floor();
    DVec3::new(at(1.7), at(1.3), at(1.0))
}

pub fn dab(report: &mut Report) -> Result<(), Failure> {
    for (name, target) in [("density", Target::Density(2.0)), ("selection", Target::Selection(1.0))] {
        let brush = Brush { radius_mm: 32.0, falloff: Falloff::Smooth, target, ..Brush::default() };
        let mut easels = [Easel::new(128)?, Easel::new(512)?];
        let [small, large] = measure_by_turns(5, 60, |which, i| -> Result<(), Failure> {
            // The same places relative to bricks, in the middle of either volume.
            let middle = f64::from(easels[which].volume.grid.dims[0]) / 2.0;
            let at = DVec3::splat(middle) + path(24.0, i, 4.0) - 12.0;
            easels[which].click(&brush, at).map(|_| ())
        })?;
        report.row(&format!("dab of 64 voxels on {name}, 128³"), small, "");
        let ratio = large.cpu / small.cpu;
        report.row(&format!("dab of 64 voxels on {name}, 512³"), large, &format!("{ratio:.2} of 128³ (CPU)"));
    }
    Ok(())
}

/// A click as the program does it: from the point to a step of history.
pub fn click(report: &mut Report) -> Result<(), Failure> {
    let folder = tempfile::tempdir()?;
    let mut documents = [document(128, folder.path())?, document(512, folder.path())?];
    let targets = [
        ("density", json!({"density": 200.0})),
        ("selection", json!({"selection": 1.0})),
        ("colour", json!({"colour": [0.9, 0.3, 0.1, 0.8]})),
        ("labels", json!({"label": 3})),
    ];
    for (name, target) in targets {
        for document in &mut documents {
            let brush = json!({"radius_mm": 32.0, "falloff": "smooth", "shape": "sphere", "target": target});
            apply(document, json!({"brush": {"set": brush}}))?;
        }
        let [small, large] = measure_by_turns(5, 40, |which, i| -> Result<(), Failure> {
            let middle = [64.0, 256.0][which];
            let at = DVec3::splat(middle) + path(24.0, i, 4.0) - 12.0;
            let points = json!([{"at": {"mm": at.to_array()}}]);
            apply(&mut documents[which], json!({"stroke": {"paint": {"points": points}}})).map(|_| ())
        })?;
        report.row(&format!("click of 64 voxels on {name}, 128³"), small, "");
        let ratio = large.cpu / small.cpu;
        report.row(&format!("click of 64 voxels on {name}, 512³"), large, &format!("{ratio:.2} of 128³ (CPU)"));
    }
    Ok(())
}

/// The same click on a sub-volume, and on a volume that has its samples as voxels.
pub fn click_in_box(report: &mut Report) -> Result<(), Failure> {
    let folder = tempfile::tempdir()?;
    let mut boxed = document(65, folder.path())?;
    apply(&mut boxed, json!({"sub_volume": {"add": {"lo": [0, 0, 0], "hi": [64, 64, 64], "scale": 2}}}))?;
    let samples = {
        let state = boxed.state().ok_or("nothing is open")?;
        let density = &state.at(Some(burin::volume::VolumeId(1)))?.volume.density;
        let texels = density.read(0, [0; 3], density.dims(0))?;
        let texels = texels.chunks_exact(density.format().bytes());
        let value = |t: &[u8]| density.map().decode(std::array::from_fn(|i| t.get(i).copied().unwrap_or(0)));
        texels.map(|t| value(t).round() as u8).collect::<Vec<u8>>()
    };
    let mut documents = [over(samples, 129, folder.path())?, boxed];
    for (name, target) in [("density", json!({"density": 200.0})), ("selection", json!({"selection": 1.0}))] {
        for (document, radius) in documents.iter_mut().zip([32.0, 16.0]) {
            let brush = json!({"radius_mm": radius, "falloff": "smooth", "shape": "sphere", "target": target});
            apply(document, json!({"brush": {"set": brush}}))?;
        }
        let [plain, boxed] = measure_by_turns(5, 40, |which, i| -> Result<(), Failure> {
            let at = (DVec3::splat(64.0) + path(24.0, i, 4.0) - 12.0) * [1.0, 0.5][which];
            let paint = json!({"points": [{"at": {"mm": at.to_array()}}], "volume": which});
            apply(&mut documents[which], json!({"stroke": {"paint": paint}})).map(|_| ())
        })?;
        report.row(&format!("click of 64 voxels on {name}, 129³"), plain, "");
        let ratio = boxed.cpu / plain.cpu;
        report.row(
            &format!("click of 64 samples on {name}, a box of 129³"),
            boxed,
            &format!("{ratio:.2} of the plain volume (CPU)"),
        );
    }
    Ok(())
}

pub fn stamp(report: &mut Report) -> Result<(), Failure> {
    let mut easel = Easel::new(512)?;
    let mut caster = Caster::new(&easel.gpu)?;
    let bounds = easel.volume.grid.world_bounds();
    let front = Camera::framing(&bounds, DVec3::NEG_Y, DVec3::Z);
    let about = |axis: DVec3, degrees: f64, c: Camera| Camera {
        eye: c.target + DQuat::from_axis_angle(axis, f64::to_radians(degrees)) * (c.eye - c.target),
        ..c
    };
    let side = about(DVec3::Z, 30.0, front);
    let camera = about(side.right_up().0, -20.0, side);
    let transfer = TransferFunction {
        colour: vec![(1.0, [0.8, 0.6, 0.4]), (2.0, [1.0, 0.0, 0.0])],
        opacity: vec![(0.0, 0.0), (0.9, 0.0), (1.0, 0.05), (2.0, 0.9)],
        unit_mm: 1.0,
    };
    let frame = Frame { transfer, ..frame(camera, Mode::Dvr, false, vec![Body::whole(0)]) };
    let brush = Brush { radius_mm: 16.0, falloff: Falloff::Hard, target: Target::Density(2.0), ..Brush::default() };
    let mut picture = None;
    let time = measure(2, 9, |i| -> Result<(), Failure> {
        easel.click(&brush, path(512.0, i, 32.0))?;
        picture = Some(caster.image(&easel.gpu, &mut easel.pools, &easel.volume.fields(), &frame)?);
        Ok(())
    })?;
    let again = caster.image(&easel.gpu, &mut easel.pools, &easel.volume.fields(), &frame)?;
    if picture.is_none_or(|p| p.colour != again.colour) {
        return Err("a timed picture differs from the untimed one".into());
    }
    for mode in ["gpu", "fixed"] {
        let op = json!("stamp+Modified+redraw");
        let row = [("kind", json!("paint_to_pixels")), ("mode", json!(mode)), ("grid", json!(512)), ("op", op)];
        report.beside("32-voxel stamp and picture, 512³", time, &format!("VTK {mode}"), &row, true);
    }
    Ok(())
}
