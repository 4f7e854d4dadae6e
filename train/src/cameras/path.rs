//! Camera paths from files: nerfstudio's `camera_path.json` and anything in
//! the manner of `transforms.json`.

use std::path::Path;

use pocketnerf_core::Camera;
use serde::Deserialize;

use super::CameraError;
use crate::json::{self, Keys};
use crate::pose;

const NERFSTUDIO: &str = "nerfstudio's {\"camera_path\": [{\"camera_to_world\": 16 numbers, \"fov\": vertical degrees}, …], \
     \"render_width\": pixels, \"render_height\": pixels}";
const TRANSFORMS: &str =
    "{\"camera_angle_x\": radians, \"frames\": [{\"transform_matrix\": 4 rows of 4 numbers}, …]}";

#[derive(Deserialize)]
#[serde(expecting = "an object")]
struct NerfstudioPath {
    camera_path: Vec<NerfstudioCamera>,
    render_width: Option<f64>,
    render_height: Option<f64>,
    camera_type: Option<String>,
}

#[derive(Deserialize)]
#[serde(expecting = "a camera")]
struct NerfstudioCamera {
    camera_to_world: Vec<f64>,
    fov: f64,
}

#[derive(Deserialize)]
#[serde(expecting = "an object")]
struct TransformsPath {
    camera_angle_x: Option<f64>,
    w: Option<f64>,
    h: Option<f64>,
    frames: Vec<TransformsFrame>,
}

#[derive(Deserialize)]
#[serde(expecting = "a frame")]
struct TransformsFrame {
    transform_matrix: Vec<Vec<f64>>,
}

/// Reads a camera path; `size` (width and height in pixels) goes before the
/// file's own. Two kinds are recognised by their keys:
///
/// * `camera_path`: nerfstudio's; `fov` is vertical, in degrees; poses are
///   taken as scene units.
/// * `frames`: as in `transforms.json`, with `camera_angle_x`, horizontal, in
///   radians, and perhaps `w` and `h`; a lens other than a pinhole is left out.
///
/// # Errors
/// One line: the file, what was found and what was expected.
pub fn camera_path(file: &Path, size: Option<[u32; 2]>) -> Result<Vec<Camera>, CameraError> {
    let text = json::read(file)?;
    let keys: Keys = json::parse(&text, file, "a JSON object with a camera path")?;
    let cameras = if keys.contains_key("camera_path") {
        nerfstudio(json::parse(&text, file, NERFSTUDIO)?, file, size)
    } else if keys.contains_key("frames") {
        transforms(json::parse(&text, file, TRANSFORMS)?, file, size)
    } else {
        return Err(CameraError::NotAPath(file.to_owned()));
    }?;
    if cameras.is_empty() { Err(CameraError::Empty(file.to_owned())) } else { Ok(cameras) }
}

fn nerfstudio(
    path: NerfstudioPath,
    file: &Path,
    size: Option<[u32; 2]>,
) -> Result<Vec<Camera>, CameraError> {
    if let Some(found) = path.camera_type.filter(|lens| lens != "perspective") {
        return Err(CameraError::Lens { file: file.to_owned(), found });
    }
    let [width, height] = size_or(size, path.render_width, path.render_height, file)?;
    let camera = |(index, camera): (usize, &NerfstudioCamera)| {
        let pose = checked(pose::from_list(&camera.camera_to_world), file, index)?;
        let expected = "a vertical angle in degrees from 0.5 to below 180";
        let fov_y = field_of_view(Some(camera.fov), 0.5..180.0, expected, file, index)?;
        let focal = (0.5 * f64::from(height) / (0.5 * fov_y.to_radians()).tan()) as f32;
        Ok(Camera {
            width,
            height,
            focal: [focal, focal],
            center: [0.5 * width as f32, 0.5 * height as f32],
            camera_to_world: pose,
        })
    };
    path.camera_path.iter().enumerate().map(camera).collect()
}

fn transforms(
    path: TransformsPath,
    file: &Path,
    size: Option<[u32; 2]>,
) -> Result<Vec<Camera>, CameraError> {
    let [width, height] = size_or(size, path.w, path.h, file)?;
    let expected = "\"camera_angle_x\" in radians from 0.01 to below pi";
    let angles = 0.01..std::f64::consts::PI;
    let fov_x = field_of_view(path.camera_angle_x, angles, expected, file, 0)? as f32;
    let camera = |(index, frame): (usize, &TransformsFrame)| {
        let pose = checked(pose::from_rows(&frame.transform_matrix), file, index)?;
        Ok(Camera::from_fov_x(width, height, fov_x, pose))
    };
    path.frames.iter().enumerate().map(camera).collect()
}

