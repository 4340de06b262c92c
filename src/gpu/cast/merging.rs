//! What is really marched for a list of bodies: their solids, bounds, and which of them are one.
//!
//! Bodies that share pose, look and mask, lie apart and together fill the volume's box are one body; so are the selected and
//! the other part of the same matter. The parts of an unexploded volume therefore cost what the volume costs and give its
//! picture exactly. Which of the united bodies a pixel belongs to is found afterwards, on the host.

use crate::gpu::cast::solid::Solid;
use crate::gpu::cast::tiles::Window;
use crate::gpu::fields::pools::Fields;
use crate::gpu::layers::MESH_CODE;
use crate::gpu::picture::frame::{Body, Frame, Mask};
use crate::gpu::picture::image::Image;
use crate::math::{Aabb, DVec2, DVec3, Plane, Pose, nearest_region, outside_by};
use crate::volume::{BRICK, BrickIndex, BrickKey, CELL, Cells, Field, Grid};
use std::sync::Arc;

/// One or several bodies, marched as one.
#[derive(Clone, Debug)]
pub(crate) struct Drawn {
    /// In world mm, as posed.
    pub solid: Solid,
    pub pose: Pose,
    /// At rest; those that cut nothing off the box are left out.
    pub planes: Vec<Plane>,
    pub mask: Mask,
    pub tint: Option<[f32; 3]>,
    /// In world mm: what clips this body too.
    pub clips: Vec<Plane>,
    /// Bounds in index space.
    pub bounds: Aabb,
    /// Id and region at rest of the bodies that this one stands for.
    pub members: Vec<(u32, Arc<[Plane]>)>,
    /// Id of the body that owns selected matter, where `members` own the other.
    pub selected: Option<u32>,
}

impl Drawn {
    /// The body that a point of the world on it belongs to.
    pub(crate) fn owner(&self, world: DVec3, selected: bool, hint: &mut usize) -> u32 {
        if let (true, Some(id)) = (selected, self.selected) {
            return id;
        }
        if self.members.len() == 1 {
            return self.members[0].0;
        }
        let rest = self.pose.unapply(world);
        // Neighbouring pixels belong to the same body.
        if self.members.get(*hint).is_none_or(|(_, planes)| outside_by(planes.iter(), rest) > 0.0) {
            *hint = nearest_region(self.members.iter().map(|(_, planes)| planes.iter()), rest).unwrap_or(0);
        }
        self.members[*hint].0
    }
}

/// The marched bodies of a frame. `running` are bricks of the selection that a stroke is changing right now.
pub(crate) fn drawn(
    frame: &Frame,
    grid: &Grid,
    fields: &Fields<'_>,
    running: &[BrickIndex],
    unite_bodies: bool,
) -> Vec<Drawn> {
    let whole = grid.index_bounds();
    let selection = selected_bounds(fields.selection, grid, running);
    let block = Solid::hexahedron(&grid.world_corners());
    // In the order of their names: sums of what overlaps, and so the picture's last bits, depend on no other order.
    let mut bodies: Vec<&Body> = frame.bodies.iter().collect();
    bodies.sort_by_key(|body| body.id);
    let single = bodies.into_iter().filter_map(|body| {
        // Nothing selected: there is no selected matter, and all of it is background.
        let (mask, bounds) = match (body.mask, selection) {
            (Mask::Selection, None) => return None,
            (Mask::Selection, Some(bounds)) => (Mask::Selection, bounds),
            (Mask::Background, None) => (Mask::None, whole),
            (mask, _) => (mask, whole),
        };
        let mut solid = if bounds == whole {
            block.clone()
        } else {
            Solid::hexahedron(&bounds.corners().map(|c| grid.world_from_index.transform_point3(c)))
        };
        let mut planes = Vec::new();
        for plane in &body.region {
            if !solid.is_inside(plane) {
                solid = solid.cut(plane)?;
                planes.push(*plane);
            }
        }
        let members = vec![(body.id, planes.clone().into())];
        let (pose, tint) = (body.pose, body.tint);
        Some(Drawn {
            solid: solid.posed(&pose),
            pose,
            planes,
            mask,
            tint,
            clips: Vec::new(),
            bounds,
            members,
            selected: None,
        })
    });
    let single: Vec<Drawn> = single.collect();
    let list = if unite_bodies { unite_matter(unite_regions(single, &block)) } else { single };
    list.into_iter().filter_map(|d| clipped(d, &frame.layers.clips)).collect()
}

/// What planes of the world leave of a posed body.
fn clipped(mut body: Drawn, clips: &[Plane]) -> Option<Drawn> {
    for clip in clips.iter().filter(|c| !body.solid.is_inside(c)).collect::<Vec<_>>() {
        body.solid = body.solid.cut(clip)?;
        body.clips.push(*clip);
    }
    Some(body)
}

