use super::*;
use crate::random::Random;

/// Numbers like a phone's, with all coefficients.
fn open_cv() -> Lens {
    Lens::open_cv([0.057_842_1, -0.080_509_9, 0.02, -0.003], [-0.000_980_296, 0.000_155_75])
}

fn fisheye() -> Lens {
    Lens::fisheye([-0.02, 0.013, -0.004, 0.0007])
}

fn full_open_cv() -> Lens {
    Lens::full_open_cv([0.1, -0.05, 0.02, 0.12, -0.03, 0.01], [0.001, -0.002])
}

fn thin_prism_fisheye() -> Lens {
    Lens::thin_prism_fisheye([0.02, -0.01, 0.003, -0.0004], [0.002, -0.001], [0.003, 0.004])
}

fn near(a: [f64; 2], b: [f64; 2]) -> bool {
    (0..2).all(|i| (a[i] - b[i]).abs() < 1e-12)
}

/// Expected values are from the formulas in Python's floats:
/// `d = 1+k1*s+k2*s**2+k3*s**3+k4*s**4` with `s = x*x+y*y`, then
/// `x*d+2*p1*x*y+p2*(s+2*x*x)`, `y*d+p1*(s+2*y*y)+2*p2*x*y`.
#[test]
fn open_cv_as_the_formula_says() {
    for ([x, y], expected) in [
        ([0.3, -0.6], [0.303_878_580_51, -0.608_058_119_22]),
        ([-0.45, 0.2], [-0.454_027_875_473_728_5, 0.201_569_231_486_101_56]),
        ([0.0, 0.7], [7.631_75e-5, 0.706_393_531_465_999_8]),
    ] {
        let found = open_cv().distort([2.0 * x, 2.0 * y, 2.0]).unwrap();
        assert!(near(found, expected), "{found:?}");
        let ([u, v, w], is_shown) = open_cv().undistort(expected);
        assert!(is_shown && w == 1.0);
        assert!((u - x).abs() < 2e-9 && (v - y).abs() < 2e-9, "{u} {v}");
    }
    assert_eq!(open_cv().distort([0.1, 0.1, -1.0]), None);
    assert_eq!(open_cv().distort([0.1, 0.1, 0.0]), None);
}

/// The same for `d = t*(1+k1*t**2+k2*t**4+k3*t**6+k4*t**8)`, directions at the angles
/// t = 0.3, 1.2 and 1.9 from the axis, 0.5, -2 and 3 around it; 1.9 is behind the camera.
#[test]
fn fisheye_as_the_formula_says() {
    for (direction, expected) in [
        (
            [0.259_343_380_052_230_8, 0.141_679_934_247_038_1, 0.955_336_489_125_606],
            [0.262_827_841_199_016_25, 0.143_583_504_047_290_98],
        ),
        (
            [-0.387_865_117_163_551_3, -0.847_500_742_570_959_2, 0.362_357_754_476_673_6],
            [-0.493_994_294_608_370_63, -1.079_397_225_943_044_7],
        ),
        (
            [-0.936_829_986_342_883_8, 0.133_541_876_001_500_97, -0.323_289_566_863_503_35],
            [-1.933_500_452_735_640_3, 0.275_613_805_570_016_6],
        ),
    ] {
        let found = fisheye().distort(direction).unwrap();
        assert!(near(found, expected), "{found:?}");
        let (back, is_shown) = fisheye().undistort(expected);
        let off = glam::DVec3::from(back).distance(direction.into());
        assert!(is_shown && off < 1e-12, "{back:?}");
    }
    // The axis itself.
    assert_eq!(fisheye().distort([0.0, 0.0, 2.0]), Some([0.0; 2]));
    assert_eq!(fisheye().undistort([0.0; 2]), ([0.0, 0.0, 1.0], true));
}

