//! Sub-volumes of small documents without a GPU: commands, edits of any kind, all bytes of them, and what a crash leaves.

use super::maker::run;
use crate::common::volumes::each;
use burin::document::{Document, Origin, State};
use burin::math::{DAffine3, DMat3, DVec3};
use burin::volume::*;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub fn does(document: &mut Document, command: Value) -> Value {
    run(document, &command.to_string()).unwrap_or_else(|error| panic!("{command}: {error}"))
}

pub fn refusal(document: &mut Document, command: Value) -> String {
    match run(document, &command.to_string()) {
        Ok(said) => panic!("{command} was done: {said}"),
        Err(error) => error.to_string(),
    }
}

pub fn add(lo: [u32; 3], hi: [u32; 3], scale: impl Into<Value>) -> Value {
    json!({"sub_volume": {"add": {"lo": lo, "hi": hi, "scale": scale.into()}}})
}

pub fn undo(document: &mut Document, steps: u32) {
    does(document, json!({"history": {"undo": {"steps": steps}}}));
}

pub fn redo(document: &mut Document, steps: u32) {
    does(document, json!({"history": {"redo": {"steps": steps}}}));
}

/// A number that looks like none before it, 0 to 1.
pub fn noise(seed: u32, [x, y, z]: [u32; 3]) -> f64 {
    let mut n = x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77) ^ z.wrapping_mul(0xC2B2_AE3D) ^ seed;
    n = (n ^ (n >> 15)).wrapping_mul(0x2C1B_3C6D);
    n = (n ^ (n >> 12)).wrapping_mul(0x297A_2D39);
    f64::from(n ^ (n >> 15)) / f64::from(u32::MAX)
}

/// An oblique volume of 40 × 36 × 34 voxels of noise in these numbers.
pub fn noisy(of: impl Fn(Vec<f64>) -> Voxels) -> Document {
    let dims = [40, 36, 34];
    let turn = DMat3::from_rotation_z(0.2) * DMat3::from_diagonal(DVec3::new(1.0, 1.5, 2.0));
    let grid =
        Grid { dims, world_from_index: DAffine3 { matrix3: turn, translation: DVec3::new(-30.0, -20.0, -35.0) } };
    let source = MemorySource::new("noise", grid, of(each(dims, |v| (noise(1, v) * 200.0).round())), (1.0, 0.0));
    let source = Arc::new(source.unwrap());
    let statistics = burin::io::statistics(source.as_ref(), &|_| true).unwrap();
    let histogram = Histogram { min: -0.5, max: 200.5, bins: vec![1; 4], ..Histogram::default() };
    let origin = Origin { path: "noise.nrrd".into(), component: 0, frame: 0 };
    let mut document = Document::new();
    document.adopt(State::new(source, origin, statistics, histogram, None, &|_| true).unwrap());
    document
}

pub fn bytes_of(numbers: Vec<f64>) -> Voxels {
    Voxels::U8(numbers.into_iter().map(|v| v as u8).collect())
}

/// Paints texels, as no brush does: where `to` says one, at voxels of a volume. Forgets history.
pub fn paint(document: &mut Document, volume: u32, kind: FieldKind, to: impl Fn([u32; 3]) -> Option<f64>) {
    let mut state = document.state().unwrap().clone();
    let mut field = state.volumes[&VolumeId(volume)].field(kind).clone();
    let map = *field.map();
    let values: Vec<f64> = each(field.dims(0), &to).into_iter().flatten().collect();
    if kind == FieldKind::Density && values.iter().any(|v| *v < map.lo || *v > map.hi()) && map.format.bytes() == 2 {
        assert!(field.edits().is_empty(), "codes that have an end");
        field = field.unedited(map.in_floats(), &|_| true).unwrap().unwrap();
        state.volumes.get_mut(&VolumeId(volume)).unwrap().density = field.clone();
    }
    let bytes = field.format().bytes();
    let mut changes = Vec::new();
    for index in field.brick_indices(0) {
        let mut texels = field.brick(BrickKey { level: 0, index }).unwrap().to_texels(bytes);
        let mut some = false;
        for at in each(field.valid(0, index), |at| at) {
            let Some(value) = to(std::array::from_fn(|a| index.origin()[a] + at[a])) else { continue };
            let texel = match kind {
                FieldKind::Density => field.map().encode(value),
                FieldKind::Labels => [value as u8, 0, 0, 0],
                _ => [value as u8; 4],
            };
            let to = (at[0] + BRICK * (at[1] + BRICK * at[2])) as usize * bytes;
            texels[to..to + bytes].copy_from_slice(&texel[..bytes]);
            some = true;
        }
        if some {
            changes.push((index, Some(Brick::from_texels(texels, bytes))));
        }
    }
    state.volumes.get_mut(&VolumeId(volume)).unwrap().field_mut(kind).swap(changes).unwrap();
    document.adopt(state);
}

