#define_import_path burin::iso
// The surface at a density: the nearest hit of any body, refined by bisection, cut faces capped with the plane's normal.
//
// ONE_SURFACE: looks go by label, and all labels' surfaces are at one density: labels tell its colour alone.
//
// Bodies may overlap: each ends the others' search at its own hit. A mask divides matter at ½; where it, and not the density,
// makes the surface, the selection's gradient is the normal.

#import burin::constants::{FAR, MASK_SELECTION}
#import burin::field::{brick_of, density_page, density_texel, address, selection_page, selected}
#import burin::body::{Ray, BodyRay, view, bodies, planes, body_ray, sample_from, sample_after, sample_distance}
#ifdef CUTS
#import burin::layers::cut_cosine
#endif
#ifdef BALL
#import burin::layers::ball_cosine
#endif
#import burin::look::{reaches, may_reach, surface_colour, surface_opacity, painted, look_at}
#import burin::light::{gradient, selection_gradient, lit, facing}
#ifdef CONTOUR
#import burin::light::{line_here, line_of_surface}
#endif
#import burin::picture::{Picture, object_at}
#import burin::span::Run

const RUN: f32 = 8.0;
#ifdef HOLES
// Beside a box too to 1/256 of its samples' distance, of which at most 512 are in a step.
const BISECTIONS: u32 = 17u;
#else
const BISECTIONS: u32 = 12u;
#endif

// The nearest hit of all bodies, in steps; whether it is where the ray enters its body; the body.
var<private> nearest: f32;
var<private> nearest_caps: bool;
var<private> nearest_body: u32;
// The same of the body that is searched.
var<private> hit: f32;
var<private> hit_caps: bool;

fn begin(before: Picture) -> bool {
    restart();
    return before.object == 0u;
}

// As if no body had been met.
fn restart() {
    nearest = FAR;
    nearest_caps = false;
    nearest_body = 0u;
}

fn owns(mask: u32, s: f32) -> bool {
    return mask == 0u || (s >= 0.5) == (mask == MASK_SELECTION);
}

// Whether a texel at a place lies at or beyond the surface of the matter there.
fn lies_beyond(p: vec3<f32>, texel: f32) -> bool {
#ifdef ONE_SURFACE
    return may_reach(texel);
#else
    look_at(p);
    return reaches(texel);
#endif
}

fn dense(p: vec3<f32>) -> bool {
    let page = density_page(brick_of(p));
    return lies_beyond(p, density_texel(page, address(page, p)));
}

fn holds(r: BodyRay, k: f32) -> bool {
    let p = r.o + r.d * k;
    return dense(p) && owns(r.mask, selected(p));
}

// What a sample finds lies after the sample before it: an entry belongs to the pass of the sample that follows it, and the sample
// that follows the nearest hit so far may still find something before it.
fn enter(r: BodyRay) -> vec2<f32> {
    return enter_between(r, view.k_from, view.k_to);
}

// The same of the samples from one on and before another.
fn enter_between(r: BodyRay, k_from: f32, k_to: f32) -> vec2<f32> {
    hit = FAR;
    hit_caps = false;
    let follows = sample_from(r.within.x);
    let enters = r.within.x < r.within.y && r.within.x <= nearest && follows >= k_from && follows < k_to;
    if (enters && holds(r, r.within.x)) {
        hit = r.within.x;
#ifdef HOLES
        hit_caps = !r.joins.x;
#else
        hit_caps = true;
#endif
        return vec2<f32>(0.0);
    }
    let reach = min(sample_from(r.within.y), sample_from(nearest) + sample_distance());
    return vec2<f32>(max(follows, k_from), min(reach, k_to));
}

fn after(k: f32) -> f32 {
    return sample_after(k);
}

fn meet(r: BodyRay, run: Run, k: f32, texel: f32) -> vec4<f32> {
#ifdef LABEL_LOOKS
    // Which surface it would be of is asked of the few that reach any.
    return vec4<f32>(0.0, 0.0, 0.0, select(0.0, 1.0, may_reach(texel)));
#else
    return vec4<f32>(0.0, 0.0, 0.0, select(0.0, 1.0, reaches(texel)));
#endif
}

fn add(r: BodyRay, run: Run, k: f32, texel: f32, c: vec4<f32>) {
#ifdef LABEL_LOOKS
    if (!lies_beyond(r.o + r.d * k, texel)) {
        return;
    }
#endif
#ifdef SELECTION
    if (owns(r.mask, selected(r.o + r.d * k))) {
        hit = k;
    }
#else
    hit = k;
#endif
}

fn open(r: BodyRay, k: f32) {}

fn inside() -> bool {
    return false;
}

fn done() -> bool {
    return hit < FAR;
}

fn leave(r: BodyRay) {
    leave_between(r, view.k_from, view.k_to);
}

