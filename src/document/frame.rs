//! From the scene to what the GPU is asked to draw: one place for the window, renders, picks and measurements.

use crate::document::error::DocumentError;
use crate::document::scene::ViewName;
use crate::document::scene::slice_plane::SlicePlane;
use crate::document::state::State;
use crate::document::subject::Subject;
use crate::explode::{PartId, Poses};
use crate::gpu::{Body, Frame, Mask, Overlay, SliceFrame};
use crate::math::{Camera, DVec3};
use crate::volume::{FieldKind, VolumeId};
use std::collections::BTreeMap;

/// Id of the body that is not a part: the whole volume, or the selection among its parts. Parts' ids begin at 1.
pub(super) const WHOLE: u32 = 0;

/// Tint of the selection in every picture, display-referred.
pub const SELECTION_COLOUR: [f32; 3] = [1.0, 0.6, 0.15];

/// Level and width of a grey window in which every value is black, as numbers of 32 bits.
const ALL_BLACK: (f64, f64) = (2e38, 2e38);

impl Subject<'_> {
    /// What the 3D view shows with the parts in these poses.
    pub(super) fn frame(&self, poses: &Poses, camera: &Camera, size: [u32; 2]) -> Frame {
        let parts = &self.scene.explosion.parts;
        let plain = poses.at_rest(parts) && parts.iter().all(|p| p.visible && p.colour.is_none());
        let bodies = if plain { vec![Body::whole(WHOLE)] } else { self.bodies(poses) };
        self.frame_of(bodies, camera, size)
    }

    /// The selection and every visible part as a body of its own, also where all are at rest. What hides what is told by samples a
    /// voxel apart, however finely pictures are drawn.
    pub(super) fn parted_frame(&self, poses: &Poses, camera: &Camera, size: [u32; 2]) -> Frame {
        let frame = self.frame_of(self.bodies(poses), camera, size);
        Frame { step_mm: frame.step_mm.max(self.grid().voxel_mm()), refine: false, ..frame }
    }

    fn frame_of(&self, bodies: Vec<Body>, camera: &Camera, size: [u32; 2]) -> Frame {
        let look = &self.scene.look;
        Frame {
            camera: *camera,
            size,
            step_mm: look.step_voxels * self.grid().voxel_mm(),
            refine: look.refine,
            mode: self.mode(),
            lighting: self.scene.lighting_of(self.id),
            transfer: self.transfer().clone(),
            bodies,
            overlay: self.overlay(),
            layers: Default::default(),
            looks: Vec::new(),
            overlays: BTreeMap::new(),
        }
    }

    fn bodies(&self, poses: &Poses) -> Vec<Body> {
        let selected = !self.selection.is_blank();
        let mask = if selected { Mask::Background } else { Mask::None };
        let parts = self.scene.explosion.parts.iter().filter(|p| p.visible).map(|part| Body {
            id: part.id.0,
            volume: VolumeId::FIRST,
            look: None,
            labels: None,
            pose: poses.of(part),
            // The volume's own box is every body's.
            region: part.faces.iter().filter(|f| f.cut).map(|f| f.plane).collect(),
            mask,
            tint: part.colour,
        });
        let selection = selected.then(|| Body { mask: Mask::Selection, ..Body::whole(WHOLE) });
        selection.into_iter().chain(parts).collect()
    }

    /// What a slice view shows in a picture of another size; `None` for the 3D view.
    pub(super) fn slice_frame(&self, view: ViewName, size: [u32; 2]) -> Option<SliceFrame> {
        let mut views = self.scene.views.clone();
        views.slices[view.slice()?].size = size;
        let plane = SlicePlane::new(self.grid(), &views, view)?;
        let window = self.scene.window_of(self.id);
        let at = (plane.axis, plane.index);
        let shown = self.scene.layer(FieldKind::Density).visible;
        let grey = if shown { (window.level, window.width) } else { ALL_BLACK };
        Some(SliceFrame::new(self.grid(), at, size, |px| plane.world(px), grey, self.overlay()))
    }

    fn overlay(&self) -> Overlay {
        let strength = |kind: FieldKind| {
            let layer = self.scene.layer(kind);
            if layer.visible { layer.opacity } else { 0.0 }
        };
        Overlay {
            colour: strength(FieldKind::Colour),
            labels: strength(FieldKind::Labels),
            selection: strength(FieldKind::Selection),
            selection_colour: SELECTION_COLOUR,
            segments: self.segments().clone(),
        }
    }
}

impl State {
    /// The part that a picked body is, or that holds the point of a body that is none.
    pub(super) fn part_at(&self, body: u32, rest: DVec3) -> Result<PartId, DocumentError> {
        self.scene.explosion.of_body(body, rest).ok_or(DocumentError::NothingOpen)
    }
}
