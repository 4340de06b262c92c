//! Boxes of a volume that a finer one fills: where they are cut out of bodies, and by how much finer samples lie in them.
//!
//! A volume, its boxes and theirs are a family. Each box is listed once for every pose that bodies of its family have and that shows
//! something of it, behind the one that it is cut out of. All bodies of the family go by those entries, so that neither a gap nor an
//! overlap is left between them. What rays do there is in `shaders/lib/holes.wgsl`.

use crate::gpu::cast::merging::MergedBody;
use crate::gpu::cast::solid::Polyhedron;
use crate::gpu::cast::tiles::{Window, spans};
use crate::gpu::device::constants::{MOST_HOLES, NO_HOLE, THROUGH_HOLE, TILE};
use crate::gpu::device::error::GpuError;
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::volumes::Fields;
use crate::gpu::picture::frame::{Body, FineBox, Frame, Mask};
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
        /// Samples in a step of the lattice; 0 behind the last of a list.
        pub steps: f32,
        /// Second column.
        pub column_y: [f32; 3],
        /// The hole that its host fills, or `NO_HOLE`.
        pub host_hole: u32,
        /// Third column.
        pub column_z: [f32; 3],
        /// The host's place among the volumes that are bound.
        pub host: u32,
        /// The eye in the host's index space.
        pub eye: [f32; 3],
        /// A texel of the density of the host that fills no hole in texels of the finer one.
        pub texel_ratio: f32,
        /// First corner in the host's index space.
        pub lo: [f32; 3],
        /// Finer texel = that texel · ratio + bias.
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

/// A box as it is posed somewhere.
#[derive(Clone, Debug)]
pub(crate) struct PosedBox {
    /// The volume that it and its hosts are cut out of.
    root: VolumeId,
    of: FineBox,
    pose: Pose,
    /// In world mm, as posed; no planes are cut off.
    pub solid: Polyhedron,
}

/// The boxes of a frame wherever bodies show something of them: those of a family in one pose on end, hosts before what is cut out
/// of them.
pub(crate) fn posed_boxes(frame: &Frame, fields: &Fields<'_>) -> Vec<PosedBox> {
    let shown = |id: VolumeId| frame.bodies.iter().any(|body| body.volume == id);
    let boxes: Vec<&FineBox> = frame.boxes.iter().filter(|b| shown(b.volume) && shown(b.host)).collect();
    let mut families: Vec<(VolumeId, Pose)> = Vec::new();
    for body in &frame.bodies {
        let family = (frame.root_of(body.volume), body.pose);
        if boxes.iter().any(|b| frame.root_of(b.volume) == family.0) && !families.contains(&family) {
            families.push(family);
        }
    }
    let posed = |&(root, pose): &(VolumeId, Pose)| {
        let of_family = boxes.iter().filter(|b| frame.root_of(b.volume) == root);
        let of_family = of_family.filter_map(|&&of| {
            let grid = fields.get(of.volume)?.grid;
            let corners = grid.centre_bounds().corners().map(|c| grid.world_from_index.transform_point3(c));
            let solid = Polyhedron::hexahedron(&corners);
            let is_met = |body: &Body| {
                let left = body.region.iter().try_fold(solid.clone(), |left, plane| left.cut(plane));
                left.is_some()
            };
            let mut at_pose = frame.bodies.iter().filter(|b| frame.root_of(b.volume) == root && b.pose == pose);
            at_pose.any(is_met).then(|| PosedBox { root, of, pose, solid: solid.posed(&pose) })
        });
        of_family.collect::<Vec<_>>()
    };
    families.iter().flat_map(posed).collect()
}

/// For every body the first of those that are one with it but for boxes of finer volumes.
pub(crate) fn kin_of(frame: &Frame, drawn: &[MergedBody]) -> Vec<usize> {
    if frame.boxes.is_empty() {
        return (0..drawn.len()).collect();
    }
    let like = |d: &MergedBody, e: &MergedBody| {
        d.pose == e.pose
            && d.shares_member(e)
            && frame.root_of(d.volume) == frame.root_of(e.volume)
            && (d.mask == Mask::Selection, &d.tint, d.look, &d.labels, d.own_colours)
                == (e.mask == Mask::Selection, &e.tint, e.look, &e.labels, e.own_colours)
    };
    drawn.iter().enumerate().map(|(i, d)| drawn[..i].iter().position(|e| like(d, e)).unwrap_or(i)).collect()
}

/// The holes of a picture.
pub(crate) struct Holes {
    pub list: Vec<Hole>,
    posed: Vec<PosedBox>,
    /// The most samples of any in a step.
    pub finest: f64,
}

