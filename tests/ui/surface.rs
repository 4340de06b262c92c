//! The surface that a picture shows: strokes, cuts and borders lie where equations say.

use super::scene;
use burin::explode::{Explosion, Poses};
use burin::gpu::ObjectId;
use burin::interact::surface::{Surface, near_way};
use burin::math::{Camera, DVec2, DVec3, Plane, Pose, Projection};
use burin::volume::{Grid, VolumeId};

const SIZE: [u32; 2] = [120, 90];

/// An orthographic picture of a ball of 20 mm about `centre`, as one body.
fn ball(camera: &Camera, centre: DVec3, object: u32) -> Surface {
    let mut depth = Vec::new();
    for y in 0..SIZE[1] {
        for x in 0..SIZE[0] {
            let ray = camera.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5), SIZE);
            let b = ray.dir.dot(ray.origin - centre);
            let c = (ray.origin - centre).length_squared() - 400.0;
            let d = b * b - c;
            depth.push(if d > 0.0 { (-b - d.sqrt()) as f32 } else { f32::INFINITY });
        }
    }
    let something = ObjectId::new(VolumeId::FIRST, object - 1, false, 0);
    let objects: Vec<_> = depth.iter().map(|d| if d.is_finite() { something } else { ObjectId::NOTHING }).collect();
    Surface::new(camera, SIZE, &depth, &objects)
}

fn set() -> (Camera, DVec3, Explosion) {
    let (grid, scene): (Grid, _) = scene();
    let centre = grid.world_bounds().centre();
    let projection = Projection::Orthographic { height_mm: 60.0 };
    let eye = centre + DVec3::new(10.0, 80.0, 5.0);
    (Camera { eye, target: centre, up: DVec3::Z, projection }, centre, (*scene.explosion).clone())
}

/// World point of the ball under a share of the picture.
fn on_ball(camera: &Camera, centre: DVec3, share: DVec2) -> DVec3 {
    let ray = camera.ray(share * DVec2::new(f64::from(SIZE[0]), f64::from(SIZE[1])), SIZE);
    let b = ray.dir.dot(ray.origin - centre);
    let d = b * b - ((ray.origin - centre).length_squared() - 400.0);
    ray.at(-b - d.max(0.0).sqrt())
}

#[test]
fn every_point_of_the_grid_lies_on_what_is_seen() {
    let (camera, centre, _) = set();
    let surface = ball(&camera, centre, 1);
    let points: Vec<_> = surface.seen().iter().flatten().collect();
    // The disc's share of the picture: π·20² of 60 × 80 mm.
    let share = points.len() as f64 / surface.seen().len() as f64;
    assert!((share - std::f64::consts::PI * 400.0 / 4800.0).abs() < 0.01, "{share}");
    assert!(points.iter().all(|s| (s.world.distance(centre) - 20.0).abs() < 1e-3 && s.body == 0));
}

#[test]
fn a_cut_is_traced_where_its_plane_meets_the_surface() {
    let (camera, centre, mut explosion) = set();
    let surface = ball(&camera, centre, 1);
    let plane = Plane::through(centre + DVec3::new(0.0, 0.0, 6.0), DVec3::new(0.3, 0.2, 1.0)).unwrap();
    let whole = explosion.parts[0].clone();
    let pieces = surface.trace((&explosion.parts, &Poses::default()), &whole, &plane, 0.0);
    assert!(pieces.len() > 40, "{}", pieces.len());
    for end in pieces.iter().flatten() {
        let off = plane.distance(on_ball(&camera, centre, *end)).abs();
        assert!(off < 0.15, "{off} mm off the plane");
    }
    // The same plane as the border of two parts.
    explosion.split_at_rest(whole.id, &plane).unwrap().unwrap();
    let seams = surface.seams(&explosion.parts, &Poses::default());
    assert!(seams.len() > 40);
    for end in seams.iter().flatten() {
        assert!(plane.distance(on_ball(&camera, centre, *end)).abs() < 0.15);
    }
    // Parts that have moved are seen apart.
    let moved = Poses::found(&explosion.parts, &[Pose { translation: DVec3::X, ..Pose::IDENTITY }]);
    assert_eq!(surface.seams(&explosion.parts, &moved), [] as [[DVec2; 2]; 0]);
    assert_eq!(surface.seams(&[whole], &Poses::default()), [] as [[DVec2; 2]; 0]);
}

