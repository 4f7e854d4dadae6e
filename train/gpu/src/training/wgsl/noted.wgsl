// What a ray has accumulated.
struct Sum {
    last: u32,
    count: u32,
    transmittance: f32,
    opacity: f32,
    depth: f32,
    channels: Channels,
}

const NOTHING = Sum(NONE, 0u, 1.0f, 0.0f, 0.0f, Channels());

// Adds a sample at the point `u` and the distance `t`, and notes it; its chunk is there.
fn add_sample(sum: ptr<function, Sum>, point: Point, u: vec3f, t: f32, steps: f32) {
    let alpha = 1.0f - exp(-point.sigma * (STEP * steps));
    let weight = (*sum).transmittance * alpha;
    let transmittance = (*sum).transmittance * (1.0f - alpha);
    let at = chunk_quad((*sum).last, (*sum).count % CHUNK);
    samples[at] = vec4f(u, weight);
    samples[at + 1u] = vec4f(transmittance, steps, point.sigma, t);
    for (var c = 0u; c < N_CHANNELS; c++) {
        samples[at + 2u + c] = point.channels[c];
        (*sum).channels[c] += weight * point.channels[c];
    }
    (*sum).transmittance = transmittance;
    (*sum).opacity += weight;
    (*sum).depth += weight * t;
    (*sum).count += 1u;
}

// Notes what a ray has accumulated.
fn note_ray(r: u32, sum: Sum) {
    let at = PER_RAY * r;
    let counts = vec2f(bitcast<f32>(sum.last), bitcast<f32>(sum.count));
    traced[at] = vec4f(counts, sum.transmittance, sum.opacity);
    traced[at + 1u] = vec4f(sum.depth, 0.0f, 0.0f, 0.0f);
    for (var c = 0u; c < N_CHANNELS; c++) {
        traced[at + 2u + c] = sum.channels[c];
    }
}
