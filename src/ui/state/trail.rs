//! The samples of the 3D stroke that no picture shows yet, and which points of the seen surface they tint.
//!
//! Knows nothing of the document but which of its pictures is how new.

use crate::interact::Hit;
use crate::interact::surface::Seen;
use crate::interact::surface::Surface;
use crate::interact::surface::near_way;
use crate::math::DVec2;
use crate::math::DVec3;
use egui::Color32;

/// Share of the radius within which a sample adds nothing to the one before.
pub(crate) const NEAR: f64 = 0.25;

/// One input point of the stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    /// What it hit; `None` where nothing was.
    pub(crate) hit: Option<Hit>,
    /// Of the command that carried it.
    pub(crate) serial: u64,
    /// Whether the way from the sample before is part of the stroke.
    pub(crate) joined: bool,
    /// A picture shows it: only the next way begins here.
    pub(crate) shown: bool,
}

/// The samples of a stroke, in world mm, and the surface points within its radius of their way.
#[derive(Debug, Default)]
pub(crate) struct Trail {
    pub(crate) samples: Vec<Sample>,
    /// Which of the surface's points are tinted; rebuilt with the picture.
    pub(crate) tinted: Vec<bool>,
    /// Samples that are in `tinted`.
    pub(crate) counted: usize,
    pub(crate) radius_mm: f64,
    /// A step beyond which nothing is painted between two samples.
    pub(crate) jump_mm: f64,
    /// Where the pointer was last.
    pub(crate) px: DVec2,
    pub(crate) colour: Color32,
    pub(crate) running: bool,
}

impl Trail {
    /// A stroke begins, with a brush that reaches so far on voxels of such a size.
    pub(crate) fn begin(&mut self, radius_mm: f64, voxel_mm: f64, colour: Color32) {
        if radius_mm != self.radius_mm || colour != self.colour {
            self.clear();
        }
        self.jump_mm = 2.0 * (radius_mm + voxel_mm);
        (self.radius_mm, self.colour, self.running) = (radius_mm, colour, true);
        self.samples.push(Sample { hit: None, serial: 0, joined: false, shown: false });
    }

    /// The pointer passed this pixel of the 3D view, over this; `serial` is that of the command that says so.
    pub(crate) fn add(&mut self, px: DVec2, hit: Option<Hit>, serial: u64) {
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
    pub(crate) fn px(&self) -> DVec2 {
        self.px
    }

    /// Whether a stroke of the 3D view is under the hand.
    pub(crate) fn is_running(&self) -> bool {
        self.running
    }

    /// The stroke has ended: what no picture shows yet stays.
    pub(crate) fn end(&mut self) {
        self.running = false;
    }

    /// The stroke was taken back, or the picture is of something else.
    pub(crate) fn clear(&mut self) {
        self.samples.clear();
        self.forget_surface();
        self.running = false;
    }

    /// A picture came that shows everything up to a command.
    pub(crate) fn shown(&mut self, serial: u64) {
        let shown = self.samples.iter().take_while(|s| s.serial <= serial).count();
        // The last one shown is where the next way begins.
        self.samples.drain(..shown.saturating_sub(1));
        if let Some(first) = self.samples.first_mut().filter(|_| shown > 0) {
            first.shown = true;
        }
        self.forget_surface();
    }

    pub(crate) fn forget_surface(&mut self) {
        self.tinted.clear();
        self.counted = 0;
    }

    /// The colour and which points of the surface it lies on; `None` if there is nothing to draw.
    pub(crate) fn tint(&mut self, surface: &Surface) -> Option<(Color32, &[bool])> {
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
            let mut reached = false;
            for (tinted, seen) in self.tinted.iter_mut().zip(seen) {
                let near = seen.is_some_and(|s| near_way(s.world, from.world, to.world, self.radius_mm));
                *tinted |= near;
                reached |= near;
            }
            // A brush that passes between the surface's points still paints what is under it.
            if !reached && let Some(i) = nearest(seen, to.world) {
                self.tinted[i] = true;
            }
        }
        self.counted = self.samples.len();
        Some((self.colour, &self.tinted))
    }
}

/// The point of the surface that is nearest to a place.
pub(crate) fn nearest(seen: &[Option<Seen>], at: DVec3) -> Option<usize> {
    let worker_end =
        seen.iter().enumerate().filter_map(|(i, seen)| Some((seen.as_ref()?.world.distance_squared(at), i)));
    worker_end.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i)| i)
}
