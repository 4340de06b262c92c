//! Painted bricks to shards and back.
//!
//! Colour, selection and labels are arrays of texels in which a brick that nobody painted is missing. Edited density cannot
//! be told apart that way, since 0 is a code like any other: `density_edits` holds texels of the edited bricks (so that
//! fractions below the source's type survive), and beside it `edited` holds 1 for each brick that is one; so it is of the other fields of a sub-volume. A shard is written
//! again only if a brick in it changed, which its hash tells; all others are links.

use crate::document::disk::error::KeepError;
use crate::document::disk::files::Writer;
use crate::document::project::arrays::{Layout, SHARD, SHARD_BRICKS, group_json, ome_attributes};
use crate::volume::{
    BRICK, BRICK_VOXELS, Brick, BrickIndex, DensityMap, Field, FieldKind, Grid, TexelFormat, VoxelType,
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;

/// Every file of an array that is there, by its place `x/y/z`.
pub(crate) type Shards = BTreeMap<String, Shard>;

/// What is known of a file of an array.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub(crate) enum Shard {
    /// Hash of what it holds, of a project of format 1.
    Content(String),
    /// Hashes of what it holds, which says whether it has to be written again, and of its bytes.
    Both {
        /// Of the bricks; empty where it is never written again.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        content: String,
        /// Of the file, blake3.
        file: String,
    },
}

impl Shard {
    /// Of its bytes, if it is known.
    pub(crate) fn file(&self) -> Option<&str> {
        match self {
            Self::Content(_) => None,
            Self::Both { file, .. } => Some(file),
        }
    }
}

/// The hash of a file's bytes.
pub(crate) fn file_hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

/// Links a file of the generation before, or writes it anew where that cannot be had; answers what is known of it now.
fn write_shard(
    writer: &Writer,
    name: &str,
    known: Option<&Shard>,
    content: String,
    encode: impl FnOnce() -> Result<Vec<u8>, KeepError>,
) -> Result<Shard, KeepError> {
    // What is not known by its bytes is written anew, so that from here on it is.
    if let Some(Shard::Both { content: old, file }) = known
        && *old == content
    {
        writer.link(name)?;
        return Ok(Shard::Both { content, file: file.clone() });
    }
    let bytes = encode()?;
    writer.write(name, &bytes)?;
    Ok(Shard::Both { content, file: file_hash(&bytes) })
}

/// Edited bricks of a field, in order.
pub(crate) type Edits = BTreeMap<BrickIndex, Brick>;

/// The arrays' folder names.
pub(crate) fn array_name(kind: FieldKind) -> &'static str {
    match kind {
        FieldKind::Density => "density_edits",
        _ => kind.name(),
    }
}

/// The array of a density that is held whole.
pub(crate) const DENSITY: &str = "density";

/// The map of edited bricks of a field over something that is computed, in the field's own folder.
pub(crate) fn edited_name(kind: FieldKind) -> String {
    format!("{}/edited", array_name(kind))
}

fn layout(place: &str, kind: FieldKind, format: TexelFormat, dims: [u32; 3]) -> Layout {
    let (voxel_type, channels) = match format {
        TexelFormat::R8Unorm => (VoxelType::U8, 1),
        TexelFormat::R16Unorm | TexelFormat::R16Uint => (VoxelType::U16, 1),
        TexelFormat::R32Float => (VoxelType::F32, 1),
        TexelFormat::Rgba8Unorm => (VoxelType::U8, 4),
    };
    Layout::field(&format!("{place}{}", array_name(kind)), voxel_type, channels, dims)
}

/// Writes a painted field, or the edits of density, below `place`. `previous` are the shards of the generation before.
/// Answers the shards that there are now; `tick` is called once per shard.
pub(crate) fn write_field(
    writer: &Writer,
    place: &str,
    field: &Field,
    grid: &Grid,
    previous: &Shards,
    tick: &(dyn Fn() -> Result<(), KeepError> + Sync),
) -> Result<Shards, KeepError> {
    let kind = field.kind();
    let layout = layout(place, kind, field.format(), grid.dims);
    let numbers = meaning(field);
    let attributes = ome_attributes(array_name(kind), grid, layout.channels, numbers.clone());
    writer.write_or_link(&format!("{place}{}/zarr.json", array_name(kind)), &group_json(attributes)?)?;
    writer.write_or_link(&format!("{}/zarr.json", layout.path), &layout.array_json()?)?;
    let array = layout.open(&writer.dir)?;
    let mut groups: BTreeMap<[u32; 3], Vec<(BrickIndex, &Brick)>> = BTreeMap::new();
    for (index, brick) in field.edits() {
        if kind == FieldKind::Density || field.is_of_box() || *brick != Brick::Uniform([0; 4]) {
            groups.entry(index.0.map(|b| b / SHARD_BRICKS)).or_default().push((index, brick));
        }
    }
    let salt = numbers.to_string();
    groups
        .into_par_iter()
        .map(|(shard, bricks)| {
            tick()?;
            let (name, file) = (place_name(shard), layout.file_name(shard));
            let encode = || layout.encode(&array, gather(&layout, field.format(), shard, &bricks));
            let shard = write_shard(writer, &file, previous.get(&name), hash_of(&salt, &bricks), encode)?;
            Ok((name, shard))
        })
        .collect()
}

