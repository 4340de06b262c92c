#define_import_path burin::march
// The one loop of all modes: a body's ray, sample by sample.
//
// A ray skips to the next sample that may show something, then takes a run that ignores the borders of cells. What a sample
// means is the mode's, a module of functions over a ray's state:
//     begin(before) -> bool          a pixel begins; false where earlier passes have finished it
//     enter(r) -> k0 k1              a body begins: the span to march
//     meet(r, run, k, texel)         what a sample is to the mode, as colour; nothing where its alpha is 0
//     after(k)                       the sample to meet next
//     add(r, run, k, texel, colour)  takes a sample
//     done() -> bool                 nothing behind matters to the body's ray
//     leave(r)                       a body ends
//     over(merge) -> bool            nothing behind matters to the pixel; `merge`: the bodies have no order
//     end(before, ray) -> Picture    a pixel ends
// and where samples stand for the stretch of the ray that ends at them (REFINE):
//     open(r, k)                     the stretch that ends at sample k begins anew, not where one before it ended
//     inside() -> bool               whether what was taken last shows at its end
// MIP: higher(r) is the ray as it skips what holds no more than it has met.
// LABEL_RUNS: looks go by label, and what a brick's labels are is told by its page.
// FOUND_AT: the sample after one is not always a step further.
// STAGED: samples that are nothing are passed over in a loop of their own, so that `add` may be dear; else each is added.

#import burin::body::{BodyRay, sample_distance}
#ifdef HOLES
#import burin::holes::reaches_over
#endif
#import burin::span::{Run, next_sample, run_from, run_texel}
#ifdef MODES
#import burin::modes as mode
#else
#ifdef ISO
#import burin::iso as mode
#else
#ifdef MIP
#import burin::mip as mode
#else
#ifdef COUNTS
#import burin::fade as mode
#else
#import burin::dvr as mode
#endif
#endif
#endif
#endif
#ifdef MIP
#import burin::mip::higher
#endif
#ifdef LABEL_RUNS
#import burin::field::label_in
#import burin::look::take_label
#ifdef REFINE
#import burin::dvr::middle_to
#ifdef MODES
#import burin::constants::MODE_DVR
#import burin::body::body_mode
#endif
#endif
#endif

// Where a run shows something next.
struct Found {
#ifdef FOUND_AT
    at: f32,
#endif
    k: f32,                     // the sample to meet next
    texel: f32,
    colour: vec4<f32>,          // what it is to the mode; clear if nothing more shows
}

// The sample that was found.
fn place_found(found: Found) -> f32 {
#ifdef FOUND_AT
    return found.at;
#else
    return found.k - 1.0;
#endif
}

#ifdef LABEL_RUNS
// Where a ray is asked whose look the matter of sample k has.
fn told_at(r: BodyRay, k: f32) -> f32 {
#ifdef REFINE
#ifdef MODES
    return select(k, middle_to(r, k), body_mode() == MODE_DVR);
#else
    return middle_to(r, k);
#endif
#else
    return k;
#endif
}
#endif

fn seek(r: BodyRay, run: Run, first: f32) -> Found {
#ifdef FOUND_AT
    var found = Found(first, first, 0.0, vec4<f32>(0.0));
#else
    var found = Found(first, 0.0, vec4<f32>(0.0));
#endif
#ifdef LABEL_RUNS
    // A loop of its own, since a branch in the other one would cost every sample a look at its label.
    loop {
        if (!run.varies || found.k >= run.end) {
            break;
        }
        take_label(label_in(run.labels, run.brick, r.o + r.d * told_at(r, found.k)));
        found.texel = run_texel(run, found.k);
        found.colour = mode::meet(r, run, found.k, found.texel);
#ifdef FOUND_AT
        found.at = found.k;
#endif
        found.k = mode::after(found.k);
        if (found.colour.a > 0.0) {
            break;
        }
    }
#endif
    loop {
#ifdef LABEL_RUNS
        if (run.varies || found.k >= run.end) {
            break;
        }
#else
        if (found.k >= run.end) {
            break;
        }
#endif
        found.texel = run_texel(run, found.k);
        found.colour = mode::meet(r, run, found.k, found.texel);
#ifdef FOUND_AT
        found.at = found.k;
#endif
        found.k = mode::after(found.k);
        if (found.colour.a > 0.0) {
            break;
        }
    }
    return found;
}

// The next sample of a span at or after k; `next` is the sample after the last one that was taken.
fn further(r: BodyRay, k: f32, next: f32, k1: f32) -> f32 {
#ifdef REFINE
    // Matter that a ray is in goes on up to the next sample, whatever that one shows.
    if (k == next && mode::inside()) {
        return k;
    }
#ifdef HOLES
    // What lies before a piece may show up to its first sample.
    if (reaches_over(r, k)) {
        return k;
    }
#endif
#endif
#ifdef MIP
    return next_sample(higher(r), k, k1);
#else
    return next_sample(r, k, k1);
#endif
}

// A run begins at sample k.
fn begin_run(r: BodyRay, k: f32, next: f32) {
#ifdef REFINE
    if (k != next) {
        mode::open(r, k);
    }
#endif
}

fn march(r: BodyRay, k0: f32, k1: f32) {
    var k = k0;
    var next = -1.0;
    loop {
        k = further(r, k, next, k1);
        if (k >= k1 || mode::done()) {
            break;
        }
        let run = run_from(r, k, min(k1, k + mode::RUN * sample_distance()));
        begin_run(r, k, next);
#ifdef STAGED
        // Asked at the end: software Vulkan runs what follows a break once more for nothing.
        loop {
            let found = seek(r, run, k);
            k = found.k;
            if (found.colour.a > 0.0) {
                mode::add(r, run, place_found(found), found.texel, found.colour);
            }
            continuing {
                break if k >= run.end || mode::done();
            }
        }
#else
#ifdef LABEL_RUNS
        // As in `seek` a brick of several labels has a loop of its own.
        loop {
            if (!run.varies || k >= run.end || mode::done()) {
                break;
            }
            take_label(label_in(run.labels, run.brick, r.o + r.d * told_at(r, k)));
            let texel = run_texel(run, k);
            mode::add(r, run, k, texel, mode::meet(r, run, k, texel));
            k = mode::after(k);
        }
        loop {
            if (run.varies || k >= run.end || mode::done()) {
                break;
            }
            let texel = run_texel(run, k);
            mode::add(r, run, k, texel, mode::meet(r, run, k, texel));
            k = mode::after(k);
        }
#else
        loop {
            let texel = run_texel(run, k);
            mode::add(r, run, k, texel, mode::meet(r, run, k, texel));
            k = mode::after(k);
            continuing {
                break if k >= run.end || mode::done();
            }
        }
#endif
#endif
        next = k;
    }
}
