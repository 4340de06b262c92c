//! Windows that stand open: closed meshes that cut, the bands about them and the shade on their walls ("Direct Volume Editing", 2008,
//! section 5.2).
//!
//! Found from the voxels when a picture first needs them, and again when their surface or they themselves change. Owns them; nothing here
//! is saved.

use crate::annotate::grid::SurfaceGrid;
use crate::annotate::path::strip::{SurfaceStrip, Tracing as Steps, rim_bands};
use crate::annotate::surface::{Surface, normal};
use crate::annotate::window::cutaway::{CutPart, Cutaway as Window};
use crate::annotate::window::lasso::lasso_patch;
use crate::annotate::window::patch::Patch;
use crate::document::error::DocumentError;
use crate::document::live::graphics::Graphics;
use crate::document::live::laid::{TOWARD_VOXELS, even_lattice, mesh_of, reach_of, relaxed, traced};
use crate::document::live::spots::{Finds, Fresh, Spot};
use crate::document::live::voxel_surface::VoxelSurface;
use crate::document::scene::annotations::{Anchor, Tracing};
use crate::document::scene::cutaways::{Cutaway, CutawayId, Outline};
use crate::document::state::State;
use crate::explode::Poses;
use crate::gpu::{CutMesh, Decal, DecalCorner, DecalMesh, DecalPicture, Layers, Texels, distance_texel};
use crate::math::{DVec3, Pose};
use crate::mesh::TriangleMesh;
use std::sync::{Arc, LazyLock};

/// Vertices along the longer side of a window's grid at most.
const MOST_VERTICES: f64 = 160.0;
/// How dark the floor of a window is.
const SHADE: f64 = 0.55;
/// Levels of that.
const SHADE_LEVELS: u32 = 64;

/// A window as it stands open.
#[derive(Clone, Debug)]
pub(crate) struct Opened {
    /// What cuts, world mm at rest from `origin`.
    pub mesh: Arc<TriangleMesh>,
    pub origin: DVec3,
    /// The same with all its digits.
    pub window: Window,
    /// What is to be told of it, in sentences.
    pub remarks: Vec<String>,
    rim: Vec<Arc<DecalMesh>>,
    walls: Arc<DecalMesh>,
}

/// What of a cutaway its mesh hangs on.
type Shape = (Outline, Anchor, f64, f64);

fn shape_of(one: &Cutaway) -> Shape {
    (one.outline.clone(), one.anchor, one.depth_mm, one.rim.width_mm)
}

/// All windows that were asked for.
#[derive(Debug, Default)]
pub(crate) struct Windows {
    pub finds: Finds<CutawayId, Shape, Opened>,
}

impl Windows {
    /// Whether some window that pictures show is not the one that is wanted yet.
    pub(crate) fn is_behind(&self, state: &State) -> bool {
        let mut open = state.scene.cutaways.all.iter().filter(|(_, one)| one.open);
        open.any(|(id, one)| self.finds.is_behind(id, &shape_of(one)))
    }

    /// A window; `at_last`: as it is wanted, whatever that costs.
    ///
    /// # Errors
    /// Without a GPU, or if there is no surface to cut.
    pub(crate) fn get(
        &mut self,
        state: &State,
        graphics: &mut Graphics,
        id: CutawayId,
        at_last: bool,
    ) -> Result<&Opened, DocumentError> {
        let one = state.scene.cutaways.get(id)?;
        let spot = Spot::of(state, &one.anchor)?;
        let shape = shape_of(one);
        self.finds.get(id, shape, &spot, at_last, |_| open(state, graphics, one, &spot, at_last))
    }