/// d/dr of r (1 - 0.2 r²) is 0 at r = 1 / √0.6 = 1.290994, which is shown at 0.860663:
/// farther out there is nothing.
#[test]
fn what_a_lens_cannot_show() {
    let lens = Lens::open_cv([-0.2, 0.0, 0.0, 0.0], [0.0; 2]);
    assert!(lens.distort([1.29, 0.0, 1.0]).is_some());
    assert_eq!(lens.distort([1.292, 0.0, 1.0]), None);
    assert!(lens.undistort([0.8606, 0.0]).1);
    // The farthest direction on that side.
    let ([x, y, z], is_shown) = lens.undistort([0.0, -2.0]);
    assert!(!is_shown);
    assert!(x == 0.0 && (y + 1.290_994).abs() < 1e-5 && z == 1.0, "{y}");
    // The same with a little tangential distortion, which goes through Newton's method.
    let lens = Lens::open_cv([-0.2, 0.0, 0.0, 0.0], [1e-3, 1e-3]);
    assert!(lens.undistort([0.6, 0.4]).1);
    assert!(!lens.undistort([1.5, 1.5]).1);
    assert!(!lens.undistort([f64::NAN, 0.0]).1);
}

#[test]
fn nothing_bends_without_coefficients() {
    assert_eq!(Lens::open_cv([0.0; 4], [0.0; 2]), Lens::Pinhole);
    let camera = camera();
    assert_eq!(Lens::Pinhole.ray(&camera, 3.5, 7.25), camera.ray(3.5, 7.25));
    let p = [0.1, 0.2, -0.3];
    assert_eq!(Lens::Pinhole.project(&camera, p), camera.project(p));
    assert!(Lens::Pinhole.shows(&camera, -1e9, 0.0));
    // The coefficients matter little: nearly the same ray.
    let lens = Lens::open_cv([1e-9, 0.0, 0.0, 0.0], [0.0; 2]);
    let [bent, straight] = [lens.ray(&camera, 9.0, 4.0), camera.ray(9.0, 4.0)];
    assert_eq!(bent.origin, straight.origin);
    for (a, b) in bent.direction.iter().zip(straight.direction) {
        assert!((a - b).abs() < 1e-6, "{bent:?} {straight:?}");
    }
}

fn camera() -> Camera {
    let pose = Camera::look_at([3.0, 0.4, 0.8], [0.1, 0.0, 0.2], [0.0, 0.0, 1.0]);
    let camera = Camera::from_fov_x(61, 47, 1.1, pose);
    Camera { focal: [50.0, 49.0], center: [29.0, 25.0], ..camera }
}

#[test]
fn rays_lead_back_to_their_pixels() {
    let camera = camera();
    let skewed = [open_cv().skewed(0.02), fisheye().skewed(-0.03), Lens::Pinhole.skewed(0.01)];
    let others = [full_open_cv(), Lens::fov(1.1), Lens::fov(-0.4), thin_prism_fisheye()];
    let others = others.into_iter().chain(skewed).chain([Lens::Equirectangular]);
    for lens in [open_cv(), fisheye(), Lens::fisheye([0.0; 4])].into_iter().chain(others) {
        for (x, y) in [(0.5, 0.5), (29.0, 25.0), (60.5, 0.5), (13.25, 40.0), (60.5, 46.5)] {
            let ray = lens.ray(&camera, x, y);
            let length: f32 = ray.direction.iter().map(|d| d * d).sum();
            assert!((length - 1.0).abs() < 1e-6);
            let p = [0, 1, 2].map(|a| ray.origin[a] + 2.5 * ray.direction[a]);
            let [u, v] = lens.project(&camera, p).unwrap();
            assert!((u - x).abs() < 1e-3 && (v - y).abs() < 1e-3, "{lens:?}: {x} {y}: {u} {v}");
        }
    }
}

