//! The two JSON files of a project: which generation is current, and what a generation is beside its arrays.

use crate::document::disk::error::KeepError;
use crate::document::disk::inside;
use crate::document::project::arrays::rows;
use crate::document::project::fields::Shards;
use crate::document::project::link::Link;
use crate::document::scene::Scene;
use crate::document::scene::kept_poses::{KeptPoses, poses_of_before};
use crate::document::scene::past::Past;
use crate::document::state::State;
use crate::math::{DAffine3, DMat3, DVec3};
use crate::volume::{DensityMap, Grid, Histogram, Number, Statistics, TexelFormat, VoxelType};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// Version of the folder's layout.
pub(crate) const VERSION: u64 = 1;
/// Names the current generation.
pub(crate) const PROJECT: &str = "project.json";
/// Bytes before the first record of a journal: one that has no more holds no work.
pub(crate) const JOURNAL_HEADER: u64 = 28;
/// A generation's own description.
pub(crate) const MANIFEST: &str = "generation.json";
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
    pub version: u64,
    pub generation: u64,
    pub volume: VolumeRecord,
    /// By array, the hash of each file that is there.
    pub shards: BTreeMap<String, Shards>,
    pub scene: Scene,
    /// Earlier views and looks; generations of before have none.
    #[serde(default, skip_serializing_if = "Past::is_empty")]
    pub past: Past,
    /// Where forces had taken the parts, so that they stand there at once; `None` where they had taken none anywhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub poses: Option<KeptPoses>,
}

/// The density.
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
    pub kept: Kept,
    pub statistics: StatisticsRecord,
    pub histogram: HistogramRecord,
}

/// Where the density is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Kept {
    Whole,
    Linked(Link),
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

impl Manifest {
    /// What is to be said of a state.
    pub fn of(generation: u64, state: &State, poses: &KeptPoses, kept: Kept, shards: BTreeMap<String, Shards>) -> Self {
        let grid = state.grid();
        let number = |v: f64| v.is_finite().then_some(v);
        let Statistics { min, max, sum, nan_count, infinite_count, exact } = state.statistics;
        let histogram = &state.histogram;
        let (slope, intercept) = state.source.scaling();
        Self {
            format: GENERATION_FORMAT.into(),
            version: VERSION,
            generation,
            volume: VolumeRecord {
                name: state.source.name().to_owned(),
                dims: grid.dims,
                world_from_index: rows(grid),
                voxel_type: state.source.voxel_type(),
                scaling: [slope, intercept],
                map: *state.density.map(),
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
            },
            shards,
            scene: state.scene.sayable(),
            past: state.past.clone(),
            poses: (!(poses.parts.is_empty() && poses.rest_of.is_some())).then(|| poses.clone()),
        }
    }

    /// The file's bytes, checked to come back as what they were.
    pub fn json(&self) -> Result<Vec<u8>, KeepError> {
        let refused = |e: serde_json::Error| KeepError::Scene { reason: e.to_string() };
        let bytes = serde_json::to_vec_pretty(self).map_err(refused)?;
        // A number that JSON has no word for is written as null and cannot be read: better to know now.
        let again: Self = serde_json::from_slice(&bytes).map_err(refused)?;
        if again == *self {
            Ok(bytes)
        } else {
            Err(KeepError::Scene { reason: "it does not read back as it was".into() })
        }
    }

