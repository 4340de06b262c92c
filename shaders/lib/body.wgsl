#define_import_path burin::body
// Bodies and rays: from a pixel to the half-open interval of lattice samples in which its ray is inside a body.
// Samples lie at t = k·step_mm along the unit ray; k counts from the eye (from the image plane in orthographic projection).
//
// No branch here hangs on a uniform's value alone: Mesa's software Vulkan (22.3) takes such a value for a constant, compiles the
// whole shader anew for every draw, and keeps each one, a megabyte and more, as long as the pipeline lives.

#import burin::constants::{MOST_BODIES, MOST_PLANES, MOST_HOLES, NO_HOLE, TILE, LIST_WIDTH, MERGE_MARK, MODE_DVR}
#import burin::field::{enter_volume, last_cell, info}

struct View {
    corner: vec3<f32>,          // ray through the picture's corner: from the eye, before it is given length 1
    step_mm: f32,
    dx: vec3<f32>,              // its change from pixel to pixel
    perspective: u32,
    dy: vec3<f32>,
    iso: f32,                   // texel of the iso-surface
    forward: vec3<f32>,
    table_scale: f32,           // entry of the table = texel·scale + bias
    lighting: vec4<f32>,        // ambient, diffuse, specular, power
    selection_colour: vec3<f32>,
    table_bias: f32,
    colour_opacity: f32,
    label_opacity: f32,
    selection_opacity: f32,
    k_from: f32,                // this pass marches k_from ≤ k < k_to
    k_to: f32,
    width: u32,                 // pixels of the window
    height: u32,
    unused_a: u32,
    above_a: vec3<u32>,         // first cell of the map of what lies above a texel: maxima
    from_a: f32,                // that texel; FAR where there is no such map
    above_b: vec3<u32>,
    from_b: f32,
    above_c: vec3<u32>,
    from_c: f32,
    ball_centre: vec3<f32>,     // of a ball that divides rays, world mm as seen from the eye
    ball_radius: f32,           // mm
    ball_keeps: u32,            // what of a ray is drawn: KEEPS_BEFORE, KEEPS_INSIDE or KEEPS_BEHIND it
    unused_b: u32,
    unused_c: u32,
    unused_d: u32,
}

struct CastBody {
    column_x: vec3<f32>,        // index_from_world of the posed body, by columns
    first_plane: u32,
    column_y: vec3<f32>,
    plane_count: u32,
    column_z: vec3<f32>,
    mask: u32,                  // lowest two bits: 0 none, 1 selection, 2 background; above them the layer of its cuts and 1, 0 for none
    eye: vec3<f32>,             // the eye in index space
    code: u32,                  // what the picture's object id says, even; + 1 where its volume is selected
    lo: vec3<f32>,              // its box in index space
    first_hole: u32,            // the boxes of finer volumes in its family, as posed: hosts before what is cut out of them
    hi: vec3<f32>,
    hole_count: u32,
    tint: vec3<f32>,
    own_hole: u32,              // the one that it fills itself; NO_HOLE if it is none
}

// A box of a volume that a finer one fills, as its host is posed.
struct Hole {
    column_x: vec3<f32>,        // index_from_world of the host's body, by columns
    steps: f32,                 // samples of the finer one in a step of the lattice; 0 behind the last
    column_y: vec3<f32>,
    host_hole: u32,             // the hole that its host fills; NO_HOLE if it fills none
    column_z: vec3<f32>,
    host: u32,                  // its host's place among the volumes that the picture shows
    eye: vec3<f32>,             // the eye in the host's index space
    texel_ratio: f32,           // a texel of the density of the host that fills no hole in texels of the finer one
    lo: vec3<f32>,              // in the host's index space
    texel_bias: f32,            // finer texel = that texel · ratio + bias
    hi: vec3<f32>,
    volume: u32,                // the place of what fills it among the volumes that the picture shows
    scale: vec3<f32>,           // samples a voxel of the host
    seamless: u32,              // whether both are shown alike
}

