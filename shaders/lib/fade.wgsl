#define_import_path burin::fade
// Transmittance alone: where the matter of a body lets less than a limit through. What `visibility` counts by.

#import burin::constants::FAR
#import burin::field::selection_at
#import burin::body::{BodyRay, sample_after}
#import burin::look::{look_at, table_at, share, opacity_of_share}
#import burin::span::Run

const RUN: f32 = 32.0;

var<private> clear: f32;
var<private> limit: f32;
var<private> faded_at: f32;

// A ray of full light; it ends where its transmittance falls to `limit_at`.
fn begin(limit_at: f32) {
    clear = 1.0;
    limit = limit_at;
    faded_at = FAR;
}

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
    var alpha = c.a;
#ifdef SELECTION
    if (alpha > 0.0 && r.mask != 0u) {
        alpha = opacity_of_share(alpha, share(r.mask, selection_at(run.selection, r.o + r.d * k)));
    }
#endif
#ifdef HOLES
    alpha = opacity_of_share(alpha, sample_after(k) - k);
#endif
    clear *= 1.0 - alpha;
    if (clear <= limit) {
        faded_at = k;
    }
}

fn open(r: BodyRay, k: f32) {}

fn inside() -> bool {
    return false;
}

fn done() -> bool {
    return faded_at < FAR;
}

// Transmittance, and the sample at which it fell to the limit, FAR if it did not.
fn end() -> vec2<f32> {
    return vec2<f32>(clear, faded_at);
}
