//! Boxes of a volume that a finer one fills: where they are cut out of bodies, and by how much finer samples lie in them.
//!
//! Each box is listed once for every pose that bodies of its host have. Both the host, to leave it out, and the body that fills it go
//! by that one entry, so that neither a gap nor an overlap is left between them. What rays do there is in `shaders/lib/holes.wgsl`.

use crate::gpu::cast::merging::MergedBody;
use crate::gpu::cast::solid::Polyhedron;
use crate::gpu::cast::tiles::{Window, spans};
use crate::gpu::device::constants::{MOST_HOLES, THROUGH_HOLE, TILE};
use crate::gpu::device::error::GpuError;
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::volumes::Fields;
use crate::gpu::picture::frame::{Body, Frame};
use crate::gpu::picture::image::Image;
use crate::math::{Camera, DAffine3, DVec2, DVec3, Pose};
use crate::shared_struct;
use crate::volume::VolumeId;
use std::ops::Range;

shared_struct! {
    /// See shaders/lib/body.wgsl.
    pub struct Hole {
        /// index_from_world of the posed host, first column.
        pub column_x: [f32; 3],
        /// Samples in a step of the lattice.
        pub steps: f32,
        /// Second column.
        pub column_y: [f32; 3],
        /// The same of its host.
        pub host_steps: f32,
        /// Third column.
        pub column_z: [f32; 3],
        /// The host's place among the volumes that are bound.
        pub host: u32,
        /// The eye in the host's index space.
        pub eye: [f32; 3],
        /// A texel of the host's density in texels of the finer one.
        pub texel_ratio: f32,
        /// First corner in the host's index space.
        pub lo: [f32; 3],
        /// Finer texel = host's texel · ratio + bias.
        pub texel_bias: f32,
        /// Last corner.
        pub hi: [f32; 3],
        /// The place of what fills it among the volumes that are bound.
        pub volume: u32,
        /// Samples a voxel of the host.
        pub scale: [f32; 3],
        /// Whether both are shown alike.
        pub seamless: u32,
    }
}

/// The holes of a picture.
pub(crate) struct Holes {
    pub list: Vec<Hole>,
    /// Whose they are and who fills them, as posed, in the same order.
    of: Vec<(VolumeId, VolumeId, Pose)>,
    /// The most samples of any in a step.
    pub finest: f64,
}

impl Holes {
    /// Those of bodies that are drawn together with what fills them.
    ///
    /// # Errors
    /// If there are more than fit, or `fields` has not a volume.
    pub(crate) fn new(
        frame: &Frame,
        fields: &Fields<'_>,
        pools: &FieldPools,
        drawn: &[MergedBody],
    ) -> Result<Self, GpuError> {
        let mut holes = Self { list: Vec::new(), of: Vec::new(), finest: 1.0 };
        let filled = frame.boxes.iter().filter(|b| drawn.iter().any(|d| d.volume == b.volume));
        let filled: Vec<_> = filled.collect();
        let look_of = |id: VolumeId| {
            let of = drawn.iter().find(|d| d.volume == id)?;
            Some((of.look, of.labels.as_ref().map(std::sync::Arc::as_ptr)))
        };
        for d in drawn {
            if holes.of.iter().any(|(host, _, pose)| (*host, pose) == (d.volume, &d.pose)) {
                continue;
            }
            for b in filled.iter().filter(|b| b.host == d.volume) {
                let grid = fields.get(d.volume).ok_or(GpuError::NoVolume { id: d.volume.0 })?.grid;
                let index_from_world: DAffine3 = grid.index_from_world() * d.pose.world_from_rest().inverse();
                let m = index_from_world.matrix3;
                let [(host_lo, host_span), (lo, span)] = [b.host, b.volume].map(|id| pools.value_of_texel(id));
                let steps = frame.steps_of(b.volume);
                holes.finest = holes.finest.max(steps);
                let corner = |v: [u32; 3]| v.map(|v| v as f32);
                holes.list.push(Hole {
                    column_x: narrow(m.x_axis),
                    steps: steps as f32,
                    column_y: narrow(m.y_axis),
                    host_steps: frame.steps_of(b.host) as f32,
                    column_z: narrow(m.z_axis),
                    host: pools.place_of(b.host) as u32,
                    eye: narrow(index_from_world.transform_point3(frame.camera.eye)),
                    texel_ratio: (host_span / span) as f32,
                    lo: corner(b.of.lo),
                    texel_bias: ((host_lo - lo) / span) as f32,
                    hi: corner(b.of.hi),
                    volume: pools.place_of(b.volume) as u32,
                    scale: corner(b.of.scale),
                    seamless: u32::from(look_of(b.host) == look_of(b.volume)),
                });
                holes.of.push((b.host, b.volume, d.pose));
            }
        }
        if holes.list.len() > MOST_HOLES as usize {
            return Err(GpuError::TooManyBoxes { boxes: holes.list.len(), most: MOST_HOLES as usize });
        }
        Ok(holes)
    }

