//! A name in a list: a click chooses what it names, a double click edits it in place.
//!
//! It takes the keyboard only then, so that keys that are meant for a tool do not end up in a name. Knows nothing of what is named.

use crate::ui::style::theme;
use crate::ui::style::theme::ROW;
use crate::ui::style::widgets::{cut_text, tipped};
use egui::text::{CCursor, CCursorRange};
use egui::text_edit::TextEditState;
use egui::{Align2, Frame, Key, Role, Sense, TextEdit, TextStyle, Ui, WidgetInfo, vec2};

/// What a hand did with a name.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Named {
    /// It was clicked.
    Chosen,
    /// Another one was entered.
    Anew(String),
}

/// Shows a name of so much width, and edits it while it has the keyboard.
pub(crate) fn name_field(ui: &mut Ui, (name, tip): (&str, &str), text: &str, width: f32) -> Option<Named> {
    let id = ui.make_persistent_id(("name", name));
    let field = id.with("field");
    if !ui.memory(|m| m.has_focus(field)) {
        let (_, rect) = ui.allocate_space(vec2(width, ROW));
        let response = ui.interact(rect, field, Sense::click());
        response.widget_info(|| {
            let mut info = WidgetInfo::labeled(Role::TextInput, true, name);
            info.current_text_value = Some(text.to_owned());
            info
        });
        let shown = cut_text(ui, text, TextStyle::Body.resolve(ui.style()), theme::TEXT, width - 8.0);
        let at = rect.left_center() - vec2(0.0, shown.size().y * 0.5);
        ui.painter().galley(at, shown, theme::TEXT);
        if response.double_clicked() {
            response.request_focus();
            let mut state = TextEditState::default();
            let all = CCursorRange::two(CCursor::new(0), CCursor::new(text.chars().count()));
            state.cursor.set_char_range(Some(all));
            state.store(ui.ctx(), field);
        }
        return tipped(response, tip).clicked().then_some(Named::Chosen);
    }
    let mut draft = ui.data(|d| d.get_temp::<String>(id)).unwrap_or_else(|| text.to_owned());
    let edit = TextEdit::singleline(&mut draft).id(field).desired_width(width - 8.0).align(Align2::LEFT_CENTER);
    let response = ui
        .add_sized(vec2(width, ROW), edit.frame(Frame::NONE.fill(theme::DEEP)))
        .accessible_name(name)
        .on_hover_text(tip);
    if response.has_focus() {
        ui.data_mut(|d| d.insert_temp(id, draft));
        return None;
    }
    ui.data_mut(|d| d.remove::<String>(id));
    let draft = draft.trim().to_owned();
    let entered = response.lost_focus() && !ui.input(|i| i.key_pressed(Key::Escape));
    (entered && draft != text && !draft.is_empty()).then_some(Named::Anew(draft))
}

/// A text that can be written at any time; answers another one once it is entered, by Enter or by leaving the field.
pub(crate) fn text_field(ui: &mut Ui, (name, tip): (&str, &str), text: &str, width: f32) -> Option<String> {
    let id = ui.make_persistent_id(("text", name));
    let mut draft = ui.data(|d| d.get_temp::<String>(id)).unwrap_or_else(|| text.to_owned());
    let edit = TextEdit::singleline(&mut draft).id(id.with("field")).desired_width(width - 8.0);
    let response = ui.add_sized(vec2(width, ROW), edit.align(Align2::LEFT_CENTER)).accessible_name(name);
    let response = tipped(response, tip);
    if response.has_focus() {
        ui.data_mut(|d| d.insert_temp(id, draft));
        return None;
    }
    ui.data_mut(|d| d.remove::<String>(id));
    let entered = response.lost_focus() && !ui.input(|i| i.key_pressed(Key::Escape));
    (entered && draft != text && !draft.trim().is_empty()).then_some(draft)
}
