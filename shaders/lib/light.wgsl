#define_import_path burin::light
// Light on matter: the gradient as its normal, a headlight, lit on both sides.

#import burin::field::{Page, density_texel, selection_at, address, is_nan}
#ifdef PAIRS
#import burin::field::rise
#endif
#import burin::body::{BodyRay, view}
#ifdef HOLES
#import burin::constants::NO_HOLE
#import burin::body::{holes, matters}
#import burin::holes::{texel_beside, ratio_of}
#import burin::field::{enter_volume, brick_of, density_page}
#endif
#import burin::look::look_light
#ifdef CONTOUR
#import burin::constants::TABLE_LAST
#import burin::body::table_place
#endif

fn difference(a: f32, b: f32) -> f32 {
#ifdef FLOAT_DENSITY
    let d = a - b;
    return select(d, 0.0, is_nan(d));
#else
    return a - b;
#endif
}

// Central differences half a voxel either way along x and y, in texels per voxel.
fn gradient_across(page: Page, p: vec3<f32>) -> vec2<f32> {
    let x = vec3<f32>(0.5, 0.0, 0.0);
    let y = vec3<f32>(0.0, 0.5, 0.0);
    return vec2<f32>(
        difference(density_texel(page, address(page, p + x)), density_texel(page, address(page, p - x))),
        difference(density_texel(page, address(page, p + y)), density_texel(page, address(page, p - y))),
    );
}

#ifdef HOLES
// The texel at a place in what fills a hole, or beside it where its host goes on.
fn texel_about(hole: u32, page: Page, p: vec3<f32>, last: vec3<f32>) -> f32 {
    if (all(p >= vec3<f32>(0.0)) && all(p <= last)) {
        return density_texel(page, address(page, p));
    }
    return texel_beside(hole, p);
}

fn rise_about(hole: u32, page: Page, p: vec3<f32>, half: vec3<f32>, last: vec3<f32>) -> f32 {
    return difference(texel_about(hole, page, p + half, last), texel_about(hole, page, p - half, last));
}

// In a box of another volume. In the band at its faces it goes over to its host's, which may be a box itself.
fn gradient_of_boxes(r: BodyRay, own: Page, own_place: vec3<f32>) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    var left = 1.0;
    // A gradient of the box that is looked at in texels and voxels of the body's.
    var unit = vec3<f32>(1.0);
    var hole = r.hole;
    var page = own;
    var p = own_place;
    loop {
        let scale = holes[hole].scale;
        let last = (holes[hole].hi - holes[hole].lo) * scale;
        // From 0 at a face to 1 half a voxel of the host away.
        let off = min(p, last - p) / scale;
        let share = left * clamp(2.0 * min(off.x, min(off.y, off.z)), 0.0, 1.0);
        if (share > 0.0) {
            sum += share * unit * vec3<f32>(
                rise_about(hole, page, p, vec3<f32>(0.5, 0.0, 0.0), last),
                rise_about(hole, page, p, vec3<f32>(0.0, 0.5, 0.0), last),
                rise_about(hole, page, p, vec3<f32>(0.0, 0.0, 0.5), last),
            );
        }
        left -= share;
        if (left <= 0.0) {
            break;
        }
        let host = holes[hole].host_hole;
        unit *= ratio_of(hole) / (ratio_of(host) * scale);
        p = holes[hole].lo + p / scale;
        enter_volume(holes[hole].host);
        page = density_page(brick_of(p));
        if (host == NO_HOLE) {
            sum += left * unit * plain_gradient(page, p);
            break;
        }
        hole = host;
    }
    enter_volume(matters[r.body].volume);
    return sum;
}

// Along the axes of index space.
fn gradient(r: BodyRay, page: Page, p: vec3<f32>) -> vec3<f32> {
    if (r.hole != NO_HOLE) {
        return gradient_of_boxes(r, page, p);
    }
    return plain_gradient(page, p);
}
#else
// Along the axes of index space.
fn gradient(r: BodyRay, page: Page, p: vec3<f32>) -> vec3<f32> {
    return plain_gradient(page, p);
}
#endif

// The same within one volume.
fn plain_gradient(page: Page, p: vec3<f32>) -> vec3<f32> {
    let z = vec3<f32>(0.0, 0.0, 0.5);
    let along_z = difference(density_texel(page, address(page, p + z)), density_texel(page, address(page, p - z)));
    return vec3<f32>(gradient_across(page, p), along_z);
}

