//! Commands on what is connected: what becomes of it.
//!
//! What is connected is found in the whole region that is meant, over the faces of sub-volumes too (`apply/connected.rs`). Only bricks in
//! which something becomes other are exchanged, so that undoing costs what changed; voxels that are not meant keep every bit.

use crate::document::Document;
use crate::document::apply::connected::{Found, find};
use crate::document::apply::matter::{Voxels, filled, selects};
use crate::document::command::Place;
use crate::document::command::answers::{ComponentOnSaid, ComponentSaid, Said};
use crate::document::command::component::{
    ComponentCommand, Connected, Isolation, Joining, Labelling, Selecting, Within,
};
use crate::document::error::DocumentError;
use crate::document::history::edit::Edit;
use crate::document::place::nothing_there;
use crate::document::reduce::place::place_in;
use crate::document::scene::check::finite;
use crate::document::state::State;
use crate::document::subject::Subject;
use crate::math::DVec2;
use crate::paint::{Brush, EraseDensity, Falloff, Operation, Reach, Target};
use crate::segment::BrickMask;
use crate::volume::{
    BRICK, Brick, BrickIndex, BrickKey, Changes, DensityMap, Field, FieldKey, FieldKind, SourceError, VolumeId,
};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Voxels of one volume after another.
type OfVolumes = Vec<(VolumeId, Voxels)>;

impl Document {
    pub(crate) fn component(&mut self, command: &ComponentCommand, edit: &mut Edit) -> Result<Said, DocumentError> {
        let watch = self.watch.clone();
        let state = self.open_mut()?;
        let connected = command.connected();
        // What is connected does not end at the faces of a sub-volume.
        let id = state.with_all_inside(connected.volume)?[0];
        let family = state.family(id)?;
        let within = match (connected.within, command) {
            (Some(within), _) => within,
            // What is selected does not keep more from being selected.
            (None, ComponentCommand::Select(_)) => Within::Volume,
            (None, _) if selects(state, &family)? => Within::Selection,
            (None, _) => Within::Volume,
        };
        let found = find(state, family, &connected, within, &|x| watch.proceed(x * 0.9))?;
        let small = connected.smaller_than.is_some();
        let said = ComponentSaid { pieces: small.then(|| found.pieces()), ..said(&found) };
        let (said, nothing) = match command {
            ComponentCommand::Keep(removal) => {
                let value = remove(state, removal, found.of_volumes(false), edit)?;
                (
                    ComponentSaid { value: Some(value), ..said },
                    "All of it is connected: there is nothing else to remove.",
                )
            }
            ComponentCommand::Remove(removal) => {
                let value = remove(state, removal, found.of_volumes(true), edit)?;
                (ComponentSaid { value: Some(value), ..said }, "It has the value that removes already.")
            }
            ComponentCommand::Select(Selecting { how, .. }) => {
                select(state, id, *how, found.of_volumes(true), edit)?;
                (said, "The selection is so already.")
            }
            ComponentCommand::Label(Labelling { label, .. }) => {
                let kept_locked = relabel(state, *label, &found.of_volumes(true), edit)?;
                let said = ComponentSaid { kept_locked: Some(kept_locked), ..said };
                let nothing = match (kept_locked, label) {
                    (0, 0) => "It has no label.",
                    (0, _) => "It has that label already.",
                    _ => "The segment that is there is locked.",
                };
                (said, nothing)
            }
        };
        let nothing = if said.pieces == Some(0) { "No piece is smaller than that." } else { nothing };
        let nothing = (edit.counts().0 == 0).then_some(nothing);
        Ok(ComponentSaid { nothing, ..said }.into())
    }

    /// The command with a pixel of the 3D view put in mm, and the volume that shows there named where none is: the whole one, where it is
    /// a sub-volume that shows.
    ///
    /// # Errors
    /// If nothing shows there, or there is no GPU to look with.
    pub(crate) fn component_in_numbers(
        &mut self,
        command: ComponentCommand,
    ) -> Result<ComponentCommand, DocumentError> {
        let Connected { at, volume, .. } = command.connected();
        let Some(at) = at else { return Ok(command) };
        let subject = self.open()?.at(volume)?;
        if let Some(sample) = place_in(at, subject.scene, subject.grid())? {
            return Ok(command.put(Some(Place::Mm(sample.position.to_array())), volume));
        }
        let Place::Pixel { px, size, .. } = at else { return Ok(command) };
        let hit = self.pick(DVec2::from_array(px), size)?.ok_or_else(|| nothing_there("at", at))?;
        let scene = &self.open()?.scene;
        let shown = hit.object.volume().map(|shown| scene.root_of(shown));
        Ok(command.put(Some(Place::Mm(hit.rest.to_array())), volume.or(shown)))
    }
}

