//! Sub-volumes: boxes of a volume that come, change their faces, go, and are baked into what they are cut out of.
//!
//! Each has beside it, under a number that no scene names, its parent as it was when it was made: what it is computed from wherever it is
//! not edited, also after the parent was painted, and after it was saved and opened again.

use crate::document::Document;
use crate::document::apply::bake::bake;
use crate::document::apply::nesting::{self, Placed, as_it_is, carry, carry_all, let_out};
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
                    let placed = placed(state, volume, SubBox { lo, hi, scale: scale.each() }, None)?;
                    add(state, placed, name, edit)
                }
                SubVolumeCommand::Set { volume, lo, hi, scale, discard } => {
                    let SubVolume { parent, of } = state.scene.sub_volume(volume)?;
                    let scale = scale.map_or(of.scale, |scale| scale.each());
                    let of = SubBox { lo: lo.unwrap_or(of.lo), hi: hi.unwrap_or(of.hi), scale };
                    let placed = placed(state, Some(parent), of, Some(volume))?;
                    change(state, volume, placed, discard, edit)
                }
                SubVolumeCommand::Remove { volume, inner } => {
                    state.scene.sub_volume(volume)?;
                    match inner {
                        true => remove_with_inner(state, volume, edit)?,
                        false => remove(state, volume, edit)?,
                    }
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
    let placed = placed(state, volume, of, None)?;
    let place = placed.place;
    let parent = state.at(Some(place.parent))?;
    Ok(FitSaid {
        place,
        around: placed.around(state, VolumeId(state.scene.volumes.next)),
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
        around: Vec::new(),
    })
}

/// Bytes of all four fields once all of a box is edited.
fn most_bytes(of: SubBox, like: &Volume) -> u64 {
    of.samples().saturating_mul(like.sample_bytes())
}

/// Memory that the system can give, where it says so.
fn available_bytes() -> Option<u64> {
    let told = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = told.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? * 1024)
}

/// The box where it can lie; see [`nesting::placed`].
///
/// # Errors
/// As there, and if it is more than memory can hold.
fn placed(state: &State, volume: Option<VolumeId>, of: SubBox, but: Option<VolumeId>) -> Result<Placed, DocumentError> {
    let placed = nesting::placed(state, volume, of, but)?;
    let of = placed.place.of;
    let bytes = most_bytes(of, state.at(Some(placed.place.parent))?.volume);
    if let Some(available) = available_bytes().filter(|available| bytes > *available) {
        let found = format!("{:?} samples, up to {} MB", of.dims(), bytes >> 20);
        let expected =
            format!("what the {} MB of memory that are free can hold; a smaller box or scale", available >> 20);
        return Err(DocumentError::invalid("lo, hi, scale", found, expected));
    }
    Ok(placed)
}

fn add(state: &mut State, placed: Placed, name: Option<String>, edit: &mut Edit) -> Result<Said, DocumentError> {
    let place = placed.place;
    let parent = state.at(Some(place.parent))?;
    let outer = parent.volume.clone();
    let before = as_it_is(&outer, place.of);
    let id = VolumeId(state.scene.volumes.next);
    let around = placed.around(state, id);
    let origin = parent.settings.origin.clone();
    let name = name.unwrap_or_else(|| format!("Box {id}"));
    let settings = VolumeSettings { sub_volume: Some(place), ..VolumeSettings::new(name, origin) };
    let window = state.scene.window_of(place.parent);
    let volume = Volume::refined(&before, place.of);
    edit.add(state, id.of_before(), Bare { volume: (*before).clone(), files: None });
    edit.add(state, id, Bare { volume, files: None });
    state.scene.volumes.next = id.0.saturating_add(1);
    state.scene.volumes.all.insert(id, settings);
    state.scene.shown.insert(id, VolumeLook { window, own: None, layers: Vec::new() });
    carry_all(state, &placed.others, &outer, edit)?;
    Ok(SubVolumeSaid { around, ..said(state, id)? }.into())
}

/// Takes a sub-volume away; the boxes in it then lie in what it was cut out of.
pub(crate) fn remove(state: &mut State, id: VolumeId, edit: &mut Edit) -> Result<(), DocumentError> {
    let others = let_out(state, id)?;
    let own = state.at(Some(id))?.volume.clone();
    carry_all(state, &others, &own, edit)?;
    remove_with_inner(state, id, edit)
}

/// Takes a sub-volume away with all boxes in it.
pub(crate) fn remove_with_inner(state: &mut State, id: VolumeId, edit: &mut Edit) -> Result<(), DocumentError> {
    let parent = state.scene.parent_of(id);
    for gone in state.scene.cut_out_of(id).into_iter().rev().chain([id]) {
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
    placed: Placed,
    discard: bool,
    edit: &mut Edit,
) -> Result<Said, DocumentError> {
    let place = placed.place;
    if place == state.scene.sub_volume(id)? {
        return Ok(said(state, id)?.into());
    }
    let around = placed.around(state, id);
    let own = state.at(Some(id))?.volume.clone();
    let outer = state.at(Some(place.parent))?.volume.clone();
    let lost = carry(state, (id, place), (&outer, place.of), edit)?;
    if lost > 0 && !discard {
        return Err(DocumentError::WouldLose(lost));
    }
    let (inner, beside): (Vec<_>, Vec<_>) =
        placed.others.into_iter().partition(|(other, _)| state.scene.parent_of(*other) == Some(id));
    carry_all(state, &inner, &own, edit)?;
    carry_all(state, &beside, &outer, edit)?;
    Ok(SubVolumeSaid { around, ..said(state, id)? }.into())
}
