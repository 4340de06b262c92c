//! Pictures of the head: by mode, exploded, unexploded in many parts, beside a dense texture, from a pool that is too small.

use super::dense::Dense;
use super::head::{Failure, Volume, blocks, camera, frame, head};
use super::measure::{Report, Time, measure, measure_by_turns};
use burin::gpu::{Body, Caster, FieldPools, Form, Frame, Gpu};
use burin::math::DVec3;
use burin::volume::Mode;
use serde_json::json;

const CENTRE: DVec3 = DVec3::new(127.5, 127.5, 82.5);
const ALL: u64 = 1 << 30;

struct Stage {
    gpu: Gpu,
    volume: Volume,
    pools: FieldPools,
    caster: Caster,
}

impl Stage {
    fn new(budget: u64) -> Result<Self, Failure> {
        let gpu = Gpu::headless()?;
        let volume = head()?;
        let pools = FieldPools::new(&gpu, &volume.grid, &volume.density, budget)?;
        let caster = Caster::new(&gpu)?;
        Ok(Self { gpu, volume, pools, caster })
    }

    /// Median time of a turning camera's frames; the last is drawn again untimed and must be the same picture.
    fn time(&mut self, make: impl Fn(usize) -> Frame) -> Result<Time, Failure> {
        let [time] = self.time_by_turns([&make])?;
        Ok(time)
    }

    /// The same for several that take turns.
    fn time_by_turns<const N: usize>(&mut self, make: [&dyn Fn(usize) -> Frame; N]) -> Result<[Time; N], Failure> {
        let (warm, count) = (2, 11);
        let mut last = [const { None }; N];
        let times = measure_by_turns(warm, count, |which, i| -> Result<(), Failure> {
            last[which] =
                Some(self.caster.image(&self.gpu, &mut self.pools, &self.volume.fields(), &make[which](i))?);
            Ok(())
        })?;
        for (make, last) in make.iter().zip(last) {
            let again =
                self.caster.image(&self.gpu, &mut self.pools, &self.volume.fields(), &make(warm + count - 1))?;
            let shown = again.colour.iter().filter(|c| c[3] > 0.0).count();
            if last.is_none_or(|l| l.colour != again.colour) || shown < again.colour.len() / 10 {
                return Err("a timed picture differs from the untimed one, or is blank".into());
            }
        }
        Ok(times)
    }
}

fn turning(mode: Mode, shaded: bool) -> impl Fn(usize) -> Frame {
    move |i| frame(camera(CENTRE, 480.0, i), mode, shaded, vec![Body::whole(0)])
}

pub fn modes(report: &mut Report) -> Result<(), Failure> {
    let mut stage = Stage::new(ALL)?;
    let row = |test: &str| {
        [("kind", json!("volume")), ("test", json!(test)), ("volume", json!("head")), ("backend", json!("egl"))]
    };
    let t = stage.time(turning(Mode::Dvr, false))?;
    report.beside("head, unshaded", t, "VTK fixed-point", &row("fixedpoint_unshaded"), false);
    let t = stage.time(turning(Mode::Dvr, true))?;
    report.beside("head, shaded", t, "VTK fixed-point", &row("fixedpoint_shaded"), false);
    let t = stage.time(turning(Mode::Mip, false))?;
    report.beside("head, MIP", t, "VTK GPU mapper", &row("gpu_mip"), false);
    let t = stage.time(turning(Mode::Iso(60.0), true))?;
    report.beside("head, iso-surface at 60", t, "VTK GPU mapper", &row("gpu_isosurface60"), false);
    Ok(())
}

pub fn exploded(report: &mut Report) -> Result<(), Failure> {
    let mut stage = Stage::new(ALL)?;
    for n in [1, 8, 64] {
        let t = stage.time(|i| {
            // The other programs stand a quarter further off, about the centre of the exploded box.
            let far = camera(DVec3::new(127.5, 127.5, 82.5), 480.0 * 1.25, i);
            frame(far, Mode::Dvr, false, blocks(n, 0.35, 6.0))
        })?;
        let row = [("kind", json!("exploded")), ("mode", json!("fixed")), ("parts", json!(n))];
        report.beside(&format!("head exploded into {n}, unshaded"), t, "VTK fixed-point", &row, false);
    }
    Ok(())
}

pub fn unexploded(report: &mut Report) -> Result<(), Failure> {
    let mut stage = Stage::new(ALL)?;
    let parts = |n| move |i| frame(camera(CENTRE, 480.0, i), Mode::Dvr, false, blocks(n, 0.0, 0.0));
    let [one, many] = stage.time_by_turns([&parts(1), &parts(64)])?;
    report.row("head in 1 part, unexploded", one, "");
    report.row("head in 64 parts, unexploded", many, &format!("{:.2} of 1 part (CPU)", many.cpu / one.cpu));
    Ok(())
}