impl Holes {
    /// Those of a frame's boxes. `kin`: see [`kin_of`].
    ///
    /// # Errors
    /// If there are more than fit, or `fields` has not a volume.
    pub(crate) fn new(
        frame: &Frame,
        fields: &Fields<'_>,
        pools: &FieldPools,
        (drawn, kin): (&[MergedBody], &[usize]),
    ) -> Result<Self, GpuError> {
        let posed = posed_boxes(frame, fields);
        if posed.len() > MOST_HOLES as usize {
            return Err(GpuError::TooManyBoxes { boxes: posed.len(), most: MOST_HOLES as usize });
        }
        let mut list: Vec<Hole> = Vec::with_capacity(posed.len());
        for (i, PosedBox { root, of, pose, .. }) in posed.iter().enumerate() {
            let grid = fields.get(of.host).ok_or(GpuError::NoVolume { id: of.host.0 })?.grid;
            let index_from_world: DAffine3 = grid.index_from_world() * pose.world_from_rest().inverse();
            let m = index_from_world.matrix3;
            let [(root_lo, root_span), (lo, span)] = [*root, of.volume].map(|id| pools.value_of_texel(id));
            let of_volume =
                |id: VolumeId| drawn.iter().zip(kin).filter(move |(d, _)| d.volume == id && d.pose == *pose);
            // Of bodies that a part or the selection is in both.
            let differ = of_volume(of.host).any(|(d, own)| {
                let same_mask = |e: &MergedBody| (d.mask == Mask::Selection) == (e.mask == Mask::Selection);
                of_volume(of.volume).any(|(e, others)| own != others && same_mask(e) && d.shares_member(e))
            });
            let corner = |v: [u32; 3]| v.map(|v| v as f32);
            let fills = |p: &PosedBox| p.of.volume == of.host && p.pose == *pose;
            list.push(Hole {
                column_x: narrow(m.x_axis),
                steps: frame.steps_of(of.volume) as f32,
                column_y: narrow(m.y_axis),
                host_hole: posed[..i].iter().position(fills).map_or(NO_HOLE, |at| at as u32),
                column_z: narrow(m.z_axis),
                host: pools.place_of(of.host) as u32,
                eye: narrow(index_from_world.transform_point3(frame.camera.eye)),
                texel_ratio: (root_span / span) as f32,
                lo: corner(of.of.lo),
                texel_bias: ((root_lo - lo) / span) as f32,
                hi: corner(of.of.hi),
                volume: pools.place_of(of.volume) as u32,
                scale: corner(of.of.scale),
                seamless: u32::from(!differ),
            });
        }
        let finest = list.iter().map(|hole| f64::from(hole.steps)).fold(1.0, f64::max);
        Ok(Self { list, posed, finest })
    }

    /// Their list, behind which one of no samples says that it ends.
    pub(crate) fn ended(self) -> Vec<Hole> {
        let mut list = self.list;
        if list.len() < MOST_HOLES as usize {
            list.push(bytemuck::Zeroable::zeroed());
        }
        list
    }

    /// Those of a body's family in its pose.
    pub(crate) fn of(&self, frame: &Frame, d: &MergedBody) -> Range<u32> {
        let root = frame.root_of(d.volume);
        let is = |p: &PosedBox| (p.root, &p.pose) == (root, &d.pose);
        let first = self.posed.iter().position(is).unwrap_or(0);
        let count = self.posed.iter().filter(|p| is(p)).count();
        first as u32..(first + count) as u32
    }

    /// The one that a body fills.
    pub(crate) fn filled_by(&self, d: &MergedBody) -> Option<u32> {
        let at = self.posed.iter().position(|p| (p.of.volume, &p.pose) == (d.volume, &d.pose))?;
        Some(at as u32)
    }

    /// The most boxes of a family.
    pub(crate) fn largest_family(&self) -> usize {
        let same = |p: &PosedBox| self.posed.iter().filter(|q| (q.root, q.pose) == (p.root, p.pose)).count();
        self.posed.iter().map(same).max().unwrap_or(0)
    }

    /// Into how many more pieces they may part the bodies that a ray meets: where one is left the matter behind it takes the rest of
    /// a sample, of every box that it is cut out of too.
    pub(crate) fn pieces(&self) -> usize {
        let depth = |hole: &Hole| {
            let above = |hole: &&Hole| self.list.get(hole.host_hole as usize);
            std::iter::successors(Some(hole), above).count()
        };
        self.list.iter().map(|hole| 1 + depth(hole)).sum()
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
