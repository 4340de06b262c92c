//! Strokes in the 3D view: they follow the surface under the pointer, break where there is none, and stay near what was hit.

use super::maker::{bytes, run, write_nrrd};
use super::maker_gpu::{block, labelled, made};
use crate::common::one::One;
use burin::document::Document;
use burin::math::{DVec2, DVec3};
use burin::volume::{Grid, Voxels};
use serde_json::{Value, json};

const SIZE: [u32; 2] = [256, 256];

/// A document of 64³ voxels of 1 mm: opaque from 105 on, seen from the front.
fn scene(value: impl Fn(DVec3) -> f64) -> Option<Document> {
    scene_on([64; 3], DVec3::ONE, value)
}

fn scene_on(dims: [u32; 3], spacing: DVec3, value: impl Fn(DVec3) -> f64) -> Option<Document> {
    let at =
        |i: u32| DVec3::new(f64::from(i % dims[0]), f64::from(i / dims[0] % dims[1]), f64::from(i / dims[0] / dims[1]));
    let voxels = (0..dims.iter().product()).map(|i| value(at(i)).clamp(0.0, 255.0) as u8).collect();
    let mut document = made(Voxels::U8(voxels), dims, spacing)?;
    for line in [
        json!({"transfer":{"set":{"function":{"colour":[[0,[1,1,1]]],"opacity":[[0,0],[100,0],[110,1]],"unit_mm":1}}}}),
        json!({"view":{"size":{"view":"3d","size":SIZE}}}),
        json!({"view":{"frame":{"from":[0,1,0]}}}),
        json!({"brush":{"set":{"falloff":"hard","target":{"label":1}}}}),
    ] {
        run(&mut document, &line.to_string()).unwrap();
    }
    Some(document)
}

fn points(line: &[DVec2]) -> Value {
    line.iter().map(|p| json!({"at":{"pixel":{"view":"3d","px":p.to_array(),"size":SIZE}}})).collect()
}

/// Pixels from one to another, so many apart.
fn way(from: [f64; 2], to: [f64; 2], apart: f64) -> Vec<DVec2> {
    let [from, to] = [from, to].map(DVec2::from_array);
    let n = (from.distance(to) / apart).round().max(1.0);
    (0..=n as u32).map(|i| from.lerp(to, f64::from(i) / n)).collect()
}

fn paint(document: &mut Document, line: &[DVec2]) -> Value {
    run(document, &json!({"stroke":{"paint":{"points":points(line)}}}).to_string()).unwrap()
}

/// What is hit all along a way of pixels, at rest.
fn hits(document: &mut Document, line: &[DVec2]) -> Vec<Option<DVec3>> {
    line.iter()
        .map(|p| {
            let ask = json!({"ask":{"pick":{"px":p.to_array(),"size":SIZE}}});
            let hit = run(document, &ask.to_string()).unwrap()["hit"]["rest_mm"].clone();
            serde_json::from_value::<[f64; 3]>(hit).ok().map(DVec3::from_array)
        })
        .collect()
}

/// No labelled voxel lies farther than radius + 1 voxel from a point that was hit, and every point that was hit is painted.
fn near_what_was_hit(document: &Document, label: u16, hits: &[Option<DVec3>], radius: f64, voxel: f64) {
    let m = document.state().unwrap().one().grid().world_from_index;
    let labels = labelled(document, label);
    assert!(!labels.is_empty());
    let at = |v: &[u32; 3]| m.transform_point3(DVec3::from_array(v.map(f64::from)));
    for v in &labels {
        let nearest = hits.iter().flatten().map(|h| h.distance(at(v))).fold(f64::INFINITY, f64::min);
        assert!(nearest <= radius + voxel + 1e-6, "{v:?} is {nearest} from what was hit");
    }
    for h in hits.iter().flatten() {
        let nearest = labels.iter().map(|v| h.distance(at(v))).fold(f64::INFINITY, f64::min);
        assert!(nearest <= 0.9 * voxel, "{h}, which was hit, is {nearest} from what is painted");
    }
}

