//! Pictures with a focus: a ball as it is, among a context that is faded or drawn as contours, against rays by the book.

use super::cast_layers::arrangements;
use super::cast_modes::{Stage, oblique_grid, projections, tissue};
use super::reference::{Dense, Pixel, difference, picture_among};
use super::reference_boxes::{Boxes, OpaqueBox};
use crate::common::gpu::gpu;
use crate::common::volumes::*;
use burin::gpu::{Ball, Body, Caster, Context, FieldPools, Focus, Form, Frame, Image, Keeps, Layers, Look, Mask};
use burin::math::{Aabb, Camera, DVec2, DVec3, Pose};
use burin::volume::*;

const MODES: [Mode; 3] = [Mode::Dvr, Mode::Iso(20_000.0), Mode::Mip];

/// Pixels along a row.
const WIDTH: usize = 32;

/// In index space: the middle of a lump that stands by itself, in front of and beside others.
const MIDDLE: DVec3 = DVec3::new(20.0, 22.0, 14.0);

/// A lump, a smaller one before it, a wall behind it that it hides in part, and a rod across.
fn matter(v: [u32; 3]) -> f64 {
    let p = DVec3::from_array(v.map(f64::from));
    let ball = |c: DVec3, r: f64| 45_000.0 * (r + 1.5 - (p - c).length()).clamp(0.0, 3.0) / 3.0;
    let rod = 40_000.0 * (2.5 - DVec2::new(p.y - 8.0, p.z - 22.0).length()).clamp(0.0, 2.0) / 2.0;
    let wall = if p.x > 46.0 { 18_000.0 + 300.0 * p.y } else { 0.0 };
    ball(MIDDLE, 6.0) + ball(DVec3::new(34.0, 30.0, 26.0), 4.0) + rod + wall
}

fn stage() -> Option<Stage> {
    let gpu = gpu()?;
    let grid = oblique_grid([60, 44, 36]);
    Some(Stage::new(gpu, grid, density_u16(grid, |v| matter(v) as u16)))
}

fn focus_of(grid: &Grid, radius_mm: f64, opacity: f32, context: Context) -> Focus {
    Focus { centre: grid.world_from_index.transform_point3(MIDDLE), radius_mm, opacity, context }
}

/// The picture of one piece of every ray, by the book.
fn layer(stage: &Stage, frame: &Frame, focus: &Focus, keeps: Keeps, boxes: &Boxes) -> Vec<Pixel> {
    let boxes = Boxes { kept: Some((focus.centre, focus.radius_mm, keeps)), ..boxes.clone() };
    picture_among(&Dense::of(&stage.fields(), &stage.grid), frame, &boxes)
}

/// The layers one behind another: o·A over B over o·C.
fn by_the_book(stage: &Stage, frame: &Frame, focus: &Focus, boxes: &Boxes) -> Vec<Pixel> {
    let [before, inside, behind] =
        [Keeps::Before, Keeps::Inside, Keeps::Behind].map(|keeps| layer(stage, frame, focus, keeps, boxes));
    let plain = picture_among(&Dense::of(&stage.fields(), &stage.grid), frame, boxes);
    let o = f64::from(focus.opacity);
    let over = |top: [f64; 4], bottom: [f64; 4]| std::array::from_fn(|i| top[i] + (1.0 - top[3]) * bottom[i]);
    let all = before.iter().zip(&inside).zip(&behind).zip(&plain);
    all.map(|(((a, b), c), plain)| {
        let colour = over(a.colour.map(|x| x * o), over(b.colour, c.colour.map(|x| x * o)));
        Pixel { colour, ..*plain }
    })
    .collect()
}

fn view(grid: &Grid, bodies: Vec<Body>) -> Frame {
    let mut view = frame(grid, tissue(), DVec3::new(1.0, -1.6, 0.8), [WIDTH as u32, 28]);
    view.camera = view.camera.zoomed(0.6);
    view.transfer.opacity.iter_mut().for_each(|p| p.1 *= 0.4);
    view.bodies = bodies;
    view
}

fn apart(a: &Image, b: &Image) -> Vec<usize> {
    (0..a.colour.len()).filter(|&i| a.colour[i] != b.colour[i]).collect()
}

