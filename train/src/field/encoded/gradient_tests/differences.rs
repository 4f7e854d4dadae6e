//! Every derivative against the central difference of the loss in f64.

use super::*;

/// Largest error of a derivative, relative to its size: it is a sum of some
/// thousand rounded `f32` terms. A wrong one shows wherever it counts.
const TOLERANCE: f64 = 1e-4;
/// How far a difference moves parameters, which lie within ±1: so little that
/// next to no unit passes the kink of its ReLU, and far above f64's rounding.
const MOVE: f64 = 2e-7;

/// The error of the derivative along `direction` relative to its size, or to
/// its typical size where its terms cancel.
fn error(
    loss: &Loss<impl Exact>,
    parameters: &[f64],
    gradient: &[f32],
    direction: &Direction,
) -> f64 {
    let moved = |by: f64| {
        let mut parameters = parameters.to_vec();
        for (i, share) in direction {
            parameters[*i] += by * share;
        }
        loss.at(&parameters)
    };
    let expected = (moved(MOVE) - moved(-MOVE)) / (2.0 * MOVE);
    let squares = direction.iter().map(|(i, share)| (f64::from(gradient[*i]) * share).powi(2));
    let typical = squares.sum::<f64>().sqrt();
    (along(gradient, direction) - expected).abs() / expected.abs().max(typical)
}

/// Gives the number of rays that ended early.
fn check<E: Exact + Copy>(case: Case<E>) -> usize {
    let mut step = Step::new(case);
    let (found, samples) = step.run(0.0, 0);
    assert!(samples > 700, "{samples} samples");
    if case.coarse_step_below == 0.0 {
        samples::check(&step);
    }
    let (loss, gradient) = (step.loss(), step.gradient());
    let parameters: Vec<f64> = step.parameters().iter().copied().map(f64::from).collect();
    let expected = loss.at(&parameters);
    // Statistics are of the colours alone.
    let same = (found - expected).abs() < 1e-6 * expected;
    assert!(same || case.depth, "loss {found}, not {expected}");
    let mut random = Random::new(5, [0; 3]);
    for range in step.layout.ranges() {
        for direction in directions(range, &gradient, &mut random) {
            let error = error(&loss, &parameters, &gradient, &direction);
            let (part, n) = (range.part, direction.len());
            assert!(error < TOLERANCE, "{case:?}: {part:?}, {n} parameters: off by {error:e}");
        }
    }
    step.groups().map(Group::ended).sum()
}

#[test]
fn hash_grids() {
    for shading in SHADINGS {
        for n_features_per_level in [1, 2, 4, 8] {
            let encoding = hash_grid(n_features_per_level);
            check(Case { encoding, shading, ..ONE_LAYER });
        }
        check(Case { encoding: hash_grid(2), shading, ..TWO_LAYERS });
    }
}

#[test]
fn rays_that_end_early() {
    for shading in SHADINGS {
        let case = Case { encoding: hash_grid(4), shading, log_density: 3.0, ..ONE_LAYER };
        let ended = check(case);
        assert!(ended > 10, "{ended} rays ended");
    }
}

#[test]
fn planes() {
    for shading in SHADINGS {
        let case = ONE_LAYER.of(PLANES);
        check(Case { shading, ..case });
        check(Case { shading, encoding: PlanesConfig { n_components: 32, ..PLANES }, ..case });
        for simd in SimdLevel::ALL.into_iter().filter(|level| level.is_available()) {
            check(Case { shading, simd: Some(simd), ..case });
        }
    }
}

/// Narrower than a colour and a density.
#[test]
fn narrow_networks() {
    for shading in SHADINGS {
        let (density_hidden, color_hidden): (&[_], &[_]) = (&[], &[]);
        let case = Case { encoding: hash_grid(1), n_features: 1, shading, ..ONE_LAYER };
        check(Case { density_hidden, color_hidden, sh_degree: 1, ..case });
    }
}

/// Samples that stand for several steps, where little light is left.
#[test]
fn late_samples() {
    for shading in SHADINGS {
        let encoding = hash_grid(4);
        check(Case { encoding, shading, log_density: 1.25, coarse_step_below: 0.6, ..ONE_LAYER });
    }
}

/// A term with a gradient by the depth.
#[test]
fn depths() {
    for shading in SHADINGS {
        let case = Case { encoding: hash_grid(2), shading, depth: true, ..ONE_LAYER };
        check(case);
        check(Case { log_density: 3.0, ..case });
    }
}

/// More samples and more rays than a batch takes.
#[test]
fn several_batches() {
    for shading in SHADINGS {
        check(Case { encoding: hash_grid(2), shading, rays: [2200, 30], ..ONE_LAYER });
    }
}

#[test]
fn every_simd_level() {
    for simd in SimdLevel::ALL.into_iter().filter(|level| level.is_available()) {
        for shading in SHADINGS {
            let simd = Some(simd);
            check(Case { encoding: hash_grid(2), shading, simd, ..ONE_LAYER });
        }
    }
}
