//! What the 3D view shows, as a grid of points in space: from it a stroke, a cut and the seams of parts are drawn on the surface that
//! is seen, at once and without asking the document.
//!
//! Places in the picture are shares of its width and height, so that they hold at every size. Knows no brush and no window.

use crate::explode::{Part, Poses};
use crate::gpu::ObjectId;
use crate::math::{Camera, DVec2, DVec3, Plane};

/// Most points along the picture's width and height: lines and tints need no more.
const MOST: [usize; 2] = [240, 180];

/// What is seen at a point of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// World mm, where it is now.
    pub world: DVec3,
    /// The body: a part's id, 0 for what is no part.
    pub body: u32,
}

/// A straight piece of a line, in shares of the picture.
pub type Piece = [DVec2; 2];

/// Points of the surface that the 3D view shows, in world mm, a grid of them over the picture.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    columns: usize,
    rows: usize,
    /// Of the first point, and from point to point.
    first: DVec2,
    step: DVec2,
    seen: Vec<Option<Seen>>,
}

impl Surface {
    /// From a picture: mm along each pixel's ray (infinite where nothing is), and body + 1 (0 where nothing is).
    pub fn new(camera: &Camera, size: [u32; 2], depth_mm: &[f32], object: &[ObjectId]) -> Self {
        let [w, h] = size.map(|s| s as usize);
        if w == 0 || h == 0 || depth_mm.len() < w * h || object.len() < w * h {
            return Self::default();
        }
        let stride = w.div_ceil(MOST[0]).max(h.div_ceil(MOST[1])).max(1);
        let (columns, rows) = (w.div_ceil(stride), h.div_ceil(stride));
        let whole = DVec2::new(w as f64, h as f64);
        let mut seen = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            for column in 0..columns {
                let [x, y] = [column * stride, row * stride];
                let i = x + w * y;
                let along = f64::from(depth_mm[i]);
                let body = object[i].body().filter(|_| along.is_finite());
                let px = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                seen.push(body.map(|body| Seen { world: camera.ray(px, size).at(along), body }));
            }
        }
        Self { columns, rows, first: DVec2::splat(0.5) / whole, step: DVec2::splat(stride as f64) / whole, seen }
    }

    /// The points, row by row; `None` where nothing is.
    pub fn seen(&self) -> &[Option<Seen>] {
        &self.seen
    }

    /// Borders between parts at rest on the surface; none where parts have moved, since there they are seen.
    pub fn seams(&self, parts: &[Part], poses: &Poses) -> Vec<Piece> {
        if parts.len() < 2 || !poses.at_rest(parts) {
            return Vec::new();
        }
        let inside = |part: &Part, at: DVec3| part.faces.iter().all(|f| f.plane.distance(at) <= 0.0);
        let mut last = 0;
        let holder = |seen: &Option<Seen>| {
            let at = seen.as_ref()?.world;
            // Neighbours mostly lie in one part.
            if !inside(&parts[last], at) {
                last = parts.iter().position(|p| inside(p, at))?;
            }
            Some(last)
        };
        let holders: Vec<Option<usize>> = self.seen.iter().map(holder).collect();
        let mut pieces = Vec::new();
        self.cells(|corners| {
            let mine = holders[corners[0]];
            let other = corners.iter().find(|&&i| holders[i] != mine);
            let (Some(mine), Some(&other)) = (mine, other) else { return };
            let Some(beyond) = self.seen[other] else { return };
            // The face that the other corner lies beyond is the border.
            let faces = parts[mine].faces.iter().map(|f| f.plane);
            let border = faces.max_by(|a, b| a.distance(beyond.world).total_cmp(&b.distance(beyond.world)));
            if let Some(border) = border {
                self.contour(corners, |i| self.seen[i].map(|s| border.distance(s.world)), &mut pieces);
            }
        });
        pieces
    }

    /// Where a plane, of the part at rest, cuts a part's surface. `slack` mm beyond the part's other faces still count.
    pub fn trace(&self, (parts, poses): (&[Part], &Poses), part: &Part, plane: &Plane, slack: f64) -> Vec<Piece> {
        let rest = poses.at_rest(parts);
        let distance = |i: usize| {
            let at = self.on((part, poses), rest, i)?;
            let inside = part.faces.iter().all(|f| f.plane.distance(at) <= slack);
            inside.then(|| plane.distance(at))
        };
        let values: Vec<Option<f64>> = (0..self.seen.len()).map(distance).collect();
        let mut pieces = Vec::new();
        self.cells(|corners| self.contour(corners, |i| values[i], &mut pieces));
        pieces
    }

    /// Where a part is seen on the inner side of a plane (of the part at rest), or all of it; as corners of boxes.
    pub fn side(&self, (parts, poses): (&[Part], &Poses), part: &Part, plane: Option<&Plane>) -> Vec<Piece> {
        let rest = poses.at_rest(parts);
        let wanted = |i: usize| {
            let Some(at) = self.on((part, poses), rest, i) else { return false };
            let inside = part.faces.iter().all(|f| f.plane.distance(at) <= 0.0);
            // A body of its own is its part wherever rounding puts its border.
            (inside || !rest) && plane.is_none_or(|plane| plane.distance(at) < 0.0)
        };
        self.boxes(wanted)
    }

    /// The boxes about all points that are wanted, one a run of neighbours in a row.
    pub fn boxes(&self, wanted: impl Fn(usize) -> bool) -> Vec<Piece> {
        let mut boxes = Vec::new();
        for row in 0..self.rows {
            let mut begun = None;
            for column in 0..=self.columns {
                let on = column < self.columns && wanted(column + self.columns * row);
                match (begun, on) {
                    (None, true) => begun = Some(column),
                    (Some(from), false) => {
                        let corner = |column: usize, row: usize| {
                            self.first + self.step * (DVec2::new(column as f64, row as f64) - 0.5)
                        };
                        boxes.push([corner(from, row), corner(column, row + 1)]);
                        begun = None;
                    }
                    _ => {}
                }
            }
        }
        boxes
    }

    /// The point on a part, at rest; `None` if another body is seen there.
    fn on(&self, (part, poses): (&Part, &Poses), at_rest: bool, i: usize) -> Option<DVec3> {
        let seen = self.seen[i]?;
        // Parts at rest are drawn as one body, which is in no part's name.
        match seen.body {
            body if body == part.id.0 => Some(poses.of(part).unapply(seen.world)),
            0 if at_rest => Some(seen.world),
            _ => None,
        }
    }

    fn cells(&self, mut each: impl FnMut([usize; 4])) {
        for row in 1..self.rows {
            for column in 1..self.columns {
                let i = column + self.columns * row;
                each([i - 1 - self.columns, i - self.columns, i, i - 1]);
            }
        }
    }

    /// The line through a cell's corners, in turn, where a value is 0; nothing if a corner has none.
    fn contour(&self, corners: [usize; 4], value: impl Fn(usize) -> Option<f64>, into: &mut Vec<Piece>) {
        let [Some(a), Some(b), Some(c), Some(d)] = corners.map(value) else { return };
        let values = [a, b, c, d];
        let mut ends = Vec::with_capacity(4);
        for i in 0..4 {
            let (here, next) = (values[i], values[(i + 1) % 4]);
            if (here < 0.0) != (next < 0.0) {
                let share = here / (here - next);
                ends.push(self.place(corners[i]).lerp(self.place(corners[(i + 1) % 4]), share));
            }
        }
        into.extend(ends.chunks_exact(2).map(|pair| [pair[0], pair[1]]));
    }

    fn place(&self, i: usize) -> DVec2 {
        let at = DVec2::new((i % self.columns) as f64, (i / self.columns) as f64);
        self.first + self.step * at
    }
}

/// Whether a point is within `radius` mm of the way from `a` to `b`.
pub fn near_way(at: DVec3, a: DVec3, b: DVec3, radius: f64) -> bool {
    let way = b - a;
    let share = if way == DVec3::ZERO { 0.0 } else { ((at - a).dot(way) / way.length_squared()).clamp(0.0, 1.0) };
    at.distance_squared(a + way * share) <= radius * radius
}
