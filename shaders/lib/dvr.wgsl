#define_import_path burin::dvr
// Direct volume rendering: samples front to back, until nothing behind would show.

#import burin::constants::{CLEAR_END, FAR}
#import burin::field::{brick_of, selection_page, selection_at, selected}
#import burin::body::{Ray, BodyRay, view, bodies, body_ray}
#import burin::look::{table_at, share, opacity_of_share, painted}
#import burin::light::{gradient, lit, facing}
#import burin::picture::{Picture, object_of}
#import burin::span::{Run, samples_in}

const RUN: f32 = 32.0;

// The ray's state: colour so far, transmittance, the sample at which opacity reached ½ and its body.
var<private> rgb: vec3<f32>;
var<private> clear: f32;
var<private> half_at: f32;
var<private> half_body: u32;

fn begin(before: Picture) -> bool {
    rgb = before.colour.rgb;
    clear = 1.0 - before.colour.a;
    half_at = 0.0;
    half_body = 0u;
    return true;
}

fn enter(r: BodyRay, ray: Ray, within: vec2<f32>) -> vec2<f32> {
    turn_to(r.body);
    return samples_in(within);
}

// What follows is a body's.
fn turn_to(body: u32) {
    if (clear > 0.5) {
        half_body = body;
    }
}

fn meet(texel: f32) -> vec4<f32> {
    return table_at(texel);
}

fn add(r: BodyRay, run: Run, k: f32, texel: f32, c: vec4<f32>) {
#ifdef STAGED
    compose(evaluate(r, run, k, texel, c), k);
#else
    compose(c, k);
#endif
}

// Lays colour and opacity behind what is there.
fn compose(c: vec4<f32>, k: f32) {
    half_at = select(half_at, k, clear > 0.5);
    rgb += clear * c.a * c.rgb;
    clear *= 1.0 - c.a;
}

// The share, paint and light of the visible sample k: display colour and opacity.
fn evaluate(r: BodyRay, run: Run, k: f32, texel: f32, c: vec4<f32>) -> vec4<f32> {
    let p = r.o + r.d * k;
    var s = 0.0;
    var out = c;
#ifdef SELECTION
    s = selection_at(run.selection, p);
    if (r.mask != 0u) {
        out.a = opacity_of_share(c.a, share(r.mask, s));
    }
#endif
    var colour = painted(c.rgb, p, s) * bodies[r.body].tint;
#ifdef LIT
    colour = lit(colour, facing(r, gradient(run.page, p), texel));
#endif
    return vec4<f32>(colour, out.a);
}

fn done() -> bool {
    return clear < CLEAR_END;
}

fn leave(r: BodyRay, within: vec2<f32>) {}

fn over(merge: bool) -> bool {
    return clear < CLEAR_END;
}

fn end(before: Picture, ray: Ray) -> Picture {
    var picture = Picture(vec4<f32>(rgb, 1.0 - clear), before.depth, before.object);
    if (1.0 - before.colour.a > 0.5 && clear <= 0.5) {
        let r = body_ray(half_body, ray);
        picture.depth = half_at * view.step_mm;
        picture.object = object_of(half_body, selected(r.o + r.d * half_at));
    }
    return picture;
}
