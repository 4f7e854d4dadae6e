//! glTF 2.0 in one binary file.

use glam::{Quat, Vec3};
use pocketnerf_core::ColorSpace;
use serde_json::{Value, json};

use crate::surface::Mesh;

const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// A mesh as a GLB file. Positions stay as they are; a node turns `up` to +y, which is up in glTF.
/// Colours have the light in them already, so the material is unlit (`KHR_materials_unlit`);
/// they are linear, as glTF has them.
#[must_use]
pub fn glb(mesh: &Mesh, up: [f32; 3]) -> Vec<u8> {
    let mut file = Builder::default();
    let [min, max] = mesh.bounds().unwrap_or([[0.0; 3]; 2]);
    let floats =
        |rows: &[[f32; 3]]| rows.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    let n = mesh.positions.len();
    let positions = file.accessor(floats(&mesh.positions), ARRAY_BUFFER, n, FLOAT, "VEC3");
    file.accessors[positions]["min"] = json!(min);
    file.accessors[positions]["max"] = json!(max);
    let normals = file.accessor(floats(&mesh.normals), ARRAY_BUFFER, n, FLOAT, "VEC3");
    let colors = mesh.colors.iter().flat_map(|color| linear(*color)).flat_map(u16::to_le_bytes);
    let colors = file.accessor(colors.collect(), ARRAY_BUFFER, n, UNSIGNED_SHORT, "VEC4");
    file.accessors[colors]["normalized"] = true.into();
    let corners = mesh.triangles.as_flattened();
    let bytes = corners.iter().flat_map(|vertex| vertex.to_le_bytes()).collect();
    let indices = file.accessor(bytes, ELEMENT_ARRAY_BUFFER, corners.len(), UNSIGNED_INT, "SCALAR");
    let turn = Quat::from_rotation_arc(Vec3::from(up).normalize_or(Vec3::Y), Vec3::Y);
    let Builder { bytes, views, accessors } = file;
    let document = json!({
        "asset": {
            "version": "2.0",
            "generator": concat!("pocketnerf ", env!("CARGO_PKG_VERSION")),
        },
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "rotation": turn.to_array() }],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": positions, "NORMAL": normals, "COLOR_0": colors },
            "indices": indices,
            "material": 0,
        }] }],
        "materials": [{
            "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 1.0 },
            "extensions": { "KHR_materials_unlit": {} },
            "doubleSided": true,
        }],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{ "byteLength": bytes.len() }],
    });
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut file = b"glTF".to_vec();
    let total = 12 + 8 + text.len() + 8 + bytes.len();
    for number in [2, total as u32, text.len() as u32] {
        file.extend(number.to_le_bytes());
    }
    file.extend(b"JSON");
    file.extend(text);
    file.extend((bytes.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(bytes);
    file
}

/// 16-bit linear RGBA.
fn linear(color: [u8; 3]) -> [u16; 4] {
    let rgb = ColorSpace::Linear.from_srgb(color.map(|c| f32::from(c) / 255.0));
    let [r, g, b] = rgb.map(|c| (65535.0 * c).round() as u16);
    [r, g, b, u16::MAX]
}

/// The binary part, and what tells its pieces.
#[derive(Default)]
struct Builder {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Builder {
    /// Adds a piece of whole four-byte words, and gives its accessor's number.
    fn accessor(&mut self, piece: Vec<u8>, target: u32, n: usize, of: u32, kind: &str) -> usize {
        self.views.push(json!({
            "buffer": 0,
            "byteOffset": self.bytes.len(),
            "byteLength": piece.len(),
            "target": target,
        }));
        self.accessors.push(json!({
            "bufferView": self.views.len() - 1,
            "componentType": of,
            "count": n,
            "type": kind,
        }));
        self.bytes.extend(piece);
        self.accessors.len() - 1
    }
}
