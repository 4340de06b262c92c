//! Which commands set the parts in motion: those that change what the forces act by.
//!
//! A script moves parts when it says so; the window lets them follow whatever is done. Compares what the scene says before and
//! after a command, and knows which commands change the voxels that explosion points stand on. Knows nothing of egui.

use crate::document::{Command, Document, ExplosionCommand, HistoryCommand};
use crate::explode::Explosion;
use crate::math::{Camera, Pose};
use crate::volume::{FieldKind, TransferFunction};

/// What forces act by, as far as the scene says it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cause {
    /// Poses that forces decide are the identity here; nobody has a name or a colour.
    explosion: Explosion,
    /// `None` where it makes no difference.
    camera: Option<Camera>,
    transfer: TransferFunction,
    /// Whether explosion points stand on the brush's field.
    paints: bool,
}

impl Cause {
    /// As it is now; `None` if nothing is open.
    pub(crate) fn of(document: &Document) -> Option<Self> {
        let scene = &document.state()?.scene;
        let mut explosion = scene.explosion.clone();
        for part in &mut explosion.parts {
            part.name.clear();
            part.colour = None;
            if !part.pinned {
                part.pose = Pose::IDENTITY;
            }
        }
        let paints = matches!(scene.brush.target.field(), FieldKind::Selection | FieldKind::Density);
        let camera = explosion.forces.viewing.then_some(scene.views.camera);
        Some(Self { explosion, camera, transfer: scene.transfer.clone(), paints })
    }

    /// Whether parts may have to move after a command that was done; `before` is what was the cause until then.
    pub(crate) fn stirred(before: Option<&Self>, command: &Command, now: Option<&Self>) -> bool {
        let (Some(before), Some(now)) = (before, now) else { return false };
        match command {
            // At degree 0 they go home.
            Command::Explosion(ExplosionCommand::Degree { .. } | ExplosionCommand::Forces { .. }) => true,
            _ if now.explosion.degree == 0.0 => false,
            Command::Stroke(_) => now.paints,
            Command::Selection(_) => true,
            Command::History(h) => !matches!(h, HistoryCommand::Begin {} | HistoryCommand::End {}),
            Command::View(_) | Command::Part(_) | Command::Transfer(_) | Command::Explosion(_) => {
                before.explosion != now.explosion || before.camera != now.camera || before.transfer != now.transfer
            }
            _ => false,
        }
    }
}
