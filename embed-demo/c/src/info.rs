//! What is known of a model.

use std::ffi::c_char;

use pocketnerf_core::{ColorSpace, Space};

use crate::border;
use crate::model::Model;
use crate::options::unknown;
use crate::status::{Error, Failure, Status, call};

/// What is known of a model, in numbers.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Info {
    /// Length of the file.
    pub bytes: u64,
    /// Weights.
    pub parameters: u64,
    /// What the open model takes beside its bytes: the table of empty space.
    pub table_bytes: u64,
    /// Part of the model's box that may hold something; 1 where that is not known.
    pub occupancy: f32,
    /// The middle of its box, caller's coordinates.
    pub center: [f32; 3],
    /// Of the ball around the box, caller's units.
    pub radius: f32,
    /// Smallest corner of the box, model's coordinates.
    pub box_min: [f32; 3],
    /// Largest corner of the box, model's coordinates.
    pub box_max: [f32; 3],
    /// Caller's units per unit of the model: caller = scale * rotation * model +
    /// translation.
    pub scale: f32,
    /// Rotation of that, row after row.
    pub rotation: [f32; 9],
    /// Translation of that.
    pub translation: [f32; 3],
    /// Distance between samples along a ray, caller's units.
    pub step: f32,
    /// The model's background, 0 to 1, in its own colour space.
    pub background: [f32; 3],
    /// 1: colours, the background's too, are linear light, and only pictures in bytes are
    /// encoded as sRGB; 0: all colours are sRGB, like those of image files.
    pub is_linear: u32,
    /// 1: the model can be asked about points, segments and rays; 0: it has normalised
    /// device coordinates, and pictures only.
    pub has_queries: u32,
    /// 1: the file has a view of its own; see `pnrf_default_camera`.
    pub has_camera: u32,
    /// The quality that pictures have where nobody chooses.
    pub quality: f32,
}

impl Info {
    fn of(model: &Model) -> Self {
        let (file, scene) = (model.file(), model.scene());
        let space = &file.model.space;
        // A space that is no box has one around all that can be seen, if at all.
        let [box_min, box_max] = space.bounds();
        let half = |a: usize| 0.5 * (box_max[a] - box_min[a]);
        let diagonal = (0..3).map(|a| half(a) * half(a)).sum::<f32>().sqrt();
        Self {
            bytes: model.n_bytes() as u64,
            parameters: file.tensors().map(|(_, view)| (view.rows() * view.cols()) as u64).sum(),
            table_bytes: model.table_len() as u64,
            occupancy: file.model.occupancy.map_or(1.0, |occupancy| occupancy.fraction()),
            center: scene.to_dataset(space.center()),
            radius: scene.scale * diagonal,
            box_min,
            box_max,
            scale: scene.scale,
            rotation: std::array::from_fn(|i| scene.rotation[i / 3][i % 3]),
            translation: scene.translation,
            step: scene.scale * file.model.sampling.step,
            background: file.model.display.background,
            is_linear: (file.model.display.color_space == ColorSpace::Linear).into(),
            has_queries: matches!(space, Space::Box { .. }).into(),
            has_camera: file.about.camera.is_some().into(),
            quality: file.about.quality.unwrap_or(0.5),
        }
    }
}

/// What is known of a model, in numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_info(
    model: *const Model,
    info: *mut Info,
    error: *mut Error,
) -> Status {
    let work = || {
        // SAFETY: the caller's promise.
        let model = unsafe { border::read(model, "model")? };
        // SAFETY: the caller's promise.
        unsafe { border::write(info, Info::of(model), "info") }
    };
    // SAFETY: the caller's promise.
    unsafe { call(error, work) }
}

/// What is known of a model, in words.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Text {
    /// What people call the scene.
    Name = 0,
    /// The kind of its field: hash-grid or nerf.
    Kind = 1,
    /// How it was trained, or from what it was converted.
    Method = 2,
    /// The program that wrote it, with its version.
    Program = 3,
    /// The name of the dataset that it was trained on.
    Dataset = 4,
}

fn text(model: &Model, which: u32) -> Result<&str, Failure> {
    let file = model.file();
    let provenance = file.about.provenance.unwrap_or_default();
    Ok(match which {
        0 => file.about.scene.name.unwrap_or_default(),
        1 => file.model.field.kind(),
        2 => provenance.method,
        3 => provenance.program,
        4 => provenance.dataset,
        other => return Err(unknown("which", other)),
    })
}

/// A text of the model's, in UTF-8 with a zero at its end; empty where the file says
/// nothing. `which`: a `PnrfText`. `capacity`: bytes that `buffer` holds. `length`, where
/// wanted, is told the bytes that are needed, the zero included, even where they are more than
/// there is room for: that is an error.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_text(
    model: *const Model,
    which: u32,
    buffer: *mut c_char,
    capacity: usize,
    length: *mut usize,
    error: *mut Error,
) -> Status {
    let work = || {
        // SAFETY: the caller's promise.
        let model = unsafe { border::read(model, "model")? };
        let text = text(model, which)?;
        let needed = text.len() + 1;
        // SAFETY: the caller's promise.
        unsafe { border::write_if_wanted(length, needed, "length")? };
        if capacity < needed {
            let text = format_args!("buffer holds {capacity} bytes where {needed} are needed");
            return Err(Failure::new(Status::Buffer, text));
        }
        // SAFETY: the caller's promise.
        let to = unsafe { border::room(buffer, needed, "buffer")? };
        let bytes = text.bytes().chain([0]);
        to.iter_mut().zip(bytes).for_each(|(to, byte)| *to = byte as c_char);
        Ok(())
    };
    // SAFETY: the caller's promise.
    unsafe { call(error, work) }
}
