//! The caster at its edges: closed forms, NaN, opacity, long rays, small pools, edits, picks, counts and the window.

use super::cast_modes::{Stage, lumps, oblique_grid, tissue};
use super::reference::{Dense, apart, difference, picture};
use crate::common::gpu::{gpu, sample};
use crate::common::volumes::*;
use burin::gpu::{Body, Caster, FieldPools, Frame, Mask};
use burin::math::{Camera, DVec2, DVec3, Plane, Pose, Projection};
use burin::volume::*;

/// Density of one value everywhere, in a box of mm.
fn slab(value: u16) -> (Grid, Field) {
    let grid = Grid::aligned([24, 20, 10], DVec3::new(1.0, 1.0, 2.0), DVec3::ZERO);
    (grid, density_u16(grid, move |_| value))
}

fn flat(opacity: f32) -> TransferFunction {
    TransferFunction { colour: vec![(0.0, [0.8, 0.4, 0.2])], opacity: vec![(0.0, opacity)], unit_mm: 1.0 }
}

/// Looks along −z on the middle of a volume from a whole number of steps above it.
fn down(grid: &Grid, transfer: TransferFunction, step_mm: f64) -> Frame {
    let middle = grid.world_bounds().centre();
    let mut view = frame(grid, transfer, DVec3::Z, [24, 20]);
    view.step_mm = step_mm;
    view.camera = Camera {
        eye: middle + DVec3::Z * 40.25,
        target: middle,
        up: DVec3::Y,
        projection: Projection::Orthographic { height_mm: 20.0 },
    };
    view
}

#[test]
fn a_slab_absorbs_as_beer_and_lambert_say() {
    let Some(gpu) = gpu() else { return };
    let (grid, density) = slab(7);
    let mut stage = Stage::new(gpu, grid, density);
    for step_mm in [0.5, 1.0, 2.0] {
        let view = down(&grid, flat(0.08), step_mm);
        let image = stage.image(&view);
        let reference = picture(&Dense::of(&stage.fields(), &grid), &view);
        // 20 mm of matter with an opacity of 0.08 per mm.
        let clear = 0.92_f64.powi(20);
        for (pixel, r) in image.colour.iter().zip(&reference) {
            assert!((f64::from(pixel[3]) - (1.0 - clear)).abs() < 1e-5, "{pixel:?}, {}", 1.0 - clear);
            assert!((f64::from(pixel[0]) - 0.8 * (1.0 - clear)).abs() < 1e-5);
            // The table keeps opacity in 32 bits.
            assert!((r.colour[3] - (1.0 - clear)).abs() < 1e-6, "the reference itself");
        }
        // Opacity ½ after ln ½ / ln 0.92 = 8.31 mm below the face at 30.25 mm: at the sample that fills that length.
        let half = 30.25 + (0.5_f64.ln() / 0.92_f64.ln() / step_mm).ceil() * step_mm;
        assert!((f64::from(image.depth_mm[0]) - half).abs() <= step_mm + 1e-3, "{} for {half}", image.depth_mm[0]);
    }
}

/// A table of 4096 entries over 0 to 4095: one for every value.
#[test]
fn every_value_of_the_table_s_range_has_the_colour_of_its_own_entry() {
    let Some(gpu) = gpu() else { return };
    let (grid, _) = slab(0);
    let colour =
        (0..4096).map(|v| (f64::from(v), if v % 2 == 0 { [0.0, 1.0, 0.25] } else { [1.0, 0.0, 0.75] })).collect();
    let transfer = TransferFunction { colour, opacity: vec![(0.0, 1.0), (4095.0, 1.0)], unit_mm: 1.0 };
    for first in [0_u16, 1500, 4072] {
        for floats in [false, true] {
            let density = match floats {
                true => density_f32(grid, |v| f32::from(first) + v[0] as f32),
                false => density_u16(grid, |v| first + v[0] as u16),
            };
            let image = Stage::new(gpu.clone(), grid, density).image(&down(&grid, transfer.clone(), 1.0));
            for (i, pixel) in image.colour.iter().enumerate() {
                // Pixel x shows voxel x in its middle.
                let value = f64::from(first) + (i % 24) as f64;
                let expected = transfer.colour_at(value);
                assert!((0..3).all(|c| (pixel[c] - expected[c]).abs() < 1e-5), "{value}: {pixel:?} for {expected:?}");
            }
        }
    }
}

