// One frame's dabs, into every slot that shows them: Direct Volume Editing (2008), equations 1 and 2, in the form
// P' = P + G ((C op P) - P), G = strength F(d), F = 0 beyond the support.
// A stroke gathers coverage and is applied once to the texels at its start. One invocation makes one word of a slot's row.
// Apron texels are computed like all others, from the voxel they repeat, so neighbouring slots agree without exchange.

const SLOT: u32 = 34u;
const SLOT_TEXELS: u32 = 39304u;
// Words between rows of `start` and `next`: texture copies want rows of 256 bytes.
const PITCH: u32 = 64u;

// Texels in a word, words in a slot's row, and how many slots lie side by side in `start`. Without a condition: colour.
#ifdef SELECTION
const PER_WORD: u32 = 4u;
const ROW: u32 = 9u;
const LANES: u32 = 7u;
#else ifdef LABELS
const PER_WORD: u32 = 2u;
const ROW: u32 = 17u;
const LANES: u32 = 3u;
#else ifdef CODES
const PER_WORD: u32 = 2u;
const ROW: u32 = 17u;
const LANES: u32 = 3u;
#else ifdef CODES_IN_FLOATS
const PER_WORD: u32 = 1u;
const ROW: u32 = 34u;
const LANES: u32 = 1u;
#else ifdef FLOATS
const PER_WORD: u32 = 1u;
const ROW: u32 = 34u;
const LANES: u32 = 1u;
#else
const PER_WORD: u32 = 1u;
const ROW: u32 = 34u;
const LANES: u32 = 1u;
#endif

const ADD: u32 = 1u;
const SUBTRACT: u32 = 2u;
const BLEND: u32 = 3u;
const RESTORE: u32 = 4u;

const LARGEST: u32 = 0u;
const PRODUCT: u32 = 1u;

const LINEAR: u32 = 1u;
const SMOOTH: u32 = 2u;

// The greatest 16-bit code.
const TOP: f32 = 65535.0;

// Words of a slot's bits.
const GATE_WORDS: u32 = 1229u;

// 1.0
const ONE: u32 = 0x3f800000u;

struct BrushStroke {
    // Columns of world_from_index in radii of the brush (smallest spacings where it has none), and unit normals of the layers
    // of voxels.
    columns: array<vec4<f32>, 3>,
    normals: array<vec4<f32>, 3>,
    // C, in the storage's own steps; colour in 0..1; a label's id in x.
    paint: vec4<f32>,
    dims: vec3<i32>,
    // Where numbers end, in the storage's own steps.
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
    // Across which a disc lies; -1 for a ball.
    axis: i32,
    fraction: vec3<f32>,
    layer: i32,
    // Strength times pressure.
    gain: f32,
    // Largest squared distance inside; 0 for a dab that is one voxel.
    edge: f32,
    // Whether the voxel that holds the centre has all of the gain, however near it comes to it.
    thin: u32,
    unused: u32,
}

