// Forwards, by workgroups: `SLOTS` rays at a time, whose samples are evaluated together, four
// invocations a column. A ray that ends makes room for the next; where none is left, those that go on
// have several columns each, of samples that lie behind one another.

const INVOCATIONS = 4u * SLOTS;
// Steps across empty cells until those that have found a sample go on.
const PATIENCE = 4u;
const COLUMNS = SLOTS / 4u;
// Samples of a ray at a time at most: their columns are noted in so many times five bits.
const MOST_AHEAD = 6u;

// A column a sample: point and distance, step, what it is encoded to, what the hidden layer and the
// network give.
var<workgroup> place: array<vec4f, SLOTS>;
var<workgroup> step_of: array<f32, SLOTS>;
var<workgroup> encoded_rows: array<f32, N_ENCODED * SLOTS>;
var<workgroup> hidden_rows: array<f32, N_HIDDEN * SLOTS>;
var<workgroup> given: array<vec4f, N_GIVEN * SLOTS>;
// Columns that are taken, and rays that are under way, times 2^16.
var<workgroup> seen: atomic<u32>;
var<workgroup> status: u32;

// A ray on its way.
struct Way {
    r: u32,
    ray: Ray,
    local: Local,
    across: Stride,
    k: f32,
    end: f32,
    steps: f32,
    sum: Sum,
    phase: f32,
    is_under_way: bool,
    // How many samples it has found, and their columns.
    found: u32,
    columns: u32,
}

@compute @workgroup_size(INVOCATIONS)
fn trace(@builtin(local_invocation_index) own: u32) {
    STEP = frame.detail.z;
    let slot = own % SLOTS;
    let part = own / SLOTS;
    var way: Way;
    var may_come = true;
    var ahead = 1u;
    loop {
        if part == 0u {
            way.found = 0u;
            way.columns = 0u;
            let patience = PATIENCE + 2u * (ahead - 1u);
            for (var i = 0u; i < patience && way.found < ahead; i++) {
                if !way.is_under_way {
                    if !may_come {
                        break;
                    }
                    may_come = begin(&way);
                    if !may_come {
                        break;
                    }
                }
                if way.found > 0u && !(way.k < way.end) {
                    // What comes there may be another piece: not before these are added.
                    break;
                }
                PHASE = way.phase;
                seek(&way);
                if !way.is_under_way {
                    note_ray(way.r, way.sum);
                }
            }
            atomicAdd(&seen, select(0u, 0x10000u, way.is_under_way || may_come));
        }
        workgroupBarrier();
        if own == 0u {
            status = atomicExchange(&seen, 0u);
        }
        let all = workgroupUniformLoad(&status);
        if all == 0u {
            break;
        }
        let n = all & 0xffffu;
        if n != 0u {
            if slot < n {
                encode_part(slot, part);
            }
            workgroupBarrier();
            hide(own, n);
            workgroupBarrier();
            if slot < n {
                give(slot, part);
            }
            workgroupBarrier();
            if way.found > 0u {
                add(&way);
                if !way.is_under_way {
                    note_ray(way.r, way.sum);
                }
            }
            // Columns are anybody's again.
            workgroupBarrier();
        }
        ahead = clamp(SLOTS / max(all >> 16u, 1u), 1u, MOST_AHEAD);
    }
}

// Takes the next ray; false where there is none.
fn begin(way: ptr<function, Way>) -> bool {
    let r = atomicAdd(&counters[NEXT_RAY], 1u);
    if r >= frame.once.y {
        return false;
    }
    let start = rays[4u * r];
    let ray = Ray(start.xyz, rays[4u * r + 1u].xyz);
    PHASE = start.w;
    (*way).r = r;
    (*way).ray = ray;
    (*way).local = to_local(ray);
    (*way).phase = start.w;
    (*way).steps = 1.0f;
    (*way).sum = NOTHING;
    (*way).k = 0.0f;
    (*way).end = 0.0f;
    if (*way).local.is_there {
        let first = first_steps((*way).local);
        (*way).k = first.x;
        (*way).end = first.y;
        (*way).across = stride((*way).local.ray);
    }
    (*way).is_under_way = true;
    return true;
}

