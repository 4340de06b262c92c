//! What a volume that was just opened looks like.

use crate::document::scene::volumes::{VolumeLook, VolumeSettings, Volumes};
use crate::document::scene::{Layer, Looks, Origin, Scene, SliceView, ViewName, Views, Window, first_look};
use crate::math::DVec3;
use crate::paint::Brush;
use crate::volume::{FieldKind, Grid, Histogram, VolumeId};
use std::collections::BTreeMap;

impl Scene {
    /// A scene of no volume: a decimetre of empty room about the origin.
    pub fn empty() -> Self {
        let grid = Grid::aligned([100; 3], DVec3::ONE, DVec3::splat(-49.5));
        let histogram = Histogram { min: 0.0, max: 1.0, bins: vec![1, 1], ids: Vec::new(), voids: [0; 2] };
        let mut scene = Self::new(&grid, &histogram, VolumeSettings::new("", Origin::nowhere()));
        (scene.volumes, scene.shown) = (Volumes::default().into(), BTreeMap::new().into());
        scene
    }
}

impl Scene {
    /// How everything is shown.
    pub fn looks(&self) -> Looks {
        let Self { transfer, look, shown, layers, focus, .. } = self;
        Looks {
            transfer: transfer.clone(),
            look: look.clone(),
            shown: shown.clone(),
            layers: layers.clone(),
            focus: focus.clone(),
        }
    }
}

impl Looks {
    /// Whether a scene is shown so; of volumes those count that both know.
    pub(crate) fn are_of(&self, scene: &Scene) -> bool {
        self.transfer == scene.transfer
            && self.look == scene.look
            && self.layers == scene.layers
            && self.focus == scene.focus
            && self.shown.iter().all(|(id, shown)| scene.shown.get(id).is_none_or(|now| now == shown))
    }

    /// Shows a scene so, and holds how it was shown. A volume that came or went since is shown as it is.
    pub(crate) fn exchange(&mut self, scene: &mut Scene) {
        std::mem::swap(&mut self.transfer, &mut scene.transfer);
        std::mem::swap(&mut self.look, &mut scene.look);
        std::mem::swap(&mut self.layers, &mut scene.layers);
        std::mem::swap(&mut self.focus, &mut scene.focus);
        for (id, shown) in self.shown.iter_mut() {
            if let Some(now) = scene.shown.get_mut(id) {
                std::mem::swap(shown, now);
            }
        }
    }
}

impl VolumeLook {
    /// As the document is shown, with this grey window.
    pub fn new(window: Window) -> Self {
        Self { window, own: None, layers: Vec::new() }
    }

    /// The first volume of a document is shown as its histogram says.
    pub(crate) fn of_first(histogram: &Histogram) -> BTreeMap<VolumeId, Self> {
        BTreeMap::from([(VolumeId::FIRST, Self::new(Window::from_histogram(histogram)))])
    }
}

/// The brush to begin with: 5 mm, or five voxels where that is less than one or more than 64.
pub(crate) fn brush_for(grid: &Grid) -> Brush {
    let (brush, voxel_mm) = (Brush::default(), grid.voxel_mm());
    let fits = (1.0..=64.0).contains(&(brush.radius_mm / voxel_mm));
    Brush { radius_mm: if fits { brush.radius_mm } else { 5.0 * voxel_mm }, ..brush }
}

impl Layer {
    /// As a field is shown until somebody says otherwise.
    pub fn new(field: FieldKind) -> Self {
        let opacity = match field {
            FieldKind::Density | FieldKind::Colour => 1.0,
            FieldKind::Selection | FieldKind::Labels => 0.5,
        };
        Self { field, visible: true, opacity, opacity_3d: None }
    }

    /// How strongly it shows in slices, 0..1.
    pub fn in_slices(&self) -> f32 {
        if self.visible { self.opacity } else { 0.0 }
    }

    /// How strongly it shows in 3D, 0..1; density as its transfer function says.
    pub fn in_3d(&self) -> f32 {
        if self.visible { self.opacity_3d.unwrap_or(self.opacity) } else { 0.0 }
    }
}

impl Scene {
    /// How a field of the active volume is shown.
    pub fn layer(&self, field: FieldKind) -> Layer {
        self.layer_of(self.volumes.active, field)
    }

    /// How a field of a volume is shown: in its own way or in the document's. Older projects do not say it of density.
    pub fn layer_of(&self, volume: VolumeId, field: FieldKind) -> Layer {
        let shared = || self.layers.iter().find(|l| l.field == field).copied();
        self.own_layer(volume, field).or_else(shared).unwrap_or_else(|| Layer::new(field))
    }

    /// The way in which a volume alone shows a field.
    pub(crate) fn own_layer(&self, volume: VolumeId, field: FieldKind) -> Option<Layer> {
        let own = |volume| self.shown.get(&volume)?.layers.iter().find(|l| l.field == field).copied();
        own(volume).or_else(|| own(self.root_of(volume)))
    }

    /// The scene as JSON says it: a path that is not UTF-8 comes back with marks in it.
    pub(crate) fn sayable(&self) -> Self {
        let mut scene = self.clone();
        for volume in scene.volumes.all.values_mut() {
            volume.origin.path = volume.origin.path.to_string_lossy().into_owned().into();
        }
        scene
    }
}

impl Views {
    /// All of the volume in every view, 512 pixels square.
    pub fn new(grid: &Grid) -> Self {
        let bounds = grid.world_bounds();
        let slice = SliceView {
            centre: bounds.centre(),
            height_mm: (bounds.max - bounds.min).max_element().max(grid.voxel_mm()),
            size: [512; 2],
        };
        Self { camera: first_look::camera(grid), size: [512; 2], slices: [slice; 3], crosshair: bounds.centre() }
    }

    /// A slice view; `None` for the 3D view.
    pub fn slice(&self, name: ViewName) -> Option<&SliceView> {
        name.slice().map(|i| &self.slices[i])
    }
}

impl ViewName {
    /// Place in [`Views::slices`]; `None` for the 3D view.
    pub const fn slice(self) -> Option<usize> {
        match self {
            Self::ThreeD => None,
            Self::Axial => Some(0),
            Self::Coronal => Some(1),
            Self::Sagittal => Some(2),
        }
    }

    /// The name in scripts and messages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::ThreeD => "3d",
            Self::Axial => "axial",
            Self::Coronal => "coronal",
            Self::Sagittal => "sagittal",
        }
    }
}
