//! Arrows, rulers, scale bars and frames.
//!
//! Owns their figures, in mm, with u along the length and the line's middle at (0, 0), and the texture that each becomes. Lengths on a
//! surface
//! are measured by whoever asks. Numbers are set as text. Knows no grid.

use crate::annotate::picture::error::{AnnotateError, checked_length};
use crate::annotate::picture::fonts::Fonts;
use crate::annotate::picture::outline::{Outline, Rect};
use crate::annotate::picture::sheet::{Paint, Sheet, TEXELS_PER_EM};
use crate::annotate::picture::text::Text;
use glam::{DAffine2, DVec2};
use serde::{Deserialize, Serialize};

/// The most ticks of a ruler and parts of a scale bar.
pub const MAX_TICKS: usize = 2_000;

/// Texels across the thinnest line of a figure.
const TEXELS_PER_LINE: f64 = 8.0;

/// A straight arrow from left to right.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Arrow {
    /// From its tail to its tip, mm.
    pub length_mm: f64,
    /// Of its shaft, mm.
    pub thickness_mm: f64,
    /// Of its head along the arrow, mm; at most its length, half of it with two heads.
    pub head_length_mm: f64,
    /// Of its head across, mm, at least the shaft's.
    pub head_width_mm: f64,
    /// Whether its tail has a head too.
    pub both_ends: bool,
}

/// A line of a measured length with ticks, and its length in words above its middle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ruler {
    /// From end to end, mm.
    pub length_mm: f64,
    /// Of its lines, mm.
    pub thickness_mm: f64,
    /// Between ticks, mm; none: only at the ends. The first is one spacing from the left end.
    pub tick_spacing_mm: Option<f64>,
    /// Every n-th tick is longer; 0: none.
    pub longer_every: u32,
    /// Height of the ticks at its ends, mm, half above and half below; longer ones have 0.7 of it, others 0.45, above the line.
    pub tick_height_mm: f64,
    /// What stands above its middle, and the height of its em, mm; empty: nothing. [`length_in_words`] is the usual one.
    pub label: String,
    /// Height of the label's em, mm.
    pub label_size_mm: f64,
}

/// A bar of alternately full and empty parts, with 0 and its length above its ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScaleBar {
    /// From end to end, mm.
    pub length_mm: f64,
    /// Number of parts, 1 to [`MAX_TICKS`].
    pub parts: usize,
    /// Height of the bar, mm.
    pub height_mm: f64,
    /// Of the line around it, mm, under half its height.
    pub thickness_mm: f64,
    /// Height of the numbers' em, mm.
    pub label_size_mm: f64,
}

/// The border of a rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Outer width and height, mm.
    pub size_mm: [f64; 2],
    /// Of its line, mm, under half of either side.
    pub thickness_mm: f64,
    /// Radius of its outer corners, mm, 0 for sharp ones.
    pub corner_mm: f64,
}

/// "23.4 mm": a length with one decimal from 10 mm on, two from 1 mm on, else three.
pub fn length_in_words(mm: f64) -> String {
    let decimals = if mm.abs() >= 9.995 {
        1
    } else if mm.abs() >= 0.9995 {
        2
    } else {
        3
    };
    format!("{mm:.decimals$} mm")
}

impl Arrow {
    /// Its texture.
    ///
    /// # Errors
    /// If a length is out of range or the head does not fit.
    pub fn sheet(&self, paint: &Paint) -> Result<Sheet, AnnotateError> {
        let length = checked_length("length_mm", self.length_mm)?;
        let thickness = checked_length("thickness_mm", self.thickness_mm)?;
        let head = checked_length("head_length_mm", self.head_length_mm)?;
        let width = checked_length("head_width_mm", self.head_width_mm)?;
        let most = if self.both_ends { 0.5 * length } else { length };
        if head > most {
            return Err(AnnotateError::out("head_length_mm", head, format!("at most {most} mm")));
        }
        if width < thickness {
            return Err(AnnotateError::out("head_width_mm", width, format!("at least the shaft's {thickness} mm")));
        }
        let (x, t, w) = (0.5 * length, 0.5 * thickness, 0.5 * width);
        let half = [[x - head, -t], [x - head, -w], [x, 0.0], [x - head, w], [x - head, t]].map(DVec2::from_array);
        let mut corners = half.to_vec();
        if self.both_ends {
            corners.extend(half.map(|p| -p));
        } else {
            corners.extend([DVec2::new(-x, t), DVec2::new(-x, -t)]);
        }
        let mut outline = Outline::new();
        outline.add(corners);
        drawn(&outline, thickness, paint)
    }
}

