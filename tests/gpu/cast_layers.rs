//! Opaque meshes, meshes that cut and planes that clip, against rays through boxes by geometry.

use super::cast_modes::{Stage, lumps, oblique_grid, projections, tissue};
use super::reference::{Dense, difference, picture_among};
use super::reference_boxes::{Boxes, OpaqueBox, Solid};
use crate::common::gpu::gpu;
use crate::common::volumes::*;
use burin::gpu::cast::tiles::Window;
use burin::gpu::{Body, CutMesh, Frame, Image, Layers, Look, Mask, ObjectId, OpaqueMesh};
use burin::math::{Aabb, DQuat, DVec2, DVec3, Plane, Pose};
use burin::mesh::{MeshError, TriangleMesh};
use burin::volume::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

const MODES: [Mode; 3] = [Mode::Dvr, Mode::Iso(44_000.0), Mode::Mip];

fn stage() -> Option<Stage> {
    let gpu = gpu()?;
    let grid = oblique_grid([66, 44, 36]);
    Some(Stage::new(gpu, grid, lumps(grid)))
}

fn any(rng: &mut ChaCha8Rng, s: f64) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| rng.random_range(-s..s)))
}

/// A box about the origin, and a pose that brings it into the volume.
fn random_box(rng: &mut ChaCha8Rng, grid: &Grid) -> (Aabb, Pose) {
    let half = any(rng, 5.0).abs() + 4.0;
    let middle = grid.world_bounds().centre() + any(rng, 9.0);
    (Aabb { min: -half, max: half * 0.8 }, Pose::about(DVec3::ZERO, DQuat::from_scaled_axis(any(rng, 2.0)), middle))
}

fn opaque_boxes(rng: &mut ChaCha8Rng, grid: &Grid, count: u32) -> Vec<OpaqueBox> {
    (0..count)
        .map(|i| {
            let (bounds, pose) = random_box(rng, grid);
            let colour = std::array::from_fn(|_| rng.random_range(0.2..1.0));
            let lighting = (i % 2 == 0).then(|| Lighting { specular: 0.0, ..Lighting::default() });
            OpaqueBox { id: 900 + i, bounds, pose, colour, lighting }
        })
        .collect()
}

fn view(grid: &Grid, bodies: Vec<Body>, boxes: &Boxes) -> Frame {
    let mut view = frame(grid, tissue(), DVec3::new(1.0, -1.6, 0.8), [42, 36]);
    view.camera = view.camera.zoomed(0.9);
    // Thin, so that what lies inside shows.
    view.transfer.opacity.iter_mut().for_each(|p| p.1 *= 0.12);
    view.bodies = bodies;
    view.layers = boxes.meshes();
    view
}

/// One body; parts that moved apart; bodies one in another, so that their intervals are merged.
pub fn arrangements(grid: &Grid) -> [Vec<Body>; 3] {
    let centre = grid.world_bounds().centre();
    let halves = [1.0, -1.0].map(|side| {
        let plane = Plane::through(centre, DVec3::new(0.5, 0.3, 0.8) * side).unwrap();
        let pose = Pose::about(centre, DQuat::from_rotation_z(0.2 * side), plane.normal * -5.0);
        Body { pose, region: vec![plane], ..Body::whole(20 + (side > 0.0) as u32) }
    });
    let turned = Pose::about(centre, DQuat::from_rotation_x(0.9), DVec3::new(3.0, -2.0, 1.0));
    let tint = Some([0.6, 0.9, 1.0]);
    let inside_one_another = vec![Body::whole(0), Body { pose: turned, tint, ..Body::whole(1) }];
    [vec![Body::whole(0)], halves.to_vec(), inside_one_another]
}

/// Draws the frame and compares it with the boxes: all but a few pixels, at edges that the raster puts on a 256th of a pixel,
/// agree as closely as pictures without layers do.
fn check(stage: &mut Stage, frame: &Frame, boxes: &Boxes) -> Image {
    let image = stage.image(frame);
    let reference = picture_among(&Dense::of(&stage.fields(), &stage.grid), frame, boxes);
    let d = difference(&image, &reference, frame.step_mm);
    println!("{:?} lit {}: {d:?}", frame.mode, frame.lighting.is_some());
    assert!(d.beyond_one < 0.01 && d.mean <= 0.2 && d.misplaced < 0.01 && d.covered > 0.02, "{:?} {d:?}", frame.mode);
    image
}

