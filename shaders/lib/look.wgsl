#define_import_path burin::look
// From texels to colour: the table, painted fields, light.

#import burin::field::{Page, brick_of, density_texel, address, is_nan, colour_page, colour_at, label_at}
#import burin::body::{BodyRay, view, bodies, matrix_of}

@group(0) @binding(5) var table: texture_2d<f32>;
@group(0) @binding(6) var segment_colours: texture_2d<f32>;

// Colour and opacity of a step for a density texel; nothing for NaN.
fn table_at(texel: f32) -> vec4<f32> {
    let entry = i32(clamp(texel * view.table_scale + view.table_bias, 0.0, 4095.0));
    let c = textureLoad(table, vec2<i32>(entry, 0), 0);
#ifdef FLOAT_DENSITY
    return select(c, vec4<f32>(0.0), is_nan(texel));
#else
    return c;
#endif
}

// Share of a body in matter whose degree of interest is s.
fn share(mask: u32, s: f32) -> f32 {
    return select(select(1.0 - s, s, mask == 1u), 1.0, mask == 0u);
}

// Opacity of a share of the extinction: 1 − (1 − α)^w.
fn opacity_of_share(alpha: f32, w: f32) -> f32 {
    let a = 1.0 - pow(max(1.0 - alpha, 0.0), w);
    return select(a, 0.0, w <= 0.0);
}

// Painted fields over the table's colour, at a place in voxels.
fn painted(rgb: vec3<f32>, p: vec3<f32>, s: f32) -> vec3<f32> {
    var c = rgb;
#ifdef COLOUR
    let paint = colour_at(colour_page(brick_of(p)), p);
    c = mix(c, paint.rgb, paint.a * view.colour_opacity);
#endif
#ifdef LABELS
    let label = label_at(p);
    let segment = textureLoad(segment_colours, vec2<i32>(i32(label & 255u), i32(label >> 8u)), 0);
    c = mix(c, segment.rgb, segment.a * view.label_opacity);
#endif
#ifdef SELECTION
    c = mix(c, view.selection_colour, s * view.selection_opacity);
#endif
    return c;
}

fn difference(a: f32, b: f32) -> f32 {
#ifdef FLOAT_DENSITY
    let d = a - b;
    return select(d, 0.0, is_nan(d));
#else
    return a - b;
#endif
}

// Central differences half a voxel either way, in texels per voxel along the axes of index space.
fn gradient(page: Page, p: vec3<f32>) -> vec3<f32> {
    let x = vec3<f32>(0.5, 0.0, 0.0);
    let y = vec3<f32>(0.0, 0.5, 0.0);
    let z = vec3<f32>(0.0, 0.0, 0.5);
    return vec3<f32>(
        difference(density_texel(page, address(page, p + x)), density_texel(page, address(page, p - x))),
        difference(density_texel(page, address(page, p + y)), density_texel(page, address(page, p - y))),
        difference(density_texel(page, address(page, p + z)), density_texel(page, address(page, p - z))),
    );
}

// Blinn-Phong with a headlight, lit on both sides; `cosine` between normal and ray, either sign.
fn lit(rgb: vec3<f32>, cosine: f32) -> vec3<f32> {
    let c = min(abs(cosine), 1.0);
    return rgb * (view.lighting.x + view.lighting.y * c) + view.lighting.z * pow(c, view.lighting.w);
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
    return dot(n, r.d) / (length(n * matrix_of(r.body)) * view.step_mm);
}
