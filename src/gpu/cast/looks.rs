//! The looks of a picture as the shaders see them: rows of one table, labels' rows in another, and which kernel draws them.
//!
//! Owns what is common to a picture's looks: whether one serves all of it, the mode or modes, and the textures' content. A row is
//! a table of colour and opacity with the look's light and its surface's opacity behind it. Knows no fields.

use crate::gpu::cast::merging::MergedBody;
use crate::gpu::device::constants::{MODE_DVR, MODE_ISO, MODE_MIP, NO_ROWS};
use crate::gpu::picture::frame::{Frame, LabelLooks, LookRef};
use crate::volume::{Mode, Segments, TABLE_ENTRIES, TransferFunction, VolumeId};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Texels of a row of the table of looks: the entries, light, opacity of the surface.
pub(crate) const ROW: usize = TABLE_ENTRIES + 2;

/// Looks in one picture: that many rows of the table take 256 MiB, with their integrals twice as much.
pub(crate) const MOST_LOOKS: usize = 4096;
/// Rows that may be filled so that every label has one of its own, beside one more for every look.
const SPARE_ROWS: usize = 64;

/// What marches a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Dvr,
    Iso,
    Mip,
    /// Bodies of several modes, and those that a mode alone does not order.
    Modes,
}

/// Numbers that a mode has in shaders.
pub(crate) fn number_of(mode: Mode) -> u32 {
    match mode {
        Mode::Dvr => MODE_DVR,
        Mode::Iso(_) => MODE_ISO,
        Mode::Mip => MODE_MIP,
    }
}

/// What a row of the table of looks holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Row {
    /// Matter that does not show.
    Nothing,
    /// A row of the frame's looks, or the picture's own.
    Look(Option<usize>),
}

/// What one picture's looks have in common, and the rows and label tables that its textures are to hold.
#[derive(Debug)]
pub(crate) struct Looks {
    pub(crate) kind: Kind,
    /// Whether bodies have looks of their own; else the view's numbers serve all.
    pub(crate) own: bool,
    /// Whether any body's looks go by label.
    pub(crate) by_label: bool,
    pub(crate) lit: bool,
    /// Whether samples stand for stretches, where bodies are rendered directly.
    pub(crate) refines: bool,
    /// Whether every label has a row of its own in the table, so that shaders need not look up which: in direct volume rendering, where
    /// texels mean the same to all labels' looks and most labels have one.
    pub(crate) row_a_label: bool,
    /// Whether labels' looks have their surfaces at one density, and every label one.
    pub(crate) one_surface: bool,
    /// What is in the table.
    pub(crate) rows: Vec<Row>,
    /// Tables of labels with the volumes that their numbers are of.
    tables: Vec<(Arc<LabelLooks>, VolumeId)>,
    /// The first row of each in the texture of labels' looks, or in the table, and the last label that it has.
    firsts: Vec<(u32, u32)>,
    /// The first row of each volume's segment colours.
    segments: BTreeMap<VolumeId, u32>,
    segment_rows: u32,
}

/// The last label that a table of labels has: all beyond it have its look.
fn last_label(labels: &LabelLooks) -> u32 {
    labels.by_label.keys().next_back().map_or(0, |&l| u32::from(l) + 1).min(0xffff)
}

/// Whether texels mean the same to all of a table's looks.
fn are_alike(labels: &LabelLooks, frame: &Frame) -> bool {
    let domains: Vec<_> = labels.rows().into_iter().map(|row| frame.look(Some(row)).transfer.domain()).collect();
    domains.windows(2).all(|pair| pair[0] == pair[1])
}

/// Whether every label of a table has a surface, all at one density.
fn have_one_surface(labels: &LabelLooks, frame: &Frame) -> bool {
    let shown = labels.by_label.values().chain([&labels.default]).all(Option::is_some);
    let modes: Vec<_> = labels.rows().into_iter().map(|row| frame.look(Some(row)).mode).collect();
    shown && modes.windows(2).all(|pair| pair[0] == pair[1])
}

fn rows_each(refines: bool) -> usize {
    if refines { 2 } else { 1 }
}

fn rows_of(segments: &Segments) -> u32 {
    segments.0.last().map_or(1, |s| u32::from(s.id) / 256 + 1)
}

