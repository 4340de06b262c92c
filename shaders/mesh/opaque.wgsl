// Opaque meshes, drawn before the rays: colour, depth and object of the nearest one.

#import burin::body::ray_through
#import burin::mesh::{Facet, places, facet, met}
#import burin::light::shine

struct Surface {
    @location(0) colour: vec4<f32>,
    @location(1) depth: f32,            // mm along the ray
    @location(2) object: u32,
    @builtin(frag_depth) order: f32,
}

@vertex
fn corner(@builtin(vertex_index) i: u32) -> Facet {
    return facet(i);
}

@fragment
fn surface(facet: Facet) -> Surface {
    let ray = ray_through(facet.at.xy);
    let t = met(facet.plane, facet.reach, ray);
    if (t < 0.0) {
        discard;
    }
    let place = places[facet.mesh];
    let colour = shine(place.lighting, place.colour, dot(facet.plane.xyz, ray.dir));
    return Surface(vec4<f32>(colour, 1.0), t, place.code, t * place.order);
}
