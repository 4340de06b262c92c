//! A project on disk: a folder of generations, of which one JSON names the current one.
//!
//! A save writes generation N+1 beside N (shards that did not change are hard links), syncs it, and then replaces
//! `project.json` by rename: a crash at any moment leaves N or N+1, whole. The generation before the current one is kept;
//! older ones go. A generation is a Zarr group; each volume is a group `volumes/<id>` of OME-Zarr 0.5 images in it:
//!   density        the source's own type and numbers, written once and linked ever after (absent if linked to its file)
//!   density_edits  texels of edited bricks, and `edited`, the map of which these are
//!   colour, selection, labels
//! and `generation.json`: the scene, where its parts stand, of each volume the grid with its full orientation, the density map and the hashes of all
//! shards, and the hash of all that. Format 1, with one volume whose arrays lay beside the JSON, is read and saved as format 2.
//! Owns the folder and its lock; knows nothing of the journal but the generation that it belongs to.

use crate::document::command::answers::Saved;
use crate::document::command::files::DensityKeeping;
use crate::document::disk::error::KeepError;
use crate::document::disk::files::{Writer, create_dir, remove_dir, replace, sync_dir};
use crate::document::disk::inside;
use crate::document::disk::lock::{LOCK, Lock};
use crate::document::disk::source_files::SourceFiles;
use crate::document::project::MANIFEST;
use crate::document::project::arrays::{SHARD, group_json};
use crate::document::project::density::{Linked, link_density, write_density};
use crate::document::project::fields::{DENSITY, Shards, array_name, edited_name, write_edited, write_field};
use crate::document::project::link::Link;
use crate::document::project::manifest::{
    DensityPlace, JOURNAL_HEADER, Manifest, PROJECT, VERSION, VolumeRecord, project_json, volume_place,
};
use crate::document::project::read::{
    Loaded, LoadedDensity, Wanted, check_project, described, generation_name, generation_of, load,
};
use crate::document::project::source::ZarrSource;
use crate::document::scene::kept_poses::SavedPoses;
use crate::document::state::State;
use crate::volume::{FieldKind, Volume, VolumeId};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A save that is done.
#[derive(Debug)]
pub(crate) struct Committed<T> {
    pub saved: Saved,
    /// What was made before the rename.
    pub made: T,
    /// What failed after it: the new generation is current, but a power cut could bring the old one back.
    pub doubt: Option<KeepError>,
}

/// What a save keeps.
#[derive(Debug)]
pub(crate) struct ToKeep<'a> {
    pub state: &'a State,
    /// How the density of a volume is kept from now on; the others as before.
    pub keeping: Option<(VolumeId, DensityKeeping)>,
    /// Volumes that were removed and can still be brought back.
    pub set_aside: BTreeMap<VolumeId, &'a Volume>,
}

impl<'a> ToKeep<'a> {
    /// All of a state; the density of the active volume as is said.
    pub(crate) fn active(state: &'a State, density: Option<DensityKeeping>) -> Self {
        let keeping = density.map(|density| (state.scene.volumes.active, density));
        Self { state, keeping, set_aside: BTreeMap::new() }
    }
}

/// An open project folder; nobody else can open it meanwhile.
#[derive(Debug)]
pub(crate) struct Store {
    dir: PathBuf,
    generation: u64,
    /// The current generation's; `None` before the first save.
    manifest: Option<Manifest>,
    /// The density of each volume that the project holds.
    sources: BTreeMap<VolumeId, Arc<ZarrSource>>,
    /// Of each linked one.
    files: BTreeMap<VolumeId, Arc<SourceFiles>>,
    is_new_folder: bool,
    lock: Lock,
}

impl Store {
    /// A new project in a folder that is empty or not there yet. Nothing is a project before the first save.
    pub(crate) fn create(dir: &Path) -> Result<Self, KeepError> {
        let is_new_folder = !dir.exists();
        create_dir(dir)?;
        // Before the lock, which is a file: a folder of something else is left as it is.
        check_leftovers(dir)?;
        let lock = Lock::take(dir)?;
        let (sources, files) = (BTreeMap::new(), BTreeMap::new());
        Ok(Self { dir: dir.to_owned(), generation: 0, manifest: None, sources, files, is_new_folder, lock })
    }

    /// Opens a project and reads its current generation, or what else is wanted.
    pub(crate) fn open(dir: &Path, wanted: Wanted<'_>) -> Result<(Self, Loaded), KeepError> {
        check_project(dir)?;
        let lock = Lock::take(dir)?;
        let loaded = load(dir, wanted)?;
        let (mut sources, mut files) = (BTreeMap::new(), BTreeMap::new());
        for (id, volume) in &loaded.volumes {
            match &volume.density {
                LoadedDensity::Whole(source) => drop(sources.insert(*id, source.clone())),
                LoadedDensity::Linked(_) => files.extend(volume.files.clone().map(|files| (*id, files))),
                LoadedDensity::Same(_) | LoadedDensity::Box(_) => {}
            }
        }
        let (generation, manifest) = (loaded.manifest.generation, Some(loaded.manifest.clone()));
        let store = Self { dir: dir.to_owned(), generation, manifest, sources, files, is_new_folder: false, lock };
        Ok((store, loaded))
    }

