//! Grids of surface particles on spheres, tori and whatever else, against equations 4 and 5 of "Direct Volume Editing" in f64.

use super::pools::budget_of;
use super::reference_family::Family;
use super::trace_reference::{Stored, distance_to_surface, plain_spine};
use crate::common::gpu::gpu;
use crate::common::volumes::*;
use burin::gpu::{Bend, FieldPools, Fields, Gpu, GpuError, GridRequest, Heading, TracedGrid, Tracer, VolumeFields};
use burin::math::{DAffine3, DMat3, DVec3};
use burin::volume::*;
use std::cell::RefCell;

thread_local! {
    /// Of one test: making its pipelines costs more than its grids.
    static TRACER: RefCell<Option<Tracer>> = const { RefCell::new(None) };
}

fn trace(
    gpu: &Gpu,
    pools: &mut FieldPools,
    fields: &Fields<'_>,
    request: &GridRequest,
) -> Result<TracedGrid, GpuError> {
    TRACER.with_borrow_mut(|tracer| {
        let tracer = tracer.get_or_insert_with(|| Tracer::new(gpu).unwrap());
        tracer.grid(gpu, pools, fields, request)
    })
}

/// A grid of a volume alone.
fn trace_one(gpu: &Gpu, stored: &Stored, request: &GridRequest) -> TracedGrid {
    let mut pools = FieldPools::new(gpu, &stored.grid, &stored.density, 256 << 20).unwrap();
    trace(gpu, &mut pools, &stored.fields(), request).unwrap()
}

fn request(centre: DVec3, along: DVec3, step_mm: f64, steps: [u32; 2]) -> GridRequest {
    GridRequest {
        family: vec![VolumeId::FIRST],
        iso: ISO,
        centre,
        along,
        step_mm,
        tolerance_mm: 0.01 * step_mm,
        steps,
        heading: Heading::Straight,
    }
}

const ISO: f64 = 1000.0;

/// 100 a mm, ISO on the surface, higher inside.
fn by_distance(outside_mm: f64) -> u16 {
    (ISO - 100.0 * outside_mm).round().clamp(0.0, 4000.0) as u16
}

fn sphere(grid: Grid, centre: DVec3, radius: f64) -> Stored {
    Stored::new(grid, |p| by_distance(p.distance(centre) - radius))
}

/// About the z axis.
fn torus(grid: Grid, centre: DVec3, [ring, tube]: [f64; 2]) -> Stored {
    Stored::new(grid, |p| {
        let p = p - centre;
        by_distance((p.truncate().length() - ring).hypot(p.z) - tube)
    })
}

/// Voxels of 1 mm; voxels of 0.8 by 1.1 by 1.6 mm, aslant.
fn grids() -> [Grid; 2] {
    let turned = DMat3::from_rotation_z(0.4) * DMat3::from_rotation_x(-0.3);
    let sheared = DMat3::from_cols(DVec3::X, DVec3::new(0.2, 1.0, 0.0), DVec3::new(0.0, -0.15, 1.0));
    let matrix3 = turned * sheared * DMat3::from_diagonal(DVec3::new(0.8, 1.1, 1.6));
    let dims = [80, 60, 40];
    let middle = matrix3 * DVec3::from_array(dims.map(|d| 0.5 * f64::from(d - 1)));
    [
        Grid::aligned([64; 3], DVec3::ONE, DVec3::splat(-31.5)),
        Grid { dims, world_from_index: DAffine3 { matrix3, translation: -middle } },
    ]
}

/// Every vertex lies on the surface that is stored.
fn check_places(stored: &Stored, grid: &TracedGrid) {
    for vertex in grid.vertices.iter().flatten() {
        let off = distance_to_surface(stored, ISO, vertex.at, vertex.normal) / stored.grid.voxel_mm();
        assert!(off < 0.05, "{vertex:?}: {off} voxels");
        assert!((vertex.normal.length() - 1.0).abs() < 1e-5);
    }
}

/// And nowhere is the grid mirrored.
fn check(stored: &Stored, grid: &TracedGrid) {
    check_places(stored, grid);
    check_sense(grid, grid.steps[1] as i32);
}

