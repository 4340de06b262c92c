//! The parts of an explosion: the whole volume, splitting it, moving parts by hand, and checking what was loaded.
//!
//! Splitting metaphor of Exploded Views (2006), 3.1. Parts partition the volume's box at every moment; hiding a part leaves
//! it in place. Knows no camera (see `splitters`) and no forces.

use crate::explode::convex;
use crate::explode::error::ExplodeError;
use crate::explode::state::{Explosion, Face, Forces, Part, PartId};
use crate::math::convex::{area, diameter, mean, polygon, volume};
use crate::math::{DVec3, Plane, Pose, nearest_region};
use crate::volume::Grid;

impl Part {
    /// Mean of the corners at rest, world mm: the centre that forces turn the part about.
    pub fn centre(&self) -> DVec3 {
        mean(&self.vertices)
    }

    /// Volume, mm³.
    pub fn volume_mm3(&self) -> f64 {
        volume(self.faces.iter().map(|f| f.plane), &self.vertices)
    }

    /// The faces' corners at rest, world mm, counter-clockwise seen from outside, in order of `faces`.
    pub fn polygons(&self) -> Vec<Vec<DVec3>> {
        self.faces.iter().map(|f| polygon(&f.plane, &self.vertices)).collect()
    }

    fn default_name(id: PartId) -> String {
        format!("Part {}", id.0)
    }
}

impl Explosion {
    /// One part: the volume's box, also where the grid is oblique. Degree 0, forces as published.
    pub fn whole(grid: &Grid) -> Self {
        let corners = grid.world_corners();
        let centre = mean(&corners);
        let mut faces = Vec::with_capacity(6);
        for axis in 0..3 {
            for side in 0..2 {
                // Bit `axis` of a corner's number says on which side it lies.
                let on: Vec<DVec3> = (0..8).filter(|i| i >> axis & 1 == side).map(|i| corners[i]).collect();
                let normal = (on[1] - on[0]).cross(on[2] - on[0]).normalize_or(DVec3::AXES[axis]);
                let plane = Plane { normal, offset: normal.dot(on[0]) };
                faces.push(Face {
                    plane: if plane.distance(centre) > 0.0 { plane.flipped() } else { plane },
                    cut: false,
                });
            }
        }
        let id = PartId(1);
        let part = Part {
            id,
            name: Part::default_name(id),
            colour: None,
            visible: true,
            held: None,
            importance: 1.0,
            faces,
            vertices: corners.to_vec(),
        };
        Self { parts: vec![part], degree: 0.0, forces: Forces::default(), seed: 0, next_id: 2 }
    }

    /// The part that holds a point of the volume at rest, world mm; of a point outside all of them the nearest. `None` without parts.
    pub fn holding(&self, rest: DVec3) -> Option<&Part> {
        nearest_region(self.parts.iter().map(|p| p.faces.iter().map(|f| &f.plane)), rest).map(|i| &self.parts[i])
    }

    /// The part that a body of a picture is. Parts' ids are those of their bodies; body 0 is what shows no single part, and then it is
    /// the part that holds the point at rest, world mm.
    pub fn of_body(&self, body: u32, rest: DVec3) -> Option<PartId> {
        if body == 0 { self.holding(rest).map(|p| p.id) } else { Some(PartId(body)) }
    }

    /// The part of an id.
    ///
    /// # Errors
    /// If there is none.
    pub fn part(&self, id: PartId) -> Result<&Part, ExplodeError> {
        self.parts.iter().find(|p| p.id == id).ok_or_else(|| self.missing(id))
    }

    /// The part of an id, to be changed.
    ///
    /// # Errors
    /// If there is none.
    pub fn part_mut(&mut self, id: PartId) -> Result<&mut Part, ExplodeError> {
        let missing = self.missing(id);
        self.parts.iter_mut().find(|p| p.id == id).ok_or(missing)
    }

    fn missing(&self, found: PartId) -> ExplodeError {
        ExplodeError::NoSuchPart { found, parts: self.parts.iter().map(|p| p.id).collect() }
    }

