//! How a picture is written: which view, how large, on what ground; and a small one that shows what it will be.
//!
//! The small one is made by the very command that writes the large one, with fewer pixels.

use crate::document::{RenderCommand, Scene, ViewName};
use crate::ui::state::dialog::Dialog;
use crate::ui::state::path_purpose::PathPurpose;
use crate::ui::state::picture_wish::Extent;
use crate::ui::state::picture_wish::Ground;
use crate::ui::state::picture_wish::Picturing;
use crate::ui::state::picture_wish::SMALL;
use crate::ui::state::picture_wish::Wish;
use crate::ui::style::colour::colour_button;
use crate::ui::style::theme;
use crate::ui::style::theme::view_title;
use crate::ui::style::widgets::{cancel, primary};
use crate::ui::style::widgets::{choice, from_right_row, row, spinner, tipped};
use crate::ui::thread::session::Request;
use crate::ui::window::app::App;
use egui::{Color32, ColorImage, DragValue, Rect, RichText, Sense, TextureOptions, Ui, pos2, vec2};

/// Most pixels of an edge and of a picture, as the command has them.
const EDGE: u32 = 16_384;
const PIXELS: u64 = 1 << 26;

impl App {
    /// Asks how a picture shall be.
    pub(crate) fn ask_picture(&mut self) {
        if self.opened().is_none() {
            return;
        }
        let wish = Wish { view: self.viewports.alone().unwrap_or(self.picture_wish.view), ..self.picture_wish };
        self.dialog = Some(Dialog::Picture(Box::new(Picturing { wish, asked: None, small: Ok(None) })));
    }

    /// The small picture has come, or not.
    pub(crate) fn take_sketch(&mut self, command: &RenderCommand, sketch: Result<([u32; 2], Vec<u8>), String>) {
        let Some(Dialog::Picture(picturing)) = &mut self.dialog else { return };
        if picturing.asked.as_ref() != Some(command) {
            return;
        }
        picturing.small = sketch.map(|(size, rgba)| {
            let image = ColorImage::from_rgba_unmultiplied(size.map(|s| s as usize), &rgba);
            Some(self.context.load_texture("sketch", image, TextureOptions::LINEAR))
        });
    }

    pub(super) fn picture_dialog(&mut self, ui: &mut Ui, mut picturing: Box<Picturing>) -> Option<Dialog> {
        let scene = self.scene.clone()?;
        ui.heading("Save picture");
        ui.add_space(8.0);
        let narrow = ui.available_width() < 640.0;
        let fields = if narrow { ui.available_width() } else { ui.available_width() - SMALL[0] as f32 - 20.0 };
        ui.horizontal_top(|ui| {
            ui.allocate_ui_with_layout(vec2(fields, 0.0), egui::Layout::top_down(egui::Align::Min), |ui| {
                ui.set_width(fields);
                wishes(ui, &mut picturing.wish, &scene);
            });
            if !narrow {
                ui.add_space(12.0);
                sketch(ui, &picturing);
            }
        });
        let size = picturing.wish.size(&scene);
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let fits = size.iter().all(|s| (1..=EDGE).contains(s)) && pixels <= PIXELS;
        ui.add_space(8.0);
        let said = if fits {
            RichText::new(format!("{} × {} pixels", size[0], size[1])).color(theme::TEXT_WEAK)
        } else {
            let text = format!(
                "{} × {} pixels are too many: at most {EDGE} either way and 67 million in all.",
                size[0], size[1]
            );
            RichText::new(text).color(theme::ERROR)
        };
        ui.label(said);
        let small = picturing.wish.small(&scene);
        if fits && picturing.asked.as_ref() != Some(&small) {
            picturing.asked = Some(small.clone());
            self.request(Request::Sketch(small));
        }
        ui.add_space(10.0);
        let (yes, no) = from_right_row(ui, |ui| {
            let yes = ui.add_enabled(fits, primary("Choose where…")).on_hover_text("Name and folder come next");
            (yes.clicked(), cancel(ui))
        });
        if yes {
            self.picture_wish = picturing.wish;
            self.ask(PathPurpose::Image(picturing.wish));
            return None;
        }
        (!no).then_some(Dialog::Picture(picturing))
    }
}

