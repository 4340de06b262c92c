//! The things that may have a look for themselves, what they have and inherit, and the commands that change it.
//!
//! One place for the menu of looks and for the editor of transfer functions. Knows no controls.

use crate::document::looks::{Inherit, LookFields, LookSetting};
use crate::document::own_looks::LookChange;
use crate::document::{
    Command, HistoryCommand, PartCommand, Scene, SegmentCommand, SelectionCommand, VolumeCommand, Volumes,
};
use crate::explode::PartId;
use crate::volume::{Lighting, Mode, TransferFunction, VolumeId};

/// Whose look it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum LookOf {
    Volume(VolumeId),
    /// The selected matter of a volume.
    Selection(VolumeId),
    /// In all volumes.
    Part(PartId),
    Segment(VolumeId, u16),
}

/// How something is shown that has no look for itself.
pub(crate) struct Inherited<'a> {
    pub(crate) transfer: &'a TransferFunction,
    pub(crate) mode: Mode,
    pub(crate) lighting: Option<Lighting>,
}

impl LookOf {
    /// What it has for itself; `None`: nothing.
    pub(crate) fn own(self, scene: &Scene) -> Option<LookChange> {
        let looks = &scene.own_looks;
        match self {
            Self::Volume(id) => scene.shown.get(&id)?.own.as_ref().map(|own| LookChange {
                transfer: Some(own.transfer.clone()),
                mode: Some(own.mode),
                lighting: Some(own.lighting),
                opacity: 1.0,
            }),
            Self::Selection(volume) => looks.selections.get(&volume).cloned(),
            Self::Part(id) => looks.parts.get(&id).cloned(),
            Self::Segment(volume, label) => looks.segment(volume, label).cloned(),
        }
    }

