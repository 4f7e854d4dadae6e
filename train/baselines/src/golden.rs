//! Files that are read for ever, and what becomes of them when bytes change.

use std::path::PathBuf;

use pocketnerf_core::Camera;
use pocketnerf_train::lens::Lens;
use pocketnerf_train::picture::Painter;

use crate::photographs::Place;
use crate::run::Record;
use crate::scene::Scene;
use crate::{Baseline, Method, Origin, Renderer, llff, neural_volumes, srn};

/// Bytes before the payload: the mark and the checksum.
const START: usize = 12;

fn path(method: Method, extension: &str) -> PathBuf {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden"));
    folder.join(format!("{method}.{extension}"))
}

/// A small baseline of each method.
fn small(method: Method) -> Baseline {
    let pose = Camera::look_at([0.2, 0.3, 4.0], [0.0; 3], [0.0, 1.0, 0.0]);
    let origin = Origin {
        dataset: "golden".to_owned(),
        fingerprint: 7,
        seed: 1,
        downscale_factor: 2,
        size: [12, 10],
        focal: [14.0; 2],
        poses: vec![pose],
        to_dataset: (2.0, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [1.0, 2.0, 3.0]),
    };
    let place =
        Place { center: [0.0; 3], half: 1.0, depths: [3.0, 5.0], background: [1.0, 0.9, 0.8] };
    let (steps, seconds) = (Some(5), None);
    let record = Record { origin, place, steps, seconds, step: 5, elapsed: 2.5, error: 0.01 };
    let scene = match method {
        Method::Llff => Scene::Llff(llff::tests::small()),
        Method::Srn => Scene::Srn(srn::tests::small()),
        Method::NeuralVolumes => Scene::NeuralVolumes(neural_volumes::tests::small()),
    };
    Baseline { record, scene }
}

/// 8-bit RGBA of its own camera's picture.
fn picture(baseline: &Baseline) -> Vec<u8> {
    let mut renderer = Renderer::new(baseline);
    let picture = renderer.paint(&baseline.origin().camera(), &Lens::Pinhole);
    let byte = |v: &f32| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    picture.map_or_else(|_| Vec::new(), |picture| picture.rgba.iter().map(byte).collect())
}

#[test]
fn files_are_read_for_ever() {
    for method in Method::ALL {
        let [file, pixels] = ["pnbase", "rgba"].map(|extension| path(method, extension));
        if std::env::var_os("POCKETNERF_BLESS").is_some() {
            let baseline = small(method);
            std::fs::write(&file, baseline.to_bytes()).unwrap();
            std::fs::write(&pixels, picture(&baseline)).unwrap();
        }
        let bytes = std::fs::read(&file).unwrap();
        let baseline = Baseline::from_bytes(&bytes).unwrap();
        assert_eq!((baseline.method(), baseline.steps()), (method, 5));
        assert_eq!(baseline.origin(), small(method).origin());
        assert!((baseline.train_psnr() - 20.0).abs() < 1e-9);
        let (found, expected) = (picture(&baseline), std::fs::read(&pixels).unwrap());
        assert_eq!(found.len(), 4 * 12 * 10);
        assert!(expected.iter().any(|byte| *byte != expected[0]), "{method}: all the same");
        for (found, expected) in found.iter().zip(&expected) {
            assert!(found.abs_diff(*expected) <= 1, "{method}: {found}, expected {expected}");
        }
    }
}

#[test]
fn whatever_bytes_are_there_nothing_panics() {
    for method in Method::ALL {
        let whole = small(method).to_bytes();
        let mut opened = 0;
        for at in START..whole.len() {
            for bit in [0, 3, 7] {
                let mut bytes = whole.clone();
                bytes[at] ^= 1 << bit;
                let sum = crc32fast::hash(&bytes[START..]).to_le_bytes();
                bytes[8..START].copy_from_slice(&sum);
                if let Ok(mut baseline) = Baseline::from_bytes(&bytes) {
                    opened += 1;
                    // Its own camera may be one of millions of pixels.
                    baseline.record.origin.size = [4, 3];
                    picture(&baseline);
                }
            }
        }
        assert!(opened > 100, "{method}: only {opened} were opened");
    }
}
