#define_import_path burin::equation_colour
// Equation 1 of colours, which mix as amounts of paint, that is, multiplied by their alpha.

#import burin::stroke::{ADD, BLEND, RESTORE, SUBTRACT, Choices, stroke}

fn colours(old: vec4<u32>, cover: vec4<f32>, does: Choices) -> vec4<u32> {
    return vec4<u32>(
        colour(old.x, cover.x, does),
        colour(old.y, cover.y, does),
        colour(old.z, cover.z, does),
        colour(old.w, cover.w, does),
    );
}

fn colour(old: u32, cover: f32, does: Choices) -> u32 {
    let p = unpack4x8unorm(old);
    let c = stroke.paint;
    if does.operation == SUBTRACT {
        return select(stored(vec4<f32>(p.rgb - cover * c.a * c.rgb, p.a)), old, p.a == 0.0);
    }
    // Amounts of paint.
    let paint = vec4<f32>(p.rgb * p.a, p.a);
    let added = vec4<f32>(c.rgb * c.a, c.a);
    var to = added;
    if does.operation == ADD {
        let sum = paint + cover * added;
        return straight(vec4<f32>(sum.rgb, min(sum.a, 1.0)));
    }
    if does.operation == BLEND {
        to = added + paint * (1.0 - c.a);
    } else if does.operation == RESTORE {
        to = vec4<f32>(0.0);
    }
    if cover >= 1.0 {
        return straight(to);
    }
    let mixed = straight(paint + cover * (to - paint));
    if does.to_end && mixed == old && old != 0u {
        return select(old - 0x01000000u, 0u, (old >> 24u) <= 1u);
    }
    return mixed;
}

fn straight(amount: vec4<f32>) -> u32 {
    if amount.a <= 0.0 {
        return 0u;
    }
    return stored(vec4<f32>(amount.rgb / amount.a, amount.a));
}

fn stored(rgba: vec4<f32>) -> u32 {
    let steps = vec4<u32>(floor(clamp(rgba, vec4<f32>(0.0), vec4<f32>(1.0)) * 255.0 + 0.5));
    let word = steps.x | (steps.y << 8u) | (steps.z << 16u) | (steps.w << 24u);
    return select(word, 0u, steps.w == 0u);
}
