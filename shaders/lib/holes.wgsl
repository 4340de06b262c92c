#define_import_path burin::holes
// Boxes of a volume that a finer one fills: what of a body's ray lies outside of them, and which samples that is.
//
// What a ray meets is told by where it is inside holes, the same for all bodies of a family: a volume, its boxes, boxes of those. A
// sample at k stands for the ray up to the sample after it. A step of the lattice that begins in a box is divided as often as the
// box is finer, each part that begins in a box of that box again; so no place counts twice or not at all, wherever a ray leaves a
// box, and for whichever other. Surfaces are sought as finely in all of an outermost box as in the finest that the ray meets there.

#import burin::constants::{FAR, NO_HOLE, MOST_HOLES, MODE_ISO, MODE_DVR}
#import burin::body::{Ray, BodyRay, view, bodies, holes, matters, hole_span, between_planes, lattice, sample_on, sample_up_to, body_mode}
#import burin::field::{brick_of, density_page, density_texel, address, enter_volume, info}

// Faces no farther from a plane than this, in steps, are cut by it.
const FLUSH: f32 = 1e-3;

// ---- texels of a family

// A texel of what fills a hole in those of the host that fills none.
fn to_root(hole: u32, texel: f32) -> f32 {
    if (hole == NO_HOLE) {
        return texel;
    }
    return (texel - holes[hole].texel_bias) / holes[hole].texel_ratio;
}

// The other way.
fn from_root(hole: u32, texel: f32) -> f32 {
    if (hole == NO_HOLE) {
        return texel;
    }
    return texel * holes[hole].texel_ratio + holes[hole].texel_bias;
}

// How many texels of what fills a hole, or of the host that fills none, one of that host is.
fn ratio_of(hole: u32) -> f32 {
    return select(holes[min(hole, MOST_HOLES - 1u)].texel_ratio, 1.0, hole == NO_HOLE);
}

// The texel where a body of a family goes on, in its own texels: at a place in the index space of what fills a hole, by the finest
// that lies there. The body's volume is that which is looked at then.
fn texel_of_family(body: u32, from_hole: u32, place: vec3<f32>) -> f32 {
    let first = bodies[body].first_hole;
    let end = first + bodies[body].hole_count;
    var p = place;
    var inside = from_hole;
    loop {
        if (inside == NO_HOLE) {
            break;
        }
        p = holes[inside].lo + p / holes[inside].scale;
        inside = holes[inside].host_hole;
    }
    var volume = holes[first].host;
    for (var i = first; i < end; i += 1u) {
        if (holes[i].host_hole == inside && all(p >= holes[i].lo) && all(p <= holes[i].hi)) {
            p = (p - holes[i].lo) * holes[i].scale;
            inside = i;
            volume = holes[i].volume;
        }
    }
    enter_volume(volume);
    let page = density_page(brick_of(p));
    let texel = to_root(inside, density_texel(page, address(page, p)));
    enter_volume(matters[body].volume);
    return from_root(from_hole, texel);
}

// The same beside a hole: where its host goes on, or that one's. The hole's volume is that which is looked at then. Without loops,
// for which software Vulkan has a limit that samples soon come to.
fn texel_beside(hole: u32, place: vec3<f32>) -> f32 {
    var p = holes[hole].lo + place / holes[hole].scale;
    var volume = holes[hole].host;
    var inside = holes[hole].host_hole;
    let host = min(inside, MOST_HOLES - 1u);
    let last = (holes[host].hi - holes[host].lo) * holes[host].scale;
    if (inside != NO_HOLE && (any(p < vec3<f32>(0.0)) || any(p > last))) {
        p = holes[host].lo + p / holes[host].scale;
        volume = holes[host].host;
        inside = holes[host].host_hole;
    }
    enter_volume(volume);
    let page = density_page(brick_of(p));
    let texel = to_root(inside, density_texel(page, address(page, p)));
    enter_volume(holes[hole].volume);
    return from_root(hole, texel);
}

// The texel at a place of the ray before a piece that goes on, as the piece's body has texels.
fn texel_before(r: BodyRay, k: f32) -> f32 {
    return texel_of_family(r.body, r.hole, r.o + r.d * k);
}

// ---- what lies along a ray

// Whether a ray meets any hole of the picture.
fn meets(ray: Ray) -> bool {
    var met = false;
    // Their list ends itself: of a number of them in the view software Vulkan would compile the shader anew for every picture.
    for (var i = 0u; i < MOST_HOLES; i += 1u) {
        if (holes[i].steps == 0.0) {
            break;
        }
        let span = hole_span(i, ray);
        met = met || span.x < span.y;
    }
    return met;
}

