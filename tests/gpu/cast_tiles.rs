//! Solids, order of sight and tiles against brute force over rays.

use burin::gpu::cast::order::{Order, RayOrigin};
use burin::gpu::cast::solid::Polyhedron;
use burin::gpu::cast::tiles::{Tiles, Window};
use burin::gpu::device::constants::{MERGE_MARK, TILE};
use burin::math::{Aabb, Camera, DQuat, DVec2, DVec3, Plane, Pose, Projection, Ray};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

struct Piece {
    planes: Vec<Plane>,
    solid: Polyhedron,
}

/// A box of 40×30×20 mm in 3×3×3 blocks, pushed out from its middle by `spread` and turned a little.
fn blocks(spread: f64, turn: f64) -> Vec<Piece> {
    let mut pieces = Vec::new();
    let size = DVec3::new(40.0, 30.0, 20.0);
    for i in 0..27 {
        let at = DVec3::new(f64::from(i % 3), f64::from(i / 3 % 3), f64::from(i / 9));
        let bounds = Aabb { min: at / 3.0 * size, max: (at + 1.0) / 3.0 * size };
        let shift = (bounds.centre() - size * 0.5) * spread;
        let pose = Pose::about(bounds.centre(), DQuat::from_rotation_z(turn * (at.x - 1.0)), shift);
        let solid = Polyhedron::hexahedron(&bounds.corners()).posed(&pose);
        pieces.push(Piece { planes: bounds.planes().iter().map(|p| pose.apply_plane(p)).collect(), solid });
    }
    pieces
}

fn cameras() -> [Camera; 2] {
    let perspective = Camera {
        eye: DVec3::new(110.0, -70.0, 45.0),
        target: DVec3::new(20.0, 15.0, 10.0),
        up: DVec3::Z,
        projection: Projection::Perspective { fov_y_deg: 35.0 },
    };
    [perspective, Camera { projection: Projection::Orthographic { height_mm: 70.0 }, ..perspective }]
}

fn interval(planes: &[Plane], ray: &Ray) -> Option<(f64, f64)> {
    ray.clip(planes, 0.0, f64::INFINITY).filter(|(a, b)| b - a > 1e-6)
}

fn check(pieces: &[Piece], camera: &Camera, window: &Window) -> Tiles {
    let solids: Vec<Polyhedron> = pieces.iter().map(|p| p.solid.clone()).collect();
    let tiles = Tiles::of(&solids, &Order::of(&solids, RayOrigin::of(camera)), camera, window);
    for y in 0..window.size[1] {
        for x in 0..window.size[0] {
            let px = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) + window.origin;
            let ray = camera.ray(px, window.picture);
            let [first, count] = tiles.heads[(x / TILE + y / TILE * tiles.dims[0]) as usize];
            let merge = count & MERGE_MARK != 0;
            let list = &tiles.lists[first as usize..(first + (count & !MERGE_MARK)) as usize];
            let met: Vec<_> = list.iter().filter_map(|&b| interval(&pieces[b as usize].planes, &ray)).collect();
            let all = pieces.iter().filter(|p| interval(&p.planes, &ray).is_some()).count();
            assert_eq!(met.len(), all, "pixel {x} {y}: a body of this ray is not in its tile's list");
            if !merge {
                assert!(
                    met.windows(2).all(|w| w[0].1 <= w[1].0 + 1e-6),
                    "pixel {x} {y}: {met:?} not in order of sight"
                );
            }
        }
    }
    check_areas(&tiles, window.size);
    tiles
}

/// Every pixel of a tile with bodies is in one area of its kind, and none else is in any.
fn check_areas(tiles: &Tiles, [width, height]: [u32; 2]) {
    for wanted in [Some(false), Some(true), None] {
        let kind = |merges: bool| wanted.is_none_or(|w| w == merges);
        let areas = tiles.areas([width, height], kind);
        for y in 0..height {
            for x in 0..width {
                let within = |a: &&[u32; 4]| a[0] <= x && x < a[2] && a[1] <= y && y < a[3];
                let [_, count] = tiles.heads[(x / TILE + y / TILE * tiles.dims[0]) as usize];
                let due = count & !MERGE_MARK > 0 && kind(count & MERGE_MARK != 0);
                assert_eq!(areas.iter().filter(within).count(), usize::from(due), "pixel {x} {y}, {wanted:?}");
            }
        }
        assert!(areas.iter().all(|a| a[2] <= width && a[3] <= height));
    }
}

#[test]
fn a_tile_lists_every_body_of_its_rays_in_order_of_sight() {
    for camera in cameras() {
        for (spread, turn) in [(0.0, 0.0), (0.35, 0.1), (1.0, 0.3)] {
            let tiles = check(&blocks(spread, turn), &camera, &Window::whole([101, 67]));
            assert_eq!(tiles.longest_merged, 0, "blocks apart from one another have an order");
            assert!(tiles.longest_ordered >= 3);
        }
    }
}

#[test]
fn a_window_within_a_picture_has_the_same_rays() {
    let window = Window { picture: [200, 150], origin: DVec2::new(61.5, 40.25), size: [33, 21], only: None };
    check(&blocks(0.5, 0.2), &cameras()[0], &window);
}

