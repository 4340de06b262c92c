//! Where a box comes to lie among others, and which of these lie in it then or no longer: several boxes are apart or nested, never in part over
//! each other.
//!
//! A box that gets other surroundings is computed from these as they are now, and so are the boxes in it; what each has for itself
//! stays as it is to the bit. So it makes no difference in which order nested boxes were made.

use crate::document::error::DocumentError;
use crate::document::history::edit::Edit;
use crate::document::scene::volumes::SubVolume;
use crate::document::state::State;
use crate::volume::{BRICK, BrickIndex, Carry, Lies, SubBox, Volume, VolumeId};
use std::sync::Arc;

/// Where a box is to lie, and the others that get another parent or other numbers by it.
#[derive(Debug)]
pub(super) struct Placed {
    pub place: SubVolume,
    pub others: Vec<(VolumeId, SubVolume)>,
}

impl Placed {
    /// The boxes that come to lie in it and were not in it before.
    pub(super) fn around(&self, state: &State, id: VolumeId) -> Vec<VolumeId> {
        let new =
            self.others.iter().filter(|(other, sub)| sub.parent == id && state.scene.parent_of(*other) != Some(id));
        new.map(|(other, _)| *other).collect()
    }
}

/// The box where it can lie: in the volume that is named, or in a sub-volume of it that holds all of it. `but`: one that is there and moves.
///
/// # Errors
/// If it is no box of the volume, or meets another in part.
pub(super) fn placed(
    state: &State,
    volume: Option<VolumeId>,
    of: SubBox,
    but: Option<VolumeId>,
) -> Result<Placed, DocumentError> {
    let parent = state.at(volume)?;
    let dims = parent.grid().dims;
    check(of, dims, &parent.settings.name)?;
    let whole = SubBox::whole(dims);
    let id = but.unwrap_or(VolumeId(state.scene.volumes.next));
    let found = || format!("{:?} to {:?}", of.lo, of.hi);
    let called = |other: VolumeId| state.scene.volumes.all.get(&other).map_or("", |volume| volume.name.as_str());
    let mut others = Vec::new();
    for (other, sub) in state.scene.boxes_of(parent.id).filter(|(other, _)| Some(*other) != but) {
        let name = called(other);
        if of.is_apart(&sub.of) {
            continue;
        }
        let (holds, is_held) = (of.holds(&sub.of), sub.of.holds(&of));
        if holds && is_held {
            let expected = format!(
                "another box than that of sub-volume {other} ({name}), which sub_volume.set divides more finely"
            );
            return Err(DocumentError::invalid("lo, hi", found(), expected));
        }
        let (scale, its) = (of.scale, sub.of.scale);
        if is_held && but.is_none() {
            let Some(inner) = whole.inner_in(&of, &sub.of) else {
                let expected =
                    format!("a multiple of {its:?}, by which sub-volume {other} ({name}) is divided that it lies in");
                return Err(DocumentError::invalid("scale", format!("{scale:?}"), expected));
            };
            return placed(state, Some(other), inner, None);
        }
        if !holds {
            let (lo, hi) = (sub.of.lo, sub.of.hi);
            let expected =
                format!("a box apart from sub-volume {other} ({name}), {lo:?} to {hi:?}, inside it or around it");
            return Err(DocumentError::invalid("lo, hi", found(), expected));
        }
        let Some(inner) = whole.inner_in(&sub.of, &of) else {
            let expected =
                format!("what divides {its:?}, by which sub-volume {other} ({name}) is divided that lies in it");
            return Err(DocumentError::invalid("scale", format!("{scale:?}"), expected));
        };
        others.push((other, SubVolume { parent: id, of: inner }));
    }
    if let Some(was) = but.map(|id| state.scene.sub_volume(id)).transpose()? {
        for (inner, sub) in state.scene.boxes_of(id) {
            let name = called(inner);
            let (to, next, whose) = match was.of.inner_lies(&sub.of, &of) {
                Lies::Inside => (of, id, "it"),
                Lies::Apart => (whole, parent.id, parent.settings.name.as_str()),
                Lies::InPart => {
                    let expected =
                        format!("a box that holds all of sub-volume {inner} ({name}) in it, or nothing of that");
                    return Err(DocumentError::invalid("lo, hi", found(), expected));
                }
            };
            let Some(other) = was.of.inner_in(&sub.of, &to) else {
                let expected = format!("one in which sub-volume {inner} ({name}) still {}", fits(whose));
                return Err(DocumentError::invalid(
                    "lo, hi, scale",
                    format!("{} at {:?}", found(), of.scale),
                    expected,
                ));
            };
            others.push((inner, SubVolume { parent: next, of: other }));
        }
    }
    Ok(Placed { place: SubVolume { parent: parent.id, of }, others })
}

