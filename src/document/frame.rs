//! From the scene to what the GPU is asked to draw: one place for the window, renders, picks and measurements.
//!
//! A picture shows every visible volume where it lies. A part is cut out of all of them: one body for each volume, and one more for
//! what of a volume is selected. A slice lies on the voxels of the active volume; the others are laid under and over it in their order.

use crate::document::error::DocumentError;
use crate::document::look_rows::LookRows;
use crate::document::scene::slice_plane::SlicePlane;
use crate::document::scene::volumes::SubVolume;
use crate::document::scene::{Layer, ViewName};
use crate::document::spared::{any_selection, divided};
use crate::document::state::State;
use crate::document::subject::Subject;
use crate::explode::{PartId, Poses};
use crate::gpu::{Body, FineBox, Frame, Mask, Overlay, SliceFrame, SliceLayer};
use crate::math::{Camera, DVec3};
use crate::volume::{FieldKind, VolumeId};
use std::collections::BTreeMap;

/// Id of the body that is not a part: the whole volume, or the selection among its parts. Parts' ids begin at 1.
pub(super) const WHOLE: u32 = 0;

/// Tint of the selection in every picture, display-referred.
pub const SELECTION_COLOUR: [f32; 3] = [1.0, 0.6, 0.15];

/// Level and width of a grey window in which every value is black, as numbers of 32 bits.
const ALL_BLACK: (f64, f64) = (2e38, 2e38);

