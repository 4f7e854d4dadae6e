// Smooth surfaces, where they are asked for: `trainer::step::surfaces`. Of three rays in a row the
// middle one comes first, its weight negative, then those before and behind it.

// A bend counts half as much as a small one where the middle is off by so much of the distance to
// its neighbours.
const EDGE = 0.5f;

// Where a ray meets a surface, local coordinates.
struct Met {
    is_met: bool,
    ray: Ray,
    t: f32,
}

fn surface_of(r: u32) -> Met {
    let mean = mean_of(r);
    let local = local_at(to_local(Ray(rays[4u * r].xyz, rays[4u * r + 1u].xyz)), mean.depth);
    let is_met = local.is_there && mean.opacity >= OPAQUE && mean.depth > 0.0f;
    return Met(is_met, local.ray, mean.depth);
}

fn begins_row(r: u32) -> bool {
    return rays[4u * r + 1u].w < 0.0f;
}

// The gradient of what is bent by a ray's distance; 0 where it is in no row.
fn bent(r: u32) -> f32 {
    if begins_row(r) {
        return bend(r)[1];
    }
    if r >= 1u && begins_row(r - 1u) {
        return bend(r - 1u)[0];
    }
    if r >= 2u && begins_row(r - 2u) {
        return bend(r - 2u)[2];
    }
    return 0.0f;
}

// How far a way leads off the line `across`, where `own` leads 1 off it.
fn off_line(way: vec3f, across: vec3f, own: vec3f) -> f32 {
    let normal = cross(own, across);
    return dot(cross(way, across), normal) / dot(normal, normal);
}

// The gradient by the distances of a row: before, middle, behind.
fn bend(first: u32) -> vec3f {
    if first + 2u >= frame.once.y {
        return vec3f();
    }
    let before = surface_of(first + 1u);
    let middle = surface_of(first);
    let after = surface_of(first + 2u);
    if !(before.is_met && middle.is_met && after.is_met) {
        return vec3f();
    }
    let start = before.ray.origin + before.t * before.ray.direction;
    let across = after.ray.origin + after.t * after.ray.direction - start;
    let own = middle.ray.direction;
    let t = off_line(start - middle.ray.origin, across, own);
    let share = dot(middle.ray.origin + t * own - start, across) / dot(across, across);
    let apart = 0.5f * length(across);
    let off = (middle.t - t) / apart;
    let kept = EDGE * EDGE / (EDGE * EDGE + off * off);
    let d = off * kept * kept / apart;
    let d_before = -d * (1.0f - share) * off_line(before.ray.direction, across, own);
    let d_after = -d * share * off_line(after.ray.direction, across, own);
    let are_finite = is_finite(d_before) && is_finite(d) && is_finite(d_after);
    return select(vec3f(), vec3f(d_before, d, d_after), are_finite);
}