#[test]
fn a_context_is_faded_as_a_whole_before_and_behind_what_is_in_focus() {
    let Some(mut stage) = stage() else { return };
    let light = Some(Lighting { specular: 0.0, ..Lighting::default() });
    for (i, bodies) in arrangements(&stage.grid).into_iter().enumerate() {
        for (j, (mode, refine, lighting)) in
            [(MODES[0], false, None), (MODES[0], true, light), (MODES[1], false, light), (MODES[2], false, None)]
                .into_iter()
                .enumerate()
        {
            // Stretches of bodies one in another are compared elsewhere.
            if refine && i == 2 {
                continue;
            }
            let focus = focus_of(&stage.grid, 12.0, 0.35, Context::Faded);
            let seen = projections(&view(&stage.grid, bodies.clone()))[(i + j) % 2].clone();
            let plain = Frame { mode, refine, lighting, ..seen };
            let without = stage.image(&plain);
            let image = stage.image(&Frame { focus: Some(focus), ..plain.clone() });
            let d = difference(&image, &by_the_book(&stage, &plain, &focus, &Boxes::default()), plain.step_mm);
            println!("{mode:?} refined {refine}: {d:?}");
            assert!(d.beyond_one < 0.01 && d.mean <= 0.2 && d.misplaced < 0.01 && d.covered > 0.1, "{d:?}");
            assert!(apart(&image, &without).len() > 60);
        }
    }
}

#[test]
fn what_lies_behind_a_focus_is_faded_and_shows_through_it() {
    let Some(mut stage) = stage() else { return };
    let mut plain = view(&stage.grid, vec![Body::whole(0)]);
    // Past the lump to the wall.
    let along = stage.grid.world_from_index.matrix3 * DVec3::new(-1.0, 0.1, 0.1);
    plain.camera = Camera::framing(&stage.grid.world_bounds(), along, DVec3::Z).zoomed(0.5);
    let focus = focus_of(&stage.grid, 12.0, 0.35, Context::Faded);
    let image = stage.image(&Frame { focus: Some(focus), ..plain.clone() });
    let none = Boxes::default();
    let d = difference(&image, &by_the_book(&stage, &plain, &focus, &none), plain.step_mm);
    assert!(d.beyond_one < 0.01 && d.mean <= 0.2 && d.misplaced < 0.01, "{d:?}");
    let [inside, behind] = [Keeps::Inside, Keeps::Behind].map(|keeps| layer(&stage, &plain, &focus, keeps, &none));
    let through = inside.iter().zip(&behind).filter(|(a, b)| b.colour[3] * (1.0 - a.colour[3]) > 0.1).count();
    assert!(through > 20, "{through}");
}

#[test]
fn looks_of_several_modes_and_meshes_have_their_places_before_in_and_behind_a_focus() {
    let Some(mut stage) = stage() else { return };
    let grid = stage.grid;
    let [whole, parts, both] = arrangements(&grid);
    let look = |mode, opacity| Look { transfer: tissue(), mode, lighting: None, opacity };
    let at = |p: DVec3| Pose { translation: grid.world_from_index.transform_point3(p), ..Pose::IDENTITY };
    let bounds = Aabb { min: DVec3::splat(-3.0), max: DVec3::splat(3.0) };
    let opaque = [DVec3::new(8.0, 12.0, 20.0), MIDDLE + DVec3::X * 5.0, DVec3::new(40.0, 26.0, 18.0)];
    let opaque = opaque.iter().zip(900..);
    let opaque = opaque.map(|(&p, id)| OpaqueBox { id, bounds, pose: at(p), colour: [0.1, 0.5, 0.9], lighting: None });
    let boxes = [Boxes::default(), Boxes { opaque: opaque.collect(), ..Boxes::default() }];
    for (mut bodies, boxes) in [(parts, &boxes[0]), (both, &boxes[0]), (whole, &boxes[1])] {
        for (i, body) in bodies.iter_mut().enumerate() {
            body.look = Some(i);
        }
        let focus = focus_of(&grid, 12.0, 0.5, Context::Faded);
        let looks = vec![look(Mode::Iso(20_000.0), 0.6), look(Mode::Mip, 0.8)];
        let plain = Frame { looks, layers: boxes.meshes(), ..view(&grid, bodies) };
        let image = stage.image(&Frame { focus: Some(focus), ..plain.clone() });
        let d = difference(&image, &by_the_book(&stage, &plain, &focus, boxes), plain.step_mm);
        assert!(d.beyond_one < 0.015 && d.mean <= 0.25 && d.misplaced < 0.015 && d.covered > 0.1, "{d:?}");
    }
}

