//! Golden files: what version 1.0 wrote is read for ever, and what this build
//! writes is what version 1.0 wrote.
//!
//! `POCKETNERF_BLESS=1` rewrites the files. That is right only while a format
//! version has not been published; afterwards its goldens stay as they are.

use std::fs;
use std::path::PathBuf;

use pocketnerf_core::encoding::hash_grid::HASH_PRIMES;
use pocketnerf_core::encoding::{Affine, Fourier, Waves};
use pocketnerf_core::field::{Activation, NerfField, NerfNetwork};
use pocketnerf_core::network::{Dense, Mlp};
use pocketnerf_core::{AnyField, DType, Display, Layout, Model, TensorView};
use pocketnerf_formats::{
    ContainerWriter, FormatError, Precision, Role, SectionId, kind, open, open_verified, write,
};
use pocketnerf_tests::checksums::{crc32, number};
use pocketnerf_tests::tiny::{self, Tiny};

/// A section kind that no build knows.
const UNKNOWN: SectionId = SectionId { kind: 0x7f, index: 1 };

/// Compares with the golden file and gives its bytes.
fn golden(name: &str, built: &[u8]) -> Vec<u8> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("golden").join(name);
    if std::env::var_os("POCKETNERF_BLESS").is_some_and(|value| value == "1") {
        fs::write(&path, built).unwrap();
    }
    let stored = fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    assert!(stored.len() < 16 << 10, "{name}: golden files stay small");
    assert!(stored == built, "{name}: this build writes other bytes");
    stored
}

fn with_unknown_section(model: &Model<'_>, critical: bool) -> Vec<u8> {
    let mut writer = ContainerWriter::new();
    writer.add_model(model, &tiny::about(), Precision::F16).unwrap();
    writer.add(UNKNOWN, 9, critical, &b"from a time to come"[..]);
    writer.finish().unwrap()
}

