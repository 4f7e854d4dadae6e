//! The version of the interface, which names the shared library too: `build.rs` includes this file.

/// The version of this interface: 65536 times the major number, plus the minor. Additions
/// increase the minor number, all other changes the major one.
pub const ABI_VERSION: u32 = 65538;
