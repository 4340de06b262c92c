//! One step of history: what it holds is what comes back, and exchanging it leaves what was there before.
//!
//! So undo and redo are the same swap. A step holds only what changed of what was decided: components of the scene, bricks of
//! fields, and the density's map when painting widened it. Where a simulation took the parts is in no step.

use crate::document::scene::Scene;
use crate::document::state::State;
use crate::explode::Explosion;
use crate::volume::{Brick, BrickIndex, Changes, DensityMap, Field, FieldKind, Refresh, Segments, SourceError};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The parts of a scene that undo knows; views and looks have a past of their own, the brush has none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct SceneDelta {
    segments: Option<Segments>,
    explosion: Option<Explosion>,
}

impl SceneDelta {
    /// What `before` holds where `after` differs from it.
    pub(crate) fn between(before: Scene, after: &Scene) -> Self {
        let mut delta = Self { segments: Some(before.segments), explosion: Some(before.explosion) };
        delta.prune(after);
        delta
    }

    /// Forgets what the scene holds anyway.
    fn prune(&mut self, scene: &Scene) {
        fn drop_equal<T: PartialEq>(slot: &mut Option<T>, now: &T) {
            if slot.as_ref() == Some(now) {
                *slot = None;
            }
        }
        drop_equal(&mut self.segments, &scene.segments);
        drop_equal(&mut self.explosion, &scene.explosion);
    }

    fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Whether it holds parts, degree and forces.
    pub(crate) fn has_explosion(&self) -> bool {
        self.explosion.is_some()
    }

    /// Exchanges what it holds with what the scene holds.
    pub(crate) fn exchange(&mut self, scene: &mut Scene) {
        fn swap<T>(slot: &mut Option<T>, now: &mut T) {
            if let Some(held) = slot {
                std::mem::swap(held, now);
            }
        }
        swap(&mut self.segments, &mut scene.segments);
        swap(&mut self.explosion, &mut scene.explosion);
    }

    /// Joins a later delta: what was there first comes back.
    fn absorb(&mut self, later: Self) {
        self.segments = self.segments.take().or(later.segments);
        self.explosion = self.explosion.take().or(later.explosion);
    }
}

/// What an exchange made new, for whoever mirrors fields.
#[derive(Clone, Debug, Default)]
pub(crate) struct Refreshed {
    /// Slots by field.
    pub slots: Vec<(FieldKind, Refresh)>,
    /// Bricks of level 0 whose own texels may be new.
    pub bricks: Vec<(FieldKind, BrickIndex)>,
    /// Whether the density got another map: all of its texels are new.
    pub remapped: bool,
    /// Whether the GPU's slots hold it already: a stroke painted them.
    pub painted: bool,
}

impl Refreshed {
    /// Adds what a later exchange made new.
    pub(crate) fn join(&mut self, later: Self) {
        self.slots.extend(later.slots);
        self.bricks.extend(later.bricks);
        self.remapped |= later.remapped;
    }
}

/// See the module's head.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Step {
    /// What the user did.
    pub name: String,
    /// Scene.
    pub scene: SceneDelta,
    /// Bricks of level 0; `None` is an unedited one.
    pub bricks: BTreeMap<(FieldKind, BrickIndex), Option<Brick>>,
    /// With a map, the density's bricks above are all of its edits.
    pub map: Option<DensityMap>,
}

impl Step {
    /// Whether it would change nothing.
    pub(crate) fn is_empty(&self) -> bool {
        self.scene.is_empty() && self.bricks.is_empty() && self.map.is_none()
    }

    /// Exchanges what it holds with what the state holds.
    ///
    /// # Errors
    /// If the source fails; state and step are then as they were.
    pub(crate) fn exchange(&mut self, state: &mut State) -> Result<Refreshed, SourceError> {
        let mut refreshed = Refreshed::default();
        let mut held = BTreeMap::new();
        let mut done: Vec<FieldKind> = Vec::new();
        // The density last: only it has a source that can fail, and a map that is exchanged as a whole.
        for kind in [FieldKind::Colour, FieldKind::Selection, FieldKind::Labels, FieldKind::Density] {
            let mut changes = Vec::new();
            for (&(of, index), brick) in &self.bricks {
                if of == kind {
                    changes.push((index, brick.clone()));
                }
            }
            let result = match self.map {
                Some(map) if kind == FieldKind::Density => {
                    remap(&mut state.density, map, changes).map(|(old, before)| {
                        self.map = Some(old);
                        refreshed.remapped = true;
                        before
                    })
                }
                _ if changes.is_empty() => continue,
                _ => state.field_mut(kind).swap(changes).map(|(before, refresh)| {
                    refreshed.slots.push((kind, refresh));
                    before
                }),
            };
            match result {
                Ok(before) => {
                    done.push(kind);
                    held.extend(before.into_iter().map(|(index, brick)| ((kind, index), brick)));
                }
                Err(error) => {
                    for kind in done {
                        let back =
                            held.iter().filter(|((of, _), _)| *of == kind).map(|((_, i), b)| (*i, b.clone())).collect();
                        state.field_mut(kind).swap(back)?;
                    }
                    return Err(error);
                }
            }
        }
        refreshed.bricks = held.keys().copied().collect();
        self.bricks = held;
        self.scene.exchange(&mut state.scene);
        Ok(refreshed)
    }

    /// Joins a step that came after this one; what was there first comes back.
    pub(crate) fn absorb(&mut self, later: Self) {
        self.name = later.name;
        self.scene.absorb(later.scene);
        let density = |key: &(FieldKind, BrickIndex)| key.0 == FieldKind::Density;
        if later.map.is_some() && self.map.is_none() {
            // The later list is all edits; ours say what some of those were still earlier.
            self.map = later.map;
            for (key, brick) in later.bricks {
                self.bricks.entry(key).or_insert(brick);
            }
            self.bricks.retain(|key, brick| !density(key) || brick.is_some());
        } else {
            let whole = self.map.is_some();
            for (key, brick) in later.bricks {
                if !(whole && density(&key)) {
                    self.bricks.entry(key).or_insert(brick);
                }
            }
        }
    }

    /// Forgets what the state holds anyway.
    pub(crate) fn prune(&mut self, state: &State) {
        self.scene.prune(&state.scene);
        let whole = self.map.is_some();
        self.bricks.retain(|&(kind, index), brick| {
            (whole && kind == FieldKind::Density) || state.field(kind).edit(index) != brick.as_ref()
        });
    }
}

/// Gives the density another map and other edits, all of them; answers with the ones before.
pub(crate) fn remap(
    density: &mut Field,
    map: DensityMap,
    edits: Changes,
) -> Result<(DensityMap, Changes), SourceError> {
    let Some(source) = density.source().cloned() else { return Ok((*density.map(), Vec::new())) };
    let Some(mut next) = Field::from_source(source, map, &|_| true)? else { return Ok((*density.map(), Vec::new())) };
    next.swap(edits)?;
    let before = density.edits().into_iter().map(|(i, b)| (i, Some(b.clone()))).collect();
    let old = *density.map();
    *density = next;
    Ok((old, before))
}