impl Ruler {
    /// Its texture, and in it the characters of the label that no font has.
    ///
    /// # Errors
    /// If a length is out of range or there would be more than [`MAX_TICKS`].
    pub fn sheet(&self, fonts: &Fonts, paint: &Paint) -> Result<Sheet, AnnotateError> {
        let length = checked_length("length_mm", self.length_mm)?;
        let t = 0.5 * checked_length("thickness_mm", self.thickness_mm)?;
        let height = checked_length("tick_height_mm", self.tick_height_mm)?;
        let (x, top) = (0.5 * length, (0.5 * height).max(t));
        let mut outline = Outline::new();
        let mut upright = |at: f64, low: f64, high: f64| {
            outline.add_rect(Rect::new(DVec2::new(at - t, low), DVec2::new(at + t, high)))
        };
        // The outer faces of the end ticks are what is measured between.
        upright(t - x, -top, top);
        upright(x - t, -top, top);
        if let Some(spacing) = self.tick_spacing_mm {
            let spacing = checked_length("tick_spacing_mm", spacing)?;
            let count = (length / spacing - 1e-9).ceil() - 1.0;
            if count > MAX_TICKS as f64 {
                let least = length / MAX_TICKS as f64;
                return Err(AnnotateError::out(
                    "tick_spacing_mm",
                    spacing,
                    format!("at least {least} mm for this length"),
                ));
            }
            for n in 1..=count.max(0.0) as u32 {
                let longer = self.longer_every > 0 && n.is_multiple_of(self.longer_every);
                let at = -x + f64::from(n) * spacing;
                // None that would run into an end's: a gap of a line stays.
                if at + t <= x - 4.0 * t && at - t >= 4.0 * t - x {
                    upright(at, 0.0, height * if longer { 0.35 } else { 0.225 });
                }
            }
        }
        outline.add_rect(Rect::new(DVec2::new(-x, -t), DVec2::new(x, t)));
        let mut sheet = Labelled { outline, thinnest: 2.0 * t, missing: Vec::new() };
        if !self.label.is_empty() {
            let size = checked_length("label_size_mm", self.label_size_mm)?;
            sheet.label(fonts, &self.label, size, DVec2::new(0.0, top + 0.25 * size))?;
        }
        sheet.drawn(paint)
    }
}

impl ScaleBar {
    /// Its texture.
    ///
    /// # Errors
    /// If a length or the number of parts is out of range.
    pub fn sheet(&self, fonts: &Fonts, paint: &Paint) -> Result<Sheet, AnnotateError> {
        let length = checked_length("length_mm", self.length_mm)?;
        let height = checked_length("height_mm", self.height_mm)?;
        let thickness = checked_length("thickness_mm", self.thickness_mm)?;
        let size = checked_length("label_size_mm", self.label_size_mm)?;
        if !(1..=MAX_TICKS).contains(&self.parts) {
            return Err(AnnotateError::out("parts", self.parts, format!("1 to {MAX_TICKS}")));
        }
        let corner = DVec2::new(0.5 * length, 0.5 * height);
        if thickness >= corner.min_element() {
            return Err(AnnotateError::out("thickness_mm", thickness, format!("under {} mm", corner.min_element())));
        }
        let mut outline = Outline::new();
        outline.add_rect(Rect::new(-corner, corner));
        let part = length / self.parts as f64;
        for n in (1..self.parts).step_by(2) {
            let left = -corner.x + n as f64 * part;
            let right = if n + 1 == self.parts { corner.x - thickness } else { left + part };
            outline
                .cut_rect(Rect::new(DVec2::new(left, thickness - corner.y), DVec2::new(right, corner.y - thickness)));
        }
        let mut sheet = Labelled { outline, thinnest: thickness, missing: Vec::new() };
        let above = corner.y + 0.3 * size;
        sheet.label(fonts, "0", size, DVec2::new(-corner.x, above))?;
        let words = if length.fract() == 0.0 { format!("{length:.0} mm") } else { length_in_words(length) };
        sheet.label(fonts, &words, size, DVec2::new(corner.x, above))?;
        sheet.drawn(paint)
    }
}

