//! What is connected: where a command says, over the faces of sub-volumes too, and to where a stroke began.
//!
//! Told from the values as they are, the whole region at once: a way may lead far round. What is connected is decided by [`Joined`] alone,
//! which voxels are meant by [`Meant`]. Changes nothing.

use crate::document::Document;
use crate::document::apply::matter::{Meant, Voxels};
use crate::document::command::component::{Connected, Matter, PieceSize, Within};
use crate::document::error::DocumentError;
use crate::document::family::Family;
use crate::document::reduce::place::place_in;
use crate::document::state::State;
use crate::document::subject::Subject;
use crate::math::DVec3;
use crate::paint::VoxelSet;
use crate::segment::{BrickMask, ComponentId, Connectivity, Joined};
use crate::volume::{BRICK, BrickIndex, VolumeId};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What is connected in a volume and its sub-volumes, and which of it is meant.
pub(super) struct Found {
    family: Family,
    pub components: Joined,
    /// Of each component, mm³.
    amounts: Vec<f64>,
    /// Of each whether it is meant.
    picked: Vec<bool>,
}

impl Found {
    /// The volume that was asked, with its sub-volumes.
    pub(super) fn volume(&self) -> VolumeId {
        self.family.0[0].id
    }

    /// The voxels that are meant, or those of all other components, volume by volume.
    pub(super) fn of_volumes(&self, picked: bool) -> Vec<(VolumeId, Voxels)> {
        let is_wanted = |id: ComponentId| self.picked[id.0 as usize] == picked;
        let of = |(at, id): (usize, VolumeId)| (id, self.components.voxels(at, is_wanted));
        self.family.0.iter().map(|member| member.id).enumerate().map(of).collect()
    }

    /// How much is meant, mm³: its voxels, each of its volume's size.
    pub(super) fn amount(&self) -> f64 {
        self.amounts.iter().zip(&self.picked).filter(|(_, picked)| **picked).map(|(amount, _)| amount).sum()
    }

    /// How many components are meant.
    pub(super) fn pieces(&self) -> usize {
        self.picked.iter().filter(|picked| **picked).count()
    }

    /// How many voxels of each volume are meant.
    pub(super) fn picked_voxels(&self) -> Vec<(VolumeId, u64)> {
        let count = |at: usize| {
            let each: Vec<f64> = (0..self.family.0.len()).map(|l| f64::from(u8::from(l == at))).collect();
            let counts = self.components.amounts(&each);
            counts.iter().zip(&self.picked).filter(|(_, picked)| **picked).map(|(count, _)| *count as u64).sum()
        };
        self.family.0.iter().enumerate().map(|(at, member)| (member.id, count(at))).collect()
    }
}

