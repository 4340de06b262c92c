// The surface at a density: the nearest hit of any body, refined by bisection, cut faces capped with the plane's normal.
//
// Bodies may overlap: each ends the others' search at its own hit. A mask divides matter at ½; where it, and not the density,
// makes the surface, the selection's gradient is the normal.

#import burin::body::{Sight, BodyRay, view, bodies, planes, sight_of, head_of, listed, ray_of, interval, skip_empty, run_from, run_texel, FAR, MERGE as MERGE_TILE}
#import burin::field::{Page, brick_of, density_page, density_texel, address, selection_page, selection_at, is_nan}
#import burin::look::{table, painted, gradient, lit, facing}

#ifdef RESUME
@group(0) @binding(7) var before_colour: texture_2d<f32>;
@group(0) @binding(8) var before_depth: texture_2d<f32>;
@group(0) @binding(9) var before_object: texture_2d<u32>;
#endif

const RUN: f32 = 8.0;
const BISECTIONS: u32 = 12u;

struct Picture {
    @location(0) colour: vec4<f32>,
    @location(1) depth: f32,
    @location(2) object: u32,
}

fn reaches(texel: f32) -> bool {
#ifdef FLOAT_DENSITY
    return !is_nan(texel) && texel >= view.iso;
#else
    return texel >= view.iso;
#endif
}

fn owns(mask: u32, s: f32) -> bool {
    return mask == 0u || (s >= 0.5) == (mask == 1u);
}

fn selected(p: vec3<f32>) -> f32 {
#ifdef SELECTION
    return selection_at(selection_page(brick_of(p)), p);
#else
    return 0.0;
#endif
}

fn dense(p: vec3<f32>) -> bool {
    let page = density_page(brick_of(p));
    return reaches(density_texel(page, address(page, p)));
}

fn inside(r: BodyRay, k: f32) -> bool {
    let p = r.o + r.d * k;
    return dense(p) && owns(r.mask, selected(p));
}

// Cosine between the ray and the outward normal of the face by which it enters the body.
fn entry_cosine(r: BodyRay, sight: Sight, entry: f32) -> f32 {
    let a = (bodies[r.body].lo - r.o) / r.d;
    let b = (bodies[r.body].hi - r.o) / r.d;
    let near = min(a, b);
    let m = mat3x3<f32>(bodies[r.body].column_x, bodies[r.body].column_y, bodies[r.body].column_z);
    // A face is told by the place at which the ray meets it, as far as these numbers tell places apart.
    var nearest = 1e-3 + 2e-6 * entry;
    var cosine = 1.0;
    // Faces of the box: planes of one index, normal = a row of index_from_world.
    for (var axis = 0u; axis < 3u; axis += 1u) {
        let off = abs(near[axis] - entry);
        if (off < nearest) {
            nearest = off;
            let normal = vec3<f32>(m[0][axis], m[1][axis], m[2][axis]);
            cosine = dot(normal, sight.dir) / length(normal);
        }
    }
    for (var i = 0u; i < bodies[r.body].plane_count; i += 1u) {
        let plane = planes[bodies[r.body].first_plane + i];
        let slope = dot(plane.xyz, sight.dir);
        let t = -(plane.w + dot(plane.xyz, sight.start)) / (slope * view.step_mm);
        if (slope < 0.0 && abs(t - entry) <= nearest) {
            nearest = abs(t - entry);
            cosine = slope;
        }
    }
    return cosine;
}

