// From what rays have accumulated to the inputs of the colour network, a column a ray. Behind them
// come columns of a few rays that are asked for their colours between the cameras: first from a
// direction there, then from the nearest cameras (`trainer::step::between_views`).

// One ray in so many is asked, where it is opaque.
const EVERY = 16u;
// Rays of less opacity meet no surface.
const OPAQUE = 0.9f;
// Directions that are asked of it.
const ASKED = 5u;
const SPAN_MARGIN = 0.1f;
const HELD = 2.0f;

struct Mean {
    features: Channels,
    opacity: f32,
    depth: f32,
}

fn mean_of(r: u32) -> Mean {
    let at = PER_RAY * r;
    let opacity = traced[at].w;
    var mean = Mean(Channels(), opacity, 0.0f);
    if opacity > 0.0f {
        for (var c = 0u; c < N_CHANNELS; c++) {
            mean.features[c] = traced[at + 2u + c] / opacity;
        }
        mean.depth = traced[at + 1u].x / opacity;
    }
    return mean;
}

// The ray that group `g` of asked columns belongs to, or none.
fn asked_ray(g: u32) -> u32 {
    let r = g * EVERY + frame.random.w % EVERY;
    if (frame.random.z & BETWEEN) == 0u || r >= frame.once.y || frame.once.w < FEWEST {
        return NONE;
    }
    return select(NONE, r, traced[PER_RAY * r].w >= OPAQUE);
}

fn write_input(column: u32, features: Channels, direction: vec3f) {
    let apart = frame.sizes.x;
    var own = features;
    for (var f = 0u; f < N_SHADED; f++) {
        ray_rows[f * apart + column] = own[f / 4u][f % 4u];
    }
    var around = harmonics(direction);
    for (var h = 0u; h < N_DIRECTIONS; h++) {
        ray_rows[(N_SHADED + h) * apart + column] = around[h / 4u][h % 4u];
    }
}

@compute @workgroup_size(64)
fn shade(@builtin(global_invocation_id) id: vec3u) {
    let n_rays = frame.once.y;
    if id.x >= n_rays {
        let g = id.x - n_rays;
        if g < (frame.once.z - n_rays) / ASKED {
            ask(g);
        }
        return;
    }
    let mean = mean_of(id.x);
    var direction = rays[4u * id.x + 1u].xyz;
    if (frame.random.z & BLUR) != 0u && mean.opacity > 0.0f {
        var random = random_at(1u, id.x);
        let point = rays[4u * id.x].xyz + mean.depth * direction;
        direction = turned(direction, BLURRED * reach_of(point, direction), &random);
    }
    write_input(id.x, mean.features, direction);
}

// Writes the columns of a ray that is asked.
fn ask(g: u32) {
    let first = frame.once.y + ASKED * g;
    let r = asked_ray(g);
    if r == NONE {
        for (var i = 0u; i < ASKED; i++) {
            write_input(first + i, Channels(), vec3f(0.0f, 0.0f, 1.0f));
        }
        return;
    }
    let mean = mean_of(r);
    let direction = rays[4u * r + 1u].xyz;
    let point = rays[4u * r].xyz + mean.depth * direction;
    var random = random_at(2u, r);
    let between = turned(direction, reach_of(point, direction), &random);
    write_input(first, mean.features, between);
    var around = nearest(point, between);
    for (var i = 1u; i < ASKED; i++) {
        write_input(first + i, mean.features, around[i - 1u].xyz);
    }
}