/// The picture and the same without layers differ in so many pixels.
fn changed(stage: &mut Stage, frame: &Frame, image: &Image) -> usize {
    let bare = stage.image(&Frame { layers: Layers::default(), ..frame.clone() });
    image.colour.iter().zip(&bare.colour).filter(|(a, b)| a != b).count()
}

#[test]
fn rays_end_at_opaque_boxes_and_show_them_behind_what_they_gathered() {
    let Some(mut stage) = stage() else { return };
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for bodies in arrangements(&stage.grid) {
        let boxes = Boxes { opaque: opaque_boxes(&mut rng, &stage.grid, 3), ..Boxes::default() };
        let (mut seen, mut others) = (0, 0);
        for mode in MODES {
            for frame in projections(&view(&stage.grid, bodies.clone(), &boxes)) {
                for lighting in [None, Some(Lighting::default())] {
                    let frame = Frame { mode, lighting, ..frame.clone() };
                    let image = check(&mut stage, &frame, &boxes);
                    seen +=
                        image.object.iter().filter(|o| o.body().is_some_and(|id| (900..=902).contains(&id))).count();
                    others += changed(&mut stage, &frame, &image);
                }
            }
        }
        assert!(seen > 100 && others > 200, "{seen} {others}");
    }
}

#[test]
fn nothing_of_a_body_shows_inside_a_closed_mesh_that_cuts() {
    let Some(mut stage) = stage() else { return };
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    for bodies in arrangements(&stage.grid) {
        let solid = |(bounds, pose)| Solid { boxes: vec![(bounds, false)], pose };
        // Several, that may overlap.
        let cuts = (0..4).map(|_| solid(random_box(&mut rng, &stage.grid))).collect();
        let boxes = Boxes { cuts, ..Boxes::default() };
        let mut others = 0;
        for mode in MODES {
            for frame in projections(&view(&stage.grid, bodies.clone(), &boxes)) {
                for lighting in [None, Some(Lighting::default())] {
                    let frame = Frame { mode, lighting, ..frame.clone() };
                    let image = check(&mut stage, &frame, &boxes);
                    others += changed(&mut stage, &frame, &image);
                }
            }
        }
        assert!(others > 100, "{others}");
    }
}

#[test]
fn a_mesh_with_a_cavity_cuts_its_wall_alone_and_one_twice_wound_cuts_once() {
    let Some(mut stage) = stage() else { return };
    let grid = stage.grid;
    let centre = grid.world_bounds().centre();
    let around = |half: f64| Aabb { min: DVec3::splat(-half), max: DVec3::splat(half) };
    let pose = Pose::about(DVec3::ZERO, DQuat::from_rotation_y(0.6), centre);
    let shifted = Aabb { min: DVec3::splat(-2.0), max: DVec3::splat(14.0) };
    let cavity = Solid { boxes: vec![(around(10.0), false), (around(6.0), true)], pose };
    let twice = Solid { boxes: vec![(around(7.0), false), (shifted, false)], pose };
    // Two meshes of opposite sense in one place: what one of them holds is gone.
    let inside_out = Solid { boxes: vec![(around(7.0), true)], pose };
    let both = vec![Solid { boxes: vec![(around(7.0), false)], pose }, inside_out.clone()];
    for cuts in [vec![cavity.clone()], vec![twice], vec![inside_out], both, vec![cavity.clone(), cavity]] {
        let boxes = Boxes { cuts, ..Boxes::default() };
        let mut others = 0;
        for mode in MODES {
            for frame in projections(&view(&grid, vec![Body::whole(0)], &boxes)) {
                let frame = Frame { mode, lighting: Some(Lighting::default()), ..frame };
                let image = check(&mut stage, &frame, &boxes);
                others += changed(&mut stage, &frame, &image);
            }
        }
        assert!(others > 60, "{others}");
    }
}

#[test]
fn an_eye_inside_a_cut_or_beside_an_opaque_box_sees_from_there() {
    let Some(mut stage) = stage() else { return };
    let grid = stage.grid;
    let eye = grid.world_bounds().centre();
    let at = Pose { translation: eye, ..Pose::IDENTITY };
    let bounds = Aabb { min: DVec3::new(-4.0, -5.0, -3.0), max: DVec3::new(6.0, 7.0, 5.0) };
    let ahead = Aabb { min: DVec3::new(2.0, 3.0, -9.0), max: DVec3::new(9.0, 14.0, 0.5) };
    let boxes = Boxes {
        kept: None,
        opaque: vec![OpaqueBox { id: 7, bounds: ahead, pose: at, colour: [0.3, 0.9, 0.4], lighting: None }],
        cuts: vec![Solid { boxes: vec![(bounds, false)], pose: at }],
    };
    let mut seen = view(&grid, vec![Body::whole(0)], &boxes);
    seen.camera.eye = eye;
    seen.camera.target = eye + DVec3::new(0.4, 1.0, -0.1) * 10.0;
    seen.step_mm = 0.7;
    for mode in MODES {
        for lighting in [None, Some(Lighting::default())] {
            let frame = Frame { mode, lighting, ..seen.clone() };
            let image = check(&mut stage, &frame, &boxes);
            assert!(image.object.iter().any(|o| o.body() == Some(7)) && changed(&mut stage, &frame, &image) > 250);
        }
    }
}

