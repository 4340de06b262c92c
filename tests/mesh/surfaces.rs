//! Closed surfaces of selections and labels against the fields themselves: where they lie, what they enclose, how they are joined.

use super::{corners, euler, is_manifold, winding};
use crate::common::volumes::{each, painted};
use burin::math::{DAffine3, DMat3, DVec3};
use burin::mesh::{TriangleMesh, label_surface, selection_surface};
use burin::volume::{Field, FieldKind, Grid};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn grid(dims: [u32; 3]) -> Grid {
    Grid::aligned(dims, DVec3::ONE, DVec3::ZERO)
}

fn at(v: [u32; 3], dims: [u32; 3]) -> usize {
    v[0] as usize + dims[0] as usize * (v[1] as usize + dims[1] as usize * v[2] as usize)
}

fn place(v: [u32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

fn field(kind: FieldKind, dims: [u32; 3], texels: &[u16]) -> Field {
    painted(kind, &grid(dims), |v| {
        let inside = (0..3).all(|a| v[a] < dims[a]);
        let [a, b] = if inside { texels[at(v, dims)].to_le_bytes() } else { [0; 2] };
        [a, b, 0, 0]
    })
}

fn selected(dims: [u32; 3], texels: &[u16]) -> TriangleMesh {
    let field = field(FieldKind::Selection, dims, texels);
    selection_surface(&field, &DAffine3::IDENTITY, &|_| true).unwrap().unwrap()
}

fn labelled(dims: [u32; 3], is_in: impl Fn([u32; 3]) -> bool) -> TriangleMesh {
    // Another label all about it.
    let texels = each(dims, |v| if is_in(v) { 3 } else { 7 * (v[0] as u16 % 2) });
    let field = field(FieldKind::Labels, dims, &texels);
    label_surface(&field, 3, &DAffine3::IDENTITY, &|_| true).unwrap().unwrap()
}

/// The selection between voxels, 0 beyond them.
fn trilinear(dims: [u32; 3], texels: &[u16], p: DVec3) -> f64 {
    let base = p.floor();
    let share = p - base;
    let mut sum = 0.0;
    for c in 0..8_u32 {
        let far = DVec3::new(f64::from(c & 1), f64::from(c >> 1 & 1), f64::from(c >> 2));
        let v = (base + far).to_array().map(|x| x as i64);
        let weight = (DVec3::ONE - far - share).abs().element_product();
        if (0..3).all(|a| (0..i64::from(dims[a])).contains(&v[a])) {
            sum += weight * f64::from(texels[at(v.map(|x| x as u32), dims)]) / 255.0;
        }
    }
    sum
}

/// Holds a selection's mesh to its field: closed, on the level set, about all that is selected and nothing else.
fn hold(dims: [u32; 3], texels: &[u16], what: &str) {
    let mesh = selected(dims, texels);
    assert!(mesh.is_closed() && is_manifold(&mesh), "{what}");
    let corners = corners(&mesh);
    for corner in &corners {
        let value = trilinear(dims, texels, *corner);
        assert!((value - 0.5).abs() < 2e-5, "{what}: {value} at {corner}");
    }
    for v in each(dims, |v| v) {
        let inside = if texels[at(v, dims)] > 127 { 1.0 } else { 0.0 };
        let found = winding(&mesh, &corners, place(v));
        assert!((found - inside).abs() < 1e-3, "{what}: {found} about {v:?}");
    }
}

/// Places for 256 blocks of eight voxels with two empty voxels between them.
const BLOCKS: [u32; 3] = [32, 32, 16];

/// The block that a voxel of [`BLOCKS`] is of, and which of its eight; `None` between them.
fn of_block(v: [u32; 3]) -> Option<(u32, u32)> {
    let within = v.map(|x| (x % 4).wrapping_sub(1));
    let [x, y, z] = v.map(|x| x / 4);
    within.iter().all(|x| *x < 2).then(|| (x + 8 * (y + 8 * z), within[0] + 2 * within[1] + 4 * within[2]))
}

/// What of a mesh is of each block.
fn by_block(mesh: &TriangleMesh) -> Vec<TriangleMesh> {
    let mut of = vec![Vec::new(); 256];
    for triangle in mesh.triangles() {
        let [x, y, z] = mesh.corners()[triangle[0] as usize].map(|x| ((x + 0.5) / 4.0) as usize);
        of[x + 8 * (y + 8 * z)].push(*triangle);
    }
    of.into_iter().map(|triangles| TriangleMesh::new(mesh.corners().to_vec(), triangles).unwrap()).collect()
}

#[test]
fn all_ways_in_which_eight_voxels_can_be_selected_give_closed_surfaces_on_the_level_set() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for round in 0..4 {
        // Magnitudes decide what is joined; equal ones are the hardest.
        let texels = each(BLOCKS, |v| {
            let Some((case, c)) = of_block(v) else { return 0 };
            match (case >> c & 1, round) {
                (0, 0) => 0,
                (0, _) => rng.random_range(0..128),
                (_, 0) => 255,
                (_, 1) => [128, 255][rng.random_range(0..2)],
                _ => rng.random_range(128..256),
            }
        });
        let mesh = selected(BLOCKS, &texels);
        assert!(mesh.is_closed() && is_manifold(&mesh), "round {round}");
        let corners = corners(&mesh);
        for corner in &corners {
            let value = trilinear(BLOCKS, &texels, *corner);
            assert!((value - 0.5).abs() < 2e-5, "round {round}: {value} at {corner}");
        }
        let blocks = by_block(&mesh);
        for v in each(BLOCKS, |v| v) {
            let Some((case, _)) = of_block(v) else { continue };
            let inside = if texels[at(v, BLOCKS)] > 127 { 1.0 } else { 0.0 };
            let found = winding(&blocks[case as usize], &corners, place(v));
            assert!((found - inside).abs() < 1e-3, "round {round}, case {case}: {found} about {v:?}");
        }
    }
}

#[test]
fn what_alternates_is_joined_where_the_field_between_is_inside() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let mut met = [0; 2];
    for _ in 0..200 {
        let [low, high] =
            [0..128_u16, 128..256].map(|range| move |rng: &mut ChaCha8Rng| rng.random_range(range.clone()));
        let texels = [high(&mut rng), low(&mut rng), low(&mut rng), high(&mut rng)];
        let [a, b, c, d] = texels.map(|t| f64::from(t) / 255.0);
        // Where the mixture of the four has its saddle.
        let under = a + d - b - c;
        let (saddle, value) = (DVec3::new((a - c) / under, (a - b) / under, 0.0), (a * d - b * c) / under);
        if (value - 0.5).abs() < 0.01 {
            continue;
        }
        let mesh = selected([2, 2, 1], &texels);
        let found = winding(&mesh, &corners(&mesh), saddle);
        let inside = value > 0.5;
        assert!((found - f64::from(u8::from(inside))).abs() < 1e-3, "{texels:?}: {found}, {value} at {saddle}");
        met[usize::from(inside)] += 1;
    }
    assert!(met.iter().all(|n| *n > 20), "{met:?}");
}

