//! The density of a volume in a project: written whole once, linked from the generation before ever after, or left in the file that
//! it was opened from, if that has the very same voxels.
//!
//! Owns how its shards are laid out and hashed; which of the three a save does is `store`'s.

use crate::document::disk::error::KeepError;
use crate::document::disk::files::Writer;
use crate::document::disk::inside;
use crate::document::disk::source_files::SourceFiles;
use crate::document::project::arrays::{Layout, SHARD, group_json, ome_attributes};
use crate::document::project::fields::{DENSITY, Shard, Shards, file_hash, place_name};
use crate::document::project::manifest::{Manifest, volume_place};
use crate::document::project::source::density_layout;
use crate::document::subject::Subject;
use crate::volume::{BRICK, BrickSource, VolumeId};
use rayon::prelude::*;
use serde_json::json;
use std::sync::Arc;

/// What a save found out of the files that it linked.
#[derive(Debug, Default)]
pub(super) struct Linked {
    pub(super) files: Option<Arc<SourceFiles>>,
    /// The voxels in the file, where they were in the project before.
    pub(super) file: Option<Arc<dyn BrickSource>>,
}

impl Linked {
    /// The file that the scene's origin names, if it has the very voxels that the project holds: whatever else lies there now must
    /// not take their place.
    pub(super) fn to_equal(subject: Subject<'_>, proceed: &dyn Fn() -> bool) -> Result<Self, KeepError> {
        let origin = &subject.settings.origin;
        let refused = |found: String| KeepError::LinkLost {
            path: origin.path.clone(),
            field: "file",
            found,
            expected: "the voxels that the project holds".into(),
        };
        let opened = crate::io::open(&origin.path).map_err(|e| refused(e.to_string()))?;
        let files = SourceFiles::opened(opened.files.clone());
        let source = opened.source(origin.component, origin.frame, &|_| true).map_err(|e| refused(e.to_string()))?;
        let ours = subject.volume.source.as_ref();
        let same =
            (source.grid(), source.voxel_type(), source.scaling()) == (ours.grid(), ours.voxel_type(), ours.scaling());
        if !same {
            return Err(refused("voxels of another grid or type".into()));
        }
        let dims = ours.grid().dims;
        for z in (0..dims[2]).step_by(BRICK as usize) {
            if !proceed() {
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

fn density_metadata(writer: &Writer, place: &str, source: &dyn BrickSource) -> Result<Layout, KeepError> {
    let (slope, intercept) = source.scaling();
    let numbers = json!({ "value": "slope * number + intercept", "slope": slope, "intercept": intercept });
    let grid = source.grid();
    let attributes = ome_attributes(DENSITY, grid, 1, numbers);
    writer.write_or_link(&format!("{place}{DENSITY}/zarr.json"), &group_json(attributes)?)?;
    let layout = density_layout(place, source.voxel_type(), grid.dims);
    writer.write_or_link(&format!("{}/zarr.json", layout.path), &layout.array_json()?)?;
    Ok(layout)
}

/// Links the density that the generation before holds. The files of one that does not know their hashes are read once.
pub(super) fn link_density(
    writer: &Writer,
    id: VolumeId,
    source: &dyn BrickSource,
    old: &Manifest,
) -> Result<Shards, KeepError> {
    let layout = density_metadata(writer, &volume_place(id), source)?;
    let before = density_layout(&old.place(id), source.voxel_type(), source.grid().dims);
    let record = old.volumes.get(&id).or_else(|| old.set_aside.get(&id));
    let link = |file: [u32; 3]| {
        let name = place_name(file);
        let known = record.and_then(|record| record.shards_of(DENSITY).get(&name)?.file());
        let hash = match (known, &writer.previous) {
            (Some(hash), _) => hash.to_owned(),
            (None, Some(dir)) => file_hash(&inside::read(dir, &before.file_name(file), before.most_bytes())?),
            (None, None) => return Err(KeepError::NoPath),
        };
        writer.link_from(&before.file_name(file), &layout.file_name(file))?;
        Ok((name, Shard::Both { content: String::new(), file: hash }))
    };
    layout.files().map(link).collect()
}

/// Writes the whole density, a shard at a time on each thread.
pub(super) fn write_density(
    writer: &Writer,
    id: VolumeId,
    source: &dyn BrickSource,
    tick: &(dyn Fn() -> Result<(), KeepError> + Sync),
) -> Result<Shards, KeepError> {
    let layout = density_metadata(writer, &volume_place(id), source)?;
    let array = layout.open(&writer.dir)?;
    let (dims, bytes) = (source.grid().dims, source.voxel_type().bytes());
    let files: Vec<_> = layout.files().collect();
    let write = |file: [u32; 3]| {
        tick()?;
        let lo = file.map(|f| f * SHARD);
        let size: [u32; 3] = std::array::from_fn(|a| SHARD.min(dims[a] - lo[a]));
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
        let encoded = layout.encode(&array, numbers)?;
        writer.write(&layout.file_name(file), &encoded)?;
        Ok((place_name(file), Shard::Both { content: String::new(), file: file_hash(&encoded) }))
    };
    files.into_par_iter().map(write).collect()
}
