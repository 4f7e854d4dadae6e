//! Which convention a folder follows, by what is in it.

use std::path::Path;

use super::{
    DatasetError, Split, blender, colmap, deepvoxels, footage, llff, phone, survey, transforms,
};

/// A convention that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Convention {
    /// `transforms_train.json`, `transforms_val.json`, `transforms_test.json`.
    Blender,
    /// `transforms.json`.
    Transforms,
    /// `poses_bounds.npy`.
    Llff,
    /// `{train,validation,test}/SCENE/intrinsics.txt`.
    DeepVoxels,
    /// `sparse/0/{cameras,images,points3D}.bin` and the like.
    Colmap,
    /// What a phone app has exported.
    Phone(phone::App),
    /// Cameras that a program of photogrammetry has exported.
    Survey(survey::Program),
}

/// Looks into the folder and names its convention.
pub(super) fn recognise(folder: &Path) -> Result<Convention, DatasetError> {
    let kind = std::fs::metadata(folder).map_err(|source| match source.kind() {
        std::io::ErrorKind::NotFound => DatasetError::Missing(folder.to_owned()),
        _ => DatasetError::Unlistable { folder: folder.to_owned(), source },
    })?;
    if !kind.is_dir() {
        let not_a_folder = || DatasetError::NotAFolder(folder.to_owned());
        return Err(footage::next_step(folder).unwrap_or_else(not_a_folder));
    }
    let names = list(folder)?;
    if names.is_empty() {
        return Err(DatasetError::Empty(folder.to_owned()));
    }
    if let Some(convention) = readable(folder) {
        return Ok(convention);
    }
    let found = some_of(&names);
    let inside = names.into_iter().find(|name| readable(&folder.join(name)).is_some());
    match footage::next_step(folder).filter(|_| inside.is_none()) {
        Some(refusal) => Err(refusal),
        None => Err(DatasetError::NotRecognised { folder: folder.to_owned(), found, inside }),
    }
}

/// The convention that a key belongs to which Blender's files do not have.
pub(super) fn dialect<'a>(
    keys: impl IntoIterator<Item = &'a String>,
) -> Option<(&'static str, String)> {
    const NERFSTUDIO: [&str; 5] =
        ["camera_model", "applied_transform", "applied_scale", "ply_file_path", "mask_path"];
    const INSTANT_NGP: [&str; 18] = [
        "fl_x",
        "fl_y",
        "x_fov",
        "y_fov",
        "camera_angle_y",
        "cx",
        "cy",
        "w",
        "h",
        "k1",
        "k2",
        "k3",
        "k4",
        "p1",
        "p2",
        "is_fisheye",
        "rolling_shutter",
        "distortion_params",
    ];
    let keys: Vec<&str> = keys.into_iter().map(String::as_str).collect();
    for (convention, own) in [("nerfstudio", &NERFSTUDIO[..]), ("instant-ngp", &INSTANT_NGP[..])] {
        let signs: Vec<&str> = own.iter().copied().filter(|key| keys.contains(key)).collect();
        if !signs.is_empty() {
            return Some((convention, format!("it has {}", signs.join(", "))));
        }
    }
    None
}

fn readable(folder: &Path) -> Option<Convention> {
    let blender = Split::ALL.map(|split| (blender::file_name(split), Convention::Blender));
    let others = [(transforms::FILE, Convention::Transforms), (llff::FILE, Convention::Llff)];
    let mut all = blender.into_iter().chain(others);
    let by_file = all.find(|(file, _)| folder.join(file).is_file());
    let deep_voxels = || deepvoxels::find(folder).map(|_| Convention::DeepVoxels);
    let colmap = || colmap::is_capture(folder).then_some(Convention::Colmap);
    let phone = || phone::app(folder).map(Convention::Phone);
    let survey = || survey::program(folder).map(Convention::Survey);
    let by_file = by_file.map(|(_, convention)| convention);
    by_file.or_else(deep_voxels).or_else(colmap).or_else(phone).or_else(survey)
}

/// The names in a folder, sorted.
fn list(folder: &Path) -> Result<Vec<String>, DatasetError> {
    let unlistable = |source| DatasetError::Unlistable { folder: folder.to_owned(), source };
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unlistable)? {
        names.push(entry.map_err(unlistable)?.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

/// The first names, for a message.
fn some_of(names: &[String]) -> String {
    const SHOWN: usize = 5;
    let shown = names[..names.len().min(SHOWN)].join(", ");
    if names.len() > SHOWN { format!("{shown} and {} more", names.len() - SHOWN) } else { shown }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_tell_the_dialects_apart() {
        let of = |keys: &[&str]| {
            let keys: Vec<String> = keys.iter().map(|&key| key.to_owned()).collect();
            dialect(&keys).map(|(name, _)| name)
        };
        assert_eq!(of(&["camera_angle_x", "frames", "aabb_scale"]), None);
        assert_eq!(of(&["camera_angle_x", "fl_x"]), Some("instant-ngp"));
        assert_eq!(of(&["fl_x", "camera_model"]), Some("nerfstudio"));
    }
}
