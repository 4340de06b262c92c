//! A running stroke on the device: what must be there before dabs are painted (room for what density becomes, the voxels that the stroke
//! keeps to), and its beginning, its going on and its end.
//!
//! A volume that needs another map of density begins on the device with the first dab that reaches it: to paint it anew costs the whole
//! volume. Owns nothing: [`Running`] is what the host knows of the stroke, the GPU has its texels and dabs.

use crate::document::Document;
use crate::document::apply::painting::{Laid, Running};
use crate::document::error::DocumentError;
use crate::gpu::PaintedBricks;
use crate::paint::{Limit, Mirror, Target, image};
use crate::volume::{BrickIndex, FieldKey};
use std::sync::Arc;

impl Document {
    /// Widens the maps of density before dabs add up beyond them, and paints anew what the stroke had painted.
    ///
    /// # Errors
    /// If the device fails or the source does; the stroke is then taken back.
    pub(super) fn make_room(&mut self, dabs: &Laid) -> Result<(), DocumentError> {
        let (Some(running), Some(state)) = (&mut self.running, &mut self.state) else { return Ok(()) };
        let wider = running.wider(state, dabs);
        if wider.is_empty() {
            return Ok(());
        }
        let before: Laid = running.on.iter().map(|on| (on.id, self.graphics.dabs(on.id))).collect();
        self.graphics.cancel(state);
        // All are put back before one is made wider: bricks of several volumes share slots.
        for (id, map) in wider {
            let widened = running.edit.remap(state, id, map);
            self.graphics.remap(state, id);
            if let Err(error) = widened {
                self.drop_stroke();
                return Err(error.into());
            }
        }
        let painted = self.begin_on_device().and_then(|()| {
            let Some(running) = &self.running else { return Ok(()) };
            for on in &running.on {
                self.graphics.confine(on.id, &on.confines);
                self.graphics.open(on.id, &on.seen);
            }
            match before.iter().all(|(_, dabs)| dabs.is_empty()) {
                true => Ok(()),
                false => self.extend_on_device(&before).map(drop),
            }
        });
        if painted.is_err() {
            self.drop_stroke();
        }
        painted
    }

    /// Begins the running stroke on the device, on all its volumes but those that no dab came to and that have no room for one.
    pub(super) fn begin_on_device(&mut self) -> Result<(), DocumentError> {
        let (Some(running), Some(state)) = (&self.running, &self.state) else { return Ok(()) };
        let Running { brush, on, .. } = running;
        let mut begun = on.iter().filter(|on| on.needs.is_none());
        begun.try_for_each(|on| self.graphics.begin(state, on.id, brush, on.reach[1]))
    }

    /// Paints further dabs on the volumes that it began on; answers the bricks that they show in.
    pub(super) fn extend_on_device(&mut self, dabs: &Laid) -> Result<Vec<(FieldKey, BrickIndex)>, DocumentError> {
        let (Some(running), Some(state)) = (&self.running, &self.state) else { return Ok(Vec::new()) };
        let begun = running.on.iter().zip(dabs).filter(|(on, _)| on.needs.is_none());
        let lent: Vec<_> = begun.map(|(_, (id, dabs))| (*id, dabs.as_slice())).collect();
        if lent.is_empty() { Ok(Vec::new()) } else { self.graphics.extend(state, &lent) }
    }

    /// What it painted, once the device is done with it; it runs there no longer.
    pub(super) fn finish_on_device(&mut self) -> Result<PaintedBricks, DocumentError> {
        let (Some(running), Some(state)) = (&self.running, &self.state) else { return Ok(Vec::new()) };
        match running.on.iter().all(|on| on.needs.is_some()) {
            true => Ok(Vec::new()),
            false => self.graphics.finish(state),
        }
    }

    /// Before the first dabs of a stroke that keeps to what is connected to its beginning: finds that in all its volumes.
    fn keep_to_connected(&mut self, dabs: &Laid) -> Result<(), DocumentError> {
        let (Some(running), Some(first)) = (&self.running, dabs.iter().find_map(|(_, dabs)| dabs.first())) else {
            return Ok(());
        };
        if running.on.iter().any(|on| on.confines.iter().any(|(limit, _)| *limit == Limit::Connected)) {
            return Ok(());
        }
        // A contour begins at its first corner, a stroke at its first dab.
        let corner = running.contour.as_ref().and_then(|contour| contour.points.first().copied());
        let begun = corner.unwrap_or(first.centre);
        let other = match &running.brush.mirror {
            Mirror::Plane(plane) => Some(image(plane, begun)),
            _ => None,
        };
        let starts: Vec<_> = std::iter::once(begun).chain(other).collect();
        let mut connected = self.connected_to(&running.volumes(), &starts)?;
        let Some(running) = &mut self.running else { return Ok(()) };
        for on in &mut running.on {
            let of_it = connected.remove(&on.id).unwrap_or_default();
            on.confines.push((Limit::Connected, Arc::new(of_it)));
        }
        Ok(())
    }

    /// Before dabs are painted by a stroke that keeps to the visible surface or to what is connected: finds what that is under them.
    pub(super) fn keep_to_limits(&mut self, dabs: &Laid) -> Result<(), DocumentError> {
        let Some(brush) = self.running.as_ref().map(|running| running.brush) else { return Ok(()) };
        if brush.connected {
            self.keep_to_connected(dabs)?;
        }
        for (i, (id, dabs)) in dabs.iter().enumerate() {
            if dabs.is_empty() {
                continue;
            }
            if let Some(running) = &self.running {
                self.graphics.confine(*id, &running.on[i].confines);
            }
            if brush.keeps_to_surface() {
                let of_it = |running: &mut Running| std::mem::take(&mut running.on[i].seen);
                let Some(mut seen) = self.running.as_mut().map(of_it) else { return Ok(()) };
                // What lies within a depth is counted from what shows alone.
                let all_mixed = brush.visible_only && matches!(brush.target, Target::Colour(_));
                let found = self.see(*id, dabs, brush.within_mm.unwrap_or(0.0), all_mixed, &mut seen);
                self.graphics.open(*id, &seen);
                if let Some(running) = &mut self.running {
                    running.on[i].seen = seen;
                }
                found?;
            }
        }
        Ok(())
    }
}
