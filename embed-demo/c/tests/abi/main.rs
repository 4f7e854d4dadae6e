//! What comes through the C interface is what the Rust crates give.

#![allow(
    clippy::undocumented_unsafe_blocks,
    reason = "each calls the interface with places of the test's own"
)]

mod handover;
mod picture;
mod query;
mod views;

use std::ffi::CStr;
use std::ptr::{null, null_mut};

use pocketnerf_c::{
    Camera, Error, Image, Model, Options, Status, pnrf_close, pnrf_default_camera,
    pnrf_default_options, pnrf_open_bytes, pnrf_scratch_length,
};

const STILL_LIFE: &[u8] = include_bytes!("../../../still-life.pnerf");
/// With coordinates of its own.
const GOLDEN: &[u8] = include_bytes!("../../../../tests/golden/hash-grid-f16.pnerf");

/// What a call says, where it fails.
fn done(call: impl FnOnce(*mut Error) -> Status) {
    let mut error = Error { status: Status::Internal, text: [0; 252] };
    let status = call(&raw mut error);
    let text = unsafe { CStr::from_ptr(error.text.as_ptr()) };
    assert_eq!((status, error.status), (Status::Ok, Status::Ok), "{text:?}");
}

/// A model that is closed in the end.
struct Open(*mut Model);

impl Open {
    fn new(bytes: &[u8], flags: u32) -> Self {
        let mut model = null_mut();
        done(|error| unsafe {
            pnrf_open_bytes(bytes.as_ptr().cast(), bytes.len(), flags, &raw mut model, error)
        });
        Self(model)
    }

    fn camera(&self, width: u32, height: u32) -> Camera {
        let mut camera = unsafe { std::mem::zeroed() };
        done(|error| unsafe { pnrf_default_camera(self.0, width, height, &raw mut camera, error) });
        camera
    }

    fn scratch(&self, options: &Options) -> Vec<f32> {
        let mut length = 0;
        done(|error| unsafe { pnrf_scratch_length(self.0, options, &raw mut length, error) });
        vec![f32::NAN; length]
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        unsafe { pnrf_close(self.0) };
    }
}

fn usual_options() -> Options {
    let mut options = unsafe { std::mem::zeroed() };
    done(|error| unsafe { pnrf_default_options(&raw mut options, error) });
    options
}

/// An image that wants nothing yet.
const NOTHING: Image = Image {
    pixels: null_mut(),
    size: 0,
    stride: 0,
    format: 0,
    alpha: 0,
    background: [0.0; 3],
    bottom_up: 0,
    depth: null_mut(),
    depth_size: 0,
    depth_stride: 0,
    depth_kind: 0,
};

#[test]
fn options_are_those_of_nobody() {
    let model = Open::new(STILL_LIFE, 0);
    let mut length = 0;
    done(|error| unsafe { pnrf_scratch_length(model.0, null(), &raw mut length, error) });
    assert_eq!(length, model.scratch(&usual_options()).len());
}
