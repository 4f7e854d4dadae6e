//! Where cameras and scenes end up.

use std::f64::consts::FRAC_PI_2;

use pocketnerf_core::Camera;
use pocketnerf_formats::Scene;
use pocketnerf_train::dataset::{Dataset, View};

use super::all;
use super::fixture::{Capture, image};
use crate::fixture::near;

fn looks(view: &View) -> ([f32; 3], [f32; 3]) {
    let ray = view.ray(4.0, 2.0);
    (ray.origin, ray.direction)
}

/// The cameras look at (1, 2, 3), which becomes the origin, and see points at depths of 3, 4
/// and 5: 4 becomes 1. They are upright, so that z stays up; most of them are on the side of
/// -y, which becomes +x, and +x becomes +y.
#[test]
fn a_capture_around_something() {
    let dataset = all(&Capture::around().folder(), 1);
    assert_eq!((dataset.format, dataset.forward_facing), ("colmap", false));
    let names: Vec<_> = dataset.views.iter().map(|view| view.name.as_str()).collect();
    assert_eq!(names, ["images/a.png", "images/b.png", "images/sub/c d.png"]);
    let expected = [
        ([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]),
        ([0.0, 1.0, 0.0], [0.0, -1.0, 0.0]),
        ([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]),
    ];
    for (view, (position, direction)) in dataset.views.iter().zip(expected) {
        let (at, along) = looks(view);
        assert!(near(at, position) && near(along, direction), "{at:?} {along:?}");
        // What is above is shown above: half a unit up, one away, 8 pixels focal length.
        let [x, y] = view.project([0.0, 0.0, 0.25]).unwrap();
        assert!((x - 4.0).abs() < 1e-4 && (y - 0.0).abs() < 1e-4, "{x} {y}");
    }
    assert!(near(dataset.bounds.unwrap(), [0.75, 1.25]));
    // The points reach 0.25 to each side; half of their box is added.
    let [low, high] = dataset.reach.unwrap();
    assert!(near(low, [-0.5; 3]) && near(high, [0.5; 3]), "{low:?} {high:?}");
    assert_eq!(dataset.aabb, None);
    assert_eq!(
        dataset.notes,
        ["27 3-D points in at least 3 images, at depths from 0.750 to 1.250, say where the scene \
          is; the world is turned and scaled by that"]
    );
}

fn in_files(dataset: &Dataset, view: usize) -> Camera {
    dataset.camera_in_files(&dataset.views[view].camera)
}

/// Cameras, boxes and what is up, as COLMAP has them.
#[test]
fn the_way_back_to_the_files() {
    let dataset = all(&Capture::around().folder(), 1);
    let positions = [[1.0, -2.0, 3.0], [5.0, 2.0, 3.0], [-3.0, 2.0, 3.0]];
    let axes = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
    for (i, (position, axis)) in positions.into_iter().zip(axes).enumerate() {
        let camera = in_files(&dataset, i);
        assert!(near(camera.position(), position) && near(camera.axis(), axis), "{camera:?}");
    }
    let (scene, world) = (dataset.scene(), dataset.world());
    assert!((scene.scale - 4.0).abs() < 1e-5 && near(world.up.unwrap(), [0.0, 0.0, 1.0]));
    // -y becomes +x, and +x becomes +y, a quarter as long.
    let [low, high] = dataset.box_as_read([[0.0, 1.0, 3.0], [5.0, 2.0, 4.0]]);
    assert!(near(low, [0.0, -0.25, 0.0]) && near(high, [0.25, 1.0, 0.25]), "{low:?} {high:?}");
    // In a model that was trained on it a camera is where it was read; in one whose coordinates
    // are the files', where they say; a model that says nothing was trained on what is read.
    let camera = &dataset.views[1].camera;
    let files = Scene { translation: [1.0, 0.0, 0.0], ..Scene::default() };
    assert_eq!(dataset.camera_in_model(camera, &scene), *camera);
    assert_eq!(dataset.camera_in_model(camera, &Scene::default()), *camera);
    assert!(near(dataset.camera_in_model(camera, &files).position(), [4.0, 2.0, 3.0]));
}

/// Side by side 1 apart they look along +y, at points from 3 to 5 away: as in captures of
/// LLFF the nearest depth becomes 4/3 and the average camera looks along -z.
#[test]
fn a_capture_that_looks_forward() {
    let mut capture = Capture::around();
    let at = |x: f64| [x, -2.0, 3.0];
    capture.images = vec![
        image(1, "a.png", at(0.0), 0.0),
        image(2, "b.png", at(1.0), 0.0),
        image(3, "c.png", at(2.0), 0.0),
    ];
    let dataset = all(&capture.folder(), 1);
    assert!(dataset.forward_facing && dataset.reach.is_none());
    assert!(near(dataset.bounds.unwrap(), [4.0 / 3.0, 20.0 / 9.0]));
    for (view, x) in dataset.views.iter().zip([-4.0 / 9.0, 0.0, 4.0 / 9.0]) {
        let (at, along) = looks(view);
        assert!(near(at, [x, 0.0, 0.0]) && near(along, [0.0, 0.0, -1.0]), "{at:?} {along:?}");
    }
    for (view, x) in [0.0, 1.0, 2.0].into_iter().enumerate() {
        assert!(near(in_files(&dataset, view).position(), at(x).map(|v| v as f32)));
    }
    assert!(near(dataset.world().up.unwrap(), [0.0, 0.0, 1.0]));
    // One of them, turned by 100 degrees, looks 72 aside of the mean, and shows 29 more.
    capture.images[1] = image(2, "b.png", at(1.0), 100f64.to_radians());
    assert!(!all(&capture.folder(), 1).forward_facing);
}