impl State {
    /// The volumes that pictures show, in order; a sub-volume after all that it is cut out of.
    pub(crate) fn visible(&self) -> impl Iterator<Item = Subject<'_>> {
        let mut visible: Vec<_> = self.subjects().filter(|subject| self.is_visible(subject.id)).collect();
        visible.sort_by_key(|subject| self.layer_at(subject.id));
        visible.into_iter()
    }

    /// What lies over what: volumes by their numbers, each below its sub-volumes, inner ones over outer ones.
    fn layer_at(&self, id: VolumeId) -> (VolumeId, usize, VolumeId) {
        (self.scene.root_of(id), self.scene.depth_of(id), id)
    }

    /// Whether pictures show a volume; a sub-volume only with what it is cut out of.
    fn is_visible(&self, id: VolumeId) -> bool {
        let settings = self.scene.volumes.all.get(&id).filter(|v| v.visible && v.opacity > 0.0);
        settings.is_some_and(|v| match self.scene.lies_in(id) {
            Some(sub) => self.is_visible(sub.parent),
            None => v.sub_volume.is_none(),
        })
    }

    /// The sub-volumes that pictures show, parents first.
    fn boxes(&self) -> Vec<FineBox> {
        let of = |subject: Subject<'_>| {
            let SubVolume { parent, of } = subject.settings.sub_volume?;
            let coarse = self.subject(parent)?.grid().voxel_mm();
            let finer = (coarse / subject.grid().voxel_mm() - 1e-6).ceil().max(1.0) as u32;
            Some(FineBox { volume: subject.id, host: parent, of, finer })
        };
        self.visible().filter_map(of).collect()
    }

    /// Corners of the sub-volumes that pictures show, where they lie, world mm, in the order of `Aabb::corners`.
    pub fn box_corners(&self) -> BTreeMap<VolumeId, [DVec3; 8]> {
        let of = |subject: Subject<'_>| {
            subject.settings.sub_volume?;
            let grid = subject.grid();
            Some((subject.id, grid.centre_bounds().corners().map(|c| grid.world_from_index.transform_point3(c))))
        };
        self.visible().filter_map(of).collect()
    }

    /// Volumes that a stroke names, with the sub-volumes that pictures show of them: what is painted there is painted in these.
    pub(super) fn with_sub_volumes(&self, named: Vec<VolumeId>) -> Vec<VolumeId> {
        let mut all = named.clone();
        for inner in named.iter().flat_map(|id| self.scene.cut_out_of(*id)) {
            if self.is_visible(inner) && !all.contains(&inner) {
                all.push(inner);
            }
        }
        all
    }

    /// The voxels of a volume that sub-volumes stand for which are painted too: from one on and before another, along each axis.
    pub(super) fn finer_boxes(&self, id: VolumeId, painted: &[VolumeId]) -> Vec<[[u32; 3]; 2]> {
        let inner = self.scene.boxes_of(id).filter(|(inner, _)| painted.contains(inner));
        // Voxels on its faces are seen from outside.
        inner.map(|(_, SubVolume { of, .. })| [of.lo.map(|v| v + 1), of.hi]).collect()
    }

    /// Whether anything is selected in a volume, in one that it is cut out of or that is cut out of that one.
    fn selects(&self, id: VolumeId) -> bool {
        let root = self.scene.root_of(id);
        let mut family = self.subjects().filter(|subject| self.scene.root_of(subject.id) == root);
        family.any(|subject| !subject.selection.is_blank())
    }

    /// What the 3D view shows with the parts in these poses.
    pub(super) fn frame(&self, poses: &Poses, camera: &Camera, size: [u32; 2]) -> Frame {
        let parts = &self.scene.explosion.parts;
        let plain = poses.at_rest(parts)
            && parts.iter().all(|p| p.visible && p.colour.is_none())
            && !self.visible().any(|subject| subject.is_dressed_in_parts())
            && !any_selection(&self.scene.sparing());
        self.frame_of(camera, size, |subject| {
            if plain { vec![whole_of(subject)] } else { bodies_of(subject, self.selects(subject.id), poses) }
        })
    }

    /// The selection and every visible part as a body of its own, also where all are at rest. What hides what is told by samples a
    /// voxel apart, however finely pictures are drawn.
    pub(super) fn parted_frame(&self, poses: &Poses, camera: &Camera, size: [u32; 2]) -> Frame {
        let frame = self.frame_of(camera, size, |subject| bodies_of(subject, self.selects(subject.id), poses));
        Frame { step_mm: frame.step_mm.max(self.voxel_mm()), refine: false, ..frame }
    }

    /// Smallest spacing of all visible volumes in mm, however finely boxes of them are divided; where there is none that of nothing, 1.
    fn voxel_mm(&self) -> f64 {
        self.visible()
            .filter(|subject| subject.settings.sub_volume.is_none())
            .map(|subject| subject.grid().voxel_mm())
            .reduce(f64::min)
            .unwrap_or(1.0)
    }

    fn frame_of(&self, camera: &Camera, size: [u32; 2], bodies: impl Fn(&Subject<'_>) -> Vec<Body>) -> Frame {
        let scene = &self.scene;
        let mut rows = LookRows::new(scene);
        let mut dressed = Vec::new();
        let mut overlays = BTreeMap::new();
        let sparing = scene.sparing();
        for subject in self.visible() {
            let bodies = bodies(&subject).into_iter();
            let looking = bodies.flat_map(|body| rows.dress(&subject, body));
            dressed.extend(looking.flat_map(|body| divided(&subject, body, &sparing)));
            overlays.insert(subject.id, self.overlay_in_3d(&subject));
        }
        let mut frame = Frame {
            camera: *camera,
            size,
            step_mm: scene.look.step_voxels * self.voxel_mm(),
            refine: scene.look.refine,
            mode: scene.look.mode,
            lighting: scene.look.lighting,
            transfer: (*scene.transfer).clone(),
            bodies: Vec::new(),
            overlay: Overlay::default(),
            layers: Default::default(),
            looks: Vec::new(),
            overlays,
            boxes: self.boxes(),
            focus: None,
        };
        rows.put(dressed, &mut frame);
        frame
    }

    /// What a slice view shows in a picture of another size; `None` for the 3D view, and where there is no volume.
    pub(super) fn slice_frame(&self, view: ViewName, size: [u32; 2]) -> Option<SliceFrame> {
        let mut views = (*self.scene.views).clone();
        views.slices[view.slice()?].size = size;
        let active = self.at(None).ok()?;
        let plane = SlicePlane::new(active.grid(), &views, view)?;
        let grey = |subject: &Subject<'_>| {
            let window = self.scene.window_of(subject.id);
            self.scene.layer_of(subject.id, FieldKind::Density).visible.then_some((window.level, window.width))
        };
        let world = |px| plane.world(px);
        let (at, overlay) = ((plane.axis, plane.index), self.overlay(&active, Layer::in_slices));
        let mut frame = SliceFrame::new(active.grid(), at, size, world, grey(&active).unwrap_or(ALL_BLACK), overlay);
        frame.own.volume = active.id;
        frame.own.opacity = if active.settings.visible { active.settings.opacity } else { 0.0 };
        for subject in self.visible().filter(|subject| subject.id != active.id) {
            let is_under = self.layer_at(subject.id) < self.layer_at(active.id);
            let lowest = frame.under.is_empty() && is_under;
            // A label map over something else shows its labels, not their numbers.
            let grey = grey(&subject).filter(|_| !subject.is_label_map());
            let grey = if lowest { grey.or(Some(ALL_BLACK)) } else { grey };
            let (of, overlay) = ((subject.id, subject.grid()), self.overlay(&subject, Layer::in_slices));
            let layer = SliceLayer::new(of, size, world, grey, subject.settings.opacity, overlay);
            if is_under { frame.under.push(layer) } else { frame.over.push(layer) }
        }
        if !frame.under.is_empty() && (grey(&active).is_none() || active.is_label_map()) {
            frame.own.window = None;
        }
        Some(frame)
    }

    /// How painted fields lie over a volume in 3D. A segment that has colours for itself there shows those.
    fn overlay_in_3d(&self, subject: &Subject<'_>) -> Overlay {
        let mut overlay = self.overlay(subject, Layer::in_3d);
        let own = |label: u16| self.scene.own_looks.segment(subject.id, label);
        for segment in &mut overlay.segments.0 {
            segment.visible &= own(segment.id).is_none_or(|change| change.transfer.is_none());
        }
        overlay
    }

    fn overlay(&self, subject: &Subject<'_>, strength: impl Fn(&Layer) -> f32) -> Overlay {
        let strength = |kind: FieldKind| strength(&self.scene.layer_of(subject.id, kind));
        Overlay {
            colour: strength(FieldKind::Colour),
            labels: strength(FieldKind::Labels),
            selection: strength(FieldKind::Selection),
            selection_colour: SELECTION_COLOUR,
            segments: subject.segments().clone(),
        }
    }
}

