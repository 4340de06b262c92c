//! The free-boundary minimiser of the symmetric Dirichlet energy over (u, v) of a patch in space: L-BFGS in f64 from the lattice's
//! own (u, v), with a line search that never turns a triangle over. Slow and plain.

use burin::annotate::grid::SurfaceGrid;
use glam::{DMat2, DVec2};

struct Triangle {
    vertices: [usize; 3],
    /// Inverse of the matrix whose columns are the triangle's edges in its own plane.
    inverse: DMat2,
    area: f64,
}

fn triangles(grid: &SurfaceGrid) -> Vec<Triangle> {
    let mut found = Vec::new();
    for vertices in grid.triangles() {
        let [a, b, c] = vertices.map(|v| grid.points[v].expect("a corner"));
        let (p, q) = (b - a, c - a);
        let x = p.normalize();
        let y = p.cross(q).cross(p).normalize();
        let edges = DMat2::from_cols(DVec2::new(p.dot(x), p.dot(y)), DVec2::new(q.dot(x), q.dot(y)));
        found.push(Triangle { vertices, inverse: edges.inverse(), area: 0.5 * edges.determinant() });
    }
    found
}

fn jacobian(t: &Triangle, uv: &[DVec2]) -> DMat2 {
    let [a, b, c] = t.vertices.map(|v| uv[v]);
    DMat2::from_cols(b - a, c - a) * t.inverse
}

fn norm2(m: DMat2) -> f64 {
    m.x_axis.length_squared() + m.y_axis.length_squared()
}

/// E and its gradient; infinite if a triangle is turned over.
fn energy(list: &[Triangle], uv: &[DVec2], gradient: &mut [DVec2]) -> f64 {
    gradient.fill(DVec2::ZERO);
    let (mut sum, mut area) = (0.0, 0.0);
    for t in list {
        let j = jacobian(t, uv);
        if j.determinant() <= 0.0 {
            return f64::INFINITY;
        }
        let k = j.inverse();
        sum += t.area * (norm2(j) + norm2(k));
        area += t.area;
        // d|J⁻¹|² = −2 J⁻ᵀ J⁻¹ J⁻ᵀ : dJ.
        let stress = (j - k.transpose() * k * k.transpose()) * (2.0 * t.area) * t.inverse.transpose();
        let [a, b, c] = t.vertices;
        gradient[b] += stress.x_axis;
        gradient[c] += stress.y_axis;
        gradient[a] -= stress.x_axis + stress.y_axis;
    }
    gradient.iter_mut().for_each(|g| *g /= area);
    sum / area
}

fn dot(a: &[DVec2], b: &[DVec2]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x.dot(*y)).sum()
}

/// E/4 − 1 of the least flat image that `rounds` steps find.
pub fn least_excess(grid: &SurfaceGrid, rounds: usize) -> f64 {
    let list = triangles(grid);
    let mut uv: Vec<DVec2> = (0..grid.points.len())
        .map(|v| DVec2::new((v % grid.columns) as f64, (v / grid.columns) as f64) * grid.spacing_mm)
        .collect();
    let mut g = vec![DVec2::ZERO; uv.len()];
    let mut e = energy(&list, &uv, &mut g);
    let mut past: Vec<(Vec<DVec2>, Vec<DVec2>)> = Vec::new();
    for _ in 0..rounds {
        let mut d = g.clone();
        let mut shares = Vec::new();
        for (s, y) in past.iter().rev() {
            let share = dot(s, &d) / dot(s, y);
            d.iter_mut().zip(y).for_each(|(d, y)| *d -= *y * share);
            shares.push(share);
        }
        if let Some((s, y)) = past.last() {
            let scale = dot(s, y) / dot(y, y);
            d.iter_mut().for_each(|d| *d *= scale);
        }
        for ((s, y), share) in past.iter().zip(shares.into_iter().rev()) {
            let back = dot(y, &d) / dot(s, y);
            d.iter_mut().zip(s).for_each(|(d, s)| *d += *s * (share - back));
        }
        let slope = -dot(&d, &g);
        let mut step = if past.is_empty() {
            1e-3 * grid.spacing_mm / d.iter().map(|d| d.length()).fold(1e-300, f64::max)
        } else {
            1.0
        };
        let mut next = Vec::new();
        let mut h = vec![DVec2::ZERO; uv.len()];
        let mut f = f64::INFINITY;
        for _ in 0..50 {
            next = uv.iter().zip(&d).map(|(p, d)| *p - *d * step).collect();
            f = energy(&list, &next, &mut h);
            if f <= e + 1e-4 * step * slope {
                break;
            }
            step *= 0.5;
        }
        if f >= e {
            if past.is_empty() {
                break;
            }
            past.clear();
            continue;
        }
        let s: Vec<DVec2> = next.iter().zip(&uv).map(|(n, p)| *n - *p).collect();
        let y: Vec<DVec2> = h.iter().zip(&g).map(|(n, p)| *n - *p).collect();
        if dot(&s, &y) > 1e-300 {
            past.push((s, y));
        }
        if past.len() > 20 {
            past.remove(0);
        }
        (uv, g, e) = (next, h, f);
    }
    e / 4.0 - 1.0
}
