//! What commands on annotations, labels and cutaways do to the scene; see `reduce`.
//!
//! Places come as indices of a volume and values of surfaces as numbers: whoever does a command looks at picture and voxels before.

use crate::document::command::Place;
use crate::document::command::annotations::{
    AnnotationChange, AnnotationCommand, CutawayChange, CutawayCommand, LabelChange, LabelCommand,
};
use crate::document::command::answers::{
    AnnotationSaid, CutawaySaid, LabelSaid, LabelStyleSaid, LabelledSaid, RemovedSaid,
};
use crate::document::error::DocumentError;
use crate::document::reduce::place::place_in;
use crate::document::reduce::{Changed, Ground};
use crate::document::scene::Scene;
use crate::document::scene::annotations::{Align, Anchor, Annotation, AnnotationId, Content, Tracing};
use crate::document::scene::cutaways::{Cutaway, Outline, Rim, Spared};
use crate::document::scene::labels::{Label, Named};
use crate::volume::VolumeId;

const RIM: [f32; 3] = [0.93, 0.90, 0.82];

/// What of a place on a surface is said.
struct AnchorSaid {
    at: Option<Place>,
    toward: Option<Place>,
    value: Option<f64>,
    selected: Option<bool>,
    volume: Option<VolumeId>,
}

fn missing(field: &str, expected: &str) -> DocumentError {
    DocumentError::invalid(field, "nothing", expected)
}

/// What neither picture nor voxels were asked for is not known here.
fn unknown(field: &str) -> DocumentError {
    missing(field, "what only the surface tells")
}

fn index_of(place: Place, scene: &Scene, ground: &Ground<'_>) -> Result<[f64; 3], DocumentError> {
    let sample = place_in(place, scene, ground.grid)?.ok_or_else(|| unknown("at"))?;
    // To the last digit.
    if let Place::Index(index) = place {
        return Ok(index);
    }
    Ok(ground.grid.index_from_world().transform_point3(sample.position).to_array())
}

/// A length that a hand would have chosen: 1, 2 or 5 times a power of ten, at most the given one.
pub(crate) fn round_length(length: f64) -> f64 {
    let ten = 10_f64.powf(length.log10().floor());
    let of = |times: f64| (times * ten <= length * 1.000_001).then_some(times * ten);
    of(5.0).or(of(2.0)).unwrap_or(ten)
}

impl Scene {
    /// The volume that another one is a box of, or is.
    fn root_meant(&self, volume: Option<VolumeId>) -> Result<VolumeId, DocumentError> {
        Ok(self.root_of(self.meant(volume)?))
    }

    pub(crate) fn apply_annotation(
        &mut self,
        command: &AnnotationCommand,
        ground: &Ground<'_>,
    ) -> Result<Changed, DocumentError> {
        match command {
            AnnotationCommand::Add(change) => {
                if let Some(id) = change.id {
                    return Err(DocumentError::invalid("id", id.0, "none: annotation.set changes what is there"));
                }
                let one = self.changed_annotation(None, change, ground)?;
                let name = format!("Add {}", one.name);
                let id = self.annotations.put(one.clone());
                Ok(Changed::new(name, AnnotationSaid { id, annotation: one, grid: None }))
            }
            AnnotationCommand::Set(change) => {
                let id = change.id.ok_or_else(|| missing("id", "the annotation that is changed"))?;
                let old = self.annotations.get(id)?.clone();
                let one = self.changed_annotation(Some(&old), change, ground)?;
                let what = match change {
                    AnnotationChange { name: Some(_), .. } => "Rename",
                    AnnotationChange { visible: Some(true), .. } => "Show",
                    AnnotationChange { visible: Some(false), .. } => "Hide",
                    AnnotationChange { at: Some(_), .. } => "Move",
                    AnnotationChange { toward: Some(_), .. } => "Turn",
                    AnnotationChange { size_mm: Some(_), .. } => "Resize",
                    _ => "Change",
                };
                let step = format!("{what} {}", old.name);
                self.annotations.all.insert(id, one.clone());
                Ok(Changed::new(step, AnnotationSaid { id, annotation: one, grid: None }))
            }
            AnnotationCommand::Remove { id } => {
                let step = format!("Remove {}", self.annotations.get(*id)?.name);
                self.annotations.all.remove(id);
                if self.labels.all.values().any(|label| label.at == Named::Annotation(*id)) {
                    self.labels.all.retain(|_, label| label.at != Named::Annotation(*id));
                }
                Ok(Changed::new(step, RemovedSaid { removed: id.0 }))
            }
        }
    }

