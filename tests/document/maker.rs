//! Small documents without a GPU.

use crate::common::one::{One, segments};
use burin::document::{Command, Document, DocumentError, Origin, State};
use burin::math::{DAffine3, DMat3, DVec3};
use burin::volume::*;
use serde_json::Value;
use std::sync::Arc;

/// An oblique, anisotropic grid of 70 × 40 × 33 voxels; value = 3x + 5y + 7z.
pub fn state() -> State {
    let dims = [70, 40, 33];
    let turn = DMat3::from_rotation_z(0.2) * DMat3::from_diagonal(DVec3::new(1.0, 1.5, 2.0));
    let grid =
        Grid { dims, world_from_index: DAffine3 { matrix3: turn, translation: DVec3::new(-30.0, -20.0, -35.0) } };
    let mut voxels = Vec::new();
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                voxels.push((3 * x + 5 * y + 7 * z) as u16);
            }
        }
    }
    let max = f64::from(*voxels.iter().max().unwrap());
    let sum = voxels.iter().map(|&v| f64::from(v)).sum();
    let mut bins = vec![0; 256];
    for &v in &voxels {
        bins[((f64::from(v) / max * 256.0) as usize).min(255)] += 1;
    }
    let source = Arc::new(MemorySource::new("ramp", grid, Voxels::U16(voxels), (1.0, 0.0)).unwrap());
    let statistics = Statistics { min: 0.0, max, sum, nan_count: 0, ..Statistics::default() };
    let origin = Origin { path: "ramp.nrrd".into(), component: 0, frame: 0 };
    State::new(source, origin, statistics, Histogram { min: 0.0, max, bins, ..Histogram::default() }, None, &|_| true)
        .unwrap()
}

/// The same with labels 1 and 2 painted across brick borders.
pub fn labelled() -> Document {
    let mut state = state();
    let changes = [(0, 1_u16), (1, 2)].map(|(x, id)| {
        let mut texels = vec![0; BRICK_VOXELS * 2];
        for texel in texels.chunks_exact_mut(2).skip(3).step_by(5) {
            texel.copy_from_slice(&id.to_le_bytes());
        }
        (BrickIndex([x, 0, 0]), Some(Brick::from_texels(texels, 2)))
    });
    state.one_mut().labels.swap(changes.to_vec()).unwrap();
    segments(&mut state.scene).ensure(1);
    segments(&mut state.scene).ensure(2);
    let mut document = Document::new();
    document.adopt(state);
    document
}

/// Does a command given as JSON.
pub fn run(document: &mut Document, line: &str) -> Result<Value, DocumentError> {
    let command: Command = serde_json::from_str(line).unwrap_or_else(|e| panic!("{line}: {e}"));
    Ok(document.apply(command)?.to_json().unwrap())
}

/// Every byte that undo answers for: fields at every level, and the scene but for its tools.
pub fn bytes(document: &Document) -> (Vec<Vec<u8>>, String) {
    let state = document.state().unwrap();
    let mut all = Vec::new();
    for kind in FieldKind::ALL {
        let field = state.one().field(kind);
        for level in 0..field.level_count() {
            all.push(field.read(level, [0; 3], field.dims(level)).unwrap());
        }
        all.push(format!("{:?} {:?}", field.map(), field.edits().keys()).into_bytes());
    }
    let mut scene = state.scene.clone();
    scene.views = burin::document::Views::new(state.one().grid()).into();
    scene.brush = burin::paint::Brush::default().into();
    (all, serde_json::to_string(&scene).unwrap())
}

/// The same without what `view.back` answers for.
pub fn undone(document: &Document) -> (Vec<Vec<u8>>, String) {
    let (fields, _) = bytes(document);
    let scene = &document.state().unwrap().scene;
    (fields, serde_json::to_string(&(&scene.segments(), &scene.explosion)).unwrap())
}

/// Writes 32-bit floats to an attached, raw NRRD.
pub fn write_nrrd(path: &std::path::Path, grid: &Grid, value: impl Fn([u32; 3]) -> f32) {
    let m = grid.world_from_index;
    let row = |v: DVec3| format!("({:?},{:?},{:?})", v.x, v.y, v.z);
    let [nx, ny, nz] = grid.dims;
    let mut bytes = format!(
        "NRRD0004\ntype: float\ndimension: 3\nspace: right-anterior-superior\nsizes: {nx} {ny} {nz}\n\
         space directions: {} {} {}\nspace origin: {}\nendian: little\nencoding: raw\n\n",
        row(m.matrix3.x_axis),
        row(m.matrix3.y_axis),
        row(m.matrix3.z_axis),
        row(m.translation)
    )
    .into_bytes();
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                bytes.extend_from_slice(&value([x, y, z]).to_le_bytes());
            }
        }
    }
    std::fs::write(path, bytes).unwrap();
}