fn balls(p: DVec3) -> f64 {
    let [a, b] = [14.0, 50.0].map(|x| p.distance(DVec3::new(x, 32.0, 32.0)) < 10.0);
    if a || b { 200.0 } else { 0.0 }
}

#[test]
fn a_stroke_over_air_breaks_and_paints_nothing_there() {
    let Some(mut document) = scene(balls) else { return };
    run(&mut document, r#"{"brush":{"set":{"radius_mm":3}}}"#).unwrap();
    // As densely as a slow hand, as a fast one, and from ball to ball at once.
    let mut painted = Vec::new();
    let met = hits(&mut document, &way([58.0, 128.0], [198.0, 128.0], 1.0));
    for (label, apart) in [(1, 1.0), (2, 4.0), (3, 20.0), (4, 140.0)] {
        run(&mut document, &json!({"brush":{"set":{"target":{"label":label}}}}).to_string()).unwrap();
        let line = way([58.0, 128.0], [198.0, 128.0], apart);
        let answer = paint(&mut document, &line);
        assert!(met.iter().any(Option::is_none), "there is air between");
        near_what_was_hit(&document, label, &met, 3.0, 1.0);
        painted.push(labelled(&document, label));
        assert!(labelled(&document, label).iter().all(|v| !(28..=36).contains(&v[0])), "between the balls");
        if apart < 100.0 {
            assert!(answer["missed"].as_u64().unwrap() > 0);
        }
        run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    }
    for other in &painted[1..] {
        same_but_for_rims(&painted[0], other);
    }
}

/// Two strokes of one way: not the same bits, since their samples differ, but no break more or less.
fn same_but_for_rims(a: &[[u32; 3]], b: &[[u32; 3]]) {
    let [a, b]: [std::collections::BTreeSet<_>; 2] = [a, b].map(|v| v.iter().collect());
    let differ = a.symmetric_difference(&b).count();
    assert!(differ * 50 <= a.len(), "{differ} voxels of {} differ", a.len());
}

#[test]
fn a_stroke_breaks_at_a_step_in_depth() {
    let plates = |p: DVec3| {
        let near = (20.0..44.0).contains(&p.x) && (54.0..58.0).contains(&p.y);
        let far = (2.0..62.0).contains(&p.x) && (6.0..10.0).contains(&p.y);
        if (8.0..56.0).contains(&p.z) && (near || far) { 200.0 } else { 0.0 }
    };
    for projection in ["perspective", "orthographic"] {
        let Some(mut document) = scene(plates) else { return };
        if projection == "orthographic" {
            let camera = json!({"eye":[31.5,120,31.5],"target":[31.5,31.5,31.5],"up":[0,0,1],"projection":{"orthographic":{"height_mm":90}}});
            run(&mut document, &json!({"view":{"camera":{"camera":camera}}}).to_string()).unwrap();
        }
        run(&mut document, r#"{"brush":{"set":{"radius_mm":2}}}"#).unwrap();
        let mut painted = Vec::new();
        let met = hits(&mut document, &way([200.0, 128.0], [60.0, 128.0], 1.0));
        for (label, apart) in [(1, 1.0), (3, 20.0), (4, 140.0)] {
            run(&mut document, &json!({"brush":{"set":{"target":{"label":label}}}}).to_string()).unwrap();
            // From one edge of the far plate over the near one to the other edge.
            paint(&mut document, &way([200.0, 128.0], [60.0, 128.0], apart));
            near_what_was_hit(&document, label, &met, 2.0, 1.0);
            let depths: std::collections::BTreeSet<u32> = labelled(&document, label).iter().map(|v| v[1]).collect();
            assert!(depths.iter().all(|y| *y <= 13 || *y >= 53), "{projection} {apart}: {depths:?}");
            assert!(depths.contains(&9) && depths.contains(&57), "both plates are painted");
            painted.push(labelled(&document, label));
            run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
        }
        for other in &painted[1..] {
            same_but_for_rims(&painted[0], other);
        }
    }
}

#[test]
fn a_stroke_over_a_ball_does_not_break_up_to_80_degrees() {
    // A smooth ball of radius 24: the surface of 105 is exactly that.
    let ball = |p: DVec3| 105.0 + 20.0 * (24.0 - p.distance(DVec3::splat(31.5)));
    for eye in ["perspective", "orthographic"] {
        let Some(mut document) = scene(ball) else { return };
        let toward = if eye == "orthographic" {
            let camera = json!({"eye":[31.5,150,31.5],"target":[31.5,31.5,31.5],"up":[0,0,1],"projection":{"orthographic":{"height_mm":110}}});
            run(&mut document, &json!({"view":{"camera":{"camera":camera}}}).to_string()).unwrap();
            DVec3::Y
        } else {
            document.state().unwrap().scene.views.camera.eye
        };
        let camera = document.state().unwrap().scene.views.camera;
        let sight = |p: DVec3| if eye == "orthographic" { toward } else { (toward - p).normalize() };
        // Places on the ball in the horizontal plane, by the angle between normal and line of sight.
        let places: Vec<_> = (0..=900)
            .map(|i| f64::from(i) * 0.1_f64.to_radians())
            .map(|turn| DVec3::new(-turn.sin(), turn.cos(), 0.0))
            .map(|n| (n, DVec3::splat(31.5) + n * 24.0))
            .filter(|(n, p)| n.dot(sight(*p)) >= 80.0_f64.to_radians().cos())
            .collect();
        let [first, last] = [places[0].1, places.last().unwrap().1].map(|p| camera.project(p, SIZE).unwrap().0);
        for (label, radius, apart) in [(1, 0.4, 1.0), (2, 1.0, 1000.0), (3, 3.0, 20.0)] {
            let set = json!({"brush":{"set":{"target":{"label":label},"radius_mm":radius}}});
            run(&mut document, &set.to_string()).unwrap();
            paint(&mut document, &way(first.to_array(), last.to_array(), apart));
            let labels: std::collections::BTreeSet<_> = labelled(&document, label).into_iter().collect();
            // All along the arc, also where a pixel passes several voxels of it.
            for (n, p) in &places {
                let nearest = labels
                    .iter()
                    .map(|v| p.distance(DVec3::from_array(v.map(f64::from))))
                    .fold(f64::INFINITY, f64::min);
                // The rays meet it within a sample, the path follows it within a tenth of a voxel, a voxel's centre is ½√3 off.
                assert!(nearest < 1.1, "{eye}, radius {radius}: nothing within {nearest} of {p}, normal {n}");
            }
            run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
        }
    }
}

#[test]
fn the_deepest_step_that_is_joined_is_the_diameter_and_two_voxels() {
    // Two plates side by side, the second so much deeper; sharp edges in the middle of the view, seen without perspective.
    for (step, radius) in [(2, 1.0), (4, 2.0), (5, 1.0), (9, 2.0), (16, 6.0)] {
        let plates = |p: DVec3| {
            let front = if p.x < 32.0 { 40.0 } else { 40.0 - f64::from(step) };
            if p.y <= front && p.y > front - 3.0 { 200.0 } else { 0.0 }
        };
        let Some(mut document) = scene(plates) else { return };
        let camera = json!({"eye":[31.5,120,31.5],"target":[31.5,31.5,31.5],"up":[0,0,1],"projection":{"orthographic":{"height_mm":80}}});
        run(&mut document, &json!({"view":{"camera":{"camera":camera}}}).to_string()).unwrap();
        run(&mut document, &json!({"brush":{"set":{"radius_mm":radius}}}).to_string()).unwrap();
        let met = hits(&mut document, &way([116.0, 128.0], [140.0, 128.0], 1.0));
        for apart in [1.0, 24.0] {
            paint(&mut document, &way([116.0, 128.0], [140.0, 128.0], apart));
            near_what_was_hit(&document, 1, &met, radius, 1.0);
            // Depths that are painted in the column under the edge.
            let depths: std::collections::BTreeSet<u32> = labelled(&document, 1)
                .iter()
                .filter(|v| v[2] == 31 && (31..=32).contains(&v[0]))
                .map(|v| v[1])
                .collect();
            let gap = (40 - step..=40).any(|y| !depths.contains(&(y as u32)));
            assert_eq!(gap, f64::from(step) > 2.0 * radius + 2.0, "step {step}, radius {radius}: {depths:?}");
            run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
        }
    }
}

#[test]
fn a_stroke_over_parts_that_moved_breaks_between_them_and_is_painted_where_they_rest() {
    let Some(mut document) = block() else { return };
    let plane = r#"{"part":{"split":{"by":{"plane":{"point":[31.5,0,0],"normal":[1,0,0]}}}}}"#;
    let halves = run(&mut document, plane).unwrap()["halves"].clone();
    // The half at larger x goes back and up, so that its front shows beside the other's.
    let pose = json!({"rotation":[0,0,0,1],"translation":[3,-12,6]});
    run(&mut document, &json!({"part":{"move":{"id":halves[0][1],"pose":pose}}}).to_string()).unwrap();
    run(&mut document, &json!({"view":{"size":{"view":"3d","size":SIZE}}}).to_string()).unwrap();
    run(&mut document, r#"{"brush":{"set":{"falloff":"hard","radius_mm":3}}}"#).unwrap();
    let met = hits(&mut document, &way([90.0, 126.0], [170.0, 126.0], 1.0));
    for (label, apart) in [(1, 1.0), (2, 20.0), (3, 200.0)] {
        run(&mut document, &json!({"brush":{"set":{"target":{"label":label}}}}).to_string()).unwrap();
        let line = way([90.0, 126.0], [170.0, 126.0], apart);
        paint(&mut document, &line);
        near_what_was_hit(&document, label, &met, 3.0, 1.0);
        // Both halves.
        let x: std::collections::BTreeSet<u32> = labelled(&document, label).iter().map(|v| v[0]).collect();
        assert!(x.iter().any(|x| *x < 25) && x.iter().any(|x| *x > 40), "{x:?}");
        run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    }
}

#[test]
fn thick_slices_and_grazing_ways_stay_near_what_was_hit() {
    let dims = [48, 48, 16];
    let hills = |p: DVec3| {
        let height = 24.0 + 9.0 * (p.x * 0.35).sin() + 6.0 * (p.z * 1.1).cos();
        if p.y < height { 200.0 } else { 0.0 }
    };
    let Some(mut document) = scene_on(dims, DVec3::new(0.8, 0.8, 3.0), hills) else { return };
    for (from, label) in [([0.3, 1.0, 0.2], 1), ([1.0, 0.25, 0.3], 2), ([-0.4, 0.5, 1.0], 3)] {
        run(&mut document, &json!({"view":{"frame":{"from":from}}}).to_string()).unwrap();
        run(&mut document, &json!({"brush":{"set":{"target":{"label":label},"radius_mm":2.5}}}).to_string()).unwrap();
        paint(&mut document, &way([100.0, 110.0], [160.0, 140.0], 35.0));
        let met = hits(&mut document, &way([100.0, 110.0], [160.0, 140.0], 1.0));
        let m = document.state().unwrap().one().grid().world_from_index;
        for v in labelled(&document, label) {
            let at = m.transform_point3(DVec3::from_array(v.map(f64::from)));
            let nearest = met.iter().flatten().map(|h| h.distance(at)).fold(f64::INFINITY, f64::min);
            assert!(nearest <= 2.5 + 0.8 + 1e-6, "{from:?}: {v:?} is {nearest} from what was hit");
        }
        run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    }
}

#[test]
fn a_running_stroke_breaks_where_one_at_once_does() {
    let Some(mut whole) = scene(balls) else { return };
    let Some(mut running) = scene(balls) else { return };
    for document in [&mut whole, &mut running] {
        run(document, r#"{"brush":{"set":{"radius_mm":3}}}"#).unwrap();
    }
    let line = way([58.0, 128.0], [198.0, 128.0], 10.0);
    let missed = paint(&mut whole, &line)["missed"].clone();
    for (i, p) in line.iter().enumerate() {
        let verb = if i == 0 { "begin" } else { "extend" };
        run(&mut running, &json!({"stroke":{verb:{"points":points(&[*p])}}}).to_string()).unwrap();
    }
    assert_eq!(run(&mut running, r#"{"stroke":{"end":{}}}"#).unwrap()["missed"], missed);
    assert_eq!(bytes(&whole), bytes(&running));
}

#[test]
fn a_stroke_that_was_running_at_a_crash_keeps_its_breaks() {
    let Some(probe) = block() else { return };
    drop(probe);
    let folder = tempfile::tempdir().unwrap();
    let (volume, project) = (folder.path().join("v.nrrd"), folder.path().join("p"));
    write_nrrd(&volume, &Grid::aligned([64; 3], DVec3::ONE, DVec3::ZERO), |v| {
        balls(DVec3::from_array(v.map(f64::from))) as f32
    });
    let begin = |name: &str| {
        let mut document = Document::new();
        run(&mut document, &json!({"volume":{"open":{"path":volume}}}).to_string()).unwrap();
        let opaque = r#"{"transfer":{"set":{"function":{"colour":[[0,[1,1,1]]],"opacity":[[0,0],[100,0],[110,1]],"unit_mm":1}}}}"#;
        run(&mut document, opaque).unwrap();
        let path = project.with_extension(name);
        run(&mut document, &json!({"project":{"save":{"path":path}}}).to_string()).unwrap();
        run(&mut document, r#"{"view":{"frame":{"from":[0,1,0]}}}"#).unwrap();
        run(&mut document, r#"{"brush":{"set":{"radius_mm":3,"target":{"label":1}}}}"#).unwrap();
        for (i, p) in way([58.0, 128.0], [198.0, 128.0], 20.0).iter().enumerate() {
            let verb = if i == 0 { "begin" } else { "extend" };
            run(&mut document, &json!({"stroke":{verb:{"points":points(&[*p])}}}).to_string()).unwrap();
        }
        (document, path)
    };
    let (mut whole, _) = begin("whole");
    run(&mut whole, r#"{"stroke":{"end":{}}}"#).unwrap();
    let (crashed, path) = begin("crashed");
    drop(crashed);
    let mut again = Document::new();
    let answer = run(&mut again, &json!({"project":{"open":{"path":path}}}).to_string()).unwrap();
    assert_eq!(answer["recovered"]["stroke"], "painted");
    assert!(labelled(&again, 1).iter().all(|v| !(28..=36).contains(&v[0])));
    assert_eq!(bytes(&again), bytes(&whole));
}

#[test]
fn points_in_mm_and_index_are_a_path_as_given() {
    let Some(mut document) = scene(balls) else { return };
    run(&mut document, r#"{"brush":{"set":{"radius_mm":2}}}"#).unwrap();
    for place in ["mm", "index"] {
        let points = json!([{"at":{place:[14,32,32]}}, {"at":{place:[50,32,32]}}]);
        run(&mut document, &json!({"stroke":{"paint":{"points":points}}}).to_string()).unwrap();
        assert!((14..=50).all(|x| labelled(&document, 1).contains(&[x, 32, 32])), "{place}");
        run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    }
}

#[test]
fn the_view_may_turn_while_a_stroke_runs() {
    let ball = |p: DVec3| 105.0 + 20.0 * (20.0 - p.distance(DVec3::splat(31.5)));
    let Some(mut document) = scene(ball) else { return };
    run(&mut document, r#"{"brush":{"set":{"radius_mm":2}}}"#).unwrap();
    let at = |p: [f64; 2]| points(&[DVec2::from_array(p)]);
    run(&mut document, &json!({"stroke":{"begin":{"points":at([128.0, 128.0])}}}).to_string()).unwrap();
    run(&mut document, r#"{"view":{"orbit":{"azimuth_deg":40,"elevation_deg":0}}}"#).unwrap();
    run(&mut document, &json!({"stroke":{"extend":{"points":at([128.0, 128.0])}}}).to_string()).unwrap();
    run(&mut document, r#"{"stroke":{"end":{}}}"#).unwrap();
    // On from where it was, over the surface: no chord through the ball.
    for v in labelled(&document, 1) {
        let depth = 20.0 - DVec3::from_array(v.map(f64::from)).distance(DVec3::splat(31.5));
        assert!(depth < 2.6, "{v:?} lies {depth} deep");
    }
    assert!(labelled(&document, 1).len() > 150, "{}", labelled(&document, 1).len());
}

/// Two plates one behind the other, the front one with a window of values that the look hides.
fn plates_with_a_window(p: DVec3) -> f64 {
    let front = (50.0..54.0).contains(&p.y);
    let behind = (40.0..46.0).contains(&p.y);
    if !(front || behind) || !(4.0..60.0).contains(&p.x) || !(4.0..60.0).contains(&p.z) {
        return 0.0;
    }
    if front && (38.0..40.0).contains(&p.x) { 99.0 } else { 200.0 }
}

#[test]
fn a_stroke_that_keeps_to_the_surface_paints_its_first_layer_and_nothing_that_is_hidden() {
    for projection in ["perspective", "orthographic"] {
        let Some(mut document) = scene(plates_with_a_window) else { return };
        if projection == "orthographic" {
            let camera = json!({"eye":[31.5,120,31.5],"target":[31.5,31.5,31.5],"up":[0,0,1],"projection":{"orthographic":{"height_mm":90}}});
            run(&mut document, &json!({"view":{"camera":{"camera":camera}}}).to_string()).unwrap();
        }
        let set = json!({"radius_mm":12,"visible_only":true,"target":{"label":1}});
        assert_eq!(
            run(&mut document, &json!({"brush":{"set":set}}).to_string()).unwrap()["brush"]["visible_only"],
            true
        );
        let camera = document.state().unwrap().scene.views.camera;
        let click = camera.project(DVec3::new(28.0, 53.5, 31.0), SIZE).unwrap().0;
        paint(&mut document, &[click]);
        let hit = hits(&mut document, &[click])[0].unwrap();
        let labels = labelled(&document, 1);
        for v in &labels {
            // The front layer; through the window, where the rays pass, its sides and what shows behind it.
            let through = (45..53).contains(&v[1]) && (36..=42).contains(&v[0]);
            assert!(v[1] == 53 || through, "{projection}: {v:?} is behind the first surface");
            assert!(!(38..40).contains(&v[0]) || v[1] != 53, "{projection}: {v:?} is hidden by the look");
        }
        // All of the layer within the ball.
        let mut layer = 0;
        for x in 4..38 {
            for z in 4..60 {
                let inside = DVec3::new(f64::from(x), 53.0, f64::from(z)).distance(hit) < 11.9;
                layer += usize::from(inside);
                assert!(!inside || labels.contains(&[x, 53, z]), "{projection}: [{x}, 53, {z}] is not painted");
            }
        }
        assert!(layer > 300);
        // The same click without it goes through to the plate behind.
        run(&mut document, r#"{"brush":{"set":{"visible_only":false,"target":{"label":2}}}}"#).unwrap();
        paint(&mut document, &[click]);
        assert!(labelled(&document, 2).iter().any(|v| v[1] < 46));
    }
}

#[test]
fn a_fast_stroke_on_the_surface_of_a_ball_leaves_no_hole_and_nothing_beneath() {
    let ball = |p: DVec3| 105.0 + 40.0 * (24.0 - p.distance(DVec3::splat(31.5)));
    let Some(mut document) = scene(ball) else { return };
    run(&mut document, r#"{"brush":{"set":{"radius_mm":5,"visible_only":true}}}"#).unwrap();
    paint(&mut document, &way([90.0, 128.0], [166.0, 128.0], 100.0));
    let labels = labelled(&document, 1);
    for v in &labels {
        let depth = 24.0 - DVec3::from_array(v.map(f64::from)).distance(DVec3::splat(31.5));
        // A cell of the surface reaches less than its diagonal; the look begins to show at 100, 0.1 voxels outside.
        assert!(depth < 1.75 && depth > -0.2, "{v:?} lies {depth} deep");
    }
    let met = hits(&mut document, &way([90.0, 128.0], [166.0, 128.0], 1.0));
    for h in met.iter().flatten() {
        let nearest =
            labels.iter().map(|v| h.distance(DVec3::from_array(v.map(f64::from)))).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1.0, "{h}: {nearest}");
    }
    assert!(labels.len() > 300, "{}", labels.len());
    // Mode and value range go together with it.
    run(&mut document, r#"{"history":{"undo":{}}}"#).unwrap();
    run(&mut document, r#"{"brush":{"set":{"range":[0,20]}}}"#).unwrap();
    let nothing = paint(&mut document, &way([120.0, 128.0], [130.0, 128.0], 5.0));
    assert!(nothing["nothing"].as_str().unwrap().contains("from 0 to 20"), "{nothing}");
}

#[test]
fn a_moved_part_is_painted_on_what_shows_of_it() {
    let Some(mut document) = block() else { return };
    let plane = r#"{"part":{"split":{"by":{"plane":{"point":[0,23.5,0],"normal":[0,1,0]}}}}}"#;
    let halves = run(&mut document, plane).unwrap()["halves"].clone();
    // The front half goes up: the cut face of the one behind shows.
    let pose = json!({"rotation":[0,0,0,1],"translation":[0,0,40]});
    run(&mut document, &json!({"part":{"move":{"id":halves[0][1],"pose":pose}}}).to_string()).unwrap();
    run(&mut document, &json!({"view":{"size":{"view":"3d","size":SIZE}}}).to_string()).unwrap();
    let set = json!({"radius_mm":6,"visible_only":true,"target":{"label":1}});
    run(&mut document, &json!({"brush":{"set":set}}).to_string()).unwrap();
    let camera = document.state().unwrap().scene.views.camera;
    let click = camera.project(DVec3::new(31.0, 23.5, 20.0), SIZE).unwrap().0;
    paint(&mut document, &[click]);
    let layers: std::collections::BTreeSet<u32> = labelled(&document, 1).iter().map(|v| v[1]).collect();
    // The cut runs between the layers 23 and 24.
    assert!(!layers.is_empty() && layers.iter().all(|y| (22..=24).contains(y)), "{layers:?}");
    assert!(labelled(&document, 1).len() > 80);
}

#[test]
fn a_stroke_on_a_slice_takes_no_heed_of_what_the_3d_view_shows() {
    let Some(mut document) = scene(plates_with_a_window) else { return };
    run(&mut document, r#"{"view":{"crosshair":{"at":{"index":[31,43,31]}}}}"#).unwrap();
    run(&mut document, r#"{"brush":{"set":{"radius_mm":3,"visible_only":true}}}"#).unwrap();
    let point = json!({"at":{"pixel":{"view":"coronal","px":[128,128],"size":[256,256]}}});
    let answer = run(&mut document, &json!({"stroke":{"paint":{"points":[point]}}}).to_string()).unwrap();
    assert!(answer["voxels_changed"].as_u64().unwrap() > 100, "{answer}");
    // In mm and index it keeps to the surface: here, between the plates, there is none.
    let answer = run(&mut document, r#"{"stroke":{"paint":{"points":[{"at":{"index":[20,32,31]}}]}}}"#).unwrap();
    assert!(answer["nothing"].as_str().unwrap().contains("shows"), "{answer}");
}