#[test]
fn layers_act_on_bodies_of_several_looks_and_modes() {
    let Some(mut stage) = stage() else { return };
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let grid = stage.grid;
    for bodies in arrangements(&grid) {
        let solid = |(bounds, pose)| Solid { boxes: vec![(bounds, false)], pose };
        let cuts = (0..3).map(|_| solid(random_box(&mut rng, &grid))).collect();
        let boxes = Boxes { opaque: opaque_boxes(&mut rng, &grid, 1), cuts, kept: None };
        let mut seen = view(&grid, bodies, &boxes);
        let look = |mode, lighting, opacity| Look { transfer: seen.transfer.clone(), mode, lighting, opacity };
        let lit = Some(Lighting::default());
        seen.looks = vec![
            look(Mode::Iso(44_000.0), lit, 0.6),
            look(Mode::Mip, None, 0.8),
            look(Mode::Dvr, lit, 1.0),
            look(Mode::Iso(38_000.0), None, 1.0),
        ];
        let mut others = 0;
        for rows in [[0, 2], [2, 1], [1, 3], [3, 0]] {
            seen.bodies.iter_mut().zip(rows).for_each(|(body, row)| body.look = Some(row));
            for frame in projections(&seen) {
                let image = check(&mut stage, &frame, &boxes);
                others += changed(&mut stage, &frame, &image);
            }
        }
        assert!(others > 100, "{others}");
    }
}

#[test]
fn planes_clip_all_bodies_where_they_stand() {
    let Some(mut stage) = stage() else { return };
    let grid = stage.grid;
    let centre = grid.world_bounds().centre();
    let clips = [DVec3::new(0.2, -1.0, 0.3), DVec3::new(1.0, 0.4, 0.0)]
        .map(|n| Plane::through(centre - n.normalize() * 2.0, n).unwrap());
    for bodies in arrangements(&grid) {
        for clips in [clips[..1].to_vec(), clips.to_vec()] {
            let mut others = 0;
            for mode in MODES {
                for frame in projections(&view(&grid, bodies.clone(), &Boxes::default())) {
                    let layers = Layers { clips: clips.clone(), ..Layers::default() };
                    let frame = Frame { mode, layers, lighting: Some(Lighting::default()), ..frame };
                    let image = check(&mut stage, &frame, &Boxes::default());
                    others += changed(&mut stage, &frame, &image);
                }
            }
            assert!(others > 200, "{others}");
        }
    }
    // A plane that has all of it outside leaves nothing, one that has all of it inside leaves the picture as it is.
    let whole = view(&grid, vec![Body::whole(0)], &Boxes::default());
    let far = Plane { normal: DVec3::X, offset: centre.x + 500.0 };
    let clipped = |stage: &mut Stage, plane| {
        stage.image(&Frame { layers: Layers { clips: vec![plane], ..Layers::default() }, ..whole.clone() })
    };
    assert_eq!(clipped(&mut stage, far), stage.image(&whole));
    assert!(clipped(&mut stage, far.flipped()).object.iter().all(|o| *o == ObjectId::NOTHING));
}

#[test]
fn a_cut_beside_a_plane_beside_an_opaque_box_are_one_picture() {
    let Some(mut stage) = stage() else { return };
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let grid = stage.grid;
    for bodies in arrangements(&grid) {
        let (bounds, pose) = random_box(&mut rng, &grid);
        let boxes = Boxes {
            kept: None,
            opaque: opaque_boxes(&mut rng, &grid, 2),
            cuts: vec![Solid { boxes: vec![(bounds, false)], pose }],
        };
        let mut seen = view(&grid, bodies, &boxes);
        let normal = any(&mut rng, 1.0);
        seen.layers.clips = Plane::through(grid.world_bounds().centre() - normal * 3.0, normal).into_iter().collect();
        for mode in MODES {
            for step_mm in [0.45, 1.3] {
                check(&mut stage, &Frame { mode, step_mm, ..seen.clone() }, &boxes);
            }
        }
    }
}

