// Surface particles: a grid over an iso-surface ("Direct Volume Editing", 2008, section 5; equation 5 as F = N×(O×N)).
//
// Two particles leave the centre along F and against it (`spine`); from every place of theirs two more along B = N×F and against it
// (`ribs`). Places are in world mm from the centre that was picked. N points toward lower values.

#import burin::constants::{MOST_VOLUMES, MOST_CORRECTIONS}
#import burin::field::{density_between, enter_volume, is_nan}
#import burin::structs::{TraceTask, TraceVertex, TracedVolume}

// The family, the finest boxes first and what they are cut out of last; behind it the components of a vector field.
@group(0) @binding(0) var<uniform> volumes: array<TracedVolume, MOST_VOLUMES>;
// What loops end by is here: software Vulkan compiles anew for every uniform that one ends by.
@group(0) @binding(1) var<storage, read> task: TraceTask;
@group(0) @binding(2) var<storage, read_write> vertices: array<TraceVertex>;
// By place of the spine: B.
@group(0) @binding(3) var<storage, read_write> across: array<vec4<f32>>;

// A place in voxels of a volume, from its base on.
fn voxels_of(i: u32, place: vec3<f32>) -> vec3<f32> {
    return volumes[i].column_x * place.x + volumes[i].column_y * place.y + volumes[i].column_z * place.z + volumes[i].centre;
}

fn is_within(i: u32, q: vec3<f32>) -> bool {
    return all(q >= volumes[i].lo) && all(q <= volumes[i].hi);
}

// The value at a place in voxels of a volume, from its zero (of a family: the iso-value).
fn value_in(i: u32, q: vec3<f32>) -> f32 {
    enter_volume(volumes[i].place);
    let voxel = floor(q);
    return (density_between(volumes[i].base + vec3<i32>(voxel), q - voxel) - volumes[i].zero) * volumes[i].span;
}

// The finest volume that tells a place; their number if none does.
fn teller_of(place: vec3<f32>) -> u32 {
#ifdef BOXES
    for (var i = 0u; i < task.family; i++) {
        if (is_within(i, voxels_of(i, place))) {
            return i;
        }
    }
    return task.family;
#else
    return select(1u, 0u, is_within(0u, voxels_of(0u, place)));
#endif
}

// What the value at a place is above the iso-value, and whether anything tells it.
struct Excess {
    value: f32,
    known: bool,
}

fn excess_at(place: vec3<f32>) -> Excess {
    let teller = teller_of(place);
    let i = min(teller, task.family - 1u);
    let value = value_in(i, voxels_of(i, place));
    return Excess(value, teller < task.family && !is_nan(value));
}

// One more voxel along an axis of a volume, told by whatever lies there.
fn tap(i: u32, q: vec3<f32>, place: vec3<f32>) -> f32 {
#ifdef BOXES
    let other = min(teller_of(place), task.family - 1u);
    return value_in(other, voxels_of(other, place));
#else
    return value_in(i, q);
#endif
}

// The paper's gradient: between central differences at the centres of voxels, which is the difference of what lies between voxels one
// voxel either way. In world mm: a gradient turns as a covector does.
fn gradient_at(place: vec3<f32>) -> vec3<f32> {
    let i = min(teller_of(place), task.family - 1u);
    let q = voxels_of(i, place);
    let x = vec3<f32>(1.0, 0.0, 0.0);
    let rise = vec3<f32>(
        tap(i, q + x, place + volumes[i].axis_x) - tap(i, q - x, place - volumes[i].axis_x),
        tap(i, q + x.yxy, place + volumes[i].axis_y) - tap(i, q - x.yxy, place - volumes[i].axis_y),
        tap(i, q + x.yyx, place + volumes[i].axis_z) - tap(i, q - x.yyx, place - volumes[i].axis_z),
    );
    // At the volume's faces one side has nothing.
    let first = volumes[i].first;
    let last = volumes[i].last;
    let g = rise / max(clamp(q + 1.0, first, last) - clamp(q - 1.0, first, last), vec3<f32>(1e-6));
    return vec3<f32>(dot(volumes[i].column_x, g), dot(volumes[i].column_y, g), dot(volumes[i].column_z, g));
}

