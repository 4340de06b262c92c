//! A value to its last bit: 64-bit integers do not fit into `f64`, and JSON has no word for infinity.
//!
//! Owns comparison without rounding, and how numbers are written: integers as integers, what is not finite as `"inf"`,
//! `"-inf"` and `"nan"`.

use crate::volume::voxel_type::VoxelType;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::cmp::Ordering;

/// A number to its last bit, of 64 bits. Equal numbers are equal in either form; NaN equals nothing.
#[derive(Clone, Copy, Debug)]
pub enum Number {
    /// An integer.
    Whole(i128),
    /// Any other.
    Real(f64),
}

impl Number {
    /// The nearest `f64`.
    pub fn to_f64(self) -> f64 {
        match self {
            Self::Whole(n) => n as f64,
            Self::Real(x) => x,
        }
    }

    /// Whether it is none at all.
    pub fn is_nan(self) -> bool {
        matches!(self, Self::Real(x) if x.is_nan())
    }

    /// As voxels of a type hold it, if they have a fraction: the nearest 32-bit float for these. Integers are left alone, since a
    /// number between two of them is neither.
    #[must_use]
    pub fn in_type(self, voxel_type: VoxelType) -> Self {
        match voxel_type {
            VoxelType::F32 => Self::Real(f64::from(self.to_f32())),
            VoxelType::F64 => Self::Real(self.to_f64()),
            _ => self,
        }
    }

    /// The nearest `f32`, rounded once.
    fn to_f32(self) -> f32 {
        match self {
            Self::Whole(n) => n as f32,
            Self::Real(x) => x as f32,
        }
    }
}

impl From<f64> for Number {
    fn from(value: f64) -> Self {
        Self::Real(value)
    }
}

impl PartialEq for Number {
    fn eq(&self, other: &Self) -> bool {
        self.partial_cmp(other) == Some(Ordering::Equal)
    }
}

impl PartialOrd for Number {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        match (*self, *other) {
            (Self::Whole(a), Self::Whole(b)) => Some(a.cmp(&b)),
            (Self::Real(a), Self::Real(b)) => a.partial_cmp(&b),
            (Self::Whole(a), Self::Real(b)) => compare(a, b),
            (Self::Real(a), Self::Whole(b)) => compare(b, a).map(Ordering::reverse),
        }
    }
}

/// An integer with a float, without rounding either.
fn compare(whole: i128, real: f64) -> Option<Ordering> {
    if real.is_nan() {
        return None;
    }
    // Beyond i128 the cast saturates, and no voxel is there.
    let (floor, fraction) = (real.floor() as i128, real - real.floor());
    Some(whole.cmp(&floor).then(if fraction > 0.0 { Ordering::Less } else { Ordering::Equal }))
}

impl std::fmt::Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Whole(n) => write!(f, "{n}"),
            Self::Real(x) => f.write_str(word(*x).map_or_else(|| x.to_string(), str::to_owned).as_str()),
        }
    }
}

/// The name of what is not finite.
fn word(x: f64) -> Option<&'static str> {
    match x {
        _ if x.is_nan() => Some("nan"),
        f64::INFINITY => Some("inf"),
        f64::NEG_INFINITY => Some("-inf"),
        _ => None,
    }
}

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match *self {
            Self::Whole(n) => match (i64::try_from(n), u64::try_from(n)) {
                (Ok(n), _) => serializer.serialize_i64(n),
                (_, Ok(n)) => serializer.serialize_u64(n),
                _ => serializer.serialize_f64(n as f64),
            },
            Self::Real(x) => match word(x) {
                Some(word) => serializer.serialize_str(word),
                None => serializer.serialize_f64(x),
            },
        }
    }
}

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Any;
        impl Visitor<'_> for Any {
            type Value = Number;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(r#"a number, "inf" or "-inf""#)
            }
            fn visit_i64<E: Error>(self, n: i64) -> Result<Number, E> {
                Ok(Number::Whole(n.into()))
            }
            fn visit_u64<E: Error>(self, n: u64) -> Result<Number, E> {
                Ok(Number::Whole(n.into()))
            }
            fn visit_f64<E: Error>(self, x: f64) -> Result<Number, E> {
                Ok(Number::Real(x))
            }
            fn visit_str<E: Error>(self, text: &str) -> Result<Number, E> {
                match text {
                    "inf" | "+inf" => Ok(Number::Real(f64::INFINITY)),
                    "-inf" => Ok(Number::Real(f64::NEG_INFINITY)),
                    "nan" => Ok(Number::Real(f64::NAN)),
                    _ => Err(E::invalid_value(serde::de::Unexpected::Str(text), &self)),
                }
            }
        }
        deserializer.deserialize_any(Any)
    }
}

impl JsonSchema for Number {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Number".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A number; integers are taken to the last digit",
            "anyOf": [{ "type": "number" }, { "enum": ["inf", "-inf", "nan"] }]
        })
    }
}
