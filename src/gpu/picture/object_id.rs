//! What a pixel shows: the volume, the body that it is cut into, whether its matter is selected, and the segment.
//!
//! The one place that knows how these are packed. Pictures, picks and EXR files use it.

use crate::volume::VolumeId;

/// Bits of a segment's label, of a body's id and of a volume's.
const SEGMENT: u32 = 16;
const BODY: u32 = 28;
const VOLUME: u32 = 18;
const SELECTED: u64 = 1 << 62;
const SOMETHING: u64 = 1 << 63;

/// The name of what a pixel shows, packed in 64 bits; that it shows nothing is a name too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ObjectId(u64);

fn masked(value: u32, bits: u32) -> u64 {
    u64::from(value) & ((1 << bits) - 1)
}

impl ObjectId {
    /// A pixel that shows nothing.
    pub const NOTHING: Self = Self(0);

    /// A body of a volume; `selected`: whether the volume is selected there; `segment`: the label of the voxel, 0 for none. A body's id is below
    /// 2²⁸, a volume's below 2¹⁸.
    pub fn new(volume: VolumeId, body: u32, selected: bool, segment: u16) -> Self {
        let packed = u64::from(segment) | masked(body, BODY) << SEGMENT | masked(volume.0, VOLUME) << (SEGMENT + BODY);
        Self(SOMETHING | packed | if selected { SELECTED } else { 0 })
    }

    fn field(self, from: u32, bits: u32) -> Option<u32> {
        (self.0 & SOMETHING != 0).then(|| (self.0 >> from & ((1 << bits) - 1)) as u32)
    }

    /// Id of the body.
    pub fn body(self) -> Option<u32> {
        self.field(SEGMENT, BODY)
    }

    /// The volume.
    pub fn volume(self) -> Option<VolumeId> {
        self.field(SEGMENT + BODY, VOLUME).map(VolumeId)
    }

    /// The label of the segment that the voxel is of; `None` if it is of none.
    pub fn segment(self) -> Option<u16> {
        self.field(0, SEGMENT).map(|label| label as u16).filter(|label| *label != 0)
    }

    /// Whether the volume is selected at the place that shows: by half at least, wherever its parts are.
    pub fn is_selected(self) -> bool {
        self.0 & SELECTED != 0
    }
}
