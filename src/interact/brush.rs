//! The brush's settings as commands that carry only what changed, so that two changes on their way do not undo each other.

use crate::document::{BrushCommand, Command};
use crate::paint::{Brush, BrushChange, Target};

/// The command that makes `new` of `old`; `None` if they are the same.
pub fn brush_change(old: &Brush, new: &Brush) -> Option<Command> {
    (old != new).then(|| set(BrushChange::between(old, new)))
}

fn set(change: BrushChange) -> Command {
    Command::Brush(BrushCommand::Set(change))
}

/// Share of the radius, 0..1, within which a press paints at all: 1, but 0 for a label that is too weak, since a voxel takes it where
/// coverage reaches ½.
pub fn reach(brush: &Brush) -> f64 {
    let too_weak = matches!(brush.target, Target::Label(_)) && brush.strength < 0.5;
    if too_weak { 0.0 } else { 1.0 }
}

/// Only the radius, mm.
pub(super) fn set_radius(mm: f64) -> Command {
    set(BrushChange { radius_mm: Some(mm), ..BrushChange::default() })
}

/// Only whether it takes away.
pub(super) fn set_erase(value: bool) -> Command {
    set(BrushChange { erase: Some(value), ..BrushChange::default() })
}
