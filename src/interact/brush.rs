//! The brush's settings as commands that carry only what changed, so that two changes on their way do not undo each other.

use crate::document::{BrushCommand, Command};
use crate::paint::{Brush, Target};

/// The command that makes `new` of `old`; `None` if they are the same.
pub fn brush_change(old: &Brush, new: &Brush) -> Option<Command> {
    fn changed<T: PartialEq + Copy>(old: T, new: T) -> Option<T> {
        (old != new).then_some(new)
    }
    (old != new).then(|| {
        Command::Brush(BrushCommand::Set {
            shape: changed(old.shape, new.shape),
            radius_mm: changed(old.radius_mm, new.radius_mm),
            falloff: changed(old.falloff, new.falloff),
            strength: changed(old.strength, new.strength),
            operation: changed(old.operation, new.operation),
            tip: changed(old.tip, new.tip),
            target: changed(old.target, new.target),
            spacing: changed(old.spacing, new.spacing),
            range: changed(old.range, new.range).flatten(),
            any_value: old.range.is_some() && new.range.is_none(),
            erase: changed(old.erase, new.erase),
            erase_density: changed(old.erase_density, new.erase_density),
            visible_only: changed(old.visible_only, new.visible_only),
        })
    })
}

/// Share of the radius, 0..1, within which a press paints at all: 1, but 0 for a label that is too weak, since a voxel takes it where
/// coverage reaches ½.
pub fn reach(brush: &Brush) -> f64 {
    let too_weak = matches!(brush.target, Target::Label(_)) && brush.strength < 0.5;
    if too_weak { 0.0 } else { 1.0 }
}

fn only(change: impl FnOnce(&mut BrushCommand)) -> Command {
    let mut command = BrushCommand::Set {
        shape: None,
        radius_mm: None,
        falloff: None,
        strength: None,
        operation: None,
        tip: None,
        target: None,
        spacing: None,
        range: None,
        any_value: false,
        erase: None,
        erase_density: None,
        visible_only: None,
    };
    change(&mut command);
    Command::Brush(command)
}

/// Only the radius, mm.
pub(super) fn set_radius(mm: f64) -> Command {
    only(|BrushCommand::Set { radius_mm, .. }| *radius_mm = Some(mm))
}

/// Only whether it takes away.
pub(super) fn set_erase(value: bool) -> Command {
    only(|BrushCommand::Set { erase, .. }| *erase = Some(value))
}
