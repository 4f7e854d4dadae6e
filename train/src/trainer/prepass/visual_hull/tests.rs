//! What silhouettes of discs leave.

use super::*;
use crate::dataset::View;
use crate::trainer::Backdrop;

/// Cameras on the axes, which see a disc of `radius` pixels.
fn views(radius: f32) -> RaySource {
    views_of(101, radius)
}

/// The same, images of `side` pixels, an odd number.
fn views_of(side: u32, radius: f32) -> RaySource {
    let eyes = [[4.0, 0.0, 0.0], [0.0, 4.0, 0.1], [0.0, 0.0, 4.0]];
    let cameras: Vec<Camera> = eyes
        .iter()
        .map(|eye| {
            let up = if eye[2] > 1.0 { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] };
            Camera::from_fov_x(side, side, 0.7, Camera::look_at(*eye, [0.0; 3], up))
        })
        .collect();
    let middle = (side / 2) as f32;
    let image: Vec<u8> = (0..side * side)
        .flat_map(|i| {
            let (x, y) = ((i % side) as f32 - middle, (i / side) as f32 - middle);
            [0, 0, 0, if x * x + y * y <= radius * radius { 255 } else { 0 }]
        })
        .collect();
    let views = cameras.into_iter().map(|camera| View::new("", camera, image.clone()));
    RaySource::new(views.collect(), Backdrop::Random)
}

#[test]
fn keeps_what_the_silhouettes_allow() {
    let hull = VisualHull::new(&views(10.0));
    // Small enough for every view to see all of it.
    let space = Space::Box { min: [-0.9; 3], max: [0.9; 3] };
    let cells = hull.cells(&space, 64);
    // 10 pixels at distance 4 and focal 138 are 0.29 units: three
    // cylinders' intersection, at least the ball, grown by about a cell.
    let center =
        |n: u32| [n % 64, n / 64 % 64, n / 4096].map(|c| (c as f32 + 0.5) * 1.8 / 64.0 - 0.9);
    let norm = |p: [f32; 3]| p.iter().map(|v| v * v).sum::<f32>().sqrt();
    assert!(cells.iter().all(|n| norm(center(*n)) < 0.29 * 1.5 + 0.15));
    let ball = (0..64u32.pow(3)).filter(|n| norm(center(*n)) < 0.28);
    let mut inside = 0;
    for n in ball {
        assert!(cells.binary_search(&n).is_ok(), "a cell of the ball was carved away");
        inside += 1;
    }
    assert!(inside > 500 && cells.len() < 6 * inside, "{inside} {}", cells.len());
}

/// Views that are done with a cell change nothing: the same cells as if all of them were
/// asked about every cell and all that it is a part of.
#[test]
fn the_same_cells_as_by_asking_all_views() {
    let space = Space::Box { min: [-0.9, -0.8, -0.9], max: [0.9; 3] };
    let map = space.unit_map();
    // Cells are as wide as a pixel, or as an eighth of one.
    for (side, radius) in [(101, 3.0), (101, 20.0), (101, 60.0), (13, 0.5), (13, 2.0), (25, 5.5)] {
        let hull = VisualHull::new(&views_of(side, radius));
        let holds = |cell: [u32; 3], size: u32| {
            let side = 1.0 / (size as f32 * map.scale);
            let at = |a: usize| map.min[a] + (cell[a] as f32 + 0.5) * side;
            at(1) - side / 2.0 < 0.9 && hull.may_hold([at(0), at(1), at(2)], side * 0.75f32.sqrt())
        };
        let expected: Vec<u32> = (0..64u32.pow(3))
            .filter(|n| {
                let cell = [n % 64, n / 64 % 64, n / 4096];
                (0..3).all(|level| holds(cell.map(|c| c >> level), 64 >> level))
            })
            .collect();
        assert_eq!(hull.cells(&space, 64), expected, "{side} {radius}");
        assert!(!expected.is_empty());
    }
}

