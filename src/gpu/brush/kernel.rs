//! The brush kernel and the numbers it is given: shaders/brush/brush.wgsl.
//!
//! Owns the structs shared with the shader, the variants by texel format, and the translation of brushes and dabs into them.
//! Knows neither bricks nor strokes in time.

use crate::gpu::device::constants::{MOST_DABS, MOST_ITEMS, ROW_PITCH_BYTES};
use crate::gpu::device::gpu::Gpu;
use crate::gpu::device::kernel::{Binding, Compute, Kernel};
use crate::gpu::device::shader::shader;
use crate::math::{DMat3, DVec3};
use crate::paint::{Along, Brush, CURVE_POINTS, EDGE, Falloff, Footprint, Operation, Reach, Target, Tip};
use crate::shared_struct;
use crate::volume::{Field, FieldKind, Grid, SLOT, SLOT_VOXELS, SubBox, TexelFormat};

/// Fours of texels in a slot's row: the kernel takes so many at a time.
pub(crate) const QUADS: u32 = SLOT.div_ceil(4);
/// Bytes of a dispatch's dabs.
pub(crate) const DABS_BYTES: u64 = MOST_DABS as u64 * size_of::<BrushDab>() as u64;
/// Bytes of a dispatch's items.
pub(crate) const ITEMS_BYTES: u64 = MOST_ITEMS as u64 * size_of::<BrushItem>() as u64;
/// Bytes of a slot's rows at that pitch, and of those of the slots beside it.
pub(crate) const SLOT_PITCH_BYTES: u64 = (SLOT * SLOT * ROW_PITCH_BYTES) as u64;

const FILE: &str = shader!(
    "brush/brush.wgsl",
    one of "CODES", "CODES_IN_FLOATS", "COLOUR", "FLOATS", "LABELS", "SELECTION"
);

shared_struct! {
    /// A stroke's constants. Lengths are in radii of the brush (in smallest spacings where it has none), numbers in the storage's own
    /// steps.
    pub(crate) struct BrushStroke {
        /// Columns of world_from_index in radii.
        columns: [[f32; 4]; 3],
        /// Unit normals of the layers of voxels.
        normals: [[f32; 4]; 3],
        /// C; colour in 0..1; a label's id in x.
        paint: [f32; 4],
        /// Of a drawn falloff: by piece x where it begins, 1 over its width, by how much it rises; in w of the first F at x = 0.
        curve: [[f32; 4]; 11],
        /// Of a box of a volume: how much of a stroke there is more for every sample from its faces on; in w, what there is on them.
        band: [f32; 4],
        dims: [i32; 3],
        /// Where numbers begin.
        low: f32,
        /// Where numbers end.
        top: f32,
        /// Of numbers in floats: the step by which weak strokes arrive.
        step: f32,
        /// From which value on it is that.
        least: f32,
        /// And up to which.
        greatest: f32,
    }
}

shared_struct! {
    /// One dab: its centre is base + fraction, a continuous index.
    pub(crate) struct BrushDab {
        base: [i32; 3],
        /// Bit 0: whether the voxel that holds the centre has all of the gain, however near it comes to it. Bits 1 and 2: across
        /// which axis a disc lies, from 1; 0 for a ball. From bit 3 on: its layer.
        form: u32,
        fraction: [f32; 3],
        /// Strength times pressure.
        gain: f32,
        /// Unit normal of the surface that it lies along; 0 for others.
        normal: [f32; 3],
        /// Along the normal distances count beyond this,
        half: f32,
        /// and are stretched so much.
        stretch: f32,
        /// Largest squared distance inside; 0 for a dab that is one voxel.
        edge: f32,
        /// The brush's radius over the dab's.
        scale: f32,
        unused: u32,
    }
}

shared_struct! {
    /// One slot's work.
    pub(crate) struct BrushItem {
        /// Voxel of the slot's first texel.
        pub origin: [i32; 3],
        /// Number of the slot within its buffers.
        pub place: u32,
        /// Box of work: first four of texels, row and layer of the slot.
        pub lo: [u32; 3],
        /// First row in the buffer of new texels.
        pub next: u32,
        /// Fours of texels, rows, layers.
        pub size: [u32; 3],
        /// First dab that can meet the slot.
        pub first_dab: u32,
        /// Dabs from there.
        pub dab_count: u32,
        /// Of the dispatch's first item: where its jobs begin.
        pub first_job: u32,
        /// What the stroke does ([`choices`]), the same in every item: bits 0 to 2 its operation, 3 and 4 how it gathers, 5 and 6 its
        /// falloff, 7 whether only texels whose bit is set are painted, 8 whether what is painted is an end that weak strokes must reach.
        pub choices: u32,
        /// 0.
        pub unused: u32,
    }
}

