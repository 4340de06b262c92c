//! What a grid over an iso-surface is asked for by, and what it is. Plain data; knows no device.

use crate::gpu::device::constants::{MOST_CORRECTIONS, MOST_VOLUMES};
use crate::gpu::device::error::GpuError;
use crate::math::DVec3;
use crate::volume::VolumeId;

/// Steps that a particle goes at most.
const MOST_STEPS: u32 = 512;
/// Turns of all loops of one particle: software Vulkan ends them all after 65,535, silently.
const MOST_TURNS: u64 = 60_000;

/// How the particles of the grid's middle row go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heading {
    /// As straight as the surface lets them: by the direction of before (equation 5).
    Straight,
    /// Along a vector field, given by volumes of its components along the world's x, y and z; where it is zero, or where one of them has
    /// nothing, as straight as before.
    Vectors([VolumeId; 3]),
    /// Along a principal direction: at the centre that which the surface bends most or least in, from there on the nearer one. As straight
    /// as before where both are within 4 % of each other.
    Curvature(Bend),
}

/// Which of the principal directions, by the size of their curvature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bend {
    /// The surface bends most.
    Most,
    /// The surface bends least.
    Least,
}

/// A grid over an iso-surface.
#[derive(Clone, Debug, PartialEq)]
pub struct GridRequest {
    /// The volumes that tell density where they are, the finest first: boxes before what they are cut out of, and that last. Where several
    /// tell, the first does.
    pub family: Vec<VolumeId>,
    /// The iso-value, in the volumes' unit.
    pub iso: f64,
    /// The picked point, world mm: no further from the surface than two voxels or a step.
    pub centre: DVec3,
    /// The picked orientation, world mm, of any length: what the middle row begins along.
    pub along: DVec3,
    /// Distance of neighbours, mm.
    pub step_mm: f64,
    /// How far vertices may lie off the surface, mm; nothing finer than a 10,000th of a voxel is tried.
    pub tolerance_mm: f64,
    /// Steps along the middle row and across it, either way: 2n+1 by 2m+1 vertices of n and m, at most 512 each.
    pub steps: [u32; 2],
    /// How the middle row goes on.
    pub heading: Heading,
}

/// A point of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracedVertex {
    /// World mm.
    pub at: DVec3,
    /// Unit, toward lower values: against the trilinear interpolation of central differences at the centres of voxels.
    pub normal: DVec3,
}

/// A grid over an iso-surface. Seen from where normals point to, the second axis is to the left of the first: what lies on it is never
/// mirrored.
#[derive(Clone, Debug, PartialEq)]
pub struct TracedGrid {
    /// n and m.
    pub steps: [u32; 2],
    /// (2m+1)(2n+1) vertices, those along the middle row's direction on end; `None` where the surface had ended before.
    pub vertices: Vec<Option<TracedVertex>>,
}

impl TracedGrid {
    /// Vertices along and across.
    pub fn size(&self) -> [usize; 2] {
        self.steps.map(|n| 2 * n as usize + 1)
    }

    /// The vertex so many steps along and across from the centre; `None` beyond the grid, too.
    pub fn vertex(&self, along: i32, across: i32) -> Option<&TracedVertex> {
        let [n, m] = self.steps.map(i64::from);
        let (along, across) = (i64::from(along) + n, i64::from(across) + m);
        let is_inside = (0..=2 * n).contains(&along) && (0..=2 * m).contains(&across);
        let at = is_inside.then_some(across * (2 * n + 1) + along)?;
        self.vertices.get(at as usize)?.as_ref()
    }

    /// How many vertices are missing.
    pub fn trimmed(&self) -> usize {
        self.vertices.iter().filter(|vertex| vertex.is_none()).count()
    }
}

impl GridRequest {
    /// All volumes that are looked at, the family first.
    pub(crate) fn volumes(&self) -> Vec<VolumeId> {
        let vectors = match self.heading {
            Heading::Vectors(of) => of.to_vec(),
            Heading::Straight | Heading::Curvature(_) => Vec::new(),
        };
        self.family.iter().copied().chain(vectors).collect()
    }

    /// Whether it can be traced.
    pub(crate) fn check(&self) -> Result<(), GpuError> {
        let bad = |what, found: String, expected| Err(GpuError::BadGrid { what, found, expected });
        if !(self.step_mm > 0.0 && self.step_mm.is_finite()) {
            return Err(GpuError::BadStep { step_mm: self.step_mm });
        }
        if !(self.tolerance_mm > 0.0 && self.tolerance_mm.is_finite()) {
            return bad("tolerance_mm", self.tolerance_mm.to_string(), "a positive length");
        }
        if !self.centre.is_finite() || !self.iso.is_finite() {
            return bad("centre and iso", format!("{} and {}", self.centre, self.iso), "finite numbers");
        }
        if self.along.try_normalize().is_none() {
            return bad("along", self.along.to_string(), "a direction");
        }
        if self.family.is_empty() {
            return bad("family", "nothing".into(), "a volume");
        }
        let volumes = self.volumes().len();
        if volumes > MOST_VOLUMES as usize {
            return Err(GpuError::TooManyVolumes { volumes, most: MOST_VOLUMES as usize });
        }
        let (steps, most) = (self.steps[0].max(self.steps[1]), self.most_steps());
        if steps > most {
            return Err(GpuError::TooManySteps { steps, most, volumes: self.family.len() });
        }
        Ok(())
    }

    /// Steps of a particle whose loops all end.
    fn most_steps(&self) -> u32 {
        let looked = match self.heading {
            Heading::Curvature(_) => 7 * 4 + 1,
            Heading::Straight | Heading::Vectors(_) => 0,
        };
        // A correction is a look for who tells the place, and so are the taps of a gradient, of which there may be three a step.
        let each = u64::from(MOST_CORRECTIONS) + 1 + 7 * 3 + looked;
        let family = if self.family.len() > 1 { self.family.len() as u64 + 1 } else { 0 };
        (MOST_TURNS / (u64::from(MOST_CORRECTIONS) + 4 + each * family)).min(u64::from(MOST_STEPS)) as u32
    }
}