fn ids(voxels: &OfVolumes) -> Vec<VolumeId> {
    voxels.iter().map(|(id, _)| *id).collect()
}

/// What is told of what is meant.
fn said(found: &Found) -> ComponentSaid {
    let of = |(volume, voxels): (VolumeId, u64)| ComponentOnSaid { volume, voxels };
    let volumes: Vec<_> = found.picked_voxels().into_iter().map(of).collect();
    ComponentSaid {
        volume: found.volume(),
        voxels: volumes.iter().map(|on| on.voxels).sum(),
        components: found.components.len(),
        mm3: found.amount(),
        pieces: None,
        volumes: if volumes.len() > 1 { volumes } else { Vec::new() },
        value: None,
        kept_locked: None,
        nothing: None,
    }
}

/// Bricks of a field with this texel in place of those of masks, but for those to be spared.
fn fill(
    field: &Field,
    voxels: &Voxels,
    texel: &[u8],
    spare: impl Fn(&[u8]) -> bool + Sync,
) -> Result<Changes, SourceError> {
    let one = |(index, mask): &(BrickIndex, BrickMask)| {
        let valid = field.valid(0, *index);
        let before = field.brick(BrickKey { level: 0, index: *index })?;
        let all = *mask == BrickMask::All && valid == [BRICK; 3];
        let new = match &before {
            Brick::Uniform(old) if old[..texel.len()] == *texel || spare(&old[..texel.len()]) => return Ok(None),
            Brick::Uniform(_) if all => Brick::Uniform(std::array::from_fn(|i| texel.get(i).copied().unwrap_or(0))),
            _ => filled(&before, mask, valid, texel, &spare),
        };
        Ok((new != before).then_some((*index, Some(new))))
    };
    Ok(voxels.par_iter().map(one).collect::<Result<Vec<_>, SourceError>>()?.into_iter().flatten().collect())
}

/// Gives density at these voxels a value that shows in none of their volumes; answers it.
fn remove(state: &mut State, removal: &Isolation, voxels: OfVolumes, edit: &mut Edit) -> Result<f64, DocumentError> {
    let value = match removal.value {
        Some(value) => finite("value", value)?,
        None => {
            let subjects = voxels.iter().map(|(id, _)| state.at(Some(*id)));
            value_of_nothing(&subjects.collect::<Result<Vec<_>, _>>()?)?
        }
    };
    let mut wider = Vec::new();
    for (id, _) in voxels.iter().filter(|(_, voxels)| !voxels.is_empty()) {
        wider.push(room_for(value, &state.at(Some(*id))?)?);
    }
    let all = ids(&voxels);
    let meant = voxels.into_iter().filter(|(_, voxels)| !voxels.is_empty());
    for ((id, voxels), (map, before, reach)) in meant.zip(wider) {
        if let Some(map) = map {
            edit.remap(state, id, map)?;
        }
        let density = &state.at(Some(id))?.volume.density;
        let texel = density.map().encode(value);
        let changes = fill(density, &voxels, &texel[..density.format().bytes()], |_| false)?;
        edit.swap_among(state, FieldKey::new(id, FieldKind::Density), changes, &all)?;
        if let Some(volume) = state.volumes.get_mut(&id) {
            volume.painted = Some(reach.within(before, &volume.density).0);
        }
    }
    Ok(value)
}

/// What density must be able to hold for a value, a brush knows that paints it: another map, if it needs one, and its reach before and
/// after.
fn room_for(value: f64, subject: &Subject<'_>) -> Result<(Option<DensityMap>, Reach, Reach), DocumentError> {
    let brush = Brush {
        target: Target::Density(value),
        operation: Operation::Replace,
        falloff: Falloff::Hard,
        range: None,
        ..Brush::default()
    };
    let volume = subject.volume;
    let before = match volume.painted {
        Some(reach) => Reach(reach),
        None => Reach::new([volume.histogram.min, volume.histogram.max], &volume.density)?,
    };
    let reach = before.after(&brush, &volume.density, 1.0);
    let wider = brush.map_for(&volume.density, &volume.statistics, 1.0);
    let map = brush.floats_for(wider.as_ref().unwrap_or(volume.density.map()), &volume.density, reach).or(wider);
    let held = map.as_ref().unwrap_or(volume.density.map());
    if !held.decode(held.encode(value)).is_finite() {
        let expected = "a value within 32-bit floats, which keep what is removed: up to 3.4e38 either way";
        return Err(DocumentError::invalid("value", format!("{value:e}"), expected));
    }
    Ok((map, before, reach))
}

