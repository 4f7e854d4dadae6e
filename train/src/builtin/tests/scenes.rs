//! The other scenes: frozen, and each with what it is there for.

use crate::builtin::cameras::AROUND;
use crate::builtin::contents::{Body, Contents};
use crate::builtin::render::ray;
use crate::builtin::scenes::contents;
use crate::builtin::scenes::wires::{CELL, WIDTHS};
use crate::builtin::shapes::Shape;
use crate::builtin::surface::Surface;
use crate::builtin::{HELD_OUT_VIEWS, SIZE, Scene, TRAIN_VIEWS, content_hash};
use crate::dataset::{Split, View};
use glam::DVec3;
use pocketnerf_core::Camera;

/// The hashes of the test views at a quarter of their size: a change makes earlier figures
/// on a scene incomparable.
const FROZEN: [(Scene, u64); 9] = [
    (Scene::StillLife, 0x6250_4555_2214_1313),
    (Scene::Wires, 0xc25e_140f_7c5b_1fa0),
    (Scene::Glossy, 0x38ec_2d83_4ede_de57),
    (Scene::Glass, 0x6b50_d99f_a6f3_8a08),
    (Scene::Foliage, 0xf127_732a_e710_24dd),
    (Scene::Fog, 0xd675_ea6c_ac77_bbbe),
    (Scene::White, 0xa563_0ecb_2d39_ce94),
    (Scene::Room, 0xa779_3891_0921_9884),
    (Scene::Village, 0x83e5_9e0b_3bc3_1fe3),
];

#[test]
fn contents_are_frozen() {
    assert_eq!(FROZEN.map(|(scene, _)| scene), Scene::ALL);
    let hash = |scene: Scene| content_hash(&scene.dataset(Split::Test, 4));
    let now = FROZEN.map(|(scene, _)| (scene, hash(scene)));
    assert_eq!(now, FROZEN, "now {now:#018x?}");
}

#[test]
fn names_are_found_again() {
    for scene in Scene::ALL {
        assert_eq!(Scene::named(scene.name()), Some(scene));
    }
    assert_eq!(Scene::named("wire"), None);
    assert_eq!(Scene::named(""), None);
}

/// Splits have the promised sizes, and validation, test and training have no view in common.
#[test]
fn splits_differ() {
    for scene in Scene::ALL.into_iter().filter(|scene| *scene != Scene::StillLife) {
        let [train, val, test] = [Split::Train, Split::Val, Split::Test].map(|split| {
            let dataset = scene.dataset(split, 16);
            assert_eq!(dataset.name(), format!("built-in scene {}", scene.name()));
            assert_eq!(dataset.has_alpha, !matches!(scene, Scene::Room | Scene::Village));
            dataset.views
        });
        assert_eq!(
            (train.len(), val.len(), test.len()),
            (TRAIN_VIEWS, HELD_OUT_VIEWS, HELD_OUT_VIEWS)
        );
        let nearest = |view: &View, among: &[View]| {
            let eye = position(&view.camera);
            let distances = among.iter().map(|other| position(&other.camera).distance(eye));
            distances.fold(f64::INFINITY, f64::min) / position(&view.camera).length()
        };
        for view in &val {
            assert!(nearest(view, &train) > 0.15 && nearest(view, &test) > 0.15, "{}", view.name);
        }
        for view in &test {
            assert!(nearest(view, &train) > 0.15, "{}", view.name);
        }
    }
}

/// Any number of cameras, nearer and farther, off the training path.
#[test]
fn cameras_spread_over_the_region() {
    for n in [1, 7, 100] {
        let cameras = Scene::Glass.cameras(n, 1.5);
        assert_eq!(cameras.len(), n);
        for (i, camera) in cameras.iter().enumerate() {
            let eye = position(camera);
            assert!((eye.length() - 6.0).abs() < 1e-5, "{eye}");
            let others = cameras.iter().enumerate().filter(|(k, _)| *k != i);
            let nearest = others.map(|(_, other)| position(other).distance(eye) / 6.0);
            // The region's area, on a sphere of radius 1, is 7.1.
            let least = 0.75 * (7.1 / n as f64).sqrt();
            assert!(nearest.fold(f64::INFINITY, f64::min) > least, "{i} of {n}");
        }
    }
}

