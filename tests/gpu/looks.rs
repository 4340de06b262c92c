//! Bodies of several volumes, looks and modes in one picture against the reference.

use super::cast_bodies::{exploded, wide};
use super::cast_modes::{Stage, lumps, oblique_grid, tissue};
use super::reference::{Dense, Difference, difference, picture};
use crate::common::gpu::gpu;
use crate::common::volumes::*;
use burin::gpu::*;
use burin::math::{DAffine3, DQuat, DVec3, Plane, Pose};
use burin::volume::*;
use std::collections::BTreeMap;
use std::sync::Arc;

fn look(mode: Mode, opacity: f32, colour: [f32; 3]) -> Look {
    let transfer = TransferFunction {
        colour: vec![(0.0, colour), (60_000.0, [1.0 - colour[0], 0.8, colour[2]])],
        opacity: vec![(9_000.0, 0.0), (45_000.0, 0.3), (60_000.0, 0.5)],
        unit_mm: 1.0,
    };
    Look { transfer, mode, lighting: None, opacity }
}

/// Modes and opacities that meet in one picture.
fn all_looks() -> Vec<Look> {
    vec![
        look(Mode::Dvr, 1.0, [0.9, 0.2, 0.1]),
        look(Mode::Iso(26_000.0), 1.0, [0.1, 0.9, 0.3]),
        look(Mode::Mip, 1.0, [0.2, 0.3, 0.9]),
        look(Mode::Iso(38_000.0), 0.4, [0.9, 0.9, 0.1]),
        Look { lighting: Some(Lighting::default()), ..look(Mode::Dvr, 0.5, [0.3, 0.6, 0.6]) },
        Look { lighting: Some(Lighting::default()), ..look(Mode::Iso(20_000.0), 1.0, [0.8, 0.4, 0.8]) },
        look(Mode::Mip, 0.6, [0.9, 0.5, 0.2]),
    ]
}

/// Looks by label: the row of each that is named, and of all others.
fn labels(default: Option<usize>, rows: &[(u16, Option<usize>)]) -> Option<Arc<LabelLooks>> {
    Some(Arc::new(LabelLooks { default, by_label: rows.iter().copied().collect() }))
}

/// A picture that the volume fills.
fn close_by(grid: &Grid, direction: DVec3) -> Frame {
    let view = frame(grid, tissue(), direction, [60, 48]);
    Frame { camera: view.camera.zoomed(0.5), ..view }
}

fn check(image: &Image, dense: &Dense, view: &Frame, what: &str) -> Difference {
    let d = difference(image, &picture(dense, view), view.step_mm);
    println!("{what}: {d:?}");
    // An iso-surface may be another one where a ray grazes it.
    assert!(d.covered > 0.1 && d.mean <= 0.2 && d.beyond_one < 0.02 && d.misplaced < 0.02, "{what}: {d:?}");
    d
}

#[test]
fn parts_of_several_looks_and_modes_are_the_references() {
    let Some(gpu) = gpu() else { return };
    let grid = oblique_grid([70, 44, 36]);
    let mut stage = Stage::new(gpu, grid, lumps(grid));
    stage.fields[2] =
        painted(FieldKind::Selection, &grid, |v| [if v[0] > 40 { 255 } else { (v[0] * 3) as u8 }, 0, 0, 0]);
    let dense = Dense::of(&stage.fields(), &grid);
    let centre = grid.world_bounds().centre();
    let part = |id: u32, normal: DVec3, shift: f64, look: Option<usize>, mask: Mask| Body {
        pose: Pose { translation: normal * -shift, rotation: DQuat::from_rotation_z(shift * 0.01) },
        region: vec![Plane::through(centre, normal).unwrap()],
        look,
        mask,
        ..Body::whole(id)
    };
    let mut view = close_by(&grid, DVec3::new(1.0, -2.0, 0.7));
    view.looks = all_looks();
    let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y];
    for (first, second, third) in [(0, 1, 2), (4, 0, 3), (2, 6, 1), (3, 2, 5), (1, 1, 3)] {
        // Apart, and overlapping without an order.
        for shift in [0.0, 14.0, -9.0] {
            view.bodies = vec![
                part(1, axes[0], shift, Some(first), Mask::None),
                part(2, axes[1], shift * 0.5, Some(second), Mask::Background),
                part(3, axes[2], shift, Some(third), Mask::Selection),
            ];
            let image = stage.image(&view);
            check(&image, &dense, &view, &format!("looks {first} {second} {third}, shift {shift}"));
        }
    }
    // Every body as the frame's own look is the picture without looks, to the bit.
    let body = |look| vec![Body { look, ..Body::whole(0) }];
    let plain = stage.image(&Frame { bodies: body(None), ..view.clone() });
    view.looks = vec![Look { transfer: tissue(), mode: Mode::Dvr, lighting: None, opacity: 1.0 }];
    assert_eq!(stage.image(&Frame { bodies: body(Some(0)), ..view.clone() }).colour, plain.colour);
}