#[test]
fn selections_of_noise_have_closed_surfaces_at_the_border_too() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    for dims in [[7, 6, 5], [1, 8, 6], [9, 1, 1], [1, 1, 1]] {
        for round in 0..4 {
            let texels = each(dims, |_| match round {
                0 => rng.random_range(0..256),
                1 => [0, 255][rng.random_range(0..2)],
                2 => [127, 128][rng.random_range(0..2)],
                _ => rng.random_range(100..256),
            });
            hold(dims, &texels, &format!("{dims:?} round {round}"));
        }
    }
}

#[test]
fn a_soft_ball_across_bricks_is_as_large_as_it_is() {
    let dims = [70, 41, 38];
    let (centre, radius) = (DVec3::new(34.3, 20.7, 18.2), 15.4);
    let texels = each(dims, |v| {
        // A ramp of four voxels about the surface.
        ((0.5 + (radius - place(v).distance(centre)) / 4.0).clamp(0.0, 1.0) * 255.0).round() as u16
    });
    let mesh = selected(dims, &texels);
    assert!(mesh.is_closed());
    assert_eq!(euler(&mesh), 2);
    for corner in corners(&mesh) {
        assert!((corner.distance(centre) - radius).abs() < 0.02, "{corner}");
    }
    let volume = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    assert!((mesh.volume_mm3() / volume - 1.0).abs() < 4e-3, "{} {volume}: inscribed", mesh.volume_mm3());
    // Nothing is selected by a half.
    assert!(selected([4, 4, 4], &[127; 64]).triangles().is_empty());
    let field = field(FieldKind::Selection, dims, &texels);
    assert_eq!(selection_surface(&field, &DAffine3::IDENTITY, &|_| false).unwrap(), None);
}

