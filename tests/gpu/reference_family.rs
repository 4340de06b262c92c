//! Volumes with boxes of a resolution of their own, and what lies where in them, by the book, in f64.
//!
//! What a place has is what the finest box about it has. Near a box's faces light goes over to that of its host.

use crate::common::volumes::each;
use burin::gpu::{Body, Caster, FieldPools, Fields, FineBox, Frame, Gpu, Image, VolumeFields};
use burin::math::DVec3;
use burin::volume::*;
use std::cell::RefCell;
use std::sync::Arc;

/// A volume, boxes of it and boxes of those: `boxes[i]` is filled by `volumes[i + 1]`, whose id is i + 1. Volumes beyond those have
/// no boxes.
pub struct Family {
    pub volumes: Vec<Volume>,
    pub boxes: Vec<FineBox>,
}

/// A volume of these values that are told apart by one.
pub fn parent_on(grid: Grid, value: impl Fn([u32; 3]) -> u16) -> Volume {
    let voxels = Voxels::U16(each(grid.dims, value));
    let source = Arc::new(MemorySource::new("made", grid, voxels, (1.0, 0.0)).unwrap());
    let statistics = Statistics { min: 0.0, max: 4000.0, ..Statistics::default() };
    let map = DensityMap::codes(0.0, 65_535.0, Some(1.0));
    Volume::new(source, map, statistics, Histogram::default(), &|_| true).unwrap().unwrap()
}

/// Waves of several lengths: something everywhere, surfaces in all directions.
pub fn waves([x, y, z]: [u32; 3]) -> u16 {
    let [x, y, z] = [x, y, z].map(f64::from);
    let wave = (x * 0.31).sin() + (y * 0.27 + 1.0).sin() + (z * 0.35 + x * 0.1).sin();
    (2000.0 + 600.0 * wave + 60.0 * (x * 1.7 + y * 2.3).sin()) as u16
}

thread_local! {
    /// Of one test: making its pipelines costs more than its pictures.
    static CASTER: RefCell<Option<Caster>> = const { RefCell::new(None) };
}

impl Family {
    /// Boxes by the id of what they are cut out of.
    pub fn new(parent: Volume, of: &[(u32, SubBox)]) -> Self {
        let mut family = Self { volumes: vec![parent], boxes: Vec::new() };
        for (i, &(host, of)) in (1..).zip(of) {
            let shared = Arc::new(family.volumes[host as usize].clone());
            family.volumes.push(Volume::refined(&shared, of));
            let finer = *of.scale.iter().max().unwrap();
            family.boxes.push(FineBox { volume: VolumeId(i), host: VolumeId(host), of, finer });
        }
        family
    }

    pub fn fields(&self) -> Fields<'_> {
        let mut fields = Fields::default();
        for (i, v) in (0..).zip(&self.volumes) {
            let [density, colour, selection, labels] = FieldKind::ALL.map(|kind| v.field(kind));
            fields.put(VolumeId(i), VolumeFields { grid: *v.grid(), density, colour, selection, labels });
        }
        fields
    }

    /// The picture with the boxes: all bodies of the first volume are the boxes' too.
    pub fn with_boxes(&self, plain: &Frame) -> Frame {
        let of_first: Vec<_> = plain.bodies.iter().filter(|body| body.volume == VolumeId::FIRST).collect();
        let of_box = |b: &FineBox| of_first.iter().map(|&body| Body { volume: b.volume, ..body.clone() }).collect();
        let bodies = self.boxes.iter().flat_map(|b| -> Vec<Body> { of_box(b) });
        Frame {
            bodies: plain.bodies.iter().cloned().chain(bodies).collect(),
            boxes: self.boxes.clone(),
            ..plain.clone()
        }
    }

    pub fn draw(&self, gpu: &Gpu, frame: &Frame) -> Image {
        let mut pools = FieldPools::empty(gpu, 256 << 20).unwrap();
        CASTER.with_borrow_mut(|caster| {
            let caster = caster.get_or_insert_with(|| Caster::new(gpu).unwrap());
            caster.image(gpu, &mut pools, &self.fields(), frame).unwrap()
        })
    }
}

/// Values of one of the volumes, x fastest.
pub(super) struct Values {
    dims: [u32; 3],
    all: Vec<f64>,
}

impl Values {
    pub(super) fn at(&self, p: DVec3) -> f64 {
        let lo = p.floor();
        let f = p - lo;
        let tap = |x: f64, y: f64, z: f64| {
            let v = [lo.x + x, lo.y + y, lo.z + z];
            let [i, j, k] = [0, 1, 2].map(|a| v[a].clamp(0.0, f64::from(self.dims[a] - 1)) as usize);
            self.all[i + self.dims[0] as usize * (j + self.dims[1] as usize * k)]
        };
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        let plane =
            |z| mix(mix(tap(0.0, 0.0, z), tap(1.0, 0.0, z), f.x), mix(tap(0.0, 1.0, z), tap(1.0, 1.0, z), f.x), f.y);
        mix(plane(0.0), plane(1.0), f.z)
    }
}

