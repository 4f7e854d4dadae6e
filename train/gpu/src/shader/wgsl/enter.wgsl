// Where a local ray enters and leaves the box that the field fills.

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

fn is_inside(p: vec3f) -> bool {
    return all(p >= BOX_MIN) && all(p <= BOX_MAX);
}

fn unit(p: vec3f) -> vec3f {
    return (p - BOX_MIN) * UNIT_SCALE;
}
