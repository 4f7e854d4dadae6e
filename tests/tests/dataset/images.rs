//! Images of every format, and photographs that are to be turned.

use image::{DynamicImage, ImageFormat, Rgb32FImage, Rgba32FImage, RgbaImage};
use pocketnerf_tests::damage::mutate;
use pocketnerf_train::dataset::{Dataset, DatasetError, LoadOptions, Split, load_with};
use pocketnerf_train::random::Random;

use crate::fixture::{Folder, POSE};
use crate::refusals::refusal;

fn write(folder: &Folder, camera: &str, name: &str) {
    let frame = format!(r#"{{"file_path": "{name}", "transform_matrix": {POSE}}}"#);
    folder.write("transforms.json", format!("{{{camera}, \"frames\": [{frame}]}}"));
}

fn load(folder: &Folder) -> Result<Dataset, DatasetError> {
    let options = LoadOptions { hold_every: 0, ..LoadOptions::default() };
    load_with(folder.path(), Split::Train, &options)
}

fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn pattern() -> RgbaImage {
    RgbaImage::from_fn(5, 3, |x, y| image::Rgba([50 * x as u8, 80 * y as u8, 7, 255 - x as u8]))
}

fn linear() -> DynamicImage {
    let pixels = [[0.5, 0.001, 0.0, 1.0], [0.25, 0.0, 0.5, 0.5], [7.0, f32::NAN, -1.0, 1.0]];
    Rgba32FImage::from_raw(3, 1, pixels.concat()).unwrap().into()
}

#[test]
fn formats() {
    let folder = Folder::new();
    let exact =
        [(ImageFormat::Png, "png"), (ImageFormat::WebP, "webp"), (ImageFormat::Tiff, "tif")];
    for (format, ending) in exact {
        folder.write(&format!("a.{ending}"), encoded(&pattern().into(), format));
        // With and without the ending.
        for name in [format!("a.{ending}"), "a".to_owned()] {
            write(&folder, r#""fl_x": 4"#, &name);
            let dataset = load(&folder).unwrap();
            assert_eq!(dataset.views[0].name, format!("a.{ending}"));
            assert_eq!(dataset.views[0].rgba, pattern().into_raw(), "{ending}");
            assert!(dataset.notes.is_empty(), "{:?}", dataset.notes);
        }
        folder.remove(&format!("a.{ending}"));
    }
    let deep = DynamicImage::from(pattern()).into_rgba16();
    folder.write("a.TIFF", encoded(&deep.into(), ImageFormat::Tiff));
    write(&folder, r#""fl_x": 4"#, "a");
    assert_eq!(load(&folder).unwrap().views[0].rgba, pattern().into_raw());
}

/// 0.5 is 188 of 255 by the sRGB curve, 0.001 is 3; alpha 0.5 makes 0.5 of 0.25.
#[test]
fn linear_colours() {
    let folder = Folder::new();
    folder.write("a.exr", encoded(&linear(), ImageFormat::OpenExr));
    write(&folder, r#""fl_x": 4"#, "a.exr");
    let dataset = load(&folder).unwrap();
    let expected = [188, 3, 0, 255, 188, 0, 255, 128, 255, 0, 0, 255];
    assert_eq!(dataset.views[0].rgba, expected);
    assert_eq!(
        dataset.notes,
        [
            "1 images (first: a.exr) have linear colours: they are converted with the sRGB curve, and \
          what is brighter than 1 is cut off"
        ]
    );
    let opaque = Rgb32FImage::from_pixel(4, 2, image::Rgb([0.5, 1.0, 0.0]));
    folder.write("a.exr", encoded(&opaque.into(), ImageFormat::OpenExr));
    assert_eq!(load(&folder).unwrap().views[0].rgba[..4], [188, 255, 0, 255]);
}

#[test]
fn formats_that_are_not_read() {
    let folder = Folder::new();
    write(&folder, r#""fl_x": 4"#, "a.png");
    let convert = "convert it to PNG; expected a whole PNG, JPEG, WebP, TIFF or EXR file";
    for (bytes, name) in [
        (&b"\0\0\0\x18ftypheic\0\0\0\0mif1heic"[..], "a HEIC file"),
        (b"\0\0\0\x18ftypmif1\0\0\0\0mif1heic", "a HEIC file"),
        (b"\0\0\0\x1cftypavif\0\0\0\0avifmif1", "an AVIF file"),
        (b"\xff\x0a rest", "a JPEG XL file"),
        (b"GIF89a and more", "a GIF file"),
        (b"BM and more of it", "a BMP file"),
        (b"II*\0\x10\0\0\0CR\x02\0", "a camera's raw file"),
    ] {
        folder.write("a.png", bytes);
        assert_eq!(
            refusal_of_all(&folder),
            format!("D/a.png: unreadable image: {name}: {convert}")
        );
    }
    let exr = encoded(&linear(), ImageFormat::OpenExr);
    folder.write("a.png", &exr[..exr.len() - 5]);
    assert!(refusal_of_all(&folder).starts_with("D/a.png: unreadable image: "));
}

fn refusal_of_all(folder: &Folder) -> String {
    let message = load(folder).unwrap_err().to_string();
    message.replace(&folder.path().display().to_string(), "D")
}

/// A JPEG of 32x16 pixels, red on the left and blue on the right, that EXIF says is to be turned.
fn photo(orientation: u8) -> Vec<u8> {
    let image = image::RgbImage::from_fn(32, 16, |x, _| {
        image::Rgb(if x < 16 { [255, 0, 0] } else { [0, 0, 255] })
    });
    let jpeg = encoded(&image.into(), ImageFormat::Jpeg);
    let mut exif = b"Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0".to_vec();
    exif.extend([orientation, 0, 0, 0, 0, 0, 0, 0]);
    let len = (exif.len() as u16 + 2).to_be_bytes();
    [&jpeg[..2], &[0xff, 0xe1], &len, &exif, &jpeg[2..]].concat()
}

/// Red, green and blue of the pixel at (4, 4).
fn corner(dataset: &Dataset) -> ([u32; 2], bool) {
    let view = &dataset.views[0];
    let size = [view.camera.width, view.camera.height];
    let pixel = &view.rgba[4 * (4 * size[0] as usize + 4)..][..3];
    (size, pixel[0] > 200 && pixel[2] < 60)
}

#[test]
fn photographs_that_are_to_be_turned() {
    let folder = Folder::new();
    let load = |camera: &str, orientation| {
        folder.write("a.jpg", photo(orientation));
        write(&folder, camera, "a.jpg");
        load(&folder).unwrap()
    };
    // The camera is for the pixels as stored.
    let wide = r#""fl_x": 64, "w": 64, "h": 32"#;
    let stored = load(wide, 6);
    assert_eq!(corner(&stored), ([32, 16], true));
    assert!(stored.notes.is_empty(), "{:?}", stored.notes);
    // It is for the turned ones: 6 turns right, so that the left is at the top; 8 turns left.
    let high = r#""fl_x": 64, "w": 32, "h": 64"#;
    for (orientation, is_red) in [(6, true), (8, false)] {
        let turned = load(high, orientation);
        assert_eq!(corner(&turned), ([16, 32], is_red));
        assert_eq!(
            turned.notes,
            ["1 images (first: a.jpg) are turned by their EXIF orientation, as their cameras ask"]
        );
    }
    // A size that is not there, or that stays as it is, does not tell.
    for (camera, orientation) in [(r#""fl_x": 64"#, 6), (wide, 3)] {
        let untold = load(camera, orientation);
        assert_eq!(corner(&untold), ([32, 16], true));
        assert!(
            untold.notes[0].starts_with("1 images (first: a.jpg) have an EXIF orientation, and")
        );
    }
    assert!(load(wide, 1).notes.is_empty());
    // It fits neither way.
    folder.write("a.jpg", photo(6));
    write(&folder, r#""fl_x": 64, "w": 32, "h": 32"#, "a.jpg");
    assert!(refusal_of_all(&folder).starts_with("D/a.jpg: 32x16 pixels, but its camera is for"));
}

#[test]
fn photographs_videos_and_archives_alone() {
    let folder = Folder::new();
    folder.image("IMG_1.jpg", [4, 2], 0);
    folder.write("IMG_2.HEIC", "");
    let find = |what: &str, of: &str| {
        format!(
            "D{what}; `pocketnerf prepare` makes a dataset of {of}, as do colmap, ns-process-data \
             of nerfstudio and colmap2nerf.py of instant-ngp"
        )
    };
    assert_eq!(refusal(folder.path()), find(": 2 photographs without poses", "them"));
    let inside = Folder::new();
    (0..3).for_each(|i| inside.image(&format!("images/{i}.png"), [4, 2], 0));
    assert_eq!(refusal(inside.path()), find("/images: 3 photographs without poses", "them"));
    folder.write("walk.MOV", "");
    let message = refusal(&folder.path().join("walk.MOV"));
    assert_eq!(message, find(": a video", "it"));
    folder.write("scan.zip", "");
    let message = refusal(&folder.path().join("scan.zip"));
    assert_eq!(message, "D: an archive, expected a folder; unpack it and give the folder");
}

/// 10,000 damaged images of each format are decoded or refused.
#[test]
fn damaged_images() {
    let image: DynamicImage = pattern().into();
    damaged(ImageFormat::Png, &encoded(&image, ImageFormat::Png));
    damaged(ImageFormat::WebP, &encoded(&image, ImageFormat::WebP));
    damaged(ImageFormat::Jpeg, &photo(6));
}

#[test]
fn damaged_images_of_many_bits() {
    damaged(ImageFormat::Tiff, &encoded(&pattern().into(), ImageFormat::Tiff));
    damaged(ImageFormat::OpenExr, &encoded(&linear(), ImageFormat::OpenExr));
}

/// Ten thousand mutants of an image are read, or refused in a line.
fn damaged(format: ImageFormat, original: &[u8]) {
    let folder = Folder::new();
    write(&folder, r#""fl_x": 4"#, "a.png");
    let mut random = Random::new(7, [0; 3]);
    let mut counts = [0, 0];
    for i in 0..10_000 {
        let mut bytes = original.to_vec();
        mutate(&mut random, &mut bytes);
        folder.write("a.png", bytes);
        match load(&folder) {
            Ok(dataset) => {
                let view = &dataset.views[0];
                let pixels = u64::from(view.camera.width) * u64::from(view.camera.height);
                assert_eq!(view.rgba.len() as u64, 4 * pixels);
                counts[0] += 1;
            }
            Err(error) => {
                counts[1] += 1;
                let line = error.to_string();
                assert!(!line.contains('\n') && line.len() < 1000, "{format:?} {i}: {line}");
            }
        }
    }
    assert!(counts.iter().all(|count| *count > 100), "{format:?}: {counts:?}");
}
