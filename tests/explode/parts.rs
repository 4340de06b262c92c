//! Splitting convex parts, against volumes and membership.

use super::{cube, oblique, octants, unit};
use burin::explode::{ExplodeError, Explosion, Forces, PartId, Poses};
use burin::math::{DAffine3, DMat3, DQuat, DVec3, Plane, Pose};
use burin::volume::Grid;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn total(explosion: &Explosion) -> f64 {
    explosion.parts.iter().map(|p| p.volume_mm3()).sum()
}

#[test]
fn the_whole_is_the_box_of_an_oblique_grid() {
    let grid = oblique();
    let whole = Explosion::whole(&grid);
    assert_eq!(whole.parts.len(), 1);
    let part = &whole.parts[0];
    assert_eq!((part.faces.len(), part.vertices.len()), (6, 8));
    let expected = grid.world_from_index.matrix3.determinant().abs() * grid.voxel_count() as f64;
    assert!((part.volume_mm3() / expected - 1.0).abs() < 1e-12);
    let index_from_world = grid.index_from_world();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for _ in 0..2000 {
        let index =
            grid.dims_f64() * DVec3::new(rng.random(), rng.random(), rng.random()) * 1.4 - grid.dims_f64() * 0.2;
        let world = grid.world_from_index.transform_point3(index);
        let inside = part.faces.iter().all(|f| f.plane.distance(world) <= 0.0);
        assert_eq!(inside, grid.voxel_at(index_from_world.transform_point3(world)).is_some());
    }
    assert!(part.faces.iter().all(|f| !f.cut));
    whole.check().unwrap();
}

#[test]
fn a_mirrored_grid_has_outward_faces_too() {
    let mut grid = oblique();
    grid.world_from_index.matrix3.x_axis *= -1.0;
    let whole = Explosion::whole(&grid);
    assert!(whole.parts[0].volume_mm3() > 0.0);
    whole.check().unwrap();
}

#[test]
fn the_longest_diagonal_survives_splits() {
    let grid = cube(20);
    assert!((Explosion::whole(&grid).diagonal_mm() - 20.0 * 3.0_f64.sqrt()).abs() < 1e-12);
    assert_eq!(octants(&grid).diagonal_mm(), Explosion::whole(&grid).diagonal_mm());
}

#[test]
fn octants_are_eight_boxes_that_share_their_corners_exactly() {
    let explosion = octants(&cube(20));
    assert_eq!(explosion.parts.len(), 8);
    for part in &explosion.parts {
        assert_eq!((part.faces.len(), part.vertices.len()), (6, 8), "{:?}", part.vertices);
        assert_eq!(part.faces.iter().filter(|f| f.cut).count(), 3);
        assert!((part.volume_mm3() - 1000.0).abs() < 1e-9);
        assert!(part.vertices.contains(&DVec3::ZERO));
        assert!(part.polygons().iter().all(|p| p.len() == 4));
    }
    explosion.check().unwrap();
}

#[test]
fn planes_of_the_worlds_axes_leave_whole_parts_of_a_turned_volume() {
    // Sections have sides along the axes of their own plane, where zeros of both signs come up.
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for n in 0..200 {
        let axis = DVec3::AXES[n % 3];
        let turn = DMat3::from_quat(DQuat::from_axis_angle(axis, rng.random_range(-3.2..3.2)));
        let matrix3 = turn * DMat3::from_diagonal(DVec3::new(1.0, 1.5, 2.0));
        let translation = DVec3::new(-30.0, -20.0, -35.0);
        let grid = Grid { dims: [70, 40, 33], world_from_index: DAffine3 { matrix3, translation } };
        let middle = grid.world_bounds().centre();
        let point = if n % 2 == 0 { middle } else { middle + unit(&mut rng) * 8.0 };
        let mut explosion = Explosion::whole(&grid);
        let whole = total(&explosion);
        let said = |of: &Explosion, normal: DVec3| {
            of.check().unwrap_or_else(|e| panic!("{n}: {normal} through {point}, turned about {axis}: {e}"));
            let sum = total(of) / whole;
            assert!((sum - 1.0).abs() < 1e-9, "{n}: {normal} through {point}, turned about {axis}: {sum} of the whole");
        };
        // Each alone, and one after the other.
        for normal in [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z] {
            let plane = Plane::through(point, normal).unwrap();
            let mut halved = Explosion::whole(&grid);
            halved.split_at_rest(PartId(1), &plane).unwrap().unwrap();
            said(&halved, normal);
            for id in explosion.parts.iter().map(|p| p.id).collect::<Vec<_>>() {
                explosion.split_at_rest(id, &plane).unwrap();
            }
            said(&explosion, normal);
        }
    }
}

