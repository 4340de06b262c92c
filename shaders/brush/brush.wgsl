// One frame's dabs, into every slot that shows them: Direct Volume Editing (2008), equations 1 and 2, in the form
// P' = P + G ((C op P) - P), G = strength F(d), F = 0 beyond the support.
// A stroke gathers coverage and is applied once to the texels at its start. One invocation takes a row of a slot's box, twelve
// texels at a time: what it reads of its item and its dabs costs more on software Vulkan than what it calculates with them.
// Apron texels are computed like all others, from the voxel they repeat, so neighbouring slots agree without exchange.
// A stroke's first dab is laid by itself (ONE_DAB): most strokes are one click, which needs to remember no coverage, and a dab that
// all invocations read at the same place is read once.

#import burin::constants::{GATE_WORDS, ROWS_AT_ONCE, ROW_PITCH_BYTES, SLOT}
#import burin::coverage::{cover_of, g_of, gathered, kept_of, state_of}
#import burin::stroke::{Choices, RESTORE, SUBTRACT, choices_of, items, stroke}
#ifdef SELECTION
#import burin::equation::{short_code}
#endif
#ifdef CODES
#import burin::equation::{code}
#endif
#ifdef CODES_IN_FLOATS
#import burin::equation::{TOP, code}
#endif
#ifdef COLOUR
#import burin::equation_colour::{colours}
#endif
#ifdef FLOATS
#import burin::equation_floats::{finite, float}
#endif

// Rows of texels in a slot.
const ROWS: u32 = SLOT * SLOT;
// Fours of texels in a slot's row.
const QUADS: u32 = (SLOT + 3u) / 4u;

// Four texels of the pool's format in words.
#ifdef SELECTION
alias Quad = u32;
const QUAD_WORDS: u32 = 1u;
#endif
#ifdef LABELS
alias Quad = vec2<u32>;
const QUAD_WORDS: u32 = 2u;
#endif
#ifdef CODES
alias Quad = vec2<u32>;
const QUAD_WORDS: u32 = 2u;
#endif
#ifdef CODES_IN_FLOATS
alias Quad = vec4<u32>;
const QUAD_WORDS: u32 = 4u;
#endif
#ifdef COLOUR
alias Quad = vec4<u32>;
const QUAD_WORDS: u32 = 4u;
#endif
#ifdef FLOATS
alias Quad = vec4<u32>;
const QUAD_WORDS: u32 = 4u;
#endif

// Fours of texels between rows of `start` and `next`, which are as far apart as copies from and to textures want them.
const PITCH: u32 = ROW_PITCH_BYTES / (4u * QUAD_WORDS);
// How many slots lie side by side in `start`.
const SLOTS_PER_ROW: u32 = PITCH / QUADS;

// The slots' texels at the stroke's start.
@group(0) @binding(3) var<storage, read> start: array<Quad>;
// The texels' coverage so far.
@group(0) @binding(4) var<storage, read_write> coverage: array<vec4<u32>>;
// The boxes' new texels, rows at PITCH.
@group(0) @binding(5) var<storage, read_write> next: array<Quad>;
// Not 0 for slots in which a voxel of their own differs from the start.
@group(0) @binding(6) var<storage, read_write> changed: array<atomic<u32>>;
// Unedited density, tight rows of the host's texels; with GOALS four numbers for every texel, where it is led to by a coverage of 1/4, 1/2,
// 3/4 and 1.
@group(0) @binding(7) var<storage, read> base: array<u32>;
// A bit for every texel of a slot, set where the range of values lets the brush paint: the host compares the values themselves.
@group(0) @binding(8) var<storage, read> gate: array<u32>;
// Bit of every locked label.
@group(0) @binding(9) var<storage, read> locked: array<u32>;
// Per workgroup: number of its item, and of the workgroup within the item's box in the lower 16 bits. Without it as many
// workgroups as the largest box needs would run for every item, and idle ones cost as much as busy ones on software Vulkan.
@group(0) @binding(10) var<storage, read> jobs: array<u32>;