    /// Longest distance between two corners of the volume, mm: twice the unit of length of the forces.
    pub fn diagonal_mm(&self) -> f64 {
        let all: Vec<DVec3> = self.parts.iter().flat_map(|p| p.vertices.iter().copied()).collect();
        // Only corners of the volume are extreme, and these stay corners of some part through every split.
        let pairs = all.iter().enumerate().flat_map(|(i, a)| all[i + 1..].iter().map(move |b| a.distance_squared(*b)));
        pairs.fold(0.0, f64::max).sqrt()
    }

    /// Splits a part by a plane of the volume at rest, world mm. The inner half comes first; both keep colour, hand and the rest, get
    /// new ids, and names that follow from the old one. `None`, and nothing changes, if the plane leaves less than a fraction of a
    /// voxel on either side.
    ///
    /// # Errors
    /// If there is no such part.
    pub fn split_at_rest(&mut self, id: PartId, plane: &Plane) -> Result<Option<[PartId; 2]>, ExplodeError> {
        let whole = self.diagonal_mm();
        let at = self.parts.iter().position(|p| p.id == id).ok_or_else(|| self.missing(id))?;
        let old = &self.parts[at];
        let Some(halves) = convex::split(&old.faces, &old.vertices, plane, whole) else { return Ok(None) };
        let old = self.parts.remove(at);
        let ids = [PartId(self.next_id), PartId(self.next_id + 1)];
        self.next_id += 2;
        for ((half, id), letter) in halves.into_iter().zip(ids).zip(["a", "b"]) {
            let named = old.name != Part::default_name(old.id);
            let name = if named { format!("{} {letter}", old.name) } else { Part::default_name(id) };
            self.parts.push(Part { id, name, faces: half.faces, vertices: half.vertices, ..old.clone() });
        }
        Ok(Some(ids))
    }

    /// Moves a part by hand; forces leave it there until it is unpinned.
    ///
    /// # Errors
    /// If there is no such part, or the pose is not a rigid motion.
    pub fn place(&mut self, id: PartId, pose: Pose) -> Result<(), ExplodeError> {
        self.check_pose(self.part(id)?, &pose)?;
        self.part_mut(id)?.held = Some(Pose { rotation: pose.rotation.normalize(), ..pose });
        Ok(())
    }

    /// Whether a part can stand there: a rigid motion, and not out of sight, where it would cost every picture the way to it.
    ///
    /// # Errors
    /// What is wrong with the pose.
    pub(super) fn check_pose(&self, part: &Part, pose: &Pose) -> Result<(), ExplodeError> {
        check_rigid(pose, "pose")?;
        let centre = part.centre();
        let away = pose.apply(centre).distance(centre);
        if away <= REACH * self.diagonal_mm() {
            return Ok(());
        }
        Err(invalid("pose", format!("a part moved by {away:e} mm"), "at most 100 diagonals of the volume"))
    }

    /// Checks numbers and shapes, for instance of a project written by another program.
    ///
    /// # Errors
    /// The first field that is wrong.
    pub fn check(&self) -> Result<(), ExplodeError> {
        within("degree", self.degree, 0.0, MAX_DEGREE, "a number from 0 to 10")?;
        self.forces.check()?;
        if self.parts.is_empty() {
            return Err(invalid("parts", "none", "at least one part"));
        }
        let mut last = None;
        for (i, part) in self.parts.iter().enumerate() {
            let at = |field: &str| format!("parts[{i}].{field}");
            if last.is_some_and(|id| part.id <= id) || part.id.0 >= self.next_id {
                let expected = "ids that rise and stay below next_id";
                return Err(invalid(&at("id"), part.id.0, expected));
            }
            last = Some(part.id);
            let held = || part.held.map_or(Ok(()), |pose| self.check_pose(part, &pose));
            part.check().and_then(|()| held()).map_err(|e| e.within(&at("")))?;
        }
        Ok(())
    }
}