/// What the kernel is compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Variant {
    Selection,
    Labels,
    Colour,
    /// Density in 16-bit codes.
    Codes,
    /// Density in 16-bit codes on the host, in `r32float` on a device without 16-bit textures: code / 65,535.
    CodesInFloats,
    /// Density in floats.
    Floats,
}

impl Variant {
    /// By the host's format and the pool's.
    pub(crate) fn of(host: TexelFormat, pool: TexelFormat) -> Self {
        match (host, pool) {
            (TexelFormat::R8Unorm, _) => Self::Selection,
            (TexelFormat::R16Uint, _) => Self::Labels,
            (TexelFormat::Rgba8Unorm, _) => Self::Colour,
            (TexelFormat::R16Unorm, TexelFormat::R32Float) => Self::CodesInFloats,
            (TexelFormat::R16Unorm, _) => Self::Codes,
            (TexelFormat::R32Float, _) => Self::Floats,
        }
    }

    fn condition(self) -> &'static str {
        match self {
            Self::Selection => "SELECTION",
            Self::Labels => "LABELS",
            Self::Colour => "COLOUR",
            Self::Codes => "CODES",
            Self::CodesInFloats => "CODES_IN_FLOATS",
            Self::Floats => "FLOATS",
        }
    }

    /// Bytes of a texel on the GPU.
    pub(crate) fn bytes(self) -> u32 {
        match self {
            Self::Selection => 1,
            Self::Labels | Self::Codes => 2,
            Self::Colour | Self::CodesInFloats | Self::Floats => 4,
        }
    }

    /// Bytes of a slot's row, in whole fours of texels.
    pub(crate) fn row_bytes(self) -> u32 {
        QUADS * 4 * self.bytes()
    }

    /// How many slots lie side by side at the copies' pitch.
    pub(crate) fn slots_per_row(self) -> u32 {
        ROW_PITCH_BYTES / self.row_bytes()
    }
}

/// Bytes of a slot in the host's format, as the kernel reads unedited density.
pub(crate) fn tight_bytes(format: TexelFormat) -> u64 {
    (SLOT_VOXELS * format.bytes()) as u64
}

/// What the kernel is compiled under: a stroke's first dab, if it is one, need not gather coverage; of falloffs, those that cost more than
/// the others, which need not pay for them; whether dabs have a form or a size of their own, and each texel something of its own that it goes toward.
pub(crate) fn conditions(variant: Variant, gathers: bool, brush: &Brush) -> Vec<&'static str> {
    let falloff = match brush.effective_falloff() {
        Falloff::Gaussian => Some("GAUSSIAN"),
        Falloff::Curve(_) => Some("CURVE"),
        Falloff::Hard | Falloff::Linear | Falloff::Smooth => None,
    };
    let formed = (brush.lies_along() || brush.pressure.radius).then_some("FORMED");
    let goals = brush.effective().looks_around().then_some("GOALS");
    std::iter::once(variant.condition())
        .chain((!gathers).then_some("ONE_DAB"))
        .chain(falloff)
        .chain(formed)
        .chain(goals)
        .collect()
}

/// The kernel of shaders/brush/brush.wgsl. Its bindings are numbered as there.
pub(crate) fn brush(gpu: &Gpu) -> Kernel<Compute> {
    // The widest element of a buffer takes four words.
    let of_four = |written| Binding::Elements { bytes: 16, written };
    let of_words = |written| Binding::Elements { bytes: 4, written };
    let bindings = [
        Binding::Uniform(size_of::<BrushStroke>()),
        Binding::UniformAt(DABS_BYTES as usize),
        Binding::UniformAt(ITEMS_BYTES as usize),
        of_four(false),
        of_four(true),
        of_four(true),
        of_words(true),
        of_words(false),
        of_words(false),
        of_words(false),
        of_words(false),
    ];
    Kernel::new(gpu, FILE, Compute("brush"), &bindings)
}

