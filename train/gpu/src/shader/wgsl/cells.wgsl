// The cells that may hold something.

const EMPTY = 0x80000000u;
const BLOCKS = RESOLUTION / 8u;

struct Around {
    is_occupied: bool,
    // The cube of cells that are alike: smallest corner and side, in cells.
    corner: vec3f,
    side: f32,
}

fn around(u: vec3f) -> Around {
    let cell = vec3u(clamp(floor(u * f32(RESOLUTION)), vec3f(), vec3f(f32(RESOLUTION))));
    if any(cell >= vec3u(RESOLUTION)) {
        return Around(false, vec3f(cell), 1.0f);
    }
    let b = cell / 8u;
    let block = occupancy[b.x + BLOCKS * (b.y + BLOCKS * b.z)];
    if (block & EMPTY) != 0u {
        let side = block & ~EMPTY;
        return Around(false, vec3f(cell & vec3u(~(side - 1u))), f32(side));
    }
    let place = cell & vec3u(7u);
    let bit = place.x + 8u * place.y + 64u * place.z;
    let bits = occupancy[BLOCKS * BLOCKS * BLOCKS + 16u * block + bit / 32u];
    return Around(((bits >> (bit & 31u)) & 1u) != 0u, vec3f(cell), 1.0f);
}
