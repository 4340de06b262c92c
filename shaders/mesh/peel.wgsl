// Faces of closed meshes one behind another: each draw keeps, per pixel, the nearest face behind the one that the draw before it
// kept (depth peeling, Everitt 2001). Of faces in one place the one with the lower number comes first, so that none is lost.

#import burin::body::ray_through
#import burin::mesh::{Facet, places, facet, met}

#ifdef LATER
@group(2) @binding(3) var kept: texture_2d<u32>;
#endif

struct Face {
    @location(0) face: vec2<u32>,       // bits of the mm along the ray, which sort as the lengths do; triangle · 2 + seen from outside
    @builtin(frag_depth) order: f32,
}

@vertex
fn corner(@builtin(vertex_index) i: u32) -> Facet {
    return facet(i);
}

@fragment
fn peel(facet: Facet, @builtin(front_facing) outside: bool) -> Face {
    let t = met(facet.plane, facet.reach, ray_through(facet.at.xy));
    if (t < 0.0) {
        discard;
    }
    let found = vec2<u32>(bitcast<u32>(abs(t)), facet.triangle * 2u + select(0u, 1u, outside));
#ifdef LATER
    let last = textureLoad(kept, vec2<i32>(facet.at.xy), 0).rg;
    if (found.x < last.x || (found.x == last.x && found.y <= last.y)) {
        discard;
    }
#endif
    return Face(found, t * places[facet.mesh].order);
}