impl Looks {
    /// Of the marched bodies of a frame.
    pub(crate) fn of(frame: &Frame, drawn: &[MergedBody]) -> Self {
        let mut rows: Vec<Option<usize>> = Vec::new();
        let mut tables: Vec<(Arc<LabelLooks>, VolumeId)> = Vec::new();
        let mut place = BTreeMap::new();
        let mut take = |row: Option<usize>, rows: &mut Vec<Option<usize>>| {
            place.entry(row).or_insert_with(|| rows.push(row));
        };
        for d in drawn {
            match &d.labels {
                Some(labels) => {
                    labels.rows().into_iter().for_each(|row| take(Some(row), &mut rows));
                    let same = |t: &(Arc<LabelLooks>, VolumeId)| Arc::ptr_eq(&t.0, labels) && t.1 == d.volume;
                    if !tables.iter().any(same) {
                        tables.push((labels.clone(), d.volume));
                    }
                }
                None => take(d.look, &mut rows),
            }
        }
        let looks: Vec<LookRef<'_>> = rows.iter().map(|&row| frame.look(row)).collect();
        let one = looks.windows(2).all(|pair| pair[0] == pair[1]) && tables.is_empty();
        let volumes = frame.volumes();
        let own = !one || volumes.len() > 1 || drawn.iter().any(|d| d.own_colours);
        let roots = volumes.iter().filter(|id| !frame.is_boxed(**id)).count();
        let is_family = roots == 1 && !frame.boxes.is_empty();
        let all = |mode: u32| looks.iter().all(|look| number_of(look.mode) == mode);
        let opaque = looks.iter().all(|look| look.opacity >= 1.0);
        let kind = match () {
            () if all(MODE_DVR) => Kind::Dvr,
            () if all(MODE_ISO) && opaque => Kind::Iso,
            // Boxes of a volume have its values: one maximum of all.
            () if all(MODE_MIP) && one && (!own || is_family) => Kind::Mip,
            () => Kind::Modes,
        };
        let lit = looks.iter().any(|look| look.lighting.is_some() && look.mode != Mode::Mip);
        let mut segment_rows = 0;
        let mut segments = BTreeMap::new();
        for volume in volumes {
            segments.insert(volume, segment_rows);
            segment_rows += rows_of(&frame.overlay_of(volume).segments);
        }
        let refines = frame.refine && matches!(kind, Kind::Dvr | Kind::Modes);
        let rows_each = rows_each(refines);
        let mut rows: Vec<Row> = rows.into_iter().map(Row::Look).collect();
        let of_labels: usize = tables.iter().map(|(labels, _)| last_label(labels) as usize + 1).sum();
        let row_a_label = kind == Kind::Dvr
            && rows.len() + of_labels <= (SPARE_ROWS + 2 * rows.len()).min(MOST_LOOKS)
            && tables.iter().all(|(labels, _)| are_alike(labels, frame));
        let mut next = 0;
        let mut firsts = Vec::with_capacity(tables.len());
        for (labels, _) in &tables {
            let last = last_label(labels);
            if row_a_label {
                firsts.push(((rows.len() * rows_each) as u32, last));
                let row = |label| labels.row(label as u16).map_or(Row::Nothing, |row| Row::Look(Some(row)));
                rows.extend((0..=last).map(row));
            } else {
                firsts.push((next, last));
                next += last / 256 + 1;
            }
        }
        Self {
            kind,
            own: own || kind == Kind::Modes,
            by_label: !tables.is_empty(),
            refines,
            lit,
            row_a_label,
            one_surface: kind == Kind::Iso
                && !tables.is_empty()
                && tables.iter().all(|(labels, _)| have_one_surface(labels, frame)),
            rows,
            tables,
            firsts,
            segments,
            segment_rows: segment_rows.max(1),
        }
    }

