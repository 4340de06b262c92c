#define_import_path burin::field
// Voxels. The only module that knows of slots and pages.
// p is a place in voxels of level 0, voxel centres at integers. Values come as texels: density 0..1 of a 16-bit code or the
// value itself (value = value_lo + texel·value_span), NaN where a tap is NaN.

#import burin::constants::{BRICK, SLOT, MOST_VOLUMES, PAGES_WIDTH, NO_PAGES}

struct FieldInfo {
    dims: vec3<u32>,            // voxels of level 0
    cell: u32,                  // voxels along an edge of a cell of the skip maps
    bricks: vec3<u32>,          // bricks of level 0
    value_lo: f32,
    density_texel: vec3<f32>,   // 1 / texels of the pool
    value_span: f32,
    colour_texel: vec3<f32>,
    floats: u32,                // whether density's texels are values and not codes
    selection_texel: vec3<f32>,
    pool: u32,                  // of density: 0 density_pool, 1 float_pool, 2 fine_codes, 3 fine_floats
    density_pages: u32,         // the numbers of the fields' first pages
    colour_pages: u32,
    selection_pages: u32,
    label_pages: u32,
    density_placed: u32,        // whether density lies in place
    labels_placed: u32,
    fine_labels: u32,           // whether labels lie in fine_labels
    unused: u32,
}

#ifdef MANY_VOLUMES
@group(1) @binding(0) var<uniform> infos: array<FieldInfo, MOST_VOLUMES>;
// The volume that is looked at: see enter_volume.
var<private> info: FieldInfo;
#else
@group(1) @binding(0) var<uniform> info: FieldInfo;
#endif
@group(1) @binding(1) var density_pool: texture_3d<f32>;
@group(1) @binding(2) var float_pool: texture_3d<f32>;
@group(1) @binding(3) var colour_pool: texture_3d<f32>;
@group(1) @binding(4) var selection_pool: texture_3d<f32>;
@group(1) @binding(5) var label_pool: texture_3d<u32>;
@group(1) @binding(6) var pages: texture_2d<u32>;
@group(1) @binding(7) var skip_maps: texture_3d<u32>;
@group(1) @binding(8) var pair_layers: texture_2d_array<f32>;
@group(1) @binding(9) var linear_sampler: sampler;
// Of boxes of a volume, so that the volume itself may lie in place.
@group(1) @binding(10) var fine_codes: texture_3d<f32>;
@group(1) @binding(11) var fine_floats: texture_3d<f32>;
@group(1) @binding(12) var fine_labels: texture_3d<u32>;

// All that follows is of this volume from here on, by its place in the list of those that the picture shows.
fn enter_volume(place: u32) {
#ifdef MANY_VOLUMES
    info = infos[place];
#endif
}

// Where a brick's texels are. A run inside one brick samples at q = p·scale + off: one fused multiply-add.
struct Page {
    scale: vec3<f32>,
    off: vec3<f32>,
    value: vec4<f32>,           // the texel of a brick of one value
    held: bool,                 // false: the brick has one value
    level: u32,
    slot: vec3<u32>,            // first texel of the slot, apron included
    first: vec3<f32>,           // centre of the slot's first texel, in texture coordinates
    last: vec3<f32>,            // centre of its last one
}

// The brick of level 0 that a sample belongs to: ⌊(p+½)/32⌋, inside the volume.
fn brick_of(p: vec3<f32>) -> vec3<i32> {
    return clamp(vec3<i32>(floor((p + 0.5) * (1.0 / f32(BRICK)))), vec3<i32>(0), vec3<i32>(info.bricks) - 1);
}

// The entry for a brick in the table that begins at page `first`; that of nothing where the field has none.
fn entry_of(first: u32, brick: vec3<i32>) -> vec2<u32> {
    let at = vec3<u32>(brick);
    let i = select(first + at.x + info.bricks.x * (at.y + info.bricks.y * at.z), 0u, first == NO_PAGES);
    return textureLoad(pages, vec2<i32>(vec2<u32>(i % PAGES_WIDTH, i / PAGES_WIDTH)), 0).rg;
}

