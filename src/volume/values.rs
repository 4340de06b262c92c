//! Values as they are: of what was not painted the source's own numbers, to the last bit; of what was, what its texels say.
//!
//! Texels round what a source holds (16-bit codes, 32-bit floats), and serve pictures and strokes. Whoever tells, compares or
//! writes values comes here.

use crate::volume::Voxels;
use crate::volume::brick::{BRICK, BrickIndex};
use crate::volume::field::{Field, FieldKind};
use crate::volume::grid::Grid;
use crate::volume::histogram::Measured;
use crate::volume::number::Number;
use crate::volume::source::{BrickSource, SourceError};
use crate::volume::voxel_type::VoxelType;
use std::sync::Arc;

/// A box of density.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// The source's voxels as stored, x fastest.
    pub own: Voxels,
    /// `value = slope · stored + intercept`.
    pub scaling: (f64, f64),
    /// (place in the box, value) of voxels that were painted, in order.
    pub painted: Vec<(usize, f64)>,
}

impl Field {
    /// The values of a box of density.
    ///
    /// # Errors
    /// If the source fails or the box is not inside the volume.
    pub fn values(&self, lo: [u32; 3], size: [u32; 3]) -> Result<Values, SourceError> {
        debug_assert_eq!(self.kind(), FieldKind::Density);
        let bytes = self.format().bytes();
        let texels = || self.read(0, lo.map(i64::from), size);
        let Some(source) = self.source() else {
            let of = |t: &[u8]| self.map().decode(std::array::from_fn(|i| t.get(i).copied().unwrap_or(0))) as f32;
            let own = Voxels::F32(texels()?.chunks_exact(bytes).map(of).collect());
            return Ok(Values { own, scaling: (1.0, 0.0), painted: Vec::new() });
        };
        let own = source.read(lo, size)?;
        let end: [u32; 3] = std::array::from_fn(|a| lo[a] + size[a]);
        let mut painted = Vec::new();
        // The box's bricks are asked, not all that were painted: whoever goes through the volume would pay for those each time.
        let [[x0, y0, z0], [x1, y1, z1]] = [lo.map(|v| v / BRICK), end.map(|v| v.div_ceil(BRICK))];
        let is_painted = |x, y, z| self.edit(BrickIndex([x, y, z])).is_some();
        if (z0..z1).any(|z| (y0..y1).any(|y| (x0..x1).any(|x| is_painted(x, y, z)))) {
            let mut base = Vec::with_capacity(own.len() * bytes);
            self.map().encode_voxels(&own, source.scaling(), &mut base);
            let texels = texels()?;
            for (i, (now, was)) in texels.chunks_exact(bytes).zip(base.chunks_exact(bytes)).enumerate() {
                if now != was {
                    let mut texel = [0; 4];
                    texel[..bytes].copy_from_slice(now);
                    painted.push((i, self.map().decode(texel)));
                }
            }
        }
        Ok(Values { own, scaling: source.scaling(), painted })
    }

    /// The value of a voxel of density.
    ///
    /// # Errors
    /// If the source fails or the voxel is outside.
    pub fn number(&self, voxel: [u32; 3]) -> Result<Number, SourceError> {
        let values = self.values(voxel, [1; 3])?;
        Ok(values.painted.first().map_or_else(|| values.unpainted(0), |&(_, value)| Number::Real(value)))
    }
}

/// The values of a density as they are now, as a source.
#[derive(Debug)]
struct AsPainted<'a> {
    density: &'a Field,
    source: &'a dyn BrickSource,
}

impl BrickSource for AsPainted<'_> {
    fn grid(&self) -> &Grid {
        self.source.grid()
    }

    fn voxel_type(&self) -> VoxelType {
        VoxelType::F64
    }

    fn scaling(&self) -> (f64, f64) {
        (1.0, 0.0)
    }

    fn name(&self) -> &str {
        self.source.name()
    }

    fn read(&self, lo: [u32; 3], size: [u32; 3]) -> Result<Voxels, SourceError> {
        let values = self.density.values(lo, size)?;
        let mut all = Vec::with_capacity(values.own.len());
        values.each(|_, number| all.push(number.to_f64()));
        Ok(Voxels::F64(all))
    }
}

impl Field {
    /// What `find` finds of density as it is now, painted values among it: once, until something is painted.
    ///
    /// # Errors
    /// Those of `find`.
    pub fn measured<E>(
        &self,
        source: &dyn BrickSource,
        find: impl FnOnce(&dyn BrickSource) -> Result<Measured, E>,
    ) -> Result<Arc<Measured>, E> {
        if let Some(known) = self.measured.get() {
            return Ok(known.clone());
        }
        let found = Arc::new(find(&AsPainted { density: self, source })?);
        Ok(self.measured.get_or_init(|| found).clone())
    }

    /// The same if it is known.
    pub fn known_measures(&self) -> Option<&Arc<Measured>> {
        self.measured.get()
    }
}

impl Values {
    /// The value of a place before any painting.
    pub fn unpainted(&self, place: usize) -> Number {
        own_number(&self.own, place, self.scaling)
    }

    /// Goes through all values in order.
    pub fn each(&self, mut visit: impl FnMut(usize, Number)) {
        let mut painted = self.painted.iter().peekable();
        for place in 0..self.own.len() {
            let number = match painted.next_if(|(at, _)| *at == place) {
                Some(&(_, value)) => Number::Real(value),
                None => self.unpainted(place),
            };
            visit(place, number);
        }
    }
}

/// The distance between neighbouring values of integer data.
pub(crate) fn unit(source: &dyn BrickSource) -> Option<f64> {
    let slope = source.scaling().0.abs();
    (source.voxel_type().is_integer() && slope > 0.0).then_some(slope)
}

/// Whether a source's stored numbers are its values.
pub(crate) fn is_plain(source: &dyn BrickSource) -> bool {
    source.scaling() == (1.0, 0.0)
}

/// The value of a stored voxel: itself where nothing scales it, else `slope · stored + intercept` in `f64`.
fn own_number(voxels: &Voxels, place: usize, (slope, intercept): (f64, f64)) -> Number {
    let plain = (slope, intercept) == (1.0, 0.0);
    match voxels {
        Voxels::U64(v) if plain => Number::Whole(v[place].into()),
        Voxels::I64(v) if plain => Number::Whole(v[place].into()),
        _ => {
            let stored = voxels.get(place);
            match (plain, voxels.voxel_type().is_integer()) {
                (true, true) => Number::Whole(stored as i128),
                (true, false) => Number::Real(stored),
                (false, _) => Number::Real(stored * slope + intercept),
            }
        }
    }
}
