//! A document as it was kept: a generation with its journal laid over it, ready to become a [`State`] again.

use crate::document::disk::error::KeepError;
use crate::document::disk::source_files::SourceFiles;
use crate::document::error::DocumentError;
use crate::document::journal::replay::Replay;
use crate::document::project::fields::Edits;
use crate::document::project::manifest::VolumeRecord;
use crate::document::project::read::{Loaded, LoadedDensity, LoadedVolume, density_of};
use crate::document::scene::kept_poses::{SavedPoses, poses_of_before};
use crate::document::scene::past::Past;
use crate::document::scene::volumes::VolumeSettings;
use crate::document::scene::{Origin, Scene};
use crate::document::state::State;
use crate::paint::Sample;
use crate::volume::{
    BRICK, BrickIndex, BrickSource, DensityMap, FieldKind, Grid, Histogram, Statistics, SubBox, Volume, VolumeId,
};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A volume as it was kept.
#[derive(Clone, Debug)]
pub struct RestoredVolume {
    /// As its source calls it.
    pub name: String,
    /// The lattice, where its source has it.
    pub grid: Grid,
    /// How density becomes texels.
    pub map: DensityMap,
    /// Of the source's values.
    pub statistics: Statistics,
    /// Of the source's values.
    pub histogram: Histogram,
    /// Where unedited density is.
    pub density: LoadedDensity,
    /// The files of a linked density; their hash is being compared.
    pub files: Option<Arc<SourceFiles>>,
    /// Edited bricks of each field.
    pub edits: BTreeMap<FieldKind, Edits>,
}

/// A document as it was kept, before its sources are opened: scene, painted bricks, and where density comes from.
#[derive(Clone, Debug)]
pub struct RestoredDocument {
    /// Everything but voxels.
    pub scene: Scene,
    /// Earlier views and looks.
    pub past: Past,
    /// Where forces had taken the parts.
    pub poses: SavedPoses,
    /// The volumes.
    pub volumes: BTreeMap<VolumeId, RestoredVolume>,
    /// What came back from the journal.
    pub recovered: Recovered,
}

/// What was done after the last save.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recovered {
    /// Commands.
    pub steps: u64,
    /// The last of them as JSON, its places in world millimetres; `null` if there is none.
    pub last: Value,
    /// Samples of the stroke that was running; painting them with the scene's brush finishes it. Say `no_stroke` to the keeper if
    /// that is not wanted.
    pub stroke: Vec<Sample>,
    /// What it painted; empty if none was running.
    pub stroke_volumes: Vec<VolumeId>,
    /// Bytes at the journal's end that were no whole step: the one that was being written.
    pub torn_bytes: u64,
    /// Where a damaged journal was put, and what is wrong with it.
    pub set_aside: Option<(PathBuf, String)>,
    /// What the user should know of the project besides, in sentences.
    pub told: Vec<String>,
}

impl RestoredVolume {
    fn new(
        record: &VolumeRecord,
        (density, files): (LoadedDensity, Option<Arc<SourceFiles>>),
        edits: BTreeMap<FieldKind, Edits>,
    ) -> Self {
        let (grid, statistics, histogram) = (record.grid(), record.statistics(), record.histogram());
        Self { name: record.name.clone(), grid, map: record.map, statistics, histogram, density, files, edits }
    }

