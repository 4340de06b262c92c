#define_import_path burin::look
// From texels to colour: the table, shares of matter, painted fields.

#import burin::constants::{TABLE_LAST, TABLE_MIDDLE, MASK_SELECTION, LOOK_LIGHT, LOOK_OPACITY, NO_ROWS}
#import burin::field::{brick_of, is_nan, colour_page, colour_at, label_at}
#import burin::body::{view, table_place, table_x, table_row, iso_texel, least_iso_texel, overlay_strengths, selection_colour, first_segments}
#ifdef OWN_LOOKS
#import burin::body::meaning
#else
#import burin::body::light_of
#endif

@group(0) @binding(5) var table: texture_2d<f32>;
@group(0) @binding(6) var segment_colours: texture_2d<f32>;
@group(0) @binding(11) var label_looks: texture_2d<f32>;

// An entry of the row that is the look's, or of one behind it; nothing where the matter is none of the body's.
fn row_at(entry: i32, behind: i32) -> vec4<f32> {
    let row = table_row();
#ifdef HIDES_LABELS
    return select(textureLoad(table, vec2<i32>(entry, max(row, 0) + behind), 0), vec4<f32>(0.0), row < 0);
#else
    return textureLoad(table, vec2<i32>(entry, row + behind), 0);
#endif
}

// Colour and opacity of a step for a density texel; nothing for NaN.
fn table_at(texel: f32) -> vec4<f32> {
    let c = row_at(i32(clamp(table_place(texel), 0.0, TABLE_LAST)), 0);
#ifdef FLOAT_DENSITY
    return select(c, vec4<f32>(0.0), is_nan(texel));
#else
    return c;
#endif
}

#ifdef REFINE
// Densities nearer to each other than so many entries are told apart by the mean of their extinctions.
const NARROW: f32 = 8.0;
// Densities beyond the table's ends go on as far as this, in entries.
const BEYOND: f32 = 1.0e6;

// The table below a density: the density in entries, ∫τ and ∫τ·(x − MIDDLE) up to it, and τ there, τ the extinction of a step;
// τ under 0 for NaN.
fn integrals_at(texel: f32) -> vec4<f32> {
    let x = clamp(table_x(texel), -BEYOND, BEYOND);
    let entry = clamp(floor(x + 0.5), 0.0, TABLE_LAST);
    let t = row_at(i32(entry), 1);
    let off = x - entry;
    let all = vec4<f32>(x, t.x + t.z * off, t.y + t.z * off * (entry - TABLE_MIDDLE + 0.5 * off), t.z);
#ifdef FLOAT_DENSITY
    return select(all, vec4<f32>(0.0, 0.0, 0.0, -1.0), is_nan(texel));
#else
    return all;
#endif
}

// Whether matter shows where density goes from one place of the table to another.
fn shows_between(a: vec4<f32>, b: vec4<f32>) -> bool {
    let shows = a.y != b.y || a.w + b.w > 0.0;
#ifdef FLOAT_DENSITY
    return shows && a.w >= 0.0 && b.w >= 0.0;
#else
    return shows;
#endif
}

// Matter in which density goes evenly from one place of the table to another: its centre, in entries and as a share of the way,
// and the extinction that a step of it has.
struct Matter {
    entry: f32,
    share: f32,
    extinction: f32,
}

fn matter_between(a: vec4<f32>, b: vec4<f32>) -> Matter {
    let width = b.x - a.x;
    let sum = b.y - a.y;
    let wide = abs(width) >= NARROW;
    let centre = (TABLE_MIDDLE + (b.z - a.z) / sum - a.x) / width;
    let share_of_way = select(0.5, clamp(centre, 0.0, 1.0), wide && sum != 0.0);
    let extinction = select(0.5 * (a.w + b.w), sum / width, wide);
    return Matter(a.x + share_of_way * width, share_of_way, max(extinction, 0.0));
}

