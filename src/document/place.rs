//! From what a command says of a place to a point of the volume at rest.

use crate::document::Document;
use crate::document::command::parts::PartCommand;
use crate::document::command::views::{FocusChange, ViewCommand};
use crate::document::command::{Command, Place};
use crate::document::error::DocumentError;
use crate::document::reduce::place::{normal_in, place_in};
use crate::document::scene::ViewName;
use crate::document::scene::check::check_size;
use crate::document::subject::Subject;
use crate::gpu::Hit;
use crate::math::{DVec2, DVec3};
use crate::paint::Sample;
use crate::volume::VolumeId;

impl Document {
    /// A place as a sample of pressure 1, indices and slices those of a volume, the active one if none is named; `None` if it is a
    /// pixel of the 3D view that shows nothing. The normal is that of the slice under a pixel, otherwise of the axial slice.
    ///
    /// # Errors
    /// If numbers are not finite, or there is no GPU to look at the 3D view with.
    pub(crate) fn resolve(&mut self, place: Place, volume: Option<VolumeId>) -> Result<Option<Sample>, DocumentError> {
        let subject = self.open()?.at(volume)?;
        if let Some(sample) = place_in(place, subject.scene, subject.grid())? {
            return Ok(Some(sample));
        }
        let normal = normal_of(&subject, ViewName::Axial);
        let Place::Pixel { px, size, .. } = place else { return Ok(None) };
        let hit = self.pick(DVec2::from_array(px), size)?;
        Ok(hit.map(|hit| Sample { position: hit.rest, normal, pressure: 1.0, breaks: false }))
    }

    /// The command with what it names by pixels of a picture put in numbers of the world, so that it means the same whatever is seen.
    ///
    /// # Errors
    /// If nothing shows at such a pixel, or there is no GPU to look with.
    pub(crate) fn in_numbers(&mut self, command: Command) -> Result<Command, DocumentError> {
        match command {
            Command::View(ViewCommand::Crosshair { at }) if !matches!(at, Place::Mm(_)) => {
                let world = self.resolve(at, None)?.ok_or_else(|| nothing_there("at", at))?.position;
                Ok(Command::View(ViewCommand::Crosshair { at: Place::Mm(world.to_array()) }))
            }
            Command::View(ViewCommand::Focus(change)) => {
                let at = match change.at {
                    Some(at) => Some(self.resolve(at, None)?.ok_or_else(|| nothing_there("at", at))?.position),
                    None => None,
                };
                let at = at.map(|at| Place::Mm(at.to_array()));
                Ok(Command::View(ViewCommand::Focus(FocusChange { at, ..change })))
            }
            Command::Part(PartCommand::Split { by, size }) => {
                let by = self.cuts_of(by, size)?;
                Ok(Command::Part(PartCommand::Split { by, size: None }))
            }
            Command::Component(command) => Ok(Command::Component(self.component_in_numbers(command)?)),
            other => self.annotations_in_numbers(other),
        }
    }

    /// The first visible surface under a pixel of the 3D view as it is drawn now, running stroke included.
    ///
    /// # Errors
    /// Without a GPU, or whatever the GPU or the source fails with.
    pub fn pick(&mut self, px: DVec2, size: Option<[u32; 2]>) -> Result<Option<Hit>, DocumentError> {
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        let size = check_size(size.unwrap_or(state.scene.views.size))?;
        if !px.is_finite() {
            return Err(DocumentError::invalid("px", px, "two finite numbers"));
        }
        let mut frame =
            state.looking(&[state.scene.volumes.active], self.motion.poses(), &state.scene.views.camera, size);
        self.lay_out(&mut frame.layers, false, true);
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        self.graphics.pick(state, &frame, px)
    }
}

/// The normal of a slice view.
pub(crate) fn normal_of(subject: &Subject<'_>, view: ViewName) -> DVec3 {
    normal_in(subject.grid(), &subject.scene.views, view)
}

/// What a command says that needs a surface where there is none.
pub(crate) fn nothing_there(field: &str, at: impl serde::Serialize) -> DocumentError {
    let at = serde_json::json!(at);
    DocumentError::invalid(field, format!("{at}, where nothing is visible"), "a pixel on a visible surface")
}
