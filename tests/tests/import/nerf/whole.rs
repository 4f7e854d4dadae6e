//! From a checkpoint to a model: settings, box, cells, file.

use pocketnerf_cli::convert::{compare_models, config, distill, refuse_others};
use pocketnerf_core::field::Shading;
use pocketnerf_core::march::Reach;
use pocketnerf_core::{Camera, Model, SimdLevel, Space};
use pocketnerf_formats::{About, PixelOrigin, Precision};
use pocketnerf_train::convert::{ConvertError, NerfConversion, Place, Settings};
use pocketnerf_train::metrics;
use pocketnerf_train::picture::{self, Sampling};
use pocketnerf_train::trainer::Length;

use super::{bytes, nerf, path};

const SETTINGS: Settings = Settings {
    near: Some(2.0),
    far: Some(6.0),
    samples: [Some(64), Some(128)],
    background: Some([0.0; 3]),
    ndc: None,
    pixel_origin: None,
    along_rays: None,
};

fn cameras() -> [Camera; 2] {
    [[4.0, 0.5, 0.0], [-1.0, -2.0, 3.2]].map(|from| {
        let pose = Camera::look_at(from, [0.0; 3], [0.0, 0.0, 1.0]);
        Camera::from_fov_x(24, 24, 0.7, pose)
    })
}

/// A field that is thin in places: cells leave some of it out, and nothing that shows.
#[test]
fn cells_cost_next_to_nothing() {
    let nerf = nerf(&bytes("first_paper.ckpt")).unwrap();
    let aabb = [[-3.0; 3], [3.0; 3]];
    let place = |ndc: bool| {
        assert!(!ndc);
        Ok(Some(Place::Box(aabb)))
    };
    let conversion = NerfConversion::new(nerf, SETTINGS, place, SimdLevel::detect()).unwrap();
    let model = conversion.model().unwrap();
    let fraction = model.occupancy.unwrap().fraction();
    assert!((0.01..0.9).contains(&fraction), "{fraction}");
    assert_eq!(model.space, Space::Box { min: aabb[0], max: aabb[1] });
    assert_eq!(model.hierarchical.unwrap().reach, Reach::Depth);
    assert_eq!(conversion.pixel_origin(), PixelOrigin::Corner);
    let source = Model { occupancy: None, ..model };
    let settings = picture::Settings { quality: 1.0, ..picture::Settings::default() };
    let about = About { pixel_origin: PixelOrigin::Corner, ..About::default() };
    let written = pocketnerf_formats::write(&model, &about, Precision::F16).unwrap();
    let file = pocketnerf_formats::open_verified(&written).unwrap();
    assert_eq!(file.about.pixel_origin, PixelOrigin::Corner);
    let paper = [(&source, Sampling::Hierarchical), (&file.model, Sampling::Hierarchical)];
    let same = compare_models(paper, &cameras(), &settings).unwrap();
    assert!(same.psnr > 50.0 && same.evaluations[0] == same.evaluations[1], "{same:?}");
    // Marched with cells and without.
    let marched = Model { occupancy: None, ..file.model };
    let whole = compare_models(
        [(&marched, Sampling::Occupancy), (&file.model, Sampling::Occupancy)],
        &cameras(),
        &settings,
    );
    let whole = whole.unwrap();
    assert!(whole.psnr > 45.0 && whole.evaluations[1] < 0.8 * whole.evaluations[0], "{whole:?}");
}

