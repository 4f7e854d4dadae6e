//! Files by hand: what other programs read in them.

use serde_json::Value;

use super::*;
use crate::surface::Mesh;

fn triangle() -> Mesh {
    Mesh {
        positions: vec![[0.0, 0.5, 0.0], [1.0, 0.5, 0.0], [0.0, 2.0, -3.0]],
        normals: vec![[0.0, 0.0, 1.0]; 3],
        colors: vec![[255, 0, 0], [0, 188, 0], [1, 2, 3]],
        triangles: vec![[0, 1, 2]],
    }
}

#[test]
fn a_ply_file() {
    let header = "ply\nformat binary_little_endian 1.0\ncomment pocketnerf\nelement vertex 3\n\
                  property float x\nproperty float y\nproperty float z\n\
                  property float nx\nproperty float ny\nproperty float nz\n\
                  property uchar red\nproperty uchar green\nproperty uchar blue\n";
    let faces = "element face 1\nproperty list uchar int vertex_indices\n";
    let mut vertices = Vec::new();
    for (position, color) in triangle().positions.iter().zip(triangle().colors) {
        let values = position.iter().chain(&[0.0_f32, 0.0, 1.0]);
        values.for_each(|value| vertices.extend(value.to_le_bytes()));
        vertices.extend(color);
    }
    let points_alone = [header.as_bytes(), b"end_header\n", &vertices].concat();
    assert_eq!(points(&triangle()), points_alone);
    let corners = [3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0];
    let header = [header, faces, "end_header\n"].concat();
    assert_eq!(ply(&triangle()), [header.as_bytes(), &vertices, &corners].concat());
}

#[test]
fn an_obj_file() {
    let expected = "# pocketnerf\n\
                    v 0 0.5 0 1.0000 0.0000 0.0000\n\
                    v 1 0.5 0 0.0000 0.7373 0.0000\n\
                    v 0 2 -3 0.0039 0.0078 0.0118\n\
                    vn 0.0000 0.0000 1.0000\nvn 0.0000 0.0000 1.0000\nvn 0.0000 0.0000 1.0000\n\
                    f 1//1 2//2 3//3\n";
    assert_eq!(String::from_utf8(obj(&triangle())).unwrap(), expected);
}

#[test]
fn a_glb_file() {
    let file = glb(&triangle(), [0.0, 0.0, 1.0]);
    let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&file[..4], word(4), word(8)), (&b"glTF"[..], 2, file.len()));
    let text = word(12);
    assert_eq!((text % 4, &file[16..20]), (0, &b"JSON"[..]));
    let document: Value = serde_json::from_slice(&file[20..20 + text]).unwrap();
    let binary = 20 + text + 8;
    assert_eq!((word(20 + text), &file[binary - 4..binary]), (file.len() - binary, &b"BIN\0"[..]));
    assert_eq!(document["buffers"][0]["byteLength"], file.len() - binary);
    let primitive = &document["meshes"][0]["primitives"][0];
    let accessor = |number: &Value| {
        let accessor = &document["accessors"][number.as_u64().unwrap() as usize];
        let view = &document["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let at = |name: &str| view[name].as_u64().unwrap() as usize;
        (accessor, &file[binary + at("byteOffset")..][..at("byteLength")])
    };
    let (positions, bytes) = accessor(&primitive["attributes"]["POSITION"]);
    let floats: Vec<f32> =
        bytes.chunks(4).map(|word| f32::from_le_bytes(word.try_into().unwrap())).collect();
    assert_eq!(floats, triangle().positions.concat());
    assert_eq!(positions["min"], serde_json::json!([0.0, 0.5, -3.0]));
    assert_eq!(positions["max"], serde_json::json!([1.0, 2.0, 0.0]));
    // Linear: sRGB 188 is half of the light.
    let (colors, bytes) = accessor(&primitive["attributes"]["COLOR_0"]);
    assert_eq!((&colors["normalized"], &colors["type"]), (&true.into(), &"VEC4".into()));
    let shorts: Vec<u16> =
        bytes.chunks(2).map(|short| u16::from_le_bytes(short.try_into().unwrap())).collect();
    assert_eq!(shorts[..4], [65535, 0, 0, 65535]);
    assert!((shorts[5] as f32 / 65535.0 - 0.5).abs() < 0.01, "{}", shorts[5]);
    let (indices, bytes) = accessor(&primitive["indices"]);
    assert_eq!((&indices["count"], bytes), (&3.into(), &[0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0][..]));
    // z becomes y: a quarter turn about -x.
    let turn: Vec<f64> = serde_json::from_value(document["nodes"][0]["rotation"].clone()).unwrap();
    let half = 0.5_f64.sqrt();
    let expected = [-half, 0.0, 0.0, half];
    assert!(turn.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{turn:?}");
    assert!(document["materials"][0]["extensions"]["KHR_materials_unlit"].is_object());
}
