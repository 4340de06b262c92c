//! How far a grid's particles may come, in each volume's voxels and bricks, and what the kernel knows of each volume.

use crate::gpu::device::error::GpuError;
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::pools::reached::Reached;
use crate::gpu::fields::volumes::{Fields, VolumeFields};
use crate::gpu::trace::request::GridRequest;
use crate::math::{Aabb, DVec3};
use crate::shared_struct;
use crate::volume::{BRICK, BrickIndex, TexelFormat, VolumeId};

shared_struct! {
    /// A volume as particles see it, places in its voxels being counted from `base`.
    pub(crate) struct TracedVolume {
        /// index_from_world, first column.
        pub column_x: [f32; 3],
        /// Its place among the volumes that are bound.
        pub place: u32,
        /// Second column.
        pub column_y: [f32; 3],
        /// The texel of the iso-value; of a component of a vector field that of 0.
        pub zero: f32,
        /// Third column.
        pub column_z: [f32; 3],
        /// Values per texel.
        pub span: f32,
        /// One voxel along i, world mm.
        pub axis_x: [f32; 3],
        /// The smallest distance of neighbours, mm.
        pub voxel_mm: f32,
        /// Along j.
        pub axis_y: [f32; 3],
        /// What a component of a vector field must exceed to count.
        pub least: f32,
        /// Along k.
        pub axis_z: [f32; 3],
        /// Unused.
        pub pad_a: u32,
        /// The voxel that the grid's centre lies in.
        pub base: [i32; 3],
        /// Unused.
        pub pad_b: u32,
        /// The grid's centre.
        pub centre: [f32; 3],
        /// Unused.
        pub pad_c: u32,
        /// Where it tells places, first corner.
        pub lo: [f32; 3],
        /// Unused.
        pub pad_d: u32,
        /// Last corner.
        pub hi: [f32; 3],
        /// Unused.
        pub pad_e: u32,
        /// The first voxel's centre; of a box, which something lies about, far away.
        pub first: [f32; 3],
        /// Unused.
        pub pad_f: u32,
        /// The last voxel's centre.
        pub last: [f32; 3],
        /// Unused.
        pub pad_g: u32,
    }
}

/// So far from the picked point the surface may lie, mm.
pub(crate) fn first_mm(request: &GridRequest, fields: &Fields<'_>) -> f64 {
    let voxels = request.family.iter().filter_map(|&id| Some(fields.get(id)?.grid.spacing().max_element()));
    request.step_mm.max(2.0 * voxels.fold(0.0, f64::max))
}

/// So far from the picked point no particle comes, mm: each step is followed by a correction of no more than its length across it.
fn reach_mm(request: &GridRequest, fields: &Fields<'_>) -> f64 {
    let [n, m] = request.steps.map(f64::from);
    first_mm(request, fields) + (n + m) * request.step_mm * std::f64::consts::SQRT_2
}

/// A ball's box in a volume's voxels.
fn box_about(volume: &VolumeFields<'_>, centre: DVec3, radius_mm: f64) -> Aabb {
    let to_index = volume.grid.index_from_world();
    let rows = to_index.matrix3.transpose();
    let half = radius_mm * DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
    let middle = to_index.transform_point3(centre);
    Aabb { min: middle - half, max: middle + half }
}

/// Where a volume tells places: a box up to its outermost samples, which lie on its faces; others as far as pictures show them.
fn bounds_of(volume: &VolumeFields<'_>) -> Aabb {
    if volume.density.is_of_box() { volume.grid.centre_bounds() } else { volume.grid.index_bounds() }
}

fn volume_of<'f, 'a>(fields: &'f Fields<'a>, id: VolumeId) -> Result<&'f VolumeFields<'a>, GpuError> {
    fields.get(id).ok_or(GpuError::NoVolume { id: id.0 })
}

