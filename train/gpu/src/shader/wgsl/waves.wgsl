// Fourier features: sines and cosines, good to about 1e-7 where a GPU's own may be off by
// 5e-4.

// sin(pi x) for x from -1/2 to 1/2: Taylor's polynomial.
fn near_sine(x: vec4f) -> vec4f {
    let xx = x * x;
    var sum = vec4f(-0.0073704309f);
    sum = sum * xx + 0.082145887f;
    sum = sum * xx - 0.59926453f;
    sum = sum * xx + 2.5501640f;
    sum = sum * xx - 5.1677128f;
    sum = sum * xx + 3.1415927f;
    return sum * x;
}

// sin(pi x) of any x.
fn sin_pi(x: vec4f) -> vec4f {
    // Half turns change the sign.
    let turns = round(x);
    let sign = 1.0f - 2.0f * abs(turns - 2.0f * floor(0.5f * turns));
    return sign * near_sine(x - turns);
}

fn cos_pi(x: vec4f) -> vec4f {
    let turns = round(x);
    let sign = 1.0f - 2.0f * abs(turns - 2.0f * floor(0.5f * turns));
    let rest = x - turns;
    // cos(pi r) = sin(pi (1/2 - |r|)).
    return sign * near_sine(0.5f - abs(rest));
}

// 1 / pi in two parts: twelve bits, and the rest.
const INVERSE_PI = vec2f(0.3182373f, 7.25815e-5f);

// A number of half turns in two parts: the first has so few bits that its octaves are exact.
struct Turns {
    upper: vec3f,
    lower: vec3f,
}

// Those of the angles `x`.
fn half_turns(x: vec3f) -> Turns {
    let upper = bitcast<vec3f>(bitcast<vec3u>(x) & vec3u(0xfffff000u));
    return Turns(upper * INVERSE_PI.x, (x - upper) * INVERSE_PI.x + x * INVERSE_PI.y);
}

// Those of the angles pi `x`.
fn half_turns_of_pi(x: vec3f) -> Turns {
    return Turns(x, vec3f());
}

// 2^k times as many, whole turns left out.
fn octave(turns: Turns, k: u32) -> vec4f {
    let times = f32(1u << k);
    let upper = turns.upper * times;
    return vec4f(upper - 2.0f * round(0.5f * upper) + turns.lower * times, 0.0f);
}
