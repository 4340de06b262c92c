//! Maps of what lies above some values: a ray that has met more than one of them looks for its maximum only there.
//!
//! Of pictures of one volume of codes, whose samples are never more than the largest of their voxels. Knows no skip maps but what
//! they are asked for.

use crate::gpu::cast::merging::MergedBody;
use crate::gpu::cast::uniforms::View;
use crate::gpu::fields::matter::{Matter, Showing};
use crate::gpu::fields::pools::FieldPools;
use crate::gpu::fields::visible_values::VisibleValues;
use crate::gpu::fields::volumes::Fields;
use crate::gpu::picture::frame::Mask;
use crate::volume::{TexelFormat, VolumeId};

/// The values, as shares of the way from the volume's least to its greatest.
const SHARES: [f64; 3] = [0.45, 0.65, 0.85];
/// More than samples differ from what they are in f64, in texels.
const MARGIN: f64 = 1e-6;

/// See the file's head.
pub(crate) struct Higher {
    volume: VolumeId,
    values: [f64; 3],
    texels: [f32; 3],
}

impl Higher {
    /// Of the volume that all bodies are cut out of, if it is one.
    pub(crate) fn of(fields: &Fields<'_>, pools: &FieldPools, drawn: &[MergedBody]) -> Option<Self> {
        let volume = drawn.first()?.volume;
        let density = fields.get(volume)?.density;
        if density.format() != TexelFormat::R16Unorm || drawn.iter().any(|d| d.volume != volume) {
            return None;
        }
        let [least, most] = density.extremes().map(f64::from);
        let (lo, span) = pools.value_of_texel(volume);
        if !(most > least && span > 0.0) {
            return None;
        }
        // Rounded, so that a stroke that makes something a little more leaves the values, and with them whole maps, as they are.
        let step = ((most - least).log2().floor() - 3.0).exp2();
        let (least, most) = ((least / step).floor() * step, (most / step).ceil() * step);
        let values = SHARES.map(|share| least + share * (most - least));
        let texels = values.map(|value| ((value - lo) / span + MARGIN) as f32);
        Some(Self { volume, values, texels })
    }

    /// What their maps are of.
    pub(crate) fn matters(&self) -> impl Iterator<Item = Matter> + '_ {
        let above = |value: &f64| Matter {
            volume: self.volume,
            values: Showing::One(VisibleValues::above(*value)),
            mask: Mask::None,
        };
        self.values.iter().map(above)
    }

    /// Tells shaders where the maps begin.
    pub(crate) fn tell(&self, view: &mut View, above: &[[u32; 3]]) {
        if let [a, b, c] = above {
            (view.above_a, view.above_b, view.above_c) = (*a, *b, *c);
            [view.from_a, view.from_b, view.from_c] = self.texels;
        }
    }
}
