//! Names the shared library by its interface: a program that was linked with one major number
//! never loads another.

#[allow(unreachable_pub, reason = "public in the library")]
#[path = "src/abi.rs"]
mod abi;

fn main() {
    println!("cargo:rerun-if-changed=src/abi.rs");
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|system| system == "linux") {
        let major = abi::ABI_VERSION >> 16;
        println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libpocketnerf_c.so.{major}");
    }
}
