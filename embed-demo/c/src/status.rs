//! The outcome of a call: a code, and a line of text.

use std::any::Any;
use std::ffi::{CStr, c_char};
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

use pocketnerf_formats::FormatError;

/// The outcome of a call.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Success.
    Ok = 0,
    /// A pointer that must not be null is null.
    Null = 1,
    /// A pointer is not aligned for its type. (Pixels, depths and the bytes of a model need no
    /// alignment.)
    Misaligned = 2,
    /// A number is out of range, NaN, or an unknown code.
    Argument = 3,
    /// The camera has no pixels, has numbers that are not finite, or a pose that is not a
    /// rotation.
    Camera = 4,
    /// A buffer is too small.
    Buffer = 5,
    /// The file cannot be read.
    File = 6,
    /// The bytes are not a .pnerf model.
    NotAModel = 7,
    /// The model has a format version, or parts, that this library does not support.
    Version = 8,
    /// The bytes of the model are damaged.
    Damaged = 9,
    /// The model does not support this query.
    Unsupported = 10,
    /// The machine lacks these vector instructions.
    NoSimd = 11,
    /// A bug in the library.
    Internal = 12,
}

impl Status {
    const fn text(self) -> &'static CStr {
        match self {
            Self::Ok => c"ok",
            Self::Null => c"a pointer is null",
            Self::Misaligned => c"a pointer is not aligned",
            Self::Argument => c"an argument is out of range",
            Self::Camera => c"the camera cannot take pictures",
            Self::Buffer => c"a buffer is too short",
            Self::File => c"the file cannot be read",
            Self::NotAModel => c"not a .pnerf model",
            Self::Version => c"a model of another format version",
            Self::Damaged => c"a damaged model",
            Self::Unsupported => c"the model does not support this query",
            Self::NoSimd => c"no such vector instructions here",
            Self::Internal => c"a bug in pocketnerf",
        }
    }
}

/// Every status, in the order of the codes.
const ALL: [Status; 13] = [
    Status::Ok,
    Status::Null,
    Status::Misaligned,
    Status::Argument,
    Status::Camera,
    Status::Buffer,
    Status::File,
    Status::NotAModel,
    Status::Version,
    Status::Damaged,
    Status::Unsupported,
    Status::NoSimd,
    Status::Internal,
];

/// Size of an error's text in bytes, with the final zero.
pub const ERROR_TEXT: usize = 252;

/// A status with a line about what was found and what was expected. A call that can fail fills
/// it in, unless the pointer is null.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Error {
    /// The status that the call returns.
    pub status: Status,
    /// One line of UTF-8 with a final zero; empty after success.
    pub text: [c_char; ERROR_TEXT],
}

/// A short description of any status code. The text is valid for ever.
#[unsafe(no_mangle)]
pub extern "C" fn pnrf_status_text(status: i32) -> *const c_char {
    let known = usize::try_from(status).ok().and_then(|code| ALL.get(code));
    known.map_or(c"unknown status", |status| status.text()).as_ptr()
}

/// Why a call ends early.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) status: Status,
    pub(crate) text: String,
}

impl Failure {
    pub(crate) fn new(status: Status, text: impl Display) -> Self {
        Self { status, text: text.to_string() }
    }

    fn panicked(panic: &(dyn Any + Send)) -> Self {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
        Self::new(Status::Internal, text.unwrap_or("please report this"))
    }
}

impl From<pocketnerf_core::Error> for Failure {
    fn from(error: pocketnerf_core::Error) -> Self {
        use pocketnerf_core::Error as Core;
        let status = match error {
            Core::ScratchTooSmall { .. } | Core::OutputLength { .. } => Status::Buffer,
            Core::Unsupported(_) | Core::TooManySamples { .. } => Status::Unsupported,
            Core::SimdUnavailable(_) => Status::NoSimd,
            _ => Status::Argument,
        };
        Self::new(status, error)
    }
}

impl From<FormatError> for Failure {
    fn from(error: FormatError) -> Self {
        use FormatError as Format;
        let status = match error {
            Format::NotPnerf { .. } | Format::TextTransfer { .. } => Status::NotAModel,
            Format::Version { .. }
            | Format::UnknownSection(_)
            | Format::UnknownVersion { .. }
            | Format::UnknownEncoding { .. }
            | Format::UnknownCode { .. }
            | Format::FieldKind(_)
            | Format::SpaceKind(_) => Status::Version,
            _ => Status::Damaged,
        };
        Self::new(status, error)
    }
}

/// Runs the work of a call. Errors and panics become a status: no panic leaves the library.
///
/// # Safety
/// `error` is null or may be written to, at any alignment.
pub(crate) unsafe fn call(error: *mut Error, work: impl FnOnce() -> Result<(), Failure>) -> Status {
    let done = catch_unwind(AssertUnwindSafe(work));
    let failure = match done {
        Ok(Ok(())) => Failure { status: Status::Ok, text: String::new() },
        Ok(Err(failure)) => failure,
        Err(panic) => Failure::panicked(&*panic),
    };
    let status = failure.status;
    if !error.is_null() {
        let mut filled = Error { status, text: [0; ERROR_TEXT] };
        copy_text(&failure.text, &mut filled.text);
        // SAFETY: the caller's promise.
        unsafe { error.write_unaligned(filled) };
    }
    status
}

/// Copies as many whole characters of a text as fit, and a zero.
fn copy_text(text: &str, to: &mut [c_char]) {
    let most = text.len().min(to.len() - 1);
    let end = (0..=most).rev().find(|end| text.is_char_boundary(*end)).unwrap_or(0);
    let line = text[..end].bytes().map(|byte| if byte < b' ' { b' ' } else { byte });
    to.iter_mut().zip(line).for_each(|(to, byte)| *to = byte as c_char);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_find_their_texts() {
        for (code, status) in (0..).zip(ALL) {
            assert_eq!(status as i32, code);
            // SAFETY: a text of ours.
            let text = unsafe { CStr::from_ptr(pnrf_status_text(code)) };
            assert_eq!(text, status.text());
        }
        for code in [-1, 13, i32::MAX, i32::MIN] {
            // SAFETY: a text of ours.
            let text = unsafe { CStr::from_ptr(pnrf_status_text(code)) };
            assert_eq!(text, c"unknown status");
        }
    }

    #[test]
    fn a_panic_ends_at_the_border() {
        let mut error = Error { status: Status::Ok, text: [1; ERROR_TEXT] };
        // SAFETY: a place of ours.
        let status = unsafe { call(&raw mut error, || panic!("{}\n", "ä".repeat(200))) };
        assert_eq!((status, error.status), (Status::Internal, Status::Internal));
        // SAFETY: it ends with a zero.
        let text = unsafe { CStr::from_ptr(error.text.as_ptr()) };
        assert_eq!(text.to_str().unwrap(), "ä".repeat(125));
    }
}