/// As far as `rows` from the middle one.
fn check_sense(grid: &TracedGrid, rows: i32) {
    let [n, m] = [grid.steps[0] as i32, rows];
    let mut seen = 0;
    for v in -m..m {
        for u in -n..n {
            let (Some(here), Some(next), Some(beside)) =
                (grid.vertex(u, v), grid.vertex(u + 1, v), grid.vertex(u, v + 1))
            else {
                continue;
            };
            let turn = (next.at - here.at).cross(beside.at - here.at).dot(here.normal);
            assert!(turn > 0.0, "mirrored at {u}, {v}: {turn}");
            seen += 1;
        }
    }
    assert!(seen > 0);
}

#[test]
fn grids_lie_on_spheres_and_tori_within_a_twentieth_of_a_voxel_and_are_never_mirrored() {
    let Some(gpu) = gpu() else { return };
    for grid in grids() {
        let ball = sphere(grid, DVec3::ZERO, 20.0);
        // A quarter turn either way is 31.4 mm.
        for (direction, along) in [
            (DVec3::new(1.0, 0.3, 0.2), DVec3::Z),
            (DVec3::new(-0.3, 0.5, 0.9), DVec3::new(1.0, 1.0, -0.4)),
            (DVec3::NEG_Y, DVec3::NEG_X),
        ] {
            // Picked a bit beside the surface.
            let traced = trace_one(&gpu, &ball, &request(direction.normalize() * 20.3, along, 1.0, [31, 31]));
            check_places(&ball, &traced);
            // At a quarter turn from the middle row all columns meet.
            check_sense(&traced, 29);
            assert!(traced.trimmed() * 100 <= traced.vertices.len(), "{} trimmed", traced.trimmed());
            // The paper's equation keeps to a great circle.
            let n = direction.normalize();
            let f = n.cross(along.cross(n)).normalize();
            for u in -20..=20 {
                let (on, angle) = (traced.vertex(u, 0).unwrap().at, f64::from(u) / 20.0);
                let expected = 20.0 * (n * angle.cos() + f * angle.sin());
                assert!(on.distance(expected) < 0.7, "{u}: {on} for {expected}");
            }
        }
        let ring = torus(grid, DVec3::ZERO, [17.0, 7.0]);
        for (at, along) in [
            (DVec3::new(24.0, 0.0, 0.0), DVec3::Y),
            (DVec3::new(0.0, 17.0, 7.0), DVec3::new(1.0, 0.5, 0.0)),
            (DVec3::new(-10.0, 0.0, 0.0), DVec3::new(0.0, 1.0, 1.0)),
        ] {
            // A quarter turn about the tube is 11 mm.
            let traced = trace_one(&gpu, &ring, &request(at, along, 0.5, [22, 22]));
            check(&ring, &traced);
            assert!(traced.trimmed() * 100 <= traced.vertices.len(), "{} trimmed", traced.trimmed());
        }
    }
}

#[test]
fn the_middle_row_is_that_of_the_equations() {
    let Some(gpu) = gpu() else { return };
    for grid in grids() {
        let ring = torus(grid, DVec3::ZERO, [17.0, 7.0]);
        let asked = request(DVec3::new(23.8, 1.0, 0.4), DVec3::new(0.2, 0.7, 1.0), 0.7, [20, 2]);
        let asked = GridRequest { tolerance_mm: 1e-3, ..asked };
        let traced = trace_one(&gpu, &ring, &asked);
        for sense in [1, -1] {
            for (i, expected) in plain_spine(&ring, &asked, f64::from(sense)).into_iter().enumerate() {
                let here = traced.vertex(sense * i as i32, 0).unwrap();
                let off = here.at.distance(expected) / 0.7;
                assert!(off < 0.005 * (1 + i) as f64, "{sense} {i}: {} for {expected}", here.at);
            }
        }
    }
}

