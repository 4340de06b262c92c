#define_import_path burin::picture
// A pixel of the picture: what a pass writes, and what the passes before it wrote.

#import burin::constants::FAR
#ifdef HOLES
#import burin::constants::THROUGH_HOLE
#endif
#import burin::body::bodies
#import burin::field::{brick_of, selection_page, selection_at, label_at}

struct Picture {
    @location(0) colour: vec4<f32>,     // multiplied by opacity, and opacity
    @location(1) depth: f32,            // mm along the ray; FAR for nothing
    @location(2) object: u32,           // 0 for nothing
}

#ifdef RESUME
@group(0) @binding(7) var before_colour: texture_2d<f32>;
@group(0) @binding(8) var before_depth: texture_2d<f32>;
@group(0) @binding(9) var before_object: texture_2d<u32>;
#endif

// What earlier passes left of a pixel; nothing for the first one.
fn before_at(px: vec2<f32>) -> Picture {
#ifdef RESUME
    let texel = vec2<i32>(px);
    var object = textureLoad(before_object, texel, 0).r;
#ifdef HOLES
#ifndef CONTINUES
    // The mark says where the ray goes, not that anything was met.
    object &= ~THROUGH_HOLE;
#endif
#endif
    return Picture(textureLoad(before_colour, texel, 0), textureLoad(before_depth, texel, 0).r, object);
#else
    return Picture(vec4<f32>(0.0), FAR, 0u);
#endif
}

// What a pixel says of the body that it shows at a place: its code, 1 more where the volume is selected there, whatever masks and
// tints ask of the selection, and the label above the 12 bits of that.
fn object_at(body: u32, p: vec3<f32>) -> u32 {
    var object = bodies[body].code;
#ifdef TELLS_SELECTION
    object += select(0u, 1u, selection_at(selection_page(brick_of(p)), p) >= 0.5);
#endif
#ifdef TELLS_LABELS
    object |= label_at(p) << 12u;
#endif
    return object;
}
