#define_import_path burin::layers
// What was drawn before the rays: opaque meshes end them, closed meshes that cut take spans of them away, decals lay marks on them.
//
// Compiled in where a picture has any (OPAQUE, CUTS, MARKS); without, its functions leave everything as it is. BALL: of every ray the
// piece before a ball, inside it or behind it is drawn alone.

#import burin::body::view
#import burin::picture::Picture
#ifdef BALL
#import burin::constants::{FAR, KEEPS_BEFORE, KEEPS_INSIDE}
#import burin::body::{Ray, ray_through}
#endif
#ifdef MARKS
#ifndef BALL
#import burin::constants::FAR
#endif
#import burin::structs::Mark
#endif

#ifdef OPAQUE
@group(3) @binding(0) var opaque_colour: texture_2d<f32>;
@group(3) @binding(1) var opaque_depth: texture_2d<f32>;
@group(3) @binding(2) var opaque_object: texture_2d<u32>;
#endif
#ifdef CUTS
#import burin::body::bodies
// By layer, nearest first: steps to entry and exit, cosine between ray and normal at the exit; FAR after the last one. What spares
// different bodies lies one after another.
@group(3) @binding(3) var cut_spans: texture_2d_array<f32>;
#endif

#ifdef MARKS
@group(3) @binding(4) var<storage, read> mark_heads: array<u32>;
@group(3) @binding(5) var<storage, read> marks: array<Mark>;

// The next mark that was not laid yet: its number and 1, 0 for none; where it lies, in steps, FAR for none.
var<private> mark_next: u32;
var<private> mark_at: f32;
#endif

var<private> pixel: vec2<i32>;
// Steps to something opaque.
var<private> far_end: f32;
#ifdef BALL
// The piece of the ray that is drawn, in steps.
var<private> kept: vec2<f32>;

// Where a ray is inside the ball, in steps; x ≥ y where it is not.
fn ball_span(ray: Ray) -> vec2<f32> {
    let o = ray.start - view.ball_centre;
    let nearest = -dot(o, ray.dir);
    // From the ball's middle straight to the ray: squares of long ways would lose what a short one says.
    let off = o + ray.dir * nearest;
    let square = view.ball_radius * view.ball_radius - dot(off, off);
    let half = sqrt(max(square, 0.0));
    let span = max(vec2<f32>(nearest - half, nearest + half), vec2<f32>(0.0)) / view.step_mm;
    return select(vec2<f32>(0.0), span, square > 0.0);
}

fn keep_piece(ray: Ray) {
    let ball = ball_span(ray);
    let met = ball.x < ball.y;
    let before = vec2<f32>(0.0, select(FAR, ball.x, met));
    let behind = select(vec2<f32>(0.0), vec2<f32>(ball.y, FAR), met);
    kept = select(behind, ball, view.ball_keeps == KEEPS_INSIDE);
    kept = select(kept, before, view.ball_keeps == KEEPS_BEFORE);
}

// Cosine between the ray and the ball's normal where the piece begins that is drawn; −1 elsewhere.
fn ball_cosine(ray: Ray, at: f32) -> f32 {
    let p = ray.start + ray.dir * (at * view.step_mm) - view.ball_centre;
    return select(-1.0, abs(dot(p, ray.dir)) / view.ball_radius, at == kept.x && at > 0.0);
}
#endif

// A pixel begins.
fn look_at(px: vec2<f32>) {
#ifdef OPAQUE
    pixel = vec2<i32>(px);
    far_end = textureLoad(opaque_depth, pixel, 0).r / view.step_mm;
#else
#ifdef CUTS
    pixel = vec2<i32>(px);
#endif
#endif
#ifdef BALL
    keep_piece(ray_through(px));
#endif
#ifdef MARKS
    let texel = vec2<u32>(px);
    mark_next = mark_heads[1u + texel.y * view.width + texel.x];
    find_mark();
#endif
}