    /// Those of a body.
    pub(crate) fn of(&self, d: &MergedBody) -> Range<u32> {
        let is = |(host, _, pose): &(VolumeId, VolumeId, Pose)| (*host, pose) == (d.volume, &d.pose);
        let first = self.of.iter().position(is).unwrap_or(0);
        let count = self.of.iter().filter(|hole| is(hole)).count();
        first as u32..(first + count) as u32
    }

    /// The one that a body fills.
    pub(crate) fn filled_by(&self, d: &MergedBody) -> Option<u32> {
        let at = self.of.iter().position(|(_, fills, pose)| (*fills, pose) == (d.volume, &d.pose))?;
        Some(at as u32)
    }
}

pub(crate) fn narrow(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

/// The bodies that fill boxes of others.
pub(crate) fn boxed_bodies(frame: &Frame) -> Vec<Body> {
    frame.bodies.iter().filter(|body| frame.is_boxed(body.volume)).cloned().collect()
}

/// What of a window solids show in, as a window of its own, and its first pixel in the other; `None` if they do not.
pub(crate) fn bounds_of<'a>(
    solids: impl IntoIterator<Item = &'a Polyhedron>,
    camera: &Camera,
    window: &Window,
) -> Option<(Window, [u32; 2])> {
    let dims = window.size.map(|s| s.div_ceil(TILE));
    let mut around: Option<[u32; 4]> = None;
    for solid in solids {
        for (y, span) in (0..).zip(spans(solid, camera, window, dims)) {
            let Some((first, last)) = span else { continue };
            let [left, top, right, bottom] = around.unwrap_or([first, y, last, y]);
            around = Some([left.min(first), top.min(y), right.max(last), bottom.max(y)]);
        }
    }
    let [left, top, right, bottom] = around?.map(|tile| tile * TILE);
    let size = [(right + TILE).min(window.size[0]) - left, (bottom + TILE).min(window.size[1]) - top];
    let origin = window.origin + DVec2::new(f64::from(left), f64::from(top));
    Some((Window { origin, size, only: None, ..*window }, [left, top]))
}

/// Lays the pixels of one picture whose rays meet a box over those of another, from its pixel `at` on.
pub(crate) fn lay_through(
    (image, codes): (&mut Image, &mut [u32]),
    (through, of_through): (&Image, &[u32]),
    at: [u32; 2],
) {
    let [width, _] = image.size.map(|s| s as usize);
    let row = through.size[0] as usize;
    for (i, &code) in of_through.iter().enumerate().filter(|(_, code)| **code & THROUGH_HOLE != 0) {
        let to = at[0] as usize + i % row + width * (at[1] as usize + i / row);
        (image.colour[to], image.depth_mm[to]) = (through.colour[i], through.depth_mm[i]);
        codes[to] = code & !THROUGH_HOLE;
    }
}
