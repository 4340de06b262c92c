//! The picture by the book: every ray, every sample, in f64, on dense arrays.
//!
//! Written from the conventions of the picture: samples at t = k·step along the unit ray, half-open intervals, box faces at
//! −½ and n−½, opacity 1 − (1−α)^(step/unit), rays end under a transmittance of 1/256, overlapping bodies add extinctions.

use super::reference_boxes::Boxes;
use super::reference_refined::refined;
use burin::gpu::{Body, Fields, Frame, Image, LookRef, Mask, VolumeFields};
use burin::math::{DMat3, DVec2, DVec3, Plane, Ray};
use burin::volume::*;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Fields as plain arrays, x fastest.
pub struct Dense {
    grid: Grid,
    density: Vec<f64>,
    selection: Vec<f64>,
    colour: Vec<[f64; 4]>,
    labels: Vec<u16>,
    /// Where density is drawn coarser.
    coarse: Option<Coarse>,
    /// The volumes besides the first one.
    others: BTreeMap<VolumeId, Dense>,
}

/// Density at the level that each brick of level 0 is drawn from, bricks x fastest.
struct Coarse {
    bricks: [i64; 3],
    level_of: Vec<u32>,
    /// Voxels and values of every level.
    levels: Vec<([i64; 3], Vec<f64>)>,
}

/// One pixel.
#[derive(Clone, Copy, Debug)]
pub struct Pixel {
    pub colour: [f64; 4],
    pub depth_mm: f64,
    pub object: u32,
}

/// Place of a voxel in an array of dims `d`, x fastest; the nearest one for those beside it.
fn index(d: [i64; 3], v: [i64; 3]) -> usize {
    let c: [i64; 3] = std::array::from_fn(|a| v[a].clamp(0, d[a] - 1));
    (c[0] + d[0] * (c[1] + d[1] * c[2])) as usize
}

/// Between the eight voxels about a place.
fn linear(dims: [i64; 3], values: impl Fn(usize) -> f64, p: DVec3) -> f64 {
    let lo = p.floor();
    let f = p - lo;
    let tap = |x: i64, y: i64, z: i64| values(index(dims, [lo.x as i64 + x, lo.y as i64 + y, lo.z as i64 + z]));
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let plane = |z| mix(mix(tap(0, 0, z), tap(1, 0, z), f.x), mix(tap(0, 1, z), tap(1, 1, z), f.x), f.y);
    mix(plane(0), plane(1), f.z)
}

pub(super) const NOTHING: Pixel = Pixel { colour: [0.0; 4], depth_mm: f64::INFINITY, object: 0 };

impl Dense {
    /// All volumes of `fields`, each on its own grid.
    pub fn many(fields: &Fields<'_>) -> Self {
        let mut all: BTreeMap<_, _> = fields.iter().map(|(id, v)| (id, Self::of_volume(v, &v.grid))).collect();
        let first = all.remove(&VolumeId::FIRST).unwrap();
        Self { others: all, ..first }
    }

    pub fn of(fields: &Fields<'_>, grid: &Grid) -> Self {
        Self::of_volume(fields.get(VolumeId::FIRST).unwrap(), grid)
    }

    fn volume(&self, id: VolumeId) -> &Self {
        self.others.get(&id).unwrap_or(self)
    }

    fn label(&self, p: DVec3) -> u16 {
        let voxel = (p + 0.5).floor();
        self.labels[self.index([voxel.x as i64, voxel.y as i64, voxel.z as i64])]
    }

    fn of_volume(fields: &VolumeFields<'_>, grid: &Grid) -> Self {
        let texels = |f: &Field| {
            let bytes = f.format().bytes();
            let all = f.read(0, [0; 3], grid.dims).unwrap();
            let texel = |t: &[u8]| std::array::from_fn::<u8, 4, _>(|i| t.get(i).copied().unwrap_or(0));
            all.chunks_exact(bytes).map(texel).collect::<Vec<[u8; 4]>>()
        };
        let unorm = |b: u8| f64::from(b) / 255.0;
        Self {
            grid: *grid,
            density: texels(fields.density).iter().map(|&t| fields.density.map().decode(t)).collect(),
            selection: texels(fields.selection).iter().map(|t| unorm(t[0])).collect(),
            colour: texels(fields.colour).iter().map(|t| t.map(unorm)).collect(),
            labels: texels(fields.labels).iter().map(|t| u16::from_le_bytes([t[0], t[1]])).collect(),
            coarse: None,
            others: BTreeMap::new(),
        }
    }

