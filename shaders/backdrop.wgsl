// What lies under a window's controls: plain rectangles and pictures, with no more work a pixel than that takes.

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var between: sampler;

struct Corner {
    @builtin(position) at: vec4<f32>,
    @location(0) uv: vec2<f32>,
    @location(1) @interpolate(flat) colour: vec4<f32>,  // display-referred, multiplied by alpha
}

// Rectangles are left, top, right, bottom in clip space.
@vertex
fn corner(@builtin(vertex_index) i: u32, @location(0) place: vec4<f32>, @location(1) colour: vec4<f32>) -> Corner {
    let uv = vec2<f32>(f32(i & 1u), f32(i >> 1u));
    return Corner(vec4<f32>(mix(place.xy, place.zw, uv), 0.0, 1.0), uv, colour);
}

fn shown(c: vec4<f32>) -> vec4<f32> {
#ifdef LINEAR_TARGET
    return vec4<f32>(select(c.rgb / 12.92, pow((c.rgb + 0.055) / 1.055, vec3<f32>(2.4)), c.rgb > vec3<f32>(0.04045)), c.a);
#else
    return c;
#endif
}

@fragment
fn fill(corner: Corner) -> @location(0) vec4<f32> {
    return shown(corner.colour);
}

@fragment
fn show(corner: Corner) -> @location(0) vec4<f32> {
    return shown(vec4<f32>(textureSample(picture, between, corner.uv).rgb, 1.0));
}
