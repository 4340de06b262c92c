//! Which voxels of a volume are meant by words: those that show, those of a range of values, those of a region.
//!
//! Told brick by brick as masks, of the voxels that no sub-volume stands for. Bricks of one value, and those whose values all show or all do not, cost no loop over voxels. What
//! shows is judged by texels, as pictures are; ranges by the source's own numbers, as a brush's. Changes nothing.

use crate::document::command::component::{Matter, Within};
use crate::document::family::Family;
use crate::document::look_rows::Owner;
use crate::document::state::State;
use crate::document::subject::Subject;
use crate::explode::PartId;
use crate::math::DVec3;
use crate::paint::Gate;
use crate::segment::{BrickMask, ROWS};
use crate::volume::{Asked, BRICK, Brick, BrickIndex, BrickKey, SLOT, SourceError, Standing, TexelFormat};
use std::collections::{BTreeSet, HashMap};
use std::sync::{Arc, Mutex, PoisonError};

/// From half on a voxel is selected.
const SELECTED: u8 = 128;
/// Words for a bit of every 16-bit code.
const CODE_WORDS: usize = 65_536 / 64;

/// Voxels of a volume, by the brick.
pub(super) type Voxels = Vec<(BrickIndex, BrickMask)>;

/// Which voxels of a volume are meant.
pub(super) struct Meant<'a> {
    subject: Subject<'a>,
    standing: &'a Standing,
    within: Within,
    matter: Told,
}

enum Told {
    Everything,
    Range(Gate),
    Visible(Visible),
}

/// What shows, by whose look it has and by label.
struct Visible {
    /// Whether it hangs on the part, or on what is selected.
    is_apart: bool,
    known: Mutex<HashMap<(Owner, u16), Arc<Shown>>>,
}

/// Which values of a label show.
struct Shown {
    /// Closed ranges, in order.
    ranges: Vec<[f64; 2]>,
    /// A bit for every code of density that has codes.
    codes: Vec<u64>,
}

impl<'a> Meant<'a> {
    pub(super) fn new(subject: Subject<'a>, standing: &'a Standing, matter: Matter, within: Within) -> Self {
        let matter = match matter {
            Matter::Everything => Told::Everything,
            Matter::Range(range) => Told::Range(Gate::new(range, &subject.density)),
            Matter::Visible => Told::Visible(Visible::new(&subject)),
        };
        Self { subject, standing, within, matter }
    }

    /// Those of a brick.
    ///
    /// # Errors
    /// If the source fails.
    pub(super) fn mask(&self, index: BrickIndex) -> Result<BrickMask, SourceError> {
        let valid = self.subject.density.valid(0, index);
        let region = match asked(self.standing, index, valid) {
            BrickMask::None => return Ok(BrickMask::None),
            asked => asked.and(region(&self.subject, self.within, index, valid)?, valid),
        };
        if region == BrickMask::None {
            return Ok(region);
        }
        let matter = match &self.matter {
            Told::Everything => return Ok(region),
            Told::Range(gate) => {
                let bits = gate.slot(&self.subject.density, index)?;
                BrickMask::new(valid, |[x, y, z]| {
                    let texel = (x + 1 + SLOT * (y + 1 + SLOT * (z + 1))) as usize;
                    bits[texel / 32] >> (texel % 32) & 1 == 1
                })
            }
            Told::Visible(visible) => visible.mask(&self.subject, index, valid)?,
        };
        Ok(region.and(matter, valid))
    }
}

/// What of a brick a region has.
fn region(subject: &Subject<'_>, within: Within, index: BrickIndex, valid: [u32; 3]) -> Result<BrickMask, SourceError> {
    let key = BrickKey { level: 0, index };
    Ok(match within {
        Within::Volume => BrickMask::All,
        Within::Selection => of_texels::<1>(&subject.selection.brick(key)?, valid, |[texel]| texel >= SELECTED),
        Within::Segment(id) => {
            of_texels::<2>(&subject.labels.brick(key)?, valid, |texel| u16::from_le_bytes(texel) == id)
        }
    })
}

/// The voxels of a brick that no sub-volume stands for.
pub(super) fn asked(standing: &Standing, index: BrickIndex, valid: [u32; 3]) -> BrickMask {
    match standing.brick(index) {
        Asked::None => BrickMask::None,
        Asked::All => BrickMask::All,
        Asked::Some => {
            let origin = index.origin();
            BrickMask::new(valid, |at| standing.is_asked(std::array::from_fn(|a| origin[a] + at[a])))
        }
    }
}

