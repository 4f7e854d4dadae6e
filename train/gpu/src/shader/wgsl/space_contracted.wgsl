// Contracted space (Reiser et al. 2023, equation 6): rays are a few straight pieces, as
// `core::space::contracted` has them.

struct Local {
    // A piece, along which distances go on, and where it ends.
    ray: Ray,
    is_there: bool,
    end: f32,
    // What comes after it.
    walk: Walk,
}

// How far a ray has been followed.
struct Walk {
    // Half of the cube's side is 1, its centre the origin.
    ray: Ray,
    // The part of space that comes next: the cube, then what lies beyond each of its faces.
    part: u32,
    // The distance at which it is entered, along this ray and along the pieces.
    begin: f32,
    before: f32,
}

// What of a ray lies in one part.
struct Stretch {
    start: vec3f,
    way: vec3f,
    length: f32,
    // Distance to where it begins, and what gives those on it.
    begin: f32,
    reach: f32,
    left: f32,
}

const PARTS = 7u;
// Samples end so far before infinity.
const MARGIN = 1e-5f;
// Share of the way to infinity that is as far as depths go.
const FARTHEST = 0.99999976f;

// The largest coordinate of a part where the ray begins, and how much it grows: a point lies in
// the part where it is greatest.
fn largest(ray: Ray, part: u32) -> vec2f {
    if part == 0u {
        return vec2f(1.0f, 0.0f);
    }
    let axis = (part - 1u) / 2u;
    let v = vec2f(ray.origin[axis], ray.direction[axis]);
    return select(-v, v, (part & 1u) != 0u);
}

// The local point of a part at the distance at.x / at.y, that of infinity too.
fn image(ray: Ray, part: u32, at: vec2f) -> vec3f {
    var p = ray.origin * at.y + ray.direction * at.x;
    if part != 0u {
        let m = dot(largest(ray, part).yx, at);
        p /= m;
        p[(part - 1u) / 2u] *= 2.0f - at.y / m;
    }
    return p;
}

// The next stretch, which is left behind.
fn next(walk: ptr<function, Walk>) -> Stretch {
    let ray = (*walk).ray;
    let part = (*walk).part;
    let begin = (*walk).begin;
    let own = largest(ray, part);
    // Which part takes over, and where: one that grows faster; at the same place, the fastest.
    var to = PARTS;
    var end = vec2f(1.0f, 0.0f);
    var fastest = 0.0f;
    for (var other = 0u; other < PARTS; other++) {
        let theirs = largest(ray, other);
        if theirs.y > own.y {
            let at = max((own.x - theirs.x) / (theirs.y - own.y), begin);
            if to == PARTS || at < end.x || (at == end.x && theirs.y > fastest) {
                to = other;
                end = vec2f(at, 1.0f);
                fastest = theirs.y;
            }
        }
    }
    let start = image(ray, part, vec2f(begin, 1.0f));
    let way = image(ray, part, end) - start;
    let length = length(way);
    let m = own.x + own.y * begin;
    let last = dot(own.yx, end);
    *walk = Walk(ray, to, end.x, (*walk).before + length);
    return Stretch(start, way, length, begin, (end.x - begin * end.y) * m / last, end.y * m / last);
}

// Where it begins.
fn to_walk(ray: Ray) -> Walk {
    let own = Ray((ray.origin - CENTER) / RADIUS, ray.direction);
    var part = 0u;
    for (var other = 1u; other < PARTS; other++) {
        let a = largest(own, other);
        let b = largest(own, part);
        if a.x > b.x || (a.x == b.x && a.y > b.y) {
            part = other;
        }
    }
    return Walk(own, part, 0.0f, 0.0f);
}

fn to_local(ray: Ray) -> Local {
    return local_at(Local(ray, false, -1.0f, to_walk(ray)), 0.0f);
}

// The piece on which distance `t` lies; behind the last, that one.
fn local_at(local: Local, t: f32) -> Local {
    var walk = local.walk;
    for (var i = 0u; i < PARTS && t >= local.end && walk.part < PARTS; i++) {
        let before = walk.before;
        let stretch = next(&walk);
        let end = walk.before - select(0.0f, MARGIN, walk.part == PARTS);
        if t < end && stretch.length > 0.0f {
            let direction = stretch.way / stretch.length;
            return Local(Ray(stretch.start - before * direction, direction), true, end, walk);
        }
    }
    return local;
}

fn first_steps(local: Local) -> vec2f {
    return vec2f();
}

// On along the piece of step `k`: one past its last step, or `k` where there is none.
fn turn(local: ptr<function, Local>, k: f32) -> f32 {
    let begin = distance_of(k);
    *local = local_at(*local, begin);
    let end = (*local).end;
    if !(begin < end && begin <= FAR) {
        return k;
    }
    // A little before, then on.
    var last = max(trunc(min((min(end, FAR) - NEAR) / STEP, MAX_STEPS)) - 2.0f, k);
    for (var i = 0u; i < 8u && last < MAX_STEPS; i++) {
        let t = distance_of(last);
        if t >= end || t > FAR {
            break;
        }
        last += 1.0f;
    }
    return last;
}

fn whole_way(local: Local) -> vec2f {
    var walk = local.walk;
    for (var i = 0u; i < PARTS && walk.part < PARTS; i++) {
        _ = next(&walk);
    }
    return vec2f(0.0f, max(walk.before - 2.0f * MARGIN, 0.0f));
}

fn way_inside(local: Local) -> vec2f {
    return vec2f(NEAR, min(whole_way(local).y, FAR));
}

fn scene_depth(ray: Ray, local: Ray, t: f32) -> f32 {
    var walk = to_walk(ray);
    var depth = 0.0f;
    for (var i = 0u; i < PARTS && walk.part < PARTS; i++) {
        let before = walk.before;
        let stretch = next(&walk);
        if stretch.length > 0.0f {
            let share = clamp((t - before) / stretch.length, 0.0f, FARTHEST);
            let on = share * stretch.reach / (1.0f - share + share * stretch.left);
            depth = stretch.begin + on;
        }
        if t <= walk.before {
            break;
        }
    }
    return depth * RADIUS;
}