// A slot's row: `line` counts the rows of all slots.
struct Row {
    line: u32,
    // Voxel of its first texel.
    voxel: vec3<i32>,
    // That voxel's y and z, or those of the voxel that it repeats.
    yz: vec2<i32>,
    // Whether the voxels of its brick lie in it, and in the volume.
    own: bool,
}

@compute @workgroup_size(ROWS_AT_ONCE)
fn brush(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let job = jobs[items[0].first_job + group.x];
    let item = items[job >> 16u];
    let does = choices_of(item.choices);
    let flat = (job & 0xffffu) * ROWS_AT_ONCE + local;
    if flat >= item.size.y * item.size.z {
        return;
    }
    // Division in floats, exact for such small numbers: that of integers is done lane by lane on software Vulkan.
    let layer = u32((f32(flat) + 0.5) / f32(item.size.y));
    let at = item.lo.yz + vec2<u32>(flat - layer * item.size.y, layer);
    let within = at.y * SLOT + at.x;
    var row: Row;
    row.line = item.place * ROWS + within;
    row.voxel = item.origin + vec3<i32>(vec3<u32>(0u, at));
    row.yz = clamp(row.voxel.yz, vec2<i32>(0), stroke.dims.yz - 1);
    row.own = all(at >= vec2<u32>(1u)) && all(at <= vec2<u32>(SLOT - 2u)) && all(row.yz == row.voxel.yz);
    let source = ((item.place / SLOTS_PER_ROW) * ROWS + within) * PITCH + (item.place % SLOTS_PER_ROW) * QUADS;
    let to = (item.next + flat) * PITCH;
    let end = item.lo.x + item.size.x;

    var differs = false;
    for (var first = item.lo.x; first < end; first += 3u) {
        // Loads beyond the box are of no use and do no harm.
        let kept = row.line * QUADS + first;
        var a = state_of(vec4<u32>(0u), does);
        var b = a;
        var c = a;
#ifndef ONE_DAB
        a = state_of(coverage[kept], does);
        b = state_of(coverage[kept + 1u], does);
        c = state_of(coverage[kept + 2u], does);
#endif
        let x = shown(row, first);
        let xb = shown(row, first + 1u);
        let xc = shown(row, first + 2u);
#ifdef ONE_DAB
        a = gathered(a, g_of(0u, x, row.yz, does.falloff), does);
        b = gathered(b, g_of(0u, xb, row.yz, does.falloff), does);
        c = gathered(c, g_of(0u, xc, row.yz, does.falloff), does);
#else
        for (var i = item.first_dab; i < item.first_dab + item.dab_count; i += 1u) {
            a = gathered(a, g_of(i, x, row.yz, does.falloff), does);
            b = gathered(b, g_of(i, xb, row.yz, does.falloff), does);
            c = gathered(c, g_of(i, xc, row.yz, does.falloff), does);
        }
#endif
        for (var n = 0u; n < min(3u, end - first); n += 1u) {
            let quad = first + n;
            let state = select(select(a, b, n == 1u), c, n == 2u);
#ifndef ONE_DAB
            coverage[kept + n] = kept_of(state, does);
#endif
            let cover = cover_of(state, does) * inside(row, quad);
            let old = texels(start[source + quad]);
            let paints = (cover > vec4<f32>(0.0)) & open(row, within, item.place, quad, does);
            let new_texels = select(old, painted(old, cover, row, quad, does), paints);
            next[to + quad - item.lo.x] = words(new_texels);
            differs = differs || any(vec4<bool>(row.own) & owned(row, quad) & (new_texels != old));
        }
    }
    if differs && atomicLoad(&changed[item.place]) == 0u {
        atomicStore(&changed[item.place], 1u);
    }
}

// How much of a stroke there is at four texels: less in the band at the faces of a box of a volume.
fn inside(row: Row, quad: u32) -> vec4<f32> {
    let last = vec3<f32>(stroke.dims - 1);
    let x = vec4<f32>(shown(row, quad));
    let yz = vec2<f32>(row.yz);
    let across = min(yz, last.yz - yz) * stroke.band.yz;
    let along = min(x, last.x - x) * stroke.band.x;
    return clamp(min(along, vec4<f32>(min(across.x, across.y))) + stroke.band.w, vec4<f32>(0.0), vec4<f32>(1.0));
}

