//! Label maps: the ids in another file as segments and labels of the document.
//!
//! Two passes over the file. The first finds which ids there are, any 64-bit integers in any type of number; they become ids of
//! the label field: the same number where it is 1 to 65535 and free, else the lowest that is free, and the segment remembers the
//! file's. The second takes for each voxel the file's nearest one by world position. Works brick by brick; what is read at once
//! is bounded, however fine the file is.

use crate::document::apply::overlap::{AT_ONCE, ROUNDING, Rows, Spread, scan};
use crate::document::command::answers::{BroughtSegment, LabelsSaid};
use crate::document::error::DocumentError;
use crate::document::subject::Subject;
use crate::io::NamedLabel;
use crate::math::{Aabb, DAffine3, DVec3};
use crate::volume::{
    BRICK, BRICK_VOXELS, Brick, BrickIndex, BrickSource, Changes, Segment, Segments, SourceError, Value, Voxels,
};
use crate::with_voxels;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Most ids at once: the label field holds 1 to 65535.
const MOST: usize = 65_535;
/// Of a scaled integer: how far the product may lie from a whole number, as a share of it. Slopes of NIfTI have 24 bits.
const SCALED: f64 = 1e-6;

/// What an import leads to; nothing is changed yet.
#[derive(Debug)]
pub(crate) struct Imported {
    /// Of the label field.
    pub changes: Changes,
    /// The table with what is new.
    pub segments: Segments,
    /// What the command answers.
    pub said: LabelsSaid,
    /// What was odd or left out.
    pub warnings: Vec<String>,
}

/// Reads `other` as labels over those of `subject`. `named` are the segments that the file's header names.
///
/// # Errors
/// If a value is no whole number, if there are too many different ones, if none lies in the volume, if the source fails, or
/// `progress` said no.
pub(crate) fn import(
    subject: &Subject<'_>,
    other: &dyn BrickSource,
    named: &[NamedLabel],
    progress: &(dyn Fn(f32) -> bool + Sync),
) -> Result<Imported, DocumentError> {
    let mut warnings = Vec::new();
    let survey = survey(subject, other, &|x| progress(x * 0.4))?;
    let covered = survey.spread.check(other.name(), "labels", subject.grid(), other.grid(), &mut warnings)?;
    let (ids, segments) = assign(subject.segments(), &survey.counts, named, other.name())?;
    let fill = Fill {
        subject,
        other,
        ids: &ids,
        spread: &survey.spread,
        other_from_index: other.grid().index_from_world() * subject.grid().world_from_index,
        locked: subject.segments().0.iter().filter(|s| s.locked).map(|s| s.id).collect(),
    };
    let Filled { changes, counts, kept_locked } = fill.bricks(&|x| progress(0.4 + x * 0.6))?;
    let lost = ids.values().filter(|id| !counts.contains_key(id)).count();
    if lost > 0 && survey.spread.inside > 0 {
        warnings.push(format!("{lost} of {} labels got no voxel of the volume", ids.len()));
    }
    if kept_locked > 0 {
        warnings.push(format!("{kept_locked} voxels keep the label they had: their segments are locked"));
    }
    let mut brought: Vec<(i128, u16)> = ids.iter().map(|(&value, &id)| (value, id)).collect();
    brought.sort_unstable();
    let listed = brought.into_iter().map(|(value, id)| {
        let name = segments.get(id).map(|s| s.name.clone());
        BroughtSegment { id, value, name, voxels: counts.get(&id).copied().unwrap_or(0) }
    });
    let said = LabelsSaid {
        segments: listed.collect(),
        labelled_voxels: counts.values().sum(),
        kept_locked,
        covered,
        resampled: !same_place(&fill.other_from_index, subject, other),
    };
    Ok(Imported { changes, segments, said, warnings })
}

/// Whether voxels lie on voxels.
fn same_place(other_from_index: &DAffine3, subject: &Subject<'_>, other: &dyn BrickSource) -> bool {
    let dims = subject.grid().dims;
    let off = |p: DVec3| (other_from_index.transform_point3(p) - p).abs().max_element();
    let far = subject.grid().dims_f64() - 1.0;
    let corners = Aabb { min: DVec3::ZERO, max: far }.corners();
    other.grid().dims == dims && corners.into_iter().all(|c| off(c) < 1e-3)
}

