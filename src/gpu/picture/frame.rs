//! What the caster is asked to draw: a list of bodies under one camera and one look.
//!
//! A body is a space (its pose), a convex region of the volume, an optional mask and a look. Parts, the posed selection and
//! the plain volume are all bodies. Nothing here knows how they are marched.

use crate::gpu::picture::focus::Focus;
use crate::gpu::picture::layer::Layers;
use crate::math::{Camera, Plane, Pose};
use crate::volume::{Lighting, Mode, Segments, SubBox, TransferFunction, VolumeId};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// What of the matter inside its region belongs to a body. The selection s divides extinction; iso-surfaces and MIP divide
/// at ½ (ERRATA, Exploded Views).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Mask {
    /// All of it: τ.
    None,
    /// The selected part: s·τ.
    Selection,
    /// The part that is not selected: (1 − s)·τ.
    Background,
}

/// Something that can be marched.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// The caller's name for it; pictures hold `id + 1`.
    pub id: u32,
    /// Whose matter it is. Its index space is that volume's.
    pub volume: VolumeId,
    /// `world_from_rest`.
    pub pose: Pose,
    /// Bounding planes with outward normals, world mm at rest, besides the volume's box.
    pub region: Vec<Plane>,
    /// Its share of the matter.
    pub mask: Mask,
    /// Row of [`Frame::looks`]; `None`: the frame's own look.
    pub look: Option<usize>,
    /// Looks by label, in place of `look`: what has none is not the body's. All of them have one kind of mode.
    pub labels: Option<Arc<LabelLooks>>,
    /// Whether it has colours for itself: then those of segments do not lie over them, nor over the selection that of selections.
    pub own_colours: bool,
    /// Display-referred; multiplies colour.
    pub tint: Option<[f32; 3]>,
    /// Names of the cutting meshes that leave it as it is, in order.
    pub spared_by: Arc<[u32]>,
}

impl Body {
    /// The whole of [`VolumeId::FIRST`] at rest.
    pub fn whole(id: u32) -> Self {
        Self {
            id,
            volume: VolumeId::FIRST,
            pose: Pose::IDENTITY,
            region: Vec::new(),
            mask: Mask::None,
            look: None,
            labels: None,
            own_colours: false,
            tint: None,
            spared_by: Arc::default(),
        }
    }
}

/// How matter becomes a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Colour and opacity.
    pub transfer: TransferFunction,
    /// How rays become colour.
    pub mode: Mode,
    /// `None`: unshaded. MIP is never shaded.
    pub lighting: Option<Lighting>,
    /// 0 to 1. Multiplies the transfer function's opacity; that of an iso-surface is 1.
    pub opacity: f32,
}

/// A look that lies elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookRef<'a> {
    /// As [`Look::transfer`].
    pub transfer: &'a TransferFunction,
    /// As [`Look::mode`].
    pub mode: Mode,
    /// As [`Look::lighting`].
    pub lighting: Option<Lighting>,
    /// As [`Look::opacity`].
    pub opacity: f32,
}

impl LookRef<'_> {
    /// Whether it is like another one.
    pub fn is(&self, other: &Look) -> bool {
        let Look { transfer, mode, lighting, opacity } = other;
        (self.mode, self.lighting, self.opacity) == (*mode, *lighting, *opacity) && self.transfer == transfer
    }

    /// The same as one that lies for itself.
    pub fn to_look(self) -> Look {
        let Self { transfer, mode, lighting, opacity } = self;
        Look { transfer: transfer.clone(), mode, lighting, opacity }
    }
}

/// A row of [`Frame::looks`] for every label, or none: then its matter is not the body's. A set of labels as a mask is one that
/// gives them the same row and the others none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LabelLooks {
    /// Of labels that are not named.
    pub default: Option<usize>,
    /// By label; 0 is what has no label.
    pub by_label: BTreeMap<u16, Option<usize>>,
}

impl LabelLooks {
    /// The row of a label.
    pub fn row(&self, label: u16) -> Option<usize> {
        self.by_label.get(&label).copied().unwrap_or(self.default)
    }

    /// The rows that any label has, in order.
    pub fn rows(&self) -> BTreeSet<usize> {
        self.by_label.values().copied().chain([self.default]).flatten().collect()
    }
}