// One step on, and a column at an occupied cell.
fn seek(way: ptr<function, Way>) {
    if !((*way).k < (*way).end) {
        (*way).k = (*way).end;
        if (*way).local.is_there {
            var local = (*way).local;
            (*way).end = turn(&local, (*way).k);
            (*way).local = local;
        }
        if !((*way).k < (*way).end) {
            (*way).is_under_way = false;
            return;
        }
        (*way).across = stride((*way).local.ray);
    }
    let ray = (*way).local.ray;
    let k = (*way).k;
    let t = distance_of(min(k + ((*way).steps - 1.0f) * 0.5f, (*way).end - 1.0f));
    let u = unit(ray.origin + t * ray.direction);
    let cells = around(u);
    if !cells.is_occupied {
        (*way).k = k + steps_to_leave(ray, (*way).across, u, cells, t);
        return;
    }
    let column = atomicAdd(&seen, 1u) & 0xffffu;
    place[column] = vec4f(u, t);
    step_of[column] = k;
    (*way).columns |= column << (5u * (*way).found);
    (*way).found += 1u;
    (*way).k = k + (*way).steps;
}

// Encodes the point of a column, every fourth level.
fn encode_part(slot: u32, part: u32) {
    let u = place[slot].xyz;
    for (var l = part; l < N_LEVELS; l += 4u) {
        let values = level_quad(l, u);
        let at = 4u * l * SLOTS + slot;
        encoded_rows[at] = values.x;
        encoded_rows[at + SLOTS] = values.y;
        encoded_rows[at + 2u * SLOTS] = values.z;
        encoded_rows[at + 3u * SLOTS] = values.w;
    }
}

fn write_hidden(at: u32, values: vec4f) {
    let positive = max(values, vec4f());
    hidden_rows[at] = positive.x;
    hidden_rows[at + SLOTS] = positive.y;
    hidden_rows[at + 2u * SLOTS] = positive.z;
    hidden_rows[at + 3u * SLOTS] = positive.w;
}

// The hidden layer of the first `n` columns: blocks of four values and four columns.
fn hide(own: u32, n: u32) {
    for (var block = own; block < N_HIDDEN / 4u * COLUMNS; block += INVOCATIONS) {
        let quad = block / COLUMNS;
        let first = 4u * (block % COLUMNS);
        if first >= n {
            continue;
        }
        let sums = hidden_sums(quad, first);
        let at = 4u * quad * SLOTS + first;
        write_hidden(at, sums[0]);
        write_hidden(at + 1u, sums[1]);
        write_hidden(at + 2u, sums[2]);
        write_hidden(at + 3u, sums[3]);
    }
}

// The output layer: every fourth quad of a column.
fn give(slot: u32, part: u32) {
    for (var quad = part; quad < N_GIVEN; quad += 4u) {
        given[quad * SLOTS + slot] = given_sum(quad, slot);
    }
}

// What the network has given of a sample: the density comes before the features.
fn point_of(slot: u32) -> Point {
    var own = given[slot];
    var point = Point(decoded_sigma(own.x), Channels());
    for (var c = 0u; c < N_CHANNELS; c++) {
        var after = vec4f();
        if c + 1u < N_GIVEN {
            after = given[(c + 1u) * SLOTS + slot];
        }
        point.channels[c] = vec4f(own.yzw, after.x);
        own = after;
    }
    return point;
}

// Adds the samples that were found. Where others would follow them than those that do, these are to be
// found again.
fn add(way: ptr<function, Way>) {
    let steps = (*way).steps;
    var sum = (*way).sum;
    for (var i = 0u; i < (*way).found; i++) {
        if sum.count % CHUNK == 0u {
            let chunk = new_chunk(sum.last);
            if chunk == NONE {
                (*way).is_under_way = false;
                break;
            }
            sum.last = chunk;
        }
        let column = ((*way).columns >> (5u * i)) & 31u;
        let found = place[column];
        add_sample(&sum, point_of(column), found.xyz, found.w, steps);
        if is_opaque(sum.transmittance) {
            (*way).is_under_way = false;
            break;
        }
        let later = steps_at(sum.transmittance);
        if later != steps {
            (*way).k = step_of[column] + steps;
            (*way).steps = later;
            break;
        }
    }
    (*way).sum = sum;
}
