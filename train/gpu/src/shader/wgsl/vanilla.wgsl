// The original NeRF networks (Mildenhall et al. 2020, section 5.2).

struct Point {
    sigma: f32,
    channels: Channels,
}

fn logistic(x: vec4f) -> vec3f {
    return 1.0f / (1.0f + exp(-clamp(x.xyz, vec3f(-80.0f), vec3f(80.0f))));
}

fn softplus(x: f32) -> f32 {
    return max(x, 0.0f) + log(1.0f + exp(-abs(x)));
}

fn evaluate(u: vec3f, direction: vec3f) -> Point {
    let output = fine_network(u, direction);
    let sigma = min(activated(output[0].x), MAX_SIGMA) * DENSITY_SCALE;
    return Point(sigma, Channels(vec4f(logistic(output[1]), 0.0f)));
}

fn ray_color(mean: Channels, direction: vec3f) -> vec3f {
    return mean[0].xyz;
}