/// How painted fields show. Opacities are 0 (hidden) to 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overlay {
    /// Painted colour over the transfer function's: `mix(table, paint, paint.a · opacity)`.
    pub colour: f32,
    /// Segment colours: `mix(colour, segment, opacity)` where a visible segment's label is.
    pub labels: f32,
    /// The selection's tint: `mix(colour, selection_colour, s · opacity)`.
    pub selection: f32,
    /// Display-referred.
    pub selection_colour: [f32; 3],
    /// Colours of the labels; hidden or missing segments leave colour alone.
    pub segments: Segments,
}

/// A box of a volume that a finer one fills: where that is drawn, its host is not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FineBox {
    /// What fills it.
    pub volume: VolumeId,
    /// What it is cut out of; another of these, perhaps.
    pub host: VolumeId,
    /// Where in the host's index space, and how fine.
    pub of: SubBox,
    /// Samples of direct volume rendering in one of its host: how much finer its closest ones lie.
    pub finer: u32,
}

/// One picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// From where.
    pub camera: Camera,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Distance of samples along the ray in mm, positive.
    pub step_mm: f64,
    /// Whether a sample of direct volume rendering stands for all matter since the sample before it, instead of for a step of what
    /// lies at it: no rings on smooth surfaces, at the same step. Surfaces and maxima do not change.
    pub refine: bool,
    /// How rays become colour.
    pub mode: Mode,
    /// `None`: unshaded. MIP is never shaded.
    pub lighting: Option<Lighting>,
    /// Colour and opacity.
    pub transfer: TransferFunction,
    /// Looks that bodies may have besides the frame's own, which `mode`, `lighting` and `transfer` are.
    pub looks: Vec<Look>,
    /// What is drawn, in any order.
    pub bodies: Vec<Body>,
    /// Painted fields.
    pub overlay: Overlay,
    /// Meshes among the bodies, what cuts and what clips them.
    pub layers: Layers,
    /// The same for volumes that have one of their own.
    pub overlays: BTreeMap<VolumeId, Overlay>,
    /// Volumes that fill boxes of others; a host stands before what fills it.
    pub boxes: Vec<FineBox>,
    /// What alone is drawn as it is, if not all of it.
    pub focus: Option<Focus>,
}

impl Frame {
    /// A look by its row; the frame's own for `None` and for rows that it has not.
    pub fn look(&self, row: Option<usize>) -> LookRef<'_> {
        match row.and_then(|row| self.looks.get(row)) {
            Some(Look { transfer, mode, lighting, opacity }) => {
                LookRef { transfer, mode: *mode, lighting: *lighting, opacity: *opacity }
            }
            None => LookRef { transfer: &self.transfer, mode: self.mode, lighting: self.lighting, opacity: 1.0 },
        }
    }

    /// The looks of a body: one, or those that any label has.
    pub fn looks_of(&self, body: &Body) -> Vec<LookRef<'_>> {
        match &body.labels {
            Some(labels) => labels.rows().into_iter().map(|row| self.look(Some(row))).collect(),
            None => vec![self.look(body.look)],
        }
    }

    /// Samples of a volume in a step of the lattice.
    pub fn steps_of(&self, volume: VolumeId) -> f64 {
        let of = self.boxes.iter().find(|b| b.volume == volume);
        of.map_or(1.0, |b| f64::from(b.finer) * self.steps_of(b.host))
    }

    /// The volume that a volume, or what it is cut out of, fills a box of; itself if it fills none.
    pub fn root_of(&self, volume: VolumeId) -> VolumeId {
        self.boxes.iter().find(|b| b.volume == volume).map_or(volume, |b| self.root_of(b.host))
    }

    /// Whether a volume fills a box of another.
    pub fn is_boxed(&self, volume: VolumeId) -> bool {
        self.boxes.iter().any(|b| b.volume == volume)
    }

    /// The same picture without them.
    #[must_use]
    pub fn without_boxes(&self) -> Self {
        let mut plain = self.clone();
        plain.boxes.clear();
        plain.bodies.retain(|body| !self.is_boxed(body.volume));
        plain
    }

    /// How a volume's painted fields show.
    pub fn overlay_of(&self, volume: VolumeId) -> &Overlay {
        self.overlays.get(&volume).unwrap_or(&self.overlay)
    }

    /// The volumes that it shows anything of, in order.
    pub fn volumes(&self) -> Vec<VolumeId> {
        let volumes: BTreeSet<_> = self.bodies.iter().map(|body| body.volume).collect();
        volumes.into_iter().collect()
    }
}
