//! From the points of a stroke to its samples: those in mm, in index or on a slice as they are given, those in the 3D view by
//! looking at the surface all along the pointer's way.
//!
//! Looks lie at fixed lengths of the pointer's way from the stroke's first point on, as dabs do along their path, so that it does not
//! matter where and how often the pointer was sampled: a stroke is painted as far as its last whole pixel, and its end takes what is
//! left. Owns where in the picture a stroke has got to. What is joined and what breaks is `paint`'s rule.

use crate::document::Document;
use crate::document::command::Place;
use crate::document::command::brush::StrokePoint;
use crate::document::error::DocumentError;
use crate::document::scene::ViewName;
use crate::document::scene::check::direction;
use crate::document::state::State;
use crate::document::subject::Subject;
use crate::explode::Poses;
use crate::gpu::{Frame, Hit};
use crate::math::{Camera, DVec2, DVec3, Pose};
use crate::paint::{Sample, Seen, SurfaceRule};
use crate::volume::VolumeId;

/// Looks lie this share of a voxel apart at most, across the line of sight.
const LOOKS_VOXELS: f64 = 0.25;
/// Samples along a ray that looks lie this share of a voxel apart at most.
const STEP_VOXELS: f64 = 0.125;
/// Most looks from one point to the next, and from one pixel to the next.
const MOST_LOOKS: f64 = 65_536.0;
const MOST_LOOKS_PER_PIXEL: f64 = 4096.0;
/// Pixels that are none.
const SAME_PX: f64 = 1e-6;

/// A look and the pressure there.
type SeenAt = (Option<Seen>, f32);

/// Where a stroke in the 3D view has got to.
#[derive(Clone, Debug)]
pub(crate) struct Trail {
    camera: Camera,
    size: [u32; 2],
    rule: SurfaceRule,
    /// The pointer's last point and what is there.
    px: DVec2,
    pressure: f32,
    hit: Option<Hit>,
    /// What the last whole pixel met.
    whole: Option<Seen>,
    /// Looks since.
    rest: Vec<SeenAt>,
    /// Length of the way from the last look to the pointer, pixels.
    past: f64,
}

/// Points as samples.
#[derive(Debug, Default)]
pub(crate) struct Resolved {
    pub(crate) samples: Vec<Sample>,
    /// Points of the 3D view where nothing shows.
    pub(crate) missed: u64,
    pub(crate) trail: Option<Trail>,
    /// Whether the first point is one of a slice.
    pub(crate) on_slice: bool,
}

impl State {
    /// What a look into the 3D view is marched by: the picture on its plain lattice, with samples dense enough to tell where a surface
    /// of these volumes is.
    pub(crate) fn looking(&self, volumes: &[VolumeId], poses: &Poses, camera: &Camera, size: [u32; 2]) -> Frame {
        let frame = self.frame(poses, camera, size);
        // What fills a box is sampled the more densely by itself.
        let whole: Vec<_> = volumes.iter().copied().filter(|id| !frame.is_boxed(*id)).collect();
        let step_mm = frame.step_mm.min(STEP_VOXELS * self.finest_mm(&whole));
        Frame { step_mm, refine: false, ..frame }
    }

    /// The smallest spacing of these volumes, mm.
    fn finest_mm(&self, volumes: &[VolumeId]) -> f64 {
        let subjects = volumes.iter().filter_map(|id| self.subject(*id));
        subjects.map(|subject| subject.grid().voxel_mm()).fold(f64::INFINITY, f64::min)
    }
}

impl Document {
    /// Resolves the points of a stroke on these volumes, the first after `trail`. Places in index and on slices are those of the first
    /// volume; pixels of the 3D view are what the picture shows there, of whatever volume, looked at as finely as the finest of
    /// them needs.
    ///
    /// # Errors
    /// As [`resolve`](Self::resolve).
    pub(crate) fn follow(
        &mut self,
        volumes: &[VolumeId],
        points: &[StrokePoint],
        trail: Option<Trail>,
    ) -> Result<Resolved, DocumentError> {
        let on_slice = |p: &StrokePoint| matches!(p.at, Place::Pixel { view, .. } if view != ViewName::ThreeD);
        let mut resolved = Resolved { trail, on_slice: points.first().is_some_and(on_slice), ..Resolved::default() };
        for point in points {
            match point.at {
                Place::Pixel { view: ViewName::ThreeD, px, size } => {
                    self.follow_pixel(volumes, point, DVec2::from_array(px), size, &mut resolved)?;
                }
                at => {
                    let given = match (point.normal, at) {
                        (Some(normal), Place::Mm(_) | Place::Index(_)) => Some(unit(normal)?),
                        _ => None,
                    };
                    let sample = self
                        .resolve(at, volumes.first().copied())?
                        .map(|s| Sample { normal: given.unwrap_or(s.normal), ..s });
                    let StrokePoint { pressure, breaks, .. } = *point;
                    resolved.samples.extend(resolved.trail.take().into_iter().flat_map(|trail| trail.end()));
                    resolved.samples.extend(sample.map(|s| Sample { pressure, breaks, ..s }));
                }
            }
        }
        Ok(resolved)
    }

