#define_import_path burin::merge
// Any number of overlapping bodies at once, direct volume rendering: extinctions add, colours are weighted by extinction.
//
// Where only one body's samples lie ahead its ray is marched as if it were alone; where several overlap their samples are
// gathered, SHARED_RUN at a time, and composed together. With MODES, samples that stand for a whole body lie between them.

#import burin::constants::{FAR, MOST_BODIES}
#import burin::body::{Ray, BodyRay, Listed, body_ray, body_at, interval}
#ifdef HOLES
#import burin::holes::{piece_from, goes_on}
#endif
#import burin::layers
#import burin::dvr::{samples_of, evaluate, compose, turn_to, done as clouded}
#ifdef REFINE
#import burin::dvr::inside
#endif
#ifdef CONTOUR
#import burin::light::{line_here, set_line}
#endif
#import burin::span::{next_sample, run_from}
#import burin::march::{march, seek, place_found, further, begin_run}
#ifdef MODES
#import burin::constants::{MODE_DVR, MODE_ISO}
#import burin::body::{view, body_mode}
#import burin::iso
#import burin::mip
#endif

// Extinction that stands for an opaque sample: finite, so that overlapping ones share the colour.
const OPAQUE: f32 = 1.0e6;

// Intervals that a ray can hold.
#ifdef UP_TO_ALL
const CAPACITY: u32 = MOST_BODIES;
#else
#ifdef UP_TO_64
const CAPACITY: u32 = 64u;
#else
#ifdef UP_TO_16
const CAPACITY: u32 = 16u;
#else
const CAPACITY: u32 = 4u;
#endif
#endif
#endif
const SHARED_RUN: u32 = 16u;
// So many samples of one body are not worth the merging of several.
const ALONE: f32 = 8.0;

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
                mix_in(c, u32(floor(place_found(found)) - first), r.body);
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

// A body's ray of which it is known where it is inside the body.
fn ray_within(body: u32, ray: Ray, within: vec2<f32>) -> BodyRay {
#ifdef HOLES
    return piece_from(body_ray(body, ray), ray, within.x, within.y);
#else
    var r = body_ray(body, ray);
    r.within = within;
    return r;
#endif
}

#ifdef MODES
// One sample of a whole body: an iso-surface, or a maximum.
struct Event {
    at: f32,                    // where it lies among the samples of others, in steps; FAR if there is none
    shown_at: f32,              // what depth it tells
    colour: vec4<f32>,
#ifdef CONTOUR
    line: f32,                  // how much of it is drawn
#endif
}

fn event(at: f32, shown_at: f32, colour: vec4<f32>) -> Event {
#ifdef CONTOUR
    return Event(at, shown_at, colour, line_here());
#else
    return Event(at, shown_at, colour);
#endif
}

// Events that lie no farther apart come in the order of their bodies.
const TOGETHER: f32 = 0.001;

// The sample at which those of an interval end that come before an event. Stretches end at the event; what is left of the one that it
// lies in begins at it.
fn end_before(event_at: f32, k1: f32, within: vec2<f32>) -> f32 {
#ifdef REFINE
    let end = select(0.0, ceil(event_at) + 1.0, within.x < event_at);
    return select(k1, min(k1, end), event_at < within.y);
#else
    return min(k1, ceil(event_at));
#endif
}

// What of an interval lies before an event, as far as samples stand for stretches.
fn up_to(event_at: f32, within: vec2<f32>) -> vec2<f32> {
#ifdef REFINE
    return vec2<f32>(within.x, min(within.y, event_at));
#else
    return within;
#endif
}

// Looks for the surface or the maximum of a body on an interval of its ray.
fn search(whole: BodyRay, within: vec2<f32>) {
    var r = whole;
    r.within = within;
    if (body_mode() == MODE_ISO) {
        let span = iso::enter_between(r, 0.0, FAR);
        march(r, span.x, span.y);
        iso::leave(r);
    } else {
#ifdef HOLES
        march(r, r.span.x, r.span.y);
#else
        march(r, ceil(within.x), ceil(within.y));
#endif
    }
}

