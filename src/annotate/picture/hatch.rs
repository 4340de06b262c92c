//! Hatching and other patterns that repeat.
//!
//! A pattern is the texture of one period along its own axes, and a map that turns it by its angle and repeats it over the rectangle: its
//! lines are as fine as wanted at any size, and no seam shows at any angle. Owns the figures of a period. Knows no grid.

use crate::annotate::picture::distance::DistanceField;
use crate::annotate::picture::error::{AnnotateError, checked_length};
use crate::annotate::picture::outline::{Outline, Rect};
use crate::annotate::picture::sheet::{Paint, Sheet, checked_halo, columns};
use crate::annotate::picture::texture::Texture;
use glam::{DAffine2, DMat2, DVec2};
use serde::{Deserialize, Serialize};

/// The most texels of a period on a side: what bounds how thin a line may be against the spacing.
const MAX_PERIOD: f64 = 2048.0;

/// The least texels of a period.
const LEAST_PERIOD: f64 = 64.0;

/// Texels across a line or a dot, where the period allows.
const TEXELS_PER_LINE: f64 = 8.0;

/// What repeats. Lengths in mm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Figure {
    /// Parallel lines.
    Lines {
        /// From middle to middle.
        spacing_mm: f64,
        /// Of a line, under the spacing.
        width_mm: f64,
    },
    /// Lines both ways.
    Cross {
        /// From middle to middle.
        spacing_mm: f64,
        /// Of a line, under the spacing.
        width_mm: f64,
    },
    /// Dots, each row shifted by half a spacing against the next.
    Dots {
        /// From middle to middle of neighbours in a row; rows are √3/2 of it apart, so that all neighbours are as near.
        spacing_mm: f64,
        /// Of a dot, under the spacing.
        diameter_mm: f64,
    },
    /// Squares of which every other one is full.
    Checker {
        /// A square's side.
        side_mm: f64,
    },
}

/// A pattern over a rectangle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hatch {
    /// What repeats.
    pub figure: Figure,
    /// Turned counter-clockwise by so many degrees; lines run to the right at 0.
    pub angle_deg: f64,
    /// Width and height of the rectangle, mm.
    pub size_mm: [f64; 2],
}

impl Hatch {
    /// Its texture, to be sampled with repetition through `texture_from_uv`.
    ///
    /// # Errors
    /// If a length is out of range, or lines are under 1/512 of the spacing.
    pub fn sheet(&self, paint: &Paint) -> Result<Sheet, AnnotateError> {
        let size =
            DVec2::new(checked_length("width_mm", self.size_mm[0])?, checked_length("height_mm", self.size_mm[1])?);
        if !self.angle_deg.is_finite() {
            return Err(AnnotateError::out("angle_deg", self.angle_deg, "a finite angle"));
        }
        let halo = checked_halo(paint)?;
        let period = self.figure.period()?;
        // Whole texels on both sides: the period of rows of dots is a little off square, at most a texel in MAX_PERIOD.
        let texels_y = (TEXELS_PER_LINE * period.y / period.thin).clamp(LEAST_PERIOD, MAX_PERIOD).ceil();
        let texel = period.y / texels_y;
        let texels_x = period.x.map_or(4.0, |x| (x / texel).round().max(1.0));
        // Where the period is not whole, the drawing is stretched to it.
        let stretch = period.x.map_or(1.0, |x| texels_x * texel / x);
        let reach = (0.5 * texels_x.max(texels_y)).max(2.0);
        let spread = reach.min(1024.0);
        let tile = DVec2::new(texels_x, texels_y) * texel;
        let outline = self.figure.outline(tile, stretch, spread * texel);
        let corner = DVec2::new(-0.5 * tile.x, 0.5 * tile.y);
        let field = DistanceField::of(&outline, corner, texel, [texels_x as usize, texels_y as usize], spread)?;
        let halo = paint.halo.map(|(colour, _)| (colour, halo.min(spread * texel)));
        // From the rectangle's uv to mm about its middle, into the pattern's axes, to periods, v downwards.
        let mm = DAffine2::from_mat2_translation(
            DMat2::from_diagonal(DVec2::new(size.x, -size.y)),
            DVec2::new(-0.5, 0.5) * size,
        );
        let turned = DAffine2::from_angle(-self.angle_deg.to_radians()) * mm;
        let along = DVec2::new(period.x.unwrap_or(tile.x), -period.y);
        let to_periods = DAffine2::from_mat2_translation(DMat2::from_diagonal(along.recip()), DVec2::splat(0.5));
        Ok(Sheet {
            texture: Texture::Distance { field, fill: paint.fill, halo },
            size_mm: size.to_array(),
            origin_mm: (0.5 * size).to_array(),
            texture_from_uv: columns(&(to_periods * turned)),
            missing: Vec::new(),
        })
    }
}