    /// Reads and checks the file of a generation's folder.
    pub fn read(dir: &Path) -> Result<Self, KeepError> {
        let path = &dir.join(MANIFEST);
        let bytes = inside::read(dir, MANIFEST, MOST_BYTES)?;
        check_head(path, &bytes, GENERATION_FORMAT)?;
        let mut manifest: Self = parse(path, &bytes, "a generation as Burin writes it")?;
        if manifest.poses.is_none() {
            let all: Value = parse(path, &bytes, "JSON")?;
            let before = poses_of_before(&all["scene"]["explosion"]);
            manifest.poses = Some(KeptPoses::at_rest(&manifest.scene, before));
        }
        let grid = manifest.grid();
        let bad = |field: &str, found: String, expected: &str| Err(KeepError::malformed(path, field, found, expected));
        if grid.dims.contains(&0) || grid.dims.iter().any(|&d| d > 1 << 20) {
            return bad("volume.dims", format!("{:?}", grid.dims), "1 to 1048576 voxels per axis");
        }
        if !(grid.world_from_index.matrix3.determinant().abs() > 0.0 && grid.world_from_index.is_finite()) {
            return bad("volume.world_from_index", format!("{:?}", rows(&grid)), "an invertible matrix");
        }
        let [slope, intercept] = manifest.volume.scaling;
        if !(slope.is_finite() && slope != 0.0 && intercept.is_finite()) {
            return bad("volume.scaling", format!("[{slope}, {intercept}]"), "finite numbers, the first other than 0");
        }
        let HistogramRecord { min, max, bins, .. } = &manifest.volume.histogram;
        let total = bins.iter().try_fold(0_u64, |sum, n| sum.checked_add(*n));
        if bins.is_empty() || bins.len() > MOST_BINS || total.is_none() || min > max {
            let found = format!("{} bins from {min:?} to {max:?}", bins.len());
            return bad("volume.histogram", found, "1 to 65536 counts over a range that rises");
        }
        let map = manifest.volume.map;
        let numbers = map.lo.is_finite() && map.codes_per_unit.is_finite() && map.codes_per_unit > 0.0;
        let known = matches!(map.format, TexelFormat::R16Unorm | TexelFormat::R32Float);
        if !(numbers && known) {
            return bad("volume.map", format!("{map:?}"), "r16_unorm or r32_float, finite, codes_per_unit above 0");
        }
        Ok(manifest)
    }

    /// The grid.
    pub fn grid(&self) -> Grid {
        let w = self.volume.world_from_index;
        let column = |c: usize| DVec3::new(w[0][c], w[1][c], w[2][c]);
        let matrix3 = DMat3::from_cols(column(0), column(1), column(2));
        Grid { dims: self.volume.dims, world_from_index: DAffine3 { matrix3, translation: column(3) } }
    }

    /// Of all of the source's values.
    pub fn statistics(&self) -> Statistics {
        let StatisticsRecord { min, max, sum, nan_count, infinite_count, exact } = &self.volume.statistics;
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
    pub fn histogram(&self) -> Histogram {
        let HistogramRecord { min, max, bins, ids, voids } = self.volume.histogram.clone();
        Histogram { min: min.unwrap_or(f64::NAN), max: max.unwrap_or(f64::NAN), bins, ids, voids }
    }

    /// The hashes of an array's files.
    pub fn shards_of(&self, array: &str) -> &Shards {
        static NONE: Shards = Shards::new();
        self.shards.get(array).unwrap_or(&NONE)
    }
}

/// The bytes of `project.json`.
pub(crate) fn project_json(generation: u64) -> Result<Vec<u8>, KeepError> {
    let head = Head { format: PROJECT_FORMAT.into(), version: VERSION, generation };
    serde_json::to_vec_pretty(&head).map_err(|e| KeepError::Scene { reason: e.to_string() })
}

/// The current generation that `project.json` names.
pub(crate) fn read_project(dir: &Path) -> Result<u64, KeepError> {
    let bytes = inside::read(dir, PROJECT, MOST_BYTES)?;
    check_head(&dir.join(PROJECT), &bytes, PROJECT_FORMAT)
}

/// Format before version before the rest, so that another version is told as such and not as a missing field.
fn check_head(path: &Path, bytes: &[u8], format: &str) -> Result<u64, KeepError> {
    let head: Head = parse(path, bytes, "JSON with format, version and generation")?;
    if head.format != format {
        return Err(KeepError::malformed(path, "format", format!("{:?}", head.format), format!("{format:?}")));
    }
    if head.version != VERSION {
        return Err(KeepError::Version { path: path.to_owned(), found: head.version, expected: VERSION });
    }
    Ok(head.generation)
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
