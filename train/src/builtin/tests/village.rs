//! The village has no end: a ground, a sky, and what is near and far between them.

use crate::builtin::cameras::OUTDOORS;
use crate::builtin::contents::{Body, Contents};
use crate::builtin::render;
use crate::builtin::scenes::{VILLAGE_GROUND, contents};
use crate::builtin::shading::Light;
use crate::builtin::shapes::Shape;
use crate::builtin::sky::{CLOUD, HORIZON, ZENITH, sky};
use crate::builtin::surface::Surface;
use crate::builtin::{SIZE, Scene};
use crate::dataset::Split;
use glam::{DVec2, DVec3, dvec2, dvec3};
use pocketnerf_core::Camera;

/// Colour and depth in the middle of a picture.
fn seen(contents: &Contents, eye: DVec3, target: DVec3) -> ([u8; 4], f32) {
    let [eye, target] = [eye, target].map(|v| v.to_array().map(|x| x as f32));
    let pose = Camera::look_at(eye, target, [0.0, 1.0, 0.0]);
    let camera = Camera::from_fov_x(9, 9, 0.01, pose);
    let (rgba, depth) = render::view(contents, &camera);
    (rgba.as_chunks::<4>().0[4 * 9 + 4], depth[4 * 9 + 4])
}

/// Three units above the ground, four along it: five units to where they meet.
#[test]
fn the_ground_is_where_it_is() {
    let village = contents(Scene::Village);
    let eye = dvec3(-1.5, 1.0, VILLAGE_GROUND + 3.0);
    let (colour, depth) = seen(&village, eye, eye + dvec3(4.0, 0.0, -3.0));
    assert!((depth - 5.0).abs() < 1e-5, "{depth}");
    assert_eq!(colour[3], 255);
    // It has no end: half a unit above it, a thousandth down, it is 500 units away.
    let bare = Body::new(Shape::Ground { height: 0.0 }, Surface::Meadow);
    let bare = Contents::new(vec![bare], Vec::new(), Light::outdoors()).under_sky();
    let eye = dvec3(0.0, 0.0, 0.5);
    let [near, far] = [1.0, 3.0].map(|turn| {
        let level = dvec3(turn, 2.0, 0.0).normalize();
        let (colour, depth) = seen(&bare, eye, eye + level - DVec3::Z / 1000.0);
        assert!((depth - 500.0).abs() < 0.05, "{depth}");
        colour
    });
    // What lies that far away is plain: the middle between dark and light grass in the light
    // of everywhere and of a lamp whose direction has the height 12 / 13.
    assert_eq!(near, far);
    let light = (0.42_f64 + 0.72 * 12.0 / 13.0).sqrt();
    let grass = [0.40, 0.50, 0.22].map(|albedo| albedo * light);
    for (got, expected) in near.iter().zip(grass) {
        assert!((f64::from(*got) - 255.0 * expected).abs() <= 1.0, "{near:?}");
    }
    // Above the horizon there is none.
    let (colour, depth) = seen(&bare, eye, eye + DVec3::Y + DVec3::Z / 1000.0);
    assert_eq!((colour[3], depth), (255, f32::INFINITY));
}

/// The sky is the same from everywhere; at the horizon it has no clouds.
#[test]
fn the_sky_is_a_function_of_direction() {
    let village = contents(Scene::Village);
    let direction = dvec3(0.36, 0.48, 0.8);
    let looks = [dvec3(1.0, 2.0, 1.0), dvec3(-2.0, -1.0, 0.3)]
        .map(|eye| seen(&village, eye, eye + direction));
    assert_eq!(looks[0], looks[1]);
    let (colour, depth) = looks[0];
    assert_eq!((colour[3], depth), (255, f32::INFINITY));
    for (got, expected) in colour.iter().zip(sky(direction).to_array()) {
        assert!((f64::from(*got) - 255.0 * expected).abs() <= 1.5, "{colour:?}");
    }
    assert_eq!(sky(DVec3::X), HORIZON);
    // Clouds lie before what is clear: of the way from there to white, all colours have gone
    // the same share.
    let up = 0.8;
    let clear = HORIZON + (ZENITH - HORIZON) * (up * (2.0 - up));
    let share = (sky(direction) - clear) / (CLOUD - clear);
    assert!((share - DVec3::splat(share.x)).abs().max_element() < 1e-9, "{share}");
    assert!((0.0..=0.9).contains(&share.x), "{share}");
    let all: Vec<f64> = (0..64)
        .map(|i| {
            let around = dvec2(f64::from(i % 8) - 3.5, f64::from(i / 8) - 3.5) * 0.2;
            let d = around.extend(0.8).normalize();
            let clear = HORIZON + (ZENITH - HORIZON) * (d.z * (2.0 - d.z));
            (sky(d).x - clear.x) / (CLOUD.x - clear.x)
        })
        .collect();
    let range = [f64::min, f64::max].map(|of| all.iter().copied().reduce(of).unwrap());
    assert!(range[0] < 0.1 && range[1] > 0.6, "clouds and gaps: {range:?}");
}