/// What is in a file of labels.
#[derive(Default)]
struct Survey {
    /// Voxels by id; 0 is no id.
    counts: BTreeMap<i128, u64>,
    spread: Spread,
}

fn survey(
    subject: &Subject<'_>,
    other: &dyn BrickSource,
    progress: &(dyn Fn(f32) -> bool + Sync),
) -> Result<Survey, DocumentError> {
    let rows = Rows::new(other.grid(), subject.grid());
    let add = |survey: &mut Survey, voxels: &Voxels, lo, size| with_voxels!(voxels, v => survey.add(other, v, lo, size, &rows));
    let join = |mut a: Survey, b: Survey| {
        a.spread.join(b.spread);
        for (id, n) in b.counts {
            *a.counts.entry(id).or_default() += n;
        }
        few(other.name(), a.counts.len())?;
        Ok(a)
    };
    scan(other, add, join, progress)
}

impl Survey {
    fn add<T: Value>(
        &mut self,
        other: &dyn BrickSource,
        voxels: &[T],
        lo: [u32; 3],
        size: [u32; 3],
        rows: &Rows,
    ) -> Result<(), DocumentError> {
        let scaling = other.scaling();
        for (n, row) in voxels.chunks_exact(size[0] as usize).enumerate() {
            let (j, k) = (lo[1] + n as u32 % size[1], lo[2] + n as u32 / size[1]);
            let inside = rows.inside(j, k);
            let mut i = 0;
            // Neighbours mostly have the same label: a run of them is judged once.
            for run in row.chunk_by(|a, b| bytemuck::bytes_of(a) == bytemuck::bytes_of(b)) {
                let (first, last) = (lo[0] + i, lo[0] + i + run.len() as u32 - 1);
                i += run.len() as u32;
                let id = id_of(run[0], scaling).map_err(|found| DocumentError::Labels {
                    file: other.name().into(),
                    found: format!("{found} at voxel [{first}, {j}, {k}]"),
                    expected: "whole numbers of at most 64 bits; open it as an image, or as a selection".into(),
                })?;
                if id == 0 {
                    continue;
                }
                let known = self.counts.len();
                *self.counts.entry(id).or_default() += run.len() as u64;
                if self.counts.len() > known {
                    few(other.name(), self.counts.len())?;
                }
                let within = (last + 1).min(inside.end).saturating_sub(first.max(inside.start));
                self.spread.join(Spread {
                    voxels: run.len() as u64,
                    inside: within.into(),
                    first: [first, j, k],
                    last: [last, j, k],
                });
            }
        }
        Ok(())
    }
}

/// Whether the label field has room for so many ids.
fn few(file: &str, count: usize) -> Result<(), DocumentError> {
    if count <= MOST {
        return Ok(());
    }
    Err(DocumentError::Labels {
        file: file.into(),
        found: format!("more than {MOST} different ids"),
        expected: format!("at most {MOST} beside 0; open it as an image, or merge ids before"),
    })
}

/// The label that a stored number is; what was found instead, if it is none.
fn id_of<T: Value>(stored: T, (slope, intercept): (f64, f64)) -> Result<i128, String> {
    if (slope, intercept) == (1.0, 0.0) && T::TYPE.is_integer() {
        // Exact also beyond 2⁵³, where `to_f64` is not.
        return Ok(match T::wrap(vec![stored]) {
            Voxels::U64(v) => v[0].into(),
            Voxels::I64(v) => v[0].into(),
            _ => stored.to_f64() as i128,
        });
    }
    let value = stored.to_f64() * slope + intercept;
    let whole = value.round();
    let tolerance = if T::TYPE.is_integer() { (value.abs() * SCALED).min(1e-3) } else { 0.0 };
    let fits = whole.abs() < 2.0_f64.powi(63);
    if fits && (value - whole).abs() <= tolerance { Ok(whole as i128) } else { Err(value.to_string()) }
}

