//! Commands on what is connected: which voxels those are, and what becomes of them.
//!
//! What is connected is found in the whole region that is meant and decided by [`Components`] alone. Only bricks in which something
//! becomes other are exchanged, so that undoing costs what changed.

use crate::document::Document;
use crate::document::apply::matter::{Meant, filled};
use crate::document::command::Place;
use crate::document::command::answers::{ComponentSaid, Said};
use crate::document::command::component::{
    ComponentCommand, Connected, Isolation, Joining, Labelling, Matter, Selecting, Within,
};
use crate::document::error::DocumentError;
use crate::document::history::edit::Edit;
use crate::document::place::nothing_there;
use crate::document::reduce::place::place_in;
use crate::document::scene::check::finite;
use crate::document::state::State;
use crate::document::subject::Subject;
use crate::math::{DVec2, DVec3};
use crate::paint::{Brush, EraseDensity, Falloff, Operation, Reach, Target};
use crate::segment::{BrickMask, ComponentId, Components, Connectivity};
use crate::volume::{
    BRICK, Brick, BrickIndex, BrickKey, Changes, Field, FieldKey, FieldKind, Grid, SourceError, VolumeId,
};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

/// What is connected, and which of it was picked.
struct Found {
    components: Components,
    picked: ComponentId,
}

impl Document {
    pub(crate) fn component(&mut self, command: &ComponentCommand, edit: &mut Edit) -> Result<Said, DocumentError> {
        let watch = self.watch.clone();
        let state = self.open_mut()?;
        let connected = command.connected();
        let subject = state.at(connected.volume)?;
        let id = subject.id;
        let selected = match command {
            // What is selected does not keep more from being selected.
            ComponentCommand::Select(_) => Within::Volume,
            _ if subject.selection.extremes()[1] >= 0.5 => Within::Selection,
            _ => Within::Volume,
        };
        let found = find(&subject, &connected, connected.within.unwrap_or(selected), &|x| watch.proceed(x * 0.9))?;
        let said = ComponentSaid {
            volume: id,
            voxels: found.components.size(found.picked),
            components: found.components.len(),
            value: None,
            kept_locked: None,
            nothing: None,
        };
        let (said, nothing) = match command {
            ComponentCommand::Keep(removal) => {
                let value = remove(state, id, removal, found.voxels(false), edit)?;
                (
                    ComponentSaid { value: Some(value), ..said },
                    "All of it is connected: there is nothing else to remove.",
                )
            }
            ComponentCommand::Remove(removal) => {
                let value = remove(state, id, removal, found.voxels(true), edit)?;
                (ComponentSaid { value: Some(value), ..said }, "It has the value that removes already.")
            }
            ComponentCommand::Select(Selecting { how, .. }) => {
                select(state, id, *how, found.voxels(true), edit)?;
                (said, "The selection is so already.")
            }
            ComponentCommand::Label(Labelling { label, .. }) => {
                let kept_locked = relabel(state, id, *label, &found.voxels(true), edit)?;
                let said = ComponentSaid { kept_locked: Some(kept_locked), ..said };
                let nothing = match (kept_locked, label) {
                    (0, 0) => "It has no label.",
                    (0, _) => "It has that label already.",
                    _ => "The segment that is there is locked.",
                };
                (said, nothing)
            }
        };
        let nothing = (edit.counts().0 == 0).then_some(nothing);
        Ok(ComponentSaid { nothing, ..said }.into())
    }

    /// The command with a pixel of the 3D view put in mm, and the volume that shows there named where none is.
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
        Ok(command.put(Some(Place::Mm(hit.rest.to_array())), volume.or(hit.object.volume())))
    }
}

impl Found {
    /// The voxels of the picked component, or those of all others.
    fn voxels(&self, picked: bool) -> Vec<(BrickIndex, BrickMask)> {
        self.components.voxels(|id| (id == self.picked) == picked)
    }
}

