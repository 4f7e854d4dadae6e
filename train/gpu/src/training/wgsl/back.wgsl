// Backwards: from rays to their samples, back to front, the derivative of the volume rendering sum.
// Small gradients are dropped by chance and the rest enlarged. What is kept stands in the order of
// the rays, however these were traced.

// The share of its gradient that a sample learns from: `trainer::step::slow_below`.
fn share_of(ray: Ray, u: vec3f) -> f32 {
    if frame.slow.x == 0.0f {
        return 1.0f;
    }
    let way = u - unit(local_origin(ray));
    return min(dot(way, way) * frame.slow.x, 1.0f);
}

// Rays of a workgroup.
const GROUP = 64u;
// Samples that a workgroup's rays keep.
var<workgroup> kept_here: atomic<u32>;

@compute @workgroup_size(GROUP)
fn drop(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_index) own: u32,
) {
    if id.x < frame.once.y {
        atomicAdd(&kept_here, dropped(id.x));
    }
    workgroupBarrier();
    if own == 0u {
        group_offsets[group.x] = atomicLoad(&kept_here);
    }
}

// Drops samples of a ray, and gives how many are left.
fn dropped(r: u32) -> u32 {
    let at = PER_RAY * r;
    let count = bitcast<u32>(traced[at].y);
    let opacity = traced[at].w;
    var d_opacity = traced[at + 1u].y;
    let d_depth = traced[at + 1u].z;
    var size = 0.0f;
    var d_sums: Channels;
    if opacity > 0.0f {
        for (var f = 0u; f < N_SHADED; f++) {
            // A feature is a sum by the opacity.
            let d = ray_rows[(COLOR_IN_BACK + f) * frame.sizes.x + r] / opacity;
            d_sums[f / 4u][f % 4u] = d;
            d_opacity -= d * (traced[at + 2u + f / 4u][f % 4u] / opacity);
            size += abs(d);
        }
    }
    for (var c = 0u; c < N_CHANNELS; c++) {
        traced[at + 2u + c] = d_sums[c];
    }
    let ray = Ray(rays[4u * r].xyz, rays[4u * r + 1u].xyz);
    let least = frame.detail.w;
    var random = random_at(3u, r);
    var chunk = bitcast<u32>(traced[at].x);
    var behind = 0.0f;
    var total = 0.0f;
    var kept = 0u;
    for (var i = count; i > 0u; i--) {
        let place = (i - 1u) % CHUNK;
        let own = chunk_quad(chunk, place);
        let point = samples[own];
        let more = samples[own + 1u];
        var d_weight = d_opacity + d_depth * more.w;
        for (var c = 0u; c < N_CHANNELS; c++) {
            d_weight += dot(d_sums[c], samples[own + 2u + c]);
        }
        let d_sigma = frame.detail.z * more.y * (more.x * d_weight - behind);
        behind += point.w * d_weight;
        let share = share_of(ray, point.xyz);
        let log_density = share * d_sigma * more.z;
        let weight = share * point.w;
        let magnitude = abs(log_density) + weight * size;
        total += magnitude;
        var enlarge = 1.0f;
        if magnitude < least {
            enlarge = select(0.0f, least / magnitude, next_random(&random) * least < magnitude);
        }
        samples[own].w = weight * enlarge;
        let is_kept = enlarge != 0.0f;
        samples[own + 1u] = vec4f(log_density * enlarge, select(0.0f, 1.0f, is_kept), 0.0f, 0.0f);
        kept += select(0u, 1u, is_kept);
        if place == 0u {
            chunk = links[chunk];
        }
    }
    offsets[r] = kept;
    results[r].z = total;
    results[r].w = bitcast<f32>(min(count, 0xffffu) | (min(kept, 0xffffu) << 16u));
    return kept;
}

const SCANNERS = 256u;
var<workgroup> sums_before: array<u32, SCANNERS>;
var<workgroup> kept_of: array<u32, GROUP>;

// From how many the rays of each workgroup keep to where they begin.
@compute @workgroup_size(SCANNERS)
fn scan(@builtin(local_invocation_index) own: u32) {
    let n = (frame.once.y + GROUP - 1u) / GROUP;
    let part = (n + SCANNERS - 1u) / SCANNERS;
    let first = min(own * part, n);
    let last = min(first + part, n);
    var sum = 0u;
    for (var g = first; g < last; g++) {
        sum += group_offsets[g];
    }
    let before = sum_before(own, sum);
    if own == SCANNERS - 1u {
        let all = before + sum;
        atomicStore(&counters[KEPT], min(all, frame.sizes.w));
        if all > frame.sizes.w {
            // The step is lost, and the next one has more memory.
            atomicStore(&counters[TOO_MANY], 1u);
        }
    }
    var begin = before;
    for (var g = first; g < last; g++) {
        let next = group_offsets[g];
        group_offsets[g] = begin;
        begin += next;
    }
}

// The sum of the values of a workgroup's invocations before this one.
fn sum_before(own: u32, value: u32) -> u32 {
    var sum = value;
    sums_before[own] = sum;
    workgroupBarrier();
    for (var apart = 1u; apart < SCANNERS; apart *= 2u) {
        var other = 0u;
        if own >= apart {
            other = sums_before[own - apart];
        }
        workgroupBarrier();
        sum += other;
        sums_before[own] = sum;
        workgroupBarrier();
    }
    return sum - value;
}

// Writes the points of what is kept, and the gradients of what the density network gives there.
@compute @workgroup_size(GROUP)
fn gather(
    @builtin(global_invocation_id) id: vec3u,
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_index) own: u32,
) {
    let r = id.x;
    var kept = 0u;
    if r < frame.once.y {
        kept = offsets[r];
    }
    kept_of[own] = kept;
    workgroupBarrier();
    if kept == 0u {
        return;
    }
    var column = group_offsets[group.x];
    for (var i = 0u; i < own; i++) {
        column += kept_of[i];
    }
    let at = PER_RAY * r;
    let count = bitcast<u32>(traced[at].y);
    var chunk = bitcast<u32>(traced[at].x);
    let apart = frame.sizes.y;
    for (var i = count; i > 0u && column < frame.sizes.w; i--) {
        let place = (i - 1u) % CHUNK;
        let own = chunk_quad(chunk, place);
        let more = samples[own + 1u];
        if more.y > 0.0f {
            let point = samples[own];
            for (var a = 0u; a < 3u; a++) {
                sample_rows[a * apart + column] = point[a];
            }
            sample_rows[DENSITY_BACK * apart + column] = more.x;
            for (var f = 0u; f < N_SHADED; f++) {
                let d = point.w * traced[at + 2u + f / 4u][f % 4u];
                sample_rows[(DENSITY_BACK + 1u + f) * apart + column] = d;
            }
            column += 1u;
        }
        if place == 0u {
            chunk = links[chunk];
        }
    }
}

// Encodes the points again.
@compute @workgroup_size(64)
fn encode_again(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let apart = frame.sizes.y;
    for (var s = id.x; s < counted[KEPT]; s += 64u * groups.x) {
        let u = vec3f(sample_rows[s], sample_rows[apart + s], sample_rows[2u * apart + s]);
        write_encoded(u, s, apart);
    }
}
