//! Texel formats: the bytes that host, project and GPU share.

use crate::volume::Voxels;
use crate::volume::voxels::Value;
use crate::with_voxels;
use serde::{Deserialize, Serialize};

/// The format of a field's texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TexelFormat {
    /// Density as a 16-bit code of a [`DensityMap`].
    R16Unorm,
    /// Density as a 32-bit float in the volume's own unit; NaN is transparent.
    R32Float,
    /// Painted colour, display-referred; alpha is how much of it covers the transfer function's colour.
    Rgba8Unorm,
    /// Selection, degree of interest 0..1.
    R8Unorm,
    /// Label: id of a segment, 0 for none.
    R16Uint,
}

impl TexelFormat {
    /// Bytes of a texel.
    pub const fn bytes(self) -> usize {
        match self {
            Self::R8Unorm => 1,
            Self::R16Unorm | Self::R16Uint => 2,
            Self::R32Float | Self::Rgba8Unorm => 4,
        }
    }
}

/// How density values become texels.
///
/// `R16Unorm`: `code = round((value − lo) · codes_per_unit)`, clamped to 0..65535. Integer data spanning at most 65,535 has a
/// whole number of codes per unit, so that every integer is exact and what is left is fraction. `R32Float`: the same without
/// rounding, which is the value itself but for data beyond all 32-bit floats.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DensityMap {
    /// `R16Unorm` or `R32Float`.
    pub format: TexelFormat,
    /// Value of code 0.
    pub lo: f64,
    /// Codes per unit of value.
    pub codes_per_unit: f64,
}

impl DensityMap {
    /// Values as they are, in 32-bit float.
    pub const FLOAT: Self = Self { format: TexelFormat::R32Float, lo: 0.0, codes_per_unit: 1.0 };

    /// Floats for values of up to this size: as they are, or if 32 bits have no room for them by a power of two smaller.
    pub fn floats(largest: f64) -> Self {
        if largest <= f64::from(f32::MAX) || !largest.is_finite() {
            return Self::FLOAT;
        }
        Self { codes_per_unit: 2.0_f64.powi(100 - largest.log2().ceil() as i32), ..Self::FLOAT }
    }

    /// Floats of the same numbers: every code is one, so that what was held in codes is the same to the last digit, and there is no end.
    #[must_use]
    pub const fn in_floats(self) -> Self {
        Self { format: TexelFormat::R32Float, ..self }
    }

    /// 16-bit codes over `[min, max]`. `unit` is the distance between neighbouring values of integer data (its slope); with
    /// it integers map one to one as long as they span at most 65,535. `None`: data with a fraction, spread over all codes.
    pub fn codes(min: f64, max: f64, unit: Option<f64>) -> Self {
        // No less than leaves a number of codes per unit.
        let span = (max - min).max(1e-300);
        let codes_per_unit = match unit {
            Some(unit) if unit > 0.0 && max > min && span / unit <= 65_535.0 => {
                // A range may be narrower than the distance of two values.
                (65_535.0 / (span / unit).round().max(1.0)).floor() / unit
            }
            Some(unit) if unit > 0.0 && max <= min => 1.0 / unit,
            _ if max > min => 65_535.0 / span,
            _ => 1.0,
        };
        Self { format: TexelFormat::R16Unorm, lo: min, codes_per_unit }
    }

    /// The value of the texel that the GPU reads as 1.0 (`R16Unorm`), so that value = lo + texel · (hi − lo).
    pub fn hi(&self) -> f64 {
        self.lo + 65_535.0 / self.codes_per_unit
    }

    /// Half a step of 16-bit codes: the largest error of a value inside the range. 0 for floats, whose steps differ: see
    /// [`error_at`](Self::error_at).
    pub fn half_step(&self) -> f64 {
        match self.format {
            TexelFormat::R32Float => 0.0,
            _ => 0.5 / self.codes_per_unit,
        }
    }

