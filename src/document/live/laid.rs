//! Where annotations lie: their grids on the surfaces as these are now, and what is laid on them.
//!
//! A grid is found when a picture or a question first needs it and again after its surface was edited, its volume moved or the annotation
//! changed ("Direct Volume Editing", 2008, section 5). While a hand moves something the plain grid is shown, which costs milliseconds; the
//! relaxed one follows. Owns these; nothing here is saved.

use crate::annotate::grid::SurfaceGrid;
use crate::annotate::path::geodesic::{RULER_VERTICES, geodesic};
use crate::annotate::path::strip::Tracing as Steps;
use crate::annotate::relaxing::relax::relax;
use crate::annotate::surface::{Surface, normal};
use crate::document::command::answers::GridSaid;
use crate::document::error::DocumentError;
use crate::document::live::drawings::{Drawing, drawing};
use crate::document::live::fonts::FontShelf;
use crate::document::live::graphics::Graphics;
use crate::document::live::spots::{Finds, Fresh, Spot};
use crate::document::live::voxel_surface::VoxelSurface;
use crate::document::scene::annotations::{
    Anchor, Annotation, AnnotationId, Content, Directions, MOST_VERTICES, Tracing,
};
use crate::document::state::State;
use crate::gpu::{Bend, Decal, DecalCorner, DecalMesh, GridRequest, Heading};
use crate::math::{DVec2, DVec3};
use std::sync::Arc;

/// Area over which a text is said to be stretched.
const STRETCHED: f64 = 1.5;
/// How far toward the eye what lies on a surface is moved along the ray, voxels.
pub(crate) const TOWARD_VOXELS: f64 = 1.0;

/// Half the steps of a grid over a rectangle, and its step.
pub(crate) fn lattice(size_mm: [f64; 2], tracing: &Tracing, voxel_mm: f64) -> ([u32; 2], f64) {
    let [w, h] = size_mm;
    let most = (MOST_VERTICES - 1) / 2;
    let wanted = tracing.step_mm.unwrap_or(voxel_mm).max(w.max(h) / f64::from(2 * most)).max(1e-9);
    // The longer side is divided evenly, the shorter one covered.
    let n = (w.max(h) / (2.0 * wanted)).ceil().clamp(1.0, f64::from(most));
    let step = w.max(h) / (2.0 * n);
    let half = |side: f64| ((side / (2.0 * step) - 1e-6).ceil().max(1.0) as u32).min(most);
    ([half(w), half(h)], step)
}

/// The same for what ends where its grid does: of the steps that are not much shorter the first that divides both sides.
pub(crate) fn even_lattice(size_mm: [f64; 2], tracing: &Tracing, voxel_mm: f64) -> ([u32; 2], f64) {
    const MISSED: f64 = 0.01;
    let (half, step) = lattice(size_mm, tracing, voxel_mm);
    let (long, short) = (size_mm[0].max(size_mm[1]), size_mm[0].min(size_mm[1]));
    let least = half[0].max(half[1]);
    // How far the shorter side is from what is wanted, as a share of it.
    let found = |n: u32| {
        let of_short = (short / long * f64::from(n)).round().max(1.0);
        (of_short as u32, (of_short / f64::from(n) * long / short - 1.0).abs())
    };
    let counts = least..=(3 * least).min((MOST_VERTICES - 1) / 2).max(least);
    let fits = counts.clone().find(|n| found(*n).1 <= MISSED);
    let best = || counts.min_by(|a, b| found(*a).1.total_cmp(&found(*b).1));
    let Some(n) = fits.or_else(best) else { return (half, step) };
    let of_short = found(n).0;
    let half = if size_mm[0] >= size_mm[1] { [n, of_short] } else { [of_short, n] };
    (half, long / (2.0 * f64::from(n)))
}

/// The plain grid about a place.
///
/// # Errors
/// Without a GPU, or whatever it fails with.
pub(crate) fn traced(
    state: &State,
    graphics: &mut Graphics,
    spot: &Spot,
    (half, step_mm): ([u32; 2], f64),
    tracing: &Tracing,
) -> Result<SurfaceGrid, DocumentError> {
    let mut family = spot.ground.family.clone();
    family.reverse();
    let heading = match tracing.directions {
        Directions::Picked => Heading::Straight,
        Directions::Field(of) => Heading::Vectors(of),
        Directions::MostCurved => Heading::Curvature(Bend::Most),
        Directions::LeastCurved => Heading::Curvature(Bend::Least),
    };
    let request = GridRequest {
        family,
        iso: spot.value,
        centre: spot.centre,
        along: spot.along,
        step_mm,
        tolerance_mm: tracing.tolerance * spot.voxel_mm,
        steps: half,
        heading,
    };
    let traced = graphics.trace(state, &request)?;
    let [columns, rows] = traced.size();
    let points = traced.vertices.iter().map(|v| v.as_ref().map(|v| v.at)).collect();
    Ok(SurfaceGrid { columns, rows, spacing_mm: step_mm, points })
}

