//! Decals among bodies, against the picture without them and with something opaque in their place: of a picture P of matter before and
//! behind a place, and the picture O of matter before it with a colour c behind, one with a mark of c and opacity α there is (1 − α)P + αO.

use super::cast_layers::arrangements;
use super::cast_modes::{Stage, lumps, oblique_grid, projections, tissue};
use crate::common::gpu::gpu;
use crate::common::volumes::*;
use burin::gpu::{Body, Decal, DecalCorner, DecalMesh, DecalPicture, Frame, Image, Layers, OpaqueMesh, Texels};
use burin::math::{DVec2, DVec3, Plane};
use burin::mesh::TriangleMesh;
use burin::volume::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

fn stage() -> Option<Stage> {
    let gpu = gpu()?;
    let grid = oblique_grid([66, 44, 36]);
    Some(Stage::new(gpu, grid, lumps(grid)))
}

/// A flat sheet.
#[derive(Clone, Debug)]
struct Sheet {
    corners: [DVec3; 4],
    colour: [f32; 3],
    opacity: f32,
}

fn sheet(rng: &mut ChaCha8Rng, grid: &Grid) -> Sheet {
    let mut any = |s: f64| DVec3::from_array(std::array::from_fn(|_| rng.random_range(-s..s)));
    let middle = grid.world_bounds().centre() + any(8.0);
    let across = any(1.0).normalize() * 14.0;
    let down = across.cross(any(1.0)).normalize() * 11.0;
    let corners = [-across - down, across - down, across + down, -across + down].map(|off| middle + off);
    let colour = std::array::from_fn(|_| rng.random_range(0.2..1.0));
    Sheet { corners, colour, opacity: rng.random_range(0.3..0.9) }
}

fn plain(colour: [f32; 3]) -> DecalPicture {
    let [r, g, b] = colour.map(|c| (c * 255.0).round() as u8);
    let levels = vec![([1, 1], vec![u32::from_le_bytes([r, g, b, 255])])];
    let picture_from_uv = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]];
    DecalPicture { texels: Texels::Colours, levels, picture_from_uv, repeats: false }
}

impl Sheet {
    fn decal(&self) -> Decal {
        let origin = self.corners[0];
        let normal = (self.corners[1] - origin).cross(self.corners[3] - origin).normalize();
        let uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let corner = |i: usize| DecalCorner {
            place: (self.corners[i] - origin).as_vec3().to_array(),
            u: uv[i][0],
            normal: normal.as_vec3().to_array(),
            v: uv[i][1],
        };
        let corners = (0..4).map(corner).collect();
        Decal {
            mesh: Arc::new(DecalMesh { origin, corners, triangles: vec![[0, 1, 2], [0, 2, 3]] }),
            picture: Arc::new(plain(self.colour)),
            volume: VolumeId::FIRST,
            selected: false,
            fill: [0.0; 3],
            halo: None,
            opacity: self.opacity,
            lighting: None,
            toward_mm: 0.0,
            is_cut: true,
        }
    }

    /// What a body holds of it, where that stands.
    fn opaque(&self, body: &Body) -> Option<OpaqueMesh> {
        let piece = body.region.iter().fold(self.corners.to_vec(), |piece, plane| clip(&piece, plane));
        let n = piece.len() as u32;
        let triangles = (2..n).map(|i| [0, i - 1, i]).collect();
        let corners = piece.iter().map(|p| p.as_vec3().to_array()).collect();
        (n > 2).then(|| OpaqueMesh {
            id: 900,
            mesh: Arc::new(TriangleMesh::new(corners, triangles).unwrap()),
            pose: body.pose,
            colour: self.colour.map(|c| (c * 255.0).round() / 255.0),
            lighting: None,
        })
    }

    /// Millimetres along a ray to what a body holds of it; infinite where it meets nothing of that.
    fn met(&self, body: &Body, frame: &Frame, px: DVec2) -> f64 {
        let ray = frame.camera.ray(px, frame.size);
        let [a, b, _, d] = self.corners.map(|c| body.pose.apply(c));
        let normal = (b - a).cross(d - a);
        let t = normal.dot(a - ray.origin) / normal.dot(ray.dir);
        let p = body.pose.unapply(ray.at(t));
        let (across, down) = (self.corners[1] - self.corners[0], self.corners[3] - self.corners[0]);
        let off = p - self.corners[0];
        let inside = |along: DVec3| (0.0..=1.0).contains(&(off.dot(along) / along.length_squared()));
        let held = body.region.iter().all(|plane| plane.distance(p) <= 0.0);
        if t > 0.0 && held && inside(across) && inside(down) { t } else { f64::INFINITY }
    }
}

/// Of a convex polygon what lies on the inner side of a plane.
fn clip(polygon: &[DVec3], plane: &Plane) -> Vec<DVec3> {
    let mut out = Vec::new();
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (da, db) = (plane.distance(a), plane.distance(b));
        if da <= 0.0 {
            out.push(a);
        }
        if (da < 0.0) != (db < 0.0) && da != db {
            out.push(a + (b - a) * (da / (da - db)));
        }
    }
    out
}

fn view(grid: &Grid, bodies: Vec<Body>) -> Frame {
    let mut view = frame(grid, tissue(), DVec3::new(1.0, -1.6, 0.8), [52, 46]);
    view.camera = view.camera.zoomed(0.9);
    view.transfer.opacity.iter_mut().for_each(|p| p.1 *= 0.12);
    view.bodies = bodies;
    view
}

