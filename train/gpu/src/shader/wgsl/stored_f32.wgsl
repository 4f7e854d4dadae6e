// Tables of single precision.

fn stored(number: u32) -> f32 {
    return bitcast<f32>(tables[number]);
}

fn stored_quad(number: u32) -> vec4f {
    return vec4f(stored(number), stored(number + 1u), stored(number + 2u), stored(number + 3u));
}
