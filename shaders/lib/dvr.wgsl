#define_import_path burin::dvr
// Direct volume rendering: samples front to back, until nothing behind would show.
//
// REFINE: a sample stands for the stretch of the ray from the sample before it, or from where the ray enters the body. Density
// goes evenly from one end to the other; the table's integrals (after Engel, Kraus and Ertl 2001, without absorption inside a
// stretch) say how much extinction that is and where its centre lies. There colour and paint are taken; light is the mean over
// the extent of what shows, the gradient going evenly too. Where a step adds much stretches are half as long. Where looks go by label
// all of a stretch has that of the voxel in its middle.

#import burin::constants::{CLEAR_END, FAR}
#import burin::field::{selection_at, selected}
#import burin::body::{Ray, BodyRay, view, body_ray, sample_after, sample_distance, sample_from}
#import burin::look::{look_at, table_at, share, opacity_of_share, painted}
#ifdef REFINE
#import burin::look::{Matter, integrals_at, shows_between, matter_between, colour_of_entry}
#endif
#import burin::light::{gradient_here, slope_of, lit, lit_evenly, facing}
#ifdef CONTOUR
#import burin::light::{line_here, line_of_matter}
#endif
#import burin::picture::{Picture, object_at}
#ifdef HOLES
#ifdef REFINE
#import burin::holes::{reaches_over, texel_before}
#endif
#endif
#import burin::span::{Run, samples_in, stretches_in, texel_on}

const RUN: f32 = 32.0;

// The ray's state: colour so far, transmittance, the sample at which opacity reached ½ and its body.
var<private> rgb: vec3<f32>;
var<private> clear: f32;
var<private> half_at: f32;
var<private> half_body: u32;
#ifdef CONTOUR
// Opacity of what is drawn, which is less than what matter hides. Where a picture takes several passes lines hide no more than they are.
var<private> drawn: f32;
#endif

fn begin(before: Picture) -> bool {
    rgb = before.colour.rgb;
    clear = 1.0 - before.colour.a;
#ifdef CONTOUR
    drawn = before.colour.a;
#endif
    half_at = 0.0;
    half_body = 0u;
    return true;
}

fn enter(r: BodyRay) -> vec2<f32> {
    turn_to(r.body);
    return samples_of(r);
}

fn samples_of(r: BodyRay) -> vec2<f32> {
#ifdef REFINE
    return stretches_in(r);
#else
    return samples_in(r);
#endif
}

// What follows is a body's.
fn turn_to(body: u32) {
    if (clear > 0.5) {
        half_body = body;
    }
}

#ifdef REFINE
// A stretch of which a whole step would add more than this to the picture is taken in halves.
const WORTH: f32 = 1.0 / 40.0;
// Where less than this comes through, stretches are two steps long.
const FAINT: f32 = 1.0 / 16.0;

// The stretch that was met last: where it begins and ends, in steps, and what lies in it; the table below the density at its end.
var<private> begins_at: f32;
var<private> ends_at: f32;
var<private> matter: Matter;
var<private> far_end: vec4<f32>;
#ifdef LABEL_LOOKS
// The texel there: what the table has below it hangs on the look of the stretch that follows.
var<private> far_texel: f32;
#endif
// Where the next one should end.
var<private> next_at: f32;
// The slope at the end of the matter that was lit last, and where that is.
var<private> lit_end: vec4<f32>;
var<private> lit_at: f32;

fn open(r: BodyRay, k: f32) {
#ifdef HOLES
    let left_at = ends_at;
#endif
    ends_at = max(k - sample_distance(), r.within.x);
    var texel = texel_on(r, ends_at);
#ifdef HOLES
    if (reaches_over(r, k)) {
        // What was marched last may have ended between samples.
        ends_at = select(r.before, left_at, left_at > r.before && left_at <= r.within.x);
        texel = texel_before(r, ends_at);
    }
#endif
#ifdef LABEL_LOOKS
    far_texel = texel;
    far_end = vec4<f32>(0.0);
#else
    far_end = integrals_at(texel);
#endif
#ifdef HOLES
    // The slope there was found where it was another body's.
    lit_at = select(-1.0, lit_at, lit_at == ends_at && r.joins.x);
#else
    lit_at = -1.0;
#endif
}

fn inside() -> bool {
    return far_end.w > 0.0;
}

// The middle of the stretch up to sample k, in steps.
fn middle_to(r: BodyRay, k: f32) -> f32 {
    return 0.5 * (ends_at + min(k, r.within.y));
}

