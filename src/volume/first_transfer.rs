//! The transfer function that a volume begins with, from the counts of its values.
//!
//! Knows a label map from a CT from anything else by its histogram alone; nothing of grids or views.

use crate::volume::histogram::Histogram;
use crate::volume::segments::Segment;
use crate::volume::transfer::TransferFunction;

/// The largest value of a point that is found from data: room for one above it.
pub(super) const MOST: f64 = 1e308;
/// Ids that get a step of colour each; of more, a point.
const STEPS: usize = 128;

/// What is dark, what is like skin, what is like bone.
const COLOURS: [[f32; 3]; 4] = [[0.55, 0.30, 0.22], [0.72, 0.42, 0.30], [0.93, 0.80, 0.66], [1.0, 1.0, 1.0]];

impl TransferFunction {
    /// A start from the data. Of measurements everything up to the edge of the background is clear, then opacity rises to the last
    /// hundredths of what is not, steeply enough that a brush paints near what is seen: the surface is where half of the light has
    /// gone. Colours go from dark through skin to white; in a CT they lie where skin and bone do. What stands where nothing was
    /// measured is clear. In a label map each id has a colour of its own and the smallest is clear. One value alone is shown as a
    /// haze, and what is painted above it as matter.
    pub fn from_histogram(histogram: &Histogram, unit_mm: f64) -> Self {
        if !histogram.ids.is_empty() {
            return of_ids(&histogram.ids, unit_mm);
        }
        let (colour, mut opacity) = match histogram.constant() {
            Some(value) => of_one(value),
            None if histogram.is_hounsfield() => of_ct(),
            None => of_measurements(histogram),
        };
        if let (true, Some(&(last, most))) = (histogram.voids[1] > 0, opacity.last()) {
            // Far enough above the values that what is painted there shows.
            let (_, end) = apart(last, histogram.max + 0.5 * (histogram.max - histogram.min), histogram.bin_width());
            let (_, clear) = apart(end, end, histogram.bin_width());
            opacity.extend([(end, most), (clear, 0.0)]);
        }
        Self { colour, opacity, unit_mm }
    }
}

type Points<T> = Vec<(f64, T)>;

fn of_one(value: f64) -> (Points<[f32; 3]>, Points<f32>) {
    let value = value.clamp(-MOST, MOST * 0.25);
    let above = value + value.abs().max(1.0);
    (vec![(value, COLOURS[2]), (above, COLOURS[3])], vec![(value, 0.6), (above, 1.0)])
}

fn of_ct() -> (Points<[f32; 3]>, Points<f32>) {
    let skin = [0.82, 0.52, 0.40];
    let values = [-500.0, -150.0, 60.0, 220.0, 900.0];
    let colours = [COLOURS[0], COLOURS[1], skin, COLOURS[2], COLOURS[3]];
    let opacities = [0.0, 0.06, 0.10, 0.25, 0.7];
    (values.into_iter().zip(colours).collect(), values.into_iter().zip(opacities).collect())
}

fn of_measurements(histogram: &Histogram) -> (Points<[f32; 3]>, Points<f32>) {
    let bins = histogram.bins.len();
    let top = histogram.classes().map_or(bins as f64, |c| histogram.share_below(c.upper..bins, 0.995));
    let (clear, top) = apart(histogram.value_at(histogram.clear()), histogram.value_at(top), histogram.bin_width());
    let places = [0.0, 0.35, 0.7, 1.0].map(|t| crate::volume::transfer::mix(clear, top, t));
    let opacities = [0.0, 0.08, 0.35, 0.6];
    (places.into_iter().zip(COLOURS).collect(), places.into_iter().zip(opacities).collect())
}

/// Two ends a bin apart at least, and no nearer than 32-bit floats can tell them; both well within all numbers.
pub(super) fn apart(lo: f64, hi: f64, bin: f64) -> (f64, f64) {
    let lo = lo.clamp(-MOST, MOST * 0.5);
    let least = bin.max(lo.abs() * 1e-5).max(f64::from(f32::MIN_POSITIVE));
    let hi = hi.clamp(-MOST, MOST);
    (lo, if hi - lo >= least { hi } else { lo + least })
}

/// A colour for each id. A ray that enters a body meets values between the background's and the body's first, and among them other
/// bodies' ids: where there are others, so little shows of a voxel that the many behind count for more.
fn of_ids(ids: &[f64], unit_mm: f64) -> TransferFunction {
    let shown = &ids[1..];
    let first = shown.first().copied().unwrap_or(1.0);
    let reach = |a: f64, b: f64| ((b - a) * 0.5).min(0.5) * 0.98;
    let mut colour = Vec::new();
    for (i, &id) in shown.iter().enumerate() {
        // By its place in the list, so that ids that lie far apart still differ from their neighbours.
        let own = Segment::new((i + 1) as u16).colour;
        if shown.len() > STEPS {
            colour.push((id, own));
            continue;
        }
        let before = reach(if i == 0 { ids[0] } else { shown[i - 1] }, id);
        let after = reach(id, shown.get(i + 1).copied().unwrap_or(id + 1.0));
        if id - before < id + after {
            colour.extend([(id - before, own), (id + after, own)]);
        } else {
            // So large that there is nothing about it.
            colour.push((id, own));
        }
    }
    let opacity = if shown.len() > 1 { 0.3 } else { 0.5 };
    let at = |share: f64| ids[0] + (first - ids[0]) * share;
    TransferFunction { colour, opacity: vec![(at(0.4), 0.0), (at(0.6), opacity)], unit_mm }
}
