//! Strokes in sub-volumes: at their resolution, over their faces, baked down, and how near what is painted comes to what was meant.

use super::maker::run;
use super::maker_gpu::{block, made};
use crate::common::volumes::Watched;
use burin::document::{Document, Origin, State};
use burin::math::DVec3;
use burin::volume::*;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

fn does(document: &mut Document, command: Value) -> Value {
    run(document, &command.to_string()).unwrap_or_else(|error| panic!("{command}: {error}"))
}

fn brush(document: &mut Document, set: Value) {
    does(document, json!({"brush": {"set": set}}));
}

fn click(document: &mut Document, mm: [f64; 3], volume: Option<u32>) -> Value {
    let mut paint = json!({"points": [{"at": {"mm": mm}}]});
    if let Some(volume) = volume {
        paint["volume"] = json!(volume);
    }
    does(document, json!({"stroke": {"paint": paint}}))
}

fn value(document: &Document, volume: u32, kind: FieldKind, voxel: [u32; 3]) -> f64 {
    let field = document.state().unwrap().volumes[&VolumeId(volume)].field(kind);
    match kind {
        FieldKind::Density => field.number(voxel).unwrap().to_f64(),
        _ => f64::from(field.value(voxel).unwrap()),
    }
}

const LO: [u32; 3] = [20, 14, 10];
const HI: [u32; 3] = [36, 30, 20];

fn boxed(scale: u32) -> Option<Document> {
    let mut document = block()?;
    does(&mut document, json!({"sub_volume": {"add": {"lo": LO, "hi": HI, "scale": scale}}}));
    Some(document)
}

#[test]
fn a_dab_over_a_face_paints_both_sides_each_voxel_once_and_fades_at_the_face() {
    let Some(mut document) = boxed(4) else { return };
    let change = json!({"target": {"density": 10}, "operation": "add", "falloff": "hard", "radius_mm": 6});
    brush(&mut document, change);
    let said = click(&mut document, [20.0, 22.0, 15.0], None);
    assert_eq!(said["step"], json!("Paint density"), "{said}");
    let parent = |document: &Document, voxel| value(document, 0, FieldKind::Density, voxel);
    let fine = |document: &Document, voxel| value(document, 1, FieldKind::Density, voxel);
    assert_eq!(parent(&document, [17, 22, 15]), 210.0, "outside the box");
    assert_eq!(parent(&document, [20, 22, 15]), 210.0, "on its face, which is seen from outside");
    assert_eq!(parent(&document, [21, 22, 15]), 200.0, "what the box stands for is painted in the box");
    // Samples of the box along x from the face on, over which the parent's stroke goes over into the box's.
    let along: Vec<f64> = (0..6).map(|i| fine(&document, [i, 32, 20]) - 200.0).collect();
    assert!((along[0] - 10.0).abs() < 0.01, "the face has what the parent has: {along:?}");
    assert!(along.iter().all(|v| (5.0 - 0.01..=10.01).contains(v)) && (along[2] - 10.0).abs() < 0.01, "{along:?}");
    assert_eq!(fine(&document, [4 * 7, 32, 20]), 200.0, "beyond the brush");
    does(&mut document, json!({"history": {"undo": {}}}));
    assert_eq!((parent(&document, [17, 22, 15]), fine(&document, [3, 32, 20])), (200.0, 200.0), "one step");
    // In the box alone it fades at the faces, where nothing is painted beyond.
    click(&mut document, [20.0, 22.0, 15.0], Some(1));
    let along: Vec<f64> = (0..6).map(|i| fine(&document, [i, 32, 20]) - 200.0).collect();
    for (found, expected) in along.iter().zip([0.0, 5.0, 10.0, 10.0, 10.0, 10.0]) {
        assert!((found - expected).abs() < 0.01, "{along:?}");
    }
    does(&mut document, json!({"history": {"undo": {}}}));
    click(&mut document, [24.0, 22.0, 15.0], Some(1));
    assert_eq!((parent(&document, [24, 22, 15]), parent(&document, [19, 22, 15])), (200.0, 200.0));
    assert_eq!(fine(&document, [16, 32, 20]), 210.0, "the sub-volume alone");
    does(&mut document, json!({"volume": {"set": {"volume": 1, "visible": false}}}));
    click(&mut document, [24.0, 22.0, 15.0], Some(0));
    assert_eq!(parent(&document, [24, 22, 15]), 210.0, "what is seen is painted: a hidden box stands for nothing");
}