    /// The project's folder.
    pub(crate) fn dir(&self) -> &Path {
        &self.dir
    }

    /// Its lock.
    pub(crate) fn lock(&self) -> &Lock {
        &self.lock
    }

    /// The current generation, 0 before the first save.
    pub(crate) fn generation(&self) -> u64 {
        self.generation
    }

    /// Writes the next generation and makes it the current one. `before` is called with its number when everything is on
    /// disk and only the rename is left, and with the volumes that it holds. `keeping` is as before where it says nothing, whole the
    /// first time. `progress` gets the share done and answers whether to go on.
    ///
    /// # Errors
    /// If it could not be done; the current generation is what it was.
    pub(crate) fn save<T>(
        &mut self,
        kept: &ToKeep<'_>,
        poses: &SavedPoses,
        before: impl FnOnce(u64, &Manifest) -> Result<T, KeepError>,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<Committed<T>, KeepError> {
        inside::check_writable(&self.dir).map_err(KeepError::io("write into", &self.dir))?;
        // Beyond whatever was written to its end: where no file says which is the current one, a newer one may be somebody's work.
        let generation = self.next_generation();
        let previous = self.manifest.as_ref().map(|_| self.dir.join(generation_name(self.generation)));
        let at = self.dir.join(generation_name(generation));
        let written = Writer::new(at.clone(), previous).and_then(|writer| {
            let (manifest, linked) = self.write(&writer, generation, kept, poses, progress)?;
            writer.sync()?;
            sync_dir(&self.dir)?;
            let made = before(generation, &manifest)?;
            replace(&self.dir.join(PROJECT), &project_json(generation)?)?;
            Ok((writer, manifest, linked, made))
        });
        let (writer, manifest, linked, made) = match written {
            Ok(done) => done,
            Err(error) => {
                remove_dir(&at).unwrap_or_else(|e| tracing::warn!("{e}"));
                return Err(error);
            }
        };
        // The new generation is the current one from here on, whatever else fails.
        let before = std::mem::replace(&mut self.generation, generation);
        let mut moved = Ok(());
        for (id, source) in &self.sources {
            match linked.get(id).map(|linked| &linked.file) {
                Some(Some(file)) => source.read_from(file.clone()),
                None if manifest.holds().contains(id) => moved = moved.and(source.move_to(&at, &volume_place(*id))),
                _ => {}
            }
        }
        self.files = linked.into_iter().filter_map(|(id, linked)| Some((id, linked.files?))).collect();
        self.manifest = Some(manifest);
        let doubt = moved.and_then(|()| sync_dir(&self.dir)).err();
        if doubt.is_none() {
            self.prune(before);
        }
        progress(1.0);
        let saved = Saved { generation, bytes_written: writer.bytes_written(), files_linked: writer.files_linked() };
        Ok(Committed { saved, made, doubt })
    }

    /// Takes back what [`create`](Self::create) made, if nothing was saved since.
    pub(crate) fn abandon(self) {
        let Self { dir, generation, is_new_folder, lock, .. } = self;
        drop(lock);
        if generation == 0 {
            let removed = std::fs::remove_file(dir.join("lock"));
            let removed = removed.and_then(|()| if is_new_folder { std::fs::remove_dir(&dir) } else { Ok(()) });
            removed.unwrap_or_else(|e| tracing::warn!("{}: {e}", dir.display()));
        }
    }

    fn write(
        &self,
        writer: &Writer,
        generation: u64,
        kept: &ToKeep<'_>,
        poses: &SavedPoses,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<(Manifest, BTreeMap<VolumeId, Linked>), KeepError> {
        let state = kept.state;
        let shards = |volume: &Volume| volume.grid().dims.iter().map(|d| d.div_ceil(SHARD) as usize).product::<usize>();
        let painted = |volume: &Volume| {
            FieldKind::ALL.iter().map(|&kind| volume.field(kind).edits().len().div_ceil(64)).sum::<usize>()
        };
        let total: usize = state.volumes.values().map(|volume| shards(volume) + painted(volume)).sum();
        let done = AtomicUsize::new(0);
        let tick = || {
            let share = done.fetch_add(1, Ordering::Relaxed) as f32 / (total + 1) as f32;
            if progress(share.min(0.99)) { Ok(()) } else { Err(KeepError::Stopped) }
        };
        let proceed = || progress(0.0);
        let group = group_json(serde_json::Map::new())?;
        writer.write_or_link("zarr.json", &group)?;
        writer.write_or_link("volumes/zarr.json", &group)?;
        let (mut records, mut linked) = (BTreeMap::new(), BTreeMap::new());
        for (&id, volume) in &state.volumes {
            let (record, link) = self.write_volume(writer, id, kept, volume, &tick, &proceed)?;
            records.insert(id, record);
            linked.extend(link.map(|link| (id, link)));
        }
        let mut manifest = Manifest::of(generation, state, poses, records);
        for (&id, volume) in &kept.set_aside {
            // What only this project holds must not go with its generation while it can still be brought back.
            let old = self.manifest.as_ref().filter(|old| old.holds().contains(&id));
            if let Some(old) = old.filter(|_| !state.volumes.contains_key(&id)) {
                let shards = link_density(writer, id, volume.source.as_ref(), old)?;
                let shards = BTreeMap::from([(DENSITY.to_owned(), shards)]);
                manifest.set_aside.insert(id, VolumeRecord::of(volume, DensityPlace::Whole, shards));
            }
        }
        writer.write(MANIFEST, &manifest.json()?)?;
        Ok((manifest, linked))
    }

    fn write_volume(
        &self,
        writer: &Writer,
        id: VolumeId,
        kept: &ToKeep<'_>,
        volume: &Volume,
        tick: &(dyn Fn() -> Result<(), KeepError> + Sync),
        proceed: &dyn Fn() -> bool,
    ) -> Result<(VolumeRecord, Option<Linked>), KeepError> {
        let (state, grid, source) = (kept.state, *volume.grid(), volume.source.as_ref());
        let place = volume_place(id);
        writer.write_or_link(&format!("{place}zarr.json"), &group_json(serde_json::Map::new())?)?;
        let old = self.manifest.as_ref();
        let record = old.and_then(|old| old.volumes.get(&id));
        let keeping = kept.keeping.filter(|(of, _)| *of == id).map(|(_, keeping)| keeping);
        let keeping = keeping.unwrap_or(match record.map(|record| &record.kept) {
            Some(DensityPlace::Linked(_)) => DensityKeeping::Linked,
            _ => DensityKeeping::Whole,
        });
        let mut shards = BTreeMap::new();
        let mut linked = None;
        let nowhere = DensityPlace::nowhere(state, id, volume);
        let is_kept = match (keeping, old.filter(|old| old.holds().contains(&id))) {
            _ if nowhere.is_some() => nowhere.unwrap_or(DensityPlace::Whole),
            (DensityKeeping::Whole, Some(old)) => {
                shards.insert(DENSITY.to_owned(), link_density(writer, id, source, old)?);
                DensityPlace::Whole
            }
            (DensityKeeping::Whole, None) => {
                shards.insert(DENSITY.to_owned(), write_density(writer, id, source, tick)?);
                DensityPlace::Whole
            }
            (DensityKeeping::Linked, _) => {
                let known = match state.files.get(&id).or(self.files.get(&id)) {
                    Some(files) => Linked { files: Some(files.clone()), file: None },
                    None => Linked::to_equal(state.subject(id).ok_or(KeepError::NoPath)?, proceed)?,
                };
                let link = Link::to(known.files.as_ref().ok_or(KeepError::NoPath)?, &self.dir, proceed)?;
                linked = Some(known);
                DensityPlace::Linked(link)
            }
        };
        let none = Shards::new();
        let before = |name: &str| record.map_or(&none, |record| record.shards_of(name));
        for kind in FieldKind::ALL {
            let name = array_name(kind);
            let field = volume.field(kind);
            shards.insert(name.to_owned(), write_field(writer, &place, field, &grid, before(name), tick)?);
            if kind == FieldKind::Density || field.is_of_box() {
                let name = edited_name(kind);
                let edited = write_edited(writer, &place, field, &grid, before(&name))?;
                shards.insert(name, edited);
            }
        }
        Ok((VolumeRecord::of(volume, is_kept, shards), linked))
    }

    /// The number of the next generation.
    pub(crate) fn next_generation(&self) -> u64 {
        described(&self.dir).first().map_or(0, |&newest| newest).max(self.generation) + 1
    }

    /// Removes what is older than the generation `before` the current one. A failure costs room and no data.
    fn prune(&self, before: u64) {
        let Ok(entries) = std::fs::read_dir(&self.dir) else { return };
        for entry in entries.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if generation_of(&name).is_some_and(|n| n < before) {
                remove_dir(&entry.path()).unwrap_or_else(|e| tracing::warn!("{e}"));
            }
        }
    }
}

/// Fails unless a folder is empty, or holds only what a first save that a crash cut short leaves.
fn check_leftovers(dir: &Path) -> Result<(), KeepError> {
    if check_project(dir).is_ok() {
        let whole = described(dir).first().copied();
        return Err(KeepError::LostProject { path: dir.to_owned(), generation: whole });
    }
    for entry in std::fs::read_dir(dir).map_err(KeepError::io("read", dir))? {
        let entry = entry.map_err(KeepError::io("read", dir))?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let about = std::fs::symlink_metadata(entry.path()).map_err(KeepError::io("read", &entry.path()))?;
        let left = match () {
            () if name == LOCK || name == "project.new" => about.is_file(),
            () if generation_of(&name).is_some() => about.is_dir(),
            // One with steps in it is somebody's work.
            () if name.starts_with("journal-") => about.is_file() && about.len() <= JOURNAL_HEADER,
            () => false,
        };
        if !left {
            return Err(KeepError::NotEmpty { path: dir.to_owned(), found: name });
        }
    }
    Ok(())
}

const _: () = assert!(VERSION == 2, "the first lines of this file describe version 2");
