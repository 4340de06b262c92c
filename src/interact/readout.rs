//! Numbers and answers as a person reads them in passing: lengths of scale bars, values under the pointer, what a crash left.

use crate::document::answers::{RecoveredSaid, StrokeFate};
use crate::math::DVec3;
use crate::volume::{Number, SubBox, VoxelType};

/// The largest 1, 2 or 5 × 10ⁿ that is not longer.
pub fn round_length(mm: f64) -> f64 {
    let power = 10.0_f64.powf(mm.log10().floor());
    [5.0, 2.0].into_iter().map(|m| m * power).find(|&l| l <= mm).unwrap_or(power)
}

/// A length in the unit that it is said in.
pub fn length(mm: f64) -> String {
    let (value, unit) = match mm {
        1000.0.. => (mm / 1000.0, "m"),
        10.0.. => (mm / 10.0, "cm"),
        0.1.. => (mm, "mm"),
        1e-4.. => (mm * 1e3, "µm"),
        _ => (mm * 1e6, "nm"),
    };
    // One, two or five times a power of ten has no more digits than this.
    format!("{} {unit}", (value * 1e6).round() / 1e6)
}

/// The unit that lengths of a grid are told in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthUnit {
    /// With the space before it.
    pub name: &'static str,
    /// How many there are in a millimetre.
    pub per_mm: f64,
    /// Decimals that tell a tenth of a voxel, 0 to 9.
    pub decimals: usize,
}

impl LengthUnit {
    /// Of a grid with voxels of this size.
    pub fn of(voxel_mm: f64) -> Self {
        let (name, per_mm) = match voxel_mm {
            500.0.. => (" m", 1e-3),
            0.01.. => (" mm", 1.0),
            1e-5.. => (" µm", 1e3),
            _ => (" nm", 1e6),
        };
        // Voxels of about a unit have one decimal.
        let decimals = (1.7 - (voxel_mm * per_mm).log10()).clamp(0.0, 9.0).floor() as usize;
        Self { name, per_mm, decimals }
    }
}

/// A place in world mm, in the unit of a grid with voxels of this size; each number in as much room, so that they do not dance.
pub fn place(world: DVec3, voxel_mm: f64) -> String {
    let LengthUnit { name, per_mm, decimals } = LengthUnit::of(voxel_mm);
    let number = |mm: f64| format!("{:>1$.2$}", mm * per_mm + 0.0, decimals.max(1) + 6, decimals);
    format!("{} {} {}{name}", number(world.x), number(world.y), number(world.z))
}

/// Six digits at most: a status line is read in passing.
pub fn short(value: f64) -> String {
    if value.fract() == 0.0 && value.abs() < 1e9 {
        format!("{value:.0}")
    } else if (1e-3..1e6).contains(&value.abs()) {
        let decimals = (5 - value.abs().log10().floor() as i32).clamp(0, 6) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.4e}")
    }
}

/// A voxel's value: what its type holds to the last digit, so that it can be typed in again; six digits of what was painted
/// between two of the type's numbers.
pub fn value(number: Number, voxel_type: VoxelType) -> String {
    match number {
        Number::Real(x) if x.is_nan() => "not a number".into(),
        Number::Real(x) if x.is_infinite() => if x > 0.0 { "infinite" } else { "−infinite" }.into(),
        Number::Real(x) if voxel_type == VoxelType::F32 && f64::from(x as f32) == x => {
            digits(format!("{:?}", x as f32))
        }
        Number::Real(x) if voxel_type == VoxelType::F64 => digits(format!("{x:?}")),
        Number::Real(x) => short(x),
        Number::Whole(n) => n.to_string(),
    }
}

