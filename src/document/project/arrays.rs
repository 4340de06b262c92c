//! OME-Zarr 0.5: how a block of voxels becomes a Zarr array, and the shards of it.
//!
//! An array has its axes slowest first (z, y, x; colour c, z, y, x), chunks of one brick, shards of 4³ bricks, zstd with a
//! checksum, and fill value 0, so that bricks that are not there cost nothing. OME metadata holds scale and translation in
//! millimetres; it cannot say more, so the whole of `world_from_index` stands beside it. Knows zarrs, and no project.

use crate::document::disk::error::KeepError;
use crate::document::disk::inside;
use crate::document::disk::inside::Files;
use crate::volume::{BRICK, Grid, VoxelType};
use serde_json::{Map, Value, json};
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zarrs::array::codec::ZstdCodec;
use zarrs::array::{
    Array, ArrayBuilder, ArrayBytes, ArrayMetadata, ArrayToBytesCodecTraits, CodecOptions, DataType, FillValue,
    data_type,
};

/// Bricks along an edge of a shard.
pub(crate) const SHARD_BRICKS: u32 = 4;
/// Voxels along an edge of a shard.
pub(crate) const SHARD: u32 = SHARD_BRICKS * BRICK;
/// Fast, and already half of what the slow levels gain.
const ZSTD_LEVEL: i32 = 1;

/// What is said of an array.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// Folder below the generation's, with slashes.
    pub path: String,
    /// Type of its numbers.
    pub voxel_type: VoxelType,
    /// Numbers per voxel, as a slowest axis of its own if there is more than one.
    pub channels: u32,
    /// Voxels along i, j, k.
    pub dims: [u32; 3],
    /// Voxels along an edge of a file.
    pub file_edge: u32,
    /// Whether a file is a shard of chunks of one brick.
    pub sharded: bool,
}

impl Layout {
    /// A field's array.
    pub(crate) fn field(name: &str, voxel_type: VoxelType, channels: u32, dims: [u32; 3]) -> Self {
        Self { path: format!("{name}/0"), voxel_type, channels, dims, file_edge: SHARD, sharded: true }
    }

    /// One number per brick.
    pub(crate) fn per_brick(path: &str, dims: [u32; 3]) -> Self {
        let dims = dims.map(|d| d.div_ceil(BRICK));
        Self { path: path.to_owned(), voxel_type: VoxelType::U8, channels: 1, dims, file_edge: BRICK, sharded: false }
    }

    /// Files along i, j, k.
    pub(crate) fn file_dims(&self) -> [u32; 3] {
        self.dims.map(|d| d.div_ceil(self.file_edge))
    }

