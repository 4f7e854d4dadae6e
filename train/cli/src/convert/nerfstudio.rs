//! The files of nerfstudio in the folder above its checkpoints: `config.yml` and
//! `dataparser_transforms.json`.

use std::path::Path;

use pocketnerf_formats::Scene;
use pocketnerf_formats::import::ngp::Ngp;

use super::config::{Values, text};
use pocketnerf_train::convert::{ConvertError, Settings};

const CONFIG: &str = "config.yml";
const TRANSFORMS: &str = "dataparser_transforms.json";

/// Completes a field by the files beside its checkpoint, and returns the config's settings.
/// Fields of other programs are left unchanged.
///
/// # Errors
/// [`ConvertError::Beside`] if there is no config, [`ConvertError::Config`] for files that
/// cannot be read and for what a model cannot express: a contracted space.
pub fn complete(ngp: &mut Ngp, checkpoint: &Path) -> Result<Settings, ConvertError> {
    if ngp.program() != "nerfstudio" {
        return Ok(Settings::default());
    }
    let folder = checkpoint.parent().and_then(Path::parent).unwrap_or(Path::new(".."));
    let file = folder.join(CONFIG);
    if !file.is_file() {
        return Err(ConvertError::Beside(file));
    }
    let refuse = |problem| ConvertError::Config { file: file.clone(), problem };
    let values = text(&file).and_then(|text| Values::of_yaml(&text)).map_err(refuse)?;
    let (settings, step) = of_config(&values).map_err(refuse)?;
    let around = ngp.context_mut();
    around.step = step.unwrap_or(around.step);
    let file = folder.join(TRANSFORMS);
    if file.is_file() {
        let scene = text(&file).and_then(|text| scene(&text));
        around.scene = scene.map_err(|problem| ConvertError::Config { file, problem })?;
    }
    Ok(settings)
}

/// Settings, and the distance between samples where one is given.
fn of_config(values: &Values) -> Result<(Settings, Option<f32>), String> {
    let key = |key: &str| format!("pipeline.model.{key}");
    let bounded = values.truth(&key("disable_scene_contraction"))?;
    let older = values.text(&key("contraction_type")).map(|kind| kind.contains("AABB"));
    if !bounded.or(older).unwrap_or(false) {
        return Err("disable_scene_contraction is not true: a contracted space cannot be \
                    expressed, only a box (instant-ngp-bounded)"
            .to_owned());
    }
    let background = match values.text(&key("background_color")) {
        Some("white") => Some([1.0; 3]),
        Some("black") => Some([0.0; 3]),
        _ => None,
    };
    let step = values.number::<f32>(&key("render_step_size"))?;
    if let Some(step) = step
        && !(1e-6..1e3).contains(&step)
    {
        return Err(format!("render_step_size is {step}, expected more than 0"));
    }
    let near = values.number(&key("near_plane"))?;
    Ok((Settings { near, background, ..Settings::default() }, step))
}

#[derive(serde::Deserialize)]
struct Transforms {
    transform: [[f32; 4]; 3],
    scale: f32,
}

/// The model's point is `scale (R p + t)` of the dataset's p.
fn scene(text: &str) -> Result<Scene<'static>, String> {
    let Transforms { transform, scale } =
        serde_json::from_str(text).map_err(|error| error.to_string())?;
    let row = |i: usize| [0, 1, 2].map(|j| transform[i][j]);
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let rotation = [row(0), row(1), row(2)];
    let [a, b, c] = rotation;
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let is_rotation = [dot(a, a) - 1.0, dot(b, b) - 1.0, dot(a, b), dot(cross, c) - 1.0];
    if !is_rotation.iter().all(|wrong| wrong.abs() < 1e-3) || !(1e-6..1e6).contains(&scale) {
        return Err("expected a rotation, a translation and a scale".to_owned());
    }
    let inverse = [0, 1, 2].map(|i| rotation.map(|row| row[i]));
    let moved = [0, 1, 2].map(|i| transform[i][3]);
    let translation = inverse.map(|row| -dot(row, moved));
    Ok(Scene { scale: 1.0 / scale, rotation: inverse, translation, name: None })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transforms_by_hand() {
        // A quarter turn about z, then moved, then half as large.
        let text = r#"{"transform": [[0,-1,0,1],[1,0,0,2],[0,0,1,3]], "scale": 0.5}"#;
        let scene = scene(text).unwrap();
        assert_eq!(scene.to_model([10.0, 20.0, 30.0]), [-9.5, 6.0, 16.5]);
        assert_eq!(scene.to_model_direction([1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
        for text in [
            "{}",
            r#"{"transform": [[0,-2,0,1],[1,0,0,2],[0,0,1,3]], "scale": 1}"#,
            r#"{"transform": [[0,-1,0,1],[1,0,0,2],[0,0,-1,3]], "scale": 1}"#,
            r#"{"transform": [[0,-1,0,1],[1,0,0,2],[0,0,1,3]], "scale": 0}"#,
        ] {
            assert!(super::scene(text).is_err(), "{text}");
        }
    }

    #[test]
    fn configs() {
        let read = |text: &str| of_config(&Values::of_yaml(text)?);
        let model = |rest: &str| {
            format!(
                "a: &x !!python/name:A ''\npipeline: !!python/object:P\n  model: !!python/object:M\n    {rest}\n"
            )
        };
        let (settings, step) = read(&model(
            "disable_scene_contraction: true\n    background_color: white\n    near_plane: 0.05\n    render_step_size: null",
        ))
        .unwrap();
        assert_eq!((settings.background, settings.near, step), (Some([1.0; 3]), Some(0.05), None));
        let refused = read(&model("disable_scene_contraction: false")).unwrap_err();
        assert!(refused.contains("contracted space"), "{refused}");
        let older = read(&model("contraction_type: AABB\n    render_step_size: 0.01")).unwrap();
        assert_eq!((older.0.background, older.1), (None, Some(0.01)));
        assert!(read(&model("disable_scene_contraction: true\n    render_step_size: 0")).is_err());
    }
}
