// Equal steps through occupied cells, until next to no light passes: equation 3 of the NeRF
// paper (Mildenhall et al. 2020), as `core::march` has it.

// Where a ray is: at step k of those before `end`.
struct Course {
    local: Local,
    across: Stride,
    k: f32,
    end: f32,
}

struct Sample {
    is_found: bool,
    t: f32,
    u: vec3f,
}

// The next sample, which stands for so many steps. Neighbours seek theirs together, and ask the
// field together afterwards.
fn seek(course: ptr<function, Course>, steps: f32) -> Sample {
    var sample: Sample;
    var c = *course;
    while !sample.is_found {
        if !(c.k < c.end) {
            c.k = c.end;
            var local = c.local;
            c.end = turn(&local, c.k);
            c.local = local;
            if !(c.k < c.end) {
                break;
            }
            c.across = stride(local.ray);
        }
        let ray = c.local.ray;
        sample.t = distance_of(min(c.k + (steps - 1.0f) * 0.5f, c.end - 1.0f));
        sample.u = unit(ray.origin + sample.t * ray.direction);
        let cells = around(sample.u);
        sample.is_found = cells.is_occupied;
        let leave = steps_to_leave(ray, c.across, sample.u, cells, sample.t);
        c.k += select(select(1.0f, leave, SKIP), steps, sample.is_found);
    }
    *course = c;
    return sample;
}

// What a ray has seen.
struct Sum {
    transmittance: f32,
    opacity: f32,
    distance: f32,
    samples: u32,
    channels: Channels,
}

fn sum_with(sum: Sum, point: Point, t: f32, steps: f32) -> Sum {
    var s = sum;
    s.samples += 1u;
    var alpha = 1.0f - exp(-point.sigma * STEP);
    if steps > 1.0f {
        alpha *= 2.0f - alpha;
    }
    if steps > 2.0f {
        alpha *= 2.0f - alpha;
    }
    let weight = s.transmittance * alpha;
    if weight > 0.0f {
        s.transmittance *= 1.0f - alpha;
        s.opacity += weight;
        s.distance += weight * t;
        s.channels = sum_of(s.channels, weight, point.channels);
    }
    return s;
}

fn seen_by(ray: Ray, local: Ray, sum: Sum) -> Seen {
    if !(sum.opacity > 0.0f) {
        return Seen(vec4f(), -1.0f, sum.samples);
    }
    // A ray that ended early counts as opaque.
    let alpha = select(sum.opacity, 1.0f, sum.transmittance < frame.detail.x);
    let mean = sum_of(Channels(), 1.0f / sum.opacity, sum.channels);
    let color = alpha * ray_color(mean, ray.direction);
    return Seen(vec4f(color, alpha), scene_depth(ray, local, sum.distance / sum.opacity), sum.samples);
}

fn trace(ray: Ray) -> Seen {
    let local = to_local(ray);
    if !local.is_there {
        return NOTHING;
    }
    let first = first_steps(local);
    var course = Course(local, stride(local.ray), first.x, first.y);
    var sum: Sum;
    sum.transmittance = 1.0f;
    var steps = 1.0f;
    while sum.samples < MAX_SAMPLES && sum.transmittance >= frame.detail.x {
        let sample = seek(&course, steps);
        if !sample.is_found {
            break;
        }
        sum = sum_with(sum, evaluate(sample.u, ray.direction), sample.t, steps);
        steps = steps_at(sum.transmittance);
    }
    return seen_by(ray, course.local.ray, sum);
}
