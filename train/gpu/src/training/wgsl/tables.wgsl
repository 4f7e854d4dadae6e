// Hash tables: gradients of encoded points to those of entries, Adam, and rounding to eight bits.
//
// Gradients of entries are sums of whole numbers, which are the same in any order. A level's unit
// is so small that they hold what matters, and so large that no sum overflows: the magnitudes of
// all gradients together are at most 2^29 units.

struct Table {
    level: Level,
    // Its first parameter and their number.
    start: u32,
    n: u32,
}

// Exponent of the unit of stored values, and units of a step.
struct Scale {
    exponent: i32,
    step: i32,
}

@group(0) @binding(30) var<storage, read> table_of: array<Table>;
@group(0) @binding(31) var<storage, read_write> units: array<f32>;
@group(0) @binding(32) var<storage, read_write> entry_gradients: array<atomic<i32>>;
@group(0) @binding(33) var<storage, read_write> parameters: array<f32>;
@group(0) @binding(34) var<storage, read_write> squares: array<f32>;
// Bits of the largest magnitude of each level.
@group(0) @binding(35) var<storage, read_write> largest_of: array<atomic<u32>>;
@group(0) @binding(36) var<storage, read_write> scales: array<Scale>;
@group(0) @binding(37) var<storage, read_write> new_factors: array<f32>;
@group(0) @binding(38) var<storage, read_write> new_tables: array<u32>;
@group(0) @binding(39) var<storage, read_write> averaged: array<f32>;

const SUMMERS = 256u;
// Parts of the samples that have sums of their own.
const UNIT_PARTS = 64u;
var<workgroup> magnitudes: array<vec4f, SUMMERS>;
// Of each level, the sums of each part.
@group(0) @binding(42) var<storage, read_write> unit_parts: array<vec4f>;

// 2^`exponent` of a normal number.
fn power_of_two(exponent: i32) -> f32 {
    return bitcast<f32>(u32(clamp(exponent, -126, 127) + 127) << 23u);
}

// Sums of magnitudes of a part of the samples, four features apart.
@compute @workgroup_size(SUMMERS)
fn sum_units(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) own: u32) {
    let apart = frame.sizes.y;
    var sum = vec4f();
    for (var s = group.x * SUMMERS + own; s < counted[KEPT]; s += SUMMERS * UNIT_PARTS) {
        for (var f = 0u; f < N_FEATURES; f++) {
            let d = sample_rows[(ENCODED_BACK + group.y * N_FEATURES + f) * apart + s];
            sum[f % 4u] += abs(d);
        }
    }
    magnitudes[own] = sum;
    workgroupBarrier();
    for (var half = SUMMERS / 2u; half > 0u; half /= 2u) {
        if own < half {
            magnitudes[own] += magnitudes[own + half];
        }
        workgroupBarrier();
    }
    if own == 0u {
        unit_parts[group.y * UNIT_PARTS + group.x] = magnitudes[0];
    }
}

// The unit of each level's gradients; 0 where they are not finite.
@compute @workgroup_size(16)
fn find_units(@builtin(local_invocation_index) l: u32) {
    if l >= arrayLength(&units) {
        return;
    }
    var all = vec4f();
    for (var part = 0u; part < UNIT_PARTS; part++) {
        all += unit_parts[l * UNIT_PARTS + part];
    }
    let most = max(max(all.x, all.y), max(all.z, all.w));
    if !(is_finite(all.x) && is_finite(all.y) && is_finite(all.z) && is_finite(all.w)) {
        units[l] = 0.0f;
        return;
    }
    // The exponent of the power of two above it.
    let exponent = i32(bitcast<u32>(most) >> 23u) - 126;
    units[l] = power_of_two(exponent - 29);
}