#[test]
fn overlapping_bodies_share_a_marked_tile() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for camera in cameras() {
        let pieces: Vec<Piece> = (0..5)
            .map(|_| {
                let mut any = |s: f64| DVec3::from_array(std::array::from_fn(|_| rng.random_range(-s..s)));
                let half = any(8.0).abs() + 4.0;
                let pose = Pose {
                    rotation: DQuat::from_scaled_axis(any(2.0)),
                    translation: DVec3::new(20.0, 15.0, 10.0) + any(8.0),
                };
                let bounds = Aabb { min: -half, max: half };
                Piece {
                    planes: bounds.planes().iter().map(|p| pose.apply_plane(p)).collect(),
                    solid: Polyhedron::hexahedron(&bounds.corners()).posed(&pose),
                }
            })
            .collect();
        let tiles = check(&pieces, &camera, &Window::whole([64, 64]));
        assert!(tiles.longest_merged >= 2);
    }
}

#[test]
fn an_eye_inside_a_body_sees_it_in_every_tile() {
    let pieces = blocks(0.0, 0.0);
    let camera = Camera { eye: DVec3::new(21.0, 14.0, 9.0), ..cameras()[0] };
    check(&pieces, &camera, &Window::whole([40, 40]));
}

#[test]
fn cuts_divide_a_volume_without_loss() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let corners = Aabb { min: DVec3::ZERO, max: DVec3::new(40.0, 30.0, 20.0) }.corners();
    let sheared = corners.map(|c| c + DVec3::new(0.3 * c.y, 0.0, 0.1 * c.x));
    let whole = Polyhedron::hexahedron(&sheared);
    assert!((whole.volume() - 24_000.0).abs() < 1e-6);
    let mut pieces = vec![whole];
    for _ in 0..6 {
        let any = |rng: &mut ChaCha8Rng, s: f64| DVec3::from_array(std::array::from_fn(|_| rng.random_range(-s..s)));
        let through = DVec3::new(24.0, 15.0, 12.0) + any(&mut rng, 6.0);
        let plane = Plane::through(through, any(&mut rng, 1.0)).unwrap();
        pieces = pieces.into_iter().flat_map(|p| [p.clone().cut(&plane), p.cut(&plane.flipped())]).flatten().collect();
    }
    assert!(pieces.len() > 20);
    assert!((pieces.iter().map(Polyhedron::volume).sum::<f64>() - 24_000.0).abs() < 1e-6);
    for (i, a) in pieces.iter().enumerate() {
        assert!(pieces[i + 1..].iter().all(|b| a.is_apart_from(b)));
    }
    // Cuts along its own faces, and past it, leave a solid as it is or nothing.
    let face = Plane { normal: DVec3::X, offset: 40.0 };
    let block = Polyhedron::hexahedron(&corners);
    assert!((block.clone().cut(&face).unwrap().volume() - 24_000.0).abs() < 1e-6);
    assert!(block.cut(&face.flipped()).is_none());
}

#[test]
fn cuts_through_corners_and_edges_close_what_they_open() {
    let cube = Polyhedron::hexahedron(&Aabb { min: DVec3::ZERO, max: DVec3::splat(2.0) }.corners());
    let halves = |solid: &Polyhedron, plane: &Plane| [solid.clone().cut(plane), solid.clone().cut(&plane.flipped())];
    for (normal, through, volume) in [
        // Two edges, three corners, one edge, a corner and middles of edges.
        (DVec3::new(1.0, -1.0, 0.0), DVec3::ZERO, 4.0),
        (DVec3::new(1.0, 1.0, 1.0), DVec3::X * 2.0, 4.0 / 3.0),
        (DVec3::new(1.0, -2.0, 0.0), DVec3::ZERO, 6.0),
        (DVec3::new(1.0, 1.0, -2.0), DVec3::ZERO, 4.0),
    ] {
        let [inner, outer] = halves(&cube, &Plane::through(through, normal).unwrap()).map(Option::unwrap);
        assert!((inner.volume() - volume).abs() < 1e-9, "{normal}: {}", inner.volume());
        assert!((outer.volume() - 8.0 + volume).abs() < 1e-9, "{normal}: {}", outer.volume());
        // The cut itself is the only face that has the other outside.
        assert!(inner.face_before(&outer).is_some() && outer.face_before(&inner).is_some(), "{normal}");
    }
    // Pieces whose corners all lie on one lattice, so that most cuts go through some.
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let mut pieces = vec![cube];
    while pieces.len() < 60 {
        let mut whole = || f64::from(rng.random_range(-1..=1));
        let normal = DVec3::new(whole(), whole(), whole());
        let through = DVec3::splat(1.0) + DVec3::new(whole(), whole(), whole());
        let Some(plane) = Plane::through(through, normal) else { continue };
        pieces = pieces.iter().flat_map(|p| halves(p, &plane)).flatten().collect();
    }
    assert!((pieces.iter().map(Polyhedron::volume).sum::<f64>() - 8.0).abs() < 1e-9);
    for (i, a) in pieces.iter().enumerate() {
        assert!(a.volume() > 1e-6 && pieces[i + 1..].iter().all(|b| a.is_apart_from(b)));
    }
}
