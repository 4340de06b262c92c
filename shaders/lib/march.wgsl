#define_import_path burin::march
// The one loop of all modes: a body's ray, sample by sample.
//
// A ray skips to the next sample that may show something, then takes a run that ignores the borders of cells. What a sample
// means is the mode's, a module of functions over a ray's state:
//     begin(before) -> bool          a pixel begins; false where earlier passes have finished it
//     enter(r, ray, within) -> k0 k1 a body begins: the span to march
//     meet(texel) -> colour          what a texel is to the mode; nothing where its alpha is 0
//     add(r, run, k, texel, colour)  takes a sample
//     done() -> bool                 nothing behind matters to the body's ray
//     leave(r, within)               a body ends
//     over(merge) -> bool            nothing behind matters to the pixel; `merge`: the bodies have no order
//     end(before, ray) -> Picture    a pixel ends
// STAGED: samples that are nothing are passed over in a loop of their own, so that `add` may be dear; else each is added.

#import burin::body::BodyRay
#import burin::span::{Run, next_sample, run_from, run_texel}
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

// Where a run shows something next.
struct Found {
    k: f32,                     // the sample after it
    texel: f32,
    colour: vec4<f32>,          // what it is to the mode; clear if nothing more shows
}

fn seek(run: Run, first: f32) -> Found {
    var found = Found(first, 0.0, vec4<f32>(0.0));
    loop {
        if (found.k >= run.end) {
            break;
        }
        found.texel = run_texel(run, found.k);
        found.colour = mode::meet(found.texel);
        found.k += 1.0;
        if (found.colour.a > 0.0) {
            break;
        }
    }
    return found;
}

fn march(r: BodyRay, k0: f32, k1: f32) {
    var k = k0;
    loop {
        k = next_sample(r, k, k1);
        if (k >= k1 || mode::done()) {
            break;
        }
        let run = run_from(r, k, min(k1, k + mode::RUN));
        // Asked at the end: software Vulkan runs what follows a break once more for nothing.
        loop {
#ifdef STAGED
            let found = seek(run, k);
            k = found.k;
            if (found.colour.a > 0.0) {
                mode::add(r, run, k - 1.0, found.texel, found.colour);
            }
#else
            let texel = run_texel(run, k);
            mode::add(r, run, k, texel, mode::meet(texel));
            k += 1.0;
#endif
            continuing {
                break if k >= run.end || mode::done();
            }
        }
    }
}
