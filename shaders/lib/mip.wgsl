#define_import_path burin::mip
// Maximum intensity projection: the table at the largest density that any body meets, opacity uncorrected.
//
// The maximum does not care for order, so overlapping bodies need no merging; of equal ones the nearest is taken. A mask divides
// matter at ½.

#import burin::constants::{FAR, MASK_SELECTION}
#import burin::field::{selected, is_nan}
#import burin::body::{Ray, BodyRay, view, bodies, body_ray, sample_after}
#import burin::look::{table_at, painted, is_shown, look_at}
#import burin::picture::{Picture, object_at}
#ifdef HOLES
#import burin::holes::{to_root, from_root}
#endif
#import burin::span::{Run, samples_in}

const RUN: f32 = 32.0;

var<private> largest: f32;
var<private> largest_at: f32;
var<private> largest_body: u32;

// First cells of the maps of what lies above a texel, and the texel: read once, as where lanes part software Vulkan reads a uniform
// lane by lane.
var<private> higher_a: vec4<f32>;
var<private> higher_b: vec4<f32>;
var<private> higher_c: vec4<f32>;

// As if nothing had been met.
fn restart() {
    largest = -FAR;
    largest_at = 0.0;
    largest_body = 0u;
}

fn begin(before: Picture) -> bool {
    restart();
    higher_a = vec4<f32>(vec3<f32>(view.above_a), view.from_a);
    higher_b = vec4<f32>(vec3<f32>(view.above_b), view.from_b);
    higher_c = vec4<f32>(vec3<f32>(view.above_c), view.from_c);
#ifdef RESUME
    // Earlier passes leave their largest texel instead of the picture's colour, which the last pass makes.
    largest = before.colour.x;
    largest_at = before.colour.y;
    largest_body = u32(before.colour.z);
#endif
    return true;
}

fn enter(r: BodyRay) -> vec2<f32> {
    return samples_in(r);
}

// The ray by whose map of empty space the next sample is looked for: cells of nothing that is more than what was met are as good as
// empty.
fn higher(r: BodyRay) -> BodyRay {
    var ahead = r;
    var at = select(vec3<f32>(r.skip_place), higher_a.xyz, largest > higher_a.w);
    at = select(at, higher_b.xyz, largest > higher_b.w);
    ahead.skip_place = vec3<u32>(select(at, higher_c.xyz, largest > higher_c.w));
    return ahead;
}

fn after(k: f32) -> f32 {
    return sample_after(k);
}

fn meet(r: BodyRay, run: Run, k: f32, texel: f32) -> vec4<f32> {
    return vec4<f32>(0.0);
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

fn add(r: BodyRay, run: Run, k: f32, texel: f32, c: vec4<f32>) {
#ifdef LABELS_IN_PLACE
    look_at(r.o + r.d * k);
#endif
#ifdef HOLES
    // A volume and its boxes have codes of their own.
    let density = to_root(r.hole, texel);
#else
    let density = texel;
#endif
    var better = exceeds(density, k) && is_shown();
#ifdef SELECTION
    if (better && r.mask != 0u) {
        better = (selected(r.o + r.d * k) >= 0.5) == (r.mask == MASK_SELECTION);
    }
#endif
    largest = select(largest, density, better);
    largest_at = select(largest_at, k, better);
    largest_body = select(largest_body, r.body, better);
}

fn open(r: BodyRay, k: f32) {}

fn inside() -> bool {
    return false;
}

fn done() -> bool {
    return false;
}

fn leave(r: BodyRay) {}

fn over(merge: bool) -> bool {
    return false;
}

// Colour and opacity of the largest texel, which is of this body.
fn maximum(r: BodyRay) -> vec4<f32> {
    let p = r.o + r.d * largest_at;
    look_at(p);
#ifdef HOLES
    let c = table_at(from_root(r.hole, largest));
#else
    let c = table_at(largest);
#endif
    return vec4<f32>(painted(c.rgb, p, selected(p)) * bodies[r.body].tint, c.a);
}

fn end(before: Picture, ray: Ray) -> Picture {
    var picture = Picture(vec4<f32>(0.0), FAR, 0u);
#ifdef CONTINUES
    picture.colour = vec4<f32>(largest, largest_at, f32(largest_body), 0.0);
#else
    if (largest > -FAR) {
        let r = body_ray(largest_body, ray);
        let c = maximum(r);
        picture.colour = vec4<f32>(c.rgb * c.a, c.a);
        if (c.a > 0.0) {
            picture.depth = largest_at * view.step_mm;
            picture.object = object_at(largest_body, r.o + r.d * largest_at);
        }
    }
#endif
    return picture;
}
