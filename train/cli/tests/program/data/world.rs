//! Captures whose files lie anyhow: what users ask and get is in the files' coordinates.

use std::fmt::Write as _;

use glam::{Mat3, Mat4, Quat, Vec3};
use pocketnerf_core::Camera;
use pocketnerf_train::builtin;
use pocketnerf_train::dataset::{Split, View};
use pocketnerf_train::picture::image_file;
use serde_json::Value;

use crate::place::Place;

/// Where COLMAP puts a point of the built-in scene: two and a half times as large, -y up, aside.
fn moved(p: Vec3) -> Vec3 {
    2.5 * (turn() * p) + Vec3::new(10.0, 20.0, 30.0)
}

/// (x, y, z) becomes (x, -z, y).
fn turn() -> Mat3 {
    Mat3::from_cols(Vec3::X, Vec3::Z, -Vec3::Y)
}

/// A camera of the built-in scene as COLMAP has it: right, up, back and position.
fn pose(camera: &Camera) -> Mat4 {
    let own = Mat4::from_cols_array(&camera.camera_to_world).transpose();
    let axes = [0, 1, 2].map(|c| (turn() * own.col(c).truncate()).extend(0.0));
    let at = moved(own.col(3).truncate()).extend(1.0);
    Mat4::from_cols(axes[0], axes[1], axes[2], at)
}

/// The first views of the built-in scene as COLMAP's text, without points.
fn write_capture(place: &Place) -> Vec<View> {
    let folder = place.path("capture");
    let sparse = folder.join("sparse/0");
    for at in [&folder.join("images"), &sparse] {
        std::fs::create_dir_all(at).unwrap();
    }
    let views = builtin::dataset(Split::Train, 16).views.split_off(20);
    let mut images = String::new();
    for (i, View { camera, rgba, .. }) in views.iter().enumerate() {
        let size = [camera.width, camera.height];
        let file = folder.join(format!("images/{i:02}.png"));
        image::save_buffer(file, rgba, size[0], size[1], image::ColorType::Rgba8).unwrap();
        // Its rows are right, down and forward.
        let pose = pose(camera);
        let [right, up, back, at] = [0, 1, 2, 3].map(|c| pose.col(c).truncate());
        let world_to_camera = Mat3::from_cols(right, -up, -back).transpose();
        let [x, y, z, w] = Quat::from_mat3(&world_to_camera).to_array();
        let [a, b, c] = (-(world_to_camera * at)).to_array();
        writeln!(images, "{} {w} {x} {y} {z} {a} {b} {c} 1 {i:02}.png\n", i + 1).unwrap();
    }
    let Camera { width, height, focal: [focal, _], .. } = views[0].camera;
    let [x, y] = [width, height].map(|side| 0.5 * side as f32);
    let camera = format!("1 SIMPLE_PINHOLE {width} {height} {focal} {x} {y}\n");
    let texts = [("cameras.txt", camera), ("images.txt", images), ("points3D.txt", String::new())];
    for (name, text) in texts {
        std::fs::write(sparse.join(name), text).unwrap();
    }
    views
}

fn numbers(value: &Value) -> Vec<f32> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap() as f32).collect()
}

fn near(found: &[f32], expected: &[f32], most: f32) {
    let is_near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= most);
    assert!(found.len() == expected.len() && is_near, "{found:?}, expected {expected:?}");
}

