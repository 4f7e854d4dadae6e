// Tables of half precision, two a word.

fn stored(number: u32) -> f32 {
    return unpack2x16float(tables[number / 2u])[number & 1u];
}

fn stored_quad(number: u32) -> vec4f {
    let at = number / 2u;
    return vec4f(unpack2x16float(tables[at]), unpack2x16float(tables[at + 1u]));
}
