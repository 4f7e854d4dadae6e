// Densities at points.
@group(0) @binding(40) var<storage, read> points: array<vec4f>;
@group(0) @binding(41) var<storage, read_write> densities: array<f32>;

@compute @workgroup_size(64)
fn look(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    for (var i = id.x; i < arrayLength(&densities); i += 64u * groups.x) {
        densities[i] = evaluate(points[i].xyz, vec3f(0.0f, 0.0f, 1.0f)).sigma;
    }
}
