//! A volume with the sub-volumes that are seen in it: whoever asks a volume about its voxels asks all of them, each place once.
//!
//! Owns who belongs to whom; which voxels are left to whom is [`Standing`]'s. Changes nothing.

use crate::document::error::DocumentError;
use crate::document::state::State;
use crate::document::subject::Subject;
use crate::math::DVec3;
use crate::segment::Lattice;
use crate::volume::{Standing, SubBox, VolumeId};

/// One of a family.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Member {
    pub id: VolumeId,
    /// The place in the family of what it is cut out of, and the box.
    pub within: Option<(usize, SubBox)>,
    /// What its own sub-volumes leave it.
    pub standing: Standing,
    /// Of one of its voxels, mm³.
    pub voxel_mm3: f64,
}

/// A volume and what is cut out of it, parents first.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Family(pub Vec<Member>);

impl State {
    /// The volume that is named with all sub-volumes inside it, parents first, whether they are seen or not; where none is named, the
    /// whole one that the active one is or is cut out of.
    ///
    /// # Errors
    /// If there is no such volume.
    pub(crate) fn with_all_inside(&self, named: Option<VolumeId>) -> Result<Vec<VolumeId>, DocumentError> {
        let active = self.at(named)?.id;
        let id = named.unwrap_or_else(|| self.scene.root_of(active));
        Ok(std::iter::once(id).chain(self.scene.cut_out_of(id)).collect())
    }

    /// The volume whose selection the parts make way for, with its sub-volumes: the first in which anything is selected, or in a
    /// sub-volume that is seen of it; else the active one.
    pub(crate) fn exploded(&self) -> Option<Family> {
        let selects = |subject: &Subject<'_>| !subject.volume.selection.is_blank();
        let roots = self.subjects().map(|subject| self.scene.root_of(subject.id));
        let mut families: Vec<VolumeId> = roots.collect();
        families.dedup();
        let mut families = families.into_iter().filter_map(|root| self.family(root).ok());
        let first = families.find(|family| family.subjects(self).any(|(_, subject)| selects(&subject)));
        first.or_else(|| self.family(self.scene.root_of(self.at(None).ok()?.id)).ok())
    }

    /// A volume with the sub-volumes that pictures show of it.
    ///
    /// # Errors
    /// If there is no such volume.
    pub(crate) fn family(&self, id: VolumeId) -> Result<Family, DocumentError> {
        self.at(Some(id))?;
        Ok(self.family_of(id, &self.with_sub_volumes(vec![id])))
    }

    /// The same with those of these volumes alone that are cut out of it.
    pub(crate) fn family_of(&self, id: VolumeId, among: &[VolumeId]) -> Family {
        let mut family: Vec<Member> = Vec::new();
        // Parents come first.
        let inner = self.scene.cut_out_of(id).into_iter().filter(|inner| among.contains(inner));
        let order: Vec<VolumeId> = std::iter::once(id).chain(inner).collect();
        for subject in order.iter().filter_map(|id| self.subject(*id)) {
            let of = subject.settings.sub_volume.filter(|_| subject.id != id);
            let host = of.and_then(|sub| Some((family.iter().position(|m| m.id == sub.parent)?, sub.of)));
            if of.is_some() && host.is_none() {
                continue;
            }
            let children = order.iter().filter_map(|id| self.scene.volumes.all.get(id)?.sub_volume);
            let inner = children.filter(|sub| sub.parent == subject.id).map(|sub| sub.of).collect();
            let standing = match host {
                Some((host, of)) => family[host].standing.of_inner(&of, inner),
                None => Standing::of_whole(subject.grid().dims, inner),
            };
            let voxel_mm3 = subject.grid().world_from_index.matrix3.determinant().abs();
            family.push(Member { id: subject.id, within: host, standing, voxel_mm3 });
        }
        Family(family)
    }
}

impl Family {
    /// Its lattices.
    pub(crate) fn lattices(&self) -> Vec<Lattice<'_>> {
        self.0.iter().map(|m| Lattice { standing: &m.standing, within: m.within }).collect()
    }

    /// Its volumes with their places, as long as the document has them all.
    pub(crate) fn subjects<'a>(&'a self, state: &'a State) -> impl Iterator<Item = (&'a Member, Subject<'a>)> {
        self.0.iter().filter_map(|member| Some((member, state.subject(member.id)?)))
    }

    /// Who may tell what is at a place of the world, the innermost first, each with the place in its index.
    pub(crate) fn telling(&self, state: &State, place: DVec3) -> Vec<(usize, DVec3)> {
        let of = |(at, (_, subject)): (usize, (&Member, Subject<'_>))| {
            let index = subject.grid().index_from_world().transform_point3(place);
            // Faces of boxes are told by either side.
            let (least, most) = (DVec3::splat(-1e-6), subject.grid().dims_f64() - 1.0 + 1e-6);
            let inside = at == 0 || (index.cmpge(least).all() && index.cmple(most).all());
            inside.then_some((at, index))
        };
        let mut all: Vec<_> = self.subjects(state).enumerate().filter_map(of).collect();
        all.reverse();
        all
    }
}