/// What is connected where the command says, and which of it is at its place.
pub(super) fn find(
    state: &State,
    family: Family,
    connected: &Connected,
    within: Within,
    progress: &(dyn Fn(f32) -> bool + Sync),
) -> Result<Found, DocumentError> {
    if let Matter::Range([lo, hi]) = connected.matter
        && (lo.is_nan() || hi.is_nan() || lo > hi)
    {
        let found = format!("[{lo}, {hi}]");
        return Err(DocumentError::invalid("matter.range", found, "two values, the smaller first"));
    }
    let subject = state.at(connected.volume)?;
    if let Within::Segment(label) = within
        && label != 0
        && subject.segments().get(label).is_none()
    {
        return Err(DocumentError::no_segment("within.segment", label, subject.segments()));
    }
    let connectivity = match u8::from(connected.neighbours) {
        18 => Connectivity::Eighteen,
        26 => Connectivity::TwentySix,
        _ => Connectivity::Six,
    };
    let bricks = |(_, subject): (_, Subject<'_>)| subject.density.brick_indices(0).len();
    let count = family.subjects(state).map(bricks).sum::<usize>().max(1) as f32;
    let done = AtomicUsize::new(0);
    let proceed = || progress(done.fetch_add(1, Ordering::Relaxed) as f32 / count);
    let components = joined(state, &family, (connected.matter, within), connectivity, &proceed)?;
    let what = match connected.matter {
        Matter::Visible => "matter that the 3D view shows",
        Matter::Range(_) => "voxels of the range",
        Matter::Everything => "voxels",
    };
    let place = match within {
        Within::Volume => String::new(),
        Within::Selection => " in what is selected (\"within\": \"volume\" leaves the selection aside)".into(),
        Within::Segment(label) => format!(" in segment {label}"),
    };
    let sizes: Vec<f64> = family.0.iter().map(|member| member.voxel_mm3).collect();
    let amounts = components.amounts(&sizes);
    if let (Some(size), Some(at)) = (connected.smaller_than, connected.at) {
        let found = format!("{} beside at: {}", serde_json::json!(size), serde_json::json!(at));
        return Err(DocumentError::invalid("smaller_than", found, "either one component at a place or all small ones"));
    }
    if let Some(size) = connected.smaller_than {
        let is_small = |(id, amount): (u32, &f64)| match size {
            PieceSize::Mm3(mm3) => *amount < mm3,
            PieceSize::Voxels(voxels) => components.size(ComponentId(id)) < voxels,
        };
        let picked = (0..).zip(&amounts).map(is_small).collect();
        return Ok(Found { family, components, amounts, picked });
    }
    let picked = match connected.at {
        Some(at) => {
            let sample = place_in(at, subject.scene, subject.grid())?.ok_or_else(|| DocumentError::of_picture("at"))?;
            component_near(state, &family, &components, sample.position).ok_or_else(|| {
                DocumentError::invalid("at", serde_json::json!(at), format!("a place at {what}{place}"))
            })?
        }
        None => {
            let all = (0..).map(ComponentId).zip(&amounts);
            let largest = all.reduce(|best, next| if next.1 > best.1 { next } else { best });
            largest.ok_or_else(|| DocumentError::invalid("matter", "none", format!("{what}{place}")))?.0
        }
    };
    let picked = (0..components.len() as u32).map(|id| ComponentId(id) == picked).collect();
    Ok(Found { family, components, amounts, picked })
}

/// The components of a family, each voxel that is asked in one.
fn joined(
    state: &State,
    family: &Family,
    (matter, within): (Matter, Within),
    connectivity: Connectivity,
    proceed: &(dyn Fn() -> bool + Sync),
) -> Result<Joined, DocumentError> {
    let subjects = family.subjects(state);
    let meant: Vec<Meant<'_>> =
        subjects.map(|(member, subject)| Meant::new(subject, &member.standing, matter, within)).collect();
    Joined::new(&family.lattices(), connectivity, |lattice, index| match proceed() {
        true => Ok(meant[lattice].mask(index)?),
        false => Err(DocumentError::Stopped),
    })
}

/// The component at a place in the world, of whoever tells what is there: that of the voxel which holds it, or else of the nearest of the
/// eight that are mixed there. What a pixel shows may lie between voxels of which not all show.
fn component_near(state: &State, family: &Family, components: &Joined, place: DVec3) -> Option<ComponentId> {
    family.telling(state, place).into_iter().find_map(|(at, index)| {
        let dims = family.0[at].standing.dims();
        let voxel = |place: DVec3| {
            let v = (place + 0.5).floor();
            let most = DVec3::from_array(dims.map(|d| f64::from(d) - 1.0));
            // What is told to lie inside is, whatever rounding says of a face.
            let v = if at == 0 { v } else { v.clamp(DVec3::ZERO, most) };
            let inside = v.cmpge(DVec3::ZERO).all() && v.cmple(most).all();
            inside.then_some([v.x as u32, v.y as u32, v.z as u32])
        };
        if let Some(own) = voxel(index).and_then(|v| components.at(at, v)) {
            return Some(own);
        }
        let base = index.floor();
        let corner = |n: u32| base + DVec3::new(f64::from(n & 1), f64::from(n >> 1 & 1), f64::from(n >> 2));
        let mut corners: Vec<DVec3> = (0..8).map(corner).collect();
        corners.sort_by(|a, b| a.distance_squared(index).total_cmp(&b.distance_squared(index)));
        corners.into_iter().find_map(|corner| components.at(at, voxel(corner)?))
    })
}

impl Document {
    /// The voxels of volumes that are painted together which are connected to something that shows at any of these places, world mm.
    ///
    /// # Errors
    /// If the source fails.
    pub(super) fn connected_to(
        &self,
        volumes: &[VolumeId],
        places: &[DVec3],
    ) -> Result<BTreeMap<VolumeId, VoxelSet>, DocumentError> {
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        let mut sets = BTreeMap::new();
        for &volume in volumes {
            if sets.contains_key(&volume) {
                continue;
            }
            let family = state.family_of(volume, volumes);
            let what = (Matter::Visible, Within::Volume);
            let components = joined(state, &family, what, Connectivity::Six, &|| true)?;
            let near = |place: &DVec3| component_near(state, &family, &components, *place);
            let wanted: Vec<_> = places.iter().filter_map(near).collect();
            for (at, (member, subject)) in family.subjects(state).enumerate() {
                let mut set = VoxelSet::default();
                for (index, mask) in components.voxels(at, |id| wanted.contains(&id)) {
                    put(&mut set, index, &mask, subject.density.valid(0, index));
                }
                sets.insert(member.id, set);
            }
        }
        Ok(sets)
    }
}

fn put(set: &mut VoxelSet, index: BrickIndex, mask: &BrickMask, valid: [u32; 3]) {
    set.put(index, |row| mask.row(row % BRICK, row / BRICK, valid));
}
