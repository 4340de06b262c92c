//! The two JSON files of a project: which generation is current, and what a generation is beside its arrays.

use crate::document::disk::error::KeepError;
use crate::document::disk::inside;
use crate::document::project::MANIFEST;
use crate::document::project::arrays::rows;
use crate::document::project::fields::Shards;
use crate::document::project::first_format;
use crate::document::project::link::Link;
use crate::document::scene::Scene;
use crate::document::scene::kept_poses::{SavedPoses, poses_of_before};
use crate::document::scene::past::Past;
use crate::document::state::State;
use crate::math::{DAffine3, DMat3, DVec3};
use crate::volume::{
    DensityMap, Grid, Histogram, Number, Statistics, SubBox, TexelFormat, Volume, VolumeId, VoxelType,
};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Version of the folder's layout.
pub(crate) const VERSION: u64 = 2;
/// The layout before there were several volumes, which is read too: one volume beside the JSON, and hashes of bricks alone.
pub(crate) const ONE_VOLUME: u64 = 1;
/// Names the current generation.
pub(crate) const PROJECT: &str = "project.json";
/// Bytes before the first record of a journal: one that has no more holds no work.
pub(crate) const JOURNAL_HEADER: u64 = 28;
/// No histogram has more.
const MOST_BINS: usize = 1 << 16;
/// Neither is ever longer: a table of shards has some ten bytes a megabyte of voxels.
const MOST_BYTES: u64 = 256 << 20;
const PROJECT_FORMAT: &str = "burin project";
const GENERATION_FORMAT: &str = "burin generation";

/// What both files begin with.
#[derive(Serialize, Deserialize)]
struct Head {
    format: String,
    version: u64,
    generation: u64,
}

/// A generation beside its arrays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Manifest {
    pub format: String,
    /// Of the layout that its arrays have.
    pub version: u64,
    pub generation: u64,
    /// What the volumes of the scene are.
    pub volumes: BTreeMap<VolumeId, VolumeRecord>,
    /// Volumes that were removed and may still be brought back before the program ends: their density alone.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub set_aside: BTreeMap<VolumeId, VolumeRecord>,
    pub scene: Scene,
    /// Earlier views and looks; generations of before have none.
    #[serde(default, skip_serializing_if = "Past::is_empty")]
    pub past: Past,
    /// Where forces had taken the parts, so that they stand there at once; `None` where they had taken none anywhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poses: Option<SavedPoses>,
}

/// A volume beside its arrays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct VolumeRecord {
    pub name: String,
    /// Voxels along i, j, k.
    pub dims: [u32; 3],
    /// Rows of index to RAS+ mm.
    pub world_from_index: [[f64; 4]; 3],
    pub voxel_type: VoxelType,
    /// Slope and intercept.
    pub scaling: [f64; 2],
    pub map: DensityMap,
    pub kept: DensityPlace,
    pub statistics: StatisticsRecord,
    pub histogram: HistogramRecord,
    /// By array, the hashes of each file that is there.
    #[serde(default)]
    pub shards: BTreeMap<String, Shards>,
}

/// Where the density is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum DensityPlace {
    Whole,
    Linked(Link),
    /// Nowhere: that of another volume, what a sub-volume of this volume's number less 2³¹ is computed from.
    Same(VolumeId),
    /// Nowhere: computed, from the volume of this number and 2³¹ more.
    Box(SubBox),
}

impl DensityPlace {
    /// Of a volume whose density is in no file of its own.
    pub(crate) fn nowhere(state: &State, id: VolumeId, volume: &Volume) -> Option<Self> {
        if id.is_of_before() {
            let sub = state.scene.volumes.all.get(&id.of_sub_volume())?.sub_volume?;
            return Some(Self::Same(sub.parent));
        }
        volume.sub_box().map(Self::Box)
    }
}

/// JSON has no NaN: `null` stands for it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct StatisticsRecord {
    min: Option<f64>,
    max: Option<f64>,
    sum: Option<Number>,
    nan_count: u64,
    #[serde(default)]
    infinite_count: u64,
    /// See [`Statistics::exact`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    exact: Option<[String; 3]>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct HistogramRecord {
    min: Option<f64>,
    max: Option<f64>,
    bins: Vec<u64>,
    /// See [`Histogram::ids`].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    ids: Vec<f64>,
    /// See [`Histogram::voids`].
    #[serde(default)]
    voids: [u64; 2],
}