    /// The same with density drawn from a level for each brick of level 0, x fastest: a sample belongs to the brick
    /// ⌊(p + ½)/32⌋, and lies at (p + ½)/2^level − ½ in voxels of the level.
    pub fn at_levels(fields: &Fields<'_>, grid: &Grid, level_of: Vec<u32>) -> Self {
        let density = fields.get(VolumeId::FIRST).unwrap().density;
        let level = |level: u8| {
            let all = density.read(level, [0; 3], density.dims(level)).unwrap();
            let value = |t: &[u8]| density.map().decode(std::array::from_fn(|i| t.get(i).copied().unwrap_or(0)));
            (density.dims(level).map(i64::from), all.chunks_exact(density.format().bytes()).map(value).collect())
        };
        let levels = (0..density.level_count()).map(level).collect();
        let bricks = grid.dims.map(|n| i64::from(n.div_ceil(32)));
        Self { coarse: Some(Coarse { bricks, level_of, levels }), ..Self::of(fields, grid) }
    }

    fn index(&self, v: [i64; 3]) -> usize {
        index(self.grid.dims.map(i64::from), v)
    }

    fn linear(&self, values: impl Fn(usize) -> f64, p: DVec3) -> f64 {
        linear(self.grid.dims.map(i64::from), values, p)
    }

    pub(super) fn density(&self, p: DVec3) -> f64 {
        let Some(coarse) = &self.coarse else { return self.linear(|i| self.density[i], p) };
        let brick = ((p + 0.5) / 32.0).floor();
        let level = coarse.level_of[index(coarse.bricks, [brick.x as i64, brick.y as i64, brick.z as i64])];
        let (dims, values) = &coarse.levels[level as usize];
        linear(*dims, |i| values[i], (p + 0.5) / f64::from(1_u32 << level) - 0.5)
    }

    pub(super) fn selection(&self, p: DVec3) -> f64 {
        self.linear(|i| self.selection[i], p)
    }

    pub(super) fn gradient(&self, value: impl Fn(DVec3) -> f64, p: DVec3) -> DVec3 {
        let along = |axis: DVec3| {
            let d = value(p + axis * 0.5) - value(p - axis * 0.5);
            if d.is_nan() { 0.0 } else { d }
        };
        DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
    }
}

/// A body as seen from one ray.
pub(super) struct Met<'a> {
    /// The body's volume.
    pub(super) dense: &'a Dense,
    frame: &'a Frame,
    pub(super) body: &'a Body,
    index: Ray,
    pub(super) index_from_world: DMat3,
    pub(super) entry: f64,
    pub(super) exit: f64,
    entry_normal: DVec3,
    /// What layers leave of the interval: from, to, and the outward normal of the face by which the ray comes in.
    pieces: Vec<(f64, f64, DVec3)>,
}

impl Met<'_> {
    pub(super) fn at(&self, t: f64) -> DVec3 {
        self.index.at(t)
    }

    fn holds(&self, t: f64) -> bool {
        self.pieces.iter().any(|p| p.0 <= t && t < p.1)
    }

    /// The look of the matter at a place; `None` where the place is not the body's.
    pub(super) fn look(&self, p: DVec3) -> Option<LookRef<'_>> {
        match &self.body.labels {
            Some(labels) => labels.row(self.dense.label(p)).map(|row| self.frame.look(Some(row))),
            None => Some(self.frame.look(self.body.look)),
        }
    }
}