#[test]
fn an_iso_sphere_has_its_area_and_depth() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([40, 40, 40]);
    let from_middle = |v: [u32; 3]| DVec3::from_array(v.map(|x| f64::from(x) - 19.5)).length();
    let density = density_u16(grid, |v| (60_000.0 - 2000.0 * from_middle(v)) as u16);
    let mut stage = Stage::new(gpu, grid, density);
    let mut view = down(&grid, tissue(), 1.0);
    view.size = [96, 96];
    view.camera.projection = Projection::Orthographic { height_mm: 40.0 };
    view.mode = Mode::Iso(60_000.0 - 2000.0 * 14.0);
    view.lighting = Some(Lighting { ambient: 0.0, diffuse: 1.0, specular: 0.0, power: 1.0 });
    view.transfer.colour = vec![(0.0, [1.0; 3])];
    let image = stage.image(&view);
    let reference = picture(&Dense::of(&stage.fields(), &grid), &view);
    let area = |hits: usize| hits as f64 * (40.0 / 96.0_f64).powi(2);
    let expected = std::f64::consts::PI * 14.0 * 14.0;
    assert!((area(reference.iter().filter(|p| p.object == 1).count()) / expected - 1.0).abs() < 0.01);
    assert!((area(image.object.iter().filter(|o| o.body() == Some(0)).count()) / expected - 1.0).abs() < 0.01);
    for y in 0..96 {
        for x in 0..96 {
            let at = DVec2::new(f64::from(x) + 0.5 - 48.0, f64::from(y) + 0.5 - 48.0) * 40.0 / 96.0;
            if at.length() < 12.0 {
                let height = (14.0_f64.powi(2) - at.length_squared()).sqrt();
                let i = x as usize + 96 * y as usize;
                // Trilinear between voxels is off a sphere by less than a tenth of a voxel.
                assert!((f64::from(image.depth_mm[i]) - (40.25 - height)).abs() < 0.1);
                assert!((f64::from(image.colour[i][0]) - height / 14.0).abs() < 0.03, "Lambert's cosine");
            }
        }
    }
}

#[test]
fn a_cut_under_iso_is_capped_with_the_planes_normal() {
    let Some(gpu) = gpu() else { return };
    let (grid, density) = slab(40_000);
    let mut stage = Stage::new(gpu, grid, density);
    let mut view = down(&grid, tissue(), 1.0);
    view.mode = Mode::Iso(30_000.0);
    view.lighting = Some(Lighting { ambient: 0.0, diffuse: 1.0, specular: 0.0, power: 1.0 });
    view.transfer.colour = vec![(0.0, [1.0; 3])];
    let normal = DVec3::new(0.6, 0.0, 0.8);
    let plane = Plane::through(DVec3::new(11.5, 9.5, 9.0), normal).unwrap();
    view.bodies[0].region = vec![plane];
    let image = stage.image(&view);
    let i = image.index(DVec2::new(12.5, 10.5)).unwrap();
    assert!((image.colour[i][0] - 0.8).abs() < 1e-5, "{:?}", image.colour[i]);
    // The pixel's ray runs down x = 12, 0.5 mm beside the plane's point: 0.375 mm lower.
    let depth = 40.25 - (9.0 - 0.375 - 9.0);
    assert!((f64::from(image.depth_mm[i]) - depth).abs() < 1e-3, "{}", image.depth_mm[i]);
}