#[test]
fn masked_pixels_carve_nothing() {
    let views = views(0.5);
    let masked = |mask: Vec<u8>| {
        let view = |i: usize| View {
            mask: Some(mask.clone()),
            ..View::new("", views.cameras()[i], views.images()[i].clone())
        };
        VisualHull::new(&RaySource::new((0..3).map(view).collect(), Backdrop::Random))
    };
    let all = vec![1; 101 * 101];
    assert!(!masked(all.clone()).may_hold([0.3, 0.0, 0.0], 1e-3));
    // 0.3 units at distance 4 and focal 138 are ten pixels: the upper half decides, as
    // seen from the second and third camera, and nothing is known of the lower.
    assert!(masked(vec![0; 101 * 101]).may_hold([0.3, 0.0, 0.0], 1e-3));
    let mut upper = all;
    upper[101 * 45..].fill(0);
    assert!(masked(upper).may_hold([0.3, 0.0, 0.0], 1e-3));
}

/// A lens that bends shows the disc elsewhere; what it shows is kept, and what lies
/// where a pinhole would see it is not.
#[test]
fn silhouettes_through_a_lens() {
    let pinhole = views(0.5);
    let lens = Lens::open_cv([4.0, 0.0, 0.0, 0.0], [0.0; 2]);
    let source = |lens: Lens| {
        let view = |(camera, center): (&Camera, [f32; 2])| {
            let image: Vec<u8> = (0..101 * 101)
                .flat_map(|i| {
                    let (x, y) = ((i % 101) as f32 + 0.5, (i / 101) as f32 + 0.5);
                    let near = (x - center[0]).hypot(y - center[1]) <= 2.0;
                    [0, 0, 0, if near { 255 } else { 0 }]
                })
                .collect();
            View { lens, ..View::new("", *camera, image) }
        };
        let views = pinhole.cameras().iter().map(|camera| {
            // Where the lens shows (0.6, 0.6, 0.6).
            view((camera, lens.project(camera, [0.6; 3]).unwrap()))
        });
        VisualHull::new(&RaySource::new(views.collect(), Backdrop::Random))
    };
    assert!(source(lens).may_hold([0.6; 3], 1e-3));
    assert!(!source(lens).may_hold([0.5; 3], 1e-3));
    let straight = pinhole.cameras()[0].project([0.6; 3]).unwrap();
    let bent = lens.project(&pinhole.cameras()[0], [0.6; 3]).unwrap();
    assert!((straight[0] - bent[0]).abs() > 2.0, "{straight:?} {bent:?}");
}

#[test]
fn one_pixel_is_never_lost() {
    let hull = VisualHull::new(&views(0.5));
    assert!(hull.may_hold([0.0; 3], 1e-3));
    assert!(!hull.may_hold([0.3, 0.0, 0.0], 1e-3));
}

#[test]
fn one_wrong_view_carves_nothing() {
    // Eleven cameras around a disc of ten pixels, of which some look beside it.
    let views = |wrong: usize| {
        let view = |i: usize| {
            let angle = i as f32 * 0.5;
            let eye = [4.0 * angle.cos(), 4.0 * angle.sin(), 1.0];
            let pose = Camera::look_at(eye, [0.0; 3], [0.0, 0.0, 1.0]);
            let camera = Camera::from_fov_x(101, 101, 0.7, pose);
            let row = if i < wrong { 90 } else { 50 };
            let inside = |n: usize| (n % 101).abs_diff(50) <= 5 && (n / 101).abs_diff(row) <= 5;
            let alpha = |n: usize| [0, 0, 0, if inside(n) { 255 } else { 0 }];
            View::new("", camera, (0..101 * 101).flat_map(alpha).collect())
        };
        VisualHull::new(&RaySource::new((0..11).map(view).collect(), Backdrop::Random))
    };
    assert!(views(0).may_hold([0.0; 3], 1e-3) && views(1).may_hold([0.0; 3], 1e-3));
    assert!(!views(2).may_hold([0.0; 3], 1e-3));
    let space = Space::Box { min: [-0.9; 3], max: [0.9; 3] };
    let cells = |wrong: usize| views(wrong).cells(&space, 32).len();
    let cells = [0, 1, 2].map(cells);
    assert!(cells[0] > 10 && cells[1] > 10 && cells[2] < cells[0], "{cells:?}");
    // Where nothing is, most views see nothing.
    assert!(!views(1).may_hold([0.5, 0.0, 0.0], 1e-3));
}
