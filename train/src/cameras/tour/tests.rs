//! Paths among photographs of known arrangement.

use pocketnerf_core::Camera;

use super::*;

const TARGET: Vec3 = Vec3::new(1.0, 2.0, 3.0);

fn at(azimuth: f32, elevation: f32) -> Vec3 {
    let ([sin, cos], [up, flat]) = ([azimuth.to_radians().sin(), azimuth.to_radians().cos()], {
        let (sin, cos) = elevation.to_radians().sin_cos();
        [sin, cos]
    });
    Vec3::new(flat * cos, flat * sin, up)
}

/// Four units from the target, which it looks at.
fn looking(azimuth: f32, elevation: f32) -> [f32; 16] {
    let eye = TARGET + 4.0 * at(azimuth, elevation);
    Camera::look_at(eye.into(), TARGET.into(), [0.0, 0.0, 1.0])
}

/// The largest angle between a pose of the path and the photograph nearest to it, degrees.
fn furthest(path: &[[f32; 16]], photographs: &[[f32; 16]]) -> f32 {
    let nearest = |pose: &[f32; 16]| {
        let angles = photographs.iter().map(|p| back(p).angle_between(back(pose)));
        angles.fold(f32::MAX, f32::min).to_degrees()
    };
    path.iter().map(nearest).fold(0.0, f32::max)
}

/// Poses change little from one to the next, and the last leads to the first.
fn is_steady(path: &[[f32; 16]]) {
    for (i, pose) in path.iter().enumerate() {
        let next = &path[(i + 1) % path.len()];
        assert!(back(pose).angle_between(back(next)).to_degrees() < 8.0, "{i}");
    }
}

/// The same, and all of them are upright.
fn is_smooth(path: &[[f32; 16]]) {
    is_steady(path);
    for pose in path {
        let [right, up] = [0, 1].map(|c| [pose[c], pose[4 + c], pose[8 + c]]);
        assert!(right[2].abs() < 1e-4 && up[2] > 0.0, "{pose:?}");
    }
}

#[test]
fn around_what_photographs_look_at() {
    // At all elevations, evenly spread.
    let photographs: Vec<_> = (0..100)
        .map(|i| looking(137.508 * i as f32, ((i as f32 + 0.5) / 105.0).asin().to_degrees()))
        .collect();
    let path = tour(&photographs, 90, Pace::Even).unwrap();
    is_smooth(&path);
    assert!(furthest(&path, &photographs) < 12.0);
    let mut around = 0.0;
    for (i, pose) in path.iter().enumerate() {
        assert!((position(pose).distance(TARGET) - 4.0).abs() < 1e-3);
        assert!(back(pose).distance((position(pose) - TARGET) / 4.0) < 1e-3);
        let [here, next] = [i, i + 1].map(|i| position(&path[i % 90]) - TARGET);
        around += here.truncate().angle_to(next.truncate());
    }
    assert!((around.abs() - TAU).abs() < 1e-3, "{around}");
}

#[test]
fn on_one_of_two_circles_not_between_them() {
    let photographs: Vec<_> = (0..40)
        .flat_map(|i| [looking(9.0 * i as f32, 0.0), looking(9.0 * i as f32 + 4.0, 50.0)])
        .collect();
    let path = tour(&photographs, 120, Pace::Even).unwrap();
    is_smooth(&path);
    assert!(furthest(&path, &photographs) < 7.0);
}

#[test]
fn to_and_fro_along_an_arc() {
    let photographs: Vec<_> =
        (0..30).map(|i| looking(200.0 + 6.0 * i as f32, 20.0 + (i % 3) as f32)).collect();
    let path = tour(&photographs, 120, Pace::Even).unwrap();
    is_smooth(&path);
    assert!(furthest(&path, &photographs) < 5.0);
    // From one end to the other, 174 degrees.
    let flat = |pose: &[f32; 16]| back(pose).truncate();
    let wide = flat(&path[0]).angle_to(flat(&path[60])).to_degrees().abs();
    assert!((wide - 174.0).abs() < 0.5, "{wide}");
}

