//! A texture with its size in mm: what an annotation's grid is covered with.
//!
//! Owns how fine a drawing is sampled and how much room its halo needs. Knows how drawings are asked for, no grid and no picture.

use crate::annotate::picture::distance::{DistanceField, MAX_SIDE, MAX_TEXELS};
use crate::annotate::picture::error::AnnotateError;
use crate::annotate::picture::outline::{Outline, Rect};
use crate::annotate::picture::texture::Texture;
use glam::{DAffine2, DVec2};
use serde::{Deserialize, Serialize};

/// Texels per em of text.
pub const TEXELS_PER_EM: f64 = 96.0;

/// The most texels that a halo is wide; a wider one makes all texels larger.
pub const MAX_HALO_TEXELS: f64 = 64.0;

/// The spread is at least this, and this much more than the halo, texels: room for a pixel that covers many texels.
const LEAST_SPREAD: f64 = 8.0;

/// Colours of a drawing. Straight alpha, display-referred.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Paint {
    /// Of what is inside.
    pub fill: [u8; 4],
    /// Colour and width in mm of what surrounds it.
    #[serde(default)]
    pub halo: Option<([u8; 4], f64)>,
}

/// A texture that covers a rectangle, or repeats over it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// What is sampled.
    pub texture: Texture,
    /// Width and height of the whole rectangle, mm.
    pub size_mm: [f64; 2],
    /// Where the drawing's own point (0, 0) lies in the rectangle, mm from its left lower corner: the first baseline's middle of a text,
    /// the
    /// middle of a ruler's or an arrow's line.
    pub origin_mm: [f64; 2],
    /// Texture coordinates of the rectangle's (u, v), (0, 0) being its left upper corner: by columns the images of u and of v, then the
    /// image of (0, 0). The identity but for patterns, whose texture is one period and repeats in both directions.
    pub texture_from_uv: [[f64; 2]; 3],
    /// Characters that no font has.
    pub missing: Vec<char>,
}

impl Sheet {
    /// Of an outline, `bounds` around it and whatever else the rectangle should hold, sampled at `texel_mm` or as much coarser as the
    /// limits of textures and halo ask for.
    ///
    /// # Errors
    /// If the halo's width or another length is out of range.
    pub fn drawn(outline: &Outline, bounds: Rect, texel_mm: f64, paint: &Paint) -> Result<Self, AnnotateError> {
        let halo = checked_halo(paint)?;
        let mut texel = texel_mm.max(halo / MAX_HALO_TEXELS);
        let size = bounds.size();
        if !(size.is_finite() && size.min_element() >= 0.0) {
            return Err(AnnotateError::out("size", size, "a finite rectangle"));
        }
        let layout = loop {
            let spread = LEAST_SPREAD + (halo / texel).ceil();
            // Half a pixel of soft edge stays inside the rectangle while a pixel covers up to four texels.
            let margin = halo + 3.0 * texel;
            let texels = ((size + 2.0 * margin) / texel).ceil().max(DVec2::ONE);
            if texels.max_element() <= MAX_SIDE as f64 && texels.x * texels.y <= MAX_TEXELS as f64 {
                break (texels, spread);
            }
            texel *= 1.05;
        };
        let (texels, spread) = layout;
        let middle = bounds.min.midpoint(bounds.max);
        let half = 0.5 * texel * texels;
        let corner = DVec2::new(middle.x - half.x, middle.y + half.y);
        let field = DistanceField::of(outline, corner, texel, [texels.x as usize, texels.y as usize], spread)?;
        Ok(Self {
            texture: Texture::Distance { field, fill: paint.fill, halo: paint.halo },
            size_mm: (2.0 * half).to_array(),
            origin_mm: (half - middle).to_array(),
            texture_from_uv: columns(&DAffine2::IDENTITY),
            missing: Vec::new(),
        })
    }

    /// An image over a rectangle of this width; the height follows from its texels.
    ///
    /// # Errors
    /// If the width is not above 0.
    pub fn of_image(image: Texture, width_mm: f64) -> Result<Self, AnnotateError> {
        let width = crate::annotate::picture::error::checked_length("width_mm", width_mm)?;
        let [w, h] = image.size();
        let height = width * h as f64 / w as f64;
        let origin_mm = [0.5 * width, 0.5 * height];
        Ok(Self {
            texture: image,
            size_mm: [width, height],
            origin_mm,
            texture_from_uv: columns(&DAffine2::IDENTITY),
            missing: vec![],
        })
    }
}

/// The halo's width, mm; 0 without one.
pub(crate) fn checked_halo(paint: &Paint) -> Result<f64, AnnotateError> {
    match paint.halo {
        Some((_, mm)) if !(mm.is_finite() && (0.0..=1e6).contains(&mm)) => {
            Err(AnnotateError::out("halo", mm, "0 to 1,000,000 mm"))
        }
        Some((_, mm)) => Ok(mm),
        None => Ok(0.0),
    }
}

pub(crate) fn columns(map: &DAffine2) -> [[f64; 2]; 3] {
    [map.matrix2.x_axis, map.matrix2.y_axis, map.translation].map(|v| v.to_array())
}
