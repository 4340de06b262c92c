//! What a person decided about each volume: how it is called, where it lies, whether and how it is shown, what its labels mean.
//!
//! Which volumes there are and which one is at hand is known to undo as one component of the scene. How a volume is shown is a look
//! among the others and walks with them (`view.back`), but for what `volume.add`, `volume.set` and `volume.remove` do, which is all
//! one step. Knows no voxels.

use crate::document::error::DocumentError;
use crate::document::scene::{Layer, Origin, Scene, ViewLook, Window};
use crate::math::Pose;
use crate::volume::{Lighting, Mode, Segments, SubBox, TransferFunction, VolumeId};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Where a sub-volume lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct SubVolume {
    /// The volume that it is cut out of; a sub-volume itself, perhaps.
    pub parent: VolumeId,
    /// The box, in voxels of the parent, and how finely they are divided.
    #[serde(flatten)]
    pub of: SubBox,
}

/// What a person decided about a volume.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct VolumeSettings {
    /// As it is called; of older projects empty until the volume is read.
    #[serde(default)]
    pub name: String,
    /// Where it came from.
    pub origin: Origin,
    /// Whether it is drawn.
    #[serde(default = "yes")]
    pub visible: bool,
    /// Strength in every picture, 0 to 1.
    #[serde(default = "all")]
    pub opacity: f32,
    /// From where its file puts it to where it lies, rigid.
    #[serde(default)]
    pub pose: Pose,
    /// What its labels mean.
    #[serde(default)]
    pub segments: Segments,
    /// The box of another volume that it is, at its own resolution. It lies where that one lies.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sub_volume: Option<SubVolume>,
    /// Whether it was laid beside others as labels: the colours of its segments show it, not its numbers.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub label_map: bool,
}

fn yes() -> bool {
    true
}

fn all() -> f32 {
    1.0
}

impl VolumeSettings {
    /// What a volume is called that was read as `source` names it: a file by its name, without the folders that it lies in.
    pub(crate) fn called(source: &str) -> &str {
        std::path::Path::new(source).file_name().and_then(|name| name.to_str()).unwrap_or(source)
    }

    /// As a volume is until somebody says otherwise.
    pub fn new(name: impl Into<String>, origin: Origin) -> Self {
        Self {
            name: name.into(),
            origin,
            visible: true,
            opacity: 1.0,
            pose: Pose::IDENTITY,
            segments: Segments::default(),
            sub_volume: None,
            label_map: false,
        }
    }
}

/// Which volumes there are.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Volumes {
    /// The one that commands mean which name none: the brush's target. Means nothing where there is no volume.
    pub active: VolumeId,
    /// The number that the next one gets; none is given twice.
    pub next: u32,
    /// By id.
    pub all: BTreeMap<VolumeId, VolumeSettings>,
}

impl Volumes {
    /// The one volume that a document begins with.
    pub fn of_one(settings: VolumeSettings) -> Self {
        let active = VolumeId::FIRST;
        Self { active, next: 1, all: BTreeMap::from([(active, settings)]) }
    }

    /// What is said to whoever names, in a field of a command, a volume that is none of them.
    pub(crate) fn none_of(&self, field: &str, named: VolumeId) -> DocumentError {
        let known: Vec<String> = self.all.iter().map(|(id, volume)| format!("{id} ({})", volume.name)).collect();
        DocumentError::invalid(field, named, format!("one of the volumes: {}", known.join(", ")))
    }
}

/// A look that a volume has for itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OwnLook {
    /// Colour and opacity.
    pub transfer: TransferFunction,
    /// How rays become colour.
    pub mode: Mode,
    /// `null`: unshaded.
    pub lighting: Option<Lighting>,
}

/// How a volume is shown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct VolumeLook {
    /// Grey window of the slices.
    pub window: Window,
    /// In 3D; the document's transfer function and look where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own: Option<OwnLook>,
    /// Fields that it shows in a way of its own; the others are shown as the document's are.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<Layer>,
}

