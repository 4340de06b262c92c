//! What commands on segments, parts and forces do to the scene; see `reduce`.

use crate::document::command::SegmentCommand;
use crate::document::command::answers::{
    DegreeSaid, ForcesSaid, PartSaid, SeedSaid, SegmentRemovedSaid, SegmentSaid, ShownOnlySaid, SplitSaid, WholeSaid,
};
use crate::document::command::parts::{ExplosionCommand, PartCommand, Splitter};
use crate::document::error::DocumentError;
use crate::document::reduce::{Changed, Ground};
use crate::document::scene::Scene;
use crate::document::scene::check::check_segment;
use crate::explode::{Cut, Explosion, Part, PartId, PartRecord};
use crate::math::{DVec3, Plane};
use crate::volume::{Grid, Segment, Segments, VolumeId};
use std::collections::BTreeSet;

impl Scene {
    pub(crate) fn apply_segment(&mut self, command: &SegmentCommand) -> Result<Changed, DocumentError> {
        match command {
            SegmentCommand::Set { id, name, colour, visible, locked, look, volume } => {
                let id = *id;
                let (of, own) = (self.meant(*volume)?, &self.own_looks);
                let so_far = own.segment(of, id).cloned();
                let look_now = match look {
                    Some(look) => look.over(so_far.as_ref(), self.lighting_of(of))?,
                    None => so_far.clone(),
                };
                let wanted = Segment::new(id);
                check_segment(&Segment { colour: colour.unwrap_or(wanted.colour), ..wanted })?;
                let table = self.table(*volume)?;
                let known = table.get(id).cloned();
                let step = match (&known, name) {
                    (None, _) => format!("Add segment {id}"),
                    (Some(old), Some(new)) if old.name != *new => format!("Rename segment {}", old.name),
                    (Some(old), _) if look.is_some() => format!("Look of segment {}", old.name),
                    (Some(old), _) => format!("Change segment {}", old.name),
                };
                table.ensure(id);
                let segment = table.get_mut(id).ok_or_else(|| DocumentError::invalid("id", id, "a segment's id"))?;
                if let Some(name) = name {
                    segment.name.clone_from(name);
                }
                segment.colour = colour.unwrap_or(segment.colour);
                segment.visible = visible.unwrap_or(segment.visible);
                segment.locked = locked.unwrap_or(segment.locked);
                let segment = segment.clone();
                if look_now != so_far {
                    self.own_looks.set_segment(of, id, look_now.clone());
                }
                Ok(Changed::new(step, SegmentSaid { segment, look: look_now }))
            }
            SegmentCommand::Remove { id, volume } => {
                let table = self.table(*volume)?;
                let Some(segment) = table.get(*id) else {
                    return Err(DocumentError::no_segment("id", *id, table));
                };
                let step = format!("Remove segment {}", segment.name);
                table.0.retain(|s| s.id != *id);
                let of = self.meant(*volume)?;
                if self.own_looks.names_segment(of, *id) {
                    self.own_looks.forget_segment(of, *id);
                }
                Ok(Changed::new(step, SegmentRemovedSaid { removed: *id }))
            }
            SegmentCommand::ShowOnly { ids, volume } => {
                let of = self.meant(*volume)?;
                let only: Option<BTreeSet<u16>> = ids.as_ref().map(|ids| ids.iter().copied().collect());
                let table = self.segments_of(of);
                let unknown = |id: &&u16| **id != 0 && table.get(**id).is_none();
                if let Some(id) = only.iter().flatten().find(unknown) {
                    return Err(DocumentError::no_segment("ids", *id, table));
                }
                let step = match &only {
                    Some(_) => "Show some segments alone",
                    None => "Show all segments",
                };
                match &only {
                    Some(only) => drop(self.own_looks.only.insert(of, only.clone())),
                    None => drop(self.own_looks.only.remove(&of)),
                }
                Ok(Changed::new(step, ShownOnlySaid { only }))
            }
            // Which segments those are is in the file.
            SegmentCommand::Import { .. } => Ok(Changed::named("Import segments")),
        }
    }

    /// The segments of a volume, the active one if none is named.
    fn table(&mut self, volume: Option<VolumeId>) -> Result<&mut Segments, DocumentError> {
        let volume = self.meant(volume)?;
        self.segments_mut(volume).ok_or(DocumentError::NothingOpen)
    }

