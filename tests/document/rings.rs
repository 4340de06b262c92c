//! A volume that was just opened shows little of the rings that samples along parallel rays leave on curved matter.

use super::maker::{run, write_nrrd};
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::Grid;
use serde_json::{Value, json};

#[test]
fn a_new_volume_shows_less_than_half_of_the_rings_of_one_sample_a_voxel() {
    if crate::common::gpu::gpu().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.nrrd");
    // A ball of 200 in air of 10, its border two voxels soft as a scanner's is.
    let grid = Grid::aligned([48; 3], DVec3::ONE, DVec3::ZERO);
    write_nrrd(&path, &grid, |v| {
        let r = v.iter().map(|&x| (f64::from(x) - 23.5).powi(2)).sum::<f64>().sqrt();
        (10.0 + 190.0 / (1.0 + ((r - 19.0) / 0.8).exp())) as f32
    });
    let mut document = Document::new();
    run(&mut document, &json!({"volume":{"open":{"path": path}}}).to_string()).unwrap();
    let mut draw = |name: &str, step: Option<f64>| {
        if let Some(step) = step {
            run(&mut document, &json!({"view":{"look":{"step_voxels": step}}}).to_string()).unwrap();
        }
        let to = folder.path().join(name);
        run(&mut document, &json!({"render":{"image":{"path": to, "size": [160, 160]}}}).to_string()).unwrap();
        let image = image::open(&to).unwrap().to_rgb8();
        image.pixels().map(|p| p.0.iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0).collect::<Vec<_>>()
    };
    let usual = draw("usual.png", None);
    let coarse = draw("coarse.png", Some(1.0));
    let limit = draw("limit.png", Some(0.0625));
    let error = |a: &[f64]| {
        let square: f64 = a.iter().zip(&limit).map(|(a, b)| (a - b).powi(2)).sum();
        (square / limit.iter().filter(|&&x| x > 20.0).count().max(1) as f64).sqrt()
    };
    assert!(limit.iter().filter(|&&x| x > 60.0).count() > 1500, "the ball is seen");
    assert!(error(&coarse) > 1.0, "one sample a voxel shows rings: {}", error(&coarse));
    assert!(error(&usual) < 0.5 * error(&coarse), "{} beside {}", error(&usual), error(&coarse));
}

#[test]
fn samples_that_are_named_are_plain_ones_and_refining_is_said_kept_and_taken_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.nrrd");
    write_nrrd(&path, &Grid::aligned([8; 3], DVec3::ONE, DVec3::ZERO), |v| v[0] as f32);
    let mut document = Document::new();
    run(&mut document, &json!({"volume":{"open":{"path": path}}}).to_string()).unwrap();
    assert!(document.state().unwrap().scene.look.refine, "a new volume is drawn without rings");
    let mut look = |given: Value| {
        let said = run(&mut document, &json!({"view":{"look": given}}).to_string()).unwrap();
        (said["look"]["step_voxels"].as_f64().unwrap(), said["look"]["refine"].as_bool().unwrap())
    };
    assert_eq!(look(json!({"shaded": false})), (0.5, true), "other things said of a look leave it alone");
    assert_eq!(look(json!({"step_voxels": 0.25})), (0.25, false));
    assert_eq!(look(json!({"mode": "mip"})), (0.25, false));
    assert_eq!(look(json!({"refine": true})), (0.25, true));
    assert_eq!(look(json!({"step_voxels": 1, "refine": true})), (1.0, true));
    assert_eq!(look(json!({"refine": false})), (1.0, false));
    assert_eq!(look(json!({"refine": true})), (1.0, true));
    let project = folder.path().join("ball.burin");
    run(&mut document, &json!({"project":{"save":{"path": project}}}).to_string()).unwrap();
    drop(document);
    let mut document = Document::new();
    run(&mut document, &json!({"project":{"open":{"path": project}}}).to_string()).unwrap();
    let kept = document.state().unwrap().scene.look.clone();
    assert_eq!((kept.step_voxels, kept.refine), (1.0, true), "saved");
    assert_eq!(run(&mut document, r#"{"view":{"back":{}}}"#).unwrap()["moved"], true);
    assert!(!document.state().unwrap().scene.look.refine, "taken back like any look");
}
