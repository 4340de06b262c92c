//! What commands on annotations do to the scene, and what of a place on a surface labels and cutaways share with them; see `reduce`.
//!
//! Places come as indices of a volume and values of surfaces as numbers: whoever does a command looks at picture and voxels before.

use crate::document::command::Place;
use crate::document::command::annotations::{AnnotationChange, AnnotationCommand};
use crate::document::command::answers::{AnnotationSaid, RemovedSaid};
use crate::document::error::DocumentError;
use crate::document::reduce::place::place_in;
use crate::document::reduce::{Changed, Ground};
use crate::document::scene::Scene;
use crate::document::scene::annotations::{Align, Anchor, Annotation, AnnotationId, Content, Tracing};
use crate::document::scene::labels::Named;
use crate::volume::VolumeId;

/// What of a place on a surface is said.
pub(super) struct AnchorSaid {
    pub(super) at: Option<Place>,
    pub(super) toward: Option<Place>,
    pub(super) value: Option<f64>,
    pub(super) selected: Option<bool>,
    pub(super) volume: Option<VolumeId>,
}

pub(super) fn missing(field: &str, expected: &str) -> DocumentError {
    DocumentError::invalid(field, "nothing", expected)
}

/// What neither picture nor voxels were asked for is not known here.
pub(super) fn unknown(field: &str) -> DocumentError {
    missing(field, "what only the surface tells")
}

pub(super) fn index_of(place: Place, scene: &Scene, ground: &Ground<'_>) -> Result<[f64; 3], DocumentError> {
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
    pub(super) fn root_meant(&self, volume: Option<VolumeId>) -> Result<VolumeId, DocumentError> {
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
                Ok(Changed::new(name, AnnotationSaid { id, annotation: one, grid: None, not_shown: None }))
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
                Ok(Changed::new(step, AnnotationSaid { id, annotation: one, grid: None, not_shown: None }))
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

    pub(super) fn changed_anchor(
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

    /// The annotation that a label, a question or a cutaway names.
    pub(crate) fn annotation(&self, id: AnnotationId) -> Result<&Annotation, DocumentError> {
        self.annotations.get(id)
    }
}
