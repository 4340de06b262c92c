//! Text as outlines: lines along a straight or a bent baseline.
//!
//! Owns where glyphs stand: alignment of lines, concentric baselines, letters turned to the tangent at the middle of their advance (letters
//! of
//! scripts that join are bent with the line instead, so that their joints stay closed). Lengths in mm, y up, the block's first
//! baseline through (0, 0), centred in x. Knows no texel and no colour.

use crate::annotate::picture::error::{AnnotateError, checked_length};
use crate::annotate::picture::fonts::{Fonts, OpenFont};
use crate::annotate::picture::outline::{Outline, Rect};
use crate::annotate::picture::shaping::{MISSING_WIDTH_EM, ShapedGlyph, ShapedLine, shape_with};
use glam::DVec2;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeSet, HashMap};
use std::f64::consts::{PI, TAU};

/// The most characters of one annotation.
pub const MAX_CHARACTERS: usize = 2_000;

/// Sides of letters that bend with their line are no longer than this, em.
const BENT_SIDE_EM: f64 = 1.0 / 24.0;

/// What the line runs along.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Baseline {
    /// A straight line.
    #[default]
    Straight,
    /// A circle of this radius in mm: above 0 its ends hang down (an arch), below 0 they rise (a bowl).
    Radius(f64),
    /// An arc whose middle lies so many mm above its ends, below 0 under them.
    Sagitta(f64),
}

/// Where the lines of a block stand to each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Align {
    /// All begin at the same edge: the left one, for lines from right to left the right one.
    Start,
    /// Middles above each other.
    #[default]
    Middle,
    /// All end at the same edge.
    End,
}

/// A text and how it is set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Text {
    /// Lines are divided by '\n'; at most [`MAX_CHARACTERS`].
    pub text: String,
    /// Height of the em, mm, above 0.
    pub size_mm: f64,
    /// What the lines run along.
    #[serde(default)]
    pub baseline: Baseline,
    /// Where lines stand to each other.
    #[serde(default)]
    pub align: Align,
    /// From baseline to baseline, em, 0.5 to 10.
    #[serde(default = "line_spacing")]
    pub line_spacing: f64,
}

fn line_spacing() -> f64 {
    1.25
}

impl Text {
    /// One of this size on straight lines, middles above each other.
    pub fn new(text: impl Into<String>, size_mm: f64) -> Self {
        let (baseline, align) = (Baseline::Straight, Align::Middle);
        Self { text: text.into(), size_mm, baseline, align, line_spacing: line_spacing() }
    }
}

/// A text as it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct SetText {
    /// Of all glyphs, mm.
    pub outline: Outline,
    /// Around the ink and, on straight lines, the lines' own height and width, mm.
    pub bounds: Rect,
    /// Length of each line along its baseline, mm.
    pub line_widths_mm: Vec<f64>,
    /// Characters that no font has, in order of code points; each stands as a box.
    pub missing: Vec<char>,
}

impl Text {
    /// Shapes and sets it.
    ///
    /// # Errors
    /// If it is too long, a length is out of range, or the bend is so tight that a line would meet itself or pass the circle's centre.
    pub fn set(&self, fonts: &Fonts) -> Result<SetText, AnnotateError> {
        let size = checked_length("size_mm", self.size_mm)?;
        if !(0.5..=10.0).contains(&self.line_spacing) {
            return Err(AnnotateError::out("line_spacing", self.line_spacing, "0.5 to 10 em"));
        }
        // Counted no further than the limit: a text may be of any length.
        if self.text.chars().take(MAX_CHARACTERS + 1).count() > MAX_CHARACTERS {
            let found = format!("{} characters", self.text.chars().count());
            return Err(AnnotateError::out("text", found, format!("at most {MAX_CHARACTERS}")));
        }
        let opened = fonts.open();
        let mut missing = BTreeSet::new();
        let lines: Vec<ShapedLine> =
            self.text.split('\n').map(|line| shape_with(&opened, line, &mut missing)).collect();
        let widest = lines.iter().map(|l| l.width_em).fold(0.0, f64::max);
        let bend = self.bend(&lines, widest)?;
        let mut glyphs = Glyphs { fonts: &opened, known: HashMap::new() };
        let mut outline = Outline::new();
        let mut bounds: Option<Rect> = None;
        let mut add = |r: Rect| bounds = Some(bounds.map_or(r, |b| b.with(r)));
        for (n, line) in lines.iter().enumerate() {
            let baseline = -(n as f64) * self.line_spacing;
            let left = match (self.align, line.right_to_left) {
                (Align::Middle, _) => -0.5 * line.width_em,
                (Align::Start, false) | (Align::End, true) => -0.5 * widest,
                _ => 0.5 * widest - line.width_em,
            };
            set_line(line, left, &Way { bend, baseline }, &mut glyphs, &mut outline);
            if bend.is_none() {
                let (low, high) =
                    (DVec2::new(left, baseline - 0.25), DVec2::new(left + line.width_em, baseline + 0.75));
                add(Rect::new(low, high));
            }
        }
        outline.bounds().into_iter().for_each(&mut add);
        let bounds = bounds.unwrap_or(Rect::new(DVec2::splat(-0.5), DVec2::splat(0.5)));
        outline.contours.iter_mut().flatten().for_each(|p| *p *= size);
        Ok(SetText {
            outline,
            bounds: Rect::new(bounds.min * size, bounds.max * size),
            line_widths_mm: lines.iter().map(|l| l.width_em * size).collect(),
            missing: missing.into_iter().collect(),
        })
    }

