use glam::Vec3;
use pocketnerf_core::{Camera, Ray};
use pocketnerf_train::lens::Lens;

use super::planes::Planes;
use super::*;
use crate::network::testing::check;

fn camera(eye: [f32; 3], side: u32) -> Camera {
    let pose = Camera::look_at(eye, [0.0; 3], [0.0, 1.0, 0.0]);
    Camera::from_fov_x(side, side, 0.9, pose)
}

#[test]
fn planes_are_where_the_camera_sees_their_pixels() {
    let camera = camera([0.3, 0.2, 4.0], 9);
    let planes = Planes::new(camera, 5, [2.0, 8.0]);
    assert_eq!(planes.depths[0], 2.0);
    assert!(
        (planes.depths[2] - 3.2).abs() < 1e-5,
        "evenly spaced in disparity: {:?}",
        planes.depths
    );
    assert!((planes.depths[4] - 8.0).abs() < 1e-5);
    for k in 0..5 {
        let point = planes.point(k, 3, 6);
        let seen = camera.project(point).unwrap();
        assert!((seen[0] - 3.5).abs() < 1e-3 && (seen[1] - 6.5).abs() < 1e-3, "{seen:?}");
        // From elsewhere, a ray to this point meets the same pixel.
        let eye = Vec3::new(-1.0, 0.5, 5.0);
        let direction = (Vec3::from(point) - eye).normalize().to_array();
        let local = planes.local(&Ray { origin: eye.to_array(), direction }).unwrap();
        let spot = planes.spot(&local, k).unwrap();
        let at = [spot.first % 9, spot.first / 9];
        let found = [0, 1].map(|a| at[a] as f32 + spot.fraction[a]);
        assert!((found[0] - 3.0).abs() < 1e-3 && (found[1] - 6.0).abs() < 1e-3, "{found:?}");
    }
    // Who looks the other way sees no plane.
    assert!(planes.local(&Ray { origin: [0.0; 3], direction: [0.0, 0.0, 1.0] }).is_none());
}

#[test]
fn planes_hide_what_is_behind_them() {
    let camera = camera([0.0, 0.0, 4.0], 4);
    // Red, half transparent, before opaque green.
    let near = vec![[1.0, 0.0, 0.0, 0.5]; 16];
    let far = vec![[0.0, 1.0, 0.0, 1.0]; 16];
    let shape = Shape::new(&camera, [3.0, 5.0], 2);
    let packed = Packed::new(shape, [near, far].par_iter().map(|plane| &plane[..]));
    let llff = Llff { images: vec![packed] };
    assert!(llff.is_sound());
    let mut rgba = vec![0.0; 4 * 16];
    llff.prepare().paint(&camera, &Lens::Pinhole, &mut rgba).unwrap();
    let middle = &rgba[4 * 5..4 * 6];
    // An opacity of a half is 128 of 255.
    let expected = [128.0 / 255.0, 127.0 / 255.0, 0.0, 1.0];
    let near = middle.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-5);
    assert!(near, "{middle:?}");
}

