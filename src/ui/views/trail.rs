//! The stroke under the hand, drawn over the last picture of the 3D view until a picture shows its voxels.
//!
//! Where the surface that is seen lies within the brush of a sample's way it is tinted: the ball as it will be painted, as far as one
//! sees it. Owns the samples that no picture shows yet. Knows nothing of the document but which of its pictures is how new.

use crate::document::StrokeCommand;
use crate::interact::{PointerEvent, reach};
use crate::ui::style::theme;
use crate::ui::views::overlay::paint_colour;
use crate::ui::window::app::App;

/// Pixels of the 3D view between two looks along the way of a stroke, and most looks from one sample of the pointer to the next.
const LOOK_PX: f64 = 2.0;
const MOST_LOOKS: f64 = 400.0;

impl App {
    /// Lets the trail in the 3D view follow a stroke's command, where the pointer is there.
    pub(crate) fn follow_stroke(&mut self, stroke: &StrokeCommand, at: Option<PointerEvent>) {
        let (Some(scene), Some(open)) = (&self.scene, &self.snapshot.open) else { return };
        let serial = self.session.serial();
        match (stroke, at) {
            (StrokeCommand::Begin { .. }, Some(e)) => {
                let brush = &scene.brush;
                let colour = if brush.erase { theme::ERROR } else { paint_colour(brush.target, scene) };
                self.trail.begin(brush.radius_mm * reach(brush), open.grid.voxel_mm(), colour);
                self.trail.add(e.px, e.hit, serial);
            }
            (StrokeCommand::Extend { .. }, Some(e)) if self.trail.is_running() => {
                // The surface is followed all along the pointer's way, as the stroke will.
                let from = self.trail.px();
                let looks = (from.distance(e.px) / LOOK_PX).ceil().clamp(1.0, MOST_LOOKS);
                for i in 1..=looks as u32 {
                    let px = from.lerp(e.px, f64::from(i) / looks);
                    let hit = self.hit(px, e.size);
                    self.trail.add(px, hit, serial);
                }
            }
            (StrokeCommand::End {}, _) => self.trail.end(),
            (StrokeCommand::Cancel {}, _) => self.trail.clear(),
            _ => {}
        }
    }
}
