//! From what an annotation shows to a picture for the GPU and the rectangle that it covers.
//!
//! Owns how contents are drawn in mm; shaping and distances are `annotate::picture`'s. A drawing depends on its content and size alone, so
//! that it is made once wherever it is laid.

use crate::annotate::picture::error::AnnotateError;
use crate::annotate::picture::hatch::{Figure, Hatch};
use crate::annotate::picture::shapes::{Arrow, Frame, Ruler, length_in_words, text_sheet};
use crate::annotate::picture::sheet::{Paint, Sheet};
use crate::annotate::picture::text::{self, Baseline, Text};
use crate::annotate::picture::texture::{TexelFormat, Texture};
use crate::document::error::DocumentError;
use crate::document::live::fonts::FontShelf;
use crate::document::reduce::annotations::round_length;
use crate::document::scene::annotations::{Align, Content, PatternKind};
use crate::gpu::{DecalPicture, Texels, distance_texel};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use half::f16;
use std::sync::Arc;

/// Width of a halo in ems.
const HALO_EM: f64 = 0.12;
/// Texels of an image along an edge.
const MOST_TEXELS: u32 = 4096;

/// What is laid on a grid.
#[derive(Clone, Debug)]
pub(crate) struct Drawing {
    pub picture: Arc<DecalPicture>,
    /// Width and height of its rectangle, mm.
    pub size_mm: [f64; 2],
    /// Where the drawing's own middle lies in it, mm from its left lower corner.
    pub origin_mm: [f64; 2],
    /// Characters that no font has.
    pub missing: String,
}

/// Opaque white: colours are the decal's.
fn paint(em_mm: f64) -> Paint {
    Paint { fill: [255; 4], halo: Some(([255; 4], HALO_EM * em_mm)) }
}

/// Under the names that a command has for what is drawn.
fn refused(error: AnnotateError) -> DocumentError {
    match error {
        AnnotateError::OutOfRange { field, found, expected } => {
            let field = match field {
                "width_mm" | "diameter_mm" | "thickness_mm" => "line_mm",
                "side_mm" => "spacing_mm",
                other => other,
            };
            DocumentError::invalid(field, found, expected)
        }
        other => DocumentError::NotNow(other.to_string()),
    }
}

/// Draws a content of a size; `length_mm`: of a ruler.
///
/// # Errors
/// If it cannot be drawn: a text that is too long, an image that is none.
pub(crate) fn drawing(
    content: &Content,
    size_mm: f64,
    length_mm: f64,
    fonts: &mut FontShelf,
) -> Result<Drawing, DocumentError> {
    let sheet = match content {
        Content::Text { text, bend_mm, align } => {
            let baseline = if *bend_mm == 0.0 { Baseline::Straight } else { Baseline::Sagitta(*bend_mm) };
            let align = match align {
                Align::Start => text::Align::Start,
                Align::Centre => text::Align::Middle,
                Align::End => text::Align::End,
            };
            let set = Text { baseline, align, ..Text::new(text.as_str(), size_mm) };
            let fonts = fonts.with(text).map_err(refused)?;
            text_sheet(&set, &fonts, &paint(size_mm))
        }
        Content::Pattern { kind, aspect, spacing_mm, line_mm, angle_deg } => {
            let (spacing_mm, width_mm, diameter_mm, side_mm) = (*spacing_mm, *line_mm, *line_mm, *spacing_mm);
            let size = [size_mm, size_mm * aspect];
            let plain = Paint { halo: None, ..paint(size_mm) };
            let figure = match kind {
                PatternKind::Lines => Figure::Lines { spacing_mm, width_mm },
                PatternKind::Cross => Figure::Cross { spacing_mm, width_mm },
                PatternKind::Dots => Figure::Dots { spacing_mm, diameter_mm },
                PatternKind::Checker => Figure::Checker { side_mm },
                PatternKind::Frame => {
                    let frame = Frame { size_mm: size, thickness_mm: *line_mm, corner_mm: 0.0 };
                    return frame.sheet(&plain).map(of_sheet).map_err(refused);
                }
            };
            Hatch { figure, angle_deg: *angle_deg, size_mm: size }.sheet(&plain)
        }
        Content::Arrow { thickness } => {
            let thickness_mm = thickness * size_mm;
            let head = (4.0 * thickness_mm).min(0.5 * size_mm);
            let arrow = Arrow {
                length_mm: size_mm,
                thickness_mm,
                head_length_mm: head,
                head_width_mm: (3.4 * thickness_mm).max(thickness_mm),
                both_ends: false,
            };
            arrow.sheet(&paint(4.0 * thickness_mm))
        }
        Content::Ruler { tick_mm, .. } => {
            let label = length_in_words(length_mm);
            let spacing = tick_mm.unwrap_or_else(|| round_length(length_mm / 10.0));
            let ruler = Ruler {
                length_mm,
                thickness_mm: 0.08 * size_mm,
                tick_spacing_mm: Some(spacing),
                longer_every: if tick_mm.is_none() { 5 } else { 0 },
                tick_height_mm: 0.9 * size_mm,
                label: label.clone(),
                label_size_mm: size_mm,
            };
            let fonts = fonts.with(&label).map_err(refused)?;
            ruler.sheet(&fonts, &paint(size_mm))
        }
        Content::Image { path, png } => {
            let png = png.as_ref().ok_or_else(|| DocumentError::invalid("path", path, "an image that was read"))?;
            let texture = decoded(path, png)?;
            Sheet::of_image(texture, size_mm)
        }
    };
    sheet.map(of_sheet).map_err(refused)
}

/// The texels of a PNG file in base 64.
///
/// # Errors
/// If it is none, or larger than a texture can be.
pub(crate) fn decoded(path: &str, png: &str) -> Result<Texture, DocumentError> {
    let bad =
        |why: String| DocumentError::invalid("path", format!("{path}: {why}"), "a PNG image with alpha or without");
    let bytes = STANDARD.decode(png).map_err(|e| bad(e.to_string()))?;
    let mut reader = image::ImageReader::with_format(std::io::Cursor::new(bytes), image::ImageFormat::Png);
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MOST_TEXELS);
    limits.max_image_height = Some(MOST_TEXELS);
    reader.limits(limits);
    let image = reader.decode().map_err(|e| bad(e.to_string()))?.to_rgba8();
    let (width, height) = (image.width() as usize, image.height() as usize);
    let texels: Vec<[u8; 4]> = image.pixels().map(|p| p.0).collect();
    Texture::image(width, height, &texels).map_err(refused)
}

fn of_sheet(sheet: Sheet) -> Drawing {
    let is_shape = sheet.texture.format() == TexelFormat::Rg16Float;
    let levels = (0..).zip(sheet.texture.mips()).map(|(i, level)| {
        let texel = |b: &[u8]| match is_shape {
            true => distance_texel([[b[0], b[1]], [b[2], b[3]]].map(|half| f16::from_le_bytes(half).to_f32()), i),
            false => u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        };
        ([level.width as u32, level.height as u32], level.bytes.chunks_exact(4).map(texel).collect())
    });
    let map = sheet.texture_from_uv.map(|column| column.map(|v| v as f32));
    let picture = DecalPicture {
        texels: if is_shape { Texels::Distances } else { Texels::Colours },
        levels: levels.collect(),
        picture_from_uv: map,
        repeats: map != [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]],
    };
    Drawing {
        picture: Arc::new(picture),
        size_mm: sheet.size_mm,
        origin_mm: sheet.origin_mm,
        missing: sheet.missing.into_iter().collect(),
    }
}