/// The caster's two forms by turns: workgroups beside fragments.
pub fn forms(report: &mut Report) -> Result<(), Failure> {
    let mut stages = [Form::Fragments, Form::Workgroups].map(|form| {
        let mut stage = Stage::new(ALL)?;
        stage.caster.set_form(form);
        Ok::<_, Failure>(stage)
    });
    let [Ok(fragments), Ok(workgroups)] = &mut stages else { return Err("a stage could not be made".into()) };
    let far = |i| camera(DVec3::new(127.5, 127.5, 82.5), 480.0 * 1.25, i);
    let apart = |n| move |i| frame(far(i), Mode::Dvr, false, blocks(n, 0.35, 6.0));
    let together = |i| frame(camera(CENTRE, 480.0, i), Mode::Dvr, false, blocks(8, -0.1, 6.0));
    let cases: [(&str, &dyn Fn(usize) -> Frame); 7] = [
        ("unshaded", &turning(Mode::Dvr, false)),
        ("shaded", &turning(Mode::Dvr, true)),
        ("MIP", &turning(Mode::Mip, false)),
        ("iso-surface at 60", &turning(Mode::Iso(60.0), true)),
        ("exploded into 8", &apart(8)),
        ("exploded into 64", &apart(64)),
        ("8 parts pushed together", &together),
    ];
    for (name, make) in cases {
        let mut last = [const { None }; 2];
        let [a, b] = measure_by_turns(2, 11, |which, i| -> Result<(), Failure> {
            let stage = if which == 0 { &mut *fragments } else { &mut *workgroups };
            last[which] = Some(stage.caster.image(&stage.gpu, &mut stage.pools, &stage.volume.fields(), &make(i))?);
            Ok(())
        })?;
        if last[0] != last[1] {
            return Err(format!("{name}: the forms draw different pictures").into());
        }
        report.row(&format!("head, {name}, fragments"), a, "");
        report.row(&format!("head, {name}, workgroups"), b, &format!("{:.2} of fragments (CPU)", b.cpu / a.cpu));
    }
    Ok(())
}

/// Bricks in place and apart beside one dense texture, and beside marching every sample, unshaded and shaded.
pub fn plain(report: &mut Report) -> Result<(), Failure> {
    let mut stage = Stage::new(ALL)?;
    let dense = Dense::new(&stage.gpu, &stage.volume, [512; 2])?;
    let mut apart = Stage::new(ALL)?;
    apart.pools = FieldPools::apart(&apart.gpu, &apart.volume.grid, &apart.volume.density, ALL)?;
    for (words, shaded) in [("unshaded", false), ("shaded", true)] {
        let make = turning(Mode::Dvr, shaded);
        let mut last = Vec::new();
        let plain = measure(2, 11, |i| -> Result<(), Failure> {
            last = dense.image(&stage.gpu, &make(i))?;
            Ok(())
        })?;
        report.row(&format!("head, {words}, one dense texture"), plain, "");
        let beside = |name: &str, stage: &mut Stage| -> Result<(), Failure> {
            let time = stage.time(&make)?;
            let image = stage.caster.image(&stage.gpu, &mut stage.pools, &stage.volume.fields(), &make(12))?;
            let far = |(a, b): (&[f32; 4], &[f32; 4])| (0..4).map(|i| (a[i] - b[i]).abs()).fold(0.0, f32::max) * 255.0;
            let mean = last.iter().zip(&image.colour).map(far).sum::<f32>() / last.len() as f32;
            if mean > 0.2 {
                return Err(format!("{name}: {mean}/255 from the dense picture on average").into());
            }
            let ratio = format!("{:.2} of dense (CPU), pictures {mean:.4}/255 apart", time.cpu / plain.cpu);
            report.row(&format!("head, {words}, {name}"), time, &ratio);
            Ok(())
        };
        beside("bricks in place", &mut stage)?;
        beside("bricks apart", &mut apart)?;
        stage.caster.shortcuts = false;
        beside("every sample", &mut stage)?;
        stage.caster.shortcuts = true;
    }
    Ok(())
}

pub fn pool(report: &mut Report) -> Result<(), Failure> {
    let mut whole = Stage::new(ALL)?;
    let full = whole.time(turning(Mode::Dvr, false))?;
    let (slots, _) = whole.pools.room(burin::volume::FieldKind::Density);
    report.note(&format!("all bricks: {slots} slots"));
    report.row("head, all bricks resident", full, "");
    let bytes = 34_u64.pow(3) * 2;
    // Half of a budget is density's.
    let mut eighth = Stage::new(slots as u64 / 8 * bytes * 2)?;
    let t = eighth.time(turning(Mode::Dvr, false))?;
    report.row("head, an eighth of the bricks", t, &format!("{:.2} of all resident (CPU)", t.cpu / full.cpu));
    Ok(())
}
