use glam::Vec3;
use pocketnerf_core::Camera;
use pocketnerf_core::query::Similarity;

use super::look::Seen;
use super::mesh::Mesh;
use super::shapes::{edges, is_closed};
use super::volume::Volume;
use super::{Settings, colors, compare, nets, parts};
use crate::cameras::sphere;
use crate::dataset::View;
use crate::random::Random;

const RADIUS: f32 = 0.7;
const CENTER: Vec3 = Vec3::new(0.1, -0.2, 0.3);

/// What cameras see of a ball, red where x is above its middle and blue below.
fn ball(cameras: Vec<Camera>) -> Vec<Seen> {
    cameras.into_iter().map(|camera| see(camera, CENTER, RADIUS)).collect()
}

fn see(camera: Camera, center: Vec3, radius: f32) -> Seen {
    let (width, height) = (camera.width as usize, camera.height as usize);
    let (mut depth, mut color) = (Vec::new(), Vec::new());
    for pixel in 0..width * height {
        let ray = camera.ray((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5);
        let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
        let (along, away) = ((center - origin).dot(direction), (center - origin).length());
        let half = radius * radius - (away * away - along * along);
        let t = if half > 0.0 { along - half.sqrt() } else { f32::INFINITY };
        depth.push(t);
        let is_red = t.is_finite() && (origin + t * direction).x > center.x;
        color.push(if is_red { [255, 0, 0] } else { [0, 0, 255] });
    }
    Seen { camera, depth, color }
}

fn around(n: usize) -> Vec<Camera> {
    let space = pocketnerf_core::Space::Box {
        min: (CENTER - 1.0).to_array(),
        max: (CENTER + 1.0).to_array(),
    };
    sphere(&space, None, n, 160)
}

fn settings(watertight: bool) -> Settings {
    Settings { resolution: 64, watertight, ..Settings::default() }
}

fn mesh(seen: &[Seen], settings: &Settings) -> Mesh {
    let mut volume = Volume::around(seen, [CENTER - 0.75, CENTER + 0.75], settings);
    volume.fill(seen);
    let mut mesh = nets::mesh(&volume);
    colors::paint(&mut mesh, seen, volume.cut());
    mesh
}

fn volume_inside(mesh: &Mesh) -> f32 {
    let corners = mesh.triangles.iter().map(|triangle| mesh.corners(*triangle));
    corners.map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

#[test]
fn a_ball_is_found_where_it_is() {
    let seen = ball(around(40));
    let mesh = mesh(&seen, &settings(false));
    let voxel = 1.5 / 64.0;
    let mut sum = 0.0;
    for ((position, normal), color) in mesh.positions.iter().zip(&mesh.normals).zip(&mesh.colors) {
        let outwards = Vec3::from(*position) - CENTER;
        assert!((outwards.length() - RADIUS).abs() < 0.4 * voxel, "{}", outwards.length());
        let angle = outwards.angle_between(Vec3::from(*normal)).to_degrees();
        assert!(angle < 20.0, "{angle}");
        sum += angle;
        if outwards.x.abs() > 4.0 * voxel {
            assert_eq!(*color, if outwards.x > 0.0 { [255, 0, 0] } else { [0, 0, 255] });
        }
    }
    let mean = sum / mesh.positions.len() as f32;
    assert!(mean < 6.0, "{mean}");
    // Closed, each triangle facing outwards: every edge is there once in each direction.
    assert!(is_closed(&mesh));
    let exact = 4.0 / 3.0 * std::f32::consts::PI * RADIUS.powi(3);
    assert!((volume_inside(&mesh) / exact - 1.0).abs() < 0.01, "{}", volume_inside(&mesh));
    let exact = 4.0 * std::f64::consts::PI * f64::from(RADIUS).powi(2);
    assert!((mesh.area() / exact - 1.0).abs() < 0.01, "{}", mesh.area());
}

#[test]
fn what_nobody_sees_is_open_or_solid() {
    // From above alone.
    let cameras = around(40).into_iter().filter(|camera| camera.position()[2] > CENTER.z + 1.0);
    let seen = ball(cameras.collect());
    let open = mesh(&seen, &settings(false));
    let boundary = |mesh: &Mesh| {
        let edges = edges(mesh);
        edges.keys().filter(|[a, b]| !edges.contains_key(&[*b, *a])).count()
    };
    assert!(boundary(&open) > 20);
    let lowest = |mesh: &Mesh| mesh.positions.iter().map(|p| p[2]).fold(f32::INFINITY, f32::min);
    assert!(lowest(&open) > CENTER.z - RADIUS);
    let closed = mesh(&seen, &settings(true));
    assert_eq!(boundary(&closed), 0);
    assert!(lowest(&closed) < CENTER.z - RADIUS);
    assert!(volume_inside(&closed) > volume_inside(&open));
}

#[test]
fn specks_are_left_out() {
    let mut seen = ball(around(40));
    let whole = mesh(&seen, &settings(false));
    // A speck of fog beside the ball, which every camera sees.
    let speck = CENTER + Vec3::new(0.0, 0.0, 0.735);
    for seen in &mut seen {
        let fog = see(seen.camera, speck, 0.015);
        let depths = seen.depth.iter_mut().zip(fog.depth);
        depths.for_each(|(depth, fog)| *depth = depth.min(fog));
    }
    let mut spoilt = mesh(&seen, &settings(false));
    assert!(spoilt.triangles.len() > whole.triangles.len());
    parts::keep_large(&mut spoilt);
    let highest = spoilt.positions.iter().map(|p| p[2]).fold(f32::MIN, f32::max);
    assert!(highest < CENTER.z + RADIUS + 0.01, "{highest}");
    // Nothing else is lost.
    assert!((spoilt.area() / whole.area() - 1.0).abs() < 0.01);
}

#[test]
fn a_box_cuts() {
    let mut half = mesh(&ball(around(40)), &settings(false));
    let area = half.area();
    half.crop(
        [(CENTER - 2.0).to_array(), (CENTER + Vec3::new(0.0, 2.0, 2.0)).to_array()],
        &Similarity::IDENTITY,
    );
    assert!(half.positions.iter().all(|p| p[0] <= CENTER.x));
    assert!((half.area() / area - 0.5).abs() < 0.03, "{}", half.area() / area);
}

#[test]
fn smoothing_takes_out_noise_and_nothing_else() {
    let mut smoothed = mesh(&ball(around(40)), &settings(false));
    let exact = volume_inside(&smoothed);
    let mut random = Random::new(1, [0; 3]);
    for position in &mut smoothed.positions {
        let noise = [(); 3].map(|()| 0.01 * (random.next_f32() - 0.5));
        *position = (Vec3::from(*position) + Vec3::from(noise)).to_array();
    }
    let away = |mesh: &Mesh| {
        let away = mesh.positions.iter().map(|p| (Vec3::from(*p).distance(CENTER) - RADIUS).abs());
        away.sum::<f32>() / mesh.positions.len() as f32
    };
    let degrees = |mesh: &Mesh| {
        let vertices = mesh.positions.iter().zip(&mesh.normals);
        let angles = vertices.map(|(p, n)| (Vec3::from(*p) - CENTER).angle_between(Vec3::from(*n)));
        (angles.sum::<f32>() / mesh.positions.len() as f32).to_degrees()
    };
    super::smooth::smooth(&mut smoothed, 0);
    let noisy = [away(&smoothed), degrees(&smoothed)];
    super::smooth::smooth(&mut smoothed, 10);
    let smooth = [away(&smoothed), degrees(&smoothed)];
    assert!(smooth[0] < 0.75 * noisy[0] && smooth[1] < 0.5 * noisy[1], "{smooth:?} {noisy:?}");
    assert!((volume_inside(&smoothed) / exact - 1.0).abs() < 0.01);
    // An open border stays where it is.
    let mut cap = mesh(&ball(around(40)), &settings(false));
    cap.crop([[-9.0; 3], [9.0, 9.0, CENTER.z + 0.5]], &Similarity::IDENTITY);
    let highest = |mesh: &Mesh| mesh.positions.iter().map(|p| p[2]).fold(f32::MIN, f32::max);
    let before = highest(&cap);
    super::smooth::smooth(&mut cap, 10);
    assert_eq!(highest(&cap), before);
}

#[test]
fn a_mesh_is_compared_with_what_views_see() {
    let seen = ball(around(40));
    let view = |seen: &Seen| {
        let rgba = vec![255; 4 * seen.depth.len()];
        View { depth: Some(seen.depth.clone()), ..View::new("ball", seen.camera, rgba) }
    };
    let views: Vec<View> = seen.iter().map(view).collect();
    let right = mesh(&seen, &settings(false));
    let error = compare(&right, &views).unwrap();
    assert!(error.chamfer_percent < 0.2 && error.normal_degrees < 5.0, "{error:?}");
    // A ball of a radius that is 0.07 larger, as seen from its middle.
    let mut large = right.clone();
    for position in &mut large.positions {
        *position = (CENTER + 1.1 * (Vec3::from(*position) - CENTER)).to_array();
    }
    let error = compare(&large, &views).unwrap();
    assert!((error.accuracy - 0.07).abs() < 0.004, "{error:?}");
    assert!((error.completeness - 0.07).abs() < 0.004, "{error:?}");
    // The diagonal of the box around the ball is 2 √3 radii.
    let percent = 100.0 * 0.07 / (2.0 * 3_f64.sqrt() * f64::from(RADIUS));
    assert!((error.chamfer_percent / percent - 1.0).abs() < 0.06, "{error:?}");
    let without = [View::new("ball", seen[0].camera, Vec::new())];
    assert_eq!(compare(&right, &without), None);
}
