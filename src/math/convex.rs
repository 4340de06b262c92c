//! Convex bodies by their planes and corners: what a plane leaves of them, faces as polygons, volume.
//!
//! A cut needs no edges: every corner on one side is joined with every corner on the other, and the hull of where these
//! lines cross the plane is the section. Lines that are no edges cross inside it. So a corner is never the solution of three
//! nearly parallel planes, and slivers stay exact. Knows nothing of what is cut, or why.

use crate::math::shapes::{Aabb, Plane};
use crate::math::{DVec2, DVec3};

/// How near, as a share of a body's diameter, a corner counts as on a face.
const ON_FACE: f64 = 1e-6;
/// Area, as a share of a body's squared diameter, under which a plane only touches it.
const TOUCH: f64 = 1e-9;

/// What a cut leaves on one side.
#[derive(Clone, Debug, PartialEq)]
pub struct Half {
    /// Places, in the list of planes that was cut, of those that still bound it. The plane of the cut bounds it too.
    pub planes: Vec<usize>,
    /// Corners, those of the section last.
    pub corners: Vec<DVec3>,
}

/// What lies on the side of a plane where distances have the sign of `side`. `distances` are those of the corners from the plane,
/// `section` is that of the body with it; corners nearer than `on` are on the plane, and come with the section.
pub fn half(planes: &[Plane], corners: &[DVec3], distances: &[f64], section: &[DVec3], side: f64, on: f64) -> Half {
    let own = corners.iter().zip(distances).filter(|(_, d)| *d * side > on).map(|(&v, _)| v);
    let corners: Vec<DVec3> = own.chain(section.iter().copied()).collect();
    let whole = diameter(&corners);
    let bounds = |i: &usize| area(&ring(&planes[*i], &corners, ON_FACE * whole)) > TOUCH * whole.powi(2);
    Half { planes: (0..planes.len()).filter(bounds).collect(), corners }
}

/// The corners of a body's section with a plane, in order around it: its own corners on the plane as they are, and where its
/// edges cross. Empty if the plane misses it.
pub fn section(vertices: &[DVec3], distances: &[f64], plane: &Plane, on: f64) -> Vec<DVec3> {
    let mut points: Vec<DVec3> =
        vertices.iter().zip(distances).filter(|(_, d)| d.abs() <= on).map(|(&v, _)| v).collect();
    let own = points.len();
    for (&a, &da) in vertices.iter().zip(distances).filter(|(_, d)| **d < -on) {
        for (&b, &db) in vertices.iter().zip(distances).filter(|(_, d)| **d > on) {
            points.push(a + (b - a) * (da / (da - db)));
        }
    }
    hull_on(plane, &points, own, on)
}

/// Hull of points on a plane, in order around it. The first `own` of them are kept as they are; others nearer than `near` to
/// one before them, or to the line of their neighbours, are left out.
fn hull_on(plane: &Plane, points: &[DVec3], own: usize, near: f64) -> Vec<DVec3> {
    let flat = flatten(plane, points);
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| flat[a].x.total_cmp(&flat[b].x).then(flat[a].y.total_cmp(&flat[b].y)).then(a.cmp(&b)));
    let turn = |a: usize, b: usize, c: usize| (flat[b] - flat[a]).perp_dot(flat[c] - flat[b]);
    let chain = |order: &mut dyn Iterator<Item = usize>| {
        let mut out: Vec<usize> = Vec::new();
        for i in order {
            while out.len() >= 2 && turn(out[out.len() - 2], out[out.len() - 1], i) <= 0.0 {
                out.pop();
            }
            out.push(i);
        }
        out.pop();
        out
    };
    let mut ring = chain(&mut order.iter().copied());
    ring.extend(chain(&mut order.iter().rev().copied()));
    // The exact chain may have preferred a computed point to the corner it stands for.
    for corner in 0..own {
        if !ring.contains(&corner) {
            match ring.iter().position(|&i| i >= own && flat[i].distance(flat[corner]) <= near) {
                Some(at) => ring[at] = corner,
                None => insert(&mut ring, corner, &flat),
            }
        }
    }
    let mut i = 0;
    while ring.len() > 2 && i < ring.len() {
        let (before, at, after) = (ring[(i + ring.len() - 1) % ring.len()], ring[i], ring[(i + 1) % ring.len()]);
        let side = flat[after] - flat[before];
        let off = side.perp_dot(flat[at] - flat[before]).abs() / side.length().max(f64::MIN_POSITIVE);
        let close = flat[at].distance(flat[before]).min(flat[at].distance(flat[after]));
        if at >= own && (off <= near || close <= near) {
            ring.remove(i);
            i = i.saturating_sub(1);
        } else {
            i += 1;
        }
    }
    ring.into_iter().map(|i| points[i]).collect()
}

