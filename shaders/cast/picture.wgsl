// Pictures of bodies, in any mode: bodies in order of sight one after another, or (MERGE, MODES) any number of overlapping ones at
// once.
//
// Marks of decals (MARKS) are laid among the samples of bodies (BETWEEN_MARKS), by what merges them, or where a picture is one surface or
// one maximum over that (MARKED_AFTER).

#import burin::body::{Ray, BodyRay, body_ray, interval, listed_at, body_at, ray_through}
#import burin::layers
#ifdef MARKS
#import burin::constants::FAR
#endif
#ifdef MARKED_AFTER
#import burin::body::{view, bodies}
#endif
#ifdef BETWEEN_MARKS
#import burin::dvr::{done as clouded, lay, turn_to}
#endif
#import burin::picture::{Picture, before_at}
#import burin::march::march
#ifdef HOLES
#import burin::constants::THROUGH_HOLE
#import burin::holes::{meets, piece_from}
#endif
#ifdef MODES
#import burin::merge::march_merged
#else
#ifdef MERGE
#import burin::merge::march_merged
#endif
#endif
#ifdef MODES
#import burin::modes as mode
#else
#ifdef ISO
#import burin::iso as mode
#else
#ifdef MIP
#import burin::mip as mode
#else
#import burin::dvr as mode
#endif
#endif
#endif

#ifndef MODES
// An interval of a body's ray.
fn pass_through(whole: BodyRay, ray: Ray, within: vec2<f32>) {
#ifdef HOLES
    var at = within.x;
    loop {
        let r = piece_from(whole, ray, at, within.y);
        if (r.within.x >= r.within.y) {
            break;
        }
        let span = mode::enter(r);
        march(r, span.x, span.y);
        mode::leave(r);
        at = r.within.y;
    }
#else
    var r = whole;
    r.within = within;
    let span = mode::enter(r);
    march(r, span.x, span.y);
    mode::leave(r);
#endif
}
#endif

#ifndef MODES
#ifndef MERGE
// What meshes leave of an interval of a body's ray.
fn pass_pieces(r: BodyRay, ray: Ray, within: vec2<f32>, merge: bool) {
#ifdef CUTS
    var piece = layers::next_piece(r.body, within.x, within.y);
    while (piece.x < piece.y && !mode::over(merge)) {
        pass_through(r, ray, piece);
        piece = layers::next_piece(r.body, piece.y, within.y);
    }
#else
    pass_through(r, ray, within);
#endif
}
#endif
#endif

#ifndef MODES
#ifndef MERGE
#ifdef MARKS
#ifdef BETWEEN_MARKS
// Lays the next mark behind what the ray has gathered.
fn lay_mark() {
    turn_to(layers::mark_body());
    lay(layers::mark_colour(), layers::mark_at);
    layers::pass_mark();
}

// An interval of a body's ray, and the marks that come before its end.
fn pass_marked(r: BodyRay, ray: Ray, within: vec2<f32>, merge: bool) {
    // Whatever lies in order before a mark comes before it.
    var begin = within.x;
    loop {
        let end = max(begin, min(layers::mark_at, within.y));
        pass_pieces(r, ray, vec2<f32>(begin, end), merge);
        if (layers::mark_at >= within.y || mode::over(merge)) {
            break;
        }
        lay_mark();
        begin = end;
    }
}

// What lies behind all bodies.
fn lay_rest() {
    while (layers::mark_at < FAR && !clouded()) {
        lay_mark();
    }
}
#else
fn pass_marked(r: BodyRay, ray: Ray, within: vec2<f32>, merge: bool) {
    pass_pieces(r, ray, within, merge);
}

fn lay_rest() {}
#endif
#else
fn pass_marked(r: BodyRay, ray: Ray, within: vec2<f32>, merge: bool) {
    pass_pieces(r, ray, within, merge);
}

fn lay_rest() {}
#endif
#endif
#endif

