//! An iso-surface of a volume and its sub-volumes as the host knows their voxels: edits included, a box told by its own samples.
//!
//! Reads the texels about a place once, so that whoever walks on the surface asks memory alone. Owns the trilinear field and the gradient
//! of "Direct Volume Editing" (2008), section 5: central differences at the centres of voxels, interpolated trilinearly. Texels are what
//! pictures are drawn from; the surface is that of the caster.

use crate::annotate::surface::Surface;
use crate::document::error::DocumentError;
use crate::document::state::State;
use crate::math::{Aabb, DAffine3, DMat3, DVec3};
use crate::volume::{TexelFormat, VolumeId};

/// Texels that are read about a place at most: 256 MB of them.
const MOST_TEXELS: u64 = 1 << 26;

/// Some texels of a volume.
#[derive(Debug)]
struct Block {
    index_from_world: DAffine3,
    /// Takes covectors of the index space to the world.
    world_from_gradient: DMat3,
    /// The first texel's index.
    lo: DVec3,
    size: [usize; 3],
    texels: Vec<f32>,
    /// The surface's value as a texel.
    iso: f64,
    codes_per_unit: f64,
    /// Where the volume tells what is there, continuous index.
    stands: Aabb,
}

/// A surface within some distance of a place.
#[derive(Debug)]
pub(crate) struct VoxelSurface {
    /// The finest first.
    blocks: Vec<Block>,
}

impl VoxelSurface {
    /// The surface at a value of a volume and of the sub-volumes that pictures show of it, as far as `reach_mm` from `centre`, world mm
    /// at rest.
    ///
    /// # Errors
    /// If there is no such volume, its source fails, or that is more than memory should hold.
    pub(crate) fn about(
        state: &State,
        root: VolumeId,
        value: f64,
        centre: DVec3,
        reach_mm: f64,
    ) -> Result<Self, DocumentError> {
        let mut family = state.with_sub_volumes(vec![root]);
        // Inner ones come after what they are cut out of.
        family.reverse();
        let blocks = family.into_iter().map(|id| block(state, id, id == root, value, centre, reach_mm));
        let blocks = blocks.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
        Ok(Self { blocks })
    }

    /// How far the field is above the surface's value at a place, world mm at rest, in the volume's unit. `None` outside.
    pub(crate) fn number(&self, p: DVec3) -> Option<f64> {
        let (block, q) = self.at(p)?;
        Some(block.value(q) / block.codes_per_unit).filter(|value| value.is_finite())
    }

    /// The same with its gradient, in the volume's unit per mm along the world's axes.
    pub(crate) fn number_and_slope(&self, p: DVec3) -> Option<(f64, DVec3)> {
        let (block, q) = self.at(p)?;
        let told = (block.value(q) / block.codes_per_unit, block.gradient(q) / block.codes_per_unit);
        Some(told).filter(|(value, slope)| value.is_finite() && slope.is_finite())
    }

    fn at(&self, p: DVec3) -> Option<(&Block, DVec3)> {
        self.blocks.iter().find_map(|block| {
            let q = block.index_from_world.transform_point3(p);
            let stands = q.cmpge(block.stands.min).all() && q.cmple(block.stands.max).all();
            stands.then_some((block, q))
        })
    }
}

