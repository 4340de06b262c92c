//! Documents of n³ voxels, and commands to them.

use super::head::Failure;
use burin::document::{Document, Origin, State};
use burin::math::DVec3;
use burin::volume::{Grid, Histogram, MemorySource, Statistics, Value as _};
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;

/// A document of n³ bytes, no two bricks alike; its origin is a small file in `folder`.
pub fn document(n: u32, folder: &Path) -> Result<Document, Failure> {
    let mut noise = 1_u32;
    let byte = |i: u64| {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (i >> 9) as u8 ^ (noise >> 28) as u8
    };
    over((0..u64::from(n).pow(3)).map(byte).collect(), n, folder)
}

/// A document of these n³ bytes.
pub fn over(voxels: Vec<u8>, n: u32, folder: &Path) -> Result<Document, Failure> {
    let grid = Grid::aligned([n; 3], DVec3::ONE, DVec3::ZERO);
    let source = Arc::new(MemorySource::new("cube", grid, u8::wrap(voxels), (1.0, 0.0))?);
    let path = folder.join("origin");
    std::fs::write(&path, b"made in memory")?;
    let statistics = Statistics { min: 0.0, max: 255.0, ..Statistics::default() };
    let histogram = Histogram { min: 0.0, max: 255.0, bins: vec![1; 256], ..Histogram::default() };
    let origin = Origin { path, component: 0, frame: 0 };
    let mut document = Document::new();
    document.adopt(State::new(source, origin, statistics, histogram, None, &|_| true)?);
    Ok(document)
}

/// Does a command.
pub fn apply(document: &mut Document, command: Value) -> Result<Value, Failure> {
    Ok(document.apply(serde_json::from_value(command)?)?.to_json()?)
}

/// A stroke of 40 mm with a ball of 16 mm, `across` mm beside the middle of n³ voxels.
pub fn stroke(document: &mut Document, n: u32, target: Value, across: f64) -> Result<Value, Failure> {
    apply(document, serde_json::json!({"brush": {"set": {"radius_mm": 16.0, "falloff": "smooth", "target": target}}}))?;
    let c = f64::from(n) / 2.0;
    let points = [[c - 20.0, c + across, c], [c + 20.0, c + across, c]].map(|at| serde_json::json!({"at": {"mm": at}}));
    apply(document, serde_json::json!({"stroke": {"paint": {"points": points}}}))
}
