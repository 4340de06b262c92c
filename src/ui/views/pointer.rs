//! From egui's raw events to the tools' events: every sample of the pointer, not just the last of a frame.

use crate::document::{HistoryCommand, ViewCommand, ViewName};
use crate::interact::devices::{Buttons, Moment, Mouse, Pen, ScreenPlace, screen_event};
use crate::interact::{Action, Button, Event, Interaction, Key, Modifiers, PointerEvent, Wheel, action_of};
use crate::paint::Target;
use crate::ui::state::path_purpose::PathPurpose;
use crate::ui::state::pixels::pixel;
use crate::ui::state::pixels::pixels;
use crate::ui::thread::session::Request;
use crate::ui::window::app::App;
use egui::{Pos2, Rect};

/// Points of a touchpad's scroll that count as one notch.
const POINTS_PER_NOTCH: f32 = 40.0;

impl App {
    /// Keeps a release for the next frame if the press came in this one, with all that follows: in a slow frame a slider that is
    /// clicked would see neither.
    pub(crate) fn hold_back(&mut self, ctx: &egui::Context, raw: &mut egui::RawInput) {
        let mut events = std::mem::take(&mut self.held_back);
        events.append(&mut raw.events);
        let mut down = Vec::new();
        let cut = events.iter().position(|event| match event {
            egui::Event::PointerButton { button, pressed: true, .. } => {
                down.push(*button);
                false
            }
            egui::Event::PointerButton { button, pressed: false, .. } => down.contains(button),
            _ => false,
        });
        if let Some(cut) = cut {
            self.held_back = events.split_off(cut);
            ctx.request_repaint();
        }
        raw.events = events;
    }

    /// Gives the tools what happened over the views, in order. `open`: no dialog or menu lies over them.
    pub(crate) fn take_pointer(&mut self, ctx: &egui::Context, rects: &[(ViewName, Rect)], open: bool) {
        let (events, scale, time, space, erase) = ctx.input(|i| {
            let free = |key| i.key_down(key);
            (i.raw.events.clone(), i.pixels_per_point, i.time, free(egui::Key::Space), free(egui::Key::E))
        });
        let typing = ctx.text_edit_focused();
        // A control that was reached by Tab has Space for itself.
        let space = space && ctx.memory(|m| m.focused().is_none());
        // Keys and the pointer's samples of a frame come in their order; what is held now is how it ended.
        let key_e = |event: &egui::Event| match event {
            egui::Event::Key { key: egui::Key::E, pressed, repeat: false, .. } => Some(*pressed),
            _ => None,
        };
        let mut erase = events.iter().find_map(key_e).map_or(erase, |pressed| !pressed);
        let mut last = None;
        for event in events {
            erase = key_e(&event).unwrap_or(erase);
            match event {
                egui::Event::Touch { force: Some(force), .. } => self.viewports.pen = Some(force),
                egui::Event::PointerButton { pos, button, pressed, modifiers } => {
                    let Some(button) = button_of(button) else { continue };
                    let modifiers = held(modifiers, space, erase && !typing);
                    if pressed {
                        let over = rects.iter().find(|(_, r)| r.contains(pos) && open);
                        let Some(&(view, rect)) = over else { continue };
                        if self.viewports.captured.is_none() {
                            let refusal = self.interaction.tool().refusal(view);
                            if let (Some(text), Button::Primary, false) = (refusal, button, modifiers.pans()) {
                                self.note(ctx, text);
                            }
                            // What was typed is entered: keys are the tool's again, also after a drag.
                            if typing && let Some(field) = ctx.memory(|m| m.focused()) {
                                ctx.memory_mut(|m| m.surrender_focus(field));
                            }
                            self.viewports.captured = Some((button, view));
                            self.viewports.last_used = view;
                            let e = self.pointer_event(view, rect, pos, scale, modifiers, time);
                            self.interact(Event::Press(button, e));
                        }
                    } else if let Some((held, view)) = self.viewports.captured
                        && held == button
                    {
                        self.viewports.captured = None;
                        self.viewports.pen = None;
                        if let Some(&(_, rect)) = rects.iter().find(|(v, _)| *v == view) {
                            let e = self.pointer_event(view, rect, pos, scale, modifiers, time);
                            self.interact(Event::Release(button, e));
                        } else {
                            self.interact(Event::Abort);
                        }
                    }
                }
                egui::Event::PointerMoved(pos) => {
                    last = Some(pos);
                    let Some((_, view)) = self.viewports.captured else { continue };
                    let Some(&(_, rect)) = rects.iter().find(|(v, _)| *v == view) else { continue };
                    let modifiers = held(ctx.input(|i| i.modifiers), space, erase && !typing);
                    let e = self.pointer_event(view, rect, pos, scale, modifiers, time);
                    self.interact(Event::Move(e));
                }
                egui::Event::MouseWheel { unit, delta, modifiers, .. } => {
                    let Some(pos) = ctx.input(|i| i.pointer.hover_pos()) else { continue };
                    let Some(&(view, _)) = rects.iter().find(|(_, r)| r.contains(pos) && open) else { continue };
                    // Some systems turn the wheel's axis while Shift is held.
                    let delta = if delta.y == 0.0 { delta.x } else { delta.y };
                    let notches = match unit {
                        egui::MouseWheelUnit::Point => delta / POINTS_PER_NOTCH,
                        egui::MouseWheelUnit::Line => delta,
                        egui::MouseWheelUnit::Page => delta * 10.0,
                    };
                    self.viewports.last_used = view;
                    let modifiers = held(modifiers, space, erase);
                    if !modifiers.shift {
                        self.begin_wheel(time);
                    }
                    self.interact(Event::Wheel(Wheel { view, notches: f64::from(notches), modifiers }));
                }
                _ => {}
            }
        }
        self.hover(ctx, rects, open, scale, last.is_some());
    }

