//! Checkpoints that are not what they seem: refused in one line, never a panic.

use pocketnerf_core::{Ray, SimdLevel};
use pocketnerf_formats::import::{Checkpoint, FieldError};
use pocketnerf_tests::damage::{many_mutations, replaced, without_archive_checksums};
use pocketnerf_train::convert::ConvertError;

use super::{bytes, volume};

/// Mutations of every file.
const MUTATIONS: u64 = 10_000;

/// Reads a file as far as it can be, and looks along a few rays.
fn use_everything(bytes: &[u8]) -> bool {
    let Ok(checkpoint) = Checkpoint::read(bytes) else { return false };
    let volume = match volume(&checkpoint, SimdLevel::detect()) {
        Ok(volume) => volume,
        Err(error) => {
            assert!(!error.to_string().contains('\n'), "{error}");
            return false;
        }
    };
    let along = |x: f32| Ray { origin: [x, 0.1, -3.0], direction: [0.0, 0.0, 1.0] };
    assert_eq!(volume.painter().colors(&[along(0.0), along(0.3)]).len(), 2);
    true
}

#[test]
fn ten_thousand_mutations() {
    let files = ["features.th", "harmonics.th", "lines.th", "four.npz"];
    let files = files.map(|name| (name, without_archive_checksums(bytes(name))));
    many_mutations(&files, MUTATIONS, 21, use_everything);
}

#[test]
fn each_defect_is_named() {
    let whole = without_archive_checksums(bytes("features.th"));
    for (part, by, name) in [
        (&b"MLP_Fea"[..], &b"MLP_PEx"[..], "kwargs.shadingMode"),
        (b"softplus", b"softmaxx", "kwargs.fea2denseAct"),
        // From 0.5 to 6, from 0 to 1.
        (
            b"G\x3f\xe0\0\0\0\0\0\0G\x40\x18\0\0\0\0\0\0",
            b"G\0\0\0\0\0\0\0\0G\x3f\xf0\0\0\0\0\0\0",
            "kwargs.near_far",
        ),
        (b"density_shift", b"density_shaft", "kwargs.density_shift"),
        (b"density_line.1", b"density_lime.1", "density_line.1"),
        (b"basis_mat.weight", b"basis_mat.height", "basis_mat.weight"),
        (b"renderModule.mlp.2.bias", b"renderModule.mlp.2.bird", "renderModule.mlp.2.bias"),
    ] {
        let bytes = replaced(&whole, part, by);
        let error = volume(&Checkpoint::read(&bytes).unwrap(), SimdLevel::detect()).unwrap_err();
        assert!(error.to_string().contains(name), "{name}: {error}");
    }
    let whole = without_archive_checksums(bytes("four.npz"));
    let error = |name: &[u8], value: &[u8]| -> ConvertError {
        let at = (0..whole.len()).find(|at| whole[*at..].starts_with(name)).unwrap();
        let data = (at..whole.len()).find(|at| whole[*at..].starts_with(b"\n")).unwrap() + 1;
        let mut bytes = whole.clone();
        bytes[data..data + value.len()].copy_from_slice(value);
        volume(&Checkpoint::read(&bytes).unwrap(), SimdLevel::detect()).unwrap_err()
    };
    assert!(error(b"radius.npy", &0.0f32.to_le_bytes()).to_string().contains("radius"));
    assert!(error(b"links.npy", &99_999i32.to_le_bytes()).to_string().contains("links: 99999"));
    assert!(error(b"basis_type.npy", &4i64.to_le_bytes()).to_string().contains("basis_type"));
    let infinite = error(b"density_data.npy", &f32::INFINITY.to_le_bytes());
    let expected = FieldError::NotFinite("density_data".to_owned());
    assert!(matches!(infinite, ConvertError::Field(found) if found == expected));
}

/// What these programs save beside what is rendered here.
#[test]
fn what_is_not_rendered_is_named() {
    let names = ["links", "density_data", "sh_data", "background_data"];
    let tensor = |(i, name): (usize, &str)| {
        format!(r#""{name}":{{"dtype":"U8","shape":[1],"data_offsets":[{i},{}]}}"#, i + 1)
    };
    let tensors: Vec<String> = names.into_iter().enumerate().map(tensor).collect();
    let header = format!("{{{}}}", tensors.join(","));
    let length = (header.len() as u64).to_le_bytes();
    let spheres = [&length, header.as_bytes(), &[0; 4]].concat();
    let vector_matrix =
        b"\x82\xa6kwargs\x81\xabshadingMode\xa2SH\xaastate_dict\x81\xa9line_coef\xc4\x01\0";
    for (bytes, what) in [
        (&spheres[..], "background_data: spheres around the scene"),
        (&vector_matrix[..], "state_dict.line_coef: a TensorVM"),
    ] {
        let error = volume(&Checkpoint::read(bytes).unwrap(), SimdLevel::detect()).unwrap_err();
        assert!(error.to_string().contains(what), "{error}");
    }
}
