// How much of the selection is seen: a count of pixels, and per body a count of those that it alone hides.
//
// A pixel counts as selected where the selected matter alone reaches opacity ½; it is visible if the bodies before that sample
// have less than 5 % opacity together. Extinctions add, so each body is marched by itself.

#import burin::constants::{FAR, MASK_SELECTION}
#import burin::body::{Ray, view, bodies, ray_through, listed_at, body_at, body_ray, interval}
#import burin::fade
#import burin::layers
#import burin::march::march
#ifdef HOLES
#import burin::holes::piece_from
#endif

// Selected pixels, visible ones, then a number per body.
@group(2) @binding(0) var<storage, read_write> counts: array<atomic<u32>>;

const HIDES: f32 = 0.05;

// Marches a body's samples before `most` until its transmittance falls to `limit`: transmittance, and the sample at which it
// did, FAR if it did not.
fn faded(body: u32, ray: Ray, most: f32, limit: f32) -> vec2<f32> {
    let r = body_ray(body, ray);
    let within = interval(r, ray);
    fade::begin(limit);
#ifdef HOLES
    var at = within.x;
    loop {
        let open = piece_from(r, ray, at, within.y);
        if (open.within.x >= open.within.y || fade::done()) {
            break;
        }
        march(open, open.span.x, min(open.span.y, most));
        at = open.within.y;
    }
#else
#ifdef CUTS
    var piece = layers::next_piece(within.x, within.y);
    while (piece.x < piece.y && !fade::done()) {
        march(r, ceil(piece.x), min(ceil(piece.y), most));
        piece = layers::next_piece(piece.y, within.y);
    }
#else
    march(r, ceil(within.x), min(ceil(within.y), most));
#endif
#endif
    return fade::end();
}

@compute @workgroup_size(8, 8)
fn count(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= view.width || id.y >= view.height) {
        return;
    }
    let px = vec2<f32>(id.xy) + 0.5;
    layers::look_at(px);
    let listed = listed_at(px);
    let ray = ray_through(px);
    var reached = FAR;
    for (var i = 0u; i < listed.count; i += 1u) {
        let body = body_at(listed.first + i);
        if (bodies[body].mask == MASK_SELECTION) {
            reached = min(reached, faded(body, ray, reached, 0.5).y);
        }
    }
    if (reached == FAR) {
        return;
    }
    atomicAdd(&counts[0], 1u);
    if (layers::is_hidden(reached)) {
        return;
    }
    var clear = 1.0;
    for (var i = 0u; i < listed.count; i += 1u) {
        let body = body_at(listed.first + i);
        if (bodies[body].mask != MASK_SELECTION) {
            let hidden = faded(body, ray, reached, 1.0 - HIDES);
            clear *= hidden.x;
            if (hidden.y < FAR) {
                atomicAdd(&counts[2u + body], 1u);
            }
        }
    }
    if (1.0 - clear < HIDES) {
        atomicAdd(&counts[1], 1u);
    }
}
