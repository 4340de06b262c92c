//! Rays through volumes with boxes of a resolution of their own, by the book, in f64.
//!
//! A step of a ray that begins in a box is divided as often as the box is finer, each part that begins in a box of that box again;
//! what a part meets is told by where it lies. Surfaces are sought at the faces of boxes too, and in all of an outermost box as
//! finely as in the finest that the ray meets there.

use super::reference_family::{Book, Family};
use burin::gpu::{Body, Frame, Gpu, LookRef, Mask};
use burin::math::{DVec2, DVec3, Plane, Ray};
use burin::volume::*;
use rayon::prelude::*;

/// Matter that is the same on a part of a ray, mm.
struct Matter {
    from: f64,
    to: f64,
    rgb: [f64; 3],
    extinction: f64,
}

/// Where it lies among others, where it shows, colour, opacity.
type Event = (f64, f64, [f64; 3], f64);

/// What a ray gathers: extinctions of matter in one place add, colours are weighted by them. A sample that begins
/// before an event comes before it.
fn compose(mut matter: Vec<Matter>, mut events: Vec<Event>) -> Seen {
    let (mut seen, mut clear) = (Seen { colour: [0.0; 4], depth_mm: f64::INFINITY }, 1.0);
    let mut lay = |t: f64, rgb: [f64; 3], alpha: f64| {
        if clear < 1.0 / 256.0 {
            return;
        }
        for (c, own) in seen.colour.iter_mut().zip(rgb) {
            *c += clear * alpha * own;
        }
        if clear > 0.5 && clear * (1.0 - alpha) <= 0.5 {
            seen.depth_mm = t;
        }
        clear *= 1.0 - alpha;
        seen.colour[3] = 1.0 - clear;
    };
    matter.sort_by(|a, b| a.from.total_cmp(&b.from));
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut rest = matter.as_slice();
    for event in events.into_iter().map(Some).chain([None]) {
        let until = event.map_or(f64::INFINITY, |e| e.0);
        let (before, behind) = rest.split_at(rest.partition_point(|m| m.from < until));
        rest = behind;
        let mut ends: Vec<f64> = before.iter().flat_map(|m| [m.from, m.to]).collect();
        ends.sort_by(f64::total_cmp);
        ends.dedup();
        let mut first = 0;
        for pair in ends.windows(2) {
            let middle = 0.5 * (pair[0] + pair[1]);
            while before.get(first).is_some_and(|m| m.to <= middle) {
                first += 1;
            }
            let here = before[first..].iter().take_while(|m| m.from < middle).filter(|m| m.to > middle);
            let (mut sum, mut rgb) = (0.0, [0.0; 3]);
            for m in here {
                sum += m.extinction;
                rgb = std::array::from_fn(|c| rgb[c] + m.extinction * m.rgb[c]);
            }
            if sum > 0.0 {
                let alpha = 1.0 - (-sum.min(1e9) * (pair[1] - pair[0])).exp();
                lay(pair[0], rgb.map(|c| c / sum), alpha);
            }
        }
        if let Some((_, t, rgb, alpha)) = event {
            lay(t, rgb, alpha);
        }
    }
    seen
}

/// What a pixel shows.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    pub colour: [f64; 4],
    pub depth_mm: f64,
}

/// A body's ray.
struct Along<'a> {
    body: &'a Body,
    /// By volume: of the body of the same name that is cut out of it.
    looks: Vec<Option<LookRef<'a>>>,
    /// What it is cut out of.
    volume: usize,
    index: Ray,
    entry: f64,
    exit: f64,
    /// Of the face that it enters by, in the world.
    normal: DVec3,
}

