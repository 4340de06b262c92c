//! Explosion points against a walk that reads every voxel of every node.

use super::unit;
use burin::explode::*;
use burin::math::{DAffine3, DMat3, DQuat, DVec3};
use burin::volume::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

fn grid(dims: [u32; 3]) -> Grid {
    let turn = DMat3::from_quat(DQuat::from_rotation_x(0.4));
    let matrix3 = turn * DMat3::from_diagonal(DVec3::new(0.5, 1.0, 2.0));
    Grid { dims, world_from_index: DAffine3 { matrix3, translation: DVec3::new(-9.0, 4.0, 30.0) } }
}

fn density(grid: &Grid, value: impl Fn([u32; 3]) -> f32) -> Field {
    let [nx, ny, nz] = grid.dims;
    let mut voxels = Vec::new();
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                voxels.push(value([x, y, z]));
            }
        }
    }
    let source = MemorySource::new("density", *grid, Voxels::F32(voxels), (1.0, 0.0)).unwrap();
    Field::from_source(Arc::new(source), DensityMap::FLOAT, &|_| true).unwrap().unwrap()
}

fn bricks(field: &Field, value: impl Fn([u32; 3]) -> u8) -> Changes {
    let dims = field.dims(0);
    let texels = |b: BrickIndex| {
        (0..BRICK_VOXELS as u32)
            .map(|i| std::array::from_fn(|a| b.origin()[a] + [i % BRICK, i / BRICK % BRICK, i / (BRICK * BRICK)][a]))
            .map(|v: [u32; 3]| if (0..3).all(|a| v[a] < dims[a]) { value(v) } else { 0 })
            .collect()
    };
    field.brick_indices(0).into_iter().map(|b| (b, Some(Brick::from_texels(texels(b), 1)))).collect()
}

fn selection(grid: &Grid, value: impl Fn([u32; 3]) -> u8) -> Field {
    let mut field = Field::blank(FieldKind::Selection, grid);
    let changes = bricks(&field, value);
    field.swap(changes).unwrap();
    field
}

/// Clear up to 10, then rising.
fn transfer() -> TransferFunction {
    TransferFunction { colour: vec![(0.0, [1.0; 3])], opacity: vec![(10.0, 0.0), (50.0, 0.5)], unit_mm: 1.0 }
}

/// A blob with a soft border, and matter that is clear in places.
fn blob(dims: [u32; 3], seed: u64) -> (impl Fn([u32; 3]) -> f32, impl Fn([u32; 3]) -> u8) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let size = DVec3::new(f64::from(dims[0]), f64::from(dims[1]), f64::from(dims[2]));
    let (a, b) = (size * 0.5 + unit(&mut rng) * 4.0, size * DVec3::new(rng.random(), rng.random(), rng.random()));
    let at = |v: [u32; 3]| DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]));
    let radius = size.min_element() * 0.52;
    let density = move |v| if at(v).distance(b) < radius * 0.6 { 5.0 } else { 30.0 };
    let selection = move |v| ((radius - at(v).distance(a)) / 4.0 * 255.0).clamp(0.0, 255.0) as u8;
    (density, selection)
}

struct Expected {
    lo: [u32; 3],
    edge: u32,
    weight: f64,
}

/// The definition: a node that holds visible matter (over all taps of its samples) and selection (over its voxels), both
/// throughout or at a leaf.
fn walk(
    dims: [u32; 3],
    d: &dyn Fn([u32; 3]) -> f32,
    s: &dyn Fn([u32; 3]) -> u8,
    lo: [u32; 3],
    edge: u32,
    out: &mut Vec<Expected>,
) {
    if (0..3).any(|a| lo[a] >= dims[a]) {
        return;
    }
    let hi: [u32; 3] = std::array::from_fn(|a| (lo[a] + edge).min(dims[a]));
    let (mut least, mut most, mut sum) = (255, 0, 0.0);
    for z in lo[2]..hi[2] {
        for y in lo[1]..hi[1] {
            for x in lo[0]..hi[0] {
                let code = s([x, y, z]);
                least = least.min(code);
                most = most.max(code);
                sum += f64::from(code) / 255.0;
            }
        }
    }
    // Cells of 4 voxels bound the taps, so an open border reaches to the next multiple of 4.
    let last = |a: usize| (hi[a].div_ceil(4) * 4 + 1).min(dims[a]);
    let (mut clear, mut visible) = (false, false);
    for z in lo[2].saturating_sub(1)..last(2) {
        for y in lo[1].saturating_sub(1)..last(1) {
            for x in lo[0].saturating_sub(1)..last(0) {
                if d([x, y, z]) > 10.0 { visible = true } else { clear = true }
            }
        }
    }
    if most == 0 || !visible {
        return;
    }
    if (least > 0 && !clear) || edge == LEAF {
        out.push(Expected { lo, edge, weight: sum });
        return;
    }
    for c in 0..8 {
        let half = edge / 2;
        walk(dims, d, s, [lo[0] + (c & 1) * half, lo[1] + (c >> 1 & 1) * half, lo[2] + (c >> 2) * half], half, out);
    }
}