#[test]
fn a_stroke_in_the_3d_view_meets_the_box_that_is_seen_there() {
    for scale in [1, 8] {
        let Some(mut document) = boxed(scale) else { return };
        // The surface at 31.25 lies in the box.
        for command in [
            json!({"view": {"look": {"mode": {"iso": 150}}}}),
            json!({"view": {"size": {"view": "3d", "size": [200, 200]}}}),
            json!({"view": {"frame": {"from": [0, 0, 1]}}}),
        ] {
            does(&mut document, command);
        }
        does(&mut document, json!({"sub_volume": {"set": {"volume": 1, "hi": [36, 30, 36]}}}));
        brush(&mut document, json!({"target": {"colour": [1, 0, 0, 1]}, "falloff": "hard", "radius_mm": 0.8}));
        let camera = document.state().unwrap().scene.views.camera;
        let px = |x: f64| {
            let (px, _) = camera.project(DVec3::new(x, 22.0, 31.25), [200, 200]).unwrap();
            json!({"at": {"pixel": {"view": "3d", "px": [px.x, px.y]}}})
        };
        let stroke = json!({"stroke": {"paint": {"points": [px(24.0), px(32.0)]}}});
        let said = does(&mut document, stroke);
        assert_eq!(said["missed"], json!(0), "{said}");
        let painted = |x: u32| value(&document, 1, FieldKind::Colour, [(x - 20) * scale, 8 * scale, 21 * scale]);
        assert!((24..=32).all(|x| painted(x) > 0.0), "{scale}: {:?}", (24..=32).map(painted).collect::<Vec<_>>());
    }
}