/// Every width is found in pictures: a wire's coverage, summed across it, is its width in
/// pixels.
#[test]
fn wires_are_as_wide_as_they_say() {
    let wires = contents(Scene::Wires);
    for (cells, colour) in WIDTHS {
        let radius = 0.5 * cells * CELL;
        let upright = wires.bodies.iter().find(|body| {
            matches!(body.shape, Shape::Wire { from, to, radius: r } if r == radius && from.x == to.x)
        });
        let body = *upright.expect("an upright wire of each width");
        let Shape::Wire { from, to, .. } = body.shape else { unreachable!() };
        let middle = 0.5 * (from + to);
        let camera = towards(middle, middle - DVec3::Y * 4.0, 100);
        let view = &render(&Contents::solid(vec![body]), &camera);
        let row = &view.rgba[4 * 50 * 100..4 * 51 * 100];
        let width: f64 = row.iter().skip(3).step_by(4).map(|&a| f64::from(a) / 255.0).sum();
        let expected = 2.0 * radius * f64::from(camera.focal[0]) / 4.0;
        println!("{cells} cells, {colour}: {width:.2} pixels, expected {expected:.2}");
        assert!((width - expected).abs() < 0.1, "{width} {expected}");
    }
}

/// The colour of a surface point, seen by two cameras a few degrees apart. On polished
/// bodies it changes, and on others not.
#[test]
fn glossy_changes_with_the_view() {
    let change = |scene: Scene| {
        let step = |x: f32| Camera::look_at([x, -3.4, 2.0], [0.0; 3], [0.0, 0.0, 1.0]);
        let cameras =
            [-0.3, 0.3].map(|x| Camera::from_fov_x(SIZE / 2, SIZE / 2, AROUND.fov_x, step(x)));
        let views = scene.views(&cameras, "x");
        let depths = |i: usize| views[i].depth.as_ref().expect("exact");
        let (mut sum, mut count) = (0.0, 0.0);
        for y in 0..SIZE / 2 {
            for x in 0..SIZE / 2 {
                let i = (y * (SIZE / 2) + x) as usize;
                let t = f64::from(depths(0)[i]);
                if !t.is_finite() {
                    continue;
                }
                let (origin, direction) = ray(&cameras[0], f64::from(x) + 0.5, f64::from(y) + 0.5);
                let p = origin + direction * t;
                let [u, v] = super::project(&cameras[1], p);
                if !(0.0..f64::from(SIZE / 2)).contains(&u.min(v))
                    || u.max(v) >= f64::from(SIZE / 2)
                {
                    continue;
                }
                let k = v as usize * (SIZE / 2) as usize + u as usize;
                // Seen by the second camera too.
                if (p.distance(position(&cameras[1])) - f64::from(depths(1)[k])).abs() < 0.02 {
                    let at = |view: &View, k: usize| {
                        DVec3::from([0, 1, 2].map(|c| f64::from(view.rgba[4 * k + c])))
                    };
                    sum += (at(&views[0], i) - at(&views[1], k)).abs().element_sum() / 3.0;
                    count += 1.0;
                }
            }
        }
        sum / count
    };
    let [glossy, white, foliage] = [Scene::Glossy, Scene::White, Scene::Foliage].map(change);
    println!("mean change: glossy {glossy:.1}, white {white:.1}, foliage {foliage:.1} of 255");
    assert!(glossy > 10.0 && white < 0.5 && glossy > 2.0 * foliage);
}

