//! Many weak strokes add up to what they say together.

use super::maker::run;
use super::maker_gpu::made;
use crate::common::one::One;
use burin::math::DVec3;
use burin::volume::Voxels;
use serde_json::json;

#[test]
fn a_thousand_strokes_of_a_tenth_of_a_grey_level_raise_it_by_a_hundred() {
    for (voxels, allowed) in [(Voxels::U8(vec![40; 512]), 2.0), (Voxels::F32(vec![40.25; 512]), 0.1)] {
        let Some(mut document) = made(voxels, [8; 3], DVec3::ONE) else { return };
        let before = f64::from(document.state().unwrap().one().density.value([4; 3]).unwrap());
        let set = json!({"operation":"add","target":{"density":0.1},"falloff":"hard","radius_mm":2});
        run(&mut document, &json!({"brush":{"set":set}}).to_string()).unwrap();
        let stroke = json!({"stroke":{"paint":{"points":[{"at":{"index":[4,4,4]}}]}}}).to_string();
        for _ in 0..1000 {
            run(&mut document, &stroke).unwrap();
        }
        let density = &document.state().unwrap().one().density;
        let raised = f64::from(density.value([4; 3]).unwrap()) - before;
        assert!((raised - 100.0).abs() <= allowed, "{raised}");
        assert_eq!(f64::from(density.value([0; 3]).unwrap()), before);
    }
}