#[test]
fn baking_adds_the_mean_of_what_was_edited_over_each_cell_and_leaves_the_rest_to_the_bit() {
    for scale in [2, 3, 4] {
        let Some(mut document) = boxed(scale) else { return };
        brush(
            &mut document,
            json!({"target": {"density": 40}, "operation": "add", "falloff": "smooth", "radius_mm": 5}),
        );
        click(&mut document, [27.3, 21.6, 15.2], Some(1));
        brush(
            &mut document,
            json!({"target": {"selection": 1}, "operation": "replace", "falloff": "hard", "radius_mm": 3}),
        );
        click(&mut document, [30.0, 24.0, 14.0], Some(1));
        let state = document.state().unwrap();
        let (parent, fine) = (state.volumes[&VolumeId(0)].clone(), state.volumes[&VolumeId(1)].clone());
        let dims = fine.grid().dims;
        // By the cell: what was added, sample by sample; 200 lies everywhere in the box, nothing is selected.
        let mut cells: BTreeMap<[u32; 3], [f64; 2]> = BTreeMap::new();
        let s = f64::from(scale);
        for z in 0..dims[2] {
            for y in 0..dims[1] {
                for x in 0..dims[0] {
                    let added = fine.density.number([x, y, z]).unwrap().to_f64() - 200.0;
                    let selected = f64::from(fine.selection.texel([x, y, z]).unwrap()[0]);
                    if added == 0.0 && selected == 0.0 {
                        continue;
                    }
                    let places = [x, y, z].map(|i| f64::from(i) / s);
                    for voxel in crate::common::volumes::each([3; 3], |o| o) {
                        let cell: [f64; 3] = std::array::from_fn(|a| places[a].floor() - 1.0 + f64::from(voxel[a]));
                        let mut weight = 1.0 / s.powi(3);
                        for a in 0..3 {
                            let off = (places[a] - cell[a]).abs();
                            weight *= if (off - 0.5).abs() < 1e-9 { 0.5 } else { f64::from(u8::from(off < 0.5)) };
                        }
                        if weight > 0.0 {
                            let at = std::array::from_fn(|a| LO[a] + cell[a] as u32);
                            let sums = cells.entry(at).or_default();
                            sums[0] += weight * added;
                            sums[1] += weight * selected;
                        }
                    }
                }
            }
        }
        does(&mut document, json!({"sub_volume": {"bake": {"volume": 1}}}));
        let mut changed = 0;
        for voxel in crate::common::volumes::each(parent.grid().dims, |v| v) {
            let [added, selected] = cells.get(&voxel).copied().unwrap_or_default();
            let baked = &document.state().unwrap().volumes[&VolumeId(0)];
            if added == 0.0 {
                assert_eq!(baked.density.number(voxel).unwrap(), parent.density.number(voxel).unwrap(), "{voxel:?}");
            } else {
                changed += 1;
                let found =
                    baked.density.number(voxel).unwrap().to_f64() - parent.density.number(voxel).unwrap().to_f64();
                assert!((found - added).abs() < 0.01, "{scale}× {voxel:?}: {found}, {added} expected");
            }
            let code = f64::from(baked.selection.texel(voxel).unwrap()[0]);
            assert!((code - selected).abs() <= 0.51, "{scale}× {voxel:?}: selected {code}, {selected} expected");
        }
        assert!(changed > 200);
        does(&mut document, json!({"history": {"undo": {}}}));
        let back = &document.state().unwrap().volumes[&VolumeId(0)];
        assert!(back.density.edits().is_empty() && back.selection.edits().is_empty());
    }
}

/// Mean distance from the ball's surface of the places where the selection crosses ½ between neighbouring samples, in voxels of the
/// parent, and how far the selected volume is off, as a share.
fn nearness(selection: &Field, scale: u32, centre: [f64; 3], radius: f64) -> (f64, f64) {
    let dims = selection.dims(0);
    let texels = selection.read(0, [0; 3], dims).unwrap();
    let at = |v: [u32; 3]| texels[(v[0] + dims[0] * (v[1] + dims[1] * v[2])) as usize];
    let s = f64::from(scale);
    let off = |p: [f64; 3]| (0..3).map(|a| (p[a] / s - centre[a]).powi(2)).sum::<f64>().sqrt() - radius;
    let (mut sum, mut count, mut inside) = (0.0, 0.0, 0.0);
    for v in crate::common::volumes::each(dims.map(|d| d - 1), |v| v) {
        inside += f64::from(u8::from(at(v) >= 128));
        for axis in 0..3 {
            let mut next = v;
            next[axis] += 1;
            let (a, b) = (f64::from(at(v)) - 127.5, f64::from(at(next)) - 127.5);
            if (a > 0.0) != (b > 0.0) {
                let mut p = v.map(f64::from);
                p[axis] += a / (a - b);
                sum += off(p).abs();
                count += 1.0;
            }
        }
    }
    let volume = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    (sum / count, inside / s.powi(3) / volume - 1.0)
}