#[test]
fn points_are_the_homogeneous_nodes_and_the_leaves_that_hold_both() {
    for (dims, seed) in [([72, 40, 33], 1), ([33, 65, 41], 2), ([8, 8, 8], 3), ([12, 9, 3], 4), ([64, 64, 64], 5)] {
        let grid = grid(dims);
        let (d, s) = blob(dims, seed);
        let (density, selection) = (density(&grid, &d), selection(&grid, &s));
        let points = explosion_points(&density, &selection, &grid, &transfer(), 9).unwrap();
        let mut expected = Vec::new();
        walk(dims, &d, &s, [0; 3], 128, &mut expected);
        assert!(!expected.is_empty() && expected.len() <= MAX_POINTS, "{dims:?}: {}", expected.len());
        assert_eq!(points.len(), expected.len(), "{dims:?}");
        let voxel_mm3 = 0.5 * 1.0 * 2.0;
        let index_from_world = grid.index_from_world();
        for point in &points {
            let at = index_from_world.transform_point3(point.position) + 0.5;
            let inside = |e: &&Expected| {
                (0..3).all(|a| {
                    let (lo, hi) = (f64::from(e.lo[a]), f64::from((e.lo[a] + e.edge).min(dims[a])));
                    // Jitter is at most an eighth of the edge from the middle.
                    ((at[a] - lo) / (hi - lo) - 0.5).abs() <= 0.1251
                })
            };
            let found: Vec<&Expected> = expected.iter().filter(inside).collect();
            assert_eq!(found.len(), 1, "{dims:?}: one node about {at}");
            assert!((point.weight - found[0].weight * voxel_mm3).abs() < 1e-6, "{dims:?}");
        }
    }
}

#[test]
fn a_node_with_an_empty_child_is_not_wholly_selected() {
    let grid = grid([32, 16, 16]);
    let d = density(&grid, |_| 30.0);
    let points = |s: &dyn Fn([u32; 3]) -> u8| {
        let selection = selection(&grid, s);
        let weights = explosion_points(&d, &selection, &grid, &transfer(), 0).unwrap();
        weights.iter().map(|p| p.weight.round()).collect::<Vec<f64>>()
    };
    // One of two nodes of 16³; then half of it, of which four leaves are left.
    assert_eq!(points(&|v| if v[0] < 16 { 255 } else { 0 }), [4096.0]);
    assert_eq!(points(&|v| if v[0] < 8 { 255 } else { 0 }), [512.0; 4]);
    assert_eq!(points(&|v| if v[0] < 24 { 255 } else { 0 }), [512.0, 512.0, 512.0, 512.0, 4096.0]);
}

#[test]
fn a_wholly_selected_visible_volume_is_one_point_at_its_centre() {
    let grid = grid([64; 3]);
    let points = explosion_points(&density(&grid, |_| 30.0), &selection(&grid, |_| 51), &grid, &transfer(), 0).unwrap();
    assert_eq!(points.len(), 1);
    assert!((points[0].weight - 64.0_f64.powi(3) * 0.2).abs() < 1e-6, "volume times mean selection");
    let none = explosion_points(&density(&grid, |_| 9.0), &selection(&grid, |_| 255), &grid, &transfer(), 0).unwrap();
    assert_eq!(none, []);
    let blank = Field::blank(FieldKind::Selection, &grid);
    assert_eq!(explosion_points(&density(&grid, |_| 30.0), &blank, &grid, &transfer(), 0).unwrap(), []);
    let nan = density(&grid, |_| f32::NAN);
    assert_eq!(explosion_points(&nan, &selection(&grid, |_| 255), &grid, &transfer(), 0).unwrap(), []);
}

