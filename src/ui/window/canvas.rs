//! What lies under the controls: the panels' grounds and the views' pictures, laid there by a shader of their own.
//!
//! Panels and views say where they lie while a frame is made; all of it is drawn before the first control. Owns the window's
//! line to its graphics device. In a window without one, as tests have, nothing lies there.

use crate::document::ViewName;
use crate::gpu::{Backdrop, BackdropDraw, BackdropPicture, Fill, Gpu, GpuError};
use crate::ui::state::pixels::pixels as pixels_of;
use crate::ui::style::theme;
use crate::ui::thread::session::Picture;
use eframe::egui_wgpu::{Callback, CallbackResources, CallbackTrait, RenderState};
use egui::layers::ShapeIdx;
use egui::{Color32, LayerId, Order, PaintCallbackInfo, Rect, Shape, Ui};

/// The window's graphics device, for what lies under the controls.
#[derive(Debug)]
pub struct Canvas(Backdrop);

/// Where what lies.
#[derive(Default)]
pub(crate) struct BackdropList {
    canvas: Option<Canvas>,
    fills: Vec<(Rect, Color32)>,
    details: Vec<(Rect, Color32)>,
    pictures: Vec<(Rect, ViewName)>,
    marks: Vec<(Rect, Color32)>,
    /// The place under all controls of this frame.
    under: Option<ShapeIdx>,
}

impl Canvas {
    /// On the device that a window draws its controls with.
    ///
    /// # Errors
    /// What the device refuses.
    pub fn new(state: &RenderState) -> Result<Self, GpuError> {
        let gpu = Gpu::from_wgpu(&state.adapter, state.device.clone(), state.queue.clone())?;
        Ok(Self(Backdrop::new(gpu, state.target_format)?))
    }
}

impl BackdropList {
    pub(crate) fn on(canvas: Canvas) -> Self {
        Self { canvas: Some(canvas), ..Self::default() }
    }

    /// Takes in a picture.
    ///
    /// # Errors
    /// What the device refuses.
    pub(crate) fn take(&mut self, picture: &Picture) -> Result<(), GpuError> {
        let Some(Canvas(backdrop)) = &mut self.canvas else { return Ok(()) };
        backdrop.take(picture.view as u32, picture.size, &picture.rgba)
    }

    /// Forgets all pictures.
    pub(crate) fn forget(&mut self) {
        if let Some(Canvas(backdrop)) = &mut self.canvas {
            backdrop.forget();
        }
    }

    /// A new frame; before the first control.
    pub(crate) fn begin(&mut self, ui: &Ui) {
        self.fills.clear();
        self.details.clear();
        self.pictures.clear();
        self.marks.clear();
        self.under = Some(ui.painter().add(Shape::Noop));
    }

    /// This colour lies here.
    pub(crate) fn fill(&mut self, place: Rect, colour: Color32) {
        self.fills.push((place, colour));
    }

    /// This colour lies here over a fill, as far as `ui` is in sight.
    pub(crate) fn detail(&mut self, ui: &Ui, place: Rect, colour: Color32) {
        let seen = place.intersect(ui.clip_rect());
        if seen.is_positive() {
            self.details.push((seen, colour));
        }
    }

    /// This colour lies here over a picture.
    pub(crate) fn mark(&mut self, place: Rect, colour: Color32) {
        self.marks.push((place, colour));
    }

    /// A view's picture lies here.
    pub(crate) fn picture(&mut self, place: Rect, view: ViewName) {
        self.pictures.push((place, view));
    }

    /// The frame is complete; with what begun it.
    ///
    /// # Errors
    /// What the device refuses.
    pub(crate) fn end(&mut self, ui: &Ui) -> Result<(), GpuError> {
        let (Some(Canvas(backdrop)), Some(place)) = (&self.canvas, self.under.take()) else { return Ok(()) };
        let (scale, window) = (ui.pixels_per_point(), ui.ctx().viewport_rect());
        let fill = |&(rect, colour): &(Rect, Color32)| Fill { place: pixels(rect, scale), colour: parts(colour) };
        let under: Vec<_> = self.fills.iter().chain(&self.details).map(fill).collect();
        let shown = self
            .pictures
            .iter()
            .map(|&(rect, view)| BackdropPicture { place: pixels(rect, scale), picture: view as u32 });
        let shown: Vec<_> = shown.collect();
        let over: Vec<_> = self.marks.iter().map(fill).collect();
        let draw = backdrop.prepare(pixels_of(window, scale), &under, &shown, &over)?;
        ui.painter().set(place, Callback::new_paint_callback(window, BackdropPass(draw)));
        Ok(())
    }

    /// Darkens the whole window under a question.
    pub(crate) fn shade(&self, ctx: &egui::Context) {
        let Some(Canvas(backdrop)) = &self.canvas else { return };
        let (scale, window) = (ctx.pixels_per_point(), ctx.viewport_rect());
        let fill = Fill { place: pixels(window, scale), colour: parts(theme::SHADE) };
        // A refusal is reported by what lies under all controls.
        if let Ok(draw) = backdrop.prepare(pixels_of(window, scale), &[fill], &[], &[]) {
            // A layer that is no window's comes after all windows of its order.
            let layer = LayerId::new(Order::Middle, egui::Id::unique("shade"));
            ctx.layer_painter(layer).add(Callback::new_paint_callback(window, BackdropPass(draw)));
        }
    }
}

fn pixels(rect: Rect, scale: f32) -> [f32; 4] {
    [rect.min.x, rect.min.y, rect.max.x, rect.max.y].map(|x| (x * scale).round())
}

fn parts(colour: Color32) -> [f32; 4] {
    colour.to_array().map(|x| f32::from(x) / 255.0)
}

struct BackdropPass(BackdropDraw);

impl CallbackTrait for BackdropPass {
    fn paint(&self, _: PaintCallbackInfo, pass: &mut wgpu::RenderPass<'static>, _: &CallbackResources) {
        self.0.draw(pass);
    }
}
