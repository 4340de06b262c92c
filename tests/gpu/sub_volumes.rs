//! Pictures of volumes of which boxes have a resolution of their own, against rays by the book.
//!
//! A ray takes a sample at every step of the lattice, and from a step that begins in the box as many as the box is finer; each stands for
//! the way to the next one, and what it meets is told by where it lies.

use crate::common::gpu::gpu;
use crate::common::volumes::*;
use burin::gpu::{Body, Caster, FieldPools, Fields, FineBox, Frame, Gpu, Image, VolumeFields};
use burin::math::{Camera, DVec3, Plane, Pose, Projection};
use burin::volume::*;
use rayon::prelude::*;
use std::sync::Arc;

/// A parent and boxes of it.
pub struct Family {
    pub volumes: Vec<Volume>,
    boxes: Vec<FineBox>,
}

fn parent(dims: [u32; 3], value: impl Fn([u32; 3]) -> u16) -> Volume {
    let grid = unit_grid(dims);
    let source = Arc::new(MemorySource::new("made", grid, Voxels::U16(each(dims, value)), (1.0, 0.0)).unwrap());
    let statistics = Statistics { min: 0.0, max: 4000.0, ..Statistics::default() };
    let map = DensityMap::codes(0.0, 65_535.0, Some(1.0));
    Volume::new(source, map, statistics, Histogram::default(), &|_| true).unwrap().unwrap()
}

/// Waves of several lengths: something everywhere, surfaces in all directions.
fn waves([x, y, z]: [u32; 3]) -> u16 {
    let [x, y, z] = [x, y, z].map(f64::from);
    let wave = (x * 0.31).sin() + (y * 0.27 + 1.0).sin() + (z * 0.35 + x * 0.1).sin();
    (2000.0 + 600.0 * wave + 60.0 * (x * 1.7 + y * 2.3).sin()) as u16
}

