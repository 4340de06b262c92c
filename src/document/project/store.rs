//! A project on disk: a folder of generations, of which one JSON names the current one.
//!
//! A save writes generation N+1 beside N (shards that did not change are hard links), syncs it, and then replaces
//! `project.json` by rename: a crash at any moment leaves N or N+1, whole. The generation before the current one is kept;
//! older ones go. A generation is a Zarr group of OME-Zarr 0.5 images:
//!   density        the source's own type and numbers, written once and linked ever after (absent if linked to its file)
//!   density_edits  texels of edited bricks, and `edited`, the map of which these are
//!   colour, selection, labels
//! and `generation.json`: the scene, where its parts stand, the grid with its full orientation, the density map, and the hashes of all
//! shards.
//! Owns the folder and its lock; knows nothing of the journal but the generation that it belongs to.

use crate::document::command::answers::Saved;
use crate::document::command::files::DensityKeeping;
use crate::document::disk::error::KeepError;
use crate::document::disk::files::{Writer, create_dir, remove_dir, replace, sync_dir};
use crate::document::disk::inside;
use crate::document::disk::lock::{LOCK, Lock};
use crate::document::disk::source_files::SourceFiles;
use crate::document::project::arrays::{SHARD, group_json, ome_attributes};
use crate::document::project::fields::{array_name, write_edited, write_field};
use crate::document::project::link::Link;
use crate::document::project::manifest::{JOURNAL_HEADER, Kept, MANIFEST, Manifest, PROJECT, VERSION, project_json};
use crate::document::project::read::{
    Loaded, LoadedDensity, Wanted, check_project, described, generation_name, generation_of, load,
};
use crate::document::project::source::{ZarrSource, density_layout};
use crate::document::scene::kept_poses::KeptPoses;
use crate::document::state::State;
use crate::volume::{BRICK, BrickSource, FieldKind, Grid};
use rayon::prelude::*;
use serde_json::json;
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

/// An open project folder; nobody else can open it meanwhile.
#[derive(Debug)]
pub(crate) struct Store {
    dir: PathBuf,
    generation: u64,
    /// The current generation's; `None` before the first save.
    manifest: Option<Manifest>,
    source: Option<Arc<ZarrSource>>,
    /// Of a linked density.
    files: Option<Arc<SourceFiles>>,
    is_new_folder: bool,
    lock: Lock,
}

impl Store {
    /// A new project in a folder that is empty or not there yet. Nothing is a project before the first save.
    pub fn create(dir: &Path) -> Result<Self, KeepError> {
        let is_new_folder = !dir.exists();
        create_dir(dir)?;
        // Before the lock, which is a file: a folder of something else is left as it is.
        check_leftovers(dir)?;
        let lock = Lock::take(dir)?;
        Ok(Self { dir: dir.to_owned(), generation: 0, manifest: None, source: None, files: None, is_new_folder, lock })
    }

    /// Opens a project and reads its current generation, or what else is wanted.
    pub fn open(dir: &Path, wanted: Wanted<'_>) -> Result<(Self, Loaded), KeepError> {
        check_project(dir)?;
        let lock = Lock::take(dir)?;
        let loaded = load(dir, wanted)?;
        let source = match &loaded.density {
            LoadedDensity::Whole(source) => Some(source.clone()),
            LoadedDensity::Linked(_) => None,
        };
        let (generation, manifest) = (loaded.manifest.generation, Some(loaded.manifest.clone()));
        let files = loaded.files.clone();
        let store = Self { dir: dir.to_owned(), generation, manifest, source, files, is_new_folder: false, lock };
        Ok((store, loaded))
    }

    /// The project's folder.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Its lock.
    pub fn lock(&self) -> &Lock {
        &self.lock
    }

