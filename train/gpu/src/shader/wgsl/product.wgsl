// A quad times four rows of weights, the first of them here, `n` quads apart.
fn product(x: vec4f, at: u32, n: u32) -> vec4f {
    return x.x * weights[at] + x.y * weights[at + n] + x.z * weights[at + 2u * n]
        + x.w * weights[at + 3u * n];
}
