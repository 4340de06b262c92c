//! Many weak strokes add up to what they say together.

use super::maker::run;
use super::maker_gpu::made;
use burin::document::Document;
use burin::math::DVec3;
use burin::volume::{VolumeId, Voxels};
use serde_json::json;

#[test]
fn a_thousand_strokes_of_a_tenth_of_a_grey_level_raise_it_by_a_hundred() {
    // In the volume, and in a box of it that is twice as fine: which sample lies at (4, 4, 4), and one beyond the brush.
    for (volume, inside, outside) in [(0, [4; 3], [0; 3]), (1, [6; 3], [12; 3])] {
        for (voxels, allowed) in [(Voxels::U8(vec![40; 512]), 2.0), (Voxels::F32(vec![40.25; 512]), 0.1)] {
            let Some(mut document) = made(voxels, [8; 3], DVec3::ONE) else { return };
            if volume > 0 {
                let add = json!({"sub_volume":{"add":{"lo":[1,1,1],"hi":[7,7,7],"scale":2}}});
                run(&mut document, &add.to_string()).unwrap();
            }
            let value = |document: &Document, voxel| {
                let density = &document.state().unwrap().volumes[&VolumeId(volume)].density;
                f64::from(density.value(voxel).unwrap())
            };
            let before = value(&document, inside);
            let set = json!({"operation":"add","target":{"density":0.1},"falloff":"hard","radius_mm":2});
            run(&mut document, &json!({"brush":{"set":set}}).to_string()).unwrap();
            let paint = json!({"stroke":{"paint":{"points":[{"at":{"mm":[4,4,4]}}],"volume":volume}}}).to_string();
            for _ in 0..1000 {
                run(&mut document, &paint).unwrap();
            }
            let raised = value(&document, inside) - before;
            assert!((raised - 100.0).abs() <= allowed, "volume {volume}: {raised}");
            assert_eq!(value(&document, outside), before);
        }
    }
}
