//! Sub-volumes: boxes of a volume that come, change their faces, go, and are baked into what they are cut out of.
//!
//! Each has beside it, under a number that no scene names, its parent as it was when it was made: what it is computed from wherever it is
//! not edited, also after the parent was painted, and after it was saved and opened again.

use crate::document::Document;
use crate::document::apply::bake::bake;
use crate::document::command::Command;
use crate::document::command::answers::{Answer, Said};
use crate::document::command::answers_sub_volumes::{BakedSaid, FitSaid, SubVolumeSaid, SubVolumesSaid};
use crate::document::command::files::VolumeCommand;
use crate::document::command::sub_volumes::SubVolumeCommand;
use crate::document::error::DocumentError;
use crate::document::history::edit::Edit;
use crate::document::history::step::Bare;
use crate::document::scene::volumes::{SubVolume, VolumeLook, VolumeSettings};
use crate::document::state::State;
use crate::volume::{FieldKind, SubBox, Volume, VolumeId};
use std::sync::Arc;

impl Document {
    pub(crate) fn sub_volume(&mut self, command: &SubVolumeCommand) -> Result<Answer, DocumentError> {
        if let SubVolumeCommand::Export { volume, field, path, label } = command {
            self.open()?.scene.sub_volume(*volume)?;
            let (field, path, label, volume) = (*field, path.clone(), *label, Some(*volume));
            return self.volume(&VolumeCommand::Export { field, path, label, volume });
        }
        let whole = Command::SubVolume(command.clone());
        let command = command.clone();
        self.record(&whole, |document, _, edit| {
            edit.takes_looks();
            let state = document.open_mut()?;
            match command {
                SubVolumeCommand::Add { volume, lo, hi, scale, name } => {
                    let place = placed(state, volume, SubBox { lo, hi, scale: scale.each() }, None)?;
                    add(state, place, name, edit)
                }
                SubVolumeCommand::Set { volume, lo, hi, scale, discard } => {
                    let SubVolume { parent, of } = state.scene.sub_volume(volume)?;
                    let scale = scale.map_or(of.scale, |scale| scale.each());
                    let of = SubBox { lo: lo.unwrap_or(of.lo), hi: hi.unwrap_or(of.hi), scale };
                    let place = placed(state, Some(parent), of, Some(volume))?;
                    change(state, volume, place, discard, edit)
                }
                SubVolumeCommand::Remove { volume } => {
                    state.scene.sub_volume(volume)?;
                    remove(state, volume, edit)?;
                    Ok(Said::Nothing)
                }
                SubVolumeCommand::Bake { volume, remove: removes } => {
                    let SubVolume { parent, .. } = state.scene.sub_volume(volume)?;
                    bake(state, volume, edit)?;
                    if removes {
                        remove(state, volume, edit)?;
                    }
                    Ok(BakedSaid { baked: volume, parent }.into())
                }
                // It changes nothing.
                SubVolumeCommand::Export { .. } => Ok(Said::Nothing),
            }
        })
    }
}

/// What `ask.sub_volumes` answers.
pub(crate) fn list(state: &State, of: Option<VolumeId>) -> Result<SubVolumesSaid, DocumentError> {
    let mut sub_volumes = Vec::new();
    if let Some(id) = of {
        state.at(Some(id))?;
    }
    for (&id, settings) in &state.scene.volumes.all {
        if settings.sub_volume.is_some_and(|sub| of.is_none_or(|of| of == sub.parent)) {
            sub_volumes.push(said(state, id)?);
        }
    }
    Ok(SubVolumesSaid { sub_volumes })
}

/// What `ask.sub_volume_fit` answers.
pub(crate) fn fit(state: &State, volume: Option<VolumeId>, of: SubBox) -> Result<FitSaid, DocumentError> {
    let place = placed(state, volume, of, None)?;
    let parent = state.at(Some(place.parent))?;
    Ok(FitSaid {
        place,
        dims: place.of.dims(),
        spacing_mm: place.of.grid(parent.grid()).spacing().to_array(),
        most_bytes: most_bytes(place.of, parent.volume),
        available_bytes: available_bytes(),
    })
}

