//! Broken datasets, and what is said of each.

use image::imageops::{blur, resize};
use image::{Rgba, RgbaImage};
use serde_json::json;

use super::spoil::{Data, inverse, opencv};

/// What it is called, how it is made, and part of the line that names it.
type Broken = (&'static str, fn(&Data), &'static str);

pub(super) const BROKEN: &[Broken] = &[
    // Poses of another convention.
    ("OpenCV poses", |d| d.poses(|_, p| opencv(p)), "the poses look like OpenCV's"),
    (
        "inverse poses",
        |d| d.poses(|_, p| inverse(p)),
        "the poses look like world-to-camera; invert",
    ),
    (
        "COLMAP's poses as they are",
        |d| d.poses(|_, p| inverse(opencv(p))),
        "the poses look like world-to-camera, OpenCV's",
    ),
    (
        "a robot's poses",
        |d| d.poses(|_, p| p.map(|[x, y, z, t]| [-z, -x, y, t])),
        "cameras that look along +x",
    ),
    // Cameras.
    (
        "three cameras look away",
        |d| d.poses(|i, p| if i % 20 == 3 { opencv(p) } else { p }),
        "cameras that look away from what the others look at: 3 of 72 (first: train/003.png)",
    ),
    ("one place", |d| d.positions(|_, _| [1.0, 2.0, 3.0]), "cameras are in one place"),
    ("tiny units", |d| d.positions(|_, p| p.map(|x| 1e-5 * x)), "units this small lose digits"),
    ("huge units", |d| d.positions(|_, p| p.map(|x| 1e5 * x)), "units this large lose digits"),
    ("far from the origin", |d| d.positions(|_, p| p.map(|x| x + 1e6)), "units from the origin"),
    (
        "cameras hardly move, beside the box",
        |d| {
            d.positions(|_, p| p.map(|x| 1e-3 * x));
            d.json(|json| json["aabb"] = json!([[-2.0, -2.0, -2.0], [2.0, 2.0, 2.0]]));
        },
        "next to nothing has a depth",
    ),
    (
        "a camera that is lost",
        |d| d.positions(|i, p| if i == 7 { p.map(|x| 100.0 * x) } else { p }),
        "cameras more than 20 times as far away as others: 1 of 72 (first: train/007.png)",
    ),
    (
        "one pose twice",
        |d| {
            d.json(|json| {
                json["frames"][6]["transform_matrix"] =
                    json["frames"][5]["transform_matrix"].clone();
            });
        },
        "the pose of another, but another photograph: 1 of 72 (first: train/006.png)",
    ),
    (
        "one photograph twice",
        |d| _ = std::fs::copy(d.file(7), d.file(20)).unwrap(),
        "the same as another, with another pose: 1 of 72 (first: train/020.png)",
    ),
    (
        "a box beside the scene",
        |d| d.json(|json| json["aabb"] = json!([[20.0, 20.0, 20.0], [22.0, 22.0, 22.0]])),
        "of the cameras look at the box that the dataset gives",
    ),
    // Lenses.
    (
        "a wide lens",
        |d| d.set(&["fl_x", "fl_y"], 5.0),
        "fields of view that no photograph has: 60 of 72 (first: train/000.png), 168.6 by",
    ),
    ("a long lens", |d| d.set(&["fl_x", "fl_y"], 5000.0), "1.1 by 1.1 degrees, expected 3 to 150"),
    (
        "a camera of larger images",
        |d| d.set(&["cx", "cy"], 200.0),
        "principal points far from the middle: 60 of 72 (first: train/000.png), (200, 200)",
    ),
    // Files.
    ("an image is missing", |d| std::fs::remove_file(d.file(4)).unwrap(), "have no image"),
    (
        "an image is cut off",
        |d| crate::fixture::cut(&d.file(4), 900),
        "images that are unreadable or cut off: 1 of 72 (first: train/004.png)",
    ),
    (
        "an image is cropped",
        |d| d.images([4], |i| image::imageops::crop_imm(&i, 0, 20, 100, 60).to_image()),
        "images of another shape than their cameras: 1 of 72 (first: train/004.png)",
    ),
    (
        "an image is smaller",
        |d| d.images([4], |i| resize(&i, 50, 50, image::imageops::FilterType::Triangle)),
        "1 of 72 (first: train/004.png), 50x50 pixels, the others have 100x100",
    ),
    (
        "photographs are turned",
        |d| (0..60).for_each(|i| d.turned(i)),
        "images to be shown turned or mirrored (EXIF): 60 of 72",
    ),
    // What photographs show.
    (
        "exposure that changes",
        |d| d.images((0..60).step_by(2), |i| brighter(i, 0.5)),
        "photographs differ from their neighbours by",
    ),
    (
        "two dark photographs",
        |d| d.images([9, 30], |i| brighter(i, 0.5)),
        "photographs much brighter or darker than their neighbours: 2 of 72",
    ),
    (
        "blurred photographs",
        |d| {
            d.images([8, 16, 24, 32], |i| {
                let blurred = blur(&i, 1.5);
                RgbaImage::from_fn(100, 100, |x, y| {
                    // Alpha stays sharp.
                    let [r, g, b, _] = blurred.get_pixel(x, y).0;
                    Rgba([r, g, b, i.get_pixel(x, y).0[3]])
                })
            });
        },
        "photographs that are blurred beside the others: 4 of 72 (first: train/008.png)",
    ),
    (
        "a photograph of nothing",
        |d| d.images([5], |i| map(i, |[.., a]| [90, 90, 90, a])),
        "photographs of one colour and nothing else: 1 of 72 (first: train/005.png)",
    ),
    // Alpha and masks.
    (
        "alpha 0 everywhere",
        |d| d.images([5], |i| map(i, |[r, g, b, _]| [r, g, b, 0])),
        "images that are transparent everywhere (alpha 0): 1 of 72",
    ),
    (
        "alpha 255 everywhere",
        |d| d.images([5, 6, 7], |i| map(i, |[r, g, b, _]| [r, g, b, 255])),
        "images that are opaque everywhere (alpha 255), while most are cut out: 3 of 72",
    ),
    (
        "alpha inverted",
        |d| d.images(0..60, |i| map(i, |[r, g, b, a]| [r, g, b, 255 - a])),
        "images that are opaque around a transparent middle: 49 of 72",
    ),
    ("masks inverted", |d| d.masks(|_, p| p[3] == 0), "if masks are the wrong way round, invert"),
    (
        "a black mask",
        |d| d.masks(|i, _| i != 3),
        "masks that are black everywhere: 1 of 72 (first: train/003.png)",
    ),
    (
        "a mask is missing",
        |d| {
            d.masks(|_, _| true);
            std::fs::remove_file(d.path().join("train/011.mask.png")).unwrap();
        },
        "images whose masks are missing: 1 of 72 (first: train/011.png)",
    ),
    // How many.
    ("few photographs", |d| d.keep(|i, _| i % 10 == 0), "6 photographs to learn from, expected"),
    ("photographs far apart", |d| d.keep(|i, _| i % 5 == 0), "degrees from one to the next"),
    (
        "a gap",
        |d| {
            d.keep(|_, p| {
                [0.8, -0.48, 0.36].iter().zip(p).map(|(a, p)| a * p[2]).sum::<f64>() < 0.8
            });
        },
        "photographs leave a gap",
    ),
    // Refused.
    (
        "mirrored poses",
        |d| d.poses(|_, p| p.map(|[x, y, z, t]| [-x, y, z, t])),
        "the pose's 3x3 part is not a rotation: determinant -1",
    ),
    (
        "transposed poses",
        |d| d.poses(|_, p| core::array::from_fn(|i| core::array::from_fn(|j| p[j][i]))),
        "is the matrix transposed?",
    ),
    (
        "scaled poses",
        |d| d.poses(|_, p| p.map(|[x, y, z, t]| [2.0 * x, 2.0 * y, 2.0 * z, t])),
        "determinant 8",
    ),
    ("no frames", |d| d.keep(|_, _| false), "\"frames\" is empty"),
    (
        "JSON that is cut off",
        |d| d.text(|text| text[..text.len() / 2].to_owned()),
        "not valid JSON",
    ),
    (
        "no focal length",
        |d| d.text(|text| text.replace("fl_", "gl_")),
        "no focal length, expected fl_x in pixels",
    ),
];

fn map(mut image: RgbaImage, change: impl Fn([u8; 4]) -> [u8; 4]) -> RgbaImage {
    image.pixels_mut().for_each(|pixel| pixel.0 = change(pixel.0));
    image
}

/// Linear light, multiplied.
fn brighter(image: RgbaImage, times: f32) -> RgbaImage {
    let change = |c: u8| (255.0 * (times * (f32::from(c) / 255.0).powf(2.2)).powf(1.0 / 2.2)) as u8;
    map(image, |[r, g, b, a]| [change(r), change(g), change(b), a])
}
