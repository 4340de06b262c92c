//! Ten volumes of 256³ voxels of 16 bits in 128 MB of pools, beside all of them whole: what is drawn, and what it costs.

use super::head::{Failure, Volume, frame};
use super::measure::{Report, measure};
use burin::gpu::{Body, Caster, FieldPools, Fields, Frame, Gpu};
use burin::math::{Camera, DVec3, Projection};
use burin::volume::{FieldKind, Grid, Mode, TransferFunction, VolumeId, Voxels};

const COUNT: u32 = 10;
const SIDE: u32 = 256;
const BUDGET: u64 = 128 << 20;

/// Beads of several sizes, another arrangement in every volume.
fn voxels(n: u32) -> Vec<u16> {
    use rayon::prelude::*;
    let slice = |z: u32| {
        (0..SIDE * SIDE).map(move |i| {
            let p = [i % SIDE, i / SIDE, z].map(|v| f64::from(v) * 0.09);
            let wave = (p[0] + f64::from(n)).sin() + (p[1] * 1.3).sin() + (p[2] * 0.7 + f64::from(n) * 0.5).cos();
            (20_000.0 + 10_000.0 * wave).max(0.0) as u16
        })
    };
    (0..SIDE).into_par_iter().flat_map_iter(slice).collect()
}

/// A row of volumes along x that is seen from its end.
pub fn volumes(report: &mut Report) -> Result<(), Failure> {
    let gpu = Gpu::headless()?;
    let at = |n: u32| Grid::aligned([SIDE; 3], DVec3::ONE, DVec3::new(f64::from(n) * 280.0, 0.0, 0.0));
    let all = (0..COUNT).map(|n| Volume::on(at(n), Voxels::U16(voxels(n)), 65_535.0));
    let all = all.collect::<Result<Vec<_>, _>>()?;
    let mut fields = Fields::default();
    for (n, volume) in (0..).zip(&all) {
        fields.put(VolumeId(n), volume.volume_fields());
    }
    let transfer = TransferFunction {
        colour: vec![(0.0, [0.9, 0.4, 0.2]), (50_000.0, [1.0; 3])],
        opacity: vec![(36_000.0, 0.0), (42_000.0, 0.08)],
        unit_mm: 1.0,
    };
    let view = |i: usize| {
        let eye = DVec3::new(-300.0, 128.0 + 6.0 * i as f64, 360.0);
        let target = DVec3::new(1400.0, 128.0, 100.0);
        let camera = Camera { eye, target, up: DVec3::Z, projection: Projection::Perspective { fov_y_deg: 40.0 } };
        let bodies = (0..COUNT).map(|n| Body { volume: VolumeId(n), ..Body::whole(n) }).collect();
        Frame { transfer: transfer.clone(), ..frame(camera, Mode::Dvr, false, bodies) }
    };
    let mut caster = Caster::new(&gpu)?;
    let mut tight = FieldPools::empty(&gpu, BUDGET)?;
    let time = measure(2, 11, |i| caster.image(&gpu, &mut tight, &fields, &view(i)).map(drop))?;
    let (held, most) = tight.room(FieldKind::Density);
    let image = caster.image(&gpu, &mut tight, &fields, &view(0))?;
    drop(tight);
    let mut whole = FieldPools::empty(&gpu, 2 << 30)?;
    let wanted = caster.image(&gpu, &mut whole, &fields, &view(0))?;
    // By volume: pixels of it, how far they are from those of the whole volumes, and those that are missing.
    let mut sums = vec![(0_u32, 0.0_f64); COUNT as usize];
    let mut missing = 0;
    for (i, object) in wanted.object.iter().enumerate() {
        let Some(volume) = object.volume() else { continue };
        missing += u32::from(wanted.colour[i][3] > 0.2 && image.colour[i][3] < 0.02);
        let off = (0..4).map(|c| (wanted.colour[i][c] - image.colour[i][c]).abs()).fold(0.0, f32::max);
        let sum = &mut sums[volume.0 as usize];
        *sum = (sum.0 + 1, sum.1 + f64::from(off) * 255.0);
    }
    if missing > 0 {
        return Err(format!("{missing} pixels of the whole volumes are missing from those of 128 MB").into());
    }
    let told: Vec<String> = sums.iter().map(|(n, sum)| format!("{:.1}", sum / f64::from(*n).max(1.0))).collect();
    report.note(&format!("mean difference from whole volumes, of 255, nearest volume first: {}", told.join(" ")));
    report.row("ten volumes of 256³ in 128 MB", time, &format!("{held} of {most} slots held"));
    Ok(())
}
