// How much of the selection is seen: a count of pixels, and per body a count of those that it alone hides.
//
// A pixel counts as selected where the selected matter alone reaches opacity ½; it is visible if the bodies before that sample
// have less than 5 % opacity together. Extinctions add, so each body is marched by itself.

#import burin::body::{Sight, BodyRay, view, bodies, sight_of, head_of, listed, ray_of, interval, skip_empty, run_from, run_texel, FAR, MERGE as MERGE_TILE}
#import burin::field::{selection_page, selection_at}
#import burin::look::{table_at, share, opacity_of_share}

// Selected pixels, visible ones, then a number per body.
@group(2) @binding(0) var<storage, read_write> counts: array<atomic<u32>>;

const SELECTION_MASK: u32 = 1u;
const HIDES: f32 = 0.05;

struct Faded {
    clear: f32,
    at: f32,                    // the sample at which transmittance fell to the limit, FAR if it did not
}

// Marches a body until its transmittance, from `clear`, falls to `limit`.
fn fade(r: BodyRay, k0: f32, k1: f32, start: f32, limit: f32) -> Faded {
    var k = k0;
    var clear = start;
    var at = FAR;
    loop {
        k = skip_empty(r, k, k1);
        if (k >= k1 || at < FAR) {
            break;
        }
        let run = run_from(r, k, min(k1, k + 32.0));
        loop {
            if (k >= run.end || at < FAR) {
                break;
            }
            var alpha = table_at(run_texel(run, k)).a;
#ifdef SELECTION
            if (alpha > 0.0 && r.mask != 0u) {
                alpha = opacity_of_share(alpha, share(r.mask, selection_at(selection_page(run.brick), r.o + r.d * k)));
            }
#endif
            clear *= 1.0 - alpha;
            if (clear <= limit) {
                at = k;
            }
            k += 1.0;
        }
    }
    return Faded(clear, at);
}

@compute @workgroup_size(8, 8)
fn count(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= view.width || id.y >= view.height) {
        return;
    }
    let px = vec2<f32>(id.xy) + 0.5;
    let head = head_of(px);
    let listed_count = head.y & ~MERGE_TILE;
    let sight = sight_of(px);
    var reached = FAR;
    for (var i = 0u; i < listed_count; i += 1u) {
        let body = listed(head.x + i);
        if (bodies[body].mask == SELECTION_MASK) {
            let r = ray_of(body, sight);
            let within = interval(r, sight);
            let selected = fade(r, ceil(within.x), min(ceil(within.y), reached), 1.0, 0.5);
            reached = min(reached, selected.at);
        }
    }
    if (reached == FAR) {
        return;
    }
    atomicAdd(&counts[0], 1u);
    var clear = 1.0;
    for (var i = 0u; i < listed_count; i += 1u) {
        let body = listed(head.x + i);
        if (bodies[body].mask != SELECTION_MASK) {
            let r = ray_of(body, sight);
            let within = interval(r, sight);
            let hidden = fade(r, ceil(within.x), min(ceil(within.y), reached), 1.0, 1.0 - HIDES);
            clear *= hidden.clear;
            if (hidden.at < FAR) {
                atomicAdd(&counts[2u + body], 1u);
            }
        }
    }
    if (1.0 - clear < HIDES) {
        atomicAdd(&counts[1], 1u);
    }
}
