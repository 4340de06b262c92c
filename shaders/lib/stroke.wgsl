#define_import_path burin::stroke
// What one frame of a stroke is: its constants, its dabs, the slots that they meet. Lengths are in radii of the brush (in smallest
// spacings where it has none), numbers in the storage's own steps.

#import burin::constants::{MOST_DABS, MOST_ITEMS}

const ADD: u32 = 1u;
const SUBTRACT: u32 = 2u;
const BLEND: u32 = 3u;
const RESTORE: u32 = 4u;

const LARGEST: u32 = 0u;
const PRODUCT: u32 = 1u;

const LINEAR: u32 = 1u;
const SMOOTH: u32 = 2u;

struct BrushStroke {
    // Columns of world_from_index in radii.
    columns: array<vec4<f32>, 3>,
    // Unit normals of the layers of voxels.
    normals: array<vec4<f32>, 3>,
    // C; colour in 0..1; a label's id in x.
    paint: vec4<f32>,
    dims: vec3<i32>,
    // Where numbers end.
    low: f32,
    top: f32,
    // Of numbers in floats: the step by which weak strokes arrive, and between which values it is that.
    step: f32,
    least: f32,
    greatest: f32,
}

struct BrushDab {
    // Centre = base + fraction, continuous index.
    base: vec3<i32>,
    // Bit 0: whether the voxel that holds the centre has all of the gain, however near it comes to it. Bits 1 and 2: across which
    // axis a disc lies, from 1; 0 for a ball. From bit 3 on: its layer.
    form: u32,
    fraction: vec3<f32>,
    // Strength times pressure.
    gain: f32,
    // Largest squared distance inside; 0 for a dab that is one voxel.
    edge: f32,
    unused_a: u32,
    unused_b: u32,
    unused_c: u32,
}

struct BrushItem {
    // Voxel of the slot's first texel.
    origin: vec3<i32>,
    // Number of the slot in this chunk's buffers.
    place: u32,
    // Box of work: first four texels, row and layer of the slot, and how many.
    lo: vec3<u32>,
    // First row in `next`.
    next: u32,
    size: vec3<u32>,
    // Dabs that can meet the slot.
    first_dab: u32,
    dab_count: u32,
    // Of the dispatch's first item: where its jobs begin.
    first_job: u32,
    // What the stroke does: bits 0 to 2 its operation, 3 and 4 how it gathers, 5 and 6 its falloff, 7 whether only texels whose
    // bit is set are painted, 8 whether what is painted is an end that weak strokes must reach. The same in every item.
    choices: u32,
    unused: u32,
}

// Uniforms: from a storage buffer such loops run many times slower on software Vulkan, and read wrong.
@group(0) @binding(0) var<uniform> stroke: BrushStroke;
@group(0) @binding(1) var<uniform> dabs: array<BrushDab, MOST_DABS>;
@group(0) @binding(2) var<uniform> items: array<BrushItem, MOST_ITEMS>;

// An item's choices. They are not among the stroke's constants: software Vulkan takes a uniform's value that a branch hangs on for
// a constant, compiles the kernel anew for every dispatch, and keeps them all.
struct Choices {
    operation: u32,
    gather: u32,
    falloff: u32,
    gated: bool,
    to_end: bool,
}

fn choices_of(bits: u32) -> Choices {
    return Choices(bits & 7u, (bits >> 3u) & 3u, (bits >> 5u) & 3u, (bits & 128u) != 0u, (bits & 256u) != 0u);
}
