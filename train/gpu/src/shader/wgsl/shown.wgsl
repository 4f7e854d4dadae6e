// A picture as screens and image files want it: bytes of sRGB over a background.

struct Display {
    // 1 where colours are linear.
    background: vec4f,
    // Pixels, and samples that one may have.
    pixels: vec4u,
}

@group(0) @binding(0) var<uniform> display: Display;
@group(0) @binding(1) var<storage, read> colors: array<vec4f>;
@group(0) @binding(2) var<storage, read> distances: array<vec2u>;
// Samples of the pixel with most, where these are too many; then the pixels.
@group(0) @binding(3) var<storage, read_write> most: atomic<u32>;
@group(0) @binding(4) var<storage, read_write> bytes: array<u32>;

fn encoded(x: vec3f) -> vec3f {
    let curve = 1.055f * exp(log(max(x, vec3f(1e-6f))) / 2.4f) - 0.055f;
    return select(curve, 12.92f * x, x <= vec3f(0.0031308f));
}

@compute @workgroup_size(256)
fn show(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= display.pixels.x {
        return;
    }
    let color = colors[id.x];
    var rgb = color.xyz + (1.0f - color.w) * display.background.xyz;
    if display.background.w != 0.0f {
        rgb = encoded(rgb);
    }
    let all = vec4u(clamp(vec4f(rgb, color.w), vec4f(), vec4f(1.0f)) * 255.0f + 0.5f);
    bytes[id.x] = all.x | (all.y << 8u) | (all.z << 16u) | (all.w << 24u);
    let samples = distances[id.x].y;
    if samples > display.pixels.y {
        atomicMax(&most, samples);
    }
}