#[test]
fn volumes_on_their_own_grids_merge_on_one_lattice() {
    let Some(gpu) = gpu() else { return };
    let one = oblique_grid([70, 44, 36]);
    let turned = DAffine3::from_rotation_translation(DQuat::from_rotation_y(0.4), DVec3::new(9.0, -4.0, 2.0));
    let two = Grid { dims: [40, 36, 50], world_from_index: turned * oblique_grid([1; 3]).world_from_index };
    let three = Grid::aligned([30; 3], DVec3::splat(1.7), one.world_bounds().centre() - 20.0);
    let codes = [lumps(one), lumps(two)];
    let floats = density_f32(three, |v| (v[0] + v[1] + v[2]) as f32 * 700.0);
    let blank =
        |grid: &Grid| [FieldKind::Colour, FieldKind::Selection, FieldKind::Labels].map(|k| Field::blank(k, grid));
    let mut rest = [blank(&one), blank(&two), blank(&three)];
    rest[1][1] = painted(FieldKind::Selection, &two, |v| [(v[1] * 6) as u8, 0, 0, 0]);
    rest[2][2] = painted(FieldKind::Labels, &three, |v| [u8::from(v[0] > 14), 0, 0, 0]);
    let mut fields = Fields::default();
    for (id, grid, density, [colour, selection, labels]) in
        [(0, one, &codes[0], &rest[0]), (4, two, &codes[1], &rest[1]), (9, three, &floats, &rest[2])]
    {
        fields.put(VolumeId(id), VolumeFields { grid, density, colour, selection, labels });
    }
    let dense = Dense::many(&fields);
    let mut pools = FieldPools::empty(&gpu, 64 << 20).unwrap();
    let mut caster = Caster::new(&gpu).unwrap();
    let mut view = close_by(&one, DVec3::new(1.0, -2.0, 0.7));
    let mut segments = Segments::default();
    segments.ensure(1);
    let overlay = Overlay { labels: 0.8, segments, ..Overlay::default() };
    view.overlays = BTreeMap::from([
        (VolumeId(9), overlay),
        (VolumeId(4), Overlay { selection: 0.7, selection_colour: [1.0, 0.1, 0.9], ..Overlay::default() }),
    ]);
    view.looks = all_looks();
    let body = |id: u32, volume: u32, look, mask| Body { volume: VolumeId(volume), look, mask, ..Body::whole(id) };
    let mut draw = |view: &Frame, what: &str| {
        let image = caster.image(&gpu, &mut pools, &fields, view).unwrap();
        check(&image, &dense, view, what)
    };
    for lighting in [None, Some(Lighting::default())] {
        view.lighting = lighting;
        view.bodies =
            vec![body(0, 0, None, Mask::None), body(0, 4, None, Mask::Selection), body(0, 9, None, Mask::None)];
        draw(&view, "one look");
    }
    for rows in [[0, 4, 0], [0, 1, 2], [2, 3, 6], [5, 1, 3], [6, 2, 2], [3, 0, 5]] {
        let [a, b, c] = rows.map(Some);
        view.bodies = vec![body(1, 0, a, Mask::None), body(2, 4, b, Mask::Background), body(3, 9, c, Mask::None)];
        draw(&view, &format!("looks {rows:?}"));
    }
}