/// Whether anything is selected by a half in a volume or its sub-volumes.
///
/// # Errors
/// If a source fails.
pub(super) fn selects(state: &State, family: &Family) -> Result<bool, SourceError> {
    for (member, subject) in family.subjects(state) {
        let selection = &subject.volume.selection;
        let holds = |index: BrickIndex| {
            let summary = selection.summary(BrickKey { level: 0, index });
            if summary.max < f32::from(SELECTED) / 255.0 {
                return Ok(false);
            }
            let valid = selection.valid(0, index);
            let mask =
                region(&subject, Within::Selection, index, valid)?.and(asked(&member.standing, index, valid), valid);
            Ok(mask != BrickMask::None)
        };
        for index in selection.present() {
            if holds(index)? {
                return Ok(true);
            }
        }
    }
    Ok(false)
}

/// The texels of a brick that are meant.
fn of_texels<const N: usize>(brick: &Brick, valid: [u32; 3], is_in: impl Fn([u8; N]) -> bool) -> BrickMask {
    match brick {
        Brick::Uniform(texel) => {
            let texel = std::array::from_fn(|i| texel[i]);
            if is_in(texel) { BrickMask::All } else { BrickMask::None }
        }
        Brick::Dense(texels) => {
            let texels = texels.as_chunks::<N>().0;
            BrickMask::new(valid, |at| is_in(texels[place(at)]))
        }
    }
}

fn place([x, y, z]: [u32; 3]) -> usize {
    (x + BRICK * (y + BRICK * z)) as usize
}

impl Visible {
    fn new(subject: &Subject<'_>) -> Self {
        let hides = subject.scene.explosion.parts.iter().any(|part| !part.visible);
        Self { is_apart: hides || subject.is_dressed_in_parts(), known: Mutex::default() }
    }

    fn mask(&self, subject: &Subject<'_>, index: BrickIndex, valid: [u32; 3]) -> Result<BrickMask, SourceError> {
        if !self.is_apart {
            return self.mask_of(subject, Owner::Whole, index, valid);
        }
        let mut mask = BrickMask::None;
        for (owner, own) in owners(subject, index, valid)? {
            mask = mask.or(own.and(self.mask_of(subject, owner, index, valid)?, valid), valid);
        }
        Ok(mask)
    }

    /// What would show if all of a brick had the same look.
    fn mask_of(
        &self,
        subject: &Subject<'_>,
        owner: Owner,
        index: BrickIndex,
        valid: [u32; 3],
    ) -> Result<BrickMask, SourceError> {
        let (density, key) = (&subject.density, BrickKey { level: 0, index });
        let labels = subject.labels.brick(key)?;
        let codes = density.format() == TexelFormat::R16Unorm;
        if let Brick::Uniform([a, b, ..]) = labels {
            let shown = self.shown(subject, owner, u16::from_le_bytes([a, b]));
            let summary = density.summary(key);
            let (min, max) = (f64::from(summary.min), f64::from(summary.max));
            if min > max || !shown.ranges.iter().any(|[lo, hi]| *lo <= max && min <= *hi) {
                return Ok(BrickMask::None);
            }
            // No code stands for NaN, which shows nowhere and counts for no extreme.
            if codes && shown.ranges.iter().any(|[lo, hi]| *lo <= min && max <= *hi) {
                return Ok(BrickMask::All);
            }
            let brick = density.brick(key)?;
            return Ok(match codes {
                true => of_texels::<2>(&brick, valid, |code| shown.code(u16::from_le_bytes(code))),
                false => of_texels::<4>(&brick, valid, |texel| shown.value(decoded(subject, texel))),
            });
        }
        let label_at = |at: [u32; 3]| {
            let [a, b, ..] = labels.texel(at, 2);
            u16::from_le_bytes([a, b])
        };
        let brick = density.brick(key)?;
        let mut last = (0, self.shown(subject, owner, 0));
        Ok(BrickMask::new(valid, |at| {
            let label = label_at(at);
            if label != last.0 {
                last = (label, self.shown(subject, owner, label));
            }
            let texel = brick.texel(at, density.format().bytes());
            if codes {
                last.1.code(u16::from_le_bytes([texel[0], texel[1]]))
            } else {
                last.1.value(decoded(subject, texel))
            }
        }))
    }

