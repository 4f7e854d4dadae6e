// How the networks follow their gradient: `trainer::optim::muon` and `trainer::optim::adam`. A
// workgroup takes a matrix or a bias.

// Parameters that follow together: a matrix, row after row, or a bias.
struct Range {
    first: u32,
    rows: u32,
    columns: u32,
    // Where its matrices begin in `scratch`.
    scratch: u32,
}

// A parameter and what is kept of it.
struct Learnt {
    value: f32,
    mean: f32,
    square: f32,
    // Of the values after steps that count in the average.
    sum: f32,
}

@group(0) @binding(43) var<storage, read> ranges: array<Range>;
@group(0) @binding(44) var<storage, read_write> learnt: array<Learnt>;
@group(0) @binding(45) var<storage, read_write> scratch: array<f32>;
// Of each number of a layout: 0 for none, else 1 and the number of its parameter, and `EXACT`.
@group(0) @binding(46) var<storage, read> sources: array<u32>;
@group(0) @binding(47) var<storage, read_write> laid_out: array<f32>;

const FOLLOWERS = 256u;
const EXACT = 0x80000000u;
// See `muon`.
const MOMENTUM = 0.9f;
const MUON_STEP = 0.6f;
const ROUNDS = 5u;
const ROUND = vec3f(3.4445f, -4.775f, 2.0315f);
const FADED = 1e-15f;
const NARROWEST = 8u;

var<workgroup> squared: array<f32, FOLLOWERS>;
var<workgroup> norm: f32;
var<workgroup> is_lost: u32;

// A matrix in `scratch`, row after row.
struct Matrix {
    first: u32,
    rows: u32,
    columns: u32,
}

fn element(m: Matrix, row: u32, column: u32) -> f32 {
    if row >= m.rows || column >= m.columns {
        return 0.0f;
    }
    return scratch[m.first + row * m.columns + column];
}

fn four_rows(m: Matrix, row: u32, column: u32) -> vec4f {
    return vec4f(
        element(m, row, column),
        element(m, row + 1u, column),
        element(m, row + 2u, column),
        element(m, row + 3u, column),
    );
}

// Four values of row `at` from a column on, of a matrix or of what it is turned on its side.
fn four_of(m: Matrix, is_turned: bool, column: u32, at: u32) -> vec4f {
    if is_turned {
        return four_rows(m, column, at);
    }
    return vec4f(
        element(m, at, column),
        element(m, at, column + 1u),
        element(m, at, column + 2u),
        element(m, at, column + 3u),
    );
}

fn write_row(to: Matrix, old: Matrix, row: u32, column: u32, values: vec4f, share: f32) {
    var all = values;
    for (var c = 0u; c < 4u; c++) {
        if row < to.rows && column + c < to.columns {
            let at = row * to.columns + column + c;
            scratch[to.first + at] = all[c] + share * element(old, row, column + c);
        }
    }
}

// `to = factor a b + share old`, where `b` is turned on its side or not.
fn combine(to: Matrix, a: Matrix, b: Matrix, is_turned: bool, old: Matrix, factors: vec2f, own: u32) {
    let i = own % 16u;
    let j = own / 16u;
    for (var row = 0u; row < to.rows; row += TILE) {
        for (var column = 0u; column < to.columns; column += TILE) {
            var sums: Sums;
            var next_a = four_rows(a, row + 4u * j, i);
            var next_b = four_of(b, is_turned, column + 4u * j, i);
            for (var k = 0u; k < a.columns; k += DEPTH) {
                // Four rows of a column a time, as `outer` has them.
                tile_a[i * 16u + j] = next_a;
                tile_b[i * 16u + j] = next_b;
                workgroupBarrier();
                next_a = four_rows(a, row + 4u * j, k + DEPTH + i);
                next_b = four_of(b, is_turned, column + 4u * j, k + DEPTH + i);
                for (var c = 0u; c < DEPTH; c += 4u) {
                    sums = products_with(sums, c, i, j);
                    sums = products_with(sums, c + 1u, i, j);
                    sums = products_with(sums, c + 2u, i, j);
                    sums = products_with(sums, c + 3u, i, j);
                }
                workgroupBarrier();
            }
            let at = row + 4u * i;
            let left = column + 4u * j;
            write_row(to, old, at, left, factors.x * sums.a, factors.y);
            write_row(to, old, at + 1u, left, factors.x * sums.b, factors.y);
            write_row(to, old, at + 2u, left, factors.x * sums.c, factors.y);
            write_row(to, old, at + 3u, left, factors.x * sums.d, factors.y);
        }
    }
    storageBarrier();
    workgroupBarrier();
}

// The sum over a workgroup of one value each, its root.
fn root_of_sum(own: u32, value: f32) -> f32 {
    squared[own] = value;
    workgroupBarrier();
    for (var half = FOLLOWERS / 2u; half > 0u; half /= 2u) {
        if own < half {
            squared[own] += squared[own + half];
        }
        workgroupBarrier();
    }
    if own == 0u {
        norm = sqrt(squared[0]);
    }
    return workgroupUniformLoad(&norm);
}