impl Subject<'_> {
    /// Whether its values are ids that its labels say anyway.
    fn is_label_map(&self) -> bool {
        self.settings.label_map || !self.histogram.ids.is_empty() && !self.labels.is_blank()
    }
}

/// A volume at rest, in one piece.
fn whole_of(subject: &Subject<'_>) -> Body {
    Body { volume: subject.id, ..Body::whole(WHOLE) }
}

/// What of a volume is selected, if anything can be, and its share of every visible part.
fn bodies_of(subject: &Subject<'_>, selected: bool, poses: &Poses) -> Vec<Body> {
    let mask = if selected { Mask::Background } else { Mask::None };
    let parts = subject.scene.explosion.parts.iter().filter(|p| p.visible).map(|part| Body {
        id: part.id.0,
        pose: poses.of(part),
        // The volume's own box is every body's.
        region: part.faces.iter().filter(|f| f.cut).map(|f| f.plane).collect(),
        mask,
        tint: part.colour,
        ..whole_of(subject)
    });
    let selection = selected.then(|| Body { mask: Mask::Selection, ..whole_of(subject) });
    selection.into_iter().chain(parts).collect()
}

impl State {
    /// The part that a picked body is, or that holds the point of a body that is none.
    pub(super) fn part_at(&self, body: u32, rest: DVec3) -> Result<PartId, DocumentError> {
        self.scene.explosion.of_body(body, rest).ok_or(DocumentError::NothingOpen)
    }
}
