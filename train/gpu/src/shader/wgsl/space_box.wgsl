// A box in scene units: rays are what they are.

struct Local {
    ray: Ray,
    is_there: bool,
}

fn to_local(ray: Ray) -> Local {
    return Local(ray, true);
}

fn scene_depth(ray: Ray, local: Ray, t: f32) -> f32 {
    return t;
}

// How far a ray goes at most, where samples are hierarchical and reach beyond the box.
fn whole_way(local: Local) -> vec2f {
    return vec2f(NEAR, FAR);
}
