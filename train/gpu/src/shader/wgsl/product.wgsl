// A quad times four rows of weights, the first of them here, `n` quads apart.
fn product(x: vec4f, at: u32, n: u32) -> vec4f {
    return x.x * weight(at) + x.y * weight(at + n) + x.z * weight(at + 2u * n)
        + x.w * weight(at + 3u * n);
}