/// Compares everything but the weights.
fn assert_same_but_weights(found: &Model<'_>, expected: &Model<'_>) {
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
        (AnyField::Nerf(found), AnyField::Nerf(expected)) => {
            return assert_same_nerf(found, expected);
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
fn assert_same_weights(found: &Model<'_>, expected: &Model<'_>, tolerance: f32) {
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

/// Half a unit in the last place of a power of two, the worst case: f16 keeps
/// eleven significant bits.
const F16_ROUNDING: f32 = 1.0 / 2048.0;

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

#[test]
fn hash_grid_i8() {
    let tiny = Tiny::new();
    let model = tiny.hash_grid();
    let bytes = write(&model, &tiny::about(), Precision::I8).unwrap();
    let bytes = golden("hash-grid-i8.pnerf", &bytes);
    let file = open_verified(&bytes).unwrap();
    assert_eq!(file.about, tiny::about());
    assert_same_but_weights(&file.model, &model);
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
    // What was read writes the same file again.
    assert!(write(&file.model, &file.about, Precision::I8).unwrap() == bytes);
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

/// The paper's networks and sampling.
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
    // A reader that does not know the paper's sampling finds the same field.
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

/// The paper's own network, 63 values to 8 layers of 256: 1.2 MB in half precision, and
/// twice as many with the coarse network.
#[test]
fn the_papers_networks_take_as_many_bytes_as_their_weights() {
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
fn unknown_ancillary_section_is_skipped() {
    let tiny = Tiny::new();
    let model = tiny.hash_grid();
    let bytes = golden("unknown-ancillary.pnerf", &with_unknown_section(&model, false));
    let file = open_verified(&bytes).unwrap();
    assert_same_weights(&file.model, &model, F16_ROUNDING);
    let section = file.container().find(UNKNOWN).unwrap();
    assert_eq!((section.version, section.bytes), (9, &b"from a time to come"[..]));
}

#[test]
fn unknown_critical_section_is_refused_by_name() {
    let tiny = Tiny::new();
    let bytes = golden("unknown-critical.pnerf", &with_unknown_section(&tiny.hash_grid(), true));
    let error = open(&bytes).unwrap_err();
    assert_eq!(error, FormatError::UnknownSection(UNKNOWN));
    assert!(error.to_string().starts_with("section of kind 0x7f index 1"), "{error}");
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

/// Reads the f16 golden as a stranger would: with SPEC.md and nothing else.
#[test]
fn by_hand_from_the_specification() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("golden/hash-grid-f16.pnerf");
    let file = fs::read(path).unwrap();
    let at = |offset: usize, size: usize| number(&file, offset, size).unwrap() as usize;

    // Header.
    assert_eq!(file[..8], [0xab, 0x50, 0x4e, 0x52, 0x46, 0x0d, 0x0a, 0x1a]);
    assert_eq!((at(8, 2), at(10, 2)), (1, 0));
    assert_eq!(at(16, 8), file.len());
    let table_end = 32 + 48 * at(12, 4);
    let mut head = file[..table_end].to_vec();
    head[24..28].fill(0);
    assert_eq!(at(24, 4), crc32(&head) as usize);

    // The payload of a section, by kind and index.
    let section = |kind: usize, index: usize| {
        let entry = (32..table_end)
            .step_by(48)
            .find(|entry| (at(*entry, 4), at(entry + 4, 4)) == (kind, index))
            .unwrap();
        let (offset, length) = (at(entry + 16, 8), at(entry + 24, 8));
        assert_eq!(offset % 64, 0);
        let payload = &file[offset..offset + length];
        assert_eq!(at(entry + 40, 4), crc32(payload) as usize);
        payload
    };
    // FIELD: kind, levels, features, log2 of the table, base resolution, growth.
    let field = section(4, 0);
    assert_eq!(field[..5], [0, 2, 2, 8, 4]);
    assert_eq!(field[5..9], 2.0f32.to_le_bytes());

    // TENSORS: ten entries. The second is level 1: name, index, f16, 256 as a
    // varint, 2, the scale, row-major, section GRID 1.
    let directory = section(8, 0);
    assert_eq!(directory[0], 10);
    let first = [0, 0, 1, 0xd8, 0x01, 2, 0xf0, 0, 16, 0];
    let second = [0, 1, 1, 0x80, 0x02, 2, 0xf0, 0, 16, 1];
    assert_eq!(directory[1..11], first);
    assert_eq!(directory[11..21], second);
    let scale = 2f64.powi((second[6] as i8).into());

    // Level 1: 4 * 2 - 1 = 7 cells, 8 corners, 5 blocks an axis; 8 * 5^3 > 2^8: hashed.
    // Corner (5, 2, 7): block (2, 1, 3), low bits (1, 0, 1).
    let hash = 2 ^ HASH_PRIMES[1] ^ HASH_PRIMES[2].wrapping_mul(3);
    let entry = (8 * (hash % 32) + 1 + 4) as usize;
    let table = section(16, 1);
    assert_eq!(table.len(), 256 * 2 * 2);
    let bits = number(table, (entry * 2 + 1) * 2, 2).unwrap();
    let (sign, exponent, mantissa) = (bits >> 15, bits >> 10 & 31, bits & 1023);
    assert!((1..31).contains(&exponent));
    let magnitude = (1.0 + mantissa as f64 / 1024.0) * 2f64.powi(exponent as i32 - 15);
    let value = if sign == 1 { -magnitude } else { magnitude } * scale;

    let tiny = Tiny::new();
    let AnyField::HashGrid(expected) = tiny.hash_grid().field else { unreachable!() };
    let expected = f64::from(expected.grid.levels[1].get(entry * 2 + 1));
    assert!((value - expected).abs() <= f64::from(F16_ROUNDING), "{value} {expected}");

    // Cell (3, 2, 1) lies in block 0, byte y + 8 z, bit x.
    let number_of_block = number(section(18, 0), 0, 2).unwrap() as usize;
    let byte = section(19, 0)[(number_of_block - 1) * 64 + 2 + 8];
    let occupancy = tiny.hash_grid().occupancy.unwrap();
    assert_eq!(byte >> 3 & 1 == 1, occupancy.cell(3, 2, 1));
}
