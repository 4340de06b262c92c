//! Fonts as bytes, in the order in which they are asked for a character.
//!
//! Owns which font draws what and the outlines of glyphs, in em. The library that reads fonts stays behind this file and `shaping`. Knows
//! no
//! file: whoever found a font hands its bytes over. Bytes of strangers may hold anything; what cannot be read is drawn as missing.

use crate::annotate::picture::error::AnnotateError;
use crate::annotate::picture::outline::{flatten_cubic, flatten_quadratic};
use glam::DVec2;
use harfrust::{Shaper, ShaperData};
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::{DrawSettings, OutlinePen};
use skrifa::{FontRef, GlyphId, MetadataProvider, OutlineGlyphCollection, charmap::Charmap};
use std::borrow::Cow;
use std::fmt;

/// How far a flattened outline may be from its curve, em.
pub const TOLERANCE_EM: f64 = 1.0 / 5000.0;

/// A glyph that reaches further than this from its origin is none, em.
const FARTHEST_EM: f64 = 64.0;

/// A font that nobody has looked into yet.
#[derive(Clone)]
pub struct FontBytes {
    /// What errors call it.
    pub name: String,
    /// The file's bytes.
    pub bytes: Cow<'static, [u8]>,
    /// Its place in a collection (.ttc); 0 in a file of one font.
    pub index: u32,
}

/// Fonts in order of preference: the first that has a character draws it.
pub struct Fonts {
    faces: Vec<Face>,
}

struct Face {
    source: FontBytes,
    shaping: ShaperData,
    units_per_em: f64,
}

impl Fonts {
    /// Those a user chose first, the shipped one behind them.
    ///
    /// # Errors
    /// If there is none, or one cannot be read, has no outlines, or no table of characters; it is named.
    pub fn new(fonts: Vec<FontBytes>) -> Result<Self, AnnotateError> {
        if fonts.is_empty() {
            return Err(AnnotateError::out("fonts", 0, "at least one"));
        }
        let faces = fonts.into_iter().map(Face::new).collect::<Result<_, _>>()?;
        Ok(Self { faces })
    }

    /// Names, in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.faces.iter().map(|f| f.source.name.as_str())
    }

    /// Those of a text's characters that no font has, each once, in order of code points. Format characters need none.
    pub fn missing(&self, text: &str) -> Vec<char> {
        let opened = self.open();
        let mut missing: Vec<char> =
            text.chars().filter(|&c| needs_glyph(c) && !opened.iter().any(|f| f.has(c))).collect();
        missing.sort_unstable();
        missing.dedup();
        missing
    }

    pub(crate) fn open(&self) -> Vec<OpenFont<'_>> {
        // They were all opened once before.
        self.faces.iter().filter_map(Face::open).collect()
    }
}

impl fmt::Debug for Fonts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.names()).finish()
    }
}

impl Face {
    fn new(source: FontBytes) -> Result<Self, AnnotateError> {
        let wrong = |found: String| AnnotateError::Font { font: source.name.clone(), found };
        let font = FontRef::from_index(&source.bytes, source.index).map_err(|e| wrong(e.to_string()))?;
        let units_per_em =
            f64::from(skrifa::raw::TableProvider::head(&font).map_err(|e| wrong(e.to_string()))?.units_per_em());
        // The format's own range.
        if !(16.0..=16384.0).contains(&units_per_em) {
            return Err(wrong(format!("{units_per_em} units per em")));
        }
        if font.outline_glyphs().format().is_none() {
            return Err(wrong("no outlines".into()));
        }
        if !font.charmap().has_map() {
            return Err(wrong("no table of characters".into()));
        }
        let shaping = ShaperData::new(&font);
        Ok(Self { source, shaping, units_per_em })
    }

    fn open(&self) -> Option<OpenFont<'_>> {
        let font = FontRef::from_index(&self.source.bytes, self.source.index).ok()?;
        Some(OpenFont {
            shaper: self.shaping.shaper(&font).build(),
            charmap: font.charmap(),
            outlines: font.outline_glyphs(),
            units_per_em: self.units_per_em,
        })
    }
}

/// Whether something is drawn for a character: not for controls and characters that only steer others (Default_Ignorable_Code_Point).
pub fn needs_glyph(c: char) -> bool {
    !(c.is_control()
        || matches!(c as u32,
            0xad | 0x34f | 0x61c | 0x115f..=0x1160 | 0x17b4..=0x17b5 | 0x180b..=0x180f | 0x200b..=0x200f | 0x2028..=0x202e
            | 0x2060..=0x206f | 0x3164 | 0xfe00..=0xfe0f | 0xfeff | 0xffa0 | 0xfff0..=0xfff8 | 0x1bca0..=0x1bca3
            | 0x1d173..=0x1d17a | 0xe0000..=0xe0fff))
}

/// A font in use.
pub(crate) struct OpenFont<'a> {
    pub shaper: Shaper<'a>,
    pub units_per_em: f64,
    charmap: Charmap<'a>,
    outlines: OutlineGlyphCollection<'a>,
}

impl OpenFont<'_> {
    pub(crate) fn has(&self, c: char) -> bool {
        self.charmap.map(c).is_some_and(|glyph| glyph.to_u32() != 0)
    }

    /// Closed contours, em, y up; none if the glyph cannot be read.
    pub(crate) fn contours(&self, glyph: u32) -> Option<Vec<Vec<DVec2>>> {
        let outline = self.outlines.get(GlyphId::new(glyph))?;
        let mut pen = Pen { contours: Vec::new(), at: DVec2::ZERO, per_unit: 1.0 / self.units_per_em };
        outline.draw(DrawSettings::unhinted(Size::unscaled(), LocationRef::default()), &mut pen).ok()?;
        let sane = pen.contours.iter().flatten().all(|p| p.is_finite() && p.abs().max_element() <= FARTHEST_EM);
        sane.then_some(pen.contours)
    }
}

struct Pen {
    contours: Vec<Vec<DVec2>>,
    at: DVec2,
    per_unit: f64,
}

impl Pen {
    fn point(&self, x: f32, y: f32) -> DVec2 {
        DVec2::new(f64::from(x), f64::from(y)) * self.per_unit
    }

    fn curve(&mut self, to: DVec2, flatten: impl FnOnce(DVec2, &mut Vec<DVec2>)) {
        if let Some(contour) = self.contours.last_mut() {
            flatten(self.at, contour);
        }
        self.at = to;
    }
}

impl OutlinePen for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.at = self.point(x, y);
        self.contours.push(vec![self.at]);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let to = self.point(x, y);
        self.curve(to, |_, out| out.push(to));
    }

    fn quad_to(&mut self, cx: f32, cy: f32, x: f32, y: f32) {
        let (control, to) = (self.point(cx, cy), self.point(x, y));
        self.curve(to, |from, out| flatten_quadratic(from, control, to, TOLERANCE_EM, out));
    }

    fn curve_to(&mut self, ax: f32, ay: f32, bx: f32, by: f32, x: f32, y: f32) {
        let (controls, to) = ([self.point(ax, ay), self.point(bx, by)], self.point(x, y));
        self.curve(to, |from, out| flatten_cubic(from, controls, to, TOLERANCE_EM, out));
    }

    fn close(&mut self) {}
}