fn meet<'a>(dense: &'a Dense, frame: &'a Frame, layers: &Boxes, body: &'a Body, ray: &Ray) -> Option<Met<'a>> {
    let dense = dense.volume(body.volume);
    let rest = body.pose.unapply_ray(ray);
    let map = dense.grid.index_from_world();
    let index = Ray { origin: map.transform_point3(rest.origin), dir: map.transform_vector3(rest.dir) };
    // Faces of the box in index space, brought to the world as (normal there, its planes in index space).
    let n = dense.grid.dims_f64();
    let mut faces: Vec<(f64, f64, DVec3)> = Vec::new();
    for (axis, extent) in [(DVec3::X, n.x), (DVec3::Y, n.y), (DVec3::Z, n.z)] {
        for (normal, offset) in [(axis, extent - 0.5), (-axis, 0.5)] {
            let world = (map.matrix3.transpose() * normal).normalize();
            faces.push((normal.dot(index.origin) - offset, normal.dot(index.dir), world));
        }
    }
    for Plane { normal, offset } in &body.region {
        faces.push((normal.dot(rest.origin) - offset, normal.dot(rest.dir), *normal));
    }
    for Plane { normal, offset } in &frame.layers.clips {
        let at_rest = body.pose.rotation.inverse() * *normal;
        faces.push((normal.dot(ray.origin) - offset, normal.dot(ray.dir), at_rest));
    }
    let mut met = Met {
        dense,
        frame,
        body,
        index,
        index_from_world: map.matrix3,
        entry: 0.0,
        exit: f64::INFINITY,
        entry_normal: -rest.dir,
        pieces: Vec::new(),
    };
    for (distance, slope, normal) in faces {
        if slope < 0.0 && -distance / slope > met.entry {
            met.entry = -distance / slope;
            met.entry_normal = normal;
        } else if slope > 0.0 {
            met.exit = met.exit.min(-distance / slope);
        } else if slope == 0.0 && distance > 0.0 {
            return None;
        }
    }
    met.entry_normal = body.pose.rotation * met.entry_normal;
    let (from, to, normal) = layers.piece(ray)?;
    if from > met.entry {
        (met.entry, met.entry_normal) = (from, normal);
    }
    met.exit = met.exit.min(to);
    let far = layers.nearest(ray).map_or(f64::INFINITY, |s| s.depth_mm);
    met.pieces = layers.pieces(ray, (met.entry, met.exit.min(far)), met.entry_normal);
    (!met.pieces.is_empty()).then_some(met)
}

/// The share of a body in matter of selection s.
pub(super) fn weight(mask: Mask, s: f64) -> f64 {
    match mask {
        Mask::None => 1.0,
        Mask::Selection => s,
        Mask::Background => 1.0 - s,
    }
}

fn shade(look: LookRef<'_>, rgb: [f64; 3], cosine: f64) -> [f64; 3] {
    let Some(l) = look.lighting else { return rgb };
    let c = cosine.abs();
    let white = f64::from(l.specular) * c.powf(f64::from(l.power));
    rgb.map(|x| x * (f64::from(l.ambient) + f64::from(l.diffuse) * c) + white)
}

/// Cosine of a gradient in index space with the ray.
fn cosine(met: &Met<'_>, ray: &Ray, gradient: DVec3) -> f64 {
    let world = met.body.pose.rotation * (met.index_from_world.transpose() * gradient);
    if world == DVec3::ZERO { 1.0 } else { world.normalize().dot(ray.dir) }
}

pub(super) fn painted(dense: &Dense, frame: &Frame, body: &Body, rgb: [f32; 3], p: DVec3) -> [f64; 3] {
    let mut c = rgb.map(f64::from);
    let over = |c: [f64; 3], paint: [f64; 3], a: f64| std::array::from_fn(|i| c[i] + (paint[i] - c[i]) * a);
    let paint: [f64; 4] = std::array::from_fn(|i| dense.linear(|v| dense.colour[v][i], p));
    let overlay = frame.overlay_of(body.volume);
    c = over(c, [paint[0], paint[1], paint[2]], paint[3] * f64::from(overlay.colour));
    if let Some(s) = overlay.segments.get(dense.label(p)).filter(|s| s.visible) {
        c = over(c, s.colour.map(f64::from), if body.own_colours { 0.0 } else { f64::from(overlay.labels) });
    }
    let tint = overlay.selection_colour.map(f64::from);
    if !(body.own_colours && body.mask == Mask::Selection) {
        c = over(c, tint, dense.selection(p) * f64::from(overlay.selection));
    }
    let own = body.tint.unwrap_or([1.0; 3]);
    std::array::from_fn(|i| c[i] * f64::from(own[i]))
}

/// A sample that stands for a whole body: an iso-surface, or a maximum.
pub(super) struct Event {
    /// Where it lies among the samples of others, mm.
    pub(super) at: f64,
    pub(super) depth_mm: f64,
    pub(super) rgb: [f64; 3],
    pub(super) alpha: f64,
    pub(super) object: u32,
}

/// Lays a sample behind what is there; `clear` is what light still comes through.
pub(super) fn lay(pixel: &mut Pixel, clear: &mut f64, (rgb, alpha): ([f64; 3], f64), depth_mm: f64, object: u32) {
    for (c, l) in pixel.colour.iter_mut().zip(rgb) {
        *c += *clear * alpha * l;
    }
    if *clear > 0.5 && *clear * (1.0 - alpha) <= 0.5 {
        (pixel.depth_mm, pixel.object) = (depth_mm, object);
    }
    *clear *= 1.0 - alpha;
}

