#define_import_path burin::merge
// Any number of overlapping bodies at once, direct volume rendering: extinctions add, colours are weighted by extinction.
//
// Where only one body's samples lie ahead its ray is marched as if it were alone; where several overlap their samples are
// gathered, SHARED_RUN at a time, and composed together. With MODES, samples that stand for a whole body lie between them. A body
// and what fills boxes of it (HOLES) are one there: one surface, one maximum. Samples of boxes are as many slots of the run, and
// those of other bodies beside them are spread over as many.

#import burin::constants::{FAR, MOST_BODIES}
#import burin::body::{Ray, BodyRay, Listed, body_ray, body_at, interval}
#ifdef HOLES
#import burin::body::{matters, lattice, sample_on}
#import burin::holes::piece_from
#endif
#import burin::layers
#import burin::dvr::{samples_of, compose, turn_to, done as clouded}
#import burin::gathered::{SHARED_RUN, matter, strongest, gather}
#ifdef HOLES
#import burin::gathered::slots
#endif
#ifdef REFINE
#import burin::dvr::inside
#endif
#ifdef CONTOUR
#import burin::light::set_line
#import burin::gathered::lines
#endif
#import burin::span::next_sample
#import burin::march::march
#import burin::body::view
#ifdef MARKS
#import burin::dvr::lay
#endif
#ifdef MODES
#import burin::constants::MODE_DVR
#import burin::body::body_mode
#ifdef HOLES
#import burin::events::{Event, event_of, is_first}
#else
#import burin::events::{Event, event_alone}
#endif
#endif

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
// So many samples of one body are not worth the merging of several.
const ALONE: f32 = 8.0;

#ifdef HOLES
// What of a piece of a body's ray is kept while others are marched.
struct Kept {
    within: vec2<f32>,
    steps: f32,
    before: f32,
    joins: vec2<bool>,
}

// A body's ray within a piece of it, or what an event leaves of that.
fn ray_kept(body: u32, ray: Ray, within: vec2<f32>, kept: Kept) -> BodyRay {
    var r = body_ray(body, ray);
    r.within = within;
    r.steps = kept.steps;
    lattice = kept.steps;
    r.before = kept.before;
    r.joins = vec2<bool>(kept.joins.x && within.x == kept.within.x, kept.joins.y && within.y == kept.within.y);
    return r;
}
#else
// A body's ray of which it is known where it is inside the body.
fn ray_within(body: u32, ray: Ray, within: vec2<f32>) -> BodyRay {
    var r = body_ray(body, ray);
    r.within = within;
    return r;
}
#endif

// Events that lie no farther apart come in the order of their bodies.
const TOGETHER: f32 = 0.001;

#ifdef EVENTS

