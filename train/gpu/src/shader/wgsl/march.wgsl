// Equal steps through occupied cells, until next to no light passes: equation 3 of the NeRF
// paper (Mildenhall et al. 2020), as `core::march` has it.

// What a ray needs to cross cells.
struct Stride {
    // Steps per unit length along each axis.
    steps_per_unit: vec3f,
    // Rounding error of a unit coordinate, in steps.
    slack: vec3f,
}

const EPSILON = 1.1920929e-7f;

fn stride(ray: Ray) -> Stride {
    let steps_per_unit = 1.0f / (ray.direction * (UNIT_SCALE * STEP));
    let rounding = (abs(ray.origin) + abs(BOX_MIN)) * (UNIT_SCALE * 4.0f * EPSILON) + 4.0f * EPSILON;
    return Stride(steps_per_unit, rounding * abs(steps_per_unit));
}

// Steps to the first sample beyond the cells around `u`, or a little less; at least 1.
fn steps_to_leave(ray: Ray, stride: Stride, u: vec3f, cells: Around, t: f32) -> f32 {
    var steps = 1e9f;
    for (var a = 0u; a < 3u; a++) {
        let d = ray.direction[a];
        if d != 0.0f {
            let face = (cells.corner[a] + select(0.0f, cells.side, d > 0.0f)) / f32(RESOLUTION);
            steps = min(steps, (face - u[a]) * stride.steps_per_unit[a] - stride.slack[a]);
        }
    }
    let safe = steps - (t * (8.0f * EPSILON / STEP) + 0.01f);
    return select(1.0f, floor(safe) + 1.0f, safe > 0.0f && safe < 1e6f);
}

// Steps that a sample stands for.
fn steps_at(transmittance: f32) -> f32 {
    let below = frame.detail.y;
    let later = select(4.0f, 2.0f, transmittance >= below * 0.25f);
    return select(later, 1.0f, transmittance >= below);
}

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