#[test]
fn layers_that_no_ray_meets_change_no_bit() {
    let Some(mut stage) = stage() else { return };
    let aside = Pose { translation: DVec3::splat(4000.0), ..Pose::IDENTITY };
    let bounds = Aabb { min: DVec3::splat(-3.0), max: DVec3::splat(3.0) };
    let boxes = Boxes {
        kept: None,
        opaque: vec![OpaqueBox { id: 7, bounds, pose: aside, colour: [1.0; 3], lighting: None }],
        cuts: vec![Solid { boxes: vec![(bounds, false)], pose: aside }],
    };
    for bodies in arrangements(&stage.grid) {
        for mode in MODES {
            let frame =
                Frame { mode, lighting: Some(Lighting::default()), ..view(&stage.grid, bodies.clone(), &boxes) };
            let bare = Frame { layers: Layers::default(), ..frame.clone() };
            assert_eq!(stage.image(&frame), stage.image(&bare), "{mode:?}");
        }
    }
}

#[test]
fn layers_hold_over_many_passes() {
    let Some(mut stage) = stage() else { return };
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let grid = stage.grid;
    let (bounds, pose) = random_box(&mut rng, &grid);
    let boxes = Boxes {
        opaque: opaque_boxes(&mut rng, &grid, 2),
        cuts: vec![Solid { boxes: vec![(bounds, false)], pose }],
        kept: None,
    };
    let [whole, _, merged] = arrangements(&grid);
    for (bodies, step_mm) in [(whole, 0.003), (merged, 0.006)] {
        let mut seen = view(&grid, bodies, &boxes);
        (seen.step_mm, seen.size) = (step_mm, [11, 9]);
        for mode in MODES {
            let frame = Frame { mode, ..seen.clone() };
            let image = stage.image(&frame);
            let reference = picture_among(&Dense::of(&stage.fields(), &grid), &frame, &boxes);
            let d = difference(&image, &reference, 0.1);
            // At most one pixel of an edge, and one whose depth is between two samples.
            assert!(d.beyond_one <= 0.011 && d.misplaced <= 0.021 && d.covered > 0.05, "{mode:?} {d:?}");
        }
    }
}

#[test]
fn a_part_of_the_picture_has_the_layers_of_the_whole() {
    let Some(mut stage) = stage() else { return };
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let grid = stage.grid;
    let (bounds, pose) = random_box(&mut rng, &grid);
    let boxes = Boxes {
        opaque: opaque_boxes(&mut rng, &grid, 2),
        cuts: vec![Solid { boxes: vec![(bounds, false)], pose }],
        kept: None,
    };
    for mode in MODES {
        let frame = Frame { mode, ..view(&grid, vec![Body::whole(0)], &boxes) };
        let whole = stage.image(&frame);
        let Stage { gpu, pools, caster, grid, fields: [density, colour, selection, labels], .. } = &mut stage;
        let fields = one_volume(grid, density, colour, selection, labels);
        let window = Window { picture: frame.size, origin: DVec2::new(13.0, 9.0), size: [21, 17], only: None };
        let part = caster.part(gpu, pools, &fields, &frame, &window).unwrap();
        let mut put = whole.clone();
        put.put(&part, [13, 9]);
        let off = put.colour.iter().zip(&whole.colour).filter(|(a, b)| (0..4).any(|c| (a[c] - b[c]).abs() > 2e-3));
        assert!(off.count() <= 2, "{mode:?}");
        // Points are hit on the mesh, in its own space too.
        let i = whole.object.iter().position(|o| o.body() == Some(900)).unwrap();
        let px = DVec2::new((i % 42) as f64 + 0.5, (i / 42) as f64 + 0.5);
        let hit = caster.pick(gpu, pools, &fields, &frame, px).unwrap().unwrap();
        assert_eq!(hit.body, 900);
        let o = &boxes.opaque[0];
        let face = (0..3).map(|a| (hit.rest[a] - o.bounds.min[a]).abs().min((hit.rest[a] - o.bounds.max[a]).abs()));
        assert!(face.fold(f64::INFINITY, f64::min) < 1e-3, "{:?} on a face of {:?}", hit.rest, o.bounds);
        let along = caster.pick_along(gpu, pools, &fields, &frame, [px - DVec2::X * 4.0, px], 5).unwrap();
        assert!(along[4].is_some_and(|h| h.body == 900 && h.world.distance(hit.world) < 1e-3), "{:?}", along[4]);
    }
}