/// A grid that is relaxed on its surface.
pub(crate) fn relaxed(surface: &VoxelSurface, spot: &Spot, plain: &SurfaceGrid) -> SurfaceGrid {
    let (columns, rows) = (plain.columns, plain.rows);
    relax(surface, spot.centre, spot.along, columns, rows, plain.spacing_mm, Some(plain), &|| false)
}

/// How far from a place the surface is looked at for a rectangle about it, mm.
pub(crate) fn reach_of(size_mm: [f64; 2], voxel_mm: f64) -> f64 {
    0.75 * DVec2::from_array(size_mm).length() + 8.0 * voxel_mm
}

/// Something on a surface, ready to be drawn.
#[derive(Clone, Debug)]
pub(crate) struct Lay {
    pub mesh: Arc<DecalMesh>,
    pub drawing: Drawing,
    pub grid: SurfaceGrid,
    pub said: GridSaid,
}

/// What of an annotation its grid hangs on.
type Shape = (Content, Anchor, f64, Tracing);

fn shape_of(one: &Annotation) -> Shape {
    (one.content.clone(), one.anchor, one.size_mm, one.tracing)
}

/// The grids of all annotations that were asked for.
#[derive(Debug, Default)]
pub(crate) struct Laid {
    pub fonts: FontShelf,
    pub finds: Finds<AnnotationId, Shape, Lay>,
}

impl Laid {
    /// Whether some grid of what pictures show is not the one that is wanted yet.
    pub(crate) fn is_behind(&self, state: &State) -> bool {
        let mut shown = state.scene.annotations.all.iter().filter(|(_, one)| one.visible);
        shown.any(|(id, one)| self.finds.is_behind(id, &shape_of(one)))
    }

    /// Where an annotation lies; `at_last`: as it is wanted, whatever that costs, else as it is quickly found.
    ///
    /// # Errors
    /// Without a GPU, or if what it shows cannot be drawn.
    pub(crate) fn get(
        &mut self,
        state: &State,
        graphics: &mut Graphics,
        id: AnnotationId,
        at_last: bool,
    ) -> Result<&Lay, DocumentError> {
        let one = state.scene.annotations.get(id)?;
        let spot = Spot::of(state, &one.anchor)?;
        let fonts = &mut self.fonts;
        self.finds.get(id, shape_of(one), &spot, at_last, |before| {
            let known = before.filter(|(shape, _)| shape.0 == one.content && shape.2 == one.size_mm);
            let known = known.map(|(_, lay)| lay.drawing.clone());
            lay(state, graphics, fonts, one, &spot, (known, at_last))
        })
    }

    /// What pictures show of all annotations. What cannot be drawn is left out.
    pub(crate) fn decals(&mut self, state: &State, graphics: &mut Graphics, at_last: bool) -> Vec<Decal> {
        self.finds.keep(|id| state.scene.annotations.all.contains_key(id));
        let shown = state.scene.annotations.all.iter().filter(|(_, one)| one.visible && one.opacity > 0.0);
        let mut decals = Vec::new();
        for (id, one) in shown {
            let Ok(subject) = state.at(Some(one.anchor.volume)) else { continue };
            let voxel_mm = subject.grid().voxel_mm();
            if !subject.settings.visible {
                continue;
            }
            match self.get(state, graphics, *id, at_last) {
                Ok(lay) => decals.push(Decal {
                    mesh: lay.mesh.clone(),
                    picture: lay.drawing.picture.clone(),
                    volume: one.anchor.volume,
                    selected: one.anchor.selected,
                    fill: one.colour,
                    halo: one.halo,
                    opacity: one.opacity,
                    lighting: state.scene.look_of(one.anchor.volume).lighting.filter(|_| one.lit),
                    toward_mm: TOWARD_VOXELS * voxel_mm,
                    is_cut: true,
                }),
                // It is told where it is asked for, and not with every picture.
                Err(error) => tracing::debug!("{}: {error}", one.name),
            }
        }
        decals
    }
}