/// The same world 1000 times larger, turned by 90 degrees around x and moved, as far as the
/// globe's middle: p becomes 1000 (x, -z, y) + (7, 8, 9) 10^6.
#[test]
fn scale_and_axes_mean_nothing() {
    let own = Capture::around();
    let mut other = own.clone();
    for point in &mut other.points {
        let [x, y, z] = *point;
        *point = [1000.0 * x + 7e6, -1000.0 * z + 8e6, 1000.0 * y + 9e6];
    }
    for image in &mut other.images {
        // To its camera, a point is turned back first: q * (cos 45°, -sin 45°, 0, 0).
        let ([w, x, y, z], c) = (image.rotation, 0.5f64.sqrt());
        image.rotation = [c * (w + x), c * (x - w), c * (y - z), c * (z + y)];
        // R R' (p - m) + 1000 t = R R' p + 1000 t - R R' m.
        let moved = turn(image.rotation, [7e6, 8e6, 9e6]);
        let translation = image.translation;
        image.translation = std::array::from_fn(|a| 1000.0 * translation[a] - moved[a]);
    }
    same(&all(&own.folder(), 1), &all(&other.folder(), 1));
}

/// p turned by a quaternion: p + 2 w (v x p) + 2 v x (v x p).
fn turn([w, x, y, z]: [f64; 4], p: [f64; 3]) -> [f64; 3] {
    let cross = |p: [f64; 3]| [y * p[2] - z * p[1], z * p[0] - x * p[2], x * p[1] - y * p[0]];
    let once = cross(p);
    let twice = cross(once);
    std::array::from_fn(|a| p[a] + 2.0 * (w * once[a] + twice[a]))
}

fn same(a: &Dataset, b: &Dataset) {
    assert_eq!(a.views.len(), b.views.len());
    for (a, b) in a.views.iter().zip(&b.views) {
        let (m, n) = (a.camera.camera_to_world, b.camera.camera_to_world);
        assert!(m.iter().zip(n).all(|(a, b)| (a - b).abs() < 1e-5), "{m:?} {n:?}");
    }
    let (a, b) = (a.reach.unwrap(), b.reach.unwrap());
    assert!(a.as_flattened().iter().zip(b.as_flattened()).all(|(a, b)| (a - b).abs() < 1e-5));
}

/// Without points, cameras say how large the scene is: they are 1 away from what they look at.
#[test]
fn a_capture_without_points() {
    let mut capture = Capture::around();
    capture.points.truncate(19);
    let folder = capture.folder();
    let few = all(&folder, 1);
    folder.remove("sparse/0/points3D.bin");
    let none = all(&folder, 1);
    for dataset in [few, none] {
        assert_eq!((dataset.bounds, dataset.reach), (None, None));
        assert!(near(dataset.views[0].camera.position(), [1.0, 0.0, 0.0]));
        assert!(dataset.notes[0].starts_with("too few 3-D points"), "{:?}", dataset.notes);
    }
}

/// Points that are far off, one in a hundred, change nothing; and where points are farther away
/// than 2.5 median depths the box ends.
#[test]
fn points_that_are_wrong_and_points_that_are_far() {
    let mut capture = Capture::around();
    let around = capture.points.clone();
    for _ in 0..8 {
        capture.points.extend(&around);
    }
    capture.points.extend([[1e5, 2.0, 3.0], [1.0, 2.0, -1e7]]);
    let [low, high] = all(&capture.folder(), 1).reach.unwrap();
    assert!(near(low, [-0.5; 3]) && near(high, [0.5; 3]), "{low:?} {high:?}");
    // A twelfth of all is 100 to the side of +x, which is +y here.
    capture.points.extend((0..20).map(|_| [101.0, 2.0, 3.0]));
    let [low, high] = all(&capture.folder(), 1).reach.unwrap();
    assert!(near([low[0], low[2]], [-0.5; 2]) && near([high[0], high[2]], [0.5; 2]));
    assert!(near([low[1], high[1]], [-2.5, 2.5]), "{low:?} {high:?}");
}

#[test]
fn cameras_turn_as_said() {
    // At the origin, turned by 90 degrees from +y to -x: forward is -x.
    let own = image(1, "a.png", [0.0; 3], FRAC_PI_2);
    let [right, down, forward] = turn(own.rotation, [-1.0, 0.0, 0.0]);
    assert!(right.abs() < 1e-9 && down.abs() < 1e-9 && (forward - 1.0).abs() < 1e-9);
}
