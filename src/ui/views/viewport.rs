//! The four views: their arrangement, headers and pictures.

use crate::document::{Command, Place, SlicePlane, ViewCommand, ViewName};
use crate::interact::projected;
use crate::math::Projection;
use crate::ui::state::borders::{Border, Edge};
use crate::ui::state::layout::BORDER;
use crate::ui::state::pixels::pixels;
use crate::ui::style::icons::Icon;
use crate::ui::style::theme;
use crate::ui::style::theme::{GAP, view_colour, view_title};
use crate::ui::style::widgets::{Face, icon_button, menu, spinner, tipped};
use crate::ui::window::app::App;
use egui::{
    Align2, Color32, Rect, Role, Sense, Slider, Stroke, StrokeKind, TextStyle, Ui, UiBuilder, WidgetInfo, pos2, vec2,
};

/// Height of a view's header.
const HEADER: f32 = 26.0;
/// Between the views: what is dragged.
const SEAM: f32 = BORDER;
/// Least width of a view's header that has room for the sides as letters.
const ROOMY: f32 = 286.0;
/// Seconds that a picture may be coarse without a word.
const MARK_AFTER_S: f64 = 0.3;
/// Least length of a slider that is worth its place.
const SLIDER: f32 = 44.0;
/// Directions that the 3D view can be seen from: letter, name, from the volume towards the eye.
const SIDES: [(&str, &str, [f64; 3]); 6] = [
    ("A", "anterior", [0.0, 1.0, 0.0]),
    ("P", "posterior", [0.0, -1.0, 0.0]),
    ("R", "right", [1.0, 0.0, 0.0]),
    ("L", "left", [-1.0, 0.0, 0.0]),
    ("S", "superior", [0.0, 0.0, 1.0]),
    ("I", "inferior", [0.0, 0.0, -1.0]),
];

impl App {
    /// Everything between the panels.
    pub(crate) fn central(&mut self, ui: &mut Ui) {
        egui::CentralPanel::no_frame().show(ui, |ui| {
            let all = ui.max_rect();
            if self.opened().is_none() {
                self.backdrop.fill(all, theme::DEEP);
                self.start_page(ui);
                self.show_words(ui.ctx(), all);
                return;
            }
            let tiles: Vec<(ViewName, Rect)> = match self.viewports.maximised {
                Some(view) => vec![(view, all)],
                None => {
                    self.seams(all);
                    quarters(all, self.layout.views).to_vec()
                }
            };
            let scale = ui.ctx().pixels_per_point();
            // Nothing of a menu, a dialog or a tooltip may paint through to a view.
            let open = ui
                .ctx()
                .input(|i| i.pointer.interact_pos())
                .is_none_or(|p| ui.ctx().layer_id_at(p).is_none_or(|l| l == ui.layer_id()))
                && self.dialog.is_none();
            let bodies: Vec<_> = tiles.iter().map(|&(v, r)| (v, body_of(r, scale))).collect();
            self.take_pointer(ui.ctx(), &bodies, open);
            for (&(view, tile), &(_, body)) in tiles.iter().zip(&bodies) {
                self.one_view(ui, view, tile, body);
            }
            let sizes = bodies.iter().map(|&(v, r)| (v, pixels(r, scale))).collect();
            self.report_views(tiles.iter().map(|t| t.0).collect(), sizes);
            self.show_words(ui.ctx(), all);
        });
    }

