//! From perspective to orthographic and back, so that what lies at the target keeps its size in the picture.

use crate::math::{Camera, Projection};

/// The angle of view that a camera in perspective gets, degrees.
const FOV_Y_DEG: f64 = 30.0;

/// The camera with the other projection; the same camera if it has it already. Perspective moves the eye towards or away from the
/// target, so that the picture is as high there as the orthographic one was.
pub fn projected(camera: &Camera, orthographic: bool) -> Camera {
    let distance = camera.eye.distance(camera.target);
    match camera.projection {
        Projection::Perspective { fov_y_deg } if orthographic => {
            let height_mm = 2.0 * distance * (fov_y_deg.to_radians() * 0.5).tan();
            Camera { projection: Projection::Orthographic { height_mm }, ..*camera }
        }
        Projection::Orthographic { height_mm } if !orthographic => {
            let away = height_mm * 0.5 / (FOV_Y_DEG.to_radians() * 0.5).tan();
            let projection = Projection::Perspective { fov_y_deg: FOV_Y_DEG };
            Camera { eye: camera.target - camera.forward() * away, projection, ..*camera }
        }
        _ => *camera,
    }
}
