//! A finished picture on the host, and its files.
//!
//! PNG takes the display-referred colour as it is; EXR holds linear colour (sRGB's transfer curve undone), `Z` in mm along
//! the ray with +inf for nothing, and `id`. Knows nothing of how the picture came to be.

use crate::gpu::picture::object_id::ObjectId;
use crate::io::{IoError, replace_file};
use crate::math::DVec2;
use exr::prelude as exr;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// Why a picture could not be kept.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The file could not be written.
    #[error("cannot write {path}: {reason}; check the folder, its rights and the free space")]
    Unwritable {
        /// File.
        path: PathBuf,
        /// What the system or the encoder said.
        reason: String,
    },
    /// No format goes with the file's name.
    #[error("{path}: no picture format for this extension; .png or .exr expected")]
    UnknownFormat {
        /// File.
        path: PathBuf,
    },
}

/// A picture; pixels row by row from the top-left corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Display-referred red, green, blue, multiplied by alpha, and alpha.
    pub colour: Vec<[f32; 4]>,
    /// Millimetres along the ray from the eye (from the image plane in orthographic projection); +inf where there is nothing.
    /// DVR: where opacity reaches ½.
    pub depth_mm: Vec<f32>,
    /// What is at that depth.
    pub object: Vec<ObjectId>,
}

impl Image {
    /// Nothing at all.
    pub fn empty(size: [u32; 2]) -> Self {
        let count = size[0] as usize * size[1] as usize;
        Self {
            size,
            colour: vec![[0.0; 4]; count],
            depth_mm: vec![f32::INFINITY; count],
            object: vec![ObjectId::NOTHING; count],
        }
    }

    /// Place of the pixel that holds a point of the picture, if it is inside.
    pub fn index(&self, px: DVec2) -> Option<usize> {
        let inside = px.x >= 0.0 && px.y >= 0.0 && px.x < f64::from(self.size[0]) && px.y < f64::from(self.size[1]);
        inside.then(|| px.x as usize + px.y as usize * self.size[0] as usize)
    }

    /// Lays another picture over this one, its top-left corner at `corner`; what reaches beyond this one is left out.
    pub fn put(&mut self, part: &Self, corner: [u32; 2]) {
        let width = part.size[0].min(self.size[0].saturating_sub(corner[0])) as usize;
        for y in 0..part.size[1].min(self.size[1].saturating_sub(corner[1])) {
            let from = (y * part.size[0]) as usize;
            let to = corner[0] as usize + (corner[1] + y) as usize * self.size[0] as usize;
            self.colour[to..to + width].copy_from_slice(&part.colour[from..from + width]);
            self.depth_mm[to..to + width].copy_from_slice(&part.depth_mm[from..from + width]);
            self.object[to..to + width].copy_from_slice(&part.object[from..from + width]);
        }
    }

    /// `factor`² pixels made one: the mean of their display-referred colours as they are shown (0 to 1), which is how the caster
    /// composites too, so that a picture over a background is the mean of the large picture over it. Depth and object stay
    /// together and are those of the pixel in the middle; of the four about the middle where `factor` is even, of the nearest.
    /// What is left of a side that `factor` does not divide is cut off.
    #[must_use]
    pub fn averaged(self, factor: u32) -> Self {
        if factor <= 1 {
            return self;
        }
        let [width, f] = [self.size[0] as usize, factor as usize];
        let mut small = Self::empty(self.size.map(|s| s / factor));
        let share = 1.0 / (f * f) as f64;
        let across = (small.size[0] as usize).max(1);
        for i in 0..small.colour.len() {
            let first = i % across * f + i / across * f * width;
            let mut sum = [0.0; 4];
            for row in 0..f {
                for &[r, g, b, a] in &self.colour[first + row * width..][..f] {
                    // A highlight is no whiter than white: its rim would stay ragged.
                    let shown = [r.min(a).max(0.0), g.min(a).max(0.0), b.min(a).max(0.0), a];
                    sum.iter_mut().zip(shown).for_each(|(s, c)| *s += f64::from(c));
                }
            }
            small.colour[i] = sum.map(|s| (s * share) as f32);
            let middle = (f - 1) / 2..=f / 2;
            let about = middle.clone().flat_map(|y| middle.clone().map(move |x| first + x + y * width));
            if let Some(at) = about.min_by(|&a, &b| self.depth_mm[a].total_cmp(&self.depth_mm[b])) {
                (small.depth_mm[i], small.object[i]) = (self.depth_mm[at], self.object[at]);
            }
        }
        small
    }

