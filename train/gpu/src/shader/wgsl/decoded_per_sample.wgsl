// Every sample has a colour; rays accumulate these.

struct Point {
    sigma: f32,
    channels: Channels,
}

fn evaluate(u: vec3f, direction: vec3f) -> Point {
    var encoded = encode(u);
    let output = density_network(&encoded);
    let color = decoded_color(features_of(output), direction);
    return Point(decoded_sigma(output[N_FEATURE_QUADS].x), Channels(vec4f(color, 0.0f)));
}

fn ray_color(mean: Channels, direction: vec3f) -> vec3f {
    return mean[0].xyz;
}
