// A pixel's ray, and what it sees.

struct Seen {
    // Premultiplied, and opacity.
    color: vec4f,
    // Scene units; negative where nothing is seen.
    depth: f32,
    samples: u32,
}

// Of all pixels of a dispatch.
struct Frame {
    // Columns of the camera-to-world matrix.
    right: vec4f,
    up: vec4f,
    back: vec4f,
    position: vec4f,
    // Focal lengths, then the principal point, pixels.
    lens: vec4f,
    // Where the camera looks.
    axis: vec4f,
    // Least light that passes, and below how much samples stand for two steps.
    detail: vec4f,
    // Width of the picture, first row and number of rows of the dispatch; 1 where rays are given,
    // and 2 where pixels have the numbers that they have in the picture.
    rows: vec4u,
    // 1.
    once: vec4u,
}

@group(0) @binding(0) var<uniform> frame: Frame;
// Rows of matrices, four columns at a time.
@group(0) @binding(1) var<storage, read> weights: array<vec4f>;
// Hash tables, as they are stored.
@group(0) @binding(2) var<storage, read> tables: array<u32>;
// Blocks of cells, then the cells of those that are not empty.
@group(0) @binding(3) var<storage, read> occupancy: array<u32>;
// Six numbers a pixel, where rays are given.
@group(0) @binding(4) var<storage, read> rays: array<f32>;
@group(0) @binding(5) var<storage, read_write> colors: array<vec4f>;
// Depth as bits, samples.
@group(0) @binding(6) var<storage, read_write> distances: array<vec2u>;

fn weight(row: u32) -> vec4f {
    return weights[row];
}

const NOTHING = Seen(vec4f(), -1.0f, 0u);

fn pixel_ray(x: u32, y: u32, number: u32) -> Ray {
    if (frame.rows.w & 1u) != 0u {
        let at = 6u * number;
        return Ray(
            vec3f(rays[at], rays[at + 1u], rays[at + 2u]),
            vec3f(rays[at + 3u], rays[at + 4u], rays[at + 5u]),
        );
    }
    let p = (vec2f(f32(x), f32(y)) + 0.5f - frame.lens.zw) / frame.lens.xy;
    let d = frame.right.xyz * p.x - frame.up.xyz * p.y - frame.back.xyz;
    return Ray(frame.position.xyz, normalize(d));
}

fn is_there(id: vec3u) -> bool {
    return id.x < frame.rows.x && id.y < frame.rows.z;
}

fn number_of(id: vec3u) -> u32 {
    let y = select(id.y, id.y + frame.rows.y, (frame.rows.w & 2u) != 0u);
    return y * frame.rows.x + id.x;
}

// Nothing, where they are none.
fn numbers_of(c: vec4f) -> vec4f {
    let are_finite = is_finite(c.x) && is_finite(c.y) && is_finite(c.z) && is_finite(c.w);
    return select(vec4f(), c, are_finite);
}

@compute @workgroup_size(8, 8)
fn render(@builtin(global_invocation_id) id: vec3u) {
    if !is_there(id) {
        return;
    }
    let number = number_of(id);
    let seen = trace(pixel_ray(id.x, id.y + frame.rows.y, number));
    colors[number] = numbers_of(seen.color);
    distances[number] = vec2u(bitcast<u32>(seen.depth), seen.samples);
    if seen.color.w > 0.0f {
        keep(number);
    }
}
