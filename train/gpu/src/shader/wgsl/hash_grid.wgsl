// Multiresolution hash grid (Müller et al. 2022, section 3), trilinear.

struct Level {
    // Cells along a unit length, and where u = 0 lies.
    scale: f32,
    shift: f32,
    // Blocks or corners along an axis where the level is dense, else 0.
    side: u32,
    // Entries of the table.
    entries: u32,
    // The first value of the table.
    first: u32,
    // What stored values are multiplied by.
    factor: f32,
}

fn hash(c: vec3u, side: u32) -> u32 {
    if side != 0u {
        return c.x + side * (c.y + side * c.z);
    }
    return c.x ^ (c.y * 2654435761u) ^ (c.z * 805459861u);
}

// The number of the entry of corner `c`.
fn entry(level: Level, c: vec3u) -> u32 {
    if BY_CORNER {
        return hash(c, level.side) % level.entries;
    }
    let low = c & vec3u(1u);
    let block = hash(c / 2u, level.side) % (level.entries / 8u);
    return 8u * block + low.x + 2u * low.y + 4u * low.z;
}

// A point in a level: a corner and how far it is to the next.
struct Position {
    corner: vec3u,
    fraction: vec3f,
}

fn position(level: Level, u: vec3f) -> Position {
    let p = clamp(u, vec3f(), vec3f(1.0f)) * level.scale + level.shift;
    return Position(vec3u(p), fract(p));
}

fn corner_weight(at: Position, number: u32) -> f32 {
    let is_far = (vec3u(number) & vec3u(1u, 2u, 4u)) != vec3u();
    let w = select(1.0f - at.fraction, at.fraction, is_far);
    return w.x * w.y * w.z;
}

fn corner(at: Position, number: u32) -> vec3u {
    return at.corner + ((vec3u(number) >> vec3u(0u, 1u, 2u)) & vec3u(1u));
}

// Value `f` of an entry, interpolated.
fn single(level: Level, at: Position, f: u32) -> f32 {
    var sum = 0.0f;
    for (var i = 0u; i < times(8u); i++) {
        let number = level.first + N_FEATURES * entry(level, corner(at, i)) + f;
        sum += corner_weight(at, i) * stored(number);
    }
    return sum * level.factor;
}

// The part of corner `number` in values `f` to `f + 3`.
fn part(level: Level, at: Position, f: u32, number: u32) -> vec4f {
    let first = level.first + N_FEATURES * entry(level, corner(at, number)) + f;
    return corner_weight(at, number) * stored_quad(first);
}

// Values `f` to `f + 3`.
fn quad(level: Level, at: Position, f: u32) -> vec4f {
    var sum = part(level, at, f, 0u);
    sum += part(level, at, f, 1u);
    sum += part(level, at, f, 2u);
    sum += part(level, at, f, 3u);
    sum += part(level, at, f, 4u);
    sum += part(level, at, f, 5u);
    sum += part(level, at, f, 6u);
    sum += part(level, at, f, 7u);
    return sum * level.factor;
}