fn block(
    state: &State,
    id: VolumeId,
    whole: bool,
    value: f64,
    centre: DVec3,
    reach_mm: f64,
) -> Result<Option<Block>, DocumentError> {
    let subject = state.at(Some(id))?;
    let grid = subject.grid();
    let index_from_world = grid.index_from_world();
    // A ball's box in index space: rows of the inverse say how far each index goes.
    let reach = DVec3::from_array(std::array::from_fn(|a| index_from_world.matrix3.row(a).length())) * reach_mm + 3.0;
    let middle = index_from_world.transform_point3(centre);
    let stands = if whole { grid.index_bounds() } else { grid.centre_bounds() };
    let (lo, hi) = ((middle - reach).max(stands.min - 3.0).floor(), (middle + reach).min(stands.max + 3.0).ceil());
    if !(hi.cmpgt(lo).all() && lo.is_finite() && hi.is_finite()) {
        return Ok(None);
    }
    let size: [u32; 3] = std::array::from_fn(|a| (hi[a] - lo[a]) as u32 + 1);
    if size.iter().map(|s| u64::from(*s)).product::<u64>() > MOST_TEXELS {
        let found = format!("{size:?} voxels within {reach_mm:.0} mm");
        return Err(DocumentError::invalid("size_mm", found, format!("a surface within {MOST_TEXELS} voxels")));
    }
    let field = &subject.volume.density;
    let bytes = field.read(0, std::array::from_fn(|a| lo[a] as i64), size)?;
    let texels = match field.format() {
        TexelFormat::R32Float => bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect(),
        _ => bytes.chunks_exact(2).map(|b| f32::from(u16::from_le_bytes([b[0], b[1]]))).collect(),
    };
    let map = field.map();
    Ok(Some(Block {
        index_from_world,
        world_from_gradient: index_from_world.matrix3.transpose(),
        lo,
        size: size.map(|s| s as usize),
        texels,
        iso: (value - map.lo) * map.codes_per_unit,
        codes_per_unit: map.codes_per_unit,
        // Beyond what was read nothing is known.
        stands: Aabb { min: stands.min.max(lo + 1.0), max: stands.max.min(hi - 1.0) },
    }))
}

impl Block {
    fn texel(&self, at: [usize; 3]) -> f64 {
        f64::from(self.texels[(at[2] * self.size[1] + at[1]) * self.size[0] + at[0]])
    }

    /// The cell's first texel and the place in it.
    fn cell(&self, q: DVec3) -> ([usize; 3], DVec3) {
        let p = q - self.lo;
        let at: [usize; 3] = std::array::from_fn(|a| (p[a].max(0.0) as usize).min(self.size[a] - 2));
        (at, p - DVec3::from_array(at.map(|i| i as f64)))
    }

    fn weights(part: DVec3) -> [f64; 8] {
        std::array::from_fn(|c| {
            let axis = |a: usize| if c >> a & 1 == 1 { part[a] } else { 1.0 - part[a] };
            axis(0) * axis(1) * axis(2)
        })
    }

    fn value(&self, q: DVec3) -> f64 {
        let (at, part) = self.cell(q);
        let corner = |c: usize| self.texel(std::array::from_fn(|a| at[a] + (c >> a & 1)));
        Self::weights(part).iter().enumerate().map(|(c, w)| w * corner(c)).sum::<f64>() - self.iso
    }

    fn gradient(&self, q: DVec3) -> DVec3 {
        let (at, part) = self.cell(q);
        let weights = Self::weights(part);
        let mut sum = DVec3::ZERO;
        for (c, weight) in weights.iter().enumerate() {
            let here: [usize; 3] = std::array::from_fn(|a| at[a] + (c >> a & 1));
            let slope = |a: usize| {
                let (mut before, mut after) = (here, here);
                before[a] = here[a].saturating_sub(1);
                after[a] = (here[a] + 1).min(self.size[a] - 1);
                (self.texel(after) - self.texel(before)) / (after[a] - before[a]).max(1) as f64
            };
            sum += DVec3::new(slope(0), slope(1), slope(2)) * *weight;
        }
        self.world_from_gradient * sum
    }
}

impl Surface for VoxelSurface {
    fn value(&self, p: DVec3) -> Option<f64> {
        let (block, q) = self.at(p)?;
        Some(block.value(q)).filter(|value| value.is_finite())
    }

    fn gradient(&self, p: DVec3) -> Option<DVec3> {
        let (block, q) = self.at(p)?;
        Some(block.gradient(q)).filter(|gradient| gradient.is_finite())
    }
}
