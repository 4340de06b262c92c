// Decals: pictures on surfaces, as marks that every pixel's ray meets at depths of their own.
//
// A pixel's marks are a list, laid in no order and sorted by shaders/mesh/sort_marks.wgsl, so that however many lie one behind another
// one pass draws them all. A decal stands as a body stands and ends where that body's region ends.

#import burin::constants::MOST_DISTANCE
#import burin::body::{bodies, planes, ray_through, view}
#import burin::light::shine
#import burin::structs::{DecalCorner, DecalPlace, Mark}

@group(2) @binding(0) var<storage, read> decal_places: array<DecalPlace>;
@group(2) @binding(1) var<storage, read> decal_corners: array<DecalCorner>;
// Levels of detail one after another; red lowest.
@group(2) @binding(2) var<storage, read> decal_texels: array<u32>;
// How many marks there are; then by pixel the number of its first one and 1, 0 for none.
@group(2) @binding(3) var<storage, read_write> heads: array<atomic<u32>>;
@group(2) @binding(4) var<storage, read_write> marks: array<Mark>;

struct Piece {
    @builtin(position) at: vec4<f32>,
    @location(0) place: vec3<f32>,      // world mm as seen from the eye
    @location(1) normal: vec3<f32>,
    @location(2) uv: vec2<f32>,
    @location(3) @interpolate(flat) decal: u32,
}

@vertex
fn corner(@builtin(vertex_index) i: u32, @builtin(instance_index) decal: u32) -> Piece {
    let turn = mat3x3<f32>(decal_places[decal].column_x, decal_places[decal].column_y, decal_places[decal].column_z);
    let p = decal_places[decal].origin + turn * decal_corners[i].place;
    let w = select(1.0, dot(p, view.forward), view.perspective != 0u);
    let from_corner = p - w * view.corner;
    let px = vec2<f32>(dot(from_corner, view.dx) / dot(view.dx, view.dx), dot(from_corner, view.dy) / dot(view.dy, view.dy));
    let half = 0.5 * vec2<f32>(f32(view.width), f32(view.height));
    var piece: Piece;
    piece.at = vec4<f32>(px.x / half.x - w, w - px.y / half.y, 0.5 * w, w);
    piece.place = p;
    piece.normal = turn * decal_corners[i].normal;
    piece.uv = vec2<f32>(decal_corners[i].u, decal_corners[i].v);
    piece.decal = decal;
    return piece;
}

// A texel: of shapes how far inside they and their halo are, in the level's unit, else colour.
fn texel_at(decal: u32, first: u32, size: vec2<i32>, at: vec2<i32>) -> vec4<f32> {
    let kept = clamp(at, vec2<i32>(0), size - 1);
    // Without whole divisions, which software Vulkan makes lane by lane.
    let wide = vec2<f32>(size);
    let wrapped = vec2<i32>(vec2<f32>(at) - wide * floor(vec2<f32>(at) / wide));
    let p = select(kept, wrapped, decal_places[decal].repeats == 1u);
    let texel = decal_texels[first + u32(p.y * size.x + p.x)];
    return select(unpack4x8unorm(texel), vec4<f32>(unpack2x16snorm(texel), 0.0, 0.0), decal_places[decal].is_shape == 1u);
}

// A level of a picture between its texels.
fn level_at(decal: u32, level: u32, place: vec2<f32>) -> vec4<f32> {
    var first = decal_places[decal].first_texel;
    var size = vec2<i32>(decal_places[decal].size);
    for (var i = 0u; i < min(level, 16u); i += 1u) {
        first += u32(size.x * size.y);
        size = max(size / 2, vec2<i32>(1));
    }
    let p = place * vec2<f32>(size) - 0.5;
    let at = vec2<i32>(floor(p));
    let part = fract(p);
    let above = mix(texel_at(decal, first, size, at), texel_at(decal, first, size, at + vec2<i32>(1, 0)), part.x);
    let below = mix(texel_at(decal, first, size, at + vec2<i32>(0, 1)), texel_at(decal, first, size, at + vec2<i32>(1, 1)), part.x);
    let unit = select(1.0, MOST_DISTANCE * exp2(f32(level)), decal_places[decal].is_shape == 1u);
    return mix(above, below, part.y) * unit;
}

// A picture where a pixel covers so many of its finest level's texels along an edge.
fn picture_at(decal: u32, place: vec2<f32>, texels: f32) -> vec4<f32> {
    let last = f32(decal_places[decal].level_count) - 1.0;
    let detail = clamp(log2(max(texels, 1e-6)), 0.0, last);
    let finer = u32(floor(detail));
    let a = level_at(decal, finer, place);
    let b = level_at(decal, min(finer + 1u, u32(last)), place);
    return mix(a, b, fract(detail));
}

// Colour times opacity, and opacity, of a shape and its halo.
fn shape(decal: u32, inside: vec2<f32>, texels: f32) -> vec4<f32> {
    let reached = clamp(0.5 + inside / max(texels, 1e-6), vec2<f32>(0.0), vec2<f32>(1.0));
    let covered = select(reached.x, max(reached.x, reached.y), decal_places[decal].has_halo == 1u);
    // What is filled lies over the halo.
    return vec4<f32>(decal_places[decal].halo * (covered - reached.x) + decal_places[decal].fill * reached.x, covered);
}

@fragment
fn lay(piece: Piece) -> @location(0) vec4<f32> {
    let decal = piece.decal;
    let turn = decal_places[decal].turn;
    let place = mat2x2<f32>(turn.xy, turn.zw) * piece.uv + decal_places[decal].shift;
    let ray = ray_through(piece.at.xy);
    let t = dot(piece.place - ray.start, ray.dir);
    let cosine = dot(normalize(piece.normal), ray.dir);
    // What a pixel covers, between its two axes: seen aslant a text stays sharper than by the longer one, and shimmers less than by the
    // shorter. Reckoned and not taken from neighbouring pixels: in triangles of a pixel or two software Vulkan finds none there.
    let pixel_mm = length(view.dx) * select(1.0, dot(piece.place, view.forward), view.perspective != 0u);
    let texels = decal_places[decal].texels_per_mm * pixel_mm * inverseSqrt(max(abs(cosine), 0.05));
    let found = picture_at(decal, place, texels);
    let drawn = shape(decal, found.xy, texels);
    var colour = select(found, drawn, decal_places[decal].is_shape == 1u) * decal_places[decal].opacity;

    var inside = t > 0.0 && all(piece.uv >= vec2<f32>(0.0)) && all(piece.uv <= vec2<f32>(1.0));
    let body = decal_places[decal].body;
    for (var i = 0u; i < bodies[body].plane_count; i += 1u) {
        let plane = planes[bodies[body].first_plane + i];
        inside = inside && dot(plane.xyz, piece.place) + plane.w <= 0.0;
    }
    if (!inside || colour.a < 0.5 / 255.0) {
        discard;
    }
    colour = vec4<f32>(shine(decal_places[decal].lighting, colour.rgb / colour.a, cosine) * colour.a, colour.a);

    let number = atomicAdd(&heads[0], 1u);
    if (number < arrayLength(&marks)) {
        let pixel = 1u + u32(piece.at.y) * view.width + u32(piece.at.x);
        marks[number].at = max(t - decal_places[decal].toward_mm, 0.0) / view.step_mm;
        marks[number].colour = pack4x8unorm(colour);
        marks[number].body = body | decal_places[decal].is_cut << 31u;
        marks[number].next = atomicExchange(&heads[pixel], number + 1u);
    }
    return vec4<f32>(0.0);
}
