//! The table of other programs' cameras in docs/embedding.md.

use pocketnerf_c::Camera;

use crate::{NOTHING, Open, STILL_LIFE, usual_options};

type Matrix = [[f32; 3]; 3];

/// Another program: the beginning of its row, W, C, which of its axes a camera looks along,
/// which is up, and whether its world is left-handed.
struct Program(&'static str, Matrix, Matrix, [f32; 3], [f32; 3], bool);

const SAME: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const X: [f32; 3] = [1.0, 0.0, 0.0];
const Y: [f32; 3] = [0.0, 1.0, 0.0];
const Z: [f32; 3] = [0.0, 0.0, 1.0];

const PROGRAMS: [Program; 6] = [
    Program("Blender", SAME, SAME, [0.0, 0.0, -1.0], Y, false),
    Program("OpenGL", [X, [0.0, 0.0, -1.0], Y], SAME, [0.0, 0.0, -1.0], Y, false),
    Program("OpenCV", SAME, [X, [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]], Z, [0.0, -1.0, 0.0], false),
    Program("ROS body", SAME, [[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], Y], X, Z, false),
    Program("Unity", [X, Z, Y], [X, Y, [0.0, 0.0, -1.0]], Z, Y, true),
    Program("Unreal", [X, [0.0, -1.0, 0.0], Z], [[0.0, 0.0, -1.0], X, Y], X, Z, true),
];

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    let cell = |i: usize, j: usize| (0..3).map(|k| a[i][k] * b[k][j]).sum();
    std::array::from_fn(|i| std::array::from_fn(|j| cell(i, j)))
}

fn apply(m: &Matrix, v: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|i| (0..3).map(|k| m[i][k] * v[k]).sum())
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
}

fn transposed(m: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}

#[test]
fn cameras_of_other_programs_become_ours() {
    let doc = include_str!("../../../../docs/embedding.md");
    let text = |m: &Matrix| m.map(|row| row.map(|v| v.to_string()).join(" ")).join(", ");
    // Ours looks along y, x to the right, z up.
    let (right, up, back) = (X, Z, [0.0, -1.0, 0.0]);
    let ours = transposed(&[right, up, back]);
    for Program(name, world, axes, forward, upward, left_handed) in PROGRAMS {
        let row = doc.lines().find(|line| line.starts_with(&format!("| {name}"))).unwrap();
        assert!(row.ends_with(&format!("| `{}` | `{}` |", text(&world), text(&axes))), "{row}");
        // What that program knows of such a camera: where its own axes point in its own
        // world. To the right is where its handedness has it.
        let own = transposed(&world);
        let theirs = [forward, upward].map(|axis| apply(&transposed(&axes), axis));
        assert_eq!(theirs, [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0]], "{name}");
        let hand = if left_handed { -1.0 } else { 1.0 };
        let sideways = cross(forward, upward).map(|v| hand * v);
        assert_eq!(apply(&axes, X), sideways, "{name}");
        let matrix = times(&times(&own, &ours), &transposed(&axes));
        let look = apply(&matrix, forward);
        assert_eq!((apply(&world, look), apply(&world, apply(&matrix, upward))), (Y, Z), "{name}");
        assert_eq!(apply(&world, apply(&matrix, sideways)), X, "{name}");
        // The documented product is our camera again, and one that is accepted.
        let found = times(&times(&world, &matrix), &axes);
        assert_eq!(found, ours, "{name}");
        let model = Open::new(STILL_LIFE, 0);
        let mut camera: Camera = model.camera(8, 6);
        for (row, values) in found.iter().enumerate() {
            camera.camera_to_world[4 * row..4 * row + 3].copy_from_slice(values);
        }
        let bytes = crate::picture::bytes_of(&model, &camera, &usual_options(), NOTHING);
        assert_eq!(bytes.len(), 4 * 8 * 6);
    }
}