// Samples in a step where a hole is filled.
fn steps_in(hole: u32) -> f32 {
    return select(holes[min(hole, MOST_HOLES - 1u)].steps, 1.0, hole == NO_HOLE);
}

// The innermost hole of a body's family that a ray is in from a place on, or (`before`) up to it; NO_HOLE where it is in none.
fn hole_at(body: u32, ray: Ray, place: f32, before: bool) -> u32 {
    let first = bodies[body].first_hole;
    let end = first + bodies[body].hole_count;
    var inside = NO_HOLE;
    for (var i = first; i < end; i += 1u) {
        let span = hole_span(i, ray);
        let holds = select(span.x <= place && place < span.y, span.x < place && place <= span.y, before);
        if (holes[i].host_hole == inside && holds) {
            inside = i;
        }
    }
    return inside;
}

// The sample that stands for a place of a ray: where it lies, how many of its kind are in a step, and where the coarser one ends
// that it is a part of.
struct Cell {
    at: f32,
    steps: f32,
    until: f32,
}

fn cell_at(body: u32, ray: Ray, place: f32) -> Cell {
    let first = bodies[body].first_hole;
    let end = first + bodies[body].hole_count;
    let whole = sample_up_to(1.0, place);
    var cell = Cell(whole, 1.0, whole + 1.0);
    var inside = NO_HOLE;
    for (var i = first; i < end; i += 1u) {
        let span = hole_span(i, ray);
        if (holes[i].host_hole == inside && span.x <= cell.at && cell.at < span.y) {
            let until = next_of(cell);
            cell = Cell(sample_up_to(holes[i].steps, place), holes[i].steps, until);
            inside = i;
        }
    }
    return cell;
}

// The sample after a cell's, of its kind.
fn next_of(cell: Cell) -> f32 {
    return (floor(cell.at * cell.steps + 0.25) + 1.0) / cell.steps;
}

// The first sample of a ray at or after a place, whosever it is.
fn begin_at(body: u32, ray: Ray, place: f32) -> f32 {
    let cell = cell_at(body, ray, place);
    return select(next_of(cell), cell.at, cell.at >= place);
}

// Whether what lies in two holes of a family is shown alike; by way of their hosts.
fn are_alike(one: u32, other: u32) -> bool {
    var a = one;
    var b = other;
    var alike = true;
    loop {
        if (a == b) {
            break;
        }
        // Hosts come before what is cut out of them.
        let later = select(max(a, b), min(a, b), max(a, b) == NO_HOLE);
        alike = alike && holes[later].seamless != 0u;
        let host = holes[later].host_hole;
        let is_a = a == later;
        a = select(a, host, is_a);
        b = select(host, b, is_a);
    }
    return alike;
}

// Whether other matter than a body's own, shown alike, goes on beyond a place of its ray.
fn goes_over(r: BodyRay, ray: Ray, place: f32, before: bool) -> bool {
    let beyond = hole_at(r.body, ray, place, before);
    return beyond != r.hole && are_alike(beyond, r.hole);
}

#ifdef REFINE
// Whether the stretch that ends at sample k begins before its piece.
fn reaches_over(r: BodyRay, k: f32) -> bool {
    return r.joins.x && k - 1.0 / r.steps < r.within.x;
}

// Where a ray came to the matter of a hole, or of the host that fills none, that it is in up to a place.
fn start_of(body: u32, ray: Ray, inside: u32, place: f32) -> f32 {
    let first = bodies[body].first_hole;
    let end = first + bodies[body].hole_count;
    var start = select(hole_span(min(inside, MOST_HOLES - 1u), ray).x, 0.0, inside == NO_HOLE);
    for (var i = first; i < end; i += 1u) {
        let span = hole_span(i, ray);
        if (holes[i].host_hole == inside && span.x < span.y && span.y < place) {
            start = max(start, span.y);
        }
    }
    return start;
}

// Where a ray enters the volume that the boxes of a family are cut out of.
fn start_of_root(body: u32, ray: Ray) -> f32 {
    let hole = bodies[body].first_hole;
    let m = mat3x3<f32>(holes[hole].column_x, holes[hole].column_y, holes[hole].column_z);
    let o = holes[hole].eye + m * ray.start;
    let along = m * ray.dir * view.step_mm;
    enter_volume(holes[hole].host);
    let last = vec3<f32>(info.dims) - 0.5;
    enter_volume(matters[body].volume);
    let inverse = 1.0 / select(along, vec3<f32>(1e-20), abs(along) < vec3<f32>(1e-20));
    let near = min((vec3<f32>(-0.5) - o) * inverse, (last - o) * inverse);
    return max(max(near.x, near.y), max(near.z, 0.0));
}