/// The scene's parts in the order in which scripts were told them when there was one volume.
const SAID_FIRST: [&str; 9] =
    ["origin", "transfer", "look", "window", "views", "layers", "segments", "brush", "explosion"];

impl Scene {
    /// What was decided about the active volume; `None` if there is no volume.
    pub fn active(&self) -> Option<&VolumeSettings> {
        self.volumes.all.get(&self.volumes.active)
    }

    /// What the active volume's labels mean.
    pub fn segments(&self) -> &Segments {
        self.segments_of(self.volumes.active)
    }

    /// The volume that a sub-volume is cut out of, if it is one.
    pub(crate) fn parent_of(&self, volume: VolumeId) -> Option<VolumeId> {
        self.volumes.all.get(&volume)?.sub_volume.map(|sub| sub.parent)
    }

    /// What a sub-volume is cut out of, what that is cut out of, and so on.
    fn ancestors(&self, volume: VolumeId) -> impl Iterator<Item = VolumeId> {
        // No more than there are, whatever a file says.
        std::iter::successors(self.parent_of(volume), |id| self.parent_of(*id)).take(self.volumes.all.len())
    }

    /// Where a sub-volume lies, if in the end it lies in a volume that is none.
    pub(crate) fn lies_in(&self, volume: VolumeId) -> Option<SubVolume> {
        let sub = self.volumes.all.get(&volume)?.sub_volume?;
        let root = self.volumes.all.get(&self.root_of(volume))?;
        root.sub_volume.is_none().then_some(sub)
    }

    /// The volume that is no sub-volume and that this one is cut out of, or is.
    pub(crate) fn root_of(&self, volume: VolumeId) -> VolumeId {
        self.ancestors(volume).last().unwrap_or(volume)
    }

    /// How many sub-volumes lie about one, itself counted; 0 of a volume that is none.
    pub(crate) fn depth_of(&self, volume: VolumeId) -> usize {
        self.ancestors(volume).count()
    }

    /// What the labels of a volume mean; nothing if there is no such volume. Sub-volumes have those of what they are cut out of.
    pub(crate) fn segments_of(&self, volume: VolumeId) -> &Segments {
        static NONE: Segments = Segments(Vec::new());
        self.volumes.all.get(&self.root_of(volume)).map_or(&NONE, |volume| &volume.segments)
    }

    /// What the labels of a volume mean, to change it; `None` if there is no such volume.
    pub fn segments_mut(&mut self, volume: VolumeId) -> Option<&mut Segments> {
        let root = self.root_of(volume);
        self.volumes.all.get_mut(&root).map(|volume| &mut volume.segments)
    }

    /// The volume that a command means: the one that it names, or the active one.
    ///
    /// # Errors
    /// If there is none of that name.
    pub(crate) fn meant(&self, named: Option<VolumeId>) -> Result<VolumeId, DocumentError> {
        match named {
            Some(id) if !self.volumes.all.contains_key(&id) => Err(self.volumes.none_of("volume", id)),
            named => Ok(named.unwrap_or(self.volumes.active)),
        }
    }

    /// The grey window of the active volume's slices.
    pub fn window(&self) -> Window {
        self.window_of(self.volumes.active)
    }

    /// The grey window of a volume's slices.
    pub fn window_of(&self, volume: VolumeId) -> Window {
        self.shown.get(&volume).map_or(Window { level: 0.5, width: 1.0 }, |shown| shown.window)
    }

    /// Shows a volume's slices in this grey window.
    pub(crate) fn show_in(&mut self, volume: VolumeId, window: Window) {
        if let Some(shown) = self.shown.get_mut(&volume) {
            shown.window = window;
        }
    }

    /// The file of the active volume.
    pub fn origin(&self) -> Option<&Origin> {
        self.active().map(|volume| &volume.origin)
    }

