// Each ray for itself.

fn ray_color(mean: Channels, direction: vec3f) -> vec3f {
    return decoded_color(mean, direction);
}
