//! Golden files: what version 1.0 wrote is read for ever, and what this build
//! writes is what version 1.0 wrote.
//!
//! `POCKETNERF_BLESS=1` rewrites the files. That is right only while a format
//! version has not been published; afterwards its goldens stay as they are.

use std::fs;
use std::path::PathBuf;

use pocketnerf_core::encoding::{Affine, Fourier, Waves};
use pocketnerf_core::field::{Activation, NerfField, NerfNetwork};
use pocketnerf_core::network::{Dense, Mlp};
use pocketnerf_core::{AnyField, DType, Display, Layout, Model, TensorView};
use pocketnerf_formats::{
    About, ModelFile, Precision, Role, SectionId, kind, open, open_verified, write,
};
use pocketnerf_tests::tiny::{self, Tiny};

use crate::compare::{F16_ROUNDING, assert_same_but_weights, assert_same_weights};

/// Compares with the golden file and gives its bytes.
pub(crate) fn golden(name: &str, built: &[u8]) -> Vec<u8> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("golden").join(name);
    if std::env::var_os("POCKETNERF_BLESS").is_some_and(|value| value == "1") {
        fs::write(&path, built).unwrap();
    }
    let stored = fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    assert!(stored.len() < 16 << 10, "{name}: golden files stay small");
    assert!(stored == built, "{name}: this build writes other bytes");
    stored
}

#[test]
fn hash_grid_f16() {
    let tiny = Tiny::new();
    let model = tiny.hash_grid();
    let bytes = write(&model, &tiny::about(), Precision::F16).unwrap();
    let bytes = golden("hash-grid-f16.pnerf", &bytes);
    let file = open_verified(&bytes).unwrap();
    assert_eq!(file.about, tiny::about());
    assert_same_but_weights(&file.model, &model);
    assert_same_weights(&file.model, &model, F16_ROUNDING);
    for (_, view) in file.tensors() {
        assert_eq!(view.dtype(), DType::F16);
    }
    // What was read writes the same file again.
    assert!(write(&file.model, &file.about, Precision::F16).unwrap() == bytes);
}

/// Tables are whole numbers of eight bits, the nearest or those that are cut off; networks are f16.
fn assert_rounded(file: &ModelFile<'_>, model: &Model<'_>) {
    for ((name, found), (_, expected)) in
        file.tensors().zip(pocketnerf_formats::tensors(&model.field))
    {
        let table = name.role() == Role::Table;
        assert_eq!(found.dtype(), if table { DType::I8 } else { DType::F16 });
        for i in 0..found.rows() * found.cols() {
            let (found_value, value) = (found.get(i), expected.get(i));
            // The largest value is at least 64 units, and may be cut off at 127 of a
            // quarter of them.
            let most = if table { 0.5 * found.scale() } else { value.abs() * F16_ROUNDING };
            let cut = table
                && found_value.abs() == 127.0 * found.scale()
                && value.abs() > found_value.abs();
            assert!(
                (found_value - value).abs() <= most || cut,
                "{name} {i}: {found_value} {value}"
            );
        }
    }
}

#[test]
fn hash_grid_i8() {
    let tiny = Tiny::new();
    let model = tiny.hash_grid();
    let bytes = write(&model, &tiny::about(), Precision::I8).unwrap();
    let bytes = golden("hash-grid-i8.pnerf", &bytes);
    let file = open_verified(&bytes).unwrap();
    assert_eq!(file.about, tiny::about());
    assert_same_but_weights(&file.model, &model);
    assert_rounded(&file, &model);
    // What was read writes the same file again.
    assert!(write(&file.model, &file.about, Precision::I8).unwrap() == bytes);
}

#[test]
fn where_photographs_were_taken() {
    let tiny = Tiny::new();
    let photographs = tiny::photographs();
    let about = About { photographs: Some(photographs.view()), ..tiny::about() };
    let bytes = write(&tiny.hash_grid(), &about, Precision::F16).unwrap();
    let bytes = golden("photographs-f16.pnerf", &bytes);
    let file = open_verified(&bytes).unwrap();
    assert_eq!(file.about, about);
    let found: Vec<[f32; 16]> = photographs.view().poses().collect();
    for (pose, eye) in found.iter().zip(tiny::EYES) {
        assert!((0..3).all(|a| (pose[4 * a + 3] - eye[a]).abs() < 1e-4), "{pose:?}");
        // They look at the origin.
        let distance = eye.iter().map(|x| x * x).sum::<f32>().sqrt();
        assert!((0..3).all(|a| (pose[4 * a + 2] - eye[a] / distance).abs() < 1e-4), "{pose:?}");
    }
    // What was read writes the same file again.
    assert!(write(&file.model, &file.about, Precision::F16).unwrap() == bytes);
}

