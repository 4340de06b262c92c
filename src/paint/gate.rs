//! Which voxels a brush's range of values lets it paint.
//!
//! Told from the values themselves and in their own type, since texels round them: an end is a number as the source's voxels hold
//! it (0.1 is the 32-bit float nearest to it, an integer of 64 bits is itself), ends belong to the range, NaN never does. A
//! voxel that was painted counts by its value before the stroke, and an end then as its texel would hold it. Cost: that of the
//! slots asked for.

use crate::volume::{
    BrickIndex, DensityMap, Field, Number, SLOT, SLOT_VOXELS, SourceError, Value, Values, VoxelType, Voxels, is_plain,
};
use crate::with_voxels;

/// Words of a slot's bits.
pub const GATE_WORDS: usize = SLOT_VOXELS.div_ceil(32);

/// A range of values that may be painted, both ends inclusive, judged on the source's own numbers.
#[derive(Clone, Debug)]
pub struct Gate {
    /// For 64-bit integers that nothing scales: the integers within.
    whole: [i128; 2],
    /// For all other voxels that were not painted.
    own: [f64; 2],
    /// For those that were.
    painted: [f64; 2],
}

impl Gate {
    /// Of a closed range, over this density.
    pub fn new(range: [Number; 2], density: &Field) -> Self {
        let [lo, hi] = range;
        let own = match density.source() {
            Some(source) if is_plain(&**source) => range.map(|end| rounded(end, source.voxel_type())),
            Some(source) => range.map(|end| unscaled(end.to_f64(), source.voxel_type(), source.scaling())),
            None => range.map(|end| rounded(end, VoxelType::F32)),
        };
        Self { whole: [ceil(lo), floor(hi)], own, painted: range.map(|end| as_painted(end.to_f64(), density.map())) }
    }

    /// A bit for every texel of a slot of level 0, x fastest, set where the brush may paint; apron texels as the voxels that they
    /// repeat.
    ///
    /// # Errors
    /// If the source fails.
    pub fn slot(&self, density: &Field, index: BrickIndex) -> Result<Vec<u32>, SourceError> {
        let (origin, dims) = (index.origin(), density.dims(0));
        let lo = origin.map(|o| o.saturating_sub(1));
        let end: [u32; 3] = std::array::from_fn(|a| (origin[a] + SLOT - 1).min(dims[a]));
        let size: [u32; 3] = std::array::from_fn(|a| end[a] - lo[a]);
        let open = self.open(&density.values(lo, size)?);
        // From texels of the slot to voxels of the box.
        let places: [Vec<usize>; 3] = std::array::from_fn(|a| {
            let voxel = |t: u32| (origin[a] + t).saturating_sub(1).clamp(lo[a], end[a] - 1) - lo[a];
            (0..SLOT).map(|t| voxel(t) as usize).collect()
        });
        let [nx, ny, _] = size.map(|s| s as usize);
        let mut bits = vec![0_u32; GATE_WORDS];
        let mut texel = 0;
        for &z in &places[2] {
            for &y in &places[1] {
                let row = &open[nx * (y + ny * z)..][..nx];
                for &x in &places[0] {
                    bits[texel / 32] |= u32::from(row[x]) << (texel % 32);
                    texel += 1;
                }
            }
        }
        Ok(bits)
    }

    /// Whether each voxel of a box may be painted.
    fn open(&self, values: &Values) -> Vec<bool> {
        fn within<T: Value>(voxels: &[T], (slope, intercept): (f64, f64), [lo, hi]: [f64; 2]) -> Vec<bool> {
            voxels.iter().map(|v| v.to_f64() * slope + intercept).map(|v| lo <= v && v <= hi).collect()
        }
        let [first, last] = self.whole;
        let counted = |n: i128| first <= n && n <= last;
        let mut open = match &values.own {
            Voxels::U64(v) if values.scaling == (1.0, 0.0) => v.iter().map(|&n| counted(n.into())).collect(),
            Voxels::I64(v) if values.scaling == (1.0, 0.0) => v.iter().map(|&n| counted(n.into())).collect(),
            other => with_voxels!(other, v => within(v, values.scaling, self.own)),
        };
        let [lo, hi] = self.painted;
        for &(place, value) in &values.painted {
            open[place] = lo <= value && value <= hi;
        }
        open
    }
}

/// The least integer that is not below.
fn ceil(number: Number) -> i128 {
    match number {
        Number::Whole(n) => n,
        Number::Real(x) => x.ceil() as i128,
    }
}

/// The greatest integer that is not above.
fn floor(number: Number) -> i128 {
    match number {
        Number::Whole(n) => n,
        Number::Real(x) => x.floor() as i128,
    }
}

/// An end as voxels of the type hold it; itself where the type's numbers do not reach it.
fn rounded(end: Number, voxel_type: VoxelType) -> f64 {
    let near = end.in_type(voxel_type).to_f64();
    if near.is_finite() { near } else { end.to_f64() }
}

/// An end as the value of a stored voxel. Headers keep slopes in 32-bit floats, so that three steps of 0.1 are 0.300000004: an end that
/// is so near to the value of a stored integer means it.
fn unscaled(end: f64, voxel_type: VoxelType, (slope, intercept): (f64, f64)) -> f64 {
    let stored = (end - intercept) / slope;
    if !stored.is_finite() {
        return end;
    }
    let near = match voxel_type {
        VoxelType::F32 => f64::from(stored as f32),
        VoxelType::F64 => stored,
        _ => stored.round(),
    };
    // The slope's rounding, and that of the end as it was typed.
    let slack = if voxel_type.is_integer() {
        (1e-6 + near.abs() * f64::from(f32::EPSILON) + (intercept / slope).abs() * f64::from(f32::EPSILON)).min(0.25)
    } else {
        f64::INFINITY
    };
    let value = near * slope + intercept;
    if (stored - near).abs() <= slack && value.is_finite() { value } else { end }
}

/// An end as a painted voxel holds it; itself beyond the map's range.
fn as_painted(end: f64, map: &DensityMap) -> f64 {
    if !end.is_finite() {
        return end;
    }
    let near = map.decode(map.encode(end));
    if (near - end).abs() <= map.error_at(end, true) { near } else { end }
}