// The first hit of a body, in steps; FAR if there is none before `limit`. A negative value is a capped entry, −1 − k. What a
// sample finds lies after the sample before it: an entry belongs to the pass of the sample that follows it, and the sample that
// follows `limit` may still find something before it.
fn search(r: BodyRay, within: vec2<f32>, limit: f32) -> f32 {
    let entry = within.x;
    let follows = ceil(entry);
    let enters = entry < min(within.y, limit) && follows >= view.k_from && follows < view.k_to;
    if (enters && inside(r, entry)) {
        return -1.0 - entry;
    }
    let k1 = min(min(ceil(within.y), ceil(limit) + 1.0), view.k_to);
    var k = max(follows, view.k_from);
    if (k >= k1) {
        return FAR;
    }
    var hit = FAR;
    loop {
        k = skip_empty(r, k, k1);
        if (k >= k1 || hit < FAR) {
            break;
        }
        let run = run_from(r, k, min(k1, k + RUN));
        loop {
            if (k >= run.end || hit < FAR) {
                break;
            }
            if (reaches(run_texel(run, k))) {
#ifdef SELECTION
                if (owns(r.mask, selected(r.o + r.d * k))) {
                    hit = k;
                }
#else
                hit = k;
#endif
            }
            k += 1.0;
        }
    }
    if (hit < FAR) {
        var outer = max(hit - 1.0, entry);
        for (var i = 0u; i < BISECTIONS; i += 1u) {
            let middle = 0.5 * (outer + hit);
            if (inside(r, middle)) {
                hit = middle;
            } else {
                outer = middle;
            }
        }
    }
    return hit;
}

// Cosine of the surface's normal at a refined hit.
fn surface_cosine(r: BodyRay, k: f32) -> f32 {
    let p = r.o + r.d * k;
    let brick = brick_of(p);
#ifdef SELECTION
    // A hair before the hit there is matter, but another body's: the mask makes the surface.
    if (r.mask != 0u && dense(r.o + r.d * (k - 1.0 / 256.0))) {
        let page = selection_page(brick);
        let x = vec3<f32>(0.5, 0.0, 0.0);
        let y = vec3<f32>(0.0, 0.5, 0.0);
        let z = vec3<f32>(0.0, 0.0, 0.5);
        let g = vec3<f32>(
            selection_at(page, p + x) - selection_at(page, p - x),
            selection_at(page, p + y) - selection_at(page, p - y),
            selection_at(page, p + z) - selection_at(page, p - z),
        );
        return facing(r, g, 1.0);
    }
#endif
    let page = density_page(brick);
    return facing(r, gradient(page, p), density_texel(page, address(page, p)));
}

@vertex
fn cover(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn march_pixel(@builtin(position) at: vec4<f32>) -> Picture {
    var picture = Picture(vec4<f32>(0.0), FAR, 0u);
#ifdef RESUME
    let texel = vec2<i32>(at.xy);
    picture = Picture(
        textureLoad(before_colour, texel, 0),
        textureLoad(before_depth, texel, 0).r,
        textureLoad(before_object, texel, 0).r,
    );
    if (picture.object != 0u) {
        return picture;
    }
#endif
    let head = head_of(at.xy);
    let merge = (head.y & MERGE_TILE) != 0u;
    let sight = sight_of(at.xy);
    var best = FAR;
    var capped = false;
    var body = 0u;
    for (var i = 0u; i < (head.y & ~MERGE_TILE); i += 1u) {
        let r = ray_of(listed(head.x + i), sight);
        let found = search(r, interval(r, sight), best);
        let k = select(found, -1.0 - found, found < 0.0);
        if (k < best) {
            best = k;
            capped = found < 0.0;
            body = r.body;
        }
        if (best < FAR && !merge) {
            break;
        }
    }
    if (best < FAR) {
        let r = ray_of(body, sight);
        let p = r.o + r.d * best;
        let s = selected(p);
        // The colour of the surface's value, for caps too.
        let value = clamp(view.iso * view.table_scale + view.table_bias, 0.0, 4095.0);
        var colour = textureLoad(table, vec2<i32>(i32(value), 0), 0).rgb;
        colour = painted(colour, p, s) * bodies[body].tint;
#ifdef LIT
        var cosine = 1.0;
        if (capped) {
            cosine = entry_cosine(r, sight, best);
        } else {
            cosine = surface_cosine(r, best);
        }
        colour = lit(colour, cosine);
#endif
        picture.colour = vec4<f32>(colour, 1.0);
        picture.depth = best * view.step_mm;
        picture.object = bodies[body].code;
        if (bodies[body].tells_selection != 0u && s >= 0.5) {
            picture.object += 1u;
        }
    }
    return picture;
}
