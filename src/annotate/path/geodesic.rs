//! Rulers: shortest paths on an iso-surface.
//!
//! Owns the search: a first path that stays on the surface, walked straight at the goal or, where that gets stuck, found through the
//! voxels that the surface passes; then Newton steps on the sum of squared chords with each vertex held to its tangent plane, traced back
//! to the surface after each. What is found is a geodesic, shortest among its neighbours; on the far side of a handle or a summit there
//! may be a shorter one. Knows no picture or document. Source: "Direct Volume Editing" (2008), section 5, for the tracing; its
//! linearised equations are a block-tridiagonal system, two unknowns to a vertex.

use crate::annotate::path::cell_route::{MAX_CELLS, cell_route};
use crate::annotate::path::strip::{Particle, Tracing, lengths, outward};
use crate::annotate::path::surface_path::{SurfacePath, resampled};
use crate::annotate::surface::{Surface, project};
use glam::{DMat2, DVec2, DVec3};

/// Vertices of a path that serve a ruler: 128 chords.
pub const RULER_VERTICES: usize = 129;

/// The most Newton steps; a handful is enough on smooth surfaces.
const MAX_ROUNDS: usize = 96;

/// The most steps of a walk, in straight distances.
const MAX_DETOUR: f64 = 8.0;

/// Cells of a quarter of their distance that two neighbours on a path may be apart.
const NEAR_CELLS: usize = 400;

/// Why there is no path.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GeodesicError {
    /// An end with no surface near.
    #[error("no surface at the {end} point {at}; pick a point on the iso-surface")]
    NoSurface {
        /// "first" or "second".
        end: &'static str,
        /// As given, world mm.
        at: DVec3,
    },
    /// Both ends are the same point.
    #[error("both ends lie at {at}; pick two different points")]
    Same {
        /// World mm.
        at: DVec3,
    },
    /// The surface does not lead from one end to the other.
    #[error("the surface does not connect {from} and {to}; pick two points on one piece of it")]
    NotConnected {
        /// World mm.
        from: DVec3,
        /// World mm.
        to: DVec3,
    },
}

/// The shortest path from `from` to `to` (world mm, on the surface or within a step of it) with `vertices` vertices (2 or more) at about
/// even distances, each within `tracing.tolerance_mm` of the iso-surface; fewer where chords would come near the tolerance.
///
/// # Errors
/// [`GeodesicError`].
pub fn geodesic(
    surface: &dyn Surface,
    from: DVec3,
    to: DVec3,
    vertices: usize,
    tracing: &Tracing,
) -> Result<SurfacePath, GeodesicError> {
    let foot = |end, at| {
        let found = outward(surface, at).and_then(|n| project(surface, at, n, tracing.tolerance_mm));
        found.ok_or(GeodesicError::NoSurface { end, at })
    };
    let ends = [foot("first", from)?, foot("second", to)?];
    if ends[0].distance(ends[1]) <= tracing.tolerance_mm {
        return Err(GeodesicError::Same { at: ends[0] });
    }
    let torn = GeodesicError::NotConnected { from: ends[0], to: ends[1] };
    let first = first_path(surface, ends, tracing).ok_or(torn.clone())?;
    // Chords shorter than the tolerance would measure its noise.
    let most = (lengths(&first).last().copied().unwrap_or(0.0) / (4.0 * tracing.tolerance_mm)).ceil() as usize + 1;
    let even = resampled(&first, vertices.min(most).max(2));
    let laid = even.iter().map(|&p| on_surface(surface, p, tracing)).collect::<Option<Vec<_>>>().ok_or(torn.clone())?;
    let points = shortened(surface, laid, tracing).ok_or(torn.clone())?;
    SurfacePath::of_points(surface, &points, tracing).ok_or(torn)
}

fn on_surface(surface: &dyn Surface, p: DVec3, tracing: &Tracing) -> Option<DVec3> {
    project(surface, p, outward(surface, p)?, tracing.tolerance_mm)
}

/// The shorter of the walks from either end, else the way through voxels.
fn first_path(surface: &dyn Surface, [from, to]: [DVec3; 2], tracing: &Tracing) -> Option<Vec<DVec3>> {
    let there = walk(surface, from, to, tracing);
    let back = walk(surface, to, from, tracing).map(|mut line| {
        line.reverse();
        line
    });
    let length = |line: &Vec<DVec3>| lengths(line).last().copied().unwrap_or(0.0);
    let walked = there.into_iter().chain(back).min_by(|a, b| length(a).total_cmp(&length(b)));
    walked.or_else(|| cell_route(surface, from, to, tracing.step_mm, MAX_CELLS))
}

