//! The components of the scene, from one list of them: what holds them, what keeps some of them, and how they begin.
//!
//! The list is in the scene's own file. A component that is added there is saved, journaled, copied for a pointer, taken back by whom
//! the list says, and what it is in a document that was just opened. Owns [`TakenBackBy`]; knows no component by name.

/// Who takes back what was changed of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TakenBackBy {
    /// A step of history.
    Undo,
    /// `view.back`, as a change of looks.
    Looks,
    /// `view.back`, as a change of views.
    Views,
    /// Nobody: it is a tool in the hand.
    Tool,
}

impl TakenBackBy {
    /// Whether a change is no step of work: looking about, and taking up a tool.
    pub(crate) fn is_idle(self) -> bool {
        matches!(self, Self::Views | Self::Tool)
    }
}

/// Makes the scene of the list of its components. Each has a name, a type, who takes it back, and what it begins as, told by the names in
/// the list's first line: the volume's grid, its histogram and what was decided about it.
macro_rules! components {
    (
        ($grid:ident, $histogram:ident, $volume:ident)
        $($(#[$meta:meta])* $name:ident: $type:ty, $kept:ident, $fresh:expr;)*
    ) => {
        /// All that a document is beside its voxels. A copy costs a pointer a component.
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        pub struct Scene {
            $($(#[$meta])* pub $name: crate::document::scene::shared::Shared<$type>,)*
        }

        impl Scene {
            /// Seen from the front, a slab from its face, framed, the crosshair in the middle, colours from the histogram, nothing
            /// painted, one part.
            pub fn new($grid: &crate::volume::Grid, $histogram: &crate::volume::Histogram, $volume: VolumeSettings) -> Self {
                Self { $($name: crate::document::scene::shared::Shared::from($fresh),)* }
            }

            /// Who takes back a component; `None` if there is none of the name.
            pub(crate) fn kept(name: &str) -> Option<crate::document::scene::components::TakenBackBy> {
                match name {
                    $(stringify!($name) => Some(crate::document::scene::components::TakenBackBy::$kept),)*
                    _ => None,
                }
            }
        }

        /// Some components of a scene: those that a step brings back.
        #[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
        pub(crate) struct Components {
            $(
                #[serde(default, skip_serializing_if = "Option::is_none")]
                pub(crate) $name: Option<crate::document::scene::shared::Shared<$type>>,
            )*
        }

        impl Components {
            /// All that a scene holds of one kind.
            pub(crate) fn of(scene: &Scene, kept: crate::document::scene::components::TakenBackBy) -> Self {
                Self {
                    $($name: (crate::document::scene::components::TakenBackBy::$kept == kept).then(|| scene.$name.clone()),)*
                }
            }

            /// Forgets what the scene holds anyway.
            pub(crate) fn prune(&mut self, scene: &Scene) {
                $(self.$name = self.$name.take().filter(|held| *held != scene.$name);)*
            }

            /// Exchanges what it holds with what the scene holds.
            pub(crate) fn exchange(&mut self, scene: &mut Scene) {
                $(if let Some(held) = &mut self.$name {
                    std::mem::swap(held, &mut scene.$name);
                })*
            }

            /// Joins a later one: what was there first comes back.
            pub(crate) fn absorb(&mut self, later: Self) {
                $(self.$name = self.$name.take().or(later.$name);)*
            }
        }
    };
}

pub(crate) use components;