#[test]
fn looks_and_volumes_of_their_own_refine_and_others_leave_samples_as_they_are() {
    let Some(gpu) = gpu() else { return };
    let grid = oblique_grid([66, 44, 36]);
    let other = Grid::aligned([30; 3], DVec3::splat(1.7), grid.world_bounds().centre() - 20.0);
    let codes = lumps(grid);
    let floats = density_f32(other, |v| (v[0] + v[1] + v[2]) as f32 * 700.0);
    let kinds = [FieldKind::Colour, FieldKind::Selection, FieldKind::Labels];
    let blank = [&grid, &other].map(|grid| kinds.map(|kind| Field::blank(kind, grid)));
    let mut fields = Fields::default();
    for (id, grid, density, [colour, selection, labels]) in
        [(0, grid, &codes, &blank[0]), (4, other, &floats, &blank[1])]
    {
        fields.put(VolumeId(id), VolumeFields { grid, density, colour, selection, labels });
    }
    let dense = Dense::many(&fields);
    let mut pools = FieldPools::empty(&gpu, 64 << 20).unwrap();
    let mut caster = Caster::new(&gpu).unwrap();
    let mut draw = |view: &Frame| caster.image(&gpu, &mut pools, &fields, view).unwrap();
    let mut bodies = exploded(&grid, [2, 2, 1], 0.5, Mask::None);
    for (body, look) in bodies.iter_mut().zip([None, Some(0), Some(4), Some(7)]) {
        body.look = look;
    }
    let aside = Pose { translation: DVec3::new(0.0, 0.0, 75.0), ..Pose::IDENTITY };
    bodies.push(Body { volume: VolumeId(4), pose: aside, look: Some(0), ..Body::whole(90) });
    for lighting in [None, Some(Lighting::default())] {
        let mut view = Frame { refine: true, lighting, ..wide(&grid, bodies.clone()) };
        view.camera = view.camera.zoomed(1.4);
        view.looks = all_looks();
        view.looks.push(Look { lighting, ..look(Mode::Dvr, 0.3, [0.2, 0.9, 0.5]) });
        let image = draw(&view);
        let d = difference(&image, &picture(&dense, &view), view.step_mm);
        println!("{d:?}");
        assert!(d.covered > 0.05 && d.largest <= 8.0 && d.mean <= 0.2 && d.misplaced < 0.01, "{d:?}");
        let plain = draw(&Frame { refine: false, ..view.clone() });
        assert_ne!(image.colour, plain.colour, "a look of its own refines");
        // A surface and a maximum among them: stretches of the others end at them and begin anew.
        for first in [1, 3, 6] {
            view.bodies[0].look = Some(first);
            let image = draw(&view);
            let d = difference(&image, &picture(&dense, &view), view.step_mm);
            println!("beside look {first}: {d:?}");
            assert!(d.mean <= 0.2 && d.beyond_one < 0.03 && d.misplaced < 0.01, "beside look {first}: {d:?}");
        }
    }
}

#[test]
fn how_much_is_seen_is_told_by_plain_samples_where_looks_go_by_label_too() {
    let Some(gpu) = gpu() else { return };
    let grid = oblique_grid([66, 44, 36]);
    let mut stage = Stage::new(gpu, grid, lumps(grid));
    stage.fields[2] = painted(FieldKind::Selection, &grid, |[x, y, _]| [u8::from(x > 30 && y > 20) * 255, 0, 0, 0]);
    stage.fields[3] = painted(FieldKind::Labels, &grid, |[x, y, z]| [((x / 5 + y / 4 + z / 6) % 7) as u8, 0, 0, 0]);
    let mut view = close_by(&grid, DVec3::new(-1.0, -1.0, 0.9));
    view.looks = vec![look(Mode::Dvr, 1.0, [0.9, 0.2, 0.1]), look(Mode::Dvr, 0.1, [0.3, 0.6, 0.6])];
    let by_label = [(1, Some(1)), (2, None), (3, None), (4, Some(1)), (6, Some(1))].into_iter().collect();
    let labels = Some(Arc::new(LabelLooks { default: Some(1), by_label }));
    let stays = Body { mask: Mask::Selection, look: Some(0), ..Body::whole(9) };
    view.bodies = vec![Body { mask: Mask::Background, labels, ..Body::whole(1) }, stays];
    let Stage { gpu, pools, fields, caster, .. } = &mut stage;
    let [density, colour, selection, labels] = &*fields;
    let fields = one_volume(&grid, density, colour, selection, labels);
    let mut seen = |refine| caster.visibility(gpu, pools, &fields, &Frame { refine, ..view.clone() }).unwrap();
    let plain = seen(false);
    assert!(plain.selected > 100 && plain.visible > 0 && plain.visible < plain.selected, "{plain:?}");
    assert_eq!(seen(true), plain);
}