fn fits(whose: &str) -> String {
    format!("is a box of whole voxels of {whose}, 1 to 8 times as fine as these")
}

/// Fails unless a box lies in a volume of these dimensions.
fn check(of: SubBox, dims: [u32; 3], name: &str) -> Result<(), DocumentError> {
    for (a, axis) in ["i", "j", "k"].into_iter().enumerate() {
        if of.hi[a] >= dims[a] {
            let expected = format!("at most {} along {axis}, the last voxel of {name}", dims[a] - 1);
            return Err(DocumentError::invalid("hi", format!("{:?}", of.hi), expected));
        }
        if of.lo[a] >= of.hi[a] {
            let expected = format!("below hi ({:?}) along every axis", of.hi);
            return Err(DocumentError::invalid("lo", format!("{:?}", of.lo), expected));
        }
        if !(1..=SubBox::FINEST).contains(&of.scale[a]) {
            return Err(DocumentError::invalid("scale", format!("{:?}", of.scale), "1 to 8 samples a voxel"));
        }
    }
    Ok(())
}

/// Where the boxes in a sub-volume lie once it is gone: in what it is cut out of.
///
/// # Errors
/// If one of them cannot lie there.
pub(super) fn let_out(state: &State, id: VolumeId) -> Result<Vec<(VolumeId, SubVolume)>, DocumentError> {
    let SubVolume { parent, of } = state.scene.sub_volume(id)?;
    let outer = state.at(Some(parent))?;
    let whole = SubBox::whole(outer.grid().dims);
    let out = |(inner, sub): (VolumeId, SubVolume)| match of.inner_in(&sub.of, &whole) {
        Some(of) => Ok((inner, SubVolume { parent, of })),
        None => {
            let name = &state.at(Some(inner))?.settings.name;
            let expected =
                format!("\"inner\": true, by which it goes too, or a box that {}", fits(&outer.settings.name));
            let found =
                format!("sub-volume {inner} ({name}) in it, {:?} to {:?} at {:?}", sub.of.lo, sub.of.hi, sub.of.scale);
            Err(DocumentError::invalid("volume", found, expected))
        }
    };
    state.scene.boxes_of(id).map(out).collect()
}

/// A volume as it is, with as much of what is painted on it as a box of it needs.
pub(super) fn as_it_is(volume: &Volume, of: SubBox) -> Arc<Volume> {
    let reach = |v: u32, by: u32| (v.saturating_sub(by) / BRICK, (v + by) / BRICK);
    let needed =
        |index: BrickIndex| (0..3).all(|a| (reach(of.lo[a], 2).0..=reach(of.hi[a], 2).1).contains(&index.0[a]));
    Arc::new(volume.as_it_is(needed))
}

/// Gives a sub-volume another place, in the parent that it has or in another one, and computes it from what lies there now; the boxes in it
/// stay as they are. `was` is the parent that it has, as it is, and `to` the new place in voxels of that. Answers how many edited samples lie outside.
pub(super) fn carry(
    state: &mut State,
    (id, place): (VolumeId, SubVolume),
    (was, to): (&Volume, SubBox),
    edit: &mut Edit,
) -> Result<u64, DocumentError> {
    let from = state.at(Some(id))?.volume.clone();
    let old = state.scene.sub_volume(id)?.of;
    let before = state.volumes.get(&id.of_before()).cloned().unwrap_or_else(|| from.clone());
    let now = as_it_is(state.at(Some(place.parent))?.volume, place.of);
    let mut volume = Volume::refined(&now, place.of);
    let lost = Carry { from: &from, before: &before, parent: as_it_is(was, old), to }.into(&mut volume)?;
    edit.replace(state, id.of_before(), (*now).clone());
    edit.replace(state, id, volume);
    if let Some(settings) = state.scene.volumes.all.get_mut(&id) {
        settings.sub_volume = Some(place);
    }
    Ok(lost)
}

/// The same of boxes whose samples stay where they are, and of all boxes in them.
pub(super) fn carry_all(
    state: &mut State,
    others: &[(VolumeId, SubVolume)],
    was: &Volume,
    edit: &mut Edit,
) -> Result<(), DocumentError> {
    for &(id, place) in others {
        let (own, old) = (state.at(Some(id))?.volume.clone(), state.scene.sub_volume(id)?.of);
        carry(state, (id, place), (was, old), edit)?;
        let inner: Vec<_> = state.scene.boxes_of(id).collect();
        carry_all(state, &inner, &own, edit)?;
    }
    Ok(())
}
