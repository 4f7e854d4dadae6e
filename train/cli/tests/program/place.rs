//! A folder with a dataset, in which the program runs.

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Output};

use pocketnerf_train::builtin;
use pocketnerf_train::dataset::Split;
use serde_json::Value;

/// A small model.
pub(crate) const TRAIN: &str =
    "train data --json --quiet --exposure off --log2-hashmap-size 9 --batch-rays 64 --seed 5";

/// The first views of the built-in scene as a Blender-style dataset.
fn write_dataset(folder: &Path) {
    let mut frames = String::new();
    let dataset = builtin::dataset(Split::Train, 16);
    for (i, view) in dataset.views.iter().take(12).enumerate() {
        let camera = &view.camera;
        let file = folder.join(format!("{i}.png"));
        let (width, height) = (camera.width, camera.height);
        image::save_buffer(file, &view.rgba, width, height, image::ColorType::Rgba8).unwrap();
        let rows: Vec<_> = camera.camera_to_world.chunks(4).collect();
        let comma = if i == 0 { "" } else { "," };
        let pose = format!("{rows:?}");
        write!(frames, r#"{comma}{{"file_path": "{i}", "transform_matrix": {pose}}}"#).unwrap();
    }
    let text = format!(r#"{{"camera_angle_x": 0.6911112, "frames": [{frames}]}}"#);
    std::fs::write(folder.join("transforms_train.json"), text).unwrap();
}

/// A folder with a dataset, in which the program runs.
pub(crate) struct Place(pub(crate) tempfile::TempDir);

impl Place {
    pub(crate) fn new() -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        std::fs::create_dir(place.path("data")).unwrap();
        write_dataset(&place.path("data"));
        place
    }

    pub(crate) fn path(&self, name: &str) -> std::path::PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn command(&self, options: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pocketnerf"));
        command.args(options.split_whitespace()).current_dir(self.0.path());
        command
    }

    pub(crate) fn run(&self, options: &str) -> Output {
        self.command(options).output().unwrap()
    }

    /// Runs to success.
    pub(crate) fn ok(&self, options: &str) -> Value {
        let output = self.run(options);
        assert!(output.status.success(), "{options}: {}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap_or(Value::Null)
    }

    /// Runs to a failure and gives its line.
    pub(crate) fn line(&self, options: &str) -> String {
        let output = self.run(options);
        assert_eq!(output.status.code(), Some(1), "{options}");
        let line = text(&output.stderr);
        assert_eq!(line.matches('\n').count(), 1, "{line}");
        line.trim_end().strip_prefix("pocketnerf: ").unwrap().to_owned()
    }

    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
