//! Provides the memory map for the linker, and the model for the program: the still life, or the
//! file in `POCKETNERF_MODEL`.

use std::path::PathBuf;

fn main() -> std::io::Result<()> {
    let out = PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default());
    let model = std::env::var_os("POCKETNERF_MODEL");
    let model = model.map_or_else(|| "../still-life.pnerf".into(), PathBuf::from);
    std::fs::copy("memory.x", out.join("memory.x"))?;
    std::fs::copy(&model, out.join("model.pnerf"))?;
    println!("cargo::rustc-link-search={}", out.display());
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    println!("cargo::rerun-if-changed=memory.x");
    println!("cargo::rerun-if-changed={}", model.display());
    println!("cargo::rerun-if-env-changed=POCKETNERF_MODEL");
    Ok(())
}
