// From the faces of closed meshes along a pixel's ray to the spans of the ray that lie in any of them.
//
// A place is inside a mesh where the mesh winds about it; windings of different meshes are counted apart, so that one does not undo
// another. All windings end at 0, which tells how they begin where the eye is inside.

#import burin::constants::{FAR, MOST_MESHES}
#import burin::body::{view, ray_through}
#import burin::mesh::{mesh_triangles, plane_of}

@group(2) @binding(3) var faces: texture_2d_array<u32>;
// By layer, nearest first: steps to the entry and to the exit, cosine between ray and normal at the exit; an entry of FAR after
// the last one.
@group(2) @binding(4) var spans: texture_storage_2d_array<rgba32float, write>;

const NOTHING: u32 = 0xffffffffu;

var<private> windings: array<i32, MOST_MESHES>;
// Meshes that the ray is inside of.
var<private> around: i32;

fn cross_face(mesh: u32, by: i32) {
    let before = windings[mesh];
    windings[mesh] = before + by;
    around += select(0, 1, before == 0) - select(0, 1, before + by == 0);
}

@compute @workgroup_size(8, 8)
fn join(@builtin(global_invocation_id) id: vec3<u32>) {
    if (any(id.xy >= textureDimensions(spans))) {
        return;
    }
    let at = vec2<i32>(id.xy);
    let ray = ray_through(vec2<f32>(id.xy) + 0.5);
    around = 0;
    let most = i32(textureNumLayers(faces));
    for (var i = 0; i < most; i += 1) {
        let face = textureLoad(faces, at, i, 0).rg;
        if (face.x == NOTHING) {
            break;
        }
        cross_face(mesh_triangles[face.y / 2u].w, select(1, -1, (face.y & 1u) == 1u));
    }
    var count = 0;
    var entry = 0.0;
    // The last span, which the next may touch.
    var last = vec4<f32>(-1.0);
    for (var i = 0; i < most; i += 1) {
        let face = textureLoad(faces, at, i, 0).rg;
        if (face.x == NOTHING) {
            break;
        }
        let triangle = mesh_triangles[face.y / 2u];
        let was_inside = around > 0;
        cross_face(triangle.w, select(-1, 1, (face.y & 1u) == 1u));
        let t = bitcast<f32>(face.x) / view.step_mm;
        if (!was_inside && around > 0) {
            entry = t;
        }
        if (was_inside && around == 0) {
            if (last.y >= 0.0 && entry > last.y) {
                textureStore(spans, at, count, last);
                count += 1;
                last.x = entry;
            } else if (last.y < 0.0) {
                last.x = entry;
            }
            last = vec4<f32>(last.x, t, abs(dot(plane_of(triangle).xyz, ray.dir)), 0.0);
        }
    }
    if (last.y >= 0.0) {
        textureStore(spans, at, count, last);
        count += 1;
    }
    textureStore(spans, at, count, vec4<f32>(FAR, FAR, 0.0, 0.0));
}
