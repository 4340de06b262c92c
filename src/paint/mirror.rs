//! Across what strokes are mirrored, so that they paint on both sides of a plane at once.
//!
//! Owns the planes that a brush may name. Knows volumes by their lattice alone; of parts only that a brush names a face by number,
//! which whoever knows parts turns into a plane.

use crate::math::{DVec3, Plane};
use crate::paint::error::PaintError;
use crate::volume::Grid;
use serde::{Deserialize, Serialize};

/// An axis of the voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum MirrorAxis {
    /// The first index.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

/// Across what strokes are mirrored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Mirror {
    /// They are not.
    #[default]
    Off,
    /// The plane through the volume's middle between its layers along this axis; of several volumes the first one's.
    Axis(MirrorAxis),
    /// The plane through three places, world mm.
    Points(#[schemars(with = "[[f64; 3]; 3]")] [DVec3; 3]),
    /// A plane, world mm.
    Plane(Plane),
    /// The plane in which a face of a part lies at rest. What is kept is the plane.
    Face {
        /// The part.
        part: u32,
        /// Number of the face in the part's list, from 0.
        face: usize,
    },
}

impl Mirror {
    /// Whether strokes are not mirrored.
    pub fn is_off(&self) -> bool {
        *self == Self::Off
    }

    /// The plane, on this lattice; `None` without one.
    pub fn plane(&self, grid: &Grid) -> Option<Plane> {
        match *self {
            Self::Off | Self::Face { .. } => None,
            Self::Plane(plane) => Some(plane),
            Self::Points([a, b, c]) => Plane::through(a, (b - a).cross(c - a)),
            Self::Axis(axis) => {
                let middle = grid.world_from_index.transform_point3((grid.dims_f64() - 1.0) * 0.5);
                Plane::through(middle, grid.index_from_world().matrix3.transpose().col(axis as usize))
            }
        }
    }

    /// # Errors
    /// If it is no plane.
    pub(crate) fn check(&self) -> Result<(), PaintError> {
        let wrong = |field, found: String, expected| Err(PaintError::Brush { field, found, expected });
        match *self {
            Self::Points(points) => {
                let [a, b, c] = points;
                let finite = points.iter().all(|p| p.is_finite());
                let area = (b - a).cross(c - a).length();
                let longest = (b - a).length().max((c - a).length());
                if !finite || area <= longest * longest * 1e-9 || !area.is_finite() {
                    let found = format!("{a}, {b}, {c}");
                    return wrong("mirror.points", found, "three places in mm that lie in no line");
                }
            }
            Self::Plane(plane) if !plane.offset.is_finite() || (plane.normal.length() - 1.0).abs().is_nan() => {
                return wrong("mirror.plane", format!("{plane:?}"), "a normal and an offset of finite numbers");
            }
            Self::Plane(plane) if (plane.normal.length() - 1.0).abs() > 1e-6 => {
                return wrong("mirror.plane.normal", plane.normal.to_string(), "a direction of length 1");
            }
            _ => {}
        }
        Ok(())
    }
}
