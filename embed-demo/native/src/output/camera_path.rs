//! Camera paths as nerfstudio's `camera_path.json`, which `pocketnerf render --camera-path` reads.

use std::path::Path;

use pocketnerf_core::camera::{Keyframe, KeyframePath};
use serde::Serialize;
use serde_json::Value;

/// The file, with nerfstudio's names. Poses are camera-to-world, row after row; angles are
/// vertical, in degrees.
#[derive(Serialize)]
struct File {
    camera_type: &'static str,
    render_width: u32,
    render_height: u32,
    fps: f64,
    seconds: f64,
    is_cycle: bool,
    /// The tension of nerfstudio's own curve.
    smoothness_value: f64,
    default_fov: f64,
    default_transition_sec: f64,
    keyframes: Vec<Stop>,
    camera_path: Vec<Frame>,
}

#[derive(Serialize)]
struct Stop {
    matrix: [f32; 16],
    fov: f64,
    aspect: f64,
    override_transition_enabled: bool,
    override_transition_sec: Option<f64>,
}

#[derive(Serialize)]
struct Frame {
    camera_to_world: [f32; 16],
    fov: f64,
    aspect: f64,
}

/// Writes a path in the dataset's coordinates, with at least one keyframe, for pictures of this
/// size: the keyframes, and the cameras between them. Every keyframe takes the usual time.
/// Completely or not at all; over a camera path, but over nothing else.
///
/// # Errors
/// One line: the file, and why it was not written.
pub fn write(file: &Path, path: &KeyframePath<'_>, size: [u32; 2]) -> Result<(), String> {
    let name = file.display();
    match std::fs::read(file) {
        Ok(bytes) if !is_camera_path(&bytes) => {
            return Err(format!("{name}: kept, it is no camera path; give another --save-path"));
        }
        _ => {}
    }
    let written = serde_json::to_vec_pretty(&contents(path, size))
        .map_err(std::io::Error::from)
        .and_then(|bytes| pocketnerf_formats::write_atomically(file, &bytes));
    written.map_err(|e| format!("{name}: cannot be written: {e}; give another --save-path"))
}

fn contents(path: &KeyframePath<'_>, [width, height]: [u32; 2]) -> File {
    let aspect = f64::from(width) / f64::from(height);
    let stop = |keyframe: &Keyframe| Stop {
        matrix: keyframe.pose,
        fov: keyframe.fov_y,
        aspect,
        override_transition_enabled: false,
        override_transition_sec: None,
    };
    let frame = |(camera_to_world, fov)| Frame { camera_to_world, fov, aspect };
    File {
        camera_type: "perspective",
        render_width: width,
        render_height: height,
        fps: path.fps,
        seconds: path.seconds(),
        is_cycle: path.is_cycle,
        smoothness_value: 0.0,
        default_fov: path.keyframes.first().map_or(0.0, |keyframe| keyframe.fov_y),
        default_transition_sec: Keyframe::SECONDS,
        keyframes: path.keyframes.iter().map(stop).collect(),
        camera_path: path.pictures().map(frame).collect(),
    }
}

/// Whether a file is nerfstudio's.
fn is_camera_path(bytes: &[u8]) -> bool {
    let found: Option<Value> = serde_json::from_slice(bytes).ok();
    found.is_some_and(|found| ["camera_path", "keyframes"].iter().any(|key| found[key].is_array()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pocketnerf_core::Camera;

    fn keyframe(x: f32) -> Keyframe {
        let pose = Camera::look_at([x, 0.0, 4.0], [x, 0.0, 0.0], [0.0, 1.0, 0.0]);
        Keyframe { pose, fov_y: 40.0, seconds: 2.0 }
    }

    #[test]
    fn a_path_as_nerfstudio_has_it() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("path.json");
        let keyframes = [keyframe(0.1), keyframe(1.1)];
        let path = KeyframePath { keyframes: &keyframes, is_cycle: false, fps: 1.5 };
        write(&file, &path, [80, 40]).unwrap();
        let found: Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
        let pose = |x: f64| {
            serde_json::json!([1., 0., 0., x, 0., 1., 0., 0., 0., 0., 1., 4., 0., 0., 0., 1.])
        };
        for (key, expected) in [
            ("/camera_type", "perspective".into()),
            ("/render_width", 80.into()),
            ("/render_height", 40.into()),
            ("/fps", 1.5.into()),
            ("/seconds", 2.0.into()),
            ("/is_cycle", false.into()),
            ("/default_transition_sec", 2.0.into()),
            ("/keyframes/1/matrix", pose(1.1)),
            ("/keyframes/1/fov", 40.0.into()),
            ("/keyframes/1/aspect", 2.0.into()),
            ("/camera_path/1/camera_to_world", pose(0.6)),
            ("/camera_path/1/fov", 40.0.into()),
        ] {
            assert_eq!(found.pointer(key), Some(&expected), "{key}");
        }
        assert_eq!(
            (&found["keyframes"][2], &found["camera_path"][3]),
            (&Value::Null, &Value::Null)
        );
        // A path gives way to another one.
        write(&file, &KeyframePath { keyframes: &keyframes[..1], ..path }, [80, 40]).unwrap();
        let found: Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
        assert_eq!(found["camera_path"].as_array().map(Vec::len), Some(1));
    }

    #[test]
    fn what_is_no_path_stays() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("notes");
        let keyframes = [keyframe(0.0)];
        let path = KeyframePath { keyframes: &keyframes, is_cycle: false, fps: 30.0 };
        for text in ["", "notes", "[1]", "{\"camera_path\": 3}", "{\"frames\": []}"] {
            std::fs::write(&file, text).unwrap();
            let said = write(&file, &path, [8, 8]).unwrap_err();
            assert!(said.ends_with("notes: kept, it is no camera path; give another --save-path"));
            assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
        }
        let said = write(&folder.path().join("none/path.json"), &path, [8, 8]).unwrap_err();
        assert!(said.contains("none/path.json: cannot be written: "), "{said}");
    }
}
