//! A rigid motion of a part: `world_from_rest`.

use crate::math::shapes::{Plane, Ray};
use glam::{DAffine3, DQuat, DVec3, EulerRot};
use serde::{Deserialize, Serialize};

/// `p_world = rotation · p_rest + translation`, millimetres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Pose {
    /// Unit quaternion, x y z w.
    #[schemars(with = "[f64; 4]")]
    pub rotation: DQuat,
    /// Millimetres.
    #[schemars(with = "[f64; 3]")]
    pub translation: DVec3,
}

impl Default for Pose {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Pose {
    /// At rest.
    pub const IDENTITY: Self = Self { rotation: DQuat::IDENTITY, translation: DVec3::ZERO };

    /// A turn about `centre` followed by a shift.
    pub fn about(centre: DVec3, rotation: DQuat, shift: DVec3) -> Self {
        Self { rotation, translation: centre + shift - rotation * centre }
    }

    /// A shift of `centre`, mm, and turns about it in degrees: about z, then y, then x, all fixed axes of the world, given as x, y, z.
    pub fn by_hand(centre: DVec3, shift: DVec3, degrees: [f64; 3]) -> Self {
        let [x, y, z] = degrees.map(f64::to_radians);
        Self::about(centre, DQuat::from_euler(EulerRot::XYZ, x, y, z), shift)
    }

    /// What [`by_hand`](Self::by_hand) makes this pose of; the turn about y is within 90°.
    pub fn shift_and_angles(&self, centre: DVec3) -> (DVec3, [f64; 3]) {
        let (x, y, z) = self.rotation.to_euler(EulerRot::XYZ);
        (self.apply(centre) - centre, [x, y, z].map(f64::to_degrees))
    }

    /// A share of the way from rest, also more than all of it: of the shift of `centre` and of the turn about it.
    #[must_use]
    pub fn share(&self, share: f64, centre: DVec3) -> Self {
        let rotation = DQuat::from_scaled_axis(self.rotation.to_scaled_axis() * share);
        Self::about(centre, rotation, (self.apply(centre) - centre) * share)
    }

    /// Where a point of the part at rest is now.
    pub fn apply(&self, p: DVec3) -> DVec3 {
        self.rotation * p + self.translation
    }

    /// Where a point of the world is in the part at rest.
    pub fn unapply(&self, p: DVec3) -> DVec3 {
        self.rotation.inverse() * (p - self.translation)
    }

    /// The same as an affine map.
    pub fn world_from_rest(&self) -> DAffine3 {
        DAffine3::from_rotation_translation(self.rotation, self.translation)
    }

    /// A plane of the part at rest, moved into the world.
    pub fn apply_plane(&self, plane: &Plane) -> Plane {
        let normal = self.rotation * plane.normal;
        Plane { normal, offset: plane.offset + normal.dot(self.translation) }
    }

    /// A plane of the world, seen from the part at rest.
    pub fn unapply_plane(&self, plane: &Plane) -> Plane {
        let offset = plane.offset - plane.normal.dot(self.translation);
        Plane { normal: self.rotation.inverse() * plane.normal, offset }
    }

    /// A ray of the world, seen from the part at rest; parameters along it stay the same.
    pub fn unapply_ray(&self, ray: &Ray) -> Ray {
        Ray { origin: self.unapply(ray.origin), dir: self.rotation.inverse() * ray.dir }
    }
}