impl VolumeRecord {
    /// What is to be said of a volume.
    pub(crate) fn of(volume: &Volume, kept: DensityPlace, shards: BTreeMap<String, Shards>) -> Self {
        let grid = volume.grid();
        let number = |v: f64| v.is_finite().then_some(v);
        let Statistics { min, max, sum, nan_count, infinite_count, exact } = volume.statistics;
        let histogram = &volume.histogram;
        let (slope, intercept) = volume.source.scaling();
        Self {
            name: volume.source.name().to_owned(),
            dims: grid.dims,
            world_from_index: rows(grid),
            voxel_type: volume.source.voxel_type(),
            scaling: [slope, intercept],
            map: *volume.density.map(),
            kept,
            statistics: StatisticsRecord {
                min: number(min),
                max: number(max),
                sum: Some(Number::Real(sum)).filter(|n| !n.is_nan()),
                nan_count,
                infinite_count,
                exact: exact.map(|numbers| numbers.map(|n| n.to_string())),
            },
            histogram: HistogramRecord {
                min: number(histogram.min),
                max: number(histogram.max),
                bins: histogram.bins.clone(),
                ids: histogram.ids.clone(),
                voids: histogram.voids,
            },
            shards,
        }
    }

    /// Fails where the record of a file `path` cannot be that of a volume; `at` is the record's place in it.
    pub(crate) fn check(&self, path: &Path, at: &str) -> Result<(), KeepError> {
        let bad = |field: &str, found: String, expected: &str| {
            Err(KeepError::malformed(path, format!("{at}.{field}"), found, expected))
        };
        let grid = self.grid();
        if grid.dims.contains(&0) || grid.dims.iter().any(|&d| d > 1 << 20) {
            return bad("dims", format!("{:?}", grid.dims), "1 to 1048576 voxels per axis");
        }
        if !(grid.world_from_index.matrix3.determinant().abs() > 0.0 && grid.world_from_index.is_finite()) {
            return bad("world_from_index", format!("{:?}", rows(&grid)), "an invertible matrix");
        }
        let [slope, intercept] = self.scaling;
        if !(slope.is_finite() && slope != 0.0 && intercept.is_finite()) {
            return bad("scaling", format!("[{slope}, {intercept}]"), "finite numbers, the first other than 0");
        }
        let HistogramRecord { min, max, bins, .. } = &self.histogram;
        let total = bins.iter().try_fold(0_u64, |sum, n| sum.checked_add(*n));
        if bins.is_empty() || bins.len() > MOST_BINS || total.is_none() || min > max {
            let found = format!("{} bins from {min:?} to {max:?}", bins.len());
            return bad("histogram", found, "1 to 65536 counts over a range that rises");
        }
        let map = self.map;
        let numbers = map.lo.is_finite() && map.codes_per_unit.is_finite() && map.codes_per_unit > 0.0;
        let known = matches!(map.format, TexelFormat::R16Unorm | TexelFormat::R32Float);
        if !(numbers && known) {
            return bad("map", format!("{map:?}"), "r16_unorm or r32_float, finite, codes_per_unit above 0");
        }
        Ok(())
    }

    /// The grid.
    pub(crate) fn grid(&self) -> Grid {
        let w = self.world_from_index;
        let column = |c: usize| DVec3::new(w[0][c], w[1][c], w[2][c]);
        let matrix3 = DMat3::from_cols(column(0), column(1), column(2));
        Grid { dims: self.dims, world_from_index: DAffine3 { matrix3, translation: column(3) } }
    }

    /// Of all of the source's values.
    pub(crate) fn statistics(&self) -> Statistics {
        let StatisticsRecord { min, max, sum, nan_count, infinite_count, exact } = &self.statistics;
        let exact = exact.as_ref().and_then(|numbers| {
            let [min, max, sum] = numbers.each_ref().map(|n| n.parse().ok());
            Some([min?, max?, sum?])
        });
        Statistics {
            min: min.unwrap_or(f64::NAN),
            max: max.unwrap_or(f64::NAN),
            sum: sum.map_or(f64::NAN, Number::to_f64),
            nan_count: *nan_count,
            infinite_count: *infinite_count,
            exact,
        }
    }

