//! A dataset of two train views and one test view, 4×2 pixels, in a folder
//! that vanishes.

use std::path::Path;

/// At (0, -4, 1), looking along +y, z up.
pub(crate) const POSE: &str = "[[1, 0, 0, 0], [0, 0, -1, -4], [0, 1, 0, 1], [0, 0, 0, 1]]";

/// At (4, 0, 1), looking along -x, z up.
const SIDE_POSE: &str = "[[0, 0, 1, 4], [1, 0, 0, 0], [0, 1, 0, 1], [0, 0, 0, 1]]";

pub(crate) struct Scene(tempfile::TempDir);

impl Scene {
    pub(crate) fn new() -> Self {
        let scene = Self(tempfile::tempdir().unwrap());
        for name in ["train/r_0.png", "train/r_1.png", "test/r_0.png"] {
            let file = scene.path().join(name);
            std::fs::create_dir_all(file.parent().unwrap()).unwrap();
            let red = u8::from(name.contains('1'));
            // Every other pixel is transparent.
            image::RgbaImage::from_fn(4, 2, |x, y| {
                image::Rgba([red, x as u8, y as u8, if (x + y) % 2 == 0 { 255 } else { 0 }])
            })
            .save(file)
            .unwrap();
        }
        let side = frames(&["./train/r_0"]).replace(POSE, SIDE_POSE);
        scene.train(&format!("{}, {side}", frames(&["./train/r_1"])));
        scene.write("transforms_test.json", &frames(&["./test/r_0"]));
        scene
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    /// Replaces the frames of the train split.
    pub(crate) fn train(&self, frames: &str) {
        self.write("transforms_train.json", frames);
    }

    /// Adds a JPEG file.
    pub(crate) fn photo(&self, name: &str) {
        write_photo(&self.path().join(name));
    }

    fn write(&self, name: &str, frames: &str) {
        let angle = std::f64::consts::FRAC_PI_2;
        let text = format!("{{\"camera_angle_x\": {angle},\n \"frames\": [{frames}]}}");
        std::fs::write(self.path().join(name), text).unwrap();
    }
}

/// A folder that vanishes, to be filled with any dataset.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    /// Writes a file, and the folders it lies in.
    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        let file = self.path().join(name);
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(file, bytes).unwrap();
    }

    /// Writes an opaque PNG of pixels `[x, y, blue]`.
    pub(crate) fn image(&self, name: &str, [width, height]: [u32; 2], blue: u8) {
        self.pixels(name, [width, height], |x, y| [x as u8, y as u8, blue]);
    }

    /// Writes an opaque PNG.
    pub(crate) fn pixels(
        &self,
        name: &str,
        [width, height]: [u32; 2],
        color: impl Fn(u32, u32) -> [u8; 3],
    ) {
        self.write(name, "");
        let image = image::RgbImage::from_fn(width, height, |x, y| image::Rgb(color(x, y)));
        image.save(self.path().join(name)).unwrap();
    }

    pub(crate) fn remove(&self, name: &str) {
        std::fs::remove_file(self.path().join(name)).unwrap();
    }
}

/// Whether vectors are the same to six digits.
pub(crate) fn near<const N: usize>(a: [f32; N], b: [f32; N]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
}

/// A vector of length 1.
pub(crate) fn unit(v: [f32; 3]) -> [f32; 3] {
    let n = v.iter().map(|x| x * x).sum::<f32>().sqrt();
    v.map(|x| x / n)
}

/// Frames with these file paths, all at [`POSE`].
pub(crate) fn frames(paths: &[impl AsRef<str>]) -> String {
    let frame = |path: &str| {
        format!(r#"{{"file_path": "{path}", "rotation": 0.1, "transform_matrix": {POSE}}}"#)
    };
    paths.iter().map(|path| frame(path.as_ref())).collect::<Vec<_>>().join(",\n")
}

/// Writes a JPEG of 4×2 pixels, whatever the file's name.
pub(crate) fn write_photo(file: &Path) {
    let photo = image::RgbImage::from_pixel(4, 2, image::Rgb([90, 120, 60]));
    photo.save_with_format(file, image::ImageFormat::Jpeg).unwrap();
}

/// Shortens (or lengthens) a file.
pub(crate) fn cut(file: &Path, bytes: u64) {
    std::fs::OpenOptions::new().write(true).open(file).unwrap().set_len(bytes).unwrap();
}