/// Puts a corner that rounding left out of a ring between the two neighbours whose side it lies on.
fn insert(ring: &mut Vec<usize>, corner: usize, flat: &[DVec2]) {
    let to_side = |i: usize| {
        let (a, b) = (flat[ring[i]], flat[ring[(i + 1) % ring.len()]]);
        flat[corner].distance(nearest_on_segment_2d(flat[corner], a, b))
    };
    let best = (0..ring.len()).min_by(|&a, &b| to_side(a).total_cmp(&to_side(b)));
    ring.insert(best.map_or(0, |i| i + 1), corner);
}

fn nearest_on_segment_2d(p: DVec2, a: DVec2, b: DVec2) -> DVec2 {
    let along = b - a;
    let t = (p - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
    a + along * t.clamp(0.0, 1.0)
}

fn flatten(plane: &Plane, points: &[DVec3]) -> Vec<DVec2> {
    let (u, v) = plane.normal.any_orthonormal_pair();
    let origin = points.first().copied().unwrap_or_default();
    // Without the sign of zeros: sorted by their bits, −0 comes before 0, and a side along an axis would be walked back and forth.
    points.iter().map(|&p| DVec2::new(u.dot(p - origin), v.dot(p - origin)) + DVec2::ZERO).collect()
}

/// The corners on a plane, counter-clockwise seen from its outer side; fewer than three if the plane is no face.
pub fn polygon(plane: &Plane, vertices: &[DVec3]) -> Vec<DVec3> {
    ring(plane, vertices, ON_FACE * diameter(vertices))
}

/// The same of corners no farther than `near` from the plane.
fn ring(plane: &Plane, vertices: &[DVec3], near: f64) -> Vec<DVec3> {
    let on: Vec<DVec3> = vertices.iter().copied().filter(|&v| plane.distance(v).abs() <= near).collect();
    if on.len() < 3 {
        return on;
    }
    let mean = on.iter().sum::<DVec3>() / on.len() as f64;
    let (u, v) = plane.normal.any_orthonormal_pair();
    let handed = if u.cross(v).dot(plane.normal) < 0.0 { -1.0 } else { 1.0 };
    let mut by_angle: Vec<(f64, DVec3)> =
        on.into_iter().map(|p| ((v.dot(p - mean) * handed).atan2(u.dot(p - mean)), p)).collect();
    by_angle.sort_by(|a, b| a.0.total_cmp(&b.0));
    by_angle.into_iter().map(|(_, p)| p).collect()
}

/// Area of a polygon.
pub fn area(polygon: &[DVec3]) -> f64 {
    let Some((&first, rest)) = polygon.split_first() else { return 0.0 };
    rest.windows(2).map(|w| (w[0] - first).cross(w[1] - first)).sum::<DVec3>().length() * 0.5
}

/// Volume: pyramids over the faces from the mean of the corners.
pub fn volume(planes: impl IntoIterator<Item = Plane>, vertices: &[DVec3]) -> f64 {
    let (centre, near) = (mean(vertices), ON_FACE * diameter(vertices));
    planes.into_iter().map(|p| area(&ring(&p, vertices, near)) * -p.distance(centre) / 3.0).sum()
}

/// Mean of the corners.
pub fn mean(vertices: &[DVec3]) -> DVec3 {
    vertices.iter().sum::<DVec3>() / vertices.len().max(1) as f64
}

/// Diagonal of the corners' world box: no shorter than any distance between two of them.
pub fn diameter(vertices: &[DVec3]) -> f64 {
    Aabb::around(vertices.iter().copied()).map_or(0.0, |b| b.half_diagonal() * 2.0)
}
