//! The free-boundary symmetric Dirichlet problem on a lattice's triangles.
//!
//! Given a patch in space, its flat image of least |F|² + |F⁻¹|², averaged over the patch's area (Smith and Schaefer 2015), sought by
//! Newton steps on the projected Hessian (the eigensystem of Smith, de Goes and Kim 2019) that never turn a triangle over. Lengths
//! are in units of the lattice's spacing. It owns the flat image and the energy on it; it knows no surface.

use crate::annotate::relaxing::banded::Banded;
use glam::{DMat2, DVec2, DVec3};

/// A triangle of the patch.
struct Rest {
    vertices: [usize; 3],
    /// F = Σ uv_k ⊗ shape_k.
    shapes: [DVec2; 3],
    area: f64,
}

/// A patch, laid flat.
pub(crate) struct Flat {
    columns: usize,
    rests: Vec<Rest>,
    /// The flat image, in spacings; where there is no vertex, what it was at the start.
    pub(crate) uv: Vec<DVec2>,
}

/// A factorised Hessian, for steps from near where it was taken.
#[derive(Default)]
pub(crate) struct Factor {
    matrix: Banded,
    /// False if the matrix is of another patch, or too far away.
    pub(crate) holds: bool,
}

impl Flat {
    /// The patch of `triangles` between `points` (in spacings), whose flat image is `uv` at the start. Vertices are those of a lattice of
    /// `columns` columns, row by row.
    pub(crate) fn new(columns: usize, points: &[DVec3], triangles: &[[usize; 3]], uv: Vec<DVec2>) -> Self {
        let rests = triangles.iter().map(|&vertices| {
            let [a, b, c] = vertices.map(|vertex| points[vertex]);
            let (p, q) = (b - a, c - a);
            // Slivers are taken as a thousandth of a square wide, so that none divides by zero.
            let length = p.length().max(1e-3);
            let along = p / length;
            let (x, y) = (q.dot(along), (q - along * q.dot(along)).length().max(1e-3));
            // The inverse of the columns (length, 0) and (x, y).
            let second = DVec2::new(1.0 / length, -x / (length * y));
            let third = DVec2::new(0.0, 1.0 / y);
            Rest { vertices, shapes: [-second - third, second, third], area: 0.5 * length * y }
        });
        Self { columns, rests: rests.collect(), uv }
    }

    /// The sum of |F|² + |F⁻¹|² times area over the patch; infinite if a triangle is turned over.
    fn sum(&self, uv: &[DVec2]) -> f64 {
        let mut sum = 0.0;
        for rest in &self.rests {
            let f = rest.map(uv);
            let det = f.determinant();
            if det <= 0.0 {
                return f64::INFINITY;
            }
            sum += rest.area * square(f) * (1.0 + 1.0 / (det * det));
        }
        sum
    }

    /// One Newton step, on the Hessian of `factor` if that holds, else on its own, which it leaves there. Returns the largest move of a
    /// vertex, in spacings.
    pub(crate) fn step(&mut self, factor: &mut Factor) -> f64 {
        let mut gradient = vec![0.0; 2 * self.uv.len()];
        for rest in &self.rests {
            let f = rest.map(&self.uv);
            let det = f.determinant();
            let cofactor = DMat2::from_cols(DVec2::new(f.y_axis.y, -f.y_axis.x), DVec2::new(-f.x_axis.y, f.x_axis.x));
            let stress =
                (f * (1.0 + 1.0 / (det * det)) - cofactor * (square(f) / (det * det * det))) * (2.0 * rest.area);
            for (&vertex, &shape) in rest.vertices.iter().zip(&rest.shapes) {
                let force = stress * shape;
                gradient[2 * vertex] += force.x;
                gradient[2 * vertex + 1] += force.y;
            }
        }
        if !factor.holds {
            factor.holds = self.factorise(factor);
        }
        if !factor.holds {
            return 0.0;
        }
        let mut change: Vec<f32> = gradient.iter().map(|&force| force as f32).collect();
        factor.matrix.solve(&mut change);
        let slope: f64 = -change.iter().zip(&gradient).map(|(&x, &y)| f64::from(x) * y).sum::<f64>();
        let change: Vec<DVec2> =
            change.chunks_exact(2).map(|pair| -DVec2::new(pair[0].into(), pair[1].into())).collect();
        let before = self.sum(&self.uv);
        let mut share = 1.0_f64.min(0.9 * self.most_share(&change));
        for _ in 0..20 {
            let moved: Vec<DVec2> = self.uv.iter().zip(&change).map(|(&at, &by)| at + by * share).collect();
            if self.sum(&moved) <= before + 1e-4 * share * slope {
                self.uv = moved;
                return share * change.iter().map(|by| by.length()).fold(0.0, f64::max);
            }
            share *= 0.5;
        }
        0.0
    }