    fn changed_annotation(
        &self,
        old: Option<&Annotation>,
        change: &AnnotationChange,
        ground: &Ground<'_>,
    ) -> Result<Annotation, DocumentError> {
        let said = match (&change.text, &change.content) {
            (Some(_), Some(_)) => return Err(DocumentError::invalid("text", "a text and a content", "one of the two")),
            (Some(text), None) => Some(match old.map(|old| &old.content) {
                Some(Content::Text { bend_mm, align, .. }) => {
                    Content::Text { text: text.clone(), bend_mm: *bend_mm, align: *align }
                }
                _ => Content::Text { text: text.clone(), bend_mm: 0.0, align: Align::default() },
            }),
            (None, content) => content.clone(),
        };
        let mut content = said
            .or_else(|| old.map(|old| old.content.clone()))
            .ok_or_else(|| missing("content", "a text, or what else the annotation shows"))?;
        let anchor = self.changed_anchor(
            old.map(|old| &old.anchor),
            AnchorSaid {
                at: change.at,
                toward: change.toward,
                value: change.value,
                selected: change.selected,
                volume: change.volume,
            },
            ground,
        )?;
        if let Content::Ruler { to, .. } = &mut content {
            match (change.to, old.map(|old| &old.content)) {
                (Some(place), _) => *to = index_of(place, self, ground)?,
                (None, Some(Content::Ruler { to: old, .. })) => *to = *old,
                // A content that was said as a whole.
                _ if *to != [0.0; 3] => {}
                _ => return Err(missing("to", "where the ruler ends")),
            }
        }
        let largest = 2.0 * ground.bounds.half_diagonal();
        let usual = match content {
            Content::Text { .. } | Content::Ruler { .. } => largest * 0.03,
            _ => largest * 0.15,
        };
        let mut one = match old {
            Some(old) => Annotation { anchor, content, ..old.clone() },
            None => Annotation {
                name: content.called(),
                content,
                anchor,
                size_mm: round_length(usual),
                tracing: Tracing::default(),
                colour: Annotation::INK,
                halo: Some(Annotation::PAPER),
                opacity: 1.0,
                lit: true,
                visible: true,
            },
        };
        if old.is_some_and(|old| old.name == old.content.called()) {
            one.name = one.content.called();
        }
        one.name = change.name.clone().unwrap_or(one.name);
        one.size_mm = change.size_mm.unwrap_or(one.size_mm);
        one.tracing.step_mm = change.step_mm.or(one.tracing.step_mm);
        one.tracing.tolerance = change.tolerance.unwrap_or(one.tracing.tolerance);
        one.tracing.directions = change.directions.unwrap_or(one.tracing.directions);
        one.tracing.relaxed = change.relaxed.unwrap_or(one.tracing.relaxed);
        one.colour = change.colour.unwrap_or(one.colour);
        one.halo = if change.no_halo { None } else { change.halo.or(one.halo) };
        one.opacity = change.opacity.unwrap_or(one.opacity);
        one.lit = change.lit.unwrap_or(one.lit);
        one.visible = change.visible.unwrap_or(one.visible);
        one.check()?;
        Ok(one)
    }

    fn changed_anchor(
        &self,
        old: Option<&Anchor>,
        said: AnchorSaid,
        ground: &Ground<'_>,
    ) -> Result<Anchor, DocumentError> {
        let AnchorSaid { at, toward, value, selected, volume } = said;
        let place = |place: Option<Place>, old: Option<[f64; 3]>, field| match place {
            Some(place) => index_of(place, self, ground),
            None => old.ok_or_else(|| missing(field, "a place on a surface")),
        };
        let centre = place(at, old.map(|old| old.centre), "at")?;
        let mut way = place(toward, old.map(|old| old.toward), "toward")?;
        // What is moved keeps its direction.
        if let (Some(old), true, true) = (old, at.is_some(), toward.is_none()) {
            way = std::array::from_fn(|a| old.toward[a] + centre[a] - old.centre[a]);
        }
        let anchor = Anchor {
            volume: match (volume, old) {
                (None, Some(old)) => old.volume,
                (volume, _) => self.root_meant(volume)?,
            },
            centre,
            toward: way,
            value: value.or(old.map(|old| old.value)).ok_or_else(|| unknown("value"))?,
            selected: selected.or(old.map(|old| old.selected)).unwrap_or_default(),
        };
        anchor.check()?;
        Ok(anchor)
    }