// Colour at a place of the table.
fn colour_of_entry(entry: f32) -> vec3<f32> {
    return row_at(i32(clamp(entry + 0.5, 0.0, TABLE_LAST)), 0).rgb;
}
#endif

// Ambient, diffuse, specular and power of the look; 1, 0, 0, 1 where it is not lit.
fn look_light() -> vec4<f32> {
#ifdef OWN_LOOKS
    return textureLoad(table, vec2<i32>(i32(LOOK_LIGHT), max(table_row(), 0)), 0);
#else
    return light_of;
#endif
}

// Opacity of its iso-surface.
fn surface_opacity() -> f32 {
#ifdef OWN_LOOKS
    return textureLoad(table, vec2<i32>(i32(LOOK_OPACITY), max(table_row(), 0)), 0).r;
#else
    return 1.0;
#endif
}

// Whether the matter that was looked at last is the body's at all.
fn is_shown() -> bool {
    return table_row() >= 0;
}

// Takes the look of a label, where the body's looks go by label.
fn take_label(label: u32) {
#ifdef OWN_LOOKS
    let i = min(label, meaning.last_label);
#ifdef ROW_A_LABEL
#ifdef REFINE
    meaning.row = i32(meaning.label_rows + 2u * i);
#else
    meaning.row = i32(meaning.label_rows + i);
#endif
#else
    let look = textureLoad(label_looks, vec2<i32>(i32(i & 255u), i32(meaning.label_rows + (i >> 8u))), 0);
    meaning.table_scale = look.x;
    meaning.table_bias = look.y;
    meaning.iso = look.z;
    meaning.row = i32(look.w);
#endif
#endif
}

// Whether the body's looks go by label.
fn goes_by_label() -> bool {
#ifdef OWN_LOOKS
    return meaning.label_rows != NO_ROWS;
#else
    return false;
#endif
}

// Takes the look of the matter at a place, where the body's looks go by label. LABELS_IN_PLACE: it is cheap enough for every sample;
// else runs of samples of one brick are told theirs (LABEL_RUNS).
fn look_at(p: vec3<f32>) {
#ifdef LABEL_LOOKS
    if (goes_by_label()) {
        take_label(label_at(p));
    }
#endif
}

// Whether a texel lies at or beyond the surface.
fn reaches(texel: f32) -> bool {
#ifdef FLOAT_DENSITY
    return !is_nan(texel) && texel >= iso_texel() && is_shown();
#else
    return texel >= iso_texel() && is_shown();
#endif
}

// Whether it may lie at or beyond the surface of any matter of the body.
fn may_reach(texel: f32) -> bool {
    // No number is at or beyond anything.
    return texel >= least_iso_texel();
}

// The colour of the surface's value.
fn surface_colour() -> vec3<f32> {
    return table_at(iso_texel()).rgb;
}

// Share of a body in matter whose degree of interest is s.
fn share(mask: u32, s: f32) -> f32 {
    return select(select(1.0 - s, s, mask == MASK_SELECTION), 1.0, mask == 0u);
}

// Opacity of a share of the extinction: 1 − (1 − α)^w.
fn opacity_of_share(alpha: f32, w: f32) -> f32 {
    let a = 1.0 - pow(max(1.0 - alpha, 0.0), w);
    return select(a, 0.0, w <= 0.0);
}

// Painted fields over the table's colour, at a place in voxels.
fn painted(rgb: vec3<f32>, p: vec3<f32>, s: f32) -> vec3<f32> {
    var c = rgb;
#ifdef COLOUR
    let paint = colour_at(colour_page(brick_of(p)), p);
    c = mix(c, paint.rgb, paint.a * overlay_strengths().x);
#endif
#ifdef LABELS
    let label = label_at(p);
    let segment = textureLoad(segment_colours, vec2<i32>(i32(label & 255u), i32(first_segments() + (label >> 8u))), 0);
    c = mix(c, segment.rgb, segment.a * overlay_strengths().y);
#endif
#ifdef SELECTION
    c = mix(c, selection_colour(), s * overlay_strengths().z);
#endif
    return c;
}
