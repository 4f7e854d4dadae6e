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

// Sixteen outputs of a column.
struct Sums {
    a: vec4f,
    b: vec4f,
    c: vec4f,
    d: vec4f,
}

fn sums_with(sums: Sums, i: u32, block: u32, column: u32, apart: u32) -> Sums {
    let x = rows[(shape.read + i) * apart + column];
    let row = shape.matrix + i * (shape.n_out / 4u) + 4u * block;
    return Sums(
        sums.a + x * matrices[row],
        sums.b + x * matrices[row + 1u],
        sums.c + x * matrices[row + 2u],
        sums.d + x * matrices[row + 3u],
    );
}

fn write_one(number: u32, column: u32, apart: u32, sum: f32) {
    var value = sum;
    if shape.mode == 1u {
        value = max(value, 0.0f);
    }
    if shape.mode == 2u {
        let is_open = rows[(shape.mask + number) * apart + column] > 0.0f;
        value = select(0.0f, value, is_open);
    }
    rows[(shape.write + number) * apart + column] = value;
}

fn write_four(number: u32, column: u32, apart: u32, values: vec4f) {
    write_one(number, column, apart, values.x);
    write_one(number + 1u, column, apart, values.y);
    write_one(number + 2u, column, apart, values.z);
    write_one(number + 3u, column, apart, values.w);
}

fn dense(column: u32, block: u32, apart: u32) {
    var sums: Sums;
    if shape.bias != NONE {
        let at = shape.bias + 4u * block;
        sums = Sums(matrices[at], matrices[at + 1u], matrices[at + 2u], matrices[at + 3u]);
    }
    // Four at a time: compilers that check loops do not write them out.
    let whole = shape.n_in & ~3u;
    for (var i = 0u; i < whole; i += 4u) {
        sums = sums_with(sums, i, block, column, apart);
        sums = sums_with(sums, i + 1u, block, column, apart);
        sums = sums_with(sums, i + 2u, block, column, apart);
        sums = sums_with(sums, i + 3u, block, column, apart);
    }
    for (var i = whole; i < shape.n_in; i++) {
        sums = sums_with(sums, i, block, column, apart);
    }
    write_four(16u * block, column, apart, sums.a);
    write_four(16u * block + 4u, column, apart, sums.b);
    write_four(16u * block + 8u, column, apart, sums.c);
    write_four(16u * block + 12u, column, apart, sums.d);
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
    // First rows, and how many: what was read, and gradients.
    a: u32,
    n_a: u32,
    b: u32,
    n_b: u32,
    // Where its gradients begin: weights, then the bias.
    weights: u32,
    bias: u32,
}

@group(0) @binding(24) var<uniform> product_of: Product;
// `[part][tile of b][tile of a][65][64]`: the last row is that of the bias.
@group(0) @binding(25) var<storage, read_write> partial: array<f32>;
@group(0) @binding(26) var<storage, read_write> gradient: array<f32>;

const PARTS_OF_COLUMNS = 256u;
const TILE = 64u;
const DEPTH = 16u;
var<workgroup> tile_a: array<vec4f, 256>;
var<workgroup> tile_b: array<vec4f, 256>;

fn read_a(row: u32, column: u32, n: vec2u) -> f32 {
    if column >= n.x || row >= product_of.n_a {
        return 0.0f;
    }
    return rows_read[(product_of.a + row) * n.y + column];
}

fn read_b(row: u32, column: u32, n: vec2u) -> f32 {
    if column >= n.x || row >= product_of.n_b {
        return 0.0f;
    }
    return rows_read[(product_of.b + row) * n.y + column];
}

fn four_of_a(row: u32, column: u32, n: vec2u) -> vec4f {
    return vec4f(
        read_a(row, column, n),
        read_a(row + 1u, column, n),
        read_a(row + 2u, column, n),
        read_a(row + 3u, column, n),
    );
}

fn four_of_b(row: u32, column: u32, n: vec2u) -> vec4f {
    return vec4f(
        read_b(row, column, n),
        read_b(row + 1u, column, n),
        read_b(row + 2u, column, n),
        read_b(row + 3u, column, n),
    );
}

// Values of a tile.
const PER_TILE = TILE * TILE + TILE;

fn outer(group: vec3u, tiles: vec3u, own: u32, n: vec2u) {
    let part = (n.x + PARTS_OF_COLUMNS - 1u) / PARTS_OF_COLUMNS;
    let first = group.x * part;
    let end = vec2u(min(first + part, n.x), n.y);
    let i = own % 16u;
    let j = own / 16u;
    // Four rows of a column a time: `[column][rows]`.
    let a_row = group.y * TILE + 4u * j;
    let b_row = group.z * TILE + 4u * j;
    var sums: Sums;
    var bias: vec4f;
    var next_a = four_of_a(a_row, first + i, end);
    var next_b = four_of_b(b_row, first + i, end);
    for (var at = first; at < end.x; at += DEPTH) {
        tile_a[i * 16u + j] = next_a;
        tile_b[i * 16u + j] = next_b;
        workgroupBarrier();
        // What comes next is on its way meanwhile.
        next_a = four_of_a(a_row, at + DEPTH + i, end);
        next_b = four_of_b(b_row, at + DEPTH + i, end);
        for (var c = 0u; c < DEPTH; c += 4u) {
            sums = products_with(sums, c, i, j);
            sums = products_with(sums, c + 1u, i, j);
            sums = products_with(sums, c + 2u, i, j);
            sums = products_with(sums, c + 3u, i, j);
        }
        if group.y == 0u && own < 16u {
            for (var c = 0u; c < DEPTH; c++) {
                bias += tile_b[c * 16u + own];
            }
        }
        workgroupBarrier();
    }
    let tile = (group.x * tiles.z + group.z) * tiles.y + group.y;
    let to = tile * PER_TILE + 4u * i * TILE + 4u * j;
    write_partial(to, sums.a);
    write_partial(to + TILE, sums.b);
    write_partial(to + 2u * TILE, sums.c);
    write_partial(to + 3u * TILE, sums.d);
    if group.y == 0u && own < 16u {
        write_partial(tile * PER_TILE + TILE * TILE + 4u * own, bias);
    }
}

fn write_partial(at: u32, values: vec4f) {
    partial[at] = values.x;
    partial[at + 1u] = values.y;
    partial[at + 2u] = values.z;
    partial[at + 3u] = values.w;
}

// Four rows of `a` by four of `b`, of a column of the tiles.
fn products_with(sums: Sums, column: u32, i: u32, j: u32) -> Sums {
    let a = tile_a[column * 16u + i];
    let b = tile_b[column * 16u + j];
    return Sums(sums.a + a.x * b, sums.b + a.y * b, sums.c + a.z * b, sums.d + a.w * b);
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
    let tiles_a = (p.n_a + TILE - 1u) / TILE;
    let tiles_b = (p.n_b + TILE - 1u) / TILE;
    // The tile and the row in it; the bias stands in the first.
    let place = select(vec2u(a / TILE, a % TILE), vec2u(0u, TILE), a == p.n_a);
    let each = PARTS_OF_COLUMNS / SHARES;
    var sum = 0.0f;
    if a <= p.n_a {
        for (var part = own.y * each; part < (own.y + 1u) * each; part++) {
            let tile = (part * tiles_b + b / TILE) * tiles_a + place.x;
            sum += partial[tile * PER_TILE + place.y * TILE + b % TILE];
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