/// Unites bodies of one pose, look and mask that lie apart and together fill the box.
fn unite_regions(single: Vec<Drawn>, block: &Solid) -> Vec<Drawn> {
    let mut groups: Vec<Vec<Drawn>> = Vec::new();
    for drawn in single {
        let same = |g: &&mut Vec<Drawn>| {
            g[0].pose == drawn.pose && g[0].mask == drawn.mask && g[0].tint == drawn.tint && g[0].bounds == drawn.bounds
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push(drawn),
            None => groups.push(vec![drawn]),
        }
    }
    let box_volume = block.volume();
    let fills = |group: &[Drawn]| {
        let sum: f64 = group.iter().map(|d| d.solid.volume()).sum();
        (sum - box_volume).abs() <= 1e-9 * box_volume
            && (1..group.len()).all(|i| group[..i].iter().all(|a| a.solid.is_apart_from(&group[i].solid)))
    };
    groups
        .into_iter()
        .flat_map(|mut group| {
            if group.len() < 2 || group[0].mask == Mask::Selection || !fills(&group) {
                return group;
            }
            let members = group.iter().flat_map(|d| d.members.iter().cloned()).collect();
            let mut one = group.swap_remove(0);
            one.solid = block.posed(&one.pose);
            one.planes.clear();
            one.members = members;
            vec![one]
        })
        .collect()
}

/// Unites the selected and the other part of the same matter: s·τ + (1 − s)·τ = τ.
fn unite_matter(mut list: Vec<Drawn>) -> Vec<Drawn> {
    let mut at = 0;
    while at < list.len() {
        let partner = (list[at].mask == Mask::Selection).then(|| {
            list.iter().position(|d| {
                d.mask == Mask::Background
                    && d.pose == list[at].pose
                    && d.tint == list[at].tint
                    && d.planes == list[at].planes
                    && d.selected.is_none()
            })
        });
        match partner.flatten() {
            Some(background) => {
                list[background].mask = Mask::None;
                list[background].selected = Some(list[at].members[0].0);
                list.remove(at);
            }
            None => at += 1,
        }
    }
    list
}

/// Bounds in index space of all places where the selection may be above 0, `None` if it is nowhere.
fn selected_bounds(selection: &Field, grid: &Grid, running: &[BrickIndex]) -> Option<Aabb> {
    let mut corners: Vec<DVec3> = Vec::new();
    let at = |v: [u32; 3]| DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2])) - 0.5;
    for &index in selection.edits().keys() {
        let origin = at(index.origin());
        match selection.cells(BrickKey { level: 0, index }) {
            Cells::Uniform([_, max]) if max > 0.0 => corners.extend([origin, origin + f64::from(BRICK)]),
            Cells::Uniform(_) => {}
            Cells::Dense(cells) => {
                let n = BRICK / CELL;
                for (i, _) in cells.iter().enumerate().filter(|(_, c)| c[1] > 0.0) {
                    let i = i as u32;
                    let cell = origin + f64::from(CELL) * (at([i % n, i / n % n, i / (n * n)]) + 0.5);
                    corners.extend([cell, cell + f64::from(CELL)]);
                }
            }
        }
    }
    for index in running {
        let origin = at(index.origin());
        corners.extend([origin, origin + f64::from(BRICK)]);
    }
    // A voxel at a brick's border reaches one voxel into the neighbour.
    let bounds = Aabb::around(corners)?;
    let whole = grid.index_bounds();
    Some(Aabb { min: (bounds.min - 1.0).max(whole.min), max: (bounds.max + 1.0).min(whole.max) })
}

/// Turns the shaders' object codes into ids.
pub(crate) fn resolve(image: &mut Image, drawn: &[Drawn], frame: &Frame, window: &Window) {
    let mut hint = 0;
    let width = image.size[0] as usize;
    for (i, object) in image.object.iter_mut().enumerate() {
        if *object == 0 {
            continue;
        }
        let depth = image.depth_mm[i];
        if *object & MESH_CODE != 0 {
            *object = frame.layers.opaque.get((*object & !MESH_CODE) as usize).map_or(0, |m| m.id + 1);
            continue;
        }
        let Some(d) = drawn.get((*object / 2) as usize - 1) else { continue };
        if let ([(id, _)], None) = (d.members.as_slice(), d.selected) {
            *object = id + 1;
            continue;
        }
        let px = DVec2::new((i % width) as f64 + 0.5, (i / width) as f64 + 0.5) + window.origin;
        let world = frame.camera.ray(px, window.picture).at(f64::from(depth));
        *object = d.owner(world, *object & 1 == 1, &mut hint) + 1;
    }
}