struct BrushItem {
    // Voxel of the slot's first texel.
    origin: vec3<i32>,
    // Number of the slot in this chunk's buffers.
    place: u32,
    // Box of work: first word, row and layer of the slot, and how many.
    lo: vec3<u32>,
    // First word in `next`.
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
@group(0) @binding(1) var<uniform> dabs: array<BrushDab, 256>;
@group(0) @binding(2) var<uniform> items: array<BrushItem, 128>;
// The slots' texels at the stroke's start.
@group(0) @binding(3) var<storage, read> start: array<u32>;
// A texel's coverage so far, as the bits of an f32: its largest G, or the sum of G, or what is left of 1 after all
// factors 1 - G (with the bits of 1 flipped, so that a cleared buffer means untouched).
@group(0) @binding(4) var<storage, read_write> coverage: array<u32>;
// The boxes' new words, rows at PITCH.
@group(0) @binding(5) var<storage, read_write> next: array<u32>;
// Not 0 for slots in which a voxel of their own differs from the start.
@group(0) @binding(6) var<storage, read_write> changed: array<atomic<u32>>;
// Unedited density, tight rows of the host's texels.
@group(0) @binding(7) var<storage, read> base: array<u32>;
// A bit for every texel of a slot, set where the range of values lets the brush paint: the host compares the values themselves.
@group(0) @binding(8) var<storage, read> gate: array<u32>;
// Bit of every locked label.
@group(0) @binding(9) var<storage, read> locked: array<u32>;
// Per workgroup: number of its item, and of the workgroup within the item's box in the lower 16 bits. Without it as many
// workgroups as the largest box needs would run for every item, and idle ones cost as much as busy ones on software Vulkan.
@group(0) @binding(10) var<storage, read> jobs: array<u32>;

// The item's choices. They are not among the stroke's constants: software Vulkan takes a uniform's value that a branch hangs on for
// a constant, compiles the kernel anew for every dispatch, and keeps them all.
var<private> operation: u32;
var<private> gather: u32;
var<private> falloff: u32;
var<private> gated: bool;
var<private> to_end: bool;

fn choose(choices: u32) {
    operation = choices & 7u;
    gather = (choices >> 3u) & 3u;
    falloff = (choices >> 5u) & 3u;
    gated = (choices & 128u) != 0u;
    to_end = (choices & 256u) != 0u;
}

fn g_of(voxel: vec3<i32>, i: u32) -> f32 {
    let offset = vec3<f32>(voxel - dabs[i].base) - dabs[i].fraction;
    var d = stroke.columns[0].xyz * offset.x + stroke.columns[1].xyz * offset.y + stroke.columns[2].xyz * offset.z;
    let axis = dabs[i].axis;
    if axis >= 0 {
        if voxel[axis] != dabs[i].layer {
            return 0.0;
        }
        let n = stroke.normals[axis].xyz;
        d -= n * dot(n, d);
    }
    if dabs[i].thin != 0u && all(offset > vec3<f32>(-0.5)) && all(offset <= vec3<f32>(0.5)) {
        return dabs[i].gain;
    }
    let squared = dot(d, d);
    if squared > dabs[i].edge {
        return 0.0;
    }
    let x = min(sqrt(squared), 1.0);
    var f = 1.0;
    if falloff == LINEAR {
        f = 1.0 - x;
    } else if falloff == SMOOTH {
        f = (1.0 - x * x) * (1.0 - x * x);
    }
    return dabs[i].gain * f;
}

// Lays the dabs on what a texel has gathered; answers the new state's bits.
fn gathered(before: u32, voxel: vec3<i32>, first: u32, count: u32) -> u32 {
    let product = gather == PRODUCT;
    let largest = gather == LARGEST;
    let flip = select(0u, ONE, product);
    var state = bitcast<f32>(before ^ flip);
    for (var i = first; i < first + count; i += 1u) {
        let g = g_of(voxel, i);
        // Subtracting g times the rest, not multiplying by 1 - g: the latter is rounded alike for every dab.
        state = select(select(state + g, state - state * g, product), max(state, g), largest);
    }
    return bitcast<u32>(state) ^ flip;
}

fn cover_of(state: u32) -> f32 {
    if gather == PRODUCT {
        return 1.0 - bitcast<f32>(state ^ ONE);
    }
    return bitcast<f32>(state);
}

fn finite(bits: u32) -> bool {
    return (bits & 0x7f800000u) != 0x7f800000u;
}

// A code of a row of pairs.
fn tight_code(word: u32, x: u32) -> u32 {
    return (word >> (16u * (x & 1u))) & 0xffffu;
}

fn is_open(place: u32, row: u32, x: u32) -> bool {
    let texel = row * SLOT + x;
    return !gated || ((gate[place * GATE_WORDS + texel / 32u] >> (texel % 32u)) & 1u) != 0u;
}

// Equation 1 for a number P and a number C; `back` is the number before any edit.
fn number(p: f32, back: f32, cover: f32) -> f32 {
    let c = stroke.paint.x;
    if operation == ADD {
        return clamp(p + cover * c, stroke.low, stroke.top);
    }
    if operation == SUBTRACT {
        return clamp(p - cover * c, stroke.low, stroke.top);
    }
    let end = select(c, back, operation == RESTORE);
    return select(p + cover * (end - p), end, cover >= 1.0);
}

// A code's new value, a step nearer to an end where rounding would leave it where it was: weak strokes never stall short of it.
fn arriving(old: u32, new_code: u32, end: u32) -> u32 {
    if !to_end || new_code != old {
        return new_code;
    }
    return select(select(old, old - 1u, end < old), old + 1u, end > old);
}

fn code(old: u32, cover: f32, place: u32, row: u32, x: u32) -> u32 {
    var back = 0u;
    if operation == RESTORE {
        back = tight_code(base[(place * SLOT * SLOT + row) * 17u + x / 2u], x);
    }
    let new_code = u32(clamp(floor(number(f32(old), f32(back), cover) + 0.5), 0.0, TOP));
    return arriving(old, new_code, select(u32(floor(stroke.paint.x + 0.5)), back, operation == RESTORE));
}

// Per format: the new texel.
#ifdef SELECTION
fn texel(old: u32, cover: f32, place: u32, row: u32, x: u32) -> u32 {
    let new_code = u32(floor(number(f32(old), 0.0, cover) + 0.5));
    return arriving(old, new_code, select(u32(floor(stroke.paint.x + 0.5)), 0u, operation == RESTORE));
}
#else ifdef LABELS
fn texel(old: u32, cover: f32, place: u32, row: u32, x: u32) -> u32 {
    if cover < 0.5 || ((locked[old >> 5u] >> (old & 31u)) & 1u) != 0u {
        return old;
    }
    let label = u32(stroke.paint.x);
    if operation == RESTORE {
        return 0u;
    }
    if operation == SUBTRACT {
        return select(old, 0u, old == label);
    }
    return label;
}
#else ifdef CODES
fn texel(old: u32, cover: f32, place: u32, row: u32, x: u32) -> u32 {
    return code(old, cover, place, row, x);
}
#else ifdef CODES_IN_FLOATS
fn texel(old: u32, cover: f32, place: u32, row: u32, x: u32) -> u32 {
    let old_code = u32(floor(bitcast<f32>(old) * TOP + 0.5));
    let new_code = code(old_code, cover, place, row, x);
    return select(bitcast<u32>(f32(new_code) / TOP), old, new_code == old_code);
}
#else ifdef FLOATS
fn texel(old: u32, cover: f32, place: u32, row: u32, x: u32) -> u32 {
    var back = old;
    if operation == RESTORE {
        back = base[(place * SLOT * SLOT + row) * SLOT + x];
    }
    // What is not a number has nothing to mix with: it stays until it is covered wholly.
    let whole = cover >= 1.0;
    if !finite(old) || !finite(back) {
        let mixes = operation != ADD && operation != SUBTRACT;
        if !whole || !mixes {
            return old;
        }
        return select(bitcast<u32>(stroke.paint.x), back, operation == RESTORE);
    }
    if whole && operation == RESTORE {
        return back;
    }
    let p = bitcast<f32>(old);
    var value = number(p, bitcast<f32>(back), cover);
    let end = select(stroke.paint.x, bitcast<f32>(back), operation == RESTORE);
    if to_end && p != end {
        // Near the end as 16-bit codes would: no less than a step at a time, and the end from within one. Near is where a tenth of
        // the way is under half a step: a weaker brush goes by equation 1 until there.
        let outlying = stroke.least < stroke.greatest && (end < stroke.least || end > stroke.greatest);
        let step = select(stroke.step, abs(end) / TOP, outlying);
        let way = abs(end - p);
        if way <= 5.0 * step && abs(value - p) < 0.5 * step {
            value = select(p + step * sign(end - p), end, way <= step);
        }
        if value == p {
            return beside(old, end > p);
        }
    }
    return bitcast<u32>(value);
}
// A key that is ordered like the floats.
fn ordered(bits: u32) -> u32 {
    return select(bits | 0x80000000u, ~bits, bits >= 0x80000000u);
}
// The bits of the next float above or below.
fn beside(bits: u32, above: bool) -> u32 {
    let key = select(ordered(bits) - 1u, ordered(bits) + 1u, above);
    return select(~key, key & 0x7fffffffu, key >= 0x80000000u);
}
#else
fn texel(old: u32, cover: f32, place: u32, row: u32, x: u32) -> u32 {
    let p = unpack4x8unorm(old);
    let c = stroke.paint;
    if operation == SUBTRACT {
        return select(packed(vec4<f32>(p.rgb - cover * c.a * c.rgb, p.a)), old, p.a == 0.0);
    }
    // Amounts of paint.
    let paint = vec4<f32>(p.rgb * p.a, p.a);
    let added = vec4<f32>(c.rgb * c.a, c.a);
    var to = added;
    if operation == ADD {
        let sum = paint + cover * added;
        return straight(vec4<f32>(sum.rgb, min(sum.a, 1.0)));
    }
    if operation == BLEND {
        to = added + paint * (1.0 - c.a);
    } else if operation == RESTORE {
        to = vec4<f32>(0.0);
    }
    if cover >= 1.0 {
        return straight(to);
    }
    let mixed = straight(paint + cover * (to - paint));
    if to_end && mixed == old && old != 0u {
        return select(old - 0x01000000u, 0u, (old >> 24u) <= 1u);
    }
    return mixed;
}
fn straight(amount: vec4<f32>) -> u32 {
    if amount.a <= 0.0 {
        return 0u;
    }
    return packed(vec4<f32>(amount.rgb / amount.a, amount.a));
}
fn packed(colour: vec4<f32>) -> u32 {
    let steps = vec4<u32>(floor(clamp(colour, vec4<f32>(0.0), vec4<f32>(1.0)) * 255.0 + 0.5));
    let word = steps.x | (steps.y << 8u) | (steps.z << 16u) | (steps.w << 24u);
    return select(word, 0u, steps.w == 0u);
}
#endif

@compute @workgroup_size(8, 8, 4)
fn brush(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let job = jobs[items[0].first_job + group.x];
    let item = job >> 16u;
    choose(items[item].choices);
    let size = items[item].size;
    // The box's words in one row of invocations: a row of a slot rarely fills a workgroup's.
    let flat = (job & 0xffffu) * 256u + local;
    if flat >= size.x * size.y * size.z {
        return;
    }
    // Division in floats, exact for such small numbers: that of integers is done lane by lane on software Vulkan.
    let layer = u32((f32(flat) + 0.5) / f32(size.x * size.y));
    let within = flat - layer * size.x * size.y;
    let line = u32((f32(within) + 0.5) / f32(size.x));
    let step = vec3<u32>(within - line * size.x, line, layer);
    let at = items[item].lo + step;
    let place = items[item].place;
    let row = at.z * SLOT + at.y;
    let old_word = start[(place / LANES) * SLOT * SLOT * PITCH + (place % LANES) * ROW + row * PITCH + at.x];
    let first = items[item].first_dab;
    let count = items[item].dab_count;
    let bits = 32u / PER_WORD;
    let mask = 0xffffffffu >> (32u - bits);

    var new_word = 0u;
    var differs = false;
    for (var lane = 0u; lane < PER_WORD; lane += 1u) {
        let x = at.x * PER_WORD + lane;
        if x >= SLOT {
            break;
        }
        let voxel = items[item].origin + vec3<i32>(vec3<u32>(x, at.yz));
        let shown = clamp(voxel, vec3<i32>(0), stroke.dims - 1);
        let index = place * SLOT_TEXELS + row * SLOT + x;
        let before = coverage[index];
        let state = gathered(before, shown, first, count);
        coverage[index] = state;
        let old = (old_word >> (bits * lane)) & mask;
        let cover = cover_of(state);
        var new_texel = old;
        if cover > 0.0 && is_open(place, row, x) {
            new_texel = texel(old, cover, place, row, x);
        }
        new_word |= new_texel << (bits * lane);
        let t = vec3<u32>(x, at.yz);
        let own = all(t >= vec3<u32>(1u)) && all(t <= vec3<u32>(32u)) && all(voxel == shown);
        differs = differs || (own && new_texel != old);
    }
    next[items[item].next + (step.z * size.y + step.y) * PITCH + step.x] = new_word;
    if differs && atomicLoad(&changed[place]) == 0u {
        atomicStore(&changed[place], 1u);
    }
}
