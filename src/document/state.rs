//! What is open: the scene with its past, the four fields and the source behind the density.
//!
//! This is all that a save writes and all that undo brings back. Knows neither history nor the GPU, and can be built on a
//! thread of its own, since reading a volume takes seconds.

use crate::document::disk::source_files::SourceFiles;
use crate::document::error::DocumentError;
use crate::document::scene::Scene;
use crate::document::scene::past::Past;
use crate::io::FileMark;
use crate::paint::Reach;
use crate::volume::{BrickSource, DensityMap, Field, FieldKind, Grid, Histogram, Statistics, TexelFormat, unit};
use std::sync::Arc;

/// Of a stroke in floats: of what was there, what is painted, their difference, its share and the sum, each half a unit in the last
/// place of up to twice the largest number.
const ROUNDINGS: f64 = 4.0;

/// See the module's head. Cheap to clone: bricks are shared.
#[derive(Clone, Debug)]
pub struct State {
    /// Everything but voxels.
    pub scene: Scene,
    /// Earlier views and looks.
    pub past: Past,
    /// The volume's values with their edits.
    pub density: Field,
    /// Painted colour.
    pub colour: Field,
    /// Degree of interest.
    pub selection: Field,
    /// Labels.
    pub labels: Field,
    /// Where unedited density comes from.
    pub source: Arc<dyn BrickSource>,
    /// Of the source's values.
    pub statistics: Statistics,
    /// Of the source's values.
    pub histogram: Histogram,
    /// Between which values density was painted, once it was.
    pub reach: Option<Reach>,
    /// The files that unedited density is read from; `None` if it is in the project.
    pub files: Option<Arc<SourceFiles>>,
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
        Self::over(source, origin, files, statistics, histogram, range, progress)
    }

    /// The same with all files that the source reads, as they were when they were opened.
    pub(super) fn over(
        source: Arc<dyn BrickSource>,
        origin: crate::document::scene::Origin,
        files: Vec<FileMark>,
        statistics: Statistics,
        histogram: Histogram,
        range: Option<[f64; 2]>,
        progress: &(dyn Fn(f32) -> bool + Sync),
    ) -> Result<Self, DocumentError> {
        let map = density_map(source.as_ref(), &statistics, &histogram, range)?;
        let density = Field::from_source(source.clone(), map, progress)?.ok_or(DocumentError::Stopped)?;
        let grid = *source.grid();
        let files = if files.is_empty() { None } else { Some(SourceFiles::opened(files)) };
        Ok(Self {
            scene: Scene::new(&grid, &histogram, origin),
            past: Past::default(),
            density,
            colour: Field::blank(FieldKind::Colour, &grid),
            selection: Field::blank(FieldKind::Selection, &grid),
            labels: Field::blank(FieldKind::Labels, &grid),
            source,
            statistics,
            histogram,
            reach: None,
            files,
        })
    }

    /// The lattice that all fields share.
    pub fn grid(&self) -> &Grid {
        self.source.grid()
    }

    /// The most by which a painted value may differ from what comes back of it, anywhere in the volume as it is now. What was not
    /// painted comes back as the source has it.
    pub fn half_step(&self) -> f64 {
        let map = self.density.map();
        // Extremes are known to 32 bits; codes end where their map does.
        let painted = match map.format {
            TexelFormat::R32Float => self.density.extremes().map(f64::from),
            _ => [map.lo, map.hi()],
        };
        let largest = [self.statistics.min, self.statistics.max, painted[0], painted[1]]
            .into_iter()
            .map(f64::abs)
            .filter(|v| v.is_finite())
            .fold(self.largest_painted(), f64::max);
        self.half_step_of(largest)
    }

    /// The same of a voxel that was painted to a value from this one of the source.
    pub fn half_step_at(&self, value: f64, own: f64) -> f64 {
        let mixed = value.abs().max(self.largest_painted());
        // What is so much larger than anything painted leaves no digit of it if it is mixed with that.
        let from = if own.abs() * f64::from(f32::EPSILON) <= 2.0 * mixed { own.abs() } else { 0.0 };
        self.half_step_of(if self.density.format() == TexelFormat::R32Float { mixed.max(from) } else { value })
    }

    fn largest_painted(&self) -> f64 {
        self.reach.map_or(0.0, |reach| reach.largest())
    }

    /// Of numbers of this size: rounding to the texel, and in the kernel's 32 bits to that of each number which it was made from.
    fn half_step_of(&self, size: f64) -> f64 {
        let map = self.density.map();
        let roundings = if map.format == TexelFormat::R32Float { ROUNDINGS } else { 1.0 };
        map.error_at(size, unit(self.source.as_ref()).is_some()) * roundings
    }

    /// A field by its kind.
    pub fn field(&self, kind: FieldKind) -> &Field {
        match kind {
            FieldKind::Density => &self.density,
            FieldKind::Colour => &self.colour,
            FieldKind::Selection => &self.selection,
            FieldKind::Labels => &self.labels,
        }
    }

    /// The same, to change it; whoever does keeps the history.
    pub fn field_mut(&mut self, kind: FieldKind) -> &mut Field {
        match kind {
            FieldKind::Density => &mut self.density,
            FieldKind::Colour => &mut self.colour,
            FieldKind::Selection => &mut self.selection,
            FieldKind::Labels => &mut self.labels,
        }
    }
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