fn checked(
    pose: Result<[f32; 16], pose::PoseProblem>,
    file: &Path,
    camera: usize,
) -> Result<[f32; 16], CameraError> {
    pose.map_err(|problem| CameraError::Pose { file: file.to_owned(), camera, problem })
}

fn field_of_view(
    angle: Option<f64>,
    range: std::ops::Range<f64>,
    expected: &'static str,
    file: &Path,
    camera: usize,
) -> Result<f64, CameraError> {
    angle.filter(|angle| range.contains(angle)).ok_or_else(|| CameraError::FieldOfView {
        file: file.to_owned(),
        camera,
        found: angle.map_or_else(|| "missing".to_owned(), |angle| angle.to_string()),
        expected,
    })
}

/// The requested size, or the file's.
fn size_or(
    asked: Option<[u32; 2]>,
    width: Option<f64>,
    height: Option<f64>,
    file: &Path,
) -> Result<[u32; 2], CameraError> {
    let own = width.zip(height).map(|(width, height)| [width, height]);
    let size = asked.map(|size| size.map(f64::from)).or(own);
    match size {
        Some(size) if size.iter().all(|side| (1.0..=65536.0).contains(side)) => {
            Ok(size.map(|side| side as u32))
        }
        _ => {
            let found = size.map_or_else(|| "missing".to_owned(), |[w, h]| format!("{w}x{h}"));
            Err(CameraError::Size { file: file.to_owned(), found })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, size: Option<[u32; 2]>) -> Result<Vec<Camera>, String> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("path.json");
        std::fs::write(&file, text).unwrap();
        camera_path(&file, size).map_err(|error| {
            let error = error.to_string();
            error.split_once("path.json").expect("the file is named").1.to_owned()
        })
    }

    const FLAT: &str = "[1,0,0,5, 0,1,0,6, 0,0,1,7, 0,0,0,1]";
    const ROWS: &str = "[[1,0,0,5],[0,1,0,6],[0,0,1,7],[0,0,0,1]]";

    #[test]
    fn nerfstudio_angles_are_vertical() {
        let text = format!(
            r#"{{"camera_type": "perspective", "render_width": 80, "render_height": 60.0, "fps": 24,
                "camera_path": [{{"camera_to_world": {FLAT}, "fov": 90, "aspect": 1}}]}}"#
        );
        let cameras = read(&text, None).unwrap();
        // 90° high, 60 pixels: focal 30.
        let camera = &cameras[0];
        assert_eq!((cameras.len(), camera.width, camera.height), (1, 80, 60));
        assert!((camera.focal[0] - 30.0).abs() < 1e-4 && camera.focal[0] == camera.focal[1]);
        assert_eq!((camera.center, camera.position()), ([40.0, 30.0], [5.0, 6.0, 7.0]));
        let other = &read(&text, Some([20, 20])).unwrap()[0];
        assert!((other.focal[0] - 10.0).abs() < 1e-4 && other.width == 20);
    }

    #[test]
    fn transforms_angles_are_horizontal() {
        let text = format!(
            r#"{{"camera_angle_x": {}, "frames": [{{"transform_matrix": {ROWS}, "file_path": "a"}}]}}"#,
            std::f64::consts::FRAC_PI_2
        );
        let camera = &read(&text, Some([80, 60])).unwrap()[0];
        assert!((camera.focal[1] - 40.0).abs() < 1e-4, "{camera:?}");
        assert_eq!(
            read(&text, None).unwrap_err(),
            ": picture size missing, expected 1x1 to 65536x65536; give --width and --height"
        );
    }

    #[test]
    fn what_is_wrong_is_said() {
        let size = Some([8, 8]);
        for (text, message) in [
            ("{}", ": no camera path: neither"),
            ("[]", ":1:0: invalid type: sequence, expected a map; expected a JSON object"),
            (r#"{"camera_path": []}"#, ": no cameras in it"),
            (r#"{"camera_path": 3}"#, ":1:17: invalid type: integer"),
            (r#"{"camera_path": [], "camera_type": "fisheye"}"#, ": camera type \"fisheye\""),
            (r#"{"frames": []}"#, ": camera 0: field of view missing"),
            (
                r#"{"frames": [{"transform_matrix": []}], "camera_angle_x": 1}"#,
                ": camera 0: the pose",
            ),
        ] {
            let error = read(text, size).unwrap_err();
            assert!(error.starts_with(message), "{error}");
        }
        let wide = format!(r#"{{"camera_path": [{{"camera_to_world": {FLAT}, "fov": 180}}]}}"#);
        assert!(read(&wide, size).unwrap_err().starts_with(": camera 0: field of view 180"));
        assert!(read(&wide, Some([0, 8])).unwrap_err().starts_with(": picture size 0x8"));
    }
}