impl Frame {
    /// Its texture.
    ///
    /// # Errors
    /// If a length is out of range or the line or the corners do not fit.
    pub fn sheet(&self, paint: &Paint) -> Result<Sheet, AnnotateError> {
        let size =
            DVec2::new(checked_length("width_mm", self.size_mm[0])?, checked_length("height_mm", self.size_mm[1])?);
        let thickness = checked_length("thickness_mm", self.thickness_mm)?;
        let half = 0.5 * size.min_element();
        if thickness >= half {
            return Err(AnnotateError::out("thickness_mm", thickness, format!("under {half} mm")));
        }
        if !(0.0..=half).contains(&self.corner_mm) {
            return Err(AnnotateError::out("corner_mm", self.corner_mm, format!("0 to {half} mm")));
        }
        let mut outline = Outline::new();
        outline.add(rounded(0.5 * size, self.corner_mm));
        let mut hole = rounded(0.5 * size - thickness, (self.corner_mm - thickness).max(0.0));
        hole.reverse();
        outline.add(hole);
        drawn(&outline, thickness, paint)
    }
}

fn rounded(corner: DVec2, radius: f64) -> Vec<DVec2> {
    let steps = if radius > 0.0 { 32 } else { 0 };
    let quarter = |n: u32| {
        let sign = [DVec2::ONE, DVec2::new(-1.0, 1.0), DVec2::NEG_ONE, DVec2::new(1.0, -1.0)][n as usize];
        let centre = sign * (corner - radius);
        (0..=steps).map(move |k| {
            let turn = f64::from(k) / f64::from(steps.max(1));
            centre + radius * DVec2::from_angle((f64::from(n) + turn) * std::f64::consts::FRAC_PI_2)
        })
    };
    (0..4).flat_map(quarter).collect()
}

fn drawn(outline: &Outline, thinnest: f64, paint: &Paint) -> Result<Sheet, AnnotateError> {
    let bounds = outline.bounds().unwrap_or(Rect::new(DVec2::ZERO, DVec2::ZERO));
    Sheet::drawn(outline, bounds, thinnest / TEXELS_PER_LINE, paint)
}

/// A figure with words.
struct Labelled {
    outline: Outline,
    thinnest: f64,
    missing: Vec<char>,
}

impl Labelled {
    /// Words with the middle of their baseline at a point.
    fn label(&mut self, fonts: &Fonts, words: &str, size_mm: f64, at: DVec2) -> Result<(), AnnotateError> {
        let set = Text::new(words, size_mm).set(fonts)?;
        // Descenders and further lines stay above the point.
        let up = -(set.bounds.min.y + 0.25 * size_mm).min(0.0);
        self.outline.extend(set.outline.mapped(&DAffine2::from_translation(at + DVec2::new(0.0, up))));
        self.thinnest = self.thinnest.min(TEXELS_PER_LINE * size_mm / TEXELS_PER_EM);
        self.missing.extend(set.missing);
        Ok(())
    }

    fn drawn(self, paint: &Paint) -> Result<Sheet, AnnotateError> {
        let mut sheet = drawn(&self.outline, self.thinnest, paint)?;
        sheet.missing = self.missing;
        Ok(sheet)
    }
}

/// A text's texture, at [`TEXELS_PER_EM`] where it is not too large for that.
///
/// # Errors
/// As [`Text::set`], or if the halo's width is out of range.
pub fn text_sheet(text: &Text, fonts: &Fonts, paint: &Paint) -> Result<Sheet, AnnotateError> {
    let set = text.set(fonts)?;
    let mut sheet = Sheet::drawn(&set.outline, set.bounds, text.size_mm / TEXELS_PER_EM, paint)?;
    sheet.missing = set.missing;
    Ok(sheet)
}