#[test]
fn where_the_surface_ends_the_grid_is_trimmed() {
    let Some(gpu) = gpu() else { return };
    let grid = Grid::aligned([48, 48, 24], DVec3::ONE, DVec3::ZERO);
    // A plane in which nothing is known within 6 mm of (30, 24).
    let height = 11.7;
    let hole = |p: DVec3| p.truncate().distance(DVec3::new(30.0, 24.0, 0.0).truncate());
    let plane =
        Stored::of_floats(grid, |p| if hole(p) < 6.0 { f32::NAN } else { f32::from(by_distance(p.z - height)) });
    let asked = request(DVec3::new(15.0, 24.0, 12.0), DVec3::X, 1.0, [40, 30]);
    let traced = trace_one(&gpu, &plane, &asked);
    for v in -30..=30 {
        for u in -40..=40 {
            let place = DVec3::new(15.0 + f64::from(u), 24.0 + f64::from(v), height);
            let vertex = traced.vertex(u, v);
            let inside = |v: f64| (-0.5..=47.5).contains(&v);
            // The middle row ends before the hole, and so do all columns beyond.
            if !inside(place.x) || !inside(place.y) || hole(place) < 6.0 || place.x > 24.0 {
                assert!(vertex.is_none(), "{u} {v}: {vertex:?}");
            } else if place.x < 22.0 {
                assert!(vertex.is_some_and(|on| on.at.distance(place) < 0.05), "{u} {v}: {vertex:?}");
            }
        }
    }
    assert!(traced.trimmed() > 0);
    // From beside it, columns end at the hole.
    let beside = trace_one(&gpu, &plane, &GridRequest { centre: DVec3::new(30.0, 12.0, 12.0), ..asked.clone() });
    let goes_on = |u| beside.vertex(u, 4).is_some() && beside.vertex(u, 30).is_none();
    assert!((-5..=5).all(goes_on));
    assert!((6..=30).all(|v| beside.vertex(0, v).is_none()) && beside.vertex(9, 20).is_some());
    // Nothing is near the picked point.
    let nothing = trace_one(&gpu, &plane, &GridRequest { centre: DVec3::new(15.0, 24.0, 18.0), ..asked.clone() });
    assert_eq!(nothing.trimmed(), nothing.vertices.len());
}

/// How far vertices of two grids are apart, mm; infinite where one of them has none.
fn apart(a: &TracedGrid, b: &TracedGrid) -> f64 {
    let pairs = a.vertices.iter().zip(&b.vertices);
    let off = pairs.map(|pair| match pair {
        (Some(a), Some(b)) => a.at.distance(b.at),
        (None, None) => 0.0,
        _ => f64::INFINITY,
    });
    off.fold(0.0, f64::max)
}

#[test]
fn paged_density_gives_the_same_grid_and_pictures_keep_what_they_need() {
    let Some(gpu) = gpu() else { return };
    let grid = Grid::aligned([130; 3], DVec3::ONE, DVec3::splat(-64.5));
    let ball = sphere(grid, DVec3::ZERO, 30.0);
    let asked = request(DVec3::new(30.0, 0.0, 0.0), DVec3::Y, 1.0, [8, 6]);
    let asked = GridRequest { tolerance_mm: 1e-3, ..asked };
    let whole = trace_one(&gpu, &ball, &asked);
    assert_eq!(whole.trimmed(), 0);
    let fields = ball.fields();
    let paged_pools = |slots| FieldPools::apart(&gpu, &grid, &ball.density, budget_of(slots)).unwrap();
    let mut pools = paged_pools(20);
    let picture = frame(&grid, ramp(500.0, 3000.0), DVec3::NEG_X, [64, 64]);
    pools.make_resident(&gpu, &fields, &picture).unwrap();
    let (held, room) = pools.room(FieldKind::Density);
    assert!(held == room, "some is coarser: {held} of {room}");
    let paged = trace(&gpu, &mut pools, &fields, &asked).unwrap();
    assert!(apart(&paged, &whole) < 0.01);
    check(&ball, &paged);
    pools.make_resident(&gpu, &fields, &picture).unwrap();
    assert!(!pools.make_resident(&gpu, &fields, &picture).unwrap(), "at rest nothing changes");
    // While pictures are in motion little is uploaded at once.
    let mut pools = paged_pools(20);
    pools.bound_uploads(Some(3));
    assert_eq!(trace(&gpu, &mut pools, &fields, &asked).unwrap(), paged);
    // More than there is room for.
    let mut pools = paged_pools(12);
    let large = GridRequest { steps: [60, 60], ..asked };
    let refused = trace(&gpu, &mut pools, &fields, &large);
    assert!(matches!(refused, Err(GpuError::GridTooLarge { .. })), "{refused:?}");
    pools.make_resident(&gpu, &fields, &picture).unwrap();
    assert!(!pools.make_resident(&gpu, &fields, &picture).unwrap(), "nothing is left of what was refused");
}

