//! From a checkpoint to a model: coordinates, cells, cameras.

use pocketnerf_cli::convert::{compare_models, nerfstudio};
use pocketnerf_core::{Camera, Model, SimdLevel, Space};
use pocketnerf_formats::import::ngp::Ngp;
use pocketnerf_train::convert::{NgpConversion, Settings};
use pocketnerf_train::picture::{self, Sampling};
use serde_json::Value;

use super::{bytes, ngp, path};

fn converted(ngp: Ngp, settings: Settings, crop: Option<[[f32; 3]; 2]>) -> NgpConversion {
    NgpConversion::new(ngp, settings, crop, SimdLevel::detect()).unwrap()
}

#[test]
fn a_snapshot_of_three_cubes() {
    let conversion = converted(ngp(&bytes("cutlass.ingp")).unwrap(), Settings::default(), None);
    let model = conversion.model().unwrap();
    assert_eq!(model.space, Space::Box { min: [-1.5; 3], max: [2.5; 3] });
    assert_eq!(model.display.background, [1.0, 0.5, 0.25]);
    let cells = model.occupancy.unwrap();
    // As small as the smallest of 128 in a quarter of the side.
    assert_eq!(cells.resolution(), 512);
    assert!((0.1..0.9).contains(&cells.fraction()), "{}", cells.fraction());
}

/// The snapshot's cameras, back in the dataset's coordinates, are those it was made of.
#[test]
fn cameras_of_a_snapshot() {
    for (file, name) in [("fused.msgpack", "fused"), ("cutlass.ingp", "cutlass")] {
        let conversion = converted(ngp(&bytes(file)).unwrap(), Settings::default(), None);
        let about: Value = serde_json::from_slice(&bytes(&format!("{name}.json"))).unwrap();
        let expected = about["cameras"].as_array().unwrap();
        let scene = conversion.scene();
        assert_eq!((conversion.views().len(), expected.len()), (3, 3));
        for (view, expected) in conversion.views().iter().zip(expected) {
            let number = |key: &str| expected[key].as_f64().unwrap() as f32;
            let mut camera = Camera {
                width: number("w") as u32,
                height: number("h") as u32,
                focal: [number("fl_x"), number("fl_y")],
                center: [number("cx"), number("cy")],
                camera_to_world: [0.0; 16],
            };
            camera.camera_to_world[15] = 1.0;
            for (r, c) in (0..3).flat_map(|r| (0..4).map(move |c| (r, c))) {
                let value = expected["camera_to_world"][r][c].as_f64().unwrap();
                camera.camera_to_world[4 * r + c] = value as f32;
            }
            let camera = scene.camera_to_model(&camera);
            assert_eq!((view.width, view.height), (camera.width, camera.height));
            let all = |c: &Camera| [&c.focal[..], &c.center, &c.camera_to_world].concat();
            for (found, expected) in all(view).iter().zip(all(&camera)) {
                assert!((found - expected).abs() < 1e-4, "{view:?} {camera:?}");
            }
        }
    }
}

#[test]
fn a_crop_leaves_cells_out() {
    let whole = converted(ngp(&bytes("fused.msgpack")).unwrap(), Settings::default(), None);
    // In the dataset's coordinates, the unit cube reaches from -0.5 / 0.33 to 0.5 / 0.33.
    let crop = [[-9.0, -9.0, -9.0], [9.0, 9.0, 0.0]];
    let cropped = converted(ngp(&bytes("fused.msgpack")).unwrap(), Settings::default(), Some(crop));
    let [whole, cropped] = [&whole, &cropped].map(|conversion| {
        let occupancy = conversion.model().unwrap().occupancy.unwrap();
        let n = occupancy.resolution();
        let set = move |cell: &u32| occupancy.cell(cell % n, cell / n % n, cell / (n * n));
        (0..n * n * n)
            .filter(set)
            .map(|cell| [cell % n, cell / n % n, cell / (n * n)])
            .collect::<Vec<_>>()
    });
    // The dataset's z is the model's y.
    let expected: Vec<_> = whole.iter().filter(|[_, y, _]| *y < 16).copied().collect();
    assert!(!expected.is_empty() && expected.len() < whole.len());
    assert_eq!(cropped, expected);
}

/// Without a density grid, the occupied cells are computed from the field.
#[test]
fn cells_that_are_baked() {
    let mut bytes = bytes("old.msgpack");
    let key = b"density_grid_binary";
    let at = (0..bytes.len()).find(|at| bytes[*at..].starts_with(key)).unwrap();
    bytes[at] = b'D';
    let source = ngp(&bytes).unwrap();
    assert!(source.context().cells.is_none());
    let black = Settings { background: Some([0.0; 3]), ..Settings::default() };
    let conversion = converted(source, black, None);
    let model = conversion.model().unwrap();
    let whole = Model { occupancy: None, ..model };
    let settings = picture::Settings { quality: 1.0, ..picture::Settings::default() };
    let models = [(&whole, Sampling::Occupancy), (&model, Sampling::Occupancy)];
    let views: Vec<Camera> = conversion.views().iter().map(|view| view.downscaled(2)).collect();
    let found = compare_models(models, &views, &settings).unwrap();
    assert!(found.psnr > 40.0, "{found:?}");
}

#[test]
fn what_is_missing_is_named() {
    let background = NgpConversion::new(
        ngp(&bytes("torch/torch_ngp.pth")).unwrap(),
        Settings::default(),
        None,
        SimdLevel::detect(),
    );
    assert!(background.unwrap_err().to_string().contains("--background"));
    // A checkpoint of nerfstudio alone does not say whether its space is a box.
    let file = "torch/nerfstudio_tcnn/nerfstudio_models/step-000000009.ckpt";
    let mut alone = ngp(&bytes(file)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let error = nerfstudio::complete(&mut alone, &folder.path().join("models/step.ckpt"));
    assert!(error.unwrap_err().to_string().contains("config.yml"));
    let config = std::fs::read_to_string(path("torch/nerfstudio_tcnn/config.yml")).unwrap();
    let contracted =
        config.replace("disable_scene_contraction: true", "disable_scene_contraction: false");
    assert_ne!(config, contracted);
    std::fs::write(folder.path().join("config.yml"), contracted).unwrap();
    let error = nerfstudio::complete(&mut alone, &folder.path().join("models/step.ckpt"));
    let error = error.unwrap_err().to_string();
    assert!(error.contains("contracted space") && error.contains("config.yml"), "{error}");
}
