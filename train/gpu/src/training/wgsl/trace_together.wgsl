// Forwards, by workgroups: `SLOTS` rays at a time, whose samples are evaluated together, four
// invocations a ray. A ray that ends makes room for the next.

const INVOCATIONS = 4u * SLOTS;
// Steps across empty cells until those that have found a sample go on.
const PATIENCE = 4u;
const COLUMNS = SLOTS / 4u;

// A column a ray: points, what they are encoded to, what the hidden layer and the network give.
var<workgroup> place: array<vec4f, SLOTS>;
var<workgroup> encoded_rows: array<f32, N_ENCODED * SLOTS>;
var<workgroup> hidden_rows: array<f32, N_HIDDEN * SLOTS>;
var<workgroup> given: array<vec4f, N_GIVEN * SLOTS>;
// Rays that have found a sample, and those that are under way, times 2^16.
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
    t: f32,
    phase: f32,
    is_under_way: bool,
}

@compute @workgroup_size(INVOCATIONS)
fn trace(@builtin(local_invocation_index) own: u32) {
    STEP = frame.detail.z;
    let slot = own % SLOTS;
    let part = own / SLOTS;
    var way: Way;
    var may_come = true;
    loop {
        var has_found = false;
        if part == 0u {
            for (var i = 0u; i < PATIENCE && !has_found; i++) {
                if !way.is_under_way {
                    if !may_come {
                        break;
                    }
                    may_come = begin(&way);
                    if !may_come {
                        break;
                    }
                }
                PHASE = way.phase;
                has_found = seek(&way, slot);
                if !way.is_under_way {
                    note_ray(way.r, way.sum);
                }
            }
            let under_way = select(0u, 0x10000u, way.is_under_way || may_come);
            atomicAdd(&seen, under_way | select(0u, 1u, has_found));
        }
        workgroupBarrier();
        if own == 0u {
            status = atomicExchange(&seen, 0u);
        }
        let all = workgroupUniformLoad(&status);
        if all == 0u {
            break;
        }
        if (all & 0xffffu) != 0u {
            encode_part(slot, part);
            workgroupBarrier();
            hide(own);
            workgroupBarrier();
            give(slot, part);
            workgroupBarrier();
            if has_found {
                add(&way, slot);
                if !way.is_under_way {
                    note_ray(way.r, way.sum);
                }
            }
        }
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

// One step on; true at an occupied cell.
fn seek(way: ptr<function, Way>, slot: u32) -> bool {
    if !((*way).k < (*way).end) {
        (*way).k = (*way).end;
        if (*way).local.is_there {
            var local = (*way).local;
            (*way).end = turn(&local, (*way).k);
            (*way).local = local;
        }
        if !((*way).k < (*way).end) {
            (*way).is_under_way = false;
            return false;
        }
        (*way).across = stride((*way).local.ray);
    }
    let ray = (*way).local.ray;
    let t = distance_of(min((*way).k + ((*way).steps - 1.0f) * 0.5f, (*way).end - 1.0f));
    let u = unit(ray.origin + t * ray.direction);
    let cells = around(u);
    if !cells.is_occupied {
        (*way).k += steps_to_leave(ray, (*way).across, u, cells, t);
        return false;
    }
    if (*way).sum.count % CHUNK == 0u {
        let chunk = new_chunk((*way).sum.last);
        if chunk == NONE {
            (*way).is_under_way = false;
            return false;
        }
        (*way).sum.last = chunk;
    }
    (*way).t = t;
    place[slot] = vec4f(u, 0.0f);
    return true;
}

// Encodes the point of a ray, every fourth level.
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

// The hidden layer: blocks of four values and four rays.
fn hide(own: u32) {
    for (var block = own; block < N_HIDDEN / 4u * COLUMNS; block += INVOCATIONS) {
        let quad = block / COLUMNS;
        let first = 4u * (block % COLUMNS);
        let sums = hidden_sums(quad, first);
        let at = 4u * quad * SLOTS + first;
        write_hidden(at, sums[0]);
        write_hidden(at + 1u, sums[1]);
        write_hidden(at + 2u, sums[2]);
        write_hidden(at + 3u, sums[3]);
    }
}

// The output layer: every fourth quad of a ray.
fn give(slot: u32, part: u32) {
    for (var quad = part; quad < N_GIVEN; quad += 4u) {
        given[quad * SLOTS + slot] = given_sum(quad, slot);
    }
}

// What the network has given of a ray's sample: the density comes before the features.
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

// Adds the sample that was found.
fn add(way: ptr<function, Way>, slot: u32) {
    var sum = (*way).sum;
    add_sample(&sum, point_of(slot), place[slot].xyz, (*way).t, (*way).steps);
    (*way).sum = sum;
    (*way).k += (*way).steps;
    (*way).steps = steps_at(sum.transmittance);
    if is_opaque(sum.transmittance) {
        (*way).is_under_way = false;
    }
}
