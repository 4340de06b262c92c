//! Pictures: to files by command, and for the window.

use crate::document::Document;
use crate::document::command::answers::{PictureSaid, Said};
use crate::document::command::files::RenderCommand;
use crate::document::error::DocumentError;
use crate::document::paths::check_target;
use crate::document::scene::ViewName;
use crate::document::scene::check::check_size;
use crate::document::scene::check::{checked_colour, safe_camera};
use crate::gpu::Image;
use crate::math::Camera;

/// Times that a picture for a file may be drawn larger than it becomes.
const MOST_SAMPLES: u32 = 8;

/// Pixels along an edge of the pieces in which a picture for a file is drawn: what is held on the device is a piece's, however
/// large the picture.
const PIECE: u32 = 2048;

impl Document {
    pub(crate) fn render(&mut self, command: &RenderCommand) -> Result<Said, DocumentError> {
        let RenderCommand::Image { path, view, size, camera, transparent, background, supersample } = command;
        let (view, size, camera, supersample) = (*view, *size, *camera, *supersample);
        check_target(path, &self.open()?.files)?;
        let views = &self.open()?.scene.views;
        let size = check_size(size.unwrap_or(views.slice(view).map_or(views.size, |s| s.size)))?;
        if view != ViewName::ThreeD && camera.is_some() {
            return Err(DocumentError::invalid(
                "camera",
                format!("one for the {} view", view.name()),
                "none for a slice",
            ));
        }
        if !(1..=MOST_SAMPLES).contains(&supersample) {
            return Err(DocumentError::invalid("supersample", supersample, format!("1 to {MOST_SAMPLES}")));
        }
        if *transparent && background.is_some() {
            return Err(DocumentError::invalid("background", "one for a transparent picture", "one of the two"));
        }
        let background = match background {
            Some(colour) => checked_colour("background", *colour)?,
            None => self.open()?.scene.look.background,
        };
        let mut image = self.fine_picture(view, size, camera, supersample)?;
        if view == ViewName::ThreeD {
            self.write_labels(&mut image, camera, background)?;
        }
        image.write(path, (!transparent).then_some(background))?;
        let shown = image.colour.iter().filter(|c| c[3] > 0.0).count();
        let written = std::path::absolute(path).unwrap_or_else(|_| path.clone());
        let covered = shown as f64 / image.colour.len() as f64;
        Ok(PictureSaid { path: written.display().to_string(), view, size, supersample, covered }.into())
    }

    /// A view at rest, drawn `supersample` times larger either way, piece by piece, and averaged.
    fn fine_picture(
        &mut self,
        view: ViewName,
        size: [u32; 2],
        camera: Option<Camera>,
        supersample: u32,
    ) -> Result<Image, DocumentError> {
        let edge = PIECE / supersample;
        let [across, down] = size.map(|s| s.div_ceil(edge));
        let mut image = Image::empty(size);
        for piece in 0..across * down {
            if !self.watch.proceed(piece as f32 / (across * down) as f32) {
                return Err(DocumentError::Stopped);
            }
            let at = [piece % across * edge, piece / across * edge];
            let part: [u32; 2] = std::array::from_fn(|a| edge.min(size[a] - at[a]));
            let larger = |s: [u32; 2]| s.map(|s| s * supersample);
            let drawn = self.part_of_picture(view, larger(size), camera, (larger(at), larger(part)))?;
            image.put(&drawn.averaged(supersample), at);
        }
        Ok(image)
    }

    /// A rectangle of a view's picture in `size` pixels, given by its top-left corner and its size, with all bricks it needs.
    fn part_of_picture(
        &mut self,
        view: ViewName,
        size: [u32; 2],
        camera: Option<Camera>,
        (corner, part): ([u32; 2], [u32; 2]),
    ) -> Result<Image, DocumentError> {
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        match state.slice_frame(view, size) {
            Some(frame) => self.graphics.slice(state, &frame.part(corner, part)),
            None if view != ViewName::ThreeD => Ok(Image::empty(part)),
            None => {
                let camera = safe_camera(camera.unwrap_or(state.scene.views.camera), &state.bounds())?;
                let mut frame = self.focused(state.frame(self.motion.poses(), &camera, size));
                self.lay_out(&mut frame.layers, true, true);
                let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
                self.graphics.part(state, &frame, corner, part)
            }
        }
    }

    /// A view as it is now, with a running stroke, in `size` pixels; by another camera than the 3D view's if given.
    ///
    /// # Errors
    /// Without a GPU, or whatever the GPU or the source fails with.
    pub fn picture(&mut self, view: ViewName, size: [u32; 2], camera: Option<Camera>) -> Result<Image, DocumentError> {
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        match state.slice_frame(view, check_size(size)?) {
            Some(frame) => self.graphics.slice(state, &frame),
            None if view != ViewName::ThreeD => Ok(Image::empty(size)),
            None => {
                let camera = safe_camera(camera.unwrap_or(state.scene.views.camera), &state.bounds())?;
                let mut frame = self.focused(state.frame(self.motion.poses(), &camera, size));
                self.lay_out(&mut frame.layers, true, false);
                let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
                self.graphics.image(state, &frame)
            }
        }
    }

    /// Some rows of the 3D view in `size` pixels, as an image of their own.
    ///
    /// # Errors
    /// As [`picture`](Self::picture).
    pub fn picture_rows(&mut self, size: [u32; 2], rows: std::ops::Range<u32>) -> Result<Image, DocumentError> {
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        let camera = safe_camera(state.scene.views.camera, &state.bounds())?;
        let mut frame = self.focused(state.frame(self.motion.poses(), &camera, check_size(size)?));
        self.lay_out(&mut frame.layers, true, false);
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        self.graphics.rows(state, &frame, rows)
    }

    /// Says whether something is held or moves: pictures and picks of the 3D view then wait for a bounded number of bricks, and
    /// coarser ones stand in. Scripts never say so.
    pub fn set_motion(&mut self, moving: bool) {
        self.graphics.set_motion(moving);
    }

    /// Whether the last picture was of coarser bricks than it would be at rest.
    pub fn is_pending(&self) -> bool {
        self.graphics.is_pending()
    }

    /// The graphics adapter, or why there is none and what to do.
    ///
    /// # Errors
    /// The reason, in words.
    pub fn describe_gpu(&mut self) -> Result<String, String> {
        self.graphics.describe().map_err(|e| e.to_string())
    }

    /// Draws on this device instead of one of its own.
    pub fn use_gpu(&mut self, gpu: crate::gpu::Gpu) {
        self.graphics.use_gpu(gpu);
    }
}