// What a body shows: the numbers that its volume's texels mean to its look, and how its volume's painted fields show.
struct BodyMatter {
    skip_place: vec3<u32>,      // the first cell of its map of empty space
    volume: u32,                // place among the volumes that the picture shows
    table_scale: f32,           // entry of the table = texel·scale + bias
    table_bias: f32,
    iso: f32,                   // texel of the iso-surface
    row: i32,                   // of the table of looks; less than 0: nothing shows
    overlay: vec3<f32>,         // opacities of painted colour, labels, selection
    segments_row: u32,          // of the volume's first row of segment colours
    mode: u32,
    label_rows: u32,            // the first row of its looks by label, NO_ROWS if they do not go by label
    last_label: u32,            // all labels beyond it have its look
    least_iso: f32,             // the least texel of the iso-surface of any label's look
    selection_colour: vec3<f32>,
    kin: u32,                   // the first body of those that are one but for boxes of finer volumes
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> bodies: array<CastBody, MOST_BODIES>;
@group(0) @binding(2) var<uniform> planes: array<vec4<f32>, MOST_PLANES>;
@group(0) @binding(3) var tile_heads: texture_2d<u32>;
@group(0) @binding(4) var tile_lists: texture_2d<u32>;
@group(0) @binding(10) var<uniform> matters: array<BodyMatter, MOST_BODIES>;
#ifdef HOLES
@group(0) @binding(12) var<uniform> holes: array<Hole, MOST_HOLES>;

// Samples in a step of the lattice, of the body whose ray was made last.
var<private> lattice: f32 = 1.0;
#endif

// A pixel's ray in world mm: `start` as seen from the eye.
struct Ray {
    start: vec3<f32>,
    dir: vec3<f32>,
}

// The same in a body's index space, per step of the lattice.
struct BodyRay {
    body: u32,
    mask: u32,
    o: vec3<f32>,
    d: vec3<f32>,
    cell_o: vec3<f32>,
    cell_d: vec3<f32>,
    cell_i: vec3<f32>,          // 1 / cell_d
    within: vec2<f32>,          // where it is inside the body, in steps, once that is known
    skip_place: vec3<u32>,
    cell_last: vec3<f32>,       // its last cell
    world: mat3x3<f32>,         // transposed it takes gradients to the world
    tint: vec3<f32>,
#ifdef HOLES
    hole: u32,                  // that it fills; NO_HOLE if none
    steps: f32,                 // its samples in a step of the lattice
    span: vec2<f32>,            // the samples of `within`: from x on, before y
    joins: vec2<bool>,          // whether matter that is shown alike goes on before and behind it
    before: f32,                // the last sample of what lies before it, where stretches reach from there
#endif
}

#ifdef OWN_LOOKS
// Of the body whose ray was made last; with LABEL_LOOKS, of the matter that was looked at last.
var<private> meaning: BodyMatter;
#endif

#ifndef OWN_LOOKS
// Read once: where lanes part software Vulkan reads a uniform's member lane by lane.
var<private> table_map: vec2<f32>;
var<private> light_of: vec4<f32>;
#endif

// Entry of the table for a texel of the body whose ray was made last.
fn table_place(texel: f32) -> f32 {
#ifdef OWN_LOOKS
    return texel * meaning.table_scale + meaning.table_bias;
#else
    return texel * table_map.x + table_map.y;
#endif
}

// The same as a place between entries: an entry's middle is a whole number.
fn table_x(texel: f32) -> f32 {
#ifdef OWN_LOOKS
    return texel * meaning.table_scale + (meaning.table_bias - 0.5);
#else
    return texel * table_map.x + (table_map.y - 0.5);
#endif
}

// The row of the table that is its look's; where samples stand for stretches, the row behind it has its integrals.
fn table_row() -> i32 {
#ifdef OWN_LOOKS
    return meaning.row;
#else
    return 0;
#endif
}

// The texel of its iso-surface.
fn iso_texel() -> f32 {
#ifdef OWN_LOOKS
    return meaning.iso;
#else
    return view.iso;
#endif
}

// The least texel of the iso-surface that any of its matter has.
fn least_iso_texel() -> f32 {
#ifdef OWN_LOOKS
    return meaning.least_iso;
#else
    return view.iso;
#endif
}

// Its mode.
fn body_mode() -> u32 {
#ifdef OWN_LOOKS
    return meaning.mode;
#else
    return MODE_DVR;
#endif
}

// Opacities of painted colour, labels and selection over it.
fn overlay_strengths() -> vec3<f32> {
#ifdef OWN_LOOKS
    return meaning.overlay;
#else
    return vec3<f32>(view.colour_opacity, view.label_opacity, view.selection_opacity);
#endif
}

// The colour that the selection is tinted with.
fn selection_colour() -> vec3<f32> {
#ifdef OWN_LOOKS
    return meaning.selection_colour;
#else
    return view.selection_colour;
#endif
}

// The first row of its volume's segment colours.
fn first_segments() -> u32 {
#ifdef OWN_LOOKS
    return meaning.segments_row;
#else
    return 0u;
#endif
}

fn ray_through(px: vec2<f32>) -> Ray {
    let v = view.corner + view.dx * px.x + view.dy * px.y;
    // Chosen, not branched on; see the head.
    let diverging = view.perspective != 0u;
    return Ray(
        select(v - view.forward, vec3<f32>(0.0), diverging),
        select(view.forward, normalize(v), diverging),
    );
}

// The bodies that a pixel's tile lists: the first place in the lists, how many, and whether they overlap without an order.
struct Listed {
    first: u32,
    count: u32,
    merge: bool,
}

fn listed_at(px: vec2<f32>) -> Listed {
    let head = textureLoad(tile_heads, vec2<i32>(vec2<u32>(px) / TILE), 0).rg;
    return Listed(head.x, head.y & ~MERGE_MARK, (head.y & MERGE_MARK) != 0u);
}

// The body at a place of the lists.
fn body_at(i: u32) -> u32 {
    return textureLoad(tile_lists, vec2<i32>(vec2<u32>(i % LIST_WIDTH, i / LIST_WIDTH)), 0).r;
}

fn matrix_of(b: u32) -> mat3x3<f32> {
    return mat3x3<f32>(bodies[b].column_x, bodies[b].column_y, bodies[b].column_z);
}

fn body_ray(b: u32, ray: Ray) -> BodyRay {
    let m = matrix_of(b);
    enter_volume(matters[b].volume);
#ifdef OWN_LOOKS
    meaning = matters[b];
#endif
    var r: BodyRay;
    r.skip_place = matters[b].skip_place;
    r.cell_last = last_cell();
    r.world = m;
    r.tint = bodies[b].tint;
#ifndef OWN_LOOKS
    table_map = vec2<f32>(view.table_scale, view.table_bias);
    light_of = view.lighting;
#endif
#ifdef HOLES
    r.hole = bodies[b].own_hole;
    r.steps = select(holes[min(r.hole, MOST_HOLES - 1u)].steps, 1.0, r.hole == NO_HOLE);
    lattice = r.steps;
#endif
    r.body = b;
    r.mask = bodies[b].mask & 3u;
    r.o = bodies[b].eye + m * ray.start;
    let d = m * ray.dir * view.step_mm;
    // A component of exactly 0 has no reciprocal; one this small moves no sample.
    r.d = select(d, vec3<f32>(1e-20), abs(d) < vec3<f32>(1e-20));
    let cells = 1.0 / f32(info.cell);
    r.cell_o = (r.o + 0.5) * cells;
    r.cell_d = r.d * cells;
    r.cell_i = 1.0 / r.cell_d;
    return r;
}

#ifdef HOLES
// Where a ray is inside a hole, in steps; x ≥ y where it is not.
fn hole_span(i: u32, ray: Ray) -> vec2<f32> {
    let m = mat3x3<f32>(holes[i].column_x, holes[i].column_y, holes[i].column_z);
    let o = holes[i].eye + m * ray.start;
    let along = m * ray.dir * view.step_mm;
    let inverse = 1.0 / select(along, vec3<f32>(1e-20), abs(along) < vec3<f32>(1e-20));
    let a = (holes[i].lo - o) * inverse;
    let b = (holes[i].hi - o) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    return vec2<f32>(max(max(near.x, near.y), max(near.z, 0.0)), min(min(far.x, far.y), far.z));
}
#endif

#ifdef HOLES
// How far from a whole number the product of a sample's place and the samples in a step may be: places are rounded.
const ROUNDED: f32 = 5e-7;

// A whole number that is as good as one that is none for rounding alone; else `other`.
fn whole_or(other: f32, x: f32) -> f32 {
    let n = round(x);
    return select(other, n, abs(x - n) <= ROUNDED * x);
}

// The first sample at or after a place, of so many in a step.
fn sample_on(steps: f32, place: f32) -> f32 {
    let x = place * steps;
    return select(whole_or(ceil(x), x), ceil(x), steps == 1.0) / steps;
}

// The last one at or before it.
fn sample_up_to(steps: f32, place: f32) -> f32 {
    let x = place * steps;
    return whole_or(floor(x), x) / steps;
}
#endif

// The first sample at or after a place of the ray of the body that was made last.
fn sample_from(place: f32) -> f32 {
#ifdef HOLES
    return sample_on(lattice, place);
#else
    return ceil(place);
#endif
}

// The sample after one.
fn sample_after(k: f32) -> f32 {
#ifdef HOLES
    // Samples may lie halfway between two; a quarter is more than rounding.
    return (floor(k * lattice + 0.25) + 1.0) / lattice;
#else
    return k + 1.0;
#endif
}

// The distance of samples, in steps.
fn sample_distance() -> f32 {
#ifdef HOLES
    return 1.0 / lattice;
#else
    return 1.0;
#endif
}

// What planes leave of a way along the ray.
fn between_planes(r: BodyRay, ray: Ray, way: vec2<f32>) -> vec2<f32> {
    var t0 = way.x;
    var t1 = way.y;
    let first = bodies[r.body].first_plane;
    let count = bodies[r.body].plane_count;
    for (var i = 0u; i < count; i += 1u) {
        let plane = planes[first + i];
        let distance = plane.w + dot(plane.xyz, ray.start);
        let slope = dot(plane.xyz, ray.dir) * view.step_mm;
        if (slope == 0.0) {
            t1 = select(t1, -1.0, distance > 0.0);
        } else {
            let t = -distance / slope;
            t0 = select(max(t0, t), t0, slope > 0.0);
            t1 = select(t1, min(t1, t), slope > 0.0);
        }
    }
    return vec2<f32>(t0, t1);
}

// Where the ray is inside the body, in steps: from x to y; x ≥ y where it is not.
fn interval(r: BodyRay, ray: Ray) -> vec2<f32> {
    let inverse = r.cell_i / f32(info.cell);
    let a = (bodies[r.body].lo - r.o) * inverse;
    let b = (bodies[r.body].hi - r.o) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    var way = vec2<f32>(max(max(near.x, near.y), max(near.z, 0.0)), min(min(far.x, far.y), far.z));
#ifdef HOLES
    // By the numbers of its host, so that both agree to the last bit where one ends and the other begins.
    way = select(hole_span(min(r.hole, MOST_HOLES - 1u), ray), way, r.hole == NO_HOLE);
#endif
    return between_planes(r, ray, way);
}
