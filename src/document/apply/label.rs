//! Labels in pictures: what they name and whether that is seen, where they are put, and how a picture for a file gets them.
//!
//! A window places the same labels itself, frame by frame, from [`LabelAnchor`]s. Owns how a still picture's labels are drawn.

use crate::annotate::labels::{self, Placed, Viewport, key_lines, place_still};
use crate::annotate::picture::shapes::text_sheet;
use crate::annotate::picture::sheet::{Paint, Sheet};
use crate::annotate::picture::text::Text;
use crate::annotate::picture::texture::Texture;
use crate::document::Document;
use crate::document::command::answers::{PlacedLabelsSaid, PlacedSaid};
use crate::document::error::DocumentError;
use crate::document::live::windows::pose_at;
use crate::document::scene::annotations::{Anchor, AnnotationId};
use crate::document::scene::check::{check_size, safe_camera};
use crate::document::scene::cutaways::CutawayId;
use crate::document::scene::labels::{LabelId, Named};
use crate::document::state::State;
use crate::gpu::Image;
use crate::math::{Camera, DVec2, DVec3};
use crate::volume::VolumeId;
use std::collections::BTreeMap;

/// Height of the picture that sizes of labels are said for.
const SAID_FOR_PX: f64 = 800.0;
/// Room about a text, in its size.
const ROOM: DVec2 = DVec2::new(0.35, 0.12);
/// How far a shade reaches about letters, in their size.
const HALO: f64 = 0.16;
/// What lies behind a surface by less than this many voxels is on it.
const ON_SURFACE_VOXELS: f64 = 3.0;

/// What a label names, as it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelAnchor {
    /// The label.
    pub id: LabelId,
    /// What it says.
    pub text: String,
    /// Where its leader ends, world mm as posed.
    pub place: DVec3,
    /// How far before it something else may be seen and it is seen nevertheless, mm.
    pub near_mm: f64,
    /// What it names.
    pub named: Named,
}

impl LabelAnchor {
    /// Whether it is seen where a picture shows so much at its pixel: how far along the ray, as whose segment, as which body.
    pub fn is_seen(&self, depth_mm: f64, at_mm: f64, segment: Option<(VolumeId, u16)>, body: Option<u32>) -> bool {
        let own = match self.named {
            Named::Segment { volume, segment: own } => segment == Some((volume, own)),
            Named::Part(part) => body == Some(part.0),
            Named::Point { .. } | Named::Annotation(_) => false,
        };
        own || depth_mm >= at_mm - self.near_mm
    }
}

/// The labels of a picture, placed.
struct Placement {
    anchors: Vec<LabelAnchor>,
    /// Of each: where it is in the picture, and whether it is seen.
    seen: Vec<(Option<DVec2>, bool)>,
    /// What is written of each: its text, or its number.
    written: Vec<String>,
    placed: Vec<Placed>,
    left_out: Vec<LabelId>,
    size_px: f64,
}

impl Document {
    /// Where what labels name stands now, of those that are shown.
    ///
    /// # Errors
    /// If labels of a volume cannot be read.
    pub fn label_anchors(&mut self) -> Result<Vec<LabelAnchor>, DocumentError> {
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        if !state.scene.labels.style.visible {
            return Ok(Vec::new());
        }
        let poses = self.motion.poses();
        let mut anchors = Vec::new();
        for (id, label) in state.scene.labels.all.iter().filter(|(_, label)| label.visible) {
            let in_volume = |volume: VolumeId, index: DVec3, selected: bool| {
                let grid = *state.at(Some(volume)).ok()?.grid();
                let rest = grid.world_from_index.transform_point3(index);
                Some((pose_at(state, poses, rest, selected).apply(rest), grid.voxel_mm()))
            };
            let found = match label.at {
                Named::Point { volume, index, selected } => in_volume(volume, DVec3::from_array(index), selected),
                Named::Annotation(annotation) => state.scene.annotation(annotation).ok().and_then(|one| {
                    in_volume(one.anchor.volume, DVec3::from_array(one.anchor.centre), one.anchor.selected)
                }),
                Named::Segment { volume, segment } => match self.poles.pole(state, volume, segment) {
                    Ok(pole) => pole.and_then(|index| in_volume(volume, index, false)),
                    Err(_) => None,
                },
                Named::Part(part) => state.scene.explosion.part(part).ok().map(|part| {
                    let middle = part.vertices.iter().sum::<DVec3>() / part.vertices.len().max(1) as f64;
                    (poses.of(part).apply(middle), state.at(None).map_or(1.0, |s| s.grid().voxel_mm()))
                }),
            };
            if let Some((place, voxel_mm)) = found {
                let near_mm = ON_SURFACE_VOXELS * voxel_mm;
                anchors.push(LabelAnchor { id: *id, text: label.text.clone(), place, near_mm, named: label.at });
            }
        }
        Ok(anchors)
    }