#[test]
fn taps_that_are_nan_are_clear() {
    let Some(gpu) = gpu() else { return };
    let grid = oblique_grid([40, 36, 20]);
    let density = density_f32(grid, |v| {
        if (v[0] / 5 + v[1] / 7).is_multiple_of(3) { f32::NAN } else { 1000.0 + (v[0] * v[2]) as f32 * 60.0 }
    });
    let mut stage = Stage::new(gpu, grid, density);
    for mode in [Mode::Dvr, Mode::Mip, Mode::Iso(26_000.0)] {
        let view = Frame { mode, ..frame(&grid, tissue(), DVec3::new(0.5, -1.0, 1.0), [48, 40]) };
        let d = stage.compare(&view);
        assert!(d.covered > 0.03 && d.beyond_one < 0.01 && d.mean < 0.2, "{d:?}");
    }
}

#[test]
fn a_ray_ends_where_nothing_more_shows() {
    let Some(gpu) = gpu() else { return };
    let (grid, density) = slab(7);
    let mut stage = Stage::new(gpu, grid, density);
    let image = stage.image(&down(&grid, flat(1.0), 1.0));
    assert!(image.colour.iter().all(|c| c[3] == 1.0 && (c[0] - 0.8).abs() < 1e-6));
    // 0.8 per step: after 4 steps 0.0016 are left, and the fifth is not taken.
    let image = stage.image(&down(&grid, flat(0.8), 1.0));
    assert!(image.colour.iter().all(|c| (c[3] - (1.0 - 0.2_f32.powi(4))).abs() < 1e-5), "{:?}", image.colour[0]);
}

#[test]
fn rays_longer_than_software_vulkan_allows_are_marched_in_passes() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([20, 20, 20]);
    let mut stage = Stage::new(gpu, grid, lumps(grid));
    let mut view = frame(&grid, tissue(), DVec3::new(0.3, -1.0, 0.4), [4, 3]);
    view.step_mm = 0.0002;
    view.camera = view.camera.zoomed(0.8);
    for mode in [Mode::Dvr, Mode::Mip, Mode::Iso(26_000.0)] {
        let d = stage.compare(&Frame { mode, ..view.clone() });
        assert!(d.covered > 0.1 && d.largest <= 1.0, "{mode:?} {d:?}");
    }
    // Merged bodies take more turns a sample, so more passes.
    view.step_mm = 0.001;
    view.bodies = (0..3)
        .map(|id| Body { pose: Pose { translation: DVec3::splat(f64::from(id)), ..Pose::IDENTITY }, ..Body::whole(id) })
        .collect();
    let d = stage.compare(&view);
    assert!(d.covered > 0.1 && d.largest <= 1.0, "{d:?}");
}

#[test]
fn an_eye_inside_the_volume_sees_from_there() {
    let Some(gpu) = gpu() else { return };
    let grid = oblique_grid([40, 36, 30]);
    let mut stage = Stage::new(gpu, grid, lumps(grid));
    let mut view = frame(&grid, tissue(), DVec3::new(0.5, -1.0, 1.0), [40, 32]);
    view.camera.eye = grid.world_bounds().centre() + DVec3::new(2.0, -3.0, 1.0);
    let d = stage.compare(&view);
    assert!(d.covered > 0.5 && d.largest <= 1.0, "{d:?}");
}

#[test]
fn a_small_pool_draws_coarser_and_misses_nothing() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([100, 90, 70]);
    let density = lumps(grid);
    let mut stage = Stage::new(gpu.clone(), grid, density);
    let view = frame(&grid, tissue(), DVec3::new(0.5, -1.0, 1.0), [40, 32]);
    // 36 bricks of 34³ two-byte texels; five eighths of this budget are density's: about an eighth of them.
    stage.pools = FieldPools::new(&gpu, &grid, &stage.fields[0], 8 * 34 * 34 * 34 * 2).unwrap();
    let coarse = stage.image(&view);
    let middles = each([4, 3, 3], |b| b.map(|b| (b * 32 + 3) as f32));
    let levels: Vec<u32> = sample(&gpu, &stage.pools, &middles).iter().map(|s| s.level).collect();
    assert!(levels.iter().max() > levels.iter().min(), "{levels:?}");
    let reference = picture(&Dense::at_levels(&stage.fields(), &grid, levels), &view);
    let d = difference(&coarse, &reference, view.step_mm);
    assert!(d.covered > 0.15 && d.largest <= 1.0 && d.misplaced < 0.002, "{d:?}");
    let fine = picture(&Dense::of(&stage.fields(), &grid), &view);
    assert!(apart(&coarse, &fine, view.step_mm).largest > 2.0, "it is coarser");
    assert_eq!(stage.image(&view), coarse, "the picture at rest is stable");
}

