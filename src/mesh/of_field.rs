//! Closed surfaces of fields at their own resolution: where the selection is a half, and about the voxels of a label.
//!
//! What lies beyond the volume is outside, so surfaces are closed at its border too. The selection's is the level set of the field
//! between its voxels; a label's goes along the faces of its voxels, made smooth (`smooth`). Voxels of a label that meet at an edge or a
//! corner alone do not touch.

use crate::math::{DAffine3, DVec3};
use crate::mesh::TriangleMesh;
use crate::mesh::march::Surface;
use crate::volume::{BRICK, BrickKey, Field, FieldKind, Region, SourceError};

/// Planes that are read at once.
const SLAB: u32 = BRICK;

/// The surface where a selection is a half, in the space that `world_from_index` leads to; without a triangle where it is nowhere as
/// much. `proceed` gets the share done and answers whether to go on: `None` if not.
///
/// # Errors
/// If the source behind the field fails.
pub fn selection_surface(
    selection: &Field,
    world_from_index: &DAffine3,
    proceed: &dyn Fn(f32) -> bool,
) -> Result<Option<TriangleMesh>, SourceError> {
    debug_assert_eq!(selection.kind(), FieldKind::Selection);
    let Some(region) = region_of(selection, |min, max| min <= max && max >= 0.5) else {
        return Ok(Some(TriangleMesh::default()));
    };
    // Twice a texel is never as much as 255, its half is odd: no sample lies on the surface.
    let sample = |texel: [u8; 1]| 2 * i32::from(texel[0]) - 255;
    let between = |inner: i32, outer: i32| f64::from(inner) / f64::from(inner - outer);
    let surface = march(selection, &region, -255, sample, between, proceed)?;
    Ok(surface.map(|surface| placed(&surface, world_from_index)))
}

/// The smooth surface about the voxels of a label; see [`selection_surface`]. Its corners are within half a voxel of the voxels' faces.
///
/// # Errors
/// If the source behind the field fails.
pub fn label_surface(
    labels: &Field,
    label: u16,
    world_from_index: &DAffine3,
    proceed: &dyn Fn(f32) -> bool,
) -> Result<Option<TriangleMesh>, SourceError> {
    debug_assert_eq!(labels.kind(), FieldKind::Labels);
    let id = f32::from(label);
    let Some(region) = region_of(labels, |min, max| min <= id && id <= max) else {
        return Ok(Some(TriangleMesh::default()));
    };
    let sample = |texel: [u8; 2]| if u16::from_le_bytes(texel) == label { 1 } else { -1 };
    let marched = march(labels, &region, -1, sample, |_, _| 0.5, &|x| proceed(x * 0.6))?;
    let Some(mut surface) = marched else { return Ok(None) };
    let done = surface.triangles.is_empty() || surface.smooth(&|x| proceed(0.6 + 0.4 * x));
    Ok(done.then(|| placed(&surface, world_from_index)))
}

/// The box of the bricks of which `is_met` says, by least and largest value, that they may hold any of it or lie beside it: what is
/// known of a brick is of a voxel about it too.
fn region_of(field: &Field, is_met: impl Fn(f32, f32) -> bool) -> Option<Region> {
    let dims = field.dims(0);
    let met = field.brick_indices(0).into_iter().filter(|&index| {
        let summary = field.summary(BrickKey { level: 0, index });
        is_met(summary.min, summary.max)
    });
    let boxes = met.map(|index| (index.origin(), index.origin().map(|o| o + BRICK)));
    let (lo, end) = boxes.reduce(|(lo, end), (a, b)| {
        (std::array::from_fn(|i| lo[i].min(a[i])), std::array::from_fn(|i| end[i].max(b[i])))
    })?;
    Some(Region { lo, end: std::array::from_fn(|a| end[a].min(dims[a])) })
}

fn march<const N: usize>(
    field: &Field,
    region: &Region,
    outside: i32,
    sample: impl Fn([u8; N]) -> i32,
    between: impl Fn(i32, i32) -> f64,
    proceed: &dyn Fn(f32) -> bool,
) -> Result<Option<Surface>, SourceError> {
    let size = region.size();
    let lo = region.lo.map(i64::from);
    let plane_texels = (size[0] * size[1]) as usize;
    // The planes that were read last, from which on.
    let mut slab: (u32, Vec<u8>) = (0, Vec::new());
    let plane = |z: usize| {
        let z = z as u32;
        let at = (z - slab.0.min(z)) as usize * plane_texels * N;
        if slab.1.is_empty() || at >= slab.1.len() {
            if !proceed(z as f32 / size[2] as f32) {
                return Err(None);
            }
            let count = SLAB.min(size[2] - z);
            let texels = field.read(0, [lo[0], lo[1], lo[2] + i64::from(z)], [size[0], size[1], count]);
            slab = (z, texels.map_err(Some)?);
        }
        let at = (z - slab.0) as usize * plane_texels * N;
        Ok(slab.1[at..at + plane_texels * N].as_chunks::<N>().0.iter().map(|texel| sample(*texel)).collect())
    };
    match Surface::march(lo, size.map(|n| n as usize), outside, plane, between) {
        Ok(surface) => Ok(Some(surface)),
        Err(None) => Ok(None),
        Err(Some(error)) => Err(error),
    }
}

/// The surface as a mesh in the world; mirrored grids turn what goes round.
fn placed(surface: &Surface, world_from_index: &DAffine3) -> TriangleMesh {
    let to_world = |corner: &DVec3| world_from_index.transform_point3(*corner).as_vec3().to_array();
    let corners = surface.corners.iter().map(to_world).collect();
    let mirrored = world_from_index.matrix3.determinant() < 0.0;
    let turned = |&[a, b, c]: &[u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
    TriangleMesh::checked(corners, surface.triangles.iter().map(turned).collect())
}
