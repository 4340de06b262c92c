// Direct volume rendering: bodies in order of sight one after another, or (MERGE) any number of overlapping intervals at once.
//
// A ray skips until a cell may show something, then samples a run inside one brick that ignores cell borders; light and paint
// are evaluated outside the sampling loop, once per sample that shows. Overlapping bodies add extinctions, colours weighted by
// extinction.

#import burin::body::{
    Sight, BodyRay, Run, view, bodies, sight_of, head_of, listed, ray_of, interval, skip_empty, run_from, run_texel, FAR, MERGE as MERGE_TILE
}
#import burin::field::{Page, brick_of, selection_page, selection_at}
#import burin::look::{table_at, share, opacity_of_share, painted, gradient, lit, facing}

#ifdef RESUME
@group(0) @binding(7) var before_colour: texture_2d<f32>;
@group(0) @binding(8) var before_depth: texture_2d<f32>;
@group(0) @binding(9) var before_object: texture_2d<u32>;
#endif

const THRESHOLD: f32 = 1.0 / 256.0;
const RUN: f32 = 32.0;
// Extinction that stands for an opaque sample: finite, so that overlapping ones share the colour.
const OPAQUE: f32 = 1.0e6;

struct Picture {
    @location(0) colour: vec4<f32>,
    @location(1) depth: f32,
    @location(2) object: u32,
}

// The ray's state: colour so far, transmittance, the sample at which opacity reached ½ and its body.
var<private> rgb: vec3<f32>;
var<private> clear: f32;
var<private> half_at: f32;
var<private> half_body: u32;

fn add(c: vec4<f32>, k: f32) {
    half_at = select(half_at, k, clear > 0.5);
    rgb += clear * c.a * c.rgb;
    clear *= 1.0 - c.a;
}

// The share, paint and light of the visible sample k: display colour and opacity.
fn evaluate(r: BodyRay, page: Page, selection: Page, k: f32, texel: f32, c: vec4<f32>) -> vec4<f32> {
    let p = r.o + r.d * k;
    var s = 0.0;
    var out = c;
#ifdef SELECTION
    s = selection_at(selection, p);
    if (r.mask != 0u) {
        out.a = opacity_of_share(c.a, share(r.mask, s));
    }
#endif
    var colour = painted(c.rgb, p, s) * bodies[r.body].tint;
#ifdef LIT
    colour = lit(colour, facing(r, gradient(page, p), texel));
#endif
    return vec4<f32>(colour, out.a);
}

// Where a run shows something next.
struct Found {
    k: f32,                     // the sample after it
    texel: f32,
    c: vec4<f32>,               // what the table makes of it; clear if nothing more shows
}

fn seek(run: Run, first: f32) -> Found {
    var found = Found(first, 0.0, vec4<f32>(0.0));
    loop {
        if (found.k >= run.end) {
            break;
        }
        found.texel = run_texel(run, found.k);
        found.c = table_at(found.texel);
        found.k += 1.0;
        if (found.c.a > 0.0) {
            break;
        }
    }
    return found;
}

// The page of the selection that a run's samples need, if any is asked for.
fn selection_of(run: Run) -> Page {
#ifdef SELECTION
    return selection_page(run.brick);
#else
    return run.page;
#endif
}

fn march(r: BodyRay, k0: f32, k1: f32) {
    var k = k0;
    if (clear > 0.5) {
        half_body = r.body;
    }
    loop {
        k = skip_empty(r, k, k1);
        if (k >= k1 || clear < THRESHOLD) {
            break;
        }
        let run = run_from(r, k, min(k1, k + RUN));
#ifdef STAGED
        let selection = selection_of(run);
        loop {
            let found = seek(run, k);
            k = found.k;
            if (found.c.a > 0.0) {
                add(evaluate(r, run.page, selection, k - 1.0, found.texel, found.c), k - 1.0);
            }
            if (k >= run.end || clear < THRESHOLD) {
                break;
            }
        }
#else
        // Asked at the end: software Vulkan runs what follows a break once more for nothing.
        loop {
            add(table_at(run_texel(run, k)), k);
            k += 1.0;
            continuing {
                break if k >= run.end || clear < THRESHOLD;
            }
        }
#endif
    }
}

#ifdef MERGE
// Intervals that a ray can hold.
#ifdef UP_TO_ALL
const CAPACITY: u32 = 512u;
#else
#ifdef UP_TO_64
const CAPACITY: u32 = 64u;
#else
#ifdef UP_TO_16
const CAPACITY: u32 = 16u;
#else
const CAPACITY: u32 = 4u;
#endif
#endif
#endif
const SHARED_RUN: u32 = 16u;
// So many samples of one body are not worth the merging of several.
const ALONE: f32 = 8.0;

// Extinction-weighted colour and extinction of a run of samples in which several bodies overlap, and its strongest body.
var<private> matter: array<vec4<f32>, SHARED_RUN>;
var<private> strongest: array<vec2<f32>, SHARED_RUN>;