/// Whether something that shows lies on a pixel's ray inside the ball, and outside of it.
fn met(dense: &Dense, grid: &Grid, frame: &Frame, focus: &Focus, px: DVec2) -> [bool; 2] {
    let ray = frame.camera.ray(px, frame.size);
    let mut met = [false; 2];
    let nearest = (focus.centre - ray.origin).dot(ray.dir);
    for i in -900..900 {
        let p = ray.at(nearest + f64::from(i) * 0.1);
        let index = grid.index_from_world().transform_point3(p);
        let n = grid.dims_f64();
        let shows = index.cmpge(DVec3::splat(-0.5)).all() && index.cmple(n - 0.5).all() && {
            let value = dense.density(index);
            match frame.mode {
                Mode::Iso(level) => value >= level,
                Mode::Dvr | Mode::Mip => frame.transfer.opacity_at(value) > 0.0,
            }
        };
        met[usize::from(p.distance(focus.centre) > focus.radius_mm)] |= shows;
    }
    met
}

#[test]
fn pixels_whose_rays_meet_only_what_is_in_focus_do_not_change_by_a_bit() {
    let Some(mut stage) = stage() else { return };
    let grid = stage.grid;
    let dense = Dense::of(&stage.fields(), &grid);
    for form in [Form::Fragments, Form::Workgroups] {
        stage.caster.set_form(form);
        for (mode, refine) in [(MODES[0], false), (MODES[0], true), (MODES[1], false), (MODES[2], false)] {
            for context in [Context::Faded, Context::Contour] {
                if form == Form::Workgroups && !refine {
                    continue;
                }
                let focus = focus_of(&grid, 11.0, 0.3, context);
                let [frame, _] = projections(&view(&grid, vec![Body::whole(0)]));
                let plain = Frame { mode, refine, lighting: Some(Lighting::default()), ..frame };
                let without = stage.image(&plain);
                let with = stage.image(&Frame { focus: Some(focus), ..plain.clone() });
                let (mut same, mut others) = (0, 0);
                for i in 0..with.colour.len() {
                    let px = DVec2::new((i % WIDTH) as f64 + 0.5, (i / WIDTH) as f64 + 0.5);
                    match met(&dense, &grid, &plain, &focus, px) {
                        [true, false] => {
                            let said = |image: &Image| (image.colour[i], image.depth_mm[i].to_bits(), image.object[i]);
                            assert_eq!(said(&with), said(&without), "{mode:?} {context:?} at {px}");
                            same += 1;
                        }
                        [false, false] => {}
                        [_, true] => others += usize::from(with.colour[i] != without.colour[i]),
                    }
                }
                assert!(same > 10 && others > 60, "{mode:?} {context:?}: {same} the same, {others} others");
            }
        }
    }
}

#[test]
fn a_context_of_full_opacity_is_the_plain_picture() {
    let Some(mut stage) = stage() else { return };
    let plain = view(&stage.grid, vec![Body::whole(0)]);
    let focus = Some(focus_of(&stage.grid, 12.0, 1.0, Context::Faded));
    assert_eq!(stage.image(&Frame { focus, ..plain.clone() }), stage.image(&plain));
}

#[test]
fn nothing_is_left_of_a_context_without_opacity() {
    let Some(mut stage) = stage() else { return };
    let focus = focus_of(&stage.grid, 12.0, 0.0, Context::Faded);
    let plain = view(&stage.grid, vec![Body::whole(0)]);
    let image = stage.image(&Frame { focus: Some(focus), ..plain.clone() });
    for (i, pixel) in image.colour.iter().enumerate() {
        let px = DVec2::new((i % WIDTH) as f64 + 0.5, (i / WIDTH) as f64 + 0.5);
        let ray = plain.camera.ray(px, plain.size);
        let off = (focus.centre - ray.origin).cross(ray.dir).length();
        assert!(pixel[3] == 0.0 || off < focus.radius_mm + 1e-3, "{px}: {pixel:?}");
    }
}

