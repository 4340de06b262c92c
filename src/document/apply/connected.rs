//! What is connected to where a stroke began, under the present opacity: 6-connected through voxels that the looks show at all.
//!
//! Bricks are judged when the fill comes to them, from the values at the stroke's start. Changes nothing.

use crate::document::Document;
use crate::document::error::DocumentError;
use crate::document::subject::Subject;
use crate::math::DVec3;
use crate::paint::{BrickBits, VoxelSet, connected};
use crate::volume::{BRICK, BRICK_VOXELS, Brick, BrickIndex, BrickKey, TexelFormat, VolumeId};
use std::collections::HashMap;

impl Document {
    /// The voxels that are connected to the shown voxel nearest to each of these places, world mm.
    ///
    /// # Errors
    /// If the source fails.
    pub(super) fn connected_to(&self, volume: VolumeId, places: &[DVec3]) -> Result<VoxelSet, DocumentError> {
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        let subject = state.at(Some(volume))?;
        let mut shown = Shown { subject: &subject, known: HashMap::new() };
        let mut starts = Vec::new();
        for place in places {
            starts.extend(shown.nearest(*place)?);
        }
        connected(subject.grid().dims, &starts, |brick| shown.bits(brick))
    }
}

/// Which voxels show.
struct Shown<'a> {
    subject: &'a Subject<'a>,
    /// Of density in codes, by label and code: 0 where it was not asked yet, 1 for what is hidden, 2 for what shows.
    known: HashMap<u16, Vec<u8>>,
}

impl Shown<'_> {
    /// Of the eight voxels about a place the nearest that shows.
    fn nearest(&mut self, place: DVec3) -> Result<Option<[u32; 3]>, DocumentError> {
        let grid = self.subject.grid();
        let base = grid.index_from_world().transform_point3(place).floor();
        let mut best: Option<(f64, [u32; 3])> = None;
        for corner in 0..8_u32 {
            let step = DVec3::new(f64::from(corner & 1), f64::from(corner >> 1 & 1), f64::from(corner >> 2));
            let at = (base + step).clamp(DVec3::ZERO, grid.dims_f64() - 1.0);
            let voxel = at.to_array().map(|v| v as u32);
            let far = grid.world_from_index.transform_point3(at).distance(place);
            if best.is_none_or(|(nearest, _)| far < nearest) {
                let (texel, label) = (self.subject.density.texel(voxel)?, self.subject.labels.value(voxel)? as u16);
                best = if self.shows(texel, label) { Some((far, voxel)) } else { best };
            }
        }
        Ok(best.map(|(_, voxel)| voxel))
    }

    /// A bit for every voxel of a brick.
    fn bits(&mut self, index: BrickIndex) -> Result<Box<BrickBits>, DocumentError> {
        let subject = self.subject;
        let (density, labels) = (&subject.density, &subject.labels);
        let mut bits: Box<BrickBits> = Box::new([0; BRICK_VOXELS / 32]);
        let (origin, size) = (index.origin(), density.valid(0, index));
        let key = BrickKey { level: 0, index };
        let uniform = match (density.brick(key)?, labels.brick(key)?) {
            (Brick::Uniform(value), Brick::Uniform(label)) => {
                Some(self.shows(value, u16::from_le_bytes([label[0], label[1]])))
            }
            _ => None,
        };
        if uniform == Some(false) {
            return Ok(bits);
        }
        let lo = origin.map(i64::from);
        let (values, ids) = match uniform {
            Some(_) => (Vec::new(), Vec::new()),
            None => (density.read(0, lo, size)?, labels.read(0, lo, size)?),
        };
        let bytes = density.format().bytes();
        let mut i = 0;
        for z in 0..size[2] {
            for y in 0..size[1] {
                let row = &mut bits[(y + BRICK * z) as usize];
                for x in 0..size[0] {
                    let open = uniform.unwrap_or_else(|| {
                        let texel = &values[i * bytes..][..bytes];
                        let label = u16::from_le_bytes([ids[2 * i], ids[2 * i + 1]]);
                        self.shows(std::array::from_fn(|b| texel.get(b).copied().unwrap_or(0)), label)
                    });
                    *row |= u32::from(open) << x;
                    i += 1;
                }
            }
        }
        Ok(bits)
    }

    fn shows(&mut self, texel: [u8; 4], label: u16) -> bool {
        let density = &self.subject.density;
        let ask = || self.subject.shows(f64::from(density.map().decode(texel) as f32), label);
        if density.format() != TexelFormat::R16Unorm {
            return ask();
        }
        let code = usize::from(u16::from_le_bytes([texel[0], texel[1]]));
        let known = &mut self.known.entry(label).or_insert_with(|| vec![0; 1 << 16])[code];
        if *known == 0 {
            *known = 1 + u8::from(ask());
        }
        *known == 2
    }
}