/// Share of the picture that boxes cover.
fn covered(boxes: &[[DVec2; 2]]) -> f64 {
    boxes.iter().map(|[a, b]| (b.x - a.x) * (b.y - a.y)).sum()
}

#[test]
fn the_near_side_of_a_depth_cut_is_what_comes_off() {
    let (camera, centre, explosion) = set();
    let surface = ball(&camera, centre, 1);
    // 12 mm before the ball's middle: what is seen before it is a disc of √(20² − 12²) = 16 mm.
    let plane = Plane::through(centre - camera.forward() * 12.0, camera.forward()).unwrap();
    let part = explosion.parts[0].clone();
    let rest = (&explosion.parts[..], &Poses::default());
    let near = covered(&surface.side(rest, &part, Some(&plane)));
    let all = covered(&surface.side(rest, &part, None));
    let disc = |radius: f64| std::f64::consts::PI * radius * radius / 4800.0;
    assert!((near - disc(16.0)).abs() < 0.01, "{near} for {}", disc(16.0));
    assert!((all - disc(20.0)).abs() < 0.01, "{all} for {}", disc(20.0));
    // A part that has moved is its own body, and its planes are at rest.
    let away = DVec3::new(4.0, 0.0, 3.0);
    let moved = Poses::found(&explosion.parts, &[Pose { translation: away, ..Pose::IDENTITY }]);
    let moved = (&explosion.parts[..], &moved);
    let there = ball(&camera, centre + away, part.id.0 + 1);
    let near = covered(&there.side(moved, &part, Some(&plane)));
    assert!((near - disc(16.0)).abs() < 0.01, "{near}");
    let other = ball(&camera, centre, part.id.0 + 7);
    assert_eq!(covered(&other.side(moved, &part, None)), 0.0, "another body is not the part");
}

#[test]
fn boxes_cover_the_wanted_points_once() {
    let (camera, centre, _) = set();
    let surface = ball(&camera, centre, 1);
    let count = surface.seen().len();
    for every in [2, 3, 7] {
        let boxes = surface.boxes(|i| i % every == 0);
        let wanted = (0..count).filter(|i| i % every == 0).count() as f64 / count as f64;
        assert!((covered(&boxes) - wanted).abs() < 1e-9, "{every}");
    }
    assert!((covered(&surface.boxes(|_| true)) - 1.0).abs() < 1e-9, "the whole picture");
}

#[test]
fn near_a_way_is_within_the_radius_of_its_nearest_point() {
    let (a, b) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(5.0, 2.0, 3.0));
    for (at, distance) in [
        (DVec3::new(3.0, 4.0, 3.0), 2.0),
        (DVec3::new(-2.0, 2.0, 3.0), 3.0),
        (DVec3::new(5.0, 2.0, 7.5), 4.5),
        (DVec3::new(8.0, 6.0, 3.0), 5.0),
    ] {
        assert!(near_way(at, a, b, distance + 1e-9) && !near_way(at, a, b, distance - 1e-9), "{at}");
    }
    assert!(near_way(a, a, a, 0.0) && !near_way(b, a, a, 3.9));
}

#[test]
fn at_rest_each_part_is_seen_on_its_own_side_of_the_cut() {
    let (camera, centre, mut explosion) = set();
    let surface = ball(&camera, centre, 1);
    let plane = Plane::through(centre, DVec3::X).unwrap();
    explosion.split_at_rest(explosion.parts[0].id, &plane).unwrap().unwrap();
    let whole = std::f64::consts::PI * 400.0 / 4800.0;
    let sides: Vec<f64> = explosion
        .parts
        .iter()
        .map(|part| covered(&surface.side((&explosion.parts, &Poses::default()), part, None)))
        .collect();
    assert!((sides.iter().sum::<f64>() - whole).abs() < 0.01, "{sides:?} of {whole}");
    // Seen a little from one side, each shows about a half.
    assert!(sides.iter().all(|side| (0.35..0.65).contains(&(side / whole))), "{sides:?} of {whole}");
}