    /// Places of all files, x fastest.
    pub(crate) fn files(&self) -> impl Iterator<Item = [u32; 3]> + use<> {
        let [nx, ny, nz] = self.file_dims();
        (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
    }

    /// Name of a file below the generation's folder.
    pub(crate) fn file_name(&self, [x, y, z]: [u32; 3]) -> String {
        let channel = if self.channels > 1 { "0/" } else { "" };
        format!("{}/c/{channel}{z}/{y}/{x}", self.path)
    }

    /// The file that holds a chunk.
    pub(crate) fn file_of(&self, chunk: [u32; 3]) -> [u32; 3] {
        chunk.map(|c| c * BRICK / self.file_edge)
    }

    /// No encoded file is longer: random numbers do not shrink, and each chunk adds its head.
    pub(crate) fn most_bytes(&self) -> u64 {
        2 * self.file_bytes() as u64 + (1 << 20)
    }

    /// Bytes of a decoded file.
    pub(crate) fn file_bytes(&self) -> usize {
        (self.file_edge as usize).pow(3) * self.channels as usize * self.voxel_type.bytes()
    }

    /// Its Zarr metadata.
    fn metadata(&self) -> Result<ArrayMetadata, String> {
        let slowest_first = |[x, y, z]: [u32; 3]| -> Vec<u64> {
            let channel = (self.channels > 1).then_some(u64::from(self.channels));
            channel.into_iter().chain([z, y, x].map(u64::from)).collect()
        };
        let shape = slowest_first(self.dims);
        let file: Vec<NonZeroU64> =
            slowest_first([self.file_edge; 3]).into_iter().filter_map(NonZeroU64::new).collect();
        let fill = FillValue::new(vec![0; self.voxel_type.bytes()]);
        let mut builder = ArrayBuilder::new(shape, file, data_type_of(self.voxel_type), fill);
        if self.sharded {
            builder.subchunk_shape(slowest_first([BRICK; 3]));
        }
        let names = ["c", "z", "y", "x"].into_iter().skip(usize::from(self.channels == 1));
        builder.bytes_to_bytes_codecs(vec![Arc::new(ZstdCodec::new(ZSTD_LEVEL, true))]).dimension_names(Some(names));
        Ok(ArrayMetadata::V3(builder.build_metadata().map_err(|e| e.to_string())?))
    }

    /// The bytes of the array's `zarr.json`.
    pub(crate) fn array_json(&self) -> Result<Vec<u8>, KeepError> {
        let metadata = self.metadata().map_err(|e| self.refused(&e))?;
        serde_json::to_vec_pretty(&metadata).map_err(|e| self.refused(&e))
    }

    /// The array as zarrs has it, read from a generation's folder.
    pub(crate) fn open(&self, dir: &Path) -> Result<Array<Files>, KeepError> {
        let store = Files(dir.to_owned());
        let metadata = self.metadata().map_err(|e| self.refused(&e))?;
        Array::new_with_metadata(Arc::new(store), &format!("/{}", self.path), metadata).map_err(|e| self.refused(&e))
    }

    /// Encodes one file's numbers, slowest axis first, in this machine's byte order.
    pub(crate) fn encode(&self, array: &Array<Files>, numbers: Vec<u8>) -> Result<Vec<u8>, KeepError> {
        let shape = self.file_shape(array)?;
        let encoded = array.codecs().encode(
            ArrayBytes::new_flen(numbers),
            &shape,
            array.data_type(),
            array.fill_value(),
            &CodecOptions::default(),
        );
        Ok(encoded.map_err(|e| self.refused(&e))?.into_owned())
    }

    /// Reads and decodes one file, whose bytes have this hash where one is known.
    pub(crate) fn decode(
        &self,
        array: &Array<Files>,
        dir: &Path,
        file: [u32; 3],
        hash: Option<&str>,
    ) -> Result<Vec<u8>, KeepError> {
        let name = self.file_name(file);
        let path = dir.join(&name);
        let bytes = inside::read(dir, &name, self.most_bytes())?;
        if let Some(expected) = hash {
            check_hash(&path, &bytes, expected)?;
        }
        let length = bytes.len();
        let shape = self.file_shape(array)?;
        let options = CodecOptions::default();
        let damaged = |reason: String| damaged_chunk(&path, length, &reason);
        let decoded = array
            .codecs()
            .decode(bytes.into(), &shape, array.data_type(), array.fill_value(), &options)
            .map_err(|e| damaged(e.to_string()))?;
        let numbers = decoded.into_fixed().map_err(|e| damaged(e.to_string()))?.into_owned();
        let found = numbers.len();
        let fits = found == self.file_bytes();
        if fits { Ok(numbers) } else { Err(damaged(format!("{found} bytes instead of {}", self.file_bytes()))) }
    }

    fn file_shape(&self, array: &Array<Files>) -> Result<Vec<NonZeroU64>, KeepError> {
        array.chunk_shape(&vec![0; array.dimensionality()]).map_err(|e| self.refused(&e))
    }

    fn refused(&self, reason: &dyn std::fmt::Display) -> KeepError {
        KeepError::malformed(&PathBuf::from(&self.path), "array", reason, "an array that Zarr can hold")
    }
}

/// Fails unless a file's bytes are those that were written.
pub(crate) fn check_hash(path: &Path, bytes: &[u8], expected: &str) -> Result<(), KeepError> {
    let found = blake3::hash(bytes).to_hex().to_string();
    if found == expected { Ok(()) } else { Err(KeepError::malformed(path, "blake3", found, expected)) }
}

/// A shard or chunk that cannot be decoded.
pub(crate) fn damaged_chunk(path: &Path, length: usize, reason: &str) -> KeepError {
    KeepError::malformed(
        path,
        "chunks",
        format!("{length} bytes ({reason})"),
        "chunks that decode and match their checksum",
    )
}

fn data_type_of(ty: VoxelType) -> DataType {
    match ty {
        VoxelType::U8 => data_type::uint8(),
        VoxelType::I8 => data_type::int8(),
        VoxelType::U16 => data_type::uint16(),
        VoxelType::I16 => data_type::int16(),
        VoxelType::U32 => data_type::uint32(),
        VoxelType::I32 => data_type::int32(),
        VoxelType::U64 => data_type::uint64(),
        VoxelType::I64 => data_type::int64(),
        VoxelType::F32 => data_type::float32(),
        VoxelType::F64 => data_type::float64(),
    }
}

/// The `zarr.json` of a group with these attributes.
pub(crate) fn group_json(attributes: Map<String, Value>) -> Result<Vec<u8>, KeepError> {
    let group = json!({ "zarr_format": 3, "node_type": "group", "attributes": attributes });
    serde_json::to_vec_pretty(&group).map_err(|e| KeepError::Scene { reason: e.to_string() })
}

/// The OME attributes of a field's group, and the grid's full place beside them; `more` says what the numbers mean.
pub(crate) fn ome_attributes(name: &str, grid: &Grid, channels: u32, more: Value) -> Map<String, Value> {
    let space = |axis: &str| json!({ "name": axis, "type": "space", "unit": "millimeter" });
    let (s, t) = (grid.spacing(), grid.world_from_index.translation);
    let mut axes = vec![space("z"), space("y"), space("x")];
    let mut scale = vec![s.z, s.y, s.x];
    let mut translation = vec![t.z, t.y, t.x];
    if channels > 1 {
        axes.insert(0, json!({ "name": "c", "type": "channel" }));
        scale.insert(0, 1.0);
        translation.insert(0, 0.0);
    }
    let transforms = json!([
        { "type": "scale", "scale": scale },
        { "type": "translation", "translation": translation },
    ]);
    let dataset = json!({ "path": "0", "coordinateTransformations": transforms });
    let mut attributes = Map::new();
    attributes.insert(
        "ome".into(),
        json!({ "version": "0.5", "multiscales": [{ "name": name, "axes": axes, "datasets": [dataset] }] }),
    );
    attributes.insert(
        "burin".into(),
        json!({ "world_from_index": rows(grid), "frame": "RAS+ mm, index (i, j, k) = (x, y, z)", "numbers": more }),
    );
    attributes
}

/// `world_from_index` as three rows of four.
pub(crate) fn rows(grid: &Grid) -> [[f64; 4]; 3] {
    let (m, t) = (grid.world_from_index.matrix3, grid.world_from_index.translation);
    std::array::from_fn(|r| [m.x_axis[r], m.y_axis[r], m.z_axis[r], t[r]])
}