    /// Eight bits a channel, not multiplied by alpha: over `background` and opaque, or with alpha if there is none.
    pub fn to_rgba8(&self, background: Option<[f32; 3]>) -> Vec<u8> {
        let byte = |x: f32| (x.clamp(0.0, 1.0) * 255.0).round() as u8;
        self.colour
            .iter()
            .flat_map(|&[r, g, b, a]| match background {
                Some(under) => {
                    let mix = |i: usize, c: f32| byte(c + under[i] * (1.0 - a));
                    [mix(0, r), mix(1, g), mix(2, b), 255]
                }
                None if a <= 0.0 => [0; 4],
                None => [byte(r / a), byte(g / a), byte(b / a), byte(a)],
            })
            .collect()
    }

    /// Writes PNG or EXR, as the file's extension says. `background` is for PNG.
    ///
    /// # Errors
    /// [`ImageError`].
    pub fn write(&self, path: &Path, background: Option<[f32; 3]>) -> Result<(), ImageError> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("png") => self.write_png(path, background),
            Some("exr") => self.write_exr(path),
            _ => Err(ImageError::UnknownFormat { path: path.to_path_buf() }),
        }
    }

    /// Writes a PNG.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_png(&self, path: &Path, background: Option<[f32; 3]>) -> Result<(), ImageError> {
        let bytes = self.to_rgba8(background);
        let [w, h] = self.size;
        let mut file = Cursor::new(Vec::new());
        image::write_buffer_with_format(&mut file, &bytes, w, h, image::ColorType::Rgba8, image::ImageFormat::Png)
            .map_err(|e| unwritable(path, &e))?;
        keep(path, file.get_ref())
    }

    /// Writes an EXR with channels `R G B A Z id volume segment selected` in one layer, 32 bits each: `id` is the body's plus 1,
    /// `volume` the volume's plus 1, `segment` the label, `selected` 1 where the volume is selected by half at least; 0 is nothing.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_exr(&self, path: &Path) -> Result<(), ImageError> {
        let linear: Vec<[f32; 4]> = self.colour.iter().map(|&c| linear(c)).collect();
        let plane = |i: usize| exr::FlatSamples::F32(linear.iter().map(|c| c[i]).collect());
        // Numbers from 1 on, so that 0 is nothing.
        let whole = |of: &dyn Fn(ObjectId) -> Option<u32>| {
            exr::FlatSamples::U32(self.object.iter().map(|&object| of(object).map_or(0, |id| id + 1)).collect())
        };
        let segments = self.object.iter().map(|object| object.segment().map_or(0, u32::from));
        let channels = [
            ("R", plane(0)),
            ("G", plane(1)),
            ("B", plane(2)),
            ("A", plane(3)),
            ("Z", exr::FlatSamples::F32(self.depth_mm.clone())),
            ("id", whole(&|object| object.body())),
            ("volume", whole(&|object| object.volume().map(|volume| volume.0))),
            ("segment", exr::FlatSamples::U32(segments.collect())),
            ("selected", exr::FlatSamples::U32(self.object.iter().map(|o| u32::from(o.is_selected())).collect())),
        ];
        let channels = channels.map(|(name, samples)| exr::AnyChannel::new(name, samples)).into_iter().collect();
        let layer = exr::Layer::new(
            (self.size[0] as usize, self.size[1] as usize),
            exr::LayerAttributes::default(),
            // In order: chunks that are compressed on several threads would lie in the file as they came, otherwise.
            exr::Encoding { line_order: exr::LineOrder::Increasing, ..exr::Encoding::FAST_LOSSLESS },
            exr::AnyChannels::sort(channels),
        );
        use exr::WritableImage;
        let mut file = Cursor::new(Vec::new());
        exr::Image::from_layer(layer).write().to_buffered(&mut file).map_err(|e| unwritable(path, &e))?;
        keep(path, file.get_ref())
    }
}

/// Puts a whole picture in an old one's place: what fails midway leaves the old one.
fn keep(path: &Path, bytes: &[u8]) -> Result<(), ImageError> {
    replace_file(path, bytes).map_err(|error| match error {
        IoError::System { source, .. } => unwritable(path, &source),
        other => unwritable(path, &other),
    })
}

fn unwritable(path: &Path, reason: &dyn std::fmt::Display) -> ImageError {
    ImageError::Unwritable { path: path.to_path_buf(), reason: crate::io::without_numbers(&reason.to_string()) }
}

/// Colour as light: the transfer curve of sRGB undone on the colour itself, then multiplied by alpha again.
fn linear([r, g, b, a]: [f32; 4]) -> [f32; 4] {
    let light = |c: f32| {
        let c = if a > 0.0 { c / a } else { 0.0 };
        let light = if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
        light * a
    };
    [light(r), light(g), light(b), a]
}
