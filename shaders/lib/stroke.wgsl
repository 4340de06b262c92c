#define_import_path burin::stroke
// What one frame of a stroke is: its constants, its dabs, the slots that they meet. Lengths are in radii of the brush (in smallest
// spacings where it has none), numbers in the storage's own steps.

#import burin::constants::{MOST_DABS, MOST_ITEMS}
#import burin::structs::{BrushDab, BrushItem, BrushStroke}

const ADD: u32 = 1u;
const SUBTRACT: u32 = 2u;
const BLEND: u32 = 3u;
const RESTORE: u32 = 4u;

const LARGEST: u32 = 0u;
const PRODUCT: u32 = 1u;

const LINEAR: u32 = 1u;
const SMOOTH: u32 = 2u;

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