    /// Where the centres of annotations stand now, world mm as posed.
    pub fn annotation_places(&self) -> BTreeMap<AnnotationId, DVec3> {
        let Some(state) = &self.state else { return BTreeMap::new() };
        let all = state.scene.annotations.all.iter();
        all.filter_map(|(id, one)| Some((*id, self.anchor_place(state, &one.anchor)?))).collect()
    }

    /// Where the middles of cutaways stand now, world mm as posed.
    pub fn cutaway_places(&self) -> BTreeMap<CutawayId, DVec3> {
        let Some(state) = &self.state else { return BTreeMap::new() };
        let all = state.scene.cutaways.all.iter();
        all.filter_map(|(id, one)| Some((*id, self.anchor_place(state, &one.anchor)?))).collect()
    }

    fn anchor_place(&self, state: &State, anchor: &Anchor) -> Option<DVec3> {
        let grid = *state.at(Some(anchor.volume)).ok()?.grid();
        let rest = grid.world_from_index.transform_point3(DVec3::from_array(anchor.centre));
        Some(pose_at(state, self.motion.poses(), rest, anchor.selected).apply(rest))
    }

    fn placement(&mut self, image: &Image, camera: &Camera) -> Result<Placement, DocumentError> {
        let anchors = self.label_anchors()?;
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        let style = state.scene.labels.style;
        let size_px = f64::from(style.size_px) * f64::from(image.size[1]) / SAID_FOR_PX;
        let seen: Vec<_> = anchors.iter().map(|anchor| seen_in(image, camera, anchor)).collect();
        let mut written: Vec<String> = anchors.iter().map(|anchor| anchor.text.clone()).collect();
        let size = |text: &str, laid: &mut crate::document::live::laid::Laid| {
            measured(text, size_px, laid).unwrap_or(DVec2::splat(size_px))
        };
        let mut wanted: Vec<labels::Label> = Vec::new();
        for ((anchor, (at, visible)), text) in anchors.iter().zip(&seen).zip(&written) {
            wanted.push(labels::Label {
                id: u64::from(anchor.id.0),
                anchor: at.unwrap_or(DVec2::splat(-1.0)),
                depth: anchor.place.distance(camera.eye),
                visible: *visible,
                size: size(text, &mut self.laid),
                priority: 0.0,
            });
        }
        if style.numbers {
            let digit = size("0", &mut self.laid);
            let more = digit.x - 2.0 * ROOM.x * size_px;
            let measure = |text: &str| DVec2::new(digit.x + (text.len().max(1) - 1) as f64 * more, digit.y);
            let key = key_lines(&mut wanted, &written, &measure);
            written = key.iter().map(|line| line.number.to_string()).collect();
        }
        let corners = state.bounds().corners();
        let outline = corners.iter().filter_map(|c| Some(camera.project(*c, image.size)?.0)).collect();
        let viewport = Viewport { size: DVec2::from_array(image.size.map(f64::from)), outline };
        let style = labels::Style::of_letters(size_px);
        let frame = place_still(&viewport, &style, &wanted);
        let left_out = frame.left_out.iter().map(|(id, _)| LabelId(*id as u32)).collect();
        Ok(Placement { anchors, seen, written, placed: frame.labels, left_out, size_px })
    }

