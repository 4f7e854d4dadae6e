//! Files by hand: what other programs read in them.

use pocketnerf_formats::World;
use serde_json::Value;

use super::*;
use crate::surface::{Corner, Mesh, Texture};

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
    assert_eq!(String::from_utf8(obj(&triangle(), None)).unwrap(), expected);
}

/// Two triangles that share an edge, in a chart each: four vertices, six corners.
fn textured() -> (Mesh, Texture) {
    let mesh = Mesh {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 1.0]],
        normals: vec![[0.0, 0.0, 1.0]; 4],
        colors: vec![[9; 3]; 4],
        triangles: vec![[0, 1, 2], [2, 1, 3]],
    };
    let corner = |vertex, u, v| Corner { vertex, uv: [u, v] };
    let corners = vec![
        corner(0, 0.0, 0.5),
        corner(1, 0.25, 0.5),
        corner(2, 0.0, 0.125),
        corner(2, 0.75, 1.0),
        corner(1, 1.0, 1.0),
        corner(3, 1.0, 0.75),
    ];
    let rgb = (0..3 * 256 * 256).map(|i| (i % 251) as u8).collect();
    let triangles = vec![[0, 1, 2], [3, 4, 5]];
    (mesh, Texture { size: 256, rgb, corners, triangles, charts: 2, used: 0.5 })
}

#[test]
fn an_obj_file_with_a_texture() {
    let (mesh, texture) = textured();
    let expected = "# pocketnerf\nmtllib ball.mtl\n\
                    v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\n\
                    vn 0.0000 0.0000 1.0000\nvn 0.0000 0.0000 1.0000\n\
                    vn 0.0000 0.0000 1.0000\nvn 0.0000 0.0000 1.0000\n\
                    vt 0.000000 0.500000\nvt 0.250000 0.500000\nvt 0.000000 0.875000\n\
                    vt 0.750000 0.000000\nvt 1.000000 0.000000\nvt 1.000000 0.250000\n\
                    usemtl surface\nf 1/1/1 2/2/2 3/3/3\nf 3/4/3 2/5/2 4/6/4\n";
    let written = obj(&mesh, Some((&texture, "ball.mtl")));
    assert_eq!(String::from_utf8(written).unwrap(), expected);
    let materials = String::from_utf8(mtl("ball.png")).unwrap();
    assert!(materials.contains("\nnewmtl surface\n"), "{materials}");
    assert!(materials.ends_with("\nillum 0\nmap_Kd ball.png\n"), "{materials}");
}

fn up(up: [f32; 3]) -> World {
    World { up: Some(up), metres: None }
}

#[test]
fn a_glb_file_with_a_texture() {
    let (mesh, texture) = textured();
    let png = texture.png().unwrap();
    let file = Glb::read(glb(&mesh, Some((&texture, &png)), &up([0.0, 1.0, 0.0])));
    let document = &file.document;
    let primitive = &document["meshes"][0]["primitives"][0];
    let names: Vec<&String> = primitive["attributes"].as_object().unwrap().keys().collect();
    // Colours of vertices would be multiplied with those of the image.
    assert_eq!(names, ["NORMAL", "POSITION", "TEXCOORD_0"]);
    for name in names {
        assert_eq!(file.accessor(&primitive["attributes"][name]).0["count"], 6);
    }
    let floats = |name: &str| -> Vec<f32> {
        let words = file.accessor(&primitive["attributes"][name]).1.as_chunks::<4>().0;
        words.iter().map(|word| f32::from_le_bytes(*word)).collect()
    };
    let all = |vertices: [usize; 6]| vertices.map(|vertex| mesh.positions[vertex]).concat();
    assert_eq!(floats("POSITION"), all([0, 1, 2, 2, 1, 3]));
    assert_eq!(floats("TEXCOORD_0")[2..8], [0.25, 0.5, 0.0, 0.125, 0.75, 1.0]);
    let corners = file.accessor(&primitive["indices"]).1.as_chunks::<4>().0;
    assert_eq!(corners.concat().iter().step_by(4).copied().collect::<Vec<_>>(), [0, 1, 2, 3, 4, 5]);
    // The image is inside, as it was.
    let material = &document["materials"][0];
    assert!(material["extensions"]["KHR_materials_unlit"].is_object());
    assert_eq!(material["pbrMetallicRoughness"]["baseColorTexture"]["index"], 0);
    assert_eq!(document["textures"][0]["source"], 0);
    assert_eq!(document["images"][0]["mimeType"], "image/png");
    let (view, bytes) = file.view(&document["images"][0]["bufferView"]);
    assert_eq!(view.get("target"), None);
    let image = image::load_from_memory(bytes).unwrap().into_rgb8();
    assert_eq!((image.dimensions(), image.as_raw()), ((256, 256), &texture.rgb));
    for view in document["bufferViews"].as_array().unwrap() {
        assert_eq!(view["byteOffset"].as_u64().unwrap() % 4, 0, "{view}");
    }
}

/// A GLB file in its parts.
struct Glb {
    document: Value,
    binary: Vec<u8>,
}

impl Glb {
    fn read(file: Vec<u8>) -> Self {
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&file[..4], word(4), word(8)), (&b"glTF"[..], 2, file.len()));
        let text = word(12);
        assert_eq!((text % 4, &file[16..20]), (0, &b"JSON"[..]));
        let document: Value = serde_json::from_slice(&file[20..20 + text]).unwrap();
        let binary = file[20 + text + 8..].to_vec();
        assert_eq!((word(20 + text), &file[24 + text..28 + text]), (binary.len(), &b"BIN\0"[..]));
        assert_eq!(
            (&document["buffers"][0]["byteLength"], binary.len() % 4),
            (&binary.len().into(), 0)
        );
        Self { document, binary }
    }

    fn view(&self, number: &Value) -> (&Value, &[u8]) {
        let view = &self.document["bufferViews"][number.as_u64().unwrap() as usize];
        let at = |name: &str| view[name].as_u64().unwrap() as usize;
        (view, &self.binary[at("byteOffset")..][..at("byteLength")])
    }

    fn accessor(&self, number: &Value) -> (&Value, &[u8]) {
        let accessor = &self.document["accessors"][number.as_u64().unwrap() as usize];
        (accessor, self.view(&accessor["bufferView"]).1)
    }
}

#[test]
fn a_glb_file() {
    let file =
        Glb::read(glb(&triangle(), None, &World { metres: Some(0.5), ..up([0.0, 0.0, 1.0]) }));
    let document = &file.document;
    let primitive = &document["meshes"][0]["primitives"][0];
    let accessor = |number: &Value| file.accessor(number);
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
    // A unit is half a metre.
    assert_eq!(document["nodes"][0]["scale"], serde_json::json!([0.5, 0.5, 0.5]));
    assert!(document["materials"][0]["extensions"]["KHR_materials_unlit"].is_object());
}