    /// The volume again; `open` reads the file that its density is linked to.
    fn into_volume(
        self,
        (id, built): (VolumeId, &BTreeMap<VolumeId, Volume>),
        open: impl FnOnce() -> Result<Arc<dyn BrickSource>, DocumentError>,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<Volume, DocumentError> {
        let whole = |source: Arc<dyn BrickSource>| {
            let (statistics, histogram) = (self.statistics, self.histogram.clone());
            Volume::new(source, self.map, statistics, histogram, progress)?.ok_or(DocumentError::Stopped)
        };
        let unread = |field: &str, found: String| {
            KeepError::malformed(Path::new(&self.name), field, found, "a volume of the project, as large as it says")
        };
        let mut volume = match &self.density {
            LoadedDensity::Whole(source) => whole(source.clone())?,
            LoadedDensity::Linked(path) => {
                let source = open()?;
                if source.grid().dims != self.grid.dims {
                    let (found, expected) = (format!("{:?}", source.grid().dims), format!("{:?}", self.grid.dims));
                    return Err(KeepError::malformed(path, "dims", found, expected).into());
                }
                whole(source)?
            }
            LoadedDensity::Same(id) => {
                let of = built.get(id).filter(|of| of.grid().dims == self.grid.dims);
                of.ok_or_else(|| unread("kept.same", id.to_string()))?.unedited(self.map)
            }
            LoadedDensity::Box(of) => {
                let parent = built.get(&id.of_before());
                let fits = |parent: &&Volume| {
                    let dims = parent.grid().dims;
                    let scales = of.scale.iter().all(|s| (1..=SubBox::FINEST).contains(s));
                    scales && (0..3).all(|a| of.lo[a] < of.hi[a] && of.hi[a] < dims[a]) && of.dims() == self.grid.dims
                };
                let parent = parent.filter(fits).ok_or_else(|| unread("kept.box", format!("{of:?}")))?;
                let mut volume = Volume::refined(&Arc::new(parent.clone()), *of);
                if *volume.density.map() != self.map {
                    volume.density = volume.density.unedited(self.map, &|_| true)?.ok_or(DocumentError::Stopped)?;
                }
                volume
            }
        };
        for (kind, edits) in self.edits {
            let changes: Vec<(BrickIndex, _)> = edits.into_iter().map(|(i, brick)| (i, Some(brick))).collect();
            if !changes.is_empty() {
                volume.field_mut(kind).swap(changes)?;
            }
        }
        Ok(volume)
    }
}

impl RestoredDocument {
    /// `beside` are the poses that lie beside the journal.
    pub(crate) fn new(
        loaded: Loaded,
        replay: Replay,
        beside: Option<SavedPoses>,
        journal: &Path,
    ) -> Result<Self, KeepError> {
        let Loaded { dirs: [project, at], manifest, volumes: mut held, mut told, .. } = loaded;
        told.extend(replay.told);
        let mut volumes = BTreeMap::new();
        for (&id, record) in &manifest.volumes {
            // What went, or went and came again, is the journal's.
            if let (false, Some(LoadedVolume { density, edits, files })) =
                (replay.volumes.contains_key(&id), held.remove(&id))
            {
                volumes.insert(id, RestoredVolume::new(record, (density, files), edits));
            }
        }
        for (&id, record) in &replay.volumes {
            if let Some(record) = record {
                record.check(journal, &format!("volumes.{id}"))?;
                let density = density_of(&project, &at, &manifest, id, record, None)?;
                volumes.insert(id, RestoredVolume::new(record, density, BTreeMap::new()));
            }
        }
        for (id, map) in replay.maps {
            if let Some(volume) = volumes.get_mut(&id) {
                // Texels of the old map; those that are still edits are in the journal.
                volume.map = map;
                volume.edits.insert(FieldKind::Density, Edits::new());
            }
        }
        for ((key, index), brick) in replay.bricks {
            let field = format!("{} brick", key.kind.name());
            let Some(volume) = volumes.get_mut(&key.volume) else {
                let (found, expected) = (format!("volume {}", key.volume), "a volume that the document has");
                return Err(KeepError::malformed(journal, field, found, expected));
            };
            let bricks = volume.grid.dims.map(|d| d.div_ceil(BRICK));
            if (0..3).any(|a| index.0[a] >= bricks[a]) {
                let (found, expected) = (format!("{:?}", index.0), format!("below {bricks:?}"));
                return Err(KeepError::malformed(journal, field, found, expected));
            }
            let field = volume.edits.entry(key.kind).or_default();
            match brick {
                Some(brick) => field.insert(index, brick),
                None => field.remove(&index),
            };
        }
        let moved = replay.scene.get("explosion").map(poses_of_before).unwrap_or_default();
        let mut scene = if replay.scene.is_empty() {
            manifest.scene.clone()
        } else {
            with_parts(&manifest.scene, replay.scene)
                .map_err(|e| KeepError::malformed(journal, "scene", e, "parts of a scene"))?
        };
        for (id, volume) in &volumes {
            let Some(settings) = scene.volumes.all.get_mut(id) else { continue };
            if let LoadedDensity::Linked(path) = &volume.density {
                // The document may have been opened by a path that means nothing here.
                settings.origin.path.clone_from(path);
            }
            if settings.name.is_empty() {
                settings.name = VolumeSettings::called(&volume.name).to_owned();
            }
        }
        // Journals of before have poses too.
        let moved = (!moved.is_empty()).then(|| SavedPoses::at_rest(&scene, moved));
        Ok(Self {
            poses: beside.or(moved).or_else(|| manifest.poses.clone()).unwrap_or_default(),
            scene,
            past: replay.past.unwrap_or_else(|| manifest.past.clone()),
            volumes,
            recovered: Recovered {
                steps: replay.steps,
                last: replay.last,
                stroke_volumes: if replay.stroke.samples.is_empty() { Vec::new() } else { replay.stroke.volumes() },
                stroke: replay.stroke.samples,
                torn_bytes: replay.torn_bytes,
                set_aside: replay.set_aside,
                told,
            },
        })
    }