    fn hover(&mut self, ctx: &egui::Context, rects: &[(ViewName, Rect)], open: bool, scale: f32, moved: bool) {
        let pos = ctx.input(|i| i.pointer.hover_pos());
        let over =
            pos.filter(|_| open).and_then(|p| rects.iter().find(|(_, r)| r.contains(p)).map(|&(v, r)| (v, r, p)));
        let Some((view, rect, pos)) = over else {
            if self.viewports.hovered.take().is_some() {
                self.probe = None;
            }
            return;
        };
        let (px, size) = (pixel(rect, pos, scale), pixels(rect, scale));
        let entered = self.viewports.hovered.is_none_or(|(v, _)| v != view);
        self.viewports.hovered = Some((view, px));
        if moved || entered {
            self.tell_aim();
        }
        if (moved || entered || std::mem::take(&mut self.probe_again)) && self.opened().is_some() {
            self.request(Request::Probe { view, px, size });
        }
    }

    fn pointer_event(
        &self,
        view: ViewName,
        rect: Rect,
        pos: Pos2,
        scale: f32,
        modifiers: Modifiers,
        time_s: f64,
    ) -> PointerEvent {
        let (px, size) = (pixel(rect, pos, scale), pixels(rect, scale));
        let hit = if view == ViewName::ThreeD { self.hit(px, size) } else { None };
        let moment = Moment { seen: None, modifiers, time_s, hit };
        let place = ScreenPlace { view, px, size };
        let buttons = self.viewports.captured.map_or(Buttons::default(), |(button, _)| Buttons::only(button));
        match self.viewports.pen {
            Some(force) => screen_event(&Pen { place, buttons, force }, place, &moment),
            None => screen_event(&Mouse { place, buttons }, place, &moment),
        }
    }

    /// Shortcuts; typing into a field keeps its keys, and a control that was reached by Tab keeps those that move it.
    pub(crate) fn take_keys(&mut self, ctx: &egui::Context) {
        let typing = ctx.text_edit_focused();
        let focused = ctx.memory(|m| m.focused().is_some());
        let pressed: Vec<_> = ctx.input(|i| {
            i.raw
                .events
                .iter()
                .filter_map(|e| match e {
                    egui::Event::Key { key, pressed: true, repeat, modifiers, .. } => Some((*key, *repeat, *modifiers)),
                    _ => None,
                })
                .collect()
        });
        for (key, repeat, modifiers) in pressed {
            let is_letter = key == egui::Key::Questionmark;
            let Some(key) = key_of(key) else { continue };
            let modifiers = held(modifiers, false, false);
            let Some(action) = action_of(key, modifiers) else { continue };
            let global = matches!(action, Action::Save | Action::SaveAs | Action::Open | Action::Keys | Action::Abort);
            let repeats = matches!(action, Action::BrushSize(_) | Action::Slice(_) | Action::Undo | Action::Redo);
            let moves = matches!(action, Action::Slice(_) | Action::Fit | Action::Front);
            // A key hit by mistake must not take back the stroke under the hand.
            let busy = self.dialog.is_some() || self.interaction.gesture().is_some();
            let kept = (typing && (!global || is_letter)) || (focused && moves) || (repeat && !repeats);
            if kept || (busy && action != Action::Abort) {
                continue;
            }
            self.act(action);
        }
    }

