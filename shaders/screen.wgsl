// The window's picture: refined rows where they are done, the coarse preview elsewhere, over the background.

struct Show {
    background: vec3<f32>,
    rows_done: f32,             // rows of the full picture that are refined
    size: vec2<f32>,            // pixels of the full picture
    preview_size: vec2<f32>,
}

@group(0) @binding(0) var<uniform> show: Show;
@group(0) @binding(1) var full: texture_2d<f32>;
@group(0) @binding(2) var preview: texture_2d<f32>;

@vertex
fn cover(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

// Linear between the preview's pixels.
fn enlarged(px: vec2<f32>) -> vec4<f32> {
    let at = px / show.size * show.preview_size - 0.5;
    let lo = floor(at);
    let f = at - lo;
    let last = vec2<i32>(show.preview_size) - 1;
    let a = clamp(vec2<i32>(lo), vec2<i32>(0), last);
    let b = clamp(vec2<i32>(lo) + 1, vec2<i32>(0), last);
    let top = mix(textureLoad(preview, a, 0), textureLoad(preview, vec2<i32>(b.x, a.y), 0), f.x);
    let bottom = mix(textureLoad(preview, vec2<i32>(a.x, b.y), 0), textureLoad(preview, b, 0), f.x);
    return mix(top, bottom, f.y);
}

@fragment
fn blit(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    var c = vec4<f32>(0.0);
    if (at.y < show.rows_done) {
        c = textureLoad(full, vec2<i32>(at.xy), 0);
    } else {
        c = enlarged(at.xy);
    }
    var rgb = clamp(c.rgb + show.background * (1.0 - c.a), vec3<f32>(0.0), vec3<f32>(1.0));
#ifdef LINEAR_TARGET
    rgb = select(rgb / 12.92, pow((rgb + 0.055) / 1.055, vec3<f32>(2.4)), rgb > vec3<f32>(0.04045));
#endif
    return vec4<f32>(rgb, 1.0);
}
