//! Pictures of the head whose segments have looks of their own: of a thousand, of one, of none.

use super::head::{Failure, camera, frame, head};
use super::measure::{Report, Time, measure_by_turns};
use burin::gpu::{Body, Caster, FieldPools, Frame, Gpu, LabelLooks, Look};
use burin::math::DVec3;
use burin::volume::{BRICK, Brick, Field, FieldKind, Grid, Lighting, Mode};
use std::sync::Arc;

const CENTRE: DVec3 = DVec3::new(127.5, 127.5, 82.5);
/// Segments along an axis of the volume.
const ALONG: u32 = 10;

/// Every voxel labelled with the block of `along`³ that it lies in, from 1 on.
fn labelled(grid: &Grid, along: u32) -> Result<Field, Failure> {
    let mut labels = Field::blank(FieldKind::Labels, grid);
    let changes = labels.brick_indices(0).into_iter().map(|index| {
        let origin = index.origin();
        let mut texels = Vec::with_capacity((BRICK * BRICK * BRICK * 2) as usize);
        for i in 0..BRICK * BRICK * BRICK {
            let at = [i % BRICK, i / BRICK % BRICK, i / BRICK / BRICK];
            let block: [u32; 3] = std::array::from_fn(|a| ((origin[a] + at[a]) * along / grid.dims[a]).min(along - 1));
            let label = 1 + block[0] + along * (block[1] + along * block[2]);
            texels.extend_from_slice(&(label as u16).to_le_bytes());
        }
        (index, Some(Brick::from_texels(texels, 2)))
    });
    let changes = changes.collect();
    labels.swap(changes)?;
    Ok(labels)
}

/// The frame with as many segments as have looks: the picture's own transfer function in another colour each, so that every picture has
/// as much to composite.
fn dressed(plain: Frame, segments: u32) -> Frame {
    if segments == 0 {
        return plain;
    }
    let look = |n: u32| {
        let mut transfer = plain.transfer.clone();
        let hue = |shift: u32| ((n * 37 + shift * 85) % 256) as f32 / 255.0;
        transfer.colour.iter_mut().for_each(|(_, colour)| *colour = [hue(0), hue(1), hue(2)]);
        Look { transfer, mode: plain.mode, lighting: plain.lighting, opacity: 1.0 }
    };
    let looks: Vec<Look> = (0..segments).map(look).collect();
    let by_label = (0..segments).map(|n| (n as u16 + 1, Some(n as usize))).collect();
    let labels = Some(Arc::new(LabelLooks { default: Some(0), by_label }));
    Frame { looks, bodies: vec![Body { labels, ..Body::whole(0) }], ..plain }
}

/// A thousand segments beside one, and one beside none, by turns.
pub fn labels(report: &mut Report) -> Result<(), Failure> {
    let gpu = Gpu::headless()?;
    let counts = [0, 1, ALONG * ALONG * ALONG];
    let mut stages = counts.map(|count| -> Result<_, Failure> {
        let mut volume = head()?;
        volume.labels = match count {
            0 => Field::blank(FieldKind::Labels, &volume.grid),
            1 => labelled(&volume.grid, 1)?,
            _ => labelled(&volume.grid, ALONG)?,
        };
        let pools = FieldPools::new(&gpu, &volume.grid, &volume.density, 1 << 30)?;
        Ok((volume, pools, Caster::new(&gpu)?))
    });
    let [Ok(none), Ok(one), Ok(many)] = &mut stages else { return Err("a stage could not be made".into()) };
    for (words, mode, light, refine) in [
        ("unshaded", Mode::Dvr, None, false),
        ("shaded", Mode::Dvr, Some(Lighting::default()), false),
        ("shaded and refined", Mode::Dvr, Some(Lighting::default()), true),
        ("iso-surface at 60", Mode::Iso(60.0), Some(Lighting::default()), false),
    ] {
        let make = |i: usize, count: u32| {
            let plain = frame(camera(CENTRE, 480.0, i), mode, light.is_some(), vec![Body::whole(0)]);
            dressed(Frame { refine, ..plain }, count)
        };
        let [none, one, many]: [Time; 3] = measure_by_turns(2, 11, |which, i| -> Result<(), Failure> {
            let (volume, pools, caster) = match which {
                0 => &mut *none,
                1 => &mut *one,
                _ => &mut *many,
            };
            let image = caster.image(&gpu, pools, &volume.fields(), &make(i, counts[which]))?;
            let shown = image.colour.iter().filter(|c| c[3] > 0.0).count();
            if shown < image.colour.len() / 10 { Err("a blank picture".into()) } else { Ok(()) }
        })?;
        report.row(&format!("head, {words}, no segment"), none, "");
        report.row(&format!("head, {words}, 1 segment"), one, &format!("{:.2} of none (CPU)", one.cpu / none.cpu));
        let beside = format!("{:.2} of one (CPU)", many.cpu / one.cpu);
        report.row(&format!("head, {words}, 1000 segments, each with a look"), many, &beside);
    }
    Ok(())
}