fn page_of(entry: u32, brick: vec3<i32>, texel: vec3<f32>) -> Page {
    var page: Page;
    page.held = (entry & 1u) != 0u;
    page.level = (entry >> 1u) & 31u;
    page.slot = ((vec3<u32>(entry) >> vec3<u32>(8u, 16u, 24u)) & vec3<u32>(255u)) * SLOT;
    let size = 1.0 / f32(1u << page.level);
    let coarse = vec3<f32>(brick >> vec3<u32>(page.level));
    // Voxel i of the coarse brick has its centre at slot + 1 + i + ½; a place p is at (p+½)·size − ½ in coarse voxels.
    page.scale = size * texel;
    page.off = (vec3<f32>(page.slot) + (1.0 + 0.5 * size) - f32(BRICK) * coarse) * texel;
    page.first = (vec3<f32>(page.slot) + 0.5) * texel;
    // A hair short of the last centre, so that the tap beyond it is never touched.
    page.last = (vec3<f32>(page.slot) + (f32(SLOT) - 0.5 - 1.0 / 256.0)) * texel;
    return page;
}

// Address of a place, taps clamped to the slot.
fn address(page: Page, p: vec3<f32>) -> vec3<f32> {
    return clamp(p * page.scale + page.off, page.first, page.last);
}

// The level-l voxel of a page that a place lies in, as a texel of the pool.
fn nearest_texel(page: Page, brick: vec3<i32>, p: vec3<f32>) -> vec3<i32> {
    let inside = vec3<i32>(floor((p + 0.5) / f32(1u << page.level))) - i32(BRICK) * (brick >> vec3<u32>(page.level));
    return vec3<i32>(page.slot) + 1 + clamp(inside, vec3<i32>(0), vec3<i32>(i32(BRICK) - 1));
}

fn is_nan(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7fffffffu) > 0x7f800000u;
}

// ---- density

// Bricks lie where they are in the volume and share their aprons: one page for all of them.
fn placed_page() -> Page {
    var page: Page;
    page.held = true;
    page.scale = info.density_texel;
    page.off = 1.5 * info.density_texel;
    page.first = 0.5 * info.density_texel;
    page.last = 1.0 - (0.5 + 1.0 / 256.0) * info.density_texel;
#ifdef PAIRS
    // Along z in layers, of which the first has its centre at 0.
    page.first.z = 0.0;
    page.last.z = 1.0 / info.density_texel.z - (1.0 + 1.0 / 256.0);
    page.scale.z = 1.0;
    page.off.z = 1.0;
#endif
    return page;
}

#ifdef IN_PLACE
fn density_page(brick: vec3<i32>) -> Page {
    return placed_page();
}
#else
fn density_page(brick: vec3<i32>) -> Page {
#ifdef PLACED
    if (info.density_placed != 0u) {
        return placed_page();
    }
#endif
    let entry = entry_of(info.density_pages, brick);
    var page = page_of(entry.r, brick, info.density_texel);
    let code = f32(entry.g) * (1.0 / 65535.0);
#ifdef FLOAT_DENSITY
    page.value = vec4<f32>(select(code, bitcast<f32>(entry.g), info.floats != 0u));
#else
    page.value = vec4<f32>(code);
#endif
    return page;
}
#endif

#ifdef MANUAL_FILTER
// Between the eight texels about an address: these floats no sampler filters.
fn filtered(pool: texture_3d<f32>, q: vec3<f32>) -> f32 {
    let x = q / info.density_texel - 0.5;
    let lo = floor(x);
    let f = x - lo;
    let a = vec3<i32>(lo);
    let v000 = textureLoad(pool, a, 0).r;
    let v100 = textureLoad(pool, a + vec3<i32>(1, 0, 0), 0).r;
    let v010 = textureLoad(pool, a + vec3<i32>(0, 1, 0), 0).r;
    let v110 = textureLoad(pool, a + vec3<i32>(1, 1, 0), 0).r;
    let v001 = textureLoad(pool, a + vec3<i32>(0, 0, 1), 0).r;
    let v101 = textureLoad(pool, a + vec3<i32>(1, 0, 1), 0).r;
    let v011 = textureLoad(pool, a + vec3<i32>(0, 1, 1), 0).r;
    let v111 = textureLoad(pool, a + vec3<i32>(1, 1, 1), 0).r;
    let z0 = mix(mix(v000, v100, f.x), mix(v010, v110, f.x), f.y);
    let z1 = mix(mix(v001, v101, f.x), mix(v011, v111, f.x), f.y);
    return mix(z0, z1, f.z);
}
#endif

// The same of a pool of floats, where several volumes are drawn.
fn float_at(pool: texture_3d<f32>, q: vec3<f32>) -> f32 {
#ifdef MANUAL_FILTER
    return filtered(pool, q);
#else
    return textureSampleLevel(pool, linear_sampler, q, 0.0).r;
#endif
}