    pub(crate) fn ask_labels(
        &mut self,
        camera: Option<Camera>,
        size: Option<[u32; 2]>,
    ) -> Result<PlacedLabelsSaid, DocumentError> {
        let state = self.open()?;
        let style = state.scene.labels.style;
        let camera = safe_camera(camera.unwrap_or(state.scene.views.camera), &state.bounds())?;
        let size = check_size(size.unwrap_or(state.scene.views.size))?;
        let image = self.picture(crate::document::scene::ViewName::ThreeD, size, Some(camera))?;
        let found = self.placement(&image, &camera)?;
        let labels = found.anchors.iter().enumerate().map(|(i, anchor)| {
            let (at, seen) = found.seen[i];
            let placed = found.placed.iter().find(|p| p.id == u64::from(anchor.id.0));
            PlacedSaid {
                id: anchor.id,
                text: anchor.text.clone(),
                anchor: at.map(|at| at.to_array()),
                seen,
                rect: placed.map(|p| {
                    let size = p.rect.max - p.rect.min;
                    [p.rect.min.x, p.rect.min.y, size.x, size.y]
                }),
                leader: placed.map_or(Vec::new(), |p| p.leader.iter().map(|p| p.to_array()).collect()),
                number: style.numbers.then_some(i + 1),
            }
        });
        Ok(PlacedLabelsSaid { style, labels: labels.collect(), left_out: found.left_out })
    }

    /// Writes the labels of the 3D view onto a picture of it.
    pub(crate) fn write_labels(
        &mut self,
        image: &mut Image,
        camera: Option<Camera>,
        background: [f32; 3],
    ) -> Result<(), DocumentError> {
        let state = self.open()?;
        let style = state.scene.labels.style;
        if !style.visible || state.scene.labels.all.is_empty() {
            return Ok(());
        }
        let camera = safe_camera(camera.unwrap_or(state.scene.views.camera), &state.bounds())?;
        let found = self.placement(image, &camera)?;
        let [ink, shade] = style.inks(background);
        for placed in &found.placed {
            let at = found.anchors.iter().position(|a| u64::from(a.id.0) == placed.id);
            let Some(text) = at.map(|i| found.written[i].as_str()) else { continue };
            let wide = found.size_px / 11.0;
            line(image, &placed.leader, 2.4 * wide, shade, 0.5);
            line(image, &placed.leader, wide, ink, 1.0);
            if let Some(end) = placed.leader.first() {
                disc(image, *end, 2.2 * wide, ink);
            }
            let middle = placed.rect.min.midpoint(placed.rect.max);
            self.write(image, text, middle, found.size_px, (ink, shade))?;
        }
        if style.numbers {
            let mut at = DVec2::new(1.2, 1.2) * found.size_px;
            for (anchor, number) in found.anchors.iter().zip(&found.written) {
                if !found.placed.iter().any(|p| p.id == u64::from(anchor.id.0)) {
                    continue;
                }
                let text = format!("{number}  {}", anchor.text);
                let size = measured(&text, found.size_px, &mut self.laid)?;
                self.write(image, &text, at + 0.5 * size, found.size_px, (ink, shade))?;
                at.y += size.y;
            }
        }
        Ok(())
    }

    fn write(
        &mut self,
        image: &mut Image,
        text: &str,
        middle: DVec2,
        size_px: f64,
        (ink, shade): ([f32; 3], [f32; 3]),
    ) -> Result<(), DocumentError> {
        let sheet = written(text, size_px, &mut self.laid)?;
        let Texture::Distance { field, .. } = &sheet.texture else { return Ok(()) };
        let size = DVec2::from_array(sheet.size_mm);
        let first = middle - 0.5 * size;
        let per_px = 1.0 / field.texel_mm;
        let sample = |p: DVec2| {
            let q = (p - first) * per_px - 0.5;
            let at = |x: f64, y: f64| {
                let x = (x.max(0.0) as usize).min(field.width - 1);
                let y = (y.max(0.0) as usize).min(field.height - 1);
                f64::from(field.texels[y * field.width + x])
            };
            let (low, part) = (q.floor(), q - q.floor());
            let above = at(low.x, low.y) * (1.0 - part.x) + at(low.x + 1.0, low.y) * part.x;
            let below = at(low.x, low.y + 1.0) * (1.0 - part.x) + at(low.x + 1.0, low.y + 1.0) * part.x;
            above * (1.0 - part.y) + below * part.y
        };
        let halo = HALO * size_px;
        cover(image, first - halo, first + size + halo, |p| {
            let inside = sample(p) / per_px;
            [(shade, 0.6 * (0.5 + inside + halo).clamp(0.0, 1.0)), (ink, (0.5 + inside).clamp(0.0, 1.0))]
        });
        Ok(())
    }
}