    pub(crate) fn apply_label(
        &mut self,
        command: &LabelCommand,
        ground: &Ground<'_>,
    ) -> Result<Changed, DocumentError> {
        match command {
            LabelCommand::Add(change) => {
                if let Some(id) = change.id {
                    return Err(DocumentError::invalid("id", id.0, "none: label.set changes what is there"));
                }
                let label = self.changed_label(None, change, ground)?;
                let step = format!("Label {}", label.text);
                let id = self.labels.put(label.clone());
                Ok(Changed::new(step, LabelSaid { id, label }))
            }
            LabelCommand::Set(change) => {
                let id = change.id.ok_or_else(|| missing("id", "the label that is changed"))?;
                let old = self.labels.get(id)?.clone();
                let label = self.changed_label(Some(&old), change, ground)?;
                let what = match change.visible {
                    Some(true) => "Show label",
                    Some(false) => "Hide label",
                    None => "Change label",
                };
                let step = format!("{what} {}", old.text);
                self.labels.all.insert(id, label.clone());
                Ok(Changed::new(step, LabelSaid { id, label }))
            }
            LabelCommand::Remove { id } => {
                let step = format!("Remove label {}", self.labels.get(*id)?.text);
                self.labels.all.remove(id);
                Ok(Changed::new(step, RemovedSaid { removed: id.0 }))
            }
            LabelCommand::FromSegments { volume, segments } => {
                let volume = self.meant(*volume)?;
                let ids = segments.clone().ok_or_else(|| unknown("segments"))?;
                let mut labels = Vec::new();
                for segment in ids {
                    let at = Named::Segment { volume, segment };
                    if self.labels.all.values().any(|label| label.at == at) {
                        continue;
                    }
                    let table = self.segments_of(volume);
                    let known =
                        table.get(segment).ok_or_else(|| DocumentError::no_segment("segments", segment, table))?;
                    let label = Label { text: known.name.clone(), at, visible: true };
                    label.check()?;
                    labels.push(LabelSaid { id: self.labels.put(label.clone()), label });
                }
                let step = if labels.is_empty() { "" } else { "Label segments" };
                Ok(Changed::new(step, LabelledSaid { labels }))
            }
            LabelCommand::Style { visible, numbers, size_px, colour, own_colour } => {
                let style = &mut self.labels.style;
                style.visible = visible.unwrap_or(style.visible);
                style.numbers = numbers.unwrap_or(style.numbers);
                style.size_px = size_px.unwrap_or(style.size_px);
                style.colour = if *own_colour { None } else { colour.or(style.colour) };
                let style = *style;
                style.check()?;
                let step = match visible {
                    Some(true) => "Show labels",
                    Some(false) => "Hide labels",
                    None => "Style of labels",
                };
                Ok(Changed::new(step, LabelStyleSaid { style }))
            }
        }
    }

    fn changed_label(
        &self,
        old: Option<&Label>,
        change: &LabelChange,
        ground: &Ground<'_>,
    ) -> Result<Label, DocumentError> {
        let named = [change.at.is_some(), change.segment.is_some(), change.part.is_some(), change.annotation.is_some()];
        if named.iter().filter(|named| **named).count() > 1 {
            let expected = "one of at, segment, part and annotation";
            return Err(DocumentError::invalid("at", "several things that are named", expected));
        }
        let at = if let Some(place) = change.at {
            let index = index_of(place, self, ground)?;
            let volume = self.root_meant(change.volume)?;
            Some(Named::Point { volume, index, selected: change.selected.unwrap_or_default() })
        } else if let Some(segment) = change.segment {
            let volume = self.meant(change.volume)?;
            let table = self.segments_of(volume);
            if table.get(segment).is_none() {
                return Err(DocumentError::no_segment("segment", segment, table));
            }
            Some(Named::Segment { volume, segment })
        } else if let Some(part) = change.part {
            self.explosion.part(part)?;
            Some(Named::Part(part))
        } else if let Some(id) = change.annotation {
            self.annotations.get(id)?;
            Some(Named::Annotation(id))
        } else {
            None
        };
        let at = at
            .or_else(|| old.map(|old| old.at))
            .ok_or_else(|| missing("at", "a place, a segment, a part or an annotation that the label names"))?;
        let of_itself = || match at {
            Named::Segment { volume, segment } => self.segments_of(volume).get(segment).map(|s| s.name.clone()),
            Named::Part(part) => self.explosion.part(part).ok().map(|part| part.name.clone()),
            Named::Annotation(id) => self.annotations.get(id).ok().map(|one| one.name.clone()),
            Named::Point { .. } => None,
        };
        let text = change.text.clone().or_else(|| old.map(|old| old.text.clone())).or_else(of_itself);
        let label = Label {
            text: text.ok_or_else(|| missing("text", "what the label says"))?,
            at,
            visible: change.visible.unwrap_or(old.is_none_or(|old| old.visible)),
        };
        label.check()?;
        Ok(label)
    }