// An invocation a feature of a corner of a sample.
@compute @workgroup_size(256)
fn scatter(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) own: u32,
) {
    let table = table_of[group.y];
    let unit = units[group.y];
    let apart = frame.sizes.y;
    let n = counted[KEPT] * 8u * N_FEATURES;
    // A step that did not fit into its memory is lost.
    if unit == 0.0f || counted[TOO_MANY] != 0u {
        return;
    }
    for (var i = group.x * 256u + own; i < n; i += 256u * groups.x) {
        let s = i / (8u * N_FEATURES);
        let number = (i / N_FEATURES) % 8u;
        let f = i % N_FEATURES;
        let u = vec3f(sample_rows[s], sample_rows[apart + s], sample_rows[2u * apart + s]);
        let d = sample_rows[(ENCODED_BACK + group.y * N_FEATURES + f) * apart + s];
        let at = position(table.level, u);
        let value = i32(round(corner_weight(at, number) * d / unit));
        if value != 0 {
            let to = table.start + N_FEATURES * entry(table.level, corner(at, number)) + f;
            atomicAdd(&entry_gradients[to], value);
        }
    }
}

// Values that are left alone only together: `trainer::optim::adam`.
const BLOCK = 16u;

// Adam without momentum.
@compute @workgroup_size(64)
fn adam(@builtin(global_invocation_id) id: vec3u) {
    let table = table_of[id.y];
    let first = BLOCK * id.x;
    if first >= table.n {
        return;
    }
    let unit = units[id.y];
    let last = min(first + BLOCK, table.n);
    if atomicLoad(&counters[TOO_MANY]) != 0u {
        return;
    }
    if unit == 0.0f {
        atomicStore(&counters[NOT_FINITE], 1u);
        return;
    }
    var any = 0;
    var found: array<i32, BLOCK>;
    for (var i = first; i < last; i++) {
        found[i - first] = atomicLoad(&entry_gradients[table.start + i]);
        any |= found[i - first];
    }
    if any == 0 {
        return;
    }
    var most = 0.0f;
    for (var i = first; i < last; i++) {
        let at = table.start + i;
        let g = f32(found[i - first]) * unit;
        var square = squares[at];
        square += (g * g - square) * frame.adam.z;
        let change = g / (sqrt(square) + frame.adam.w);
        let value = frame.adam.y * parameters[at] - frame.adam.x * change;
        if !is_finite(value) {
            atomicStore(&counters[NOT_FINITE], 1u);
        }
        squares[at] = square;
        parameters[at] = value;
        atomicStore(&entry_gradients[at], 0);
        most = max(most, abs(value));
    }
    let bits = bitcast<u32>(most);
    if bits > atomicLoad(&largest_of[id.y]) {
        atomicMax(&largest_of[id.y], bits);
    }
}

// Units become as large as what they have to hold needs: `field::rounding`.
@compute @workgroup_size(16)
fn hold_all(@builtin(local_invocation_index) l: u32) {
    if l >= arrayLength(&scales) {
        return;
    }
    var scale = scales[l];
    let most = bitcast<f32>(atomicLoad(&largest_of[l]));
    while most > 127.0f * power_of_two(scale.exponent) && scale.exponent < COARSEST {
        scale.exponent += 1;
        scale.step = (scale.step + 1) / 2;
    }
    scales[l] = scale;
    new_factors[l] = power_of_two(scale.exponent);
}

const DEAD_ZONE = 0.62f;

fn rounded(value: f32, scale: Scale) -> u32 {
    let scaled = value * power_of_two(-scale.exponent);
    var whole = round(clamp(scaled, -127.0f, 127.0f));
    if scale.step > 1 {
        let step = f32(scale.step);
        let most = floor(127.0f / step);
        let steps = clamp(scaled * (1.0f / step), -most, most);
        whole = select(round(steps) * step, 0.0f, abs(steps) < DEAD_ZONE);
    }
    return u32(i32(whole)) & 255u;
}

// An invocation a word of four values.
@compute @workgroup_size(64)
fn round_all(@builtin(global_invocation_id) id: vec3u) {
    let table = table_of[id.y];
    if 4u * id.x >= table.n {
        return;
    }
    let scale = scales[id.y];
    let at = table.start + 4u * id.x;
    var word = 0u;
    for (var i = 0u; i < 4u; i++) {
        word |= rounded(parameters[at + i], scale) << (8u * i);
    }
    new_tables[at / 4u] = word;
}

// Adds the parameters to their sums.
@compute @workgroup_size(64)
fn accumulate(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    for (var i = id.x; i < arrayLength(&averaged); i += 64u * groups.x) {
        averaged[i] += parameters[i];
    }
}