    /// Of the source's values.
    pub(crate) fn histogram(&self) -> Histogram {
        let HistogramRecord { min, max, bins, ids, voids } = self.histogram.clone();
        Histogram { min: min.unwrap_or(f64::NAN), max: max.unwrap_or(f64::NAN), bins, ids, voids }
    }

    /// The hashes of an array's files.
    pub(crate) fn shards_of(&self, array: &str) -> &Shards {
        static NONE: Shards = Shards::new();
        self.shards.get(array).unwrap_or(&NONE)
    }
}

impl Manifest {
    /// What is to be said of a state.
    pub(crate) fn of(
        generation: u64,
        state: &State,
        poses: &SavedPoses,
        volumes: BTreeMap<VolumeId, VolumeRecord>,
    ) -> Self {
        Self {
            format: GENERATION_FORMAT.into(),
            version: VERSION,
            generation,
            volumes,
            set_aside: BTreeMap::new(),
            scene: state.scene.sayable(),
            past: state.past.clone(),
            poses: (!(poses.parts.is_empty() && poses.rest_of.is_some())).then(|| poses.clone()),
        }
    }

    /// Where the arrays of a volume lie below the generation's folder: what their names begin with.
    pub(crate) fn place(&self, id: VolumeId) -> String {
        if self.version == ONE_VOLUME { String::new() } else { volume_place(id) }
    }

    /// The map of each volume's density.
    pub(crate) fn maps(&self) -> BTreeMap<VolumeId, DensityMap> {
        self.volumes.iter().map(|(id, volume)| (*id, volume.map)).collect()
    }

    /// The volumes whose density the generation holds.
    pub(crate) fn holds(&self) -> BTreeSet<VolumeId> {
        let all = self.volumes.iter().chain(&self.set_aside);
        all.filter(|(_, volume)| volume.kept == DensityPlace::Whole).map(|(id, _)| *id).collect()
    }

    /// The file's bytes, checked to come back as what they were.
    pub(crate) fn json(&self) -> Result<Vec<u8>, KeepError> {
        let refused = |e: serde_json::Error| KeepError::Scene { reason: e.to_string() };
        let bytes = serde_json::to_vec_pretty(&Sealed { blake3: UNSEALED.into(), content: self }).map_err(refused)?;
        // A number that JSON has no word for is written as null and cannot be read: better to know now.
        let again: Self = serde_json::from_slice(&bytes).map_err(refused)?;
        if again != *self {
            return Err(KeepError::Scene { reason: "it does not read back as it was".into() });
        }
        Ok(sealed(bytes))
    }

    /// Reads and checks the file of a generation's folder.
    pub(crate) fn read(dir: &Path) -> Result<Self, KeepError> {
        let path = &dir.join(MANIFEST);
        let bytes = inside::read(dir, MANIFEST, MOST_BYTES)?;
        let (_, version) = check_head(path, &bytes, GENERATION_FORMAT)?;
        let expected = "a generation as Burin writes it";
        let mut manifest: Self = if version == ONE_VOLUME {
            let mut old: Value = parse(path, &bytes, expected)?;
            first_format::generation(&mut old);
            parse(path, old.to_string().as_bytes(), expected)?
        } else {
            parse(path, &bytes, expected)?
        };
        if manifest.poses.is_none() {
            let all: Value = parse(path, &bytes, "JSON")?;
            let before = poses_of_before(&all["scene"]["explosion"]);
            manifest.poses = Some(SavedPoses::at_rest(&manifest.scene, before));
        }
        for (name, volumes) in [("volumes", &manifest.volumes), ("set_aside", &manifest.set_aside)] {
            for (id, volume) in volumes {
                let at = if version == ONE_VOLUME { "volume".to_owned() } else { format!("{name}.{id}") };
                volume.check(path, &at)?;
            }
        }
        // What is wrong by itself says more than that something is.
        if version != ONE_VOLUME {
            check_seal(path, &bytes)?;
        }
        Ok(manifest)
    }
}

