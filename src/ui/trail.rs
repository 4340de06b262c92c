//! The stroke under the hand, drawn over the last picture of the 3D view until a picture shows its voxels.
//!
//! Where the surface that is seen lies within the brush of a sample's way it is tinted: the ball as it will be painted, as far as one
//! sees it. Owns the samples that no picture shows yet. Knows nothing of the document but which of its pictures is how new.

use crate::interact::Hit;
use crate::interact::surface::{Surface, near_way};
use crate::math::DVec2;
use egui::Color32;

/// Share of the radius within which a sample adds nothing to the one before.
const NEAR: f64 = 0.25;

/// One input point of the stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sample {
    /// What it hit; `None` where nothing was.
    hit: Option<Hit>,
    /// Of the command that carried it.
    serial: u64,
    /// Whether the way from the sample before is part of the stroke.
    joined: bool,
    /// A picture shows it: only the next way begins here.
    shown: bool,
}

/// See the module's head.
#[derive(Debug, Default)]
pub(super) struct Trail {
    samples: Vec<Sample>,
    /// Which of the surface's points are tinted; rebuilt with the picture.
    tinted: Vec<bool>,
    /// Samples that are in `tinted`.
    counted: usize,
    radius_mm: f64,
    /// A step beyond which nothing is painted between two samples.
    jump_mm: f64,
    /// Where the pointer was last.
    px: DVec2,
    colour: Color32,
    running: bool,
}

impl Trail {
    /// A stroke begins, with a brush that reaches so far on voxels of such a size.
    pub(super) fn begin(&mut self, radius_mm: f64, voxel_mm: f64, colour: Color32) {
        if radius_mm != self.radius_mm || colour != self.colour {
            self.clear();
        }
        self.jump_mm = 2.0 * (radius_mm + voxel_mm);
        (self.radius_mm, self.colour, self.running) = (radius_mm, colour, true);
        self.samples.push(Sample { hit: None, serial: 0, joined: false, shown: false });
    }

    /// The pointer passed this pixel of the 3D view, over this; `serial` is that of the command that says so.
    pub(super) fn add(&mut self, px: DVec2, hit: Option<Hit>, serial: u64) {
        self.px = px;
        let before = self.samples.last().and_then(|last| last.hit);
        let (joined, near) = match (before, hit) {
            (Some(a), Some(b)) => {
                let apart = a.world.distance(b.world);
                (a.part == b.part && apart <= self.jump_mm, apart < self.radius_mm * NEAR)
            }
            _ => (false, false),
        };
        // What the ball before covers but for a sliver is not worth a look at every point of the surface.
        if joined && near {
            return;
        }
        self.samples.push(Sample { hit, serial, joined, shown: false });
    }

    /// Where the pointer was last.
    pub(super) fn px(&self) -> DVec2 {
        self.px
    }

    /// Whether a stroke of the 3D view is under the hand.
    pub(super) fn is_running(&self) -> bool {
        self.running
    }

    /// The stroke has ended: what no picture shows yet stays.
    pub(super) fn end(&mut self) {
        self.running = false;
    }

    /// The stroke was taken back, or the picture is of something else.
    pub(super) fn clear(&mut self) {
        self.samples.clear();
        self.forget_surface();
        self.running = false;
    }

    /// A picture came that shows everything up to a command.
    pub(super) fn shown(&mut self, serial: u64) {
        let shown = self.samples.iter().take_while(|s| s.serial <= serial).count();
        // The last one shown is where the next way begins.
        self.samples.drain(..shown.saturating_sub(1));
        if let Some(first) = self.samples.first_mut().filter(|_| shown > 0) {
            first.shown = true;
        }
        self.forget_surface();
    }

    fn forget_surface(&mut self) {
        self.tinted.clear();
        self.counted = 0;
    }

    /// The colour and which points of the surface it lies on; `None` if there is nothing to draw.
    pub(super) fn tint(&mut self, surface: &Surface) -> Option<(Color32, &[bool])> {
        let seen = surface.seen();
        if self.samples.iter().all(|s| s.hit.is_none() || s.shown) || seen.is_empty() {
            return None;
        }
        if self.tinted.len() != seen.len() {
            self.forget_surface();
            self.tinted.resize(seen.len(), false);
        }
        for i in self.counted..self.samples.len() {
            let Some(to) = self.samples[i].hit.filter(|_| !self.samples[i].shown) else { continue };
            let from = if self.samples[i].joined { self.samples[i - 1].hit.unwrap_or(to) } else { to };
            for (tinted, seen) in self.tinted.iter_mut().zip(seen) {
                *tinted |= seen.is_some_and(|s| near_way(s.world, from.world, to.world, self.radius_mm));
            }
        }
        self.counted = self.samples.len();
        Some((self.colour, &self.tinted))
    }
}
