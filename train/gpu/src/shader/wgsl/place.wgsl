// Where samples lie: steps along a ray, and points in the box that the field fills.

fn distance_of(k: f32) -> f32 {
    return (k + PHASE) * STEP + NEAR;
}

fn is_inside(p: vec3f) -> bool {
    return all(p >= BOX_MIN) && all(p <= BOX_MAX);
}

fn unit(p: vec3f) -> vec3f {
    return (p - BOX_MIN) * UNIT_SCALE;
}
