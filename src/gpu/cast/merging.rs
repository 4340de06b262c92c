//! What is really marched for a list of bodies: their solids, bounds, and which of them are one.
//!
//! Bodies that share pose, look and mask, lie apart and together fill the volume's box are one body; so are the selected and
//! the other part of the same matter. The parts of an unexploded volume therefore cost what the volume costs and give its
//! picture exactly. Which of the united bodies a pixel belongs to is found afterwards, on the host.

use crate::gpu::cast::solid::Polyhedron;
use crate::gpu::cast::tiles::Window;
use crate::gpu::device::error::GpuError;
use crate::gpu::fields::matter::{LabelValues, Matter, Showing};
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::visible_values::VisibleValues;
use crate::gpu::fields::volumes::Fields;
use crate::gpu::layers::MESH_CODE;
use crate::gpu::picture::frame::{Body, Frame, LabelLooks, Mask, Overlay};
use crate::gpu::picture::image::Image;
use crate::gpu::picture::object_id::ObjectId;
use crate::math::{Aabb, DVec2, DVec3, Plane, Pose, nearest_region, outside_by};
use crate::volume::{BRICK, BrickIndex, BrickKey, CELL, Cells, Field, FieldKey, FieldKind, Grid, VolumeId};
use std::collections::BTreeMap;
use std::sync::Arc;

/// One or several bodies, marched as one.
#[derive(Clone, Debug)]
pub(crate) struct MergedBody {
    /// Whose matter it is.
    pub volume: VolumeId,
    /// In world mm, as posed.
    pub solid: Polyhedron,
    pub pose: Pose,
    /// At rest; those that cut nothing off the box are left out.
    pub planes: Vec<Plane>,
    pub mask: Mask,
    /// Row of the frame's looks.
    pub look: Option<usize>,
    pub labels: Option<Arc<LabelLooks>>,
    pub own_colours: bool,
    pub tint: Option<[f32; 3]>,
    /// Names of the cutting meshes that leave it as it is.
    pub spared_by: Arc<[u32]>,
    /// In world mm: what clips this body too.
    pub clips: Vec<Plane>,
    /// Bounds in index space.
    pub bounds: Aabb,
    /// Id and region at rest of the bodies that this one stands for.
    pub members: Vec<(u32, Arc<[Plane]>)>,
    /// Id of the body that owns selected matter, where `members` own the other.
    pub selected: Option<u32>,
}

impl MergedBody {
    /// What of its volume it shows.
    pub(crate) fn matter(&self, frame: &Frame) -> Matter {
        let values = |row| VisibleValues::of_look(frame.look(row));
        let values = match &self.labels {
            Some(labels) => Showing::ByLabel(LabelValues::new(labels, |row| values(Some(row)))),
            None => Showing::One(values(self.look)),
        };
        Matter { volume: self.volume, values, mask: self.mask }
    }

    /// Opacities of painted colour, segments and selection over it.
    pub(crate) fn overlay(&self, frame: &Frame) -> [f32; 3] {
        let Overlay { colour, labels, selection, .. } = *frame.overlay_of(self.volume);
        match (self.own_colours, self.mask) {
            (true, Mask::Selection) => [colour, 0.0, 0.0],
            (true, _) => [colour, 0.0, selection],
            (false, _) => [colour, labels, selection],
        }
    }