/// (1 − |n·v|)³ on what the ray hides front to back, where the table changes by a sixteenth in a voxel, less by the square below.
fn contour(dense: &Dense, grid: &Grid, frame: &Frame, px: DVec2, (from, to): (f64, f64)) -> [f64; 4] {
    let ray = frame.camera.ray(px, frame.size);
    let inverse = grid.index_from_world();
    let turned = |cosine: f64| (1.0 - cosine.abs()).powi(3);
    let cosine = |index: DVec3| {
        let along = |axis: DVec3| dense.density(index + axis * 0.5) - dense.density(index - axis * 0.5);
        let g = DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z));
        let world = inverse.matrix3.transpose() * g;
        (g.length(), if world == DVec3::ZERO { 1.0 } else { world.normalize().dot(ray.dir) })
    };
    let inside = |t: f64| {
        let index = inverse.transform_point3(ray.at(t));
        index.cmpge(DVec3::splat(-0.5)).all() && index.cmplt(grid.dims_f64() - 0.5).all()
    };
    let (lo, hi) = frame.transfer.domain();
    let (mut colour, mut clear) = ([0.0; 4], 1.0);
    let mut k = (from / frame.step_mm).ceil();
    while k * frame.step_mm < to.min(400.0) && clear >= 1.0 / 256.0 {
        let t = k * frame.step_mm;
        k += 1.0;
        if !inside(t) {
            continue;
        }
        let index = inverse.transform_point3(ray.at(t));
        let value = dense.density(index);
        let thin = f64::from(frame.transfer.opacity_at(value));
        let alpha = 1.0 - (1.0 - thin).powf(frame.step_mm / frame.transfer.unit_mm);
        let (length, cosine) = cosine(index);
        let window = (length / (hi - lo) * 16.0).min(1.0);
        let line = clear * alpha * turned(cosine) * window * window;
        for (c, own) in colour.iter_mut().zip(frame.transfer.colour_at(value)) {
            *c += line * f64::from(own);
        }
        colour[3] += line;
        clear *= 1.0 - alpha;
    }
    colour
}

#[test]
fn contours_are_where_matter_turns_away_from_the_eye() {
    let Some(mut stage) = stage() else { return };
    let focus = focus_of(&stage.grid, 9.0, 0.8, Context::Contour);
    let dense = Dense::of(&stage.fields(), &stage.grid);
    for seen in projections(&view(&stage.grid, vec![Body::whole(0)])) {
        // Refining and light are not the contours'.
        let frame = Frame { focus: Some(focus), ..seen.clone() };
        let image = stage.image(&frame);
        let inside = layer(&stage, &seen, &focus, Keeps::Inside, &Boxes::default());
        let (mut drawn, mut worst) = (0, 0.0_f64);
        for (i, pixel) in image.colour.iter().enumerate() {
            let px = DVec2::new((i % WIDTH) as f64 + 0.5, (i / WIDTH) as f64 + 0.5);
            let ray = seen.camera.ray(px, seen.size);
            let piece =
                |keeps| Boxes { kept: Some((focus.centre, focus.radius_mm, keeps)), ..Boxes::default() }.piece(&ray);
            let line = |keeps| {
                piece(keeps).map_or([0.0; 4], |(from, to, _)| contour(&dense, &stage.grid, &seen, px, (from, to)))
            };
            let (before, behind) = (line(Keeps::Before).map(|c| 0.8 * c), line(Keeps::Behind).map(|c| 0.8 * c));
            drawn += usize::from(before[3] > 0.1);
            let b = inside[i].colour;
            for c in 0..4 {
                let expected = before[c] + (1.0 - before[3]) * (b[c] + (1.0 - b[3]) * behind[c]);
                worst = worst.max((f64::from(pixel[c]) - expected).abs() * 255.0);
            }
        }
        println!("{drawn} pixels of contours, worst {worst}");
        assert!(drawn > 10 && worst <= 3.0, "{drawn} {worst}");
    }
}

