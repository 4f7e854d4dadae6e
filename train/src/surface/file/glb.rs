//! glTF 2.0 in one binary file.

use glam::{Quat, Vec3};
use pocketnerf_core::ColorSpace;
use pocketnerf_formats::World;
use serde_json::{Value, json};

use crate::surface::{Mesh, Texture};

const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const LINEAR: u32 = 9729;
const LINEAR_MIPMAP_LINEAR: u32 = 9987;
const CLAMP_TO_EDGE: u32 = 33071;

/// A mesh as a GLB file. Positions stay as they are; a node turns the world's up to
/// +y, which is up in glTF, and scales it to metres, where it is known how long they are.
/// Colours have the light in them already, so the material is unlit (`KHR_materials_unlit`).
/// Those of vertices are linear, as glTF has them; a texture, with its PNG file, is sRGB and stands
/// instead of them.
#[must_use]
pub fn glb(mesh: &Mesh, texture: Option<(&Texture, &[u8])>, world: &World) -> Vec<u8> {
    let mut file = Builder::default();
    let vertices: Vec<usize> = match texture {
        Some((texture, _)) => texture.corners.iter().map(|corner| corner.vertex as usize).collect(),
        None => (0..mesh.positions.len()).collect(),
    };
    let n = vertices.len();
    let vectors = |rows: &[[f32; 3]]| bytes(vertices.iter().flat_map(|vertex| rows[*vertex]));
    let [min, max] = mesh.bounds().unwrap_or([[0.0; 3]; 2]);
    let positions = file.accessor(vectors(&mesh.positions), ARRAY_BUFFER, n, FLOAT, "VEC3");
    file.accessors[positions]["min"] = json!(min);
    file.accessors[positions]["max"] = json!(max);
    let normals = file.accessor(vectors(&mesh.normals), ARRAY_BUFFER, n, FLOAT, "VEC3");
    let mut attributes = json!({ "POSITION": positions, "NORMAL": normals });
    let mut material = json!({
        "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 1.0 },
        "extensions": { "KHR_materials_unlit": {} },
        "doubleSided": true,
    });
    if let Some((texture, _)) = texture {
        let places = bytes(texture.corners.iter().flat_map(|corner| corner.uv));
        attributes["TEXCOORD_0"] = file.accessor(places, ARRAY_BUFFER, n, FLOAT, "VEC2").into();
        material["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
    } else {
        let colors = mesh.colors.iter().flat_map(|color| linear(*color)).flat_map(u16::to_le_bytes);
        let colors = file.accessor(colors.collect(), ARRAY_BUFFER, n, UNSIGNED_SHORT, "VEC4");
        file.accessors[colors]["normalized"] = true.into();
        attributes["COLOR_0"] = colors.into();
    }
    let triangles = texture.map_or(&mesh.triangles, |(texture, _)| &texture.triangles);
    let corners = triangles.as_flattened();
    let numbers = corners.iter().flat_map(|vertex| vertex.to_le_bytes()).collect();
    let indices =
        file.accessor(numbers, ELEMENT_ARRAY_BUFFER, corners.len(), UNSIGNED_INT, "SCALAR");
    let turn = Quat::from_rotation_arc(Vec3::from(world.up()).normalize_or(Vec3::Y), Vec3::Y);
    let scale = [world.metres.unwrap_or(1.0); 3];
    let mut document = json!({
        "asset": {
            "version": "2.0",
            "generator": concat!("pocketnerf ", env!("CARGO_PKG_VERSION")),
        },
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "rotation": turn.to_array(), "scale": scale }],
        "meshes": [{ "primitives": [
            { "attributes": attributes, "indices": indices, "material": 0 },
        ] }],
        "materials": [material],
    });
    if let Some((_, png)) = texture {
        let view = file.view(png, None);
        document["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
        document["samplers"] = json!([{
            "magFilter": LINEAR,
            "minFilter": LINEAR_MIPMAP_LINEAR,
            "wrapS": CLAMP_TO_EDGE,
            "wrapT": CLAMP_TO_EDGE,
        }]);
        document["textures"] = json!([{ "sampler": 0, "source": 0 }]);
    }
    file.finish(document)
}

fn bytes(floats: impl Iterator<Item = f32>) -> Vec<u8> {
    floats.flat_map(f32::to_le_bytes).collect()
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
    /// Adds a piece, and gives the number of its view. Each begins at a whole four-byte word.
    fn view(&mut self, piece: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({
            "buffer": 0,
            "byteOffset": self.bytes.len(),
            "byteLength": piece.len(),
        });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.views.push(view);
        self.bytes.extend(piece);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    /// Adds a piece, and gives its accessor's number.
    fn accessor(&mut self, piece: Vec<u8>, target: u32, n: usize, of: u32, kind: &str) -> usize {
        let view = self.view(&piece, Some(target));
        self.accessors.push(json!({
            "bufferView": view,
            "componentType": of,
            "count": n,
            "type": kind,
        }));
        self.accessors.len() - 1
    }

    /// The file: the document, and behind it the binary part.
    fn finish(self, mut document: Value) -> Vec<u8> {
        let Self { bytes, views, accessors } = self;
        document["accessors"] = accessors.into();
        document["bufferViews"] = views.into();
        document["buffers"] = json!([{ "byteLength": bytes.len() }]);
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
}
