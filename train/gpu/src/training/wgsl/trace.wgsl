// Forwards: every ray from sample to sample until it is opaque. What going back needs is noted in
// chunks, so that long rays and short ones take as much memory as they have samples.

@compute @workgroup_size(64)
fn trace(@builtin(global_invocation_id) id: vec3u) {
    let r = id.x;
    if r >= frame.once.y {
        return;
    }
    let start = rays[4u * r];
    let along = rays[4u * r + 1u];
    STEP = frame.detail.z;
    PHASE = start.w;
    let ray = Ray(start.xyz, along.xyz);
    var last = NONE;
    var count = 0u;
    var transmittance = 1.0f;
    var opacity = 0.0f;
    var depth = 0.0f;
    var sums: Channels;
    var local = to_local(ray);
    if local.is_there {
        let first = first_steps(local);
        var k = first.x;
        var end = first.y;
        var across = stride(local.ray);
        var steps = 1.0f;
        loop {
            if !(k < end) {
                k = end;
                end = turn(&local, k);
                if !(k < end) {
                    break;
                }
                across = stride(local.ray);
            }
            let t = distance_of(min(k + (steps - 1.0f) * 0.5f, end - 1.0f));
            let u = unit(local.ray.origin + t * local.ray.direction);
            let cells = around(u);
            if !cells.is_occupied {
                k += steps_to_leave(local.ray, across, u, cells, t);
                continue;
            }
            if count % CHUNK == 0u {
                let chunk = atomicAdd(&counters[NEXT_CHUNK], 1u);
                if chunk >= frame.sizes.z {
                    // The step is taken again with more memory.
                    atomicStore(&counters[TOO_MANY], 1u);
                    break;
                }
                links[chunk] = last;
                last = chunk;
            }
            let point = evaluate(u, ray.direction);
            k += steps;
            let alpha = 1.0f - exp(-point.sigma * (STEP * steps));
            let weight = transmittance * alpha;
            transmittance *= 1.0f - alpha;
            opacity += weight;
            depth += weight * t;
            let at = chunk_quad(last, count % CHUNK);
            samples[at] = vec4f(u, weight);
            samples[at + 1u] = vec4f(transmittance, steps, point.sigma, 0.0f);
            for (var c = 0u; c < N_CHANNELS; c++) {
                samples[at + 2u + c] = point.channels[c];
                sums[c] += weight * point.channels[c];
            }
            count += 1u;
            if is_opaque(transmittance) {
                break;
            }
            steps = steps_at(transmittance);
        }
    }
    let at = PER_RAY * r;
    traced[at] = vec4f(bitcast<f32>(last), bitcast<f32>(count), transmittance, opacity);
    traced[at + 1u] = vec4f(depth, 0.0f, 0.0f, 0.0f);
    for (var c = 0u; c < N_CHANNELS; c++) {
        traced[at + 2u + c] = sums[c];
    }
}
