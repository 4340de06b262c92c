#define_import_path burin::equation
// Direct Volume Editing (2008), equation 1, of numbers, in the form P' = P + G ((C op P) - P). Four at a time.

#import burin::stroke::{ADD, RESTORE, SUBTRACT, Choices, stroke}

// The greatest 16-bit code.
const TOP: f32 = 65535.0;

// `back` is the number before any edit.
fn number(p: vec4<f32>, back: vec4<f32>, cover: vec4<f32>, does: Choices) -> vec4<f32> {
    let c = stroke.paint.x;
    let low = vec4<f32>(stroke.low);
    let top = vec4<f32>(stroke.top);
    let more = clamp(p + cover * c, low, top);
    let less = clamp(p - cover * c, low, top);
    let end = select(vec4<f32>(c), back, does.operation == RESTORE);
    let mixed = select(p + cover * (end - p), end, cover >= vec4<f32>(1.0));
    return select(select(mixed, less, does.operation == SUBTRACT), more, does.operation == ADD);
}

// A code's new value, a step nearer to an end where rounding would leave it where it was: weak strokes never stall short of it.
fn arriving(old: vec4<u32>, new_code: vec4<u32>, end: vec4<u32>, does: Choices) -> vec4<u32> {
    let nearer = select(select(old, old - 1u, end < old), old + 1u, end > old);
    return select(new_code, nearer, vec4<bool>(does.to_end) & (new_code == old));
}

// Where C lies among codes, or what was there before any edit.
fn end_code(back: vec4<u32>, does: Choices) -> vec4<u32> {
    return select(vec4<u32>(u32(floor(stroke.paint.x + 0.5))), back, does.operation == RESTORE);
}

// A code of 16 bits.
fn code(old: vec4<u32>, back: vec4<u32>, cover: vec4<f32>, does: Choices) -> vec4<u32> {
    let to = number(vec4<f32>(old), vec4<f32>(back), cover, does);
    let new_code = vec4<u32>(clamp(floor(to + 0.5), vec4<f32>(0.0), vec4<f32>(TOP)));
    return arriving(old, new_code, end_code(back, does), does);
}

// A code of 8 bits; before any edit it was 0.
fn short_code(old: vec4<u32>, cover: vec4<f32>, does: Choices) -> vec4<u32> {
    let new_code = vec4<u32>(floor(number(vec4<f32>(old), vec4<f32>(0.0), cover, does) + 0.5));
    return arriving(old, new_code, end_code(vec4<u32>(0u), does), does);
}
