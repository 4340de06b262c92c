// A slice: grey window, then painted colour, labels and selection over it. Linear in the plane, one voxel deep.

#import burin::field::{info, brick_of, density_page, density_texel, address, is_nan, colour_page, colour_at, selection_page,
    selection_at, label_at}
#import burin::structs::Slice

@group(0) @binding(0) var<uniform> slice: Slice;
@group(0) @binding(1) var segment_colours: texture_2d<f32>;

@vertex
fn cover(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

// Lays a colour over what is there, colours multiplied by opacity.
fn over(c: vec4<f32>, rgb: vec3<f32>, opacity: f32) -> vec4<f32> {
    return mix(c, vec4<f32>(rgb, 1.0), opacity);
}

fn shown(at: vec2<f32>) -> vec4<f32> {
    let p = slice.top_left + slice.per_x * at.x + slice.per_y * at.y;
    if (any(p < vec3<f32>(-0.5)) || any(p >= vec3<f32>(info.dims) - 0.5)) {
        return vec4<f32>(0.0);
    }
    let brick = brick_of(p);
#ifdef BARE
    var c = vec4<f32>(0.0);
#else
    let page = density_page(brick);
    let density = density_texel(page, address(page, p));
#ifdef FLOAT_DENSITY
    if (is_nan(density)) {
        return vec4<f32>(0.0);
    }
#endif
    var c = vec4<f32>(vec3<f32>(clamp((density - slice.black) / (slice.white - slice.black), 0.0, 1.0)), 1.0);
#endif
#ifdef COLOUR
    let paint = colour_at(colour_page(brick), p);
    c = over(c, paint.rgb, paint.a * slice.colour_opacity);
#endif
#ifdef LABELS
    let label = label_at(p);
    let segment = textureLoad(segment_colours, vec2<i32>(i32(label & 255u), i32(label >> 8u)), 0);
    c = over(c, segment.rgb, segment.a * slice.label_opacity);
#endif
#ifdef SELECTION
    let s = selection_at(selection_page(brick), p);
    c = over(c, slice.selection_colour, s * slice.selection_opacity);
#endif
    return c * slice.opacity;
}

@fragment
fn draw(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    return shown(at.xy);
}