// Meets the stretch up to sample k. If that is too much for one stretch it is refused, and its first half is next. Values are
// chosen, not branched on: software Vulkan computes both sides of a branch.
fn meet(r: BodyRay, run: Run, k: f32, at: f32) -> vec4<f32> {
    var texel = at;
#ifdef HOLES
    // Half of a stretch that reaches over.
    if (k < r.within.x && r.joins.x) {
        texel = texel_before(r, k);
    }
#endif
#ifdef LABEL_LOOKS
#ifndef LABEL_RUNS
    look_at(r.o + r.d * middle_to(r, k));
#endif
    far_end = integrals_at(far_texel);
#endif
    let here = integrals_at(texel);
    let shows = shows_between(far_end, here);
    matter = matter_between(far_end, here);
    let apart = sample_distance();
    let much = shows && clear * min(matter.extinction * apart, 1.0) > WORTH;
#ifdef HOLES
    let whole = sample_from(k) == k;
#else
    let whole = floor(k) == k;
#endif
    let middle = k - 0.5 * apart;
    let refused = much && whole && middle > ends_at && middle < r.within.y;
    begins_at = select(ends_at, begins_at, refused);
    ends_at = select(min(k, r.within.y), ends_at, refused);
    far_end = select(here, far_end, refused);
#ifdef LABEL_LOOKS
    far_texel = select(texel, far_texel, refused);
#endif
    // Two steps on if the run has as many.
#ifdef HOLES
    let ahead = (run.end - k) / apart - 1.0;
#else
    let ahead = run.end - 1.0 - k;
#endif
    let far = select(1.0, max(1.0, min(2.0, ahead)), shows && clear < FAINT);
    next_at = select(k + select(far, 0.5, much || !whole) * apart, middle, refused);
    return vec4<f32>(0.0, 0.0, 0.0, select(0.0, 1.0, shows && !refused));
}

fn after(k: f32) -> f32 {
    return next_at;
}

fn add(r: BodyRay, run: Run, k: f32, texel: f32, c: vec4<f32>) {
    compose(evaluate(r, run, k, texel, c), begins_at + matter.share * (ends_at - begins_at));
}

// The share, paint and light of the stretch that was met last: display colour and opacity.
fn evaluate(r: BodyRay, run: Run, k: f32, texel: f32, c: vec4<f32>) -> vec4<f32> {
    let way = ends_at - begins_at;
    let p = r.o + r.d * (begins_at + matter.share * way);
    var s = 0.0;
    var extinction = matter.extinction * way;
#ifdef SELECTION
    s = selected(p);
    extinction *= share(r.mask, s);
#endif
    var colour = painted(colour_of_entry(matter.entry), p, s) * r.tint;
#ifdef LIT
    let slope = slope_of(r, gradient_here(r, run.page, r.o + r.d * ends_at), texel);
    let before = select(slope, lit_end, lit_at == begins_at);
    lit_end = slope;
    lit_at = ends_at;
    let reach = min(matter.share, 1.0 - matter.share);
    colour = lit_evenly(colour, before, slope, matter.share - reach, matter.share + reach);
#endif
    return vec4<f32>(colour, 1.0 - exp(-extinction));
}
#else
fn after(k: f32) -> f32 {
    return sample_after(k);
}

fn meet(r: BodyRay, run: Run, k: f32, texel: f32) -> vec4<f32> {
#ifdef LABELS_IN_PLACE
    look_at(r.o + r.d * k);
#endif
    return table_at(texel);
}

fn add(r: BodyRay, run: Run, k: f32, texel: f32, c: vec4<f32>) {
#ifdef STAGED
    compose(evaluate(r, run, k, texel, c), k);
#else
    compose(c, k);
#endif
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
#ifdef HOLES
    out.a = opacity_of_share(out.a, sample_after(k) - k);
#endif
    var colour = painted(c.rgb, p, s) * r.tint;
#ifdef CONTOUR
    line_of_matter(r, gradient_here(r, run.page, p), texel);
#endif
#ifdef LIT
    colour = lit(colour, facing(r, gradient_here(r, run.page, p), texel));
#endif
    return vec4<f32>(colour, out.a);
}
#endif

// Lays colour and opacity behind what is there.
fn compose(c: vec4<f32>, k: f32) {
    half_at = select(half_at, k, clear > 0.5);
#ifdef CONTOUR
    let laid = clear * c.a * line_here();
    drawn += laid;
    rgb += laid * c.rgb;
#else
    rgb += clear * c.a * c.rgb;
#endif
    clear *= 1.0 - c.a;
}

#ifdef MARKS
// The same of a colour that is multiplied by its opacity: a mark of a decal.
fn lay(c: vec4<f32>, k: f32) {
    half_at = select(half_at, k, clear > 0.5);
#ifdef CONTOUR
    drawn += clear * c.a;
#endif
    rgb += clear * c.rgb;
    clear *= 1.0 - c.a;
}
#endif

fn done() -> bool {
    return clear < CLEAR_END;
}

fn leave(r: BodyRay) {}

fn over(merge: bool) -> bool {
    return clear < CLEAR_END;
}

fn end(before: Picture, ray: Ray) -> Picture {
    var picture = Picture(vec4<f32>(rgb, 1.0 - clear), before.depth, before.object);
#ifdef CONTOUR
    picture.colour.a = drawn;
#endif
    if (1.0 - before.colour.a > 0.5 && clear <= 0.5) {
        let r = body_ray(half_body, ray);
        picture.depth = half_at * view.step_mm;
        picture.object = object_at(half_body, r.o + r.d * half_at);
    }
    return picture;
}