/// What a distilled model learns from, and how large it may become.
#[test]
fn views_to_learn_from() {
    let nerf = nerf(&bytes("first_paper.ckpt")).unwrap();
    let place = |_| Ok(Some(Place::Box([[-1.0; 3], [1.0; 3]])));
    let conversion = NerfConversion::new(nerf, SETTINGS, place, SimdLevel::detect()).unwrap();
    let model = conversion.model().unwrap();
    let settings = picture::Settings { quality: 1.0, ..picture::Settings::default() };
    let mut rendered = 0;
    let mut renderer = picture::Renderer::new(&model, &settings);
    let place = (&model.space, &model.display);
    let dataset = distill::views(&mut renderer, place, &cameras(), |_| rendered += 1).unwrap();
    assert!(dataset.has_alpha && rendered == 2);
    for (view, camera) in dataset.views.iter().zip(cameras()) {
        assert_eq!(view.camera, camera);
        let picture = picture::render(&model, &camera, &settings).unwrap();
        for background in [[0.0; 3], [1.0; 3]] {
            let pairs = metrics::composite_on(&view.rgba, background);
            let apart = pairs.iter().zip(picture.over(background)).map(|(a, b)| (a - b).abs());
            assert!(apart.fold(0.0, f32::max) < 1.5 / 255.0);
        }
    }
    let length = Length::Seconds(60.0);
    let log2 = |bytes| {
        let mut config = distill::config(&model.space, Shading::PerRay, bytes, length)?;
        assert_eq!(config.aabb, Some([[-1.0; 3], [1.0; 3]]));
        config.field.hash_grid_mut().map(|field| field.grid.log2_hashmap_size)
    };
    assert_eq!(log2(100_000_000), Some(17));
    assert_eq!(log2(100_000), None);
    assert!(log2(600_000).is_some());
    let [some, fewer] = [2_500_000, 1_000_000].map(|bytes| log2(bytes).unwrap());
    assert!(10 <= fewer && fewer < some && some < 17, "{fewer} {some}");
}

#[test]
fn the_same_bytes_at_any_number_of_threads() {
    let convert = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let nerf = nerf(&bytes("nerf_pl.ckpt")).unwrap();
            let conversion = NerfConversion::new(nerf, SETTINGS, |_| Ok(None), SimdLevel::detect());
            let conversion = conversion.unwrap();
            let model = conversion.model().unwrap();
            pocketnerf_formats::write(&model, &About::default(), Precision::F16).unwrap()
        })
    };
    assert!(convert(1) == convert(3));
}

#[test]
fn what_cannot_be_converted_is_named() {
    let convert = |settings, place: Result<Option<Place>, ConvertError>| {
        let nerf = nerf(&bytes("flexible.ckpt")).unwrap();
        NerfConversion::new(nerf, settings, |_| place, SimdLevel::detect()).unwrap_err().to_string()
    };
    let error = convert(Settings { near: None, ..SETTINGS }, Ok(None));
    assert!(error.contains("--near") && !error.contains("--far"), "{error}");
    let ndc = Settings { ndc: Some(true), ..SETTINGS };
    assert!(convert(ndc, Err(ConvertError::NoCameras(""))).contains("--data"));
    let error = convert(Settings { far: Some(1.0), ..SETTINGS }, Ok(None));
    assert!(error.contains("near 2, far 1"), "{error}");
    let ply = refuse_others(b"ply\nformat binary_little_endian 1.0\n").unwrap_err().to_string();
    assert!(ply.contains("Gaussian splats"), "{ply}");
}

#[test]
fn the_config_beside_a_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let checkpoint = folder.path().join("200000.tar");
    std::fs::copy(path("yenchenlin.tar"), &checkpoint).unwrap();
    assert_eq!(config::beside(&checkpoint).unwrap(), None);
    let file = folder.path().join("args.txt");
    let text = "N_importance = 128\nN_samples = 64\ndataset_type = blender\nwhite_bkgd = True\n";
    std::fs::write(&file, text).unwrap();
    let (found, settings) = config::beside(&checkpoint).unwrap().unwrap();
    assert_eq!(found, file);
    let given = Settings { far: Some(7.0), ..Settings::default() };
    let both = given.or(settings);
    assert_eq!((both.near, both.far, both.background), (Some(2.0), Some(7.0), Some([1.0; 3])));
    assert_eq!(both.samples, [Some(64), Some(128)]);
    std::fs::write(&file, "lindisp = True\n").unwrap();
    let error = config::beside(&checkpoint).unwrap_err().to_string();
    assert!(error.contains("args.txt") && error.contains("lindisp"), "{error}");
}
