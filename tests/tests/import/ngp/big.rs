//! Snapshots of the usual size, whose parameters follow a formula: `big8.json` and
//! `big16.json` say which.

use half::f16;
use pocketnerf_formats::import::ngp::Ngp;
use rmp::encode;
use serde_json::{Value, json};

use super::exact::agree;
use super::{bytes, ngp};

/// Cells along a side of the density grid.
const CELLS: usize = 128;

/// Splitmix64's number i, from -1/2 to 1/2.
fn shuffled(i: u64) -> f64 {
    let z = (i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ z >> 31) >> 40) as f64 / f64::from(1 << 24) - 0.5
}

fn params(formula: &Value) -> Vec<u8> {
    let mut bytes = Vec::new();
    for range in formula["ranges"].as_array().unwrap() {
        let number = |key: &str| range[key].as_f64().unwrap();
        let [from, to] = ["from", "to"].map(|key| range[key].as_u64().unwrap());
        for i in from..to {
            let value = (shuffled(i) + number("shift")) * number("amplitude");
            bytes.extend(f16::from_f64(value).to_le_bytes());
        }
    }
    let (first, last) = (&bytes[..16], &bytes[bytes.len() - 16..]);
    for (part, key) in [(first, "first"), (last, "last")] {
        let expected = formula[key].as_array().unwrap();
        for (found, expected) in part.as_chunks().0.iter().zip(expected) {
            assert_eq!(f16::from_le_bytes(*found), f16::from_f64(expected.as_f64().unwrap()));
        }
    }
    bytes
}

/// A shell, in Morton order.
fn densities() -> Vec<u8> {
    let every_third = |code: usize| (0..7).fold(0, |c, bit| c | (code >> (3 * bit) & 1) << bit);
    let density = |code: usize| {
        let from_middle = |axis: usize| (2 * every_third(code >> axis) as i64 - 127).pow(2);
        let q = from_middle(0) + from_middle(1) + from_middle(2);
        if (900..=12100).contains(&q) { 0.03125 } else { 0.0 }
    };
    (0..CELLS.pow(3)).flat_map(|code| f16::from_f64(density(code)).to_le_bytes()).collect()
}

fn write(to: &mut Vec<u8>, value: &Value, binaries: &[Vec<u8>]) {
    match value {
        Value::Object(map) => {
            encode::write_map_len(to, map.len() as u32).unwrap();
            for (key, value) in map {
                encode::write_str(to, key).unwrap();
                match (key.strip_suffix("_binary"), value.as_u64()) {
                    (Some(_), Some(i)) => encode::write_bin(to, &binaries[i as usize]).unwrap(),
                    _ => write(to, value, binaries),
                }
            }
        }
        Value::Array(values) => {
            encode::write_array_len(to, values.len() as u32).unwrap();
            values.iter().for_each(|value| write(to, value, binaries));
        }
        Value::String(text) => encode::write_str(to, text).unwrap(),
        Value::Bool(truth) => encode::write_bool(to, *truth).unwrap(),
        Value::Null => encode::write_nil(to).unwrap(),
        Value::Number(number) => match number.as_u64() {
            Some(whole) => drop(encode::write_uint(to, whole).unwrap()),
            None => encode::write_f32(to, number.as_f64().unwrap() as f32).unwrap(),
        },
    }
}

/// The snapshot that a file of this name describes.
pub(crate) fn snapshot(name: &str) -> Vec<u8> {
    let about: Value = serde_json::from_slice(&bytes(&format!("{name}.json"))).unwrap();
    let formula = &about["formula"];
    let mut root = formula["config"].clone();
    let mut views = [Vec::new(), Vec::new()];
    for camera in about["cameras"].as_array().unwrap() {
        let [metadata, pose] = view(&about, camera);
        views[0].push(metadata);
        views[1].push(pose);
    }
    let [metadata, poses] = views;
    root["snapshot"] = json!({
        "version": 1,
        "mode": "nerf",
        "n_params": formula["n_params"],
        "params_type": "__half",
        "params_binary": 0,
        "density_grid_size": CELLS,
        "density_grid_binary": 1,
        "background_color": [0.0, 0.0, 0.0, 1.0],
        "nerf": { "aabb_scale": 1, "dataset": {
            "scale": about["scale"], "offset": about["offset"], "aabb_scale": 1,
            "metadata": metadata, "xforms": poses,
        } },
    });
    let mut file = Vec::new();
    write(&mut file, &root, &[params(formula), densities()]);
    file
}

/// What instant-ngp keeps of a camera that is given in the dataset's coordinates.
fn view(about: &Value, camera: &Value) -> [Value; 2] {
    let number = |value: &Value| value.as_f64().unwrap();
    let [w, h, cx, cy] = ["w", "h", "cx", "cy"].map(|key| number(&camera[key]));
    let metadata = json!({
        "resolution": [w, h],
        "focal_length": [camera["fl_x"], camera["fl_y"]],
        "principal_point": [cx / w, cy / h],
        "lens": null,
    });
    let row = |r: usize| {
        let at = |c: usize| number(&camera["camera_to_world"][r][c]);
        let position = at(3) * number(&about["scale"]) + number(&about["offset"][r]);
        json!([at(0), -at(1), -at(2), position])
    };
    let pose = json!([row(1), row(2), row(0)]);
    [metadata, json!({"start": pose, "end": pose})]
}

#[test]
fn eight_levels_of_four_features() {
    agree(ngp(&snapshot("big8")).unwrap(), "instant-ngp", "big8");
}

#[test]
fn sixteen_levels_of_two_features() {
    let ngp: Ngp = ngp(&snapshot("big16")).unwrap();
    assert_eq!(ngp.context().views.len(), 3);
    agree(ngp, "instant-ngp", "big16");
}
