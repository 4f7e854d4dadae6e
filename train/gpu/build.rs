//! Takes comments and most spaces out of the program's files, which web pages download.

use std::path::PathBuf;
use std::{env, fs};

const FOLDERS: [&str; 2] = ["src/shader/wgsl", "src/training/wgsl"];

fn main() -> std::io::Result<()> {
    FOLDERS.into_iter().try_for_each(shorten)
}

/// Writes the files of a folder without comments.
fn shorten(folder: &str) -> std::io::Result<()> {
    println!("cargo::rerun-if-changed={folder}");
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    for file in fs::read_dir(folder)? {
        let path = file?.path();
        let text = fs::read_to_string(&path)?;
        let lines = text.lines().map(str::trim);
        let kept = lines.filter(|line| !line.is_empty() && !line.starts_with("//"));
        let mut kept: String = kept.flat_map(|line| [line, "\n"]).collect();
        for spaced in [", ", " + ", " * ", ": ", " {"] {
            kept = kept.replace(spaced, spaced.trim());
        }
        fs::write(out.join(path.file_name().unwrap_or_default()), kept)?;
    }
    Ok(())
}
