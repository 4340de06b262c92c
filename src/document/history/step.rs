//! One step of history: what it holds is what comes back, and exchanging it leaves what was there before.
//!
//! So undo and redo are the same swap. A step holds only what changed of what was decided: components of the scene, bricks of
//! fields, and the density's map when painting widened it. Where a simulation took the parts is in no step.

use crate::document::command::resolved::{ResolvedCommand, join};
use crate::document::disk::source_files::SourceFiles;
use crate::document::scene::components::TakenBackBy;
use crate::document::scene::volumes::VolumeLook;
use crate::document::scene::{Components, Scene};
use crate::document::state::State;
use crate::volume::{
    Brick, BrickIndex, Changes, DensityMap, Field, FieldKey, FieldKind, Refresh, SourceError, Volume, VolumeId,
};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The components of a scene that undo knows; views and looks have a past of their own, the brush has none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct SceneDelta {
    held: Components,
    /// How volumes are shown, of those that the step itself shows otherwise; `None` where there was no such volume.
    shown: BTreeMap<VolumeId, Option<VolumeLook>>,
}

impl SceneDelta {
    /// What `before` holds where `after` differs from it; how volumes are shown only `with_looks`.
    pub(crate) fn between(before: &Scene, after: &Scene, with_looks: bool) -> Self {
        let mut delta = Self { held: Components::of(before, TakenBackBy::Undo), ..Self::default() };
        if with_looks {
            let ids: BTreeSet<VolumeId> = before.shown.keys().chain(after.shown.keys()).copied().collect();
            delta.shown = ids.into_iter().map(|id| (id, before.shown.get(&id).cloned())).collect();
        }
        delta.prune(after);
        delta
    }

    /// Forgets what the scene holds anyway.
    fn prune(&mut self, scene: &Scene) {
        self.held.prune(scene);
        self.shown.retain(|id, held| held.as_ref() != scene.shown.get(id));
    }

    fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Whether it holds parts, degree and forces.
    pub(crate) fn has_explosion(&self) -> bool {
        self.held.explosion.is_some()
    }

    /// Exchanges what it holds with what the scene holds.
    pub(crate) fn exchange(&mut self, scene: &mut Scene) {
        self.held.exchange(scene);
        for (id, held) in &mut self.shown {
            let now = scene.shown.remove(id);
            if let Some(look) = std::mem::replace(held, now) {
                scene.shown.insert(*id, look);
            }
        }
    }

    /// Joins a later delta: what was there first comes back.
    fn absorb(&mut self, later: Self) {
        self.held.absorb(later.held);
        for (id, held) in later.shown {
            self.shown.entry(id).or_insert(held);
        }
    }
}

/// What an exchange made new, for whoever mirrors fields.
#[derive(Clone, Debug, Default)]
pub(crate) struct Refreshed {
    /// Slots by field.
    pub slots: Vec<(FieldKey, Refresh)>,
    /// Bricks of level 0 whose own texels may be new.
    pub bricks: Vec<(FieldKey, BrickIndex)>,
    /// Volumes whose density got another map: all of its texels are new.
    pub remapped: BTreeSet<VolumeId>,
    /// Volumes that came or went: all of them is new.
    pub exchanged: BTreeSet<VolumeId>,
    /// Whether the GPU's slots hold it already: a stroke painted them.
    pub painted: bool,
}

impl Refreshed {
    /// Adds what a later exchange made new.
    pub(crate) fn join(&mut self, later: Self) {
        self.slots.extend(later.slots);
        self.bricks.extend(later.bricks);
        self.remapped.extend(later.remapped);
        self.exchanged.extend(later.exchanged);
    }
}

/// A volume that came or went, without what was painted on it.
#[derive(Clone, Debug)]
pub(crate) struct Bare {
    pub volume: Volume,
    pub files: Option<Arc<SourceFiles>>,
}

/// Bricks of level 0 by field; `None` is an unedited one.
type Bricks = BTreeMap<(FieldKey, BrickIndex), Option<Brick>>;

impl Bare {
    /// A volume of that name with all that is painted on it, as what it is without and that.
    pub(crate) fn apart(self, id: VolumeId) -> (Self, Bricks) {
        let volume = self.volume.unedited(*self.volume.density.map());
        let edits = FieldKind::ALL.into_iter().flat_map(|kind| {
            let key = FieldKey::new(id, kind);
            self.volume.field(kind).edits().into_iter().map(move |(index, brick)| ((key, index), Some(brick.clone())))
        });
        let bricks = edits.collect();
        (Self { volume, files: self.files }, bricks)
    }
}

