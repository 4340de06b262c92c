//! What a hand feels of a surface: the contact test and the force of "Direct Volume Editing" (2008), section 3.1.
//!
//! A [`ContactField`] is the density about a place as the host knows it, copied once, so that a device's own thread may ask it a thousand
//! times a second without a lock, a file or the GPU. It is as old as the last read-back: a running stroke is felt when it has ended. A
//! [`ContactFeed`] hands the newest one from the document to the device. Owns no hand and no pose: places are those of the world at rest.

use crate::document::error::DocumentError;
use crate::document::live::voxel_surface::VoxelSurface;
use crate::document::scene::check::{finite, positive};
use crate::document::state::State;
use crate::math::DVec3;
use crate::volume::VolumeId;
use std::sync::{Arc, Mutex, PoisonError, TryLockError};

/// How far about a place a field is known: so many of the volume's voxels ...
const REACH_VOXELS: f64 = 24.0;
/// ... and so many mm at most.
const MOST_REACH_MM: f64 = 40.0;

/// How hard a surface is ("Direct Volume Editing", section 3.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactForce {
    /// Force by depth, N/mm, above 0.
    pub stiffness_n_per_mm: f64,
    /// The greatest force, N, above 0: what the device can and a hand may bear.
    pub most_n: f64,
    /// How far outside of the surface it counts as touched, mm, not below 0.
    pub tolerance_mm: f64,
}

impl Default for ContactForce {
    /// What a small desktop device renders steadily at 1,000 Hz.
    fn default() -> Self {
        Self { stiffness_n_per_mm: 0.5, most_n: 3.0, tolerance_mm: 0.25 }
    }
}

impl ContactForce {
    /// # Errors
    /// If a number is out of its range.
    pub fn check(&self) -> Result<(), DocumentError> {
        positive("stiffness", self.stiffness_n_per_mm)?;
        positive("most", self.most_n)?;
        finite("tolerance_mm", self.tolerance_mm)?;
        if self.tolerance_mm < 0.0 {
            return Err(DocumentError::invalid("tolerance_mm", self.tolerance_mm, "0 or more"));
        }
        Ok(())
    }

    /// The force at a depth, N: stiffness × depth, no less than 0, since a surface does not pull, and no more than the greatest.
    pub fn at_depth(&self, depth_mm: f64) -> f64 {
        (self.stiffness_n_per_mm * depth_mm).clamp(0.0, self.most_n)
    }
}

/// How a point stands to a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// Whether the field knows the place: it lies in the volume and near enough to where the field was taken.
    pub known: bool,
    /// Whether the value there is above the surface's.
    pub inside: bool,
    /// Whether it is inside, or outside within the tolerance.
    pub touching: bool,
    /// (f − value)/|∇f|, mm: how deep it lies, below 0 outside. `None` where the field is even, and where it is unknown.
    pub depth_mm: Option<f64>,
    /// Outward unit normal −∇f/|∇f|, world at rest. `None` as above.
    pub normal: Option<DVec3>,
    /// The force on the hand, N, world axes.
    pub force_n: DVec3,
}

/// The density about a place, for the thread of a device. Cheap to clone.
#[derive(Clone, Debug)]
pub struct ContactField {
    /// The surface of value 0, so that its numbers are the field's own.
    surface: Arc<VoxelSurface>,
    volume: VolumeId,
    centre: DVec3,
    reach_mm: f64,
    revision: u64,
}

impl ContactField {
    /// The density of a volume and of the sub-volumes that pictures show of it about a place, world mm at rest.
    ///
    /// # Errors
    /// If there is no such volume, or its source fails.
    pub(crate) fn about(state: &State, volume: VolumeId, at: DVec3, revision: u64) -> Result<Self, DocumentError> {
        let reach_mm = (REACH_VOXELS * state.at(Some(volume))?.grid().voxel_mm()).min(MOST_REACH_MM);
        let surface = Arc::new(VoxelSurface::about(state, volume, 0.0, at, reach_mm)?);
        Ok(Self { surface, volume, centre: at, reach_mm, revision })
    }

    /// Whose surface it is.
    pub fn volume(&self) -> VolumeId {
        self.volume
    }

    /// About where it was taken, world mm at rest.
    pub fn centre(&self) -> DVec3 {
        self.centre
    }

    /// How far about that it is known, mm.
    pub fn reach_mm(&self) -> f64 {
        self.reach_mm
    }

    /// How a point, world mm at rest, stands to the surface of a value, and what force it feels.
    pub fn contact(&self, at: DVec3, value: f64, law: &ContactForce) -> Contact {
        if at.distance(self.centre) > self.reach_mm {
            return Contact::default();
        }
        let Some((number, slope)) = self.surface.number_and_slope(at) else { return Contact::default() };
        let (above, steep) = (number - value, slope.length());
        let (depth_mm, normal) = if steep > 0.0 && (above / steep).is_finite() {
            (Some(above / steep), Some(-slope / steep))
        } else {
            (None, None)
        };
        let inside = above > 0.0;
        let touching = inside || depth_mm.is_some_and(|depth| depth >= -law.tolerance_mm);
        let force_n = match (depth_mm, normal) {
            (Some(depth), Some(normal)) => normal * law.at_depth(depth),
            _ => DVec3::ZERO,
        };
        Contact { known: true, inside, touching, depth_mm, normal, force_n }
    }
}

#[derive(Debug, Default)]
struct Between {
    /// Where the device is, and whose surface it feels: the active volume's if none is named.
    wanted: Mutex<Option<(DVec3, Option<VolumeId>)>>,
    latest: Mutex<Option<ContactField>>,
}

/// The line between a document and the thread of a device. Neither waits for the other: what one of them is changing this very moment the
/// other has the next time.
#[derive(Clone, Debug, Default)]
pub struct ContactFeed(Arc<Between>);

impl ContactFeed {
    /// Says where the device is, world mm at rest, and whose surface it feels.
    pub fn want(&self, at: DVec3, volume: Option<VolumeId>) {
        if let Ok(mut wanted) = self.0.wanted.try_lock() {
            *wanted = Some((at, volume));
        }
    }

    /// The newest field; the `known` one while the document puts another there.
    pub fn latest(&self, known: Option<ContactField>) -> Option<ContactField> {
        match self.0.latest.try_lock() {
            Ok(latest) => latest.clone().or(known),
            Err(TryLockError::WouldBlock | TryLockError::Poisoned(_)) => known,
        }
    }

    /// Nothing can be felt any more: another document is open.
    pub(crate) fn forget(&self) {
        *self.0.latest.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }

    /// Puts a newer field there where the device has moved on or something was changed. Answers whether it did.
    ///
    /// # Errors
    /// If there is no such volume, or its source fails.
    pub(crate) fn renew(&self, state: &State, revision: u64) -> Result<bool, DocumentError> {
        let wanted = *self.0.wanted.lock().unwrap_or_else(PoisonError::into_inner);
        let Some((at, volume)) = wanted.filter(|(at, _)| at.is_finite()) else { return Ok(false) };
        let volume = state.scene.root_of(state.at(volume)?.id);
        let latest = self.0.latest.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let is_it = |field: &ContactField| {
            field.revision == revision && field.volume == volume && field.centre.distance(at) <= 0.5 * field.reach_mm
        };
        if latest.as_ref().is_some_and(is_it) {
            return Ok(false);
        }
        // Made before the lock is taken, so that the device is never kept from the one before.
        let field = ContactField::about(state, volume, at, revision)?;
        *self.0.latest.lock().unwrap_or_else(PoisonError::into_inner) = Some(field);
        Ok(true)
    }
}
