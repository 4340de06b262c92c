// A voxel of density and the next one along z, in every texel of a box: see src/gpu/fields/pool/pairs.rs.

#import burin::structs::PairsBox

@group(0) @binding(0) var<uniform> box: PairsBox;
@group(0) @binding(1) var density: texture_3d<f32>;
@group(0) @binding(2) var<storage, read_write> pairs: array<u32>;

@compute @workgroup_size(8, 8, 4)
fn pair(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = box.lo + id;
    if (any(at >= box.end)) {
        return;
    }
    let here = textureLoad(density, at, 0).r;
    let next = textureLoad(density, vec3<u32>(at.xy, min(at.z + 1u, box.last)), 0).r;
    pairs[id.x + box.pitch * (id.y + (box.end.y - box.lo.y) * id.z)] = pack2x16unorm(vec2<f32>(here, next));
}