#[test]
fn hash_grid_f32() {
    let tiny = Tiny::new();
    let model = tiny.hash_grid();
    let bytes = write(&model, &tiny::about(), Precision::F32).unwrap();
    let bytes = golden("hash-grid-f32.pnerf", &bytes);
    let file = open_verified(&bytes).unwrap();
    assert_eq!(file.about, tiny::about());
    assert_same_but_weights(&file.model, &model);
    assert_same_weights(&file.model, &model, 0.0);
}

#[test]
fn per_sample_f16() {
    let tiny = Tiny::new();
    let model = tiny.per_sample();
    let about = Default::default();
    let bytes = write(&model, &about, Precision::F16).unwrap();
    let bytes = golden("per-sample-f16.pnerf", &bytes);
    let file = open_verified(&bytes).unwrap();
    assert_eq!(file.about, about);
    assert_same_but_weights(&file.model, &model);
    assert_same_weights(&file.model, &model, F16_ROUNDING);
}

/// A forward-facing capture's space.
#[test]
fn ndc_f16() {
    let tiny = Tiny::new();
    let model = tiny.ndc();
    let bytes = write(&model, &tiny::about(), Precision::F16).unwrap();
    let bytes = golden("ndc-f16.pnerf", &bytes);
    let file = open_verified(&bytes).unwrap();
    assert_eq!(file.about, tiny::about());
    assert_same_but_weights(&file.model, &model);
    assert_same_weights(&file.model, &model, F16_ROUNDING);
    // What was read writes the same file again.
    assert!(write(&file.model, &file.about, Precision::F16).unwrap() == bytes);
}

/// A model that says what its pictures bear, and so has a section DETAIL.
#[test]
fn detail_f16() {
    let tiny = Tiny::new();
    let usual = tiny.hash_grid();
    let model = Model { display: Display { tolerance: 0.0625, ..usual.display }, ..usual };
    let bytes = write(&model, &tiny::about(), Precision::F16).unwrap();
    let bytes = golden("detail-f16.pnerf", &bytes);
    let file = open_verified(&bytes).unwrap();
    assert_eq!(file.model.display.tolerance, 0.0625);
    assert_same_but_weights(&file.model, &model);
    // What was read writes the same file again.
    assert!(write(&file.model, &file.about, Precision::F16).unwrap() == bytes);
    // The usual tolerance goes without saying.
    let usual = write(&usual, &tiny::about(), Precision::F16).unwrap();
    assert!(open(&usual).unwrap().container().find(SectionId::first(kind::DETAIL)).is_none());
}

/// A sparse grid of voxels: an index of whole numbers, and values of eight bits.
#[test]
fn plenoxels_i8() {
    let tiny = Tiny::new();
    let model = tiny.plenoxels();
    let bytes = write(&model, &tiny::about(), Precision::I8).unwrap();
    let bytes = golden("plenoxels-i8.pnerf", &bytes);
    let file = open_verified(&bytes).unwrap();
    assert_eq!(file.about, tiny::about());
    assert_same_but_weights(&file.model, &model);
    let types = [("voxel index", DType::U16, Role::Index), ("voxels 0", DType::I8, Role::Table)];
    for ((name, view), expected) in file.tensors().zip(types) {
        assert_eq!((&*name.to_string(), view.dtype(), name.role()), expected);
    }
    // Half of the smallest unit that cuts off nothing, or a few values cut off.
    let field = |model: &Model<'_>| {
        let AnyField::Plenoxels(field) = model.field else { unreachable!() };
        let values = field.grid.values;
        (0..values.rows() * values.cols()).map(|i| values.get(i)).collect::<Vec<f32>>()
    };
    for (found, value) in field(&file.model).into_iter().zip(field(&model)) {
        assert!((found - value).abs() <= 0.5 / 128.0, "{found} {value}");
    }
    // What was read writes the same file again.
    assert!(write(&file.model, &file.about, Precision::I8).unwrap() == bytes);
}

/// Planes and lines in eight bits, networks in f16.
#[test]
fn planes_i8() {
    let tiny = Tiny::new();
    let model = tiny.planes();
    let bytes = write(&model, &tiny::about(), Precision::I8).unwrap();
    let bytes = golden("planes-i8.pnerf", &bytes);
    let file = open_verified(&bytes).unwrap();
    assert_eq!(file.about, tiny::about());
    assert_same_but_weights(&file.model, &model);
    assert_rounded(&file, &model);
    let names: Vec<_> = file.tensors().take(12).map(|(name, _)| name.to_string()).collect();
    assert_eq!((&*names[0], &*names[11]), ("planes table 0", "planes table 11"));
    // What was read writes the same file again.
    assert!(write(&file.model, &file.about, Precision::I8).unwrap() == bytes);
}

