// How many steps a ray takes at a time, and across cells that are empty, as `core::march` has
// it.

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
    let d = ray.direction;
    let face = (cells.corner + select(vec3f(), vec3f(cells.side), d > vec3f())) / f32(RESOLUTION);
    let along = (face - u) * stride.steps_per_unit - stride.slack;
    let each = select(vec3f(1e9f), along, d != vec3f());
    let steps = min(min(each.x, each.y), min(each.z, 1e9f));
    let safe = steps - (t * (8.0f * EPSILON / STEP) + 0.01f);
    return select(1.0f, floor(safe) + 1.0f, safe > 0.0f && safe < 1e6f);
}

// Steps that a sample stands for.
fn steps_at(transmittance: f32) -> f32 {
    let below = frame.detail.y;
    let later = select(4.0f, 2.0f, transmittance >= below * 0.25f);
    return select(later, 1.0f, transmittance >= below);
}
