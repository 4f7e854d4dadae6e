// Evenly spaced samples, then more of them where those have weight (Mildenhall et al. 2020,
// section 5.2), as `core::reference` has it.

const N_ALL = N_COARSE + N_FINE;

var<private> t_coarse: array<f32, N_COARSE>;
var<private> coarse_weight: array<f32, N_COARSE>;
var<private> t_all: array<f32, N_ALL>;

// Whether the field is asked at a local point.
fn is_sampled(p: vec3f) -> bool {
    return !CLIPPED || (is_inside(p) && around(unit(p)).is_occupied);
}

// Where the bin between samples i and i + 1 begins and ends.
fn middle(i: u32) -> f32 {
    return 0.5f * (t_coarse[i] + t_coarse[i + 1u]);
}

// What of the light passes the part of a ray that sample i of `n` stands for.
fn passes(sigma: f32, length: f32) -> f32 {
    return exp(-min(sigma * length, 80.0f));
}

// The weights of the evenly spaced samples; how many the field was asked at.
fn weigh(entered: Local) -> u32 {
    var local = entered;
    var transmittance = 1.0f;
    var samples = 0u;
    for (var i = 0u; i < N_COARSE; i++) {
        coarse_weight[i] = 0.0f;
        local = local_at(local, t_coarse[i]);
        let p = local.ray.origin + t_coarse[i] * local.ray.direction;
        if !is_sampled(p) {
            continue;
        }
        samples += 1u;
        var length = LAST;
        if i + 1u < N_COARSE {
            length = t_coarse[i + 1u] - t_coarse[i];
        }
        let passed = passes(coarse_sigma(unit(p)), length);
        coarse_weight[i] = transmittance * (1.0f - passed);
        transmittance *= passed;
    }
    return samples;
}

// All distances in ascending order: N_FINE more by the inverse of the cumulative distribution
// of the weights, the first and the last left out.
fn refine() {
    var total = 0.0f;
    for (var i = 1u; i < N_COARSE - 1u; i++) {
        total += coarse_weight[i] + 1e-5f;
    }
    // The bin that is looked at, and what lies before it.
    var bin = 1u;
    var before = 0.0f;
    var part = (coarse_weight[1] + 1e-5f) / total;
    var taken = 0u;
    for (var j = 0u; j < N_FINE; j++) {
        let at = f32(j) / f32(max(N_FINE, 2u) - 1u);
        while bin < N_COARSE - 2u && at >= before + part {
            before += part;
            bin += 1u;
            part = (coarse_weight[bin] + 1e-5f) / total;
        }
        let inside = clamp((at - before) / select(part, 1.0f, part < 1e-5f), 0.0f, 1.0f);
        let t = middle(bin - 1u) + inside * (middle(bin) - middle(bin - 1u));
        while taken < N_COARSE && t_coarse[taken] <= t {
            t_all[taken + j] = t_coarse[taken];
            taken += 1u;
        }
        t_all[taken + j] = t;
    }
    for (; taken < N_COARSE; taken++) {
        t_all[taken + N_FINE] = t_coarse[taken];
    }
}

fn trace(ray: Ray) -> Seen {
    var local = to_local(ray);
    if !local.is_there {
        return NOTHING;
    }
    var reach = whole_way(local);
    if CLIPPED {
        reach = way_inside(local);
        if !(reach.x <= reach.y) {
            return NOTHING;
        }
    } else if BY_DEPTH {
        let cosine = dot(frame.axis.xyz, ray.direction);
        reach = select(reach, reach / cosine, cosine > 1e-3f);
    }
    for (var i = 0u; i < N_COARSE; i++) {
        let along = f32(i) / f32(N_COARSE - 1u);
        t_coarse[i] = reach.x * (1.0f - along) + reach.y * along;
    }
    var samples = 0u;
    if N_FINE > 0u {
        samples = weigh(local);
    }
    refine();
    var transmittance = 1.0f;
    var opacity = 0.0f;
    var distance = 0.0f;
    var sums: Channels;
    for (var i = 0u; i < N_ALL; i++) {
        let t = t_all[i];
        local = local_at(local, t);
        let p = local.ray.origin + t * local.ray.direction;
        if !is_sampled(p) {
            continue;
        }
        samples += 1u;
        var length = LAST;
        if i + 1u < N_ALL {
            length = t_all[i + 1u] - t;
        }
        let point = evaluate(unit(p), ray.direction);
        let passed = passes(point.sigma, length);
        let weight = transmittance * (1.0f - passed);
        transmittance *= passed;
        if !(weight > 0.0f) {
            continue;
        }
        opacity += weight;
        distance += weight * t;
        sums = sum_of(sums, weight, point.channels);
    }
    if !(opacity > 0.0f) {
        return Seen(vec4f(), -1.0f, samples);
    }
    let color = opacity * ray_color(sum_of(Channels(), 1.0f / opacity, sums), ray.direction);
    return Seen(vec4f(color, opacity), scene_depth(ray, local.ray, distance / opacity), samples);
}