/// Sites are exact, heads in f16.
#[test]
fn derf_f16() {
    let tiny = Tiny::new();
    let model = tiny.derf();
    let bytes = write(&model, &tiny::about(), Precision::F16).unwrap();
    let bytes = golden("derf-f16.pnerf", &bytes);
    let file = open_verified(&bytes).unwrap();
    assert_eq!(file.about, tiny::about());
    assert_same_but_weights(&file.model, &model);
    assert_same_weights(&file.model, &model, F16_ROUNDING);
    for (name, view) in file.tensors() {
        let exact = name.to_string() == "sites";
        assert_eq!(name.role() == Role::Exact, exact);
        assert_eq!(view.dtype(), if exact { DType::F32 } else { DType::F16 }, "{name}");
    }
    // What was read writes the same file again.
    assert!(write(&file.model, &file.about, Precision::F16).unwrap() == bytes);
}

/// A vanilla NeRF with hierarchical sampling.
#[test]
fn nerf_f16() {
    let tiny = Tiny::new();
    let model = tiny.nerf();
    let bytes = write(&model, &tiny::about(), Precision::F16).unwrap();
    let bytes = golden("nerf-f16.pnerf", &bytes);
    let file = open_verified(&bytes).unwrap();
    assert_eq!(file.about, tiny::about());
    assert_same_but_weights(&file.model, &model);
    assert_same_weights(&file.model, &model, F16_ROUNDING);
    for (name, view) in file.tensors() {
        let exact = name.to_string() == "direction frequencies";
        assert_eq!(name.role() == Role::Exact, exact);
        assert_eq!(view.dtype(), if exact { DType::F32 } else { DType::F16 }, "{name}");
    }
    // What was read writes the same file again.
    assert!(write(&file.model, &file.about, Precision::F16).unwrap() == bytes);
    // A reader without hierarchical sampling finds the same field.
    let section = file.container().find(SectionId::first(kind::HIERARCHICAL)).unwrap();
    assert!(!section.is_critical());
}

/// A model without the coarse network is a model.
#[test]
fn nerf_without_its_coarse_network() {
    let tiny = Tiny::new();
    let AnyField::Nerf(field) = tiny.nerf().field else { unreachable!() };
    let fine = AnyField::Nerf(NerfField { coarse: None, ..field });
    let model = Model { field: fine, hierarchical: None, ..tiny.nerf() };
    let bytes = write(&model, &tiny::about(), Precision::F16).unwrap();
    let file = open_verified(&bytes).unwrap();
    assert_same_but_weights(&file.model, &model);
    assert_same_weights(&file.model, &model, F16_ROUNDING);
    assert!(file.container().find(SectionId::first(kind::HIERARCHICAL)).is_none());
}

/// The original network, 63 values to 8 layers of 256: 1.2 MB in half precision, and
/// twice as many with the coarse network.
#[test]
fn vanilla_nerfs_take_as_many_bytes_as_their_weights() {
    let zeros = vec![0; 4 * (63 + 256) * 256];
    let layer = |n_in: usize, n_out: usize| {
        let tensor = |rows: usize| {
            let bytes = &zeros[..4 * rows * n_out];
            TensorView::new(bytes, DType::F32, [rows as u32, n_out as u32], 0, Layout::RowMajor)
        };
        Dense { weight: tensor(n_in).unwrap(), bias: Some(tensor(1).unwrap()) }
    };
    let trunk: Vec<_> = [63, 256, 256, 256, 256, 63 + 256, 256, 256].map(|n| layer(n, 256)).into();
    let color = Mlp::new(&[layer(256 + 27, 128), layer(128, 3)]).unwrap();
    let (density, feature) = (layer(256, 1), Some(layer(256, 256)));
    let network = NerfNetwork::new(&trunk, [1 << 5, 0], density, feature, color).unwrap();
    let octaves = |n| Fourier { waves: Waves::Octaves { n, pi: true }, include_input: true };
    let tiny = Tiny::new();
    for (coarse, expected) in [(None, 1.19e6), (Some(network), 2.38e6)] {
        let field = AnyField::Nerf(NerfField {
            positions: octaves(10),
            directions: Some(octaves(4)),
            map: Affine::CENTRED,
            activation: Activation::Relu,
            density_scale: 1.0,
            fine: network,
            coarse,
        });
        let model = Model { field, ..tiny.nerf() };
        let bytes = write(&model, &tiny::about(), Precision::F16).unwrap().len() as f64;
        assert!((bytes / expected - 1.0).abs() < 0.02, "{bytes}");
    }
}

#[test]
fn opens_at_any_alignment() {
    let tiny = Tiny::new();
    let bytes = write(&tiny.hash_grid(), &tiny::about(), Precision::F16).unwrap();
    for shift in 0..8 {
        let mut moved = vec![0; shift];
        moved.extend_from_slice(&bytes);
        open_verified(&moved[shift..]).unwrap();
    }
}
