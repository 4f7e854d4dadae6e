//! Writes views as a dataset: `transforms_{train,val,test}.json` with PNG images beside them,
//! which this program, instant-ngp and nerfstudio read.

use std::path::Path;

use rayon::prelude::*;
use serde_json::{Value, json};

use super::{Split, View, blender};
use crate::json::escape;
use crate::lens::Lens;
use crate::output::{OutputError, write_atomic};
use crate::picture::image_file::{write_rgb, write_rgba};

/// Writes `views` as a split of the dataset in `folder`, which exists: images as
/// `SPLIT/000.png` in the order of the views, RGBA with straight alpha, masks beside them, and the
/// file that lists them with each one's camera and lens. Another split there stays as it is.
///
/// # Errors
/// One line that names the file.
pub fn write(folder: &Path, split: Split, views: &[View]) -> Result<(), OutputError> {
    let file = folder.join(blender::file_name(split));
    let is_known = |lens: &Lens| ["pinhole", "opencv", "fisheye"].contains(&lens.name());
    if let Some(View { name, lens, .. }) = views.iter().find(|view| !is_known(&view.lens)) {
        return Err(OutputError::Lens { file, image: escape(name), lens: lens.name() });
    }
    let images = folder.join(split.name());
    std::fs::create_dir_all(&images)
        .map_err(|source| OutputError::Refused { file: images.clone(), source })?;
    views.par_iter().enumerate().try_for_each(|(i, view)| {
        let (width, height) = (view.camera.width, view.camera.height);
        if let Some(mask) = &view.mask {
            let grey = mask.iter().flat_map(|counts| [if *counts == 0 { 0 } else { 255 }; 3]);
            write_rgb(&images.join(mask_name(i)), width, height, &grey.collect::<Vec<u8>>())?;
        }
        write_rgba(&images.join(file_name(i)), width, height, &view.rgba)
    })?;
    let frames: Vec<Value> = views.iter().enumerate().map(|(i, v)| frame(split, i, v)).collect();
    let text = json!({ "frames": frames }).to_string();
    write_atomic(&file, text.as_bytes())
}

fn file_name(i: usize) -> String {
    format!("{i:03}.png")
}

fn mask_name(i: usize) -> String {
    format!("{i:03}.mask.png")
}

/// A frame: its image, its pose, and its own intrinsics.
fn frame(split: Split, i: usize, view: &View) -> Value {
    let camera = &view.camera;
    let rows: Vec<&[f32]> = camera.camera_to_world.chunks(4).collect();
    let mut frame = json!({
        "file_path": format!("{}/{}", split.name(), file_name(i)),
        "transform_matrix": rows,
        "w": camera.width,
        "h": camera.height,
        "fl_x": camera.focal[0],
        "fl_y": camera.focal[1],
        "cx": camera.center[0],
        "cy": camera.center[1],
    });
    if view.mask.is_some() {
        frame["mask_path"] = format!("{}/{}", split.name(), mask_name(i)).into();
    }
    if view.lens != Lens::Pinhole {
        let names = ["k1", "k2", "k3", "k4", "p1", "p2"];
        for (name, value) in names.into_iter().zip(view.lens.coefficients()) {
            frame[name] = value.into();
        }
        frame["is_fisheye"] = matches!(view.lens, Lens::Fisheye(_)).into();
    }
    frame
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;
    use crate::dataset::load;

    #[test]
    fn what_is_written_is_read_again() {
        let folder = tempfile::tempdir().unwrap();
        let mut views = builtin::dataset(Split::Test, 20).views;
        views.truncate(3);
        views[1].lens = Lens::open_cv([0.1, -0.02, 0.0, 0.0], [0.001, 0.0]);
        views[2].camera.focal[1] *= 1.25;
        views[2].mask = Some((0..20 * 20).map(|i| if i < 150 { 0 } else { 255 }).collect());
        write(folder.path(), Split::Test, &views).unwrap();
        let read = load(folder.path(), Split::Test, 1).unwrap().views;
        assert_eq!(read.len(), 3);
        for (own, read) in views.iter().zip(&read) {
            assert_eq!((own.camera, own.lens), (read.camera, read.lens));
            assert_eq!(own.mask, read.mask);
            // Colours of transparent pixels mean nothing.
            let seen =
                |v: &View| v.rgba.chunks(4).filter(|p| p[3] > 0).flatten().copied().collect();
            let (own, read): (Vec<u8>, Vec<u8>) = (seen(own), seen(read));
            assert_eq!(own, read);
        }
        views[0].lens = Lens::fov(0.9);
        let refusal = write(folder.path(), Split::Test, &views).unwrap_err().to_string();
        assert!(
            refusal.contains("has a fov lens, expected pinhole, opencv or fisheye"),
            "{refusal}"
        );
    }
}
