//! Pictures while something moves.

use super::maker::run;
use burin::document::{Document, Origin, State, ViewName};
use burin::math::DVec3;
use burin::volume::*;
use std::sync::Arc;

#[test]
fn a_picture_in_motion_waits_for_few_bricks_and_at_rest_none_is_missing() {
    let mut document = Document::new();
    if let Err(reason) = document.describe_gpu() {
        crate::common::gpu::missing(reason);
        return;
    }
    // Matter in 80 bricks, every one painted in many colours: density of that size lies in place, paint does not.
    let dims = [640, 128, 32];
    let grid = Grid::aligned(dims, DVec3::ONE, DVec3::ZERO);
    let voxels = vec![200_u8; grid.voxel_count() as usize];
    let statistics = Statistics { min: 200.0, max: 200.0, sum: 0.0, nan_count: 0, ..Statistics::default() };
    let source = Arc::new(MemorySource::new("slab", grid, Voxels::U8(voxels), (1.0, 0.0)).unwrap());
    let origin = Origin { path: "slab.nrrd".into(), component: 0, frame: 0 };
    let histogram = Histogram { min: 0.0, max: 250.0, bins: vec![1; 256] };
    let mut state = State::new(source, origin, statistics, histogram, None, &|_| true).unwrap();
    let texels: Vec<u8> = (0..BRICK_VOXELS).flat_map(|i| [(i * 7 % 251) as u8, (i / 99) as u8, 0, 255]).collect();
    let changes = state.colour.brick_indices(0).into_iter().map(|b| (b, Some(Brick::from_texels(texels.clone(), 4))));
    state.colour.swap(changes.collect()).unwrap();
    document.adopt(state);
    let opaque =
        r#"{"transfer":{"set":{"function":{"colour":[[0,[1,1,1]]],"opacity":[[90,0],[110,0.9]],"unit_mm":1}}}}"#;
    run(&mut document, opaque).unwrap();
    run(&mut document, r#"{"view":{"size":{"view":"3d","size":[64,64]}}}"#).unwrap();
    let mut picture = |moving: bool| {
        document.set_motion(moving);
        let image = document.picture(ViewName::ThreeD, [64, 64], None).unwrap();
        (image.colour, document.is_pending())
    };
    let (rough, pending) = picture(true);
    assert!(pending && rough.iter().any(|c| c[3] > 0.0), "coarser bricks stand in");
    let (next, pending) = picture(true);
    assert!(!pending, "the rest comes with the next picture");
    let (rest, pending) = picture(false);
    assert!(!pending && rest == next && rest != rough);
}
