//! The paper's grid in f64, written from "Direct Volume Editing", section 5, equations 4 and 5 (with F = N×(O×N), B = N×F): Euler
//! steps of one spacing along a spine and its ribs, each brought back to the surface along the normal before it.

use burin::annotate::grid::SurfaceGrid;
use burin::annotate::surface::Surface;
use glam::DVec3;

fn outward(surface: &dyn Surface, p: DVec3) -> Option<DVec3> {
    let g = surface.gradient(p)?;
    (g.length() > 1e-9).then(|| -g / g.length())
}

/// Steps of (f − iso)/|∇f| along the fixed normal; one that crosses the surface is taken again from where it began, half as long.
fn traced_back(surface: &dyn Surface, mut p: DVec3, along: DVec3, tolerance: f64, reach: f64) -> Option<DVec3> {
    let start = p;
    let mut value = surface.value(p)?;
    let mut share = 1.0;
    for _ in 0..400 {
        let step = value / surface.gradient(p)?.length();
        if step.abs() * share < tolerance {
            break;
        }
        let next = p + along * (step * share);
        let there = surface.value(next)?;
        if there * value < 0.0 {
            share /= 2.0;
        } else {
            (p, value) = (next, there);
        }
        if p.distance(start) > reach {
            return None;
        }
    }
    let left = (value / surface.gradient(p)?.length()).abs();
    // A field steeper than its interpolated gradient ends a little before the surface; a flatter one that never crossed is no surface.
    (left < 0.05).then_some(p)
}

/// The vertices after each of `steps` steps from `p`, and the carried direction there; `sign` is that of the steps.
fn trace(surface: &dyn Surface, p: DVec3, o: DVec3, sign: f64, steps: usize, step: f64) -> Vec<Option<(DVec3, DVec3)>> {
    let mut at = (|| {
        let n = outward(surface, p)?;
        Some((p, n.cross(o.cross(n)).normalize()))
    })();
    (0..steps)
        .map(|_| {
            at = at.and_then(|(p, f)| {
                let n = outward(surface, p)?;
                let next = traced_back(surface, p + f * (sign * step), n, 1e-4 * step, 0.5 * step)?;
                let n = outward(surface, next)?;
                let f = n.cross(f.cross(n));
                (f.length() > 1e-9).then(|| (next, f.normalize()))
            });
            at
        })
        .collect()
}

/// The paper's grid of `columns` × `rows` vertices, `step` mm apart.
pub fn plain_grid(
    surface: &dyn Surface,
    centre: DVec3,
    orientation: DVec3,
    columns: usize,
    rows: usize,
    step: f64,
) -> SurfaceGrid {
    let (m, n) = (columns / 2, rows / 2);
    let mut points = vec![None; columns * rows];
    let seed = outward(surface, centre).and_then(|n| traced_back(surface, centre, n, 1e-4 * step, f64::INFINITY));
    if let Some(seed) = seed {
        let first = outward(surface, seed).map(|n| (seed, n.cross(orientation.cross(n)).normalize()));

        let ahead = trace(surface, seed, orientation, 1.0, m, step);
        let behind = trace(surface, seed, orientation, -1.0, m, step);
        let spine = behind.into_iter().rev().chain([first]).chain(ahead);
        for (column, at) in spine.enumerate() {
            let Some((p, f)) = at else { continue };
            let Some(normal) = outward(surface, p) else { continue };
            points[n * columns + column] = Some(p);
            let b = normal.cross(f);
            for (sign, rib) in [1.0, -1.0].map(|sign| (sign, trace(surface, p, b, sign, n, step))) {
                for (count, at) in rib.into_iter().enumerate() {
                    let row = n as isize + (count as isize + 1) * sign as isize;
                    points[row as usize * columns + column] = at.map(|(p, _)| p);
                }
            }
        }
    }
    SurfaceGrid { columns, rows, spacing_mm: step, points }
}
