// Equal steps through occupied cells, until next to no light passes: equation 3 of the NeRF
// paper (Mildenhall et al. 2020), as `core::march` has it.

fn trace(ray: Ray) -> Seen {
    var local = to_local(ray);
    if !local.is_there {
        return NOTHING;
    }
    let first = first_steps(local);
    var k = first.x;
    var end = first.y;
    let least = frame.detail.x;
    var across = stride(local.ray);
    var steps = 1.0f;
    var transmittance = 1.0f;
    var opacity = 0.0f;
    var distance = 0.0f;
    var samples = 0u;
    var sums: Channels;
    while samples < MAX_SAMPLES {
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
            k += select(1.0f, steps_to_leave(local.ray, across, u, cells, t), SKIP);
            continue;
        }
        let point = evaluate(u, ray.direction);
        samples += 1u;
        k += steps;
        var alpha = 1.0f - exp(-point.sigma * STEP);
        if steps > 1.0f {
            alpha *= 2.0f - alpha;
        }
        if steps > 2.0f {
            alpha *= 2.0f - alpha;
        }
        let weight = transmittance * alpha;
        if !(weight > 0.0f) {
            continue;
        }
        transmittance *= 1.0f - alpha;
        opacity += weight;
        distance += weight * t;
        for (var c = 0u; c < N_CHANNELS; c++) {
            sums[c] += weight * point.channels[c];
        }
        if transmittance < least {
            break;
        }
        steps = steps_at(transmittance);
    }
    if !(opacity > 0.0f) {
        return Seen(vec4f(), -1.0f, samples);
    }
    // A ray that ended early counts as opaque.
    let alpha = select(opacity, 1.0f, transmittance < least);
    for (var c = 0u; c < N_CHANNELS; c++) {
        sums[c] /= opacity;
    }
    let color = alpha * ray_color(sums, ray.direction);
    let depth = scene_depth(ray, local.ray, distance / opacity);
    return Seen(vec4f(color, alpha), depth, samples);
}
