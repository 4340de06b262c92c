//! Ready looks: transfer functions for what people want to see, and where a surface is best begun.
//!
//! CT in Hounsfield units is known by its air and has looks by value; any other data has looks by how its values are spread, since
//! an MR value has no unit. Knows the histogram only.

use crate::volume::first_transfer::{MOST, apart};
use crate::volume::histogram::Histogram;
use crate::volume::transfer::TransferFunction;
use crate::volume::transfer::mix;

/// A look that is chosen by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Preset {
    /// What it shows.
    pub name: &'static str,
    /// One line more.
    pub tip: &'static str,
    /// Colours and opacities.
    pub function: TransferFunction,
}

/// Value, colour, opacity of one unit of length.
type Stop = (f64, [f32; 3], f32);

const SKIN: [[f32; 3]; 3] = [[0.70, 0.44, 0.34], [0.86, 0.64, 0.52], [0.96, 0.86, 0.76]];
const TISSUE: [[f32; 3]; 3] = [[0.42, 0.20, 0.18], [0.78, 0.52, 0.46], [0.95, 0.84, 0.78]];
const BONE: [[f32; 3]; 3] = [[0.58, 0.38, 0.26], [0.90, 0.80, 0.64], [1.0, 0.98, 0.94]];
const LUNG: [[f32; 3]; 3] = [[0.30, 0.42, 0.58], [0.52, 0.66, 0.82], [0.80, 0.88, 0.96]];

impl Histogram {
    /// Whether the values are those of a CT in Hounsfield units: whole air about −1000 and matter above water.
    pub fn is_hounsfield(&self) -> bool {
        let total: u64 = self.bins.iter().sum();
        let air = self.count_in(-1100.0, -800.0);
        (-4096.0..=-800.0).contains(&self.min) && self.max >= 200.0 && air as f64 >= total as f64 * 0.02
    }

    /// Values counted in bins that reach into `[lo, hi]`.
    fn count_in(&self, lo: f64, hi: f64) -> u64 {
        let reaches = |i: usize| self.value_at((i + 1) as f64) >= lo && self.value_at(i as f64) <= hi;
        (0..self.bins.len()).filter(|&i| reaches(i)).map(|i| self.bins[i]).sum()
    }

    /// The value that a share of all values above `floor` lie below.
    fn quantile_above(&self, floor: f64, share: f64) -> f64 {
        let above: Vec<(f64, u64)> = (0..self.bins.len())
            .map(|i| (self.value_at((i + 1) as f64), self.bins[i]))
            .filter(|&(edge, _)| edge > floor)
            .collect();
        let total: u64 = above.iter().map(|b| b.1).sum();
        let mut seen = 0;
        let found = above.iter().find(|(_, n)| {
            seen += n;
            seen as f64 >= total as f64 * share
        });
        found.map_or(self.max, |b| b.0)
    }

    /// The value where air ends and matter begins, if anything does.
    fn clear_value(&self) -> f64 {
        self.value_at(self.clear())
    }
}

impl TransferFunction {
    /// The looks that data of this histogram can have; opacities are those of `unit_mm`, at most the size of a voxel.
    pub fn presets(histogram: &Histogram, unit_mm: f64) -> Vec<Preset> {
        let make = |name, tip, stops: &[Stop]| Preset { name, tip, function: function(stops, histogram, unit_mm) };
        let ramp = |values: [f64; 3], colours: [[f32; 3]; 3], opacities: [f32; 3]| {
            [0, 1, 2].map(|i| (values[i], colours[i], opacities[i]))
        };
        if histogram.is_hounsfield() {
            let lung = ramp([-950.0, -750.0, -550.0], LUNG, [0.0, 0.05, 0.03]);
            let lung = [lung[0], lung[1], lung[2], (-400.0, LUNG[2], 0.0)];
            return vec![
                make("Skin", "The outer surface, opaque", &ramp([-400.0, -250.0, 100.0], SKIN, [0.0, 0.3, 0.6])),
                make(
                    "Soft tissue",
                    "Fat, muscle and organs, half clear",
                    &[(-150.0, TISSUE[0], 0.0), (0.0, TISSUE[1], 0.05), (80.0, TISSUE[2], 0.12), (300.0, BONE[1], 0.2)],
                ),
                make("Bone", "Nothing softer than bone", &ramp([150.0, 350.0, 1000.0], BONE, [0.0, 0.35, 0.7])),
                make("Lung", "Air spaces, clear around them", &lung),
                make(
                    "Bone in skin",
                    "Bone under a veil of skin",
                    &[
                        (-400.0, SKIN[1], 0.0),
                        (-200.0, SKIN[1], 0.02),
                        (100.0, SKIN[2], 0.02),
                        (300.0, BONE[1], 0.35),
                        (1000.0, BONE[2], 0.7),
                    ],
                ),
            ];
        }
        let clear = histogram.clear_value();
        let [low, middle, high, top] = [0.2, 0.5, 0.9, 0.99].map(|share| histogram.quantile_above(clear, share));
        let begin = mix(clear, middle, 0.3);
        vec![
            make("Skin", "The outer surface, opaque", &ramp([clear, begin, middle.max(begin)], SKIN, [0.0, 0.3, 0.6])),
            make(
                "Brain, soft tissue",
                "From dim to bright, half clear",
                &[(clear, TISSUE[0], 0.0), (low, TISSUE[0], 0.01), (middle, TISSUE[1], 0.06), (high, TISSUE[2], 0.2)],
            ),
            make(
                "Brightest",
                "Only the brightest tenth",
                &ramp([high, mix(high, top, 0.5), top], BONE, [0.0, 0.3, 0.6]),
            ),
            make("See-through", "Everything, as thin as mist", &ramp([clear, middle, top], LUNG, [0.0, 0.01, 0.05])),
        ]
    }

    /// A value for a first surface: from where matter stops being clear on, the first whose colour is light enough to show the
    /// surface's shape, but none deeper than the middle of the matter; the lightest if all are dark.
    pub fn first_surface(&self, histogram: &Histogram) -> f64 {
        let seen = self.opacity.iter().position(|p| p.1 > 0.0).unwrap_or(0);
        let start = self.opacity.get(seen.saturating_sub(1)).map_or(histogram.min, |p| p.0).max(histogram.min);
        let start = start.min(histogram.max);
        let end = histogram.quantile_above(start, 0.5).max(start);
        let luminance = |value: f64| {
            let [r, g, b] = self.colour_at(value);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let values = (1..=32).map(|i| mix(start, end, f64::from(i) / 32.0));
        let light = values.clone().find(|&v| luminance(v) >= 0.34);
        light.or_else(|| values.max_by(|a, b| luminance(*a).total_cmp(&luminance(*b)))).unwrap_or(end)
    }
}

/// A function through stops, moved apart where the data leave them no room.
fn function(stops: &[Stop], histogram: &Histogram, unit_mm: f64) -> TransferFunction {
    let step = histogram.max * 1e-3 - histogram.min * 1e-3;
    let mut function = TransferFunction { colour: Vec::new(), opacity: Vec::new(), unit_mm };
    for &(value, colour, opacity) in stops {
        // Room above for all that have to move.
        let value = value.clamp(-0.4 * MOST, 0.4 * MOST);
        let last = function.opacity.last().copied();
        let value = last.map_or(value, |(last, _)| apart(last, value, step).1);
        function.colour.push((value, colour));
        function.opacity.push((value, opacity));
    }
    function
}
