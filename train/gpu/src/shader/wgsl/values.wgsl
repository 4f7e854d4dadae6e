// What all programs have in common.

struct Ray {
    origin: vec3f,
    direction: vec3f,
}

// `n`, though no compiler knows it: loops of so many rounds stay loops, and programs small.
fn times(n: u32) -> u32 {
    return n * frame.once.x;
}

// Whether it is a number: comparisons cannot tell, where compilers assume that all are.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}