// Matter along a ray that is too short for a sample: so many of them on end are looked behind.
const SHORT: u32 = 4u;

// The last sample before a place that a ray is in another's matter up to; no farther back than the body goes.
fn sample_before(r: BodyRay, ray: Ray, place: f32, entry: f32) -> f32 {
    var at = place;
    for (var turn = 0u; turn < SHORT; turn += 1u) {
        let inside = hole_at(r.body, ray, at, true);
        let steps = steps_in(inside);
        let k = (round(sample_on(steps, at) * steps) - 1.0) / steps;
        let start = start_of(r.body, ray, inside, at);
        at = max(start, k);
        if (k >= start) {
            break;
        }
    }
    return max(at, max(entry, start_of_root(r.body, ray)));
}
#endif

// ---- pieces

// Whether the body that was turned to last is one whose surface is sought.
fn is_sought() -> bool {
#ifdef ISO
    return true;
#else
#ifdef MODES
    return body_mode() == MODE_ISO;
#else
    return false;
#endif
#endif
}

// Whether its samples stand for stretches.
fn is_stretched() -> bool {
#ifdef REFINE
    return body_mode() == MODE_DVR;
#else
    return false;
#endif
}

// The hole of a family that one lies in and that lies in none.
fn outermost(hole: u32) -> u32 {
    var outer = hole;
    loop {
        let host = holes[outer].host_hole;
        if (host == NO_HOLE) {
            break;
        }
        outer = host;
    }
    return outer;
}

// Samples in a step by which a surface is sought: those of the finest box that the ray meets in the outermost about a body.
fn steps_to_seek(r: BodyRay, ray: Ray) -> f32 {
    if (r.hole == NO_HOLE) {
        return 1.0;
    }
    let outer = outermost(r.hole);
    let first = bodies[r.body].first_hole;
    let end = first + bodies[r.body].hole_count;
    var steps = steps_in(r.hole);
    for (var i = first; i < end; i += 1u) {
        let span = hole_span(i, ray);
        if (span.x < span.y && outermost(i) == outer) {
            steps = max(steps, holes[i].steps);
        }
    }
    return steps;
}

// The first piece of a body's ray from `start` on and before `most` that no finer volume fills; x ≥ y if there is none.
fn piece_from(whole: BodyRay, ray: Ray, start: f32, most: f32) -> BodyRay {
    var r = whole;
    let first = bodies[r.body].first_hole;
    let end = first + bodies[r.body].hole_count;
    var x = start;
    var y = most;
    // Holes that touch are left one after another, in whatever order they are listed.
    loop {
        let before = x;
        for (var i = first; i < end; i += 1u) {
            let hole = hole_span(i, ray);
            if (holes[i].host_hole == r.hole && hole.x <= x && x < hole.y) {
                x = hole.y;
            }
        }
        if (x == before) {
            break;
        }
    }
    r.within = vec2<f32>(x, y);
    if (x >= y) {
        return r;
    }
    for (var i = first; i < end; i += 1u) {
        let hole = hole_span(i, ray);
        if (holes[i].host_hole == r.hole && hole.x < hole.y && hole.x > x && hole.x < y) {
            y = hole.x;
        }
    }
    r.steps = steps_in(r.hole);
    r.joins = vec2<bool>(false);
    let sought = is_sought();
    if (sought || is_stretched()) {
        let planes = between_planes(r, ray, vec2<f32>(0.0, FAR));
        r.joins.x = x - planes.x > FLUSH && goes_over(r, ray, x, true);
        r.joins.y = planes.y - y > FLUSH && goes_over(r, ray, y, false);
        r.steps = select(r.steps, steps_to_seek(r, ray), sought);
        r.span = vec2<f32>(sample_on(r.steps, x), sample_on(r.steps, y));
#ifdef REFINE
        if (r.joins.x && !sought) {
            r.before = sample_before(r, ray, x, planes.x);
        }
#endif
    } else {
        r.span = vec2<f32>(begin_at(r.body, ray, x), begin_at(r.body, ray, y));
        let own = cell_at(r.body, ray, r.span.x);
        if (r.span.x < r.span.y && own.steps != r.steps) {
            // What is left of a sample of other matter.
            r.steps = own.steps;
            y = min(y, own.until);
            r.span.y = min(r.span.y, own.until);
        }
    }
    lattice = r.steps;
    r.within.y = y;
    return r;
}
