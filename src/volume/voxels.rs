//! Voxels in a source's own type.

use crate::volume::number::Number;
use crate::volume::voxel_type::VoxelType;
use serde::{Deserialize, Serialize};

/// A voxel type of Rust that a source may have.
pub trait Value: bytemuck::Pod + Send + Sync {
    /// Its name.
    const TYPE: VoxelType;
    /// The number; 64-bit integers beyond 2⁵³ lose their lowest bits.
    fn to_f64(self) -> f64;
    /// The nearest value of the type: integers round half away from zero and saturate, NaN becomes 0.
    fn from_f64(value: f64) -> Self;
    /// Wraps a vector of the type.
    fn wrap(values: Vec<Self>) -> Voxels;
}

/// Runs `$body` with `$v` bound to the typed vector of a [`Voxels`].
#[macro_export]
macro_rules! with_voxels {
    ($value:expr, $v:ident => $body:expr) => {
        match $value {
            $crate::volume::Voxels::U8($v) => $body,
            $crate::volume::Voxels::I8($v) => $body,
            $crate::volume::Voxels::U16($v) => $body,
            $crate::volume::Voxels::I16($v) => $body,
            $crate::volume::Voxels::U32($v) => $body,
            $crate::volume::Voxels::I32($v) => $body,
            $crate::volume::Voxels::U64($v) => $body,
            $crate::volume::Voxels::I64($v) => $body,
            $crate::volume::Voxels::F32($v) => $body,
            $crate::volume::Voxels::F64($v) => $body,
        }
    };
}

/// Runs `$body` with the type `$T` that a [`VoxelType`] names.
#[macro_export]
macro_rules! with_voxel_type {
    ($value:expr, $T:ident => $body:expr) => {
        match $value {
            $crate::volume::VoxelType::U8 => {
                type $T = u8;
                $body
            }
            $crate::volume::VoxelType::I8 => {
                type $T = i8;
                $body
            }
            $crate::volume::VoxelType::U16 => {
                type $T = u16;
                $body
            }
            $crate::volume::VoxelType::I16 => {
                type $T = i16;
                $body
            }
            $crate::volume::VoxelType::U32 => {
                type $T = u32;
                $body
            }
            $crate::volume::VoxelType::I32 => {
                type $T = i32;
                $body
            }
            $crate::volume::VoxelType::U64 => {
                type $T = u64;
                $body
            }
            $crate::volume::VoxelType::I64 => {
                type $T = i64;
                $body
            }
            $crate::volume::VoxelType::F32 => {
                type $T = f32;
                $body
            }
            $crate::volume::VoxelType::F64 => {
                type $T = f64;
                $body
            }
        }
    };
}

macro_rules! voxels {
    ($($variant:ident $ty:ty, $round:expr;)*) => {
        /// A block of voxels in their own type, x fastest.
        #[derive(Clone, Debug, PartialEq)]
        #[allow(missing_docs)]
        pub enum Voxels { $($variant(Vec<$ty>),)* }

        $(impl Value for $ty {
            const TYPE: VoxelType = VoxelType::$variant;
            fn to_f64(self) -> f64 { self as f64 }
            fn from_f64(value: f64) -> Self { let round: fn(f64) -> f64 = $round; round(value) as $ty }
            fn wrap(values: Vec<Self>) -> Voxels { Voxels::$variant(values) }
        })*
    };
}

voxels! {
    U8 u8, f64::round;
    I8 i8, f64::round;
    U16 u16, f64::round;
    I16 i16, f64::round;
    U32 u32, f64::round;
    I32 i32, f64::round;
    U64 u64, f64::round;
    I64 i64, f64::round;
    F32 f32, |x| x;
    F64 f64, |x| x;
}

impl Voxels {
    /// The type.
    pub fn voxel_type(&self) -> VoxelType {
        fn of<T: Value>(_: &[T]) -> VoxelType {
            T::TYPE
        }
        with_voxels!(self, v => of(v))
    }

    /// Number of voxels.
    pub fn len(&self) -> usize {
        with_voxels!(self, v => v.len())
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number at a position, before slope and intercept.
    pub fn get(&self, i: usize) -> f64 {
        with_voxels!(self, v => v[i].to_f64())
    }

    /// The voxels' bytes in this machine's order.
    pub fn as_bytes(&self) -> &[u8] {
        with_voxels!(self, v => bytemuck::cast_slice(v))
    }

    /// The voxels' bytes in this machine's order, for filling in place.
    pub fn as_bytes_mut(&mut self) -> &mut [u8] {
        with_voxels!(self, v => bytemuck::cast_slice_mut(v))
    }

    /// `len` zeros of a type; fails instead of aborting when memory is short.
    pub fn try_zeroed(ty: VoxelType, len: usize) -> Result<Self, std::collections::TryReserveError> {
        with_voxel_type!(ty, T => {
            let mut v: Vec<T> = Vec::new();
            v.try_reserve_exact(len)?;
            v.resize(len, bytemuck::Zeroable::zeroed());
            Ok(T::wrap(v))
        })
    }
}

/// What is true of all of a volume's values, after slope and intercept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// Smallest finite value; NaN if there is none.
    pub min: f64,
    /// Largest finite value; NaN if there is none.
    pub max: f64,
    /// Sum of all finite values.
    pub sum: f64,
    /// Number of voxels that are NaN.
    pub nan_count: u64,
    /// Number of voxels that are infinite.
    #[serde(default)]
    pub infinite_count: u64,
    /// Of 64-bit integers that nothing scales: smallest, largest and sum to the last digit, which `f64` has no room for.
    #[serde(default)]
    pub exact: Option<[i128; 3]>,
}

impl Statistics {
    /// Smallest, largest and sum as they are told.
    pub fn numbers(&self) -> [Number; 3] {
        match self.exact {
            Some(exact) => exact.map(Number::Whole),
            None => [self.min, self.max, self.sum].map(Number::Real),
        }
    }
}