#ifdef MARKS
// Passes over marks that do not show: of other passes, behind what is opaque, out of the piece that is drawn, cut away.
fn find_mark() {
    mark_at = FAR;
    loop {
        if (mark_next == 0u) {
            break;
        }
        let at = marks[mark_next - 1u].at;
#ifdef MARKED_AFTER
        var shows = !is_hidden(at);
#else
        var shows = at >= view.k_from && at < view.k_to && !is_hidden(at);
#endif
#ifdef BALL
        shows = shows && at >= kept.x && at < kept.y;
#endif
#ifdef CUTS
        if (shows && (marks[mark_next - 1u].body & IS_CUT) != 0u) {
            shows = !is_cut_at(mark_body(), at);
        }
#endif
        if (shows) {
            mark_at = at;
            break;
        }
        mark_next = marks[mark_next - 1u].next;
    }
}

const IS_CUT: u32 = 0x80000000u;

// The body of the next mark, which there must be.
fn mark_body() -> u32 {
    return marks[mark_next - 1u].body & ~IS_CUT;
}

// Its colour times opacity, and opacity.
fn mark_colour() -> vec4<f32> {
    return unpack4x8unorm(marks[mark_next - 1u].colour);
}

// It is laid: the next one.
fn pass_mark() {
    mark_next = marks[mark_next - 1u].next;
    find_mark();
}
#endif

// What of an interval is drawn: it lies before everything opaque.
fn in_front(within: vec2<f32>) -> vec2<f32> {
#ifdef BALL
    let drawn = vec2<f32>(max(within.x, kept.x), min(within.y, kept.y));
#else
    let drawn = within;
#endif
#ifdef OPAQUE
    return vec2<f32>(drawn.x, min(drawn.y, far_end));
#else
    return drawn;
#endif
}

// Whether something opaque lies before sample k.
fn is_hidden(k: f32) -> bool {
#ifdef OPAQUE
    return far_end <= k;
#else
    return false;
#endif
}

#ifdef CUTS
// The layer in which a body's cuts begin; behind all of them if nothing cuts it.
fn first_cut(body: u32) -> i32 {
    let first = i32(bodies[body].mask >> 2u) - 1;
    return select(first, i32(textureNumLayers(cut_spans)), first < 0);
}

// The first piece of a body's ray after `start` and before `most` that nothing cuts away; x ≥ y if there is none.
fn next_piece(body: u32, start: f32, most: f32) -> vec2<f32> {
    var piece = vec2<f32>(start, most);
    for (var i = first_cut(body); i < i32(textureNumLayers(cut_spans)); i += 1) {
        let cut = textureLoad(cut_spans, pixel, i, 0);
        if (cut.x >= piece.y) {
            break;
        }
        if (cut.x > piece.x) {
            piece.y = cut.x;
            break;
        }
        piece.x = max(piece.x, cut.y);
    }
    return piece;
}

// Whether a place of a body's ray is cut away.
fn is_cut_at(body: u32, at: f32) -> bool {
    for (var i = first_cut(body); i < i32(textureNumLayers(cut_spans)); i += 1) {
        let cut = textureLoad(cut_spans, pixel, i, 0);
        if (cut.x > at) {
            break;
        }
        if (at < cut.y) {
            return true;
        }
    }
    return false;
}

// Cosine between the ray and the face by which it leaves a cut of a body; −1 where it leaves none.
fn cut_cosine(body: u32, at: f32) -> f32 {
    for (var i = first_cut(body); i < i32(textureNumLayers(cut_spans)); i += 1) {
        let cut = textureLoad(cut_spans, pixel, i, 0);
        if (cut.x > at) {
            break;
        }
        if (cut.y == at) {
            return cut.z;
        }
    }
    return -1.0;
}
#endif

// What is opaque behind what a ray gathered. It is what the pixel shows where the ray's opacity is below ½ there.
fn backed(picture: Picture) -> Picture {
    var out = picture;
#ifdef OPAQUE
#ifndef CONTINUES
    var object = textureLoad(opaque_object, pixel, 0).r;
#ifdef BALL
    object = select(0u, object, far_end >= kept.x && far_end < kept.y);
#endif
    if (object != 0u) {
        let clear = 1.0 - picture.colour.a;
        out.colour = vec4<f32>(picture.colour.rgb + clear * textureLoad(opaque_colour, pixel, 0).rgb, 1.0);
        if (clear > 0.5) {
            out.depth = textureLoad(opaque_depth, pixel, 0).r;
            out.object = object;
        }
    }
#endif
#endif
    return out;
}