#[test]
fn matter_refines_before_and_behind_surfaces_and_maxima_in_it() {
    let Some(gpu) = gpu() else { return };
    let grid = oblique_grid([66, 44, 36]);
    let mut stage = Stage::new(gpu, grid, lumps(grid));
    stage.fields[3] = painted(FieldKind::Labels, &grid, |[x, y, z]| [((x / 5 + y / 4 + z / 6) % 7) as u8, 0, 0, 0]);
    let dense = Dense::of(&stage.fields(), &grid);
    let mut view = Frame { refine: true, ..close_by(&grid, DVec3::new(-1.0, -1.0, 0.9)) };
    view.looks = all_looks();
    let body = |id: u32, look: usize| Body { look: Some(look), ..Body::whole(id) };
    let some = |id: u32, labels| Body { labels, ..Body::whole(id) };
    let cases = [
        ("a surface", vec![body(1, 4), body(2, 1)]),
        ("a thin surface", vec![body(1, 0), body(2, 3)]),
        ("a maximum", vec![body(1, 4), body(2, 6)]),
        ("two thin surfaces", vec![body(1, 4), body(2, 3), Body { look: Some(7), ..Body::whole(3) }]),
        (
            "surfaces of some labels in others",
            vec![
                some(1, labels(Some(4), &[(1, None), (2, Some(0)), (3, None)])),
                some(2, labels(None, &[(1, Some(3)), (3, Some(7))])),
            ],
        ),
    ];
    view.looks.push(Look { lighting: Some(Lighting::default()), ..look(Mode::Iso(30_000.0), 0.5, [0.9, 0.9, 0.9]) });
    for (what, bodies) in cases {
        view.bodies = bodies;
        let image = stage.image(&view);
        let d = difference(&image, &picture(&dense, &view), view.step_mm);
        println!("{what}: {d:?}");
        assert!(d.covered > 0.1 && d.mean <= 0.2 && d.beyond_one < 0.03 && d.misplaced < 0.02, "{what}: {d:?}");
        let d = difference(&stage.image_apart(&view), &picture(&dense, &view), view.step_mm);
        println!("{what}, apart: {d:?}");
        assert!(d.mean <= 0.3 && d.beyond_one < 0.05 && d.misplaced < 0.03, "{what}, apart: {d:?}");
        let plain = stage.image(&Frame { refine: false, ..view.clone() });
        assert_ne!(image.colour, plain.colour, "{what}");
    }
}