#[test]
fn what_is_asked_and_answered_is_in_the_coordinates_of_the_files() {
    let place = Place::new();
    let views = write_capture(&place);
    place.ok("train capture --out m.pnerf --json --quiet --exposure off --log2-hashmap-size 10 \
         --batch-rays 256 --steps 90 --scale 0.4 --aabb=7.5,17,27.5,12.5,22.5,32.5 \
         --save-every 0.000001");
    let info = place.ok("info m.pnerf --json");
    near(&numbers(&info["world"]["up"]), &[0.0, -1.0, 0.0], 0.02);
    near(&[info["world"]["metres"].as_f64().unwrap() as f32], &[0.4], 1e-6);
    // Seen through the loader, and from where COLMAP says: the same picture.
    let score = place.ok("eval m.pnerf capture --split train --json --quiet --out eval");
    let seen = &score["per_view"][0];
    assert_eq!(seen["name"], "images/01.png");
    let seen = seen["psnr"].as_f64().unwrap() as f32;
    let view = &views[1];
    let rows: Vec<String> =
        pose(&view.camera).transpose().to_cols_array().map(|v| v.to_string()).into();
    std::fs::write(place.path("pose.txt"), format!("[{}]", rows.join(","))).unwrap();
    let fov = 2.0 * (0.5 * view.camera.width as f32 / view.camera.focal[0]).atan().to_degrees();
    place.ok(&format!(
        "render m.pnerf --pose pose.txt --width 25 --height 25 --fov {fov} --background white \
         --json --out own.png"
    ));
    let picture = image_file::open(place.path("own.png")).unwrap().to_rgb8().into_raw();
    let photograph = view.rgba.as_chunks::<4>().0.iter().flat_map(|pixel| {
        let alpha = f32::from(pixel[3]) / 255.0;
        [0, 1, 2].map(|c| f32::from(pixel[c]) * alpha + 255.0 * (1.0 - alpha))
    });
    let squares = picture.iter().zip(photograph).map(|(a, b)| (f32::from(*a) - b).powi(2));
    let psnr = -10.0 * (squares.sum::<f32>() / picture.len() as f32 / 65025.0).log10();
    assert!(psnr > 14.5 && (psnr - seen).abs() < 0.3, "{psnr} dB, {seen} through the loader");
    // The surface lies where COLMAP's points would.
    let mesh =
        place.ok("export m.pnerf --mesh m.ply --resolution 40 --crop 7,15,26,13,25,34 --json");
    let [low, high] = [0, 1].map(|corner| numbers(&mesh["bounds"][corner]));
    let corners = [[-0.84, -0.84, -0.72], [0.84, 0.84, 0.95]].map(|p| moved(p.into()));
    let middle = |a: usize| 0.5 * (corners[0][a] + corners[1][a]);
    near(&[0, 1, 2].map(|a| 0.5 * (low[a] + high[a])), &[0, 1, 2].map(middle), 1.0);
    assert!((0..3).all(|a| (2.0..6.5).contains(&(high[a] - low[a]))), "{low:?} {high:?}");
    near(&numbers(&mesh["up"]), &[0.0, -1.0, 0.0], 0.02);
    // What was said is the run's: the same box, and other words are not needed.
    place.ok("train capture --resume m.ckpt.pnerf --aabb=7.5,17,27.5,12.5,22.5,32.5 --out r.pnerf --quiet");
    assert!(place.bytes("r.pnerf") == place.bytes("m.pnerf"));
    // Said anew, of a model that is there; the rest of the file stays.
    place.ok("repack m.pnerf n.pnerf --up z --scale 3 --json");
    let again = place.ok("info n.pnerf --json");
    assert_eq!(
        (numbers(&again["world"]["up"]), &again["world"]["metres"]),
        (vec![0.0, 0.0, 1.0], &3.0.into())
    );
    assert_eq!(again["world"]["scale"], info["world"]["scale"]);
    place.ok("render n.pnerf --pose pose.txt --width 25 --height 25 --background white --json --out n.png");
    let [a, b] = ["--up q", "--scale 0"].map(|wrong| {
        let output = place.run(&format!("repack m.pnerf o.pnerf {wrong}"));
        assert!(!output.status.success());
        String::from_utf8(output.stderr).unwrap()
    });
    assert!(a.contains("three numbers that are not all 0") && b.contains("1e-6 to 1e6"), "{a}{b}");
}
