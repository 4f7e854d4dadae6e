//! A COLMAP model, written as text or byte by byte.

use std::fmt::Write as _;

use crate::fixture::Folder;

/// Numbers and names of camera models, in the order of the numbers.
pub(super) const MODELS: [&str; 11] = [
    "SIMPLE_PINHOLE",
    "PINHOLE",
    "SIMPLE_RADIAL",
    "RADIAL",
    "OPENCV",
    "OPENCV_FISHEYE",
    "FULL_OPENCV",
    "FOV",
    "SIMPLE_RADIAL_FISHEYE",
    "RADIAL_FISHEYE",
    "THIN_PRISM_FISHEYE",
];

#[derive(Clone)]
pub(super) struct Camera {
    pub(super) id: u32,
    pub(super) model: &'static str,
    pub(super) size: [u64; 2],
    pub(super) numbers: Vec<f64>,
}

#[derive(Clone)]
pub(super) struct Image {
    pub(super) id: u32,
    pub(super) rotation: [f64; 4],
    pub(super) translation: [f64; 3],
    pub(super) camera: u32,
    pub(super) name: String,
}

#[derive(Clone)]
pub(super) struct Capture {
    pub(super) cameras: Vec<Camera>,
    pub(super) images: Vec<Image>,
    pub(super) points: Vec<[f64; 3]>,
}

/// An image taken at a position by a camera that looks along +y with z up, and is then turned
/// by an angle around z.
pub(super) fn image(id: u32, name: &str, position: [f64; 3], angle: f64) -> Image {
    // Right is x, down is -z, forward is y: a quarter turn around x, after one by -angle around z.
    let (half, sin, cos) = (0.5f64.sqrt(), (-0.5 * angle).sin(), (-0.5 * angle).cos());
    let rotation = [half * cos, half * cos, -half * sin, half * sin];
    let [x, y, z] = position;
    // As seen by it: right (cos, sin, 0), down (0, 0, -1), forward (-sin, cos, 0).
    let (sin, cos) = angle.sin_cos();
    let translation = [-(x * cos + y * sin), z, -(y * cos - x * sin)];
    Image { id, rotation, translation, camera: 1, name: name.to_owned() }
}

impl Capture {
    /// Three photographs of what is around (1, 2, 3), 4 away on the side of -y, +x and -x,
    /// and 27 points there, 1 apart.
    pub(super) fn around() -> Self {
        let quarter = std::f64::consts::FRAC_PI_2;
        let images = vec![
            image(7, "a.png", [1.0, -2.0, 3.0], 0.0),
            image(3, "b.png", [5.0, 2.0, 3.0], quarter),
            image(5, "sub/c d.png", [-3.0, 2.0, 3.0], -quarter),
        ];
        let step = [-1.0, 0.0, 1.0];
        let plane = step.iter().flat_map(|x| step.map(|y| [1.0 + x, 2.0 + y]));
        let points = plane.flat_map(|[x, y]| step.map(|z| [x, y, 3.0 + z])).collect();
        Self { cameras: vec![Self::camera("SIMPLE_PINHOLE", &[8.0, 4.0, 2.0])], images, points }
    }

    pub(super) fn camera(model: &'static str, numbers: &[f64]) -> Camera {
        Camera { id: 1, model, size: [8, 4], numbers: numbers.to_vec() }
    }

    /// In a folder, as binary files in `sparse/0`, with an image of 8x4 pixels for each.
    pub(super) fn folder(&self) -> Folder {
        let folder = Folder::new();
        self.write_binary(&folder, "sparse/0");
        self.write_images(&folder, "images", [8, 4]);
        folder
    }

    pub(super) fn write_images(&self, folder: &Folder, inside: &str, size: [u32; 2]) {
        for image in &self.images {
            folder.image(&format!("{inside}/{}", image.name), size, size[0] as u8);
        }
    }

    pub(super) fn write_binary(&self, folder: &Folder, model: &str) {
        let [cameras, images, points] = self.binary();
        folder.write(&format!("{model}/cameras.bin"), cameras);
        folder.write(&format!("{model}/images.bin"), images);
        folder.write(&format!("{model}/points3D.bin"), points);
    }

    /// `cameras.bin`, `images.bin` and `points3D.bin`.
    pub(super) fn binary(&self) -> [Vec<u8>; 3] {
        let floats = |numbers: &[f64]| -> Vec<u8> {
            numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
        };
        let mut cameras = (self.cameras.len() as u64).to_le_bytes().to_vec();
        for Camera { id, model, size: [width, height], numbers } in &self.cameras {
            let number = MODELS.iter().position(|name| name == model).unwrap() as i32;
            cameras.extend(id.to_le_bytes().into_iter().chain(number.to_le_bytes()));
            cameras.extend(width.to_le_bytes().into_iter().chain(height.to_le_bytes()));
            cameras.extend(floats(numbers));
        }
        let mut images = (self.images.len() as u64).to_le_bytes().to_vec();
        for image in &self.images {
            images.extend(image.id.to_le_bytes());
            images.extend(floats(&image.rotation).into_iter().chain(floats(&image.translation)));
            images.extend(image.camera.to_le_bytes());
            images.extend(image.name.bytes().chain([0]));
            // Each shows two points, of which one is known.
            images.extend(2u64.to_le_bytes());
            for (at, point) in [([1.5, 2.5], 1i64), ([3.25, 0.5], -1)] {
                images.extend(floats(&at).into_iter().chain(point.to_le_bytes()));
            }
        }
        let mut points = (self.points.len() as u64).to_le_bytes().to_vec();
        for (id, point) in (1u64..).zip(&self.points) {
            points.extend(id.to_le_bytes().into_iter().chain(floats(point)));
            points.extend([9, 8, 7].into_iter().chain(0.5f64.to_le_bytes()));
            points.extend((self.images.len() as u64).to_le_bytes());
            for image in &self.images {
                points.extend(image.id.to_le_bytes().into_iter().chain(0u32.to_le_bytes()));
            }
        }
        [cameras, images, points]
    }

    /// The same as text.
    pub(super) fn text(&self) -> [String; 3] {
        let words =
            |numbers: &[f64]| numbers.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
        let mut cameras = "# Camera list\n#   CAMERA_ID, MODEL, …\n".to_owned();
        for Camera { id, model, size: [width, height], numbers } in &self.cameras {
            writeln!(cameras, "{id} {model} {width} {height} {}", words(numbers)).unwrap();
        }
        let mut images = "# Image list with two lines of data per image:\n".to_owned();
        for (i, image) in self.images.iter().enumerate() {
            let Image { id, rotation, translation, camera, name } = image;
            let pose = words(&[&rotation[..], translation].concat());
            // The second one shows nothing: its line of points is empty.
            let marks = if i == 1 { "" } else { "1.5 2.5 1 3.25 0.5 -1" };
            writeln!(images, "{id} {pose} {camera} {name}\n{marks}").unwrap();
        }
        let mut points = "# 3D point list with one line of data per point:\n".to_owned();
        for (id, point) in (1..).zip(&self.points) {
            let track = self.images.iter().map(|image| format!(" {} 0", image.id));
            let track = track.collect::<String>();
            writeln!(points, "{id} {} 9 8 7 0.5{track}", words(point)).unwrap();
        }
        [cameras, images, points]
    }

    pub(super) fn write_text(&self, folder: &Folder, model: &str) {
        let [cameras, images, points] = self.text();
        folder.write(&format!("{model}/cameras.txt"), cameras);
        folder.write(&format!("{model}/images.txt"), images);
        folder.write(&format!("{model}/points3D.txt"), points);
    }
}