    /// The most by which a value of this size that was painted may differ from what comes back of it: rounding to the texel and,
    /// in the kernel's 32 bits, on the way to it. Where source values lie between codes (`exact` is false) a voxel painted to
    /// within its own code cannot be told from an unpainted one: there it is twice as much.
    pub fn error_at(&self, value: f64, exact: bool) -> f64 {
        let size = value.abs();
        match self.format {
            TexelFormat::R32Float => {
                let [most, least] = [f32::MAX, f32::from_bits(1)].map(|v| f64::from(v) / self.codes_per_unit);
                size.min(most) * f64::from(f32::EPSILON) + least
            }
            _ => self.half_step() * if exact { 1.0 } else { 2.0 } * (1.0 + 1.0 / 64.0) + size * f64::EPSILON,
        }
    }

    /// Value to texel bytes.
    pub fn encode(&self, value: f64) -> [u8; 4] {
        match self.format {
            TexelFormat::R32Float => (((value - self.lo) * self.codes_per_unit) as f32).to_le_bytes(),
            _ => {
                let [a, b] = nearest_code((value - self.lo) * self.codes_per_unit).to_le_bytes();
                [a, b, 0, 0]
            }
        }
    }

    /// Texel bytes to value.
    pub fn decode(&self, texel: [u8; 4]) -> f64 {
        match self.format {
            TexelFormat::R32Float => self.lo + f64::from(f32::from_le_bytes(texel)) / self.codes_per_unit,
            _ => self.lo + f64::from(u16::from_le_bytes([texel[0], texel[1]])) / self.codes_per_unit,
        }
    }

    /// Stored voxels to texels, appended to `out`; `value = slope · stored + intercept`.
    pub fn encode_voxels(&self, voxels: &Voxels, (slope, intercept): (f64, f64), out: &mut Vec<u8>) {
        fn run<T: Value>(map: &DensityMap, v: &[T], slope: f64, intercept: f64, out: &mut Vec<u8>) {
            // Written in place: an iterator of single bytes costs several times as much.
            let start = out.len();
            out.resize(start + v.len() * map.format.bytes(), 0);
            match map.format {
                TexelFormat::R32Float => {
                    for (out, &x) in out[start..].chunks_exact_mut(4).zip(v) {
                        out.copy_from_slice(&map.encode(x.to_f64() * slope + intercept));
                    }
                }
                _ => {
                    let (scale, shift) = (slope * map.codes_per_unit, (intercept - map.lo) * map.codes_per_unit);
                    for (out, &x) in out[start..].chunks_exact_mut(2).zip(v) {
                        out.copy_from_slice(&nearest_code(x.to_f64() * scale + shift).to_le_bytes());
                    }
                }
            }
        }
        let (scale, shift) = (slope * self.codes_per_unit, (intercept - self.lo) * self.codes_per_unit);
        match voxels {
            _ if self.format == TexelFormat::R32Float => {}
            Voxels::U8(v) if whole_codes(v, scale, shift, out) => return,
            Voxels::I8(v) if whole_codes(v, scale, shift, out) => return,
            Voxels::U16(v) if whole_codes(v, scale, shift, out) => return,
            Voxels::I16(v) if whole_codes(v, scale, shift, out) => return,
            _ => {}
        }
        with_voxels!(voxels, v => run(self, v, slope, intercept, out));
    }
}

/// Appends the codes `scale · stored + shift` of short integers where both numbers are whole, as those of integer data are:
/// calculated in integers it is the same code, many at a time. Answers false, and appends nothing, where they are not, or so large
/// that the sum would not fit.
fn whole_codes<T: Copy + Into<i32>>(voxels: &[T], scale: f64, shift: f64, out: &mut Vec<u8>) -> bool {
    let largest = f64::from(1_u32 << (8 * size_of::<T>()));
    if scale.fract() != 0.0 || shift.fract() != 0.0 || scale.abs() * largest + shift.abs() >= f64::from(i32::MAX) {
        return false;
    }
    let (scale, shift) = (scale as i32, shift as i32);
    let start = out.len();
    out.resize(start + voxels.len() * 2, 0);
    for (out, &x) in out[start..].chunks_exact_mut(2).zip(voxels) {
        let code = (x.into() * scale + shift).clamp(0, 65_535);
        out.copy_from_slice(&(code as u16).to_le_bytes());
    }
    true
}

/// The nearest code, NaN being 0: of numbers that are not negative the cast cuts the fraction off, where `round` is a call.
fn nearest_code(code: f64) -> u16 {
    (code.clamp(0.0, 65_535.0) + 0.5) as u16
}
