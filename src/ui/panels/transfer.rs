//! The transfer function over the histogram: points that are dragged, added and removed by hand.
//!
//! Opacity has its points in the plot, colour its own in the strip below: two curves over the same values, each moved by itself.
//! Shift takes the colour along that stands at an opacity point.

use crate::document::{Command, TransferCommand};
use crate::interact::curve;
use crate::interact::readout;
use crate::ui::panels::look_menu::whose_line;
use crate::ui::state::look_of::LookOf;
use crate::ui::state::transfer_editor::Plot;
use crate::ui::state::transfer_editor::Point;
use crate::ui::style::colour::colour_button;
use crate::ui::style::icons::Icon;
use crate::ui::style::theme;
use crate::ui::style::theme::{GAP, ROW};
use crate::ui::style::widgets::{Face, button, icon_button, line, menu, number, row};
use crate::ui::window::app::App;
use crate::volume::{Preset, TransferFunction};
use egui::{
    Color32, DragValue, Label, Mesh, Pos2, Rect, Response, RichText, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2,
    vec2,
};

/// As a share of the window: what stands below has to be in sight on a small screen too.
const HEIGHT: f32 = 0.14;
const STRIP: f32 = 14.0;
const HANDLE: f32 = 9.0;
/// What a point of opacity says of itself.
const OPACITY_TIP: &str = "Opacity at a value: drag it; Shift takes its colour along; right-click removes it";
/// And one of colour.
const COLOUR_TIP: &str = "Colour at a value: drag it; click to change it; right-click removes it";

