//! The oracle: plain loops over all voxels, f64, from the equations as the brush's documentation states them.

use super::*;

/// What a voxel must hold: bytes, and whether rounding may decide otherwise (a hard rim or the ½ of a label within the
/// arithmetic's error).
pub struct Expected {
    pub texel: [u8; 4],
    pub doubtful: bool,
    /// Of a number in codes: what is rounded to the texel.
    code: Option<f64>,
}

/// Equal dabs that follow each other, with what does not depend on the voxel.
struct Laid {
    count: usize,
    gain: f64,
    centre: DVec3,
    index: DVec3,
    /// For a disc: axis across the layer and its normal.
    layer: Option<(usize, DVec3)>,
    radius: f64,
    /// Of an ellipsoid: the surface's normal.
    normal: DVec3,
}

impl Laid {
    fn new(grid: &Grid, brush: &Brush, dabs: &[Dab]) -> Self {
        let dab = &dabs[0];
        let m = grid.world_from_index;
        let layer = (brush.shape == Shape::Disc).then(|| {
            let [a, b, c] = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis];
            let normals = [b.cross(c).normalize(), c.cross(a).normalize(), a.cross(b).normalize()];
            let lean = |i: usize| normals[i].dot(dab.normal).abs();
            let axis = (0..3).max_by(|&i, &j| lean(i).total_cmp(&lean(j))).unwrap();
            (axis, normals[axis])
        });
        Self {
            count: dabs.len(),
            gain: f64::from(brush.strength) * f64::from(dab.pressure),
            centre: dab.centre,
            index: m.inverse().transform_point3(dab.centre),
            layer,
            normal: dab.normal,
            radius: dab.radius_mm,
        }
    }

    /// Equation 2: G, and whether the distance is too close to a hard rim for f32.
    fn g(&self, grid: &Grid, brush: &Brush, v: [u32; 3]) -> (f64, bool) {
        let at = DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]));
        if self.radius == 0.0 {
            return (if (self.index - at).abs().max_element() <= 0.5 { self.gain } else { 0.0 }, false);
        }
        let mut offset = grid.world_from_index.transform_point3(at) - self.centre;
        if let Some((axis, normal)) = self.layer {
            if (self.index[axis] - at[axis]).abs() > 0.5 {
                return (0.0, false);
            }
            offset -= normal * offset.dot(normal);
        }
        if brush.shape == Shape::Ellipsoid {
            let along = self.normal.dot(offset);
            offset += self.normal * (along / brush.ratio - along);
        }
        let x = offset.length() / self.radius;
        // Labels take part by distance, whatever the falloff.
        let falloff = if matches!(brush.target, Target::Label(_)) { Falloff::Hard } else { brush.falloff };
        let f = match falloff {
            _ if x > 1.0 => 0.0,
            Falloff::Hard => 1.0,
            Falloff::Linear => 1.0 - x,
            Falloff::Smooth => (1.0 - x * x).powi(2),
            Falloff::Gaussian => ((-4.5 * x * x).exp() - (-4.5_f64).exp()) / (1.0 - (-4.5_f64).exp()),
            Falloff::Curve(_) => drawn(x),
        };
        // Where F is not 0 at the rim, rounding decides who is inside.
        let ends = matches!(falloff, Falloff::Hard | Falloff::Curve(_));
        (self.gain * f, ends && (x - 1.0).abs() < 1e-6)
    }
}

fn coverage(grid: &Grid, brush: &Brush, dabs: &[Laid], v: [u32; 3]) -> (f64, bool) {
    let offset = matches!(brush.effective(), Operation::Add | Operation::Subtract);
    let (mut largest, mut rest, mut sum, mut doubtful) = (0.0_f64, 1.0, 0.0, false);
    for dab in dabs {
        let (g, doubt) = dab.g(grid, brush, v);
        largest = largest.max(g);
        rest *= (1.0 - g).powi(dab.count as i32);
        sum += g * dab.count as f64;
        doubtful |= doubt;
    }
    let cover = match (brush.tip, offset) {
        (Tip::Wash, _) => largest,
        (Tip::BuildUp, true) => sum,
        (Tip::BuildUp, false) => 1.0 - rest,
    };
    (cover, doubtful)
}

fn round(x: f64, top: f64) -> f64 {
    (x + 0.5).floor().clamp(0.0, top)
}

