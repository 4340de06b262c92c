//! Framing and layers by command: what a picture shows and what of it stays.

use super::maker::{run, state, write_nrrd};
use super::maker_gpu::{block, select};
use crate::common::one::One;
use burin::document::{Document, SlicePlane, ViewName};
use burin::math::{Camera, DVec2, DVec3, Projection};
use burin::volume::Grid;

fn camera(document: &Document) -> Camera {
    document.state().unwrap().scene.views.camera
}

/// Half the picture's height over the bounding sphere's radius, both as angles or both as mm: 1 where the sphere just fits.
fn fit(document: &Document) -> f64 {
    let camera = camera(document);
    let bounds = document.state().unwrap().one().grid().world_bounds();
    let radius = (bounds.max - bounds.min).length() * 0.5;
    match camera.projection {
        Projection::Perspective { fov_y_deg } => {
            (fov_y_deg * 0.5).to_radians() / (radius / camera.eye.distance(camera.target)).asin()
        }
        Projection::Orthographic { height_mm } => height_mm * 0.5 / radius,
    }
}

#[test]
fn framing_keeps_the_projection_and_fits_the_volume() {
    let mut document = Document::new();
    document.adopt(state());
    for projection in [
        Projection::Orthographic { height_mm: 3.0 },
        Projection::Perspective { fov_y_deg: 55.0 },
        Projection::Perspective { fov_y_deg: 30.0 },
    ] {
        let other = Camera { eye: DVec3::new(9.0, -70.0, 4.0), projection, ..camera(&document) };
        let set = serde_json::json!({"view": {"camera": {"camera": other}}}).to_string();
        run(&mut document, &set).unwrap();
        run(&mut document, r#"{"view":{"frame":{"from":[1,0,0]}}}"#).unwrap();
        let framed = camera(&document);
        assert_eq!(std::mem::discriminant(&framed.projection), std::mem::discriminant(&projection));
        if let (Projection::Perspective { fov_y_deg: now }, Projection::Perspective { fov_y_deg: was }) =
            (framed.projection, projection)
        {
            assert_eq!(now, was);
        }
        assert!((fit(&document) - 1.0).abs() < 1e-9, "{projection:?}: {framed:?}");
        assert!((framed.eye - framed.target).normalize().distance(DVec3::X) < 1e-12);
    }
}

#[test]
fn hidden_density_leaves_what_is_painted_on_black() {
    let Some(mut document) = block() else { return };
    select(&mut document);
    let mut slice = |line: &str| {
        if !line.is_empty() {
            run(&mut document, line).unwrap();
        }
        document.picture(ViewName::Axial, [64, 64], None).unwrap().to_rgba8(Some([0.0; 3]))
    };
    let (shown, hidden, back) = (
        slice(""),
        slice(r#"{"view":{"layer":{"field":"density","visible":false,"opacity":1}}}"#),
        slice(r#"{"view":{"back":{}}}"#),
    );
    let grey = |p: &[u8]| p[0] == p[1] && p[1] == p[2];
    let lit = |rgba: &[u8]| rgba.chunks_exact(4).filter(|p| p[0] > 0 && grey(p)).count();
    let painted = |rgba: &[u8]| rgba.chunks_exact(4).filter(|p| p[0] > 40 && !grey(p)).count();
    assert!(lit(&shown) > 500 && painted(&shown) > 50, "{} grey, {} painted", lit(&shown), painted(&shown));
    assert_eq!(lit(&hidden), 0, "nothing of the density is left");
    assert!(painted(&hidden) > 50, "the painted ball is");
    assert_eq!(back, shown);
}

#[test]
fn density_has_a_layer_without_an_opacity_of_its_own() {
    let mut document = Document::new();
    document.adopt(state());
    let error = run(&mut document, r#"{"view":{"layer":{"field":"density","visible":true,"opacity":0.5}}}"#);
    assert!(error.unwrap_err().to_string().contains("opacity: 0.5 found, 1: density's own look"));
    // Projects of before know three layers.
    let mut old = document.state().unwrap().scene.clone();
    old.layers.retain(|l| l.field != burin::volume::FieldKind::Density);
    assert!(old.layer(burin::volume::FieldKind::Density).visible);
    assert_eq!(old.layers.len(), 3);
}

#[test]
fn paint_on_a_volume_just_opened_is_seen_where_the_brush_was() {
    if block().is_none() {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("ball.nrrd");
    // Soft matter with a bright core, as a head is.
    let grid = Grid::aligned([64; 3], DVec3::ONE, DVec3::ZERO);
    write_nrrd(&path, &grid, |[i, j, k]| {
        let r = (DVec3::new(f64::from(i), f64::from(j), f64::from(k)) - 31.5).length();
        if r < 8.0 {
            200.0
        } else if r < 28.0 {
            110.0
        } else {
            0.0
        }
    });
    let mut document = Document::new();
    run(&mut document, &serde_json::json!({"volume": {"open": {"path": path}}}).to_string()).unwrap();
    let paint = r#"{"brush":{"set":{"radius_mm":3,"falloff":"hard","target":{"colour":[0,1,0,1]}}}}"#;
    run(&mut document, paint).unwrap();
    let stroke = r#"{"stroke":{"paint":{"points":[{"at":{"pixel":{"view":"3d","px":[32,32],"size":[64,64]}}}]}}}"#;
    run(&mut document, stroke).unwrap();
    let rgba = document.picture(ViewName::ThreeD, [64, 64], None).unwrap().to_rgba8(Some([0.0; 3]));
    let [r, g, b] = [0, 1, 2].map(|c| u32::from(rgba[(32 * 64 + 32) * 4 + c]));
    assert!(g > 2 * r && g > 2 * b, "green under the brush, not {r} {g} {b}");
}

#[test]
fn a_slice_is_fitted_into_its_picture_whatever_the_grid_and_the_picture() {
    let mut document = Document::new();
    document.adopt(state());
    let grid = *document.state().unwrap().one().grid();
    for size in [[300, 200], [200, 300], [1000, 90], [64, 64]] {
        for view in ["axial", "coronal", "sagittal"] {
            for line in [
                format!(r#"{{"view":{{"size":{{"view":"{view}","size":{size:?}}}}}}}"#),
                format!(r#"{{"view":{{"zoom":{{"view":"{view}","factor":0.07}}}}}}"#),
                format!(r#"{{"view":{{"pan":{{"view":"{view}","px":[40,-900]}}}}}}"#),
                format!(r#"{{"view":{{"fit":{{"view":"{view}"}}}}}}"#),
            ] {
                run(&mut document, &line).unwrap();
            }
            let name = serde_json::from_value(serde_json::json!(view)).unwrap();
            let plane = SlicePlane::new(&grid, &document.state().unwrap().scene.views, name).unwrap();
            // The slice's corners, half a voxel out of the outermost centres, in pixels of the picture.
            let [x, y] = plane.in_plane;
            let mut corners = Vec::new();
            for i in 0..4 {
                let mut index = DVec3::ZERO;
                index[plane.axis] = f64::from(plane.index);
                for (bit, axis) in [(0, x), (1, y)] {
                    let ends = [-0.5, f64::from(grid.dims[axis]) - 0.5];
                    index[axis] = ends[i >> bit & 1];
                }
                corners.push(plane.pixel(grid.world_from_index.transform_point3(index)));
            }
            let lo = corners.iter().copied().reduce(|a, b| a.min(b)).unwrap();
            let hi = corners.iter().copied().reduce(|a, b| a.max(b)).unwrap();
            let [w, h] = size.map(f64::from);
            let (left, right, top, bottom) = (lo.x, w - hi.x, lo.y, h - hi.y);
            assert!((left - right).abs() < 1e-6 && (top - bottom).abs() < 1e-6, "{view} {size:?} in the middle");
            assert!(left.min(top).abs() < 1e-6 && left.max(top) > -1e-6, "{view} {size:?} just fits: {lo} to {hi}");
        }
    }
}

#[test]
fn a_fitted_3d_view_keeps_its_direction_and_holds_every_part_where_it_stands() {
    let mut document = Document::new();
    document.adopt(state());
    run(&mut document, r#"{"part":{"split":{"by":{"plane":{"point":[0,0,0],"normal":[1,0.3,0]}}}}}"#).unwrap();
    for (size, projection) in [
        ([300, 300], r#"{"perspective":{"fov_y_deg":40}}"#),
        ([120, 600], r#"{"perspective":{"fov_y_deg":70}}"#),
        ([120, 600], r#"{"orthographic":{"height_mm":3}}"#),
        ([600, 120], r#"{"orthographic":{"height_mm":3}}"#),
    ] {
        for away in [0.0, 70.0] {
            let move_part = format!(
                r#"{{"part":{{"move":{{"id":2,"pose":{{"rotation":[0,0,0,1],"translation":[{away},0,20]}}}}}}}}"#
            );
            let line = format!(r#"{{"view":{{"size":{{"view":"3d","size":{size:?}}}}}}}"#);
            let set = format!(
                r#"{{"view":{{"camera":{{"camera":{{"eye":[9,-70,40],"target":[5,0,1],"up":[0.1,0,1],"projection":{projection}}}}}}}}}"#
            );
            for line in [&move_part, &line, &set] {
                run(&mut document, line).unwrap();
            }
            let before = camera(&document);
            run(&mut document, r#"{"view":{"fit":{"view":"3d"}}}"#).unwrap();
            let after = camera(&document);
            assert!(after.forward().distance(before.forward()) < 1e-12 && after.up == before.up, "the direction stays");
            let parts = &document.state().unwrap().scene.explosion.parts;
            let poses = document.poses();
            let corners: Vec<DVec3> =
                parts.iter().flat_map(|p| p.vertices.iter().map(|&v| poses.of(p).apply(v))).collect();
            for &corner in &corners {
                let (px, _) = after.project(corner, size).unwrap();
                let inside = px.cmpge(DVec2::ZERO).all() && px.x <= f64::from(size[0]) && px.y <= f64::from(size[1]);
                assert!(inside, "{corner} at {px} of {size:?}, {projection}, {away}");
            }
            // Not from far away either: the sphere about them touches the nearer pair of borders.
            let lo = corners.iter().copied().reduce(|a, b| a.min(b)).unwrap();
            let hi = corners.iter().copied().reduce(|a, b| a.max(b)).unwrap();
            let radius = (hi - lo).length() * 0.5;
            let narrow = f64::from(size[0].min(size[1])) / f64::from(size[1]);
            let touches = match after.projection {
                Projection::Orthographic { height_mm } => height_mm * 0.5 * narrow,
                Projection::Perspective { fov_y_deg } => {
                    let half = ((fov_y_deg * 0.5).to_radians().tan() * narrow).atan();
                    after.eye.distance(after.target) * half.sin()
                }
            };
            assert!((touches / radius - 1.0).abs() < 1e-9, "{touches} for {radius}");
        }
    }
    let hide = r#"{"part":{"set":{"id":2,"visible":false}}}"#;
    let near = |document: &mut Document| {
        run(document, r#"{"view":{"fit":{"view":"3d"}}}"#).unwrap();
        camera(document).half_height()
    };
    let all = near(&mut document);
    run(&mut document, hide).unwrap();
    assert!(near(&mut document) < all * 0.9, "what is hidden needs no room");
}

/// What is seen of a ball of voxels of this size at first, after an orbit, from near, and in a fitted and a nearer slice.
fn views_of_a_ball(voxel_mm: f64) -> Option<Vec<Vec<u8>>> {
    use super::maker_gpu::made;
    use burin::volume::Voxels;
    let at = |i: u32| DVec3::new(f64::from(i % 12), f64::from(i / 12 % 10), f64::from(i / 120));
    let voxel = |i: u32| if at(i).distance(DVec3::new(5.5, 4.5, 3.5)) < 3.0 { 200 } else { (i % 40) as u8 };
    let mut document = made(Voxels::U8((0..12 * 10 * 8).map(voxel).collect()), [12, 10, 8], DVec3::splat(voxel_mm))?;
    let function = serde_json::json!({"colour":[[0,[1,0.8,0.6]]],"opacity":[[60,0],[120,0.9]],"unit_mm":voxel_mm});
    run(&mut document, &serde_json::json!({"transfer":{"set":{"function":function}}}).to_string()).unwrap();
    let mut pictures = Vec::new();
    for (view, line) in [
        (ViewName::ThreeD, r#"{"view":{"frame":{"from":[1,-2,0.5]}}}"#),
        (ViewName::ThreeD, r#"{"view":{"orbit":{"azimuth_deg":40,"elevation_deg":10}}}"#),
        (ViewName::ThreeD, r#"{"view":{"zoom":{"view":"3d","factor":0.4}}}"#),
        (ViewName::ThreeD, r#"{"view":{"fit":{"view":"3d"}}}"#),
        (ViewName::Axial, r#"{"view":{"fit":{"view":"axial"}}}"#),
        (ViewName::Axial, r#"{"view":{"zoom":{"view":"axial","factor":0.3}}}"#),
    ] {
        run(&mut document, line).unwrap();
        pictures.push(document.picture(view, [48, 48], None).unwrap().to_rgba8(Some([0.0; 3])));
    }
    Some(pictures)
}

#[test]
fn a_volume_looks_the_same_in_any_unit() {
    let Some(expected) = views_of_a_ball(1.0) else { return };
    for picture in &expected {
        assert!(picture.chunks_exact(4).filter(|p| p[0] > 40).count() > 100);
    }
    for voxel_mm in [1e-10, 1e-9, 1e-7, 1e-6, 1e-3, 1e3, 1e6, 1e9] {
        for (i, (found, expected)) in views_of_a_ball(voxel_mm).unwrap().iter().zip(&expected).enumerate() {
            let apart = found.iter().zip(expected).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
            assert!(apart <= 3, "{voxel_mm} mm, picture {i}: {apart}");
        }
    }
}
