//! Whether two models are the same.

use pocketnerf_core::encoding::{Fourier, Waves};
use pocketnerf_core::field::NerfField;
use pocketnerf_core::{AnyField, Model};

/// Half a unit in the last place of a power of two, the worst case: f16 keeps
/// eleven significant bits.
pub(crate) const F16_ROUNDING: f32 = 1.0 / 2048.0;

/// Compares everything but the weights.
pub(crate) fn assert_same_but_weights(found: &Model<'_>, expected: &Model<'_>) {
    assert_eq!(found.space, expected.space);
    assert_eq!(found.sampling, expected.sampling);
    assert_eq!(found.hierarchical, expected.hierarchical);
    assert_eq!(found.display, expected.display);
    match (found.occupancy, expected.occupancy) {
        (Some(found), Some(expected)) => {
            assert_eq!(found.resolution(), expected.resolution());
            assert_eq!(found.n_cascades(), expected.n_cascades());
            assert_eq!(found.coarse_bytes(), expected.coarse_bytes());
            assert_eq!(found.fine_bytes(), expected.fine_bytes());
        }
        (None, None) => {}
        _ => panic!("occupancy on one side only"),
    }
    match (&found.field, &expected.field) {
        (AnyField::HashGrid(found), AnyField::HashGrid(expected)) => {
            assert_eq!(found.grid.config, expected.grid.config);
        }
        (AnyField::Derf(found), AnyField::Derf(expected)) => {
            assert_eq!(found.shape, expected.shape);
            // To the last bit, whatever the precision of the heads.
            assert_eq!(found.sites.bytes(), expected.sites.bytes());
            assert_eq!(found.density_scale, expected.density_scale);
            return;
        }
        (AnyField::Planes(found), AnyField::Planes(expected)) => {
            assert_eq!(found.planes.resolution, expected.planes.resolution);
            assert_eq!(found.planes.n_components, expected.planes.n_components);
        }
        (AnyField::Nerf(found), AnyField::Nerf(expected)) => {
            return assert_same_nerf(found, expected);
        }
        (AnyField::Plenoxels(found), AnyField::Plenoxels(expected)) => {
            assert_eq!(found.grid.resolution, expected.grid.resolution);
            // To the last bit, whatever the precision of the values.
            assert_eq!(found.grid.index.bytes(), expected.grid.index.bytes());
            assert_eq!(found.sh_degree, expected.sh_degree);
            assert_eq!(found.log_density_bias, expected.log_density_bias);
            return;
        }
        _ => panic!("fields of different kinds"),
    }
    let (Some(found), Some(expected)) = (found.field.decoder(), expected.field.decoder()) else {
        panic!("fields without decoders");
    };
    assert_eq!(found.n_features, expected.n_features);
    assert_eq!(found.sh_degree, expected.sh_degree);
    assert_eq!(found.shading, expected.shading);
    assert_eq!(found.log_density_bias, expected.log_density_bias);
}

fn encodings<'a>(field: &NerfField<'a>) -> Vec<Fourier<'a>> {
    std::iter::once(field.positions).chain(field.directions).collect()
}

fn assert_same_nerf(found: &NerfField<'_>, expected: &NerfField<'_>) {
    assert_eq!(found.map, expected.map);
    assert_eq!(found.activation, expected.activation);
    assert_eq!(found.density_scale, expected.density_scale);
    let (ours, theirs) = (encodings(found), encodings(expected));
    assert_eq!(ours.len(), theirs.len());
    for (found, expected) in ours.iter().zip(&theirs) {
        assert_eq!(found.include_input, expected.include_input);
        match (found.waves, expected.waves) {
            (Waves::Octaves { n, pi }, Waves::Octaves { n: expected_n, pi: expected_pi }) => {
                assert_eq!((n, pi), (expected_n, expected_pi));
            }
            (Waves::Gaussian(found), Waves::Gaussian(expected)) => {
                // To the last bit, whatever the precision of the networks.
                assert_eq!(found.bytes(), expected.bytes());
            }
            _ => panic!("other waves"),
        }
    }
    for (found, expected) in [
        (Some(&found.fine), Some(&expected.fine)),
        (found.coarse.as_ref(), expected.coarse.as_ref()),
    ] {
        assert_eq!(found.is_some(), expected.is_some());
        let (Some(found), Some(expected)) = (found, expected) else { continue };
        assert_eq!((found.skips, found.linear), (expected.skips, expected.linear));
        assert_eq!(found.feature.is_some(), expected.feature.is_some());
    }
}

/// Compares weights; `tolerance` is relative to the tensor's largest value.
pub(crate) fn assert_same_weights(found: &Model<'_>, expected: &Model<'_>, tolerance: f32) {
    let found: Vec<_> = pocketnerf_formats::tensors(&found.field).collect();
    let expected: Vec<_> = pocketnerf_formats::tensors(&expected.field).collect();
    assert_eq!(found.len(), expected.len());
    for ((name, found), (expected_name, expected)) in found.iter().zip(&expected) {
        assert_eq!(name, expected_name);
        assert_eq!(found.shape(), expected.shape());
        let n = found.rows() * found.cols();
        let largest = (0..n).map(|i| expected.get(i).abs()).fold(0.0, f32::max);
        for i in 0..n {
            let error = (found.get(i) - expected.get(i)).abs();
            assert!(error <= tolerance * largest, "{name} value {i}: off by {error}");
        }
    }
}