#[test]
fn an_edit_shows_in_the_next_picture() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([64, 40, 40]);
    let mut stage = Stage::new(gpu, grid, density_u16(grid, |_| 0));
    let view = frame(&grid, tissue(), DVec3::new(0.5, -1.0, 1.0), [40, 32]);
    assert!(stage.image(&view).colour.iter().all(|c| c[3] == 0.0));
    let texels = each([BRICK; 3], |v| if v[0] > 4 && v[1] > 9 && v[2] > 9 { 40_000_u16 } else { 0 });
    let brick = Brick::from_texels(texels.iter().flat_map(|t| t.to_le_bytes()).collect(), 2);
    let (_, refresh) = stage.fields[0].swap(vec![(BrickIndex([1, 0, 0]), Some(brick))]).unwrap();
    stage.pools.refresh(&stage.gpu, FieldKind::Density, &stage.fields[0], &refresh).unwrap();
    let d = stage.compare(&view);
    assert!(d.covered > 0.05 && d.largest <= 1.0, "{d:?}");
}

#[test]
fn a_pick_answers_with_the_surface_at_rest() {
    let Some(gpu) = gpu() else { return };
    let (grid, density) = slab(40_000);
    let mut stage = Stage::new(gpu, grid, density);
    let mut view = down(&grid, tissue(), 1.0);
    view.mode = Mode::Iso(30_000.0);
    view.bodies =
        vec![Body { pose: Pose { translation: DVec3::new(1.0, 2.0, 3.0), ..Pose::IDENTITY }, ..Body::whole(4) }];
    let [density, colour, selection, labels] = &stage.fields;
    let fields = one_volume(&stage.grid, density, colour, selection, labels);
    let px = DVec2::new(12.3, 9.6);
    let hit = stage.caster.pick(&stage.gpu, &mut stage.pools, &fields, &view, px).unwrap().unwrap();
    // The face at z = 19 mm, 3 mm higher; the ray through px.
    let ray = view.camera.ray(px, view.size);
    let world = DVec3::new(ray.origin.x, ray.origin.y, 22.0);
    assert!((hit.world - world).length() < 1e-3, "{hit:?}");
    assert!((hit.rest - (world - DVec3::new(1.0, 2.0, 3.0))).length() < 1e-3);
    assert_eq!(hit.body, 4);
    let beside = stage.caster.pick(&stage.gpu, &mut stage.pools, &fields, &view, DVec2::new(0.2, 19.9)).unwrap();
    assert_eq!(beside, None);
}