    /// The current generation, 0 before the first save.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Writes the next generation and makes it the current one. `before` is called with its number when everything is on
    /// disk and only the rename is left. `keeping` is as before if `None`, whole the first time. `progress` gets the share done
    /// and answers whether to go on.
    ///
    /// # Errors
    /// If it could not be done; the current generation is what it was.
    pub fn save<T>(
        &mut self,
        state: &State,
        poses: &KeptPoses,
        keeping: Option<DensityKeeping>,
        before: impl FnOnce(u64) -> Result<T, KeepError>,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<Committed<T>, KeepError> {
        inside::check_writable(&self.dir).map_err(KeepError::io("write into", &self.dir))?;
        // Beyond whatever was written to its end: where no file says which is the current one, a newer one may be somebody's work.
        let generation = self.next_generation();
        let keeping = keeping.unwrap_or(match self.manifest.as_ref().map(|m| &m.volume.kept) {
            Some(Kept::Linked(_)) => DensityKeeping::Linked,
            _ => DensityKeeping::Whole,
        });
        let previous = self.manifest.as_ref().map(|_| self.dir.join(generation_name(self.generation)));
        let at = self.dir.join(generation_name(generation));
        let written = Writer::new(at.clone(), previous).and_then(|writer| {
            let (manifest, linked) = self.write(&writer, generation, (state, poses), keeping, progress)?;
            writer.sync()?;
            sync_dir(&self.dir)?;
            let made = before(generation)?;
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
        self.manifest = Some(manifest);
        let moved = match (linked.file, &self.source) {
            (Some(file), Some(source)) => {
                source.read_from(file);
                Ok(())
            }
            (None, Some(source)) if linked.files.is_none() => source.move_to(&at),
            _ => Ok(()),
        };
        self.files = linked.files;
        let doubt = moved.and_then(|()| sync_dir(&self.dir)).err();
        if doubt.is_none() {
            self.prune(before);
        }
        progress(1.0);
        let saved = Saved { generation, bytes_written: writer.bytes_written(), files_linked: writer.files_linked() };
        Ok(Committed { saved, made, doubt })
    }

    /// Takes back what [`create`](Self::create) made, if nothing was saved since.
    pub fn abandon(self) {
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
        (state, poses): (&State, &KeptPoses),
        keeping: DensityKeeping,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<(Manifest, Linked), KeepError> {
        let grid = *state.grid();
        let total = grid.dims.iter().map(|d| d.div_ceil(SHARD) as usize).product::<usize>();
        let painted: usize = FieldKind::ALL.iter().map(|&k| state.field(k).edits().len().div_ceil(64)).sum();
        let done = AtomicUsize::new(0);
        let tick = || {
            let share = done.fetch_add(1, Ordering::Relaxed) as f32 / (total + painted + 1) as f32;
            if progress(share.min(0.99)) { Ok(()) } else { Err(KeepError::Stopped) }
        };
        writer.write_or_link("zarr.json", &group_json(serde_json::Map::new())?)?;
        let old = self.manifest.as_ref();
        let mut linked = Linked::default();
        let kept = match (keeping, old.map(|m| &m.volume.kept)) {
            (DensityKeeping::Whole, Some(Kept::Whole)) => {
                link_density(writer, &grid, state.source.as_ref())?;
                Kept::Whole
            }
            (DensityKeeping::Whole, _) => {
                write_density(writer, &grid, state.source.as_ref(), &tick)?;
                Kept::Whole
            }
            (DensityKeeping::Linked, _) => {
                let go_on = || progress(0.0);
                linked = match state.files.as_ref().or(self.files.as_ref()) {
                    Some(files) => Linked { files: Some(files.clone()), file: None },
                    None => Linked::to_equal(state, &go_on)?,
                };
                let files = linked.files.as_ref().ok_or(KeepError::NoPath)?;
                Kept::Linked(Link::to(files, &self.dir, &go_on)?)
            }
        };
        let mut shards = BTreeMap::new();
        let none = BTreeMap::new();
        let before = |name: &str| old.map_or(&none, |m| m.shards_of(name));
        for kind in FieldKind::ALL {
            let name = array_name(kind);
            shards.insert(name.to_owned(), write_field(writer, state.field(kind), &grid, before(name), &tick)?);
        }
        let edited = crate::document::project::fields::EDITED;
        shards.insert(edited.to_owned(), write_edited(writer, &state.density, &grid, before(edited))?);
        let manifest = Manifest::of(generation, state, poses, kept, shards);
        writer.write(MANIFEST, &manifest.json()?)?;
        Ok((manifest, linked))
    }

    /// The number of the next generation.
    pub fn next_generation(&self) -> u64 {
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

/// What a save found out of the files that it linked.
#[derive(Debug, Default)]
struct Linked {
    files: Option<Arc<SourceFiles>>,
    /// The voxels in the file, where they were in the project before.
    file: Option<Arc<dyn BrickSource>>,
}

impl Linked {
    /// The file that the scene's origin names, if it has the very voxels that the project holds: whatever else lies there now must
    /// not take their place.
    fn to_equal(state: &State, go_on: &dyn Fn() -> bool) -> Result<Self, KeepError> {
        let origin = &state.scene.origin;
        let refused = |found: String| KeepError::LinkLost {
            path: origin.path.clone(),
            field: "file",
            found,
            expected: "the voxels that the project holds".into(),
        };
        let opened = crate::io::open(&origin.path).map_err(|e| refused(e.to_string()))?;
        let files = SourceFiles::opened(opened.files.clone());
        let source = opened.source(origin.component, origin.frame, &|_| true).map_err(|e| refused(e.to_string()))?;
        let ours = state.source.as_ref();
        let same =
            (source.grid(), source.voxel_type(), source.scaling()) == (ours.grid(), ours.voxel_type(), ours.scaling());
        if !same {
            return Err(refused("voxels of another grid or type".into()));
        }
        let dims = ours.grid().dims;
        for z in (0..dims[2]).step_by(BRICK as usize) {
            if !go_on() {
                return Err(KeepError::Stopped);
            }
            let (lo, size) = ([0, 0, z], [dims[0], dims[1], BRICK.min(dims[2] - z)]);
            if source.read(lo, size)?.as_bytes() != ours.read(lo, size)?.as_bytes() {
                return Err(refused(format!("other voxels in planes {z} to {}", z + size[2] - 1)));
            }
        }
        Ok(Self { files: Some(files), file: Some(source) })
    }
}

fn density_metadata(writer: &Writer, grid: &Grid, source: &dyn BrickSource) -> Result<(), KeepError> {
    let (slope, intercept) = source.scaling();
    let numbers = json!({ "value": "slope * number + intercept", "slope": slope, "intercept": intercept });
    let attributes = ome_attributes("density", grid, 1, numbers);
    writer.write_or_link("density/zarr.json", &group_json(attributes)?)?;
    let layout = density_layout(source.voxel_type(), grid.dims);
    writer.write_or_link(&format!("{}/zarr.json", layout.path), &layout.array_json()?)
}

fn link_density(writer: &Writer, grid: &Grid, source: &dyn BrickSource) -> Result<(), KeepError> {
    density_metadata(writer, grid, source)?;
    let layout = density_layout(source.voxel_type(), grid.dims);
    layout.files().try_for_each(|file| writer.link(&layout.file_name(file)))
}

/// Writes the whole density, a shard at a time on each thread.
fn write_density(
    writer: &Writer,
    grid: &Grid,
    source: &dyn BrickSource,
    tick: &(dyn Fn() -> Result<(), KeepError> + Sync),
) -> Result<(), KeepError> {
    density_metadata(writer, grid, source)?;
    let layout = density_layout(source.voxel_type(), grid.dims);
    let array = layout.open(&writer.dir)?;
    let bytes = source.voxel_type().bytes();
    let files: Vec<_> = layout.files().collect();
    files.into_par_iter().try_for_each(|file| {
        tick()?;
        let lo = file.map(|f| f * SHARD);
        let size: [u32; 3] = std::array::from_fn(|a| SHARD.min(grid.dims[a] - lo[a]));
        let voxels = source.read(lo, size)?;
        let mut numbers = vec![0; layout.file_bytes()];
        let row = size[0] as usize * bytes;
        for (i, from) in voxels.as_bytes().chunks_exact(row).enumerate() {
            let (y, z) = (i % size[1] as usize, i / size[1] as usize);
            let start = SHARD as usize * (y + SHARD as usize * z) * bytes;
            numbers[start..start + row].copy_from_slice(from);
        }
        drop(voxels);
        // Also where all is 0, so that a missing shard is known for damage.
        writer.write(&layout.file_name(file), &layout.encode(&array, numbers)?)
    })
}

const _: () = assert!(VERSION == 1, "the module's head describes version 1");
