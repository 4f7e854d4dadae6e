// Rays that stay straight: where they enter and leave the box that the field fills.

fn intersect(ray: Ray, near: f32, far: f32) -> vec2f {
    var reach = vec2f(near, far);
    for (var a = 0u; a < 3u; a++) {
        let o = ray.origin[a];
        let d = ray.direction[a];
        if d == 0.0f {
            // Parallel to the slab: inside or never.
            if o < BOX_MIN[a] || o > BOX_MAX[a] {
                return vec2f(1.0f, 0.0f);
            }
        } else {
            let t0 = (BOX_MIN[a] - o) / d;
            let t1 = (BOX_MAX[a] - o) / d;
            reach = vec2f(max(reach.x, min(t0, t1)), min(reach.y, max(t0, t1)));
        }
    }
    return reach;
}

fn is_outside(ray: Ray, k: f32) -> bool {
    let t = distance_of(k);
    return t > FAR || !is_inside(ray.origin + t * ray.direction);
}

// The first step, and one past the last.
fn first_steps(local: Local) -> vec2f {
    let reach = intersect(local.ray, NEAR, FAR);
    if !(reach.x <= reach.y) {
        return vec2f();
    }
    // A little outside, then in.
    var k = max(trunc((reach.x - NEAR) / STEP) - 2.0f, 0.0f);
    var end = min(trunc((reach.y - NEAR) / STEP) + 3.0f, MAX_STEPS);
    for (var i = 0u; i < 8u && k < end && is_outside(local.ray, k); i++) {
        k += 1.0f;
    }
    for (var i = 0u; i < 8u && k < end && is_outside(local.ray, end - 1.0f); i++) {
        end -= 1.0f;
    }
    return vec2f(k, end);
}

// Nothing comes after them.
fn turn(local: ptr<function, Local>, k: f32) -> f32 {
    return k;
}

fn local_at(local: Local, t: f32) -> Local {
    return local;
}

fn way_inside(local: Local) -> vec2f {
    return intersect(local.ray, NEAR, FAR);
}
