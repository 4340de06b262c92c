//! Pictures with a focus: what lies in a ball as it is, what lies before and behind it as layers of their own opacity.
//!
//! Each is a picture in which rays keep one of their three pieces (`shaders/lib/layers.wgsl`, BALL). Where nothing shows before the ball
//! and nothing that could be seen behind it, the pixel is that of the plain picture, drawn by the very programs that know of no ball: it
//! does not change by a bit. What a pixel is said to show is what the plain picture shows there, so that a hand keeps to the surface
//! that it would meet. Two-level rendering is after Mroz and Hauser 2001 (RTVR), section 3.

use crate::gpu::cast::holes::bounds_of;
use crate::gpu::cast::solid::Polyhedron;
use crate::gpu::cast::tiles::Window;
use crate::gpu::device::constants::CLEAR_END;
use crate::gpu::device::error::GpuError;
use crate::gpu::picture::focus::{Context, Focus};
use crate::gpu::picture::frame::Frame;
use crate::gpu::picture::image::Image;
use crate::gpu::picture::layer::{Ball, Keeps};
use crate::math::Aabb;
use crate::volume::Mode;

/// A window of a picture with a focus; `draw` draws one without.
///
/// # Errors
/// Those of `draw`.
pub(crate) fn draw_focused(
    focus: &Focus,
    frame: &Frame,
    window: &Window,
    draw: &mut impl FnMut(&Frame, &Window) -> Result<Image, GpuError>,
) -> Result<Image, GpuError> {
    let plain = Frame { focus: None, ..frame.clone() };
    let context = of_context(focus, &plain);
    let mut image = draw(&kept(focus, &context, Keeps::Before), window)?;
    // A cube about it; its silhouette holds the ball's.
    let reach = Aabb { min: focus.centre - focus.radius_mm, max: focus.centre + focus.radius_mm };
    let cube = Polyhedron::hexahedron(&reach.corners());
    let through = match bounds_of([&cube], &frame.camera, window) {
        Some((around, [left, top])) => {
            let [right, bottom] = [left + around.size[0], top + around.size[1]];
            // By the rays of the whole window, to the last bit.
            let window = Window { only: Some([[left, top], [right, bottom]]), ..*window };
            let behind = draw(&kept(focus, &context, Keeps::Behind), &window)?;
            let inside = draw(&kept(focus, &plain, Keeps::Inside), &window)?;
            Some(([left, top, right, bottom], [inside, behind, draw(&plain, &window)?]))
        }
        None => None,
    };
    let width = window.size[0].max(1) as usize;
    for at in 0..image.colour.len() {
        let (x, y) = ((at % width) as u32, (at / width) as u32);
        let shown = match &through {
            Some(([left, top, right, bottom], [inside, behind, plain]))
                if (*left..*right).contains(&x) && (*top..*bottom).contains(&y) =>
            {
                (image.depth_mm[at], image.object[at]) = (plain.depth_mm[at], plain.object[at]);
                let layers = [image.colour[at], inside.colour[at], behind.colour[at]];
                laid(focus.opacity, layers).unwrap_or(plain.colour[at])
            }
            _ => image.colour[at].map(|c| c * focus.opacity),
        };
        image.colour[at] = shown;
    }
    Ok(image)
}

/// The layers of a ray laid together; `None` where nothing shows before the ball, and nothing behind it could.
fn laid(opacity: f32, [before, inside, behind]: [[f32; 4]; 3]) -> Option<[f32; 4]> {
    let shows_behind = behind[3] > 0.0 && 1.0 - inside[3] >= CLEAR_END;
    if before[3] == 0.0 && !shows_behind {
        return None;
    }
    let over = 1.0 - opacity * before[3];
    let past = if shows_behind { over * (1.0 - inside[3]) * opacity } else { 0.0 };
    Some(std::array::from_fn(|i| opacity * before[i] + over * inside[i] + past * behind[i]))
}

/// A picture of one piece of every ray.
fn kept(focus: &Focus, frame: &Frame, keeps: Keeps) -> Frame {
    let mut frame = frame.clone();
    let Focus { centre, radius_mm, context, .. } = *focus;
    let contour = context == Context::Contour && keeps != Keeps::Inside;
    frame.layers.ball = Some(Ball { centre, radius_mm, keeps, contour });
    frame
}

/// The picture that the context is taken from. Contours have their matter's colour, unlit; those of a maximum are those of the matter that
/// its table shows.
fn of_context(focus: &Focus, plain: &Frame) -> Frame {
    let mut frame = plain.clone();
    if focus.context == Context::Contour {
        let matter = |mode| if mode == Mode::Mip { Mode::Dvr } else { mode };
        (frame.refine, frame.lighting, frame.mode) = (false, None, matter(frame.mode));
        for look in &mut frame.looks {
            (look.lighting, look.mode) = (None, matter(look.mode));
        }
    }
    frame
}
