//! Columns, leaders and poles against references written from their equations.

use super::label_scene::meet;
use burin::annotate::labels::*;
use glam::{DVec2, DVec3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

#[test]
fn a_column_is_as_near_to_its_wishes_as_gaps_allow() {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    for round in 0..200 {
        let count = random.random_range(1..12);
        let wishes: Vec<Wish> = (0..count)
            .map(|_| Wish { y: random.random_range(-50.0..350.0), height: random.random_range(10.0..20.0) })
            .collect();
        let (gap, top, bottom) = (2.0, 0.0, 300.0);
        let ys = spread(&wishes, gap, gap, top, bottom).unwrap_or_default();
        assert_eq!(ys.len(), count, "round {round}");
        let legal = |ys: &[f64]| {
            let apart =
                (1..count).all(|n| ys[n] - ys[n - 1] >= (wishes[n].height + wishes[n - 1].height) / 2.0 + gap - 1e-9);
            apart
                && ys[0] - wishes[0].height / 2.0 >= top - 1e-9
                && ys[count - 1] + wishes[count - 1].height / 2.0 <= bottom + 1e-9
        };
        let cost = |ys: &[f64]| ys.iter().zip(&wishes).map(|(y, wish)| (y - wish.y).powi(2)).sum::<f64>();
        assert!(legal(&ys), "round {round}: {ys:?}");
        // The problem is convex: what no block of neighbours can better by a small move is the best.
        for first in 0..count {
            for last in first..count {
                for by in [-1e-3, 1e-3] {
                    let mut moved = ys.clone();
                    moved[first..=last].iter_mut().for_each(|y| *y += by);
                    assert!(
                        !legal(&moved) || cost(&moved) >= cost(&ys) - 1e-9,
                        "round {round}: {first}..={last} by {by}"
                    );
                }
            }
        }
    }
    assert_eq!(spread(&[Wish { y: 0.0, height: 20.0 }; 3], 1.0, 1.0, 0.0, 61.0), None);
    assert_eq!(spread(&[Wish { y: 0.0, height: 20.0 }; 3], 1.0, 9.0, 0.0, 64.0), Some(vec![10.0, 32.0, 54.0]));
}

#[test]
fn labels_on_their_way_keep_apart_and_within_their_bounds() {
    let mut random = ChaCha8Rng::seed_from_u64(12);
    for round in 0..300 {
        let count = random.random_range(1..10);
        let mut line = |from: f64| {
            let mut y = from;
            (0..count)
                .map(|_| {
                    y += 12.0 + random.random_range(0.0..6.0);
                    y
                })
                .collect::<Vec<f64>>()
        };
        let (ys, aims) = (line(0.0), line(if round % 2 == 0 { 20.0 } else { -20.0 }));
        let mut stands: Vec<Stand> =
            ys.iter().map(|&y| Stand { y, low: y - 8.0, high: y + 8.0, height: 10.0 }).collect();
        // One that has just come does not move; its neighbours give way to it.
        let still = random.random_range(0..count);
        (stands[still].low, stands[still].high) = (ys[still], ys[still]);
        for _ in 0..5 {
            approach(&mut stands, &aims, 2.0, 3.0);
        }
        for n in 0..count {
            assert!((stands[n].y - ys[n]).abs() <= 8.0 + 1e-9 && (n != still || stands[n].y == ys[n]));
            assert!(n == 0 || stands[n].y - stands[n - 1].y >= 12.0 - 1e-9);
        }
    }
}

/// Random labels of two columns in one order; sides as they come, points anywhere between.
fn jumble(random: &mut ChaCha8Rng, count: usize) -> Vec<Ends> {
    (0..count)
        .map(|n| Ends {
            // Whole pixels, so that points share an x, and some are the same.
            anchor: DVec2::new(random.random_range(20..180) as f64, random.random_range(0..200) as f64),
            port: DVec2::new(if random.random_bool(0.5) { 0.0 } else { 200.0 }, 20.0 * n as f64),
        })
        .collect()
}

#[test]
fn leaders_of_any_order_do_not_cross() {
    let mut random = ChaCha8Rng::seed_from_u64(13);
    for round in 0..400 {
        let mut ends = jumble(&mut random, 14);
        // Both columns have to be there: one leader of each side is certain.
        (ends[0].port.x, ends[1].port.x) = (0.0, 200.0);
        let leaders = route(&ends, 1.5);
        for (n, leader) in leaders.iter().enumerate() {
            assert!(leader[0].distance(ends[n].anchor) < 0.015 && leader.last() == Some(&ends[n].port));
            for (m, other) in leaders[..n].iter().enumerate() {
                let met = leader.windows(2).any(|p| other.windows(2).any(|q| meet(p[0], p[1], q[0], q[1])));
                assert!(!met, "round {round}: {m} and {n}\n{other:?}\n{leader:?}");
            }
        }
    }
}

#[test]
fn leaders_are_the_shortest_that_pass_points_on_their_sides() {
    let mut random = ChaCha8Rng::seed_from_u64(14);
    for round in 0..150 {
        let mut ends = jumble(&mut random, 9);
        for (n, end) in ends.iter_mut().enumerate() {
            // Distinct x, so that the reference needs no rule for equal ones.
            end.anchor.x += 0.03 * n as f64;
        }
        (ends[0].port.x, ends[1].port.x) = (0.0, 200.0);
        let (clearance, leaders) = (1.5, route(&ends, 1.5));
        for (n, leader) in leaders.iter().enumerate() {
            let way = if ends[n].port.x > 0.0 { 1.0 } else { -1.0 };
            let runs = |m: usize, x: f64| (x - ends[m].anchor.x) * if ends[m].port.x > 0.0 { 1.0 } else { -1.0 } > 0.0;
            // Gates that this leader goes through: x, and the y that it has to be above or below of.
            let mut gates: Vec<(f64, f64, bool)> = (0..ends.len())
                .filter(|&m| m != n && (ends[m].anchor.x - ends[n].anchor.x) * way > 0.0)
                .map(|m| {
                    let x = ends[m].anchor.x;
                    let between = (n.min(m) + 1..n.max(m)).filter(|&k| runs(k, x)).count() + 1;
                    let off = clearance * between as f64;
                    (x, ends[m].anchor.y + if n < m { -off } else { off }, n < m)
                })
                .collect();
            gates.sort_by(|a, b| (a.0 * way).total_cmp(&(b.0 * way)));
            let mut corners = vec![ends[n].anchor];
            corners.extend(gates.iter().map(|gate| DVec2::new(gate.0, gate.1)));
            corners.push(ends[n].port);
            let open = |a: usize, b: usize| {
                gates[a.min(gates.len())..b - 1].iter().all(|&(x, y, above)| {
                    let at = corners[a].y
                        + (corners[b].y - corners[a].y) * (x - corners[a].x) / (corners[b].x - corners[a].x);
                    if above { at <= y + 1e-6 } else { at >= y - 1e-6 }
                })
            };
            let mut least = vec![f64::INFINITY; corners.len()];
            least[0] = 0.0;
            for b in 1..corners.len() {
                for a in 0..b {
                    if open(a, b) {
                        least[b] = least[b].min(least[a] + corners[a].distance(corners[b]));
                    }
                }
            }
            let best = least[corners.len() - 1];
            assert!((length(leader) - best).abs() < 1e-3, "round {round}, leader {n}: {} not {best}", length(leader));
        }
    }
}

#[test]
fn two_columns_choose_the_order_that_bends_leaders_least() {
    // The left leader starts right of the right one and above it: it has to pass above, though its label is the lower one. And the
    // same upside down.
    for up in [1.0, -1.0] {
        let at = |x: f64, y: f64| DVec2::new(x, up * y);
        let left = Ends { anchor: at(110.0, 40.0), port: at(0.0, 60.0) };
        let right = Ends { anchor: at(90.0, 80.0), port: at(200.0, 55.0) };
        let [a, b] = route_both([&[left], &[right]], 2.0);
        assert_eq!((a[0].len(), b[0].len()), (2, 2), "{a:?} {b:?}");
    }
}

#[test]
fn the_pole_is_the_deepest_voxel() {
    let mut random = ChaCha8Rng::seed_from_u64(15);
    for round in 0..25 {
        let size = [random.random_range(1..9), random.random_range(1..9), random.random_range(1..9)];
        let spacing =
            DVec3::new(random.random_range(0.3..2.0), random.random_range(0.3..2.0), random.random_range(0.3..2.0));
        let inside: Vec<bool> = (0..size[0] * size[1] * size[2]).map(|_| random.random_bool(0.9)).collect();
        let mask = |i: usize, j: usize, k: usize| inside[i + size[0] * (j + size[1] * k)];
        let whole = |p: [i64; 3]| {
            let within = (0..3).all(|a| (0..size[a] as i64).contains(&p[a]));
            within && mask(p[0] as usize, p[1] as usize, p[2] as usize)
        };
        let depth = |p: [i64; 3]| {
            let mut least = f64::INFINITY;
            for k in -1..=size[2] as i64 {
                for j in -1..=size[1] as i64 {
                    for i in -1..=size[0] as i64 {
                        if !whole([i, j, k]) {
                            let off = DVec3::new((i - p[0]) as f64, (j - p[1]) as f64, (k - p[2]) as f64) * spacing;
                            least = least.min(off.length());
                        }
                    }
                }
            }
            least
        };
        let mut best = 0.0_f64;
        for k in 0..size[2] as i64 {
            for j in 0..size[1] as i64 {
                for i in 0..size[0] as i64 {
                    best = if whole([i, j, k]) { best.max(depth([i, j, k])) } else { best };
                }
            }
        }
        match pole(&mask, size, spacing) {
            Some((at, mm)) => {
                assert!((mm - best).abs() < 1e-9, "round {round}: {mm} not {best}");
                assert!((depth(at.map(|n| n as i64)) - mm).abs() < 1e-9, "round {round}");
            }
            None => assert!(!inside.contains(&true)),
        }
    }
    // A ring's centroid is outside, its pole is not; a box's is in the middle.
    let ring =
        |i: usize, j: usize, _: usize| (20.0..=60.0).contains(&(DVec2::new(i as f64, j as f64) - 8.0).length_squared());
    assert!(pole(&ring, [17, 17, 5], DVec3::ONE).is_some_and(|(at, _)| ring(at[0], at[1], at[2])));
    assert_eq!(pole(&|_, _, _| true, [9, 9, 21], DVec3::ONE), Some(([4, 4, 10], 5.0)));
    assert_eq!(pole(&|_, _, _| false, [3, 3, 3], DVec3::ONE), None);
    assert_eq!(pole(&|_, _, _| true, [3, 0, 3], DVec3::ONE), None);
    assert_eq!(pole(&|_, _, _| true, [3, 3, 3], DVec3::new(1.0, 0.0, 1.0)), None);
}
