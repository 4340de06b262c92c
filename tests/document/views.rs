//! Framing and layers by command: what a picture shows and what of it stays.

use super::maker::{run, state, write_nrrd};
use super::maker_gpu::{block, select};
use burin::document::{Document, ViewName};
use burin::math::{Camera, DVec3, Projection};
use burin::volume::Grid;

fn camera(document: &Document) -> Camera {
    document.state().unwrap().scene.views.camera
}

/// Half the picture's height over the bounding sphere's radius, both as angles or both as mm: 1 where the sphere just fits.
fn fit(document: &Document) -> f64 {
    let camera = camera(document);
    let bounds = document.state().unwrap().grid().world_bounds();
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
        slice(r#"{"history":{"undo":{}}}"#),
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
