//! Kinds of model that are not converted, recognised to say so and what to do instead.

use super::ConvertError;

/// How files begin, what such files are, and a hint.
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
    (
        b"\x89HDF\r\n",
        "HDF5 files (Keras, JAX)",
        "save the weights as .safetensors with the names of nerf-pytorch",
    ),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn others_are_named() {
        let error = refuse_others(b"ply\nformat binary").unwrap_err().to_string();
        assert!(error.contains("Gaussian splats") && error.contains("train on"), "{error}");
        assert!(refuse_others(b"PK\x03\x04").is_ok() && refuse_others(b"").is_ok());
    }
}