/// Glass is neither opaque nor empty, in many values: layers lie before each other.
#[test]
fn glass_is_partly_transparent() {
    let views = Scene::Glass.dataset(Split::Test, 4).views;
    for view in &views {
        let alphas = view.rgba.iter().skip(3).step_by(4).map(|&a| f64::from(a) / 255.0);
        let count = |low, high| alphas.clone().filter(|a| (low..high).contains(a)).count();
        let pixels = (view.camera.width * view.camera.height) as usize;
        assert!(count(0.1, 0.9) > pixels / 20, "{}: {}", view.name, count(0.1, 0.9));
    }
    let all: Vec<_> = views.iter().flat_map(|v| v.rgba.iter().skip(3).step_by(4)).collect();
    // One pane, another, and both.
    for (alpha, what) in [(0.55, "blue"), (0.30, "amber"), (1.0 - 0.65 * 0.55, "red and green")] {
        let near = all.iter().filter(|&&&a| (f64::from(a) / 255.0 - alpha).abs() < 0.06);
        assert!(near.count() > 500, "{what}");
    }
}

/// Through three panes at right angles the picture shows their product of transmittances,
/// and where it falls to one half.
#[test]
fn layers_composite_exactly() {
    let camera = towards(DVec3::new(0.12, 0.0, 0.30), DVec3::new(0.12, -4.0, 0.30), 9);
    let view = render(&contents(Scene::Glass), &camera);
    // The green pane is turned: the way through it is longer by the secant, 1 / 0.96.
    let green = 1.0 - 0.55_f64.powf(1.0 / 0.96);
    let panes = [
        (0.35, DVec3::new(0.86, 0.16, 0.14)),
        (green, DVec3::new(0.10, 0.62, 0.36)),
        (0.55, DVec3::new(0.14, 0.34, 0.84)),
    ];
    let (mut colour, mut through) = (DVec3::ZERO, 1.0);
    for (alpha, tint) in panes {
        colour += tint * alpha * through;
        through *= 1.0 - alpha;
    }
    let middle = &view.rgba[4 * (4 * 9 + 4)..][..4];
    let expected = (colour / (1.0 - through)).extend(1.0 - through).to_array();
    for (got, expected) in middle.iter().zip(expected) {
        let got = f64::from(*got) / 255.0;
        assert!((got - expected).abs() < 1.5 / 255.0, "{middle:?} {expected:?}");
    }
    // 0.65 pass the red pane, 0.35 the green one too: half is lost inside the green one,
    // which lies 3.62 units away and is turned about its middle, 0.12 units to the left.
    let depth = f64::from(view.depth.as_ref().expect("exact")[4 * 9 + 4]);
    assert!((depth - (3.62 + 0.12 * 0.28 / 0.96)).abs() < 0.016, "{depth}");
}

/// Nothing is drawn twice: along no ray do two media overlap.
#[test]
fn media_do_not_overlap() {
    for scene in [Scene::Glass, Scene::Fog] {
        let contents = contents(scene);
        for camera in scene.cameras(40, 1.0) {
            let camera = camera.downscaled(8);
            for (x, y) in (0..50).flat_map(|y| (0..50).map(move |x| (x, y))) {
                let (origin, direction) = ray(&camera, f64::from(x), f64::from(y));
                let direction = contents.off_axes(direction);
                let passages = contents
                    .media
                    .iter()
                    .filter_map(|medium| medium.passage(origin, direction, f64::INFINITY));
                let mut spans: Vec<_> = passages.map(|passage| passage.span()).collect();
                spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
                assert!(spans.windows(2).all(|pair| pair[0][1] <= pair[1][0]), "{spans:?}");
            }
        }
    }
}

