//! The window's own copy of the scene follows a command at once, so that a slider stays under the hand while the document is busy.
//!
//! Only what is set as it is said is echoed. The document's next snapshot replaces the copy, so an echo can never become the truth.

use crate::document::{
    Command, ExplosionCommand, PartCommand, Place, Scene, SegmentCommand, TransferCommand, ViewCommand, Window,
};
use crate::explode::Poses;
use crate::volume::Lighting;

/// Lets the copy follow; `poses` are where parts stand.
pub(crate) fn echo(scene: &mut Scene, poses: &Poses, command: &Command) {
    match command {
        Command::Brush(brush) => scene.brush = brush.applied_to(&scene.brush),
        Command::Transfer(TransferCommand::Set { function }) => scene.transfer = function.clone(),
        Command::View(view) => echo_view(scene, view),
        Command::Segment(SegmentCommand::Set { id, name, colour, visible, locked }) => {
            scene.segments.ensure(*id);
            if let Some(segment) = scene.segments.get_mut(*id) {
                set(&mut segment.name, name.clone());
                set(&mut segment.colour, *colour);
                set(&mut segment.visible, *visible);
                set(&mut segment.locked, *locked);
            }
        }
        Command::Part(PartCommand::Set { id, name, colour, own_colour, visible, pinned, importance }) => {
            if let Some(part) = scene.explosion.parts.iter_mut().find(|p| p.id == *id) {
                set(&mut part.name, name.clone());
                if *own_colour {
                    part.colour = None;
                }
                part.colour = colour.or(part.colour);
                set(&mut part.visible, *visible);
                let stands = poses.of(part);
                set(&mut part.held, pinned.map(|pinned| pinned.then_some(stands)));
                set(&mut part.importance, *importance);
            }
        }
        Command::Explosion(ExplosionCommand::Degree { value }) => scene.explosion.degree = *value,
        Command::Explosion(ExplosionCommand::Forces { forces }) => scene.explosion.forces = *forces,
        _ => {}
    }
}

fn echo_view(scene: &mut Scene, command: &ViewCommand) {
    match command {
        ViewCommand::Window { level, width } => scene.window = Window { level: *level, width: *width },
        ViewCommand::Layer(layer) => match scene.layers.iter_mut().find(|l| l.field == layer.field) {
            Some(known) => *known = *layer,
            None => scene.layers.push(*layer),
        },
        ViewCommand::Crosshair { at: Place::Mm(at) } => scene.views.crosshair = (*at).into(),
        ViewCommand::Size { view, size } => match view.slice() {
            Some(i) => scene.views.slices[i].size = *size,
            None => scene.views.size = *size,
        },
        ViewCommand::Look { mode, shaded, lighting, step_voxels, background } => {
            let look = &mut scene.look;
            set(&mut look.mode, *mode);
            set(&mut look.step_voxels, *step_voxels);
            set(&mut look.background, *background);
            match shaded {
                Some(false) => look.lighting = None,
                Some(true) if look.lighting.is_none() => look.lighting = Some(Lighting::default()),
                _ => {}
            }
            look.lighting = lighting.or(look.lighting);
        }
        _ => {}
    }
}

fn set<T>(field: &mut T, new: Option<T>) {
    if let Some(new) = new {
        *field = new;
    }
}
