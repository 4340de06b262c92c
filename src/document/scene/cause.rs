//! What rest poses depend on: the one place that says it.
//!
//! Whoever searches rest poses, asks whether parts have to move, or wants to know whether poses that were kept are the right ones,
//! compares this: parts, forces, camera, and how each volume is shown and lies. Names and colours are not in it, nor is the camera where
//! no force looks along rays. Knows no poses.

use crate::document::scene::Scene;
use crate::document::scene::own_looks::OwnLooks;
use crate::document::scene::shared::Shared;
use crate::document::scene::volumes::VolumeSettings;
use crate::explode::{Explosion, Face, Forces, Part, PartId};
use crate::math::{Camera, DVec3, Pose};
use crate::volume::{TransferFunction, VolumeId};
use serde::Serialize;

/// What rest poses were found for. Two that are equal have the same rest.
#[derive(Clone, Debug)]
pub(crate) struct Cause {
    explosion: Shared<Explosion>,
    camera: Option<Camera>,
    volumes: Vec<VolumeCause>,
    own_looks: Shared<OwnLooks>,
    /// How often voxels had changed that explosion points stand on.
    voxels: u64,
}

impl Cause {
    /// As it is now.
    pub(crate) fn of(scene: &Scene, voxels: u64) -> Self {
        let (explosion, volumes) = (scene.explosion.clone(), volumes_of(scene));
        let own_looks = scene.own_looks.clone();
        Self { explosion, camera: camera_of(scene).copied(), volumes, own_looks, voxels }
    }

    /// Whether it is this now.
    pub(crate) fn holds(&self, scene: &Scene, voxels: u64) -> bool {
        self.voxels == voxels
            && pushes_alike(&self.explosion, &scene.explosion)
            && self.camera.as_ref() == camera_of(scene)
            && self.volumes == volumes_of(scene)
            && self.own_looks == scene.own_looks
    }

    /// Whether rest poses are the same, if explosion points are.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        pushes_alike(&self.explosion, &other.explosion)
            && self.camera == other.camera
            && self.volumes == other.volumes
            && self.own_looks == other.own_looks
    }

    /// The parts and what pushes them.
    pub(crate) fn explosion(&self) -> &Explosion {
        &self.explosion
    }
}

/// A volume, as far as it can hide something or be selected.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct VolumeCause {
    volume: VolumeId,
    transfer: TransferFunction,
    visible: bool,
    opacity: f32,
    pose: Pose,
}

fn volumes_of(scene: &Scene) -> Vec<VolumeCause> {
    let one = |(&volume, settings): (&VolumeId, &VolumeSettings)| {
        let VolumeSettings { visible, opacity, pose, .. } = *settings;
        VolumeCause { volume, transfer: scene.transfer_of(volume).clone(), visible, opacity, pose }
    };
    scene.volumes.all.iter().map(one).collect()
}

fn camera_of(scene: &Scene) -> Option<&Camera> {
    scene.explosion.forces.viewing.then_some(&scene.views.camera)
}

/// Whether two explosions have the same bodies: forces and degree may differ.
pub(crate) fn has_same_bodies(a: &Explosion, b: &Explosion) -> bool {
    let same =
        |(a, b): (&Part, &Part)| a.id == b.id && a.held == b.held && a.importance == b.importance && a.faces == b.faces;
    a.parts.len() == b.parts.len() && a.parts.iter().zip(&b.parts).all(same)
}

/// Whether the same forces act on the same bodies, and what hides the selection is the same.
fn pushes_alike(a: &Explosion, b: &Explosion) -> bool {
    a.degree == b.degree
        && a.forces == b.forces
        && a.seed == b.seed
        && has_same_bodies(a, b)
        && a.parts.iter().zip(&b.parts).all(|(a, b)| a.visible == b.visible && a.vertices == b.vertices)
}

/// A part, as far as forces know it.
#[derive(Serialize)]
struct BodySaid<'a> {
    id: PartId,
    held: Option<Pose>,
    visible: bool,
    importance: f64,
    faces: &'a [Face],
    vertices: &'a [DVec3],
}

#[derive(Serialize)]
struct PushSaid<'a> {
    bodies: Vec<BodySaid<'a>>,
    degree: f64,
    forces: &'a Forces,
    seed: u64,
}

/// A name for the parts and what pushes them: the same wherever they are the same.
pub(crate) fn mark_of_parts(explosion: &Explosion) -> String {
    fn body(part: &Part) -> BodySaid<'_> {
        let Part { id, held, visible, importance, faces, vertices, name: _, colour: _ } = part;
        BodySaid { id: *id, held: *held, visible: *visible, importance: *importance, faces, vertices }
    }
    let bodies = explosion.parts.iter().map(body).collect();
    mark_of(&PushSaid { bodies, degree: explosion.degree, forces: &explosion.forces, seed: explosion.seed })
}

/// A name for all that a scene says of where its parts rest: the same wherever it says the same. Voxels are not in it.
pub(crate) fn mark_of_scene(scene: &Scene) -> String {
    let said = (mark_of_parts(&scene.explosion), camera_of(scene), volumes_of(scene));
    // As projects have it in which nobody had said more.
    if scene.own_looks.is_empty() { mark_of(&said) } else { mark_of(&(said, &*scene.own_looks)) }
}

fn mark_of(said: &impl Serialize) -> String {
    let mut hasher = blake3::Hasher::new();
    match serde_json::to_writer(&mut hasher, said) {
        Ok(()) => hasher.finalize().to_hex().to_string(),
        // What cannot be said is like nothing.
        Err(error) => format!("none: {error}"),
    }
}
