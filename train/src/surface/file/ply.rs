//! The Polygon File Format (Turk, "The PLY polygon file format", 1994), binary.

use crate::surface::Mesh;

/// A mesh as a PLY file: float positions and normals, 8-bit sRGB colours, triangles.
#[must_use]
pub fn ply(mesh: &Mesh) -> Vec<u8> {
    let faces =
        format!("element face {}\nproperty list uchar int vertex_indices\n", mesh.triangles.len());
    let mut bytes = vertices(mesh, &faces);
    for triangle in &mesh.triangles {
        bytes.push(3);
        triangle.iter().for_each(|vertex| bytes.extend((*vertex as i32).to_le_bytes()));
    }
    bytes
}

/// Its vertices alone: a point cloud.
#[must_use]
pub fn points(mesh: &Mesh) -> Vec<u8> {
    vertices(mesh, "")
}

fn vertices(mesh: &Mesh, faces: &str) -> Vec<u8> {
    let mut header = format!(
        "ply\nformat binary_little_endian 1.0\ncomment pocketnerf\nelement vertex {}\n",
        mesh.positions.len()
    );
    for name in ["x", "y", "z", "nx", "ny", "nz"] {
        header += &format!("property float {name}\n");
    }
    for name in ["red", "green", "blue"] {
        header += &format!("property uchar {name}\n");
    }
    let mut bytes = (header + faces + "end_header\n").into_bytes();
    for ((position, normal), color) in mesh.positions.iter().zip(&mesh.normals).zip(&mesh.colors) {
        position.iter().chain(normal).for_each(|value| bytes.extend(value.to_le_bytes()));
        bytes.extend(color);
    }
    bytes
}
