//! Why a stroke changed nothing, in one plain sentence for whoever painted it.
//!
//! Looks at the fields as they are, which is as they were at the stroke's start, and at the stroke's own dabs. Changes nothing.

use crate::document::subject::Subject;
use crate::paint::{Brush, Dab, Footprint, Gate, IndexBox, Operation, Sample, StrokePath, Target, Tip, VoxelSet};
use crate::volume::{BRICK, BrickIndex, FieldKind, SLOT, SourceError};
use std::collections::HashMap;

/// Voxels that are looked at; of a larger stroke only what needs no look is told.
const MOST_VOXELS: u64 = 1 << 22;

/// The sentence; `missed` points met nothing, `seen` is the visible surface that it kept to, its dabs lie `step_mm` apart.
pub(super) fn why_nothing(
    subject: &Subject<'_>,
    brush: &Brush,
    (samples, missed): (&[Sample], u64),
    (seen, step_mm): (&VoxelSet, f64),
) -> Result<String, SourceError> {
    if samples.is_empty() {
        return Ok(match missed {
            0 => "The stroke had no points.",
            _ => "Nothing was hit: the stroke lay beside everything that the 3D view shows.",
        }
        .into());
    }
    if brush.strength == 0.0 {
        return Ok("The brush's strength is 0.".into());
    }
    if samples.iter().all(|s| s.pressure == 0.0) {
        return Ok("The pressure was 0 all along.".into());
    }
    let footprints: Vec<_> =
        dabs(brush, samples, subject, step_mm).iter().filter_map(|d| d.footprint(brush, subject.grid())).collect();
    let Some(bounds) = footprints.iter().map(|f| f.bounds).reduce(|a, b| a.union(&b)) else {
        return Ok("The stroke lay outside the volume.".into());
    };
    if let Target::Label(_) = brush.target {
        let strongest = footprints.iter().map(|f| f.gain).fold(0.0, f32::max);
        if brush.tip == Tip::Wash && strongest < 0.5 {
            let percent = (strongest * 100.0).round();
            return Ok(format!("Labels take a strength times pressure of 50 % or more; here it was {percent} %."));
        }
    }
    let open = Open::under(subject, brush, &footprints, &bounds, seen)?;
    if !open.visible {
        return Ok("Nothing under the brush shows in the 3D view, and it paints only what does.".into());
    }
    if let (Some([lo, hi]), Open { in_range: false, .. }) = (brush.range, &open) {
        return Ok(format!("No voxel under the brush has a value from {lo} to {hi}, where alone it may paint."));
    }
    if let Some(label) = open.locked {
        let name = subject.segments().get(label).map_or_else(|| label.to_string(), |s| s.name.clone());
        return Ok(format!("The segment there is locked: {name}."));
    }
    Ok(match (brush.effective(), brush.target.field()) {
        (Operation::Restore, FieldKind::Density) => {
            "Nothing to restore: the values there are those of the file. To remove matter, let the eraser set a value."
        }
        (Operation::Restore, FieldKind::Selection) => "Nothing is selected there.",
        (Operation::Restore, FieldKind::Colour) => "Nothing is coloured there.",
        (Operation::Restore, FieldKind::Labels) => "No segment is there.",
        (Operation::Subtract, FieldKind::Labels) => "That segment is not there.",
        (Operation::Add | Operation::Subtract, _) => {
            "The values there are at the end of what can be stored, or the stroke is too weak to move them by one step."
        }
        _ => "What the stroke paints is there already, or it is too weak to move a value by one step.",
    }
    .into())
}

fn dabs(brush: &Brush, samples: &[Sample], subject: &Subject<'_>, step_mm: f64) -> Vec<Dab> {
    let Ok(mut path) = StrokePath::apart_by(step_mm, brush, subject.grid()) else { return Vec::new() };
    let mut dabs = path.extend(samples).unwrap_or_default();
    dabs.extend(path.end());
    dabs
}

/// What keeps the brush from the voxels that it covers.
struct Open {
    /// Whether one of them is of the visible surface, or need not be.
    visible: bool,
    /// Whether one of these has a value that may be painted.
    in_range: bool,
    /// The first locked label, if all that may be painted are locked.
    locked: Option<u16>,
}

impl Open {
    fn under(
        subject: &Subject<'_>,
        brush: &Brush,
        footprints: &[Footprint],
        bounds: &IndexBox,
        seen: &VoxelSet,
    ) -> Result<Self, SourceError> {
        let unknown = Self { visible: true, in_range: true, locked: None };
        let size: [u32; 3] = std::array::from_fn(|a| bounds.end[a] - bounds.lo[a]);
        let looked: u64 = footprints.iter().map(|f| volume(&f.bounds)).sum();
        if volume(bounds) > MOST_VOXELS || looked > MOST_VOXELS {
            return Ok(unknown);
        }
        let labels = match brush.target.field() {
            FieldKind::Labels => subject.labels.read(0, bounds.lo.map(i64::from), size)?,
            _ => Vec::new(),
        };
        let mut gates = HashMap::new();
        if let Some(range) = brush.range {
            let gate = Gate::new(range, &subject.density);
            for brick in bounds.bricks() {
                gates.insert(brick, gate.slot(&subject.density, brick)?);
            }
        }
        let (mut visible, mut in_range, mut locked, mut free) = (false, false, None, false);
        for footprint in footprints {
            for voxel in voxels(&footprint.bounds).filter(|&v| footprint.coverage(v) > 0.0) {
                let [x, y, z] = std::array::from_fn(|a| (voxel[a] - bounds.lo[a]) as usize);
                let i = x + size[0] as usize * (y + size[1] as usize * z);
                if brush.visible_only && !seen.contains(voxel) {
                    continue;
                }
                visible = true;
                if !gates.is_empty() && !is_open(&gates, voxel) {
                    continue;
                }
                in_range = true;
                let label = labels.get(2 * i..2 * i + 2).map_or(0, |t| u16::from_le_bytes([t[0], t[1]]));
                match subject.segments().get(label) {
                    Some(segment) if segment.locked => locked = locked.or(Some(label)),
                    _ => free = true,
                }
            }
        }
        Ok(Self { visible, in_range, locked: locked.filter(|_| !free) })
    }
}

/// Whether the range of values lets a voxel be painted.
fn is_open(gates: &HashMap<BrickIndex, Vec<u32>>, voxel: [u32; 3]) -> bool {
    let [x, y, z] = voxel.map(|v| v % BRICK + 1);
    let texel = (x + SLOT * (y + SLOT * z)) as usize;
    gates.get(&BrickIndex::of_voxel(voxel)).is_some_and(|bits| bits[texel / 32] >> (texel % 32) & 1 == 1)
}

fn volume(bounds: &IndexBox) -> u64 {
    (0..3).map(|a| u64::from(bounds.end[a] - bounds.lo[a])).product()
}

fn voxels(bounds: &IndexBox) -> impl Iterator<Item = [u32; 3]> + use<> {
    let IndexBox { lo, end } = *bounds;
    (lo[2]..end[2]).flat_map(move |z| (lo[1]..end[1]).flat_map(move |y| (lo[0]..end[0]).map(move |x| [x, y, z])))
}
