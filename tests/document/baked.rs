//! Baking boxes: each voxel of the parent gets the mean of what was edited in its cell, by volume; whatever its numbers are, all others keep
//! theirs to the last digit, in questions and in files.

use super::boxes::*;
use crate::common::volumes::each;
use burin::document::Document;
use burin::volume::*;
use serde_json::{Value, json};
use std::collections::BTreeMap;

type Numbers = fn(Vec<f64>) -> Voxels;

const KINDS: [(&str, Numbers); 5] = [
    ("u8", bytes_of),
    ("i16", |n| Voxels::I16(n.into_iter().map(|v| (v * 7.0) as i16 - 500).collect())),
    ("u16", |n| Voxels::U16(n.into_iter().map(|v| (v * 300.0) as u16).collect())),
    ("f32", |n| Voxels::F32(n.into_iter().map(|v| v as f32 * 0.37).collect())),
    ("f64", |n| Voxels::F64(n.into_iter().map(|v| v * 1.0e3 + 0.1).collect())),
];

const LO: [u32; 3] = [8, 7, 6];
const HI: [u32; 3] = [16, 15, 14];

fn volume(document: &Document, id: u32) -> Volume {
    document.state().unwrap().volumes[&VolumeId(id)].clone()
}

fn bake(id: u32) -> Value {
    json!({"sub_volume": {"bake": {"volume": id}}})
}

/// The share of sample j along an axis in the cell of voxel v, both counted from the box's first voxel: a whole one inside, a half on a face.
fn share(j: u32, v: i64, scale: u32) -> f64 {
    let off = (f64::from(j) / f64::from(scale) - v as f64).abs();
    let whole = 1.0 / f64::from(scale);
    // An axis at 1x has a sample a voxel.
    if (off - 0.5).abs() < 1e-9 {
        0.5 * whole
    } else if off < 0.5 {
        whole
    } else {
        0.0
    }
}

/// All texels of a field, as they are and without edits.
fn now_and_before(field: &Field) -> [Vec<[u8; 4]>; 2] {
    let (dims, bytes) = (field.dims(0), field.format().bytes());
    let padded = |texel: &[u8]| std::array::from_fn(|i| texel.get(i).copied().unwrap_or(0));
    let now: Vec<[u8; 4]> = field.read(0, [0; 3], dims).unwrap().chunks_exact(bytes).map(padded).collect();
    let mut was = now.clone();
    for index in field.edits().into_keys() {
        let (base, origin) = (field.base_brick(index).unwrap(), index.origin());
        for at in each(field.valid(0, index), |v| v) {
            let [x, y, z] = std::array::from_fn(|a| origin[a] + at[a]);
            was[(x + dims[0] * (y + dims[1] * z)) as usize] = base.texel(at, bytes);
        }
    }
    [now, was]
}

/// For each voxel of the parent in whose cell anything was edited: what `of` says of every edited sample, as it is and as it was, with its
/// share of the cell.
fn by_cell<T>(
    field: &Field,
    scale: u32,
    of: impl Fn(usize, [u8; 4], [u8; 4]) -> T,
) -> BTreeMap<[u32; 3], Vec<(f64, T)>> {
    let [now, was] = now_and_before(field);
    let mut cells: BTreeMap<[u32; 3], Vec<(f64, T)>> = BTreeMap::new();
    for (i, sample) in each(field.dims(0), |v| v).into_iter().enumerate().filter(|(i, _)| now[*i] != was[*i]) {
        for near in each([3; 3], |v| v) {
            let cell: [i64; 3] = std::array::from_fn(|a| i64::from(sample[a] / scale) + i64::from(near[a]) - 1);
            let weight: f64 = (0..3).map(|a| share(sample[a], cell[a], scale)).product();
            if weight > 0.0 {
                let voxel = std::array::from_fn(|a| (i64::from(LO[a]) + cell[a]) as u32);
                cells.entry(voxel).or_default().push((weight, of(i, now[i], was[i])));
            }
        }
    }
    cells
}

/// All values of a volume, as questions tell them.
fn numbers_of(volume: &Volume) -> Vec<Number> {
    let mut all = Vec::new();
    volume.density.values([0; 3], volume.grid().dims).unwrap().each(|_, number| all.push(number));
    all
}