// A particle on the surface; `on` is false once it has ended.
struct Particle {
    place: vec3<f32>,
    on: bool,
    normal: vec3<f32>,
    slope: f32,                 // |gradient|
    forward: vec3<f32>,         // F
}

// Traces a place back along a normal onto the surface, by no more than `most` mm. What is left is told by the least slope that was met.
fn traced_back(start: vec3<f32>, before: Particle, most: f32) -> Particle {
    var p = before;
    p.place = start;
    p.on = false;
    var here = excess_at(start);
    var ended = !here.known;
    var slope = before.slope;
    var scale = 1.0;
    var gone = 0.0;
    var corrections = 0u;
    // Again where the slope at the place that was found is less.
    for (var again = 0u; again < 3u; again++) {
        if (ended || p.on) {
            break;
        }
        for (; corrections < MOST_CORRECTIONS; corrections++) {
            if (abs(here.value) <= task.tolerance_mm * slope) {
                break;
            }
            let way = clamp(here.value / before.slope, -most - gone, most - gone) * scale;
            let next_place = p.place + before.normal * way;
            let next = excess_at(next_place);
            ended = !next.known || abs(way) <= most * 1e-6;
            if (ended) {
                break;
            }
            slope = min(before.slope, abs(next.value - here.value) / abs(way));
            // Beyond the surface: from the last place on, by half.
            let crossed = (next.value < 0.0) != (here.value < 0.0);
            scale = select(scale, scale * 0.5, crossed);
            gone = select(gone + way, gone, crossed);
            p.place = select(next_place, p.place, crossed);
            here.value = select(next.value, here.value, crossed);
        }
        let gradient = gradient_at(p.place);
        let size = length(gradient);
        slope = min(slope, size);
        // False for NaN too.
        p.on = !ended && size > 0.0 && !is_nan(size) && abs(here.value) <= task.tolerance_mm * slope;
        p.normal = gradient * (-1.0 / size);
        p.slope = size;
    }
    return p;
}

// The projection of a direction into the tangent plane, F = N×(O×N), not normalised.
fn projected(o: vec3<f32>, n: vec3<f32>) -> vec3<f32> {
    return cross(n, cross(o, n));
}

// Turns a particle's direction into the tangent plane where it is.
fn transported(before: Particle) -> Particle {
    var p = before;
    let f = projected(before.forward, before.normal);
    let size = length(f);
    p.on = before.on && size > 1e-4;
    p.forward = f / max(size, 1e-4);
    return p;
}

#ifdef VECTORS
fn component(i: u32, place: vec3<f32>) -> f32 {
    let q = voxels_of(i, place);
    let value = value_in(i, q);
    // Codes may have no exact zero.
    let counts = is_within(i, q) && !is_nan(value) && abs(value) > volumes[i].least;
    return select(0.0, value, counts);
}

