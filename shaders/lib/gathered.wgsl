#define_import_path burin::gathered
// A run of samples in which several bodies overlap: their matter in slots along the ray, so that extinctions add and colours are
// weighted by them. A slot is a step of the lattice, or (HOLES) as short as the finest samples about there.

#import burin::body::{BodyRay, sample_distance}
#import burin::dvr::evaluate
#ifdef REFINE
#ifdef HOLES
#import burin::dvr::{begins_at, ends_at}
#endif
#endif
#import burin::march::{seek, place_found, further, begin_run}
#import burin::span::run_from
#ifdef CONTOUR
#import burin::light::line_here
#endif

// Extinction that stands for an opaque sample: finite, so that overlapping ones share the colour.
const OPAQUE: f32 = 1.0e6;

const SHARED_RUN: u32 = 16u;

// Extinction-weighted colour and extinction of a run of samples in which several bodies overlap, and its strongest body.
var<private> matter: array<vec4<f32>, SHARED_RUN>;
var<private> strongest: array<vec2<f32>, SHARED_RUN>;
#ifdef CONTOUR
// Extinction-weighted share of it that is drawn.
var<private> lines: array<f32, SHARED_RUN>;
#endif

fn mix_in(c: vec4<f32>, i: u32, body: u32) {
    let extinction = select(-log(1.0 - c.a), OPAQUE, c.a >= 0.999999);
#ifdef CONTOUR
    lines[i] += line_here() * extinction;
#endif
    matter[i] += vec4<f32>(c.rgb * extinction, extinction);
    if (extinction > strongest[i].x) {
        strongest[i] = vec2<f32>(extinction, f32(body));
    }
}

#ifdef HOLES
// Slots of the run in a step of the lattice.
var<private> slots: f32 = 1.0;

// Spreads matter of a way from one place to another over the slots that it takes.
fn spread(c: vec4<f32>, start: f32, end: f32, base: f32, body: u32) {
    const HAIR: f32 = 1e-3;
    let first = u32(clamp(floor((start - base) * slots + HAIR), 0.0, f32(SHARED_RUN - 1u)));
    let last = u32(clamp(ceil((end - base) * slots - HAIR), f32(first + 1u), f32(SHARED_RUN)));
    let extinction = select(-log(1.0 - c.a), OPAQUE, c.a >= 0.999999);
    let each = extinction / f32(last - first);
    for (var i = first; i < last; i += 1u) {
#ifdef CONTOUR
        lines[i] += line_here() * each;
#endif
        matter[i] += vec4<f32>(c.rgb * each, each);
        if (each > strongest[i].x) {
            strongest[i] = vec2<f32>(each, f32(body));
        }
    }
}
#endif

// Adds a body's samples k0 ≤ k < k1, less than SHARED_RUN after `first`, to `matter`.
fn gather(r: BodyRay, first: f32, k0: f32, k1: f32) {
    var k = k0;
    var next = -1.0;
    loop {
        k = further(r, k, next, k1);
        if (k >= k1) {
            break;
        }
        let run = run_from(r, k, k1);
        begin_run(r, k, next);
        loop {
            let found = seek(r, run, k);
            k = found.k;
            if (found.colour.a > 0.0) {
                let c = evaluate(r, run, place_found(found), found.texel, found.colour);
#ifdef HOLES
#ifdef REFINE
                spread(c, begins_at, ends_at, first, r.body);
#else
                spread(c, place_found(found), place_found(found) + sample_distance(), first, r.body);
#endif
#else
                mix_in(c, u32(ceil(place_found(found)) - first), r.body);
#endif
            }
            if (k >= run.end) {
                break;
            }
        }
        next = k;
    }
}