    /// Whether a body that both stand for has the same name.
    pub(crate) fn shares_member(&self, other: &Self) -> bool {
        let names = |d: &Self| d.members.iter().map(|m| m.0).chain(d.selected).collect::<Vec<_>>();
        let others = names(other);
        names(self).iter().any(|name| others.contains(name))
    }

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

/// A volume as bodies are cut out of it.
struct Block {
    grid: Grid,
    /// Its box in index space: with what fills a box of another volume it ends at the centres of its outermost voxels.
    whole: Aabb,
    /// The same in the world.
    solid: Polyhedron,
    /// Where anything may be selected.
    selected: Option<Aabb>,
}

impl Block {
    fn of(fields: &Fields<'_>, pools: &FieldPools, id: VolumeId, boxed: bool) -> Result<Self, GpuError> {
        let volume = fields.get(id).ok_or(GpuError::NoVolume { id: id.0 })?;
        let running = pools.pinned(FieldKey::new(id, FieldKind::Selection));
        let grid = volume.grid;
        if boxed {
            let whole = grid.centre_bounds();
            let corners = whole.corners().map(|c| grid.world_from_index.transform_point3(c));
            let selected = !volume.selection.is_blank() || !running.is_empty();
            return Ok(Self {
                grid,
                whole,
                solid: Polyhedron::hexahedron(&corners),
                selected: selected.then_some(whole),
            });
        }
        Ok(Self {
            grid,
            whole: grid.index_bounds(),
            solid: Polyhedron::hexahedron(&grid.world_corners()),
            selected: selected_bounds(volume.selection, &grid, &running),
        })
    }
}

/// How bodies become one.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Uniting<'a> {
    /// Not at all.
    No,
    /// Wherever the picture is the same.
    Yes,
    /// Only where those are one that these boxes are cut out of: surfaces and maxima of both are one.
    As(&'a [MergedBody]),
}

/// The marched bodies of a frame. What of the selection a stroke is changing right now is known by the pools.
///
/// # Errors
/// If `fields` has not the volume of a body.
pub(crate) fn unite(
    frame: &Frame,
    fields: &Fields<'_>,
    pools: &FieldPools,
    uniting: Uniting<'_>,
) -> Result<Vec<MergedBody>, GpuError> {
    let blocks = frame.volumes().into_iter().map(|id| Ok((id, Block::of(fields, pools, id, frame.is_boxed(id))?)));
    let blocks = blocks.collect::<Result<BTreeMap<_, _>, GpuError>>()?;
    // In the order of their names: sums of what overlaps, and so the picture's last bits, depend on no other order.
    let mut bodies: Vec<&Body> = frame.bodies.iter().collect();
    bodies.sort_by_key(|body| (body.id, body.volume));
    let single = bodies.into_iter().filter_map(|body| {
        let Block { grid, whole, solid: block, selected } = blocks.get(&body.volume)?;
        let whole = *whole;
        // Nothing selected: there is no selected matter, and all of it is background.
        let (mask, bounds) = match (body.mask, *selected) {
            (Mask::Selection, None) => return None,
            (Mask::Selection, Some(bounds)) => (Mask::Selection, bounds),
            (Mask::Background, None) => (Mask::None, whole),
            (mask, _) => (mask, whole),
        };
        let mut solid = if bounds == whole {
            block.clone()
        } else {
            Polyhedron::hexahedron(&bounds.corners().map(|c| grid.world_from_index.transform_point3(c)))
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
        let (look, labels) = (body.look, body.labels.clone());
        Some(MergedBody {
            volume: body.volume,
            solid: solid.posed(&pose),
            pose,
            planes,
            mask,
            look,
            labels,
            own_colours: body.own_colours,
            tint,
            spared_by: body.spared_by.clone(),
            clips: Vec::new(),
            bounds,
            members,
            selected: None,
        })
    });
    let single: Vec<MergedBody> = single.collect();
    let list = match uniting {
        Uniting::No => single,
        Uniting::Yes => unite_matter(unite_regions(single, &blocks, |_| true)),
        Uniting::As(hosts) => {
            let is_one = |group: &[MergedBody]| {
                let all = |host: &MergedBody| group.iter().all(|d| d.shares_member(host));
                hosts.iter().any(|host| host.pose == group[0].pose && all(host))
            };
            unite_matter(unite_regions(single, &blocks, is_one))
        }
    };
    Ok(list.into_iter().filter_map(|d| clipped(d, &frame.layers.clips)).collect())
}

/// What planes of the world leave of a posed body.
fn clipped(mut body: MergedBody, clips: &[Plane]) -> Option<MergedBody> {
    for clip in clips.iter().filter(|c| !body.solid.is_inside(c)).collect::<Vec<_>>() {
        body.solid = body.solid.cut(clip)?;
        body.clips.push(*clip);
    }
    Some(body)
}

/// Unites bodies of one pose, look and mask that lie apart and together fill the box.
fn unite_regions(
    single: Vec<MergedBody>,
    blocks: &BTreeMap<VolumeId, Block>,
    may_be_one: impl Fn(&[MergedBody]) -> bool,
) -> Vec<MergedBody> {
    let mut groups: Vec<Vec<MergedBody>> = Vec::new();
    for drawn in single {
        let same = |g: &&mut Vec<MergedBody>| {
            let g = &g[0];
            (g.volume, g.mask, g.tint) == (drawn.volume, drawn.mask, drawn.tint)
                && (g.look, &g.labels, g.own_colours) == (drawn.look, &drawn.labels, drawn.own_colours)
                && g.spared_by == drawn.spared_by
                && g.pose == drawn.pose
                && g.bounds == drawn.bounds
        };
        match groups.iter_mut().find(same) {
            Some(group) => group.push(drawn),
            None => groups.push(vec![drawn]),
        }
    }
    let fills = |group: &[MergedBody], block: &Polyhedron| {
        let box_volume = block.volume();
        let sum: f64 = group.iter().map(|d| d.solid.volume()).sum();
        (sum - box_volume).abs() <= 1e-9 * box_volume
            && (1..group.len()).all(|i| group[..i].iter().all(|a| a.solid.is_apart_from(&group[i].solid)))
    };
    groups
        .into_iter()
        .flat_map(|mut group| {
            let Some(Block { solid: block, .. }) = blocks.get(&group[0].volume) else { return group };
            if group.len() < 2 || group[0].mask == Mask::Selection || !may_be_one(&group) || !fills(&group, block) {
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
fn unite_matter(mut list: Vec<MergedBody>) -> Vec<MergedBody> {
    let mut at = 0;
    while at < list.len() {
        let partner = (list[at].mask == Mask::Selection).then(|| {
            list.iter().position(|d| {
                d.mask == Mask::Background
                    && d.volume == list[at].volume
                    && (d.look, &d.labels, d.own_colours) == (list[at].look, &list[at].labels, list[at].own_colours)
                    && d.spared_by == list[at].spared_by
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

/// Turns the shaders' codes into objects: twice a body's place plus 2, 1 more where its volume is selected, the label above.
pub(crate) fn resolve(image: &mut Image, codes: &[u32], drawn: &[MergedBody], frame: &Frame, window: &Window) {
    let mut hint = 0;
    let width = image.size[0] as usize;
    for (i, &code) in codes.iter().enumerate().filter(|(_, code)| **code != 0) {
        if code & MESH_CODE != 0 {
            let mesh = frame.layers.opaque.get((code & !MESH_CODE) as usize);
            image.object[i] = mesh.map_or(ObjectId::NOTHING, |m| ObjectId::new(VolumeId::FIRST, m.id, false, 0));
            continue;
        }
        let (place, selected, segment) = ((code & 0xfff) / 2, code & 1 == 1, (code >> 12) as u16);
        let Some(d) = drawn.get(place as usize - 1) else { continue };
        let id = match (d.members.as_slice(), d.selected) {
            ([(id, _)], None) => *id,
            _ => {
                let px = DVec2::new((i % width) as f64 + 0.5, (i / width) as f64 + 0.5) + window.origin;
                let world = frame.camera.ray(px, window.picture).at(f64::from(image.depth_mm[i]));
                d.owner(world, selected, &mut hint)
            }
        };
        image.object[i] = ObjectId::new(d.volume, id, selected, segment);
    }
}