// Along the vector field; where that is zero, as before.
fn headed(before: Particle, first: bool) -> Particle {
    var p = transported(before);
    let i = task.family;
    let v = vec3<f32>(component(i, p.place), component(i + 1u, p.place), component(i + 2u, p.place));
    let size = max(max(abs(v.x), abs(v.y)), abs(v.z));
    let f = projected(v / max(size, 1e-37), p.normal);
    let part = length(f);
    p.forward = select(p.forward, f / max(part, 1e-4), size > 0.0 && part > 1e-4);
    return p;
}
#else
#ifdef CURVATURE
// Along the principal direction that is nearer to the way of before; at the centre along that which is asked for. Where the surface
// bends alike in all directions, as before.
fn headed(before: Particle, first: bool) -> Particle {
    var p = transported(before);
    let f = p.forward;
    let b = cross(p.normal, f);
    let h = volumes[min(teller_of(p.place), task.family - 1u)].voxel_mm;
    let along_f = gradient_at(p.place + h * f) - gradient_at(p.place - h * f);
    let along_b = gradient_at(p.place + h * b) - gradient_at(p.place - h * b);
    // The Hessian in the tangent plane, times 2h.
    let ff = dot(f, along_f);
    let bb = dot(b, along_b);
    let fb = 0.5 * (dot(b, along_f) + dot(f, along_b));
    let middle = 0.5 * (ff + bb);
    let half = length(vec2<f32>(0.5 * (ff - bb), fb));
    // Of the greater of the two, in the tangent plane from F to B.
    let greater = 0.5 * atan2(2.0 * fb, ff - bb);
    let quarter = 1.5707963;
    let nearer = greater - quarter * round(greater / quarter);
    let bends_most = abs(middle + half) >= abs(middle - half);
    let asked = select(greater + quarter, greater, bends_most != (task.least != 0u));
    var angle = select(nearer, asked, first);
    angle = select(angle, 0.0, !(half > 0.02 * (abs(middle) + half)));
    var way = f * cos(angle) + b * sin(angle);
    way = select(way, -way, dot(way, f) < 0.0);
    p.forward = way;
    return p;
}
#else
fn headed(before: Particle, first: bool) -> Particle {
    return transported(before);
}
#endif
#endif

fn keep(i: u32, p: Particle) {
    vertices[i].position = p.place;
    vertices[i].on = 1u;
    vertices[i].normal = p.normal;
    vertices[i].slope = p.slope;
}

// The centre: the picked place itself traced back along the normal there.
fn centre() -> Particle {
    var p: Particle;
    let gradient = gradient_at(vec3<f32>(0.0));
    p.slope = length(gradient);
    p.normal = gradient * (-1.0 / p.slope);
    p.forward = task.orientation;
    let sound = p.slope > 0.0 && !is_nan(p.slope);
    p = traced_back(vec3<f32>(0.0), p, task.first_mm);
    p.on = p.on && sound;
    return headed(p, true);
}

@compute @workgroup_size(8)
fn spine(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= 2u) {
        return;
    }
    let width = 2u * task.steps_along + 1u;
    let middle = task.steps_across * width + task.steps_along;
    var p = centre();
    if (id.x == 0u && p.on) {
        keep(middle, p);
        across[task.steps_along] = vec4<f32>(cross(p.normal, p.forward), 0.0);
    }
    // One particle goes against F, which keeps its sense, and so does B.
    let sense = select(1.0, -1.0, id.x == 1u);
    for (var i = 1u; i <= task.steps_along; i++) {
        if (p.on) {
            p = traced_back(p.place + sense * task.step_mm * p.forward, p, task.step_mm);
        }
        if (p.on) {
            p = headed(p, false);
        }
        if (!p.on) {
            break;
        }
        let column = select(i32(i), -i32(i), id.x == 1u);
        keep(u32(i32(middle) + column), p);
        across[u32(i32(task.steps_along) + column)] = vec4<f32>(cross(p.normal, p.forward), 0.0);
    }
}

@compute @workgroup_size(8)
fn ribs(@builtin(global_invocation_id) id: vec3<u32>) {
    let width = 2u * task.steps_along + 1u;
    let column = id.x >> 1u;
    if (column >= width) {
        return;
    }
    let start = task.steps_across * width + column;
    var p: Particle;
    p.place = vertices[start].position;
    p.on = vertices[start].on != 0u;
    p.normal = vertices[start].normal;
    p.slope = vertices[start].slope;
    let against = (id.x & 1u) == 1u;
    p.forward = select(across[column].xyz, -across[column].xyz, against);
    for (var i = 1u; i <= task.steps_across; i++) {
        if (p.on) {
            p = traced_back(p.place + task.step_mm * p.forward, p, task.step_mm);
        }
        if (p.on) {
            p = transported(p);
        }
        if (!p.on) {
            break;
        }
        let rows = select(i32(i), -i32(i), against) * i32(width);
        keep(u32(i32(start) + rows), p);
    }
}