/// Edits something of every kind of a volume: texels of noise in a ball.
pub fn paint_all(document: &mut Document, volume: u32, centre: [f64; 3], radius: f64) {
    for (seed, kind) in (7..).zip(FieldKind::ALL) {
        paint(document, volume, kind, |v| {
            let off = (0..3).map(|a| (f64::from(v[a]) - centre[a]).powi(2)).sum::<f64>().sqrt();
            let value = noise(seed, v);
            (off <= radius).then_some(match kind {
                FieldKind::Density => value * 180.0,
                FieldKind::Labels => (value * 3.0).floor(),
                _ => (value * 255.0).round(),
            })
        });
    }
}

/// The texels of a volume at the finest level.
pub fn texels(document: &Document, volume: u32, kind: FieldKind) -> Vec<u8> {
    let field = document.state().unwrap().volumes[&VolumeId(volume)].field(kind);
    field.read(0, [0; 3], field.dims(0)).unwrap()
}

/// Every byte that was ever painted in all volumes, in what sub-volumes are computed from too, and what was decided about them: all that
/// the rest follows from.
pub fn everything(document: &Document) -> Vec<(String, Vec<u8>)> {
    let state = document.state().unwrap();
    let mut all = Vec::new();
    for (id, volume) in &state.volumes {
        let of = (volume.sub_box(), *volume.density.map(), volume.grid().dims);
        all.push((format!("{id} {of:?}"), Vec::new()));
        for kind in FieldKind::ALL {
            let field = volume.field(kind);
            for (index, brick) in field.edits() {
                all.push((format!("{id} {kind:?} {index:?}"), brick.to_texels(field.format().bytes())));
            }
        }
    }
    let volumes = serde_json::to_string(&state.scene.volumes.all).unwrap();
    all.push((format!("{:?} {volumes}", state.scene.shown.keys()), Vec::new()));
    all
}

/// The same with all texels of all levels, as pictures show them.
pub fn every_texel(document: &Document) -> Vec<(String, Vec<u8>)> {
    let mut all = everything(document);
    let volumes = &document.state().unwrap().volumes;
    for (id, volume) in volumes.iter().filter(|(id, _)| !id.is_of_before()) {
        for kind in FieldKind::ALL {
            let field = volume.field(kind);
            for level in 0..field.level_count() {
                let texels = field.read(level, [0; 3], field.dims(level)).unwrap();
                all.push((format!("{id} {kind:?} level {level}"), texels));
            }
        }
    }
    all
}

/// Fails where two documents, or one at two times, differ, and says where first.
pub fn same(found: &[(String, Vec<u8>)], expected: &[(String, Vec<u8>)], when: &str) {
    for (found, expected) in found.iter().zip(expected) {
        assert_eq!(found.0, expected.0, "{when}");
        let differing = found.1.iter().zip(&expected.1).filter(|(a, b)| a != b).count();
        assert!(found.1.len() == expected.1.len() && differing == 0, "{when}: {} in {differing} bytes", found.0);
    }
    assert_eq!(found.len(), expected.len(), "{when}");
}

/// What is found of a project whose program was killed.
pub fn killed(document: Document, project: &Path) -> (Document, PathBuf) {
    std::mem::forget(document);
    let copy = project.with_extension("found.burin");
    std::fs::remove_dir_all(&copy).ok();
    copy_folder(project, &copy);
    (opened(&copy), copy)
}

pub fn opened(project: &Path) -> Document {
    let mut document = Document::new();
    let said = does(&mut document, json!({"project": {"open": {"path": project}}}));
    assert!(said["warnings"].as_array().is_none_or(Vec::is_empty), "{said}");
    document
}

pub fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        let (from, to) = (entry.path(), to.join(entry.file_name()));
        if from.is_dir() {
            copy_folder(&from, &to);
        } else if entry.file_name() != "lock" {
            std::fs::copy(&from, &to).unwrap();
        }
    }
}