/// Along a ray through the middle of a fog of radius R, (1 − s²/R²)² has the integral 16/15 R.
#[test]
fn fog_has_its_closed_form() {
    let (center, radius, sigma) = (DVec3::new(0.72, -0.46, -0.34), 0.42, 4.0_f64);
    let eye = center + DVec3::new(3.0, 1.0, 0.5);
    let view = render(&contents(Scene::Fog), &towards(center, eye, 121));
    let middle = 60 * 121 + 60;
    let alpha = f64::from(view.rgba[4 * middle + 3]) / 255.0;
    let expected = 1.0 - (-sigma * radius * 16.0 / 15.0).exp();
    assert!((alpha - expected).abs() <= 1.0 / 255.0, "{alpha} {expected}");
    // Half the light is lost well before the middle.
    let depth = view.depth.as_ref().expect("exact");
    let distance = eye.distance(center);
    let half = f64::from(depth[middle]);
    assert!(half > distance - radius && half < distance, "{half} {distance}");
    // Where less than half is lost, there is no depth.
    assert!(view.rgba.as_chunks::<4>().0.iter().zip(depth).all(|(pixel, depth)| {
        pixel[3] == 0 || (pixel[3] > 120) == depth.is_finite() || pixel[3].abs_diff(127) < 12
    }));
}

#[test]
fn white_is_white() {
    for view in Scene::White.dataset(Split::Test, 4).views {
        let pixels = view.rgba.as_chunks::<4>().0.iter().filter(|pixel| pixel[3] > 0);
        assert!(pixels.clone().count() > 2500);
        let darkest = pixels.flat_map(|pixel| &pixel[..3]).min().copied();
        assert!(darkest >= Some(247), "{darkest:?}");
    }
}

/// Every pixel of a room is opaque, and no camera is inside of a body.
#[test]
fn room_is_closed() {
    let factors = [0.1, 0.5, 0.8, 1.0, 1.2, 3.0];
    for camera in factors.into_iter().flat_map(|factor| Scene::Room.cameras(24, factor)) {
        let eye = position(&camera);
        let [view] = &Scene::Room.views(&[camera.downscaled(16)], "x")[..] else { panic!() };
        assert!(view.rgba.iter().skip(3).step_by(4).all(|&a| a == 255), "{eye}");
        let depth = view.depth.as_ref().expect("exact");
        assert!(depth.iter().all(|&t| t > 0.08 && t < 5.5), "{eye}");
    }
    let dataset = Scene::Room.dataset(Split::Test, 16);
    assert!(dataset.aabb.is_some() && !dataset.has_alpha);
}

fn position(camera: &Camera) -> DVec3 {
    DVec3::from(camera.position().map(f64::from))
}

/// A camera of `size` × `size` pixels.
fn towards(target: DVec3, eye: DVec3, size: u32) -> Camera {
    let [eye, target] = [eye, target].map(|v| v.to_array().map(|x| x as f32));
    let fov_x = AROUND.fov_x * size as f32 / SIZE as f32;
    Camera::from_fov_x(size, size, fov_x, Camera::look_at(eye, target, [0.0, 0.0, 1.0]))
}

fn render(contents: &Contents, camera: &Camera) -> View {
    let (rgba, depth) = crate::builtin::render::view(contents, camera);
    View { depth: Some(depth), ..View::new("x", *camera, rgba) }
}

/// Rays exactly along axes meet what is there and nothing else.
#[test]
fn rays_may_run_along_axes() {
    let pillar = Shape::Cylinder { base: DVec3::ZERO, radius: 0.1, height: 1.0 };
    let block = Shape::block(DVec3::new(0.0, 0.0, -0.5), DVec3::splat(0.2));
    let surface = Surface::Plain(DVec3::ONE);
    for (shape, expected) in [(pillar, 3.0), (block, 4.3)] {
        let contents = Contents::solid(vec![Body::new(shape, surface)]);
        for (x, expected) in [(0.0, expected), (0.5, f32::INFINITY)] {
            let from = DVec3::new(x, 0.0, 4.0);
            let view = render(&contents, &towards(from - DVec3::Z, from, 9));
            assert_eq!(view.depth.expect("exact")[4 * 9 + 4], expected, "{shape:?} at {x}");
        }
    }
}