#[test]
fn looks_by_label_refine_wherever_labels_lie() {
    let Some(gpu) = gpu() else { return };
    let grid = oblique_grid([66, 44, 36]);
    let mut stage = Stage::new(gpu, grid, lumps(grid));
    stage.fields[3] = painted(FieldKind::Labels, &grid, |v| match v {
        [x, ..] if x < 34 => [5, 0, 0, 0],
        [x, y, z] => [((x / 5 + y / 4 + z / 6) % 7) as u8, 0, 0, 0],
    });
    let dense = Dense::of(&stage.fields(), &grid);
    let mut view = Frame { refine: true, ..close_by(&grid, DVec3::new(-1.0, -1.0, 0.9)) };
    let lit = Some(Lighting::default());
    view.looks = vec![
        look(Mode::Dvr, 1.0, [0.9, 0.2, 0.1]),
        Look { lighting: lit, ..look(Mode::Dvr, 0.5, [0.3, 0.6, 0.6]) },
        Look { lighting: lit, ..look(Mode::Dvr, 0.2, [0.2, 0.9, 0.5]) },
        look(Mode::Dvr, 1.0, [0.1, 0.2, 0.9]),
    ];
    view.looks[3].transfer.opacity = vec![(15_000.0, 0.0), (50_000.0, 0.4)];
    view.looks[3].transfer.colour = vec![(15_000.0, [1.0, 0.0, 0.0]), (50_000.0, [0.0, 0.5, 1.0])];
    for (what, labels) in [
        ("a look a label", labels(Some(1), &[(1, Some(0)), (3, None), (4, Some(2))])),
        ("few of many numbers", labels(Some(1), &[(1, Some(0)), (3, None), (900, Some(2))])),
        ("looks of other values", labels(Some(0), &[(1, Some(3)), (2, None), (5, Some(3))])),
        ("a set as a mask", labels(None, &[(5, Some(1)), (6, Some(1))])),
    ] {
        view.bodies = vec![Body { labels, ..Body::whole(0) }];
        let image = stage.image(&view);
        let d = difference(&image, &picture(&dense, &view), view.step_mm);
        println!("{what}: {d:?}");
        assert!(d.covered > 0.1 && d.mean <= 0.2 && d.beyond_one < 0.02 && d.misplaced < 0.02, "{what}: {d:?}");
        let d = difference(&stage.image_apart(&view), &picture(&dense, &view), view.step_mm);
        println!("{what}, apart: {d:?}");
        // A brick's first stretch asks the brick for its label, that ends in it.
        assert!(d.mean <= 0.3 && d.beyond_one < 0.05 && d.misplaced < 0.03, "{what}, apart: {d:?}");
        let plain = stage.image(&Frame { refine: false, ..view.clone() });
        assert_ne!(image.colour, plain.colour, "{what}");
        stage.caster.shortcuts = false;
        let every = stage.image(&view);
        stage.caster.shortcuts = true;
        let far = |(a, b): &(&[f32; 4], &[f32; 4])| (0..4).any(|i| (a[i] - b[i]).abs() > 1.0 / 255.0);
        let others = image.colour.iter().zip(&every.colour).filter(far).count();
        println!("{what}: {others} pixels are others where nothing is skipped");
        assert!(others * 200 <= image.colour.len(), "{what}: skipping changes {others} pixels");
    }
}