#[test]
fn visibility_counts_as_the_definition_says() {
    let Some(gpu) = gpu() else { return };
    let grid = oblique_grid([50, 44, 36]);
    let mut stage = Stage::new(gpu, grid, lumps(grid));
    stage.fields[2] = painted(FieldKind::Selection, &grid, move |v| {
        let p = DVec3::from_array(std::array::from_fn(|a| f64::from(v[a]) / f64::from(grid.dims[a]) - 0.45));
        [((0.32 - p.length()) * 1400.0).clamp(0.0, 255.0) as u8, 0, 0, 0]
    });
    let middle = grid.world_bounds().centre();
    let cut = Plane::through(middle, DVec3::new(1.0, 0.2, 0.1)).unwrap();
    let part = |id, plane: Plane, shift: f64| {
        let pose = Pose { translation: plane.normal * -shift, ..Pose::IDENTITY };
        Body { pose, region: vec![plane], mask: Mask::Background, ..Body::whole(id) }
    };
    let stays = Body { mask: Mask::Selection, ..Body::whole(9) };
    let mut view = frame(&grid, tissue(), DVec3::new(0.4, -1.0, 0.6), [96, 80]);
    view.bodies = vec![part(1, cut, 12.0), part(2, cut.flipped(), 5.0), stays];
    let [density, colour, selection, labels] = &stage.fields;
    let fields = one_volume(&stage.grid, density, colour, selection, labels);
    let counted = stage.caster.visibility(&stage.gpu, &mut stage.pools, &fields, &view).unwrap();

    // By the book: bodies one at a time, opacity up to the sample where the selection alone reaches ½.
    let dense = Dense::of(&fields, &grid);
    let (mut selected, mut visible, mut hidden) = (0_i64, 0_i64, [0_i64; 2]);
    let alone = picture(&dense, &Frame { bodies: vec![view.bodies[2].clone()], ..view.clone() });
    for (i, there) in alone.iter().enumerate().filter(|(_, p)| p.object == 10) {
        selected += 1;
        let px = DVec2::new((i % 96) as f64 + 0.5, (i / 96) as f64 + 0.5);
        let ray = view.camera.ray(px, view.size);
        // Everything from the reached sample on is cut away by a plane across the ray, just before it.
        let wall = Plane::through(ray.at(there.depth_mm - 1e-6), ray.dir).unwrap();
        let opacity = |n: usize| {
            let mut body = view.bodies[n].clone();
            let normal = body.pose.rotation.inverse() * wall.normal;
            body.region.push(Plane::through(body.pose.unapply(ray.at(there.depth_mm - 1e-6)), normal).unwrap());
            super::reference::pixel(&dense, &Frame { bodies: vec![body], ..view.clone() }, px).colour[3]
        };
        let own = [opacity(0), opacity(1)];
        for (h, o) in hidden.iter_mut().zip(own) {
            *h += i64::from(o >= 0.05);
        }
        visible += i64::from((1.0 - own[0]) * (1.0 - own[1]) > 0.95);
    }
    println!("{counted:?}, by the book {selected} {visible} {hidden:?}");
    let close = |a: u64, b: i64| (a as i64 - b).abs() <= 2;
    assert!(selected > 100 && visible > 10 && visible < selected && hidden[0] + hidden[1] > 10);
    assert!(close(counted.selected, selected) && close(counted.visible, visible));
    assert_eq!(counted.hidden_by.len(), 2);
    for (n, (id, pixels)) in counted.hidden_by.iter().enumerate() {
        assert_eq!(*id, n as u32 + 1);
        assert!(close(*pixels, hidden[n]));
    }
    assert!((counted.share() - visible as f64 / selected as f64).abs() < 0.01);
}

/// Dense below the fifth layer and selected below the eighth: 6 mm of thin matter lie before the selection, and take
/// 1 − exp(−κ · 6 mm).
#[test]
fn the_selection_is_hidden_from_five_hundredths_of_opacity_on() {
    let Some(gpu) = gpu() else { return };
    let grid = Grid::aligned([24, 20, 10], DVec3::new(1.0, 1.0, 2.0), DVec3::ZERO);
    let mut stage = Stage::new(gpu, grid, density_u16(grid, |v| if v[2] < 4 { 40_000 } else { 100 }));
    stage.fields[2] = painted(FieldKind::Selection, &grid, |v| [if v[2] < 7 { 255 } else { 0 }, 0, 0, 0]);
    for (before, is_hidden) in [(0.0499_f64, false), (0.0501, true)] {
        let thin = 1.0 - (1.0 - before).powf(1.0 / 6.0);
        let transfer = TransferFunction {
            opacity: vec![(0.0, thin as f32), (30_000.0, thin as f32), (30_001.0, 0.9)],
            ..flat(0.0)
        };
        let mut view = down(&grid, transfer, 0.25);
        // Samples lie between the planes where the selection's share bends: their sum is the integral.
        view.camera.eye.z += 0.125;
        view.bodies =
            vec![Body { mask: Mask::Background, ..Body::whole(3) }, Body { mask: Mask::Selection, ..Body::whole(9) }];
        let [density, colour, selection, labels] = &stage.fields;
        let fields = one_volume(&stage.grid, density, colour, selection, labels);
        let counted = stage.caster.visibility(&stage.gpu, &mut stage.pools, &fields, &view).unwrap();
        let all = 24 * 20;
        let (visible, hidden) = if is_hidden { (0, all) } else { (all, 0) };
        assert_eq!((counted.selected, counted.visible), (all, visible), "{before}");
        assert_eq!(counted.hidden_by, [(3, hidden)], "{before}");
    }
}