/// Writes the map of edited bricks of a field.
pub(crate) fn write_edited(
    writer: &Writer,
    place: &str,
    field: &Field,
    grid: &Grid,
    previous: &Shards,
) -> Result<Shards, KeepError> {
    let edited = edited_name(field.kind());
    let layout = Layout::per_brick(&format!("{place}{edited}"), grid.dims);
    writer.write_or_link(&format!("{place}{edited}/zarr.json"), &layout.array_json()?)?;
    let array = layout.open(&writer.dir)?;
    let mut files: BTreeMap<[u32; 3], Vec<u8>> = BTreeMap::new();
    for index in field.edits().into_keys() {
        let file = files.entry(index.0.map(|b| b / BRICK)).or_insert_with(|| vec![0; BRICK_VOXELS]);
        file[in_cube(index.0, BRICK)] = 1;
    }
    let mut shards = Shards::new();
    for (file, flags) in files {
        let (name, content) = (place_name(file), short(&blake3::hash(&flags)));
        let encode = || layout.encode(&array, flags);
        let shard = write_shard(writer, &layout.file_name(file), previous.get(&name), content, encode)?;
        shards.insert(name, shard);
    }
    Ok(shards)
}

/// Reads what [`write_field`] wrote; `edited` limits it to the bricks that are edits.
pub(crate) fn read_field(
    dir: &Path,
    place: &str,
    kind: FieldKind,
    format: TexelFormat,
    dims: [u32; 3],
    shards: &Shards,
    edited: Option<&[BrickIndex]>,
) -> Result<Edits, KeepError> {
    let layout = layout(place, kind, format, dims);
    let array = layout.open(dir)?;
    let mut wanted: BTreeMap<[u32; 3], (Vec<BrickIndex>, Option<&str>)> = BTreeMap::new();
    for (name, known) in shards {
        let shard = place_of(dir, &layout, name)?;
        let all = (0..SHARD_BRICKS.pow(3)).map(|i| {
            let at = [i % SHARD_BRICKS, i / SHARD_BRICKS % SHARD_BRICKS, i / SHARD_BRICKS.pow(2)];
            BrickIndex(std::array::from_fn(|a| shard[a] * SHARD_BRICKS + at[a]))
        });
        let inside = all.filter(|b| (0..3).all(|a| b.0[a] < dims[a].div_ceil(BRICK)));
        wanted.insert(shard, (inside.collect(), known.file()));
    }
    if let Some(edited) = edited {
        wanted.values_mut().for_each(|(bricks, _)| bricks.clear());
        for &index in edited {
            let shard = index.0.map(|b| b / SHARD_BRICKS);
            let Some((bricks, _)) = wanted.get_mut(&shard) else {
                let path = dir.join(layout.file_name(shard));
                return Err(KeepError::malformed(&path, "shards", "no shard", "one, since a brick in it was edited"));
            };
            bricks.push(index);
        }
    }
    let read: Vec<Vec<(BrickIndex, Brick)>> = wanted
        .into_par_iter()
        .map(|(shard, (indices, hash))| {
            let numbers = layout.decode(&array, dir, shard, hash)?;
            let bricks = indices.into_iter().map(|index| (index, scatter(&layout, format, index, &numbers)));
            Ok(bricks.filter(|(_, b)| edited.is_some() || *b != Brick::Uniform([0; 4])).collect())
        })
        .collect::<Result<_, KeepError>>()?;
    Ok(read.into_iter().flatten().collect())
}

/// Reads the map of edited bricks.
pub(crate) fn read_edited(
    dir: &Path,
    place: &str,
    kind: FieldKind,
    dims: [u32; 3],
    shards: &Shards,
) -> Result<Vec<BrickIndex>, KeepError> {
    let layout = Layout::per_brick(&format!("{place}{}", edited_name(kind)), dims);
    let array = layout.open(dir)?;
    let mut edited = Vec::new();
    for (name, known) in shards {
        let file = place_of(dir, &layout, name)?;
        let flags = layout.decode(&array, dir, file, known.file())?;
        for (i, _) in flags.iter().enumerate().filter(|(_, flag)| **flag != 0) {
            let i = i as u32;
            let at = [i % BRICK, i / BRICK % BRICK, i / (BRICK * BRICK)];
            let index = BrickIndex(std::array::from_fn(|a| file[a] * BRICK + at[a]));
            if (0..3).all(|a| index.0[a] < layout.dims[a]) {
                edited.push(index);
            }
        }
    }
    Ok(edited)
}