#[test]
fn whatever_its_numbers_are_a_volume_gets_the_means_and_keeps_the_rest_to_the_last_digit() {
    for (name, numbers) in KINDS {
        for (scale, beyond) in [(3, true), (2, false)] {
            let mut document = noisy(numbers);
            // Painted here and there before, with fractions of a step.
            let step = document.state().unwrap().volumes[&VolumeId(0)].density.map().codes_per_unit.recip();
            let ends = volume(&document, 0).statistics;
            let span = ends.max - ends.min;
            paint(&mut document, 0, FieldKind::Density, |v| {
                (v[0] % 5 == 0).then_some(ends.min + span * noise(3, v) * 0.9 + 0.3 * step)
            });
            does(&mut document, add(LO, HI, scale));
            let most = if beyond { 3.0 } else { 0.4 };
            let fine = volume(&document, 1);
            let (own, dims) = (numbers_of(&fine), fine.grid().dims);
            paint(&mut document, 1, FieldKind::Density, |v| {
                let own = own[(v[0] + dims[0] * (v[1] + dims[1] * v[2])) as usize].to_f64();
                let far = (v[0] + v[1] + v[2]) % 3 == 0 && v[0] > scale && v[1] > scale;
                let new = own + span * most * noise(4, v);
                far.then_some(if beyond { new } else { new.min(ends.max) })
            });
            let (before, coarse, fine) = (everything(&document), volume(&document, 0), volume(&document, 1));
            let values = fine.density.values([0; 3], dims).unwrap();
            let painted: BTreeMap<usize, f64> = values.painted.iter().copied().collect();
            let added = |i: usize, _, _| painted.get(&i).map_or(0.0, |value| value - values.unpainted(i).to_f64());
            let cells = by_cell(&fine.density, scale, added);
            let exported = |document: &mut Document| {
                let folder = tempfile::tempdir().unwrap();
                let path = folder.path().join("exported.nrrd");
                does(document, json!({"volume": {"export": {"field": "density", "path": path, "volume": 0}}}));
                let source = burin::io::open(&path).unwrap().source(0, 0, &|_| true).unwrap();
                source.read([0; 3], source.grid().dims).unwrap()
            };
            let file_before = exported(&mut document);
            does(&mut document, bake(1));
            let file_after = exported(&mut document);
            let baked = volume(&document, 0);
            let [coarse, baked] = [numbers_of(&coarse), numbers_of(&baked)];
            assert!(cells.len() > 100, "{name} {scale}");
            let mut largest: f64 = 0.0;
            for (i, voxel) in each([40, 36, 34], |v| v).into_iter().enumerate() {
                let (was, is) = (coarse[i], baked[i]);
                match cells.get(&voxel) {
                    None => {
                        // Real numbers by their bits.
                        assert_eq!(format!("{is:?}"), format!("{was:?}"), "{name} {scale}x {voxel:?}");
                        assert_eq!(
                            file_after.get(i).to_bits(),
                            file_before.get(i).to_bits(),
                            "{name} {scale}x {voxel:?}"
                        );
                    }
                    Some(edits) => {
                        let expected = was.to_f64() + edits.iter().map(|(weight, added)| weight * added).sum::<f64>();
                        largest = largest.max(expected);
                        let near = step.max(expected.abs() * 1e-6) + ends.max.abs() * 1e-6;
                        assert!(
                            (is.to_f64() - expected).abs() <= near,
                            "{name} {scale}x {voxel:?}: {is:?}, {expected} expected"
                        );
                    }
                }
            }
            assert!(!beyond || largest > ends.max, "{name} {scale}x: beyond all that there was");
            undo(&mut document, 1);
            same(&everything(&document), &before, name);
        }
    }
}

