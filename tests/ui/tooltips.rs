//! Every control says what it does when the pointer rests on it, whatever the window shows.

use super::names::{acts, states};
use egui::accesskit::Role;
use egui_kittest::kittest::NodeT;

#[test]
fn no_control_is_without_a_tooltip() {
    let mut without = Vec::new();
    let mut seen = 0;
    for (state, window, _) in states() {
        let mut stack = vec![window.harness.root()];
        while let Some(node) = stack.pop() {
            stack.extend(node.children());
            let about = node.accesskit_node();
            // A tooltip over a picture would hide it, as over a page of text.
            if !acts(&node) || matches!(about.role(), Role::Image | Role::Window) {
                continue;
            }
            seen += 1;
            let name = about.label().unwrap_or_default();
            // A tooltip is also what assistive tools read out as the control's description.
            let said = about.data().description().unwrap_or_default().trim().to_owned();
            if said.is_empty() && !without.contains(&name) {
                without.push(format!("{name} (with {state})"));
            }
        }
    }
    assert!(seen > 1000, "the walk found only {seen} controls");
    without.sort();
    without.dedup();
    assert!(without.is_empty(), "{without:#?}");
}