#ifdef MARKS
#ifdef MARKED_AFTER
// Lays marks over a picture that was made as a whole: those before its surface; over a maximum all of them.
fn finished(picture: Picture) -> Picture {
    var out = picture;
#ifndef CONTINUES
    var over = vec4<f32>(0.0);
#ifdef MIP
    let surface = FAR;
#else
    let surface = select(FAR, picture.depth / view.step_mm, picture.object != 0u);
#endif
    loop {
        if (layers::mark_at >= surface) {
            break;
        }
        if (picture.object == 0u && over.a <= 0.5 && over.a + (1.0 - over.a) * layers::mark_colour().a > 0.5) {
            out.depth = layers::mark_at * view.step_mm;
            out.object = bodies[layers::mark_body()].code;
        }
        over += (1.0 - over.a) * layers::mark_colour();
        layers::pass_mark();
    }
    out.colour = over + (1.0 - over.a) * picture.colour;
#endif
    return out;
}
#else
fn finished(picture: Picture) -> Picture {
    return picture;
}
#endif
#else
fn finished(picture: Picture) -> Picture {
    return picture;
}
#endif

#ifdef HOLES
// The picture at a pixel's centre where its ray meets a hole, marked as such; other pixels are drawn without holes.
fn picture_of(px: vec2<f32>) -> Picture {
    if (!meets(ray_through(px))) {
        return before_at(px);
    }
    var picture = picture_through(px);
#ifndef CONTINUES
    picture.object |= THROUGH_HOLE;
#endif
    return picture;
}
#else
// The picture at a pixel's centre.
fn picture_of(px: vec2<f32>) -> Picture {
    return picture_through(px);
}
#endif

fn picture_through(px: vec2<f32>) -> Picture {
    layers::look_at(px);
    let before = before_at(px);
    if (!mode::begin(before)) {
        return finished(before);
    }
    let listed = listed_at(px);
    let ray = ray_through(px);
#ifdef MODES
    march_merged(listed, ray);
#else
#ifdef MERGE
    march_merged(listed, ray);
#else
    for (var i = 0u; i < listed.count; i += 1u) {
        let r = body_ray(body_at(listed.first + i), ray);
        let within = layers::in_front(interval(r, ray));
        pass_marked(r, ray, within, listed.merge);
        if (mode::over(listed.merge)) {
            break;
        }
    }
    lay_rest();
#endif
#endif
    return layers::backed(finished(mode::end(before, ray)));
}

#ifdef TILED
// By tiles: a workgroup draws one of a list, so that nothing has to be rasterised.

#import burin::constants::TILE

@group(2) @binding(0) var<storage, read> tiles: array<u32>;     // column | row << 16
@group(2) @binding(1) var colours: texture_storage_2d<rgba32float, write>;
@group(2) @binding(2) var depths: texture_storage_2d<r32float, write>;
@group(2) @binding(3) var objects: texture_storage_2d<r32uint, write>;

@compute @workgroup_size(64)
fn march_tile(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) i: u32,
) {
    let place = group.x + group.y * groups.x;
    if (place >= arrayLength(&tiles)) {
        return;
    }
    let tile = tiles[place];
    // Lanes that run together are a block of pixels: 8 are 4 × 2, 32 are 8 × 4.
    let inside = vec2<u32>((i & 3u) | ((i >> 3u & 1u) << 2u), (i >> 2u & 1u) | (i >> 4u << 1u));
    let px = vec2<u32>(tile & 0xffffu, tile >> 16u) * TILE + inside;
    if (any(px >= textureDimensions(colours))) {
        return;
    }
    let picture = picture_of(vec2<f32>(px) + 0.5);
    textureStore(colours, px, picture.colour);
    textureStore(depths, px, vec4<f32>(picture.depth, 0.0, 0.0, 0.0));
    textureStore(objects, px, vec4<u32>(picture.object, 0u, 0u, 0u));
}
#else
@vertex
fn cover(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn march_pixel(@builtin(position) at: vec4<f32>) -> Picture {
    return picture_of(at.xy);
}
#endif