impl App {
    pub(super) fn transfer_panel(&mut self, ui: &mut Ui) {
        let Some(old) = self.shown_function() else { return };
        self.whose_function(ui);
        let Some(open) = &self.snapshot.open else { return };
        let histogram = open.histogram.clone();
        let mut new = old.clone();

        let width = ui.available_width();
        let height = (ui.ctx().viewport_rect().height() * HEIGHT).round();
        let (outer, ground) = ui.allocate_exact_size(vec2(width, height), Sense::click());
        ground.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, "Transfer function over the histogram"));
        let painter = ui.painter_at(outer);
        self.backdrop.detail(ui, outer, theme::DEEP);
        let rect = outer.shrink2(vec2(HANDLE * 0.5 + 1.0, HANDLE * 0.5 + 1.0));
        let plot = Plot::new(rect, &histogram);
        let (lo, hi) = (plot.lo, plot.hi);
        for bar in self.transfer.bars(&plot, &histogram, ui.pixels_per_point()) {
            self.backdrop.detail(ui, bar, theme::CONTROL_HOVER);
        }
        paint_curve(&painter, &plot, &old);

        let tip =
            "How opaque each value is, over how often it occurs. Double-click adds a point; right-click removes one";
        let ground = ground.on_hover_text(tip);
        let mut touched: Option<Response> = None;
        if ground.double_clicked()
            && let Some(at) = ground.interact_pointer_pos()
            && let Some(i) = curve::add_opacity(&mut new, plot.value(at.x), plot.opacity(at.y), plot.gap())
        {
            self.transfer.selected = Some(Point::Opacity(i));
            touched = Some(ground.clone());
        }
        for i in 0..old.opacity.len() {
            let (value, opacity) = old.opacity[i];
            let at = pos2(plot.x(value), plot.y(opacity));
            let name = format!("Opacity point {}", i + 1);
            let response = handle(ui, ("opacity", i), at, &name).on_hover_text(OPACITY_TIP);
            let selected = self.transfer.selected == Some(Point::Opacity(i));
            paint_handle(&painter, at, theme::TEXT, selected || response.hovered(), true);
            if response.drag_started() || response.clicked() {
                self.transfer.selected = Some(Point::Opacity(i));
            }
            if response.dragged()
                && let Some(to) = response.interact_pointer_pos()
            {
                let beside = curve::colour_beside(&old, i, plot.gap()).filter(|_| ui.input(|i| i.modifiers.shift));
                curve::move_opacity(&mut new, i, plot.value(to.x).clamp(lo, hi), plot.opacity(to.y), plot.gap());
                if let Some(colour) = beside {
                    let value = new.opacity[i].0;
                    curve::move_colour(&mut new, colour, value, plot.gap());
                }
                touched = Some(response);
            } else if response.secondary_clicked() {
                curve::remove(&mut new.opacity, i);
                self.transfer.selected = None;
                touched = Some(response);
            }
        }

        let strip = self.colour_strip(ui, &plot, &old, &mut new);
        touched = strip.or(touched);
        touched = self.number_rows(ui, &plot, &mut new).or(touched);
        if new != old
            && let Some(response) = touched
        {
            let command = self.function_set(new);
            self.edit(&response, command);
        }
    }

    /// The function that is shown: of what the hand chose, as long as it has one for itself, else of the active volume.
    fn shown_function(&mut self) -> Option<TransferFunction> {
        let scene = self.scene.as_ref()?;
        let active = scene.volumes.active;
        let at_hand = self.transfer.of.filter(|of| match of {
            LookOf::Selection(id) | LookOf::Segment(id, _) => *id == active,
            LookOf::Volume(_) | LookOf::Part(_) => true,
        });
        let chosen = at_hand.and_then(|of| of.own(scene)?.transfer);
        if chosen.is_none() && self.transfer.of.is_some() {
            self.transfer.edit(None);
        }
        Some(chosen.unwrap_or_else(|| scene.transfer_of(active).clone()))
    }

    /// The command after which the function that is shown is this one.
    fn function_set(&self, function: TransferFunction) -> Command {
        match (self.transfer.of, &self.scene) {
            (Some(of), Some(scene)) => of.set_function(scene, function),
            _ => Command::Transfer(TransferCommand::Set { function, volume: None }),
        }
    }

    /// Says whose function it is where that is a question, and leads back to the volume's.
    fn whose_function(&mut self, ui: &mut Ui) {
        let Some(scene) = &self.scene else { return };
        let Some(of) = self.transfer.of else {
            whose_line(ui, scene, "Function");
            return;
        };
        let whose = of.within(scene).map_or_else(String::new, |volume| format!(" of {volume}"));
        let text = format!("Own function of {}{whose}", of.called(scene).unwrap_or_default());
        ui.horizontal(|ui| {
            let width = ui.available_width() - ROW - GAP;
            line(ui, &text, width, theme::ACCENT);
            let face = Face::small(Icon::Close, "Back to the volume's function", "Shows the volume's function again");
            if icon_button(ui, face).clicked() {
                self.transfer.edit(None);
            }
        });
    }

    fn colour_strip(
        &mut self,
        ui: &mut Ui,
        plot: &Plot,
        old: &TransferFunction,
        new: &mut TransferFunction,
    ) -> Option<Response> {
        let mut touched = None;
        let (outer, ground) = ui.allocate_exact_size(vec2(ui.available_width(), STRIP + HANDLE), Sense::click());
        ground.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, "Colours over the values"));
        let bar = Rect::from_min_max(pos2(plot.rect.left(), outer.top()), pos2(plot.rect.right(), outer.top() + STRIP));
        paint_strip(ui.painter(), bar, plot, old);
        let ground = ground.on_hover_text("The colour of each value. Double-click adds one; click one to change it");
        if ground.double_clicked()
            && let Some(at) = ground.interact_pointer_pos()
            && let Some(i) = curve::add_colour(new, plot.value(at.x).clamp(plot.lo, plot.hi), plot.gap())
        {
            self.transfer.selected = Some(Point::Colour(i));
            touched = Some(ground.clone());
        }
        for (i, (value, colour)) in old.colour.iter().enumerate() {
            let at = pos2(plot.x(*value), outer.top() + STRIP + HANDLE * 0.5);
            let response = handle(ui, ("colour", i), at, &format!("Colour point {}", i + 1)).on_hover_text(COLOUR_TIP);
            let selected = self.transfer.selected == Some(Point::Colour(i));
            paint_handle(ui.painter(), at, theme::rgb(*colour), selected || response.hovered(), false);
            if response.drag_started() || response.clicked() {
                self.transfer.selected = Some(Point::Colour(i));
            }
            if response.dragged()
                && let Some(to) = response.interact_pointer_pos()
            {
                curve::move_colour(new, i, plot.value(to.x).clamp(plot.lo, plot.hi), plot.gap());
                touched = Some(response);
            } else if response.secondary_clicked() {
                curve::remove(&mut new.colour, i);
                self.transfer.selected = None;
                touched = Some(response);
            }
        }
        touched
    }

    /// The chosen point in numbers; below it ready looks, and the way back to the start.
    fn number_rows(&mut self, ui: &mut Ui, plot: &Plot, new: &mut TransferFunction) -> Option<Response> {
        let mut touched = None;
        let span = readout::span([plot.lo, plot.hi]);
        let each = (ui.available_width() - theme::LABEL - 2.0 * GAP) * 0.5;
        let field = |ui: &mut Ui, value: &mut f64, name: &str, tip: &str, span: f64| {
            let field = DragValue::new(value).speed(span / 500.0);
            number(ui, each, (name, tip), "", field, move |x, chars| readout::field(x, span, chars))
        };
        let chosen = match self.transfer.selected {
            Some(Point::Opacity(_)) => "Opacity at",
            Some(Point::Colour(_)) => "Colour at",
            None => "Point",
        };
        row(ui, chosen, |ui| match self.transfer.selected {
            Some(Point::Opacity(i)) if i < new.opacity.len() => {
                let (mut value, mut opacity) = (new.opacity[i].0, f64::from(new.opacity[i].1));
                let a = field(ui, &mut value, "Value of the point", "The value that the point stands at", span);
                let tip = "Opacity there, 0 clear to 1 opaque, of one unit of length";
                let b = field(ui, &mut opacity, "Opacity of the point", tip, 1.0);
                if a.changed() || b.changed() {
                    curve::move_opacity(new, i, value, opacity, plot.gap());
                    touched = Some(a | b);
                }
            }
            Some(Point::Colour(i)) if i < new.colour.len() => {
                let mut value = new.colour[i].0;
                let a = field(ui, &mut value, "Value of the colour", "The value that the colour stands at", span);
                let b = colour_button(ui, "Colour of the point", &mut new.colour[i].1);
                if a.changed() {
                    curve::move_colour(new, i, value, plot.gap());
                }
                if a.changed() || b.changed() {
                    touched = Some(a | b);
                }
            }
            _ => {
                ui.add(Label::new(RichText::new("click one for its numbers").color(theme::TEXT_WEAK)).truncate());
            }
        });
        ui.horizontal(|ui| {
            // What is left is as wide as the words beside it need.
            let width = ((ui.available_width() - GAP) * 0.36).min(ui.available_width() - GAP - 160.0).max(72.0).round();
            let about = ("Ready looks", "Looks", "Ready colours and opacities for what you want to see");
            menu(ui, vec2(width, ROW), about, |ui| self.looks_menu(ui));
            let tip = "Start again: colours and opacities from how often each value occurs";
            if button(ui, vec2(ui.available_width(), ROW), "Rebuild from histogram", tip) {
                self.transfer.selected = None;
                self.rebuild_function();
            }
        });
        touched
    }

    fn looks_menu(&mut self, ui: &mut Ui) {
        let Some(open) = self.opened() else { return };
        let unit_mm = open.grid.voxel_mm();
        for Preset { name, tip, function } in TransferFunction::presets(&open.histogram.clone(), unit_mm) {
            if ui.button(name).on_hover_text(tip).clicked() {
                self.transfer.selected = None;
                let command = self.function_set(function);
                self.send(command);
            }
        }
    }

    fn rebuild_function(&mut self) {
        let command = match (self.transfer.of, self.opened()) {
            (Some(_), Some(open)) => {
                self.function_set(TransferFunction::from_histogram(&open.histogram, open.grid.voxel_mm()))
            }
            _ => Command::Transfer(TransferCommand::Reset { volume: None }),
        };
        self.send(command);
    }
}

