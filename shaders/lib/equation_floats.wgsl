#define_import_path burin::equation_floats
// Equation 1 of numbers in floats: what is not a number, and how weak strokes arrive where there are no steps.

#import burin::equation::{TOP, number}
#import burin::stroke::{ADD, RESTORE, SUBTRACT, Choices, stroke}

fn float(old: vec4<u32>, back: vec4<u32>, cover: vec4<f32>, does: Choices) -> vec4<u32> {
    let mixed = number(bitcast<vec4<f32>>(old), bitcast<vec4<f32>>(back), cover, does);
    return vec4<u32>(
        arrived(old.x, back.x, cover.x, mixed.x, does),
        arrived(old.y, back.y, cover.y, mixed.y, does),
        arrived(old.z, back.z, cover.z, mixed.z, does),
        arrived(old.w, back.w, cover.w, mixed.w, does),
    );
}

// What a float becomes that equation 1 makes `mixed` of.
fn arrived(old: u32, back: u32, cover: f32, mixed: f32, does: Choices) -> u32 {
    let restores = does.operation == RESTORE;
    // What is not a number has nothing to mix with: it stays until it is covered wholly.
    let whole = cover >= 1.0;
    if !finite(old) || !finite(back) {
        let mixes = does.operation != ADD && does.operation != SUBTRACT;
        if !whole || !mixes {
            return old;
        }
        return select(bitcast<u32>(stroke.paint.x), back, restores);
    }
    if whole && restores {
        return back;
    }
    let p = bitcast<f32>(old);
    var value = mixed;
    let end = select(stroke.paint.x, bitcast<f32>(back), restores);
    if does.to_end && p != end {
        // Near the end as 16-bit codes would: no less than a step at a time, and the end from within one. Near is where a tenth of
        // the way is under half a step: a weaker brush goes by equation 1 until there.
        let outlying = (stroke.least < stroke.greatest) & ((end < stroke.least) | (end > stroke.greatest));
        let step = select(stroke.step, abs(end) / TOP, outlying);
        let way = abs(end - p);
        if way <= 5.0 * step && abs(value - p) < 0.5 * step {
            value = select(p + step * sign(end - p), end, way <= step);
        }
        if value == p {
            return beside(old, end > p);
        }
    }
    return bitcast<u32>(value);
}

fn finite(bits: u32) -> bool {
    return (bits & 0x7f800000u) != 0x7f800000u;
}

// A key that is ordered like the floats.
fn ordered(bits: u32) -> u32 {
    return select(bits | 0x80000000u, ~bits, bits >= 0x80000000u);
}

// The bits of the next float above or below.
fn beside(bits: u32, above: bool) -> u32 {
    let key = select(ordered(bits) - 1u, ordered(bits) + 1u, above);
    return select(~key, key & 0x7fffffffu, key >= 0x80000000u);
}
