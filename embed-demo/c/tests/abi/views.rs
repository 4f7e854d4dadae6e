//! Cameras that a model brings with it, and what is under their pixels.

use std::f32::consts::FRAC_PI_2;
use std::ptr::{null, null_mut};

use pocketnerf_c::{
    Camera, Hit, OPEN_MODEL_COORDINATES, Status, pnrf_default_camera, pnrf_orbit_camera,
    pnrf_photograph_camera, pnrf_photograph_count, pnrf_pick, pnrf_world,
};
use pocketnerf_core::query::Depth;
use pocketnerf_core::{Camera as CoreCamera, Ray, SimdLevel, Tuning};
use pocketnerf_formats::{World, open, with_world};

use crate::{GOLDEN, Open, STILL_LIFE, done, usual_options};

const PHOTOGRAPHS: &[u8] = include_bytes!("../../../../tests/golden/photographs-f16.pnerf");

fn camera(make: impl FnOnce(*mut Camera, *mut pocketnerf_c::Error) -> Status) -> Camera {
    let mut camera = unsafe { std::mem::zeroed() };
    done(|error| make(&raw mut camera, error));
    camera
}

fn column(camera: &Camera, c: usize) -> [f32; 3] {
    [0, 4, 8].map(|row| camera.camera_to_world[row + c])
}

#[track_caller]
fn assert_near(found: [f32; 3], expected: [f32; 3], most: f32) {
    let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(off <= most, "{found:?}, expected {expected:?}");
}

#[test]
fn cameras_of_photographs() {
    let model = Open::new(PHOTOGRAPHS, 0);
    assert_eq!(unsafe { pnrf_photograph_count(model.0) }, 3);
    let scene = open(PHOTOGRAPHS).unwrap().about.scene;
    // As the golden file has them: three cameras that look at the origin.
    let eyes = [[3.0, 0.0, 1.0], [0.0, -3.0, 0.5], [-2.0, 2.0, 2.0]];
    for (number, eye) in (0..).zip(eyes) {
        let found = camera(|camera, error| unsafe {
            pnrf_photograph_camera(model.0, number, 40, 30, camera, error)
        });
        assert_near(column(&found, 3), scene.to_dataset(eye), 1e-3);
        let ahead = [0, 1, 2].map(|a| scene.translation[a] - column(&found, 3)[a]);
        let length = ahead.iter().map(|v| v * v).sum::<f32>().sqrt();
        assert_near(column(&found, 2), ahead.map(|v| -v / length), 1e-3);
        // 0.75 radians for 40 pixels.
        assert!((found.focal[0] - 20.0 / 0.375f32.tan()).abs() < 1e-3, "{:?}", found.focal);
        assert_eq!((found.width, found.height, found.center), (40, 30, [20.0, 15.0]));
    }
    let mut untouched = unsafe { std::mem::zeroed::<Camera>() };
    let refused =
        unsafe { pnrf_photograph_camera(model.0, 3, 40, 30, &raw mut untouched, null_mut()) };
    assert_eq!((refused, untouched.width), (Status::Argument, 0));
    assert_eq!(unsafe { pnrf_photograph_count(Open::new(GOLDEN, 0).0) }, 0);
    assert_eq!(unsafe { pnrf_photograph_count(null()) }, 0);
}

#[test]
fn cameras_go_around_what_the_file_calls_up() {
    let world = World { up: Some([0.0, -1.0, 0.0]), metres: Some(0.5) };
    let bytes = with_world(&open(GOLDEN).unwrap(), &world).unwrap();
    let told = |flags| {
        let model = Open::new(&bytes, flags);
        let (mut up, mut metres) = ([0.0; 3], 0.0);
        done(|error| unsafe { pnrf_world(model.0, up.as_mut_ptr(), &raw mut metres, error) });
        let above = camera(|camera, error| unsafe {
            pnrf_orbit_camera(model.0, 0.0, FRAC_PI_2 / 3.0, 4.0, null(), 8, 6, camera, error)
        });
        (up, metres, above)
    };
    let (up, metres, above) = told(0);
    assert_eq!((up, metres), ([0.0, -1.0, 0.0], 0.5));
    let file = open(&bytes).unwrap();
    let centre = file.about.scene.to_dataset(file.model.space.center());
    // 30 degrees up: half of the distance along -y.
    let eye = [centre[0] + 2.0 * 3f32.sqrt(), centre[1] - 2.0, centre[2]];
    assert_near(column(&above, 3), eye, 1e-4);
    // In the model's coordinates the same direction, and as many metres as its unit has.
    let (up, metres, _) = told(OPEN_MODEL_COORDINATES);
    assert_near(up, file.about.scene.to_model_direction([0.0, -1.0, 0.0]), 1e-6);
    assert!((metres - 0.5 * file.about.scene.scale).abs() < 1e-6, "{metres}");
    let plain = Open::new(GOLDEN, 0);
    let mut metres = 1.0;
    done(|error| unsafe { pnrf_world(plain.0, null_mut(), &raw mut metres, error) });
    assert_eq!(metres, 0.0);
}

