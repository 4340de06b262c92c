//! Which segments the 3D view leaves out because others are shown alone, in numbers and words, and how one more comes or goes.
//!
//! What is left out is hidden and not gone: every place that says so takes its words from here. Knows no controls.

use crate::document::{Command, Scene, SegmentCommand};
use crate::volume::VolumeId;
use std::collections::BTreeSet;

/// What of a volume's segments is shown alone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ShownAlone {
    volume: VolumeId,
    /// Labels that are shown, 0 among them for what has none.
    labels: BTreeSet<u16>,
    /// Segments that are not.
    hidden: usize,
}

impl ShownAlone {
    /// What is shown alone of a volume; `None` where all is shown.
    pub(crate) fn of(scene: &Scene, volume: VolumeId) -> Option<Self> {
        let labels = scene.own_looks.only.get(&volume)?.clone();
        let hidden = scene.segments_of(volume).0.iter().filter(|segment| !labels.contains(&segment.id)).count();
        Some(Self { volume, labels, hidden })
    }

    /// Whether matter of a label is shown; 0: what has none.
    pub(crate) fn shows(&self, label: u16) -> bool {
        self.labels.contains(&label)
    }

    /// The command after which a label is shown too, or no more. Where none would be left all are shown.
    pub(crate) fn with(&self, label: u16, shown: bool) -> Command {
        let mut labels = self.labels.clone();
        if shown {
            labels.insert(label)
        } else {
            labels.remove(&label)
        };
        show_only((!labels.is_empty()).then_some(labels), self.volume)
    }

    /// What is hidden, in words that a narrow panel has room for.
    pub(crate) fn words(&self) -> String {
        match (self.hidden, self.shows(0)) {
            (0, true) => "None hidden in 3D".into(),
            (0, false) => "No label: hidden in 3D".into(),
            (hidden, _) => format!("{hidden} hidden in 3D, not gone"),
        }
    }
}

/// Shows labels of a volume alone in 3D; all of them if they are left out.
pub(crate) fn show_only(labels: Option<BTreeSet<u16>>, volume: VolumeId) -> Command {
    let ids = labels.map(|labels| labels.into_iter().collect());
    Command::Segment(SegmentCommand::ShowOnly { ids, volume: Some(volume) })
}

/// What the 3D view says of what it leaves out, of all volumes together; `None` where it leaves nothing out.
pub(crate) fn said_in_3d(scene: &Scene) -> Option<String> {
    let seen = scene.volumes.all.iter().filter(|(_, volume)| volume.visible && volume.opacity > 0.0);
    let alone: Vec<_> = seen.filter_map(|(&id, _)| ShownAlone::of(scene, id)).collect();
    let hidden: usize = alone.iter().map(|alone| alone.hidden).sum();
    match hidden {
        0 if alone.iter().all(|alone| alone.shows(0)) => None,
        0 => Some("What has no label is hidden, not gone".into()),
        1 => Some("1 segment is hidden, not gone".into()),
        _ => Some(format!("{hidden} segments are hidden, not gone")),
    }
}