#[test]
fn meshes_lie_where_an_oblique_or_mirrored_grid_has_their_voxels() {
    let dims = [12, 11, 10];
    let turned = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    for scale in [DVec3::new(0.8, 1.1, 1.7), DVec3::new(-0.8, 1.1, 1.7)] {
        let world =
            DAffine3 { matrix3: turned * DMat3::from_diagonal(scale), translation: DVec3::new(900.0, -55.0, 7.0) };
        let texels = each(dims, |v| if place(v).distance(DVec3::splat(5.2)) < 3.6 { 255 } else { 0 });
        let selection = field(FieldKind::Selection, dims, &texels);
        let plain = selection_surface(&selection, &DAffine3::IDENTITY, &|_| true).unwrap().unwrap();
        let mesh = selection_surface(&selection, &world, &|_| true).unwrap().unwrap();
        let voxel = scale.element_product().abs();
        assert!(mesh.is_closed());
        assert!((mesh.volume_mm3() / (plain.volume_mm3() * voxel) - 1.0).abs() < 1e-4, "outward");
        for (own, index) in corners(&mesh).iter().zip(corners(&plain)) {
            assert!(own.distance(world.transform_point3(index)) < 1e-3);
        }
        let labels = field(FieldKind::Labels, dims, &texels.iter().map(|t| t / 255).collect::<Vec<_>>());
        let mesh = label_surface(&labels, 1, &world, &|_| true).unwrap().unwrap();
        let count = texels.iter().filter(|t| **t == 255).count() as f64;
        assert!((mesh.volume_mm3() / (count * voxel) - 1.0).abs() < 0.01);
    }
}

/// The distance from a place to the nearest face between a voxel that is in and one that is not, of those within a voxel.
fn to_faces(dims: [u32; 3], is_in: &dyn Fn([u32; 3]) -> bool, p: DVec3) -> f64 {
    let holds = |v: [i64; 3]| (0..3).all(|a| (0..i64::from(dims[a])).contains(&v[a])) && is_in(v.map(|x| x as u32));
    let near = p.round().to_array().map(|x| x as i64);
    let mut least = f64::INFINITY;
    for n in 0..27_i64 {
        let v = [near[0] + n % 3 - 1, near[1] + n / 3 % 3 - 1, near[2] + n / 9 - 1];
        for axis in 0..3 {
            let mut next = v;
            next[axis] += 1;
            if holds(v) == holds(next) {
                continue;
            }
            // The square between them.
            let middle = DVec3::from_array(v.map(|x| x as f64)) + DVec3::AXES[axis] * 0.5;
            let mut on = (p - middle).clamp(DVec3::splat(-0.5), DVec3::splat(0.5));
            on[axis] = 0.0;
            least = least.min(p.distance(middle + on));
        }
    }
    least
}

/// Holds a label's mesh to its voxels: closed, within half a voxel of their faces, as large as they are.
fn hold_label(dims: [u32; 3], is_in: &dyn Fn([u32; 3]) -> bool, what: &str) -> TriangleMesh {
    let mesh = labelled(dims, is_in);
    assert!(mesh.is_closed() && is_manifold(&mesh), "{what}");
    for corner in corners(&mesh) {
        let far = to_faces(dims, is_in, corner);
        assert!(far <= 0.5, "{what}: {far} at {corner}");
    }
    let count = each(dims, |v| v).into_iter().filter(|v| is_in(*v)).count() as f64;
    let volume = mesh.volume_mm3();
    assert!((volume / count - 1.0).abs() < 0.01, "{what}: {volume} of {count}");
    mesh
}

#[test]
fn a_labelled_ball_is_smooth() {
    let dims = [33, 33, 33];
    for centre in [DVec3::splat(16.0), DVec3::splat(16.5), DVec3::new(16.2, 15.7, 16.4), DVec3::new(15.6, 16.5, 16.0)] {
        let is_in = |v: [u32; 3]| place(v).distance(centre) <= 12.0;
        let mesh = hold_label(dims, &is_in, "ball");
        assert_eq!(euler(&mesh), 2);
        let corners = corners(&mesh);
        let mut normals = vec![DVec3::ZERO; corners.len()];
        let (mut by_area, mut area, mut plain) = (0.0, 0.0, 0.0);
        for triangle in mesh.triangles() {
            let [a, b, c] = triangle.map(|i| corners[i as usize]);
            let normal = (b - a).cross(c - a);
            triangle.iter().for_each(|i| normals[*i as usize] += normal);
            let off = normal.angle_between((a + b + c) / 3.0 - centre).to_degrees();
            by_area += off * off * normal.length();
            area += normal.length();
            plain += off * off;
        }
        let of_corner =
            |(normal, corner): (&DVec3, &DVec3)| normal.angle_between(*corner - centre).to_degrees().powi(2);
        let smooth: f64 = normals.iter().zip(&corners).map(of_corner).sum::<f64>() / corners.len() as f64;
        let found = [by_area / area, plain / mesh.triangles().len() as f64, smooth].map(f64::sqrt);
        assert!(found.iter().all(|off| *off < 3.0), "{found:?} degrees by area, by triangle, by corner at {centre}");
    }
}