    fn follow_pixel(
        &mut self,
        volumes: &[VolumeId],
        point: &StrokePoint,
        px: DVec2,
        size: Option<[u32; 2]>,
        resolved: &mut Resolved,
    ) -> Result<(), DocumentError> {
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        let size = crate::document::scene::check::check_size(size.unwrap_or(state.scene.views.size))?;
        if !px.is_finite() {
            return Err(DocumentError::invalid("px", px, "two finite numbers"));
        }
        let camera = state.scene.views.camera;
        let mut frame = state.looking(volumes, self.motion.poses(), &camera, size);
        self.lay_out(&mut frame.layers, false, true);
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        let subject = state.at(volumes.first().copied())?;
        let sizes = volumes.iter().filter_map(|id| Some(pixel_mm(&frame, &state.subject(*id)?)));
        let (pixel_mm, voxel_mm) = (sizes.fold(0.0, f64::max), state.finest_mm(volumes));
        let radius_mm = state.scene.brush.radius_mm;
        let rule = SurfaceRule {
            radius_mm,
            voxel_mm,
            pixel_mm,
            normal: crate::document::place::normal_of(&subject, ViewName::Axial),
        };
        let at_once = |hit: Option<Hit>, whole: Option<Seen>| {
            let (pressure, rest) = (point.pressure, Vec::new());
            Trail { camera, size, rule, px, pressure, hit, whole, rest, past: 0.0 }
        };
        let mut trail = resolved.trail.take();
        let first = trail.is_none();
        // Where the view is another or the path breaks, what was left of it comes to its end.
        if trail.as_ref().is_some_and(|t| point.breaks || !t.is_of(&camera, size)) {
            resolved.samples.extend(trail.as_ref().into_iter().flat_map(Trail::end));
            trail = trail.filter(|_| !point.breaks).and_then(|t| {
                let (from, _) = camera.project(t.hit?.world, size)?;
                Some(Trail { px: from, pressure: t.pressure, ..at_once(t.hit, t.hit.map(seen)) })
            });
        }
        let mut trail = match trail {
            // A look at the point itself.
            None => {
                let hit = self.graphics.pick_along(state, &frame, [px, px], 1)?.pop().flatten();
                let mut samples = rule.follow(None, &[(hit.map(seen), point.pressure)], 1);
                // A point that is a path given by mm or index before goes on from there.
                if let (true, Some(sample)) = (first && !point.breaks, samples.first_mut()) {
                    sample.breaks = false;
                }
                resolved.samples.extend(samples);
                at_once(hit, hit.map(seen))
            }
            Some(mut trail) => {
                let per_pixel = looks_per_pixel(pixel_mm, voxel_mm, size, trail.px.distance(px));
                let ([from, to], count) = trail.looks(px, per_pixel);
                let hits = match count {
                    0 => Vec::new(),
                    _ => self.graphics.pick_along(state, &frame, [from, to], count)?,
                };
                let last = hits.last().copied().filter(|_| to.distance(px) <= SAME_PX);
                let hit = match last.or((trail.px == px).then_some(trail.hit)) {
                    Some(hit) => hit,
                    None => self.graphics.pick_along(state, &frame, [px, px], 1)?.pop().flatten(),
                };
                resolved.samples.extend(trail.go(px, point.pressure, [from, to], &hits, per_pixel));
                Trail { hit, ..trail }
            }
        };
        resolved.missed += u64::from(trail.hit.is_none());
        trail.pressure = point.pressure;
        resolved.trail = Some(trail);
        Ok(())
    }
}

