//! A glance at a volume file before it is opened: is it an image, or do its values name regions?
//!
//! Only where the answer may be "regions" is the user asked. A segmentation that says so in its header or by its name is taken
//! at its word; else some slices are read: whole numbers, 0 for what is outside, and neighbours that are mostly equal. It takes
//! a moment at most; whatever takes longer, or cannot be read, is opened as an image, and opening says what is wrong.

use crate::io;
use crate::ui::browse::names::ends_with;
use crate::volume::{BrickSource, Value};
use crate::with_voxels;
use std::collections::HashSet;
use std::path::Path;
use std::time::{Duration, Instant};

/// The moment.
const MOMENT: Duration = Duration::from_millis(2500);
/// Slices that are read, spread over the volume.
const SLICES: u32 = 24;
/// Voxels along each edge of a slice that are read at most.
const EDGE: u32 = 768;
/// Different values that regions may have.
const MOST_VALUES: usize = 4096;
/// Share of neighbours inside regions that must be equal: an image of 8 bits has a third of it at most, thin parcels of a brain's
/// surface four fifths.
const EQUAL: f64 = 0.6;

/// What a glance has found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Glance {
    /// An image, as far as can be seen.
    Image,
    /// Its header or its name says that it holds segments.
    Segments,
    /// Its values look like those of regions.
    Regions,
}

/// Looks at a file; `go_on` is asked now and then.
pub fn glance(path: &Path, proceed: &(dyn Fn() -> bool + Sync)) -> Glance {
    let begun = Instant::now();
    let in_time = |_| begun.elapsed() < MOMENT && proceed();
    let Ok(opened) = io::open(path) else { return Glance::Image };
    let named = path.file_name().is_some_and(|name| ends_with(name, &[".seg.nrrd"]));
    if named || !opened.labels.is_empty() {
        return Glance::Segments;
    }
    if opened.components > 1 || opened.frames > 1 {
        return Glance::Image;
    }
    let Ok(source) = opened.source(0, 0, &in_time) else { return Glance::Image };
    if looks_like_regions(source.as_ref(), &|| in_time(0.0)) { Glance::Regions } else { Glance::Image }
}

/// What some slices say of a volume's values.
#[derive(Default)]
struct Seen {
    values: HashSet<i64>,
    outside: u64,
    pairs: u64,
    equal: u64,
}

fn looks_like_regions(source: &dyn BrickSource, proceed: &dyn Fn() -> bool) -> bool {
    let [nx, ny, nz] = source.grid().dims;
    let size = [nx.min(EDGE), ny.min(EDGE), 1];
    let lo = |z: u32| [(nx - size[0]) / 2, (ny - size[1]) / 2, z];
    let (slope, intercept) = source.scaling();
    let count = nz.min(SLICES);
    let mut seen = Seen::default();
    for i in 0..count {
        let z = (u64::from(nz) * (2 * u64::from(i) + 1) / (2 * u64::from(count))) as u32;
        let Ok(voxels) = source.read(lo(z), size) else { return false };
        let regions = with_voxels!(&voxels, v => seen.take(v, size[0] as usize, slope, intercept));
        if !regions || !proceed() {
            return false;
        }
    }
    seen.outside > 0 && seen.pairs > 0 && seen.equal as f64 >= EQUAL * seen.pairs as f64
}

impl Seen {
    /// Takes in a slice; `false` if no regions have such values.
    fn take<T: Value>(&mut self, voxels: &[T], width: usize, slope: f64, intercept: f64) -> bool {
        for row in voxels.chunks(width.max(1)) {
            let mut last = None;
            for voxel in row {
                let value = voxel.to_f64() * slope + intercept;
                let whole = value.round();
                // Slopes of NIfTI have 24 bits.
                if !((0.0..9e15).contains(&value) && (value - whole).abs() <= 1e-6 * whole.max(1.0)) {
                    return false;
                }
                let value = whole as i64;
                if value == 0 {
                    self.outside += 1;
                } else if let Some(last) = last.filter(|&last| last != 0) {
                    self.pairs += 1;
                    self.equal += u64::from(last == value);
                }
                if last != Some(value) && self.values.insert(value) && self.values.len() > MOST_VALUES {
                    return false;
                }
                last = Some(value);
            }
        }
        true
    }
}
