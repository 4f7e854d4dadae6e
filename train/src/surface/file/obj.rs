//! Wavefront OBJ, with a colour after each position, as MeshLab, Blender and others read it.

use std::fmt::Write;

use crate::surface::Mesh;

/// A mesh as an OBJ file. Colours are sRGB from 0 to 1.
#[must_use]
pub fn obj(mesh: &Mesh) -> Vec<u8> {
    let mut text = String::from("# pocketnerf\n");
    for ([x, y, z], color) in mesh.positions.iter().zip(&mesh.colors) {
        let [r, g, b] = color.map(|c| f32::from(c) / 255.0);
        let _ = writeln!(text, "v {x} {y} {z} {r:.4} {g:.4} {b:.4}");
    }
    for [x, y, z] in &mesh.normals {
        let _ = writeln!(text, "vn {x:.4} {y:.4} {z:.4}");
    }
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|vertex| vertex + 1);
        let _ = writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}");
    }
    text.into_bytes()
}
