//! The number types that voxels have in files.

use serde::Deserialize;
use serde::Serialize;

/// The numeric type of a source's voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs)]
pub enum VoxelType {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

impl VoxelType {
    /// Size of a voxel.
    pub const fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// Whether the type has no fraction.
    pub const fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// The least and the greatest value of an integer type.
    pub const fn limits(self) -> Option<[f64; 2]> {
        match self {
            Self::U8 => Some([0.0, u8::MAX as f64]),
            Self::I8 => Some([i8::MIN as f64, i8::MAX as f64]),
            Self::U16 => Some([0.0, u16::MAX as f64]),
            Self::I16 => Some([i16::MIN as f64, i16::MAX as f64]),
            Self::U32 => Some([0.0, u32::MAX as f64]),
            Self::I32 => Some([i32::MIN as f64, i32::MAX as f64]),
            Self::U64 => Some([0.0, u64::MAX as f64]),
            Self::I64 => Some([i64::MIN as f64, i64::MAX as f64]),
            Self::F32 | Self::F64 => None,
        }
    }

    /// What stands for all there is of a colour's part: the greatest integer, or 1.
    pub fn full(self) -> f64 {
        self.limits().map_or(1.0, |[_, greatest]| greatest)
    }

    /// The name that `burin info` prints.
    pub const fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::U64 => "u64",
            Self::I64 => "i64",
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }
}
