//! What a journal's records lead to: the scene by its fields' names, the maps of densities, the past, and which volumes came or went.
//!
//! Owns what is to be told of a state that differs from it. Knows no file: records are taken in and given out.

use crate::document::disk::error::KeepError;
use crate::document::journal::record::StepHead;
use crate::document::project::link::Link;
use crate::document::project::manifest::{DensityPlace, Manifest, VolumeRecord};
use crate::document::scene::Scene;
use crate::document::scene::past::Past;
use crate::document::state::State;
use crate::volume::{DensityMap, VolumeId};
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};

/// What the records of a journal lead to so far, on top of what its generation holds.
#[derive(Debug)]
pub(crate) struct Now {
    /// The scene's fields by name.
    scene: Map<String, Value>,
    maps: BTreeMap<VolumeId, DensityMap>,
    past: Past,
    /// Volumes whose density the generation holds.
    held: BTreeSet<VolumeId>,
    /// What of scene, maps and volumes differs from the generation's.
    pub changed: Map<String, Value>,
    pub new_maps: BTreeMap<VolumeId, DensityMap>,
    pub volumes: BTreeMap<VolumeId, Option<VolumeRecord>>,
    /// Whether the past differs too.
    pub new_past: bool,
    pub steps: u64,
    pub last: Value,
}

/// What a journal begins with: what its generation holds.
#[derive(Debug)]
pub(crate) struct Beginning<'a> {
    pub generation: u64,
    pub scene: &'a Scene,
    pub past: &'a Past,
    pub maps: BTreeMap<VolumeId, DensityMap>,
    /// Volumes whose density lies in the generation.
    pub held: BTreeSet<VolumeId>,
}

impl<'a> Beginning<'a> {
    /// That of a generation.
    pub(crate) fn of(manifest: &'a Manifest) -> Self {
        let Manifest { generation, scene, past, .. } = manifest;
        Self { generation: *generation, scene, past, maps: manifest.maps(), held: manifest.holds() }
    }
}

impl Now {
    pub(crate) fn new(beginning: Beginning<'_>) -> Result<Self, KeepError> {
        let Beginning { scene, past, maps, held, .. } = beginning;
        Ok(Self {
            scene: parts(scene)?,
            maps,
            past: past.clone(),
            held,
            changed: Map::new(),
            new_maps: BTreeMap::new(),
            volumes: BTreeMap::new(),
            new_past: false,
            steps: 0,
            last: Value::Null,
        })
    }

    /// The past now.
    pub(crate) fn past(&self) -> &Past {
        &self.past
    }

    /// The scene now, by the names of its parts.
    pub(crate) fn scene(&self) -> &Map<String, Value> {
        &self.scene
    }

    /// The map of a volume's density now.
    pub(crate) fn map(&self, volume: VolumeId) -> Option<&DensityMap> {
        self.maps.get(&volume)
    }

    /// Takes in a record's head.
    pub(crate) fn take(&mut self, head: StepHead) {
        self.scene.extend(head.scene.clone());
        self.changed.extend(head.scene);
        for (id, volume) in head.volumes {
            match &volume {
                Some(record) => drop(self.maps.insert(id, record.map)),
                None => drop(self.maps.remove(&id)),
            }
            self.new_maps.remove(&id);
            self.volumes.insert(id, volume);
        }
        self.new_maps.extend(&head.maps);
        self.maps.extend(head.maps);
        if let Some(delta) = head.past {
            delta.apply(&mut self.past);
            self.new_past = true;
        }
        self.steps += head.steps;
        if !head.command.is_null() {
            self.last = head.command;
        }
    }

    /// What is to be written of volumes that came or went, and of maps that are other ones. `exchanged` are volumes that are perhaps
    /// not what they were though there was one of their name before.
    pub(super) fn difference(
        &self,
        state: &State,
        exchanged: &BTreeSet<VolumeId>,
    ) -> Result<(Arrivals, BTreeMap<VolumeId, DensityMap>), KeepError> {
        let mut volumes = Arrivals::new();
        for id in self.maps.keys().filter(|id| !state.volumes.contains_key(id)) {
            volumes.insert(*id, None);
        }
        let mut maps = BTreeMap::new();
        for (&id, volume) in &state.volumes {
            let nowhere = DensityPlace::nowhere(state, id, volume);
            // Sub-volumes, and what they are computed from, are exchanged for others of their names.
            let is_other = nowhere.is_some() && exchanged.contains(&id);
            match self.maps.get(&id).filter(|_| !is_other) {
                Some(map) if map == volume.density.map() => {}
                Some(_) => drop(maps.insert(id, *volume.density.map())),
                None => {
                    let kept = match state.files.get(&id) {
                        _ if nowhere.is_some() => nowhere.unwrap_or(DensityPlace::Whole),
                        _ if self.held.contains(&id) => DensityPlace::Whole,
                        Some(files) => DensityPlace::Linked(Link::until_next_start(files.files())?),
                        None => return Err(KeepError::NoPath),
                    };
                    volumes.insert(id, Some(VolumeRecord::of(volume, kept, BTreeMap::new())));
                }
            }
        }
        Ok((volumes, maps))
    }
}

/// Volumes that came, and `None` for those that went.
pub(super) type Arrivals = BTreeMap<VolumeId, Option<VolumeRecord>>;

/// The scene's fields by name.
pub(super) fn parts(scene: &Scene) -> Result<Map<String, Value>, KeepError> {
    match serde_json::to_value(scene) {
        Ok(Value::Object(parts)) => Ok(parts),
        Ok(_) => Err(KeepError::Scene { reason: "it is no object".into() }),
        Err(error) => Err(KeepError::Scene { reason: error.to_string() }),
    }
}
