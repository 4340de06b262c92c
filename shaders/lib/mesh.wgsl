#define_import_path burin::mesh
// Triangles of meshes: where their corners lie in the picture, and where a pixel's ray meets them.
//
// Places are in world mm as seen from the eye. Which pixels a triangle covers is the rasteriser's; how far along the ray it lies
// is reckoned from its plane, on the same ray that the caster marches.

#import burin::constants::MOST_MESHES
#import burin::body::{Ray, view}
#import burin::structs::MeshPlace

@group(2) @binding(0) var<uniform> places: array<MeshPlace, MOST_MESHES>;
@group(2) @binding(1) var<storage, read> mesh_corners: array<f32>;          // x, y, z by corner
@group(2) @binding(2) var<storage, read> mesh_triangles: array<vec4<u32>>;  // three corners and the mesh

// What a pixel knows of the triangle that covers it.
struct Facet {
    @builtin(position) at: vec4<f32>,
    @location(0) @interpolate(flat) triangle: u32,
    @location(1) @interpolate(flat) mesh: u32,
    @location(2) @interpolate(flat) plane: vec4<f32>,   // normal·p = w
    @location(3) @interpolate(flat) reach: vec2<f32>,   // least and greatest depth along the direction of sight
}

fn corner_of(i: u32) -> vec3<f32> {
    return vec3<f32>(mesh_corners[3u * i], mesh_corners[3u * i + 1u], mesh_corners[3u * i + 2u]);
}

fn turned(mesh: u32, v: vec3<f32>) -> vec3<f32> {
    return mat3x3<f32>(places[mesh].column_x, places[mesh].column_y, places[mesh].column_z) * v;
}

fn seen(mesh: u32, corner: vec3<f32>) -> vec3<f32> {
    return places[mesh].origin + turned(mesh, corner);
}

// A triangle's plane.
fn plane_of(triangle: vec4<u32>) -> vec4<f32> {
    let a = corner_of(triangle.x);
    // Sides before they are seen from afar: their digits are better.
    let n = turned(triangle.w, cross(corner_of(triangle.y) - a, corner_of(triangle.z) - a));
    let length = length(n);
    let normal = select(n / length, vec3<f32>(0.0), length == 0.0);
    return vec4<f32>(normal, dot(normal, seen(triangle.w, a)));
}

// Corner `vertex` of all triangles' corners, in clip space: rays through its pixel are the caster's.
fn facet(vertex: u32) -> Facet {
    let triangle = mesh_triangles[vertex / 3u];
    var corners = array<vec3<f32>, 3>(
        seen(triangle.w, corner_of(triangle.x)),
        seen(triangle.w, corner_of(triangle.y)),
        seen(triangle.w, corner_of(triangle.z)),
    );
    let depths = vec3<f32>(dot(corners[0], view.forward), dot(corners[1], view.forward), dot(corners[2], view.forward));
    let p = corners[vertex % 3u];
    let w = select(1.0, dot(p, view.forward), view.perspective != 0u);
    let from_corner = p - w * view.corner;
    let px = vec2<f32>(dot(from_corner, view.dx) / dot(view.dx, view.dx), dot(from_corner, view.dy) / dot(view.dy, view.dy));
    let half = 0.5 * vec2<f32>(f32(view.width), f32(view.height));
    var facet: Facet;
    // Cut off nowhere but at the eye; order is the fragments'.
    facet.at = vec4<f32>(px.x / half.x - w, w - px.y / half.y, 0.5 * w, w);
    facet.triangle = vertex / 3u;
    facet.mesh = triangle.w;
    facet.plane = plane_of(triangle);
    facet.reach = vec2<f32>(min(depths.x, min(depths.y, depths.z)), max(depths.x, max(depths.y, depths.z)));
    return facet;
}

// Millimetres along a ray to a triangle that covers its pixel.
fn met(plane: vec4<f32>, reach: vec2<f32>, ray: Ray) -> f32 {
    let along = dot(ray.dir, view.forward);
    let ends = reach / along;
    let slope = dot(plane.xyz, ray.dir);
    let t = (plane.w - dot(plane.xyz, ray.start)) / slope;
    // Seen edge on, the plane says little: the corners do.
    return select(clamp(t, ends.x, ends.y), 0.5 * (ends.x + ends.y), slope == 0.0);
}
