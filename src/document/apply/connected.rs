//! What is connected to where a stroke began, under the present opacity: through the faces of voxels that the looks show at all.
//!
//! Told from the values at the stroke's start, the whole volume at once: a way may lead far round. What is connected is decided by
//! [`Components`] alone. Changes nothing.

use crate::document::Document;
use crate::document::apply::component::component_near;
use crate::document::apply::matter::Meant;
use crate::document::command::component::{Matter, Within};
use crate::document::error::DocumentError;
use crate::math::DVec3;
use crate::paint::VoxelSet;
use crate::segment::{Components, Connectivity};
use crate::volume::{BRICK, VolumeId};

impl Document {
    /// The voxels that are connected to something that shows at any of these places, world mm.
    ///
    /// # Errors
    /// If the source fails.
    pub(super) fn connected_to(&self, volume: VolumeId, places: &[DVec3]) -> Result<VoxelSet, DocumentError> {
        let state = self.state.as_ref().ok_or(DocumentError::NothingOpen)?;
        let subject = state.at(Some(volume))?;
        let meant = Meant::new(subject, Matter::Visible, Within::Volume);
        let dims = subject.grid().dims;
        let components = Components::new(dims, Connectivity::Six, |index| meant.mask(index))?;
        let near = |place: &DVec3| component_near(subject.grid(), &components, *place);
        let wanted: Vec<_> = places.iter().filter_map(near).collect();
        let mut set = VoxelSet::default();
        for (index, mask) in components.voxels(|id| wanted.contains(&id)) {
            let valid = subject.density.valid(0, index);
            set.put(index, |row| mask.row(row % BRICK, row / BRICK, valid));
        }
        Ok(set)
    }
}