fn lay(
    state: &State,
    graphics: &mut Graphics,
    fonts: &mut FontShelf,
    one: &Annotation,
    spot: &Spot,
    (known, at_last): (Option<Drawing>, bool),
) -> Result<Fresh<Lay>, DocumentError> {
    if let Content::Ruler { to, .. } = &one.content {
        return ruler(state, fonts, one, spot, *to);
    }
    let drawing = match known {
        Some(drawing) => drawing,
        None => drawing(&one.content, one.size_mm, 0.0, fonts)?,
    };
    let (half, step) = lattice(drawing.size_mm, &one.tracing, spot.voxel_mm);
    let plain = traced(state, graphics, spot, (half, step), &one.tracing)?;
    let reach = reach_of(drawing.size_mm, spot.voxel_mm);
    let wants = one.tracing.relaxed && one.tracing.directions == Directions::Picked;
    let relaxes = wants && at_last;
    let surface = VoxelSurface::about(state, spot.root, spot.value, spot.centre, reach)?;
    let grid = if relaxes { relaxed(&surface, spot, &plain) } else { plain };
    let normals = grid.normals(&surface);
    let mut said = said_of(&grid, &surface, drawing.size_mm);
    said.relaxed = relaxes;
    said.missing = drawing.missing.clone();
    remark(&mut said, &grid, one);
    let [w, h] = drawing.size_mm;
    let middle = [(grid.columns / 2) as f64, (grid.rows / 2) as f64];
    let uv = |i: usize| {
        let [x, y] = [(i % grid.columns) as f64 - middle[0], (i / grid.columns) as f64 - middle[1]];
        [0.5 + x * grid.spacing_mm / w, 0.5 - y * grid.spacing_mm / h]
    };
    let triangles = grid.triangles();
    let mesh = Arc::new(mesh_of(&grid.points, &normals, &triangles, spot.centre, uv));
    let what = Lay { mesh, drawing, grid, said };
    Ok(Fresh { what, ball: (spot.centre, reach), is_final: relaxes || !wants })
}

/// A mesh of those vertices that there are.
pub(crate) fn mesh_of(
    points: &[Option<DVec3>],
    normals: &[Option<DVec3>],
    triangles: &[[usize; 3]],
    origin: DVec3,
    uv: impl Fn(usize) -> [f64; 2],
) -> DecalMesh {
    let mut number = vec![u32::MAX; points.len()];
    let mut corners = Vec::new();
    for (i, point) in points.iter().enumerate() {
        let Some(point) = point else { continue };
        number[i] = corners.len() as u32;
        let [u, v] = uv(i).map(|x| x as f32);
        let normal = normals.get(i).copied().flatten().unwrap_or(DVec3::Z).as_vec3().to_array();
        corners.push(DecalCorner { place: (*point - origin).as_vec3().to_array(), u, normal, v });
    }
    let triangles = triangles.iter().map(|t| t.map(|i| number[i])).filter(|t| !t.contains(&u32::MAX)).collect();
    DecalMesh { origin, corners, triangles }
}

pub(crate) fn said_of(grid: &SurfaceGrid, surface: &VoxelSurface, size_mm: [f64; 2]) -> GridSaid {
    let distortion = grid.distortion();
    let centre = grid.points.get(grid.centre()).copied().flatten();
    GridSaid {
        columns: grid.columns,
        rows: grid.rows,
        step_mm: grid.spacing_mm,
        size_mm,
        normal: centre.and_then(|p| normal(surface, p)).unwrap_or_default().to_array(),
        trimmed: grid.trimmed(),
        excess: distortion.excess,
        area: [distortion.most_area, distortion.least_area],
        turned_over: grid.turned_over(surface),
        ..GridSaid::default()
    }
}

/// What a person should know of a grid.
fn remark(said: &mut GridSaid, grid: &SurfaceGrid, one: &Annotation) {
    let count = grid.points.len();
    if said.trimmed == count {
        let value = one.anchor.value;
        said.remarks.push(format!("there is no surface of value {value} at its centre; move it onto one"));
        return;
    }
    if said.trimmed > 0 {
        let share = 100.0 * said.trimmed as f64 / count as f64;
        said.remarks.push(format!("{share:.1} % of it is left out: the surface ends or tears there"));
    }
    if said.area[0] > STRETCHED || said.area[1] < 1.0 / STRETCHED {
        let stretched = said.area[0].max(1.0 / said.area[1]);
        said.fitting_mm = fitting(grid).map(|share| one.size_mm * share);
        let smaller = said
            .fitting_mm
            .map_or(String::new(), |size_mm| format!("; at {size_mm:.3} mm it would be less than {STRETCHED}"));
        let found = format!("the surface bends so that areas of it are stretched or shrunk by {stretched:.2}");
        said.remarks.push(found + &smaller);
    }
    if !said.missing.is_empty() {
        said.remarks.push(format!("no font has the characters {}", said.missing));
    }
}

