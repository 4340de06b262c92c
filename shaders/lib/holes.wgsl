#define_import_path burin::holes
// Boxes of a volume that a finer one fills: what of a body's ray lies outside of them, and which samples that is.
//
// A sample at k stands for the ray up to the sample after it. Where a ray enters a box the samples of the box begin with the next
// sample of its host, and where it leaves the box the host begins with the next sample of the box, which stands for what is left of
// the step: no place counts twice or not at all. Holes of one body do not overlap; they may touch.

#import burin::constants::{NO_HOLE, MOST_HOLES}
#import burin::body::{Ray, BodyRay, view, bodies, holes, hole_span, lattice}
#import burin::field::{brick_of, density_page, density_texel, address, enter_volume}

fn texel_in(volume: u32, place: vec3<f32>) -> f32 {
    enter_volume(volume);
    let page = density_page(brick_of(place));
    return density_texel(page, address(page, place));
}

// A texel of a hole's host where it goes on, in texels of what fills the hole, at a place in the index space of that.
fn texel_of_host(hole: u32, place: vec3<f32>) -> f32 {
    let texel = texel_in(holes[hole].host, holes[hole].lo + place / holes[hole].scale);
    enter_volume(holes[hole].volume);
    return texel * holes[hole].texel_ratio + holes[hole].texel_bias;
}

// A texel of what fills a hole, in texels of its host, at a place in the index space of that.
fn texel_of_filling(hole: u32, place: vec3<f32>) -> f32 {
    let texel = texel_in(holes[hole].volume, (place - holes[hole].lo) * holes[hole].scale);
    enter_volume(holes[hole].host);
    return (texel - holes[hole].texel_bias) / holes[hole].texel_ratio;
}

// Whether what lies before a piece is shown as it is, so that a stretch may reach from there into it.
fn goes_on(r: BodyRay) -> bool {
    let hole = select(r.left, r.hole, r.left == NO_HOLE);
    return r.joins.x && holes[min(hole, MOST_HOLES - 1u)].seamless != 0u;
}

// Whether the stretch that ends at sample k begins before its piece.
fn reaches_over(r: BodyRay, k: f32) -> bool {
    return k - 1.0 / r.steps < r.within.x && goes_on(r);
}

// The last sample before a piece that goes on.
fn sample_before(r: BodyRay) -> f32 {
    let steps = select(holes[r.left].steps, holes[min(r.hole, MOST_HOLES - 1u)].host_steps, r.left == NO_HOLE);
    return (ceil(r.within.x * steps) - 1.0) / steps;
}

// The texel at a place of the ray before a piece that goes on, as the piece's body has texels.
fn texel_before(r: BodyRay, k: f32) -> f32 {
    let p = r.o + r.d * k;
    if (r.left == NO_HOLE) {
        return texel_of_host(r.hole, p);
    }
    // A ray may be in a hole for less than a step.
    if (all(p >= holes[r.left].lo) && all(p <= holes[r.left].hi)) {
        return texel_of_filling(r.left, p);
    }
    return texel_in(holes[r.left].host, p);
}

fn sample_on(steps: f32, place: f32) -> f32 {
    return ceil(place * steps) / steps;
}

// Whether a ray meets any hole of the picture.
fn meets(ray: Ray) -> bool {
    var met = false;
    for (var i = 0u; i < view.hole_count; i += 1u) {
        let span = hole_span(i, ray);
        met = met || span.x < span.y;
    }
    return met;
}

// The first piece of a body's ray from `start` on and before `most` that no finer volume fills; x ≥ y if there is none.
fn piece_from(whole: BodyRay, ray: Ray, start: f32, most: f32) -> BodyRay {
    var r = whole;
    let first = bodies[r.body].first_hole;
    let count = bodies[r.body].hole_count;
    var x = start;
    var y = most;
    r.steps = select(holes[min(r.hole, MOST_HOLES - 1u)].steps, 1.0, r.hole == NO_HOLE);
    var begins = sample_on(r.steps, start);
    r.joins = vec2<bool>(false);
    r.left = NO_HOLE;
    r.ends_whole = false;
    if (r.hole != NO_HOLE) {
        let own = hole_span(r.hole, ray);
        begins = sample_on(holes[r.hole].host_steps, start);
        r.joins = vec2<bool>(start == own.x, most == own.y);
    }
    // Holes that touch are left one after another, in whatever order they are listed.
    for (var turn = 0u; turn < count; turn += 1u) {
        for (var i = first; i < first + count; i += 1u) {
            let hole = hole_span(i, ray);
            if (hole.x < hole.y && hole.x <= x && x <= hole.y) {
                x = hole.y;
                begins = max(sample_on(holes[i].steps, hole.y), sample_on(r.steps, hole.x));
                r.joins.x = true;
                r.left = i;
            }
        }
    }
    for (var i = first; i < first + count; i += 1u) {
        let hole = hole_span(i, ray);
        if (hole.x < hole.y && hole.x > x && hole.x <= y) {
            y = hole.x;
            r.joins.y = true;
            r.ends_whole = holes[i].seamless != 0u;
        }
    }
    // Where looks differ nothing reaches over.
    if (r.joins.y && r.hole != NO_HOLE && y == most) {
        r.ends_whole = holes[r.hole].seamless != 0u;
    }
#ifndef REFINE
#ifndef ISO
#ifndef MIP
    // What is left of a step that begins in a hole is taken as finely.
    if (r.left != NO_HOLE) {
        let whole = sample_on(r.steps, begins);
        if (begins < whole) {
            if (whole < y) {
                y = whole;
                r.joins.y = true;
            }
            r.steps = max(r.steps, holes[r.left].steps);
        }
    }
#endif
#endif
#endif
    lattice = r.steps;
    r.within = vec2<f32>(x, y);
    r.span = vec2<f32>(begins, sample_on(r.steps, y));
    return r;
}