// The same of the samples from one on and before another.
fn leave_between(r: BodyRay, k_from: f32, k_to: f32) {
#ifdef HOLES
    // Where the same matter goes on at another resolution, the place itself is a sample.
    let ends = r.within.y;
    let of_pass = ends >= k_from && ends < k_to && ends <= nearest;
    if (hit == FAR && r.joins.y && r.within.x < ends && of_pass && holds(r, ends)) {
        hit = ends;
    }
    if (hit < FAR && !hit_caps) {
        var outer = max(sample_from(hit) - sample_distance(), r.within.x);
#else
    if (hit < FAR && !hit_caps) {
        var outer = max(hit - 1.0, r.within.x);
#endif
        for (var i = 0u; i < BISECTIONS; i += 1u) {
            let middle = 0.5 * (outer + hit);
            if (holds(r, middle)) {
                hit = middle;
            } else {
                outer = middle;
            }
        }
    }
    // Of surfaces in one place, as the faces of a cut are, that of the body which was named first.
    if (hit < nearest || (hit < FAR && hit == nearest && r.body < nearest_body)) {
        nearest = hit;
        nearest_caps = hit_caps;
        nearest_body = r.body;
    }
}

fn over(merge: bool) -> bool {
    return nearest < FAR && !merge;
}

// Cosine between the ray and the outward normal of the face by which it enters the body.
fn entry_cosine(r: BodyRay, ray: Ray, entry: f32) -> f32 {
#ifdef CUTS
    let cut = cut_cosine(r.body, entry);
    if (cut >= 0.0) {
        return cut;
    }
#endif
#ifdef BALL
    let ball = ball_cosine(ray, entry);
    if (ball >= 0.0) {
        return ball;
    }
#endif
    let a = (bodies[r.body].lo - r.o) / r.d;
    let b = (bodies[r.body].hi - r.o) / r.d;
    let near = min(a, b);
    let m = mat3x3<f32>(bodies[r.body].column_x, bodies[r.body].column_y, bodies[r.body].column_z);
    // A face is told by the place at which the ray meets it, as far as these numbers tell places apart.
    var closest = 1e-3 + 2e-6 * entry;
    var cosine = 1.0;
    // Faces of the box: planes of one index, normal = a row of index_from_world.
    for (var axis = 0u; axis < 3u; axis += 1u) {
        let off = abs(near[axis] - entry);
        if (off < closest) {
            closest = off;
            let normal = vec3<f32>(m[0][axis], m[1][axis], m[2][axis]);
            cosine = dot(normal, ray.dir) / length(normal);
        }
    }
    for (var i = 0u; i < bodies[r.body].plane_count; i += 1u) {
        let plane = planes[bodies[r.body].first_plane + i];
        let slope = dot(plane.xyz, ray.dir);
        let t = -(plane.w + dot(plane.xyz, ray.start)) / (slope * view.step_mm);
        if (slope < 0.0 && abs(t - entry) <= closest) {
            closest = abs(t - entry);
            cosine = slope;
        }
    }
    return cosine;
}

// Cosine of the surface's normal at a refined hit.
fn surface_cosine(r: BodyRay, k: f32) -> f32 {
    let p = r.o + r.d * k;
    let brick = brick_of(p);
#ifdef SELECTION
    // A hair before the hit there is matter, but another body's: the mask makes the surface.
    if (r.mask != 0u && dense(r.o + r.d * (k - 1.0 / 256.0))) {
        return facing(r, selection_gradient(selection_page(brick), p), 1.0);
    }
#endif
    let page = density_page(brick);
    return facing(r, gradient(r, page, p), density_texel(page, address(page, p)));
}

// Colour and opacity of the nearest hit, which is of this body.
fn surface(r: BodyRay, ray: Ray) -> vec4<f32> {
    let p = r.o + r.d * nearest;
    look_at(p);
    // The colour of the surface's value, for caps too.
    var colour = painted(surface_colour(), p, selected(p)) * bodies[r.body].tint;
#ifdef LIT
    colour = lit(colour, nearest_cosine(r, ray));
#endif
#ifdef CONTOUR
    line_of_surface(nearest_cosine(r, ray));
#endif
    return vec4<f32>(colour, surface_opacity());
}

// Cosine between the ray and the normal of the nearest hit.
fn nearest_cosine(r: BodyRay, ray: Ray) -> f32 {
    if (nearest_caps) {
        return entry_cosine(r, ray, nearest);
    }
    return surface_cosine(r, nearest);
}

fn end(before: Picture, ray: Ray) -> Picture {
    var picture = before;
    if (nearest < FAR) {
        let r = body_ray(nearest_body, ray);
        picture.colour = vec4<f32>(surface(r, ray).rgb, 1.0);
#ifdef CONTOUR
        picture.colour *= line_here();
#endif
        picture.depth = nearest * view.step_mm;
        picture.object = object_at(nearest_body, r.o + r.d * nearest);
    }
    return picture;
}