#[test]
fn labels_of_any_shape_are_enclosed_as_they_are() {
    let one = |v: [u32; 3]| v == [3, 2, 4];
    let mesh = hold_label([7, 6, 8], &one, "one voxel");
    assert_eq!(euler(&mesh), 2);
    hold_label([7, 6, 8], &|v| v[2] == 3, "a plate to the border");
    hold_label([12, 12, 12], &|v| v[2] == 6 && (2..10).contains(&v[0]) && (3..9).contains(&v[1]), "a plate");
    hold_label([12, 5, 5], &|v| v[1] == 2 && v[2] == 2 && v[0] > 1, "a rod that ends at the border");
    let whole = hold_label([9, 6, 5], &|_| true, "the whole volume");
    assert_eq!(euler(&whole), 2);
    let torus = |v: [u32; 3]| {
        let p = place(v) - DVec3::new(13.0, 13.0, 6.0);
        (p.truncate().length() - 8.0).hypot(p.z) < 3.3
    };
    assert_eq!(euler(&hold_label([27, 27, 13], &torus, "a ring")), 0);
    let shell = |v: [u32; 3]| (4.0..8.0).contains(&place(v).distance(DVec3::splat(9.0)));
    assert_eq!(euler(&hold_label([19, 19, 19], &shell, "a hollow ball")), 4);
    let two = |v: [u32; 3]| {
        place(v).distance(DVec3::new(10.0, 10.0, 10.0)) < 8.0 || place(v).distance(DVec3::splat(24.0)) < 1.5
    };
    assert_eq!(euler(&hold_label([34, 28, 28], &two, "a large one and a small one")), 4);
    // Across bricks, to all of the volume's corners.
    let slab = |v: [u32; 3]| (v[0] + 2 * v[1] + v[2]) % 71 < 40;
    hold_label([40, 35, 34], &slab, "slanted slabs");
}

#[test]
fn voxels_that_meet_at_an_edge_or_a_corner_alone_do_not_touch() {
    for (other, what) in [([4, 4, 3], "edge"), ([4, 4, 4], "corner")] {
        let is_in = |v: [u32; 3]| v == [3, 3, 3] || v == other;
        assert_eq!(euler(&hold_label([8, 8, 8], &is_in, what)), 4, "{what}: two pieces");
    }
    // A ring about an edge at which it touches itself, and all ways in which eight voxels can be labelled.
    let ring = |v: [u32; 3]| {
        let around = [[0, 0, 0], [0, 0, 1], [0, 0, 2], [1, 0, 2], [1, 1, 2], [1, 1, 1], [1, 1, 0]];
        around.contains(&std::array::from_fn(|a| v[a].wrapping_sub(2)))
    };
    hold_label([7, 7, 7], &ring, "ring");
    let is_in = |v: [u32; 3]| of_block(v).is_some_and(|(case, c)| case >> c & 1 == 1);
    let mesh = hold_label(BLOCKS, &is_in, "all cases");
    for (case, block) in by_block(&mesh).iter().enumerate().skip(1) {
        let (volume, count) = (block.volume_mm3(), f64::from(case.count_ones()));
        assert!((volume / count - 1.0).abs() < 0.01, "case {case}: {volume} of {count}");
    }
}

#[test]
fn noise_is_closed_and_stays_at_its_faces() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    for share in [0.1, 0.5, 0.9] {
        let dims = [13, 12, 11];
        let set = each(dims, |_| rng.random_range(0.0..1.0) < share);
        let is_in = |v: [u32; 3]| set[at(v, dims)];
        let mesh = labelled(dims, is_in);
        assert!(mesh.is_closed() && is_manifold(&mesh));
        for corner in corners(&mesh) {
            assert!(to_faces(dims, &is_in, corner) <= 0.5);
        }
        let count = set.iter().filter(|s| **s).count() as f64;
        assert!((mesh.volume_mm3() / count - 1.0).abs() < 0.01, "{share}: {} of {count}", mesh.volume_mm3());
    }
}
