// Half the squared error of the colour, expected over what may be behind the scene, and its
// gradient by the outputs of the colour network (`trainer::loss::squared_error`).

fn output(c: u32, column: u32) -> f32 {
    return ray_rows[(COLOR_OUT + c) * frame.sizes.x + column];
}

fn color_at(column: u32) -> vec3f {
    return logistic(vec4f(output(0u, column), output(1u, column), output(2u, column), 0.0f));
}

// The gradient by a colour becomes that by the outputs, whose rows fill up a block of sixteen.
// One that leads back from 0 or 1 is never lost (`field::logistic`).
fn write_gradient(column: u32, color: vec3f, d_color: vec3f) {
    let inside = (color > vec3f(0.5f)) == (d_color > vec3f());
    let least = select(vec3f(), vec3f(0.002f), inside);
    let d = d_color * max(color * (1.0f - color), least);
    for (var c = 0u; c < 3u; c++) {
        ray_rows[(COLOR_BACK + c) * frame.sizes.x + column] = d[c];
    }
}

@compute @workgroup_size(64)
fn loss(@builtin(global_invocation_id) id: vec3u) {
    let n_rays = frame.once.y;
    if id.x >= n_rays {
        let g = id.x - n_rays;
        if g < (frame.once.z - n_rays) / ASKED {
            hold(g);
        }
        return;
    }
    let at = PER_RAY * id.x;
    let transmittance = traced[at].z;
    let met = traced[at].w;
    let behind = rays[4u * id.x + 2u];
    let wanted = rays[4u * id.x + 3u];
    let weight = abs(rays[4u * id.x + 1u].w);
    let opacity = select(met, 1.0f, is_opaque(transmittance));
    let own = color_at(id.x);
    let color = opacity * own + (1.0f - opacity) * behind.xyz;
    let off = color - wanted.xyz;
    // A background that is b brighter makes `b (alpha - opacity)` of difference.
    let unlike = opacity - wanted.w;
    let through = 3.0f * behind.w * unlike;
    let d_color = weight * off;
    write_gradient(id.x, own, select(vec3f(), opacity * d_color, met > 0.0f));
    var d_opacity = 0.0f;
    // That of a ray that has ended is 1, whatever its samples.
    if opacity < 1.0f {
        d_opacity = weight * through + dot(d_color, own - behind.xyz);
    }
    var d_depth = 0.0f;
    if frame.slow.y > 0.0f && met >= OPAQUE {
        // The distance of a surface is a sum by the opacity.
        d_depth = frame.slow.y * weight * bent(id.x) / met;
        d_opacity -= d_depth * (traced[at + 1u].x / met);
    }
    traced[at + 1u].y = d_opacity;
    traced[at + 1u].z = d_depth;
    results[id.x] = vec4f((dot(off, off) + through * unlike) / 3.0f, opacity, 0.0f, 0.0f);
}

// A channel between the cameras that leaves what these see is an error.
fn hold(g: u32) {
    let first = frame.once.y + ASKED * g;
    let own = color_at(first);
    var low = color_at(first + 1u);
    var high = low;
    for (var i = 2u; i < ASKED; i++) {
        let other = color_at(first + i);
        low = min(low, other);
        high = max(high, other);
    }
    let beyond = own - clamp(own, low - SPAN_MARGIN, high + SPAN_MARGIN);
    write_gradient(first, own, select(HELD * beyond, vec3f(), asked_ray(g) == NONE));
    for (var i = 1u; i < ASKED; i++) {
        write_gradient(first + i, vec3f(), vec3f());
    }
}