/// A value of density that no look of these volumes shows: what the brush's erasing sets, the least, the greatest, or one between what shows.
fn value_of_nothing(subjects: &[Subject<'_>]) -> Result<f64, DocumentError> {
    let subject = subjects.first().ok_or(DocumentError::NoVolume)?;
    let erased = match subject.scene.brush.erase_density {
        EraseDensity::To(value) => Some(value),
        EraseDensity::Restore => None,
    };
    let labels: Vec<u16> = std::iter::once(0).chain(subject.segments().0.iter().map(|s| s.id)).collect();
    let ends = [subject.statistics.min, subject.statistics.max];
    let [least, most] = if ends[0] <= ends[1] { ends } else { [subject.histogram.min, subject.histogram.max] };
    let step = ((most - least) / 1024.0).max(f64::MIN_POSITIVE);
    let all = || subjects.iter().flat_map(|subject| labels.iter().map(move |label| (subject, *label)));
    let shown: Vec<[f64; 2]> = all().flat_map(|(subject, label)| subject.shown_values(label)).collect();
    let beside = shown.iter().flat_map(|[lo, hi]| [lo - step, hi + step, *lo - 1.0, *hi + 1.0]);
    // What a voxel will hold counts, rounded to its texel where there is a code for it.
    let held = |subject: &Subject<'_>, value: f64| {
        let map = subject.density.map();
        let kept = map.decode(map.encode(value));
        if (kept - value).abs() <= map.half_step() { kept } else { value }
    };
    let is_clear = |value: &f64| {
        value.is_finite()
            && all()
                .all(|(subject, label)| !subject.shows(*value, label) && !subject.shows(held(subject, *value), label))
    };
    erased.into_iter().chain([least, most]).chain(beside).find(is_clear).ok_or_else(|| {
        let expected = "a value for what is removed: every value shows under the present look";
        DocumentError::invalid("value", "none", expected)
    })
}

/// Selects these voxels. Where nothing else stays selected, that holds for all sub-volumes of the volume, also for those that are not seen.
fn select(
    state: &mut State,
    id: VolumeId,
    how: Joining,
    mut voxels: OfVolumes,
    edit: &mut Edit,
) -> Result<(), DocumentError> {
    let texel = if how == Joining::Subtract { 0 } else { u8::MAX };
    if how == Joining::Replace {
        let named = ids(&voxels);
        let hidden = state.scene.cut_out_of(id).into_iter().filter(|inner| !named.contains(inner));
        voxels.extend(hidden.map(|inner| (inner, Voxels::new())));
    }
    let all = ids(&voxels);
    for (id, voxels) in voxels {
        let selection = &state.at(Some(id))?.volume.selection;
        let changes = match how {
            Joining::Add | Joining::Subtract => fill(selection, &voxels, &[texel], |_| false)?,
            Joining::Replace => {
                let blank = Brick::Uniform([0; 4]);
                let new = |(index, mask): &(BrickIndex, BrickMask)| {
                    (*index, Some(filled(&blank, mask, selection.valid(0, *index), &[texel], |_| false)))
                };
                selection.replaced_by(voxels.par_iter().map(new).collect())
            }
        };
        edit.swap_among(state, FieldKey::new(id, FieldKind::Selection), changes, &all)?;
    }
    Ok(())
}

/// Labels these voxels but for those of locked segments; answers how many these are.
fn relabel(state: &mut State, label: u16, voxels: &OfVolumes, edit: &mut Edit) -> Result<u64, DocumentError> {
    let (kept, all) = (AtomicU64::new(0), ids(voxels));
    for (id, voxels) in voxels {
        let subject = state.at(Some(*id))?;
        let segments = subject.segments().0.iter();
        let locked: Vec<[u8; 2]> = segments.filter(|s| s.locked && s.id != label).map(|s| s.id.to_le_bytes()).collect();
        let labels = &subject.volume.labels;
        let changes = fill(labels, voxels, &label.to_le_bytes(), |texel| locked.iter().any(|l| l == texel))?;
        if !locked.is_empty() {
            voxels.par_iter().try_for_each(|(index, mask)| -> Result<(), SourceError> {
                let valid = labels.valid(0, *index);
                let brick = labels.brick(BrickKey { level: 0, index: *index })?;
                let of_locked = BrickMask::new(valid, |at| locked.iter().any(|l| *l == brick.texel(at, 2)[..2]));
                kept.fetch_add(of_locked.and(mask.clone(), valid).count(valid), Ordering::Relaxed);
                Ok(())
            })?;
        }
        if let Some(segments) = state.scene.segments_mut(*id)
            && !changes.is_empty()
        {
            segments.ensure(label);
        }
        edit.swap_among(state, FieldKey::new(*id, FieldKind::Labels), changes, &all)?;
    }
    Ok(kept.into_inner())
}