#ifdef PAIRS
// The pair that was read last, and its layer.
var<private> last_pair: vec2<f32>;
var<private> last_layer: f32;

fn pair_at(q: vec2<f32>, layer: f32) -> vec2<f32> {
    return textureSampleLevel(pair_layers, linear_sampler, q, i32(layer), 0.0).rg;
}

// Between two layers on end.
fn paired(q: vec3<f32>) -> f32 {
    last_layer = floor(q.z);
    last_pair = pair_at(q.xy, last_layer);
    return last_pair.r + (q.z - last_layer) * (last_pair.g - last_pair.r);
}

// The difference of density half a voxel either way along z, at the address of the texel that was read last: of the three layers that
// asks for, its pair has two.
fn rise(q: vec3<f32>) -> f32 {
    let f = q.z - last_layer;
    let below = f < 0.5;
    let other = pair_at(q.xy, last_layer + select(1.0, -1.0, below));
    let low = select(last_pair, other, below);
    let high = select(other, last_pair, below);
    return high.r - low.r + (f + select(-0.5, 0.5, below)) * (high.g - high.r - low.g + low.r);
}
#endif

fn pooled(q: vec3<f32>) -> f32 {
#ifdef PAIRS
    return paired(q);
#else
#ifdef MANY_VOLUMES
#ifdef FINE_CODES
    if (info.pool == 2u) {
        return textureSampleLevel(fine_codes, linear_sampler, q, 0.0).r;
    }
#endif
#ifdef FINE_FLOATS
    if (info.pool == 3u) {
        return float_at(fine_floats, q);
    }
#endif
#ifdef FLOAT_POOL
#ifdef CODE_POOL
    if (info.pool != 0u) {
        return float_at(float_pool, q);
    }
    return textureSampleLevel(density_pool, linear_sampler, q, 0.0).r;
#else
    return float_at(float_pool, q);
#endif
#else
    return textureSampleLevel(density_pool, linear_sampler, q, 0.0).r;
#endif
#else
#ifdef MANUAL_FILTER
    return filtered(density_pool, q);
#else
    return textureSampleLevel(density_pool, linear_sampler, q, 0.0).r;
#endif
#endif
#endif
}

// The texel at an address of the page, linear between voxels.
fn density_texel(page: Page, q: vec3<f32>) -> f32 {
    return select(page.value.x, pooled(q), page.held);
}

// Density in the volume's unit at a place of the page's brick.
fn density_at(page: Page, p: vec3<f32>) -> f32 {
    return info.value_lo + density_texel(page, address(page, p)) * info.value_span;
}

// ---- density by loads, where the 8 bits that samplers weigh with are too few

fn loaded(at: vec3<i32>) -> f32 {
#ifdef MANY_VOLUMES
#ifdef FINE_CODES
    if (info.pool == 2u) {
        return textureLoad(fine_codes, at, 0).r;
    }
#endif
#ifdef FINE_FLOATS
    if (info.pool == 3u) {
        return textureLoad(fine_floats, at, 0).r;
    }
#endif
#ifdef FLOAT_POOL
#ifdef CODE_POOL
    if (info.pool != 0u) {
        return textureLoad(float_pool, at, 0).r;
    }
    return textureLoad(density_pool, at, 0).r;
#else
    return textureLoad(float_pool, at, 0).r;
#endif
#else
    return textureLoad(density_pool, at, 0).r;
#endif
#else
    return textureLoad(density_pool, at, 0).r;
#endif
}

// The texel at a share `t` (0..1) of the way from a voxel of level 0 to the next one along each axis, voxels beside the volume being those
// at its faces. The brick must be held at level 0, or be of one value.
fn density_between(voxel: vec3<i32>, t: vec3<f32>) -> f32 {
    let end = vec3<i32>(info.dims) - 1;
    let lo = clamp(voxel, vec3<i32>(0), end);
    let hi = clamp(voxel + 1, vec3<i32>(0), end);
#ifdef IN_PLACE
    let off = vec3<i32>(1);
    let held = true;
    let value = 0.0;
#else
    let brick = lo / i32(BRICK);
    let page = density_page(brick);
    var off = vec3<i32>(page.slot) + 1 - i32(BRICK) * brick;
#ifdef PLACED
    off = select(off, vec3<i32>(1), info.density_placed != 0u);
#endif
    let held = page.held;
    let value = page.value.x;
#endif
    let a = lo + off;
    let b = hi + off;
    let y0 = mix(mix(loaded(a), loaded(vec3<i32>(b.x, a.yz)), t.x),
        mix(loaded(vec3<i32>(a.x, b.y, a.z)), loaded(vec3<i32>(b.xy, a.z)), t.x), t.y);
    let y1 = mix(mix(loaded(vec3<i32>(a.xy, b.z)), loaded(vec3<i32>(b.x, a.y, b.z)), t.x),
        mix(loaded(vec3<i32>(a.x, b.yz)), loaded(b), t.x), t.y);
    return select(value, mix(y0, y1, t.z), held);
}