#[test]
fn a_camera_goes_around_the_centre() {
    let model = Open::new(GOLDEN, 0);
    let file = open(GOLDEN).unwrap();
    let centre = file.about.scene.to_dataset(file.model.space.center());
    let around = |azimuth, elevation, distance, up: Option<[f32; 3]>| {
        let up = up.as_ref().map_or(null(), |up| up.as_ptr());
        camera(|camera, error| unsafe {
            pnrf_orbit_camera(model.0, azimuth, elevation, distance, up, 8, 6, camera, error)
        })
    };
    let beside = |d: [f32; 3]| [0, 1, 2].map(|a| centre[a] + d[a]);
    assert_near(column(&around(0.0, 0.0, 5.0, None), 3), beside([5.0, 0.0, 0.0]), 1e-4);
    let left = around(FRAC_PI_2, 0.0, 5.0, None);
    assert_near(column(&left, 3), beside([0.0, 5.0, 0.0]), 1e-4);
    assert_near(column(&left, 1), [0.0, 0.0, 1.0], 1e-5);
    assert_near(column(&left, 2), [0.0, 1.0, 0.0], 1e-5);
    // 30 degrees up, y up: as high as half the distance.
    let above = around(0.0, FRAC_PI_2 / 3.0, 4.0, Some([0.0, 3.0, 0.0]));
    assert_near(column(&above, 3), beside([2.0 * 3f32.sqrt(), 2.0, 0.0]), 1e-4);
    // As far away as the default camera, with its field of view.
    let own = camera(|camera, error| unsafe { pnrf_default_camera(model.0, 8, 6, camera, error) });
    let usual = around(1.0, 0.3, 0.0, None);
    let far = |camera: &Camera| {
        let eye = column(camera, 3);
        (0..3).map(|a| (eye[a] - centre[a]).powi(2)).sum::<f32>().sqrt()
    };
    assert!((far(&usual) - far(&own)).abs() < 1e-4, "{} {}", far(&usual), far(&own));
    assert_eq!((usual.focal, usual.center), (own.focal, own.center));

    let mut untouched = unsafe { std::mem::zeroed::<Camera>() };
    let out = &raw mut untouched;
    for (azimuth, elevation, distance) in
        [(f32::NAN, 0.0, 1.0), (0.0, 1.6, 1.0), (0.0, f32::NAN, 1.0), (0.0, 0.0, -1.0)]
    {
        let status = unsafe {
            pnrf_orbit_camera(model.0, azimuth, elevation, distance, null(), 8, 6, out, null_mut())
        };
        assert_eq!(status, Status::Argument, "{azimuth} {elevation} {distance}");
    }
    let ndc = Open::new(include_bytes!("../../../../tests/golden/ndc-f16.pnerf"), 0);
    let status = unsafe { pnrf_orbit_camera(ndc.0, 0.0, 0.0, 0.0, null(), 8, 6, out, null_mut()) };
    assert_eq!((status, untouched.width), (Status::Unsupported, 0));
}

#[test]
fn what_is_under_pixels() {
    let (model, file) = (Open::new(STILL_LIFE, 0), open(STILL_LIFE).unwrap());
    let (usual, mut scratch) = (usual_options(), model.scratch(&usual_options()));
    let seen =
        camera(|camera, error| unsafe { pnrf_default_camera(model.0, 20, 15, camera, error) });
    let pixels: Vec<[f32; 2]> =
        (0..300).map(|i| [(i % 20) as f32 + 0.5, (i / 20) as f32 + 0.5]).collect();
    let mut hits = vec![Hit { depth: -1.0, point: [7.0; 3], normal: [7.0; 3] }; 300];
    let (p, out) = (pixels.as_ptr().cast(), hits.as_mut_ptr());
    let (m, (s, length)) = (model.0, (scratch.as_mut_ptr(), scratch.len()));
    done(|e| unsafe { pnrf_pick(m, &usual, &seen, p, 300, out, s, length, e) });

    let Camera { width, height, focal, center, camera_to_world } = seen;
    let core = CoreCamera { width, height, focal, center, camera_to_world };
    let rays: Vec<Ray> = pixels.iter().map(|[x, y]| core.ray(*x, *y)).collect();
    let probe = file.probe(SimdLevel::detect(), Tuning::FAST).unwrap();
    let mut own = vec![0.0; probe.scratch_len()];
    let (mut depths, mut normals) = (vec![0.0; 300], vec![[0.0; 3]; 300]);
    probe.depths(&rays, Depth::Median, None, &mut own, &mut depths).unwrap();
    probe.surface_normals(&rays, &depths, &mut own, &mut normals).unwrap();
    assert!(depths.iter().any(|t| t.is_finite()) && depths.contains(&f32::INFINITY));
    let mut towards = 0;
    for (((hit, ray), depth), normal) in hits.iter().zip(&rays).zip(&depths).zip(&normals) {
        assert_eq!((hit.depth, hit.normal), (*depth, *normal));
        if !depth.is_finite() {
            assert_eq!((hit.point, hit.normal), ([0.0; 3], [0.0; 3]));
            continue;
        }
        let place = [0, 1, 2].map(|a| ray.origin[a] + depth * ray.direction[a]);
        assert_near(hit.point, place, 1e-5);
        let length = normal.iter().map(|v| v * v).sum::<f32>();
        assert!((length - 1.0).abs() < 1e-4, "{normal:?}");
        let facing: f32 = normal.iter().zip(ray.direction).map(|(a, b)| a * b).sum();
        towards += u32::from(facing < 0.0);
    }
    // Surfaces that are seen face the camera, but for those at silhouettes.
    let hit = depths.iter().filter(|t| t.is_finite()).count() as u32;
    assert!(4 * towards > 3 * hit, "{towards} of {hit}");

    // Nothing is written unless all is right.
    let before = hits.clone();
    let out = hits.as_mut_ptr();
    let wrong = [[1.0, 1.0], [f32::NAN, 1.0]];
    let w = wrong.as_ptr().cast();
    let status = |pixels, n, length| unsafe {
        pnrf_pick(m, &usual, &seen, pixels, n, out, s, length, null_mut())
    };
    assert_eq!(status(w, 2, length), Status::Argument);
    assert_eq!(status(p, 300, 100), Status::Buffer);
    assert_eq!(status(null(), 1, length), Status::Null);
    assert_eq!(status(p, 0, length), Status::Ok);
    assert_eq!(hits, before);
}
