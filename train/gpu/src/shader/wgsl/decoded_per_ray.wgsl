// Rays accumulate features; their mean has a colour.

struct Point {
    sigma: f32,
    channels: Channels,
}

fn evaluate(u: vec3f, direction: vec3f) -> Point {
    var encoded = encode(u);
    let output = density_network(&encoded);
    return Point(decoded_sigma(output[N_FEATURE_QUADS].x), features_of(output));
}
