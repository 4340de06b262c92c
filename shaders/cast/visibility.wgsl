// How much of the selection is seen: a count of pixels, and per part a count of those that it alone hides.
//
// A pixel counts as selected where the selected matter alone reaches opacity ½; it is visible if the bodies before that sample
// have less than 5 % opacity together. Extinctions add, so each body is marched by itself; only what is selected in a volume and
// what is selected in its boxes is marched as it lies along the ray, since where it reaches ½ depends on that. Here bodies are kin
// that are selected in one family, or of one part.

#import burin::constants::{FAR, MASK_SELECTION}
#import burin::body::{Ray, BodyRay, Listed, view, bodies, matters, ray_through, listed_at, body_at, body_ray, interval}
#import burin::fade
#import burin::layers
#import burin::march::march
#ifdef HOLES
#import burin::holes::piece_from
#endif

// Selected pixels, visible ones, then a number per body.
@group(2) @binding(0) var<storage, read_write> counts: array<atomic<u32>>;

const HIDES: f32 = 0.05;

// The first piece of an interval of a body's ray, from `at` on, that nothing cuts away and no finer volume fills; x ≥ y if there is
// none.
fn next_open(whole: BodyRay, ray: Ray, within: vec2<f32>, at: f32) -> BodyRay {
    var piece = vec2<f32>(max(within.x, at), within.y);
#ifdef CUTS
    piece = layers::next_piece(whole.body, piece.x, within.y);
#endif
#ifdef HOLES
    var r = piece_from(whole, ray, piece.x, piece.y);
#ifdef CUTS
    // All of a piece may be filled.
    while (r.within.x >= r.within.y && piece.x < piece.y) {
        piece = layers::next_piece(whole.body, piece.y, within.y);
        r = piece_from(whole, ray, piece.x, piece.y);
    }
#endif
#else
    var r = whole;
    r.within = piece;
#endif
    return r;
}

fn march_before(r: BodyRay, most: f32) {
#ifdef HOLES
    march(r, r.span.x, min(r.span.y, most));
#else
    march(r, ceil(r.within.x), min(ceil(r.within.y), most));
#endif
}

// Marches a body's samples before `most` until its transmittance falls to the limit.
fn fade_through(body: u32, ray: Ray, most: f32) {
    let whole = body_ray(body, ray);
    let within = interval(whole, ray);
    var at = within.x;
    loop {
        let r = next_open(whole, ray, within, at);
        if (r.within.x >= r.within.y || fade::done()) {
            break;
        }
        march_before(r, most);
        at = r.within.y;
    }
}

// Whether a listed body is one of `kin`.
fn is_of(listed: Listed, i: u32, kin: u32) -> bool {
    return matters[body_at(listed.first + i)].kin == kin;
}

// Whether none of its kin is listed before a body.
fn is_first(listed: Listed, i: u32) -> bool {
    let kin = matters[body_at(listed.first + i)].kin;
    var first = true;
    for (var j = 0u; j < i; j += 1u) {
        first = first && !is_of(listed, j, kin);
    }
    return first;
}

// The sample before `most` at which what is selected in the family of a listed body reaches opacity ½; FAR if it does not.
fn reached_by(listed: Listed, i: u32, ray: Ray, most: f32) -> f32 {
    fade::begin(0.5);
#ifdef HOLES
    let kin = matters[body_at(listed.first + i)].kin;
    var at = 0.0;
    loop {
        var next_at = FAR;
        var next = 0u;
        for (var j = i; j < listed.count; j += 1u) {
            if (is_of(listed, j, kin)) {
                let body = body_at(listed.first + j);
                let whole = body_ray(body, ray);
                let r = next_open(whole, ray, interval(whole, ray), at);
                if (r.within.x < min(r.within.y, next_at)) {
                    next_at = r.within.x;
                    next = body;
                }
            }
        }
        if (next_at == FAR || fade::done()) {
            break;
        }
        let whole = body_ray(next, ray);
        let r = next_open(whole, ray, interval(whole, ray), at);
        march_before(r, most);
        at = r.within.y;
    }
#else
    fade_through(body_at(listed.first + i), ray, most);
#endif
    return fade::end().y;
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
#ifdef HOLES
        let counts_once = is_first(listed, i);
#else
        let counts_once = true;
#endif
        if ((bodies[body].mask & 3u) == MASK_SELECTION && counts_once) {
            reached = min(reached, reached_by(listed, i, ray, reached));
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
        if ((bodies[body].mask & 3u) != MASK_SELECTION && is_first(listed, i)) {
            let kin = matters[body].kin;
            fade::begin(1.0 - HIDES);
            for (var j = i; j < listed.count; j += 1u) {
                if (is_of(listed, j, kin) && !fade::done()) {
                    fade_through(body_at(listed.first + j), ray, reached);
                }
            }
            let hidden = fade::end();
            clear *= hidden.x;
            if (hidden.y < FAR) {
                atomicAdd(&counts[2u + kin], 1u);
            }
        }
    }
    if (1.0 - clear < HIDES) {
        atomicAdd(&counts[1], 1u);
    }
}
