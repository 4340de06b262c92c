//! A coarse picture on the CPU that says which parts hide the selection: the measuring callback of these tests.

use burin::explode::{Explosion, Measured};
use burin::math::{Camera, DVec2, DVec3, Plane, Pose};
use rayon::prelude::*;

/// Extinction per mm of the selection and of the background at a world point at rest.
pub type Matter<'a> = dyn Fn(DVec3) -> (f64, f64) + Sync + 'a;

/// A pixel shows the selection where the selection alone reaches opacity ½; it is visible if what the parts put before that
/// has less than 5 % opacity. A hidden pixel is laid to every part that alone has 5 %, or else to the densest.
pub fn measure(
    explosion: &Explosion,
    poses: &[Pose],
    camera: &Camera,
    px: u32,
    step: f64,
    matter: &Matter,
) -> Measured {
    let all = explosion.parts.iter().flat_map(|p| p.vertices.iter().copied());
    let bounds = burin::math::Aabb::around(all).unwrap();
    let far = (camera.eye - bounds.centre()).length() + 4.0 * bounds.half_diagonal();
    let planes: Vec<Vec<Plane>> = explosion.parts.iter().map(|p| p.faces.iter().map(|f| f.plane).collect()).collect();
    let pixels: Vec<Option<(bool, Vec<bool>)>> = (0..px * px)
        .into_par_iter()
        .map(|i| {
            let ray = camera.ray(DVec2::new(f64::from(i % px) + 0.5, f64::from(i / px) + 0.5), [px, px]);
            let (t0, t1) = ray.clip(&bounds.planes(), 0.0, far)?;
            let (mut depth, mut hit) = (0.0, None);
            for k in (t0 / step).ceil() as u64..(t1 / step).ceil() as u64 {
                depth += matter(ray.at(k as f64 * step)).0 * step;
                if depth >= std::f64::consts::LN_2 {
                    hit = Some(k as f64 * step);
                    break;
                }
            }
            let hit = hit?;
            let before: Vec<f64> = planes
                .iter()
                .zip(poses)
                .zip(&explosion.parts)
                .map(|((planes, pose), part)| {
                    let rest = pose.unapply_ray(&ray);
                    let Some((t0, t1)) = rest.clip(planes, 0.0, hit).filter(|_| part.visible) else { return 0.0 };
                    let steps = (t0 / step).ceil() as u64..(t1 / step).ceil() as u64;
                    steps.map(|k| matter(rest.at(k as f64 * step)).1 * step).sum()
                })
                .collect();
            let five = -(0.95_f64.ln());
            let hidden = before.iter().sum::<f64>() >= five;
            let most = before.iter().copied().fold(0.0, f64::max);
            Some((hidden, before.iter().map(|&b| hidden && b >= five.min(most)).collect()))
        })
        .collect();
    let shown: Vec<_> = pixels.into_iter().flatten().collect();
    let count = shown.len().max(1) as f64;
    let share = |i: usize| shown.iter().filter(|(_, by)| by[i]).count() as f64 / count;
    Measured {
        visible: if shown.is_empty() { 1.0 } else { shown.iter().filter(|(hidden, _)| !hidden).count() as f64 / count },
        hidden: (0..explosion.parts.len()).map(share).collect(),
    }
}

/// The 26 directions of a cube's faces, edges and corners.
pub fn directions() -> Vec<DVec3> {
    let at = |i: i32| f64::from(i % 3 - 1);
    (0..27).map(|i| DVec3::new(at(i), at(i / 3), at(i / 9))).filter(|d| *d != DVec3::ZERO).collect()
}