    /// What shaders that march these looks are compiled for. `in_place`: labels lie where their voxels are.
    pub(crate) fn conditions(&self, in_place: bool) -> impl Iterator<Item = &'static str> {
        let all = [
            ("OWN_LOOKS", self.own),
            ("LABEL_LOOKS", self.by_label),
            ("ROW_A_LABEL", self.row_a_label),
            ("ONE_SURFACE", self.one_surface),
            ("HIDES_LABELS", self.by_label && !self.row_a_label),
            // A surface asks for labels only where it may be.
            ("LABEL_RUNS", self.by_label && self.kind != Kind::Iso && !in_place),
        ];
        all.into_iter().filter(|condition| condition.1).map(|condition| condition.0)
    }

    /// Rows of a look in the table: its own, and that of its integrals where the picture refines.
    pub(crate) fn rows_each(&self) -> usize {
        rows_each(self.refines)
    }

    /// The first row of a look in the table.
    pub(crate) fn row_of(&self, row: Option<usize>) -> i32 {
        self.rows.iter().position(|r| *r == Row::Look(row)).map_or(-1, |i| (i * self.rows_each()) as i32)
    }

    /// The first row of a body's labels, in the texture of labels' looks or in the table, and the last label that it has.
    pub(crate) fn labels_of(&self, d: &MergedBody) -> (u32, u32) {
        let Some(labels) = &d.labels else { return (NO_ROWS, 0) };
        let at = self.tables.iter().position(|t| Arc::ptr_eq(&t.0, labels) && t.1 == d.volume);
        at.map_or((NO_ROWS, 0), |at| self.firsts[at])
    }

    /// The first row of a volume's segment colours.
    pub(crate) fn segments_of(&self, volume: VolumeId) -> u32 {
        self.segments.get(&volume).copied().unwrap_or(0)
    }

    /// Colours of all volumes' visible segments, 256 labels a row.
    pub(crate) fn segment_colours(&self, frame: &Frame) -> Vec<[u8; 4]> {
        let mut colours = vec![[0_u8; 4]; self.segment_rows as usize * 256];
        for (&volume, &first) in &self.segments {
            for s in frame.overlay_of(volume).segments.0.iter().filter(|s| s.visible) {
                let [r, g, b] = s.colour.map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8);
                colours[first as usize * 256 + usize::from(s.id)] = [r, g, b, 255];
            }
        }
        colours
    }

    /// What labels look like, 256 a row: table scale and bias, texel of the iso-surface, row of the table (−1: nothing shows).
    /// `texel` answers (lo, span) of a volume's density: density = lo + texel·span.
    pub(crate) fn label_texels(&self, frame: &Frame, texel: &dyn Fn(VolumeId) -> (f64, f64)) -> Vec<[f32; 4]> {
        let rows: BTreeMap<Row, usize> =
            self.rows.iter().enumerate().map(|(i, row)| (*row, i * self.rows_each())).collect();
        let mut texels = Vec::new();
        for ((labels, volume), (first, last)) in self.tables.iter().zip(&self.firsts) {
            texels.resize(*first as usize * 256, [0.0; 4]);
            let numbers = texel(*volume);
            let of = |row: Option<usize>| match row {
                Some(row) => {
                    let Meaning { table_scale, table_bias, iso } = Meaning::of(frame.look(Some(row)), numbers);
                    [table_scale, table_bias, iso, rows[&Row::Look(Some(row))] as f32]
                }
                None => [0.0, 0.0, 0.0, -1.0],
            };
            let default = of(labels.default);
            let start = texels.len();
            texels.resize(start + *last as usize + 1, default);
            for (&label, &row) in &labels.by_label {
                texels[start + usize::from(label)] = of(row);
            }
        }
        texels.resize(texels.len().next_multiple_of(256).max(256), [0.0; 4]);
        texels
    }
}

/// The rows of a look in the table: opacity of a step, for MIP as it stands; where the picture refines its integrals too.
pub(crate) fn rows(look: LookRef<'_>, step_mm: f64, refines: bool) -> Vec<[f32; 4]> {
    let mut row = entries(look, step_mm);
    row.push(match look.lighting.filter(|_| look.mode != Mode::Mip) {
        Some(light) => [light.ambient, light.diffuse, light.specular, light.power],
        None => [1.0, 0.0, 0.0, 1.0],
    });
    row.push([look.opacity.clamp(0.0, 1.0); 4]);
    if refines {
        row.extend(integrals(look, step_mm));
        row.resize(2 * ROW, [0.0; 4]);
    }
    row
}

/// The entries of a look's row.
pub(crate) fn entries(look: LookRef<'_>, step_mm: f64) -> Vec<[f32; 4]> {
    let step = if look.mode == Mode::Mip { look.transfer.unit_mm } else { step_mm };
    thinned(look).table(step)
}

/// What lies below the entries, for pictures that refine.
pub(crate) fn integrals(look: LookRef<'_>, step_mm: f64) -> Vec<[f32; 4]> {
    thinned(look).integrals(step_mm)
}

/// A look's transfer function with its opacity in it.
fn thinned(look: LookRef<'_>) -> Cow<'_, TransferFunction> {
    if look.opacity >= 1.0 {
        return Cow::Borrowed(look.transfer);
    }
    let mut thinner = look.transfer.clone();
    // Both ends stay, so that the entries are of the same values.
    thinner.opacity.iter_mut().for_each(|(_, opacity)| *opacity *= look.opacity.max(0.0));
    Cow::Owned(thinner)
}

/// What a volume's texels are to a look.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meaning {
    pub(crate) table_scale: f32,
    pub(crate) table_bias: f32,
    pub(crate) iso: f32,
}

impl Meaning {
    /// `(lo, span)`: density = lo + texel·span.
    pub(crate) fn of(look: LookRef<'_>, (lo, span): (f64, f64)) -> Self {
        let (first, last) = look.transfer.domain();
        // Halves, since their distance may be beyond all numbers.
        let entries = (TABLE_ENTRIES - 1) as f64 * 0.5 / (last * 0.5 - first * 0.5);
        Self {
            table_scale: (span * entries) as f32,
            table_bias: ((lo - first) * entries + 0.5) as f32,
            iso: match look.mode {
                Mode::Iso(value) => ((value - lo) / span) as f32,
                Mode::Dvr | Mode::Mip => 0.0,
            },
        }
    }
}