/// Points of balls lie in the rectangles that are said to hold them.
#[test]
fn rectangles_hold_their_balls() {
    let camera = camera();
    let mut random = Random::new(3, [0; 3]);
    let mut number = |scale: f32| scale * (2.0 * random.next_f32() - 1.0);
    let lenses = [
        open_cv(),
        fisheye(),
        Lens::fisheye([0.0; 4]),
        Lens::open_cv([-0.2, 0.03, 0.0, 0.0], [0.01, -0.02]),
        full_open_cv(),
        Lens::fov(1.1),
        thin_prism_fisheye(),
        open_cv().skewed(0.3),
        fisheye().skewed(-0.2),
        Lens::Equirectangular,
    ];
    for lens in lenses {
        let (mut within, mut inside, mut tight) = (0, 0, 0);
        for _ in 0..400 {
            let center = [number(4.0), number(4.0), number(4.0)];
            let radius = 0.01 + number(0.3).abs();
            let rectangle = lens.rectangle(&camera, center, radius);
            let mut seen = [f32::INFINITY, f32::INFINITY, -f32::INFINITY, -f32::INFINITY];
            for _ in 0..60 {
                let d = glam::Vec3::new(number(1.0), number(1.0), number(1.0)).normalize_or_zero();
                let p = [0, 1, 2].map(|a| center[a] + radius * d[a]);
                let Some([x, y]) = lens.project(&camera, p) else { continue };
                assert_ne!(rectangle, Rectangle::Nothing, "{lens:?}: {center:?} {radius}");
                seen = [seen[0].min(x), seen[1].min(y), seen[2].max(x), seen[3].max(y)];
            }
            let Rectangle::Within([x0, y0, x1, y1]) = rectangle else { continue };
            assert!(
                x0 <= seen[0] && y0 <= seen[1] && seen[2] <= x1 && seen[3] <= y1,
                "{lens:?}: {center:?} {radius}: {rectangle:?} {seen:?}"
            );
            within += 1;
            // In the picture they are not much larger than need be.
            let is_inside = lens
                .project(&camera, center)
                .is_some_and(|[x, y]| (0.0..61.0).contains(&x) && (0.0..47.0).contains(&y));
            inside += u32::from(is_inside);
            tight += u32::from(is_inside && x1 - x0 < 3.0 * (seen[2] - seen[0]));
        }
        assert!(within > 100 && inside > 20, "{lens:?}: {within} {inside}");
        assert!(4 * tight > 3 * inside, "{lens:?}: {inside} {tight}");
    }
}

/// What a lens shows somewhere, undistorted and distorted again, is there: over all of a picture
/// that is 90 degrees wide, and more with fisheyes. Where it shows nothing it says so.
#[test]
fn distorting_undoes_undistorting() {
    let lenses = [
        open_cv(),
        fisheye(),
        full_open_cv(),
        Lens::full_open_cv([2.0, 1.0, 0.1, 2.1, 1.0, 0.2], [0.0; 2]),
        Lens::fov(1.1),
        Lens::fov(-2.5),
        thin_prism_fisheye(),
        Lens::thin_prism_fisheye([0.0; 4], [0.0; 2], [0.05, -0.03]),
        open_cv().skewed(0.02),
        thin_prism_fisheye().skewed(-0.1),
        Lens::Equirectangular,
    ];
    for lens in lenses {
        let mut shown = 0;
        for (i, j) in (-20..=20).flat_map(|i| (-20..=20).map(move |j| (i, j))) {
            let point = [f64::from(i) * 0.05, f64::from(j) * 0.05];
            let (direction, is_shown) = lens.undistort(point);
            shown += u32::from(is_shown);
            let again = lens.distort(direction);
            let off = again.map_or(1.0, |again| (again[0] - point[0]).hypot(again[1] - point[1]));
            assert!(!is_shown || off < 2e-9, "{lens:?}: {point:?} {direction:?} {again:?}");
        }
        // FOV: nothing beyond atan(2 tan(omega / 2) tan 89°) / omega, 0.62 for omega 2.5.
        let least = if lens == Lens::fov(-2.5) { 400 } else { 1500 };
        assert!(shown > least, "{lens:?}: {shown}");
    }
}