#[test]
fn volumes_add_up_and_points_belong_to_one_part_over_random_splits() {
    for seed in 0..4 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let grid = oblique();
        let mut explosion = Explosion::whole(&grid);
        let whole = total(&explosion);
        let centre = explosion.parts[0].centre();
        let mut refused = 0;
        while explosion.parts.len() < 80 {
            let part = &explosion.parts[rng.random_range(0..explosion.parts.len())];
            // Planes through the part, sometimes through corners of it, sometimes nearly parallel to a face.
            let near = part.faces[rng.random_range(0..part.faces.len())].plane.normal;
            let normal = match rng.random_range(0..4) {
                0 => (near + unit(&mut rng) * 1e-9).normalize(),
                1 => (near + unit(&mut rng) * 1e-3).normalize(),
                _ => unit(&mut rng),
            };
            let corner = part.vertices[rng.random_range(0..part.vertices.len())];
            let point = if rng.random_range(0..3) == 0 {
                corner
            } else {
                corner.lerp(part.centre(), rng.random_range(0.0..1.5))
            };
            let plane = Plane::through(point, normal).unwrap();
            let (id, before) = (part.id, part.volume_mm3());
            match explosion.split_at_rest(id, &plane).unwrap() {
                None => refused += 1,
                Some(ids) => {
                    let after: f64 = ids.iter().map(|&id| explosion.part(id).unwrap().volume_mm3()).sum();
                    // Corners within 1e-10 of the diameter of the plane go to both halves.
                    assert!((after - before).abs() < 1e-8 * whole, "seed {seed}: {before} became {after}");
                }
            }
        }
        assert!(refused < 200, "{refused}");
        assert!((total(&explosion) / whole - 1.0).abs() < 1e-8);
        explosion.check().unwrap();
        for part in &explosion.parts {
            for (i, a) in part.vertices.iter().enumerate() {
                assert!(part.vertices[i + 1..].iter().all(|b| a != b), "seed {seed}: a corner twice");
                let on = part.faces.iter().filter(|f| f.plane.distance(*a).abs() < 1e-6).count();
                assert!(on >= 3, "seed {seed}: corner {a} lies on {on} faces");
            }
        }
        for _ in 0..500 {
            let p = grid
                .world_from_index
                .transform_point3(grid.dims_f64() * DVec3::new(rng.random(), rng.random(), rng.random()) - 0.5);
            let holders = explosion.parts.iter().filter(|q| q.faces.iter().all(|f| f.plane.distance(p) <= 0.0)).count();
            assert_eq!(holders, 1, "seed {seed}: {p} from {centre}");
        }
    }
}

#[test]
fn a_plane_that_misses_or_grazes_splits_nothing() {
    let mut explosion = Explosion::whole(&cube(20));
    let before = explosion.clone();
    for (point, normal) in [
        (DVec3::new(11.0, 0.0, 0.0), DVec3::X),
        (DVec3::new(10.0, 0.0, 0.0), DVec3::X),
        (DVec3::new(10.0 - 1e-7, 0.0, 0.0), DVec3::X),
        (DVec3::splat(10.0 - 1e-7), DVec3::ONE),
        (DVec3::NAN, DVec3::X),
    ] {
        let plane = Plane { normal: normal.normalize(), offset: normal.normalize().dot(point) };
        assert_eq!(explosion.split_at_rest(PartId(1), &plane).unwrap(), None);
        assert_eq!(explosion, before);
    }
    let plane = Plane { normal: DVec3::X, offset: 0.0 };
    assert!(matches!(explosion.cut_of(PartId(9), &Poses::default(), &plane), Err(ExplodeError::NoSuchPart { .. })));
}

#[test]
fn halves_get_new_ids_and_keep_colour_pin_importance_and_pose() {
    let mut explosion = Explosion::whole(&cube(20));
    let part = explosion.part_mut(PartId(1)).unwrap();
    part.name = "skull".into();
    part.colour = Some([0.1, 0.2, 0.3]);
    part.importance = 3.0;
    let pose = Pose { rotation: DQuat::from_rotation_z(0.3), translation: DVec3::new(5.0, -3.0, 1.0) };
    explosion.place(PartId(1), pose).unwrap();
    let plane = Plane { normal: DVec3::X, offset: 0.0 };
    let ids = explosion.split_at_rest(PartId(1), &plane).unwrap().unwrap();
    assert_eq!(ids, [PartId(2), PartId(3)]);
    assert!(explosion.part(PartId(1)).is_err());
    for (id, name) in ids.into_iter().zip(["skull a", "skull b"]) {
        let half = explosion.part(id).unwrap();
        assert_eq!(half.name, name);
        assert_eq!((half.colour, half.importance), (Some([0.1, 0.2, 0.3]), 3.0));
        assert_eq!(half.held.unwrap().translation, pose.translation);
    }
    assert!(explosion.part(ids[0]).unwrap().vertices.iter().all(|v| v.x <= 0.0));
    explosion.part_mut(ids[1]).unwrap().name = "Part 3".into();
    let more = explosion.split_at_rest(ids[1], &Plane { normal: DVec3::Y, offset: 0.0 }).unwrap().unwrap();
    assert_eq!(explosion.part(more[0]).unwrap().name, "Part 4");
    assert_eq!(explosion.next_id, 6);
}