/// A roof one unit wide on both sides and one high, with its ridge along x, and turned.
#[test]
fn roofs_have_slopes_and_ends() {
    let roof = |turn| Shape::Gable { base: DVec3::ZERO, half: dvec2(2.0, 1.0), height: 1.0, turn };
    let hit = |turn, origin, direction: DVec3| {
        roof(turn).enter(origin, direction.normalize()).map(|hit| (hit.t, hit.normal))
    };
    let diagonal = 0.5_f64.sqrt();
    let near = |found: Option<(f64, DVec3)>, t: f64, normal: DVec3| {
        let (at, outward) = found.expect("a hit");
        assert!((at - t).abs() < 1e-12 && outward.distance(normal) < 1e-12, "{found:?}");
    };
    // From above onto a slope, onto an end, and from below.
    near(hit(DVec2::X, dvec3(0.3, 0.5, 3.0), -DVec3::Z), 2.5, dvec3(0.0, diagonal, diagonal));
    near(hit(DVec2::X, dvec3(5.0, 0.2, 0.3), -DVec3::X), 3.0, DVec3::X);
    near(hit(DVec2::X, dvec3(0.3, -0.5, -1.0), DVec3::Z), 1.0, -DVec3::Z);
    near(hit(DVec2::Y, dvec3(0.5, 0.3, 3.0), -DVec3::Z), 2.5, dvec3(diagonal, 0.0, diagonal));
    // Beside an end, over the ridge, and away from it.
    assert_eq!(hit(DVec2::X, dvec3(5.0, 0.8, 0.3), -DVec3::X), None);
    assert_eq!(hit(DVec2::X, dvec3(0.0, 5.0, 1.1), -DVec3::Y), None);
    assert_eq!(hit(DVec2::X, dvec3(0.3, 0.5, 3.0), DVec3::Z), None);
    let [enter, leave] = roof(DVec2::X).span(dvec3(0.0, 5.0, 0.5), -DVec3::Y).expect("through");
    assert!((enter - 4.5).abs() < 1e-12 && (leave - 5.5).abs() < 1e-12, "{enter} {leave}");
}

/// Every pixel is opaque, and no camera is inside of a body or below the ground.
#[test]
fn cameras_stand_outside() {
    let factors = [0.1, 0.5, 0.8, 1.0, 1.1, 3.0];
    for camera in factors.into_iter().flat_map(|factor| Scene::Village.cameras(24, factor)) {
        let [view] = &Scene::Village.views(&[camera.downscaled(16)], "x")[..] else { panic!() };
        assert!(view.rgba.iter().skip(3).step_by(4).all(|&a| a == 255));
        let depth = view.depth.as_ref().expect("exact");
        let eye = camera.position();
        assert!(depth.iter().all(|&t| t > 0.2), "{eye:?}");
        assert!(eye[2] > VILLAGE_GROUND as f32 + 0.2, "{eye:?}");
    }
}

/// Most photographs show the well, the horizon and the sky; a good part of their pixels lies
/// far away, at all distances.
#[test]
fn near_and_far_are_seen() {
    let dataset = Scene::Village.dataset(Split::Test, 8);
    assert!(dataset.aabb.is_none() && !dataset.has_alpha);
    let mut count = [0; 5];
    let mut with_sky = 0;
    for view in &dataset.views {
        let depths = view.depth.as_ref().expect("exact");
        with_sky += u32::from(depths.iter().any(|t| t.is_infinite()));
        for t in depths {
            let limits = [4.5, 10.0, 20.0, 250.0, f32::MAX];
            count[limits.iter().position(|limit| t <= limit).unwrap_or(4)] += 1;
        }
    }
    let all = dataset.views.len() as f64 * f64::from(SIZE / 8).powi(2);
    let shares = count.map(|n| f64::from(n) / all);
    println!("{with_sky} of {} with sky, shares {shares:.3?}", dataset.views.len());
    assert_eq!(with_sky as usize, dataset.views.len());
    assert!(shares[0] > 0.2 && shares[1] > 0.1 && shares[2] > 0.02 && shares[3] > 0.02);
    assert!(shares[4] > 0.15);
    for camera in OUTDOORS.train() {
        let [x, y] = super::project(&camera, DVec3::ZERO);
        let inside = 0.0..f64::from(SIZE);
        assert!(inside.contains(&x) && inside.contains(&y), "{x} {y}");
    }
}