/// Diagonals of the volume that a part may be moved.
const REACH: f64 = 100.0;

/// Largest degree of explosion: forces grow with it, and ten times the published strength leaves every picture.
const MAX_DEGREE: f64 = 10.0;

impl Part {
    fn check(&self) -> Result<(), ExplodeError> {
        within("importance", self.importance, 1e-3, 1e6, "a number from 0.001 to 1,000,000 (pin a part to hold it)")?;
        if let Some(c) = self.colour.filter(|c| c.iter().any(|x| !(0.0..=1.0).contains(x))) {
            return Err(invalid("colour", format!("{c:?}"), "components between 0 and 1"));
        }
        if self.vertices.len() < 4 || self.vertices.iter().any(|v| !v.is_finite()) {
            return Err(invalid("vertices", format!("{} corners", self.vertices.len()), "at least 4 finite corners"));
        }
        let near = 1e-5 * diameter(&self.vertices);
        for face in &self.faces {
            let plane = &face.plane;
            let unit = (plane.normal.length() - 1.0).abs() < 1e-6;
            if !(unit && plane.offset.is_finite()) {
                return Err(invalid("faces", format!("{plane:?}"), "a normal of length 1 and a finite offset"));
            }
            if let Some(v) = self.vertices.iter().find(|&&v| plane.distance(v) > near) {
                return Err(invalid("faces", format!("corner {v} outside"), "planes that hold all corners"));
            }
            if area(&polygon(plane, &self.vertices)) <= 0.0 {
                return Err(invalid("faces", format!("{plane:?}"), "planes with at least 3 corners on them"));
            }
        }
        // A closed body's outward face areas cancel.
        let sum: DVec3 = self.faces.iter().map(|f| f.plane.normal * area(&polygon(&f.plane, &self.vertices))).sum();
        if self.faces.len() < 4 || sum.length() > 1e-5 * diameter(&self.vertices).powi(2) {
            return Err(invalid("faces", format!("{} planes", self.faces.len()), "planes that close a body"));
        }
        Ok(())
    }
}

impl Forces {
    /// Checks that every constant is a number in the range where the forces stay finite and the steps stable.
    ///
    /// # Errors
    /// The first constant that is not.
    pub fn check(&self) -> Result<(), ExplodeError> {
        let unit = "a number from 0 to 1";
        within("forces.delta_explosion", self.delta_explosion, 0.0, 1.0, unit)?;
        within("forces.delta_viewing", self.delta_viewing, 0.0, 1.0, unit)?;
        within("forces.delta_spacing", self.delta_spacing, 0.0, 1.0, unit)?;
        within("forces.return_constant", self.return_constant, 0.01, 10.0, "a number from 0.01 to 10")?;
        within("forces.return_length", self.return_length, 0.01, 10.0, "half-diagonals from 0.01 to 10")?;
        within("forces.explosion_length", self.explosion_length, 0.01, 10.0, "half-diagonals from 0.01 to 10")?;
        within("forces.softening", self.softening, 0.01, 1.0, "half-diagonals from 0.01 to 1")
    }
}

fn check_rigid(pose: &Pose, field: &str) -> Result<(), ExplodeError> {
    let rigid = (pose.rotation.length() - 1.0).abs() < 1e-3 && pose.translation.is_finite();
    let small = pose.translation.abs().max_element() < 1e9;
    if rigid && small {
        Ok(())
    } else {
        Err(invalid(
            field,
            format!("rotation {}, translation {}", pose.rotation, pose.translation),
            "a unit quaternion and finite millimetres",
        ))
    }
}

fn within(field: &str, found: f64, lo: f64, hi: f64, expected: &'static str) -> Result<(), ExplodeError> {
    if (lo..=hi).contains(&found) { Ok(()) } else { Err(invalid(field, found, expected)) }
}

fn invalid(field: &str, found: impl ToString, expected: &'static str) -> ExplodeError {
    ExplodeError::Invalid { field: field.to_owned(), found: found.to_string(), expected }
}