/// What is connected where the command says, and which of it is at its place.
fn find(
    subject: &Subject<'_>,
    connected: &Connected,
    within: Within,
    progress: &(dyn Fn(f32) -> bool + Sync),
) -> Result<Found, DocumentError> {
    if let Matter::Range([lo, hi]) = connected.matter
        && (lo.is_nan() || hi.is_nan() || lo > hi)
    {
        let found = format!("[{lo}, {hi}]");
        return Err(DocumentError::invalid("matter.range", found, "two values, the smaller first"));
    }
    if let Within::Segment(label) = within
        && label != 0
        && subject.segments().get(label).is_none()
    {
        return Err(DocumentError::no_segment("within.segment", label, subject.segments()));
    }
    let connectivity = match u8::from(connected.neighbours) {
        18 => Connectivity::Eighteen,
        26 => Connectivity::TwentySix,
        _ => Connectivity::Six,
    };
    let meant = Meant::new(*subject, connected.matter, within);
    let count = subject.density.brick_indices(0).len().max(1) as f32;
    let done = AtomicUsize::new(0);
    let components = Components::new(subject.grid().dims, connectivity, |index| {
        match progress(done.fetch_add(1, Ordering::Relaxed) as f32 / count) {
            true => Ok(meant.mask(index)?),
            false => Err(DocumentError::Stopped),
        }
    })?;
    let what = match connected.matter {
        Matter::Visible => "matter that the 3D view shows",
        Matter::Range(_) => "voxels of the range",
        Matter::Everything => "voxels",
    };
    let place = match within {
        Within::Volume => String::new(),
        Within::Selection => " in what is selected (\"within\": \"volume\" leaves the selection aside)".into(),
        Within::Segment(label) => format!(" in segment {label}"),
    };
    let picked = match connected.at {
        Some(at) => nearest(subject, &components, at)?
            .ok_or_else(|| DocumentError::invalid("at", serde_json::json!(at), format!("a place at {what}{place}")))?,
        None => {
            components.largest().ok_or_else(|| DocumentError::invalid("matter", "none", format!("{what}{place}")))?
        }
    };
    Ok(Found { components, picked })
}

/// The component at a place: that of the voxel which holds it, or else of the nearest of the eight that are mixed there. What a pixel
/// shows may lie between voxels of which not all show.
fn nearest(subject: &Subject<'_>, components: &Components, at: Place) -> Result<Option<ComponentId>, DocumentError> {
    let Some(sample) = place_in(at, subject.scene, subject.grid())? else {
        return Err(DocumentError::of_picture("at"));
    };
    Ok(component_near(subject.grid(), components, sample.position))
}

/// The component of the voxel at a place in the world, or else of the nearest of the eight about it that has one.
pub(super) fn component_near(grid: &Grid, components: &Components, place: DVec3) -> Option<ComponentId> {
    let index = grid.index_from_world().transform_point3(place);
    let voxel = |at: DVec3| grid.voxel_at(at);
    if let Some(own) = voxel(index).and_then(|v| components.at(v)) {
        return Some(own);
    }
    let base = index.floor();
    let corner = |n: u32| base + DVec3::new(f64::from(n & 1), f64::from(n >> 1 & 1), f64::from(n >> 2));
    let mut corners: Vec<DVec3> = (0..8).map(corner).collect();
    corners.sort_by(|a, b| a.distance_squared(index).total_cmp(&b.distance_squared(index)));
    corners.into_iter().find_map(|corner| components.at(voxel(corner)?))
}

type Voxels = Vec<(BrickIndex, BrickMask)>;

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

/// Gives density at these voxels a value that does not show; answers it.
fn remove(
    state: &mut State,
    id: VolumeId,
    removal: &Isolation,
    voxels: Voxels,
    edit: &mut Edit,
) -> Result<f64, DocumentError> {
    let subject = state.at(Some(id))?;
    let value = match removal.value {
        Some(value) => finite("value", value)?,
        None => value_of_nothing(&subject)?,
    };
    if voxels.is_empty() {
        return Ok(value);
    }
    // What density must be able to hold for it, a brush knows that paints it.
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
    if let Some(map) = map {
        edit.remap(state, id, map)?;
    }
    let density = &state.at(Some(id))?.volume.density;
    let texel = density.map().encode(value);
    let changes = fill(density, &voxels, &texel[..density.format().bytes()], |_| false)?;
    edit.swap(state, FieldKey::new(id, FieldKind::Density), changes)?;
    if let Some(volume) = state.volumes.get_mut(&id) {
        volume.painted = Some(reach.within(before, &volume.density).0);
    }
    Ok(value)
}

