//! Wavefront OBJ, with a colour after each position, as MeshLab, Blender and others read it, or with a
//! texture that a material names (MTL).

use std::fmt::Write;

use crate::surface::{Mesh, Texture};

/// What the material is called.
const MATERIAL: &str = "surface";

/// A mesh as an OBJ file. Colours are sRGB from 0 to 1; with a texture, the material of the MTL file
/// of this name has them instead.
#[must_use]
pub fn obj(mesh: &Mesh, texture: Option<(&Texture, &str)>) -> Vec<u8> {
    let mut text = String::from("# pocketnerf\n");
    if let Some((_, materials)) = texture {
        let _ = writeln!(text, "mtllib {materials}");
    }
    for ([x, y, z], color) in mesh.positions.iter().zip(&mesh.colors) {
        let _ = write!(text, "v {x} {y} {z}");
        if texture.is_none() {
            let [r, g, b] = color.map(|c| f32::from(c) / 255.0);
            let _ = write!(text, " {r:.4} {g:.4} {b:.4}");
        }
        text.push('\n');
    }
    for [x, y, z] in &mesh.normals {
        let _ = writeln!(text, "vn {x:.4} {y:.4} {z:.4}");
    }
    if let Some((texture, _)) = texture {
        for [u, v] in texture.corners.iter().map(|corner| corner.uv) {
            // From the bottom here.
            let _ = writeln!(text, "vt {u:.6} {:.6}", 1.0 - v);
        }
        let _ = writeln!(text, "usemtl {MATERIAL}");
    }
    for (number, triangle) in mesh.triangles.iter().enumerate() {
        text.push('f');
        for (i, vertex) in triangle.iter().enumerate() {
            let vertex = vertex + 1;
            let _ = match texture {
                None => write!(text, " {vertex}//{vertex}"),
                Some((texture, _)) => {
                    write!(text, " {vertex}/{}/{vertex}", texture.triangles[number][i] + 1)
                }
            };
        }
        text.push('\n');
    }
    text.into_bytes()
}

/// The MTL file beside it: an unlit material with the image of this name.
#[must_use]
pub fn mtl(image: &str) -> Vec<u8> {
    format!(
        "# pocketnerf\nnewmtl {MATERIAL}\nKa 0 0 0\nKd 1 1 1\nKs 0 0 0\nillum 0\nmap_Kd {image}\n"
    )
    .into_bytes()
}
