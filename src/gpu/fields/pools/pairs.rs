//! Pairs of voxels of the volume that lies in place: whether pictures read them, and what makes them stale.

use crate::gpu::device::error::GpuError;
use crate::gpu::device::gpu::Gpu;
use crate::gpu::fields::pool::Pool;
use crate::gpu::fields::pools::{CODES, FieldPools, share};
use crate::paint::IndexBox;
use crate::volume::{BrickIndex, BrickKey, FieldKey, FieldKind, Refresh, Region, VolumeId};

impl FieldPools {
    /// Has pairs of the density that lies in place, as it is on the device now, where they serve and fit into density's share of the
    /// budget. To be called before a picture, after its volumes were bound.
    ///
    /// # Errors
    /// A lost device.
    pub(crate) fn pair(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        let budget = share(self.budget, FieldKind::Density);
        if let Some(pool) = &mut self.pools[CODES] {
            pool.pair(gpu, &mut self.pairs, budget)?;
        }
        self.rebind(gpu)
    }

    /// The pairs of the only one of some volumes, if it lies in place and has any.
    pub(crate) fn pairs_of(&self, volumes: &[VolumeId]) -> Option<&wgpu::Texture> {
        let [id] = volumes else { return None };
        let at = self.pool_of(FieldKey::new(*id, FieldKind::Density)).filter(|at| *at == CODES)?;
        let pool = self.pools[at].as_ref().filter(|pool| pool.is_in_place())?;
        pool.pairs.as_ref().map(|pairs| &pairs.texture)
    }

    /// Whether pictures of the volumes that are bound read pairs.
    pub(crate) fn reads_pairs(&self) -> bool {
        self.pairs_of(&self.bound).is_some()
    }

    /// A stroke wrote voxels of level 0 into slots.
    pub(crate) fn wrote(&mut self, key: FieldKey, voxels: impl IntoIterator<Item = IndexBox>) {
        let Some(at) = self.pool_of(key) else { return };
        let Some(pool) = self.pools[at].as_mut().filter(|pool: &&mut Pool| pool.is_in_place()) else { return };
        for IndexBox { lo, end } in voxels {
            // Voxel 0 is texel 1, and those beside the volume are copies.
            pool.wrote(Region { lo, end: end.map(|v| v + 2) });
        }
    }

    /// The same of whole slots.
    pub(crate) fn wrote_slots(&mut self, key: FieldKey, bricks: &[BrickIndex]) {
        let all = Refresh::whole(bricks.iter().map(|&index| BrickKey { level: 0, index }));
        self.wrote(key, all.slots.into_iter().map(|(_, Region { lo, end })| IndexBox { lo, end }));
    }
}