/// Equation 1 with its printed order of arguments where `printed` says so: lerp(C op P, P, G).
fn equation_1(p: f64, c: f64, op: Operation, back: f64, g: f64, printed: bool) -> f64 {
    let mixed = match op {
        Operation::Replace | Operation::Blend => c,
        Operation::Add => p + c,
        Operation::Subtract => p - c,
        Operation::Restore => back,
        other => unreachable!("{other:?} has an oracle of its own"),
    };
    if printed { mixed + g * (p - mixed) } else { p + g * (mixed - p) }
}

fn colour(p: [u8; 4], c: [f32; 4], op: Operation, g: f64) -> [u8; 4] {
    let p = p.map(|b| f64::from(b) / 255.0);
    let c = c.map(f64::from);
    let amount = |x: [f64; 4]| [x[0] * x[3], x[1] * x[3], x[2] * x[3], x[3]];
    let (from, brush) = (amount(p), amount(c));
    let straight = |x: [f64; 4]| -> [u8; 4] {
        let a = x[3].min(1.0);
        if round(a * 255.0, 255.0) == 0.0 {
            return [0; 4];
        }
        [x[0] / a, x[1] / a, x[2] / a, a].map(|v| round(v * 255.0, 255.0) as u8)
    };
    match op {
        Operation::Subtract => {
            let out: [f64; 4] = std::array::from_fn(|i| if i < 3 { p[i] - g * brush[i] } else { p[3] });
            if p[3] == 0.0 { [0; 4] } else { out.map(|v| round(v * 255.0, 255.0) as u8) }
        }
        Operation::Add => straight(std::array::from_fn(|i| from[i] + g * brush[i])),
        _ => {
            let to: [f64; 4] = match op {
                Operation::Replace => brush,
                Operation::Blend => std::array::from_fn(|i| brush[i] + from[i] * (1.0 - c[3])),
                _ => [0.0; 4],
            };
            straight(std::array::from_fn(|i| from[i] + g * (to[i] - from[i])))
        }
    }
}

/// All voxels of a field after a stroke.
pub fn stroke(canvas: &Canvas, brush: &Brush, dabs: &[Dab], printed: bool) -> Vec<Expected> {
    let field = canvas.field(brush.target.field());
    let map = *field.map();
    let bytes = field.format().bytes();
    let start = canvas.texels(field.kind());
    let density = canvas.texels(FieldKind::Density);
    let density_bytes = canvas.density.format().bytes();
    let pad = |t: &[u8]| -> [u8; 4] { std::array::from_fn(|i| t.get(i).copied().unwrap_or(0)) };
    let op = brush.effective();
    let laid: Vec<_> = dabs.chunk_by(|a, b| a == b).map(|d| Laid::new(&canvas.grid, brush, d)).collect();
    each(canvas.grid.dims, |v| v)
        .into_iter()
        .enumerate()
        .map(|(i, v)| {
            let old = pad(&start[i * bytes..(i + 1) * bytes]);
            let keep = Expected { texel: old, doubtful: false, code: None };
            if let Some([lo, hi]) = brush.range.map(|range| range.map(Number::to_f64)) {
                let value = canvas.density.map().decode(pad(&density[i * density_bytes..(i + 1) * density_bytes]));
                if !(lo <= value && value <= hi) {
                    return keep;
                }
            }
            let (g, doubtful) = coverage(&canvas.grid, brush, &laid, v);
            if g == 0.0 && !printed {
                return Expected { doubtful, ..keep };
            }
            let mut code = None;
            let texel = match brush.target {
                Target::Selection(c) => {
                    let p = f64::from(old[0]) / 255.0;
                    let value = equation_1(p, f64::from(c), op, 0.0, g, printed) * 255.0;
                    code = Some(value.clamp(0.0, 255.0));
                    [round(value, 255.0) as u8, 0, 0, 0]
                }
                Target::Density(c) => {
                    let p = map.decode(old);
                    let back = match op {
                        Operation::Restore => map.decode(pad(&canvas.base[i * bytes..(i + 1) * bytes])),
                        _ => p,
                    };
                    let mixes = !matches!(op, Operation::Add | Operation::Subtract);
                    if !p.is_finite() || !back.is_finite() {
                        let end = if op == Operation::Restore { back } else { c };
                        if mixes && g >= 1.0 { map.encode(end) } else { old }
                    } else {
                        let value = equation_1(p, c, op, back, g, printed);
                        let whole = map.format == TexelFormat::R16Unorm;
                        code = whole.then(|| ((value - map.lo) * map.codes_per_unit).clamp(0.0, 65_535.0));
                        map.encode(value)
                    }
                }
                Target::Colour(c) => colour(old, c, op, g),
                Target::Label(id) => {
                    let current = u16::from_le_bytes([old[0], old[1]]);
                    let locked = canvas.segments.get(current).is_some_and(|s| s.locked);
                    let new = match op {
                        _ if locked || g < 0.5 => current,
                        Operation::Replace | Operation::Blend | Operation::Add => id,
                        Operation::Subtract if current == id => 0,
                        Operation::Subtract => current,
                        Operation::Restore => 0,
                        other => unreachable!("{other:?} is none for labels"),
                    };
                    pad(&new.to_le_bytes())
                }
            };
            let label = matches!(brush.target, Target::Label(_));
            Expected { texel, doubtful: doubtful || (label && (g - 0.5).abs() < 1e-5), code }
        })
        .collect()
}