/// Where the arrays of a volume lie below a generation's folder.
pub(crate) fn volume_place(id: VolumeId) -> String {
    format!("volumes/{id}/")
}

/// What stands for the hash of a file in the file while it is taken.
const UNSEALED: &str = "0000000000000000000000000000000000000000000000000000000000000000";

/// JSON that says the hash of itself: of its bytes with zeros in the hash's place.
#[derive(Serialize)]
struct Sealed<'a, T: Serialize> {
    blake3: String,
    #[serde(flatten)]
    content: &'a T,
}

/// Where the hash is in a file's bytes.
fn seal_place(bytes: &[u8]) -> Option<std::ops::Range<usize>> {
    const KEY: &[u8] = b"\"blake3\": \"";
    // It is the first thing that the file says.
    let start = bytes.get(..64)?.windows(KEY.len()).position(|w| w == KEY)? + KEY.len();
    let end = start + UNSEALED.len();
    (bytes.get(end)? == &b'"').then_some(start..end)
}

fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let hash = blake3::hash(&bytes).to_hex();
    if let Some(place) = seal_place(&bytes) {
        bytes[place].copy_from_slice(hash.as_bytes());
    }
    bytes
}

fn check_seal(path: &Path, bytes: &[u8]) -> Result<(), KeepError> {
    let Some(place) = seal_place(bytes) else {
        return Err(KeepError::malformed(path, "blake3", "none", "the hash of the file as its first field"));
    };
    let said = String::from_utf8_lossy(&bytes[place.clone()]).into_owned();
    let mut content = bytes.to_vec();
    content[place].copy_from_slice(UNSEALED.as_bytes());
    let found = blake3::hash(&content).to_hex().to_string();
    if found == said { Ok(()) } else { Err(KeepError::malformed(path, "blake3", found, said)) }
}

/// The bytes of `project.json`.
pub(crate) fn project_json(generation: u64) -> Result<Vec<u8>, KeepError> {
    let head = Head { format: PROJECT_FORMAT.into(), version: VERSION, generation };
    let sealed_head = Sealed { blake3: UNSEALED.into(), content: &head };
    serde_json::to_vec_pretty(&sealed_head).map(sealed).map_err(|e| KeepError::Scene { reason: e.to_string() })
}

/// The current generation that `project.json` names.
pub(crate) fn read_project(dir: &Path) -> Result<u64, KeepError> {
    let bytes = inside::read(dir, PROJECT, MOST_BYTES)?;
    let path = dir.join(PROJECT);
    let (generation, version) = check_head(&path, &bytes, PROJECT_FORMAT)?;
    if version != ONE_VOLUME {
        check_seal(&path, &bytes)?;
    }
    Ok(generation)
}

/// Format before version before the rest, so that another version is told as such and not as a missing field. Answers generation
/// and version.
fn check_head(path: &Path, bytes: &[u8], format: &str) -> Result<(u64, u64), KeepError> {
    let head: Head = parse(path, bytes, "JSON with format, version and generation")?;
    if head.format != format {
        return Err(KeepError::malformed(path, "format", format!("{:?}", head.format), format!("{format:?}")));
    }
    if ![ONE_VOLUME, VERSION].contains(&head.version) {
        return Err(KeepError::Version { path: path.to_owned(), found: head.version, expected: VERSION });
    }
    Ok((head.generation, head.version))
}

fn parse<T: for<'a> Deserialize<'a>>(path: &Path, bytes: &[u8], expected: &str) -> Result<T, KeepError> {
    let mut json = serde_json::Deserializer::from_slice(bytes);
    let parsed = serde_path_to_error::deserialize(&mut json).map_err(|error| match error.path().to_string().as_str() {
        "." | "" => error.into_inner().to_string(),
        field => format!("{field}: {}", error.inner()),
    });
    let parsed = parsed.and_then(|parsed| json.end().map(|()| parsed).map_err(|e| e.to_string()));
    parsed.map_err(|found| KeepError::malformed(path, "JSON", found, expected))
}