#[test]
fn an_exploded_part_splits_where_the_plane_is_seen() {
    let mut explosion = Explosion::whole(&cube(20));
    let pose = Pose { rotation: DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2), translation: DVec3::X * 100.0 };
    let poses = Poses::found(&explosion.parts, &[pose]);
    // Seen at x = 104: at rest this is y = -4, since the part is turned by a right angle about z.
    let plane = Plane { normal: DVec3::X, offset: 104.0 };
    let cut = explosion.cut_of(PartId(1), &poses, &plane).unwrap();
    let ids = explosion.cut(&[cut]).unwrap()[0];
    let inner = explosion.part(ids[0]).unwrap();
    assert!(inner.vertices.iter().all(|&v| pose.apply(v).x < 104.0 + 1e-9));
    assert!(inner.vertices.iter().all(|v| v.y > -4.0 - 1e-9));
    assert!((inner.volume_mm3() - 14.0 * 400.0).abs() < 1e-6);
    let mut missed = Explosion::whole(&cube(20));
    let cut = missed.cut_of(PartId(1), &poses, &Plane { normal: DVec3::X, offset: 4.0 }).unwrap();
    assert!(missed.cut(&[cut]).unwrap().is_empty());
}

#[test]
fn a_wrong_explosion_is_named_by_its_field() {
    let good = octants(&cube(20));
    good.check().unwrap();
    let said = |change: &dyn Fn(&mut Explosion)| {
        let mut bad = good.clone();
        change(&mut bad);
        bad.check().unwrap_err().to_string()
    };
    assert!(said(&|e| e.degree = f64::NAN).starts_with("degree: NaN found"));
    assert!(said(&|e| e.degree = -0.1).starts_with("degree"));
    assert!(said(&|e| e.forces.softening = 0.0).starts_with("forces.softening"));
    assert!(said(&|e| e.parts.clear()).starts_with("parts: none"));
    assert!(said(&|e| e.parts[3].importance = 0.0).starts_with("parts[3].importance"));
    assert!(said(&|e| e.parts[2].id = PartId(99)).starts_with("parts[2].id"));
    assert!(said(&|e| e.parts[2].vertices[0].x = f64::INFINITY).starts_with("parts[2].vertices"));
    assert!(said(&|e| e.parts[2].vertices.truncate(2)).starts_with("parts[2].vertices"));
    assert!(said(&|e| e.parts[2].faces[1].plane.offset -= 1.0).starts_with("parts[2].faces"));
    assert!(said(&|e| e.parts[2].faces.truncate(5)).starts_with("parts[2].faces"));
    let bent = Pose { rotation: DQuat::from_xyzw(0.0, 0.0, 0.0, 3.0), translation: DVec3::ZERO };
    assert!(said(&|e| e.parts[0].held = Some(bent)).starts_with("parts[0].pose"));
    let poses = Poses::found(&good.parts, &[Pose::IDENTITY, bent]);
    assert!(poses.check(&good).unwrap_err().to_string().starts_with("parts[1].pose"));
    Poses::default().check(&good).unwrap();
    assert!(said(&|e| e.parts[0].colour = Some([f32::NAN; 3])).starts_with("parts[0].colour"));
}

#[test]
fn every_constant_of_the_forces_keeps_to_its_range() {
    type Constant = fn(&mut Forces) -> &mut f64;
    let constants: [(&str, Constant, [f64; 2]); 7] = [
        ("delta_explosion", |f| &mut f.delta_explosion, [0.0, 1.0]),
        ("delta_viewing", |f| &mut f.delta_viewing, [0.0, 1.0]),
        ("delta_spacing", |f| &mut f.delta_spacing, [0.0, 1.0]),
        ("return_constant", |f| &mut f.return_constant, [0.01, 10.0]),
        ("return_length", |f| &mut f.return_length, [0.01, 10.0]),
        ("explosion_length", |f| &mut f.explosion_length, [0.01, 10.0]),
        ("softening", |f| &mut f.softening, [0.01, 1.0]),
    ];
    for (name, constant, [lo, hi]) in constants {
        let check = |value: f64| {
            let mut forces = Forces::default();
            *constant(&mut forces) = value;
            forces.check().map_err(|e| e.to_string())
        };
        assert_eq!((check(lo), check(hi)), (Ok(()), Ok(())), "{name}");
        for value in [lo - 1e-9, hi + 1e-9, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let error = check(value).unwrap_err();
            assert!(error.starts_with(&format!("forces.{name}: {value}")), "{error}");
        }
    }
}