/// Half of the photographs are taken from much further away; nobody has been in between.
#[test]
fn it_ends_where_photographs_move_on_by_a_stride() {
    let photographs: Vec<_> = (0..60)
        .map(|i| {
            let distance = if i < 35 { 4.0 } else { 8.0 };
            let eye = TARGET + distance * at(6.0 * i as f32, 20.0);
            Camera::look_at(eye.into(), TARGET.into(), [0.0, 0.0, 1.0])
        })
        .collect();
    let path = tour(&photographs, 100, Pace::Even).unwrap();
    is_smooth(&path);
    let distances: Vec<f32> = path.iter().map(|p| position(p).distance(TARGET)).collect();
    let (low, high) = distances.iter().fold((9f32, 0f32), |(l, h), d| (l.min(*d), h.max(*d)));
    assert!(low > 3.9 && high < 4.7, "{low} {high}");
    let wide = back(&path[0]).truncate().angle_to(back(&path[50]).truncate());
    assert!(furthest(&path, &photographs) < 5.0 && wide.abs().to_degrees() > 150.0, "{wide}");
}

/// On a curve that climbs from the equator over the side, and photographs in heaps beside it.
#[test]
fn from_photograph_to_photograph_where_there_is_no_ring() {
    let climb = (0..40).map(|i| looking(10.0 + 0.2 * i as f32, 1.8 * i as f32));
    let aside = (0..4).map(|i| looking(90.0 * i as f32 + 60.0, 1.0));
    let photographs: Vec<_> = aside.chain(climb).collect();
    let path = tour(&photographs, 120, Pace::Even).unwrap();
    assert!(furthest(&path, &photographs) < 3.0);
    let elevations: Vec<f32> = path.iter().map(|p| back(p).z.asin().to_degrees()).collect();
    let (low, high) = elevations.iter().fold((90f32, 0f32), |(l, h), e| (l.min(*e), h.max(*e)));
    assert!(low < 5.0 && high > 60.0, "{low} {high}");
    is_steady(&path);
    // As upright as these photographs.
    assert!(path.iter().all(|pose| pose[8].abs() < 0.01));
}

#[test]
fn an_ellipse_where_all_look_in_one_direction() {
    // Five by four, 1 and 0.5 apart, which look along y at one point, 20 away.
    let photographs: Vec<_> = (0..20)
        .map(|i| {
            let eye = [(i % 5) as f32, 0.0, 0.5 * (i / 5) as f32];
            Camera::look_at(eye, [2.0, 20.0, 0.75], [0.0, 0.0, 1.0])
        })
        .collect();
    let path = tour(&photographs, 60, Pace::Even).unwrap();
    is_smooth(&path);
    let middle = Vec3::new(2.0, 0.0, 0.75);
    for pose in &path {
        let away = position(pose) - middle;
        assert!(away.y.abs() < 0.02 && away.x.abs() < 2.05 && away.z.abs() < 0.8, "{away}");
        assert!(away.length() > 0.6, "{away}");
        let ahead = position(pose) - 20.0 * back(pose);
        assert!(ahead.distance(Vec3::new(2.0, 20.0, 0.75)) < 0.3, "{ahead}");
    }
}

#[test]
fn in_a_room_it_looks_around() {
    // Within two units of the middle, outwards.
    let photographs: Vec<_> = (0..60)
        .map(|i| {
            let out = at(6.0 * i as f32, (i % 5) as f32 * 5.0 - 10.0);
            let eye = TARGET + 2.0 * Vec3::new(out.x, out.y, 0.0);
            Camera::look_at(eye.into(), (eye + out).into(), [0.0, 0.0, 1.0])
        })
        .collect();
    let path = tour(&photographs, 120, Pace::Even).unwrap();
    is_smooth(&path);
    assert!(furthest(&path, &photographs) < 12.0);
    for pose in &path {
        let near = photographs.iter().map(|p| position(p).distance(position(pose)));
        assert!(near.fold(f32::MAX, f32::min) < 0.3);
        assert!(back(pose).dot(position(pose) - TARGET) < 0.0);
    }
}

#[test]
fn few_or_equal_photographs() {
    assert_eq!(tour(&[looking(0.0, 0.0), looking(9.0, 0.0)], 4, Pace::Even), None);
    let path = tour(&[looking(30.0, 10.0); 3], 4, Pace::Even).unwrap();
    assert!(path.iter().flatten().all(|x| x.is_finite()), "{path:?}");
    let not_poses = tour(&[[0.0; 16]; 3], 4, Pace::Even);
    assert_eq!(not_poses, None);
}