    /// How it is shown where it has nothing for itself. Parts are in all volumes: of theirs it is the active one's.
    pub(crate) fn inherited(self, scene: &Scene) -> Inherited<'_> {
        let of = match self {
            Self::Volume(_) => {
                let (mode, lighting) = (scene.look.mode, scene.look.lighting);
                return Inherited { transfer: &scene.transfer, mode, lighting };
            }
            Self::Selection(volume) | Self::Segment(volume, _) => volume,
            Self::Part(_) => scene.volumes.active,
        };
        Inherited { transfer: scene.transfer_of(of), mode: scene.mode_of(of), lighting: scene.lighting_of(of) }
    }

    /// The colour that it is known by.
    pub(crate) fn colour(self, scene: &Scene) -> Option<[f32; 3]> {
        match self {
            Self::Volume(_) => None,
            Self::Selection(_) => Some(crate::document::SELECTION_COLOUR),
            Self::Part(id) => scene.explosion.part(id).ok()?.colour,
            Self::Segment(volume, label) => Some(scene.segments_of(volume).colour_of(label)),
        }
    }

    /// What its own colour is called to whoever shows it in that alone.
    pub(crate) fn in_its_colour(self) -> &'static str {
        match self {
            Self::Volume(_) => "In the volume's colour",
            Self::Selection(_) => "In the selection's colour",
            Self::Part(_) => "In the part's colour",
            Self::Segment(..) => "In the segment's colour",
        }
    }

    /// As it is called; `None` if it is gone.
    pub(crate) fn called(self, scene: &Scene) -> Option<String> {
        match self {
            Self::Volume(id) => volume_name(&scene.volumes, id),
            Self::Selection(id) => scene.volumes.all.contains_key(&id).then(|| "the selection".to_owned()),
            Self::Part(id) => scene.explosion.part(id).ok().map(|part| part.name.clone()),
            Self::Segment(volume, label) => scene.segments_of(volume).get(label).map(|segment| segment.name.clone()),
        }
    }

    /// The volume that it is of, where that is a question.
    pub(crate) fn within(self, scene: &Scene) -> Option<String> {
        match self {
            Self::Volume(_) | Self::Part(_) => None,
            Self::Selection(id) | Self::Segment(id, _) => {
                volume_name(&scene.volumes, id).filter(|_| scene.volumes.all.len() > 1)
            }
        }
    }

    /// The command that gives it this.
    pub(crate) fn set(self, scene: &Scene, look: LookSetting) -> Command {
        let named = |id: VolumeId| (id != scene.volumes.active).then_some(id);
        match self {
            Self::Volume(volume) => Command::Volume(VolumeCommand::Set {
                volume,
                name: None,
                visible: None,
                opacity: None,
                look: Some(look),
                shared_look: false,
                pose: None,
                active: false,
            }),
            Self::Selection(volume) => Command::Selection(SelectionCommand::Set { look, volume: named(volume) }),
            Self::Part(id) => Command::Part(PartCommand::Set {
                id,
                name: None,
                colour: None,
                own_colour: false,
                visible: None,
                pinned: None,
                importance: None,
                look: Some(look),
            }),
            Self::Segment(volume, id) => Command::Segment(SegmentCommand::Set {
                id,
                name: None,
                colour: None,
                visible: None,
                locked: None,
                look: Some(look),
                volume: named(volume),
            }),
        }
    }

    /// The command that gives it a transfer function for itself.
    pub(crate) fn set_function(self, scene: &Scene, function: TransferFunction) -> Command {
        let fields = LookFields { transfer: Some(function), ..LookFields::default() };
        self.set(scene, LookSetting::Own(Box::new(fields)))
    }

    /// The commands after which it has what is wanted for itself and inherits the rest: one step of history. Commands say what changes;
    /// what is to be inherited again is given up with the rest, which is then said anew.
    pub(crate) fn change(self, scene: &Scene, wanted: &LookChange) -> Vec<Command> {
        let now = self.own(scene).unwrap_or_default();
        let inherit = || self.set(scene, LookSetting::Inherit(Inherit::Inherit));
        let own = |fields: LookFields| self.set(scene, LookSetting::Own(Box::new(fields)));
        if *wanted == LookChange::default() {
            return vec![inherit()];
        }
        let LookChange { transfer, mode, lighting, opacity } = wanted.clone();
        let all = LookFields { transfer, mode, shaded: None, lighting, opacity: Some(opacity) };
        let gives_up = now.transfer.is_some() && wanted.transfer.is_none()
            || now.mode.is_some() && wanted.mode.is_none()
            || now.lighting.is_some() && wanted.lighting.is_none();
        if gives_up {
            let [begin, end] = [HistoryCommand::Begin {}, HistoryCommand::End {}].map(Command::History);
            let said = LookFields { opacity: (opacity != 1.0).then_some(opacity), ..all };
            return vec![begin, inherit(), own(said), end];
        }
        vec![own(LookFields {
            transfer: all.transfer.filter(|_| wanted.transfer != now.transfer),
            mode: all.mode.filter(|_| wanted.mode != now.mode),
            lighting: all.lighting.filter(|_| wanted.lighting != now.lighting),
            opacity: all.opacity.filter(|_| wanted.opacity != now.opacity),
            shaded: None,
        })]
    }
}

/// What a volume is called; those of one name are told apart by number.
pub(crate) fn volume_name(volumes: &Volumes, id: VolumeId) -> Option<String> {
    let name = &volumes.all.get(&id)?.name;
    let alike = volumes.all.values().filter(|other| other.name == *name).count();
    Some(if alike > 1 { format!("{name} ({id})") } else { name.clone() })
}

/// The volume that the panels show, where that is a question.
pub(crate) fn shown_volume(scene: &Scene) -> Option<String> {
    volume_name(&scene.volumes, scene.volumes.active).filter(|_| scene.volumes.all.len() > 1)
}

/// Whose looks the panels show where that is a question: the active volume's name, and whether it has its own or which share it.
pub(crate) fn whose(scene: &Scene) -> Option<(String, String)> {
    let volumes = &scene.volumes;
    let own = |id: VolumeId| LookOf::Volume(id).own(scene).is_some();
    let name = volume_name(volumes, volumes.active)?;
    if own(volumes.active) {
        return Some((name, "its own".into()));
    }
    if volumes.all.len() < 2 {
        return None;
    }
    let others: Vec<_> = volumes.all.iter().filter(|&(&id, _)| id != volumes.active && !own(id)).collect();
    let shared = match &others[..] {
        // Nothing else is shown with what is said of it.
        [] => "its own".to_owned(),
        [(id, _)] => format!("shared with {}", volume_name(volumes, **id)?),
        several => format!("shared with {} others", several.len()),
    };
    Some((name, shared))
}
