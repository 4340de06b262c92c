//! Reading a project: which generation it is, and what is in it.
//!
//! `project.json` says it. A folder that lost that file is no leftover: its newest whole generation is the project. Of a damaged
//! generation the one before it is offered. Changes nothing on disk; knows neither lock nor journal.

use crate::document::disk::error::KeepError;
use crate::document::disk::inside;
use crate::document::disk::source_files::SourceFiles;
use crate::document::project::MANIFEST;
use crate::document::project::fields::{DENSITY, Edits, array_name, edited_name, read_edited, read_field};
use crate::document::project::manifest::{DensityPlace, Manifest, PROJECT, VolumeRecord, read_project};
use crate::document::project::source::ZarrSource;
use crate::volume::{FieldKind, SubBox, VolumeId};
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Nobody saves so often: a greater number is none that a save gave.
const MOST: u64 = 1 << 48;

/// What is wanted of a project beside its folder.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted<'a> {
    /// The file of a linked density, where it is not at the place that the project knows.
    pub source: Option<&'a Path>,
    /// An older generation than the current one.
    pub generation: Option<u64>,
}

/// Where a loaded document's unedited density is.
#[derive(Clone, Debug)]
pub enum LoadedDensity {
    /// In the project.
    Whole(Arc<ZarrSource>),
    /// In this file; it has the length that it should have, its hash is being taken.
    Linked(PathBuf),
    /// That of this volume.
    Same(VolumeId),
    /// Computed from its parent as it was.
    Box(SubBox),
}

/// A volume as a generation has it on disk.
#[derive(Clone, Debug)]
pub(crate) struct LoadedVolume {
    pub density: LoadedDensity,
    pub edits: BTreeMap<FieldKind, Edits>,
    /// Of a linked density.
    pub files: Option<Arc<SourceFiles>>,
}

/// A generation as it is on disk.
#[derive(Debug)]
pub(crate) struct Loaded {
    /// The project's folder, and the generation's.
    pub dirs: [PathBuf; 2],
    pub manifest: Manifest,
    pub volumes: BTreeMap<VolumeId, LoadedVolume>,
    /// What the user should know.
    pub told: Vec<String>,
    /// Whether it is the one that `project.json` names.
    pub is_current: bool,
}

/// Fails unless there is something of a project in a folder.
pub(crate) fn check_project(dir: &Path) -> Result<(), KeepError> {
    if !dir.is_dir() || (named(dir)?.is_none() && described(dir).is_empty()) {
        return Err(KeepError::NotAProject { path: dir.to_owned() });
    }
    Ok(())
}

/// The generation that `project.json` names; `None` if there is no such file.
pub(crate) fn named(dir: &Path) -> Result<Option<u64>, KeepError> {
    match std::fs::symlink_metadata(dir.join(PROJECT)) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(KeepError::io("read", &dir.join(PROJECT))(error)),
        Ok(_) => read_project(dir).map(Some),
    }
}

/// Numbers of the generations that were written to their end, the newest first.
pub(crate) fn described(dir: &Path) -> Vec<u64> {
    let Ok(entries) = std::fs::read_dir(dir) else { return Vec::new() };
    let number = |entry: std::fs::DirEntry| generation_of(&entry.file_name().to_string_lossy());
    let mut all: Vec<u64> = entries.flatten().filter_map(number).collect();
    all.retain(|&n| dir.join(generation_name(n)).join(MANIFEST).symlink_metadata().is_ok());
    all.sort_unstable_by_key(|&n| std::cmp::Reverse(n));
    all
}

/// Reads the generation that is wanted, the current one unless said otherwise.
pub(crate) fn load(dir: &Path, wanted: Wanted<'_>) -> Result<Loaded, KeepError> {
    let named = named(dir)?;
    match (wanted.generation.filter(|n| Some(*n) != named), named) {
        (Some(asked), _) => {
            let mut loaded = read_generation(dir, asked, wanted.source)?;
            loaded.is_current = false;
            loaded.told.push(format!(
                "generation {asked} was opened as asked, not the project's last; a save makes it the last"
            ));
            Ok(loaded)
        }
        (None, Some(current)) => {
            read_generation(dir, current, wanted.source).map_err(|error| offer(dir, current, error))
        }
        (None, None) => newest_whole(dir, wanted.source),
    }
}

/// The newest generation that can be read, of a folder that does not say which is the current one.
fn newest_whole(dir: &Path, source: Option<&Path>) -> Result<Loaded, KeepError> {
    let mut first = None;
    let mut damaged = Vec::new();
    for generation in described(dir) {
        match read_generation(dir, generation, source) {
            Ok(mut loaded) => {
                loaded.is_current = false;
                let mut told =
                    format!("{PROJECT} is missing; generation {generation}, the newest that is whole, was opened");
                if !damaged.is_empty() {
                    told.push_str(&format!(" (damaged: {})", damaged.join("; ")));
                }
                told.push_str("; a save makes it the project again");
                loaded.told.push(told);
                return Ok(loaded);
            }
            // Whole, but not by itself.
            Err(
                error @ (KeepError::SourceMissing { .. } | KeepError::SourceChanged { .. } | KeepError::Version { .. }),
            ) => {
                return Err(error);
            }
            Err(error) => {
                damaged.push(error.to_string());
                first.get_or_insert(error);
            }
        }
    }
    Err(first.unwrap_or(KeepError::NotAProject { path: dir.to_owned() }))
}