// ---- selection, 0..1

fn selection_page(brick: vec3<i32>) -> Page {
    let entry = entry_of(info.selection_pages, brick);
    var page = page_of(entry.r, brick, info.selection_texel);
    page.value = vec4<f32>(f32(entry.g) * (1.0 / 255.0));
    return page;
}

fn selection_texel(page: Page, q: vec3<f32>) -> f32 {
    return select(page.value.x, textureSampleLevel(selection_pool, linear_sampler, q, 0.0).r, page.held);
}

fn selection_at(page: Page, p: vec3<f32>) -> f32 {
    return selection_texel(page, address(page, p));
}

// The selection at any place; 0 where the picture asks for none.
fn selected(p: vec3<f32>) -> f32 {
#ifdef SELECTION
    return selection_at(selection_page(brick_of(p)), p);
#else
    return 0.0;
#endif
}

// ---- painted colour, not premultiplied

fn colour_page(brick: vec3<i32>) -> Page {
    let entry = entry_of(info.colour_pages, brick);
    var page = page_of(entry.r, brick, info.colour_texel);
    page.value = unpack4x8unorm(entry.g);
    return page;
}

fn colour_texel(page: Page, q: vec3<f32>) -> vec4<f32> {
    return select(page.value, textureSampleLevel(colour_pool, linear_sampler, q, 0.0), page.held);
}

fn colour_at(page: Page, p: vec3<f32>) -> vec4<f32> {
    return colour_texel(page, address(page, p));
}

// ---- labels: the voxel's own

// The entry of a brick's labels.
fn label_entry(brick: vec3<i32>) -> vec2<u32> {
    return entry_of(info.label_pages, brick);
}

// Whether a brick of this entry has several labels.
fn has_labels(entry: vec2<u32>) -> bool {
    return (entry.r & 1u) != 0u;
}

fn label_at(p: vec3<f32>) -> u32 {
#ifdef LABELS_IN_PLACE
    // As density in place: voxel 0 is texel 1, and what lies beside the volume is a copy.
    return textureLoad(label_pool, vec3<i32>(p + 1.5), 0).r;
#else
    let brick = brick_of(p);
    return label_in(label_entry(brick), brick, p);
#endif
}

fn label_in(entry: vec2<u32>, brick: vec3<i32>, p: vec3<f32>) -> u32 {
    let page = page_of(entry.r, brick, vec3<f32>(1.0));
    if (!page.held) {
        return entry.g;
    }
#ifdef PLACED_LABELS
    if (info.labels_placed != 0u) {
        return textureLoad(label_pool, vec3<i32>(p + 1.5), 0).r;
    }
#endif
#ifdef FINE_LABELS
    if (info.fine_labels != 0u) {
        return textureLoad(fine_labels, nearest_texel(page, brick, p), 0).r;
    }
#endif
    return textureLoad(label_pool, nearest_texel(page, brick, p), 0).r;
}

// ---- empty space: 0 where a cell may show something, else the distance in cells to the next such cell (capped)

fn cell_of(p: vec3<f32>) -> vec3<i32> {
    return vec3<i32>(floor((p + 0.5) / f32(info.cell)));
}

// `place` is the first cell of a map in the texture of all maps. Cells beside the volume are those at its faces.
fn skip_at(place: vec3<u32>, cell: vec3<i32>) -> u32 {
    return skip_within(place, last_cell(), vec3<f32>(cell));
}

// The same for who knows the last cell already: whole numbers divide slowly.
fn skip_within(place: vec3<u32>, last: vec3<f32>, cell: vec3<f32>) -> u32 {
    return textureLoad(skip_maps, vec3<i32>(place) + vec3<i32>(clamp(cell, vec3<f32>(0.0), last)), 0).r;
}

// The last cell of a volume's maps.
fn last_cell() -> vec3<f32> {
    return vec3<f32>((info.dims - 1u) / info.cell);
}
