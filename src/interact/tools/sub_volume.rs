//! The tool for sub-volumes: a drag makes a box of finer voxels, or moves a face of one that is there.
//!
//! On a slice the box is what is dragged over, as thick as it is narrow; in 3D it lies about the place that is pressed, as large as the
//! drag is long.

use crate::document::{Command, Scene, Scale, SubVolumeCommand, ViewName};
use crate::interact::boxes::{Handle, crosses, handles, taken};
use crate::interact::context::Context;
use crate::interact::event::PointerEvent;
use crate::interact::gesture::{CLICK_PX, Gesture};
use crate::interact::mark::{Ink, Mark, Pen};
use crate::interact::slices::CutSlice;
use crate::interact::tools::{About, Does, Press};
use crate::math::{DVec2, DVec3};
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
            return Press::begins(Face { view: e.view, handle, from: e.px, to: e.px });
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
        let (grid, from) = (*context.grid, e.px);
        Press::begins(New { view: e.view, grid, slice, about, mm_per_px, from, to: from })
    }
}

/// A box that is being dragged.
#[derive(Debug)]
struct New {
    view: ViewName,
    /// Of the volume that it is cut out of.
    grid: Grid,
    slice: Option<CutSlice>,
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
        SubBox { lo: first, hi: end, scale: [SCALE; 3] }
    }
}

impl Gesture for New {
    fn start(&self, _e: &PointerEvent) -> Vec<Command> {
        Vec::new()
    }

    fn drag(&mut self, e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        self.to = e.px;
        Vec::new()
    }

    fn commit(self: Box<Self>, _e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        if self.from.distance(self.to) <= CLICK_PX {
            return Vec::new();
        }
        let SubBox { lo, hi, .. } = self.sub_box();
        let add = SubVolumeCommand::Add { volume: None, lo, hi, scale: Scale::All(SCALE), name: None };
        vec![Command::SubVolume(add)]
    }

    fn abort(self: Box<Self>, _height: u32) -> Vec<Command> {
        Vec::new()
    }

    fn marks(&self, view: ViewName) -> Vec<Mark> {
        if view != self.view {
            return Vec::new();
        }
        let ink = Ink::Accent;
        let (a, b) = (self.from, self.to);
        match self.slice {
            Some(_) => {
                let corners = [a, DVec2::new(b.x, a.y), b, DVec2::new(a.x, b.y)];
                (0..4).map(|i| Mark::Line { from: corners[i], to: corners[(i + 1) % 4], ink }).collect()
            }
            None => vec![Mark::Ring { at: a, radius_px: a.distance(b), ink, faint: false }],
        }
    }
}

/// A face that is being moved.
#[derive(Debug)]
struct Face {
    view: ViewName,
    handle: Handle,
    from: DVec2,
    to: DVec2,
}

impl Face {
    /// How far the hand has moved it, in voxels.
    fn voxels(&self) -> i64 {
        let along = self.handle.voxel_px;
        ((self.to - self.from).dot(along) / along.length_squared()).round() as i64
    }
}

impl Gesture for Face {
    fn start(&self, _e: &PointerEvent) -> Vec<Command> {
        Vec::new()
    }

    fn drag(&mut self, e: &PointerEvent, _scene: &Scene) -> Vec<Command> {
        self.to = e.px;
        Vec::new()
    }

    fn commit(self: Box<Self>, _e: &PointerEvent, scene: &Scene) -> Vec<Command> {
        let Handle { volume, axis, last, .. } = self.handle;
        let moved = self.voxels();
        let place = scene.volumes.all.get(&volume).and_then(|v| v.sub_volume);
        let Some(of) = place.map(|place| place.of).filter(|_| moved != 0) else { return Vec::new() };
        let (mut lo, mut hi) = (of.lo, of.hi);
        let shifted = |v: u32| (i64::from(v) + moved).clamp(0, i64::from(u32::MAX)) as u32;
        if last {
            hi[axis] = shifted(hi[axis]).max(lo[axis] + 1);
        } else {
            lo[axis] = shifted(lo[axis]).min(hi[axis] - 1);
        }
        let (lo, hi) = (Some(lo), Some(hi));
        vec![Command::SubVolume(SubVolumeCommand::Set { volume, lo, hi, scale: None, discard: false })]
    }

    fn abort(self: Box<Self>, _height: u32) -> Vec<Command> {
        Vec::new()
    }

    fn marks(&self, view: ViewName) -> Vec<Mark> {
        if view != self.view {
            return Vec::new();
        }
        let to = self.handle.at + self.handle.voxel_px * self.voxels() as f64;
        let ring = Mark::Ring { at: to, radius_px: 5.0, ink: Ink::Accent, faint: false };
        vec![Mark::Line { from: self.handle.at, to, ink: Ink::Accent }, ring]
    }
}