impl Trail {
    /// What the pointer's last point met.
    pub(crate) fn hit(&self) -> Option<Hit> {
        self.hit
    }

    /// Whether a point of a picture of this camera goes on from here.
    fn is_of(&self, camera: &Camera, size: [u32; 2]) -> bool {
        self.camera == *camera && self.size == size
    }

    /// The looks that the way to a point takes: from where and to where, the first a step after `from`, and how many.
    fn looks(&self, px: DVec2, per_pixel: f64) -> ([DVec2; 2], u32) {
        let (way, length) = (px - self.px, self.px.distance(px));
        let count = ((self.past + length + SAME_PX) * per_pixel).floor().min(MOST_LOOKS);
        let along = way / length.max(f64::MIN_POSITIVE);
        let from = self.px - along * self.past;
        ([from, from + along * (count / per_pixel)], count as u32)
    }

    /// Goes on to a point along looks; answers the samples of the pixels that are whole with them.
    fn go(
        &mut self,
        px: DVec2,
        pressure: f32,
        [from, to]: [DVec2; 2],
        hits: &[Option<Hit>],
        per_pixel: f64,
    ) -> Vec<Sample> {
        let (length, count) = (self.px.distance(px), hits.len() as f64);
        let share = |i: usize| {
            let look = from.lerp(to, (i + 1) as f64 / count);
            if length > 0.0 { (self.px.distance(look) / length).min(1.0) as f32 } else { 1.0 }
        };
        let pressed = |i: usize| self.pressure + (pressure - self.pressure) * share(i);
        let looks: Vec<SeenAt> = hits.iter().enumerate().map(|(i, hit)| (hit.map(seen), pressed(i))).collect();
        self.rest.extend(looks);
        self.past = if hits.is_empty() { self.past + length } else { to.distance(px) };
        self.px = px;
        let whole = self.rest.len() - self.rest.len() % per_pixel.max(1.0) as usize;
        let looks: Vec<SeenAt> = self.rest.drain(..whole).collect();
        let samples = self.rule.follow(self.whole, &looks, per_pixel.max(1.0) as usize);
        self.whole = looks.last().map_or(self.whole, |look| look.0);
        samples
    }

    /// The samples of what is left at the stroke's end: from the last whole pixel to the pointer.
    pub(crate) fn end(&self) -> Vec<Sample> {
        let mut looks = self.rest.clone();
        if self.past > SAME_PX {
            looks.push((self.hit.map(seen), self.pressure));
        }
        self.rule.follow(self.whole, &looks, looks.len())
    }
}

fn seen(hit: Hit) -> Seen {
    Seen { position: hit.rest, part: hit.body }
}

/// Size of a pixel of the picture where what is drawn ends, mm: what is nearer is smaller.
pub(crate) fn pixel_mm(frame: &Frame, subject: &Subject<'_>) -> f64 {
    let corners = subject.grid().world_corners();
    let forward = frame.camera.forward();
    let far = |pose: &Pose| corners.map(|c| (pose.apply(c) - frame.camera.eye).dot(forward));
    let own = frame.bodies.iter().filter(|b| b.volume == subject.id);
    let furthest = own.flat_map(|b| far(&b.pose)).fold(0.0, f64::max);
    frame.camera.mm_per_pixel(furthest, frame.size[1])
}

/// How many looks make a pixel. It does not depend on where along the way the pointer was sampled, but for ways that lead far out
/// of the picture.
fn looks_per_pixel(pixel_mm: f64, voxel_mm: f64, size: [u32; 2], way: f64) -> f64 {
    let longest = way.max(f64::from(size[0]).hypot(f64::from(size[1])));
    let most = (MOST_LOOKS / longest.max(1.0)).floor().min(MOST_LOOKS_PER_PIXEL);
    if most < 1.0 {
        return MOST_LOOKS / longest;
    }
    (pixel_mm / (LOOKS_VOXELS * voxel_mm)).ceil().clamp(1.0, most)
}

/// A direction of length 1; one that has it already to the last bits stays as it is, so that what was written down comes back.
pub(super) fn unit(normal: [f64; 3]) -> Result<DVec3, DocumentError> {
    let (given, unit) = (DVec3::from_array(normal), direction("normal", normal)?);
    Ok(if given.distance(unit) < 1e-12 { given } else { unit })
}
