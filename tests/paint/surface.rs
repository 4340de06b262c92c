//! The rule by which looks at a surface are joined to a path, case by case as it is written.

use burin::math::DVec3;
use burin::paint::{Sample, Seen, SurfaceRule};

fn rule(radius_mm: f64) -> SurfaceRule {
    SurfaceRule { radius_mm, voxel_mm: 1.0, pixel_mm: 0.5, normal: DVec3::Y }
}

fn met(x: f64, y: f64, part: u32) -> Option<Seen> {
    Some(Seen { position: DVec3::new(x, y, 0.0), part })
}

/// The samples of looks, all of full pressure, every `per_pixel`-th of them a pixel's.
fn follow(rule: &SurfaceRule, looks: &[Option<Seen>], per_pixel: usize) -> Vec<Sample> {
    let looks: Vec<_> = looks.iter().map(|&look| (look, 1.0)).collect();
    rule.follow(None, &looks, per_pixel)
}

/// Places of the pieces' ends along x.
fn pieces(samples: &[Sample]) -> Vec<(f64, f64)> {
    let mut pieces: Vec<(f64, f64)> = Vec::new();
    for sample in samples {
        match pieces.last_mut() {
            Some(last) if !sample.breaks => last.1 = sample.position.x,
            _ => pieces.push((sample.position.x, sample.position.x)),
        }
    }
    pieces
}

/// A first pixel, then one whose four looks lead 5 mm on, each but for what is put in its place.
fn way(instead: &[(usize, Option<Seen>)]) -> Vec<Option<Seen>> {
    let mut looks = vec![None, None, None, met(0.0, 0.0, 1)];
    looks.extend((1..=4).map(|i| met(1.25 * f64::from(i), 0.0, 1)));
    for &(at, look) in instead {
        looks[3 + at] = look;
    }
    looks
}

#[test]
fn a_surface_that_falls_back_is_followed_by_the_looks_between() {
    // 5 mm apart is more than two voxels, and less than a dab of 10 mm reaches beside: 1.8 · √(21) = 8.2 mm.
    let rule = rule(10.0);
    assert_eq!(pieces(&follow(&rule, &way(&[]), 4)), [(0.0, 5.0)]);
    // Something lies off the way: the path goes there, not straight on.
    let samples = follow(&rule, &way(&[(2, met(2.5, 1.0, 1))]), 4);
    assert!(samples.iter().any(|s| s.position == DVec3::new(2.5, 1.0, 0.0)) && pieces(&samples).len() == 1);
    // Without looks between there is nothing to follow.
    let apart = [met(0.0, 0.0, 1), met(5.0, 0.0, 1)];
    assert_eq!(pieces(&follow(&rule, &apart, 1)).len(), 2);
}

#[test]
fn nothing_another_part_or_a_jump_between_ends_the_piece() {
    let rule = rule(10.0);
    for at in 1..=3 {
        let x = 1.25 * at as f64;
        for (what, look) in [("nothing", None), ("another part", met(x, 0.0, 2)), ("a jump", met(x, 2.5, 1))] {
            // Both ends are of one part and near: each piece reaches a voxel towards the other.
            let found = pieces(&follow(&rule, &way(&[(at, look)]), 4));
            assert_eq!(found, [(0.0, 1.0), (4.0, 5.0)], "{what} at look {at}");
        }
    }
    // Of two parts nothing is joined, however near.
    let other =
        [None, None, None, met(0.0, 0.0, 1), met(0.1, 0.0, 1), met(0.2, 0.0, 1), met(0.3, 0.0, 1), met(0.4, 0.0, 2)];
    assert_eq!(pieces(&follow(&rule, &other, 4)), [(0.0, 0.0), (0.4, 0.4)]);
    assert_eq!(pieces(&follow(&rule, &[met(0.0, 0.0, 1), None, met(0.5, 0.0, 1)], 1)), [(0.0, 0.0), (0.5, 0.5)]);
}

#[test]
fn a_step_is_closed_from_both_sides_up_to_the_diameter_and_two_voxels() {
    for radius in [0.5, 3.0, 10.0] {
        let rule = rule(radius);
        let most = 2.0 * (radius + 1.0);
        for (apart, wanted) in [
            (2.0, vec![(0.0, 2.0)]),
            (most - 1e-9, vec![(0.0, 1.0), (most - 1e-9 - 1.0, most - 1e-9)]),
            (most + 1e-9, vec![(0.0, 0.0), (most + 1e-9, most + 1e-9)]),
        ] {
            let found = pieces(&follow(&rule, &[met(0.0, 0.0, 1), met(apart, 0.0, 1)], 1));
            let near = found.len() == wanted.len()
                && found.iter().zip(&wanted).all(|(a, b)| (a.0 - b.0).abs() < 1e-9 && (a.1 - b.1).abs() < 1e-9);
            assert!(near, "radius {radius}, {apart} apart: {found:?}, {wanted:?} expected");
        }
    }
}

#[test]
fn a_stroke_that_goes_on_does_not_paint_its_last_place_again() {
    let rule = rule(3.0);
    let last = met(0.0, 0.0, 1);
    let on = rule.follow(last, &[(met(1.0, 0.0, 1), 0.5)], 1);
    assert_eq!(on.iter().map(|s| (s.position.x, s.breaks, s.pressure)).collect::<Vec<_>>(), [(1.0, false, 0.5)]);
    let off = rule.follow(last, &[(None, 1.0), (met(30.0, 0.0, 1), 1.0)], 1);
    assert_eq!(off.iter().map(|s| (s.position.x, s.breaks)).collect::<Vec<_>>(), [(30.0, true)]);
}

#[test]
fn the_slots_that_show_a_voxel_are_its_brick_s_and_those_beside_it() {
    use burin::paint::VoxelSet;
    use burin::volume::BrickIndex;
    let dims = [96, 96, 40];
    for (voxel, beside) in [
        ([31, 5, 5], [[0, 0, 0], [1, 0, 0]]),
        ([5, 31, 5], [[0, 0, 0], [0, 1, 0]]),
        ([64, 5, 5], [[1, 0, 0], [2, 0, 0]]),
        ([95, 95, 31], [[2, 2, 0], [2, 2, 1]]),
    ] {
        let mut set = VoxelSet::default();
        set.insert(voxel);
        let slots = set.slots(dims, [0; 3]);
        assert!(beside.iter().all(|b| slots.contains(&BrickIndex(*b))), "{voxel:?}: {slots:?}");
    }
}
