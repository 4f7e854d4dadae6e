// Without cells, anything may be anywhere.

const RESOLUTION = 1u;

struct Around {
    is_occupied: bool,
    corner: vec3f,
    side: f32,
}

fn around(u: vec3f) -> Around {
    return Around(true, vec3f(), 1.0f);
}
