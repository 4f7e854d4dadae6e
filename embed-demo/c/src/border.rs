//! The caller's pointers, checked for null and alignment. That their memory is valid is the
//! caller's promise.

use std::slice;

use crate::status::{Failure, Status};

fn check<T>(pointer: *const T, name: &str) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::new(Status::Null, format_args!("{name} is null")));
    }
    if !pointer.is_aligned() {
        let size = align_of::<T>();
        let text = format_args!("{name} is at {pointer:p}, expected a multiple of {size}");
        return Err(Failure::new(Status::Misaligned, text));
    }
    Ok(())
}

/// What a pointer points to.
///
/// # Safety
/// Where the pointer is neither null nor misaligned, a `T` lies there that nobody writes to during
/// the call.
pub(crate) unsafe fn read<'c, T>(pointer: *const T, name: &str) -> Result<&'c T, Failure> {
    check(pointer, name)?;
    // SAFETY: checked, and the caller's promise.
    Ok(unsafe { &*pointer })
}

/// The same, with `None` for null.
///
/// # Safety
/// As [`read`].
pub(crate) unsafe fn read_or_none<'c, T>(
    pointer: *const T,
    name: &str,
) -> Result<Option<&'c T>, Failure> {
    // SAFETY: the caller's promise.
    if pointer.is_null() { Ok(None) } else { unsafe { read(pointer, name) }.map(Some) }
}

/// Writes one `T`, whatever the place holds now.
///
/// # Safety
/// Where the pointer is neither null nor misaligned, there is room for a `T` that is the call's
/// alone.
pub(crate) unsafe fn write<T>(pointer: *mut T, value: T, name: &str) -> Result<(), Failure> {
    check(pointer, name)?;
    // SAFETY: checked, and the caller's promise.
    unsafe { pointer.write(value) };
    Ok(())
}

/// The same, unless the pointer is null.
///
/// # Safety
/// As [`write`].
pub(crate) unsafe fn write_unless_null<T>(
    pointer: *mut T,
    value: T,
    name: &str,
) -> Result<(), Failure> {
    // SAFETY: the caller's promise.
    if pointer.is_null() { Ok(()) } else { unsafe { write(pointer, value, name) } }
}

/// Checks a place before the work whose result goes there.
pub(crate) fn check_unless_null<T>(pointer: *mut T, name: &str) -> Result<(), Failure> {
    if pointer.is_null() { Ok(()) } else { check(pointer, name) }
}

/// A slice; of any pointer if it is empty.
///
/// # Safety
/// As [`read`], for all of them.
pub(crate) unsafe fn list<'c, T>(
    pointer: *const T,
    length: usize,
    name: &str,
) -> Result<&'c [T], Failure> {
    check_length::<T>(length, name)?;
    if length == 0 {
        return Ok(&[]);
    }
    check(pointer, name)?;
    // SAFETY: checked, and the caller's promise.
    Ok(unsafe { slice::from_raw_parts(pointer, length) })
}

/// A slice to write to.
///
/// # Safety
/// As [`write`], for all of them. Numbers of any bits are numbers: `T` is made of them.
pub(crate) unsafe fn room<'c, T>(
    pointer: *mut T,
    length: usize,
    name: &str,
) -> Result<&'c mut [T], Failure> {
    check_length::<T>(length, name)?;
    if length == 0 {
        return Ok(&mut []);
    }
    check(pointer, name)?;
    // SAFETY: checked, and the caller's promise.
    Ok(unsafe { slice::from_raw_parts_mut(pointer, length) })
}

/// No memory is larger than half of all addresses.
fn check_length<T>(length: usize, name: &str) -> Result<(), Failure> {
    let bytes = length.checked_mul(size_of::<T>());
    if bytes.is_none_or(|bytes| bytes > isize::MAX as usize) {
        let text = format_args!("{name}: {length} of them fit no memory");
        return Err(Failure::new(Status::Argument, text));
    }
    Ok(())
}