fn handle(ui: &Ui, salt: (&str, usize), at: Pos2, name: &str) -> Response {
    let rect = Rect::from_center_size(at, vec2(HANDLE + 7.0, HANDLE + 7.0));
    let response = ui.interact(rect, ui.scope_id().with(salt), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Slider, true, name));
    response
}

/// A disc for opacity, a square for colour.
fn paint_handle(painter: &egui::Painter, at: Pos2, fill: Color32, lit: bool, round: bool) {
    let radius = if lit { HANDLE * 0.6 } else { HANDLE * 0.5 };
    // Faces over each other: a ring costs as many edges as a face has none.
    let ring = if lit { Color32::WHITE } else { theme::TEXT_WEAK };
    for (grown, colour) in [(1.5, theme::DEEP), (0.75, ring), (-0.75, fill)] {
        if round {
            painter.circle_filled(at, radius + grown, colour);
        } else {
            painter.rect_filled(
                Rect::from_center_size(at, egui::Vec2::splat(2.0 * (radius + grown) - 1.0)),
                1.0,
                colour,
            );
        }
    }
}

fn paint_curve(painter: &egui::Painter, plot: &Plot, function: &TransferFunction) {
    let inner = function.opacity.iter().map(|&(v, a)| pos2(plot.x(v), plot.y(a)));
    let (first, last) = (function.opacity.first().map_or(0.0, |p| p.1), function.opacity.last().map_or(0.0, |p| p.1));
    let points: Vec<Pos2> = std::iter::once(pos2(plot.rect.left(), plot.y(first)))
        .chain(inner)
        .chain(std::iter::once(pos2(plot.rect.right(), plot.y(last))))
        .collect();
    painter.add(Shape::line(points, Stroke::new(1.5, theme::TEXT)));
}

fn paint_strip(painter: &egui::Painter, bar: Rect, plot: &Plot, function: &TransferFunction) {
    let mut mesh = Mesh::default();
    let mut stops: Vec<f64> = function.colour.iter().map(|p| p.0).filter(|v| (plot.lo..=plot.hi).contains(v)).collect();
    stops.insert(0, plot.lo);
    stops.push(plot.hi);
    for (i, value) in stops.iter().enumerate() {
        let colour = theme::rgb(function.colour_at(*value));
        let x = plot.x(*value);
        mesh.colored_vertex(pos2(x, bar.top()), colour);
        mesh.colored_vertex(pos2(x, bar.bottom()), colour);
        if i > 0 {
            let n = 2 * i as u32;
            mesh.add_triangle(n - 2, n - 1, n);
            mesh.add_triangle(n - 1, n, n + 1);
        }
    }
    painter.add(Shape::mesh(mesh));
}
