//! Commands on parts: splitters, names, colours, hands.

use crate::document::Document;
use crate::document::apply::view::nothing_there;
use crate::document::command::parts::{PartCommand, Splitter};
use crate::document::error::DocumentError;
use crate::document::history::edit::Edit;
use crate::document::place::check_size;
use crate::explode::{Explosion, Part, PartId, PartRecord, axis_plane, depth_plane};
use crate::math::{DVec2, DVec3, Plane};
use serde_json::{Value, json};

impl Document {
    pub(crate) fn part(&mut self, command: PartCommand, edit: &mut Edit) -> Result<Value, DocumentError> {
        match command {
            PartCommand::Split { by, size } => {
                edit.name(match by {
                    Splitter::Axis { .. } => "Axis split",
                    Splitter::Depth { .. } => "Depth split",
                    Splitter::Line { .. } => "Line split",
                    Splitter::Plane { .. } => "Plane split",
                });
                let halves = self.split(by, size)?;
                let parts = self.open()?.scene.explosion.parts.len();
                Ok(json!({ "halves": halves, "parts": parts }))
            }
            PartCommand::Set { id, name, colour, own_colour, visible, pinned, importance } => {
                let stands = self.motion.poses().of(self.open()?.scene.explosion.part(id)?);
                let explosion = &mut self.open_mut()?.scene.explosion;
                let part = explosion.part_mut(id)?;
                let what = match (&name, colour.is_some() || own_colour, visible, pinned) {
                    (Some(_), ..) => "Rename",
                    (_, true, ..) => "Colour",
                    (_, _, Some(true), _) => "Show",
                    (_, _, Some(false), _) => "Hide",
                    (_, _, _, Some(true)) => "Pin",
                    (_, _, _, Some(false)) => "Unpin",
                    _ => "Change",
                };
                edit.name(format!("{what} {}", part.name));
                if own_colour && colour.is_some() {
                    return Err(DocumentError::invalid("own_colour", "true beside a colour", "one of the two"));
                }
                *part = Part {
                    name: name.unwrap_or_else(|| part.name.clone()),
                    colour: if own_colour { None } else { colour.or(part.colour) },
                    visible: visible.unwrap_or(part.visible),
                    // Who pins a part wants it where it is.
                    held: pinned.map_or(part.held, |pinned| pinned.then_some(stands)),
                    importance: importance.unwrap_or(part.importance),
                    ..part.clone()
                };
                explosion.check()?;
                Ok(json!({ "part": PartRecord::of(explosion.part(id)?, stands) }))
            }
            PartCommand::Move { id, pose } => {
                let explosion = &mut self.open_mut()?.scene.explosion;
                edit.name(format!("Move {}", explosion.part(id)?.name));
                explosion.place(id, pose)?;
                Ok(json!({ "part": explosion.part(id)? }))
            }
            PartCommand::Reset {} => {
                edit.name("One part");
                let state = self.open_mut()?;
                let old = &state.scene.explosion;
                let mut whole = Explosion::whole(state.grid());
                // Ids are never used twice, so that nobody mistakes one part for another.
                let renumbered = old.parts.len() > 1 || old.next_id != whole.next_id;
                if renumbered {
                    for part in &mut whole.parts {
                        part.id = PartId(old.next_id);
                        part.name = format!("Part {}", old.next_id);
                    }
                    whole.next_id = old.next_id + 1;
                }
                state.scene.explosion = Explosion { degree: old.degree, forces: old.forces, seed: old.seed, ..whole };
                Ok(json!({ "parts": 1 }))
            }
        }
    }

    fn split(&mut self, by: Splitter, size: Option<[u32; 2]>) -> Result<Vec<[PartId; 2]>, DocumentError> {
        let views = &self.open()?.scene.views;
        let camera = views.camera;
        let size = check_size(size.unwrap_or(views.size))?;
        match by {
            Splitter::Line { from, to } => {
                let state = self.state.as_mut().ok_or(DocumentError::NothingOpen)?;
                let (from, to) = (DVec2::from_array(from), DVec2::from_array(to));
                Ok(state.scene.explosion.split_by_line(self.motion.poses(), &camera, from, to, size)?)
            }
            Splitter::Plane { point, normal, part } => {
                let plane = Plane::through(DVec3::from_array(point), DVec3::from_array(normal))
                    .filter(|p| p.normal.is_finite() && p.offset.is_finite())
                    .ok_or_else(|| {
                        DocumentError::invalid("normal", format!("{normal:?}"), "a finite direction other than zero")
                    })?;
                let explosion = &mut self.open_mut()?.scene.explosion;
                let ids = match part {
                    Some(id) => vec![explosion.part(id)?.id],
                    None => explosion.parts.iter().map(|p| p.id).collect(),
                };
                let mut halves = Vec::new();
                for id in ids {
                    halves.extend(explosion.split_at_rest(id, &plane)?);
                }
                Ok(halves)
            }
            Splitter::Axis { px, axis } => {
                let (part, hit) = self.part_under(px, size)?;
                let plane = axis_plane(&camera, DVec2::from_array(px), size, axis, hit)?;
                self.split_standing(part, &plane)
            }
            Splitter::Depth { px } => {
                let (part, hit) = self.part_under(px, size)?;
                let plane = depth_plane(&camera, hit)?;
                self.split_standing(part, &plane)
            }
        }
    }

    /// Cuts a part by a plane of the world, where it stands.
    fn split_standing(&mut self, part: PartId, plane: &Plane) -> Result<Vec<[PartId; 2]>, DocumentError> {
        let state = self.state.as_mut().ok_or(DocumentError::NothingOpen)?;
        Ok(state.scene.explosion.split(part, self.motion.poses(), plane)?.into_iter().collect())
    }

    /// The part that is hit first by a visible sample, and where, world mm as it is seen.
    fn part_under(&mut self, px: [f64; 2], size: [u32; 2]) -> Result<(PartId, DVec3), DocumentError> {
        let hit = self.pick(DVec2::from_array(px), Some(size))?.ok_or_else(|| nothing_there("px", px))?;
        Ok((self.open()?.part_at(hit.body, hit.rest)?, hit.world))
    }
}