#[test]
fn looks_by_label_are_the_references_and_hidden_labels_are_skipped() {
    let Some(gpu) = gpu() else { return };
    let grid = oblique_grid([70, 44, 36]);
    let mut stage = Stage::new(gpu, grid, lumps(grid));
    // Bricks of one label, bricks of many, labels beyond the table's.
    let label = |v: [u32; 3]| match v {
        [x, ..] if x < 34 => 5,
        [x, y, _] if x > 60 && y > 20 => 900,
        [x, y, z] => ((x / 5 + y / 4 + z / 6) % 7) as u16,
    };
    stage.fields[3] = painted(FieldKind::Labels, &grid, |v| {
        let [a, b] = label(v).to_le_bytes();
        [a, b, 0, 0]
    });
    let dense = Dense::of(&stage.fields(), &grid);
    let mut view = close_by(&grid, DVec3::new(-1.0, -1.0, 0.9));
    view.looks = all_looks();
    // Thinner ones, and one whose table is of other values.
    let thin = |colour| Look { lighting: Some(Lighting::default()), ..look(Mode::Dvr, 0.3, colour) };
    view.looks.extend([thin([0.1, 0.2, 0.9]), thin([0.9, 0.9, 0.9]), look(Mode::Dvr, 1.0, [0.2, 0.9, 0.4])]);
    view.looks[9].transfer.opacity = vec![(15_000.0, 0.0), (50_000.0, 0.4)];
    view.looks[9].transfer.colour = vec![(15_000.0, [1.0, 0.0, 0.0]), (50_000.0, [0.0, 0.5, 1.0])];
    view.looks.push(Look { lighting: Some(Lighting::default()), ..look(Mode::Iso(20_000.0), 1.0, [0.1, 0.9, 0.9]) });
    let cases = [
        ("two looks", labels(Some(0), &[(1, Some(4)), (2, None), (5, Some(0)), (900, Some(4))])),
        ("a set as a mask", labels(None, &[(1, Some(4)), (3, Some(4))])),
        (
            "a look a label",
            labels(Some(4), &[(0, Some(0)), (1, Some(4)), (2, None), (3, Some(0)), (4, Some(7)), (5, Some(8))]),
        ),
        ("looks of other values", labels(Some(0), &[(1, Some(9)), (3, None), (5, Some(9))])),
        ("surfaces", labels(None, &[(1, Some(1)), (3, Some(5)), (5, Some(1))])),
        ("one surface in two colours", labels(Some(5), &[(1, Some(10)), (4, Some(10))])),
        ("thin surfaces", labels(Some(3), &[(5, None), (0, None)])),
        ("maxima", labels(Some(2), &[(1, None), (4, Some(6)), (900, None)])),
    ];
    for (what, labels) in cases {
        view.bodies = vec![Body { labels, ..Body::whole(0) }];
        let image = stage.image(&view);
        check(&image, &dense, &view, what);
        // Labels in slots of their own, as where several volumes are drawn.
        check(&stage.image_apart(&view), &dense, &view, &format!("{what}, apart"));
        stage.caster.shortcuts = false;
        let plain = stage.image(&view);
        stage.caster.shortcuts = true;
        let far = |(a, b): (&[f32; 4], &[f32; 4])| (0..4).any(|i| (a[i] - b[i]).abs() > 1.0 / 255.0);
        assert!(!image.colour.iter().zip(&plain.colour).any(far), "{what}: skipping changes nothing");
    }
    // A pixel tells the segment that it shows.
    view.bodies = vec![Body::whole(4)];
    let image = stage.image(&view);
    let step = view.step_mm;
    let mut told = std::collections::BTreeSet::new();
    let mut off = 0;
    for (i, object) in image.object.iter().enumerate().filter(|(_, o)| o.body().is_some()) {
        let px = burin::math::DVec2::new((i % 60) as f64 + 0.5, (i / 60) as f64 + 0.5);
        let at = |t: f64| {
            let p = grid.index_from_world().transform_point3(view.camera.ray(px, view.size).at(t));
            label((p + 0.5).floor().max(DVec3::ZERO).min(grid.dims_f64() - 1.0).to_array().map(|v| v as u32))
        };
        let depth = f64::from(image.depth_mm[i]);
        assert_eq!((object.body(), object.volume(), object.is_selected()), (Some(4), Some(VolumeId::FIRST), false));
        let here = [at(depth - 0.01 * step), at(depth), at(depth + 0.01 * step)];
        off += usize::from(!here.contains(&object.segment().unwrap_or(0)));
        told.insert(object.segment());
    }
    assert!(off < 5 && told.len() > 4, "{off} pixels tell another segment; {told:?}");
    // A cell that holds only hidden labels is skipped, its neighbours are not.
    let hidden = LabelLooks { default: Some(0), by_label: BTreeMap::from([(5, None)]) };
    let rows = |row: usize| VisibleValues::of_look(view.look(Some(row)));
    let matter =
        Matter { volume: VolumeId::FIRST, values: Showing::ByLabel(LabelValues::new(&hidden, rows)), mask: Mask::None };
    let Stage { gpu, pools, fields, .. } = &mut stage;
    let [density, colour, selection, labels] = &*fields;
    let fields = one_volume(&grid, density, colour, selection, labels);
    pools.make_resident(gpu, &fields, &view).unwrap();
    let places = pools.skip_maps(gpu, &fields, &[matter]).unwrap();
    let at = [[20.0, 22.0, 18.0], [31.0, 22.0, 18.0], [38.0, 22.0, 18.0]];
    let skips: Vec<u32> = crate::common::gpu::sample_maps(gpu, pools, &places, &at).iter().map(|s| s.skip[0]).collect();
    assert!(skips[0] > 1 && skips[1] == 1 && skips[2] == 0, "{skips:?}");
}