    /// Colours and opacities that a volume is shown with: its own or the document's.
    pub fn transfer_of(&self, volume: VolumeId) -> &TransferFunction {
        self.own_look(volume).map_or(&self.transfer, |own| &own.transfer)
    }

    /// The same, to change it: the volume's own if it has one, else the document's.
    pub(crate) fn transfer_mut(&mut self, volume: VolumeId) -> &mut TransferFunction {
        match self.shown.get_mut(&volume).and_then(|shown| shown.own.as_mut()) {
            Some(own) => &mut own.transfer,
            None => &mut self.transfer,
        }
    }

    /// The scene as a question for it is answered: with the active volume's file, window and segments, and of several volumes, or
    /// of one that was changed as such, all of them.
    pub(crate) fn said(&self) -> serde_json::Value {
        let mut said = serde_json::json!(self.sayable());
        let (Some(parts), Some(active)) = (said.as_object_mut(), self.active()) else { return said };
        let as_opened = VolumeSettings {
            name: active.name.clone(),
            segments: active.segments.clone(),
            ..VolumeSettings::new("", active.origin.clone())
        };
        let plain =
            *active == as_opened && self.shown.values().all(|shown| shown.own.is_none() && shown.layers.is_empty());
        if self.volumes.all.len() == 1 && self.volumes.active == VolumeId::FIRST && plain {
            parts.remove("volumes");
            parts.remove("shown");
        }
        if self.also.is_empty() {
            parts.remove("also");
        }
        if !self.focus.on {
            parts.remove("focus");
        }
        let path = active.origin.path.to_string_lossy();
        parts.insert(
            "origin".into(),
            serde_json::json!({
                "path": path, "component": active.origin.component, "frame": active.origin.frame,
            }),
        );
        parts.insert("window".into(), serde_json::json!(self.window()));
        parts.insert("segments".into(), serde_json::json!(active.segments));
        // What scripts have always read comes first and in its order.
        let mut ordered: serde_json::Map<String, serde_json::Value> =
            SAID_FIRST.iter().filter_map(|name| parts.remove_entry(*name)).collect();
        ordered.append(parts);
        ordered.into()
    }

    /// How rays through a volume become colour.
    pub fn mode_of(&self, volume: VolumeId) -> Mode {
        self.own_look(volume).map_or(self.look.mode, |own| own.mode)
    }

    /// The look that the active volume is shown with: mode and light its own or the document's, the rest the document's.
    pub fn look_of(&self, volume: VolumeId) -> ViewLook {
        ViewLook { mode: self.mode_of(volume), lighting: self.lighting_of(volume), ..*self.look }
    }

    /// Shows a volume so; one without a look of its own is shown as the document is.
    pub(crate) fn show(&mut self, volume: VolumeId, look: ViewLook) {
        match self.shown.get_mut(&volume).and_then(|shown| shown.own.as_mut()) {
            Some(own) => {
                (own.mode, own.lighting) = (look.mode, look.lighting);
                *self.look = ViewLook { mode: self.look.mode, lighting: self.look.lighting, ..look };
            }
            None => *self.look = look,
        }
    }

    /// Forgets what is other about the looks of parts and volumes that are gone.
    pub(crate) fn keep_own_looks(&mut self) {
        let Self { own_looks, explosion, volumes, .. } = self;
        if !own_looks.is_empty() {
            own_looks.keep(|id| explosion.part(id).is_ok(), |id| volumes.all.contains_key(&id));
        }
    }

    /// How a volume is lit.
    pub fn lighting_of(&self, volume: VolumeId) -> Option<Lighting> {
        self.own_look(volume).map_or(self.look.lighting, |own| own.lighting)
    }

    fn own_look(&self, volume: VolumeId) -> Option<&OwnLook> {
        let own = self.shown.get(&volume).and_then(|shown| shown.own.as_ref());
        own.or_else(|| self.own_look(self.lies_in(volume)?.parent))
    }
}