#[test]
fn nothing_and_too_much_are_answers() {
    let Some(gpu) = gpu() else { return };
    let (grid, density) = slab(7);
    let mut stage = Stage::new(gpu.clone(), grid, density);
    let mut view = down(&grid, flat(0.5), 1.0);
    view.bodies.clear();
    assert!(stage.image(&view).object.iter().all(|o| *o == burin::gpu::ObjectId::NOTHING));
    view.size = [0, 7];
    assert!(stage.image(&view).colour.is_empty());
    view.size = [8, 8];
    view.bodies = (0..600).map(Body::whole).collect();
    let fields = stage.fields.clone();
    let [density, colour, selection, labels] = &fields;
    let fields = one_volume(&stage.grid, density, colour, selection, labels);
    let error = Caster::new(&gpu).unwrap().image(&gpu, &mut stage.pools, &fields, &view).unwrap_err();
    assert!(error.to_string().contains("600"), "{error}");
    view.bodies.truncate(1);
    view.step_mm = 0.0;
    let error = stage.caster.image(&gpu, &mut stage.pools, &fields, &view).unwrap_err();
    assert!(error.to_string().contains("step_mm"), "{error}");
    // Odd sizes fill their tiles only in part.
    let odd = Frame { size: [13, 9], step_mm: 1.0, ..down(&grid, flat(0.08), 1.0) };
    let reference = picture(&Dense::of(&fields, &grid), &odd);
    assert!(difference(&stage.image(&odd), &reference, 1.0).largest <= 1.0);
}

#[test]
fn an_eye_out_of_all_measure_sees_nothing_and_ends() {
    let Some(gpu) = gpu() else { return };
    let (grid, density) = slab(7);
    let mut stage = Stage::new(gpu, grid, density);
    let mut view = down(&grid, flat(0.5), 1.0);
    let middle = grid.world_bounds().centre();
    // 2²⁴ steps and more: their numbers are no whole numbers in 32-bit float.
    for far in [1e8, 1e30] {
        view.camera.eye = middle + DVec3::Z * far;
        assert!(stage.image(&view).colour.iter().all(|c| c[3] == 0.0), "{far}");
    }
}

#[test]
fn an_axis_over_2048_is_drawn_whole() {
    let Some(gpu) = gpu() else { return };
    let grid = unit_grid([2100, 12, 12]);
    let density = density_u16(grid, |v| (20_000.0 + 15_000.0 * (f64::from(v[0]) * 0.02).sin()) as u16);
    let mut stage = Stage::new(gpu, grid, density);
    let mut view = frame(&grid, tissue(), DVec3::new(0.3, -1.0, 0.5), [300, 40]);
    view.camera = view.camera.zoomed(0.06);
    for mode in [Mode::Dvr, Mode::Mip] {
        view.mode = mode;
        let d = stage.compare(&view);
        assert!(d.largest <= 1.0, "{mode:?}: {d:?}");
    }
    // Its far end too.
    let image = stage.image(&view);
    let shown: Vec<usize> = (0..300).filter(|&x| (0..40).any(|y| image.colour[y * 300 + x][3] > 0.1)).collect();
    assert!(shown.len() > 150, "{}", shown.len());
}