// x of the voxels that four texels show.
fn shown(row: Row, quad: u32) -> vec4<i32> {
    let x = vec4<i32>(row.voxel.x + i32(quad * 4u)) + vec4<i32>(0, 1, 2, 3);
    return clamp(x, vec4<i32>(0), vec4<i32>(stroke.dims.x - 1));
}

// Which of four texels are voxels of the slot's own brick, and not of an apron or repeated, as far as x says.
fn owned(row: Row, quad: u32) -> vec4<bool> {
    let t = vec4<u32>(quad * 4u) + vec4<u32>(0u, 1u, 2u, 3u);
    let repeats = shown(row, quad) != vec4<i32>(t) + row.voxel.x;
    return (t >= vec4<u32>(1u)) & (t <= vec4<u32>(SLOT - 2u)) & !repeats;
}

// Which of four texels may be painted.
fn open(row: Row, within: u32, place: u32, quad: u32, does: Choices) -> vec4<bool> {
    var bits = 15u;
    if does.gated {
        let texel = within * SLOT + quad * 4u;
        let word = place * GATE_WORDS + texel / 32u;
        let low = gate[word] >> (texel % 32u);
        // A shift by 32 in two steps is one by 32.
        let high = (gate[word + 1u] << 1u) << (31u - texel % 32u);
        bits = low | high;
    }
    return (vec4<u32>(bits) & vec4<u32>(1u, 2u, 4u, 8u)) != vec4<u32>(0u);
}

#ifdef SELECTION
fn texels(quad: Quad) -> vec4<u32> {
    return (vec4<u32>(quad) >> vec4<u32>(0u, 8u, 16u, 24u)) & vec4<u32>(0xffu);
}
fn words(t: vec4<u32>) -> Quad {
    return t.x | (t.y << 8u) | (t.z << 16u) | (t.w << 24u);
}
fn painted(old: vec4<u32>, cover: vec4<f32>, row: Row, quad: u32, does: Choices) -> vec4<u32> {
#ifdef GOALS
    let to = toward(vec4<f32>(old), cover, row, quad);
    return vec4<u32>(clamp(floor(to + 0.5), vec4<f32>(0.0), vec4<f32>(255.0)));
#else
    return short_code(old, cover, does);
#endif
}
#endif

#ifdef LABELS
fn texels(quad: Quad) -> vec4<u32> {
    return halves(quad);
}
fn words(t: vec4<u32>) -> Quad {
    return pairs(t);
}
fn painted(old: vec4<u32>, cover: vec4<f32>, row: Row, quad: u32, does: Choices) -> vec4<u32> {
    let label = vec4<u32>(u32(stroke.paint.x));
    let keys = vec4<u32>(locked[old.x >> 5u], locked[old.y >> 5u], locked[old.z >> 5u], locked[old.w >> 5u]);
    let held = ((keys >> (old & vec4<u32>(31u))) & vec4<u32>(1u)) != vec4<u32>(0u);
    let taken = select(old, vec4<u32>(0u), old == label);
    var to = select(label, taken, does.operation == SUBTRACT);
    to = select(to, vec4<u32>(0u), does.operation == RESTORE);
    return select(to, old, held | (cover < vec4<f32>(0.5)));
}
#endif

#ifdef CODES
fn texels(quad: Quad) -> vec4<u32> {
    return halves(quad);
}
fn words(t: vec4<u32>) -> Quad {
    return pairs(t);
}
fn painted(old: vec4<u32>, cover: vec4<f32>, row: Row, quad: u32, does: Choices) -> vec4<u32> {
#ifdef GOALS
    return led(old, cover, row, quad);
#else
    return code(old, codes_before(row, quad, does), cover, does);
#endif
}
#endif

