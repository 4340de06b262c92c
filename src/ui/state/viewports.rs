//! Which views are shown and what the pointer is doing over them.

use crate::document::{Aim, ViewName};
use crate::interact::Button;
use crate::math::DVec2;
use std::collections::BTreeMap;

/// Which views are shown and what the pointer is doing over them.
#[derive(Debug)]
pub(crate) struct Viewports {
    /// Alone on the screen.
    pub(crate) maximised: Option<ViewName>,
    pub(crate) last_used: ViewName,
    pub(crate) hovered: Option<(ViewName, DVec2)>,
    pub(crate) captured: Option<(Button, ViewName)>,
    /// Where the brush was told to be last.
    pub(crate) aimed: Option<Aim>,
    /// How hard a pen is pressed; `None`: a mouse, which cannot tell.
    pub(crate) pen: Option<f32>,
    pub(crate) shown: Vec<ViewName>,
    pub(crate) sizes: BTreeMap<ViewName, [u32; 2]>,
}

impl Default for Viewports {
    fn default() -> Self {
        Self {
            maximised: None,
            last_used: ViewName::ThreeD,
            hovered: None,
            captured: None,
            aimed: None,
            pen: None,
            shown: Vec::new(),
            sizes: BTreeMap::new(),
        }
    }
}

impl Viewports {
    /// One view alone, or all four again.
    pub(crate) fn toggle(&mut self, view: ViewName) {
        self.maximised = if self.maximised.is_some() { None } else { Some(view) };
    }

    /// All four.
    pub(crate) fn show_all(&mut self) {
        self.maximised = None;
    }

    /// The view that is alone.
    pub(crate) fn alone(&self) -> Option<ViewName> {
        self.maximised
    }

    /// The view that a key means: the one under the pointer, or the one used last.
    pub(crate) fn meant(&self) -> ViewName {
        self.maximised.or(self.hovered.map(|(view, _)| view)).unwrap_or(self.last_used)
    }

    /// For another volume, which knows nothing of this window's sizes.
    pub(crate) fn forget_sizes(&mut self) {
        self.sizes.clear();
        self.aimed = None;
        self.shown.clear();
    }
}
