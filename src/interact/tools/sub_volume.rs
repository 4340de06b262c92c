//! The tool for sub-volumes: a drag makes a box of finer voxels, or moves a face of one that is there.
//!
//! On a slice the box is what is dragged over, as thick as it is narrow; in 3D it lies about the place that is pressed, as large as the
//! drag is long.

use crate::document::{Command, Scene, Scale, SubVolumeCommand, ViewName};
use crate::interact::boxes::{Handle, crosses, edges, handles, taken};
use crate::interact::context::Context;
use crate::interact::event::PointerEvent;
use crate::interact::gesture::{CLICK_PX, Gesture};
use crate::interact::mark::{Ink, Mark, Pen};
use crate::interact::readout;
use crate::interact::slices::CutSlice;
use crate::interact::tools::{About, Does, Press};
use crate::math::{Aabb, Camera, DVec2, DVec3};
use crate::volume::{Grid, SubBox};

pub(super) const ABOUT: About = About {
    name: "Sub-volume",
    group: "Paint",
    keys: &[("U", "Sub-volume: drag a box of finer voxels, or a face of one by its handle")],
    hint: "Drag over a slice, or from a place in 3D, for a box of finer voxels; drag a handle to move its face",
    icon: &[
        Pen::Closed(&[(2.0, 2.0), (14.0, 2.0), (14.0, 14.0), (2.0, 14.0)]),
        Pen::Closed(&[(6.0, 6.0), (14.0, 6.0), (14.0, 14.0), (6.0, 14.0)]),
        Pen::Line(&[(10.0, 6.0), (10.0, 14.0)]),
        Pen::Line(&[(6.0, 10.0), (14.0, 10.0)]),
    ],
    of_parts: false,
    has_shift: false,
};

/// Samples a voxel of a box that is dragged: enough for what one would draw between voxels, a sixteenth of the finest's memory.
const SCALE: u32 = 4;
/// Voxels that a box is thick and wide at least.
const LEAST: f64 = 4.0;

pub(super) struct SubVolume;

impl Does for SubVolume {
    fn press(&self, e: &PointerEvent, context: &Context<'_>) -> Press {
        let slice = CutSlice::new(context.grid, context.scene, e.view, e.size);
        let camera = &context.scene.views.camera;
        let handles = match &slice {
            Some(slice) => {
                let normal = slice.plane.right.cross(slice.plane.up);
                let met = context.boxes.iter().filter(|(_, corners)| crosses(corners, slice.plane.centre, normal));
                let met = met.map(|(id, corners)| (*id, *corners)).collect();
                handles(context.scene, &met, &|world| Some(slice.plane.pixel(world)))
            }
            None => handles(context.scene, context.boxes, &|world| Some(camera.project(world, e.size)?.0)),
        };
        if let Some(handle) = taken(&handles, e.px) {
            let of = context.scene.volumes.all.get(&handle.volume).and_then(|v| v.sub_volume).map(|sub| sub.of);
            let Some(of) = of else { return Press::Looks };
            let sample_bytes = context.sample_bytes.get(&handle.volume).copied().unwrap_or_default();
            return Press::begins(Face { view: e.view, handle, of, sample_bytes, from: e.px, to: e.px });
        }
        let about = match (&slice, e.hit) {
            (Some(slice), _) => slice.plane.world(e.px),
            (None, Some(hit)) => hit.part.map_or(hit.world, |part| {
                let part = context.scene.explosion.part(part);
                part.map_or(hit.world, |part| context.poses.of(part).unapply(hit.world))
            }),
            (None, None) => return Press::Looks,
        };
        let mm_per_px = match (&slice, e.hit) {
            (Some(slice), _) => slice.plane.mm_per_px,
            (None, hit) => camera.mm_per_pixel(hit.map_or(1.0, |hit| hit.depth_mm), e.size[1]),
        };
        let scene = context.scene;
        let active = scene.volumes.active;
        let there = scene.volumes.all.values().filter_map(|v| v.sub_volume);
        Press::begins(New {
            view: e.view,
            grid: *context.grid,
            slice,
            camera: *camera,
            size: e.size,
            there: there.filter(|sub| sub.parent == active).map(|sub| sub.of).collect(),
            sample_bytes: context.sample_bytes.get(&active).copied().unwrap_or_default(),
            about,
            mm_per_px,
            from: e.px,
            to: e.px,
        })
    }
}

/// A box that is being dragged.
#[derive(Debug)]
struct New {
    view: ViewName,
    /// Of the volume that it is cut out of.
    grid: Grid,
    slice: Option<CutSlice>,
    camera: Camera,
    /// Of the view, pixels.
    size: [u32; 2],
    /// Boxes that are there already.
    there: Vec<SubBox>,
    sample_bytes: u64,
    /// Where the button went down, world mm.
    about: DVec3,
    mm_per_px: f64,
    from: DVec2,
    to: DVec2,
}

