#define_import_path burin::coverage
// What dabs lay on voxels: G = strength F(d), F = 0 beyond the support (Direct Volume Editing, 2008, equation 2), and what a stroke
// gathers of it. Four voxels at a time that follow each other along x, so that a dab is read once for four.

#import burin::stroke::{LARGEST, LINEAR, PRODUCT, SMOOTH, Choices, dabs, stroke}

// e^(-4.5), what a bell has left at the radius: taken from it, or it would jump there.
const GAUSSIAN_RIM: f32 = 0.011108997;
// Pieces of a drawn falloff.
const CURVE_PIECES: u32 = 11u;
// 1.0
const ONE: u32 = 0x3f800000u;

fn g_of(i: u32, x: vec4<i32>, yz: vec2<i32>, falloff: u32) -> vec4<f32> {
    let dab = dabs[i];
    let ox = vec4<f32>(x - dab.base.x) - dab.fraction.x;
    let o = vec2<f32>(yz - dab.base.yz) - dab.fraction.yz;
    let a = stroke.columns[0];
    let b = stroke.columns[1];
    let c = stroke.columns[2];
    var dx = a.x * ox + b.x * o.x + c.x * o.y;
    var dy = a.y * ox + b.y * o.x + c.y * o.y;
    var dz = a.z * ox + b.z * o.x + c.z * o.y;
    let axis = (dab.form >> 1u) & 3u;
    // A ball is a disc without a normal.
#ifdef FORMED
    let upright = dab.normal;
#else
    let upright = vec3<f32>(0.0);
#endif
    var n = select(upright, stroke.normals[0].xyz, axis == 1u);
    n = select(n, stroke.normals[1].xyz, axis == 2u);
    n = select(n, stroke.normals[2].xyz, axis == 3u);
    let lift = dots(dx, dy, dz, vec4<f32>(n.x), vec4<f32>(n.y), vec4<f32>(n.z));
    dx -= n.x * lift;
    dy -= n.y * lift;
    dz -= n.z * lift;
    var squared = dots(dx, dy, dz, dx, dy, dz);
#ifdef FORMED
    // What lies along a surface counts along the normal too, beyond where it is covered alike; a lighter touch is smaller.
    let beyond = max(abs(lift) - dab.half, vec4<f32>(0.0)) * dab.stretch;
    squared = (squared + beyond * beyond) * (dab.scale * dab.scale);
#endif
    let r = min(sqrt(squared), vec4<f32>(1.0));
    let f = falloff_of(r, falloff);
    var g = select(dab.gain * f, vec4<f32>(0.0), squared > vec4<f32>(dab.edge));
    // Not `&&` here: a branch must not hang on a uniform's value alone (see the kernel's choices).
    let held = ((dab.form & 1u) != 0u) & all(o > vec2<f32>(-0.5)) & all(o <= vec2<f32>(0.5));
    let holds = vec4<bool>(held) & (ox > vec4<f32>(-0.5)) & (ox <= vec4<f32>(0.5));
    g = select(g, vec4<f32>(dab.gain), holds);
    let layer = i32(dab.form >> 3u);
    let beside = ((axis == 2u) & (yz.x != layer)) | ((axis == 3u) & (yz.y != layer));
    let off = vec4<bool>(beside) | (vec4<bool>(axis == 1u) & (x != vec4<i32>(layer)));
    return select(g, vec4<f32>(0.0), off);
}

// F at distances in radii, up to 1.
fn falloff_of(r: vec4<f32>, falloff: u32) -> vec4<f32> {
#ifdef CURVE
    var f = vec4<f32>(stroke.curve[0].w);
    for (var i = 0u; i < CURVE_PIECES; i += 1u) {
        let piece = stroke.curve[i];
        f += piece.z * clamp((r - piece.x) * piece.y, vec4<f32>(0.0), vec4<f32>(1.0));
    }
    return f;
#else
#ifdef GAUSSIAN
    return (exp(-4.5 * r * r) - GAUSSIAN_RIM) / (1.0 - GAUSSIAN_RIM);
#else
    let rest = 1.0 - r * r;
    return select(select(vec4<f32>(1.0), 1.0 - r, falloff == LINEAR), rest * rest, falloff == SMOOTH);
#endif
#endif
}

// Of four vectors with four others.
fn dots(ax: vec4<f32>, ay: vec4<f32>, az: vec4<f32>, bx: vec4<f32>, by: vec4<f32>, bz: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(
        dot(vec3<f32>(ax.x, ay.x, az.x), vec3<f32>(bx.x, by.x, bz.x)),
        dot(vec3<f32>(ax.y, ay.y, az.y), vec3<f32>(bx.y, by.y, bz.y)),
        dot(vec3<f32>(ax.z, ay.z, az.z), vec3<f32>(bx.z, by.z, bz.z)),
        dot(vec3<f32>(ax.w, ay.w, az.w), vec3<f32>(bx.w, by.w, bz.w)),
    );
}

// What is kept of a texel: its largest G, or the sum of G, or what is left of 1 after all factors 1 - G, as bits of an f32; those
// of 1 flipped where they are of a rest, so that a cleared buffer means untouched.
fn state_of(kept: vec4<u32>, does: Choices) -> vec4<f32> {
    return bitcast<vec4<f32>>(kept ^ vec4<u32>(flip(does)));
}

fn kept_of(state: vec4<f32>, does: Choices) -> vec4<u32> {
    return bitcast<vec4<u32>>(state) ^ vec4<u32>(flip(does));
}

fn flip(does: Choices) -> u32 {
    return select(0u, ONE, does.gather == PRODUCT);
}

fn gathered(state: vec4<f32>, g: vec4<f32>, does: Choices) -> vec4<f32> {
    // Subtracting g times the rest, not multiplying by 1 - g: the latter is rounded alike for every dab.
    let added = select(state + g, state - state * g, does.gather == PRODUCT);
    return select(added, max(state, g), does.gather == LARGEST);
}

fn cover_of(state: vec4<f32>, does: Choices) -> vec4<f32> {
    return select(state, 1.0 - state, does.gather == PRODUCT);
}
