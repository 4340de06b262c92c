//! Pictures of density that is being painted: at every moment those of a volume that is what the slots hold.

use super::*;
use burin::gpu::{Caster, Frame, Image};

fn fields_of(canvas: &Canvas) -> burin::gpu::Fields<'_> {
    one_volume(&canvas.grid, &canvas.density, &canvas.colour, &canvas.selection, &canvas.labels)
}

fn picture(gpu: &Gpu, caster: &mut Caster, canvas: &mut Canvas, frame: &Frame) -> Image {
    let Canvas { density, colour, selection, labels, pools, grid, .. } = canvas;
    caster.image(gpu, pools, &one_volume(grid, density, colour, selection, labels), frame).unwrap()
}

/// The picture of a volume with this density that no stroke ever met.
fn of_field(gpu: &Gpu, canvas: &Canvas, density: &Field, frame: &Frame) -> Image {
    let mut pools = FieldPools::new(gpu, &canvas.grid, density, 64 << 20).unwrap();
    let fields = one_volume(&canvas.grid, density, &canvas.colour, &canvas.selection, &canvas.labels);
    Caster::new(gpu).unwrap().image(gpu, &mut pools, &fields, frame).unwrap()
}

/// Density as the running stroke shows it.
fn shown(canvas: &Canvas) -> Field {
    let fields = fields_of(canvas);
    let live = |b| Some((b, Some(canvas.painter.live(&canvas.pools, &fields, VolumeId::FIRST, b).unwrap()?)));
    let bricks = touched(&canvas.painter).into_iter().filter_map(live).collect();
    let mut field = canvas.density.clone();
    field.swap(bricks).unwrap();
    field
}

#[test]
fn what_is_painted_taken_back_or_looked_past_shows_in_the_very_next_picture() {
    let Some(gpu) = gpu() else { return };
    // Three bricks along x, so that dabs cross their borders and the volume's faces.
    let grid = unit_grid([70, 40, 36]);
    let mut canvas = Canvas::codes(&gpu, grid);
    let mut caster = Caster::new(&gpu).unwrap();
    for (mode, lighting) in [(Mode::Dvr, Some(Lighting::default())), (Mode::Dvr, None), (Mode::Mip, None)] {
        let look = frame(&grid, ramp(30_000.0, 90_000.0), DVec3::new(-0.3, -1.0, 0.4), [40, 40]);
        let frame = Frame { mode, lighting, ..look };
        let mut now = |canvas: &mut Canvas| picture(&gpu, &mut caster, canvas, &frame);
        let start = now(&mut canvas);
        assert!(start == of_field(&gpu, &canvas, &canvas.density, &frame));
        let brush =
            Brush { target: Target::Density(65_000.0), radius_mm: 6.0, falloff: Falloff::Hard, ..Brush::default() };
        let places = [[31.5, 2.0, 31.0], [66.0, 37.0, 33.0], [33.0, 1.0, 30.0]].map(DVec3::from_array);
        canvas.begin(&brush);
        for at in places {
            canvas.extend(&[dab_at(&grid, at, 6.0)]);
            let painted = now(&mut canvas);
            assert!(painted != start, "{mode:?}: the stroke shows");
            assert!(painted == of_field(&gpu, &canvas, &shown(&canvas), &frame), "{mode:?} at {at}");
        }
        // Looked past for a moment, as a brush that keeps to the visible surface does.
        let painted = now(&mut canvas);
        let Canvas { density, colour, selection, labels, painter, pools, .. } = &mut canvas;
        let fields = one_volume(&grid, density, colour, selection, labels);
        let look = |pools: &mut FieldPools| Caster::new(&gpu).unwrap().image(&gpu, pools, &fields, &frame);
        let before = painter.at_start(pools, |_, _| true, look).unwrap();
        assert!(before == start, "{mode:?}: the start of a running stroke");
        assert!(now(&mut canvas) == painted, "{mode:?}: the stroke shows again");

        let refresh = of_one(canvas.painter.cancel(&mut canvas.pools).unwrap());
        canvas.pools.refresh_painted(&gpu, FieldKind::Density, &canvas.density, &refresh).unwrap();
        assert!(now(&mut canvas) == start, "{mode:?}: a cancelled stroke leaves nothing");

        canvas.begin(&brush);
        canvas.extend(&places.map(|at| dab_at(&grid, at, 6.0)));
        let changed = canvas.finish().into_iter().map(|(index, brick)| (index, Some(brick))).collect();
        let (old, refresh) = canvas.density.swap(changed).unwrap();
        canvas.pools.refresh_painted(&gpu, FieldKind::Density, &canvas.density, &refresh).unwrap();
        assert!(now(&mut canvas) == painted, "{mode:?}: what a stroke leaves is what it showed");
        let (_, refresh) = canvas.density.swap(old).unwrap();
        canvas.pools.refresh(&gpu, FieldKind::Density, &canvas.density, &refresh).unwrap();
        assert!(now(&mut canvas) == start, "{mode:?}: undone");
    }
}