/// Steps straight at the goal, each in the tangent plane and traced back. `None` where it gets no nearer for long, or off the surface.
fn walk(surface: &dyn Surface, from: DVec3, to: DVec3, tracing: &Tracing) -> Option<Vec<DVec3>> {
    let straight = from.distance(to);
    let step = tracing.step_mm.min(straight / 8.0);
    let mut line = vec![from];
    let mut at = from;
    let mut nearest = straight;
    let mut since = 0.0;
    for _ in 0..(MAX_DETOUR * straight / step).ceil().min(1e5) as usize {
        let left = at.distance(to);
        if left <= 1.5 * step {
            line.push(to);
            // Two sheets may pass each other closer than a step; the last stretch must lie on one.
            return connected(surface, at, to, tracing).then_some(line);
        }
        let toward = to - at;
        // Opposite points of a sphere: every way round is as good, so any.
        let particle = Particle::at(surface, at, toward)
            .filter(|p| p.heading.dot(toward) > 1e-6 * left)
            .or_else(|| Particle::at(surface, at, toward.any_orthogonal_vector()))?;
        // On rough ground a shorter step may find the surface.
        at = [1.0, 0.5, 0.25].iter().find_map(|share| particle.moved(surface, share * step, tracing))?.at;
        line.push(at);
        let now = at.distance(to);
        since = if now < nearest - 1e-3 * step { 0.0 } else { since + step };
        nearest = nearest.min(now);
        if since > straight.max(16.0 * step) {
            return None;
        }
    }
    None
}

/// Whether the surface leads from one point on it to another that is near: halfway it is not further away than halfway is long, or, where
/// it is rough, a way through few cells leads there.
fn connected(surface: &dyn Surface, a: DVec3, b: DVec3, tracing: &Tracing) -> bool {
    let length = a.distance(b);
    let middle = 0.5 * (a + b);
    let normal = outward(surface, a).zip(outward(surface, b)).and_then(|(a, b)| (a + b).try_normalize());
    let found = normal.and_then(|n| project(surface, middle, n, tracing.tolerance_mm));
    found.is_some_and(|p| p.distance(middle) <= 0.5 * length + tracing.tolerance_mm)
        || cell_route(surface, a, b, 0.25 * length.max(tracing.tolerance_mm), NEAR_CELLS).is_some()
}

/// Shortens a path on the surface until nothing is gained; its ends stay. `None` if neighbours on it are not connected.
fn shortened(surface: &dyn Surface, mut points: Vec<DVec3>, tracing: &Tracing) -> Option<Vec<DVec3>> {
    let energy = |points: &[DVec3]| points.windows(2).map(|p| p[0].distance_squared(p[1])).sum::<f64>();
    let mut now = energy(&points);
    let mut share: f64 = 1.0;
    for _ in 0..MAX_ROUNDS {
        let Some((moves, normals)) = newton_step(surface, &points) else { break };
        let mut gained = 0.0;
        // Where the surface is a saddle a full step goes too far.
        while share > 1e-3 {
            // A vertex that finds no surface there waits where it is.
            let tried: Vec<DVec3> = (0..points.len())
                .map(|k| {
                    let still = moves[k] == DVec3::ZERO;
                    let traced = |p| project(surface, p, normals[k], tracing.tolerance_mm);
                    if still { points[k] } else { traced(points[k] + moves[k] * share).unwrap_or(points[k]) }
                })
                .collect();
            let then = energy(&tried);
            if then < now {
                gained = (now - then) / now;
                points = tried;
                now = then;
                break;
            }
            share *= 0.5;
        }
        if gained < 1e-9 {
            break;
        }
        share = (2.0 * share).min(1.0);
    }
    points.windows(2).all(|p| connected(surface, p[0], p[1], tracing)).then_some(points)
}

/// Moves within the tangent planes that bring the sum of squared chords to its least, and the normals at the vertices; none at the ends.
fn newton_step(surface: &dyn Surface, points: &[DVec3]) -> Option<(Vec<DVec3>, Vec<DVec3>)> {
    let count = points.len();
    let normals = points.iter().map(|&p| outward(surface, p)).collect::<Option<Vec<_>>>()?;
    let frames: Vec<[DVec3; 2]> = normals.iter().map(|n| n.any_orthonormal_pair().into()).collect();
    let dots = |i: usize, v: DVec3| DVec2::new(frames[i][0].dot(v), frames[i][1].dot(v));
    let across = |i: usize, k: usize| DMat2::from_cols(dots(i, frames[k][0]), dots(i, frames[k][1]));
    // Thomas' elimination with 2x2 blocks: 2 x_i - C_{i,i-1} x_{i-1} - C_{i,i+1} x_{i+1} = pull_i.
    let mut upper = vec![DMat2::ZERO; count];
    let mut reach = vec![DVec2::ZERO; count];
    for i in 1..count - 1 {
        let pull = dots(i, points[i - 1] + points[i + 1] - 2.0 * points[i]);
        let below = if i > 1 { across(i, i - 1) } else { DMat2::ZERO };
        let inverse = (DMat2::from_diagonal(DVec2::splat(2.0)) - below * upper[i - 1]).inverse();
        upper[i] = if i + 2 < count { inverse * across(i, i + 1) } else { DMat2::ZERO };
        reach[i] = inverse * (pull + below * reach[i - 1]);
    }
    let mut moves = vec![DVec3::ZERO; count];
    let mut after = DVec2::ZERO;
    for i in (1..count - 1).rev() {
        let x = reach[i] + upper[i] * after;
        moves[i] = frames[i][0] * x.x + frames[i][1] * x.y;
        after = x;
    }
    moves.iter().all(|m| m.is_finite()).then_some((moves, normals))
}