    pub(crate) fn apply_cutaway(
        &mut self,
        command: &CutawayCommand,
        ground: &Ground<'_>,
    ) -> Result<Changed, DocumentError> {
        match command {
            CutawayCommand::Add(change) => {
                if let Some(id) = change.id {
                    return Err(DocumentError::invalid("id", id.0, "none: cutaway.set changes what is there"));
                }
                let cutaway = self.changed_cutaway(None, change, ground)?;
                let step = format!("Open {}", cutaway.name);
                let id = self.cutaways.put(cutaway.clone());
                Ok(Changed::new(step, CutawaySaid { id, cutaway, mesh: None }))
            }
            CutawayCommand::Set(change) => {
                let id = change.id.ok_or_else(|| missing("id", "the cutaway that is changed"))?;
                let old = self.cutaways.get(id)?.clone();
                let cutaway = self.changed_cutaway(Some(&old), change, ground)?;
                let what = match change {
                    CutawayChange { name: Some(_), .. } => "Rename",
                    CutawayChange { open: Some(true), .. } => "Open",
                    CutawayChange { open: Some(false), .. } => "Close",
                    CutawayChange { at: Some(_), .. } => "Move",
                    CutawayChange { depth_mm: Some(_), .. } => "Deepen",
                    CutawayChange { width_mm: Some(_), .. } | CutawayChange { height_mm: Some(_), .. } => "Resize",
                    _ => "Change",
                };
                let step = format!("{what} {}", old.name);
                self.cutaways.all.insert(id, cutaway.clone());
                Ok(Changed::new(step, CutawaySaid { id, cutaway, mesh: None }))
            }
            CutawayCommand::Remove { id } => {
                let step = format!("Remove {}", self.cutaways.get(*id)?.name);
                self.cutaways.all.remove(id);
                Ok(Changed::new(step, RemovedSaid { removed: id.0 }))
            }
        }
    }

    fn changed_cutaway(
        &self,
        old: Option<&Cutaway>,
        change: &CutawayChange,
        ground: &Ground<'_>,
    ) -> Result<Cutaway, DocumentError> {
        let anchor = self.changed_anchor(
            old.map(|old| &old.anchor),
            AnchorSaid {
                at: change.at,
                toward: change.toward,
                value: change.value,
                selected: None,
                volume: change.volume,
            },
            ground,
        )?;
        let usual = round_length(ground.bounds.half_diagonal() * 0.3);
        let outline = match (&change.lasso, old.map(|old| &old.outline)) {
            (Some(places), _) => {
                let points = places.iter().map(|place| index_of(*place, self, ground));
                Outline::Lasso { points: points.collect::<Result<_, _>>()? }
            }
            (None, Some(Outline::Lasso { .. })) if change.width_mm.is_some() || change.height_mm.is_some() => {
                return Err(DocumentError::invalid(
                    "width_mm",
                    "a size",
                    "none: this window has the outline of a lasso",
                ));
            }
            (None, Some(Outline::Lasso { points })) => {
                // What is moved takes its outline along.
                let old = old.map_or(anchor.centre, |old| old.anchor.centre);
                let by: [f64; 3] = std::array::from_fn(|a| anchor.centre[a] - old[a]);
                Outline::Lasso { points: points.iter().map(|p| std::array::from_fn(|a| p[a] + by[a])).collect() }
            }
            (None, Some(Outline::Grid { width_mm, height_mm })) => Outline::Grid {
                width_mm: change.width_mm.unwrap_or(*width_mm),
                height_mm: change.height_mm.unwrap_or(*height_mm),
            },
            (None, None) => {
                let width_mm = change.width_mm.or(change.height_mm).unwrap_or(usual);
                Outline::Grid { width_mm, height_mm: change.height_mm.unwrap_or(width_mm) }
            }
        };
        let mut one = match old {
            Some(old) => Cutaway { anchor, outline, ..old.clone() },
            None => Cutaway {
                name: format!("Window {}", self.cutaways.next + 1),
                anchor,
                outline,
                depth_mm: usual,
                rim: Rim { width_mm: usual * 0.04, colour: RIM },
                shaded: true,
                spares: Spared::default(),
                open: true,
            },
        };
        one.name = change.name.clone().unwrap_or(one.name);
        one.depth_mm = change.depth_mm.unwrap_or(one.depth_mm);
        one.rim.width_mm = change.rim_mm.unwrap_or(one.rim.width_mm);
        one.rim.colour = change.rim_colour.unwrap_or(one.rim.colour);
        one.shaded = change.shaded.unwrap_or(one.shaded);
        one.spares.selection = change.spare_selection.unwrap_or(one.spares.selection);
        one.spares.segments = change.spare_segments.clone().unwrap_or(one.spares.segments);
        one.open = change.open.unwrap_or(one.open);
        one.check()?;
        Ok(one)
    }

    /// The annotation that a label, a question or a cutaway names.
    pub(crate) fn annotation(&self, id: AnnotationId) -> Result<&Annotation, DocumentError> {
        self.annotations.get(id)
    }
}