#[test]
fn too_many_points_merge_upward_and_keep_weight_and_middle() {
    let dims = [96; 3];
    let grid = grid(dims);
    let d = density(&grid, |_| 30.0);
    // Every second voxel: no node is wholly selected, so 1,728 leaves are found, and denser towards +x.
    let s = move |v: [u32; 3]| if (v[0] + v[1] + v[2]).is_multiple_of(2) { (v[0] * 2 + 20) as u8 } else { 0 };
    let selection = selection(&grid, s);
    let points = explosion_points(&d, &selection, &grid, &transfer(), 3).unwrap();
    assert!((400..=MAX_POINTS).contains(&points.len()), "{}", points.len());
    let (mut sum, mut moment) = (0.0, DVec3::ZERO);
    for x in 0..96 {
        let w = f64::from(x * 2 + 20) / 255.0 * 96.0 * 48.0;
        sum += w;
        moment += DVec3::new(f64::from(x), 47.5, 47.5) * w;
    }
    let total: f64 = points.iter().map(|p| p.weight).sum();
    assert!((total / sum - 1.0).abs() < 1e-9);
    let middle = points.iter().map(|p| p.position * p.weight).sum::<DVec3>() / total;
    let expected = grid.world_from_index.transform_point3(moment / sum);
    // Jitter of 1,728 leaves averages to about 1 voxel / sqrt(1728).
    assert!(middle.distance(expected) < 0.2, "{middle} {expected}");
}

#[test]
fn jitter_follows_the_seed_and_a_stroke_here_moves_no_point_there() {
    let dims = [96, 40, 40];
    let grid = grid(dims);
    let d = density(&grid, |_| 30.0);
    let both = selection(&grid, |v| if v[0] % 64 < 20 && (v[0] + v[1]) % 3 == 0 { 200 } else { 0 });
    let one = selection(&grid, |v| if v[0] < 20 && (v[0] + v[1]) % 3 == 0 { 200 } else { 0 });
    let points = |s: &Field, seed| explosion_points(&d, s, &grid, &transfer(), seed).unwrap();
    assert_eq!(points(&both, 1), points(&both, 1));
    assert_ne!(points(&both, 1), points(&both, 2));
    let (both, one) = (points(&both, 1), points(&one, 1));
    assert!(both.len() > one.len() && one.iter().all(|p| both.contains(p)));
}

#[test]
fn octrees_that_follow_strokes_equal_octrees_read_afresh() {
    let dims = [72, 40, 33];
    let grid = grid(dims);
    let (d, s) = blob(dims, 6);
    let mut density = density(&grid, &d);
    let mut selection = selection(&grid, &s);
    let mut octrees = Octrees::new(&grid, &density, &selection).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for i in 0..4 {
        let at: [u32; 3] = std::array::from_fn(|a| rng.random_range(0..dims[a]));
        let erase = i % 2 == 1;
        let dab = move |v: [u32; 3]| (0..3).map(|a| v[a].abs_diff(at[a]).pow(2)).sum::<u32>() < 120;
        let before: Vec<u8> = selection.read(0, [0; 3], dims).unwrap();
        let now = |v: [u32; 3]| before[(v[0] + dims[0] * (v[1] + dims[1] * v[2])) as usize];
        let changes: Changes = bricks(&selection, |v| if dab(v) { if erase { 0 } else { 255 } } else { now(v) });
        // While the stroke runs only its bricks are known.
        for (index, brick) in &changes {
            let cells = selected_cells(brick.as_ref().unwrap(), selection.valid(0, *index));
            octrees.paint(&density, *index, &cells);
        }
        let running = octrees.points(&transfer(), 4);
        let (_, refresh) = selection.swap(changes).unwrap();
        let touched = refresh.finest();
        octrees.update(&density, &selection, touched).unwrap();
        let fresh = explosion_points(&density, &selection, &grid, &transfer(), 4).unwrap();
        assert_eq!(octrees.points(&transfer(), 4), fresh);
        assert_eq!(running, fresh);
    }
    // Density that is painted away takes its points with it.
    let clear =
        density.brick_indices(0).into_iter().map(|b| (b, Some(Brick::Uniform(1.0_f32.to_le_bytes())))).collect();
    let (_, refresh) = density.swap(clear).unwrap();
    octrees.update(&density, &selection, refresh.finest()).unwrap();
    assert_eq!(octrees.points(&transfer(), 4), []);
}

/// How much of `[lo, hi]` lies in `[from, to]`.
fn within([lo, hi]: [f64; 2], [from, to]: [f64; 2]) -> f64 {
    (hi.min(to) - lo.max(from)).max(0.0)
}

