// Rays accumulate features; their mean has a colour.

alias Channels = array<vec4f, N_FEATURE_QUADS>;

struct Point {
    sigma: f32,
    channels: Channels,
}

fn evaluate(u: vec3f, direction: vec3f) -> Point {
    var encoded = encode(u);
    let output = density_network(&encoded);
    var channels: Channels;
    for (var c = 0u; c < N_CHANNELS; c++) {
        channels[c] = output[c];
    }
    return Point(decoded_sigma(output[N_FEATURE_QUADS].x), channels);
}

fn ray_color(mean: Channels, direction: vec3f) -> vec3f {
    var features: array<vec4f, N_FEATURE_QUADS>;
    for (var f = 0u; f < N_FEATURE_QUADS; f++) {
        features[f] = mean[f];
    }
    return decoded_color(&features, direction);
}