/// The share of pixels that are off by more than 1/255 in any component, and the largest difference of the others.
fn off(image: &Image, expected: &[[f32; 4]]) -> f64 {
    let far = |a: &[f32; 4], b: &[f32; 4]| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1.0 / 255.0);
    let count = image.colour.iter().zip(expected).filter(|(a, b)| far(a, b)).count();
    count as f64 / expected.len() as f64
}

fn mixed(a: [f32; 4], b: [f32; 4], share: f32) -> [f32; 4] {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * share)
}

/// The picture with sheets, of pictures without: those behind first.
fn expected(stage: &mut Stage, frame: &Frame, sheets: &[Sheet]) -> Vec<[f32; 4]> {
    let bare = Frame { layers: Layers { decals: Vec::new(), ..frame.layers.clone() }, ..frame.clone() };
    let mut colours = stage.image(&bare).colour;
    let held: Vec<_> = sheets.iter().flat_map(|sheet| frame.bodies.iter().map(move |body| (sheet, body))).collect();
    let with = |(sheet, body): &(&Sheet, &Body)| {
        let opaque = sheet.opaque(body).into_iter().collect();
        Frame { layers: Layers { opaque, ..bare.layers.clone() }, ..bare.clone() }
    };
    let backed: Vec<_> = held.iter().map(|held| stage.image(&with(held)).colour).collect();
    for (i, colour) in colours.iter_mut().enumerate() {
        let px = DVec2::new((i % frame.size[0] as usize) as f64 + 0.5, (i / frame.size[0] as usize) as f64 + 0.5);
        let met: Vec<f64> = held.iter().map(|(sheet, body)| sheet.met(body, frame, px)).collect();
        let mut order: Vec<usize> = (0..held.len()).filter(|&h| met[h].is_finite()).collect();
        order.sort_by(|&a, &b| met[b].total_cmp(&met[a]));
        for h in order {
            *colour = mixed(*colour, backed[h][i], held[h].0.opacity);
        }
    }
    colours
}

#[test]
fn a_decal_lies_among_the_matter_of_its_ray() {
    let Some(mut stage) = stage() else { return };
    let grid = stage.grid;
    let mut rng = ChaCha8Rng::seed_from_u64(31);
    for bodies in arrangements(&grid) {
        let sheets: Vec<Sheet> = (0..3).map(|_| sheet(&mut rng, &grid)).collect();
        let decals: Vec<Decal> = sheets.iter().map(Sheet::decal).collect();
        for mode in [Mode::Dvr, Mode::Iso(44_000.0)] {
            // One pass; stretches; several passes.
            let all = [(false, 1.0, [52, 46]), (true, 1.0, [52, 46]), (false, 0.005, [9, 8])];
            // Every pipeline that merges is compiled for many seconds: they have one arrangement, and several passes no stretches.
            let merges = bodies.len() > 1 && bodies[0].region.is_empty();
            for (refine, finer, size) in all.into_iter().take(if merges { 2 } else { 3 }) {
                for frame in projections(&view(&grid, bodies.clone())) {
                    let lighting = (size[0] > 9).then(Lighting::default);
                    let step_mm = frame.step_mm * finer;
                    let mut frame = Frame { mode, lighting, refine, step_mm, size, ..frame };
                    frame.layers.decals = decals.clone();
                    let image = stage.image(&frame);
                    let share = off(&image, &expected(&mut stage, &frame, &sheets));
                    let bare = stage.image(&Frame { layers: Layers::default(), ..frame.clone() });
                    let seen = off(&image, &bare.colour);
                    println!("{} bodies {mode:?} refine {refine}: {share:.4} off, {seen:.3} marked", bodies.len());
                    assert!(share < 0.015 && seen > 0.01, "{mode:?} refine {refine}: {share} {seen}");
                }
            }
        }
    }
}

#[test]
fn over_a_maximum_lie_all_decals() {
    let Some(mut stage) = stage() else { return };
    let grid = stage.grid;
    let mut rng = ChaCha8Rng::seed_from_u64(32);
    let bodies = vec![Body::whole(0)];
    let sheets: Vec<Sheet> = (0..2).map(|_| sheet(&mut rng, &grid)).collect();
    for frame in projections(&view(&grid, bodies.clone())) {
        let mut frame = Frame { mode: Mode::Mip, lighting: None, ..frame };
        let bare = stage.image(&frame);
        frame.layers.decals = sheets.iter().map(Sheet::decal).collect();
        let image = stage.image(&frame);
        let mut wanted = bare.colour.clone();
        for (i, colour) in wanted.iter_mut().enumerate() {
            let px = DVec2::new((i % 52) as f64 + 0.5, (i / 52) as f64 + 0.5);
            let mut met: Vec<_> = sheets.iter().map(|s| (s.met(&bodies[0], &frame, px), s)).collect();
            met.sort_by(|a, b| b.0.total_cmp(&a.0));
            for (_, sheet) in met.into_iter().filter(|m| m.0.is_finite()) {
                let [r, g, b] = sheet.colour.map(|c| (c * 255.0).round() / 255.0);
                *colour = mixed(*colour, [r, g, b, 1.0], sheet.opacity);
            }
        }
        assert!(off(&image, &wanted) < 0.015, "{}", off(&image, &wanted));
        assert!(off(&image, &bare.colour) > 0.03, "{}", off(&image, &bare.colour));
    }
}
