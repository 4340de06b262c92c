//! What is found about places on surfaces, and for how long it holds: until the surface there is edited, its volume moves, or something else
//! is wanted there.
//!
//! Owns that rule for annotations and windows alike. What could not be found is remembered too, so that a picture does not look for it again
//! and again. Knows neither grids nor meshes.

use crate::document::error::DocumentError;
use crate::document::history::step::Refreshed;
use crate::document::scene::annotations::Anchor;
use crate::document::state::State;
use crate::math::{DAffine3, DVec3};
use crate::volume::{FieldKind, VolumeId};
use std::collections::BTreeMap;

/// What is seen of the surroundings of an anchor: if any of it changes, what was found there is another thing.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ground {
    world_from_index: DAffine3,
    /// The volume and the sub-volumes that are seen in it.
    pub family: Vec<VolumeId>,
}

impl Ground {
    /// The world at rest of an index of the volume.
    pub(crate) fn place(&self, index: [f64; 3]) -> DVec3 {
        self.world_from_index.transform_point3(DVec3::from_array(index))
    }
}

/// A place on a surface, in the world at rest.
#[derive(Clone, Debug)]
pub(crate) struct Spot {
    pub root: VolumeId,
    pub value: f64,
    pub centre: DVec3,
    pub along: DVec3,
    pub voxel_mm: f64,
    pub ground: Ground,
}

impl Spot {
    /// # Errors
    /// If the volume is gone.
    pub(crate) fn of(state: &State, anchor: &Anchor) -> Result<Self, DocumentError> {
        let subject = state.at(Some(anchor.volume))?;
        let place = |index: [f64; 3]| subject.grid().world_from_index.transform_point3(DVec3::from_array(index));
        let centre = place(anchor.centre);
        Ok(Self {
            root: anchor.volume,
            value: anchor.value,
            centre,
            along: place(anchor.toward) - centre,
            voxel_mm: subject.grid().voxel_mm(),
            ground: Ground {
                world_from_index: subject.grid().world_from_index,
                family: state.with_sub_volumes(vec![anchor.volume]),
            },
        })
    }
}

/// What was just found.
pub(crate) struct Fresh<T> {
    pub what: T,
    /// A ball of the world at rest on whose voxels it hangs: middle and radius, mm.
    pub ball: (DVec3, f64),
    /// Whether it is as it is wanted, and not only as it is quickly found.
    pub is_final: bool,
}

#[derive(Debug)]
struct Find<S, T> {
    shape: S,
    ground: Ground,
    ball: (DVec3, f64),
    is_stale: bool,
    is_final: bool,
    /// Or why it cannot be found.
    what: Result<T, String>,
}

/// What was found by name, `S` being what of the scene it hangs on.
#[derive(Debug)]
pub(crate) struct Finds<K, S, T>(BTreeMap<K, Find<S, T>>);

impl<K, S, T> Default for Finds<K, S, T> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<K: Ord, S: PartialEq, T> Finds<K, S, T> {
    /// Another document is open.
    pub(crate) fn forget(&mut self) {
        self.0.clear();
    }

    /// Forgets what the scene no longer names.
    pub(crate) fn keep(&mut self, is_named: impl Fn(&K) -> bool) {
        self.0.retain(|key, _| is_named(key));
    }

    /// Voxels have changed: what hangs on them is found anew when it is next asked for.
    pub(crate) fn mirror(&mut self, state: &State, refreshed: &Refreshed) {
        for find in self.0.values_mut() {
            find.is_stale |= touches(state, refreshed, &find.ground, find.ball);
        }
    }

    /// Whether what is wanted is not there yet.
    pub(crate) fn is_behind(&self, key: &K, shape: &S) -> bool {
        self.0.get(key).is_none_or(|find| find.is_stale || !find.is_final || find.shape != *shape)
    }

    /// What is there, else what `find` finds, which gets what was there before; `at_last`: as it is wanted, whatever that costs.
    ///
    /// # Errors
    /// Why there is none.
    pub(crate) fn get(
        &mut self,
        key: K,
        shape: S,
        spot: &Spot,
        at_last: bool,
        find: impl FnOnce(Option<(&S, &T)>) -> Result<Fresh<T>, DocumentError>,
    ) -> Result<&T, DocumentError>
    where
        K: Copy,
    {
        let known = self.0.get(&key);
        let is_it =
            |f: &Find<S, T>| !f.is_stale && f.ground == spot.ground && f.shape == shape && (f.is_final || !at_last);
        if !known.is_some_and(is_it) {
            let before = known.and_then(|f| Some((&f.shape, f.what.as_ref().ok()?)));
            let (what, ball, is_final) = match find(before) {
                Ok(Fresh { what, ball, is_final }) => (Ok(what), ball, is_final),
                Err(error) => (Err(why(error)?), (spot.centre, f64::INFINITY), true),
            };
            self.put(key, shape, spot, (what, ball, is_final));
        }
        let found = self.0.get(&key).ok_or(DocumentError::NothingOpen)?;
        found.what.as_ref().map_err(|why| DocumentError::NotNow(why.clone()))
    }

    fn put(&mut self, key: K, shape: S, spot: &Spot, (what, ball, is_final): (Result<T, String>, (DVec3, f64), bool)) {
        let ground = spot.ground.clone();
        self.0.insert(key, Find { shape, ground, ball, is_stale: false, is_final, what });
    }
}

/// Why nothing can be found at a place.
///
/// # Errors
/// What is not of the place: what a device or a disk fails with may be gone the next time.
pub(crate) fn why(error: DocumentError) -> Result<String, DocumentError> {
    match error {
        DocumentError::Invalid { .. } | DocumentError::NotNow(_) => Ok(error.to_string()),
        other => Err(other),
    }
}

/// Whether what was refreshed may have changed a surface in a ball.
fn touches(state: &State, refreshed: &Refreshed, ground: &Ground, (centre, reach): (DVec3, f64)) -> bool {
    let family = |id: &VolumeId| ground.family.contains(id);
    if refreshed.remapped.iter().chain(&refreshed.exchanged).any(family) {
        return true;
    }
    refreshed.slots.iter().any(|(key, refresh)| {
        let Some(subject) = state.subject(key.volume) else { return false };
        let grid = subject.grid();
        let bricks = || refresh.slots.iter().filter(|(brick, _)| brick.level == 0);
        key.kind == FieldKind::Density
            && family(&key.volume)
            && bricks().any(|(_, region)| {
                // The nearest place of the box, near enough for boxes that lie askew.
                let at = |v: [u32; 3]| DVec3::from_array(v.map(f64::from));
                let index = grid.index_from_world().transform_point3(centre);
                let near = index.clamp(at(region.lo) - 1.0, at(region.end) + 1.0);
                grid.world_from_index.transform_point3(near).distance(centre) <= reach
            })
    })
}