#[test]
fn edits_are_followed() {
    let Some(gpu) = gpu() else { return };
    let grid = Grid::aligned([64; 3], DVec3::ONE, DVec3::splat(-31.5));
    let mut ball = sphere(grid, DVec3::ZERO, 20.0);
    let larger = sphere(grid, DVec3::ZERO, 23.5);
    let mut pools = FieldPools::new(&gpu, &grid, &ball.density, 64 << 20).unwrap();
    let asked = request(DVec3::new(20.0, 0.0, 0.0), DVec3::Y, 1.0, [12, 12]);
    check(&ball, &trace(&gpu, &mut pools, &ball.fields(), &asked).unwrap());
    let bricks = larger.density.brick_indices(0).into_iter();
    let changes = bricks.map(|index| (index, Some(larger.density.brick(BrickKey { level: 0, index }).unwrap())));
    let (_, refresh) = ball.density.swap(changes.collect()).unwrap();
    pools.refresh(&gpu, FieldKind::Density, &ball.density, &refresh).unwrap();
    let moved = GridRequest { centre: DVec3::new(22.0, 0.0, 0.0), ..asked };
    let traced = trace(&gpu, &mut pools, &ball.fields(), &moved).unwrap();
    assert_eq!(traced.trimmed(), 0);
    check(&larger, &traced);
    assert!(traced.vertices.iter().flatten().all(|v| (v.at.length() - 23.5).abs() < 0.05));
}

#[test]
fn a_place_in_a_box_is_told_by_the_finest_one() {
    let Some(gpu) = gpu() else { return };
    let grid = Grid::aligned([48; 3], DVec3::ONE, DVec3::splat(-23.5));
    let value = |[x, y, z]: [u32; 3]| {
        let p = DVec3::new(f64::from(x), f64::from(y), f64::from(z)) - 23.5;
        by_distance(p.length() - 9.0)
    };
    let outer = SubBox { lo: [28, 18, 18], hi: [40, 30, 30], scale: [3, 2, 4] };
    let inner = SubBox { lo: [4, 8, 16], hi: [14, 16, 32], scale: [2, 2, 2] };
    let parent = super::reference_family::parent_on(grid, value);
    let family = Family::new(parent, &[(0, outer), (1, inner)]);
    let fields = family.fields();
    let stored: Vec<Stored> = family.volumes.iter().map(Stored::of).collect();
    let mut pools = FieldPools::empty(&gpu, 256 << 20).unwrap();
    let asked = request(DVec3::new(9.0, 1.0, 0.0), DVec3::new(0.0, 1.0, 0.3), 0.5, [20, 20]);
    let family_of = vec![VolumeId(2), VolumeId(1), VolumeId(0)];
    let asked = GridRequest { family: family_of, tolerance_mm: 0.002, ..asked };
    let traced = trace(&gpu, &mut pools, &fields, &asked).unwrap();
    assert_eq!(traced.trimmed(), 0);
    check_sense(&traced, 20);
    let mut told = [0; 3];
    for vertex in traced.vertices.iter().flatten() {
        let is_in = |s: &Stored| {
            let (p, ends) = (s.grid.index_from_world().transform_point3(vertex.at), s.grid.centre_bounds());
            p.cmpge(ends.min).all() && p.cmple(ends.max).all()
        };
        let by = (0..3).rev().find(|&i| is_in(&stored[i])).unwrap();
        told[by] += 1;
        // By the faces the way to the surface may lead through them.
        let off = distance_to_surface(&stored[by], ISO, vertex.at, vertex.normal) / stored[by].grid.voxel_mm();
        assert!(off < 0.05, "{vertex:?} in {by}: {off}");
    }
    assert!(told.iter().all(|&count| count > 50), "{told:?}");
    // The box differs from its parent: an edit that is the box's alone.
    let mut edited = family.volumes[1].clone();
    let smaller = |_: BrickIndex| Some(Brick::from_texels([250_u16; BRICK_VOXELS].map(u16::to_le_bytes).concat(), 2));
    let bricks = edited.density.brick_indices(0).into_iter().map(|index| (index, smaller(index))).collect();
    edited.density.swap(bricks).unwrap();
    let of = VolumeFields { density: &edited.density, ..*fields.get(VolumeId(1)).unwrap() };
    let mut other = fields.clone();
    other.put(VolumeId(1), of);
    let alone = GridRequest { family: vec![VolumeId(1), VolumeId(0)], ..asked.clone() };
    let mut pools = FieldPools::empty(&gpu, 256 << 20).unwrap();
    let traced = trace(&gpu, &mut pools, &other, &alone).unwrap();
    assert_eq!(traced.trimmed(), traced.vertices.len(), "the box has no surface left");
}

