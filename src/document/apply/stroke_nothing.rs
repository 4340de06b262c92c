//! Why a stroke changed nothing, in one plain sentence for whoever painted it.
//!
//! Looks at the fields as they are, which is as they were at the stroke's start, and at the stroke's own dabs. Changes nothing.

use crate::document::subject::Subject;
use crate::paint::{
    Brush, Confines, Dab, Footprint, IndexBox, Limit, Limits, Mirror, Operation, Sample, Side, StrokePath, Target, Tip,
    VoxelSet, with_images,
};
use crate::volume::{BRICK, BrickIndex, FieldKind, SLOT, SourceError};
use std::collections::HashMap;

/// Voxels that are looked at; of a larger stroke only what needs no look is told.
const MOST_VOXELS: u64 = 1 << 22;

/// The sentence; `missed` points met nothing, `seen` is the visible surface that it kept to, `confines` are sets that it kept within, its
/// dabs lie `step_mm` apart.
pub(super) fn why_nothing(
    subject: &Subject<'_>,
    brush: &Brush,
    (samples, missed): (&[Sample], u64),
    (seen, confines, step_mm): (&VoxelSet, &Confines, f64),
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
    let Subject { volume, .. } = *subject;
    let (density, selection, labels) = (&volume.density, &volume.selection, &volume.labels);
    let limits = Limits { brush, grid: subject.grid(), density, selection, labels, seen, confines };
    let open = Open::under(subject, &limits, &footprints, &bounds)?;
    if let Some(limit) = open.shut {
        return Ok(kept_off(subject, brush, limit));
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
    match &brush.mirror {
        Mirror::Plane(plane) => with_images(plane, &dabs),
        _ => dabs,
    }
}

/// What is said where a limit leaves nothing of what the brush covers.
fn kept_off(subject: &Subject<'_>, brush: &Brush, limit: Limit) -> String {
    let side = |side: Option<Side>| if side == Some(Side::Outside) { "outside" } else { "inside" };
    match limit {
        Limit::Visible => "Nothing under the brush shows in the 3D view, and it paints only what does.".into(),
        Limit::Depth => {
            let depth = brush.within_mm.unwrap_or_default();
            format!("Nothing under the brush lies within {depth} mm of the surface that the 3D view shows.")
        }
        Limit::Connected => {
            "Nothing under the brush is connected to something that shows where the stroke began.".into()
        }
        Limit::Contour => "No voxel lies in the contour.".into(),
        Limit::SubVolumes => "All that the brush covers lies in sub-volumes, which are painted in its place.".into(),
        Limit::Selection => {
            format!(
                "Nothing under the brush lies {} the selection, where alone it may paint.",
                side(brush.only.selection)
            )
        }
        Limit::Segment => {
            let of = brush.only.segment;
            let id = of.map_or(0, |of| of.id);
            let name = subject.segments().get(id).map_or_else(|| id.to_string(), |s| s.name.clone());
            let side = side(of.map(|of| of.side));
            format!("Nothing under the brush lies {side} the segment {name}, where alone it may paint.")
        }
        Limit::Range => match brush.range {
            Some([lo, hi]) => {
                format!("No voxel under the brush has a value from {lo} to {hi}, where alone it may paint.")
            }
            None => "No voxel under the brush has a value that may be painted.".into(),
        },
    }
}

/// What keeps the brush from the voxels that it covers.
struct Open {
    /// The limit that leaves none of what those before it left.
    shut: Option<Limit>,
    /// The first locked label, if all that may be painted are locked.
    locked: Option<u16>,
}

impl Open {
    fn under(
        subject: &Subject<'_>,
        limits: &Limits<'_>,
        footprints: &[Footprint],
        bounds: &IndexBox,
    ) -> Result<Self, SourceError> {
        let unknown = Self { shut: None, locked: None };
        let size: [u32; 3] = std::array::from_fn(|a| bounds.end[a] - bounds.lo[a]);
        let looked: u64 = footprints.iter().map(|f| volume(&f.bounds)).sum();
        if volume(bounds) > MOST_VOXELS || looked > MOST_VOXELS {
            return Ok(unknown);
        }
        let labels = match limits.brush.target.field() {
            FieldKind::Labels => subject.labels.read(0, bounds.lo.map(i64::from), size)?,
            _ => Vec::new(),
        };
        let mut gates = HashMap::new();
        for brick in bounds.bricks() {
            gates.insert(brick, limits.each(brick)?);
        }
        let names: Vec<Limit> = gates.values().next().map_or_else(Vec::new, |of| of.iter().map(|g| g.0).collect());
        // How many voxels each limit leaves of those that the ones before it left.
        let mut left = vec![0_u64; names.len()];
        let (mut covered, mut locked, mut free) = (false, None, false);
        for footprint in footprints {
            for voxel in footprint.bounds.voxels().filter(|&v| footprint.coverage(v) > 0.0) {
                let [x, y, z] = std::array::from_fn(|a| (voxel[a] - bounds.lo[a]) as usize);
                let i = x + size[0] as usize * (y + size[1] as usize * z);
                covered = true;
                let open = (0..names.len()).take_while(|&n| is_open(&gates, n, voxel)).count();
                left.iter_mut().take(open).for_each(|count| *count += 1);
                if open < names.len() {
                    continue;
                }
                let label = labels.get(2 * i..2 * i + 2).map_or(0, |t| u16::from_le_bytes([t[0], t[1]]));
                match subject.segments().get(label) {
                    Some(segment) if segment.locked => locked = locked.or(Some(label)),
                    _ => free = true,
                }
            }
        }
        let shut = names.iter().zip(left).find(|(_, left)| covered && *left == 0).map(|(limit, _)| *limit);
        Ok(Self { shut, locked: locked.filter(|_| !free) })
    }
}

/// Whether a limit lets a voxel be painted.
fn is_open(gates: &HashMap<BrickIndex, Vec<(Limit, Vec<u32>)>>, limit: usize, voxel: [u32; 3]) -> bool {
    let [x, y, z] = voxel.map(|v| v % BRICK + 1);
    let texel = (x + SLOT * (y + SLOT * z)) as usize;
    let bits = gates.get(&BrickIndex::of_voxel(voxel)).and_then(|of| of.get(limit));
    bits.is_some_and(|(_, bits)| bits[texel / 32] >> (texel % 32) & 1 == 1)
}

fn volume(bounds: &IndexBox) -> u64 {
    (0..3).map(|a| u64::from(bounds.end[a] - bounds.lo[a])).product()
}