#[test]
fn a_sweep_finds_the_plane_of_a_wall() {
    // A striped wall at z = 0, four units before three cameras.
    let wall = |x: f32, y: f32| [0.5 + 0.5 * (9.0 * x).sin(), 0.5 + 0.5 * (7.0 * y).cos(), 0.3];
    let view = |x: f32| {
        let eye = Vec3::new(x, 0.0, 4.0);
        let pose =
            [1.0, 0.0, 0.0, eye.x, 0.0, 1.0, 0.0, eye.y, 0.0, 0.0, 1.0, eye.z, 0.0, 0.0, 0.0, 1.0];
        let camera = Camera::from_fov_x(48, 48, 0.8, pose);
        let pixels = (0..48 * 48).flat_map(|pixel| {
            let ray = camera.ray((pixel % 48) as f32 + 0.5, (pixel / 48) as f32 + 0.5);
            let (o, d) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
            let at = o - d * (o.z / d.z);
            wall(at.x, at.y).map(|c| (255.0 * c) as u8)
        });
        let mut photograph = Photograph::plain(camera, [0; 3]);
        photograph.rgb = pixels.collect();
        photograph
    };
    let views = [-0.3, 0.0, 0.3].map(view);
    let planes = Planes::new(views[1].camera, 9, [2.0, 6.0]);
    let distance = |k: &usize| (planes.depths[*k] - 4.0).abs();
    let wall = (0..9).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
    let values = sweep(&planes, &views[1], &[&views[0], &views[2]]);
    let middle = (12..36).flat_map(|y| (12..36).map(move |x| 48 * y + x));
    let found = middle.clone().filter(|pixel| {
        let mut light = 1.0;
        let shares: Vec<f32> = (0..9)
            .map(|k| {
                let share = light * values[k][*pixel][3];
                light -= share;
                share
            })
            .collect();
        let most = (0..9).max_by(|a, b| shares[*a].total_cmp(&shares[*b])).unwrap();
        most.abs_diff(wall) <= 1
    });
    let (found, all) = (found.count(), middle.count());
    assert!(found * 10 > all * 9, "{found} of {all} pixels");
}

#[test]
fn gradients_are_those_of_the_loss() {
    let planes = Planes::new(camera([0.0, 0.0, 4.0], 6), 3, [3.0, 6.0]);
    let from = camera([0.4, -0.3, 4.2], 6);
    let target = |pixel: u32| Target {
        ray: from.ray((pixel % 6) as f32 + 0.5, (pixel / 6) as f32 + 0.5),
        color: [0.2, 0.03 * pixel as f32, 0.9],
        counts: pixel != 14,
    };
    let targets: Vec<Target> = (0..36).map(target).collect();
    let parameters: Vec<f64> =
        (0..3 * 36 * 4).map(|i| 0.5 + 0.4 * f64::from(i * 7 + i % 5).sin()).collect();
    let seen = |parameters: &[f64]| {
        let values = parameters.as_chunks::<4>().0;
        let values: Vec<&[[f64; 4]]> = values.chunks(36).collect();
        let seen = Seen::of(&planes, &values, &targets, [1.0, 0.5, 0.0]);
        let gradient: Vec<f64> = (0..3).flat_map(|k| seen.gradient(k)).flatten().collect();
        (seen.error(), gradient)
    };
    // The gradient is that of the sum.
    let (_, gradient) = seen(&parameters);
    let met = targets.iter().filter(|target| {
        let local = planes.local(&target.ray);
        target.counts && local.is_some_and(|local| planes.spot(&local, 2).is_some())
    });
    let n = (3 * met.count()) as f64;
    assert!((30.0..100.0).contains(&n), "{n}");
    let tensors = (0..3).map(|k| k * 144..(k + 1) * 144);
    check(&parameters, tensors, &gradient, |p| seen(p).0 * n);
}

#[test]
fn a_short_run_leaves_photographs_out_all_over_the_scene() {
    for n in [1, 2, 3, 17, 100] {
        let mut all = order(n);
        if n == 100 {
            // The first quarter has no gap of more than a tenth.
            let mut first = all[..25].to_vec();
            first.sort_unstable();
            assert!(first.windows(2).all(|pair| pair[1] - pair[0] <= 10), "{first:?}");
        }
        all.sort_unstable();
        assert!(all.into_iter().eq(0..n));
    }
}

/// Two small images whose planes are of plain colours.
pub(crate) fn small() -> Llff {
    let image = |x: f32| {
        let shape = Shape::new(&camera([x, 0.1, 4.0], 6), [3.0, 5.0], 2);
        let planes = [[0.9, 0.2, 0.1 + 0.1 * x, 0.6], [0.1, 0.3, 0.8, 1.0]];
        let planes = planes.map(|value| vec![value; 36]);
        Packed::new(shape, planes.par_iter().map(|plane| &plane[..]))
    };
    Llff { images: vec![image(-0.4), image(0.5)] }
}