#[test]
fn points_of_a_volume_with_a_box_stand_for_what_is_selected_of_either_where_it_tells() {
    let of = SubBox { lo: [9, 6, 7], hi: [27, 21, 22], scale: [3, 2, 4] };
    let coarse = grid([40, 37, 34]);
    let fine = of.grid(&coarse);
    let whole = Standing::of_whole(coarse.dims, vec![of]);
    let inner = whole.of_inner(&of, Vec::new());
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (near, far) = (DVec3::new(20.0, 14.0, 13.0), DVec3::new(30.0, 25.0, 16.0));
    // Two balls, each through the box's faces, with soft borders; in the box the first is smaller than beside it.
    let code = |p: DVec3, radius: f64| {
        let depth = (radius - p.distance(near)).max(radius - p.distance(far));
        (depth * 200.0).clamp(0.0, 255.0) as u8
    };
    let at = |v: [u32; 3]| DVec3::from_array(v.map(f64::from));
    let scale = at(of.scale);
    let coarse_code = |v: [u32; 3]| code(at(v), 9.0);
    let fine_code = |v: [u32; 3]| code(at(of.lo) + at(v) / scale, 7.0);
    let (on_coarse, on_fine) = (selection(&coarse, coarse_code), selection(&fine, fine_code));
    let densities = [density(&coarse, |_| 50.0), density(&fine, |_| 50.0)];
    let trees = [
        Octrees::within(&coarse, whole.clone(), &densities[0], &on_coarse).unwrap(),
        Octrees::within(&fine, inner, &densities[1], &on_fine).unwrap(),
    ];
    let table = transfer();
    let points = points_of(&[(&trees[0], &table), (&trees[1], &table)], rng.random());
    assert!(points.len() <= MAX_POINTS && points.len() > 30, "{}", points.len());
    // Cell by cell: what of a voxel's lies outside of the box, what of a sample's inside.
    let faces: [[f64; 2]; 3] = std::array::from_fn(|a| [f64::from(of.lo[a]), f64::from(of.hi[a])]);
    let (mut sum, mut moment) = (0.0, DVec3::ZERO);
    let mut add = |grid: &Grid, v: [u32; 3], code: u8, share: f64| {
        let weight = share * f64::from(code) / 255.0 * grid.world_from_index.matrix3.determinant().abs();
        sum += weight;
        moment += weight * grid.world_from_index.transform_point3(at(v));
    };
    for v in crate::common::volumes::each(coarse.dims, |v| v) {
        let inside: f64 = (0..3).map(|a| within([-0.5, 0.5].map(|h| f64::from(v[a]) + h), faces[a])).product();
        add(&coarse, v, coarse_code(v), 1.0 - inside);
    }
    for v in crate::common::volumes::each(fine.dims, |v| v) {
        let ends = fine.dims.map(|d| [0.0, f64::from(d) - 1.0]);
        let share: f64 = (0..3).map(|a| within([-0.5, 0.5].map(|h| f64::from(v[a]) + h), ends[a])).product();
        add(&fine, v, fine_code(v), share);
    }
    let found: f64 = points.iter().map(|p| p.weight).sum();
    assert!((found / sum - 1.0).abs() < 1e-9, "{found} mm³ of {sum}");
    let centre = points.iter().map(|p| p.position * p.weight).sum::<DVec3>() / found;
    assert!(centre.distance(moment / sum) < 1.0, "{centre}, {} expected", moment / sum);
    // Points of samples lie no further from something selected than leaves of samples are long.
    let selected: Vec<DVec3> = crate::common::volumes::each(fine.dims, |v| (v, fine_code(v)))
        .into_iter()
        .filter(|(_, code)| *code > 0)
        .map(|(v, _)| fine.world_from_index.transform_point3(at(v)))
        .collect();
    let alone = points_of(&[(&trees[1], &table)], 1);
    for point in &alone {
        let off = selected.iter().map(|p| p.distance(point.position)).fold(f64::INFINITY, f64::min);
        assert!(off < fine.spacing().length() * f64::from(LEAF) * 0.5, "{point:?}: {off}");
    }
}

#[test]
fn a_running_stroke_beside_and_under_a_box_counts_where_the_volume_tells() {
    let of = SubBox { lo: [8, 8, 8], hi: [24, 24, 24], scale: [2; 3] };
    let grid = grid([40, 40, 34]);
    let whole = Standing::of_whole(grid.dims, vec![of]);
    let blank = Field::blank(FieldKind::Selection, &grid);
    let matter = density(&grid, |_| 50.0);
    let mut octrees = Octrees::within(&grid, whole, &matter, &blank).unwrap();
    let all = selection(&grid, |_| 255);
    let cells = LiveCells::of(&all, BrickIndex([0; 3])).unwrap();
    octrees.paint(&matter, BrickIndex([0; 3]), &cells.selected);
    let weight: f64 = octrees.points(&transfer(), 0).iter().map(|p| p.weight).sum();
    // All but the cells of 4³ that lie within the box altogether: 12 to 24 along each axis.
    let expected = f64::from(32_u32.pow(3) - 12_u32.pow(3)) * grid.world_from_index.matrix3.determinant();
    assert!((weight / expected - 1.0).abs() < 1e-9, "{weight}, {expected} expected");
}