    fn shown(&self, subject: &Subject<'_>, owner: Owner, label: u16) -> Arc<Shown> {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        known.entry((owner, label)).or_insert_with(|| Arc::new(Shown::new(subject, owner, label))).clone()
    }
}

/// Whose looks the voxels of a brick have, of those that are in no hidden part: the selection's where they are selected by a half,
/// else their part's at rest.
fn owners(subject: &Subject<'_>, index: BrickIndex, valid: [u32; 3]) -> Result<Vec<(Owner, BrickMask)>, SourceError> {
    let selected = match subject.selection.is_blank() {
        true => BrickMask::None,
        false => {
            let brick = subject.selection.brick(BrickKey { level: 0, index })?;
            of_texels::<1>(&brick, valid, |[texel]| texel >= SELECTED)
        }
    };
    let explosion = &subject.scene.explosion;
    let part = |at: [u32; 3]| {
        let voxel = DVec3::from_array(std::array::from_fn(|a| f64::from(index.origin()[a] + at[a])));
        let part = explosion.holding(subject.grid().world_from_index.transform_point3(voxel))?;
        part.visible.then_some(part.id)
    };
    let mut parts: Vec<(PartId, BrickMask)> = Vec::new();
    if selected != BrickMask::All {
        // Parts are convex: what holds all corners holds the brick. Of hidden ones, which are not told apart here, several may.
        let corner = |n: usize| part(std::array::from_fn(|a| if n >> a & 1 == 1 { valid[a] - 1 } else { 0 }));
        match corner(0) {
            Some(id) if (1..8).all(|n| corner(n) == Some(id)) => parts.push((id, BrickMask::All)),
            _ => {
                let [nx, ny, nz] = valid;
                let places = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
                let of: Vec<Option<PartId>> = places.map(part).collect();
                for id in of.iter().flatten().copied().collect::<BTreeSet<_>>() {
                    let is_own = |[x, y, z]: [u32; 3]| of[(x + nx * (y + ny * z)) as usize] == Some(id);
                    parts.push((id, BrickMask::new(valid, is_own)));
                }
            }
        }
    }
    let unselected = |(id, own): (PartId, BrickMask)| (Owner::Part(id), own.without(&selected, valid));
    let mut owners: Vec<_> = parts.into_iter().map(unselected).collect();
    owners.push((Owner::Selection, selected));
    owners.retain(|(_, own)| *own != BrickMask::None);
    Ok(owners)
}

/// The value of a texel, as pictures have it.
fn decoded(subject: &Subject<'_>, texel: [u8; 4]) -> f64 {
    f64::from(subject.density.map().decode(texel) as f32)
}

impl Shown {
    fn new(subject: &Subject<'_>, owner: Owner, label: u16) -> Self {
        let mut shown = Self { ranges: subject.shown_values_of(owner, label), codes: Vec::new() };
        if subject.density.format() == TexelFormat::R16Unorm {
            let mut codes = vec![0; CODE_WORDS];
            for code in 0..=u16::MAX {
                let [a, b] = code.to_le_bytes();
                let is_shown = shown.value(decoded(subject, [a, b, 0, 0]));
                codes[usize::from(code / 64)] |= u64::from(is_shown) << (code % 64);
            }
            shown.codes = codes;
        }
        shown
    }

    fn code(&self, code: u16) -> bool {
        self.codes[usize::from(code / 64)] >> (code % 64) & 1 == 1
    }

    fn value(&self, value: f64) -> bool {
        self.ranges.iter().any(|[lo, hi]| *lo <= value && value <= *hi)
    }
}

/// A brick with this texel in place of those of a mask.
pub(super) fn filled(
    brick: &Brick,
    mask: &BrickMask,
    valid: [u32; 3],
    texel: &[u8],
    spare: impl Fn(&[u8]) -> bool,
) -> Brick {
    let bytes = texel.len();
    brick.edited(bytes, |texels| {
        for row in 0..ROWS as u32 {
            let (y, z) = (row % BRICK, row / BRICK);
            let mut bits = mask.row(y, z, valid);
            while bits != 0 {
                let at = place([bits.trailing_zeros(), y, z]) * bytes;
                bits &= bits - 1;
                let there = &mut texels[at..at + bytes];
                if !spare(there) {
                    there.copy_from_slice(texel);
                }
            }
        }
    })
}
