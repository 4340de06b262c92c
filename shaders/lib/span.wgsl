#define_import_path burin::span
// Which samples of a body's ray are looked at, and where their voxels are.
//
// A span is a half-open interval of the lattice, k0 ≤ k < k1. The next sample of a span is the first one that does not lie in
// empty space. A run is the samples from there on that one page serves: it ends at a brick's border, at the span's end or after
// as many samples as its caller says, whichever comes first, and ignores the borders of cells.

#import burin::constants::BRICK
#import burin::field::{Page, brick_of, density_page, density_texel, address, selection_page, skip_within, label_entry, has_labels, info}
#import burin::body::{BodyRay, view, sample_from, sample_after, sample_distance}
#import burin::look::{goes_by_label, take_label}

// The samples of this pass on what of a ray is inside its body: from x on, before y.
fn samples_in(r: BodyRay) -> vec2<f32> {
#ifdef HOLES
    return vec2<f32>(max(r.span.x, view.k_from), min(r.span.y, view.k_to));
#else
    return vec2<f32>(max(ceil(r.within.x), view.k_from), min(ceil(r.within.y), view.k_to));
#endif
}

// The same where samples end stretches of the ray: the last one lies where the ray leaves the body.
fn stretches_in(r: BodyRay) -> vec2<f32> {
    let first = max(sample_from(r.within.x), view.k_from);
#ifdef HOLES
    // What lies behind takes the stretch that reaches over.
    let last = select(sample_from(r.within.y) + sample_distance(), r.within.y, r.joins.y);
    let end = min(last, view.k_to);
#else
    let end = min(sample_from(r.within.y) + sample_distance(), view.k_to);
#endif
    return vec2<f32>(first, select(first, end, r.within.x < r.within.y));
}

// The place of sample k.
fn place_of(r: BodyRay, k: f32) -> vec3<f32> {
#ifdef REFINE
    return r.o + r.d * min(k, r.within.y);
#else
    return r.o + r.d * k;
#endif
}

// The first sample at or after `first` whose cell may show something; k1 or later if there is none before k1.
fn next_sample(r: BodyRay, first: f32, k1: f32) -> f32 {
    var k = first;
#ifndef PLAIN
    loop {
        if (k >= k1) {
            break;
        }
#ifdef REFINE
        let cell = floor(r.cell_o + r.cell_d * min(k, r.within.y));
#else
        let cell = floor(r.cell_o + r.cell_d * k);
#endif
        let distance = skip_within(r.skip_place, r.cell_last, cell);
        if (distance == 0u) {
            break;
        }
        let leave = (cell + 0.5 - r.cell_o) * r.cell_i + (f32(distance) - 0.5) * abs(r.cell_i);
        k = max(sample_after(k), sample_from(min(leave.x, min(leave.y, leave.z))));
    }
#endif
    return k;
}

struct Run {
    brick: vec3<i32>,           // of the first sample
    page: Page,
    selection: Page,            // where the picture asks for the selection
    // Sample k is at the address q + dq·k.
    q: vec3<f32>,
    dq: vec3<f32>,
    end: f32,                   // the first sample that is none of them
    last: f32,                  // where the ray leaves the body
#ifdef LABEL_RUNS
    labels: vec2<u32>,          // the entry of the brick's labels
    varies: bool,               // whether looks go by label and the brick has several
#endif
}

// The run that begins at sample k and ends at `most` at the latest.
fn run_from(r: BodyRay, k: f32, most: f32) -> Run {
    let brick = brick_of(place_of(r, k));
    let page = density_page(brick);
#ifdef SELECTION
    let selection = selection_page(brick);
#else
    let selection = page;
#endif
    let end = run_end(r, brick, k, most);
#ifdef LABEL_RUNS
    let labels = label_entry(brick);
    let varies = goes_by_label() && has_labels(labels);
    if (goes_by_label() && !varies) {
        take_label(labels.g);
    }
    return Run(brick, page, selection, r.o * page.scale + page.off, r.d * page.scale, end, r.within.y, labels, varies);
#else
    return Run(brick, page, selection, r.o * page.scale + page.off, r.d * page.scale, end, r.within.y);
#endif
}

// The texel at sample k of a run.
fn run_texel(run: Run, k: f32) -> f32 {
#ifdef REFINE
    return density_texel(run.page, run.q + run.dq * min(k, run.last));
#else
    return density_texel(run.page, run.q + run.dq * k);
#endif
}

// The texel anywhere on a ray.
fn texel_on(r: BodyRay, k: f32) -> f32 {
    let p = r.o + r.d * k;
    let page = density_page(brick_of(p));
    return density_texel(page, address(page, p));
}

// Where a run that begins at sample k of a brick of level 0 ends: with the brick, at `most` at the latest. One sample at least.
fn run_end(r: BodyRay, brick: vec3<i32>, k: f32, most: f32) -> f32 {
#ifdef IN_PLACE
#ifndef SELECTION
#ifndef LABEL_RUNS
    // One page serves all bricks.
    return most;
#else
    return min(most, max(brick_end(r, brick), sample_after(k)));
#endif
#else
    return min(most, max(brick_end(r, brick), sample_after(k)));
#endif
#else
    return min(most, max(brick_end(r, brick), sample_after(k)));
#endif
}

// The first sample at or after which the ray has left a brick of level 0.
fn brick_end(r: BodyRay, brick: vec3<i32>) -> f32 {
    let corner = f32(BRICK) * (vec3<f32>(brick) + select(vec3<f32>(0.0), vec3<f32>(1.0), r.d > vec3<f32>(0.0))) - 0.5;
    let leave = (corner - r.o) * r.cell_i / f32(info.cell);
    return sample_from(min(leave.x, min(leave.y, leave.z)));
}