// Notes a new value of a parameter.
fn follow_to(i: u32, value: f32) {
    if !is_finite(value) {
        atomicStore(&counters[NOT_FINITE], 1u);
    }
    learnt[i].value = value;
}

// A step that is as long in every direction.
fn follow_muon(range: Range, own: u32) {
    let n = range.rows * range.columns;
    let is_high = range.rows > range.columns;
    let rows = min(range.rows, range.columns);
    let columns = max(range.rows, range.columns);
    var x = Matrix(range.scratch, rows, columns);
    var next = Matrix(range.scratch + n, rows, columns);
    let square = Matrix(range.scratch + 2u * n, rows, rows);
    let fourth = Matrix(square.first + rows * rows, rows, rows);
    var sum = 0.0f;
    for (var i = own; i < n; i += FOLLOWERS) {
        let g = gradient[range.first + i];
        var it = learnt[range.first + i];
        it.mean += (g - it.mean) * (1.0f - MOMENTUM);
        it.square += (g * g - it.square) * frame.follow.w;
        learnt[range.first + i] = it;
        // As if the step had been taken already.
        let value = it.mean + (g - it.mean) * (1.0f - MOMENTUM);
        sum += value * value;
        let r = i / range.columns;
        let c = i % range.columns;
        scratch[x.first + select(r * columns + c, c * columns + r, is_high)] = value;
    }
    let size = root_of_sum(own, sum);
    if size < FADED {
        return;
    }
    for (var i = own; i < n; i += FOLLOWERS) {
        let r = i / range.columns;
        let c = i % range.columns;
        scratch[x.first + select(r * columns + c, c * columns + r, is_high)] /= size;
    }
    storageBarrier();
    workgroupBarrier();
    for (var turn = 0u; turn < ROUNDS; turn++) {
        combine(square, x, x, true, x, vec2f(1.0f, 0.0f), own);
        combine(fourth, square, square, false, square, ROUND.zy, own);
        combine(next, fourth, x, false, x, vec2f(1.0f, ROUND.x), own);
        let before = x;
        x = next;
        next = before;
    }
    let length = frame.follow.x * MUON_STEP * sqrt(f32(columns));
    for (var i = own; i < n; i += FOLLOWERS) {
        let r = i / range.columns;
        let c = i % range.columns;
        let at = x.first + select(r * columns + c, c * columns + r, is_high);
        follow_to(range.first + i, learnt[range.first + i].value - length * scratch[at]);
    }
}

// Adam, which leaves alone what received no gradient.
fn follow_adam(range: Range, own: u32) {
    let n = range.rows * range.columns;
    for (var first = BLOCK * own; first < n; first += BLOCK * FOLLOWERS) {
        let last = min(first + BLOCK, n);
        var any = false;
        for (var i = first; i < last; i++) {
            // NaN is something, too.
            any |= !(gradient[range.first + i] == 0.0f);
        }
        for (var i = range.first + first; any && i < range.first + last; i++) {
            let g = gradient[i];
            var it = learnt[i];
            it.mean += (g - it.mean) * frame.follow.z;
            it.square += (g * g - it.square) * frame.follow.w;
            learnt[i] = it;
            let change = it.mean / (sqrt(it.square) + frame.adam.w);
            follow_to(i, it.value - frame.follow.y * change);
        }
    }
}

fn follow_gradient(range: Range, own: u32) {
    let is_wide = min(range.rows, range.columns) >= NARROWEST;
    if is_wide && (frame.random.z & MUON) != 0u {
        follow_muon(range, own);
    } else {
        follow_adam(range, own);
    }
}

@compute @workgroup_size(FOLLOWERS)
fn follow(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) own: u32) {
    if own == 0u {
        is_lost = atomicLoad(&counters[TOO_MANY]);
    }
    let range = ranges[group.x];
    // Nothing is learnt of a step that is lost, which counts in the average like others.
    if workgroupUniformLoad(&is_lost) == 0u {
        follow_gradient(range, own);
    }
    if (frame.random.z & AVERAGED) != 0u {
        storageBarrier();
        workgroupBarrier();
        for (var i = own; i < range.rows * range.columns; i += FOLLOWERS) {
            learnt[range.first + i].sum += learnt[range.first + i].value;
        }
    }
}

// Half precision, in units of 2^-8: `field::rounding::Half`.
fn halved(value: f32) -> f32 {
    let scaled = clamp(value * 256.0f, -65504.0f, 65504.0f);
    if abs(scaled) < 6.103515625e-5f {
        return round(scaled * 16777216.0f) / (16777216.0f * 256.0f);
    }
    let bits = bitcast<u32>(scaled);
    let nearest = (bits + 0xfffu + ((bits >> 13u) & 1u)) & 0xffffe000u;
    return bitcast<f32>(nearest) / 256.0f;
}

// The networks as other kernels read them.
@compute @workgroup_size(64)
fn lay_out(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&sources) {
        return;
    }
    let origin = sources[id.x];
    let number = origin & ~EXACT;
    var value = 0.0f;
    if number != 0u {
        value = learnt[number - 1u].value;
        if (origin & EXACT) == 0u {
            value = halved(value);
        }
    }
    laid_out[id.x] = value;
}