    /// Does what a key or a button asks for; with nothing open there is little to do.
    pub(crate) fn act(&mut self, action: Action) {
        let can = match action {
            Action::Open | Action::Keys | Action::Abort => true,
            Action::Undo | Action::Redo | Action::Save | Action::SaveAs => self.has_document(),
            _ => self.opened().is_some(),
        };
        if !can {
            return;
        }
        match action {
            Action::Choose(tool) => {
                for command in self.interaction.choose(tool) {
                    self.send(command);
                }
                self.request(Request::Held(None));
            }
            Action::BrushSize(factor) => {
                if let (Some(scene), Some(open)) = (&self.scene, self.opened()) {
                    let grid = &open.grid;
                    let context = crate::interact::Context {
                        scene,
                        poses: &open.poses,
                        grid,
                        boxes: &open.boxes,
                        sample_bytes: &open.sample_bytes,
                        writing: &self.writing,
                        voxel_mm: grid.voxel_mm(),
                    };
                    self.send(Interaction::sized(factor, &context));
                }
            }
            Action::Label(id) => self.paint_with(Target::Label(id)),
            Action::Remove => self.remove_picked(),
            Action::Slice(voxels) => {
                let view = self.viewports.meant();
                if view != ViewName::ThreeD {
                    self.send_view(ViewCommand::Scroll { view, voxels });
                }
            }
            Action::Undo => self.undo_redo(HistoryCommand::Undo { steps: 1 }),
            Action::Redo => self.undo_redo(HistoryCommand::Redo { steps: 1 }),
            Action::Save => self.save(),
            Action::SaveAs => {
                self.after_save = None;
                self.ask(PathPurpose::SaveAs);
            }
            Action::Open => self.ask(PathPurpose::Open),
            Action::Fit => self.send_view(ViewCommand::Fit { view: self.viewports.meant() }),
            Action::Front => self.send_view(ViewCommand::Frame { from: [0.0, 1.0, 0.0], up: None, zoom: None }),
            Action::Back(of) => self.walk_past(ViewCommand::Back { of }),
            Action::Forward(of) => self.walk_past(ViewCommand::Forward { of }),
            Action::Maximise => self.viewports.toggle(self.viewports.meant()),
            Action::Keys => self.keys_open = !self.keys_open,
            Action::Abort => {
                if self.interaction.gesture().is_some() {
                    self.interact(Event::Abort);
                } else if self.dialog.is_some() {
                    self.leave_dialog();
                } else {
                    self.keys_open = false;
                }
            }
        }
    }

    /// Back or forward in the past of views and looks, unless a drag is under way.
    pub(crate) fn walk_past(&mut self, command: ViewCommand) {
        if self.interaction.gesture().is_none() {
            self.end_wheel();
            self.send_view(command);
        }
    }

    /// A view command, if something is open.
    pub(crate) fn send_view(&mut self, command: ViewCommand) {
        if self.opened().is_some() {
            self.send(crate::document::Command::View(command));
        }
    }
}

fn button_of(button: egui::PointerButton) -> Option<Button> {
    match button {
        egui::PointerButton::Primary => Some(Button::Primary),
        egui::PointerButton::Secondary => Some(Button::Secondary),
        egui::PointerButton::Middle => Some(Button::Middle),
        _ => None,
    }
}

fn held(m: egui::Modifiers, space: bool, erase: bool) -> Modifiers {
    Modifiers { shift: m.shift, ctrl: m.command || m.ctrl, alt: m.alt, space, erase }
}

fn key_of(key: egui::Key) -> Option<Key> {
    use egui::Key as K;
    Some(match key {
        K::OpenBracket => Key::BracketLeft,
        K::CloseBracket => Key::BracketRight,
        K::Escape => Key::Escape,
        K::F1 | K::Questionmark => Key::Help,
        K::Delete => Key::Delete,
        K::Home => Key::Home,
        K::ArrowUp | K::PageUp => Key::Up,
        K::ArrowDown | K::PageDown => Key::Down,
        K::ArrowLeft => Key::Left,
        K::ArrowRight => Key::Right,
        key => {
            let mut name = key.name().chars();
            match (name.next(), name.next()) {
                (Some(c), None) if c.is_ascii_alphanumeric() => Key::Char(c.to_ascii_uppercase()),
                _ => return None,
            }
        }
    })
}
