use super::*;
use crate::query::Depth;
use crate::{Error, Ray};

/// Asks every question that fills an output; asserts that a refusal leaves it as it was.
fn ask_all(
    probe: &Probe<'_>,
    n: usize,
    point: [f32; 3],
    direction: [f32; 3],
    scratch: usize,
) -> [Result<(), Error>; 5] {
    const UNTOUCHED: f32 = -7.0;
    let mut scratch = vec![0.0; scratch];
    // The odd one is the last of two.
    let (points, directions) = ([[0.0; 3], point], [[0.0, 0.0, 1.0], direction]);
    let rays = [0, 1].map(|i| Ray { origin: points[i], direction: directions[i] });
    let segments = [[[0.0; 3]; 2], [[0.5; 3], point]];
    let (mut one, mut three, mut four) =
        (vec![UNTOUCHED; n], vec![[UNTOUCHED; 3]; n], vec![[UNTOUCHED; 4]; n]);
    let results = [
        probe.density(&points, &mut scratch, &mut one),
        probe.segment_transmittance(&segments, &mut scratch, &mut one),
        probe.depths(&rays, Depth::Median, None, &mut scratch, &mut one),
        probe.density_gradient(&points, &mut scratch, &mut three),
        probe.radiance(&points, &directions, &mut scratch, &mut four),
    ];
    let all = one.iter().chain(three.as_flattened()).chain(four.as_flattened());
    if results.iter().all(Result::is_err) {
        assert!(all.into_iter().all(|v| *v == UNTOUCHED), "{results:?}");
    } else {
        assert!(all.into_iter().all(|v| !v.is_nan()), "{results:?}");
    }
    results
}

#[test]
fn refusals_write_nothing() {
    for kind in kinds() {
        let model = fog(&kind, 0.0, 1.0);
        each_probe(&model, |probe, _| {
            let (needed, up) = (probe.scratch_len(), [0.0, 0.0, 1.0]);
            assert_eq!(ask_all(probe, 2, [0.1; 3], up, needed), [Ok(()); 5]);
            let short = Error::ScratchTooSmall { needed, given: needed - 1 };
            assert_eq!(ask_all(probe, 2, [0.1; 3], up, needed - 1), [Err(short); 5]);
            for given in [1, 3] {
                let length = Error::OutputLength { needed: 2, given };
                assert_eq!(ask_all(probe, given, [0.1; 3], up, needed), [Err(length); 5]);
            }
            for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 2e11] {
                for axis in 0..3 {
                    let mut point = [0.1; 3];
                    point[axis] = bad;
                    let results = ask_all(probe, 2, point, up, needed);
                    assert!(results.iter().all(|r| matches!(r, Err(Error::Range(_)))));
                    let mut scratch = vec![0.0; needed];
                    let refused = probe.collision_probability(&[point], 1.0, 1.0, &mut scratch);
                    assert!(matches!(refused, Err(Error::Range(_))));
                }
            }
            for bad in [[0.0; 3], [f32::NAN, 0.0, 1.0], [f32::INFINITY, 0.0, 0.0]] {
                let [_, _, depths, _, radiance] = ask_all(probe, 2, [0.1; 3], bad, needed);
                assert!(matches!(depths, Err(Error::Range(_))), "{depths:?}");
                assert!(matches!(radiance, Err(Error::Range(_))), "{radiance:?}");
            }
        });
    }
}

#[test]
fn numbers_without_meaning() {
    for kind in kinds() {
        let model = fog(&kind, 0.0, 1.0);
        let probe = Probe::new(&model, SimdLevel::compiled(), Tuning::SMALL).unwrap();
        let mut scratch = vec![0.0; probe.scratch_len()];
        let ray = [Ray { origin: [0.0; 3], direction: [1.0, 0.0, 0.0] }];
        for depth in [
            Depth::FirstSigma(f32::NAN),
            Depth::FirstSigma(-1.0),
            Depth::FirstSigma(f32::INFINITY),
            Depth::FirstOpacity(0.0),
            Depth::FirstOpacity(1.0),
            Depth::FirstOpacity(f32::NAN),
        ] {
            let refused = probe.depths(&ray, depth, None, &mut scratch, &mut [0.0]);
            assert!(matches!(refused, Err(Error::Range(_))), "{depth:?}");
        }
        let axis = Some([f32::NAN; 3]);
        assert!(probe.depths(&ray, Depth::Median, axis, &mut scratch, &mut [0.0]).is_err());
        for (volume, area) in [(-1.0, 1.0), (1.0, 0.0), (f32::NAN, 1.0), (1.0, f32::INFINITY)] {
            assert!(probe.collision_probability(&[], volume, area, &mut scratch).is_err());
        }
        let mut out = [[0.0; 4]];
        assert_eq!(
            probe.radiance(&[[0.0; 3]], &[], &mut scratch, &mut out),
            Err(Error::InputLength { needed: 1, given: 0 })
        );
        for tuning in [Tuning { samples: 33, rays: 16 }, Tuning { samples: 32, rays: 0 }] {
            assert!(Probe::new(&model, SimdLevel::compiled(), tuning).is_err());
        }
        let good = Similarity::IDENTITY;
        let mirrored = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
        for bad in [
            Similarity { scale: 0.0, ..good },
            Similarity { scale: -1.0, ..good },
            Similarity { scale: f32::NAN, ..good },
            Similarity { scale: 1e7, ..good },
            Similarity { rotation: [[1.0; 3]; 3], ..good },
            Similarity { rotation: mirrored, ..good },
            Similarity { translation: [0.0, f32::NAN, 0.0], ..good },
        ] {
            assert!(matches!(probe.with_similarity(bad), Err(Error::Range(_))), "{bad:?}");
        }
    }
}

/// Weights that are no numbers are empty space, and those beyond measure an opaque thing;
/// no answer is NaN.
#[test]
fn hostile_weights() {
    for kind in kinds() {
        for log in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
            let model = fog(&kind, 0.0, log);
            each_probe(&model, |probe, _| {
                let needed = probe.scratch_len();
                let results = ask_all(probe, 2, [0.1; 3], [0.0, 0.0, -1.0], needed);
                assert_eq!(results, [Ok(()); 5]);
                let mut scratch = vec![0.0; needed];
                let p = probe.similarity().to_dataset([0.1; 3]);
                let hit = probe.collision_probability(&[p], 1.0, 1e-3, &mut scratch).unwrap();
                assert_eq!(hit, if log > 0.0 { 1.0 } else { 0.0 });
            });
        }
    }
}

#[cfg(feature = "ndc")]
#[test]
fn normalised_device_coordinates_have_no_probe() {
    for kind in kinds() {
        let (min, max) = ([-1.0; 3], [1.0; 3]);
        let ndc = crate::space::Ndc { near: 1.0, slope: [1.0; 2], min, max };
        let model = Model { space: crate::Space::Ndc(ndc), ..fog(&kind, 0.0, 1.0) };
        let refused = Probe::new(&model, SimdLevel::compiled(), Tuning::SMALL);
        assert!(matches!(refused, Err(Error::Unsupported(_))));
    }
}