#[test]
fn what_layers_hide_or_take_away_counts_as_such() {
    let Some(mut stage) = stage() else { return };
    let grid = stage.grid;
    let middle = grid.dims.map(|n| f64::from(n) * 0.5);
    stage.fields[0] = density_u16(grid, |_| 60_000);
    stage.pools = burin::gpu::FieldPools::new(&stage.gpu, &grid, &stage.fields[0], 256 << 20).unwrap();
    stage.fields[2] = painted(FieldKind::Selection, &grid, move |v| {
        let off = (0..3).map(|a| (f64::from(v[a]) - middle[a]).powi(2)).sum::<f64>();
        [if off < 250.0 { 255 } else { 0 }, 0, 0, 0]
    });
    let bodies = vec![Body { mask: Mask::Selection, ..Body::whole(1) }];
    let centre = grid.world_from_index.transform_point3(DVec3::from_array(middle));
    let mut frame = view(&grid, bodies, &Boxes::default());
    frame.transfer.opacity = vec![(0.0, 1.0)];
    let wide = Aabb { min: DVec3::splat(-60.0), max: DVec3::splat(60.0) };
    let toward = (frame.camera.eye - centre).normalize();
    let place = |along: f64| Pose { translation: centre + toward * along, ..Pose::IDENTITY };
    let mut count = |layers: Layers| {
        let Stage { gpu, pools, caster, grid, fields: [density, colour, selection, labels], .. } = &mut stage;
        let fields = one_volume(grid, density, colour, selection, labels);
        caster.visibility(gpu, pools, &fields, &Frame { layers, ..frame.clone() }).unwrap()
    };
    let bare = count(Layers::default());
    assert!(bare.selected > 30 && bare.visible == bare.selected, "{bare:?}");
    let board = Arc::new(TriangleMesh::cuboid(&Aabb { min: DVec3::splat(-20.0), max: DVec3::splat(20.0) }));
    let opaque =
        |along| OpaqueMesh { id: 3, mesh: board.clone(), pose: place(along), colour: [1.0; 3], lighting: None };
    let hidden = count(Layers { opaque: vec![opaque(40.0)], ..Layers::default() });
    assert_eq!((hidden.selected, hidden.visible), (bare.selected, 0), "behind something opaque");
    let behind = count(Layers { opaque: vec![opaque(-45.0)], ..Layers::default() });
    assert_eq!(behind, bare, "before something opaque");
    let cut = CutMesh { id: 0, mesh: Arc::new(TriangleMesh::cuboid(&wide)), pose: place(0.0) };
    assert_eq!(count(Layers { cuts: vec![cut], ..Layers::default() }).selected, 0, "cut away");
    let half = Plane::through(centre, DVec3::Z).unwrap();
    let clipped = count(Layers { clips: vec![half], ..Layers::default() });
    assert!(clipped.selected * 4 < bare.selected * 3 && clipped.selected > 8, "{clipped:?} of {bare:?}");
}

