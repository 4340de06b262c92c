//! A contour drawn on a slice that fills: one stroke of one dab that covers it, kept within the contour.
//!
//! So everything that holds for strokes holds for it: limits, mirror, several volumes, undo, journal.

use crate::document::Document;
use crate::document::apply::trail::{Resolved, unit};
use crate::document::command::Place;
use crate::document::command::answers::Answer;
use crate::document::command::brush::Lasso;
use crate::document::error::DocumentError;
use crate::document::place::normal_of;
use crate::document::scene::ViewName;
use crate::paint::{Contour, Sample};

/// The most corners of a contour.
const MOST_POINTS: usize = 1 << 16;

impl Document {
    /// # Errors
    /// If its places lie in no plane of a slice, or as a stroke.
    pub(super) fn lasso(&mut self, lasso: &Lasso) -> Result<Answer, DocumentError> {
        let state = self.open()?;
        let volumes = state.with_sub_volumes(state.scene.painted_by(lasso.volume, lasso.volumes.as_deref())?);
        let subject = state.at(volumes.first().copied())?;
        let depth_mm = lasso.depth_mm.unwrap_or(state.scene.brush.depth_mm);
        if !(0.0..1e100).contains(&depth_mm) {
            return Err(DocumentError::invalid("depth_mm", depth_mm, "a finite depth in mm, 0 or more"));
        }
        if !(3..=MOST_POINTS).contains(&lasso.points.len()) {
            let found = format!("{} points", lasso.points.len());
            return Err(DocumentError::invalid("points", found, format!("3 to {MOST_POINTS} places of a contour")));
        }
        let view = |place: &Place| match place {
            Place::Pixel { view, .. } => Some(*view),
            Place::Mm(_) | Place::Index(_) => None,
        };
        let first = view(&lasso.points[0]);
        if let Some(other) =
            lasso.points.iter().map(view).find(|view| *view != first || *view == Some(ViewName::ThreeD))
        {
            let found =
                other.map_or("a place beside pixels".into(), |view| format!("a pixel of {view:?}").to_lowercase());
            return Err(DocumentError::invalid(
                "points",
                found,
                "places of one slice: all in mm, index, or pixels of it",
            ));
        }
        let normal = match (first, lasso.normal) {
            (None, Some(normal)) => unit(normal)?,
            (view, _) => normal_of(&subject, view.unwrap_or(ViewName::Axial)),
        };
        let mut points = Vec::with_capacity(lasso.points.len());
        for place in &lasso.points {
            let sample = self.resolve(*place, volumes.first().copied())?;
            points.extend(sample.map(|s| s.position));
        }
        let contour = Contour { points, normal, depth_mm };
        let (position, _) = contour.reach();
        let sample = Sample { position, normal, pressure: lasso.pressure, breaks: false };
        let resolved = Resolved { samples: vec![sample], on_slice: true, ..Resolved::default() };
        self.begin_within(&volumes, resolved, Some(contour))?;
        self.finish_stroke()
    }
}