/// A value of density that no look shows: what the brush's erasing sets, the least, the greatest, or one between what shows.
fn value_of_nothing(subject: &Subject<'_>) -> Result<f64, DocumentError> {
    let erased = match subject.scene.brush.erase_density {
        EraseDensity::To(value) => Some(value),
        EraseDensity::Restore => None,
    };
    let labels: Vec<u16> = std::iter::once(0).chain(subject.segments().0.iter().map(|s| s.id)).collect();
    let ends = [subject.statistics.min, subject.statistics.max];
    let [least, most] = if ends[0] <= ends[1] { ends } else { [subject.histogram.min, subject.histogram.max] };
    let step = ((most - least) / 1024.0).max(f64::MIN_POSITIVE);
    let shown: Vec<[f64; 2]> = labels.iter().flat_map(|&label| subject.shown_values(label)).collect();
    let beside = shown.iter().flat_map(|[lo, hi]| [lo - step, hi + step, *lo - 1.0, *hi + 1.0]);
    let density = &subject.density;
    // What a voxel will hold counts, rounded to its texel where there is a code for it.
    let held = |value: f64| {
        let map = density.map();
        let kept = map.decode(map.encode(value));
        if (kept - value).abs() <= map.half_step() { kept } else { value }
    };
    let is_clear = |value: &f64| {
        value.is_finite()
            && labels.iter().all(|&label| !subject.shows(*value, label) && !subject.shows(held(*value), label))
    };
    erased.into_iter().chain([least, most]).chain(beside).find(is_clear).ok_or_else(|| {
        let expected = "a value for what is removed: every value shows under the present look";
        DocumentError::invalid("value", "none", expected)
    })
}

/// Selects these voxels.
fn select(state: &mut State, id: VolumeId, how: Joining, voxels: Voxels, edit: &mut Edit) -> Result<(), DocumentError> {
    let selection = &state.at(Some(id))?.volume.selection;
    let texel = if how == Joining::Subtract { 0 } else { u8::MAX };
    let changes = match how {
        Joining::Add | Joining::Subtract => fill(selection, &voxels, &[texel], |_| false)?,
        Joining::Replace => {
            let blank = Brick::Uniform([0; 4]);
            let new = |(index, mask): &(BrickIndex, BrickMask)| {
                (*index, Some(filled(&blank, mask, selection.valid(0, *index), &[texel], |_| false)))
            };
            let mut changes: Changes = voxels.par_iter().map(new).collect();
            let given: std::collections::BTreeSet<BrickIndex> = changes.iter().map(|(index, _)| *index).collect();
            let gone = selection.present().into_iter().filter(|index| !given.contains(index));
            changes.extend(gone.map(|index| (index, selection.nothing())));
            changes
        }
    };
    Ok(edit.swap(state, FieldKey::new(id, FieldKind::Selection), changes)?)
}

/// Labels these voxels but for those of locked segments; answers how many these are.
fn relabel(
    state: &mut State,
    id: VolumeId,
    label: u16,
    voxels: &Voxels,
    edit: &mut Edit,
) -> Result<u64, DocumentError> {
    let subject = state.at(Some(id))?;
    let locked: Vec<[u8; 2]> =
        subject.segments().0.iter().filter(|s| s.locked && s.id != label).map(|s| s.id.to_le_bytes()).collect();
    let labels = &subject.volume.labels;
    let changes = fill(labels, voxels, &label.to_le_bytes(), |texel| locked.iter().any(|l| l == texel))?;
    let kept = AtomicU64::new(0);
    if !locked.is_empty() {
        voxels.par_iter().try_for_each(|(index, mask)| -> Result<(), SourceError> {
            let valid = labels.valid(0, *index);
            let brick = labels.brick(BrickKey { level: 0, index: *index })?;
            let of_locked = BrickMask::new(valid, |at| locked.iter().any(|l| *l == brick.texel(at, 2)[..2]));
            kept.fetch_add(of_locked.and(mask.clone(), valid).count(valid), Ordering::Relaxed);
            Ok(())
        })?;
    }
    if let Some(segments) = state.scene.segments_mut(id)
        && !changes.is_empty()
    {
        segments.ensure(label);
    }
    edit.swap(state, FieldKey::new(id, FieldKind::Labels), changes)?;
    Ok(kept.into_inner())
}
