// Pictures of bodies, in any mode: bodies in order of sight one after another, or (MERGE) any number of overlapping ones at once.

#import burin::body::{body_ray, interval, listed_at, body_at, ray_through}
#import burin::picture::{Picture, before_at}
#import burin::march::march
#ifdef MERGE
#import burin::merge::march_merged
#endif
#ifdef ISO
#import burin::iso as mode
#else
#ifdef MIP
#import burin::mip as mode
#else
#import burin::dvr as mode
#endif
#endif

// The picture at a pixel's centre.
fn picture_of(px: vec2<f32>) -> Picture {
    let before = before_at(px);
    if (!mode::begin(before)) {
        return before;
    }
    let listed = listed_at(px);
    let ray = ray_through(px);
#ifdef MERGE
    march_merged(listed, ray);
#else
    for (var i = 0u; i < listed.count; i += 1u) {
        let r = body_ray(body_at(listed.first + i), ray);
        let within = interval(r, ray);
        let span = mode::enter(r, ray, within);
        march(r, span.x, span.y);
        mode::leave(r, within);
        if (mode::over(listed.merge)) {
            break;
        }
    }
#endif
    return mode::end(before, ray);
}

@vertex
fn cover(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn march_pixel(@builtin(position) at: vec4<f32>) -> Picture {
    return picture_of(at.xy);
}
