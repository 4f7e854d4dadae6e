// Normalised device coordinates (Mildenhall et al. 2020, supplement C).

struct Local {
    ray: Ray,
    is_there: bool,
}

// Share of the way to infinity that is as far as depths go.
const FARTHEST = 0.99999976f;

struct Path {
    // Where the ray enters.
    origin: vec3f,
    // From there to infinity.
    way: vec3f,
    // Distance to where it enters, scene units, and from there to half of the way.
    begin: f32,
    half_way: f32,
}

fn path(ray: Ray) -> Path {
    let o = ray.origin;
    let d = ray.direction;
    // From the near plane on, or from the eye where that lies beyond it.
    let z = min(o.z, -NDC_NEAR);
    let at = (o.xy + (z - o.z) * (d.xy / d.z)) / z;
    let origin = vec3f(-NDC_SLOPE * at, 1.0f + 2.0f * NDC_NEAR / z);
    let way = vec3f(-NDC_SLOPE * (d.xy / d.z - at), -2.0f * NDC_NEAR / z);
    return Path(origin, way, (z - o.z) / d.z, z / d.z);
}

fn to_local(ray: Ray) -> Local {
    // Rays that do not go forwards never enter.
    if !(ray.direction.z < -1e-6f) {
        return Local(ray, false);
    }
    let path = path(ray);
    return Local(Ray(path.origin, path.way / length(path.way)), path.way.z > 0.0f);
}

fn scene_depth(ray: Ray, local: Ray, t: f32) -> f32 {
    let path = path(ray);
    let share = clamp(t / length(path.way), 0.0f, FARTHEST);
    return path.begin + path.half_way * share / (1.0f - share);
}

fn whole_way(local: Local) -> vec2f {
    return vec2f(0.0f, (1.0f - local.ray.origin.z) / local.ray.direction.z);
}
