//! Table 1 of "Direct Volume Editing" (2008): what it costs to fill a box of n³ voxels at 2, 4 and 8 samples a voxel, density alone and
//! with colour, all of it forced.
//!
//! Beside each: the bytes written over what this machine's memory takes in the same run, and the plain brush kernel on as many voxels.

use super::head::{Failure, Volume};
use super::measure::{Report, Time, measure};
use super::paint::Easel;
use burin::gpu::Gpu;
use burin::math::DVec3;
use burin::paint::{Brush, Falloff, Operation, Target};
use burin::volume as voxels;
use burin::volume::{
    BRICK, Brick, BrickKey, DensityMap, FieldKind, Grid, Histogram, MemorySource, Statistics, SubBox, Voxels,
};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Voxels of the parent along an edge: one more than the largest box has, and what a box's edge asks for beyond it.
const PARENT: u32 = 70;

fn parent() -> Result<Arc<voxels::Volume>, Failure> {
    let grid = Grid::aligned([PARENT; 3], DVec3::ONE, DVec3::ZERO);
    let value = |i: u32| {
        let [x, y, z] = [i % PARENT, i / PARENT % PARENT, i / (PARENT * PARENT)].map(f64::from);
        (127.0 + 60.0 * ((x * 0.3).sin() + (y * 0.23 + z * 0.31).sin())) as u8
    };
    let source = MemorySource::new("bench", grid, Voxels::U8((0..PARENT.pow(3)).map(value).collect()), (1.0, 0.0))?;
    let statistics = Statistics { min: 0.0, max: 255.0, ..Statistics::default() };
    let map = DensityMap::codes(0.0, 255.0, Some(1.0));
    let made = voxels::Volume::new(Arc::new(source), map, statistics, Histogram::default(), &|_| true)?;
    let mut volume = made.ok_or("stopped")?;
    let paint = |index| {
        let texels = (0..burin::volume::BRICK_VOXELS).flat_map(|i| [i as u8, (i >> 5) as u8, (i >> 10) as u8, 200]);
        (index, Some(Brick::from_texels(texels.collect(), 4)))
    };
    let all = volume.colour.brick_indices(0).into_iter().map(paint).collect();
    volume.colour.swap(all)?;
    Ok(Arc::new(volume))
}

/// Makes all texels of fields of a box of n³ voxels, brick by brick. Answers how many bytes they have.
fn fill(volume: &voxels::Volume, kinds: &[FieldKind]) -> Result<u64, Failure> {
    let mut bytes = 0;
    for &kind in kinds {
        let field = volume.field(kind);
        let texels = field.brick_indices(0).into_par_iter().map(|index| {
            let brick = field.brick(BrickKey { level: 0, index })?;
            Ok(std::hint::black_box(brick.heap_bytes()) as u64)
        });
        bytes += texels.collect::<Result<Vec<u64>, burin::volume::SourceError>>()?.iter().sum::<u64>();
    }
    Ok(bytes)
}

/// Bytes a millisecond that memory takes from all threads.
fn memory() -> Result<f64, Failure> {
    let mut to = vec![0_u8; 256 << 20];
    let bytes = to.len() as f64;
    let time = measure(1, 5, |i| -> Result<(), Failure> {
        to.par_chunks_mut(1 << 20).for_each(|part| part.fill(i as u8));
        std::hint::black_box(&to);
        Ok(())
    })?;
    Ok(bytes / time.wall)
}

/// The brush kernel over all voxels of n³, a click that covers them.
fn brush(n: u32) -> Result<Time, Failure> {
    let volume = Volume::new([n; 3], Voxels::U8(vec![1; (n as usize).pow(3)]), 255.0)?;
    let mut easel = Easel::on(Gpu::headless()?, volume, 1 << 30)?;
    let middle = DVec3::splat(f64::from(n - 1) * 0.5);
    let (operation, target) = (Operation::Add, Target::Density(1.0));
    let brush = Brush { radius_mm: f64::from(n), falloff: Falloff::Hard, operation, target, ..Brush::default() };
    measure(1, 3, |_| easel.click(&brush, middle).map(drop))
}

pub fn boxes(report: &mut Report) -> Result<(), Failure> {
    let parent = parent()?;
    let bandwidth = memory()?;
    // Clicks on as many voxels; beyond what one takes at once by the voxel.
    let largest = 4 * BRICK;
    let mut clicks: BTreeMap<u32, f64> = BTreeMap::new();
    let mut of_brush = |count: f64| -> Result<f64, Failure> {
        let n = (count.cbrt().round() as u32).min(largest);
        if let std::collections::btree_map::Entry::Vacant(place) = clicks.entry(n) {
            place.insert(brush(n)?.wall);
        }
        Ok(clicks[&n] * count / f64::from(n.pow(3)))
    };
    let whole = of_brush(f64::from(largest.pow(3)))?;
    report.note(&format!("memory takes {:.1} GB/s; a click on {largest}³ voxels {:.1} ms", bandwidth / 1e6, whole));
    for scale in [2, 4, 8] {
        for n in [3, 11, 19, 32, 64] {
            let of = SubBox { lo: [2; 3], hi: [2 + n; 3], scale: [scale; 3] };
            let count: f64 = of.dims().iter().map(|&d| f64::from(d)).product();
            for (name, kinds) in
                [("density", &[FieldKind::Density][..]), ("with colour", &[FieldKind::Density, FieldKind::Colour])]
            {
                let mut bytes = 0;
                let time = measure(1, 3, |_| -> Result<(), Failure> {
                    bytes = fill(&voxels::Volume::refined(&parent, of), kinds)?;
                    Ok(())
                })?;
                let beside = format!(
                    "{:.2} ns a voxel, {:.1} × memory, {:.2} × brush",
                    time.wall * 1e6 / count,
                    time.wall / (bytes as f64 / bandwidth),
                    time.wall / of_brush(count)?,
                );
                report.row(&format!("{n}³ at {scale}×, {name}"), time, &beside);
            }
        }
    }
    Ok(())
}
