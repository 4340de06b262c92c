#define_import_path burin::events
// Samples that stand for a whole body: an iso-surface, or a maximum. What is found of a body and of what fills boxes of it (HOLES) is
// one of them. `merge` orders them among the samples of bodies that are rendered directly.

#import burin::constants::{FAR, MODE_ISO}
#import burin::body::{Ray, BodyRay, Listed, body_ray, body_at, body_mode, interval}
#ifdef HOLES
#import burin::body::matters
#import burin::holes::piece_from
#endif
#import burin::iso
#import burin::layers
#import burin::march::march
#import burin::mip
#ifdef CONTOUR
#import burin::light::line_here
#endif

// One sample of a whole body: an iso-surface, or a maximum.
struct Event {
    at: f32,                    // where it lies among the samples of others, in steps; FAR if there is none
    shown_at: f32,              // what depth it tells
    body: u32,                  // which shows there
    colour: vec4<f32>,
#ifdef CONTOUR
    line: f32,                  // how much of it is drawn
#endif
}

fn event(at: f32, shown_at: f32, body: u32, colour: vec4<f32>) -> Event {
#ifdef CONTOUR
    return Event(at, shown_at, body, colour, line_here());
#else
    return Event(at, shown_at, body, colour);
#endif
}

// Looks for the surface or the maximum of a body on an interval of its ray.
fn search(whole: BodyRay, within: vec2<f32>) {
    var r = whole;
    r.within = within;
    if (body_mode() == MODE_ISO) {
        let span = iso::enter_between(r, 0.0, FAR);
        march(r, span.x, span.y);
        iso::leave_between(r, 0.0, FAR);
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
        if (piece.within.x >= piece.within.y || piece.within.x > iso::nearest) {
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

// The same where meshes cut it.
fn search_all(r: BodyRay, ray: Ray, within: vec2<f32>) {
#ifdef CUTS
    var piece = layers::next_piece(r.body, within.x, within.y);
    while (piece.x < piece.y && piece.x <= iso::nearest) {
        search_pieces(r, ray, piece);
        piece = layers::next_piece(r.body, piece.y, within.y);
    }
#else
    search_pieces(r, ray, within);
#endif
}

// What was found; a maximum where the last of the bodies ends.
fn event_at(end: f32, ray: Ray) -> Event {
    if (iso::nearest < FAR) {
        let r = body_ray(iso::nearest_body, ray);
        let colour = iso::surface(r, ray);
        return event(iso::nearest, iso::nearest, r.body, colour);
    }
    if (mip::largest > -FAR) {
        let r = body_ray(mip::largest_body, ray);
        return event(end, mip::largest_at, r.body, mip::maximum(r));
    }
    return event(FAR, FAR, 0u, vec4<f32>(0.0));
}

#ifndef HOLES
// The event of a body.
fn event_alone(r: BodyRay, ray: Ray, within: vec2<f32>) -> Event {
    iso::restart();
    mip::restart();
    search_all(r, ray, within);
    return event_at(within.y, ray);
}
#else
// Whether none of its kin is listed before a body.
fn is_first(listed: Listed, i: u32) -> bool {
    let kin = matters[body_at(listed.first + i)].kin;
    var first = true;
    for (var j = 0u; j < i; j += 1u) {
        first = first && matters[body_at(listed.first + j)].kin != kin;
    }
    return first;
}

// The event of a listed body and of all kin that are listed after it.
fn event_of(listed: Listed, i: u32, ray: Ray) -> Event {
    iso::restart();
    mip::restart();
    let kin = matters[body_at(listed.first + i)].kin;
    var end = -FAR;
    for (var j = i; j < listed.count; j += 1u) {
        let body = body_at(listed.first + j);
        if (matters[body].kin == kin) {
            let r = body_ray(body, ray);
            let within = layers::in_front(interval(r, ray));
            if (within.x < within.y) {
                search_all(r, ray, within);
                end = max(end, within.y);
            }
        }
    }
    return event_at(end, ray);
}
#endif
