//! What a GPU samples: textures of distances or of colours, and their coarser levels down to 1 × 1.
//!
//! A level of a distance texture has two half floats a texel: red the distance to the fill's edge, green to the halo's, in texels of level
//! 0,
//! positive inside. A pixel that covers w texels of level 0 is covered by clamp(0.5 + value / w, 0, 1). Coarser levels do not hold mean
//! distances, under which thin strokes fade to nothing, but (mean coverage − 0.5) · 2^level, so that coverage is kept at every size.
//! Knows no device; `bytes` are laid out as one is given them.

use crate::annotate::picture::distance::DistanceField;
use crate::annotate::picture::error::AnnotateError;
use half::f16;

/// The most texels on an image's side.
pub const MAX_IMAGE_SIDE: usize = 8192;

/// What the bytes of a level are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TexelFormat {
    /// Two half floats: distances to the edges of fill and halo, in texels of level 0.
    Rg16Float,
    /// Premultiplied red, green, blue and alpha, 8 bits each, display-referred.
    Rgba8,
}

/// One level of a chain, tightly packed, row 0 uppermost.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Texels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Four bytes a texel in both formats, little-endian.
    pub bytes: Vec<u8>,
}

/// A texture over an annotation's rectangle: u from 0 at its left to 1 at its right, v from 0 at its top to 1 at its bottom.
#[derive(Clone, Debug, PartialEq)]
pub enum Texture {
    /// One fill, and a halo around it, by distance.
    Distance {
        /// Distances to the fill's edge.
        field: DistanceField,
        /// Red, green, blue and alpha (straight) of what is inside, display-referred.
        fill: [u8; 4],
        /// Colour of the halo (straight) and its width in mm, at most `field.spread` texels; none has width 0.
        halo: Option<([u8; 4], f64)>,
    },
    /// Colours with alpha.
    Image {
        /// Texels in a row.
        width: usize,
        /// Rows.
        height: usize,
        /// Premultiplied, display-referred, row 0 uppermost.
        rgba: Vec<[u8; 4]>,
    },
}

impl Texture {
    /// Of an image with straight alpha, row 0 uppermost.
    ///
    /// # Errors
    /// If a side is 0 or more than [`MAX_IMAGE_SIDE`], or there are not `width × height` texels.
    pub fn image(width: usize, height: usize, straight: &[[u8; 4]]) -> Result<Self, AnnotateError> {
        if !(1..=MAX_IMAGE_SIDE).contains(&width) || !(1..=MAX_IMAGE_SIDE).contains(&height) {
            return Err(AnnotateError::out(
                "image",
                format!("{width} × {height}"),
                format!("1 to {MAX_IMAGE_SIDE} texels a side"),
            ));
        }
        if straight.len() != width * height {
            return Err(AnnotateError::out(
                "image",
                format!("{} texels", straight.len()),
                format!("{width} × {height}"),
            ));
        }
        let times = |c: u8, a: u8| ((u32::from(c) * u32::from(a) + 127) / 255) as u8;
        let rgba = straight.iter().map(|&[r, g, b, a]| [times(r, a), times(g, a), times(b, a), a]).collect();
        Ok(Self::Image { width, height, rgba })
    }

    /// What the bytes of its levels are.
    pub fn format(&self) -> TexelFormat {
        match self {
            Self::Distance { .. } => TexelFormat::Rg16Float,
            Self::Image { .. } => TexelFormat::Rgba8,
        }
    }

    /// Texels in a row and rows of level 0.
    pub fn size(&self) -> [usize; 2] {
        match self {
            Self::Distance { field, .. } => [field.width, field.height],
            Self::Image { width, height, .. } => [*width, *height],
        }
    }

    /// The halo's width in texels of level 0; 0 without one.
    pub fn halo_texels(&self) -> f64 {
        match self {
            Self::Distance { field, halo: Some((_, mm)), .. } => (mm / field.texel_mm).clamp(0.0, field.spread),
            _ => 0.0,
        }
    }

