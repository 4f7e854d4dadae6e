// The colour of features, in [0, 1].
fn decoded_color(features: Features, direction: vec3f) -> vec3f {
    var input: array<vec4f, N_FEATURE_QUADS + N_HARMONICS>;
    for (var i = 0u; i < N_FEATURE_QUADS; i++) {
        input[i] = features[i];
    }
    let around = harmonics(direction);
    for (var i = 0u; i < N_HARMONICS; i++) {
        input[N_FEATURE_QUADS + i] = around[i];
    }
    return logistic(color_network(&input)[0]);
}
