//! Pictures of density that is being painted: at every moment those of a volume that is what the slots hold.

use super::*;
use burin::gpu::{Body, Caster, Frame, Image, LabelLooks, Look};

fn fields_of(canvas: &Canvas) -> burin::gpu::Fields<'_> {
    one_volume(&canvas.grid, &canvas.density, &canvas.colour, &canvas.selection, &canvas.labels)
}

fn picture(gpu: &Gpu, caster: &mut Caster, canvas: &mut Canvas, frame: &Frame) -> Image {
    let Canvas { density, colour, selection, labels, pools, grid, .. } = canvas;
    caster.image(gpu, pools, &one_volume(grid, density, colour, selection, labels), frame).unwrap()
}

/// The picture of volumes on which no stroke was ever seen, one field as it is given.
fn of_field(gpu: &Gpu, canvas: &Canvas, field: &Field, frame: &Frame) -> Image {
    let density = if field.kind() == FieldKind::Density { field } else { &canvas.density };
    let labels = if field.kind() == FieldKind::Labels { field } else { &canvas.labels };
    let mut pools = FieldPools::new(gpu, &canvas.grid, density, 64 << 20).unwrap();
    let fields = one_volume(&canvas.grid, density, &canvas.colour, &canvas.selection, labels);
    Caster::new(gpu).unwrap().image(gpu, &mut pools, &fields, frame).unwrap()
}

fn field_of(canvas: &mut Canvas, kind: FieldKind) -> &mut Field {
    if kind == FieldKind::Labels { &mut canvas.labels } else { &mut canvas.density }
}

/// A field as the running stroke shows it.
fn shown(canvas: &mut Canvas, kind: FieldKind) -> Field {
    let fields = fields_of(canvas);
    let live = |b| Some((b, Some(canvas.painter.live(&canvas.pools, &fields, VolumeId::FIRST, b).unwrap()?)));
    let bricks = touched(&canvas.painter).into_iter().filter_map(live).collect();
    let mut field = field_of(canvas, kind).clone();
    field.swap(bricks).unwrap();
    field
}

/// Paints, takes back, looks past and undoes, and looks at each moment.
fn follow(gpu: &Gpu, canvas: &mut Canvas, brush: &Brush, frame: &Frame, what: &str) {
    let (kind, grid) = (brush.target.field(), canvas.grid);
    let mut caster = Caster::new(gpu).unwrap();
    let mut now = |canvas: &mut Canvas| picture(gpu, &mut caster, canvas, frame);
    let before = field_of(canvas, kind).clone();
    let start = now(canvas);
    assert!(start == of_field(gpu, canvas, &before, frame), "{what}: at first");
    let places = [[31.5, 2.0, 31.0], [66.0, 37.0, 33.0], [33.0, 1.0, 30.0]].map(DVec3::from_array);
    canvas.begin(brush);
    for at in places {
        canvas.extend(&[dab_at(&grid, at, 6.0)]);
        let painted = now(canvas);
        assert!(painted != start, "{what}: the stroke shows");
        let field = shown(canvas, kind);
        assert!(painted == of_field(gpu, canvas, &field, frame), "{what} at {at}");
    }
    // Looked past for a moment, as a brush that keeps to the visible surface does.
    let painted = now(canvas);
    let Canvas { density, colour, selection, labels, painter, pools, .. } = canvas;
    let fields = one_volume(&grid, density, colour, selection, labels);
    let look = |pools: &mut FieldPools| Caster::new(gpu).unwrap().image(gpu, pools, &fields, frame);
    let before = painter.at_start(pools, |_, _| true, look).unwrap();
    assert!(before == start, "{what}: the start of a running stroke");
    assert!(now(canvas) == painted, "{what}: the stroke shows again");

    let refresh = of_one(canvas.painter.cancel(&mut canvas.pools).unwrap());
    let Canvas { density, labels, pools, .. } = canvas;
    let field = if kind == FieldKind::Labels { labels } else { density };
    pools.refresh_painted(gpu, kind, field, &refresh).unwrap();
    assert!(now(canvas) == start, "{what}: a cancelled stroke leaves nothing");

    canvas.begin(brush);
    canvas.extend(&places.map(|at| dab_at(&grid, at, 6.0)));
    let changed = canvas.finish().into_iter().map(|(index, brick)| (index, Some(brick))).collect();
    let (old, refresh) = field_of(canvas, kind).swap(changed).unwrap();
    let Canvas { density, labels, pools, .. } = canvas;
    let field = if kind == FieldKind::Labels { labels } else { density };
    pools.refresh_painted(gpu, kind, field, &refresh).unwrap();
    assert!(now(canvas) == painted, "{what}: what a stroke leaves is what it showed");
    let (_, refresh) = field_of(canvas, kind).swap(old).unwrap();
    let Canvas { density, labels, pools, .. } = canvas;
    let field = if kind == FieldKind::Labels { labels } else { density };
    pools.refresh(gpu, kind, field, &refresh).unwrap();
    assert!(now(canvas) == start, "{what}: undone");
}

#[test]
fn what_is_painted_taken_back_or_looked_past_shows_in_the_very_next_picture() {
    let Some(gpu) = gpu() else { return };
    // Three bricks along x, so that dabs cross their borders and the volume's faces.
    let grid = unit_grid([70, 40, 36]);
    let mut canvas = Canvas::codes(&gpu, grid);
    let brush = Brush { target: Target::Density(65_000.0), radius_mm: 6.0, falloff: Falloff::Hard, ..Brush::default() };
    let look = frame(&grid, ramp(30_000.0, 90_000.0), DVec3::new(-0.3, -1.0, 0.4), [40, 40]);
    for (mode, lighting) in [(Mode::Dvr, Some(Lighting::default())), (Mode::Dvr, None), (Mode::Mip, None)] {
        follow(&gpu, &mut canvas, &brush, &Frame { mode, lighting, ..look.clone() }, &format!("{mode:?}"));
    }
    // Labels that the brush's are among, in place from the first of these pictures on.
    let row = |colour: [f32; 3], mode| {
        let mut transfer = look.transfer.clone();
        transfer.colour.iter_mut().for_each(|(_, c)| *c = colour);
        Look { transfer, mode, lighting: None, opacity: 1.0 }
    };
    let brush = Brush { target: Target::Label(9), ..brush };
    for mode in [Mode::Dvr, Mode::Iso(45_000.0), Mode::Mip] {
        for refine in [false, true] {
            let looks = vec![row([1.0, 0.0, 0.0], mode), row([0.0, 1.0, 0.0], mode)];
            let by_label = [(9, Some(1)), (2, None)].into_iter().collect();
            let labels = Some(std::sync::Arc::new(LabelLooks { default: Some(0), by_label }));
            let frame = Frame { refine, looks, bodies: vec![Body { labels, ..Body::whole(0) }], ..look.clone() };
            follow(&gpu, &mut canvas, &brush, &frame, &format!("labels, {mode:?}, refined {refine}"));
        }
    }
}
