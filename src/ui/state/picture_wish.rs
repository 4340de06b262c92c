//! How a picture to be written is wished, and the command that writes it.

use crate::document::RenderCommand;
use crate::document::Scene;
use crate::document::ViewName;
use egui::TextureHandle;
use std::path::PathBuf;

/// Most pixels of the small picture, either way.
pub(crate) const SMALL: [u32; 2] = [384, 240];

/// How large a picture is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Extent {
    Shown,
    Double,
    Hd,
    Uhd,
    Custom,
}

/// What lies behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Ground {
    Shown,
    Colour,
    Clear,
}

/// What is wished.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wish {
    pub(crate) view: ViewName,
    pub(crate) extent: Extent,
    pub(crate) custom: [u32; 2],
    pub(crate) ground: Ground,
    pub(crate) colour: [f32; 3],
    pub(crate) samples: u32,
    pub(crate) exr: bool,
}

impl Default for Wish {
    fn default() -> Self {
        Self {
            view: ViewName::ThreeD,
            extent: Extent::Shown,
            custom: [1600, 1200],
            ground: Ground::Shown,
            colour: [1.0; 3],
            samples: 2,
            exr: false,
        }
    }
}

impl Wish {
    /// Pixels.
    pub(crate) fn size(&self, scene: &Scene) -> [u32; 2] {
        let shown = scene.views.slice(self.view).map_or(scene.views.size, |s| s.size);
        match self.extent {
            Extent::Shown => shown,
            Extent::Double => shown.map(|s| s.saturating_mul(2)),
            Extent::Hd => [1920, 1080],
            Extent::Uhd => [3840, 2160],
            Extent::Custom => self.custom,
        }
    }

    /// The command that writes it.
    pub(crate) fn command(&self, scene: &Scene, path: PathBuf) -> RenderCommand {
        RenderCommand::Image {
            path,
            view: self.view,
            size: Some(self.size(scene)),
            camera: None,
            // EXR is transparent anyhow.
            transparent: self.ground == Ground::Clear && !self.exr,
            background: (self.ground == Ground::Colour && !self.exr).then_some(self.colour),
            supersample: self.samples,
        }
    }

    /// The same with few pixels; a PNG in any case, since it is shown.
    pub(crate) fn small(&self, scene: &Scene) -> RenderCommand {
        let size = self.size(scene).map(f64::from);
        let scale = (f64::from(SMALL[0]) / size[0]).min(f64::from(SMALL[1]) / size[1]).min(1.0);
        let mut command = self.command(scene, PathBuf::new());
        let RenderCommand::Image { size: wanted, supersample, transparent, .. } = &mut command;
        *wanted = Some(size.map(|s| ((s * scale).round() as u32).max(1)));
        *supersample = self.samples.min(2);
        *transparent |= self.exr;
        command
    }
}

/// The question.
pub(crate) struct Picturing {
    pub(crate) wish: Wish,
    /// What the small picture was asked for.
    pub(crate) asked: Option<RenderCommand>,
    pub(crate) small: Result<Option<TextureHandle>, String>,
}
