//! What is open: the scene with its past, the volumes and the files behind them.
//!
//! This is all that a save writes and all that undo brings back. Knows neither history nor the GPU, and can be built on a
//! thread of its own, since reading a volume takes seconds.

use crate::document::disk::source_files::SourceFiles;
use crate::document::error::DocumentError;
use crate::document::scene::Scene;
use crate::document::scene::past::Past;
use crate::document::scene::volumes::VolumeSettings;
use crate::io::FileMark;
use crate::volume::{BrickSource, DensityMap, FieldKey, Histogram, Statistics, TexelFormat, Volume, VolumeId, unit};
use std::collections::BTreeMap;
use std::sync::Arc;

/// All that is open: what a save writes and undo brings back.
#[derive(Clone, Debug)]
pub struct State {
    /// Everything but voxels.
    pub scene: Scene,
    /// Earlier views and looks.
    pub past: Past,
    /// The voxels of the scene's volumes.
    pub volumes: BTreeMap<VolumeId, Volume>,
    /// The files that unedited density is read from; none where it is in the project.
    pub files: BTreeMap<VolumeId, Arc<SourceFiles>>,
}

impl State {
    /// Reads the source once and starts with nothing painted. `range` are the values that 16-bit codes span, from the data
    /// if `None`. `progress` gets the share done and answers whether to go on.
    ///
    /// # Errors
    /// If the source fails, the range is not one, or `progress` said no.
    pub fn new(
        source: Arc<dyn BrickSource>,
        origin: crate::document::scene::Origin,
        statistics: Statistics,
        histogram: Histogram,
        range: Option<[f64; 2]>,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<Self, DocumentError> {
        let files = FileMark::of(&origin.path).map_or_else(|_| Vec::new(), |file| vec![file]);
        let volume = over(source, statistics, histogram, range, progress)?;
        Ok(Self::of_one(volume, origin, files))
    }

    /// A document of one volume with all files that its source reads, as they were when they were opened.
    pub(super) fn of_one(volume: Volume, origin: crate::document::scene::Origin, files: Vec<FileMark>) -> Self {
        let first = VolumeId::FIRST;
        let settings = VolumeSettings::new(VolumeSettings::called(volume.source.name()), origin);
        let files = (!files.is_empty()).then(|| (first, SourceFiles::opened(files)));
        Self {
            scene: Scene::new(volume.grid(), &volume.histogram, settings),
            past: Past::default(),
            volumes: BTreeMap::from([(first, volume)]),
            files: files.into_iter().collect(),
        }
    }

    /// A field by its key; `None` if there is no such volume.
    pub fn field(&self, key: FieldKey) -> Option<&crate::volume::Field> {
        self.volumes.get(&key.volume).map(|volume| volume.field(key.kind))
    }
}

/// A volume over a source, read once, with nothing painted; see [`State::new`].
pub(super) fn over(
    source: Arc<dyn BrickSource>,
    statistics: Statistics,
    histogram: Histogram,
    range: Option<[f64; 2]>,
    progress: &(dyn Fn(f32) -> bool + Sync),
) -> Result<Volume, DocumentError> {
    let map = density_map(source.as_ref(), &statistics, &histogram, range)?;
    Volume::new(source, map, statistics, histogram, progress)?.ok_or(DocumentError::Stopped)
}

/// How the density is kept: 16-bit codes where every integer stays exact, or where half a code is at most 1/2000 of what the
/// middle 98 % of the values span; 32-bit floats otherwise, and where there is a NaN, for which there is no code.
pub(super) fn density_map(
    source: &dyn BrickSource,
    statistics: &Statistics,
    histogram: &Histogram,
    range: Option<[f64; 2]>,
) -> Result<DensityMap, DocumentError> {
    if let Some([lo, hi]) = range
        && !(lo.is_finite() && hi.is_finite() && lo < hi)
    {
        return Err(DocumentError::invalid("range", format!("[{lo}, {hi}]"), "two finite values, the smaller first"));
    }
    let (min, max) = range.map_or((statistics.min, statistics.max), |[lo, hi]| (lo, hi));
    let largest = min.abs().max(max.abs());
    if largest > f64::from(f32::MAX) && largest.is_finite() {
        // A few numbers beyond all others mark what has no data; it is drawn as infinite. Where most are so large they are the data.
        let far = (0..histogram.bins.len()).filter(|&i| histogram.value_at(i as f64 + 0.5).abs() > largest * 0.01);
        let large: u64 = far.map(|i| histogram.bins[i]).sum();
        let most = large * 2 > histogram.bins.iter().sum();
        return Ok(if most { DensityMap::floats(largest) } else { DensityMap::FLOAT });
    }
    if statistics.nan_count > 0 || !(min.is_finite() && max.is_finite()) {
        return Ok(DensityMap::FLOAT);
    }
    if min == max && unit(source).is_none() {
        // One value tells nothing of the steps that what is painted beside it will need.
        return Ok(DensityMap::FLOAT);
    }
    Ok(map_over(min, max, unit(source), (range.is_none()).then(|| middle(histogram))))
}

/// The map of values in `[min, max]`; see [`density_map`]. `middle` is the width of the values that must stay apart.
pub(super) fn map_over(min: f64, max: f64, unit: Option<f64>, middle: Option<f64>) -> DensityMap {
    let map = DensityMap::codes(min, max, unit);
    let exact = unit.is_some_and(|u| (max - min) / u <= 65_535.0);
    let fine = middle.is_none_or(|m| map.half_step() <= m / 2000.0);
    // Steps near the smallest number have no codes per unit.
    if map.codes_per_unit.is_finite() && (exact || (unit.is_none() && fine)) {
        map
    } else {
        DensityMap { format: TexelFormat::R32Float, ..DensityMap::FLOAT }
    }
}

/// From the first to the last hundredth of the values, never less than a bin.
fn middle(histogram: &Histogram) -> f64 {
    let total: u64 = histogram.bins.iter().sum();
    let width = histogram.bin_width();
    let bin_at = |share: f64| {
        let mut seen = 0;
        histogram.bins.iter().position(|n| {
            seen += n;
            seen as f64 >= total as f64 * share
        })
    };
    match (bin_at(0.01), bin_at(0.99)) {
        (Some(a), Some(b)) => width * (b - a + 1) as f64,
        _ => width,
    }
}
