// Tables of whole numbers of eight bits, four a word.

fn stored(number: u32) -> f32 {
    return f32(extractBits(bitcast<i32>(tables[number / 4u]), 8u * (number & 3u), 8u));
}

fn stored_quad(number: u32) -> vec4f {
    let word = bitcast<i32>(tables[number / 4u]);
    return vec4f(vec4i(word << 24u, word << 16u, word << 8u, word) >> vec4u(24u));
}
