//! Boxes among what a ray meets, by the geometry of slabs in f64: opaque ones, and solids made of boxes that cut.

use super::reference::Pixel;
use burin::gpu::{CutMesh, Keeps, Layers, OpaqueMesh};
use burin::math::{Aabb, DVec3, Pose, Ray};
use burin::mesh::TriangleMesh;
use burin::volume::Lighting;
use std::sync::Arc;

/// An opaque box.
#[derive(Clone, Debug)]
pub struct OpaqueBox {
    pub id: u32,
    pub bounds: Aabb,
    pub pose: Pose,
    pub colour: [f32; 3],
    pub lighting: Option<Lighting>,
}

/// Boxes in one space, each turned inside out or not: a place is inside where they do not cancel.
#[derive(Clone, Debug)]
pub struct Solid {
    pub boxes: Vec<(Aabb, bool)>,
    pub pose: Pose,
}

/// What a frame's meshes are.
#[derive(Clone, Debug, Default)]
pub struct Boxes {
    pub opaque: Vec<OpaqueBox>,
    pub cuts: Vec<Solid>,
    /// A ball, in world mm, and the piece of every ray that is drawn.
    pub kept: Option<(DVec3, f64, Keeps)>,
}

/// Where a ray is inside a box, and the outward normals there, in the box's space.
fn slabs(bounds: &Aabb, ray: &Ray) -> Option<[(f64, DVec3); 2]> {
    let (mut entry, mut exit) = ((f64::NEG_INFINITY, DVec3::ZERO), (f64::INFINITY, DVec3::ZERO));
    for axis in 0..3 {
        let normal = [DVec3::X, DVec3::Y, DVec3::Z][axis];
        for (normal, at) in [(-normal, bounds.min[axis]), (normal, bounds.max[axis])] {
            let slope = normal.dot(ray.dir);
            let t = (at - ray.origin[axis]) / ray.dir[axis];
            if slope < 0.0 && t > entry.0 {
                entry = (t, normal);
            } else if slope > 0.0 && t < exit.0 {
                exit = (t, normal);
            } else if slope == 0.0 && (ray.origin[axis] - at) * normal[axis] > 0.0 {
                return None;
            }
        }
    }
    (entry.0 < exit.0).then_some([entry, exit])
}

impl Boxes {
    /// The nearest opaque face before the eye.
    pub fn nearest(&self, ray: &Ray) -> Option<Pixel> {
        let seen = self.opaque.iter().flat_map(|o| {
            let faces = slabs(&o.bounds, &o.pose.unapply_ray(ray)).into_iter().flatten();
            faces.filter(|f| f.0 >= 0.0).map(move |(t, normal)| (t, o, o.pose.rotation * normal))
        });
        let (t, o, normal) = seen.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let mut rgb = o.colour.map(f64::from);
        if let Some(l) = o.lighting {
            let c = normal.dot(ray.dir).abs();
            let white = f64::from(l.specular) * c.powf(f64::from(l.power));
            rgb = rgb.map(|x| x * (f64::from(l.ambient) + f64::from(l.diffuse) * c) + white);
        }
        Some(Pixel { colour: [rgb[0], rgb[1], rgb[2], 1.0], depth_mm: t, object: o.id + 1 })
    }

    /// The piece of a ray that is drawn, and the ball's outward normal where it begins at the ball.
    pub fn piece(&self, ray: &Ray) -> Option<(f64, f64, DVec3)> {
        let Some((centre, radius, keeps)) = self.kept else { return Some((0.0, f64::INFINITY, DVec3::ZERO)) };
        // |o + t·d|² = r²
        let o = ray.origin - centre;
        let (b, c) = (o.dot(ray.dir), o.dot(o) - radius * radius);
        let root = (b * b - c).sqrt();
        let met = root > 0.0 && -b + root > 0.0;
        let normal = |t: f64| if t > 0.0 { (ray.at(t) - centre) / radius } else { DVec3::ZERO };
        let ends = [(-b - root).max(0.0), -b + root];
        match (keeps, met) {
            (Keeps::Before, false) => Some((0.0, f64::INFINITY, DVec3::ZERO)),
            (Keeps::Before, true) => Some((0.0, ends[0], DVec3::ZERO)),
            (Keeps::Inside, true) => Some((ends[0], ends[1], normal(ends[0]))),
            (Keeps::Behind, true) => Some((ends[1], f64::INFINITY, normal(ends[1]))),
            (Keeps::Inside | Keeps::Behind, false) => None,
        }
    }

    /// Whether a place of a ray is cut away.
    fn cut(&self, ray: &Ray, t: f64) -> bool {
        self.cuts.iter().any(|solid| {
            let local = solid.pose.unapply_ray(ray);
            let winds = solid.boxes.iter().filter(|b| slabs(&b.0, &local).is_some_and(|[a, b]| a.0 <= t && t < b.0));
            winds.map(|b| if b.1 { -1 } else { 1 }).sum::<i32>() != 0
        })
    }

    /// What is left of an interval: from, to, and the outward normal of the face by which the ray comes in; `normal` is the
    /// interval's own.
    pub fn pieces(&self, ray: &Ray, (from, to): (f64, f64), normal: DVec3) -> Vec<(f64, f64, DVec3)> {
        let mut ends = vec![(from, normal)];
        for solid in &self.cuts {
            let local = solid.pose.unapply_ray(ray);
            let met = solid.boxes.iter().filter_map(|b| slabs(&b.0, &local)).flatten();
            ends.extend(met.filter(|f| f.0 > from && f.0 < to).map(|f| (f.0, solid.pose.rotation * f.1)));
        }
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut pieces: Vec<(f64, f64, DVec3)> = Vec::new();
        for (i, &(start, normal)) in ends.iter().enumerate() {
            let end = ends.get(i + 1).map_or(to, |e| e.0);
            if start >= end || self.cut(ray, 0.5 * (start + end)) {
                continue;
            }
            match pieces.last_mut() {
                Some(last) if last.1 == start => last.1 = end,
                _ => pieces.push((start, end, normal)),
            }
        }
        pieces
    }

    /// The same as meshes.
    pub fn meshes(&self) -> Layers {
        let opaque = self.opaque.iter().map(|o| OpaqueMesh {
            id: o.id,
            mesh: Arc::new(TriangleMesh::cuboid(&o.bounds)),
            pose: o.pose,
            colour: o.colour,
            lighting: o.lighting,
        });
        let cuts = self.cuts.iter().map(|s| CutMesh { id: 0, mesh: Arc::new(joined(&s.boxes)), pose: s.pose });
        Layers { opaque: opaque.collect(), cuts: cuts.collect(), ..Layers::default() }
    }
}

/// One mesh of many boxes.
fn joined(boxes: &[(Aabb, bool)]) -> TriangleMesh {
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for (bounds, inside_out) in boxes {
        let first = corners.len() as u32;
        let one = TriangleMesh::cuboid(bounds);
        corners.extend_from_slice(one.corners());
        triangles.extend(one.triangles().iter().map(|t| {
            let [a, b, c] = t.map(|i| i + first);
            if *inside_out { [a, c, b] } else { [a, b, c] }
        }));
    }
    TriangleMesh::new(corners, triangles).unwrap()
}
