// Planes and lines (Chen et al. 2022, section 3), bilinear and linear.

// Where a point lies between entries: those before it along each axis, and how far it is to the
// next ones.
struct Cell {
    low: vec3u,
    fraction: vec3f,
}

fn cell_of(u: vec3f) -> Cell {
    let p = clamp(u, vec3f(), vec3f(1.0f)) * f32(PLANE_SIDE - 1u);
    // The last cell has its far side too.
    let low = min(vec3u(p), vec3u(PLANE_SIDE - 2u));
    return Cell(low, p - vec3f(low));
}

// Where it lies on a plane: the first of the four entries around it, and their weights.
struct Across {
    entry: u32,
    weights: vec4f,
}

fn across(at: Cell, first: u32, second: u32) -> Across {
    let a = vec2f(1.0f - at.fraction[first], at.fraction[first]);
    let b = vec2f(1.0f - at.fraction[second], at.fraction[second]);
    return Across(at.low[first] + PLANE_SIDE * at.low[second], vec4f(a * b.x, a * b.y));
}

// Four values of a plane, which begin at number `first`.
fn on_plane(at: Across, first: u32) -> vec4f {
    let near = first + N_VALUES_OF_ENTRY * at.entry;
    let far = near + N_VALUES_OF_ENTRY * PLANE_SIDE;
    var sum = at.weights.x * stored_quad(near);
    sum += at.weights.y * stored_quad(near + N_VALUES_OF_ENTRY);
    sum += at.weights.z * stored_quad(far);
    sum += at.weights.w * stored_quad(far + N_VALUES_OF_ENTRY);
    return sum;
}

// Four values of a line, which begin at number `first`.
fn on_line(at: Cell, axis: u32, first: u32) -> vec4f {
    let near = first + N_VALUES_OF_ENTRY * at.low[axis];
    return mix(stored_quad(near), stored_quad(near + N_VALUES_OF_ENTRY), at.fraction[axis]);
}
