// The same picture from one dense texture: the least that a ray caster of this lattice can cost on this machine.

struct View {
    eye: vec3<f32>,             // in voxels
    table_scale: f32,
    corner: vec3<f32>,          // ray through pixel (0, 0) before it is given length 1
    unused_a: f32,
    dx: vec3<f32>,
    unused_b: f32,
    dy: vec3<f32>,
    unused_c: f32,
    dims: vec3<f32>,
    unused_d: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var density: texture_3d<f32>;
@group(0) @binding(2) var skip: texture_3d<u32>;
@group(0) @binding(3) var table: texture_2d<f32>;
@group(0) @binding(4) var linear_sampler: sampler;

override LIT: bool = false;

@vertex
fn cover(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn texel_at(q: vec3<f32>) -> f32 {
    return textureSampleLevel(density, linear_sampler, q, 0.0).r;
}

fn table_at(texel: f32) -> vec4<f32> {
    return textureLoad(table, vec2<i32>(i32(texel * view.table_scale + 0.5), 0), 0);
}

fn lit(rgb: vec3<f32>, p: vec3<f32>, d: vec3<f32>) -> vec3<f32> {
    let h = 0.5 / view.dims;
    let q = (p + 0.5) / view.dims;
    let g = vec3<f32>(
        texel_at(q + vec3<f32>(h.x, 0.0, 0.0)) - texel_at(q - vec3<f32>(h.x, 0.0, 0.0)),
        texel_at(q + vec3<f32>(0.0, h.y, 0.0)) - texel_at(q - vec3<f32>(0.0, h.y, 0.0)),
        texel_at(q + vec3<f32>(0.0, 0.0, h.z)) - texel_at(q - vec3<f32>(0.0, 0.0, h.z)),
    );
    let size = length(g);
    let c = select(1.0, min(abs(dot(g, d)) / size, 1.0), size > 1e-6);
    return rgb * (0.2 + 0.8 * c) + 0.2 * pow(c, 20.0);
}

@fragment
fn march(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let d = normalize(view.corner + view.dx * at.x + view.dy * at.y);
    let a = (vec3<f32>(-0.5) - view.eye) / d;
    let b = (view.dims - 0.5 - view.eye) / d;
    let near = min(a, b);
    let far = max(a, b);
    var k = ceil(max(max(near.x, near.y), max(near.z, 0.0)));
    let k1 = ceil(min(far.x, min(far.y, far.z)));
    let go = (view.eye + 0.5) * 0.25;
    let gd = d * 0.25;
    let gi = 1.0 / gd;
    let xo = (view.eye + 0.5) / view.dims;
    let xd = d / view.dims;
    var rgb = vec3<f32>(0.0);
    var clear = 1.0;
    loop {
        loop {
            if (k >= k1) {
                break;
            }
            let cell = floor(go + gd * k);
            let distance = textureLoad(skip, vec3<i32>(cell), 0).r;
            if (distance == 0u) {
                break;
            }
            let leave = (cell + 0.5 - go) * gi + (f32(distance) - 0.5) * abs(gi);
            k = max(k + 1.0, ceil(min(leave.x, min(leave.y, leave.z))));
        }
        if (k >= k1 || clear < 1.0 / 256.0) {
            break;
        }
        let end = min(k1, k + 32.0);
        if (LIT) {
            loop {
                var c = vec4<f32>(0.0);
                loop {
                    if (k >= end) {
                        break;
                    }
                    c = table_at(texel_at(xo + xd * k));
                    k += 1.0;
                    if (c.a > 0.0) {
                        break;
                    }
                }
                if (c.a > 0.0) {
                    rgb += clear * c.a * lit(c.rgb, view.eye + d * (k - 1.0), d);
                    clear *= 1.0 - c.a;
                }
                if (k >= end || clear < 1.0 / 256.0) {
                    break;
                }
            }
        } else {
            loop {
                if (k >= end || clear < 1.0 / 256.0) {
                    break;
                }
                let c = table_at(texel_at(xo + xd * k));
                rgb += clear * c.a * c.rgb;
                clear *= 1.0 - c.a;
                k += 1.0;
            }
        }
    }
    return vec4<f32>(rgb, 1.0 - clear);
}