impl New {
    /// The box in voxels, whole and inside the volume.
    fn sub_box(&self) -> SubBox {
        let index = self.grid.index_from_world();
        let centre = index.transform_point3(self.about);
        let spacing = self.grid.spacing();
        let (mut lo, mut hi) = (centre, centre);
        match &self.slice {
            Some(slice) => {
                let other = index.transform_point3(slice.plane.world(self.to));
                (lo, hi) = (centre.min(other), centre.max(other));
                let axis = slice.plane.axis;
                let wide = (0..3).filter(|a| *a != axis).map(|a| (hi[a] - lo[a]) * spacing[a]);
                let half = 0.5 * wide.fold(f64::INFINITY, f64::min) / spacing[axis];
                (lo[axis], hi[axis]) = (lo[axis] - half, hi[axis] + half);
            }
            None => {
                let reach = DVec3::splat(self.from.distance(self.to) * self.mm_per_px) / spacing;
                (lo, hi) = (lo - reach, hi + reach);
            }
        }
        let last = self.grid.dims_f64() - 1.0;
        let (mut first, mut end) = ([0; 3], [0; 3]);
        for a in 0..3 {
            let middle = 0.5 * (lo[a] + hi[a]);
            let half = (0.5 * (hi[a] - lo[a])).max(0.5 * LEAST);
            let from = (middle - half).round().clamp(0.0, (last[a] - 1.0).max(0.0));
            (first[a], end[a]) = (from as u32, (middle + half).round().clamp(from + 1.0, last[a].max(1.0)) as u32);
        }
        // Inside of one that is there it is finer than that.
        let holds = |of: &&SubBox| (0..3).all(|a| of.lo[a] <= first[a] && end[a] <= of.hi[a]);
        let scale = self.there.iter().find(holds).map_or([SCALE; 3], |of| of.scale.map(|s| (2 * s).min(SubBox::FINEST)));
        SubBox { lo: first, hi: end, scale }
    }
}

impl Gesture for New {
    fn is_live(&self) -> bool {
        false
    }

    fn drag(&mut self, e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        self.to = e.px;
        Vec::new()
    }

    fn commit(self: Box<Self>, _e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        if self.from.distance(self.to) <= CLICK_PX {
            return Vec::new();
        }
        let SubBox { lo, hi, scale } = self.sub_box();
        let add = SubVolumeCommand::Add { volume: None, lo, hi, scale: Scale::Each(scale), name: None };
        vec![Command::SubVolume(add)]
    }

    fn marks(&self, view: ViewName) -> Vec<Mark> {
        if view != self.view {
            return Vec::new();
        }
        let of = self.sub_box();
        let centres = Aabb { min: DVec3::from_array(of.lo.map(f64::from)), max: DVec3::from_array(of.hi.map(f64::from)) };
        let corners = centres.corners().map(|corner| self.grid.world_from_index.transform_point3(corner));
        let drawn = |world| match &self.slice {
            Some(slice) => Some(slice.plane.pixel(world)),
            None => Some(self.camera.project(world, self.size)?.0),
        };
        let lines = edges(&corners, &drawn).into_iter().map(|[from, to]| Mark::Line { from, to, ink: Ink::Accent });
        let text = readout::box_size(&of, self.sample_bytes);
        lines.chain([Mark::Note { at: self.to, text }]).collect()
    }
}

/// A face that is being moved.
#[derive(Debug)]
struct Face {
    view: ViewName,
    handle: Handle,
    /// The box as it was.
    of: SubBox,
    sample_bytes: u64,
    from: DVec2,
    to: DVec2,
}

impl Face {
    /// How far the hand has moved it, in voxels.
    fn voxels(&self) -> i64 {
        let along = self.handle.voxel_px;
        ((self.to - self.from).dot(along) / along.length_squared()).round() as i64
    }

    /// The box as the hand has it now.
    fn sub_box(&self) -> SubBox {
        let (Handle { axis, last, .. }, mut of) = (self.handle, self.of);
        let shifted = |v: u32| (i64::from(v) + self.voxels()).clamp(0, i64::from(u32::MAX)) as u32;
        if last {
            of.hi[axis] = shifted(of.hi[axis]).max(of.lo[axis] + 1);
        } else {
            of.lo[axis] = shifted(of.lo[axis]).min(of.hi[axis] - 1);
        }
        of
    }
}

impl Gesture for Face {
    fn is_live(&self) -> bool {
        false
    }

    fn drag(&mut self, e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        self.to = e.px;
        Vec::new()
    }

    fn commit(self: Box<Self>, _e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        let of = self.sub_box();
        if of == self.of {
            return Vec::new();
        }
        let (volume, lo, hi) = (self.handle.volume, Some(of.lo), Some(of.hi));
        vec![Command::SubVolume(SubVolumeCommand::Set { volume, lo, hi, scale: None, discard: false })]
    }

    fn marks(&self, view: ViewName) -> Vec<Mark> {
        if view != self.view {
            return Vec::new();
        }
        let to = self.handle.at + self.handle.voxel_px * self.voxels() as f64;
        let ring = Mark::Ring { at: to, radius_px: 5.0, ink: Ink::Accent, faint: false };
        let note = Mark::Note { at: self.to, text: readout::box_size(&self.sub_box(), self.sample_bytes) };
        vec![Mark::Line { from: self.handle.at, to, ink: Ink::Accent }, ring, note]
    }
}
