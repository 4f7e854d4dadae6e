// Dense layers over rows of columns: forwards, backwards, and the gradient of their weights.

struct Shape {
    // Rows that are read, and written in blocks of sixteen.
    n_in: u32,
    n_out: u32,
    // Where the matrix begins, in quads: a row of `n_out` numbers for each input.
    matrix: u32,
    // Where the bias begins, or none.
    bias: u32,
    // First rows of what is read, written, and of what must be positive.
    read: u32,
    write: u32,
    mask: u32,
    // 0: as it is; 1: nothing below 0; 2: where the mask is positive.
    mode: u32,
}

@group(0) @binding(20) var<uniform> shape: Shape;
@group(0) @binding(21) var<storage, read> matrices: array<vec4f>;
// The rows of rays or of samples.
@group(0) @binding(22) var<storage, read_write> rows: array<f32>;
@group(0) @binding(23) var<storage, read> rows_read: array<f32>;

fn columns_of_rays() -> vec2u {
    return vec2u(frame.once.z, frame.sizes.x);
}

fn columns_of_samples() -> vec2u {
    return vec2u(counted[KEPT], frame.sizes.y);
}

fn dense(column: u32, block: u32, apart: u32) {
    let at = 4u * block;
    var sums: array<vec4f, 4>;
    if shape.bias != NONE {
        for (var q = 0u; q < 4u; q++) {
            sums[q] = matrices[shape.bias + at + q];
        }
    }
    for (var i = 0u; i < shape.n_in; i++) {
        let x = rows[(shape.read + i) * apart + column];
        let row = shape.matrix + i * (shape.n_out / 4u) + at;
        sums[0] += x * matrices[row];
        sums[1] += x * matrices[row + 1u];
        sums[2] += x * matrices[row + 2u];
        sums[3] += x * matrices[row + 3u];
    }
    for (var o = 0u; o < 16u; o++) {
        let number = 16u * block + o;
        var value = sums[o / 4u][o % 4u];
        if shape.mode == 1u {
            value = max(value, 0.0f);
        }
        if shape.mode == 2u {
            let is_open = rows[(shape.mask + number) * apart + column] > 0.0f;
            value = select(0.0f, value, is_open);
        }
        rows[(shape.write + number) * apart + column] = value;
    }
}

@compute @workgroup_size(64)
fn dense_rays(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let n = columns_of_rays();
    for (var c = id.x; c < n.x; c += 64u * groups.x) {
        dense(c, id.y, n.y);
    }
}

@compute @workgroup_size(64)
fn dense_samples(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let n = columns_of_samples();
    for (var c = id.x; c < n.x; c += 64u * groups.x) {
        dense(c, id.y, n.y);
    }
}

// The gradient of a layer's weights: sums over the columns of what it read times the gradient of
// what it gave. Each part of the columns has sums of its own.
struct Product {
    // First rows, and how many: what was read, behind which comes a row of ones for the bias, and
    // gradients.
    a: u32,
    n_a: u32,
    b: u32,
    n_b: u32,
    // Where its gradients begin: weights, then the bias.
    weights: u32,
    bias: u32,
}

@group(0) @binding(24) var<uniform> product_of: Product;
// `[part][tile of b][tile of a][64][64]`.
@group(0) @binding(25) var<storage, read_write> partial: array<f32>;
@group(0) @binding(26) var<storage, read_write> gradient: array<f32>;

const PARTS_OF_COLUMNS = 256u;
const TILE = 64u;
const DEPTH = 16u;
var<workgroup> tile_a: array<vec4f, 256>;
var<workgroup> tile_b: array<vec4f, 256>;

fn read_a(row: u32, column: u32, n: vec2u) -> f32 {
    if column >= n.x || row > product_of.n_a {
        return 0.0f;
    }
    if row == product_of.n_a {
        return 1.0f;
    }
    return rows_read[(product_of.a + row) * n.y + column];
}

fn read_b(row: u32, column: u32, n: vec2u) -> f32 {
    if column >= n.x || row >= product_of.n_b {
        return 0.0f;
    }
    return rows_read[(product_of.b + row) * n.y + column];
}

fn outer(group: vec3u, tiles: vec3u, own: u32, n: vec2u) {
    let part = (n.x + PARTS_OF_COLUMNS - 1u) / PARTS_OF_COLUMNS;
    let first = group.x * part;
    let last = min(first + part, n.x);
    let i = own % 16u;
    let j = own / 16u;
    var sums: array<vec4f, 4>;
    for (var at = first; at < last; at += DEPTH) {
        // Four rows of a column a time: `[column][rows]`.
        let column = at + own % 16u;
        let row = 4u * (own / 16u);
        let is_own = column < last;
        for (var r = 0u; r < 4u; r++) {
            let place = (own % 16u) * 16u + own / 16u;
            tile_a[place][r] = select(0.0f, read_a(group.y * TILE + row + r, column, n), is_own);
            tile_b[place][r] = select(0.0f, read_b(group.z * TILE + row + r, column, n), is_own);
        }
        workgroupBarrier();
        for (var c = 0u; c < DEPTH; c++) {
            let a = tile_a[c * 16u + i];
            let b = tile_b[c * 16u + j];
            sums[0] += a.x * b;
            sums[1] += a.y * b;
            sums[2] += a.z * b;
            sums[3] += a.w * b;
        }
        workgroupBarrier();
    }
    let tile = (group.x * tiles.z + group.z) * tiles.y + group.y;
    for (var r = 0u; r < 4u; r++) {
        for (var c = 0u; c < 4u; c++) {
            partial[tile * TILE * TILE + (4u * i + r) * TILE + 4u * j + c] = sums[r][c];
        }
    }
}

@compute @workgroup_size(256)
fn outer_rays(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) tiles: vec3u,
    @builtin(local_invocation_index) own: u32,
) {
    outer(group, tiles, own, columns_of_rays());
}

@compute @workgroup_size(256)
fn outer_samples(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) tiles: vec3u,
    @builtin(local_invocation_index) own: u32,
) {
    outer(group, tiles, own, columns_of_samples());
}

const SUMS = 32u;
const SHARES = 8u;
var<workgroup> shares: array<f32, SUMS * SHARES>;

// The sums of all parts, always in the same order: those of a share, then those.
@compute @workgroup_size(SUMS, SHARES)
fn reduce(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) own: vec3u) {
    let p = product_of;
    let number = group.x * SUMS + own.x;
    let a = number / p.n_b;
    let b = number % p.n_b;
    let tiles_a = p.n_a / TILE + 1u;
    let tiles_b = (p.n_b + TILE - 1u) / TILE;
    let each = PARTS_OF_COLUMNS / SHARES;
    var sum = 0.0f;
    if a <= p.n_a {
        for (var part = own.y * each; part < (own.y + 1u) * each; part++) {
            let tile = (part * tiles_b + b / TILE) * tiles_a + a / TILE;
            sum += partial[tile * TILE * TILE + (a % TILE) * TILE + b % TILE];
        }
    }
    shares[own.y * SUMS + own.x] = sum;
    workgroupBarrier();
    if own.y == 0u && a <= p.n_a {
        for (var share = 1u; share < SHARES; share++) {
            sum += shares[share * SUMS + own.x];
        }
        gradient[select(p.weights + a * p.n_b + b, p.bias + b, a == p.n_a)] = sum;
    }
}
