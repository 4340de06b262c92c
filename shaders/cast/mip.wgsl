// Maximum intensity projection: the table at the largest density that any body meets, opacity uncorrected.
//
// The maximum does not care for order, so overlapping bodies need no merging; of equal ones the nearest is taken. A mask divides
// matter at ½.

#import burin::body::{Sight, BodyRay, view, bodies, sight_of, head_of, listed, ray_of, interval, skip_empty, run_from, run_texel, FAR, MERGE as MERGE_TILE}
#import burin::field::{brick_of, selection_page, selection_at, is_nan}
#import burin::look::{table_at, painted}

#ifdef RESUME
@group(0) @binding(7) var before_colour: texture_2d<f32>;
@group(0) @binding(8) var before_depth: texture_2d<f32>;
@group(0) @binding(9) var before_object: texture_2d<u32>;
#endif

const RUN: f32 = 32.0;

struct Picture {
    @location(0) colour: vec4<f32>,
    @location(1) depth: f32,
    @location(2) object: u32,
}

var<private> largest: f32;
var<private> largest_at: f32;
var<private> largest_body: u32;

fn selected(p: vec3<f32>) -> f32 {
#ifdef SELECTION
    return selection_at(selection_page(brick_of(p)), p);
#else
    return 0.0;
#endif
}

// Of equal maxima the nearest, in whatever order bodies come.
fn exceeds(texel: f32, k: f32) -> bool {
    let better = texel > largest || (texel == largest && k < largest_at);
#ifdef FLOAT_DENSITY
    return !is_nan(texel) && better;
#else
    return better;
#endif
}

fn march(r: BodyRay, k0: f32, k1: f32) {
    var k = k0;
    loop {
        k = skip_empty(r, k, k1);
        if (k >= k1) {
            break;
        }
        let run = run_from(r, k, min(k1, k + RUN));
        loop {
            if (k >= run.end) {
                break;
            }
            let texel = run_texel(run, k);
            var better = exceeds(texel, k);
#ifdef SELECTION
            if (better && r.mask != 0u) {
                better = (selected(r.o + r.d * k) >= 0.5) == (r.mask == 1u);
            }
#endif
            largest = select(largest, texel, better);
            largest_at = select(largest_at, k, better);
            largest_body = select(largest_body, r.body, better);
            k += 1.0;
        }
    }
}

@vertex
fn cover(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn march_pixel(@builtin(position) at: vec4<f32>) -> Picture {
    largest = -FAR;
    largest_at = 0.0;
    largest_body = 0u;
    var picture = Picture(vec4<f32>(0.0), FAR, 0u);
#ifdef RESUME
    // Earlier passes leave their largest texel beside the picture's colour, which the last pass makes.
    let texel = vec2<i32>(at.xy);
    let before = textureLoad(before_colour, texel, 0);
    largest = before.x;
    largest_at = before.y;
    largest_body = u32(before.z);
#endif
    let head = head_of(at.xy);
    let sight = sight_of(at.xy);
    for (var i = 0u; i < (head.y & ~MERGE_TILE); i += 1u) {
        let r = ray_of(listed(head.x + i), sight);
        let within = interval(r, sight);
        march(r, max(ceil(within.x), view.k_from), min(ceil(within.y), view.k_to));
    }
#ifdef CONTINUES
    picture.colour = vec4<f32>(largest, largest_at, f32(largest_body), 0.0);
#else
    if (largest > -FAR) {
        let r = ray_of(largest_body, sight);
        let p = r.o + r.d * largest_at;
        let s = selected(p);
        let c = table_at(largest);
        let colour = painted(c.rgb, p, s) * bodies[largest_body].tint;
        picture.colour = vec4<f32>(colour * c.a, c.a);
        if (c.a > 0.0) {
            picture.depth = largest_at * view.step_mm;
            picture.object = bodies[largest_body].code;
            if (bodies[largest_body].tells_selection != 0u && s >= 0.5) {
                picture.object += 1u;
            }
        }
    }
#endif
    return picture;
}
