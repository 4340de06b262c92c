//! Shapes as closed polygons: what glyphs, arrows and ticks are before they become distances.
//!
//! Owns flattening of curves and the few figures that drawings are made of. Lengths in mm, x to the right, y up; a point is inside where
//! the
//! winding number is not 0, so figures may overlap. Knows no texel.

use glam::{DAffine2, DVec2};

/// A rectangle along the axes, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    /// Left and lower corner.
    pub min: DVec2,
    /// Right and upper corner.
    pub max: DVec2,
}

impl Rect {
    /// Between two corners.
    pub fn new(min: DVec2, max: DVec2) -> Self {
        Self { min, max }
    }

    /// Width and height, mm.
    pub fn size(&self) -> DVec2 {
        self.max - self.min
    }

    /// The least rectangle around both.
    pub fn with(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Wider by so much on all four sides.
    pub fn grown(self, mm: f64) -> Self {
        Self { min: self.min - mm, max: self.max + mm }
    }
}

/// Closed polygons under the non-zero rule.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outline {
    /// Each one's corners in order; the last is joined to the first. mm, y up.
    pub contours: Vec<Vec<DVec2>>,
}

impl Outline {
    /// Nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// The least rectangle around all corners; none if there are none.
    pub fn bounds(&self) -> Option<Rect> {
        let mut points = self.contours.iter().flatten();
        let first = *points.next()?;
        Some(points.fold(Rect::new(first, first), |r, &p| r.with(Rect::new(p, p))))
    }

    /// One more polygon; counter-clockwise ones fill, clockwise ones inside them leave holes.
    pub fn add(&mut self, contour: Vec<DVec2>) {
        if contour.len() >= 3 {
            self.contours.push(contour);
        }
    }

    /// All of another.
    pub fn extend(&mut self, other: Self) {
        self.contours.extend(other.contours);
    }

    /// A filled rectangle between two corners.
    pub fn add_rect(&mut self, rect: Rect) {
        let Rect { min, max } = rect;
        self.add(vec![min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)]);
    }

    /// A hole of a filled rectangle.
    pub fn cut_rect(&mut self, rect: Rect) {
        let Rect { min, max } = rect;
        self.add(vec![min, DVec2::new(min.x, max.y), max, DVec2::new(max.x, min.y)]);
    }

    /// A filled disc, as the polygon of `sides` corners of the same area.
    pub fn add_disc(&mut self, centre: DVec2, radius: f64, sides: usize) {
        let n = sides.max(8);
        let step = std::f64::consts::TAU / n as f64;
        let corner = radius * (step / step.sin()).sqrt();
        self.add((0..n).map(|i| centre + corner * DVec2::from_angle(i as f64 * step)).collect());
    }

    /// Every corner moved by an affine map; one that mirrors keeps what is inside.
    pub fn mapped(&self, map: &DAffine2) -> Self {
        Self { contours: self.contours.iter().map(|c| c.iter().map(|&p| map.transform_point2(p)).collect()).collect() }
    }

    /// Every corner moved by `map`, after sides were divided to be no longer than `longest`: for maps that bend.
    pub fn bent(&self, longest: f64, map: impl Fn(DVec2) -> DVec2) -> Self {
        let bend = |contour: &Vec<DVec2>| {
            let mut out = Vec::with_capacity(contour.len() * 2);
            for (i, &a) in contour.iter().enumerate() {
                let b = contour[(i + 1) % contour.len()];
                let n = ((b - a).length() / longest).ceil().clamp(1.0, 4096.0) as usize;
                out.extend((0..n).map(|k| map(a.lerp(b, k as f64 / n as f64))));
            }
            out
        };
        Self { contours: self.contours.iter().map(bend).collect() }
    }
}

/// Corners of a curve's pieces, `from` left out and the end included; none is further than `tolerance` from the curve.
///
/// The chord of a piece is at most |B″|/(8 n²) off, with |B″| = 2|p0 − 2p1 + p2| for a parabola.
pub fn flatten_quadratic(from: DVec2, control: DVec2, to: DVec2, tolerance: f64, out: &mut Vec<DVec2>) {
    let n = pieces(2.0 * (from - 2.0 * control + to).length(), tolerance);
    out.extend((1..=n).map(|i| {
        let t = i as f64 / n as f64;
        from.lerp(control, t).lerp(control.lerp(to, t), t)
    }));
}

/// As [`flatten_quadratic`], with |B″| at most 6 times the greater second difference.
pub fn flatten_cubic(from: DVec2, controls: [DVec2; 2], to: DVec2, tolerance: f64, out: &mut Vec<DVec2>) {
    let [a, b] = controls;
    let n = pieces(6.0 * (from - 2.0 * a + b).length().max((a - 2.0 * b + to).length()), tolerance);
    out.extend((1..=n).map(|i| {
        let t = i as f64 / n as f64;
        let (p, q, r) = (from.lerp(a, t), a.lerp(b, t), b.lerp(to, t));
        p.lerp(q, t).lerp(q.lerp(r, t), t)
    }));
}

fn pieces(second_derivative: f64, tolerance: f64) -> usize {
    // Fonts of strangers may hold any number.
    (second_derivative / (8.0 * tolerance)).sqrt().ceil().clamp(1.0, 64.0) as usize
}
