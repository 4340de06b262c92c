//! How a brush weakens from its middle to its rim: F of Direct Volume Editing (2008), equation 2, in closed forms or as a curve that a
//! person drew.
//!
//! Owns the numbers of a drawn curve, few enough to go wherever a brush goes. x is distance over radius. Knows no dabs.

use crate::paint::error::PaintError;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

/// A voxel further from the centre than the radius by less than this share counts as lying on it, so that a voxel at exactly
/// the radius is inside however its distance is rounded (f64 here, f32 in the kernel, where lengths are in radii, so that the unit
/// of the grid decides nothing), and one that is outside by a millionth is outside.
pub const EDGE: f64 = 5e-7;

/// The most points of a drawn curve.
pub const CURVE_POINTS: usize = 12;

/// Points that are moved or added by hand keep so far from each other.
const GAP: f32 = 0.01;

/// F(d/radius): 1 at the centre unless it is drawn otherwise, 0 beyond the radius.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Falloff {
    /// 1 up to the radius (inclusive).
    Hard,
    /// 1 − x.
    Linear,
    /// (1 − x²)².
    Smooth,
    /// (e^(−4.5x²) − e^(−4.5)) / (1 − e^(−4.5)): a bell that is 0 at the radius.
    Gaussian,
    /// Straight between the points [x, F] of a curve: 2 to 12 of them, x from 0 at the centre to 1 at the radius and growing from
    /// point to point, F from 0 to 1.
    Curve(FalloffCurve),
}

/// The points of a drawn falloff.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<[f32; 2]>", into = "Vec<[f32; 2]>")]
pub struct FalloffCurve {
    count: usize,
    /// Behind the last one: zeros.
    points: [[f32; 2]; CURVE_POINTS],
}

impl FalloffCurve {
    /// A curve through these points [x, F].
    ///
    /// # Errors
    /// If there are fewer than 2 or more than 12 points, x does not grow from 0 to 1, or F is outside 0..1.
    pub fn new(points: &[[f32; 2]]) -> Result<Self, PaintError> {
        let wrong = |found: String, expected| PaintError::Brush { field: "falloff.curve", found, expected };
        if !(2..=CURVE_POINTS).contains(&points.len()) {
            return Err(wrong(format!("a curve of {} points", points.len()), "2 to 12 points [x, strength]"));
        }
        if let Some([x, f]) = points.iter().find(|p| !(0.0..=1.0).contains(&p[1]) || !p[0].is_finite()) {
            return Err(wrong(format!("[{x}, {f}]"), "points [x, strength] of numbers from 0 to 1"));
        }
        if let Some(pair) = points.windows(2).find(|pair| pair[0][0] >= pair[1][0]) {
            let found = format!("x = {} followed by x = {}", pair[0][0], pair[1][0]);
            return Err(wrong(found, "x that grows from point to point"));
        }
        let ends = [points[0][0], points[points.len() - 1][0]];
        if ends != [0.0, 1.0] {
            let found = format!("x from {} to {}", ends[0], ends[1]);
            return Err(wrong(found, "x from 0, the centre, to 1, the radius"));
        }
        let mut held = [[0.0; 2]; CURVE_POINTS];
        held[..points.len()].copy_from_slice(points);
        Ok(Self { count: points.len(), points: held })
    }

    /// What a falloff is at even distances, as a curve to go on from.
    pub fn of(falloff: Falloff) -> Self {
        const EVEN: usize = 5;
        if let Falloff::Curve(curve) = falloff {
            return curve;
        }
        let mut points = [[0.0; 2]; CURVE_POINTS];
        for (i, point) in points.iter_mut().take(EVEN).enumerate() {
            let x = i as f64 / (EVEN - 1) as f64;
            *point = [x as f32, falloff.at(x, 1.0) as f32];
        }
        Self { count: EVEN, points }
    }

    /// Its points [x, F], from the centre outward.
    pub fn points(&self) -> &[[f32; 2]] {
        &self.points[..self.count]
    }

    /// With a point moved by hand: between its neighbours, the ends up and down alone.
    #[must_use]
    pub fn moved(mut self, i: usize, [x, f]: [f32; 2]) -> Self {
        if i < self.count && f.is_finite() && x.is_finite() {
            let inner = i > 0 && i + 1 < self.count;
            let [lo, hi] = if inner { [self.points[i - 1][0] + GAP, self.points[i + 1][0] - GAP] } else { [0.0; 2] };
            let x = if inner && lo <= hi { x.clamp(lo, hi) } else { self.points[i][0] };
            self.points[i] = [x, f.clamp(0.0, 1.0)];
        }
        self
    }

    /// With one more point, unless one stands there or there are too many.
    #[must_use]
    pub fn with(mut self, [x, f]: [f32; 2]) -> Self {
        let free = self.points().iter().all(|p| (p[0] - x).abs() >= GAP) && f.is_finite();
        if free && x > 0.0 && x < 1.0 && self.count < CURVE_POINTS {
            let i = self.points().partition_point(|p| p[0] < x);
            self.points.copy_within(i..self.count, i + 1);
            self.points[i] = [x, f.clamp(0.0, 1.0)];
            self.count += 1;
        }
        self
    }

    /// Without a point; the ends stay.
    #[must_use]
    pub fn without(mut self, i: usize) -> Self {
        if i > 0 && i + 1 < self.count {
            self.points.copy_within(i + 1..self.count, i);
            self.count -= 1;
            self.points[self.count] = [0.0; 2];
        }
        self
    }

    /// F at x, 0..1.
    pub fn at(&self, x: f64) -> f64 {
        let points = self.points().iter().map(|p| p.map(f64::from));
        let mut pairs = points.clone().zip(points.skip(1));
        let pair = pairs.find(|(_, to)| x <= to[0]);
        pair.map_or(0.0, |([a, f], [b, g])| f + (g - f) * ((x - a) / (b - a)).max(0.0))
    }
}

impl TryFrom<Vec<[f32; 2]>> for FalloffCurve {
    type Error = PaintError;

    fn try_from(points: Vec<[f32; 2]>) -> Result<Self, PaintError> {
        Self::new(&points)
    }
}

impl From<FalloffCurve> for Vec<[f32; 2]> {
    fn from(curve: FalloffCurve) -> Self {
        curve.points().to_vec()
    }
}

impl JsonSchema for FalloffCurve {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "FalloffCurve".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Points [x, F], x growing from 0 to 1, F from 0 to 1",
            "type": "array",
            "minItems": 2,
            "maxItems": CURVE_POINTS,
            "items": {
                "type": "array",
                "items": { "type": "number", "minimum": 0, "maximum": 1 },
                "minItems": 2,
                "maxItems": 2
            }
        })
    }
}

impl Falloff {
    /// F: 0 beyond the radius; radius 0 counts at distance 0 only.
    pub fn at(self, distance_mm: f64, radius_mm: f64) -> f64 {
        if distance_mm > radius_mm * (1.0 + EDGE) {
            return 0.0;
        }
        let x = if radius_mm > 0.0 { (distance_mm / radius_mm).min(1.0) } else { 0.0 };
        match self {
            Self::Hard => 1.0,
            Self::Linear => 1.0 - x,
            Self::Smooth => (1.0 - x * x) * (1.0 - x * x),
            Self::Gaussian => ((-4.5 * x * x).exp() - GAUSSIAN_RIM) / (1.0 - GAUSSIAN_RIM),
            Self::Curve(curve) => curve.at(x),
        }
    }
}

/// e^(−4.5): what a Gaussian bell has left at the radius, which is taken from it.
const GAUSSIAN_RIM: f64 = 0.011_108_996_538_242_306;
