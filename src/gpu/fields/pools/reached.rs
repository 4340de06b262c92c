//! What a kernel asks of the pools that reads voxels wherever it comes to: bricks of density at level 0, whatever pictures show.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::pool::Pool;
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::slot_key::number_of;
use crate::gpu::fields::volumes::Fields;
use crate::volume::{BrickIndex, FieldKey, FieldKind, VolumeId};
use std::collections::BTreeMap;

/// Bricks of level 0 by volume.
pub(crate) type Reached = BTreeMap<VolumeId, Vec<BrickIndex>>;

impl FieldPools {
    /// Makes density of these bricks resident at level 0 and lets shaders see `volumes`, in order. What pictures need comes after
    /// that until [`let_go_of_reached`](Self::let_go_of_reached), which is for the caller to say, after an error too. All of density is there
    /// anyway where it lies in place.
    ///
    /// # Errors
    /// [`GpuError::GridTooLarge`] if they are more than fit; else as [`make_resident`](Self::make_resident).
    pub(crate) fn make_reached_resident(
        &mut self,
        gpu: &Gpu,
        fields: &Fields<'_>,
        volumes: &[VolumeId],
        reached: &Reached,
    ) -> Result<(), GpuError> {
        gpu.check()?;
        self.follow_volumes(gpu, fields, volumes.iter().copied())?;
        // What pools do not hold at once, uploads being bounded, comes with the next turns.
        loop {
            let other = self.ask_for_reached(reached);
            self.catch_up(gpu, fields)?;
            if self.all_at_finest(reached) {
                break;
            }
            if !other && !self.is_pending() {
                let (_, room) = volumes.first().map_or((0, 0), |&id| self.room(FieldKey::new(id, FieldKind::Density)));
                let asked = reached.values().map(Vec::len).sum();
                return Err(GpuError::GridTooLarge { field: FieldKind::Density.name(), asked, room });
            }
        }
        self.bind(gpu, volumes)
    }

    /// Ends that.
    pub(crate) fn let_go_of_reached(&mut self) {
        self.ask_for_reached(&Reached::new());
    }

    fn lies_in_place(&self, id: VolumeId) -> bool {
        self.pool(FieldKey::new(id, FieldKind::Density)).is_some_and(Pool::is_in_place)
    }

    /// Says to every volume which of its bricks these are. Answers whether they are others than before.
    fn ask_for_reached(&mut self, reached: &Reached) -> bool {
        let mut other = false;
        for id in self.volumes().collect::<Vec<_>>() {
            let in_place = self.lies_in_place(id);
            let Some(volume) = self.volumes.get_mut(&id) else { continue };
            let bricks = volume.demand.bricks();
            let asked = reached.get(&id).filter(|_| !in_place).into_iter().flatten();
            other |= volume.demand.reach(asked.map(|&index| number_of(bricks, index)).collect());
        }
        if other {
            self.reconsider();
        }
        other
    }

    fn all_at_finest(&self, reached: &Reached) -> bool {
        reached.iter().filter(|(id, _)| !self.lies_in_place(**id)).all(|(&id, bricks)| {
            let of = self.volumes.get(&id).map_or([1; 3], |volume| volume.demand.bricks());
            let key = FieldKey::new(id, FieldKind::Density);
            bricks.iter().all(|&index| self.pages.level_of(key, number_of(of, index)) == 0)
        })
    }
}
