//! What a data-centre card is measured by: 512³ voxels of 16 bits at 1920×1080, unshaded and shaded, and a dab of 64 voxels.
//!
//! The figure beside a mark is the time of the passes on the device where it tells it, else (and where the device is software) wall
//! time with everything else: a picture's way to the host, a stroke's brackets. On processors that draw in software a frame takes seconds, and there are fewer.

use super::head::{Failure, camera, frame, large, transfer};
use super::measure::{Report, Time, measure, median};
use super::paint::Easel;
use burin::gpu::{Body, Caster, FieldPools, Frame, Gpu};
use burin::math::DVec3;
use burin::paint::{Brush, Falloff, Target};
use burin::volume::Mode;
use std::time::Instant;

const BUDGET: u64 = 2 << 30;
/// Milliseconds.
const UNSHADED: f64 = 2.7;
const SHADED: f64 = 7.5;
const DAB: f64 = 0.1;
/// A first frame that takes longer, in seconds, is drawn three times more only.
const SLOW: f64 = 0.5;

fn view(i: usize, shaded: bool) -> Frame {
    let whole = frame(camera(DVec3::splat(255.5), 960.0, i), Mode::Dvr, shaded, vec![Body::whole(0)]);
    let mut function = transfer();
    function.colour.iter_mut().for_each(|point| point.0 *= 256.0);
    function.opacity.iter_mut().for_each(|point| point.0 *= 256.0);
    // As much matter on a ray as in half as many voxels.
    function.unit_mm = 2.0;
    Frame { size: [1920, 1080], transfer: function, ..whole }
}

/// Milliseconds of all passes of this name since the last reading.
fn on_device(gpu: &Gpu, name: &str) -> Result<Option<f64>, Failure> {
    let passes = gpu.pass_times()?.filter(|_| !gpu.is_software());
    Ok(passes.map(|p| p.iter().filter(|(pass, _)| *pass == name).map(|(_, ms)| ms).sum()))
}

/// The median on the device after runs that were not counted, beside the mark.
fn row(report: &Report, name: &str, time: Time, device: Vec<Option<f64>>, warm: usize, mark: f64) {
    let device: Option<Vec<f64>> = device.into_iter().skip(warm).collect();
    let (ms, words) = match device.filter(|d| !d.is_empty()).map(median) {
        Some(ms) => (ms, "on the device"),
        None => (time.wall, "wall with all else, for want of a clock on the device"),
    };
    let met = if ms <= mark { "met" } else { "missed" };
    report.row(name, time, &format!("{ms:.3} ms {words}, mark {mark} ms {met}"));
}

pub fn marks(report: &mut Report) -> Result<(), Failure> {
    let gpu = Gpu::headless_timed()?;
    let volume = large()?;
    let mut pools = FieldPools::new(&gpu, &volume.grid, &volume.density, BUDGET)?;
    let mut caster = Caster::new(&gpu)?;
    for (words, shaded, mark) in [("unshaded", false, UNSHADED), ("shaded", true, SHADED)] {
        let (mut device, mut last) = (Vec::new(), None);
        let mut draw = |i: usize| -> Result<(), Failure> {
            last = Some(caster.image(&gpu, &mut pools, &volume.fields(), &view(i, shaded))?);
            device.push(on_device(&gpu, "cast")?);
            Ok(())
        };
        // The first one brings bricks and compiles.
        draw(0)?;
        let start = Instant::now();
        draw(1)?;
        let count = if start.elapsed().as_secs_f64() > SLOW { 3 } else { 31 };
        let time = measure(0, count, |i| draw(i + 2))?;
        let again = caster.image(&gpu, &mut pools, &volume.fields(), &view(count + 1, shaded))?;
        let shown = again.colour.iter().filter(|c| c[3] > 0.0).count();
        if last.is_none_or(|l| l.colour != again.colour) || shown < again.colour.len() / 10 {
            return Err("a timed picture differs from the untimed one, or is blank".into());
        }
        on_device(&gpu, "cast")?;
        row(report, &format!("512³ u16 at 1920×1080, {words}"), time, device, 2, mark);
    }
    drop((pools, caster));
    dab(report, gpu, volume)
}

fn dab(report: &Report, gpu: Gpu, volume: super::head::Volume) -> Result<(), Failure> {
    let mut easel = Easel::on(gpu, volume, BUDGET)?;
    let target = Target::Density(40_000.0);
    let brush = Brush { radius_mm: 32.0, falloff: Falloff::Smooth, target, ..Brush::default() };
    let (warm, mut device) = (5, Vec::new());
    let time = measure(warm, 30, |i| -> Result<(), Failure> {
        easel.click(&brush, DVec3::splat(256.0 + i as f64))?;
        device.push(on_device(easel.gpu(), "dabs")?);
        Ok(())
    })?;
    row(report, "512³ u16, dab of 64 voxels on density", time, device, warm, DAB);
    Ok(())
}
