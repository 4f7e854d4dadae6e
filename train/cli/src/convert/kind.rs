//! Recognises kinds of model that are not converted, to suggest what to do instead.

use pocketnerf_formats::import::{FieldError, ImportError};

use pocketnerf_train::convert::ConvertError;

const SAFETENSORS: &str = "save the weights as .safetensors with the names of nerf-pytorch";

/// The first bytes of files, what such files are, and a hint.
const OTHERS: [(&[u8], &str, &str); 7] = [
    (
        b"ply\n",
        "point clouds, meshes and Gaussian splats (.ply)",
        "there is no field in them: train on the photographs they were made from",
    ),
    (
        b"ply\r",
        "point clouds, meshes and Gaussian splats (.ply)",
        "there is no field in them: train on the photographs they were made from",
    ),
    (b"glTF", "meshes (.glb)", "render views of it and train on them"),
    (b"v ", "meshes (.obj)", "render views of it and train on them"),
    (b"# ", "texts and meshes (.obj)", "give the checkpoint itself"),
    (b"\x89HDF\r\n", "HDF5 files (Keras, JAX)", SAFETENSORS),
    (
        b"{",
        "JSON files (MobileNeRF, SNeRG, MERF, datasets)",
        "train on the photographs they were made from; configs are found beside a checkpoint",
    ),
];

/// Refuses files that are recognised as something else.
///
/// # Errors
/// [`ConvertError::Kind`].
pub fn refuse_others(bytes: &[u8]) -> Result<(), ConvertError> {
    let kind = OTHERS.iter().find(|(begin, ..)| bytes.starts_with(begin));
    match kind {
        Some(&(_, found, hint)) => Err(ConvertError::Kind { found, hint }),
        None => Ok(()),
    }
}

/// Names of tensors or archive entries near the beginning or the end of files of some kinds.
const CONTAINED: [(&[u8], &str, &str); 4] = [
    (b"child.npy", "PlenOctrees", ON_PHOTOGRAPHS),
    (b"Dense_0", "models of JAX (mip-NeRF, Zip-NeRF, jaxnerf)", SAFETENSORS),
    (b"gauss_params", "Gaussian splats of nerfstudio", ON_PHOTOGRAPHS),
    (b"_model.field.", "nerfstudio's other methods", ON_PHOTOGRAPHS),
];
const ON_PHOTOGRAPHS: &str = "train on the photographs it was made from: pocketnerf train DATA";
/// Bytes to search at both ends.
const ENDS: usize = 1 << 16;

/// The error for a file that cannot be used: what it is, if it is recognised, else `error`.
#[must_use]
pub fn instead(bytes: &[u8], error: ConvertError) -> ConvertError {
    // A damaged file of a known program.
    let known = match &error {
        ConvertError::Field(error) => !matches!(error, FieldError::Unknown { .. }),
        ConvertError::Checkpoint(error) => !matches!(error, ImportError::MissingEntry(_)),
        _ => true,
    };
    let ends = [&bytes[..bytes.len().min(ENDS)], &bytes[bytes.len().saturating_sub(ENDS)..]];
    let holds =
        |name: &[u8]| ends.iter().any(|end| end.windows(name.len()).any(|part| part == name));
    match CONTAINED.iter().find(|(name, ..)| !known && holds(name)) {
        Some(&(_, found, hint)) => ConvertError::Kind { found, hint },
        None => error,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_what_a_file_is() {
        let unknown = || ConvertError::Field(FieldError::Unknown { found: Vec::new() });
        let missing = || ConvertError::Checkpoint(ImportError::MissingEntry("data.pkl".to_owned()));
        let splats = [&[0; 99][..], b"_model.gauss_params", &[0; 99]].concat();
        assert!(instead(&splats, unknown()).to_string().contains("Gaussian splats"));
        let octree = [&vec![0; 1 << 18][..], b"child.npy"].concat();
        assert!(instead(&octree, missing()).to_string().contains("PlenOctrees"));
        assert!(matches!(instead(b"", unknown()), ConvertError::Field(_)));
        let wrong = ConvertError::Field(FieldError::Missing("x".to_owned()));
        assert!(matches!(instead(&splats, wrong), ConvertError::Field(FieldError::Missing(_))));
    }

    #[test]
    fn others_are_named() {
        let error = refuse_others(b"ply\nformat binary").unwrap_err().to_string();
        assert!(error.contains("Gaussian splats") && error.contains("train on"), "{error}");
        assert!(refuse_others(b"PK\x03\x04").is_ok() && refuse_others(b"").is_ok());
    }
}