#ifdef HOLES
// The same piece by piece, where finer volumes fill boxes of the body.
fn search_pieces(r: BodyRay, ray: Ray, within: vec2<f32>) {
    var at = within.x;
    loop {
        let piece = piece_from(r, ray, at, within.y);
        if (piece.within.x >= piece.within.y || iso::nearest < FAR) {
            break;
        }
        search(piece, piece.within);
        at = piece.within.y;
    }
}
#else
fn search_pieces(r: BodyRay, ray: Ray, within: vec2<f32>) {
    search(r, within);
}
#endif

fn event_of(r: BodyRay, ray: Ray, within: vec2<f32>) -> Event {
    iso::restart();
    mip::restart();
#ifdef CUTS
    var piece = layers::next_piece(within.x, within.y);
    while (piece.x < piece.y && iso::nearest == FAR) {
        search_pieces(r, ray, piece);
        piece = layers::next_piece(piece.y, within.y);
    }
#else
    search_pieces(r, ray, within);
#endif
    if (iso::nearest < FAR) {
        let colour = iso::surface(r, ray);
        return event(iso::nearest, iso::nearest, colour);
    }
    if (mip::largest > -FAR) {
        return event(within.y, mip::largest_at, mip::maximum(r));
    }
    return event(FAR, FAR, vec4<f32>(0.0));
}
#endif