impl Book<'_> {
    /// The value at a place of a body's ray.
    fn value_of(&self, m: &Along<'_>, p: DVec3) -> f64 {
        if m.volume == 0 { self.value(p) } else { self.values[m.volume].at(p) }
    }

    /// A body's ray, if it meets it.
    fn along<'b>(&self, frame: &'b Frame, body: &'b Body, ray: &Ray) -> Option<Along<'b>> {
        let rest = body.pose.unapply_ray(ray);
        let volume = body.volume.0 as usize;
        let grid = self.family.volumes[volume].grid();
        let map = grid.index_from_world();
        let index = Ray { origin: map.transform_point3(rest.origin), dir: map.transform_vector3(rest.dir) };
        let n = grid.dims_f64();
        let mut faces: Vec<(f64, f64, DVec3)> = Vec::new();
        for axis in 0..3 {
            for (normal, offset) in [(DVec3::AXES[axis], n[axis] - 0.5), (-DVec3::AXES[axis], 0.5)] {
                let world = (map.matrix3.transpose() * normal).normalize();
                faces.push((normal.dot(index.origin) - offset, normal.dot(index.dir), body.pose.rotation * world));
            }
        }
        for Plane { normal, offset } in &body.region {
            let world = body.pose.rotation * *normal;
            faces.push((normal.dot(rest.origin) - offset, normal.dot(rest.dir), world));
        }
        for Plane { normal, offset } in &frame.layers.clips {
            faces.push((normal.dot(ray.origin) - offset, normal.dot(ray.dir), *normal));
        }
        let (mut entry, mut exit, mut normal) = (0.0, f64::INFINITY, -ray.dir);
        for (distance, slope, face) in faces {
            if slope < 0.0 && -distance / slope > entry {
                (entry, normal) = (-distance / slope, face);
            } else if slope > 0.0 {
                exit = f64::min(exit, -distance / slope);
            } else if slope == 0.0 && distance > 0.0 {
                return None;
            }
        }
        let looks = self.boxes().map(|v| VolumeId(v as u32)).map(|of_box| {
            let same = |b: &&Body| (b.id, b.mask, b.volume) == (body.id, body.mask, of_box);
            frame.bodies.iter().find(same).map(|b| frame.look(b.look))
        });
        let looks = [Some(frame.look(body.look))].into_iter().chain(looks).collect();
        (entry < exit).then_some(Along { body, looks, volume, index, entry, exit, normal })
    }

    /// Where a ray is in a box: from, to.
    fn span(&self, volume: usize, index: &Ray) -> Option<(f64, f64)> {
        Some(self.slab(volume, index)).filter(|(t0, t1)| t0 < t1)
    }

    /// Where a ray comes into the last of a box's slabs and where it leaves the first; it misses the box where that is before.
    fn slab(&self, volume: usize, index: &Ray) -> (f64, f64) {
        let o = self.own_place(volume, index.origin);
        let d = self.own_place(volume, index.origin + index.dir) - o;
        let last = self.last(volume);
        let (mut t0, mut t1) = (0.0_f64, f64::INFINITY);
        for a in 0..3 {
            let d = if d[a] == 0.0 { 1e-20 } else { d[a] };
            let (u, v) = (-o[a] / d, (last[a] - o[a]) / d);
            (t0, t1) = (t0.max(u.min(v)), t1.min(u.max(v)));
        }
        (t0, t1)
    }

    fn divide(&self, m: &Along<'_>, step: f64, (k, steps, volume): (f64, f64, usize), out: &mut Vec<(f64, f64)>) {
        match self.child_at(volume, m.index.at(k * step)) {
            Some(child) => {
                let finer = f64::from(self.family.boxes[child - 1].finer);
                for part in 0..self.family.boxes[child - 1].finer {
                    let at = k + f64::from(part) / (steps * finer);
                    self.divide(m, step, (at, steps * finer, child), out);
                }
            }
            None => out.push((k * step, 1.0 / steps)),
        }
    }

    /// Samples of a body: mm, and for which part of a step they stand.
    fn samples(&self, m: &Along<'_>, step: f64) -> Vec<(f64, f64)> {
        let mut out = Vec::new();
        let mut k = (m.entry / step).floor();
        while k * step < m.exit {
            if m.volume == 0 {
                self.divide(m, step, (k, 1.0, 0), &mut out);
            } else {
                out.push((k * step, 1.0));
            }
            k += 1.0;
        }
        out.retain(|s| m.entry <= s.0 && s.0 < m.exit);
        out
    }

    /// What of the light each sample of a body's share of matter lets through, and where, mm.
    pub fn fading(&self, frame: &Frame, body: &Body, ray: &Ray) -> Vec<(f64, f64)> {
        let Some(m) = self.along(frame, body, ray) else { return Vec::new() };
        let through = |(t, share): (f64, f64)| {
            let p = m.index.at(t);
            let look = self.look(&m, p).unwrap();
            let thin = f64::from(look.transfer.opacity_at(self.value(p))) * f64::from(look.opacity);
            let own = match body.mask {
                Mask::None => 1.0,
                Mask::Selection => self.selected(p),
                Mask::Background => 1.0 - self.selected(p),
            };
            (t, (1.0 - thin).powf(own * share * frame.step_mm / look.transfer.unit_mm))
        };
        self.samples(&m, frame.step_mm).into_iter().map(through).collect()
    }

    /// The look of the matter at a place of a body's ray.
    fn look<'b>(&self, m: &Along<'b>, p: DVec3) -> Option<LookRef<'b>> {
        m.looks[if m.volume == 0 { self.holder(p) } else { 0 }]
    }

    fn light(&self, look: LookRef<'_>, ray: &Ray, rgb: [f32; 3], normal: DVec3) -> [f64; 3] {
        let rgb = rgb.map(f64::from);
        let Some(l) = look.lighting else { return rgb };
        let c = if normal == DVec3::ZERO { 1.0 } else { normal.normalize().dot(ray.dir).abs() };
        let white = f64::from(l.specular) * c.powf(f64::from(l.power));
        rgb.map(|x| x * (f64::from(l.ambient) + f64::from(l.diffuse) * c) + white)
    }

    /// The normal of the values at a place, in the world.
    fn normal(&self, m: &Along<'_>, p: DVec3) -> DVec3 {
        let map = self.family.volumes[m.volume].grid().index_from_world();
        let gradient = if m.volume == 0 {
            self.gradient(self.holder(p), p)
        } else {
            let along = |a: DVec3| self.value_of(m, p + a * 0.5) - self.value_of(m, p - a * 0.5);
            DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
        };
        m.body.pose.rotation * (map.matrix3.transpose() * gradient)
    }

    /// Where a surface is sought along a ray, in order.
    fn looks(&self, m: &Along<'_>, step: f64) -> Vec<f64> {
        let (mut all, mut outer) = (vec![m.entry], Vec::new());
        for volume in self.boxes() {
            let Some(span) = self.span(volume, &m.index) else { continue };
            all.extend([span.0, span.1]);
            let mut top = volume;
            while self.host(top) != 0 {
                top = self.host(top);
            }
            outer.push((top, span, self.steps(volume)));
        }
        let mut k = (m.entry / step).floor();
        while k * step < m.exit {
            let t = k * step;
            all.push(t);
            let tops = outer.iter().filter(|o| self.host(o.0) == 0 && o.1.0 < t + step && t <= o.1.1);
            for (top, ..) in tops {
                let (from, to) = self.span(*top, &m.index).unwrap();
                let finest = outer.iter().filter(|o| o.0 == *top).map(|o| o.2).max().unwrap();
                let within = (0..finest).map(|i| t + step * f64::from(i) / f64::from(finest));
                all.extend(within.filter(|&t| from <= t && t < to));
            }
            k += 1.0;
        }
        all.retain(|&t| m.entry <= t && t < m.exit);
        all.sort_by(f64::total_cmp);
        all
    }

    /// The first place of a ray at or beyond a density, and whether the body is entered there.
    fn hit(&self, m: &Along<'_>, (look, level): (LookRef<'_>, f64), step: f64) -> Option<(f64, bool)> {
        let is_of = |p: DVec3| self.look(m, p) == Some(look);
        let dense = |t: f64| self.value_of(m, m.index.at(t)) >= level && is_of(m.index.at(t));
        let looks = self.looks(m, step);
        let at = looks.iter().position(|&t| dense(t))?;
        if at == 0 {
            return Some((looks[0], true));
        }
        let (mut outer, mut inner) = (looks[at - 1], looks[at]);
        for _ in 0..40 {
            let middle = 0.5 * (outer + inner);
            if dense(middle) { inner = middle } else { outer = middle }
        }
        Some((inner, false))
    }

    /// The maximum or the surface of what has a look: where it lies among others, where it shows, colour, opacity.
    fn event(&self, m: &Along<'_>, look: LookRef<'_>, step: f64, ray: &Ray) -> Option<Event> {
        let LookRef { transfer, mode, opacity, .. } = look;
        let Mode::Iso(level) = mode else {
            let all = self.samples(m, step).into_iter().map(|s| (m.index.at(s.0), s.0));
            let all = all.filter(|s| self.look(m, s.0) == Some(look)).map(|(p, t)| (self.value_of(m, p), t));
            let most = all.fold(None, |best: Option<(f64, f64)>, s| best.filter(|b| b.0 >= s.0).or(Some(s)));
            let (value, t) = most?;
            let alpha = f64::from(transfer.opacity_at(value)) * f64::from(opacity);
            let ends = m.looks.iter().enumerate().filter(|of| *of.1 == Some(look)).filter_map(|(volume, _)| {
                let span = if volume == 0 { Some((m.entry, m.exit)) } else { self.span(volume, &m.index) };
                span.map(|span| span.1.min(m.exit))
            });
            return Some((ends.fold(0.0, f64::max), t, transfer.colour_at(value).map(f64::from), alpha));
        };
        let (t, entered) = self.hit(m, (look, level), step)?;
        let normal = if entered { m.normal } else { self.normal(m, m.index.at(t)) };
        let colour = self.light(look, ray, transfer.colour_at(level), normal);
        Some((t, t, colour, f64::from(opacity)))
    }

    /// The pixel at a place of the picture.
    pub fn pixel(&self, frame: &Frame, px: DVec2) -> Seen {
        let ray = frame.camera.ray(px, frame.size);
        let step = frame.step_mm;
        let (mut matter, mut events) = (Vec::new(), Vec::new());
        let is_host = |b: &&Body| b.volume == VolumeId::FIRST || b.volume.0 as usize > self.family.boxes.len();
        for body in frame.bodies.iter().filter(is_host) {
            let Some(m) = self.along(frame, body, &ray) else { continue };
            matter.extend(self.samples(&m, step).into_iter().filter_map(|(t, share)| {
                let p = m.index.at(t);
                let look = self.look(&m, p).filter(|look| look.mode == Mode::Dvr)?;
                let value = self.value_of(&m, p);
                let thin = f64::from(look.transfer.opacity_at(value)) * f64::from(look.opacity);
                let extinction = -(1.0 - thin).ln() / look.transfer.unit_mm;
                let lit = || self.light(look, &ray, look.transfer.colour_at(value), self.normal(&m, p));
                (extinction > 0.0).then(|| Matter { from: t, to: t + share * step, rgb: lit(), extinction })
            }));
            // What is of one look is one maximum, one surface.
            let mut others: Vec<LookRef<'_>> = Vec::new();
            for look in m.looks.iter().flatten().filter(|look| look.mode != Mode::Dvr) {
                if !others.contains(look) {
                    others.push(*look);
                }
            }
            events.extend(others.into_iter().filter_map(|look| self.event(&m, look, step, &ray)));
        }
        compose(matter, events)
    }

    /// How long the ray of a pixel is in boxes of any body, mm; less than 0 by how little it misses them all.
    pub fn meets(&self, frame: &Frame, px: DVec2) -> f64 {
        let ray = frame.camera.ray(px, frame.size);
        let way = |body: &Body, volume: usize| {
            let map = self.family.volumes[0].grid().index_from_world();
            let rest = body.pose.unapply_ray(&ray);
            let index = Ray { origin: map.transform_point3(rest.origin), dir: map.transform_vector3(rest.dir) };
            let (t0, t1) = self.slab(volume, &index);
            t1 - t0
        };
        let of_body = |body| self.boxes().map(move |volume| way(body, volume));
        frame.bodies.iter().filter(|b| b.volume == VolumeId::FIRST).flat_map(of_body).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// How far a picture is from the book, in 8-bit steps of colour and opacity, and what it was held to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Apart {
    pub through: usize,
    pub furthest: f64,
    /// Pixels that are further off than 1.
    pub beyond_one: usize,
    /// Pixels whose depth is there in one only.
    pub lost: usize,
    /// Depths, mm.
    pub deep: f64,
}