#[test]
fn the_middle_row_follows_a_vector_field_and_goes_straight_on_where_it_is_zero() {
    let Some(gpu) = gpu() else { return };
    let grid = grids()[0];
    let ball = sphere(grid, DVec3::ZERO, 20.0);
    // Components on another grid: about the z axis, and nothing above z = 6.
    let turned = DMat3::from_rotation_x(0.5) * DMat3::from_diagonal(DVec3::new(1.5, 2.0, 1.8));
    let dims = [50, 40, 44];
    let middle = turned * DVec3::from_array(dims.map(|d| 0.5 * f64::from(d - 1)));
    let lattice = Grid { dims, world_from_index: DAffine3 { matrix3: turned, translation: -middle } };
    let component = |axis: usize| {
        Stored::of_floats(lattice, |p| {
            let v = if p.z > 6.0 { DVec3::ZERO } else { DVec3::new(-p.y, p.x, 0.0) };
            v[axis] as f32
        })
    };
    let components = [0, 1, 2].map(component);
    let mut fields = ball.fields();
    for (i, of) in (5..).zip(&components) {
        fields.put(VolumeId(i), *of.fields().get(VolumeId::FIRST).unwrap());
    }
    let mut pools = FieldPools::empty(&gpu, 256 << 20).unwrap();
    let vectors = Heading::Vectors([5, 6, 7].map(VolumeId));
    // The hand says up, the field says round.
    let low = GridRequest {
        heading: vectors,
        ..request(DVec3::new(20.0, 0.0, -4.0).normalize() * 20.0, DVec3::Z, 1.0, [25, 5])
    };
    let traced = trace(&gpu, &mut pools, &fields, &low).unwrap();
    assert_eq!(traced.trimmed(), 0);
    check(&ball, &traced);
    let height = traced.vertex(0, 0).unwrap().at.z;
    for u in -25..=25_i32 {
        let at = traced.vertex(u, 0).unwrap().at;
        assert!((at.z - height).abs() < 0.5, "{u}: {at}");
        let angle = f64::from(u) / at.truncate().length();
        let turn = at.y.atan2(at.x) - angle;
        assert!((turn.sin()).abs() < 0.05, "{u}: {at}, {turn}");
    }
    // Where it is zero: straight up, over the pole.
    let high = GridRequest { heading: vectors, ..request(DVec3::new(16.0, 0.0, 12.0), DVec3::Z, 1.0, [20, 5]) };
    let traced = trace(&gpu, &mut pools, &fields, &high).unwrap();
    check_places(&ball, &traced);
    assert!((0..=20).all(|u| traced.vertex(u, 0).unwrap().at.y.abs() < 0.3));
}