    /// The share of `change` at which the first triangle has no area left; infinite if none has.
    fn most_share(&self, change: &[DVec2]) -> f64 {
        let mut most = f64::INFINITY;
        for rest in &self.rests {
            let (f, by) = (rest.map(&self.uv), rest.map(change));
            // det(F + t·D) = a t² + b t + c.
            let a = by.determinant();
            let b = f.x_axis.perp_dot(by.y_axis) + by.x_axis.perp_dot(f.y_axis);
            let c = f.determinant();
            let inner = b * b - 4.0 * a * c;
            if inner < 0.0 {
                continue;
            }
            let q = -0.5 * (b + inner.sqrt().copysign(b));
            for root in [q / a, c / q] {
                if root > 0.0 && root < most {
                    most = root;
                }
            }
        }
        most
    }

    fn factorise(&self, factor: &mut Factor) -> bool {
        // The flat image may move and turn as a whole, which costs nothing: the shift keeps the matrix from being singular.
        [1e-5, 1e-3].into_iter().any(|shift| {
            self.assemble(&mut factor.matrix, shift);
            factor.matrix.factorise()
        })
    }

    fn assemble(&self, matrix: &mut Banded, shift: f64) {
        matrix.clear(2 * self.uv.len(), 2 * self.columns + 1);
        let mut trace = 0.0;
        for rest in &self.rests {
            // All in one triangle first, since most of the time would go into finding places in the matrix.
            let mut local = [[[0.0; 4]; 3]; 3];
            for (weight, mode) in modes(rest.map(&self.uv)) {
                let reach = rest.shapes.map(|shape| mode * shape);
                for (k, row) in local.iter_mut().enumerate() {
                    let scaled = reach[k] * (weight * rest.area);
                    for (l, entry) in row.iter_mut().enumerate() {
                        let other = reach[l];
                        for (sum, term) in entry.iter_mut().zip([
                            scaled.x * other.x,
                            scaled.x * other.y,
                            scaled.y * other.x,
                            scaled.y * other.y,
                        ]) {
                            *sum += term;
                        }
                    }
                    trace += scaled.dot(reach[k]);
                }
            }
            for (k, &row) in rest.vertices.iter().enumerate() {
                for (l, &column) in rest.vertices.iter().enumerate() {
                    if column > row {
                        continue;
                    }
                    let [xx, xy, yx, yy] = local[k][l].map(|value| value as f32);
                    matrix.add(2 * row, 2 * column, xx);
                    matrix.add(2 * row + 1, 2 * column, yx);
                    matrix.add(2 * row + 1, 2 * column + 1, yy);
                    if column < row {
                        matrix.add(2 * row, 2 * column + 1, xy);
                    }
                }
            }
        }
        matrix.shift((shift * trace / self.uv.len() as f64) as f32 + f32::MIN_POSITIVE);
    }
}

impl Rest {
    fn map(&self, uv: &[DVec2]) -> DMat2 {
        let mut columns = [DVec2::ZERO; 2];
        for (&vertex, shape) in self.vertices.iter().zip(&self.shapes) {
            columns[0] += uv[vertex] * shape.x;
            columns[1] += uv[vertex] * shape.y;
        }
        DMat2::from_cols(columns[0], columns[1])
    }
}

fn square(f: DMat2) -> f64 {
    f.x_axis.length_squared() + f.y_axis.length_squared()
}

/// Eigenvalues (those below zero as zero) and eigenmatrices of the Hessian of |F|² + |F⁻¹|² at F, det F > 0.
fn modes(f: DMat2) -> [(f64, DMat2); 4] {
    // F = R(a) · diag(s, t) · R(b), s ≥ t.
    let (e, h) = (0.5 * (f.x_axis.x + f.y_axis.y), 0.5 * (f.x_axis.x - f.y_axis.y));
    let (g, k) = (0.5 * (f.x_axis.y + f.y_axis.x), 0.5 * (f.x_axis.y - f.y_axis.x));
    let (q, r) = (e.hypot(k), h.hypot(g));
    let (s, t) = (q + r, (q - r).max(1e-9));
    let (sum, difference) = (k.atan2(e), g.atan2(h));
    let u = DMat2::from_angle(0.5 * (sum + difference));
    let v = DMat2::from_angle(0.5 * (sum - difference));
    let mode = |m: [f64; 4]| u * DMat2::from_cols_array(&m) * v;
    let half = 0.5_f64.sqrt();
    let cube = (s * t).powi(3);
    [
        (2.0 + 6.0 / s.powi(4), mode([1.0, 0.0, 0.0, 0.0])),
        (2.0 + 6.0 / t.powi(4), mode([0.0, 0.0, 0.0, 1.0])),
        (2.0 + 2.0 * (s * s + s * t + t * t) / cube, mode([0.0, half, half, 0.0])),
        ((2.0 - 2.0 * (s * s - s * t + t * t) / cube).max(0.0), mode([0.0, half, -half, 0.0])),
    ]
}
