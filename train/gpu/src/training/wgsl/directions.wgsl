// Directions between cameras: `trainer::pixels::neighbours` in `pocketnerf-train`.

// Directions turn within the angle to the camera that is so many-th nearest.
const NEIGHBOUR = 4u;
const FEWEST = 5u;
const MOST_TURN = 0.5f;
// Of few views, directions are blurred within this share of it.
const BLURRED = 0.65f;

// The direction from a camera to a point.
fn towards(camera: u32, point: vec3f) -> vec3f {
    let way = point - cameras[camera].xyz;
    let square = dot(way, way);
    return select(vec3f(), way * inverseSqrt(square), square > 0.0f);
}

// The cameras that see `point` from nearest to a direction, the nearest first.
fn nearest(point: vec3f, direction: vec3f) -> array<vec4f, FEWEST> {
    var found: array<vec4f, FEWEST>;
    for (var i = 0u; i < FEWEST; i++) {
        found[i] = vec4f(0.0f, 0.0f, 0.0f, -2.0f);
    }
    for (var camera = 0u; camera < frame.once.w; camera++) {
        let way = towards(camera, point);
        var own = vec4f(way, dot(way, direction));
        for (var i = 0u; i < FEWEST; i++) {
            let other = found[i];
            let is_nearer = own.w > other.w;
            found[i] = select(other, own, is_nearer);
            own = select(own, other, is_nearer);
        }
    }
    return found;
}

// The angle within which a direction may turn at a point.
fn reach_of(point: vec3f, direction: vec3f) -> f32 {
    if frame.once.w < FEWEST {
        return MOST_TURN;
    }
    return min(acos(clamp(nearest(point, direction)[NEIGHBOUR].w, -1.0f, 1.0f)), MOST_TURN);
}

// A direction turned any way by up to an angle.
fn turned(direction: vec3f, reach: f32, random: ptr<function, Random>) -> vec3f {
    // Across it and across that: any direction of the plane is as probable.
    let other = select(vec3f(1.0f, 0.0f, 0.0f), vec3f(0.0f, 1.0f, 0.0f), abs(direction.x) > 0.7f);
    let a = normalize(cross(direction, other));
    let b = cross(direction, a);
    let around = 6.2831855f * next_random(random);
    let across = a * cos(around) + b * sin(around);
    let angle = reach * next_random(random);
    return normalize(direction * cos(angle) + across * sin(angle));
}