#[test]
fn the_middle_row_follows_a_line_of_curvature() {
    let Some(gpu) = gpu() else { return };
    for grid in grids() {
        let ring = torus(grid, DVec3::ZERO, [17.0, 7.0]);
        let centre = DVec3::new(17.0 + 7.0 * 0.8, 0.0, 7.0 * 0.6);
        for (bend, along) in [(Bend::Most, DVec3::new(0.0, 0.9, 1.0)), (Bend::Least, DVec3::new(0.0, 1.0, 0.9))] {
            let asked = GridRequest { heading: Heading::Curvature(bend), ..request(centre, along, 0.5, [20, 4]) };
            let traced = trace_one(&gpu, &ring, &asked);
            assert_eq!(traced.trimmed(), 0);
            check(&ring, &traced);
            for u in -20..=20_i32 {
                let at = traced.vertex(u, 0).unwrap().at;
                match bend {
                    // About the tube: stays in its plane, and goes up where the hand pointed.
                    Bend::Most => {
                        assert!(at.y.abs() < 0.6, "{bend:?} {u}: {at}");
                        let angle = at.z.atan2(at.truncate().length() - 17.0) - 0.6_f64.asin();
                        assert!((angle - f64::from(u) * 0.5 / 7.0).abs() < 0.1, "{u}: {at}");
                    }
                    // About the ring: stays at its height.
                    Bend::Least => {
                        assert!((at.z - 4.2).abs() < 0.6, "{bend:?} {u}: {at}");
                        let angle = at.y.atan2(at.x) - f64::from(u) * 0.5 / 22.6;
                        assert!(angle.abs() < 0.05, "{u}: {at}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_line_of_curvature_goes_on_where_the_other_one_bends_more() {
    let Some(gpu) = gpu() else { return };
    let grid = grids()[0];
    // On the inner side the ring bends more than the tube: where cos < −10/14, from 136° on.
    let ring = torus(grid, DVec3::ZERO, [10.0, 7.0]);
    let start = 1.9_f64;
    let centre = DVec3::new(10.0 + 7.0 * start.cos(), 0.0, 7.0 * start.sin());
    let most = Heading::Curvature(Bend::Most);
    let asked = GridRequest { heading: most, ..request(centre, DVec3::new(-1.0, 0.3, -0.4), 0.5, [16, 2]) };
    let traced = trace_one(&gpu, &ring, &asked);
    for u in -16..=16_i32 {
        let at = traced.vertex(u, 0).unwrap().at;
        let angle = at.z.atan2(at.x - 10.0).rem_euclid(std::f64::consts::TAU);
        assert!(at.y.abs() < 0.5 && (angle - start - f64::from(u) * 0.5 / 7.0).abs() < 0.1, "{u}: {at} {angle}");
    }
}

#[test]
fn the_tolerance_is_a_length_where_the_values_rise_less_from_step_to_step() {
    let Some(gpu) = gpu() else { return };
    // By a factor of e in 3 mm along x.
    let rise = |p: DVec3| 300.0 * (-p.x / 3.0).exp();
    let ball = Stored::of_floats(grids()[0], |p| (ISO + rise(p) * (20.0 - p.length())) as f32);
    for (along, picked) in [(DVec3::X, DVec3::new(-0.6, 0.0, 0.8)), (DVec3::NEG_X, DVec3::new(0.6, 0.8, 0.0))] {
        let asked = GridRequest { tolerance_mm: 0.03, ..request(picked * 20.0, along, 3.0, [7, 6]) };
        let traced = trace_one(&gpu, &ball, &asked);
        check_places(&ball, &traced);
        assert!(traced.trimmed() * 20 <= traced.vertices.len(), "{} trimmed", traced.trimmed());
    }
}

#[test]
fn requests_that_are_none_are_refused() {
    let Some(gpu) = gpu() else { return };
    let ball = sphere(grids()[0], DVec3::ZERO, 20.0);
    let good = request(DVec3::new(20.0, 0.0, 0.0), DVec3::Y, 1.0, [2, 2]);
    let mut pools = FieldPools::new(&gpu, &ball.grid, &ball.density, 64 << 20).unwrap();
    let mut refused = |request: GridRequest| trace(&gpu, &mut pools, &ball.fields(), &request).unwrap_err();
    assert!(matches!(refused(GridRequest { step_mm: 0.0, ..good.clone() }), GpuError::BadStep { .. }));
    assert!(matches!(refused(GridRequest { tolerance_mm: f64::NAN, ..good.clone() }), GpuError::BadGrid { .. }));
    assert!(matches!(refused(GridRequest { along: DVec3::ZERO, ..good.clone() }), GpuError::BadGrid { .. }));
    assert!(matches!(refused(GridRequest { iso: f64::INFINITY, ..good.clone() }), GpuError::BadGrid { .. }));
    assert!(matches!(refused(GridRequest { family: vec![], ..good.clone() }), GpuError::BadGrid { .. }));
    assert!(matches!(refused(GridRequest { family: vec![VolumeId(9)], ..good.clone() }), GpuError::NoVolume { id: 9 }));
    assert!(matches!(
        refused(GridRequest { steps: [513, 2], ..good.clone() }),
        GpuError::TooManySteps { most: 512, .. }
    ));
    let many = GridRequest { family: (0..40).map(VolumeId).collect(), steps: [2, 60], ..good };
    assert!(matches!(refused(many), GpuError::TooManySteps { .. }));
}

#[test]
fn the_longest_grid_ends_where_it_should() {
    let Some(gpu) = gpu() else { return };
    let grid = Grid::aligned([600, 8, 24], DVec3::ONE, DVec3::ZERO);
    let plane = Stored::new(grid, |p| by_distance(p.z - 11.7));
    let traced = trace_one(&gpu, &plane, &request(DVec3::new(40.0, 4.0, 12.0), DVec3::X, 1.0, [512, 3]));
    let ends = [-40, 512].map(|u| traced.vertex(u, 0).unwrap().at.x);
    assert!(ends[0].abs() < 0.2 && (ends[1] - 552.0).abs() < 0.2, "{ends:?}");
    assert!(traced.vertex(-41, 0).is_none());
}