/// What the numbers of a field's array mean, for other readers; also part of its shards' hashes, so that texels of another
/// map are never taken for the same.
fn meaning(field: &Field) -> Value {
    let DensityMap { lo, codes_per_unit, .. } = *field.map();
    match field.format() {
        TexelFormat::R16Unorm => {
            json!({ "value": "lo + code / codes_per_unit", "lo": lo, "codes_per_unit": codes_per_unit,
            "where": "edited is 1" })
        }
        TexelFormat::R32Float if *field.map() == DensityMap::FLOAT => {
            json!({ "value": "as it is", "where": "edited is 1" })
        }
        TexelFormat::R32Float => {
            json!({ "value": "lo + number / codes_per_unit", "lo": lo, "codes_per_unit": codes_per_unit,
            "where": "edited is 1" })
        }
        TexelFormat::Rgba8Unorm => json!({ "value": "red, green, blue, alpha over 255, display-referred" }),
        TexelFormat::R8Unorm => json!({ "value": "degree of interest over 255" }),
        TexelFormat::R16Uint => json!({ "value": "id of a segment, 0 for none" }),
    }
}

fn hash_of(salt: &str, bricks: &[(BrickIndex, &Brick)]) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(salt.as_bytes());
    for (index, brick) in bricks {
        index.0.iter().for_each(|i| {
            hasher.update(&i.to_le_bytes());
        });
        match brick {
            Brick::Uniform(value) => hasher.update(&[0]).update(value),
            Brick::Dense(texels) => hasher.update(&[1]).update(texels),
        };
    }
    short(&hasher.finalize())
}

fn short(hash: &blake3::Hash) -> String {
    hash.to_hex()[..32].to_owned()
}

/// How a file's place is called in the manifest.
pub(crate) fn place_name([x, y, z]: [u32; 3]) -> String {
    format!("{x}/{y}/{z}")
}

fn place_of(dir: &Path, layout: &Layout, name: &str) -> Result<[u32; 3], KeepError> {
    let numbers: Option<Vec<u32>> = name.split('/').map(|n| n.parse().ok()).collect();
    let dims = layout.file_dims();
    match numbers.as_deref() {
        Some(&[x, y, z]) if x < dims[0] && y < dims[1] && z < dims[2] => Ok([x, y, z]),
        _ => {
            let (path, field) = (dir.join(crate::document::project::MANIFEST), format!("shards of {}", layout.path));
            Err(KeepError::malformed(&path, field, format!("{name:?}"), format!("x/y/z below {dims:?}")))
        }
    }
}

/// Position within a cube of `edge`, x fastest.
fn in_cube(at: [u32; 3], edge: u32) -> usize {
    let [x, y, z] = at.map(|v| (v % edge) as usize);
    x + edge as usize * (y + edge as usize * z)
}

/// A shard's numbers from its bricks: rows of bricks, colour taken apart into planes.
fn gather(layout: &Layout, format: TexelFormat, shard: [u32; 3], bricks: &[(BrickIndex, &Brick)]) -> Vec<u8> {
    let mut numbers = vec![0; layout.file_bytes()];
    for (index, brick) in bricks {
        let corner: [u32; 3] = std::array::from_fn(|a| (index.0[a] - shard[a] * SHARD_BRICKS) * BRICK);
        let texels = brick.to_texels(format.bytes());
        rows(layout, format, corner, |row, plane, run| {
            let from = &texels[row * run.texel_bytes..];
            for (i, number) in numbers[run.start..run.start + run.len].chunks_exact_mut(run.number_bytes).enumerate() {
                let at = i * run.texel_bytes + plane * run.number_bytes;
                number.copy_from_slice(&from[at..at + run.number_bytes]);
            }
        });
    }
    numbers
}

/// One brick out of a shard's numbers.
fn scatter(layout: &Layout, format: TexelFormat, index: BrickIndex, numbers: &[u8]) -> Brick {
    let corner = index.0.map(|b| b % SHARD_BRICKS * BRICK);
    let mut texels = vec![0; BRICK_VOXELS * format.bytes()];
    rows(layout, format, corner, |row, plane, run| {
        let to = &mut texels[row * run.texel_bytes..];
        for (i, number) in numbers[run.start..run.start + run.len].chunks_exact(run.number_bytes).enumerate() {
            let at = i * run.texel_bytes + plane * run.number_bytes;
            to[at..at + run.number_bytes].copy_from_slice(number);
        }
    });
    Brick::from_texels(texels, format.bytes())
}

/// A row of a brick in its shard.
struct Run {
    start: usize,
    len: usize,
    texel_bytes: usize,
    number_bytes: usize,
}

/// Calls `each(first texel of the row within the brick, plane, where the row is in the shard)`.
fn rows(layout: &Layout, format: TexelFormat, corner: [u32; 3], mut each: impl FnMut(usize, usize, Run)) {
    let (texel_bytes, number_bytes) = (format.bytes(), layout.voxel_type.bytes());
    let edge = SHARD as usize;
    let [cx, cy, cz] = corner.map(|c| c as usize);
    let n = BRICK as usize;
    for plane in 0..layout.channels as usize {
        for z in 0..n {
            for y in 0..n {
                let start = (cx + edge * (cy + y + edge * (cz + z + edge * plane))) * number_bytes;
                each(n * (y + n * z), plane, Run { start, len: n * number_bytes, texel_bytes, number_bytes });
            }
        }
    }
}