    /// Adds what cuts to a frame; `dressed`: also rims and the shade of walls.
    pub(crate) fn cut(
        &mut self,
        state: &State,
        graphics: &mut Graphics,
        poses: &Poses,
        layers: &mut Layers,
        (dressed, at_last): (bool, bool),
    ) {
        self.finds.keep(|id| state.scene.cutaways.all.contains_key(id));
        for (id, one) in state.scene.cutaways.all.iter().filter(|(_, one)| one.open) {
            let pose = match Spot::of(state, &one.anchor) {
                Ok(spot) => pose_at(state, poses, spot.centre, one.anchor.selected),
                Err(_) => continue,
            };
            let opened = match self.get(state, graphics, *id, at_last) {
                Ok(opened) => opened,
                Err(error) => {
                    // It is told where it is asked for, and not with every picture.
                    tracing::debug!("{}: {error}", one.name);
                    continue;
                }
            };
            let at = Pose { translation: pose.apply(opened.origin), rotation: pose.rotation };
            layers.cuts.push(CutMesh { id: id.0, mesh: opened.mesh.clone(), pose: at });
            if dressed {
                layers.decals.extend(dress(state, one, opened));
            }
        }
    }
}

/// The pose of what holds a place at rest.
pub(crate) fn pose_at(state: &State, poses: &Poses, place: DVec3, selected: bool) -> Pose {
    let explosion = &state.scene.explosion;
    let part = explosion.of_body(0, place).and_then(|id| explosion.part(id).ok());
    match part {
        Some(part) if !selected => poses.of(part),
        _ => Pose::IDENTITY,
    }
}

fn dress(state: &State, one: &Cutaway, opened: &Opened) -> Vec<Decal> {
    let volume = one.anchor.volume;
    let Ok(subject) = state.at(Some(volume)) else { return Vec::new() };
    let plain = Decal {
        mesh: opened.walls.clone(),
        picture: SHADES.clone(),
        volume,
        selected: one.anchor.selected,
        fill: one.rim.colour,
        halo: None,
        opacity: 1.0,
        lighting: None,
        toward_mm: 0.5 * TOWARD_VOXELS * subject.grid().voxel_mm(),
        is_cut: false,
    };
    let mut decals = Vec::new();
    if one.shaded {
        decals.push(plain.clone());
    }
    if one.rim.width_mm > 0.0 {
        let lighting = state.scene.look_of(volume).lighting;
        let toward_mm = TOWARD_VOXELS * subject.grid().voxel_mm();
        let band = |mesh: &Arc<DecalMesh>| Decal {
            mesh: mesh.clone(),
            picture: FILLED.clone(),
            lighting,
            toward_mm,
            ..plain.clone()
        };
        decals.extend(opened.rim.iter().map(band));
    }
    decals
}

const IDENTITY: [[f32; 2]; 3] = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]];

/// All of it inside a shape. One for all pictures, so that it comes to the device once.
static FILLED: LazyLock<Arc<DecalPicture>> = LazyLock::new(|| {
    let levels = vec![([1, 1], vec![distance_texel([f32::MAX; 2], 0)])];
    Arc::new(DecalPicture { texels: Texels::Distances, levels, picture_from_uv: IDENTITY, repeats: false })
});

/// Black that grows denser from top to bottom.
static SHADES: LazyLock<Arc<DecalPicture>> = LazyLock::new(|| {
    let alpha = |i: u32| (255.0 * SHADE * (f64::from(i) + 0.5) / f64::from(SHADE_LEVELS)).round() as u8;
    let texels = (0..SHADE_LEVELS).map(|i| u32::from_le_bytes([0, 0, 0, alpha(i)])).collect();
    let levels = vec![([1, SHADE_LEVELS], texels)];
    Arc::new(DecalPicture { texels: Texels::Colours, levels, picture_from_uv: IDENTITY, repeats: false })
});

