//! From a line of text to glyphs in the order in which they stand, left to right.
//!
//! A line is ordered by the Unicode bidirectional algorithm (UAX 9), its runs are divided by script (UAX 24) and by the font that has the
//! characters (grapheme by grapheme, UAX 29), and each piece is shaped by its font's own rules: ligatures, joined forms, kerning, marks.
//! Owns that chain; knows no lengths but em, and no place of the line.

use crate::annotate::picture::fonts::{Fonts, OpenFont, needs_glyph};
use harfrust::{Direction, ShapeOptions, Tag, UnicodeBuffer};
use std::collections::BTreeSet;
use std::ops::Range;
use unicode_bidi::BidiInfo;
use unicode_script::{Script, UnicodeScript};
use unicode_segmentation::UnicodeSegmentation;

/// Width of the box that stands for a character no font has, em.
pub const MISSING_WIDTH_EM: f64 = 0.6;

/// One glyph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapedGlyph {
    /// Which of the fonts, in their order.
    pub font: usize,
    /// Number of the glyph in its font; none: the box that stands for a missing one.
    pub glyph: Option<u32>,
    /// Where in the line's bytes its characters begin; glyphs of one cluster belong together.
    pub cluster: usize,
    /// From the pen to the glyph's origin, em, y up.
    pub offset_em: [f64; 2],
    /// How far the pen moves to the right behind it, em.
    pub advance_em: f64,
    /// Whether its script joins letters, so that a bent line must bend them and not turn them one by one.
    pub joins: bool,
}

/// A line's glyphs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShapedLine {
    /// From left to right.
    pub glyphs: Vec<ShapedGlyph>,
    /// Sum of the advances, em.
    pub width_em: f64,
    /// Whether the line as a whole reads from right to left.
    pub right_to_left: bool,
}

/// Shapes one line; characters without a font are added to `missing`. Tabs are spaces; other controls, line ends too, are left out.
pub fn shape_line(fonts: &Fonts, line: &str, missing: &mut BTreeSet<char>) -> ShapedLine {
    shape_with(&fonts.open(), line, missing)
}