/// A period along the pattern's axes, mm: none in x where all x are alike.
struct Period {
    x: Option<f64>,
    y: f64,
    /// The thinnest part of the figure.
    thin: f64,
}

impl Figure {
    fn period(&self) -> Result<Period, AnnotateError> {
        let (spacing, width, field) = match *self {
            Self::Lines { spacing_mm, width_mm } | Self::Cross { spacing_mm, width_mm } => {
                (spacing_mm, width_mm, "width_mm")
            }
            Self::Dots { spacing_mm, diameter_mm } => (spacing_mm, diameter_mm, "diameter_mm"),
            Self::Checker { side_mm } => (2.0 * side_mm, side_mm, "side_mm"),
        };
        let spacing = checked_length("spacing_mm", spacing)?;
        let width = checked_length(field, width)?;
        if width >= spacing || width < spacing / 512.0 {
            return Err(AnnotateError::out(
                field,
                width,
                format!("{} mm to under the spacing of {spacing} mm", spacing / 512.0),
            ));
        }
        let thin = width.min(spacing - width);
        Ok(match self {
            Self::Lines { .. } => Period { x: None, y: spacing, thin },
            Self::Cross { .. } | Self::Checker { .. } => Period { x: Some(spacing), y: spacing, thin },
            Self::Dots { .. } => Period { x: Some(spacing), y: spacing * 3f64.sqrt(), thin },
        })
    }

    /// All of it within `reach` of the tile about (0, 0).
    fn outline(&self, tile: DVec2, stretch: f64, reach: f64) -> Outline {
        let mut outline = Outline::new();
        let far = 0.5 * tile + 2.0 * reach;
        let [columns, rows] = [far.x / tile.x, far.y / tile.y].map(|n| n.ceil() as i32);
        let half_x = 0.5 * tile.x;
        match *self {
            Self::Lines { width_mm, .. } => {
                for row in -rows..=rows {
                    let y = f64::from(row) * tile.y;
                    outline.add_rect(Rect::new(
                        DVec2::new(-far.x, y - 0.5 * width_mm),
                        DVec2::new(far.x, y + 0.5 * width_mm),
                    ));
                }
            }
            Self::Cross { width_mm, .. } => {
                for n in -rows.max(columns)..=rows.max(columns) {
                    let (at, half) = (f64::from(n) * tile.y, 0.5 * width_mm);
                    outline.add_rect(Rect::new(DVec2::new(-far.x, at - half), DVec2::new(far.x, at + half)));
                    outline.add_rect(Rect::new(DVec2::new(at - half, -far.y), DVec2::new(at + half, far.y)));
                }
            }
            Self::Dots { diameter_mm, .. } => {
                for row in -rows..=rows {
                    for column in -columns..=columns {
                        let at = DVec2::new(f64::from(column), f64::from(row)) * tile;
                        for at in [at, at + 0.5 * tile] {
                            let mut dot = Outline::new();
                            dot.add_disc(DVec2::ZERO, 0.5 * diameter_mm, 96);
                            outline.extend(dot.mapped(&DAffine2::from_scale_angle_translation(
                                DVec2::new(stretch, 1.0),
                                0.0,
                                at,
                            )));
                        }
                    }
                }
            }
            Self::Checker { .. } => {
                for row in -2 * rows..=2 * rows {
                    for column in -2 * columns..=2 * columns {
                        if (row + column) % 2 == 0 {
                            let at = DVec2::new(f64::from(column), f64::from(row)) * half_x;
                            outline.add_rect(Rect::new(at, at + half_x));
                        }
                    }
                }
            }
        }
        outline
    }
}