fn said(state: &State, id: VolumeId) -> Result<SubVolumeSaid, DocumentError> {
    let subject = state.at(Some(id))?;
    let place = state.scene.sub_volume(id)?;
    let held: usize = FieldKind::ALL.iter().map(|&kind| subject.field(kind).heap_bytes()).sum();
    Ok(SubVolumeSaid {
        volume: id,
        name: subject.settings.name.clone(),
        place,
        dims: place.of.dims(),
        spacing_mm: subject.grid().spacing().to_array(),
        most_bytes: most_bytes(place.of, subject.volume),
        held_bytes: held as u64,
    })
}

/// Bytes of all four fields once all of a box is edited.
fn most_bytes(of: SubBox, like: &Volume) -> u64 {
    let texel: usize = FieldKind::ALL.iter().map(|kind| kind.format(like.density.format()).bytes()).sum();
    of.dims().iter().map(|&d| u64::from(d)).product::<u64>() * texel as u64
}

/// Memory that the system can give, where it says so.
fn available_bytes() -> Option<u64> {
    let told = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = told.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}

/// The box where it can lie: in the volume that is named, or in a sub-volume of it that holds all of it. `but`: one that moves.
///
/// # Errors
/// If it is no box of the volume, meets another in part, or is more than memory can hold.
fn placed(
    state: &State,
    volume: Option<VolumeId>,
    of: SubBox,
    but: Option<VolumeId>,
) -> Result<SubVolume, DocumentError> {
    let parent = state.at(volume)?;
    let dims = parent.grid().dims;
    for a in 0..3 {
        let axis = ["i", "j", "k"][a];
        if of.hi[a] >= dims[a] {
            let expected = format!("at most {} along {axis}, the last voxel of {}", dims[a] - 1, parent.settings.name);
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
    for (&id, other) in &state.scene.volumes.all {
        let Some(sub) = other.sub_volume.filter(|sub| sub.parent == parent.id && Some(id) != but) else { continue };
        if of.is_apart(&sub.of) {
            continue;
        }
        let holds = |a: &SubBox, b: &SubBox| (0..3).all(|i| a.lo[i] <= b.lo[i] && b.hi[i] <= a.hi[i]);
        let nests = (0..3).all(|a| of.scale[a].is_multiple_of(sub.of.scale[a]));
        if holds(&sub.of, &of) && nests && but.is_none() && of.lo != sub.of.lo {
            // The same box as its samples count it.
            let within = |v: [u32; 3]| std::array::from_fn(|a| (v[a] - sub.of.lo[a]) * sub.of.scale[a]);
            let scale = std::array::from_fn(|a| of.scale[a] / sub.of.scale[a]);
            return placed(state, Some(id), SubBox { lo: within(of.lo), hi: within(of.hi), scale }, None);
        }
        let (lo, hi) = (sub.of.lo, sub.of.hi);
        let expected = format!(
            "a box apart from sub-volume {id} ({}), {lo:?} to {hi:?}; one inside it is made with \"volume\": {id} or a scale that is a \
             multiple of its {:?}",
            other.name, sub.of.scale
        );
        return Err(DocumentError::invalid("lo, hi", format!("{:?} to {:?}", of.lo, of.hi), expected));
    }
    let bytes = most_bytes(of, parent.volume);
    let dims = of.dims();
    if let Some(available) = available_bytes().filter(|available| bytes > *available) {
        let found = format!("{dims:?} samples, up to {} MB", bytes >> 20);
        let expected =
            format!("what the {} MB of memory that are free can hold; a smaller box or scale", available >> 20);
        return Err(DocumentError::invalid("lo, hi, scale", found, expected));
    }
    Ok(SubVolume { parent: parent.id, of })
}

/// The parent as it is, with as much of what is painted on it as a box needs.
fn as_it_is(state: &State, place: SubVolume) -> Result<Arc<Volume>, DocumentError> {
    let parent = state.at(Some(place.parent))?;
    let reach = |v: u32, by: u32| (v.saturating_sub(by) / crate::volume::BRICK, (v + by) / crate::volume::BRICK);
    let of = place.of;
    let needed = |index: crate::volume::BrickIndex| {
        (0..3).all(|a| (reach(of.lo[a], 2).0..=reach(of.hi[a], 2).1).contains(&index.0[a]))
    };
    Ok(Arc::new(parent.volume.as_it_is(needed)))
}

fn add(state: &mut State, place: SubVolume, name: Option<String>, edit: &mut Edit) -> Result<Said, DocumentError> {
    let before = as_it_is(state, place)?;
    let parent = state.at(Some(place.parent))?;
    let id = VolumeId(state.scene.volumes.next);
    let origin = parent.settings.origin.clone();
    let [x, y, z] = place.of.scale;
    let finer = if x == y && y == z { format!("{x}×") } else { format!("{x}×{y}×{z}") };
    let name = name.unwrap_or_else(|| format!("Sub-volume {id} ({finer})"));
    let settings = VolumeSettings { sub_volume: Some(place), ..VolumeSettings::new(name, origin) };
    let window = state.scene.window_of(place.parent);
    let volume = Volume::refined(&before, place.of);
    edit.add(state, id.of_before(), Bare { volume: (*before).clone(), files: None });
    edit.add(state, id, Bare { volume, files: None });
    state.scene.volumes.next = id.0.saturating_add(1);
    state.scene.volumes.all.insert(id, settings);
    state.scene.shown.insert(id, VolumeLook { window, own: None, layers: Vec::new() });
    Ok(said(state, id)?.into())
}

pub(crate) fn remove(state: &mut State, id: VolumeId, edit: &mut Edit) -> Result<(), DocumentError> {
    let parent = state.scene.parent_of(id);
    for gone in state.scene.cut_out_of(id).into_iter().chain([id]) {
        edit.remove(state, gone)?;
        if state.volumes.contains_key(&gone.of_before()) {
            edit.remove(state, gone.of_before())?;
        }
        state.scene.volumes.all.remove(&gone);
        state.scene.shown.remove(&gone);
        if state.scene.volumes.active == gone {
            state.scene.volumes.active = parent.unwrap_or_default();
        }
    }
    state.scene.keep_own_looks();
    Ok(())
}

fn change(
    state: &mut State,
    id: VolumeId,
    place: SubVolume,
    discard: bool,
    edit: &mut Edit,
) -> Result<Said, DocumentError> {
    let old = state.at(Some(id))?.volume.clone();
    let was = state.scene.sub_volume(id)?.of;
    if place.of == was {
        return Ok(said(state, id)?.into());
    }
    if let Some(inner) = state.scene.cut_out_of(id).first() {
        let name = &state.at(Some(*inner))?.settings.name;
        return Err(DocumentError::NotNow(format!("{name} is cut out of it: remove that first, or bake it")));
    }
    let before = as_it_is(state, place)?;
    let mut volume = Volume::refined(&before, place.of);
    let lost = volume.take_edits(&old)?;
    if lost > 0 && !discard {
        let expected = "a box that holds all that is edited, or \"discard\": true";
        return Err(DocumentError::invalid("lo, hi", format!("{lost} edited samples outside of it"), expected));
    }
    edit.replace(state, id.of_before(), Bare { volume: (*before).clone(), files: None });
    edit.replace(state, id, Bare { volume, files: None });
    if let Some(settings) = state.scene.volumes.all.get_mut(&id) {
        settings.sub_volume = Some(place);
    }
    Ok(said(state, id)?.into())
}
