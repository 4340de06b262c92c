//! Grids of surface particles, the paper's Table 2: 11² to 81² vertices on a sphere, plain.

use super::head::Failure;
use super::measure::{Report, measure};
use burin::gpu::{FieldPools, Fields, Gpu, GridRequest, Heading, Tracer, VolumeFields};
use burin::math::DVec3;
use burin::volume::{DensityMap, Field, FieldKind, Grid, MemorySource, VolumeId, Voxels};
use std::sync::Arc;

pub fn grids(report: &mut Report) -> Result<(), Failure> {
    const EDGE: u32 = 128;
    const RADIUS: f64 = 50.0;
    let gpu = Gpu::headless()?;
    let grid = Grid::aligned([EDGE; 3], DVec3::ONE, DVec3::splat(-0.5 * f64::from(EDGE - 1)));
    let voxel = |i: u32| {
        let at = DVec3::new(f64::from(i % EDGE), f64::from(i / EDGE % EDGE), f64::from(i / EDGE / EDGE));
        let outside = grid.world_from_index.transform_point3(at).length() - RADIUS;
        (1000.0 - 50.0 * outside).clamp(0.0, 4000.0) as u16
    };
    let voxels = Voxels::U16((0..EDGE.pow(3)).map(voxel).collect());
    let source = Arc::new(MemorySource::new("sphere", grid, voxels, (1.0, 0.0))?);
    let map = DensityMap::codes(0.0, 65_535.0, Some(1.0));
    let density = Field::from_source(source, map, &|_| true)?.ok_or("no density was made")?;
    let [colour, selection, labels] =
        [FieldKind::Colour, FieldKind::Selection, FieldKind::Labels].map(|kind| Field::blank(kind, &grid));
    let fields =
        Fields::one(VolumeFields { grid, density: &density, colour: &colour, selection: &selection, labels: &labels });
    let mut pools = FieldPools::new(&gpu, &grid, &density, 256 << 20)?;
    let mut tracer = Tracer::new(&gpu)?;
    for n in [5, 10, 20, 30, 40] {
        let request = GridRequest {
            family: vec![VolumeId::FIRST],
            iso: 1000.0,
            centre: DVec3::new(0.6, -0.48, 0.64) * RADIUS,
            along: DVec3::Z,
            step_mm: 1.0,
            tolerance_mm: 0.01,
            steps: [n; 2],
            heading: Heading::Straight,
        };
        let untimed = tracer.grid(&gpu, &mut pools, &fields, &request)?;
        let mut last = None;
        let time = measure(3, 25, |_| -> Result<(), Failure> {
            last = Some(tracer.grid(&gpu, &mut pools, &fields, &request)?);
            Ok(())
        })?;
        if last.as_ref() != Some(&untimed) || untimed.trimmed() > 0 {
            return Err("a timed grid differs from the untimed one, or is trimmed".into());
        }
        let vertices = untimed.vertices.len() as f64;
        let each = format!("{:.0} ns CPU a vertex", time.cpu * 1e6 / vertices);
        report.row(&format!("surface particles, {}²", 2 * n + 1), time, &each);
    }
    Ok(())
}