    /// The document again. `open` reads a file that a density is linked to and is not called for density in the project.
    /// `progress` gets the share done and answers whether to go on.
    ///
    /// # Errors
    /// If a source fails or has another grid, or `progress` said no.
    pub fn into_state(
        self,
        open: impl Fn(&Origin) -> Result<Arc<dyn BrickSource>, DocumentError>,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<State, DocumentError> {
        let Self { mut scene, past, volumes: kept, .. } = self;
        let (mut volumes, mut files) = (BTreeMap::new(), BTreeMap::new());
        let count = kept.len().max(1) as f32;
        let parent_of = |id: &VolumeId| match kept.get(&id.of_before())?.density {
            LoadedDensity::Same(of) => Some(of),
            _ => None,
        };
        let depth = |id: VolumeId| std::iter::successors(parent_of(&id), parent_of).take(kept.len()).count();
        let place = |id: &VolumeId| (depth(id.of_sub_volume()), id.of_sub_volume(), !id.is_of_before());
        let places: BTreeMap<VolumeId, _> = kept.keys().map(|id| (*id, place(id))).collect();
        let mut kept: Vec<_> = kept.into_iter().collect();
        // What a sub-volume is computed from comes right before it, and its parent before that.
        kept.sort_by_key(|(id, _)| places.get(id).copied());
        for (done, (id, volume)) in kept.into_iter().enumerate() {
            if id.is_of_before() {
                let volume = volume.into_volume((id, &volumes), || Err(DocumentError::NoVolume), progress)?;
                volumes.insert(id, volume);
                continue;
            }
            // A volume that the scene does not know is one all the same.
            let fresh = || VolumeSettings::new(VolumeSettings::called(&volume.name), Origin::nowhere());
            let origin = scene.volumes.all.entry(id).or_insert_with(fresh).origin.clone();
            files.extend(volume.files.clone().map(|files| (id, files)));
            let volume =
                volume.into_volume((id, &volumes), || open(&origin), &|x| progress((done as f32 + x) / count))?;
            volumes.insert(id, volume);
        }
        Ok(State { scene, past, volumes, files })
    }
}

fn with_parts(scene: &Scene, parts: serde_json::Map<String, Value>) -> Result<Scene, serde_json::Error> {
    let mut all = serde_json::to_value(scene)?;
    if let Value::Object(all) = &mut all {
        all.extend(parts);
    }
    serde_json::from_value(all)
}