fn open(
    state: &State,
    graphics: &mut Graphics,
    one: &Cutaway,
    spot: &Spot,
    at_last: bool,
) -> Result<Fresh<Opened>, DocumentError> {
    let refused = |e: &dyn std::fmt::Display| DocumentError::NotNow(format!("{}: {e}", one.name));
    let voxel = spot.voxel_mm;
    let steps = Steps::of_voxel(voxel);
    let mut remarks = Vec::new();
    let (patch, outward, surface, reach) = match &one.outline {
        Outline::Grid { width_mm, height_mm } => {
            let size = [*width_mm, *height_mm];
            let reach = reach_of(size, voxel) + one.rim.width_mm;
            let step_mm = Some(voxel.max(width_mm.max(*height_mm) / MOST_VERTICES));
            let tracing = Tracing { step_mm, ..Tracing::default() };
            let plain = traced(state, graphics, spot, even_lattice(size, &tracing, voxel), &tracing)?;
            let surface = VoxelSurface::about(state, spot.root, spot.value, spot.centre, reach)?;
            let grid = if at_last { relaxed(&surface, spot, &plain) } else { plain };
            if grid.trimmed() > 0 {
                let share = 100.0 * grid.trimmed() as f64 / grid.points.len() as f64;
                remarks.push(format!("{share:.1} % of it is left out: the surface ends or tears there"));
            }
            let outward = outward_at(&surface, &grid).ok_or_else(|| refused(&"there is no surface at its middle"))?;
            (Patch::from_grid(&grid, outward).map_err(|e| refused(&e))?, outward, surface, reach)
        }
        Outline::Lasso { points } => {
            let line: Vec<DVec3> = points.iter().map(|p| spot.ground.place(*p)).collect();
            let far = line.iter().map(|p| p.distance(spot.centre)).fold(0.0, f64::max);
            let reach = 1.5 * far + one.rim.width_mm + 8.0 * voxel;
            let surface = VoxelSurface::about(state, spot.root, spot.value, spot.centre, reach)?;
            let outward = line.iter().filter_map(|p| normal(&surface, *p)).sum::<DVec3>();
            let edge = voxel.max(far * 2.0 / MOST_VERTICES);
            let laid = lasso_patch(&surface, &line, outward, edge, steps.tolerance_mm).map_err(|e| refused(&e))?;
            if laid.trimmed > 0 {
                remarks.push(format!("{} places of it have no surface and are left out", laid.trimmed));
            }
            (laid.patch, outward, surface, reach)
        }
    };
    let window = Window::new(&patch, outward, one.depth_mm, voxel).map_err(|e| refused(&e))?;
    let origin = spot.centre;
    let narrow = |p: &DVec3| (*p - origin).as_vec3().to_array();
    let corners: Vec<[f32; 3]> = window.corners().iter().map(narrow).collect();
    let mesh = TriangleMesh::new(corners, window.triangles().to_vec()).map_err(|e| refused(&e))?;
    let bands = match one.rim.width_mm > 0.0 {
        true => rim_bands(&surface, &patch, 0.0, one.rim.width_mm, 3, &steps),
        false => Vec::new(),
    };
    let rim = bands.iter().map(|band| Arc::new(band_mesh(band, &surface, origin))).collect();
    let walls = Arc::new(wall_mesh(&window, origin));
    let reach = reach + one.depth_mm;
    let what = Opened { mesh: Arc::new(mesh), origin, window, remarks, rim, walls };
    Ok(Fresh { what, ball: (spot.centre, reach), is_final: at_last })
}

fn outward_at(surface: &VoxelSurface, grid: &SurfaceGrid) -> Option<DVec3> {
    normal(surface, grid.points.get(grid.centre()).copied().flatten()?)
}

fn band_mesh(band: &SurfaceStrip, surface: &dyn Surface, origin: DVec3) -> DecalMesh {
    let normals: Vec<Option<DVec3>> = band.points.iter().map(|p| normal(surface, (*p)?)).collect();
    let quads = band.quads().into_iter().map(|quad| quad.map(|i| i as usize));
    let triangles: Vec<[usize; 3]> = quads.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    mesh_of(&band.points, &normals, &triangles, origin, |_| [0.5, 0.5])
}

/// Walls and floor: the deeper the farther down the picture.
fn wall_mesh(window: &Window, origin: DVec3) -> DecalMesh {
    let half = window.corners().len() / 2;
    let corner = |(i, p): (usize, &DVec3)| DecalCorner {
        place: (*p - origin).as_vec3().to_array(),
        u: 0.5,
        normal: [0.0, 0.0, 1.0],
        v: if i < half { 0.0 } else { 1.0 },
    };
    let corners = window.corners().iter().enumerate().map(corner).collect();
    let kept = window.triangles().iter().enumerate().filter(|(i, _)| window.part(*i) != CutPart::Sheet);
    DecalMesh { origin, corners, triangles: kept.map(|(_, t)| *t).collect() }
}
