//! Documents over any voxels, opened from a file, and what their values are by the definition of each type.

use super::maker::run;
use crate::io::files::{Nifti, keep};
use burin::document::Document;
use burin::volume::Voxels;
use serde_json::{Value, json};

/// Voxels with how their file keeps them.
#[derive(Clone)]
pub struct Data {
    pub voxels: Voxels,
    pub dims: [u32; 3],
    pub big: bool,
    /// Slope and intercept; slope 0 is none.
    pub scaling: [f32; 2],
}

impl Data {
    pub fn new(voxels: Voxels, dims: [u32; 3]) -> Self {
        Self { voxels, dims, big: false, scaling: [0.0, 0.0] }
    }

    /// The file's bytes: NIfTI-1, which holds every type, both byte orders and a scaling.
    pub fn file(&self) -> Vec<u8> {
        let mut header = Nifti::new(self.voxels.voxel_type(), &self.dims.map(|d| d as i16), self.big);
        header.f32s(112, &self.scaling).i16(252, 1);
        header.with(&self.voxels)
    }

    /// A document that opened it, and the answer.
    pub fn open(&self, extra: Value) -> (Document, Value) {
        let folder = tempfile::tempdir().unwrap();
        let mut open = json!({ "path": keep(&folder, "v.nii", &self.file()) });
        open.as_object_mut().unwrap().extend(extra.as_object().unwrap().clone());
        let mut document = Document::new();
        let answer = run(&mut document, &json!({"volume":{"open":open}}).to_string()).unwrap();
        // The file stays readable through its open handle.
        (document, answer)
    }

    fn is_scaled(&self) -> bool {
        self.scaling[0] != 0.0 && self.scaling != [1.0, 0.0]
    }

    /// A voxel's value as a 64-bit float.
    pub fn value(&self, i: usize) -> f64 {
        let [slope, intercept] = self.scaling.map(f64::from);
        let stored = self.voxels.get(i);
        if self.is_scaled() { stored * slope + intercept } else { stored }
    }

    /// A voxel's value as JSON has it.
    pub fn said(&self, i: usize) -> Value {
        match &self.voxels {
            _ if self.is_scaled() => said(self.value(i)),
            Voxels::U8(v) => json!(v[i]),
            Voxels::I8(v) => json!(v[i]),
            Voxels::U16(v) => json!(v[i]),
            Voxels::I16(v) => json!(v[i]),
            Voxels::U32(v) => json!(v[i]),
            Voxels::I32(v) => json!(v[i]),
            Voxels::U64(v) => json!(v[i]),
            Voxels::I64(v) => json!(v[i]),
            Voxels::F32(v) => said(f64::from(v[i])),
            Voxels::F64(v) => said(v[i]),
        }
    }

    pub fn place(&self, i: usize) -> [u32; 3] {
        let [nx, ny, _] = self.dims.map(|d| d as usize);
        [i % nx, i / nx % ny, i / (nx * ny)].map(|v| v as u32)
    }
}

/// A float as JSON has it.
pub fn said(x: f64) -> Value {
    match x {
        _ if x.is_nan() => json!("nan"),
        f64::INFINITY => json!("inf"),
        f64::NEG_INFINITY => json!("-inf"),
        _ => json!(x),
    }
}

pub fn ask(document: &mut Document, question: &Value) -> Value {
    run(document, &json!({ "ask": question }).to_string()).unwrap()
}

/// `ask.voxel` at an index.
pub fn voxel(document: &mut Document, at: [u32; 3]) -> Value {
    ask(document, &json!({"voxel":{"at":{"index":at}}}))
}

/// Its density.
pub fn density(document: &mut Document, at: [u32; 3]) -> Value {
    voxel(document, at)["density"].take()
}
