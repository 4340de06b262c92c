//! Lines on a surface: rulers, arrows and the baselines of texts.
//!
//! Owns [`SurfacePath`], a polyline whose vertices lie on the iso-surface, with lengths, ticks and strips along it. Knows nothing of how
//! a path was found, nor of textures or pictures. Source: "Direct Volume Editing" (2008), section 5 (particles traced back to the surface).

use crate::annotate::path::strip::{Particle, SurfaceStrip, Tracing, lengths, outward, rows_across};
use crate::annotate::surface::{Surface, project};
use glam::DVec3;

/// The most ticks that one path may have.
pub const MAX_TICKS: usize = 1 << 16;

/// Points nearer to each other than this share of the tolerance are one.
const SAME: f64 = 1e-3;

/// A mark on a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tick {
    /// Length along the path, mm.
    pub along_mm: f64,
    /// On the surface, world mm.
    pub at: DVec3,
    /// Outward unit normal there.
    pub normal: DVec3,
    /// Unit tangent there, the way the path goes.
    pub tangent: DVec3,
}

/// A polyline on a surface, in world mm; two points or more, none on the one before it.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfacePath {
    points: Vec<DVec3>,
    normals: Vec<DVec3>,
    along_mm: Vec<f64>,
}

impl SurfacePath {
    /// Of points near the surface (world mm), each traced to it along the gradient there; points that fall on the one before them are
    /// left out. `None` if a point has no surface, or fewer than two are left.
    pub fn of_points(surface: &dyn Surface, points: &[DVec3], tracing: &Tracing) -> Option<Self> {
        let mut found: Vec<DVec3> = Vec::with_capacity(points.len());
        for &p in points {
            let at = project(surface, p, outward(surface, p)?, tracing.tolerance_mm)?;
            if found.last().is_none_or(|last| last.distance(at) > SAME * tracing.tolerance_mm) {
                found.push(at);
            }
        }
        let normals = found.iter().map(|&p| outward(surface, p)).collect::<Option<Vec<_>>>()?;
        let along_mm = lengths(&found);
        (found.len() > 1).then_some(Self { points: found, normals, along_mm })
    }

    /// The baseline through points on the surface as they were picked: the polyline at even steps of at most `tracing.step_mm`, laid on
    /// the surface. `None` as for [`of_points`](Self::of_points).
    pub fn through(surface: &dyn Surface, picked: &[DVec3], tracing: &Tracing) -> Option<Self> {
        let along = lengths(picked);
        let steps = (along.last()? / tracing.step_mm).ceil().max(1.0) as usize;
        Self::of_points(surface, &resampled(picked, steps + 1), tracing)
    }

    /// The same with both ends carried straight on over the surface by so many mm, 0 or more. `None` if it ends before.
    pub fn lengthened(&self, surface: &dyn Surface, before_mm: f64, after_mm: f64, tracing: &Tracing) -> Option<Self> {
        let last = self.points.len() - 1;
        let walk = |at: usize, toward: DVec3, length: f64| {
            let steps = (length / tracing.step_mm).ceil();
            let mut particle = Particle::at(surface, self.points[at], toward)?;
            let mut points = Vec::new();
            for _ in 0..steps as u64 {
                particle = particle.moved(surface, length / steps, tracing)?;
                points.push(particle.at);
            }
            Some(points)
        };
        let mut points = walk(0, -self.tangent(0), before_mm)?;
        points.reverse();
        points.extend(&self.points);
        points.extend(walk(last, self.tangent(last), after_mm)?);
        Self::of_points(surface, &points, tracing)
    }

    /// Vertices, world mm.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Outward unit normals at the vertices.
    pub fn normals(&self) -> &[DVec3] {
        &self.normals
    }

    /// Length up to each vertex, mm.
    pub fn along_mm(&self) -> &[f64] {
        &self.along_mm
    }

    /// Length of the whole, mm.
    pub fn length_mm(&self) -> f64 {
        self.along_mm.last().copied().unwrap_or(0.0)
    }

    /// The place `along_mm` from the path's beginning, held within it: on the surface where it can be traced there, else on the
    /// polyline. `None` if there is no gradient.
    pub fn at(&self, surface: &dyn Surface, along_mm: f64, tracing: &Tracing) -> Option<Tick> {
        let along_mm = along_mm.clamp(0.0, self.length_mm());
        let k = self.along_mm.partition_point(|&a| a <= along_mm).clamp(1, self.points.len() - 1);
        let share = (along_mm - self.along_mm[k - 1]) / (self.along_mm[k] - self.along_mm[k - 1]);
        let normal = self.normals[k - 1].lerp(self.normals[k], share).try_normalize()?;
        let chord = self.points[k - 1].lerp(self.points[k], share);
        let at = project(surface, chord, normal, tracing.tolerance_mm).unwrap_or(chord);
        let normal = outward(surface, at)?;
        let tangent =
            self.tangent(k - 1).lerp(self.tangent(k), share).reject_from_normalized(normal).try_normalize()?;
        Some(Tick { along_mm, at, normal, tangent })
    }

    /// Marks every `every_mm` from the path's beginning on, that one included. None if `every_mm` is not above 0 or would give more than
    /// [`MAX_TICKS`].
    pub fn ticks(&self, surface: &dyn Surface, every_mm: f64, tracing: &Tracing) -> Vec<Tick> {
        // A length that rounding leaves a hair below a whole number of ticks still gets the last one.
        let count = (self.length_mm() / every_mm * (1.0 + 1e-9)).floor();
        if !(every_mm > 0.0 && count < MAX_TICKS as f64) {
            return Vec::new();
        }
        (0..=count as usize).filter_map(|k| self.at(surface, k as f64 * every_mm, tracing)).collect()
    }

    /// A strip along the path with rows from `from_mm` to `to_mm` across it, positive to the left of the path seen from outside: N×T, the
    /// side on which letters stand that are read along it. Vertices that the surface does not have are `None`.
    pub fn strip(
        &self,
        surface: &dyn Surface,
        from_mm: f64,
        to_mm: f64,
        rows: usize,
        tracing: &Tracing,
    ) -> SurfaceStrip {
        let left: Vec<_> =
            (0..self.points.len()).map(|k| self.normals[k].cross(self.tangent(k)).try_normalize()).collect();
        let across = rows_across(from_mm, to_mm, rows);
        SurfaceStrip::beside(surface, &self.points, &left, self.along_mm.clone(), across, tracing)
    }

    /// Direction of the path at a vertex: between its neighbours. Zero where it turns back on itself.
    fn tangent(&self, k: usize) -> DVec3 {
        let last = self.points.len() - 1;
        (self.points[(k + 1).min(last)] - self.points[k.saturating_sub(1)]).normalize_or_zero()
    }
}

/// `count` points at even lengths along a polyline, its ends included; `count` is 2 or more.
pub(crate) fn resampled(line: &[DVec3], count: usize) -> Vec<DVec3> {
    let along = lengths(line);
    let total = along.last().copied().unwrap_or(0.0);
    let mut k = 1;
    let mut points = Vec::with_capacity(count);
    for i in 0..count {
        let goal = total * i as f64 / (count - 1) as f64;
        while k + 1 < line.len() && along[k] < goal {
            k += 1;
        }
        let piece = along.get(k).map_or(0.0, |end| end - along[k - 1]);
        let share = if piece > 0.0 { ((goal - along[k - 1]) / piece).clamp(0.0, 1.0) } else { 0.0 };
        points.push(if line.len() > 1 { line[k - 1].lerp(line[k], share) } else { line[0] });
    }
    points
}
