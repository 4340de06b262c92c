//! What a volume that was just opened looks like.

use crate::document::scene::{Layer, Looks, Origin, Scene, SliceView, ViewName, Views, Window, first_look};
use crate::explode::Explosion;
use crate::paint::Brush;
use crate::volume::{FieldKind, Grid, Histogram, Segments};

impl Scene {
    /// Seen from the front, a slab from its face, framed, the crosshair in the middle, colours from the histogram, nothing
    /// painted, one part.
    pub fn new(grid: &Grid, histogram: &Histogram, origin: Origin) -> Self {
        Self {
            origin,
            transfer: first_look::transfer(grid, histogram),
            look: first_look::look(grid),
            window: Window::from_histogram(histogram),
            views: Views::new(grid),
            layers: FieldKind::ALL.map(Layer::new).to_vec(),
            segments: Segments::default(),
            brush: brush_for(grid),
            explosion: Explosion::whole(grid),
        }
    }
}

impl Scene {
    /// How everything is shown.
    pub fn looks(&self) -> Looks {
        let Self { transfer, look, window, layers, .. } = self;
        Looks { transfer: transfer.clone(), look: *look, window: *window, layers: layers.clone() }
    }
}

impl Looks {
    /// Whether a scene is shown so.
    pub(crate) fn are_of(&self, scene: &Scene) -> bool {
        self.transfer == scene.transfer
            && self.look == scene.look
            && self.window == scene.window
            && self.layers == scene.layers
    }

    /// Shows a scene so, and holds how it was shown.
    pub(crate) fn exchange(&mut self, scene: &mut Scene) {
        std::mem::swap(&mut self.transfer, &mut scene.transfer);
        std::mem::swap(&mut self.look, &mut scene.look);
        std::mem::swap(&mut self.window, &mut scene.window);
        std::mem::swap(&mut self.layers, &mut scene.layers);
    }
}

/// The brush to begin with: 5 mm, or five voxels where that is less than one or more than 64.
fn brush_for(grid: &Grid) -> Brush {
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
        Self { field, visible: true, opacity }
    }
}

impl Scene {
    /// How a field is shown. Older projects do not say it of density.
    pub fn layer(&self, field: FieldKind) -> Layer {
        self.layers.iter().find(|l| l.field == field).copied().unwrap_or_else(|| Layer::new(field))
    }

    /// The scene as JSON says it: a path that is not UTF-8 comes back with marks in it.
    pub(crate) fn sayable(&self) -> Self {
        let path = self.origin.path.to_string_lossy().into_owned().into();
        Self { origin: Origin { path, ..self.origin.clone() }, ..self.clone() }
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