/// Bodies of direct volume rendering, with events between their samples: an event comes before a sample at the same place.
fn dvr(frame: &Frame, met: &[Met<'_>], events: Vec<Event>, ray: &Ray) -> Pixel {
    let step = frame.step_mm;
    let mut pixel = NOTHING;
    let mut clear = 1.0;
    let first = met.iter().map(|m| m.entry).fold(f64::INFINITY, f64::min);
    let last = met.iter().map(|m| m.exit).fold(0.0, f64::max);
    let mut events = events.into_iter().peekable();
    let mut k = (first / step).ceil();
    while k * step < last && clear >= 1.0 / 256.0 {
        let t = k * step;
        while let Some(e) = events.next_if(|e| e.at <= t && clear >= 1.0 / 256.0) {
            lay(&mut pixel, &mut clear, (e.rgb, e.alpha), e.depth_mm, e.object);
        }
        if clear < 1.0 / 256.0 {
            break;
        }
        let (mut extinction, mut light) = (0.0, [0.0; 3]);
        let mut strongest = (0.0, 0);
        for m in met.iter().filter(|m| m.holds(t)) {
            let (p, dense) = (m.at(t), m.dense);
            let value = dense.density(p);
            let Some(look) = m.look(p).filter(|_| !value.is_nan()) else { continue };
            let thin = f64::from(look.transfer.opacity_at(value)) * f64::from(look.opacity);
            let alpha = 1.0 - (1.0 - thin).powf(step / look.transfer.unit_mm);
            let own = -(1.0 - alpha).max(1e-300).ln() * weight(m.body.mask, dense.selection(p));
            if own <= 0.0 {
                continue;
            }
            let mut rgb = painted(dense, frame, m.body, look.transfer.colour_at(value), p);
            if look.lighting.is_some() {
                let g = dense.gradient(|p| dense.density(p), p);
                rgb = shade(look, rgb, cosine(m, ray, g));
            }
            extinction += own;
            light = std::array::from_fn(|i| light[i] + rgb[i] * own);
            if own > strongest.0 {
                strongest = (own, m.body.id + 1);
            }
        }
        if extinction > 0.0 {
            let rgb = light.map(|l| l / extinction);
            lay(&mut pixel, &mut clear, (rgb, 1.0 - f64::exp(-extinction)), t, strongest.1);
        }
        k += 1.0;
    }
    for e in events {
        if clear >= 1.0 / 256.0 {
            lay(&mut pixel, &mut clear, (e.rgb, e.alpha), e.depth_mm, e.object);
        }
    }
    pixel.colour[3] = 1.0 - clear;
    pixel
}

/// The first hit of a body: mm, colour, opacity.
fn surface(frame: &Frame, m: &Met<'_>, ray: &Ray) -> Option<(f64, [f64; 3], f64)> {
    let (step, dense) = (frame.step_mm, m.dense);
    let level = |p: DVec3| match m.look(p)?.mode {
        Mode::Iso(level) => Some(level),
        _ => None,
    };
    let dense_at = |t: f64| level(m.at(t)).is_some_and(|level| dense.density(m.at(t)) >= level);
    let owned_at = |t: f64| match m.body.mask {
        Mask::None => true,
        Mask::Selection => dense.selection(m.at(t)) >= 0.5,
        Mask::Background => dense.selection(m.at(t)) < 0.5,
    };
    let inside = |t: f64| dense_at(t) && owned_at(t);
    let by_step = |entry: f64, exit: f64| {
        let mut k = (entry / step).ceil();
        while k * step < exit && !inside(k * step) {
            k += 1.0;
        }
        if k * step >= exit {
            return None;
        }
        let (mut outer, mut inner) = (((k - 1.0) * step).max(entry), k * step);
        for _ in 0..40 {
            let middle = 0.5 * (outer + inner);
            if inside(middle) { inner = middle } else { outer = middle }
        }
        let p = m.at(inner);
        let by_mask = m.body.mask != Mask::None && dense_at(outer);
        let g =
            if by_mask { dense.gradient(|p| dense.selection(p), p) } else { dense.gradient(|p| dense.density(p), p) };
        Some((inner, cosine(m, ray, g)))
    };
    let hit = |&(entry, exit, normal): &(f64, f64, DVec3)| {
        if inside(entry) { Some((entry, normal.dot(ray.dir))) } else { by_step(entry, exit) }
    };
    let (t, cosine) = m.pieces.iter().find_map(hit)?;
    let (p, look) = (m.at(t), m.look(m.at(t))?);
    let rgb = painted(dense, frame, m.body, look.transfer.colour_at(level(p)?), p);
    Some((t, shade(look, rgb, cosine), f64::from(look.opacity)))
}

fn iso(frame: &Frame, met: &[Met<'_>], ray: &Ray) -> Pixel {
    let mut best = NOTHING;
    for m in met {
        if let Some((t, [r, g, b], _)) = surface(frame, m, ray).filter(|hit| hit.0 < best.depth_mm) {
            best = Pixel { colour: [r, g, b, 1.0], depth_mm: t, object: m.body.id + 1 };
        }
    }
    best
}

/// The largest value of a body, and where.
fn largest(frame: &Frame, m: &Met<'_>) -> Option<(f64, f64)> {
    let mut best: Option<(f64, f64)> = None;
    let mut k = (m.entry / frame.step_mm).ceil();
    while k * frame.step_mm < m.exit {
        let (t, p) = (k * frame.step_mm, m.at(k * frame.step_mm));
        let value = m.dense.density(p);
        let owned = m.holds(t) && weight(m.body.mask, if m.dense.selection(p) >= 0.5 { 1.0 } else { 0.0 }) > 0.0;
        if owned && m.look(p).is_some() && !value.is_nan() && best.is_none_or(|b| value > b.0) {
            best = Some((value, t));
        }
        k += 1.0;
    }
    best
}

/// Bodies of several modes: an iso-surface is one sample of its opacity, a maximum one sample at the span's end.
fn modes(frame: &Frame, met: Vec<Met<'_>>, ray: &Ray) -> Pixel {
    let mut events: Vec<Event> = Vec::new();
    let (samples, whole): (Vec<_>, Vec<_>) = met.into_iter().partition(|m| mode_of(frame, m.body) == Mode::Dvr);
    for m in &whole {
        let object = m.body.id + 1;
        match mode_of(frame, m.body) {
            Mode::Mip => {
                let Some((value, t)) = largest(frame, m) else { continue };
                let (p, look) = (m.at(t), m.look(m.at(t)).unwrap());
                let alpha = f64::from(look.transfer.opacity_at(value)) * f64::from(look.opacity);
                let rgb = painted(m.dense, frame, m.body, look.transfer.colour_at(value), p);
                events.push(Event { at: m.exit, depth_mm: t, rgb, alpha, object });
            }
            _ => {
                let Some((t, rgb, alpha)) = surface(frame, m, ray) else { continue };
                events.push(Event { at: t, depth_mm: t, rgb, alpha, object });
            }
        }
    }
    // Bodies come in the order of their names; a stable sort keeps it among events at one place.
    let place = |e: &Event| (e.at / frame.step_mm * 500.0).round() as i64;
    events.sort_by_key(place);
    if frame.refine { refined(frame, &samples, events, ray) } else { dvr(frame, &samples, events, ray) }
}

/// The kind of mode that a body has.
fn mode_of(frame: &Frame, body: &Body) -> Mode {
    let row = body.labels.as_ref().map_or(body.look, |labels| labels.rows().first().copied());
    frame.look(row).mode
}

fn mip(dense: &Dense, frame: &Frame, met: &[Met<'_>]) -> Pixel {
    let mut best: Option<(f64, f64, &Met<'_>)> = None;
    for m in met {
        let mut k = (m.entry / frame.step_mm).ceil();
        while k * frame.step_mm < m.exit {
            let p = m.at(k * frame.step_mm);
            let value = dense.density(p);
            if m.holds(k * frame.step_mm)
                && weight(m.body.mask, if dense.selection(p) >= 0.5 { 1.0 } else { 0.0 }) > 0.0
                && !value.is_nan()
                && best.is_none_or(|b| value > b.0 || (value == b.0 && k * frame.step_mm < b.1))
            {
                best = Some((value, k * frame.step_mm, m));
            }
            k += 1.0;
        }
    }
    let Some((value, t, m)) = best else { return NOTHING };
    let look = frame.look(m.body.look);
    let alpha = f64::from(look.transfer.opacity_at(value) * look.opacity);
    let rgb = painted(dense, frame, m.body, look.transfer.colour_at(value), m.at(t));
    if alpha == 0.0 {
        return NOTHING;
    }
    Pixel { colour: [rgb[0] * alpha, rgb[1] * alpha, rgb[2] * alpha, alpha], depth_mm: t, object: m.body.id + 1 }
}

/// The pixel whose centre is at `px`.
pub fn pixel(dense: &Dense, frame: &Frame, px: DVec2) -> Pixel {
    pixel_among(dense, frame, &Boxes::default(), px)
}

/// All pixels, row by row.
pub fn picture(dense: &Dense, frame: &Frame) -> Vec<Pixel> {
    picture_among(dense, frame, &Boxes::default())
}

/// The same among the boxes that the frame's meshes are.
pub fn picture_among(dense: &Dense, frame: &Frame, layers: &Boxes) -> Vec<Pixel> {
    let [w, h] = frame.size;
    let centre = |i: u32| DVec2::new(f64::from(i % w) + 0.5, f64::from(i / w) + 0.5);
    (0..w * h).into_par_iter().map(|i| pixel_among(dense, frame, layers, centre(i))).collect()
}

fn pixel_among(dense: &Dense, frame: &Frame, layers: &Boxes, px: DVec2) -> Pixel {
    let ray = frame.camera.ray(px, frame.size);
    let mut bodies: Vec<&Body> = frame.bodies.iter().collect();
    bodies.sort_by_key(|b| (b.id, b.volume));
    let met: Vec<_> = bodies.into_iter().filter_map(|b| meet(dense, frame, layers, b, &ray)).collect();
    let looks: Vec<_> = frame.bodies.iter().flat_map(|b| frame.looks_of(b)).collect();
    let one = looks.windows(2).all(|pair| pair[0] == pair[1]) && frame.volumes().len() < 2;
    let all = |of: fn(Mode) -> bool| looks.iter().all(|look| of(look.mode));
    let front = if all(|mode| mode == Mode::Dvr) {
        if frame.refine { refined(frame, &met, Vec::new(), &ray) } else { dvr(frame, &met, Vec::new(), &ray) }
    } else if all(|mode| matches!(mode, Mode::Iso(_))) && looks.iter().all(|look| look.opacity == 1.0) {
        iso(frame, &met, &ray)
    } else if one && all(|mode| mode == Mode::Mip) {
        mip(dense, frame, &met)
    } else {
        modes(frame, met, &ray)
    };
    let drawn =
        |back: &Pixel| layers.piece(&ray).is_some_and(|(from, to, _)| from <= back.depth_mm && back.depth_mm < to);
    let Some(back) = layers.nearest(&ray).filter(drawn) else { return front };
    let clear = 1.0 - front.colour[3];
    let colour = std::array::from_fn(|i| front.colour[i] + clear * back.colour[i]);
    // A pixel is where its opacity reaches ½.
    if clear > 0.5 { Pixel { colour, ..back } } else { Pixel { colour, ..front } }
}

/// How far an image is from the reference, in 8-bit steps of colour and alpha.
#[derive(Clone, Copy, Debug)]
pub struct Difference {
    pub largest: f64,
    pub mean: f64,
    /// Share of pixels that differ by more than 1.
    pub beyond_one: f64,
    /// Share of pixels whose object differs, or whose depth differs by more than a step.
    pub misplaced: f64,
    /// Share of pixels with anything in them.
    pub covered: f64,
}

pub fn difference(image: &Image, reference: &[Pixel], step_mm: f64) -> Difference {
    let d = apart(image, reference, step_mm);
    crate::common::oracle::tell(d.largest, d.mean);
    d
}

/// The same where the reference is of another picture, and is to differ.
pub fn apart(image: &Image, reference: &[Pixel], step_mm: f64) -> Difference {
    let count = reference.len() as f64;
    let mut d = Difference { largest: 0.0, mean: 0.0, beyond_one: 0.0, misplaced: 0.0, covered: 0.0 };
    for (i, r) in reference.iter().enumerate() {
        let here = (0..4)
            .map(|c| (f64::from(image.colour[i][c]).clamp(0.0, 1.0) - r.colour[c].clamp(0.0, 1.0)).abs() * 255.0)
            .fold(0.0, f64::max);
        d.largest = d.largest.max(here);
        d.mean += here / count;
        d.beyond_one += f64::from(u8::from(here > 1.0)) / count;
        let off = match (f64::from(image.depth_mm[i]), r.depth_mm) {
            (a, b) if a.is_infinite() || b.is_infinite() => a != b,
            (a, b) => (a - b).abs() > 1.01 * step_mm,
        };
        d.misplaced += f64::from(u8::from(off || image.object[i].body().map_or(0, |id| id + 1) != r.object)) / count;
        d.covered += f64::from(u8::from(r.colour[3] > 0.0)) / count;
    }
    d
}