pub(crate) fn shape_with(fonts: &[OpenFont<'_>], line: &str, missing: &mut BTreeSet<char>) -> ShapedLine {
    let kept = |c: char| {
        if c == '\t' { Some(' ') } else { (!c.is_control() && !matches!(c, '\u{2028}' | '\u{2029}')).then_some(c) }
    };
    let line: String = line.chars().filter_map(kept).collect();
    let info = BidiInfo::new(&line, None);
    let Some(paragraph) = info.paragraphs.first() else { return ShapedLine::default() };
    let mut glyphs = Vec::new();
    let (levels, runs) = info.visual_runs(paragraph, paragraph.range.clone());
    for run in runs {
        let right_to_left = levels[run.start].is_rtl();
        let mut pieces = pieces(fonts, &line, run);
        if right_to_left {
            pieces.reverse();
        }
        for piece in pieces {
            shape_piece(fonts, &line, &piece, right_to_left, missing, &mut glyphs);
        }
    }
    let width_em = glyphs.iter().map(|g| g.advance_em).sum();
    ShapedLine { glyphs, width_em, right_to_left: paragraph.level.is_rtl() }
}

/// Neighbouring characters of one direction, script and font.
struct Piece {
    range: Range<usize>,
    script: Script,
    font: Option<usize>,
}

fn pieces(fonts: &[OpenFont<'_>], line: &str, run: Range<usize>) -> Vec<Piece> {
    let own = |c: char| Some(c.script()).filter(|s| !matches!(s, Script::Common | Script::Inherited | Script::Unknown));
    // Signs that all scripts share go with what stands before them, at the beginning with what follows.
    let mut script = line[run.clone()].chars().find_map(own).unwrap_or(Script::Common);
    let mut out: Vec<Piece> = Vec::new();
    for (start, grapheme) in line[run.clone()].grapheme_indices(true) {
        let range = run.start + start..run.start + start + grapheme.len();
        script = grapheme.chars().find_map(own).unwrap_or(script);
        let before = out.last().map(|p| p.font);
        let font = font_of(fonts, grapheme, before.flatten());
        match out.last_mut() {
            Some(last) if last.script == script && last.font == font => last.range.end = range.end,
            _ => out.push(Piece { range, script, font }),
        }
    }
    out
}

/// The first font that has all of a grapheme, else the first that has its beginning. Spaces and format characters stay with the font
/// before.
fn font_of(fonts: &[OpenFont<'_>], grapheme: &str, before: Option<usize>) -> Option<usize> {
    let mut drawn = grapheme.chars().filter(|&c| needs_glyph(c));
    let first = drawn.clone().next();
    if drawn.clone().all(char::is_whitespace) && before.is_some_and(|n| drawn.clone().all(|c| fonts[n].has(c))) {
        return before;
    }
    let all = fonts.iter().position(|f| drawn.clone().all(|c| f.has(c)));
    all.or_else(|| first.and_then(|c| fonts.iter().position(|f| f.has(c))))
        .or_else(|| drawn.next().is_none().then_some(0))
}

fn shape_piece(
    fonts: &[OpenFont<'_>],
    line: &str,
    piece: &Piece,
    right_to_left: bool,
    missing: &mut BTreeSet<char>,
    out: &mut Vec<ShapedGlyph>,
) {
    let text = &line[piece.range.clone()];
    let absent = |font: usize, cluster: usize| ShapedGlyph {
        font,
        glyph: None,
        cluster,
        offset_em: [0.0; 2],
        advance_em: MISSING_WIDTH_EM,
        joins: false,
    };
    let Some((number, font)) = piece.font.and_then(|n| fonts.get(n).map(|f| (n, f))) else {
        missing.extend(text.chars().filter(|&c| needs_glyph(c)));
        let mut boxes: Vec<_> = text.grapheme_indices(true).map(|(at, _)| absent(0, piece.range.start + at)).collect();
        if right_to_left {
            boxes.reverse();
        }
        out.extend(boxes);
        return;
    };
    let mut buffer = UnicodeBuffer::new();
    // Letters join across the borders of pieces too.
    buffer.set_pre_context(&line[..piece.range.start]);
    for (at, c) in text.char_indices() {
        buffer.add(c, (piece.range.start + at) as u32);
    }
    buffer.set_post_context(&line[piece.range.end..]);
    buffer.set_direction(if right_to_left { Direction::RightToLeft } else { Direction::LeftToRight });
    if let Some(script) = iso(piece.script) {
        buffer.set_script(script);
    }
    let shaped = font.shaper.shape(buffer, ShapeOptions::new());
    let em = |units: i32| f64::from(units) / font.units_per_em;
    let joins = joins_letters(piece.script);
    for (info, at) in shaped.glyph_infos().iter().zip(shaped.glyph_positions()) {
        let cluster = info.cluster as usize;
        if info.glyph_id == 0 {
            missing.extend(
                line[cluster..]
                    .graphemes(true)
                    .next()
                    .into_iter()
                    .flat_map(str::chars)
                    .filter(|&c| needs_glyph(c) && !font.has(c)),
            );
            out.push(absent(number, cluster));
            continue;
        }
        out.push(ShapedGlyph {
            font: number,
            glyph: Some(info.glyph_id),
            cluster,
            offset_em: [em(at.x_offset), em(at.y_offset)],
            advance_em: em(at.x_advance),
            joins,
        });
    }
}

fn iso(script: Script) -> Option<harfrust::Script> {
    let name = script.short_name().as_bytes();
    harfrust::Script::from_iso15924_tag(Tag::new(&[*name.first()?, *name.get(1)?, *name.get(2)?, *name.get(3)?]))
}

/// Scripts whose letters touch along the line: cursive ones, and those that hang from a bar.
fn joins_letters(script: Script) -> bool {
    use Script::{
        Adlam, Arabic, Bengali, Chorasmian, Devanagari, Gurmukhi, Hanifi_Rohingya, Mandaic, Manichaean, Modi,
        Mongolian, Nko, Phags_Pa, Psalter_Pahlavi, Sharada, Sogdian, Syriac, Tirhuta,
    };
    #[rustfmt::skip]
    let joins = matches!(script, Adlam | Arabic | Bengali | Chorasmian | Devanagari | Gurmukhi | Hanifi_Rohingya | Mandaic | Manichaean
        | Modi | Mongolian | Nko | Phags_Pa | Psalter_Pahlavi | Sharada | Sogdian | Syriac | Tirhuta);
    joins
}
