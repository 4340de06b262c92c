//! From what is decided about looks to bodies with rows of looks: whose matter is shown how.
//!
//! A body has the look of its volume, changed by that of its part or of the selection; where segments of the volume have looks too, or
//! some of them are hidden, the looks of a body go by label, and it is divided into one body for each mode among them, since a ray marches
//! a body in one mode. Looks that are the same share a row. Knows no poses and no pixels.

use crate::document::scene::Scene;
use crate::document::scene::own_looks::LookChange;
use crate::document::subject::Subject;
use crate::explode::PartId;
use crate::gpu::{Body, Frame, LabelLooks, Look, LookRef, Mask};
use crate::volume::{Lighting, Mode, VolumeId};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// What tells two looks of one scene apart. Transfer functions by where they lie: nobody moves them while a frame is made.
#[derive(PartialEq, Eq, Hash)]
struct Key {
    transfer: usize,
    mode: (u8, u64),
    lighting: Option<[u32; 4]>,
    opacity: u32,
}

impl Key {
    fn of(look: &LookRef<'_>) -> Self {
        let bits = |light: Lighting| [light.ambient, light.diffuse, light.specular, light.power].map(f32::to_bits);
        Self {
            transfer: std::ptr::from_ref(look.transfer) as usize,
            mode: (kind(look.mode), if let Mode::Iso(value) = look.mode { value.to_bits() } else { 0 }),
            lighting: look.lighting.map(bits),
            opacity: look.opacity.to_bits(),
        }
    }
}

/// The kind of a mode, whatever its surface.
fn kind(mode: Mode) -> u8 {
    match mode {
        Mode::Dvr => 0,
        Mode::Iso(_) => 1,
        Mode::Mip => 2,
    }
}

impl LookChange {
    fn over<'a>(&'a self, look: LookRef<'a>) -> LookRef<'a> {
        LookRef {
            transfer: self.transfer.as_ref().unwrap_or(look.transfer),
            mode: self.mode.unwrap_or(look.mode),
            lighting: self.lighting.unwrap_or(look.lighting),
            opacity: look.opacity * self.opacity,
        }
    }
}

/// Whose look matter of a volume has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Owner {
    /// Its volume's.
    Whole,
    /// That of what is selected.
    Selection,
    /// That of a part.
    Part(PartId),
}

impl<'a> Subject<'a> {
    /// The look that what has none for itself inherits.
    pub(crate) fn look(&self) -> LookRef<'a> {
        LookRef {
            transfer: self.transfer(),
            mode: self.mode(),
            lighting: self.scene.lighting_of(self.id),
            opacity: self.strength(),
        }
    }

    /// How strongly it is shown: a sub-volume no more than what it is cut out of.
    pub(crate) fn strength(&self) -> f32 {
        let all = &self.scene.volumes.all;
        let parents = std::iter::successors(self.settings.sub_volume, |sub| all.get(&sub.parent)?.sub_volume);
        let strengths = parents.take(all.len()).filter_map(|sub| all.get(&sub.parent)).map(|parent| parent.opacity);
        strengths.fold(self.settings.opacity, |all, one| all * one)
    }

    /// The volume whose segments and parts it is shown by.
    fn family(&self) -> VolumeId {
        self.scene.root_of(self.id)
    }

    /// What is other about the look of what of it is selected.
    fn selection_change(&self) -> Option<&'a LookChange> {
        let of = &self.scene.own_looks.selections;
        of.get(&self.id).or_else(|| of.get(&self.family()))
    }

    /// Whether its parts or its selection have looks for themselves, so that they cannot be drawn as one.
    pub(crate) fn is_dressed_in_parts(&self) -> bool {
        let own = &self.scene.own_looks;
        !own.parts.is_empty() || (self.selection_change().is_some() && !self.selection.is_blank())
    }

    /// The look of matter of a label; `None` where nothing of it shows.
    fn look_of(&self, owner: Owner, label: u16) -> Option<LookRef<'a>> {
        let (own, plain) = (&self.scene.own_looks, self.look());
        let change = match owner {
            Owner::Whole => None,
            Owner::Selection => self.selection_change(),
            Owner::Part(id) => own.parts.get(&id),
        };
        let base = change.map_or(plain, |change| change.over(plain));
        let look = own.segment(self.family(), label).map_or(base, |change| change.over(base));
        (own.shows_label(self.family(), label) && look.opacity > 0.0).then_some(look)
    }

    /// All whose looks may differ.
    fn owners(&self) -> impl Iterator<Item = Owner> + use<'a> {
        let own = &self.scene.own_looks;
        let selection = self.selection_change().is_some().then_some(Owner::Selection);
        std::iter::once(Owner::Whole).chain(selection).chain(own.parts.keys().map(|id| Owner::Part(*id)))
    }

    /// Whether the 3D view shows matter of a value and label at all, in any part.
    pub(crate) fn shows(&self, value: f64, label: u16) -> bool {
        !value.is_nan()
            && self.owners().filter_map(|owner| self.look_of(owner, label)).any(|look| match look.mode {
                Mode::Iso(level) => value >= level,
                Mode::Dvr | Mode::Mip => look.transfer.opacity_at(value) > 0.0,
            })
    }

    /// All values of a label that the 3D view shows in any part, as closed ranges in order.
    pub(crate) fn shown_values(&self, label: u16) -> Vec<[f64; 2]> {
        self.values_in(self.owners().filter_map(|owner| self.look_of(owner, label)))
    }

    /// The same of what is selected, or of one part.
    pub(crate) fn shown_values_of(&self, owner: Owner, label: u16) -> Vec<[f64; 2]> {
        self.values_in(self.look_of(owner, label).into_iter())
    }

    fn values_in(&self, looks: impl Iterator<Item = LookRef<'a>>) -> Vec<[f64; 2]> {
        let of = |look: LookRef<'_>| match look.mode {
            Mode::Iso(level) => vec![[level, f64::INFINITY]],
            Mode::Dvr | Mode::Mip => opaque_values(&look.transfer.opacity),
        };
        let mut all: Vec<[f64; 2]> = looks.flat_map(of).collect();
        all.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut joined: Vec<[f64; 2]> = Vec::new();
        for [lo, hi] in all {
            match joined.last_mut() {
                Some(last) if lo <= last[1].next_up() => last[1] = last[1].max(hi),
                _ => joined.push([lo, hi]),
            }
        }
        joined
    }
}