#ifdef CODES_IN_FLOATS
fn texels(quad: Quad) -> vec4<u32> {
    return quad;
}
fn words(t: vec4<u32>) -> Quad {
    return t;
}
fn painted(old: vec4<u32>, cover: vec4<f32>, row: Row, quad: u32, does: Choices) -> vec4<u32> {
    let old_code = vec4<u32>(floor(bitcast<vec4<f32>>(old) * TOP + 0.5));
#ifdef GOALS
    let new_code = led(old_code, cover, row, quad);
#else
    let new_code = code(old_code, codes_before(row, quad, does), cover, does);
#endif
    return select(bitcast<vec4<u32>>(vec4<f32>(new_code) / TOP), old, new_code == old_code);
}
#endif

#ifdef COLOUR
fn texels(quad: Quad) -> vec4<u32> {
    return quad;
}
fn words(t: vec4<u32>) -> Quad {
    return t;
}
fn painted(old: vec4<u32>, cover: vec4<f32>, row: Row, quad: u32, does: Choices) -> vec4<u32> {
    return colours(old, cover, does);
}
#endif

#ifdef FLOATS
fn texels(quad: Quad) -> vec4<u32> {
    return quad;
}
fn words(t: vec4<u32>) -> Quad {
    return t;
}
fn painted(old: vec4<u32>, cover: vec4<f32>, row: Row, quad: u32, does: Choices) -> vec4<u32> {
#ifdef GOALS
    let to = bitcast<vec4<u32>>(toward(bitcast<vec4<f32>>(old), cover, row, quad));
    let whole = bitcast<vec4<u32>>(toward(bitcast<vec4<f32>>(old), vec4<f32>(1.0), row, quad));
    // What is not a number has nothing to mix with: it stays until it is covered wholly.
    let number = vec4<bool>(finite(old.x), finite(old.y), finite(old.z), finite(old.w));
    let held = select(old, whole, cover >= vec4<f32>(1.0));
    return select(held, to, number);
#else
    var back = old;
    if does.operation == RESTORE {
        let first = row.line * SLOT + quad * 4u;
        back = vec4<u32>(base[first], base[first + 1u], base[first + 2u], base[first + 3u]);
    }
    return float(old, back, cover, does);
#endif
}
#endif

// Texels of 16 bits.
fn halves(words: vec2<u32>) -> vec4<u32> {
    return (words.xxyy >> vec4<u32>(0u, 16u, 0u, 16u)) & vec4<u32>(0xffffu);
}

fn pairs(t: vec4<u32>) -> vec2<u32> {
    return t.xz | (t.yw << vec2<u32>(16u));
}

#ifdef GOALS
// Where four numbers come by their coverage: straight between the goals of 0, which is the number itself, 1/4, 1/2, 3/4 and 1.
fn toward(p: vec4<f32>, cover: vec4<f32>, row: Row, quad: u32) -> vec4<f32> {
    let first = (row.line * SLOT + quad * 4u) * 4u;
    return vec4<f32>(
        way(p.x, first, cover.x),
        way(p.y, first + 4u, cover.y),
        way(p.z, first + 8u, cover.z),
        way(p.w, first + 12u, cover.w),
    );
}

fn way(p: f32, at: u32, cover: f32) -> f32 {
    let goals = bitcast<vec4<f32>>(vec4<u32>(base[at], base[at + 1u], base[at + 2u], base[at + 3u]));
    let share = clamp(vec4<f32>(4.0 * cover) - vec4<f32>(0.0, 1.0, 2.0, 3.0), vec4<f32>(0.0), vec4<f32>(1.0));
    let moved = p + dot(goals - vec4<f32>(p, goals.xyz), share);
    return select(moved, goals.w, cover >= 1.0);
}

// Codes of 16 bits on that way.
fn led(old: vec4<u32>, cover: vec4<f32>, row: Row, quad: u32) -> vec4<u32> {
    let to = toward(vec4<f32>(old), cover, row, quad);
    return vec4<u32>(clamp(floor(to + 0.5), vec4<f32>(0.0), vec4<f32>(65535.0)));
}
#endif

// The codes of unedited density, where they matter. A row is 17 words.
fn codes_before(row: Row, quad: u32, does: Choices) -> vec4<u32> {
    if does.operation != RESTORE {
        return vec4<u32>(0u);
    }
    let first = row.line * (SLOT / 2u) + quad * 2u;
    return halves(vec2<u32>(base[first], base[first + 1u]));
}