/// The denominator 1 - 0.5 r² is 0 at r = √2: there and farther out nothing is shown.
#[test]
fn a_rational_lens_ends_at_its_pole() {
    let lens = Lens::full_open_cv([0.0, 0.0, 0.0, -0.5, 0.0, 0.0], [0.0; 2]);
    // 1.4 / (1 - 0.98)
    let [x, _] = lens.distort([1.4, 0.0, 1.0]).unwrap();
    assert!((x - 70.0).abs() < 1e-9, "{x}");
    assert_eq!(lens.distort([1.42, 0.0, 1.0]), None);
    let ([x, ..], is_shown) = lens.undistort([70.0, 0.0]);
    assert!(is_shown && (x - 1.4).abs() < 1e-9, "{x}");
}

#[test]
fn lenses_that_are_simpler_ones() {
    let (k, p) = ([0.1, -0.05, 0.02], [0.001, 0.002]);
    let full = Lens::full_open_cv([k[0], k[1], k[2], 0.0, 0.0, 0.0], p);
    assert_eq!(full, Lens::open_cv([k[0], k[1], k[2], 0.0], p));
    assert_eq!(Lens::fov(0.0), Lens::Pinhole);
    let names = [full_open_cv(), Lens::fov(1.0), thin_prism_fisheye()].map(|lens| lens.name());
    assert_eq!(names, ["full-opencv", "fov", "thin-prism-fisheye"]);
    assert_eq!(thin_prism_fisheye().coefficients().len(), 8);
}

/// x also grows by 0.1 of y, after all else: at (0.5, 0.25) by 0.025.
#[test]
fn a_sensor_that_is_not_at_right_angles() {
    assert_eq!(Lens::Pinhole.skewed(0.0), Lens::Pinhole);
    let lens = Lens::Pinhole.skewed(0.1);
    assert!(near(lens.distort([1.0, 0.5, 2.0]).unwrap(), [0.525, 0.25]));
    assert_eq!((lens.name(), lens.coefficients().last()), ("skewed-opencv", Some(&0.1)));
    let [x, y] = open_cv().distort([1.0, 0.5, 2.0]).unwrap();
    assert!(near(open_cv().skewed(0.1).distort([1.0, 0.5, 2.0]).unwrap(), [x + 0.1 * y, y]));
}

/// A picture of 8x4 pixels: a quarter turn is two pixels wide, an eighth up is one high.
#[test]
fn a_panorama_by_hand() {
    let pose = Camera::look_at([1.0, 2.0, 3.0], [1.0, 9.0, 3.0], [0.0, 0.0, 1.0]);
    let focal = [4.0 / std::f32::consts::PI; 2];
    let camera = Camera { focal, center: [4.0, 2.0], ..Camera::from_fov_x(8, 4, 1.0, pose) };
    let lens = Lens::Equirectangular;
    let half = 0.5f32.sqrt();
    for ([x, y], expected) in [
        ([4.0, 2.0], [0.0, 1.0, 0.0]),
        ([6.0, 2.0], [1.0, 0.0, 0.0]),
        ([2.0, 2.0], [-1.0, 0.0, 0.0]),
        ([8.0, 2.0], [0.0, -1.0, 0.0]),
        ([4.0, 1.0], [0.0, half, half]),
        ([6.0, 3.0], [half, 0.0, -half]),
        ([1.0, 0.0], [0.0, 0.0, 1.0]),
    ] {
        let ray = lens.ray(&camera, x, y);
        let is_near = ray.direction.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(is_near && ray.origin == [1.0, 2.0, 3.0], "{x} {y}: {ray:?}");
        assert!(lens.shows(&camera, x, y));
    }
    assert!(!lens.shows(&camera, 4.0, -0.1) && !lens.shows(&camera, 8.1, 2.0));
    // What crosses the seam behind the camera may be at both ends.
    let behind = lens.rectangle(&camera, [1.1, -5.0, 3.0], 0.5);
    assert_eq!(behind, Rectangle::Unknown);
}