// The same at the place of the texel that was read last.
fn gradient_here(r: BodyRay, page: Page, p: vec3<f32>) -> vec3<f32> {
#ifdef PAIRS
    let along_z = rise(address(page, p));
    return vec3<f32>(gradient_across(page, p), along_z);
#else
    return gradient(r, page, p);
#endif
}

// The same of the selection.
fn selection_gradient(page: Page, p: vec3<f32>) -> vec3<f32> {
    let x = vec3<f32>(0.5, 0.0, 0.0);
    let y = vec3<f32>(0.0, 0.5, 0.0);
    let z = vec3<f32>(0.0, 0.0, 0.5);
    return vec3<f32>(
        selection_at(page, p + x) - selection_at(page, p - x),
        selection_at(page, p + y) - selection_at(page, p - y),
        selection_at(page, p + z) - selection_at(page, p - z),
    );
}

// Blinn-Phong with a headlight, lit on both sides; `cosine` between normal and ray, either sign.
fn lit(rgb: vec3<f32>, cosine: f32) -> vec3<f32> {
    return shine(look_light(), rgb, cosine);
}

// The same by a light's ambient, diffuse, specular share and power.
fn shine(light: vec4<f32>, rgb: vec3<f32>, cosine: f32) -> vec3<f32> {
    let c = min(abs(cosine), 1.0);
    return rgb * (light.x + light.y * c) + light.z * pow(c, light.w);
}

// Places of a stretch that light is the mean of.
const LIGHTS: u32 = 6u;

// A gradient in index space as one of the world, and its part along the ray; nothing where `facing` finds none.
fn slope_of(r: BodyRay, g: vec3<f32>, texel: f32) -> vec4<f32> {
    let largest = max(abs(g.x), max(abs(g.y), abs(g.z)));
    let slope = vec4<f32>(g * r.world, dot(g, r.d) / view.step_mm);
    return select(slope, vec4<f32>(0.0), largest <= 2.4e-7 * abs(texel));
}

// `lit` on the mean from one share of a way to another, on which the slope goes evenly from `a` to `b`.
fn lit_evenly(rgb: vec3<f32>, a: vec4<f32>, b: vec4<f32>, first: f32, last: f32) -> vec3<f32> {
    let light = look_light();
    var plain = 0.0;
    var white = 0.0;
    for (var i = 0u; i < LIGHTS; i += 1u) {
        let slope = mix(a, b, mix(first, last, (f32(i) + 0.5) / f32(LIGHTS)));
        let square = dot(slope.xyz, slope.xyz);
        let c = select(min(abs(slope.w) * inverseSqrt(square), 1.0), 1.0, square == 0.0);
        plain += c;
        white += pow(c, light.w);
    }
    let many = f32(LIGHTS);
    return rgb * (light.x + light.y * plain / many) + light.z * white / many;
}

// Cosine between the ray and the normal of a gradient in index space. A gradient of no more than the noise of arithmetic on
// values of this size counts as facing the light.
fn facing(r: BodyRay, g: vec3<f32>, texel: f32) -> f32 {
    let largest = max(abs(g.x), max(abs(g.y), abs(g.z)));
    if (largest <= 2.4e-7 * abs(texel)) {
        return 1.0;
    }
    let n = g / largest;
    // World normal = transpose(index_from_world) · gradient; r.d is index_from_world · ray · step.
    return dot(n, r.d) / (length(n * r.world) * view.step_mm);
}

#ifdef CONTOUR
// What is drawn of matter where only its contours are: places that turn away from the eye, (1 − |n·v|)ⁿ, and of them those where
// density changes, by a window of the gradient's magnitude (after Csébfalvi, Mroz, Hauser, König and Gröller 2001).
const TURNS: f32 = 3.0;
// So much of the table in a voxel is a border and no noise.
const SHARP: f32 = 1.0 / 16.0;

// The share of the place that was met last.
var<private> line: f32;

fn set_line(share: f32) {
    line = share;
}

fn line_here() -> f32 {
    return line;
}

// Where a surface is that has this cosine between normal and ray.
fn line_of_surface(cosine: f32) {
    line = pow(1.0 - min(abs(cosine), 1.0), TURNS);
}

// The same inside matter with this gradient, in texels per voxel.
fn line_of_matter(r: BodyRay, g: vec3<f32>, texel: f32) {
    let change = abs(table_place(length(g)) - table_place(0.0)) / TABLE_LAST;
    let window = min(change / SHARP, 1.0);
    line_of_surface(facing(r, g, texel));
    line *= window * window;
}
#endif