#[test]
fn selections_colours_and_labels_are_baked_each_in_its_way() {
    for scale in [2, 3] {
        let mut document = noisy(bytes_of);
        paint_all(&mut document, 0, [11.0, 10.0, 9.0], 5.0);
        does(&mut document, add(LO, HI, scale));
        let of = f64::from(scale);
        paint_all(&mut document, 1, [4.0 * of, 3.5 * of, 3.6 * of], 2.4 * of);
        paint(&mut document, 1, FieldKind::Labels, |[x, y, z]| {
            let label = if x < 3 * scale { 2.0 } else { (noise(9, [x, y, z]) * 3.0).floor() };
            (y < 5 * scale && z < 6 * scale).then_some(label)
        });
        let (before, coarse, fine) = (everything(&document), volume(&document, 0), volume(&document, 1));
        does(&mut document, bake(1));
        let baked = volume(&document, 0);
        let selected = by_cell(&fine.selection, scale, |_, now, was| f64::from(now[0]) - f64::from(was[0]));
        // Amounts of paint: a colour times its alpha.
        let paint_of = |[r, g, b, a]: [u8; 4]| [r, g, b, 255].map(|c| f64::from(c) / 255.0 * f64::from(a) / 255.0);
        let coloured = by_cell(&fine.colour, scale, |_, now, was| {
            let (now, was) = (paint_of(now), paint_of(was));
            [0, 1, 2, 3].map(|c| now[c] - was[c])
        });
        let labelled = by_cell(&fine.labels, scale, |_, now, _| now[0]);
        let texels = |volume: &Volume| {
            [&volume.selection, &volume.colour, &volume.labels].map(|field| now_and_before(field)[0].clone())
        };
        let ([selection_was, colour_was, label_was], [selection, colour, label]) = (texels(&coarse), texels(&baked));
        let mut relabelled = 0;
        for (i, voxel) in each(baked.grid().dims, |v| v).into_iter().enumerate() {
            let own = f64::from(selection_was[i][0]);
            let sum: f64 = selected.get(&voxel).map_or(0.0, |edits| edits.iter().map(|(w, d)| w * d).sum());
            let found = f64::from(selection[i][0]);
            assert!((found - (own + sum).clamp(0.0, 255.0)).abs() <= 0.5 + 1e-9, "{scale}x selection {voxel:?}");

            let (was, is) = (colour_was[i], colour[i]);
            match coloured.get(&voxel) {
                None => assert_eq!(is, was, "{scale}x colour {voxel:?}"),
                Some(edits) => {
                    let (own, found) = (paint_of(was), paint_of(is));
                    let sums = [0, 1, 2, 3].map(|c| own[c] + edits.iter().map(|(w, d)| w * d[c]).sum::<f64>());
                    for c in 0..4 {
                        // There is no more of a colour than there is paint.
                        let expected = sums[c].min(sums[3]).clamp(0.0, 1.0);
                        let off = (found[c] - expected).abs();
                        assert!(off <= 1.1 / 255.0, "{scale}x colour {voxel:?}: {found:?} {expected}");
                    }
                }
            }

            // The most of the cell, of which what is not edited has the label of the voxel.
            let own = label_was[i][0];
            let mut weights = BTreeMap::from([(own, 1.0)]);
            for (weight, label) in labelled.get(&voxel).into_iter().flatten() {
                *weights.entry(own).or_insert(0.0) -= weight;
                *weights.entry(*label).or_insert(0.0) += weight;
            }
            let found = label[i][0];
            let most = weights.values().copied().fold(0.0, f64::max);
            assert!(weights[&found] >= most - 1e-9, "{scale}x label {voxel:?}: {found} of {weights:?}");
            assert!(found == own || weights[&own] < most, "{scale}x label {voxel:?}: {found} of {weights:?}");
            relabelled += u32::from(found != own);
        }
        assert!(relabelled > 20, "{scale}x: {relabelled}");
        undo(&mut document, 1);
        same(&everything(&document), &before, "undone");
    }
}

#[test]
fn nested_boxes_are_baked_one_into_the_other() {
    let mut document = noisy(bytes_of);
    does(&mut document, add(LO, HI, 2));
    does(&mut document, add([10, 9, 8], [14, 13, 12], 4));
    // All of a voxel of the volume, far from all faces: what is added comes down whole.
    let inner = volume(&document, 2);
    paint(&mut document, 2, FieldKind::Density, |v| {
        v.iter().all(|v| (6..=10).contains(v)).then(|| inner.density.number(v).unwrap().to_f64() + 16.0)
    });
    let before = everything(&document);
    let value = |document: &Document, id, v| volume(document, id).density.number(v).unwrap().to_f64();
    let (was_outer, was) = (value(&document, 1, [8, 8, 8]), value(&document, 0, [12, 11, 10]));
    does(&mut document, bake(2));
    let risen = value(&document, 1, [8, 8, 8]) - was_outer;
    assert!((risen - 16.0).abs() < 0.01, "{risen}: a sample of the outer one, all of whose cell was raised");
    assert_eq!(value(&document, 0, [12, 11, 10]), was, "not further down");
    does(&mut document, json!({"sub_volume": {"bake": {"volume": 1, "remove": true}}}));
    let risen = value(&document, 0, [12, 11, 10]) - was;
    // Of its cell a half was raised whole; of the two quarters at its ends, whose own cells reach beyond, three quarters.
    let along: f64 = 0.25 * 0.75 + 0.5 + 0.25 * 0.75;
    assert!((risen - 16.0 * along.powi(3)).abs() < 0.02, "{risen}");
    let state = document.state().unwrap();
    assert_eq!(state.scene.volumes.all[&VolumeId(2)].sub_volume.unwrap().parent, VolumeId(0), "the inner one stays");
    undo(&mut document, 2);
    same(&everything(&document), &before, "undone");
}

#[test]
fn a_box_beside_follows_what_is_baked_beyond_all_that_its_codes_can_say() {
    let mut document = noisy(bytes_of);
    does(&mut document, add(LO, HI, 2));
    does(&mut document, add([HI[0], LO[1], LO[2]], [HI[0] + 4, HI[1], HI[2]], 3));
    let fine = volume(&document, 1);
    paint(&mut document, 1, FieldKind::Density, |v| {
        (v[0] > 8).then(|| fine.density.number(v).unwrap().to_f64() + 600.0)
    });
    let before = everything(&document);
    does(&mut document, bake(1));
    let value = |id, v| volume(&document, id).density.number(v).unwrap().to_f64();
    let on_face = value(0, [HI[0], 11, 10]);
    assert!(on_face > 250.0, "{on_face}: half of its cell was raised by 600");
    let beside = value(2, [0, 12, 12]);
    assert!((beside - on_face).abs() < 0.01, "{beside} beside {on_face}");
    undo(&mut document, 1);
    same(&everything(&document), &before, "undone");
}