    /// All levels, level 0 first, the last one 1 × 1. Level k + 1 has half the texels of level k on a side, rounded down, at least one; a
    /// texel is the mean of those it covers, by the area it covers of each, so that means are kept at every size.
    pub fn mips(&self) -> Vec<Level> {
        match self {
            Self::Distance { field, .. } => distance_levels(field, self.halo_texels()),
            Self::Image { width, height, rgba } => image_levels(*width, *height, rgba),
        }
    }
}

fn distance_levels(field: &DistanceField, halo: f64) -> Vec<Level> {
    // Distance and coverage of the fill, then of the halo.
    let cover = |d: f32| (0.5 + d).clamp(0.0, 1.0);
    let texel = |&d: &f32| [d, cover(d), d + halo as f32, cover(d + halo as f32)];
    let mut levels = Vec::new();
    chain([field.width, field.height], field.texels.iter().map(texel).collect(), |[width, height], texels| {
        let step = (1u32 << levels.len().min(31)) as f32;
        let value = |d: f32, cover: f32| match (levels.is_empty(), cover) {
            (true, _) => d,
            (_, c) if c > 1e-4 && c < 1.0 - 1e-4 => (c - 0.5) * step,
            (_, c) => {
                if c > 0.5 {
                    d.max(0.5 * step)
                } else {
                    d.min(-0.5 * step)
                }
            }
        };
        let pair = |[d, c, e, h]: &[f32; 4]| {
            let [[a, b], [x, y]] = [value(*d, *c), value(*e, *h)].map(|v| f16::from_f32(v).to_le_bytes());
            [a, b, x, y]
        };
        let bytes = texels.iter().flat_map(pair).collect();
        levels.push(Level { width, height, bytes });
    });
    levels
}

fn image_levels(width: usize, height: usize, rgba: &[[u8; 4]]) -> Vec<Level> {
    // Burin lays display-referred colours over each other as they are, so they are averaged as they are too: a far picture then is the mean
    // of
    // the near one. Premultiplied, or the hidden colour of transparent texels would bleed into edges.
    let mut levels = Vec::new();
    chain([width, height], rgba.iter().map(|c| c.map(f32::from)).collect(), |[width, height], texels: &[[f32; 4]]| {
        let bytes = texels.iter().flat_map(|c| c.map(|x| (x + 0.5) as u8)).collect();
        levels.push(Level { width, height, bytes });
    });
    levels
}

/// Hands on a level and all coarser ones.
fn chain<const N: usize>(
    mut size: [usize; 2],
    mut texels: Vec<[f32; N]>,
    mut level: impl FnMut([usize; 2], &[[f32; N]]),
) {
    level(size, &texels);
    while size != [1, 1] {
        let to = size.map(|n| (n / 2).max(1));
        texels = halved(size, to, &texels);
        size = to;
        level(size, &texels);
    }
}

fn halved<const N: usize>([width, height]: [usize; 2], to: [usize; 2], texels: &[[f32; N]]) -> Vec<[f32; N]> {
    let (columns, rows) = (shares(width, to[0]), shares(height, to[1]));
    let mut out = Vec::with_capacity(to[0] * to[1]);
    for row in &rows {
        for column in &columns {
            let mut sum = [0.0f32; N];
            for &(y, by) in row {
                for &(x, bx) in column {
                    let texel = &texels[y * width + x];
                    sum.iter_mut().zip(texel).for_each(|(sum, v)| *sum += by * bx * v);
                }
            }
            out.push(sum);
        }
    }
    out
}

/// For each of `to` texels, which of `from` it covers and what share of it that is.
fn shares(from: usize, to: usize) -> Vec<Vec<(usize, f32)>> {
    let wide = from as f64 / to as f64;
    let share = |i: usize| {
        let (low, high) = (i as f64 * wide, (i + 1) as f64 * wide);
        let last = (high.ceil() as usize).min(from);
        let within = |k: usize| (high.min(k as f64 + 1.0) - low.max(k as f64)) / wide;
        (low as usize..last).map(|k| (k, within(k) as f32)).filter(|&(_, s)| s > 0.0).collect()
    };
    (0..to).map(share).collect()
}
