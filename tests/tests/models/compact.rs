//! Models in fewer bytes than packing alone gives.

use pocketnerf_core::{Camera, SimdLevel};
use pocketnerf_formats::{
    Container, PACKED_HALVES, Precision, kind, open, open_verified, pack, unpacked, write,
};
use pocketnerf_tests::tiny::{self, Tiny};
use pocketnerf_train::compact::{CompactError, Compacted, smallest, to_bytes};
use pocketnerf_train::picture::{Renderer, Settings};

fn still_life() -> Vec<u8> {
    std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../embed-demo/still-life.pnerf")).unwrap()
}

/// The model's own view, and some beside it.
fn cameras(bytes: &[u8]) -> Vec<Camera> {
    let camera = open(bytes).unwrap().camera(60, 60);
    let moved = |by: f32| {
        let mut camera = camera;
        camera.camera_to_world[3] += by;
        camera
    };
    [0.0, 0.1, -0.1].map(moved).to_vec()
}

fn settings() -> Settings {
    Settings { simd: SimdLevel::detect(), ..Settings::default() }
}

/// Pictures over the model's background, one after another.
fn pictures(bytes: &[u8], cameras: &[Camera]) -> Vec<f32> {
    let bytes = unpacked(bytes).unwrap();
    let file = open_verified(&bytes).unwrap();
    let mut renderer = Renderer::new(&file.model, &Settings { quality: 1.0, ..settings() });
    let background = file.model.display.background;
    cameras.iter().flat_map(|camera| renderer.render(camera).unwrap().over(background)).collect()
}

#[test]
fn as_many_bytes_as_asked_for_and_the_difference_that_is_said() {
    let bytes = still_life();
    let cameras = cameras(&bytes);
    let own = pictures(&bytes, &cameras);
    let mut last = f64::INFINITY;
    for most in [90_000, 70_000, 55_000] {
        let Compacted { bytes: small, steps, network_steps, psnr, .. } =
            to_bytes(&bytes, most, None, &cameras, &settings()).unwrap();
        println!("{most}: {} bytes, {psnr:.2} dB, {steps:?} {network_steps:?}", small.len());
        // Networks are rounded too, and packed so.
        assert!(network_steps.iter().any(|step| *step > 1), "{network_steps:?}");
        let sections = Container::open(&small).unwrap();
        let mut matrices = sections.sections().filter(|s| s.id.kind == kind::NETWORK);
        assert!(matrices.any(|matrix| matrix.encoding == PACKED_HALVES));
        assert!(small.len() <= most && small.len() as f64 >= 0.97 * most as f64);
        // What is said is what a program sees that opens the file.
        let found = pictures(&small, &cameras);
        let squares = own.iter().zip(&found).map(|(a, b)| f64::from((a - b).powi(2)));
        let seen = -10.0 * (squares.sum::<f64>() / own.len() as f64).log10();
        assert!((seen - psnr).abs() < 1e-6, "{seen} {psnr}");
        // Fewer bytes are worse, and fine levels suffer first.
        assert!(psnr < last && psnr > 20.0, "{psnr}");
        assert!(steps.last() >= steps.first() && steps.iter().any(|step| *step > 1));
        // The same again.
        let again = to_bytes(&bytes, most, None, &cameras, &settings()).unwrap();
        assert!(again.bytes == small);
        last = psnr;
    }
}

/// What training got used to gives way like all else: networks do not pay for tables.
#[test]
fn known_steps_that_do_not_fit_become_coarser() {
    let bytes = still_life();
    let cameras = cameras(&bytes);
    let in_bytes = |most, lengths: Option<&[f32]>| {
        to_bytes(&bytes, most, lengths, &cameras, &settings()).unwrap()
    };
    let known = in_bytes(90_000, None);
    for most in [86_000, 75_000, 60_000] {
        let [free, used] = [None, Some(&known.lengths[..])].map(|lengths| in_bytes(most, lengths));
        println!("{most}: {:.2} dB, {:.2} dB {:?}", free.psnr, used.psnr, used.network_steps);
        assert!(used.bytes.len() <= most);
        assert!(used.psnr > free.psnr - 0.5, "{most}: {:.2}, {:.2}", used.psnr, free.psnr);
        let finer = used.steps.iter().zip(&known.steps).filter(|(used, known)| used < known);
        assert_eq!(finer.count(), 0, "{:?} {:?}", used.steps, known.steps);
    }
}

#[test]
fn as_few_bytes_as_a_difference_of_pictures_allows() {
    let bytes = still_life();
    let cameras = cameras(&bytes);
    let least = |psnr: f64| {
        smallest(&bytes, &cameras, &settings(), |_, error| Ok(-10.0 * error.log10() >= psnr))
            .unwrap()
    };
    let mut last = 0;
    for psnr in [30.0, 36.0, 42.0] {
        let small = least(psnr);
        println!("{psnr}: {} bytes, {:.2} dB, {:?}", small.bytes.len(), small.psnr, small.steps);
        assert!((psnr..psnr + 1.0).contains(&small.psnr), "{}", small.psnr);
        assert!(small.bytes.len() > last);
        last = small.bytes.len();
        // So many bytes are not spent better.
        let same = to_bytes(&bytes, last, None, &cameras, &settings()).unwrap();
        assert!(same.psnr < small.psnr + 0.5, "{} {}", same.psnr, small.psnr);
    }
    // What no rounded model is: the file as it is, packed.
    let whole = smallest(&bytes, &cameras, &settings(), |_, _| Ok(false)).unwrap();
    assert!(whole.bytes == pack(&bytes).unwrap() && whole.psnr == f64::INFINITY);
}

/// However bad pictures may be: where density becomes less, light passes further.
#[test]
fn a_smaller_model_takes_at_most_twice_as_many_samples() {
    let bytes = still_life();
    let cameras = cameras(&bytes);
    let samples = |bytes: &[u8]| -> u64 {
        let bytes = unpacked(bytes).unwrap();
        let file = open_verified(&bytes).unwrap();
        let mut renderer = Renderer::new(&file.model, &Settings { quality: 1.0, ..settings() });
        cameras.iter().map(|camera| renderer.render(camera).unwrap().stats.samples).sum()
    };
    let small = smallest(&bytes, &cameras, &settings(), |_, _| Ok(true)).unwrap();
    let work = samples(&small.bytes) as f64 / samples(&bytes) as f64;
    println!("{} bytes, {:.2} dB, {work:.2} times as many", small.bytes.len(), small.psnr);
    assert!(small.psnr < 20.0 && work <= 2.0, "{work}");
}

#[test]
fn what_fits_is_packed_alone_and_what_cannot_fit_is_refused() {
    let bytes = still_life();
    let cameras = cameras(&bytes);
    let packed = pack(&bytes).unwrap();
    let whole = to_bytes(&bytes, packed.len(), None, &cameras, &settings()).unwrap();
    assert!(whole.bytes == packed && whole.psnr == f64::INFINITY);
    assert!(whole.steps.iter().all(|step| *step == 1));
    let refused = to_bytes(&bytes, 9_000, None, &cameras, &settings()).unwrap_err();
    let CompactError::TooSmall { most: 9_000, least } = refused else { panic!("{refused}") };
    assert!((9_000..55_000).contains(&least), "{least}");
    assert!(refused.to_string().starts_with("9000 bytes are too few, expected at least "));
    let nerf = write(&Tiny::new().nerf(), &tiny::about(), Precision::F16).unwrap();
    assert_eq!(to_bytes(&nerf, 100, None, &cameras, &settings()), Err(CompactError::NoTables));
}