impl Family {
    pub fn new(dims: [u32; 3], of: &[SubBox]) -> Self {
        let parent = parent(dims, waves);
        let shared = Arc::new(parent.clone());
        let mut family = Self { volumes: vec![parent], boxes: Vec::new() };
        for (i, &of) in (1..).zip(of) {
            family.volumes.push(Volume::refined(&shared, of));
            let finer = *of.scale.iter().max().unwrap();
            family.boxes.push(FineBox { volume: VolumeId(i), host: VolumeId::FIRST, of, finer });
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

    /// The picture with the boxes: all bodies of the parent are the boxes' too.
    pub fn with_boxes(&self, plain: &Frame) -> Frame {
        let of_box = |b: &FineBox| plain.bodies.iter().map(|body| Body { volume: b.volume, ..body.clone() }).collect();
        let bodies = self.boxes.iter().flat_map(|b| -> Vec<Body> { of_box(b) });
        Frame {
            bodies: plain.bodies.iter().cloned().chain(bodies).collect(),
            boxes: self.boxes.clone(),
            ..plain.clone()
        }
    }

    fn draw(&self, gpu: &Gpu, frame: &Frame) -> Image {
        let mut pools = FieldPools::empty(gpu, 256 << 20).unwrap();
        Caster::new(gpu).unwrap().image(gpu, &mut pools, &self.fields(), frame).unwrap()
    }

    /// The value at a place of the parent's index space, and the box that it lies in.
    fn value(&self, p: DVec3) -> (f64, Option<usize>) {
        let inside = |b: &FineBox| {
            let (lo, hi) = (b.of.lo.map(f64::from), b.of.hi.map(f64::from));
            (0..3).all(|a| lo[a] <= p[a] && p[a] < hi[a])
        };
        match self.boxes.iter().position(inside) {
            Some(i) => {
                let of = self.boxes[i].of;
                let q = (p - DVec3::from_array(of.lo.map(f64::from))) * DVec3::from_array(of.scale.map(f64::from));
                let density = &self.volumes[i + 1].density;
                (trilinear(density, 0, q.to_array().map(|x| x as f32), |t| density.map().decode(t)), Some(i))
            }
            None => {
                let density = &self.volumes[0].density;
                (trilinear(density, 0, p.to_array().map(|x| x as f32), |t| density.map().decode(t)), None)
            }
        }
    }
}

fn views(dims: [u32; 3]) -> Vec<Camera> {
    let bounds = unit_grid(dims).world_bounds();
    let slanted = Camera::framing(&bounds, DVec3::new(0.5, 1.0, 0.4), DVec3::Z);
    let along = Camera::framing(&bounds, DVec3::X, DVec3::Z);
    vec![slanted, Camera { projection: Projection::Orthographic { height_mm: 48.0 }, ..along }]
}

/// Unshaded direct volume rendering of a ray.
fn by_the_book(family: &Family, frame: &Frame, px: [u32; 2]) -> [f64; 4] {
    let at = burin::math::DVec2::new(f64::from(px[0]) + 0.5, f64::from(px[1]) + 0.5);
    let ray = frame.camera.ray(at, frame.size);
    let n = family.volumes[0].grid().dims_f64();
    let (mut t0, mut t1) = (0.0_f64, f64::INFINITY);
    for a in 0..3 {
        let (x, d) = (ray.origin[a], if ray.dir[a] == 0.0 { 1e-20 } else { ray.dir[a] });
        let (u, v) = ((-0.5 - x) / d, (n[a] - 0.5 - x) / d);
        (t0, t1) = (t0.max(u.min(v)), t1.min(u.max(v)));
    }
    let (mut colour, mut clear) = ([0.0; 3], 1.0);
    let mut k = (t0 / frame.step_mm).ceil();
    while k * frame.step_mm < t1 && clear >= 1.0 / 256.0 {
        let (_, inside) = family.value(ray.at(k * frame.step_mm));
        let parts = inside.map_or(1, |i| family.boxes[i].finer);
        for part in 0..parts {
            let share = 1.0 / f64::from(parts);
            let (value, _) = family.value(ray.at((k + f64::from(part) * share) * frame.step_mm));
            let way = frame.step_mm * share / frame.transfer.unit_mm;
            let alpha = 1.0 - (1.0 - f64::from(frame.transfer.opacity_at(value))).powf(way);
            for (c, own) in colour.iter_mut().zip(frame.transfer.colour_at(value)) {
                *c += clear * alpha * f64::from(own);
            }
            clear *= 1.0 - alpha;
        }
        k += 1.0;
    }
    [colour[0], colour[1], colour[2], 1.0 - clear]
}

fn worst(a: &Image, b: &Image) -> f32 {
    let pairs = a.colour.iter().flatten().zip(b.colour.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) * 255.0
}

pub const DIMS: [u32; 3] = [44, 40, 36];
pub const INNER: SubBox = SubBox { lo: [12, 20, 10], hi: [26, 34, 24], scale: [4; 3] };

#[test]
fn rays_through_a_box_agree_with_the_equations_and_others_do_not_change_by_a_bit() {
    let Some(gpu) = gpu() else { return };
    for scale in [[4, 4, 4], [3, 2, 1]] {
        let family = Family::new(DIMS, &[SubBox { scale, ..INNER }]);
        for camera in views(DIMS) {
            let transfer = ramp(1500.0, 3500.0);
            let plain = Frame { camera, ..frame(family.volumes[0].grid(), transfer, DVec3::X, [120, 96]) };
            let boxed = family.with_boxes(&plain);
            let (without, with) = (family.draw(&gpu, &plain), family.draw(&gpu, &boxed));
            let corners = INNER.lo.map(f64::from);
            let ends = INNER.hi.map(f64::from);
            let meets = |px: [u32; 2]| {
                let at = burin::math::DVec2::new(f64::from(px[0]) + 0.5, f64::from(px[1]) + 0.5);
                let ray = camera.ray(at, plain.size);
                let (mut t0, mut t1) = (0.0_f64, f64::INFINITY);
                for a in 0..3 {
                    let d = if ray.dir[a] == 0.0 { 1e-20 } else { ray.dir[a] };
                    let (u, v) = ((corners[a] - ray.origin[a]) / d, (ends[a] - ray.origin[a]) / d);
                    (t0, t1) = (t0.max(u.min(v)), t1.min(u.max(v)));
                }
                t1 - t0
            };
            let pixels = each([120, 96, 1], |[x, y, _]| [x, y]);
            let book: Vec<_> = pixels.par_iter().map(|&px| by_the_book(&family, &boxed, px)).collect();
            let (mut through, mut furthest) = (0, 0.0_f64);
            for (i, &px) in pixels.iter().enumerate() {
                if meets(px) < -1e-3 {
                    assert_eq!(with.colour[i].map(f32::to_bits), without.colour[i].map(f32::to_bits), "{px:?}");
                }
                if meets(px) > 0.0 {
                    through += 1;
                    let off = (0..4).map(|c| (f64::from(with.colour[i][c]) - book[i][c]).abs()).fold(0.0, f64::max);
                    furthest = furthest.max(off * 255.0);
                }
            }
            assert!(through > 400 && furthest <= 1.0, "{scale:?}: {through} pixels, {furthest} of 255 off");
        }
    }
}

#[test]
fn a_box_that_divides_nothing_changes_nothing_to_speak_of_in_any_mode() {
    let Some(gpu) = gpu() else { return };
    let family = Family::new(DIMS, &[SubBox { scale: [1; 3], ..INNER }]);
    let light = Some(Lighting::default());
    for camera in views(DIMS) {
        // Steps so short are marched in several passes.
        const SHORT: Option<f64> = Some(0.004);
        for (mode, lighting, refine, step) in [
            (Mode::Dvr, None, false, None),
            (Mode::Dvr, light, false, None),
            (Mode::Dvr, None, true, None),
            (Mode::Iso(2300.0), light, false, None),
            (Mode::Mip, None, false, None),
            (Mode::Dvr, light, false, SHORT),
            (Mode::Iso(2300.0), light, false, SHORT),
            (Mode::Mip, None, false, SHORT),
        ] {
            let plain = frame(family.volumes[0].grid(), ramp(1500.0, 3500.0), DVec3::X, [120, 96]);
            let step_mm = step.unwrap_or(plain.step_mm);
            let plain = Frame { camera, mode, lighting, refine, step_mm, ..plain };
            let (without, with) = (family.draw(&gpu, &plain), family.draw(&gpu, &family.with_boxes(&plain)));
            let off = worst(&without, &with);
            assert!(off <= 1.0, "{mode:?} {lighting:?} refine {refine} step {step_mm}: {off} of 255");
            let depth = without.depth_mm.iter().zip(&with.depth_mm);
            let lost = depth.filter(|(a, b)| a.is_finite() != b.is_finite()).count();
            assert_eq!(lost, 0, "{mode:?} {lighting:?} refine {refine} step {step_mm}");
        }
    }
}

#[test]
fn a_surface_goes_on_through_the_faces_of_boxes_without_a_hole_or_a_step_of_light() {
    let Some(gpu) = gpu() else { return };
    // Boxes that touch, and a part's plane through one of them.
    let second = SubBox { lo: [26, 20, 10], hi: [38, 34, 24], scale: [8, 2, 5] };
    let mut family = Family::new(DIMS, &[INNER, second]);
    // A ramp along a slant: its surface is a plane, and so it has one light.
    let slant = |[x, y, z]: [u32; 3]| (x * 20 + y * 60 + z * 20) as u16;
    let parent = parent(DIMS, slant);
    let shared = Arc::new(parent.clone());
    family.volumes = vec![parent, Volume::refined(&shared, INNER), Volume::refined(&shared, second)];
    let cut = Plane { normal: DVec3::new(1.0, 0.2, 0.0).normalize(), offset: 24.0 };
    let parts = vec![
        Body { region: vec![cut], ..Body::whole(1) },
        Body {
            region: vec![cut.flipped()],
            pose: Pose { translation: DVec3::new(9.0, 0.0, 0.0), ..Pose::IDENTITY },
            ..Body::whole(2)
        },
    ];
    for bodies in [vec![Body::whole(0)], parts] {
        for camera in views(DIMS) {
            let looks = frame(family.volumes[0].grid(), ramp(0.0, 4000.0), DVec3::X, [160, 128]);
            let mode = Mode::Iso(2450.0);
            let plain = Frame { camera, mode, lighting: Some(Lighting::default()), bodies: bodies.clone(), ..looks };
            let (without, with) = (family.draw(&gpu, &plain), family.draw(&gpu, &family.with_boxes(&plain)));
            let depth = without.depth_mm.iter().zip(&with.depth_mm);
            let holes = depth.clone().filter(|(a, b)| a.is_finite() != b.is_finite()).count();
            let off = depth.filter(|(a, _)| a.is_finite()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(holes == 0 && off < 0.01, "{} bodies: {holes} holes, {off} mm off", bodies.len());
            let light = worst(&without, &with);
            assert!(light <= 1.0, "{} bodies: {light} of 255", bodies.len());
        }
    }
}