// The sample at which those of an interval end that come before an event. Stretches end at the event; what is left of the one that it
// lies in begins at it.
fn end_before(event_at: f32, k1: f32, within: vec2<f32>, steps: f32) -> f32 {
#ifdef REFINE
    let end = select(0.0, ceil(event_at) + 1.0, within.x < event_at);
    return select(k1, min(k1, end), event_at < within.y);
#else
#ifdef HOLES
    return min(k1, sample_on(steps, event_at));
#else
    return min(k1, ceil(event_at));
#endif
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
#endif

fn march_merged(listed: Listed, ray: Ray) {
    // By interval: its body, its end, and the first sample from the current one on that may show something of it.
    var ahead: array<f32, CAPACITY>;
    var k1: array<f32, CAPACITY>;
    var who: array<u32, CAPACITY>;
    var within: array<vec2<f32>, CAPACITY>;
#ifdef HOLES
    var kept: array<Kept, CAPACITY>;
#endif
#ifdef REFINE
    var inside_at: array<bool, CAPACITY>;
#endif
    var n = 0u;
#ifdef MODES
    var events: array<Event, CAPACITY>;
    // Which comes first of those in one place.
    var event_order: array<u32, CAPACITY>;
    var event_count = 0u;
#endif
    for (var i = 0u; i < listed.count; i += 1u) {
        let body = body_at(listed.first + i);
        let r = body_ray(body, ray);
        let visible = layers::in_front(interval(r, ray));
#ifdef MODES
        if (body_mode() != MODE_DVR) {
#ifdef HOLES
            let searched = is_first(listed, i) && event_count < CAPACITY;
            let order = matters[body].kin;
#else
            let searched = visible.x < visible.y && event_count < CAPACITY;
            let order = body;
#endif
            if (searched) {
#ifdef HOLES
                let event = event_of(listed, i, ray);
#else
                let event = event_alone(r, ray, visible);
#endif
                // Of the pass that it lies in, and of something that shows.
                if (event.at < FAR && event.at >= view.k_from && event.at < view.k_to && event.colour.a > 0.0) {
                    events[event_count] = event;
                    event_order[event_count] = order;
                    event_count += 1u;
                }
            }
            continue;
        }
#endif
#ifdef CUTS
        var piece = layers::next_piece(r.body, visible.x, visible.y);
        while (piece.x < piece.y) {
            let part = piece;
            piece = layers::next_piece(r.body, piece.y, visible.y);
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
                    ahead[n] = select(ahead[n], span.x, open_part.joins.x);
#endif
                    k1[n] = span.y;
                    who[n] = body;
                    within[n] = open_part.within;
                    kept[n] = Kept(open_part.within, open_part.steps, open_part.before, open_part.joins);
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
        var next_at = FAR;
#ifdef MODES
        var next = CAPACITY;
        for (var j = 0u; j < event_count; j += 1u) {
            let at = events[j].at;
            let tied = abs(at - next_at) <= TOGETHER && event_order[j] < event_order[min(next, CAPACITY - 1u)];
            if (at < next_at - TOGETHER || tied) {
                next = j;
                next_at = at;
            }
        }
#endif
#ifdef MARKS
        let is_mark = layers::mark_at < next_at;
        next_at = min(next_at, layers::mark_at);
#endif
        var first = FAR;
        var second = FAR;
        var nearest = 0u;
        for (var j = 0u; j < n; j += 1u) {
#ifdef EVENTS
#ifdef HOLES
            let end = end_before(next_at, k1[j], within[j], kept[j].steps);
#else
            let end = end_before(next_at, k1[j], within[j], 1.0);
#endif
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
#ifdef EVENTS
        if (clouded()) {
            break;
        }
        if (first == FAR && next_at < FAR) {
#ifdef MARKS
            if (is_mark) {
                turn_to(layers::mark_body());
                lay(layers::mark_colour(), next_at);
                layers::pass_mark();
            }
#endif
#ifdef MODES
#ifdef MARKS
            if (!is_mark) {
#endif
            turn_to(events[next].body);
#ifdef CONTOUR
            set_line(events[next].line);
#endif
            compose(events[next].colour, events[next].shown_at);
            events[next].at = FAR;
#ifdef MARKS
            }
#endif
#endif
#ifdef REFINE
            for (var j = 0u; j < n; j += 1u) {
                if (within[j].x < next_at && next_at < within[j].y) {
                    within[j].x = next_at;
                    inside_at[j] = false;
#ifdef HOLES
                    let resumes = max(sample_on(kept[j].steps, next_at), view.k_from);
                    ahead[j] = next_sample(ray_kept(who[j], ray, within[j], kept[j]), resumes, k1[j]);
#else
                    ahead[j] = next_sample(ray_within(who[j], ray, within[j]), max(ceil(next_at), view.k_from), k1[j]);
#endif
                }
            }
#endif
            continue;
        }
        // Samples before it come first.
#ifdef REFINE
        let until = ceil(next_at) + 1.0;
#else
#ifdef HOLES
        let until = next_at;
#else
        let until = ceil(next_at);
#endif
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
#ifdef EVENTS
            let part = up_to(next_at, within[nearest]);
#else
            let part = within[nearest];
#endif
#ifdef HOLES
#ifdef EVENTS
            reached = min(reached, end_before(next_at, k1[nearest], within[nearest], kept[nearest].steps));
#endif
            march(ray_kept(who[nearest], ray, part, kept[nearest]), first, reached);
#else
#ifdef EVENTS
            reached = min(reached, end_before(next_at, k1[nearest], within[nearest], 1.0));
#endif
            march(ray_within(who[nearest], ray, part), first, reached);
#endif
#ifdef REFINE
            inside_at[nearest] = inside();
#endif
        } else {
#ifdef HOLES
            // From where the first sample's matter may begin, in slots as short as the finest samples about there.
#ifdef REFINE
            let base = ceil(first) - 1.0;
            const MOST_SLOTS = 8.0;
#else
            let base = floor(first);
            const MOST_SLOTS = 16.0;
#endif
            slots = 1.0;
            for (var j = 0u; j < n; j += 1u) {
                slots = select(slots, max(slots, kept[j].steps), ahead[j] < min(k1[j], base + f32(SHARED_RUN)));
            }
            slots = min(slots, MOST_SLOTS);
            reached = base + floor(f32(SHARED_RUN) / slots);
#else
            let base = first;
            reached = base + f32(SHARED_RUN);
#endif
#ifdef EVENTS
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
#ifdef EVENTS
                let part = up_to(next_at, within[j]);
#else
                let part = within[j];
#endif
#ifdef HOLES
                var end = min(sample_on(kept[j].steps, reached), k1[j]);
#ifdef EVENTS
                end = min(end, end_before(next_at, k1[j], within[j], kept[j].steps));
#endif
                if (ahead[j] < end) {
                    gather(ray_kept(who[j], ray, part, kept[j]), base, ahead[j], end);
#else
#ifdef EVENTS
                let end = min(reached, end_before(next_at, k1[j], within[j], 1.0));
#else
                let end = min(reached, k1[j]);
#endif
                if (ahead[j] < end) {
                    gather(ray_within(who[j], ray, part), base, ahead[j], end);
#endif
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
#ifdef HOLES
#ifdef REFINE
                    let at = base + (f32(i) + 1.0) / slots;
#else
                    let at = base + f32(i) / slots;
#endif
#else
                    let at = base + f32(i);
#endif
                    compose(vec4<f32>(m.rgb / m.a, 1.0 - exp(-m.a)), at);
                }
            }
        }
        for (var j = 0u; j < n; j += 1u) {
            if (ahead[j] < reached) {
#ifdef HOLES
                let resumes = sample_on(kept[j].steps, reached);
#else
                let resumes = reached;
#endif
#ifdef REFINE
                if (inside_at[j]) {
                    ahead[j] = resumes;
                    continue;
                }
#endif
#ifdef HOLES
                ahead[j] = next_sample(ray_kept(who[j], ray, within[j], kept[j]), resumes, k1[j]);
#else
                ahead[j] = next_sample(ray_within(who[j], ray, within[j]), resumes, k1[j]);
#endif
            }
        }
    }
}
