// Hierarchical samples are placed by the field itself.

fn coarse_sigma(u: vec3f) -> f32 {
    var encoded = encode(u);
    return decoded_sigma(density_network(&encoded)[N_FEATURE_QUADS].x);
}
