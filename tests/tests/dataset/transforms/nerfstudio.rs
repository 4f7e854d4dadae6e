//! What nerfstudio's files say beyond cameras: panoramas, points, depths and the like.

use pocketnerf_train::dataset::{Dataset, LoadOptions, Split, load_with};

use super::{CAMERA, frames, only, scene, write};
use crate::fixture::{Folder, near, unit};
use crate::mutated::mutations;
use crate::refusals::refusal;

fn all(folder: &Folder) -> Dataset {
    let options = LoadOptions { hold_every: 0, ..LoadOptions::default() };
    load_with(folder.path(), Split::Train, &options).unwrap()
}

/// An image of 4x2 pixels, half of what the camera says: a quarter turn is a pixel wide, an eighth
/// of one up is half a pixel. The camera looks along +y with z up, from (0, -4, 1).
#[test]
fn panoramas() {
    for model in [r#""camera_model": "EQUIRECTANGULAR""#, r#""latlong": true"#] {
        for own in [CAMERA, r#""w": 8, "h": 4"#, r#""x": 0"#] {
            let view = only(&scene(&format!("{own}, {model}"), &["a.png"]));
            assert_eq!((view.lens.name(), &view.mask), ("equirectangular", &None));
            let ray = |x, y| view.ray(x, y);
            assert!(near(ray(2.0, 1.0).origin, [0.0, -4.0, 1.0]));
            assert!(near(ray(2.0, 1.0).direction, [0.0, 1.0, 0.0]));
            assert!(near(ray(3.0, 1.0).direction, [1.0, 0.0, 0.0]));
            assert!(near(ray(2.0, 0.5).direction, unit([0.0, 1.0, 1.0])));
            assert!(near(ray(0.5, 1.5).direction, unit([-0.5, -0.5, -0.5f32.sqrt()])));
        }
    }
    // Two cameras 2 apart: 2.5 to each side of their middle, since the farthest is 1 from it.
    let folder = scene(CAMERA, &["a.png", "b.png"]);
    let other = frames(&["b.png"], "").replace("[1, 0, 0, 0]", "[1, 0, 0, 2]");
    let both = format!("{}, {other}", frames(&["a.png"], ""));
    write(&folder, &format!(r#"{CAMERA}, "camera_model": "EQUIRECTANGULAR""#), &both);
    let dataset = all(&folder);
    assert_eq!(dataset.reach, Some([[-1.5, -6.5, -1.5], [3.5, -1.5, 3.5]]));
    assert!(dataset.notes[0].starts_with("panoramas do not tell how far the scene reaches: 2.500"));
}

/// 125 points, 0.1 apart around (0, 0, 1), 4 in front of the camera.
fn points() -> Vec<[f32; 3]> {
    let steps = || (-2..=2).map(|i| 0.1 * i as f32);
    let plane = steps().flat_map(|x| steps().map(move |y| (x, y)));
    plane.flat_map(|(x, y)| steps().map(move |z| [x, y, 1.0 + z])).collect()
}

/// The points as PLY, each with a byte before and after.
fn ply(form: &str) -> Vec<u8> {
    let header = format!(
        "ply\nformat {form} 1.0\ncomment by hand\nelement vertex 125\nproperty uchar red\n\
         property float x\nproperty float y\nproperty float z\nproperty uchar blue\n\
         element face 0\nproperty list uchar int vertex_index\nend_header\n"
    );
    let mut bytes = header.into_bytes();
    for point in points() {
        match form {
            "ascii" => {
                let [x, y, z] = point;
                bytes.extend(format!("9 {x} {y} {z} 8\n").bytes());
            }
            _ => {
                bytes.push(9);
                for axis in point {
                    let little = form == "binary_little_endian";
                    bytes.extend(if little { axis.to_le_bytes() } else { axis.to_be_bytes() });
                }
                bytes.push(8);
            }
        }
    }
    bytes
}

const FORMS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

#[test]
fn points_say_where_the_scene_is() {
    let camera = format!(r#"{CAMERA}, "ply_file_path": "./sparse_pc.ply""#);
    for form in FORMS {
        let folder = scene(&camera, &["a.png"]);
        folder.write("sparse_pc.ply", ply(form));
        let dataset = all(&folder);
        // From 3.8 to 4.2 away. One camera looks at no point: the box is around the points, half
        // their size to each side.
        let [near, far] = dataset.bounds.unwrap();
        assert!((near - 3.8).abs() < 1e-5 && (far - 4.2).abs() < 1e-5, "{near} {far}");
        let [low, high] = dataset.reach.unwrap();
        let expected = [[-0.4, -0.4, 0.6], [0.4, 0.4, 1.4]];
        for (found, expected) in low.iter().chain(&high).zip(expected.as_flattened()) {
            assert!((found - expected).abs() < 1e-5, "{low:?} {high:?}");
        }
        let said = "125 points of sparse_pc.ply, at depths from 3.800 to 4.200, say where the \
                    scene is";
        assert_eq!(dataset.notes, [said]);
    }
    // What cannot be used is said.
    let folder = scene(&camera, &["a.png"]);
    for (bytes, said) in [
        (None, "the points of sparse_pc.ply are not used: cannot be read: No such file"),
        (Some(b"pl".to_vec()), "the points of sparse_pc.ply are not used: no header of a PLY file"),
        (Some(ply("ascii")[..400].to_vec()), "the points of sparse_pc.ply are not used: "),
        // 224 bytes of header, and 14 for each vertex.
        (Some(ply(FORMS[1])[..600].to_vec()), {
            "the points of sparse_pc.ply are not used: cut off: 26 of 125 vertices"
        }),
        (
            Some(ply("ascii").iter().map(|c| if *c == b'x' { b'q' } else { *c }).collect()),
            "the points of sparse_pc.ply are not used: verteq before vertices, expected these first",
        ),
    ] {
        if let Some(bytes) = bytes {
            folder.write("sparse_pc.ply", bytes);
        }
        let dataset = all(&folder);
        assert!(dataset.notes[0].starts_with(said), "{:?}", dataset.notes);
        assert_eq!((dataset.bounds, dataset.reach), (None, None));
    }
}

#[test]
fn what_is_not_used_is_said() {
    let folder = scene(CAMERA, &["a.png", "b.png"]);
    folder.pixels("mask.png", [4, 2], |x, _| [255 * (x as u8 % 2); 3]);
    let more = r#", "mask_path": "mask.png", "depth_file_path": "depth.png""#;
    let list = format!("{}, {}", frames(&["a.png"], more), frames(&["b.png"], ""));
    write(&folder, &format!(r#"{CAMERA}, "orientation_override": "up""#), &list);
    assert_eq!(
        all(&folder).notes,
        [
            "1 frames have depths: they are not used",
            "orientation_override \"up\" is not applied: the world stays as it is",
            "1 of 2 images have no mask: all their pixels count",
        ]
    );
    let camera = format!(r#"{CAMERA}, "orientation_override": "none", "fisheye_crop_radius": 9"#);
    write(&folder, &camera, &frames(&["a.png"], ""));
    assert!(all(&folder).notes.is_empty());
    write(&folder, &format!("{camera}, \"is_fisheye\": true"), &frames(&["a.png"], ""));
    let message = refusal(folder.path());
    assert!(
        message.starts_with("D/transforms.json: \"fisheye_crop_radius\" cannot be read; apply")
    );
    for model in ["FISHEYE624", "ORTHOPHOTO", "VR180_L", "OMNIDIRECTIONALSTEREO_R"] {
        write(
            &folder,
            &format!("{CAMERA}, \"camera_model\": \"{model}\""),
            &frames(&["a.png"], ""),
        );
        let message = refusal(folder.path());
        let start =
            format!("D/transforms.json: camera_model \"{model}\" cannot be read; undistort");
        assert!(message.starts_with(&start), "{message}");
    }
}

#[test]
fn damaged_files() {
    let more = r#", "sharpness": 3, "mask_path": "a.png", "fl_x": 9, "k1": 0.1, "w": 4, "h": 2"#;
    let camera = format!(
        r#"{CAMERA}, "camera_model": "OPENCV", "ply_file_path": "p.ply", "aabb_scale": 4,
        "train_filenames": ["a.png"], "sharpness_discard_threshold": 0.5"#
    );
    let folder = scene(&camera, &["a.png"]);
    folder.pixels("a.png", [4, 2], |_, _| [9; 3]);
    write(&folder, &camera, &frames(&["a.png"], more));
    folder.write("p.ply", ply("binary_little_endian"));
    mutations(&folder, &["transforms.json"], 10_000);
    // Points that cannot be read are left out, so that nothing is refused.
    let options = LoadOptions { hold_every: 0, ..LoadOptions::default() };
    let mut random = pocketnerf_train::random::Random::new(5, [0; 3]);
    let mut used = [0, 0];
    for i in 0..10_000 {
        let mut bytes = ply(FORMS[i % 3]);
        pocketnerf_tests::damage::mutate(&mut random, &mut bytes);
        folder.write("p.ply", bytes);
        let dataset = load_with(folder.path(), Split::Train, &options).unwrap();
        used[usize::from(dataset.bounds.is_some())] += 1;
        let numbers = dataset.bounds.into_iter().flatten();
        assert!(numbers.chain(dataset.reach.into_iter().flatten().flatten()).all(f32::is_finite));
    }
    assert!(used.iter().all(|count| *count > 500), "{used:?}");
}