#[test]
fn the_contours_of_a_surface_are_one_line_of_its_own_opacity() {
    let Some(mut stage) = stage() else { return };
    let grid = stage.grid;
    let [seen, _] = projections(&view(&grid, vec![Body::whole(0)]));
    // Behind the eye: all of the picture is context.
    let centre = seen.camera.eye - seen.camera.forward() * 40.0;
    let focus = Focus { centre, radius_mm: 5.0, opacity: 1.0, context: Context::Contour };
    let plain = Frame { mode: Mode::Iso(20_000.0), ..seen };
    // Light that is a surface's cosine and nothing else, on white.
    let light = Lighting { ambient: 0.0, diffuse: 1.0, specular: 0.0, power: 1.0 };
    let mut white = Frame { lighting: Some(light), ..plain.clone() };
    white.transfer.colour = vec![(0.0, [1.0; 3]), (60_000.0, [1.0; 3])];
    let cosines = stage.image(&white);
    let lines = stage.image(&Frame { focus: Some(focus), ..white.clone() });
    let alike = stage.image(&Frame { lighting: None, focus: Some(focus), ..white });
    assert!(lines.colour == alike.colour, "contours are lit by nothing");
    let (mut drawn, mut far) = (0, 0);
    for (i, line) in lines.colour.iter().enumerate() {
        let surface = cosines.colour[i];
        let expected = if surface[3] > 0.0 { (1.0 - surface[0]).powi(3) } else { 0.0 };
        drawn += usize::from(expected > 0.1);
        far += usize::from((line[3] - expected).abs() > 1.0 / 255.0 || (line[0] - line[3]).abs() > 1e-5);
    }
    assert!(drawn > 20 && far == 0, "{drawn} drawn, {far} others");
}

#[test]
fn a_focus_lies_in_the_world_whatever_parts_and_boxes_there_are() {
    let Some(gpu) = gpu() else { return };
    let family = super::sub_volumes::family(super::sub_volumes::DIMS, &[super::sub_volumes::INNER]);
    let grid = *family.volumes[0].grid();
    let centre = grid.world_from_index.transform_point3(DVec3::new(19.0, 27.0, 17.0));
    let focus = Focus { centre, radius_mm: 9.0, opacity: 0.0, context: Context::Faded };
    for mode in [Mode::Dvr, Mode::Iso(2100.0), Mode::Mip] {
        let lighting = Some(Lighting::default());
        let seen = frame(&grid, ramp(1500.0, 3000.0), DVec3::new(0.5, 1.0, 0.4), [40, 40]);
        let plain = Frame { mode, lighting, ..seen };
        let draw = |frame: &Frame| {
            let mut pools = FieldPools::empty(&gpu, 256 << 20).unwrap();
            Caster::new(&gpu).unwrap().image(&gpu, &mut pools, &family.fields(), frame).unwrap()
        };
        let boxed = family.with_boxes(&Frame { focus: Some(focus), ..plain.clone() });
        let image = draw(&boxed);
        // Without opacity outside it is what is inside, of the box and of what it lies in.
        let ball = Ball { centre, radius_mm: 9.0, keeps: Keeps::Inside, contour: false };
        let inside =
            draw(&Frame { focus: None, layers: Layers { ball: Some(ball), ..Layers::default() }, ..boxed.clone() });
        let without = draw(&Frame { focus: Some(focus), ..plain });
        let differ = |other: &Image| {
            let far = |&i: &usize| (0..4).any(|c| (image.colour[i][c] - other.colour[i][c]).abs() > 1.0 / 255.0);
            (0..image.colour.len()).filter(far).count()
        };
        // But for a pixel at whose edge the ball and a surface meet.
        assert!(differ(&inside) <= 2, "{mode:?}");
        assert!(differ(&without) > 5, "{mode:?}: the box does not show");
    }
    // A body that a hand moved away from the ball is context; the other half is not.
    let Some(mut stage) = stage() else { return };
    let focus = focus_of(&stage.grid, 14.0, 0.0, Context::Faded);
    let far = Pose { translation: DVec3::X * 300.0, ..Pose::IDENTITY };
    let moved = Body { pose: far, mask: Mask::None, ..Body::whole(1) };
    let seen = Frame { focus: Some(focus), ..view(&stage.grid, vec![moved]) };
    assert!(stage.image(&seen).colour.iter().all(|c| c[3] == 0.0));
    let seen = Frame { focus: Some(focus), ..view(&stage.grid, vec![Body::whole(1)]) };
    assert!(stage.image(&seen).colour.iter().any(|c| c[3] > 0.2));
}
