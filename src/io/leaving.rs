//! A field on its way out: its numbers as a file has them.

use crate::io::error::IoError;
use crate::io::layout::to_native;
use crate::volume::BrickSource;
use crate::volume::Field;
use crate::volume::FieldKind;
use crate::volume::Grid;
use crate::volume::Segments;
use crate::volume::Value;
use crate::volume::Values;
use crate::volume::VoxelType;
use crate::volume::Voxels;
use crate::with_voxels;
use std::collections::BTreeMap;

/// How voxels are put into the file, where its name does not say it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// As they are.
    Raw,
    /// One gzip member.
    #[default]
    Gzip,
}

/// A field on its way out.
#[derive(Debug)]
pub(crate) struct Leaving<'a> {
    pub(crate) field: &'a Field,
    pub(crate) grid: &'a Grid,
    pub(crate) segments: &'a Segments,
    /// Type of the numbers in the file.
    pub(crate) voxel_type: VoxelType,
    /// Numbers a voxel.
    pub(crate) width: u32,
    /// `value = slope · stored + intercept` of the numbers in the file.
    pub(crate) scaling: (f64, f64),
    /// What the file has for the id of each segment.
    pub(crate) values: BTreeMap<u16, i128>,
}

impl Leaving<'_> {
    /// The bytes of planes `z` and on, little-endian, and how many of their voxels count as changed.
    pub(crate) fn slab(&self, z: u32, size: [u32; 3]) -> Result<(Vec<u8>, u64), IoError> {
        let (field, lo) = (self.field, [0, 0, z]);
        let texel_bytes = field.format().bytes();
        let (FieldKind::Density, Some(source)) = (field.kind(), field.source()) else {
            let texels = field.read(0, lo.map(i64::from), size)?;
            let changed = texels.chunks_exact(texel_bytes).filter(|t| t.iter().any(|&b| b != 0)).count();
            return Ok((self.labelled(texels), changed as u64));
        };
        let Values { own: mut voxels, painted, .. } = field.values(lo, size)?;
        with_voxels!(&mut voxels, v => take_edits(v, &painted, source.scaling()));
        let mut bytes = self.stored(&**source, voxels);
        to_native(&mut bytes, self.voxel_type.bytes(), false);
        Ok((bytes, painted.len() as u64))
    }

    /// A source's numbers as the file has them.
    pub(crate) fn stored(&self, source: &dyn BrickSource, voxels: Voxels) -> Vec<u8> {
        let (slope, intercept) = source.scaling();
        if self.scaling == (slope, intercept) {
            return voxels.as_bytes().to_vec();
        }
        let values: Vec<f64> = with_voxels!(&voxels, v => v.iter().map(|x| x.to_f64() * slope + intercept).collect());
        Voxels::F64(values).as_bytes().to_vec()
    }

    /// The texels, those of labels with the file's ids in place of ours.
    pub(crate) fn labelled(&self, texels: Vec<u8>) -> Vec<u8> {
        let bytes = self.voxel_type.bytes();
        if self.values.iter().all(|(&id, &value)| value == i128::from(id)) && bytes == 2
            || self.field.kind() != FieldKind::Labels
        {
            return texels;
        }
        let mut out = Vec::with_capacity(texels.len() / 2 * bytes);
        let mut last = (0_u16, [0; 16]);
        for texel in texels.chunks_exact(2) {
            let id = u16::from_le_bytes([texel[0], texel[1]]);
            if id != last.0 {
                let value = self.values.get(&id).copied().unwrap_or(i128::from(id));
                last = (id, value.to_le_bytes());
            }
            out.extend_from_slice(&last.1[..bytes]);
        }
        out
    }
}

/// Puts painted values in place of the source's numbers.
pub(crate) fn take_edits<T: Value>(voxels: &mut [T], painted: &[(usize, f64)], (slope, intercept): (f64, f64)) {
    for &(place, value) in painted {
        voxels[place] = T::from_f64((value - intercept) / slope);
    }
}

/// A format that fields can leave in.
pub(crate) struct Format {
    /// What people know it by.
    pub(crate) name: &'static str,
    /// What it holds or who reads it, a sentence without its stop.
    pub(crate) about: &'static str,
    /// How its files' names end, lower case, the usual one first.
    pub(crate) endings: &'static [&'static str],
    /// What an ending says of it; `None`: as it is asked for.
    pub(crate) compression: fn(&str) -> Option<Compression>,
    /// Whether it is for labels only.
    pub(crate) labels_only: bool,
    /// Whether it can say a slope and an intercept of these sizes.
    pub(crate) keeps: fn((f64, f64)) -> bool,
    /// All that comes before the voxels, which follow little-endian.
    pub(crate) header: fn(&Leaving<'_>, Compression) -> Vec<u8>,
}