/// The id in the label field of each of the file's, and the table with all of them.
fn assign(
    table: &Segments,
    counts: &BTreeMap<i128, u64>,
    named: &[NamedLabel],
    file: &str,
) -> Result<(HashMap<i128, u16>, Segments), DocumentError> {
    let names: BTreeMap<i128, &NamedLabel> = named.iter().filter(|n| n.value != 0).map(|n| (n.value, n)).collect();
    let name_of = |value: i128| match names.get(&value).and_then(|n| n.name.clone()) {
        Some(name) => name,
        None => format!("Segment {value}"),
    };
    let known: HashMap<(i128, &str), u16> = table.0.iter().map(|s| ((s.file_value(), s.name.as_str()), s.id)).collect();
    let mut taken: HashSet<u16> = table.0.iter().map(|s| s.id).collect();
    let mut ids = HashMap::new();
    let mut later = Vec::new();
    // A segment that the header names and no voxel has is one all the same.
    let values: std::collections::BTreeSet<i128> = counts.keys().chain(names.keys()).copied().collect();
    for value in values {
        if let Some(&id) = known.get(&(value, name_of(value).as_str())) {
            ids.insert(value, id);
            continue;
        }
        match u16::try_from(value).ok().filter(|id| *id > 0 && taken.insert(*id)) {
            Some(id) => drop(ids.insert(value, id)),
            None => later.push(value),
        }
    }
    let free: Vec<u16> = (1..=u16::MAX).filter(|id| !taken.contains(id)).take(later.len()).collect();
    if free.len() < later.len() {
        let found = format!("{} ids where {} are free", later.len(), free.len());
        let expected = format!("at most {MOST} segments in all; remove some before");
        return Err(DocumentError::Labels { file: file.into(), found, expected });
    }
    ids.extend(later.into_iter().zip(free));
    let mut segments = table.clone();
    // As one list: put in one by one, tens of thousands would each move all that come after.
    for (&value, &id) in ids.iter().filter(|(_, id)| table.get(**id).is_none()) {
        let source_value = (value != i128::from(id)).then_some(value);
        let colour = names.get(&value).and_then(|n| n.colour);
        let segment = Segment { name: name_of(value), source_value, ..Segment::new(id) };
        segments.0.push(Segment { colour: colour.unwrap_or(segment.colour), ..segment });
    }
    segments.0.sort_by_key(|s| s.id);
    Ok((ids, segments))
}

/// The second pass.
struct Fill<'a> {
    subject: &'a Subject<'a>,
    other: &'a dyn BrickSource,
    ids: &'a HashMap<i128, u16>,
    spread: &'a Spread,
    other_from_index: DAffine3,
    locked: HashSet<u16>,
}

#[derive(Default)]
struct Filled {
    changes: Changes,
    /// Voxels that got a label, by id.
    counts: BTreeMap<u16, u64>,
    kept_locked: u64,
}