/// What one step holds: parts of the scene, bricks of level 0 by field, maps of density, the commands that made it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Step {
    /// What the user did.
    pub name: String,
    /// The same as commands that can be done again elsewhere, in order.
    pub commands: Vec<ResolvedCommand>,
    /// Scene.
    pub scene: SceneDelta,
    /// Bricks of level 0; `None` is an unedited one.
    pub bricks: Bricks,
    /// With a map, the volume's density bricks above are all of its edits.
    pub maps: BTreeMap<VolumeId, DensityMap>,
    /// Volumes as a whole: one that comes, or takes the place of another of its name, its edits above; `None` where one goes.
    pub volumes: BTreeMap<VolumeId, Option<Bare>>,
}

/// How to take back a part of an exchange that fails later.
enum Done {
    Swapped(FieldKey),
    Mapped(VolumeId, DensityMap),
}

impl Step {
    /// Whether it would change nothing.
    pub(crate) fn is_empty(&self) -> bool {
        self.scene.is_empty() && self.bricks.is_empty() && self.maps.is_empty() && self.volumes.is_empty()
    }

    /// Exchanges what it holds with what the state holds.
    ///
    /// # Errors
    /// If the source fails; state and step are then as they were.
    pub(crate) fn exchange(&mut self, state: &mut State) -> Result<Refreshed, SourceError> {
        let mut refreshed = Refreshed::default();
        let (mut came, mut replaced) = (Vec::new(), BTreeMap::new());
        for (&id, bare) in &self.volumes {
            refreshed.exchanged.insert(id);
            if let Some(bare) = bare {
                match detach(state, id) {
                    Some(there) => drop(replaced.insert(id, there)),
                    None => came.push(id),
                }
                attach(state, id, bare.clone());
            }
        }
        let changes = self.changes(state);
        let mut held = BTreeMap::new();
        let mut done = Vec::new();
        for (key, changes) in changes {
            match self.swap(state, key, changes, &mut refreshed) {
                Ok((before, how)) => {
                    done.push(how);
                    held.extend(before.into_iter().map(|(index, brick)| ((key, index), brick)));
                }
                Err(error) => {
                    for how in done {
                        take_back(state, how, &held)?;
                    }
                    for id in came {
                        detach(state, id);
                    }
                    for (id, there) in replaced {
                        attach(state, id, there);
                    }
                    return Err(error);
                }
            }
        }
        for how in done {
            if let Done::Mapped(id, old) = how {
                self.maps.insert(id, old);
                refreshed.remapped.insert(id);
            }
        }
        // Of what was put in a volume's place is held what was there, all of it.
        held.retain(|(key, _), _| !replaced.contains_key(&key.volume));
        for (id, volume) in &mut self.volumes {
            if came.contains(id) {
                *volume = None;
                continue;
            }
            // It goes with the map that it has.
            self.maps.remove(id);
            *volume = match replaced.remove(id) {
                Some(there) => {
                    let (bare, bricks) = there.apart(*id);
                    held.extend(bricks);
                    Some(bare)
                }
                None => detach(state, *id),
            };
        }
        refreshed.bricks = held.keys().copied().collect();
        self.bricks = held;
        self.scene.exchange(&mut state.scene);
        Ok(refreshed)
    }

    /// What is to be swapped, field by field. Density last: only it has a source that can fail, and a map that is exchanged as a
    /// whole. A volume that goes leaves all that was painted on it.
    fn changes(&self, state: &State) -> Vec<(FieldKey, Changes)> {
        let mut by_field: BTreeMap<FieldKey, Changes> = BTreeMap::new();
        for (&(key, index), brick) in &self.bricks {
            by_field.entry(key).or_default().push((index, brick.clone()));
        }
        for id in self.maps.keys() {
            by_field.entry(FieldKey::new(*id, FieldKind::Density)).or_default();
        }
        for (&id, bare) in &self.volumes {
            let Some(volume) = state.volumes.get(&id).filter(|_| bare.is_none()) else { continue };
            for kind in FieldKind::ALL {
                let gone = volume.field(kind).edits().into_keys().map(|index| (index, None)).collect();
                by_field.insert(FieldKey::new(id, kind), gone);
            }
        }
        by_field.retain(|key, changes| {
            state.volumes.contains_key(&key.volume) && (!changes.is_empty() || self.maps.contains_key(&key.volume))
        });
        let mut all: Vec<_> = by_field.into_iter().collect();
        all.sort_by_key(|(key, _)| key.kind == FieldKind::Density);
        all
    }