/// The error with an older generation to go back to, if there is a whole one.
fn offer(dir: &Path, current: u64, error: KeepError) -> KeepError {
    let is_damage = match &error {
        KeepError::Malformed { .. } => true,
        KeepError::Io { source, .. } => matches!(source.kind(), ErrorKind::NotFound | ErrorKind::InvalidInput),
        _ => false,
    };
    let older = || described(dir).into_iter().find(|&n| n < current && read_generation(dir, n, None).is_ok());
    match if is_damage { older() } else { None } {
        Some(whole) => KeepError::Damaged { source: Box::new(error), whole },
        None => error,
    }
}

fn read_generation(dir: &Path, generation: u64, given: Option<&Path>) -> Result<Loaded, KeepError> {
    let at = dir.join(generation_name(generation));
    inside::check_folder(&at)?;
    let manifest = Manifest::read(&at)?;
    if manifest.generation != generation {
        let (path, found) = (at.join(MANIFEST), manifest.generation);
        return Err(KeepError::malformed(&path, "generation", found, generation.to_string()));
    }
    let mut told = Vec::new();
    let linked = manifest.volumes.values().filter(|volume| matches!(volume.kept, DensityPlace::Linked(_))).count();
    if given.is_some() && linked == 0 {
        told.push("the project holds its volume: the source that was given is not used".into());
    }
    let mut volumes = BTreeMap::new();
    let mut given = given;
    for (&id, record) in &manifest.volumes {
        let (density, files) = match (&record.kept, given) {
            // Of several the one that the given file is.
            (DensityPlace::Linked(link), Some(file)) if linked > 1 => match link.find(dir, Some(file)) {
                Ok(files) => {
                    given = None;
                    (LoadedDensity::Linked(files.path().to_owned()), Some(files))
                }
                Err(KeepError::SourceChanged { .. }) => density_of(dir, &at, &manifest, id, record, None)?,
                Err(error) => return Err(error),
            },
            _ => density_of(dir, &at, &manifest, id, record, given)?,
        };
        let place = manifest.place(id);
        let mut edits = BTreeMap::new();
        for kind in FieldKind::ALL {
            let (shards, format) = (record.shards_of(array_name(kind)), kind.format(record.map.format));
            let name = edited_name(kind);
            let has_map = kind == FieldKind::Density || record.shards.contains_key(&name);
            let only = || read_edited(&at, &place, kind, record.dims, record.shards_of(&name));
            let only = has_map.then(only).transpose()?;
            edits.insert(kind, read_field(&at, &place, kind, format, record.dims, shards, only.as_deref())?);
        }
        volumes.insert(id, LoadedVolume { density, edits, files });
    }
    Ok(Loaded { dirs: [dir.to_owned(), at], manifest, volumes, told, is_current: true })
}

/// Where the density of a volume is that a generation, or the journal behind it, knows.
pub(crate) fn density_of(
    project: &Path,
    at: &Path,
    manifest: &Manifest,
    id: VolumeId,
    record: &VolumeRecord,
    given: Option<&Path>,
) -> Result<(LoadedDensity, Option<Arc<SourceFiles>>), KeepError> {
    match &record.kept {
        DensityPlace::Whole => {
            let (scaling, place) = ((record.scaling[0], record.scaling[1]), manifest.place(id));
            let held = manifest.volumes.get(&id).or_else(|| manifest.set_aside.get(&id)).unwrap_or(record);
            let shards = held.shards_of(DENSITY);
            let (name, grid) = (record.name.clone(), record.grid());
            let source = ZarrSource::open(at, name, grid, record.voxel_type, scaling, &place, shards)?;
            Ok((LoadedDensity::Whole(Arc::new(source)), None))
        }
        DensityPlace::Linked(link) => {
            let files = link.find(project, given)?;
            Ok((LoadedDensity::Linked(files.path().to_owned()), Some(files)))
        }
        DensityPlace::Same(id) => Ok((LoadedDensity::Same(*id), None)),
        DensityPlace::Box(of) => Ok((LoadedDensity::Box(*of), None)),
    }
}

/// Reads the description of a document that was never saved; its fields are blank but for the journal's bricks.
pub(crate) fn read_unsaved(dir: &Path) -> Result<Loaded, KeepError> {
    let manifest = Manifest::read(dir)?;
    let mut volumes = BTreeMap::new();
    for (&id, record) in &manifest.volumes {
        if record.kept == DensityPlace::Whole {
            let (field, expected) = (format!("volumes.{id}.kept"), "a link to the file that was opened");
            return Err(KeepError::malformed(&dir.join(MANIFEST), field, "whole", expected));
        }
        let (density, files) = density_of(dir, dir, &manifest, id, record, None)?;
        volumes.insert(id, LoadedVolume { density, edits: BTreeMap::new(), files });
    }
    let dirs = [dir.to_owned(), dir.to_owned()];
    Ok(Loaded { dirs, manifest, volumes, told: Vec::new(), is_current: true })
}

/// The folder of a generation.
pub(crate) fn generation_name(generation: u64) -> String {
    format!("generation-{generation:06}")
}

/// The number in a folder's name, if it is one that a generation has.
pub(crate) fn generation_of(name: &str) -> Option<u64> {
    let number = name.strip_prefix("generation-")?.parse().ok()?;
    (number < MOST && generation_name(number) == name).then_some(number)
}
