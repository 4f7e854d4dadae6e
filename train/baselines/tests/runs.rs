//! Runs of all baselines on the built-in scene: what they learn, whether they are repeatable, and
//! what becomes of their files.

use std::time::Instant;

use pocketnerf_baselines::{Baseline, BaselineError, Method, Origin, Photographs, Renderer, Run};
use pocketnerf_core::Camera;
use pocketnerf_train::builtin;
use pocketnerf_train::dataset::{Dataset, Split, View};
use pocketnerf_train::evaluate::evaluate_pictures;
use pocketnerf_train::lens::Lens;
use pocketnerf_train::metrics::{Metrics, composite_on, psnr, quantize_all};
use pocketnerf_train::picture::Painter;
use pocketnerf_train::trainer::Length;

const WHITE: [f32; 3] = [1.0; 3];
/// By how much pictures are made smaller: 25x25 pixels remain.
const FACTOR: u32 = 16;

fn dataset(split: Split) -> Dataset {
    builtin::dataset(split, FACTOR)
}

fn run(method: Method, steps: u32) -> (Photographs, Run) {
    let dataset = dataset(Split::Train);
    let origin = Origin::of(&dataset, 3, FACTOR);
    let photographs = Photographs::new(dataset, None).unwrap();
    let length = Length::Steps(steps);
    let run = Run::new(method, &photographs, origin, length, Instant::now()).unwrap();
    (photographs, run)
}

fn trained(method: Method, steps: u32) -> Baseline {
    let (photographs, mut run) = run(method, steps);
    while run.step(&photographs).unwrap().is_some() {}
    run.finish().unwrap()
}

fn picture(baseline: &Baseline, camera: &Camera) -> Vec<f32> {
    let mut renderer = Renderer::new(baseline);
    renderer.paint(camera, &Lens::Pinhole).unwrap().rgba.clone()
}

/// The PSNR of a picture that is the mean of all training views.
fn psnr_of_the_mean() -> f64 {
    let over_white = |view: &View| composite_on(&view.rgba, WHITE);
    let train: Vec<Vec<f32>> = dataset(Split::Train).views.iter().map(over_white).collect();
    let n = train.len() as f32;
    let mean: Vec<f32> =
        (0..train[0].len()).map(|i| train.iter().map(|view| view[i]).sum::<f32>() / n).collect();
    let test = dataset(Split::Test);
    let of = |view: &View| psnr(&quantize_all(&mean), &quantize_all(&over_white(view)));
    test.views.iter().map(of).sum::<f64>() / test.views.len() as f64
}

#[test]
fn held_out_views_are_better_than_the_mean_of_all_photographs() {
    let mean = psnr_of_the_mean();
    for (method, steps, better) in
        [(Method::Llff, 60, 4.0), (Method::Srn, 400, 3.0), (Method::NeuralVolumes, 100, 4.0)]
    {
        let baseline = trained(method, steps);
        let mut renderer = Renderer::new(&baseline);
        let test = dataset(Split::Test);
        let metrics = Metrics::default();
        let found = evaluate_pictures(&mut renderer, &test, WHITE, &metrics, |_, _, _| ()).unwrap();
        assert!(found.psnr > mean + better, "{method}: {} dB, the mean {mean}", found.psnr);
        assert_eq!(baseline.steps(), steps);
        assert_eq!(baseline.doubt(), None, "{method}");
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_at_any_number_of_threads() {
    for method in Method::ALL {
        let of = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| trained(method, 4))
        };
        let one = of(1).to_bytes();
        for threads in [2, 3, 7] {
            assert!(one == of(threads).to_bytes(), "{method}: {threads} threads");
        }
    }
}

#[test]
fn an_interrupted_run_ends_as_if_nothing_had_happened() {
    for method in Method::ALL {
        let (photographs, mut whole) = run(method, 7);
        let mut checkpoint = Vec::new();
        while let Some(progress) = whole.step(&photographs).unwrap() {
            if progress.step == 3 {
                checkpoint = whole.checkpoint();
            }
        }
        let stored = Run::read(&checkpoint).unwrap();
        assert_eq!((stored.method(), stored.steps()), (method, 3));
        let origin = stored.origin().clone();
        let mut resumed = stored.resume(&origin, Instant::now()).unwrap();
        while resumed.step(&photographs).unwrap().is_some() {}
        let [a, b] = [whole, resumed].map(|run| run.finish().unwrap().to_bytes());
        assert!(a == b, "{method}");
        // Other photographs are refused.
        let stored = Run::read(&checkpoint).unwrap();
        let other = Origin { fingerprint: origin.fingerprint + 1, ..origin };
        let refused = stored.resume(&other, Instant::now()).unwrap_err();
        assert!(matches!(refused, BaselineError::OtherPhotographs));
    }
}

#[test]
fn files_are_read_back_and_damaged_ones_are_refused() {
    let camera = dataset(Split::Test).views[0].camera;
    for method in Method::ALL {
        let baseline = trained(method, 2);
        let bytes = baseline.to_bytes();
        let read = Baseline::from_bytes(&bytes).unwrap();
        assert!(picture(&baseline, &camera) == picture(&read, &camera), "{method}");
        assert_eq!((read.origin(), read.steps()), (baseline.origin(), 2));
        assert!(read.to_bytes() == bytes, "{method}");
        for length in [0, 7, 8, 11, 12, 40, bytes.len() - 1] {
            assert!(Baseline::from_bytes(&bytes[..length]).is_err(), "{method}: {length} bytes");
        }
        for at in [0, 7, 8, 12, 30, bytes.len() / 2, bytes.len() - 1] {
            let mut other = bytes.clone();
            other[at] ^= 1;
            assert!(Baseline::from_bytes(&other).is_err(), "{method}: byte {at}");
        }
        // A checkpoint is none, and the other way round.
        assert!(matches!(Run::read(&bytes), Err(BaselineError::Kind { .. })));
    }
}

#[test]
fn what_cannot_be_learnt_from_is_refused() {
    let nothing = Dataset::new("nothing", "test", Split::Train, Vec::new());
    assert!(matches!(Photographs::new(nothing, None), Err(BaselineError::NoPhotographs)));
    let mut opaque = dataset(Split::Train);
    // Something else at every edge: no plain background.
    for (view, i) in opaque.views.iter_mut().zip(0_u32..) {
        for (pixel, k) in view.rgba.as_chunks_mut::<4>().0.iter_mut().zip(0_u32..) {
            *pixel = [(k * 37 % 256) as u8, (i * 91 % 256) as u8, (k * i % 256) as u8, 255];
        }
    }
    opaque.has_alpha = false;
    let mut one = opaque.clone();
    one.views.truncate(1);
    let refusal = |dataset: Dataset, method| {
        let refusal = Photographs::new(dataset, None).unwrap().refusal(method);
        refusal.map(|refusal| refusal.to_string())
    };
    assert_eq!(
        refusal(one, Method::Llff).unwrap(),
        "1 photographs, expected at least 2 for this method"
    );
    let unknown = refusal(opaque.clone(), Method::NeuralVolumes).unwrap();
    assert!(unknown.starts_with("the background of these photographs is not known"), "{unknown}");
    assert_eq!(refusal(opaque, Method::Srn), None);
}
