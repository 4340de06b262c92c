//! What commands on labels do to the scene; see `reduce`.

use crate::document::command::annotations::{LabelChange, LabelCommand};
use crate::document::command::answers::{LabelSaid, LabelStyleSaid, LabelledSaid, RemovedSaid};
use crate::document::error::DocumentError;
use crate::document::reduce::annotations::{index_of, missing, unknown};
use crate::document::reduce::{Changed, Ground};
use crate::document::scene::Scene;
use crate::document::scene::labels::{Label, Named};

impl Scene {
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
}