    pub(crate) fn apply_part(&mut self, command: &PartCommand, ground: &Ground<'_>) -> Result<Changed, DocumentError> {
        match command {
            PartCommand::Split { by, .. } => {
                let (cut, halves) = self.split(by)?;
                self.halve_own_looks(&cut, &halves);
                let parts = self.explosion.parts.len();
                Ok(Changed::new(by.step_name(), SplitSaid { halves, parts }))
            }
            PartCommand::Set { id, name, colour, own_colour, visible, pinned, importance, look } => {
                let so_far = self.own_looks.parts.get(id).cloned();
                let lit = self.lighting_of(self.volumes.active);
                let look_now = match look {
                    Some(look) => look.over(so_far.as_ref(), lit)?,
                    None => so_far.clone(),
                };
                let stands = ground.poses.of(self.explosion.part(*id)?);
                let explosion = &mut self.explosion;
                let part = explosion.part_mut(*id)?;
                let what = match (name, colour.is_some() || *own_colour, visible, pinned) {
                    (Some(_), ..) => "Rename",
                    (_, true, ..) => "Colour",
                    (_, _, Some(true), _) => "Show",
                    (_, _, Some(false), _) => "Hide",
                    (_, _, _, Some(true)) => "Pin",
                    (_, _, _, Some(false)) => "Unpin",
                    _ if look.is_some() => "Look of",
                    _ => "Change",
                };
                let step = format!("{what} {}", part.name);
                if *own_colour && colour.is_some() {
                    return Err(DocumentError::invalid("own_colour", "true beside a colour", "one of the two"));
                }
                *part = Part {
                    name: name.clone().unwrap_or_else(|| part.name.clone()),
                    colour: if *own_colour { None } else { colour.or(part.colour) },
                    visible: visible.unwrap_or(part.visible),
                    // Who pins a part wants it where it is.
                    held: pinned.map_or(part.held, |pinned| pinned.then_some(stands)),
                    importance: importance.unwrap_or(part.importance),
                    ..part.clone()
                };
                explosion.check()?;
                let part = PartRecord::of(explosion.part(*id)?, stands);
                match &look_now {
                    same if *same == so_far => {}
                    Some(look) => drop(self.own_looks.parts.insert(*id, look.clone())),
                    None => drop(self.own_looks.parts.remove(id)),
                }
                Ok(Changed::new(step, PartSaid { part, look: look_now }))
            }
            PartCommand::Move { id, pose } => {
                let step = format!("Move {}", self.explosion.part(*id)?.name);
                self.explosion.place(*id, *pose)?;
                let look = self.own_looks.parts.get(id).cloned();
                Ok(Changed::new(step, PartSaid { part: self.explosion.part(*id)?.clone().into(), look }))
            }
            PartCommand::Reset {} => {
                self.explosion = one_part(&self.explosion, ground.grid).into();
                self.keep_own_looks();
                Ok(Changed::new("One part", WholeSaid { parts: 1 }))
            }
        }
    }

    /// Halves look as what they were cut from.
    fn halve_own_looks(&mut self, cut: &[PartId], halves: &[[PartId; 2]]) {
        if self.own_looks.parts.is_empty() {
            return;
        }
        // A part that a plane only grazed is there as it was.
        let gone: Vec<PartId> = cut.iter().copied().filter(|id| self.explosion.part(*id).is_err()).collect();
        for (id, halves) in gone.iter().zip(halves) {
            if let Some(look) = self.own_looks.parts.remove(id) {
                self.own_looks.parts.extend(halves.map(|half| (half, look.clone())));
            }
        }
    }

    /// Answers the parts that were to be cut, in order, and the halves of those that were.
    fn split(&mut self, by: &Splitter) -> Result<(Vec<PartId>, Vec<[PartId; 2]>), DocumentError> {
        let ids_of = |cuts: &[Cut]| cuts.iter().map(|cut| cut.part).collect();
        match by {
            Splitter::Plane { point, normal, part } => {
                let plane = Plane::through(DVec3::from_array(*point), DVec3::from_array(*normal))
                    .filter(|p| p.normal.is_finite() && p.offset.is_finite())
                    .ok_or_else(|| {
                        DocumentError::invalid("normal", format!("{normal:?}"), "a finite direction other than zero")
                    })?;
                let ids = match part {
                    Some(id) => vec![self.explosion.part(*id)?.id],
                    None => self.explosion.parts.iter().map(|p| p.id).collect(),
                };
                let cuts: Vec<Cut> = ids.into_iter().map(|part| Cut { part, plane }).collect();
                Ok((ids_of(&cuts), self.explosion.cut(&cuts)?))
            }
            Splitter::Cuts { cuts, .. } => {
                for (i, Cut { plane, .. }) in cuts.iter().enumerate() {
                    if !((plane.normal.length() - 1.0).abs() < 1e-6 && plane.offset.is_finite()) {
                        let expected = "a normal of length 1 and a finite offset";
                        return Err(DocumentError::invalid(format!("cuts[{i}].plane"), format!("{plane:?}"), expected));
                    }
                }
                Ok((ids_of(cuts), self.explosion.cut(cuts)?))
            }
            Splitter::Axis { .. } | Splitter::Depth { .. } | Splitter::Line { .. } => {
                Err(DocumentError::of_picture("by"))
            }
        }
    }

    pub(crate) fn apply_explosion(&mut self, command: &ExplosionCommand) -> Result<Changed, DocumentError> {
        match command {
            ExplosionCommand::Degree { value } => {
                self.explosion.degree = *value;
                self.explosion.check()?;
                Ok(Changed::new("Degree of explosion", DegreeSaid { degree: *value, hint: None }))
            }
            ExplosionCommand::Forces { forces } => {
                forces.check()?;
                self.explosion.forces = *forces;
                Ok(Changed::new("Forces", ForcesSaid { forces: *forces }))
            }
            ExplosionCommand::Seed { value } => {
                self.explosion.seed = *value;
                Ok(Changed::new("Seed of explosion points", SeedSaid { seed: *value }))
            }
            // Where forces take parts is found, not said.
            ExplosionCommand::Settle {} | ExplosionCommand::Step { .. } => Ok(Changed::default()),
        }
    }
}

/// The volume in one part again. Ids are never used twice, so that nobody mistakes one part for another.
fn one_part(old: &Explosion, grid: &Grid) -> Explosion {
    let mut whole = Explosion::whole(grid);
    if old.parts.len() > 1 || old.next_id != whole.next_id {
        for part in &mut whole.parts {
            part.id = PartId(old.next_id);
            part.name = format!("Part {}", old.next_id);
        }
        whole.next_id = old.next_id + 1;
    }
    Explosion { degree: old.degree, forces: old.forces, seed: old.seed, ..whole }
}