    fn one_view(&mut self, ui: &mut Ui, view: ViewName, tile: Rect, body: Rect) {
        let header = Rect::from_min_max(tile.min, pos2(tile.max.x, body.min.y));
        self.backdrop.fill(header, theme::BAR);
        let inner = header.shrink2(vec2(6.0, 0.0));
        let mut head =
            ui.new_child(UiBuilder::new().max_rect(inner).layout(egui::Layout::left_to_right(egui::Align::Center)));
        self.view_header(&mut head, view, inner);

        let response = ui.interact(body, ui.scope_id().with(("view", view)), Sense::click_and_drag());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, format!("{} view", view_title(view))));
        let Some(scene) = &self.scene else { return };
        let background = scene.look.background;
        let painter = ui.painter_at(body);
        if self.pictures.has(view) {
            self.backdrop.picture(body, view);
        } else {
            let ground = if view == ViewName::ThreeD { theme::rgb(background) } else { Color32::BLACK };
            self.backdrop.fill(body, ground);
            let text = match &self.snapshot.gpu {
                Some(Err(_)) => "No GPU: no picture",
                _ => "Drawing…",
            };
            let font = egui::FontId::proportional(13.5);
            painter.text(body.center(), Align2::CENTER_CENTER, text, font, theme::TEXT_WEAK);
        }
        if self.pictures.has(view) {
            self.overlay(&painter, view, body);
        }
        if view == ViewName::ThreeD {
            self.refining_mark(ui, body);
        }
        if self.viewports.hovered.is_some_and(|(v, _)| v == view) && self.viewports.maximised.is_none() {
            let colour = view_colour(view).gamma_multiply(0.55);
            painter.rect_stroke(body, 0.0, Stroke::new(1.0, colour), StrokeKind::Inside);
        }
    }

    /// What lies between the views.
    fn seams(&mut self, all: Rect) {
        let [first, .., last] = quarters(all, self.layout.views).map(|q| q.1);
        let (now, extent) = (self.layout.views, (all.size() - vec2(SEAM, SEAM)).into());
        let (x, y) = ([first.max.x, last.min.x], [first.max.y, last.min.y]);
        let place = |x: [f32; 2], y: [f32; 2]| Rect::from_min_max(pos2(x[0], y[0]), pos2(x[1], y[1]));
        for (border, place) in [
            (Border::Upright, place(x, [all.min.y, all.max.y])),
            (Border::Level, place([all.min.x, all.max.x], y)),
            (Border::Crossing, place(x, y).expand(3.0)),
        ] {
            self.border(Edge { border, place, now, extent });
        }
    }

    /// Says in the corner of the 3D view that what is seen is not yet all there is; not while a hand holds something, when it never is.
    fn refining_mark(&mut self, ui: &mut Ui, body: Rect) {
        let now = ui.input(|i| i.time);
        let waits = self.refining && self.pictures.has(ViewName::ThreeD) && self.interaction.gesture().is_none();
        self.refining_since = if waits { self.refining_since.or(Some(now)) } else { None };
        let Some(since) = self.refining_since else { return };
        if now - since < MARK_AFTER_S {
            ui.ctx().request_repaint_after(std::time::Duration::from_secs_f64(MARK_AFTER_S));
            return;
        }
        let text = if self.snapshot.moving { "Parts are moving" } else { "Refining" };
        let place = Rect::from_min_size(pos2(body.max.x - 150.0, body.min.y + 6.0), vec2(142.0, 20.0)).intersect(body);
        let layout = egui::Layout::right_to_left(egui::Align::Center);
        let mut corner = ui.new_child(UiBuilder::new().max_rect(place).layout(layout));
        corner.set_clip_rect(body);
        spinner(&mut corner, 12.0);
        let label = egui::Label::new(egui::RichText::new(text).size(12.0).color(theme::TEXT)).selectable(false);
        corner.add(label);
    }

    /// Title, what belongs to the view as far as there is room for it, and the button that enlarges it.
    fn view_header(&mut self, ui: &mut Ui, view: ViewName, inner: Rect) {
        let title = view_title(view);
        let button = 24.0;
        ui.shrink_clip_rect(inner);
        let (mark, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
        ui.painter().rect_filled(mark, 2.0, view_colour(view));
        let label = ui.add(
            egui::Label::new(egui::RichText::new(title).color(theme::TEXT)).sense(Sense::click()).selectable(false),
        );
        if label.on_hover_text("Double-click: one view or all four").double_clicked() {
            self.viewports.toggle(view);
        }
        ui.add_space(GAP);
        let alone = self.viewports.alone().is_some();
        if view == ViewName::ThreeD {
            if inner.width() >= ROOMY {
                self.side_buttons(ui);
            } else {
                let tip = "The side that is seen, and how what is far is drawn";
                menu(ui, vec2(20.0, 20.0), ("Sides of the 3D view", "From", tip), |ui| self.side_buttons(ui));
            }
        } else {
            self.slice_slider(ui, view, inner.right() - 2.0 * button - GAP);
        }
        let at = Rect::from_min_max(pos2(inner.right() - 2.0 * button, inner.top() + 1.0), inner.max - vec2(0.0, 1.0));
        let mut corner =
            ui.new_child(UiBuilder::new().max_rect(at).layout(egui::Layout::left_to_right(egui::Align::Center)));
        corner.spacing_mut().item_spacing.x = 0.0;
        let tip = match view {
            ViewName::ThreeD => "Fit all visible parts; the direction stays (Home). From the front: Shift + Home",
            _ => "Fit the slice into its view (Home)",
        };
        let name = format!("Fit the {title} view");
        if icon_button(&mut corner, Face::small(Icon::Fit, &name, tip)).clicked() {
            self.send_view(ViewCommand::Fit { view });
        }
        let name = if alone { "All four views".to_owned() } else { format!("Only the {title} view") };
        let face = Face::small(if alone { Icon::Four } else { Icon::Maximise }, &name, &name);
        if icon_button(&mut corner, face).clicked() {
            self.viewports.toggle(view);
        }
    }

    /// The sides that the 3D view can be seen from, and its projection.
    fn side_buttons(&mut self, ui: &mut Ui) {
        for (letter, name, from) in SIDES {
            let b = egui::Button::new(letter).min_size(vec2(20.0, 20.0)).frame_when_inactive(false);
            let b = ui.add(b).accessible_name(format!("See from {name}"));
            if b.on_hover_text(format!("See from {name}")).clicked() {
                self.send_view(ViewCommand::Frame { from, up: None, zoom: None });
            }
        }
        self.projection_button(ui);
    }

    fn projection_button(&mut self, ui: &mut Ui) {
        let Some(camera) = self.scene.as_ref().map(|s| s.views.camera) else { return };
        let on = matches!(camera.projection, Projection::Orthographic { .. });
        let b = egui::Button::new("Ortho").selected(on).min_size(vec2(20.0, 20.0)).frame_when_inactive(on);
        let b = ui.add(b).accessible_name("Orthographic projection");
        if b.on_hover_text("Orthographic: what is far is as large as what is near").clicked() {
            self.send_view(ViewCommand::Camera { camera: projected(&camera, !on) });
        }
    }

    /// Which slice is shown, with a slider where there is room for one.
    fn slice_slider(&mut self, ui: &mut Ui, view: ViewName, right: f32) {
        let (Some(scene), Some(open)) = (&self.scene, self.opened()) else { return };
        let Some(plane) = SlicePlane::new(&open.grid, &scene.views, view) else { return };
        let grid = open.grid;
        let count = grid.dims[plane.axis];
        let mut index = plane.index + 1;
        let font = TextStyle::Monospace.resolve(ui.style());
        let room = right - ui.cursor().left();
        // In a narrow header the number is written closer, last without what it is of.
        let texts = [format!("{index} / {count}"), format!("{index}/{count}"), format!("{index}")];
        let texts = texts.map(|text| ui.painter().layout_no_wrap(text, font.clone(), theme::TEXT_WEAK));
        let [wide, ..] = &texts;
        // As wide as the last slice needs, so that the slider keeps its length.
        let digits = count.to_string().len() as f32;
        let number = wide.size().x.max(7.6 * (2.0 * digits + 3.0)).min(room);
        let length = room - number - GAP * 2.0;
        if length >= SLIDER {
            ui.spacing_mut().slider_width = length;
            ui.spacing_mut().interact_size.y = 16.0;
            let slider = ui
                .add_enabled(count > 1, Slider::new(&mut index, 1..=count).show_value(false))
                .accessible_name(format!("{} slice", view_title(view)));
            let slider = tipped(slider, "Which slice is shown: also the wheel, Up and Down");
            if slider.changed() {
                let to_index = grid.index_from_world();
                let mut at = to_index.transform_point3(scene.views.crosshair);
                at[plane.axis] = f64::from(index) - 1.0;
                let world = grid.world_from_index.transform_point3(at);
                // A drag is one change of view.
                let at = Place::Mm(world.to_array());
                self.edit(&slider, Command::View(ViewCommand::Crosshair { at }));
            }
        }
        if let Some(text) = texts.into_iter().find(|text| text.size().x <= room) {
            let (rect, number) = ui.allocate_exact_size(vec2(right - ui.cursor().left(), 20.0), Sense::hover());
            number.widget_info(|| {
                WidgetInfo::labeled(Role::Label, true, format!("{} slice {}", view_title(view), text.text()))
            });
            ui.painter().galley(rect.right_center() - vec2(text.size().x, text.size().y * 0.5), text, theme::TEXT_WEAK);
        }
    }
}

/// 3D at the top left, then clockwise axial, sagittal, coronal; they meet at these shares of width and height.
fn quarters(all: Rect, [across, down]: [f32; 2]) -> [(ViewName, Rect); 4] {
    let room = all.size() - vec2(SEAM, SEAM);
    let mid = (all.min + vec2(room.x * across, room.y * down)).round();
    let worker_end = mid + vec2(SEAM, SEAM);
    [
        (ViewName::ThreeD, Rect::from_min_max(all.min, mid)),
        (ViewName::Axial, Rect::from_min_max(pos2(worker_end.x, all.min.y), pos2(all.max.x, mid.y))),
        (ViewName::Coronal, Rect::from_min_max(pos2(all.min.x, worker_end.y), pos2(mid.x, all.max.y))),
        (ViewName::Sagittal, Rect::from_min_max(worker_end, all.max)),
    ]
}

/// The picture's place under the header, on whole pixels.
fn body_of(tile: Rect, scale: f32) -> Rect {
    let snap = |x: f32| (x * scale).round() / scale;
    let min = pos2(snap(tile.min.x), snap(tile.min.y + HEADER));
    Rect::from_min_max(min, pos2(snap(tile.max.x), snap(tile.max.y)).max(min + vec2(1.0, 1.0)))
}
