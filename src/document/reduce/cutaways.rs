//! What commands on cutaways do to the scene; see `reduce`.

use crate::document::command::annotations::{CutawayChange, CutawayCommand};
use crate::document::command::answers::{CutawaySaid, RemovedSaid};
use crate::document::error::DocumentError;
use crate::document::reduce::annotations::{AnchorSaid, index_of, missing, round_length};
use crate::document::reduce::{Changed, Ground};
use crate::document::scene::Scene;
use crate::document::scene::cutaways::{Cutaway, Outline, Rim, Spared};

const RIM: [f32; 3] = [0.93, 0.90, 0.82];

impl Scene {
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
                Ok(Changed::new(step, CutawaySaid { id, cutaway, mesh: None, not_shown: None }))
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
                Ok(Changed::new(step, CutawaySaid { id, cutaway, mesh: None, not_shown: None }))
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
}
