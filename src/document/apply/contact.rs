//! What is felt of a surface: the question, and what a device's thread is given.

use crate::document::Document;
use crate::document::command::Place;
use crate::document::command::answers_ask::ContactSaid;
use crate::document::error::DocumentError;
use crate::document::live::contact::{ContactFeed, ContactField, ContactForce};
use crate::document::place::nothing_there;
use crate::document::scene::check::finite;
use crate::math::DVec3;
use crate::volume::{Mode, VolumeId};

impl Document {
    /// The line to a device that feels what is open: its thread says where it is and takes the newest field.
    pub fn touch(&self) -> ContactFeed {
        self.touch.clone()
    }

    /// Gives a device that wants one a field as of now; for once a frame. Costs nothing where no device is. Answers whether it did.
    ///
    /// # Errors
    /// If the volume that the device names is gone, or its source fails.
    pub fn renew_touch(&self) -> Result<bool, DocumentError> {
        match &self.state {
            Some(state) => self.touch.renew(state, self.revision),
            None => Ok(false),
        }
    }

    /// The density about a place, world mm at rest, as a device feels it: what was read back last, without the GPU.
    ///
    /// # Errors
    /// If nothing is open, there is no such volume, a number is not finite, or the source fails.
    pub fn contact_field(&self, at: DVec3, volume: Option<VolumeId>) -> Result<ContactField, DocumentError> {
        at.to_array().iter().try_for_each(|x| finite("at", *x).map(|_| ()))?;
        let state = self.open()?;
        let root = state.scene.root_of(state.at(volume)?.id);
        ContactField::about(state, root, at, self.revision)
    }

    pub(crate) fn ask_contact(
        &mut self,
        at: Place,
        volume: Option<VolumeId>,
        value: Option<f64>,
        law: &ContactForce,
    ) -> Result<ContactSaid, DocumentError> {
        law.check()?;
        let rest = self.resolve(at, volume)?.ok_or_else(|| nothing_there("at", at))?.position;
        let state = self.open()?;
        let root = state.scene.root_of(state.at(volume)?.id);
        let value = match (value, state.scene.mode_of(root)) {
            (Some(value), _) => finite("value", value)?,
            (None, Mode::Iso(value)) => value,
            (None, _) => {
                return Err(DocumentError::invalid(
                    "value",
                    "nothing",
                    "the surface's value, since no iso-surface is shown",
                ));
            }
        };
        let contact = self.contact_field(rest, Some(root))?.contact(rest, value, law);
        Ok(ContactSaid {
            mm: rest.to_array(),
            volume: root,
            value,
            known: contact.known,
            inside: contact.inside,
            touching: contact.touching,
            depth_mm: contact.depth_mm,
            normal: contact.normal.map(|normal| normal.to_array()),
            force_n: contact.force_n.to_array(),
        })
    }
}