fn mix_in(c: vec4<f32>, i: u32, body: u32) {
    let extinction = select(-log(1.0 - c.a), OPAQUE, c.a >= 0.999999);
    matter[i] += vec4<f32>(c.rgb * extinction, extinction);
    if (extinction > strongest[i].x) {
        strongest[i] = vec2<f32>(extinction, f32(body));
    }
}

// Adds a body's samples k0 ≤ k < k1, less than SHARED_RUN after `first`, to `matter`.
fn gather(r: BodyRay, first: f32, k0: f32, k1: f32) {
    var k = k0;
    loop {
        k = skip_empty(r, k, k1);
        if (k >= k1) {
            break;
        }
        let run = run_from(r, k, k1);
        let selection = selection_of(run);
        loop {
            let found = seek(run, k);
            k = found.k;
            if (found.c.a > 0.0) {
                let c = evaluate(r, run.page, selection, k - 1.0, found.texel, found.c);
                mix_in(c, u32(k - 1.0 - first), r.body);
            }
            if (k >= run.end) {
                break;
            }
        }
    }
}
#endif

@vertex
fn cover(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn march_pixel(@builtin(position) at: vec4<f32>) -> Picture {
    let head = head_of(at.xy);
    let count = head.y & ~MERGE_TILE;
    rgb = vec3<f32>(0.0);
    clear = 1.0;
    half_at = 0.0;
    half_body = 0u;
    var before_half = FAR;
    var before_code = 0u;
#ifdef RESUME
    let texel = vec2<i32>(at.xy);
    let before = textureLoad(before_colour, texel, 0);
    rgb = before.rgb;
    clear = 1.0 - before.a;
    before_half = textureLoad(before_depth, texel, 0).r;
    before_code = textureLoad(before_object, texel, 0).r;
#endif
    let started_clear = clear > 0.5;
    let sight = sight_of(at.xy);

#ifdef MERGE
    // By interval: its body, its end, and the first sample from the current one on that may show something of it.
    var ahead: array<f32, CAPACITY>;
    var k1: array<f32, CAPACITY>;
    var who: array<u32, CAPACITY>;
    var n = 0u;
    for (var i = 0u; i < count; i += 1u) {
        let body = listed(head.x + i);
        let r = ray_of(body, sight);
        let within = interval(r, sight);
        let a = max(ceil(within.x), view.k_from);
        let b = min(ceil(within.y), view.k_to);
        if (a < b && n < CAPACITY) {
            ahead[n] = skip_empty(r, a, b);
            k1[n] = b;
            who[n] = body;
            n += 1u;
        }
    }
    loop {
        var first = FAR;
        var second = FAR;
        var nearest = 0u;
        for (var j = 0u; j < n; j += 1u) {
            let at = select(FAR, ahead[j], ahead[j] < k1[j]);
            if (at < first) {
                second = first;
                first = at;
                nearest = j;
            } else {
                second = min(second, at);
            }
        }
        if (first == FAR || clear < THRESHOLD) {
            break;
        }
        var reached = min(second, k1[nearest]);
        if (second - first >= ALONE) {
            march(ray_of(who[nearest], sight), first, reached);
        } else {
            reached = first + f32(SHARED_RUN);
            for (var i = 0u; i < SHARED_RUN; i += 1u) {
                matter[i] = vec4<f32>(0.0);
                strongest[i] = vec2<f32>(0.0);
            }
            for (var j = 0u; j < n; j += 1u) {
                let end = min(reached, k1[j]);
                if (ahead[j] < end) {
                    gather(ray_of(who[j], sight), first, ahead[j], end);
                }
            }
            for (var i = 0u; i < SHARED_RUN; i += 1u) {
                let m = matter[i];
                if (m.a > 0.0 && clear >= THRESHOLD) {
                    if (clear > 0.5) {
                        half_body = u32(strongest[i].y);
                    }
                    add(vec4<f32>(m.rgb / m.a, 1.0 - exp(-m.a)), first + f32(i));
                }
            }
        }
        for (var j = 0u; j < n; j += 1u) {
            if (ahead[j] < reached) {
                ahead[j] = skip_empty(ray_of(who[j], sight), reached, k1[j]);
            }
        }
    }
#else
    for (var i = 0u; i < count; i += 1u) {
        let r = ray_of(listed(head.x + i), sight);
        let within = interval(r, sight);
        march(r, max(ceil(within.x), view.k_from), min(ceil(within.y), view.k_to));
        if (clear < THRESHOLD) {
            break;
        }
    }
#endif

    var picture: Picture;
    picture.colour = vec4<f32>(rgb, 1.0 - clear);
    picture.depth = before_half;
    picture.object = before_code;
    if (started_clear && clear <= 0.5) {
        picture.depth = half_at * view.step_mm;
        picture.object = bodies[half_body].code;
#ifdef SELECTION
        if (bodies[half_body].tells_selection != 0u) {
            let r = ray_of(half_body, sight);
            let p = r.o + r.d * half_at;
            if (selection_at(selection_page(brick_of(p)), p) >= 0.5) {
                picture.object += 1u;
            }
        }
#endif
    }
    return picture;
}
