//! Voxel volumes of analytic fields, and references written from their definitions.

use burin::annotate::surface::Surface;
use glam::{DVec3, USizeVec3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::collections::HashMap;

/// Values at voxel centres, voxel (i,j,k) at low + (i,j,k)·voxel_mm; trilinear between.
pub struct Voxels {
    pub low: DVec3,
    pub voxel_mm: f64,
    pub count: USizeVec3,
    pub values: Vec<f64>,
}

impl Voxels {
    pub fn of(low: DVec3, high: DVec3, voxel_mm: f64, field: impl Fn(DVec3) -> f64) -> Self {
        let count = ((high - low) / voxel_mm).ceil().as_usizevec3() + USizeVec3::ONE;
        let mut values = Vec::with_capacity(count.x * count.y * count.z);
        for k in 0..count.z {
            for j in 0..count.y {
                for i in 0..count.x {
                    values.push(field(low + DVec3::new(i as f64, j as f64, k as f64) * voxel_mm));
                }
            }
        }
        Self { low, voxel_mm, count, values }
    }

    fn voxel(&self, i: usize, j: usize, k: usize) -> f64 {
        self.values[i + self.count.x * (j + self.count.y * k)]
    }

    fn central(&self, i: usize, j: usize, k: usize) -> DVec3 {
        let d = |a: f64, b: f64, n: usize| (b - a) / (n as f64 * self.voxel_mm);
        let (i0, i1) = (i.saturating_sub(1), (i + 1).min(self.count.x - 1));
        let (j0, j1) = (j.saturating_sub(1), (j + 1).min(self.count.y - 1));
        let (k0, k1) = (k.saturating_sub(1), (k + 1).min(self.count.z - 1));
        DVec3::new(
            d(self.voxel(i0, j, k), self.voxel(i1, j, k), i1 - i0),
            d(self.voxel(i, j0, k), self.voxel(i, j1, k), j1 - j0),
            d(self.voxel(i, j, k0), self.voxel(i, j, k1), k1 - k0),
        )
    }

    fn around(&self, p: DVec3) -> Option<([usize; 3], [f64; 3])> {
        let q = (p - self.low) / self.voxel_mm;
        let most = (self.count - USizeVec3::ONE).as_dvec3();
        if !(q.cmpge(DVec3::ZERO).all() && q.cmple(most).all()) {
            return None;
        }
        let base = q.floor().min(most - DVec3::ONE);
        Some((base.as_usizevec3().to_array(), (q - base).to_array()))
    }
}

impl Surface for Voxels {
    fn value(&self, p: DVec3) -> Option<f64> {
        let ([i, j, k], [x, y, z]) = self.around(p)?;
        let mut sum = 0.0;
        for c in 0..8 {
            let (a, b, d) = (c & 1, c >> 1 & 1, c >> 2);
            let w = (if a == 1 { x } else { 1.0 - x })
                * (if b == 1 { y } else { 1.0 - y })
                * (if d == 1 { z } else { 1.0 - z });
            sum += w * self.voxel(i + a, j + b, k + d);
        }
        Some(sum)
    }

    fn gradient(&self, p: DVec3) -> Option<DVec3> {
        let ([i, j, k], [x, y, z]) = self.around(p)?;
        let mut sum = DVec3::ZERO;
        for c in 0..8 {
            let (a, b, d) = (c & 1, c >> 1 & 1, c >> 2);
            let w = (if a == 1 { x } else { 1.0 - x })
                * (if b == 1 { y } else { 1.0 - y })
                * (if d == 1 { z } else { 1.0 - z });
            sum += self.central(i + a, j + b, k + d) * w;
        }
        Some(sum)
    }
}

/// A sphere about the origin, voxels of 1 mm.
pub fn sphere(radius: f64) -> Voxels {
    let box_ = DVec3::splat(radius + 4.3);
    Voxels::of(-box_, box_, 1.0, |p| radius - p.length())
}

/// A cylinder about z.
pub fn cylinder(radius: f64, half: f64) -> Voxels {
    let box_ = DVec3::new(radius + 4.3, radius + 4.3, half);
    Voxels::of(-box_, box_, 1.0, |p| radius - p.truncate().length())
}

/// A torus about z.
pub fn torus(ring: f64, tube: f64) -> Voxels {
    let box_ = DVec3::new(ring + tube + 4.3, ring + tube + 4.3, tube + 4.3);
    Voxels::of(-box_, box_, 1.0, |p| tube - (p.truncate().length() - ring).hypot(p.z))
}

pub fn unit(rng: &mut ChaCha8Rng) -> DVec3 {
    loop {
        let v = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        if v.length() > 0.1 && v.length() < 1.0 {
            return v.normalize();
        }
    }
}

/// Brute force: every directed edge once, and its opposite once; no triangle names a corner twice or has no area.
pub fn is_closed(corners: &[DVec3], triangles: &[[u32; 3]]) -> Result<(), String> {
    let mut seen: HashMap<(u32, u32), u32> = HashMap::new();
    for &[a, b, c] in triangles {
        let [pa, pb, pc] = [a, b, c].map(|i| corners[i as usize]);
        if (pb - pa).cross(pc - pa).length() <= 1e-14 {
            return Err(format!("triangle {a} {b} {c} has no area"));
        }
        for e in [(a, b), (b, c), (c, a)] {
            *seen.entry(e).or_default() += 1;
        }
    }
    for (&(a, b), &n) in &seen {
        let back = seen.get(&(b, a)).copied().unwrap_or(0);
        if n != 1 || back != 1 {
            return Err(format!("edge {a}->{b} is there {n} times, its opposite {back} times"));
        }
    }
    Ok(())
}

/// Distance of a point from a triangle (Ericson 2005, 5.1.5).
pub fn distance_to_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return p.distance(a);
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return p.distance(b);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return p.distance(a + ab * (d1 / (d1 - d3)));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return p.distance(c);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return p.distance(a + ac * (d2 / (d2 - d6)));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return p.distance(b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))));
    }
    let n = ab.cross(ac).normalize();
    n.dot(ap).abs()
}

/// The winding by definition: signed crossings of a ray to infinity, +1 where it leaves through a counter-clockwise side. Another
/// direction is taken where a hit lies on an edge or the ray in a plane, to rounding.
pub fn winding_by_ray(corners: &[DVec3], triangles: &[[u32; 3]], p: DVec3, rng: &mut ChaCha8Rng) -> i32 {
    'again: for _ in 0..64 {
        let d = unit(rng);
        let mut sum = 0;
        for t in triangles {
            let [a, b, c] = t.map(|i| corners[i as usize]);
            let (e1, e2) = (b - a, c - a);
            let normal = e1.cross(e2);
            let det = d.dot(normal);
            let s = p - a;
            let span = normal.length();
            if det.abs() < 1e-9 * span {
                // Nearly in the plane: of no account only if it passes clear of the triangle.
                if s.dot(normal).abs() > 1e-6 * span {
                    continue;
                }
                continue 'again;
            }
            let t = -s.dot(normal) / det;
            let hit = s + d * t;
            let v = hit.cross(e2).dot(normal) / (span * span);
            let w = e1.cross(hit).dot(normal) / (span * span);
            let least = v.min(w).min(1.0 - v - w);
            if least.abs() < 1e-9 && t > -1e-6 {
                continue 'again;
            }
            if least > 0.0 && t > 0.0 {
                sum += if det > 0.0 { 1 } else { -1 };
            }
        }
        return sum;
    }
    panic!("no direction is clear");
}