/// The bricks of level 0 that particles may look at.
///
/// # Errors
/// A volume that `fields` has not.
pub(crate) fn reached(request: &GridRequest, fields: &Fields<'_>) -> Result<Reached, GpuError> {
    let volumes = request.volumes();
    let mut coarsest: f64 = 0.0;
    for &id in &volumes {
        coarsest = coarsest.max(volume_of(fields, id)?.grid.spacing().max_element());
    }
    // Curvature looks a voxel further, gradients another one.
    let radius_mm = reach_mm(request, fields) + 3.0 * coarsest;
    let mut reached = Reached::new();
    for id in volumes {
        let volume = volume_of(fields, id)?;
        let about = box_about(volume, request.centre, radius_mm);
        let bricks = volume.density.brick_dims(0);
        let range = |a: usize| {
            let [lo, hi] = [about.min[a], about.max[a] + 1.0].map(|v| (v / f64::from(BRICK)).floor());
            // Voxels beside the volume are those at its faces.
            let end = f64::from(bricks[a]) - 1.0;
            lo.clamp(0.0, end) as u32..hi.clamp(0.0, end) as u32 + 1
        };
        let all = range(2).flat_map(|z| range(1).flat_map(move |y| range(0).map(move |x| BrickIndex([x, y, z]))));
        reached.insert(id, all.collect());
    }
    Ok(reached)
}

/// What the kernel knows of the request's volumes, in the order of [`GridRequest::volumes`]. They must be bound.
///
/// # Errors
/// A volume that `fields` has not.
pub(crate) fn traced_volumes(
    request: &GridRequest,
    fields: &Fields<'_>,
    pools: &FieldPools,
) -> Result<Vec<TracedVolume>, GpuError> {
    let radius_mm = reach_mm(request, fields);
    let of = |(i, id): (usize, VolumeId)| {
        let volume = volume_of(fields, id)?;
        let (grid, density) = (&volume.grid, volume.density);
        let to_index = grid.index_from_world();
        let (columns, axes) = (to_index.matrix3, grid.world_from_index.matrix3);
        let (lo, span) = pools.value_of_texel(id);
        let about = box_about(volume, request.centre, radius_mm);
        let bounds = bounds_of(volume);
        let centre = to_index.transform_point3(request.centre);
        // Far outside it nothing is told, wherever that is.
        let base = centre.floor().clamp(DVec3::splat(-1e6), DVec3::splat(1e6));
        let from_base = |v: DVec3| (v - base).as_vec3().to_array();
        let in_family = i < request.family.len();
        let open = if density.is_of_box() { 1e9 } else { 0.0 };
        let ends = grid.centre_bounds();
        Ok(TracedVolume {
            column_x: columns.x_axis.as_vec3().to_array(),
            place: pools.place_of(id) as u32,
            column_y: columns.y_axis.as_vec3().to_array(),
            zero: ((if in_family { request.iso } else { 0.0 } - lo) / span) as f32,
            column_z: columns.z_axis.as_vec3().to_array(),
            span: span as f32,
            axis_x: axes.x_axis.as_vec3().to_array(),
            voxel_mm: grid.voxel_mm() as f32,
            axis_y: axes.y_axis.as_vec3().to_array(),
            least: match density.format() {
                TexelFormat::R32Float => 0.0,
                _ => (density.map().half_step() * 1.01) as f32,
            },
            axis_z: axes.z_axis.as_vec3().to_array(),
            pad_a: 0,
            base: base.as_ivec3().to_array(),
            pad_b: 0,
            centre: from_base(centre),
            pad_c: 0,
            lo: from_base(bounds.min.max(about.min)),
            pad_d: 0,
            hi: from_base(bounds.max.min(about.max)),
            pad_e: 0,
            first: from_base(ends.min - open),
            pad_f: 0,
            last: from_base(ends.max + open),
            pad_g: 0,
        })
    };
    request.volumes().into_iter().enumerate().map(of).collect()
}
