// From an encoded point to density and features, and from features to a colour.

alias Features = array<vec4f, N_FEATURE_QUADS>;

// Real spherical harmonics of a unit direction, the first DEGREE * DEGREE of them.
fn harmonics(d: vec3f) -> array<vec4f, N_HARMONICS> {
    let x = d.x;
    let y = d.y;
    let z = d.z;
    let xx = x * x;
    let yy = y * y;
    let zz = z * z;
    let all = array<vec4f, 4>(
        vec4f(0.28209479f, -0.48860251f * y, 0.48860251f * z, -0.48860251f * x),
        vec4f(1.0925484f * x * y, -1.0925484f * y * z, 0.9461747f * zz - 0.31539157f, -1.0925484f * x * z),
        vec4f(
            0.5462742f * (xx - yy),
            0.5900436f * y * (yy - 3.0f * xx),
            2.8906114f * x * y * z,
            0.4570458f * y * (1.0f - 5.0f * zz),
        ),
        vec4f(
            0.37317634f * z * (5.0f * zz - 3.0f),
            0.4570458f * x * (1.0f - 5.0f * zz),
            1.4453057f * z * (xx - yy),
            0.5900436f * x * (3.0f * yy - xx),
        ),
    );
    var some: array<vec4f, N_HARMONICS>;
    for (var i = 0u; i < N_HARMONICS; i++) {
        some[i] = all[i];
    }
    return some;
}

fn logistic(x: vec4f) -> vec3f {
    return 1.0f / (1.0f + exp(-clamp(x.xyz, vec3f(-80.0f), vec3f(80.0f))));
}

fn decoded_sigma(log_density: f32) -> f32 {
    return min(exp(min(log_density + LOG_DENSITY_BIAS, 80.0f)), MAX_SIGMA);
}