#[test]
fn what_is_painted_comes_nearer_to_what_was_meant_the_finer_it_is() {
    for (radius, centre) in
        [(2.3, [14.0, 14.0, 14.0]), (2.3, [14.31, 13.83, 14.43]), (7.7, [14.0; 3]), (7.7, [14.31, 13.83, 14.43])]
    {
        for (scale, most) in [(1, 0.2), (2, 0.1), (4, 0.05), (8, 0.025)] {
            let Some(mut document) = made(Voxels::U8(vec![100; 29 * 29 * 29]), [29; 3], DVec3::ONE) else { return };
            does(&mut document, json!({"sub_volume": {"add": {"lo": [3, 3, 3], "hi": [25, 25, 25], "scale": scale}}}));
            brush(&mut document, json!({"target": {"selection": 1}, "falloff": "hard", "radius_mm": radius}));
            click(&mut document, centre, Some(1));
            let selection = &document.state().unwrap().volumes[&VolumeId(1)].selection;
            let within: [f64; 3] = std::array::from_fn(|a| centre[a] - 3.0);
            let (distance, volume) = nearness(selection, scale, within, radius);
            println!("radius {radius} at {centre:?}, {scale}×: {distance:.4} voxels, volume {:+.2} %", volume * 100.0);
            assert!(distance <= most, "radius {radius}, {scale}×: {distance}");
            assert!(scale < 8 || volume.abs() <= 0.01, "radius {radius}, {scale}×: {volume}");
        }
    }
}

#[test]
fn weak_strokes_add_up_in_a_sub_volume_as_they_do_elsewhere() {
    let Some(mut document) = boxed(2) else { return };
    brush(&mut document, json!({"target": {"density": 0.1}, "operation": "add", "falloff": "hard", "radius_mm": 1}));
    for _ in 0..1000 {
        click(&mut document, [28.0, 22.0, 15.0], Some(1));
    }
    let risen = value(&document, 1, FieldKind::Density, [16, 16, 10]) - 200.0;
    assert!((risen - 100.0).abs() <= 2.0, "{risen}");
}

#[test]
fn a_stroke_in_a_box_costs_the_volume_about_it_nothing() {
    if crate::common::gpu::gpu().is_none() {
        return;
    }
    // Both go from 0 to 255: what is added needs other codes wherever it is added.
    let (grid, read) = (Grid::aligned([96; 3], DVec3::ONE, DVec3::ZERO), Arc::new(AtomicU64::new(0)));
    let voxels: Vec<u8> = (0..96_u32.pow(3)).map(|i| (i % 96 * 255 / 95) as u8).collect();
    let memory = MemorySource::new("counted", grid, Voxels::U8(voxels), (1.0, 0.0)).unwrap();
    let counts = read.clone();
    let source = Arc::new(Watched(memory, move |_, size: [u32; 3]| {
        counts.fetch_add(size.iter().map(|&s| u64::from(s)).product(), Ordering::Relaxed);
        Ok(())
    }));
    let statistics = burin::io::statistics(source.as_ref(), &|_| true).unwrap();
    let histogram = Histogram { min: -0.5, max: 255.5, bins: vec![1; 4], ..Histogram::default() };
    let origin = Origin { path: "counted.nrrd".into(), component: 0, frame: 0 };
    let mut document = Document::new();
    document.adopt(State::new(source, origin, statistics, histogram, None, &|_| true).unwrap());
    does(&mut document, json!({"sub_volume": {"add": {"lo": [30, 30, 30], "hi": [62, 62, 62], "scale": 2}}}));
    brush(&mut document, json!({"target": {"density": 60.0}, "operation": "add", "radius_mm": 4, "falloff": "smooth"}));
    let map = |document: &Document, id: u32| *document.state().unwrap().volumes[&VolumeId(id)].density.map();
    let before = map(&document, 0);
    click(&mut document, [46.0; 3], None);
    assert_ne!(map(&document, 1), before, "the box holds what was added");
    assert_eq!(map(&document, 0), before);
    read.store(0, Ordering::Relaxed);
    click(&mut document, [47.0, 46.0, 46.0], None);
    let again = read.load(Ordering::Relaxed);
    assert!(again < 96_u64.pow(3) / 8, "{again} voxels of {} read for a click in the box", 96_u64.pow(3));
    // Over its face the volume about it is painted too, and has room for that.
    let at = |document: &Document| value(document, 0, FieldKind::Density, [93, 46, 46]);
    let old = at(&document);
    click(&mut document, [93.0, 46.0, 46.0], None);
    assert!((at(&document) - old - 60.0).abs() < 0.1 && map(&document, 0) != before);
}