/// Without the fraction of a whole number.
fn digits(text: String) -> String {
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// A number for a field of `chars` characters: with `decimals`, with fewer where they have no room, in powers of ten where those
/// keep more of it or the whole number has no room.
pub fn fixed(value: f64, decimals: usize, chars: usize) -> String {
    let fits = |text: &String| text.chars().count() <= chars;
    let plain = (0..=decimals).rev().map(|d| (format!("{value:.d$}"), d)).find(|(text, _)| fits(text));
    let powers = (0..4).rev().map(|d| format!("{value:.d$e}")).find(fits);
    let off = |text: &str| text.parse::<f64>().map_or(f64::INFINITY, |shown| (shown - value).abs());
    match (plain, powers) {
        (Some((plain, d)), Some(powers)) if d < decimals && off(&powers) < off(&plain) => powers,
        (Some((plain, _)), _) => plain,
        (None, powers) => powers.unwrap_or_else(|| format!("{value:.0e}")),
    }
}

/// Bytes as a person says them.
pub fn bytes(count: u64) -> String {
    const UNITS: [&str; 4] = ["kB", "MB", "GB", "TB"];
    if count < 1000 {
        return format!("{count} B");
    }
    let (mut value, mut unit) = (count as f64 / 1000.0, 0);
    while value >= 999.5 && unit + 1 < UNITS.len() {
        value /= 1000.0;
        unit += 1;
    }
    if value < 9.95 { format!("{value:.1} {}", UNITS[unit]) } else { format!("{value:.0} {}", UNITS[unit]) }
}

/// How large a sub-volume is, and the memory that it may take at so many bytes a sample.
pub fn box_size(of: &SubBox, sample_bytes: u64) -> String {
    let [x, y, z] = of.dims();
    format!("{x} × {y} × {z} samples, at most {}", bytes(of.samples() * sample_bytes))
}

/// From one value to another that is not smaller, as far as numbers go.
pub fn span([lo, hi]: [f64; 2]) -> f64 {
    (hi - lo).min(f64::MAX)
}

/// Decimals that tell a thousandth of `span` from none.
pub fn decimals(span: f64) -> usize {
    if span.is_finite() && span > 0.0 { (2 - span.log10().floor() as i32).clamp(0, 9) as usize } else { 0 }
}

/// A value of data that span so much, for a field of `chars` characters: with the decimals that it has, as far as they matter.
pub fn field(value: f64, span: f64, chars: usize) -> String {
    trimmed(value, decimals(span) + 3, chars)
}

/// Level or width of a grey window so wide: a thousandth of it is seen by nobody.
pub fn grey(value: f64, width: f64, chars: usize) -> String {
    trimmed(value, decimals(width) + 1, chars)
}

/// With so many decimals at most, and none that are 0 at its end.
fn trimmed(value: f64, decimals: usize, chars: usize) -> String {
    let text = fixed(value, decimals, chars);
    if text.contains('.') && !text.contains('e') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// How long ago something was, to the unit that one would say aloud.
pub fn ago(seconds: u64) -> String {
    let said = |n: u64, unit: &str| format!("{n} {unit}{} ago", if n == 1 { "" } else { "s" });
    match seconds {
        0..60 => "just now".into(),
        60..3600 => said(seconds / 60, "minute"),
        3600..86_400 => said(seconds / 3600, "hour"),
        _ => said(seconds / 86_400, "day"),
    }
}

/// What the answer of an opened project says of work that was not saved when the program ended; `None` if there was none.
pub fn recovered(recovered: &RecoveredSaid) -> Option<String> {
    let torn = (recovered.torn_bytes > 0).then_some(recovered.torn_bytes);
    let torn = torn
        .map(|n| format!("The step that was being noted when the program ended is lost ({n} bytes of it are there)."));
    let text = match (recovered.stroke, recovered.steps) {
        (StrokeFate::Painted, 0) => {
            "The stroke that was running when the program ended was brought back as far as it had come"
        }
        (StrokeFate::Painted, _) => {
            "What was not saved when the program ended was brought back, and the stroke that was running as far as it had \
             come"
        }
        (_, 0) => return torn,
        _ => "What was not saved when the program ended was brought back",
    };
    Some([Some(format!("{text}. Save to keep it.")), torn].into_iter().flatten().collect::<Vec<_>>().join(" "))
}

/// What stands behind a colon elsewhere as a sentence of its own; a name keeps its letters.
pub fn sentence(text: &str) -> String {
    let word = text.split(' ').next().unwrap_or_default();
    match word.chars().next() {
        Some(first) if word.chars().all(|c| c.is_ascii_lowercase()) => {
            first.to_uppercase().chain(text.chars().skip(1)).collect()
        }
        _ => text.to_owned(),
    }
}
