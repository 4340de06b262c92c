//! Labels as the window showed them in the frame before: what their placing remembers, and when that was.

use crate::annotate::labels::{Frame, Label, Memory, Style, Viewport, place};

/// A pause longer than this is no motion, s.
const LONGEST_STEP_S: f64 = 0.1;

/// What the placing of labels needs of the frame before.
#[derive(Clone, Debug, Default)]
pub(crate) struct LabelsShown {
    memory: Memory,
    /// Seconds of egui's clock.
    at_s: Option<f64>,
    /// Since when nothing moved.
    still_since_s: f64,
    last: Option<Frame>,
}

/// When labels are to be placed again though nothing else asks for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Again {
    /// In the next frame.
    Soon,
    /// After a rest they may be tidied.
    Later,
    /// Not at all.
    Never,
}

impl LabelsShown {
    /// Another document is open, or there are none.
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }

    /// Where labels are now, and when to ask again.
    pub(crate) fn place(&mut self, viewport: &Viewport, style: &Style, labels: &[Label], now_s: f64) -> (Frame, Again) {
        let dt_s = self.at_s.map_or(0.0, |at| (now_s - at).clamp(0.0, LONGEST_STEP_S));
        self.at_s = Some(now_s);
        let frame = place(viewport, style, labels, &mut self.memory, dt_s);
        let moves = self.last.as_ref() != Some(&frame);
        if moves {
            self.still_since_s = now_s;
        }
        let fades = frame.labels.iter().any(|label| label.opacity > 0.0 && label.opacity < 1.0);
        self.last = Some(frame.clone());
        let again = match () {
            () if moves || fades || !frame.settled => Again::Soon,
            () if now_s - self.still_since_s < style.still_s + 1.0 => Again::Later,
            () => Again::Never,
        };
        (frame, again)
    }
}
