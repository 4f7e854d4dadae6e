// Forwards: every ray from sample to sample until it is opaque. What going back needs is noted in
// chunks, so that long rays and short ones take as much memory as they have samples.

@compute @workgroup_size(64)
fn trace(@builtin(global_invocation_id) id: vec3u) {
    let r = id.x;
    if r >= frame.once.y {
        return;
    }
    let start = rays[4u * r];
    let ray = Ray(start.xyz, rays[4u * r + 1u].xyz);
    STEP = frame.detail.z;
    PHASE = start.w;
    var sum = NOTHING;
    var local = to_local(ray);
    if local.is_there {
        let first = first_steps(local);
        var k = first.x;
        var end = first.y;
        var across = stride(local.ray);
        var steps = 1.0f;
        loop {
            if !(k < end) {
                k = end;
                end = turn(&local, k);
                if !(k < end) {
                    break;
                }
                across = stride(local.ray);
            }
            let t = distance_of(min(k + (steps - 1.0f) * 0.5f, end - 1.0f));
            let u = unit(local.ray.origin + t * local.ray.direction);
            let cells = around(u);
            if !cells.is_occupied {
                k += steps_to_leave(local.ray, across, u, cells, t);
                continue;
            }
            if sum.count % CHUNK == 0u {
                let chunk = new_chunk(sum.last);
                if chunk == NONE {
                    break;
                }
                sum.last = chunk;
            }
            add_sample(&sum, evaluate(u, ray.direction), u, t, steps);
            k += steps;
            if is_opaque(sum.transmittance) {
                break;
            }
            steps = steps_at(sum.transmittance);
        }
    }
    note_ray(r, sum);
}