impl Fill<'_> {
    fn bricks(&self, progress: &(dyn Fn(f32) -> bool + Sync)) -> Result<Filled, DocumentError> {
        let bricks = self.subject.volume.labels.brick_indices(0);
        let begun = AtomicUsize::new(0);
        bricks
            .par_iter()
            .map(|&index| {
                if !progress(begun.fetch_add(1, Ordering::Relaxed) as f32 / bricks.len() as f32) {
                    return Err(DocumentError::Stopped);
                }
                self.brick(index)
            })
            .try_reduce(Filled::default, |mut a, b| {
                a.changes.extend(b.changes);
                b.counts.into_iter().for_each(|(id, n)| *a.counts.entry(id).or_default() += n);
                a.kept_locked += b.kept_locked;
                Ok(a)
            })
    }

    fn brick(&self, index: BrickIndex) -> Result<Filled, DocumentError> {
        let field = &self.subject.volume.labels;
        let mut new = vec![0_u16; BRICK_VOXELS];
        self.sample(index.origin(), field.valid(0, index), index.origin(), &mut new)?;
        let mut filled = Filled::default();
        if new.iter().all(|&id| id == 0) {
            return Ok(filled);
        }
        let bytes = field.format().bytes();
        let mut texels = match field.edit(index) {
            Some(brick) => brick.to_texels(bytes),
            None => vec![0; BRICK_VOXELS * bytes],
        };
        for (texel, id) in texels.chunks_exact_mut(bytes).zip(new).filter(|(_, id)| *id != 0) {
            let old = u16::from_le_bytes([texel[0], texel[1]]);
            if old != id && self.locked.contains(&old) {
                filled.kept_locked += 1;
                continue;
            }
            texel.copy_from_slice(&id.to_le_bytes());
            *filled.counts.entry(id).or_default() += 1;
        }
        filled.changes.push((index, Some(Brick::from_texels(texels, bytes))));
        Ok(filled)
    }

    /// Labels of a box of ours that lies in one brick, written at their place in it.
    fn sample(&self, lo: [u32; 3], size: [u32; 3], origin: [u32; 3], out: &mut [u16]) -> Result<(), SourceError> {
        let low = DVec3::new(f64::from(lo[0]), f64::from(lo[1]), f64::from(lo[2]));
        let high = low + DVec3::new(f64::from(size[0]), f64::from(size[1]), f64::from(size[2])) - 1.0;
        let corners = Aabb { min: low, max: high }.corners().map(|c| self.other_from_index.transform_point3(c));
        let bounds = Aabb::around(corners).unwrap_or(Aabb { min: low, max: high });
        let (mut from, mut count) = ([0_u32; 3], [0_u32; 3]);
        for a in 0..3 {
            // Only where the file has labels at all.
            let first = (bounds.min[a] + 0.5 - ROUNDING).floor().max(f64::from(self.spread.first[a]));
            let last = (bounds.max[a] + 0.5 + ROUNDING).floor().min(f64::from(self.spread.last[a]));
            if self.spread.voxels == 0 || first > last {
                return Ok(());
            }
            (from[a], count[a]) = (first as u32, (last - first) as u32 + 1);
        }
        let longest = if size[2] > 1 { 2 } else { usize::from(size[1] > 1) };
        if count.iter().map(|&n| u64::from(n)).product::<u64>() > AT_ONCE && size[longest] > 1 {
            let half = size[longest] / 2;
            let (mut first, mut second, mut middle) = (size, size, lo);
            first[longest] = half;
            second[longest] -= half;
            middle[longest] += half;
            self.sample(lo, first, origin, out)?;
            return self.sample(middle, second, origin, out);
        }
        let ids = self.ids_of(&self.other.read(from, count)?);
        for z in 0..size[2] {
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let at = low + DVec3::new(f64::from(x), f64::from(y), f64::from(z));
                    let p = self.other_from_index.transform_point3(at);
                    let mut place = 0;
                    let mut inside = true;
                    for a in [2, 1, 0] {
                        let end = f64::from(self.other.grid().dims[a]) - 0.5;
                        // On a face the outermost voxel is the nearest.
                        let nearest = (p[a] + 0.5 + ROUNDING).floor().clamp(0.0, end - 0.5) - f64::from(from[a]);
                        inside &= p[a] >= -0.5 - ROUNDING && p[a] <= end + ROUNDING;
                        inside &= nearest >= 0.0 && nearest < f64::from(count[a]);
                        place = place * count[a] as usize + nearest.max(0.0) as usize;
                    }
                    if inside {
                        let [x, y, z] = [lo[0] + x - origin[0], lo[1] + y - origin[1], lo[2] + z - origin[2]];
                        out[(x + BRICK * (y + BRICK * z)) as usize] = ids[place];
                    }
                }
            }
        }
        Ok(())
    }

    fn ids_of(&self, voxels: &Voxels) -> Vec<u16> {
        fn run<T: Value>(v: &[T], scaling: (f64, f64), ids: &HashMap<i128, u16>) -> Vec<u16> {
            let mut out = Vec::with_capacity(v.len());
            for run in v.chunk_by(|a, b| bytemuck::bytes_of(a) == bytemuck::bytes_of(b)) {
                // The survey has met every number that there is.
                let id = id_of(run[0], scaling).ok().and_then(|value| ids.get(&value)).copied().unwrap_or(0);
                out.resize(out.len() + run.len(), id);
            }
            out
        }
        with_voxels!(voxels, v => run(v, self.other.scaling(), self.ids))
    }
}
