// A training step: what its kernels read and write. Each binds what it uses.

struct Frame {
    // Least light that passes; below how much samples stand for two steps; distance between
    // samples; gradient below which samples are kept by chance.
    detail: vec4f,
    // Learning rate of tables; what a step leaves of an entry; part of the squared gradient that
    // is new; least divisor.
    adam: vec4f,
    // Inverse of the squared distance, unit lengths, from which on samples learn all: 0 everywhere;
    // weight of smooth surfaces.
    slow: vec4f,
    // Learning rate of the networks' matrices, and of all else that Adam leads, corrected; parts of
    // the gradient and of its square that are new.
    follow: vec4f,
    // The number 1; how many rays there are; columns that the colour network is evaluated for: the
    // rays, then directions between cameras; cameras.
    once: vec4u,
    // Distance between two rows of the colour network's values, and of the density network's; room
    // for chunks of samples, and for samples that are passed back.
    sizes: vec4u,
    // Seed; number of the step; flags, `BLUR` and so on; a random number of the step.
    random: vec4u,
}

@group(0) @binding(0) var<uniform> frame: Frame;
// Networks as the renderer has them.
@group(0) @binding(1) var<storage, read> weights: array<vec4f>;
@group(0) @binding(2) var<storage, read> tables: array<u32>;
@group(0) @binding(3) var<storage, read> occupancy: array<u32>;
// What the stored values of each level are multiplied by.
@group(0) @binding(4) var<storage, read> factors: array<f32>;
// Of each ray: origin and phase, direction and weight, which is negative where a row of three
// begins, background and its variance, target and opacity.
@group(0) @binding(5) var<storage, read> rays: array<vec4f>;
// Of each ray, `PER_RAY` quads: its last chunk, its samples, what passes, opacity; depth, gradient
// by the opacity and by the depth; the sums, later the gradient by them.
@group(0) @binding(6) var<storage, read_write> traced: array<vec4f>;
// Of each sample, `PER_SAMPLE` quads: point and weight; light that passes, steps, density, distance; its
// channels. Later: gradients by the density's logarithm and the channels, and whether it is kept.
@group(0) @binding(7) var<storage, read_write> samples: array<vec4f>;
// The chunk of a ray before this one.
@group(0) @binding(8) var<storage, read_write> links: array<u32>;
@group(0) @binding(9) var<storage, read_write> counters: array<atomic<u32>, 8>;
// The same, to be read alone.
@group(0) @binding(10) var<storage, read> counted: array<u32>;
// Rows of the colour network and of the density network, a column a ray and a sample.
@group(0) @binding(11) var<storage, read_write> ray_rows: array<f32>;
@group(0) @binding(12) var<storage, read_write> sample_rows: array<f32>;
// Of each ray: squared error a channel, opacity, gradient of its samples, samples and how many
// of them are kept.
@group(0) @binding(13) var<storage, read_write> results: array<vec4f>;
// Of each ray: samples that are kept. Of the rays of a workgroup: the same, then where they begin.
@group(0) @binding(14) var<storage, read_write> offsets: array<u32>;
@group(0) @binding(16) var<storage, read_write> group_offsets: array<u32>;
@group(0) @binding(15) var<storage, read> cameras: array<vec4f>;

// Samples of a chunk.
const CHUNK = 16u;
const NONE = 0xffffffffu;
const PER_RAY = 2u + N_CHANNELS;
const PER_SAMPLE = 2u + N_CHANNELS;
// Numbers of counters.
const NEXT_CHUNK = 0u;
const TOO_MANY = 1u;
const KEPT = 2u;
const NOT_FINITE = 3u;
const NEXT_RAY = 4u;
// Bits of `frame.random.z`.
const BLUR = 1u;
const BETWEEN = 2u;
const MUON = 4u;
const AVERAGED = 8u;

var<private> STEP: f32;
var<private> PHASE: f32;

fn weight(row: u32) -> vec4f {
    return weights[row];
}

fn chunk_quad(chunk: u32, place: u32) -> u32 {
    return (chunk * CHUNK + place) * PER_SAMPLE;
}

// A new chunk of a ray whose last one is given, or none: then the step is lost, and the next one has more
// memory.
fn new_chunk(last: u32) -> u32 {
    let chunk = atomicAdd(&counters[NEXT_CHUNK], 1u);
    if chunk >= frame.sizes.z {
        atomicStore(&counters[TOO_MANY], 1u);
        return NONE;
    }
    links[chunk] = last;
    return chunk;
}

fn is_opaque(transmittance: f32) -> bool {
    return transmittance < frame.detail.x;
}

// Random numbers of a place (O'Neill 2014, as Jarzynski and Olano 2020 use it).
struct Random {
    state: u32,
}

fn random_at(purpose: u32, place: u32) -> Random {
    let step = mixed(frame.random.x ^ mixed(frame.random.y));
    return Random(mixed(mixed(step ^ purpose) ^ place));
}

fn mixed(value: u32) -> u32 {
    let state = value * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// Uniform in [0, 1).
fn next_random(random: ptr<function, Random>) -> f32 {
    (*random).state = (*random).state * 747796405u + 2891336453u;
    return f32(mixed((*random).state) >> 8u) / 16777216.0f;
}