impl BrushStroke {
    /// The constants of a stroke on a field of this format.
    pub(crate) fn new(brush: &Brush, (grid, of): (&Grid, Option<SubBox>), target: &Field, reach: Reach) -> Self {
        let map = target.map();
        let offset = matches!(brush.effective(), Operation::Add | Operation::Subtract);
        let paint = match brush.effective_target() {
            Target::Density(value) if offset => [(value * map.codes_per_unit) as f32, 0.0, 0.0, 0.0],
            Target::Density(value) if target.format() == TexelFormat::R32Float => {
                [((value - map.lo) * map.codes_per_unit) as f32, 0.0, 0.0, 0.0]
            }
            Target::Density(value) => {
                [((value - map.lo) * map.codes_per_unit).clamp(0.0, 65_535.0) as f32, 0.0, 0.0, 0.0]
            }
            Target::Colour(rgba) => rgba,
            Target::Selection(value) => [value * 255.0, 0.0, 0.0, 0.0],
            Target::Label(id) => [f32::from(id), 0.0, 0.0, 0.0],
        };
        // A hair wider than f32 rounds.
        let hair = |v: f64| (v.abs() * 1e-6).min(1.0);
        let [low, top] = match (target.kind(), target.format(), brush.bounds(target)) {
            (FieldKind::Density, TexelFormat::R32Float, [lo, hi]) => [lo - hair(lo), hi + hair(hi)]
                .map(|v| ((v - map.lo) * map.codes_per_unit).clamp(f32::MIN.into(), f32::MAX.into())),
            (FieldKind::Density, _, ends) => ends.map(|v| ((v - map.lo) * map.codes_per_unit).clamp(0.0, 65_535.0)),
            _ => [0.0, 255.0],
        }
        .map(|v| v as f32);
        let rows = grid.index_from_world().matrix3.transpose();
        let normals = DMat3::from_cols(rows.x_axis.normalize(), rows.y_axis.normalize(), rows.z_axis.normalize());
        let scaled = |v: f64| (v * map.codes_per_unit).clamp(f32::MIN.into(), f32::MAX.into()) as f32;
        // In radii: no unit of the grid then changes a bit of what the kernel calculates.
        let length = if brush.radius_mm > 0.0 { brush.radius_mm } else { grid.voxel_mm() };
        Self {
            columns: columns(&(grid.world_from_index.matrix3 * length.recip())),
            normals: columns(&normals),
            paint,
            curve: curve(brush.effective_falloff()),
            // Strokes fade over half a voxel of the parent, so that nothing steps at the faces.
            band: of.map_or([0.0, 0.0, 0.0, 1.0], |of| {
                let [x, y, z] = of.scale.map(|s| 2.0 / s as f32);
                [x, y, z, 0.0]
            }),
            dims: grid.dims.map(|d| d as i32),
            low,
            top,
            step: scaled(reach.step()),
            least: scaled(reach.0[0] - map.lo),
            greatest: scaled(reach.0[1] - map.lo),
        }
    }
}

/// What a stroke does, in the bits that shaders/brush/brush.wgsl takes apart.
pub(crate) fn choices(brush: &Brush, gated: bool) -> u32 {
    let offset = matches!(brush.effective(), Operation::Add | Operation::Subtract);
    let operation = match brush.effective() {
        Operation::Replace => 0,
        Operation::Add => 1,
        Operation::Subtract => 2,
        Operation::Blend => 3,
        Operation::Restore => 4,
        // Compiled in.
        _ => 0,
    };
    let gather = match (brush.tip, offset) {
        (Tip::Wash, _) => 0,
        (Tip::BuildUp, false) => 1,
        (Tip::BuildUp, true) => 2,
    };
    let falloff = match brush.effective_falloff() {
        Falloff::Hard => 0,
        Falloff::Linear => 1,
        Falloff::Smooth => 2,
        Falloff::Gaussian | Falloff::Curve(_) => 3,
    };
    operation | gather << 3 | falloff << 5 | u32::from(gated) << 7 | u32::from(brush.ends()) << 8
}

/// A drawn falloff by its pieces; those that it lacks rise by nothing.
fn curve(falloff: Falloff) -> [[f32; 4]; CURVE_POINTS - 1] {
    let mut pieces = [[0.0; 4]; CURVE_POINTS - 1];
    if let Falloff::Curve(curve) = falloff {
        for (piece, pair) in pieces.iter_mut().zip(curve.points().windows(2)) {
            let [[a, f], [b, g]] = [pair[0], pair[1]];
            *piece = [a, 1.0 / (b - a), g - f, 0.0];
        }
        pieces[0][3] = curve.points()[0][1];
    }
    pieces
}

fn columns(m: &DMat3) -> [[f32; 4]; 3] {
    [m.x_axis, m.y_axis, m.z_axis].map(|c| [c.x as f32, c.y as f32, c.z as f32, 0.0])
}

impl BrushDab {
    pub(crate) fn new(footprint: &Footprint, brush_radius_mm: f64) -> Self {
        let base = footprint.centre.floor();
        let reach = if footprint.radius_mm > 0.0 { 1.0 + EDGE } else { 0.0 };
        let along = footprint.along.unwrap_or(Along { normal: DVec3::ZERO, half_mm: 0.0, stretch: 0.0 });
        let disc = footprint.layer.map_or(0, |l| (l.axis as u32 + 1) << 1 | l.index << 3);
        Self {
            base: base.to_array().map(|v| v as i32),
            form: u32::from(footprint.thin) | disc,
            fraction: (footprint.centre - base).to_array().map(|v| v as f32),
            gain: footprint.gain,
            normal: along.normal.to_array().map(|v| v as f32),
            half: (along.half_mm / brush_radius_mm.max(f64::MIN_POSITIVE)) as f32,
            stretch: along.stretch as f32,
            edge: (reach * reach) as f32,
            scale: if footprint.radius_mm > 0.0 { (brush_radius_mm / footprint.radius_mm) as f32 } else { 1.0 },
            unused: 0,
        }
    }
}