    /// Radius of the first baseline's circle, em, above 0 where its centre lies below.
    fn bend(&self, lines: &[ShapedLine], widest: f64) -> Result<Option<f64>, AnnotateError> {
        let (field, radius) = match self.baseline {
            Baseline::Straight => return Ok(None),
            Baseline::Radius(mm) => ("radius", mm / self.size_mm),
            Baseline::Sagitta(mm) => match radius_of_sagitta(mm / self.size_mm, widest) {
                Some(radius) => ("sagitta", radius),
                None if mm == 0.0 || widest == 0.0 => return Ok(None),
                None => {
                    let most = widest * self.size_mm * MOST_SAGITTA;
                    return Err(AnnotateError::out(
                        "sagitta",
                        mm,
                        format!("at most {most:.3} mm either way for this text"),
                    ));
                }
            },
        };
        if !radius.is_finite() {
            return Err(AnnotateError::out(field, radius * self.size_mm, "a finite length"));
        }
        let mut least = 0.0f64;
        for (n, line) in lines.iter().enumerate() {
            let down = n as f64 * self.line_spacing;
            // Descenders of an arch and ascenders of a bowl point to the centre.
            let (behind, ink): (f64, f64) = if radius > 0.0 { (down, 0.3) } else { (-down, 0.8) };
            least = least.max(behind + ink.max(line.width_em / (0.95 * TAU)));
        }
        if radius.abs() < least {
            let (found, expected) = (radius.abs() * self.size_mm, least * self.size_mm);
            return Err(AnnotateError::out(
                field,
                format!("a radius of {found:.3} mm"),
                format!("at least {expected:.3} mm for this text"),
            ));
        }
        Ok(Some(radius))
    }
}

/// The most sagitta of an arc of length 1 that is no more than 0.95 of a circle: (1 − cos θ) / 2θ at its greatest, θ = 2.3311.
const MOST_SAGITTA: f64 = 0.362;

/// Radius of an arc of `length` with this sagitta: the least θ with (1 − cos θ)/θ = 2|s|/L, R = L/2θ. The sign is the sagitta's.
pub fn radius_of_sagitta(sagitta: f64, length: f64) -> Option<f64> {
    let wanted = 2.0 * sagitta.abs() / length;
    if !(wanted > 1e-9 && wanted <= 2.0 * MOST_SAGITTA) {
        return None;
    }
    let (mut low, mut high) = (0.0f64, 0.742 * PI);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        // 1 − cos θ = 2 sin²(θ/2), which keeps its digits near 0.
        if 2.0 * (0.5 * middle).sin().powi(2) < wanted * middle { low = middle } else { high = middle }
    }
    Some(sagitta.signum() * length / (low + high))
}

/// One line's baseline, em.
struct Way {
    bend: Option<f64>,
    baseline: f64,
}

impl Way {
    /// The point `along` the baseline from its middle and `up` from it, and the tangent there.
    fn at(&self, along: f64, up: f64) -> (DVec2, DVec2) {
        let Some(radius) = self.bend else { return (DVec2::new(along, self.baseline + up), DVec2::X) };
        let own = radius + self.baseline;
        let (sin, cos) = (along / own).sin_cos();
        (DVec2::new((own + up) * sin, (own + up) * cos - radius), DVec2::new(cos, -sin))
    }
}

fn set_line(line: &ShapedLine, left: f64, way: &Way, glyphs: &mut Glyphs<'_, '_>, outline: &mut Outline) {
    let mut pen = left;
    for cluster in line.glyphs.chunk_by(|a, b| a.cluster == b.cluster && a.font == b.font) {
        let advance: f64 = cluster.iter().map(|g| g.advance_em).sum();
        let middle = pen + 0.5 * advance;
        let (foot, tangent) = way.at(middle, 0.0);
        for glyph in cluster {
            let origin = DVec2::new(pen + glyph.offset_em[0], glyph.offset_em[1]);
            let contours = glyphs.contours(glyph);
            if glyph.joins && way.bend.is_some() {
                let shape = Outline { contours: contours.to_vec() };
                outline.extend(shape.bent(BENT_SIDE_EM, |p| way.at(origin.x + p.x, origin.y + p.y).0));
            } else {
                let place = |p: &DVec2| foot + tangent.rotate(DVec2::new(origin.x + p.x - middle, origin.y + p.y));
                contours.iter().for_each(|c| outline.add(c.iter().map(place).collect()));
            }
            pen += glyph.advance_em;
        }
    }
}

/// Outlines of glyphs, each read once.
struct Glyphs<'a, 'b> {
    fonts: &'a [OpenFont<'b>],
    known: HashMap<(usize, Option<u32>), Vec<Vec<DVec2>>>,
}

impl Glyphs<'_, '_> {
    fn contours(&mut self, glyph: &ShapedGlyph) -> &[Vec<DVec2>] {
        let fonts = self.fonts;
        self.known.entry((glyph.font, glyph.glyph)).or_insert_with(|| {
            glyph.glyph.and_then(|id| fonts.get(glyph.font)?.contours(id)).unwrap_or_else(missing_box)
        })
    }
}

fn missing_box() -> Vec<Vec<DVec2>> {
    let mut outline = Outline::new();
    let outer = Rect::new(DVec2::new(0.06, 0.0), DVec2::new(MISSING_WIDTH_EM - 0.06, 0.72));
    outline.add_rect(outer);
    outline.cut_rect(outer.grown(-0.06));
    outline.contours
}