/// The picture with boxes beside the book where rays meet them; where they miss them beside the one without, to the bit.
pub fn compare(family: &Family, gpu: &Gpu, plain: &Frame) -> Apart {
    compare_boxed(family, gpu, plain, &family.with_boxes(plain))
}

/// The same where boxes are shown in their own way.
pub fn compare_boxed(family: &Family, gpu: &Gpu, plain: &Frame, boxed: &Frame) -> Apart {
    let (without, with) = (family.draw(gpu, plain), family.draw(gpu, boxed));
    let book = Book::of(family);
    let centre = |i: usize| {
        let [x, y] = [i as u32 % plain.size[0], i as u32 / plain.size[0]];
        DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
    };
    let look = |i: usize| {
        let meets = book.meets(plain, centre(i));
        (meets, (meets > 1e-3).then(|| book.pixel(boxed, centre(i))))
    };
    let seen: Vec<_> = (0..with.colour.len()).into_par_iter().map(look).collect();
    let mut apart = Apart::default();
    for (i, (meets, seen)) in seen.into_iter().enumerate() {
        if meets < -1e-3 {
            let at = centre(i);
            assert_eq!(with.colour[i].map(f32::to_bits), without.colour[i].map(f32::to_bits), "{at}");
            assert_eq!(with.depth_mm[i].to_bits(), without.depth_mm[i].to_bits(), "{at}");
            assert_eq!(with.object[i], without.object[i], "{at}");
        }
        if let Some(s) = seen {
            apart.through += 1;
            let off = (0..4).map(|c| (f64::from(with.colour[i][c]) - s.colour[c]).abs() * 255.0).fold(0.0, f64::max);
            apart.furthest = apart.furthest.max(off);
            apart.beyond_one += usize::from(off > 1.0);
            let deep = (f64::from(with.depth_mm[i]) - s.depth_mm).abs();
            apart.lost += usize::from(with.depth_mm[i].is_finite() != s.depth_mm.is_finite());
            apart.deep = if deep.is_finite() { apart.deep.max(deep) } else { apart.deep };
        }
    }
    apart
}