    fn swap(
        &self,
        state: &mut State,
        key: FieldKey,
        changes: Changes,
        refreshed: &mut Refreshed,
    ) -> Result<(Changes, Done), SourceError> {
        let Some(volume) = state.volumes.get_mut(&key.volume) else { return Ok((Vec::new(), Done::Swapped(key))) };
        let goes = self.volumes.get(&key.volume).is_some_and(Option::is_none);
        match self.maps.get(&key.volume) {
            Some(map) if key.kind == FieldKind::Density && !goes => {
                let (old, before) = remap(&mut volume.density, *map, changes)?;
                Ok((before, Done::Mapped(key.volume, old)))
            }
            _ => {
                let (before, refresh) = volume.field_mut(key.kind).swap(changes)?;
                refreshed.slots.push((key, refresh));
                Ok((before, Done::Swapped(key)))
            }
        }
    }

    /// Joins a step that came after this one; what was there first comes back.
    pub(crate) fn absorb(&mut self, later: Self) {
        self.name = later.name;
        join(&mut self.commands, later.commands);
        self.scene.absorb(later.scene);
        let density = |key: &FieldKey| key.kind == FieldKind::Density;
        let whole: BTreeSet<VolumeId> = self.maps.keys().copied().collect();
        // A volume that comes back comes with all that it had; what was done later to another of its name is nothing to it, and
        // nothing to one that was not there.
        let as_a_whole: BTreeSet<VolumeId> = self.volumes.keys().copied().collect();
        for (key, brick) in later.bricks {
            let volume = key.0.volume;
            if !(as_a_whole.contains(&volume) || density(&key.0) && whole.contains(&volume)) {
                self.bricks.entry(key).or_insert(brick);
            }
        }
        for (id, map) in later.maps {
            if whole.contains(&id) || as_a_whole.contains(&id) {
                continue;
            }
            // The later list is all edits; ours say what some of those were still earlier.
            self.maps.insert(id, map);
            self.bricks.retain(|(key, _), brick| !(density(key) && key.volume == id) || brick.is_some());
        }
        for (id, bare) in later.volumes {
            self.volumes.entry(id).or_insert(bare);
        }
    }

    /// Forgets what the state holds anyway.
    pub(crate) fn prune(&mut self, state: &State) {
        self.scene.prune(&state.scene);
        // What came and went again was never there.
        let never: BTreeSet<VolumeId> =
            self.volumes.iter().filter(|(_, bare)| bare.is_none()).map(|(id, _)| *id).collect();
        let never = |id: &VolumeId| never.contains(id) && !state.volumes.contains_key(id);
        self.volumes.retain(|id, _| !never(id));
        self.maps.retain(|id, _| !never(id));
        self.bricks.retain(|(key, _), _| !never(&key.volume));
        let (maps, volumes) = (&self.maps, &self.volumes);
        self.bricks.retain(|&(key, index), brick| {
            let whole = maps.contains_key(&key.volume) && key.kind == FieldKind::Density;
            let here = || state.field(key).and_then(|field| field.edit(index));
            whole || volumes.contains_key(&key.volume) || here() != brick.as_ref()
        });
    }
}

fn attach(state: &mut State, id: VolumeId, bare: Bare) {
    state.volumes.insert(id, bare.volume);
    if let Some(files) = bare.files {
        state.files.insert(id, files);
    }
}

fn detach(state: &mut State, id: VolumeId) -> Option<Bare> {
    let files = state.files.remove(&id);
    state.volumes.remove(&id).map(|volume| Bare { volume, files })
}

/// Takes back what a part of an exchange did.
fn take_back(
    state: &mut State,
    how: Done,
    held: &BTreeMap<(FieldKey, BrickIndex), Option<Brick>>,
) -> Result<(), SourceError> {
    let of = |wanted: FieldKey| -> Changes {
        held.iter().filter(|((key, _), _)| *key == wanted).map(|((_, index), brick)| (*index, brick.clone())).collect()
    };
    match how {
        Done::Swapped(key) => {
            if let Some(volume) = state.volumes.get_mut(&key.volume) {
                volume.field_mut(key.kind).swap(of(key))?;
            }
        }
        Done::Mapped(id, map) => {
            if let Some(volume) = state.volumes.get_mut(&id) {
                remap(&mut volume.density, map, of(FieldKey::new(id, FieldKind::Density)))?;
            }
        }
    }
    Ok(())
}

/// Gives the density another map and other edits, all of them; answers with the ones before.
pub(crate) fn remap(
    density: &mut Field,
    map: DensityMap,
    edits: Changes,
) -> Result<(DensityMap, Changes), SourceError> {
    let Some(mut next) = density.unedited(map, &|_| true)? else { return Ok((*density.map(), Vec::new())) };
    next.swap(edits)?;
    let before = density.edits().into_iter().map(|(i, b)| (i, Some(b.clone()))).collect();
    let old = *density.map();
    *density = next;
    Ok((old, before))
}
