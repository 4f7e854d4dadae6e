//! Facts about a model.

use std::ffi::c_char;

use pocketnerf_core::{ColorSpace, Space};

use crate::border;
use crate::model::Model;
use crate::options::unknown;
use crate::status::{Error, Failure, Status, call};

/// Facts about a model, in numbers. The box of contracted space, which has no end, is the cube
/// that keeps its shape.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Info {
    /// Length of the file.
    pub bytes: u64,
    /// Number of weights.
    pub parameters: u64,
    /// Size of the empty-space skip table, which an open model needs beside its bytes.
    pub table_bytes: u64,
    /// Occupied fraction of the model's box; 1 if unknown.
    pub occupancy: f32,
    /// The centre of its box, caller's coordinates.
    pub center: [f32; 3],
    /// The radius of the sphere around the box, caller's units.
    pub radius: f32,
    /// Smallest corner of the box, model's coordinates.
    pub box_min: [f32; 3],
    /// Largest corner of the box, model's coordinates.
    pub box_max: [f32; 3],
    /// Caller's units per unit of the model: caller = scale * rotation * model +
    /// translation.
    pub scale: f32,
    /// The `rotation` above, row after row.
    pub rotation: [f32; 9],
    /// The `translation` above.
    pub translation: [f32; 3],
    /// Distance between samples along a ray, caller's units.
    pub step: f32,
    /// The model's background, 0 to 1, in its own colour space.
    pub background: [f32; 3],
    /// 1: colours and background are linear light, and only pictures in bytes are encoded as
    /// sRGB; 0: all colours are sRGB, as in image files.
    pub is_linear: u32,
    /// 1: queries about points, segments and rays are supported; 0: the model is in normalised
    /// device coordinates or in contracted space, for pictures only.
    pub has_queries: u32,
    /// 1: the file has its own view; see `pnrf_default_camera`.
    pub has_camera: u32,
    /// The default quality of pictures.
    pub quality: f32,
}

impl Info {
    fn of(model: &Model) -> Self {
        let (file, scene) = (model.file(), model.scene());
        let space = &file.model.space;
        let ([box_min, box_max], unit) = extent(space);
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
            step: scene.scale * unit * file.model.sampling.step,
            background: file.model.display.background,
            is_linear: (file.model.display.color_space == ColorSpace::Linear).into(),
            has_queries: matches!(space, Space::Box { .. }).into(),
            has_camera: file.about.camera.is_some().into(),
            quality: file.about.quality.unwrap_or(0.5),
        }
    }
}

/// The box of a space, and its unit of length in scene units. The bounds of normalised device
/// coordinates contain all that can be seen.
fn extent(space: &Space) -> ([[f32; 3]; 2], f32) {
    if !space.is_bent() {
        return (space.bounds(), 1.0);
    }
    let (center, radius) = (space.center(), space.viewing_distance());
    ([center.map(|c| c - radius), center.map(|c| c + radius)], radius)
}

/// Writes facts about a model, in numbers, to `info`.
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

/// Facts about a model, in words.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Text {
    /// The name of the scene.
    Name = 0,
    /// The kind of its field, such as `hash-grid`.
    Kind = 1,
    /// The method of its training, or what it was converted from.
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

/// Copies a text in UTF-8 with a final zero to `buffer`; empty if the file has none. `which`
/// is a `PnrfText`; `capacity` is the size of `buffer` in bytes, and too small a buffer is an
/// error. `length`, unless null, receives the bytes needed, with the zero, even then.
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
        unsafe { border::write_unless_null(length, needed, "length")? };
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
