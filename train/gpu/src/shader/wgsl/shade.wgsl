// The colours of a workgroup's rays are computed together, half of the rays at a time: an
// invocation computes a few outputs of four rays, so that a weight is read once for four.

const RAYS = 32u;

// What rays have added up, behind one another.
@group(0) @binding(7) var<storage, read_write> means: array<vec4f>;

// Quad q of ray r: number RAYS * q + r.
var<workgroup> values: array<vec4f, N_VALUES>;
// A bit a half that sees anything.
var<workgroup> are_seen: atomic<u32>;
var<workgroup> are_computed: u32;

var<private> kept: Channels;

fn ray_color(mean: Channels, direction: vec3f) -> vec3f {
    kept = mean;
    // Until it has one.
    return vec3f(1.0f);
}

@compute @workgroup_size(8, 8)
fn shade(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) place: u32) {
    let half = place / RAYS;
    let ray = place % RAYS;
    let number = number_of(id);
    var color = vec4f();
    if is_there(id) {
        color = colors[number];
    }
    let is_seen = color.w > 0.0f;
    if place == 0u {
        atomicStore(&are_seen, 0u);
    }
    workgroupBarrier();
    if is_seen {
        atomicOr(&are_seen, 1u << half);
    }
    workgroupBarrier();
    if place == 0u {
        are_computed = atomicLoad(&are_seen);
    }
    let halves = workgroupUniformLoad(&are_computed);
    for (var h = 0u; h < 2u; h++) {
        if ((halves >> h) & 1u) == 0u {
            continue;
        }
        if half == h && is_seen {
            let around = harmonics(pixel_ray(id.x, id.y + frame.rows.y, number).direction);
            for (var i = 0u; i < N_FEATURE_QUADS; i++) {
                values[RAYS * i + ray] = means[N_MEAN * number + i];
            }
            for (var i = 0u; i < N_HARMONICS; i++) {
                values[RAYS * (N_FEATURE_QUADS + i) + ray] = around[i];
            }
        }
        workgroupBarrier();
        color_layers(place % 8u, place / 8u);
        if half == h && is_seen {
            var sum = vec4f();
            for (var g = 0u; g < 8u; g++) {
                sum += values[RAYS * g + ray];
            }
            colors[number] = numbers_of(vec4f(color.xyz * logistic(sum), color.w));
        }
        workgroupBarrier();
    }
}