fn wishes(ui: &mut Ui, wish: &mut Wish, scene: &Scene) {
    let views = [ViewName::ThreeD, ViewName::Axial, ViewName::Coronal, ViewName::Sagittal]
        .map(|v| (v, view_title(v), if v == ViewName::ThreeD { "The 3D view" } else { "The slice that is shown" }));
    row(ui, "View", |ui| {
        if let Some(view) = choice(ui, "View", Some(wish.view), &views) {
            wish.view = view;
        }
    });
    let extents = [
        (Extent::Shown, "As shown", "As many pixels as the view has"),
        (Extent::Double, "2×", "Twice as many either way"),
        (Extent::Hd, "HD", "1920 × 1080"),
        (Extent::Uhd, "4K", "3840 × 2160"),
        (Extent::Custom, "Own", "A size of your own"),
    ];
    row(ui, "Size", |ui| {
        if let Some(extent) = choice(ui, "Size", Some(wish.extent), &extents) {
            if extent == Extent::Custom {
                wish.custom = wish.size(scene);
            }
            wish.extent = extent;
        }
    });
    if wish.extent == Extent::Custom {
        row(ui, "", |ui| {
            for (i, name) in ["Width", "Height"].into_iter().enumerate() {
                let value = DragValue::new(&mut wish.custom[i]).range(1..=EDGE).speed(4.0);
                tipped(ui.add(value).accessible_name(format!("{name} in pixels")), "Drag, or click and type");
                if i == 0 {
                    ui.label("×");
                }
            }
        });
    }
    let samples = [
        (1, "Plain", "One sample a pixel"),
        (2, "Smooth", "Four samples a pixel"),
        (4, "Finest", "Sixteen samples a pixel: takes sixteen times as long"),
    ];
    row(ui, "Edges", |ui| {
        if let Some(n) = choice(ui, "Edges", Some(wish.samples), &samples) {
            wish.samples = n;
        }
    });
    let formats = [
        (false, "PNG", "For documents and the web"),
        (
            true,
            "EXR",
            "Linear light; each pixel of the 3D view also has its depth in mm and says its volume, part, segment and whether it is selected",
        ),
    ];
    row(ui, "Format", |ui| {
        if let Some(exr) = choice(ui, "Format", Some(wish.exr), &formats) {
            wish.exr = exr;
        }
    });
    let grounds = [
        (Ground::Shown, "As shown", "The view's own"),
        (Ground::Colour, "Colour", "A colour for this picture alone"),
        (Ground::Clear, "None", "Transparent"),
    ];
    if wish.exr {
        row(ui, "Background", |ui| ui.label(RichText::new("None: EXR is transparent").color(theme::TEXT_WEAK)));
    } else {
        row(ui, "Background", |ui| {
            if let Some(ground) = choice(ui, "Background", Some(wish.ground), &grounds) {
                wish.ground = ground;
            }
        });
        if wish.ground == Ground::Colour {
            row(ui, "", |ui| {
                colour_button(ui, "Background of the picture", &mut wish.colour);
            });
        }
    }
}

/// The small picture, over a chequered ground where it is transparent.
fn sketch(ui: &mut Ui, picturing: &Picturing) {
    let (rect, response) = ui.allocate_exact_size(vec2(SMALL[0] as f32, SMALL[1] as f32), Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "What the picture will be"));
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, theme::ROUND, theme::DEEP);
    match &picturing.small {
        Ok(Some(texture)) => {
            let size = texture.size_vec2();
            let scale = (rect.width() / size.x).min(rect.height() / size.y).min(1.0);
            let place = Rect::from_center_size(rect.center(), size * scale);
            chequers(&painter, place);
            let all = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            painter.image(texture.id(), place, all, Color32::WHITE);
        }
        Ok(None) => {
            let middle = Rect::from_center_size(rect.center(), vec2(24.0, 24.0));
            ui.scope_builder(egui::UiBuilder::new().max_rect(middle), |ui| spinner(ui, 24.0));
        }
        Err(why) => {
            let inner = rect.shrink(16.0);
            ui.scope_builder(egui::UiBuilder::new().max_rect(inner), |ui| {
                ui.add(egui::Label::new(RichText::new(why).color(theme::ERROR)).wrap());
            });
        }
    }
}

fn chequers(painter: &egui::Painter, place: Rect) {
    const CELL: f32 = 10.0;
    painter.rect_filled(place, 0.0, Color32::from_gray(0x66));
    let (across, down) = ((place.width() / CELL).ceil() as u32, (place.height() / CELL).ceil() as u32);
    for i in 0..across * down {
        let (x, y) = (i % across, i / across);
        if (x + y) % 2 == 0 {
            let at = place.min + vec2(x as f32, y as f32) * CELL;
            painter.rect_filled(
                Rect::from_min_size(at, vec2(CELL, CELL)).intersect(place),
                0.0,
                Color32::from_gray(0x99),
            );
        }
    }
}