/// Where what a label names is in a picture, and whether it is seen there.
fn seen_in(image: &Image, camera: &Camera, anchor: &LabelAnchor) -> (Option<DVec2>, bool) {
    let Some((px, _)) = camera.project(anchor.place, image.size) else { return (None, false) };
    let [w, h] = image.size.map(f64::from);
    if !(px.x >= 0.0 && px.y >= 0.0 && px.x < w && px.y < h) {
        return (None, false);
    }
    let i = px.y as usize * image.size[0] as usize + px.x as usize;
    let at_mm = camera.ray(px, image.size).origin.distance(anchor.place);
    let object = image.object[i];
    let segment = object.volume().zip(object.segment());
    (Some(px), anchor.is_seen(f64::from(image.depth_mm[i]), at_mm, segment, object.body()))
}

fn written(text: &str, size_px: f64, laid: &mut crate::document::live::laid::Laid) -> Result<Sheet, DocumentError> {
    let refused = |e: &dyn std::fmt::Display| DocumentError::NotNow(e.to_string());
    let fonts = laid.fonts.with(text).map_err(|e| refused(&e))?;
    let paint = Paint { fill: [255; 4], halo: Some(([255; 4], HALO * size_px)) };
    text_sheet(&Text::new(text, size_px), &fonts, &paint).map_err(|e| refused(&e))
}

/// Width and height of a text with the room about it, pixels.
fn measured(text: &str, size_px: f64, laid: &mut crate::document::live::laid::Laid) -> Result<DVec2, DocumentError> {
    let refused = |e: &dyn std::fmt::Display| DocumentError::NotNow(e.to_string());
    let fonts = laid.fonts.with(text).map_err(|e| refused(&e))?;
    let set = Text::new(text, size_px).set(&fonts).map_err(|e| refused(&e))?;
    Ok(set.bounds.size() + 2.0 * ROOM * size_px)
}

/// Lays colours over the pixels of a box, each by how much of a pixel it covers.
fn cover<const N: usize>(image: &mut Image, lo: DVec2, hi: DVec2, laid: impl Fn(DVec2) -> [([f32; 3], f64); N]) {
    let [w, h] = image.size;
    let range =
        |lo: f64, hi: f64, end: u32| (lo.floor().max(0.0) as u32)..(hi.ceil().clamp(0.0, f64::from(end)) as u32);
    for y in range(lo.y, hi.y, h) {
        for x in range(lo.x, hi.x, w) {
            let pixel = &mut image.colour[(y * w + x) as usize];
            for (colour, share) in laid(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)) {
                let share = share as f32;
                for (c, over) in pixel.iter_mut().zip(colour.iter().chain(&[1.0])) {
                    *c += share * (over - *c);
                }
            }
        }
    }
}

fn line(image: &mut Image, points: &[DVec2], width: f64, colour: [f32; 3], opacity: f64) {
    let reach = 0.5 * width + 1.0;
    let lo = points.iter().copied().fold(DVec2::INFINITY, DVec2::min) - reach;
    let hi = points.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max) + reach;
    cover(image, lo, hi, |p| {
        let far = points.windows(2).map(|ends| {
            let along = ends[1] - ends[0];
            let share = ((p - ends[0]).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
            p.distance(ends[0] + along * share)
        });
        let far = far.fold(f64::INFINITY, f64::min);
        [(colour, opacity * (0.5 + 0.5 * width - far).clamp(0.0, 1.0))]
    });
}

fn disc(image: &mut Image, middle: DVec2, radius: f64, colour: [f32; 3]) {
    cover(image, middle - radius - 1.0, middle + radius + 1.0, |p| {
        [(colour, (0.5 + radius - p.distance(middle)).clamp(0.0, 1.0))]
    });
}