#[test]
fn arrays_that_are_no_mesh_and_meshes_that_are_too_many_are_answered() {
    let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(
        TriangleMesh::new(corners.clone(), vec![[0, 1, 2], [1, 2, 3]]),
        Err(MeshError::NoSuchCorner { triangle: 1, corner: 3, corners: 3 })
    );
    let nan = TriangleMesh::new(vec![[0.0, f32::NAN, 0.0]], Vec::new()).unwrap_err();
    assert!(nan.to_string().contains("corner 0"), "{nan}");
    let Some(mut stage) = stage() else { return };
    let cuboid = |half: f64| TriangleMesh::cuboid(&Aabb { min: DVec3::splat(-half), max: DVec3::splat(half) });
    let cut = |mesh: &Arc<TriangleMesh>| CutMesh { id: 0, mesh: mesh.clone(), pose: Pose::IDENTITY };
    let mut frame = view(&stage.grid, vec![Body::whole(0)], &Boxes::default());
    let whole = stage.image(&frame);
    // No mesh, and one without triangles.
    frame.layers.cuts = vec![cut(&Arc::new(TriangleMesh::new(corners, Vec::new()).unwrap()))];
    assert_eq!(stage.image(&frame), whole);
    let mut draw = |frame: &Frame| {
        let Stage { gpu, pools, caster, grid, fields: [density, colour, selection, labels], .. } = &mut stage;
        let fields = one_volume(grid, density, colour, selection, labels);
        caster.image(gpu, pools, &fields, frame)
    };
    let one = Arc::new(cuboid(1.0));
    frame.layers.cuts = (0..65).map(|_| cut(&one)).collect();
    let error = draw(&frame).unwrap_err().to_string();
    assert!(error.contains("65 meshes") && error.contains("at most 64"), "{error}");
    // Shells one in another: more faces than a ray can hold are told, and what fits is drawn.
    let centre = frame.camera.target;
    let shells = |count: usize| {
        (0..count).map(|i| CutMesh {
            id: 0,
            mesh: Arc::new(cuboid(1.0 + i as f64 * 0.1)),
            pose: Pose { translation: centre, ..Pose::IDENTITY },
        })
    };
    frame.layers.cuts = shells(60).collect();
    let nested = draw(&frame).unwrap();
    frame.layers.cuts = shells(60).skip(59).collect();
    let outermost = draw(&frame).unwrap();
    let off = nested.colour.iter().zip(&outermost.colour).filter(|(a, b)| (0..4).any(|c| (a[c] - b[c]).abs() > 1e-3));
    assert!(off.count() <= 4, "the union of shells is the largest");
    let thick = (0..70).flat_map(|i| {
        let at = centre - DVec3::Z * (i as f64 * 0.2);
        let bounds = Aabb { min: at - DVec3::new(20.0, 20.0, 0.05), max: at + DVec3::new(20.0, 20.0, 0.05) };
        let mesh = TriangleMesh::cuboid(&bounds);
        mesh.corners().to_vec()
    });
    let corners: Vec<[f32; 3]> = thick.collect();
    let box_of = TriangleMesh::cuboid(&Aabb { min: DVec3::ZERO, max: DVec3::ONE });
    let triangles = (0..70_u32).flat_map(|i| box_of.triangles().iter().map(move |t| t.map(|c| c + 8 * i))).collect();
    frame.layers.cuts = vec![cut(&Arc::new(TriangleMesh::new(corners, triangles).unwrap()))];
    frame.camera.eye = centre + DVec3::Z * 200.0 + DVec3::X;
    let error = draw(&frame).unwrap_err().to_string();
    assert!(error.contains("more than 128 faces"), "{error}");
}

#[test]
fn a_body_that_a_cut_spares_is_as_without_it() {
    let Some(mut stage) = stage() else { return };
    let grid = stage.grid;
    let [_, halves, _] = arrangements(&grid);
    let centre = grid.world_bounds().centre();
    // A box in each half, where that stands: neither reaches the other half.
    let half = DVec3::splat(9.0);
    let mesh = Arc::new(TriangleMesh::cuboid(&Aabb { min: -half, max: half }));
    let cut = |id: u32, body: &Body| {
        let inward = -body.region[0].normal;
        let place = body.pose.apply(centre + inward * 11.0);
        CutMesh { id, mesh: mesh.clone(), pose: Pose::about(DVec3::ZERO, DQuat::IDENTITY, place) }
    };
    let cuts = [cut(1, &halves[0]), cut(2, &halves[1])];
    for mode in MODES {
        for frame in projections(&view(&grid, halves.clone(), &Boxes::default())) {
            let mut frame = Frame { mode, lighting: Some(Lighting::default()), ..frame };
            let mut draw = |spared: [&[u32]; 2], cuts: &[CutMesh]| {
                frame.layers.cuts = cuts.to_vec();
                for (body, spared) in frame.bodies.iter_mut().zip(spared) {
                    body.spared_by = spared.into();
                }
                stage.image(&frame)
            };
            let [none, all] = [draw([&[], &[]], &[]), draw([&[], &[]], &cuts)];
            let [first, second] = [draw([&[], &[]], &cuts[..1]), draw([&[], &[]], &cuts[1..])];
            // A surface may lie before both boxes, a maximum beside them.
            let cuts_both = all != none && first != all && second != all && first != second;
            assert!(cuts_both || mode != Mode::Dvr, "{mode:?}: both cut");
            assert_eq!(draw([&[1], &[]], &cuts), second, "{mode:?}: the first half is spared by the first");
            assert_eq!(draw([&[], &[2]], &cuts), first, "{mode:?}: the second half is spared by the second");
            assert_eq!(draw([&[2], &[1]], &cuts), all, "{mode:?}: what cuts elsewhere spares nothing here");
            assert_eq!(draw([&[1, 2], &[1, 2]], &cuts), none, "{mode:?}: nothing is cut");
        }
    }
}