/// A family as rays meet it. Places are in the index space of the first volume.
pub struct Book<'a> {
    pub(super) family: &'a Family,
    pub(super) values: Vec<Values>,
    /// By volume: its first sample, and its samples in a voxel of the first one.
    lie: Vec<(DVec3, DVec3)>,
    selection: Vec<Values>,
}

impl<'a> Book<'a> {
    pub fn of(family: &'a Family) -> Self {
        let values = |v: &Volume| {
            let texels = v.density.read(0, [0; 3], v.grid().dims).unwrap();
            let bytes = v.density.format().bytes();
            let value = |t: &[u8]| v.density.map().decode(std::array::from_fn(|i| t.get(i).copied().unwrap_or(0)));
            Values { dims: v.grid().dims, all: texels.chunks_exact(bytes).map(value).collect() }
        };
        let selection = |v: &Volume| {
            let texels = v.selection.read(0, [0; 3], v.grid().dims).unwrap();
            Values { dims: v.grid().dims, all: texels.into_iter().map(|t| f64::from(t) / 255.0).collect() }
        };
        let mut lie = vec![(DVec3::ZERO, DVec3::ONE); family.volumes.len()];
        for b in &family.boxes {
            let (lo, scale) = lie[b.host.0 as usize];
            let [own_lo, own_scale] = [b.of.lo, b.of.scale].map(|v| DVec3::from_array(v.map(f64::from)));
            lie[b.volume.0 as usize] = (lo + own_lo / scale, scale * own_scale);
        }
        Self {
            family,
            lie,
            values: family.volumes.iter().map(values).collect(),
            selection: family.volumes.iter().map(selection).collect(),
        }
    }

    /// Volumes that fill boxes.
    pub(super) fn boxes(&self) -> std::ops::RangeInclusive<usize> {
        1..=self.family.boxes.len()
    }

    pub(super) fn host(&self, volume: usize) -> usize {
        self.family.boxes[volume - 1].host.0 as usize
    }

    /// A place in the index space of a volume.
    pub(super) fn own_place(&self, volume: usize, p: DVec3) -> DVec3 {
        let (lo, scale) = self.lie[volume];
        (p - lo) * scale
    }

    pub(super) fn last(&self, volume: usize) -> DVec3 {
        DVec3::from_array(self.values[volume].dims.map(|n| f64::from(n - 1)))
    }

    /// The box of a volume that a place lies in.
    pub(super) fn child_at(&self, volume: usize, p: DVec3) -> Option<usize> {
        self.boxes().filter(|&c| self.host(c) == volume).find(|&c| {
            let (q, last) = (self.own_place(c, p), self.last(c));
            (0..3).all(|a| q[a] >= 0.0 && q[a] < last[a])
        })
    }

    /// The volume whose values a place has.
    pub fn holder(&self, p: DVec3) -> usize {
        let mut volume = 0;
        while let Some(child) = self.child_at(volume, p) {
            volume = child;
        }
        volume
    }

    pub(super) fn value_in(&self, volume: usize, p: DVec3) -> f64 {
        self.values[volume].at(self.own_place(volume, p))
    }

    pub fn value(&self, p: DVec3) -> f64 {
        self.value_in(self.holder(p), p)
    }

    /// How much a place is selected.
    pub(super) fn selected(&self, p: DVec3) -> f64 {
        let holder = self.holder(p);
        self.selection[holder].at(self.own_place(holder, p))
    }

    /// Samples in a step.
    pub(super) fn steps(&self, volume: usize) -> u32 {
        if volume == 0 { 1 } else { self.family.boxes[volume - 1].finer * self.steps(self.host(volume)) }
    }

    /// The value where a box's host goes on.
    fn beside(&self, volume: usize, p: DVec3) -> f64 {
        let host = self.host(volume);
        let (own, last) = (self.own_place(host, p), self.last(host));
        let inside = host == 0 || (0..3).all(|a| own[a] >= 0.0 && own[a] <= last[a]);
        if inside { self.value_in(host, p) } else { self.beside(host, p) }
    }

    pub fn gradient(&self, volume: usize, p: DVec3) -> DVec3 {
        let (scale, last) = (self.lie[volume].1, self.last(volume));
        let tap = |q: DVec3| {
            let own = self.own_place(volume, q);
            let inside = volume == 0 || (0..3).all(|a| own[a] >= 0.0 && own[a] <= last[a]);
            if inside { self.value_in(volume, q) } else { self.beside(volume, q) }
        };
        let along = |axis: usize| {
            let half = DVec3::AXES[axis] * (0.5 / scale[axis]);
            (tap(p + half) - tap(p - half)) * scale[axis]
        };
        let own = DVec3::new(along(0), along(1), along(2));
        if volume == 0 {
            return own;
        }
        let of = self.family.boxes[volume - 1].of;
        let q = self.own_place(volume, p);
        let off = q.min(last - q) / DVec3::from_array(of.scale.map(f64::from));
        let share = (2.0 * off.min_element()).clamp(0.0, 1.0);
        if share == 1.0 { own } else { self.gradient(self.host(volume), p).lerp(own, share) }
    }
}