/// The share of a grid about its centre within which no area is stretched much; `None` if there is none.
fn fitting(grid: &SurfaceGrid) -> Option<f64> {
    let [across, down] = [grid.columns / 2, grid.rows / 2];
    let step = |share: f64| {
        let half = [(across as f64 * share).floor() as usize, (down as f64 * share).floor() as usize];
        (half[0] > 0 && half[1] > 0).then_some(half)
    };
    (1..20).rev().map(|twentieth| f64::from(twentieth) / 20.0).find(|share| {
        let Some([x, y]) = step(*share) else { return false };
        let rows = down - y..=down + y;
        let points = rows.flat_map(|r| &grid.points[r * grid.columns + across - x..=r * grid.columns + across + x]);
        let part = SurfaceGrid { columns: 2 * x + 1, rows: 2 * y + 1, points: points.copied().collect(), ..*grid };
        let found = part.distortion();
        found.most_area < STRETCHED && found.least_area > 1.0 / STRETCHED
    })
}

/// A ruler along the shortest way.
fn ruler(
    state: &State,
    fonts: &mut FontShelf,
    one: &Annotation,
    spot: &Spot,
    to: [f64; 3],
) -> Result<Fresh<Lay>, DocumentError> {
    let end = spot.ground.place(to);
    let middle = spot.centre.midpoint(end);
    let reach = 1.2 * spot.centre.distance(end) + 2.0 * one.size_mm + 8.0 * spot.voxel_mm;
    let surface = VoxelSurface::about(state, spot.root, spot.value, middle, reach)?;
    let steps = Steps { step_mm: spot.voxel_mm, tolerance_mm: one.tracing.tolerance * spot.voxel_mm };
    let refused = |e: &dyn std::fmt::Display| DocumentError::NotNow(format!("{}: {e}", one.name));
    let path = geodesic(&surface, spot.centre, end, RULER_VERTICES, &steps).map_err(|e| refused(&e))?;
    let length = path.length_mm();
    let drawing = drawing(&one.content, one.size_mm, length, fonts)?;
    let [w, h] = drawing.size_mm;
    let [x, y] = drawing.origin_mm;
    // Ends and their ticks reach a little over the way.
    let before = x - 0.5 * length;
    let path = path.lengthened(&surface, before.max(0.0), (w - before - length).max(0.0), &steps).unwrap_or(path);
    let rows = ((h / spot.voxel_mm).ceil() as usize).clamp(3, 65) | 1;
    let strip = path.strip(&surface, -y, h - y, rows, &steps);
    let columns = strip.columns;
    let uv = |i: usize| {
        let (column, row) = (i % columns, i / columns);
        [strip.along_mm[column] / w, 1.0 - (strip.across_mm[row] + y) / h]
    };
    let triangles: Vec<[usize; 3]> = strip
        .quads()
        .into_iter()
        .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
        .map(|t| t.map(|i| i as usize))
        .collect();
    let normals: Vec<Option<DVec3>> = strip.points.iter().map(|p| normal(&surface, (*p)?)).collect();
    let mesh = Arc::new(mesh_of(&strip.points, &normals, &triangles, spot.centre, uv));
    let said = GridSaid {
        columns,
        rows: strip.rows,
        step_mm: path.length_mm() / (columns.max(2) - 1) as f64,
        size_mm: drawing.size_mm,
        normal: surface.gradient(spot.centre).map_or(DVec3::ZERO, |g| -g.normalize_or_zero()).to_array(),
        trimmed: strip.trimmed(),
        area: [1.0; 2],
        length_mm: Some(length),
        missing: drawing.missing.clone(),
        ..GridSaid::default()
    };
    let grid = SurfaceGrid { columns, rows: strip.rows, spacing_mm: said.step_mm, points: strip.points.clone() };
    Ok(Fresh { what: Lay { mesh, drawing, grid, said }, ball: (middle, reach), is_final: true })
}