/// Where opacity that is linear between points, and constant beyond the first and the last, is above 0.
fn opaque_values(points: &[(f64, f32)]) -> Vec<[f64; 2]> {
    let mut ranges = Vec::new();
    if let (Some(first), Some(last)) = (points.first(), points.last()) {
        ranges.extend((first.1 > 0.0).then_some([f64::NEG_INFINITY, first.0]));
        ranges.extend((last.1 > 0.0).then_some([last.0, f64::INFINITY]));
    }
    ranges.extend(points.iter().filter(|point| point.1 > 0.0).map(|point| [point.0; 2]));
    for pair in points.windows(2) {
        let between = [pair[0].0.next_up(), pair[1].0.next_down()];
        if (pair[0].1 > 0.0 || pair[1].1 > 0.0) && between[0] <= between[1] {
            ranges.push(between);
        }
    }
    ranges
}

/// Gives bodies their looks, and a frame the rows of these.
pub(crate) struct LookRows<'a> {
    scene: &'a Scene,
    rows: Vec<Look>,
    known: HashMap<Key, usize>,
    /// Looks by label, by what they are laid on.
    tables: HashMap<(VolumeId, Option<usize>), Vec<Arc<LabelLooks>>>,
}

impl<'a> LookRows<'a> {
    pub(crate) fn new(scene: &'a Scene) -> Self {
        Self { scene, rows: Vec::new(), known: HashMap::new(), tables: HashMap::new() }
    }

    /// The row of a look; `None` where nothing of it shows.
    fn row(&mut self, look: LookRef<'_>) -> Option<usize> {
        if look.opacity <= 0.0 {
            return None;
        }
        let rows = &mut self.rows;
        Some(*self.known.entry(Key::of(&look)).or_insert_with(|| {
            rows.push(look.to_look());
            rows.len() - 1
        }))
    }

    /// A body of a volume as one or more that have looks; none where nothing of it shows.
    pub(crate) fn dress(&mut self, subject: &Subject<'a>, body: Body) -> Vec<Body> {
        let own = &self.scene.own_looks;
        let change = match body.mask {
            Mask::Selection => subject.selection_change(),
            Mask::None | Mask::Background => own.parts.get(&PartId(body.id)),
        };
        let look = change.map_or(subject.look(), |change| change.over(subject.look()));
        let body = Body { own_colours: change.is_some_and(|change| change.transfer.is_some()), ..body };
        let by_label = own.segments.contains_key(&subject.family()) || own.only.contains_key(&subject.family());
        if !by_label || subject.labels.is_blank() {
            let shown = own.shows_label(subject.family(), 0);
            let row = self.row(look).filter(|_| shown);
            return row.map(|row| Body { look: Some(row), ..body }).into_iter().collect();
        }
        let base = self.row(look);
        let known = self.tables.get(&(subject.id, base)).cloned();
        let tables = known.unwrap_or_else(|| self.tables_of(subject, base, look));
        tables.into_iter().map(|labels| Body { labels: Some(labels), ..body.clone() }).collect()
    }

    /// Looks by label on top of a look: one table for each mode among them.
    fn tables_of(&mut self, subject: &Subject<'a>, base: Option<usize>, look: LookRef<'a>) -> Vec<Arc<LabelLooks>> {
        let (scene, volume) = (self.scene, subject.family());
        let own = &scene.own_looks;
        let only = own.only.get(&volume);
        let mut all = LabelLooks { default: base.filter(|_| only.is_none()), by_label: BTreeMap::new() };
        for &label in only.into_iter().flatten() {
            all.by_label.insert(label, base);
        }
        for (&label, change) in own.segments.get(&volume).into_iter().flatten() {
            if own.shows_label(volume, label) {
                let row = self.row(change.over(look));
                all.by_label.insert(label, row);
            }
        }
        let rows = &self.rows;
        let of_kind = |wanted: u8| {
            let of = |row: Option<usize>| row.filter(|row| kind(rows[*row].mode) == wanted);
            let by_label = all.by_label.iter().map(|(&label, &row)| (label, of(row))).collect();
            LabelLooks { default: of(all.default), by_label }
        };
        let tables = (0..3).map(of_kind).filter(|table| !table.rows().is_empty()).map(Arc::new);
        let tables: Vec<_> = tables.collect();
        self.tables.insert((volume, base), tables.clone());
        tables
    }

    /// Puts bodies and rows into a frame. A row that all bodies have, and that is whole, is the frame's own look.
    pub(crate) fn put(self, bodies: Vec<Body>, frame: &mut Frame) {
        (frame.bodies, frame.looks) = (bodies, self.rows);
        if let [only] = &frame.looks[..]
            && only.opacity >= 1.0
            && frame.bodies.iter().all(|body| body.labels.is_none())
        {
            frame.transfer = only.transfer.clone();
            (frame.mode, frame.lighting) = (only.mode, only.lighting);
            frame.bodies.iter_mut().for_each(|body| body.look = None);
            frame.looks.clear();
        }
    }
}
