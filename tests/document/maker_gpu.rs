//! A block of matter in clear space, and a document that can paint it; nothing where there is no GPU and that is known.

use super::maker::run;
use crate::common::one::One;
use burin::document::{Document, Origin, State};
use burin::math::DVec3;
use burin::volume::*;
use std::sync::Arc;

/// 64 × 48 × 40 voxels of 1 mm, the first at the origin; 200 in the block 8..56 × 8..40 × 8..32, 0 about it.
pub fn block() -> Option<Document> {
    crate::common::gpu::gpu()?;
    let mut document = Document::new();
    let dims = [64, 48, 40];
    let grid = Grid::aligned(dims, DVec3::ONE, DVec3::ZERO);
    let mut voxels = Vec::new();
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                let inside = (8..56).contains(&x) && (8..40).contains(&y) && (8..32).contains(&z);
                voxels.push(if inside { 200_u8 } else { 0 });
            }
        }
    }
    let inside = 48 * 32 * 24_u64;
    let mut bins = vec![0; 201];
    bins[0] = grid.voxel_count() - inside;
    bins[200] = inside;
    let statistics =
        Statistics { min: 0.0, max: 200.0, sum: 200.0 * inside as f64, nan_count: 0, ..Statistics::default() };
    let source = Arc::new(MemorySource::new("block", grid, Voxels::U8(voxels), (1.0, 0.0)).unwrap());
    let origin = Origin { path: "block.nrrd".into(), component: 0, frame: 0 };
    let histogram = Histogram { min: -0.5, max: 200.5, bins, ..Histogram::default() };
    document.adopt(State::new(source, origin, statistics, histogram, None, &|_| true).unwrap());
    let opaque =
        r#"{"transfer":{"set":{"function":{"colour":[[0,[1,0.8,0.6]]],"opacity":[[90,0],[110,0.9]],"unit_mm":1}}}}"#;
    run(&mut document, opaque).unwrap();
    run(&mut document, r#"{"view":{"size":{"view":"3d","size":[96,96]}}}"#).unwrap();
    Some(document)
}

/// A document over voxels that are made here.
pub fn made(voxels: Voxels, dims: [u32; 3], spacing: DVec3) -> Option<Document> {
    crate::common::gpu::gpu()?;
    let mut document = Document::new();
    let grid = Grid::aligned(dims, spacing, DVec3::ZERO);
    let source = Arc::new(MemorySource::new("made", grid, voxels, (1.0, 0.0)).unwrap());
    let statistics = burin::io::statistics(source.as_ref(), &|_| true).unwrap();
    let histogram =
        Histogram { min: statistics.min - 0.5, max: statistics.max + 0.5, bins: vec![1; 4], ..Histogram::default() };
    let origin = Origin { path: "made.nrrd".into(), component: 0, frame: 0 };
    document.adopt(State::new(source, origin, statistics, histogram, None, &|_| true).unwrap());
    Some(document)
}

/// The voxels of a label, x fastest.
pub fn labelled(document: &Document, label: u16) -> Vec<[u32; 3]> {
    let field = document.state().unwrap().one().field(FieldKind::Labels);
    let dims = field.dims(0);
    let texels = field.read(0, [0; 3], dims).unwrap();
    let at = |i: usize| {
        let i = i as u32;
        [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])]
    };
    let texels = texels.chunks_exact(2).enumerate();
    texels.filter(|(_, t)| **t == label.to_le_bytes()).map(|(i, _)| at(i)).collect()
}

/// Cuts the block into 8 along its middle planes.
pub fn cut(document: &mut Document) {
    for normal in ["[1,0,0]", "[0,1,0]", "[0,0,1]"] {
        let line =
            format!(r#"{{"part":{{"split":{{"by":{{"plane":{{"point":[31.5,23.5,19.5],"normal":{normal}}}}}}}}}}}"#);
        run(document, &line).unwrap();
    }
}

/// Paints a ball of selection into the middle.
pub fn select(document: &mut Document) {
    run(document, r#"{"brush":{"set":{"target":{"selection":1},"radius_mm":7,"falloff":"smooth"}}}"#).unwrap();
    run(document, r#"{"stroke":{"paint":{"points":[{"at":{"mm":[31,23,19]}}]}}}"#).unwrap();
}