/// How far apart two texels are, in steps of the storage; floats in units of 2 ppm of the larger number involved.
pub fn steps(format: TexelFormat, a: [u8; 4], b: [u8; 4]) -> f64 {
    let code = |t: [u8; 4]| f64::from(u16::from_le_bytes([t[0], t[1]]));
    match format {
        TexelFormat::R16Unorm => (code(a) - code(b)).abs(),
        TexelFormat::R16Uint => {
            if a == b {
                0.0
            } else {
                f64::INFINITY
            }
        }
        TexelFormat::R8Unorm => f64::from(a[0].abs_diff(b[0])),
        // Paint of no more than one step of alpha has no hue to speak of.
        TexelFormat::Rgba8Unorm if a[3].max(b[3]) <= 1 => f64::from(a[3].abs_diff(b[3])),
        TexelFormat::Rgba8Unorm => (0..4).map(|i| f64::from(a[i].abs_diff(b[i]))).fold(0.0, f64::max),
        TexelFormat::R32Float => {
            let (x, y) = (f64::from(f32::from_le_bytes(a)), f64::from(f32::from_le_bytes(b)));
            if a == b || (x.is_nan() && y.is_nan()) {
                0.0
            } else {
                (x - y).abs() / (2e-6 * (x.abs().max(y.abs()) + 100.0))
            }
        }
    }
}

/// Asserts that texels are what the oracle expects, to one step: the kernel's f32 and the oracle's f64 differ by some 1e-6 of
/// the storage's range at most, so only a rounding that lies on the edge can fall to the other side. Of a few dabs a number is
/// rounded to the nearest code, but for those that weak strokes move where rounding would leave them.
pub fn check(what: &str, canvas: &Canvas, brush: &Brush, dabs: &[Dab], found: &[u8]) {
    let wrong = mismatches(canvas, brush, dabs, found, false);
    assert!(wrong.is_empty(), "{what}: {} voxels, first {:?}", wrong.len(), &wrong[..wrong.len().min(3)]);
}

/// Voxels that differ by more than a step: (index, found, expected).
pub fn mismatches(
    canvas: &Canvas,
    brush: &Brush,
    dabs: &[Dab],
    found: &[u8],
    printed: bool,
) -> Vec<(usize, [u8; 4], [u8; 4])> {
    let field = canvas.field(brush.target.field());
    let bytes = field.format().bytes();
    assert_eq!(found.len() as u64, canvas.grid.voxel_count() * bytes as u64);
    let expected = stroke(canvas, brush, dabs, printed);
    let pad = |t: &[u8]| -> [u8; 4] { std::array::from_fn(|i| t.get(i).copied().unwrap_or(0)) };
    let start = canvas.texels(field.kind());
    let number = |t: [u8; 4]| f64::from(u16::from_le_bytes([t[0], if bytes == 2 { t[1] } else { 0 }]));
    let nearest = |f: [u8; 4], old: [u8; 4], e: &Expected| {
        let Some(code) = e.code.filter(|_| dabs.len() < 100) else { return true };
        let moved = brush.ends() && e.texel == old && (number(f) - number(old)).abs() == 1.0;
        moved || (number(f) - code).abs() <= 0.52
    };
    found
        .chunks_exact(bytes)
        .map(pad)
        .zip(start.chunks_exact(bytes).map(pad))
        .zip(expected)
        .enumerate()
        .filter(|(_, ((f, old), e))| {
            !e.doubtful && (steps(field.format(), *f, e.texel) > 1.0 || !printed && !nearest(*f, *old, e))
        })
        .map(|(i, ((f, _), e))| (i, f, e.texel))
        .collect()
}