fn march_merged(listed: Listed, ray: Ray) {
    // By interval: its body, its end, and the first sample from the current one on that may show something of it.
    var ahead: array<f32, CAPACITY>;
    var k1: array<f32, CAPACITY>;
    var who: array<u32, CAPACITY>;
    var within: array<vec2<f32>, CAPACITY>;
#ifdef REFINE
    var inside_at: array<bool, CAPACITY>;
#endif
    var n = 0u;
#ifdef MODES
    var events: array<Event, CAPACITY>;
    var event_body: array<u32, CAPACITY>;
    var event_count = 0u;
#endif
    for (var i = 0u; i < listed.count; i += 1u) {
        let body = body_at(listed.first + i);
        let r = body_ray(body, ray);
        let visible = layers::in_front(interval(r, ray));
#ifdef MODES
        if (body_mode() != MODE_DVR) {
            if (visible.x < visible.y && event_count < CAPACITY) {
                let event = event_of(r, ray, visible);
                // Of the pass that it lies in, and of something that shows.
                if (event.at < FAR && event.at >= view.k_from && event.at < view.k_to && event.colour.a > 0.0) {
                    events[event_count] = event;
                    event_body[event_count] = body;
                    event_count += 1u;
                }
            }
            continue;
        }
#endif
#ifdef CUTS
        var piece = layers::next_piece(visible.x, visible.y);
        while (piece.x < piece.y) {
            let part = piece;
            piece = layers::next_piece(piece.y, visible.y);
#else
            let part = visible;
#endif
#ifdef HOLES
            var at = part.x;
            loop {
                let open_part = piece_from(r, ray, at, part.y);
                if (open_part.within.x >= open_part.within.y || n >= CAPACITY) {
                    break;
                }
                let span = samples_of(open_part);
                if (span.x < span.y) {
                    ahead[n] = next_sample(open_part, span.x, span.y);
#ifdef REFINE
                    ahead[n] = select(ahead[n], span.x, goes_on(open_part));
#endif
                    k1[n] = span.y;
                    who[n] = body;
                    within[n] = open_part.within;
                    n += 1u;
                }
                at = open_part.within.y;
            }
#else
            let inner = ray_within(body, ray, part);
            let span = samples_of(inner);
            if (span.x < span.y && n < CAPACITY) {
                ahead[n] = next_sample(inner, span.x, span.y);
                k1[n] = span.y;
                who[n] = body;
                within[n] = part;
                n += 1u;
            }
#endif
#ifdef CUTS
        }
#endif
    }
    loop {
#ifdef MODES
        var next = CAPACITY;
        var next_at = FAR;
        for (var j = 0u; j < event_count; j += 1u) {
            let at = events[j].at;
            let tied = abs(at - next_at) <= TOGETHER && event_body[j] < event_body[min(next, CAPACITY - 1u)];
            if (at < next_at - TOGETHER || tied) {
                next = j;
                next_at = at;
            }
        }
#endif
        var first = FAR;
        var second = FAR;
        var nearest = 0u;
        for (var j = 0u; j < n; j += 1u) {
#ifdef MODES
            let end = end_before(next_at, k1[j], within[j]);
#else
            let end = k1[j];
#endif
            let at = select(FAR, ahead[j], ahead[j] < end);
            if (at < first) {
                second = first;
                first = at;
                nearest = j;
            } else {
                second = min(second, at);
            }
        }
#ifdef MODES
        if (clouded()) {
            break;
        }
        if (first == FAR && next_at < FAR) {
            turn_to(event_body[next]);
#ifdef CONTOUR
            set_line(events[next].line);
#endif
            compose(events[next].colour, events[next].shown_at);
            events[next].at = FAR;
#ifdef REFINE
            for (var j = 0u; j < n; j += 1u) {
                if (within[j].x < next_at && next_at < within[j].y) {
                    within[j].x = next_at;
                    inside_at[j] = false;
                    ahead[j] = next_sample(ray_within(who[j], ray, within[j]), max(ceil(next_at), view.k_from), k1[j]);
                }
            }
#endif
            continue;
        }
        // Samples before it come first.
#ifdef REFINE
        let until = ceil(next_at) + 1.0;
#else
        let until = ceil(next_at);
#endif
        second = min(second, until);
#endif
        if (first == FAR || clouded()) {
            break;
        }
        var reached = min(second, k1[nearest]);
#ifdef HOLES
        // Nothing else begins before it ends, or not soon.
        let alone = second - first >= ALONE || second >= k1[nearest];
#else
        let alone = second - first >= ALONE;
#endif
        if (alone) {
            turn_to(who[nearest]);
#ifdef MODES
            reached = min(reached, end_before(next_at, k1[nearest], within[nearest]));
            march(ray_within(who[nearest], ray, up_to(next_at, within[nearest])), first, reached);
#else
            march(ray_within(who[nearest], ray, within[nearest]), first, reached);
#endif
#ifdef REFINE
            inside_at[nearest] = inside();
#endif
        } else {
#ifdef HOLES
            // A step's samples, of whatever resolution, are composed together.
            let base = floor(first);
#else
            let base = first;
#endif
            reached = base + f32(SHARED_RUN);
#ifdef MODES
            reached = min(reached, until);
#endif
            for (var i = 0u; i < SHARED_RUN; i += 1u) {
                matter[i] = vec4<f32>(0.0);
                strongest[i] = vec2<f32>(0.0);
#ifdef CONTOUR
                lines[i] = 0.0;
#endif
            }
            for (var j = 0u; j < n; j += 1u) {
#ifdef MODES
                let end = min(reached, end_before(next_at, k1[j], within[j]));
                let part = up_to(next_at, within[j]);
#else
                let end = min(reached, k1[j]);
                let part = within[j];
#endif
                if (ahead[j] < end) {
                    gather(ray_within(who[j], ray, part), base, ahead[j], end);
#ifdef REFINE
                    inside_at[j] = inside();
#endif
                }
            }
            for (var i = 0u; i < SHARED_RUN; i += 1u) {
                let m = matter[i];
                if (m.a > 0.0 && !clouded()) {
                    turn_to(u32(strongest[i].y));
#ifdef CONTOUR
                    set_line(lines[i] / m.a);
#endif
                    compose(vec4<f32>(m.rgb / m.a, 1.0 - exp(-m.a)), base + f32(i));
                }
            }
        }
        for (var j = 0u; j < n; j += 1u) {
            if (ahead[j] < reached) {
#ifdef REFINE
                if (inside_at[j]) {
                    ahead[j] = reached;
                    continue;
                }
#endif
                ahead[j] = next_sample(ray_within(who[j], ray, within[j]), reached, k1[j]);
            }
        }
    }
}
